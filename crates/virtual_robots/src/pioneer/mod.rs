//! The robot's side of the ARCOS protocol.
//!
//! **Connecting.** SYNC0, SYNC1, SYNC2 in this order are echoed, the last with name, class and
//! subclass; then OPEN (or a bare 1) opens the session. A step repeated is answered again, so a
//! lost echo costs nothing; a step out of order is ignored. In an open session a bare 0 is PULSE
//! and a bare 2 is CLOSE, because they are the same bytes; a bare 1 can only be the SYNC1 of a
//! client that lost track, and the robot closes the old session and answers it.
//!
//! **Open.** Information packets leave every 100 ms with the sonar readings new since the last one.
//! Without any packet from the client for the watchdog's time (2 s) the motors stop; at the next
//! packet, whatever it says, the robot goes on with what it was doing. CLOSE switches the motors off
//! and ends the packets; odometry goes on.
//!
//! **Motion.** See the `motion` module: VEL and MOVE set the translation, RVEL, ROTATE, HEAD, DHEAD
//! and DCHEAD the rotation, both at the same time; VEL2 takes both over, and the next command of
//! the other kinds takes over again, from a stand in what it does not set itself.
//!
//! Source: the manufacturer's public manuals of the Pioneer 2 and 3; the thesis, Annex C.
//! Differences: stalls are reported but do not switch the motors off; the battery keeps its
//! voltage; tones, grippers and auxiliary ports are accepted and do nothing.

mod commands;
mod motion;
mod sonar_ring;
#[cfg(test)]
mod tests;

use std::{sync::Arc, time::Duration};

use geometry::{Base, Odom, Se2, Transform2};
use robot_models::{Odometry, RobotModel, WheelSpeeds};
use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};
use wire::arcos::{ConfigPac, Decoder, EncoderPac, IoFields, PowerFields, Sip};

use self::{
    motion::{Motion, MotionLimits},
    sonar_ring::SonarRing,
};

/// A packet that stays unfinished for this long is noise; the manufacturer's library waits as long.
const UNFINISHED_MAX: Duration = Duration::from_millis(100);

/// Speeds below this, m/s, are no motion: what one encoder tick in 100 ms amounts to.
const STANDING_MPS: f64 = 0.001;

/// What one robot of a model has of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct PioneerConfig {
    /// The name it reports.
    pub name: String,
    /// The serial number it reports.
    pub serial: String,
    /// Time between information packets; less than 10 ms is taken as 10 ms.
    pub sip_period: Duration,
    /// Time without a packet after which the motors stop; zero switches the watchdog off.
    pub watchdog: Duration,
    /// Battery voltage, V.
    pub battery_v: f64,
    /// Whether the sonars fire before they are asked to.
    pub sonar_on: bool,
}

/// What the body tells its firmware at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorFeedback {
    /// Encoder counts since the body exists, left and right, forwards positive.
    pub encoder_ticks: [i64; 2],
    /// Whether a wheel is driven but does not turn, left and right.
    pub stalled: [bool; 2],
    /// Whether the body touches something: what a bumper feels.
    pub touching: bool,
}

/// What the firmware asks of the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorReference {
    /// Wheel speeds, already ramped under the limits the client set.
    pub wheels: WheelSpeeds,
    /// What the motors may accelerate with to get there, m/s².
    pub acceleration_mps2: f64,
}

/// Where a client of a simulated robot wants the true robot to be put.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimPose {
    /// There, in the world.
    At(Se2),
    /// Where it began.
    Start,
}

/// What became of the packets received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirmwareCounters {
    /// Packets whose checksum was right.
    pub n_packets: u64,
    /// Of these, commands that have no meaning for this robot.
    pub n_unknown: u64,
    /// Of these, commands whose argument could not be read.
    pub n_malformed: u64,
    /// Of these, commands that came outside a session or out of order.
    pub n_unexpected: u64,
    /// Times the watchdog stopped the motors.
    pub n_watchdog_stops: u64,
    /// Information packets sent.
    pub n_sips: u64,
}

/// One robot's firmware. Give it what came in on the wire and what the body feels, every few
/// milliseconds; it appends what goes out and says what the motors should do.
#[derive(Clone, Debug)]
pub struct PioneerFirmware {
    model: Arc<RobotModel>,
    config: PioneerConfig,
    rng: RandomStream,
    decoder: Decoder,
    session: Session,
    motion: Motion,
    odometry: Odometry,
    sonar: SonarRing,
    /// Way since switching on, forwards less backwards.
    odometer_m: f64,
    travel_since_sip_m: [f64; 2],
    wheel_speeds: WheelSpeeds,
    feedback: MotorFeedback,
    motors_enabled: bool,
    bump_stall: bool,
    encoder_packets: bool,
    digital_out: u8,
    analogue_port: u8,
    last_step: Option<Stamp>,
    last_byte: Stamp,
    /// `None` once the watchdog has stopped the motors.
    last_packet: Option<Stamp>,
    last_sip: Stamp,
    sim_pose: Option<SimPose>,
    counters: FirmwareCounters,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Session {
    /// Waits for SYNC0.
    Closed,
    /// SYNC0 answered.
    Synced0,
    /// SYNC1 answered.
    Synced1,
    /// SYNC2 answered: waits for OPEN.
    Ready,
    Open,
}

impl Default for PioneerConfig {
    fn default() -> Self {
        Self {
            name: "cairn".to_owned(),
            serial: "cairn-0001".to_owned(),
            sip_period: Duration::from_millis(100),
            watchdog: Duration::from_secs(2),
            battery_v: 12.6,
            sonar_on: true,
        }
    }
}

impl PioneerFirmware {
    /// A robot that has just been switched on: no session, motors off, odometry at (0, 0, 0).
    ///
    /// `rng` is the randomness of its sensors.
    pub fn new(model: Arc<RobotModel>, config: PioneerConfig, rng: RandomStream) -> Self {
        let limits = starting_limits(&model);
        let sonar = SonarRing::new(model.sonars.len(), config.sonar_on);
        Self {
            odometry: Odometry::new(model.drive),
            model,
            config,
            rng,
            decoder: Decoder::new(),
            session: Session::Closed,
            motion: Motion::new(limits),
            sonar,
            odometer_m: 0.0,
            travel_since_sip_m: [0.0; 2],
            wheel_speeds: WheelSpeeds::ZERO,
            feedback: MotorFeedback::default(),
            motors_enabled: false,
            bump_stall: false,
            encoder_packets: false,
            digital_out: 0,
            analogue_port: 0,
            last_step: None,
            last_byte: Stamp::ZERO,
            last_packet: None,
            last_sip: Stamp::ZERO,
            sim_pose: None,
            counters: FirmwareCounters::default(),
        }
    }

    /// One step for a body of the simulated world: see [`step_with`](Self::step_with).
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        world: &World,
        body_id: BodyId,
        out: &mut Vec<u8>,
    ) -> MotorReference {
        let body = world.body(body_id);
        let feedback = MotorFeedback {
            encoder_ticks: body.encoder_ticks,
            stalled: body.stalled,
            touching: body.touching,
        };
        let mut rng = self.rng.clone();
        let mut ping = |sensor_index| world.ping(body_id, sensor_index, &mut rng).range_m;
        let reference = self.step_with(now, received, feedback, &mut ping, out);
        self.rng = rng;
        reference
    }

    /// One step: `received` are the bytes that came in since the last one, `ping` fires a sonar and
    /// gives the range of its echo in metres. Bytes to send are appended to `out`.
    ///
    /// `now` must not go back; steps of 10 ms are usual, and the set points are ramped in these
    /// steps. Does not allocate, except for a command with a string argument and for CONFIG.
    pub fn step_with(
        &mut self,
        now: Stamp,
        received: &[u8],
        feedback: MotorFeedback,
        ping: &mut dyn FnMut(usize) -> f64,
        out: &mut Vec<u8>,
    ) -> MotorReference {
        let before = self.last_step.unwrap_or(now);
        self.feel(feedback);
        if self.session == Session::Open {
            self.sonar.fire(before, now, ping);
        }
        self.listen(now, received, out);
        self.watch(now);
        let wheels = self.motion.step(
            self.odometry.odom_from_base().se2().yaw_rad,
            self.odometer_m,
            &self.model.drive,
            now.since(before),
        );
        self.report(now, out);
        self.last_step = Some(now);
        MotorReference { wheels, acceleration_mps2: top_acceleration_mps2(&self.motion.limits) }
    }

    /// The line went dead (a socket was closed): ends the session as CLOSE does.
    pub fn hang_up(&mut self) {
        self.close();
        self.decoder.clear();
    }

    /// Whether a session is open.
    pub fn is_open(&self) -> bool {
        self.session == Session::Open
    }

    /// Whether the motors follow their reference.
    pub fn motors_enabled(&self) -> bool {
        self.motors_enabled
    }

    /// Where the robot believes to be.
    pub fn odom_from_base(&self) -> Transform2<Odom, Base> {
        self.odometry.odom_from_base()
    }

    /// The pose that a client asked the simulator to put the robot at, once.
    pub fn take_sim_pose(&mut self) -> Option<SimPose> {
        self.sim_pose.take()
    }

    /// What became of the packets received.
    pub fn counters(&self) -> FirmwareCounters {
        self.counters
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    /// Adds what decides the firmware's future to `hash`.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        let pose = self.odometry.odom_from_base().se2();
        let velocity = self.motion.velocity();
        for value in [pose.x_m, pose.y_m, pose.yaw_rad, velocity.linear_mps, velocity.angular_radps]
        {
            hash.absorb(value);
        }
        hash.absorb_u64(self.session as u64);
        hash.absorb_u64(self.counters.n_packets);
        hash.absorb_u64(self.counters.n_sips);
        hash.absorb_u64(self.last_packet.map_or(0, Stamp::as_nanos));
    }

    fn feel(&mut self, feedback: MotorFeedback) {
        let [left, right] = feedback.encoder_ticks;
        if self.last_step.is_none() {
            self.odometry.set_ticks(left, right);
        }
        let travel = self.odometry.update(left, right);
        self.odometer_m += 0.5 * (travel.left_m + travel.right_m);
        self.travel_since_sip_m[0] += travel.left_m;
        self.travel_since_sip_m[1] += travel.right_m;
        self.feedback = feedback;
    }

    fn listen(&mut self, now: Stamp, received: &[u8], out: &mut Vec<u8>) {
        if !received.is_empty() {
            self.decoder.push(received);
            self.last_byte = now;
        } else if self.decoder.has_unfinished() && now.since(self.last_byte) >= UNFINISHED_MAX {
            self.decoder.give_up_unfinished();
        }
        while let Some(packet) = self.decoder.next_packet() {
            self.counters.n_packets += 1;
            self.last_packet = Some(now);
            self.motion.resume();
            self.obey(now, packet.body(), out);
        }
    }

    fn watch(&mut self, now: Stamp) {
        if let Some(last_packet) = self.last_packet
            && self.session == Session::Open
            && !self.config.watchdog.is_zero()
            && now.since(last_packet) >= self.config.watchdog
        {
            self.last_packet = None;
            self.counters.n_watchdog_stops += 1;
            self.motion.suspend();
        }
        let bumped = self.bump_stall && self.feedback.touching;
        if bumped {
            self.motion.stop_at_once();
        }
    }

    fn close(&mut self) {
        self.session = Session::Closed;
        self.motors_enabled = false;
        self.encoder_packets = false;
        self.motion.stop_at_once();
        self.motion.limits = starting_limits(&self.model);
    }

    fn report(&mut self, now: Stamp, out: &mut Vec<u8>) {
        let period = self.config.sip_period.max(Duration::from_millis(10));
        if self.session != Session::Open || now.since(self.last_sip) < period {
            return;
        }
        let seconds = now.since(self.last_sip).as_secs_f64();
        let [left_m, right_m] = std::mem::take(&mut self.travel_since_sip_m);
        self.wheel_speeds =
            WheelSpeeds { left_mps: left_m / seconds, right_mps: right_m / seconds };
        self.sip().encode(out);
        self.sonar.forget_fresh();
        if self.encoder_packets {
            self.encoder_pac().encode(out);
        }
        self.counters.n_sips += 1;
        // On the beat, unless steps are so rare that it was missed altogether.
        let on_beat = self.last_sip + period;
        self.last_sip = if now.since(on_beat) < period { on_beat } else { now };
    }

    /// What the robot would report now.
    fn sip(&self) -> Sip {
        let pose = self.odometry.odom_from_base().se2();
        let heading_rad = pose.yaw_rad;
        let setpoint_rad = self.motion.heading_setpoint_rad().unwrap_or(heading_rad);
        let velocity = self.motion.velocity();
        let measured = self.model.drive.body_velocity(self.wheel_speeds);
        let touching = self.bump_stall && self.feedback.touching;
        let [left, right] = self.feedback.stalled.map(|stalled| u8::from(stalled || touching));
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
            battery_decivolts: (10.0 * self.config.battery_v).round() as u8,
            stall_left: left,
            stall_right: right,
            control_units: Sip::heading_to_units(setpoint_rad),
            flags: u16::from(self.motors_enabled) | (self.sonar.enabled_bits() << 1),
            io: Some(IoFields {
                analogue_port: self.analogue_port.into(),
                digital_out: self.digital_out,
                ..IoFields::default()
            }),
            power: Some(PowerFields {
                battery_decivolts: (10.0 * self.config.battery_v).round() as u16,
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

    fn config_pac(&self) -> ConfigPac {
        let limits = &self.motion.limits;
        let per_mm = 0.001 / self.model.drive.metres_per_tick();
        let degrees = |rad: f64| rad.to_degrees().round() as u16;
        let millimetres = |m: f64| (1000.0 * m).round() as u16;
        ConfigPac {
            class: self.model.arcos_class.clone(),
            subclass: self.model.arcos_subclass.clone(),
            serial: self.config.serial.clone(),
            name: self.config.name.clone(),
            rotation_top_degps: degrees(self.model.limits.turn_rate_max_radps),
            speed_top_mmps: millimetres(self.model.limits.speed_max_mps),
            acceleration_top_mmps2: millimetres(TOP_ACCELERATION_MPS2),
            rotation_acceleration_top_degps2: TOP_TURN_ACCELERATION_DEGPS2,
            sip_cycle_ms: u8::try_from(self.config.sip_period.as_millis()).unwrap_or(u8::MAX),
            watchdog_ms: u16::try_from(self.config.watchdog.as_millis()).unwrap_or(u16::MAX),
            rotation_max_degps: degrees(limits.turn_rate_radps),
            speed_max_mmps: millimetres(limits.speed_mps),
            rotation_acceleration_degps2: degrees(limits.turn_acceleration_radps2),
            rotation_deceleration_degps2: degrees(limits.turn_deceleration_radps2),
            acceleration_mmps2: millimetres(limits.acceleration_mps2),
            deceleration_mmps2: millimetres(limits.deceleration_mps2),
            ticks_per_mm: per_mm.round() as u16,
            rear_sonar: u8::from(self.model.sonars.len() > 8),
            ..ConfigPac::default()
        }
    }
}

/// What the motors can do, m/s²: the greatest value SETA accepts.
const TOP_ACCELERATION_MPS2: f64 = 4.0;

/// The greatest value SETRA accepts, deg/s².
const TOP_TURN_ACCELERATION_DEGPS2: u16 = 600;

/// Speed limit before the client sets one, m/s; the robot's factory setting.
const STARTING_SPEED_MPS: f64 = 0.75;

/// Turn rate limit before the client sets one, deg/s; the robot's factory setting.
const STARTING_TURN_RATE_DEGPS: f64 = 100.0;

fn starting_limits(model: &RobotModel) -> MotionLimits {
    let limits = &model.limits;
    MotionLimits {
        speed_mps: STARTING_SPEED_MPS.min(limits.speed_max_mps),
        acceleration_mps2: limits.acceleration_max_mps2,
        deceleration_mps2: limits.acceleration_max_mps2,
        turn_rate_radps: STARTING_TURN_RATE_DEGPS.to_radians().min(limits.turn_rate_max_radps),
        turn_acceleration_radps2: limits.turn_acceleration_max_radps2,
        turn_deceleration_radps2: limits.turn_acceleration_max_radps2,
    }
}

/// The reference is ramped already, so the body may follow as fast as its motors can.
fn top_acceleration_mps2(limits: &MotionLimits) -> f64 {
    TOP_ACCELERATION_MPS2.max(limits.acceleration_mps2).max(limits.deceleration_mps2)
}

fn fifteen_bits(metres: f64) -> u16 {
    // Two's complement of any width has the same low 15 bits.
    (1000.0 * metres).round() as i64 as u16 & 0x7FFF
}

/// The nearest number of 16 bits; a cast from a float saturates.
fn rounded(value: f64) -> i16 {
    value.round() as i16
}
