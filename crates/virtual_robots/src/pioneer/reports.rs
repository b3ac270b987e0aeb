//! What the robot sends: information packets on the beat, and what was asked for beside them.

use std::time::Duration;

use robot_models::WheelSpeeds;
use run_context::Stamp;
use wire::arcos::{
    ConfigPac, EncoderPac, GripperPac, IoFields, IoPac, PowerFields, SimStatPac, Sip,
};

use super::{
    FRONT, N_SEGMENTS, PioneerFirmware, REAR, Session, TOP_ACCELERATION_MPS2,
    TOP_TURN_ACCELERATION_DEGPS2, battery::Battery,
};

/// Speeds below this, m/s, are no motion: what one encoder tick in 100 ms amounts to.
const STANDING_MPS: f64 = 0.001;

/// Shortest time between information packets.
const PERIOD_MIN: Duration = Duration::from_millis(10);

/// Infrared sensors that see nothing: their bits are set.
const INFRARED_QUIET: u8 = 0xFF;

impl PioneerFirmware {
    /// Sends what is due.
    pub(super) fn report(&mut self, now: Stamp, out: &mut Vec<u8>) {
        if self.session != Session::Open {
            return;
        }
        self.answer(out);
        let period = self.model.status_period.max(PERIOD_MIN);
        if now.since(self.last_sip) < period {
            return;
        }
        let seconds = now.since(self.last_sip).as_secs_f64();
        let [left_m, right_m] = std::mem::take(&mut self.travel_since_sip_m);
        self.wheel_speeds =
            WheelSpeeds { left_mps: left_m / seconds, right_mps: right_m / seconds };
        if self.streams.sim_stat.is_continuous()
            && let Some(stat) = self.sim_stat_pac()
        {
            stat.encode(out);
        }
        let sip = self.sip();
        sip.encode(out);
        self.sonar.forget_fresh(sip.sonar().len());
        if self.streams.encoder.is_continuous() {
            self.encoder_pac().encode(out);
        }
        if self.streams.io.is_continuous() {
            self.io_pac().encode(out);
        }
        if self.streams.gripper.is_continuous() {
            NO_GRIPPER.encode(out);
        }
        self.counters.n_sips += 1;
        // On the beat, unless steps are so rare that it was missed altogether.
        let on_beat = self.last_sip + period;
        self.last_sip = if now.since(on_beat) < period { on_beat } else { now };
    }

    /// Sends the packets that were asked for once.
    fn answer(&mut self, out: &mut Vec<u8>) {
        let once = |stream: super::Stream| stream.is_wanted() && !stream.is_continuous();
        if once(self.streams.encoder) {
            self.encoder_pac().encode(out);
            self.streams.encoder.sent();
        }
        if once(self.streams.io) {
            self.io_pac().encode(out);
            self.streams.io.sent();
        }
        if once(self.streams.gripper) {
            NO_GRIPPER.encode(out);
            self.streams.gripper.sent();
        }
        // The truth is known from the step after the question on; a real robot never knows it.
        if once(self.streams.sim_stat)
            && let Some(stat) = self.sim_stat_pac()
        {
            stat.encode(out);
            self.streams.sim_stat.sent();
        }
    }

    /// What the robot would report now.
    fn sip(&self) -> Sip {
        let pose = self.odometry.odom_from_base().se2();
        let heading_rad = pose.yaw_rad;
        let setpoint_rad = self.motion.heading_setpoint_rad().unwrap_or(heading_rad);
        let velocity = self.motion.velocity();
        let measured = self.model.drive.body_velocity(self.wheel_speeds);
        let bumped = self.bump_stalls() != [false; 2];
        let [left, right] = self.feedback.stalled.map(|stalled| u8::from(stalled || bumped));
        let voltage_v = self.battery.voltage_v();
        let mut sip = Sip {
            moving: velocity.linear_mps.abs() > STANDING_MPS
                || velocity.angular_radps.abs() > STANDING_MPS
                || self.wheel_speeds.left_mps.abs() > STANDING_MPS
                || self.wheel_speeds.right_mps.abs() > STANDING_MPS,
            x_mm: fifteen_bits(pose.x_m),
            y_mm: fifteen_bits(pose.y_m),
            heading_units: Sip::heading_to_units(heading_rad),
            left_mmps: rounded(1000.0 * self.wheel_speeds.left_mps),
            right_mmps: rounded(1000.0 * self.wheel_speeds.right_mps),
            // A cast from a float saturates.
            battery_decivolts: (10.0 * voltage_v).round() as u8,
            stall_left: left | (self.feedback.bumpers[REAR] << 1),
            stall_right: right | (self.feedback.bumpers[FRONT] << 1),
            control_units: Sip::heading_to_units(setpoint_rad),
            flags: u16::from(self.motors_enabled) | (self.sonar.enabled_bits() << 1),
            io: Some(IoFields {
                analogue_port: self.analogue_port.into(),
                digital_out: self.digital_out,
                ..IoFields::default()
            }),
            power: Some(PowerFields {
                battery_decivolts: (10.0 * voltage_v).round() as u16,
                charge_state: 0,
                rotation_decidegps: rounded(10.0 * measured.angular_radps.to_degrees()),
            }),
            ..Sip::AT_REST
        };
        for &reading in self.sonar.fresh() {
            if !sip.push_sonar(reading) {
                break;
            }
        }
        sip
    }

    fn encoder_pac(&self) -> EncoderPac {
        // The packet's counters wrap at 32 bits, as the robot's do.
        let [left_ticks, right_ticks] = self.feedback.encoder_ticks.map(|ticks| ticks as i32);
        EncoderPac { left_ticks, right_ticks }
    }

    fn io_pac(&self) -> IoPac {
        let [front, rear] = self.feedback.bumpers;
        IoPac {
            digital_in: [0, front, rear, INFRARED_QUIET],
            digital_out: [self.digital_out, 0],
            ..IoPac::default()
        }
    }

    fn sim_stat_pac(&self) -> Option<SimStatPac> {
        let truth = self.truth?;
        let pose = truth.world_from_base;
        let ms = |time: Duration| u16::try_from(time.as_millis()).unwrap_or(u16::MAX);
        Some(SimStatPac {
            has_map: truth.bounds_m.is_some(),
            sim_interval_ms: ms(truth.step),
            real_interval_ms: ms(truth.step),
            last_interval_ms: ms(self.last_interval.unwrap_or(truth.step)),
            x_mm: millimetres(pose.x_m),
            y_mm: millimetres(pose.y_m),
            heading_deg: pose.yaw_rad.to_degrees().round() as i32,
            bounds_mm: truth.bounds_m.map(|bounds| bounds.map(millimetres)),
        })
    }

    /// What it says that it is.
    pub(super) fn class_and_subclass(&self) -> [String; 2] {
        let line = self.model.line.as_ref();
        line.map_or_else(Default::default, |line| [line.class.clone(), line.subclass.clone()])
    }

    pub(super) fn config_pac(&self) -> ConfigPac {
        let limits = &self.motion.limits;
        let per_mm = 0.001 / self.model.drive.metres_per_tick();
        let degrees = |rad: f64| rad.to_degrees().round() as u16;
        let millimetres = |m: f64| (1000.0 * m).round() as u16;
        let whole_ms = |time: Duration| u8::try_from(time.as_millis()).unwrap_or(u8::MAX);
        let [class, subclass] = self.class_and_subclass();
        ConfigPac {
            class,
            subclass,
            serial: self.config.serial.clone(),
            name: self.config.name.clone(),
            rotation_top_degps: degrees(self.model.limits.turn_rate_max_radps),
            speed_top_mmps: millimetres(self.model.limits.speed_max_mps),
            acceleration_top_mmps2: millimetres(TOP_ACCELERATION_MPS2),
            rotation_acceleration_top_degps2: TOP_TURN_ACCELERATION_DEGPS2,
            sip_cycle_ms: whole_ms(self.model.status_period.max(PERIOD_MIN)),
            watchdog_ms: u16::try_from(self.config.watchdog.as_millis()).unwrap_or(u16::MAX),
            rotation_max_degps: degrees(limits.turn_rate_radps),
            speed_max_mmps: millimetres(limits.speed_mps),
            rotation_acceleration_degps2: degrees(limits.turn_acceleration_radps2),
            rotation_deceleration_degps2: degrees(limits.turn_deceleration_radps2),
            acceleration_mmps2: millimetres(limits.acceleration_mps2),
            deceleration_mmps2: millimetres(limits.deceleration_mps2),
            ticks_per_mm: per_mm.round() as u16,
            front_sonar: u16::from(!self.model.sonars.is_empty()),
            rear_sonar: u8::from(self.model.sonars.len() > self.model.ring.chain_len),
            sonar_cycle_ms: whole_ms(self.model.ring.ping_period),
            front_bumpers: N_SEGMENTS,
            rear_bumpers: N_SEGMENTS,
            low_battery_decivolts: (10.0 * Battery::LOW_V).round() as u16,
            ..ConfigPac::default()
        }
    }
}

/// The robot has no gripper; a client that is told so asks no more.
const NO_GRIPPER: GripperPac = GripperPac { kind: 0, switches: 0, grasp_time: 0 };

pub(super) fn fifteen_bits(metres: f64) -> u16 {
    // Two's complement of any width has the same low 15 bits.
    (1000.0 * metres).round() as i64 as u16 & 0x7FFF
}

/// A cast from a float saturates.
fn millimetres(metres: f64) -> i32 {
    (1000.0 * metres).round() as i32
}

/// The nearest number of 16 bits; a cast from a float saturates.
fn rounded(value: f64) -> i16 {
    value.round() as i16
}
