//! What each command does to the robot.

use robot_models::WheelSpeeds;
use run_context::Stamp;
use wire::arcos::{Command, Report};

use super::{
    NumberSet, PioneerFirmware, Session, SimRequest, Stream, TOP_ACCELERATION_MPS2,
    TOP_TURN_ACCELERATION_DEGPS2, motion::heading_from_deg,
};

/// Metres per second in one step of VEL2.
const VEL2_STEP_MPS: f64 = 0.02;

impl PioneerFirmware {
    /// Does what the packet with this body asks.
    pub(super) fn obey(&mut self, now: Stamp, body: &[u8], out: &mut Vec<u8>) {
        let Ok(command) = Command::decode(body) else {
            self.counters.n_malformed += 1;
            return;
        };
        if self.session == Session::Open {
            self.obey_open(now, &command, out);
        } else {
            self.connect(now, &command, out);
        }
    }

    fn connect(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        let (session, echo) = match (self.session, command) {
            (_, Command::Sync0) => (Session::Synced0, Report::Sync0),
            (Session::Synced0 | Session::Synced1, Command::Sync1) => {
                (Session::Synced1, Report::Sync1)
            }
            (Session::Synced1 | Session::Ready, Command::Sync2) => {
                let [class, subclass] = self.class_and_subclass();
                let name = self.config.name.clone();
                (Session::Ready, Report::Sync2 { name, class, subclass })
            }
            (Session::Ready, Command::Sync1 | Command::Open) => {
                self.open(now);
                return;
            }
            _ => {
                self.counters.n_unexpected += 1;
                return;
            }
        };
        self.session = session;
        // A name too long for a packet stays unsaid; the client will retry and report it.
        let _too_long = echo.encode(out);
    }

    fn open(&mut self, now: Stamp) {
        self.session = Session::Open;
        self.last_sip = now;
        self.travel_since_sip_m = [0.0; 2];
        self.sonar.forget_all();
        self.unknown = NumberSet::default();
    }

    fn obey_open(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        match command {
            Command::Sync1 => {
                self.close();
                self.session = Session::Synced0;
                self.connect(now, command, out);
            }
            Command::Sync2 | Command::Close => self.close(),
            Command::Enable(on) => self.enable(*on != 0),
            Command::SetO => self.zero_odometry(),
            Command::Config => {
                // Only a name too long for a packet can fail; nothing is sent then.
                let _too_long = self.config_pac().encode(out);
            }
            Command::Encoder(wanted) => self.streams.encoder = Stream::asked(*wanted),
            Command::IoRequest(wanted) => self.streams.io = Stream::asked(*wanted),
            Command::GripRequest(wanted) => self.streams.gripper = Stream::asked(*wanted),
            Command::BatTest(decivolts) => self.battery.pretend_v(0.1 * f64::from(*decivolts)),
            Command::Sonar(argument) => self.sonar.switch(*argument),
            Command::Polling(order) => self.sonar.set_order(order),
            Command::DigOut(bits) => {
                let [values, mask] = bits.to_le_bytes();
                self.digital_out = (self.digital_out & !mask) | (values & mask);
            }
            Command::AdSel(port) => self.analogue_port = u8::try_from(*port).unwrap_or(0),
            Command::BumpStall(rings) => self.bump_stall = [rings & 1 != 0, rings & 2 != 0],
            Command::Other { number } => {
                self.counters.n_unknown += 1;
                self.unknown.insert(*number);
            }
            // SYNC0 is the same byte as PULSE: only the watchdog cares. The rest has no effect
            // here.
            Command::Sync0
            | Command::Pulse
            | Command::Open
            | Command::Say(_)
            | Command::Gripper(_)
            | Command::GripperVal(_)
            | Command::HostBaud(_)
            | Command::BatteryInfo(_)
            | Command::Sound(_)
            | Command::SoundTog(_) => {}
            Command::SimSetPose { .. }
            | Command::SimReset
            | Command::SimStat(_)
            | Command::SimMessage(_)
            | Command::SimExit(_) => self.obey_simulator(command),
            _ => self.obey_motion(command),
        }
    }

    /// Commands that a real robot does not know.
    fn obey_simulator(&mut self, command: &Command) {
        match command {
            Command::SimSetPose { x_mm, y_mm, heading_deg } => {
                self.ask_simulator(SimRequest::PlaceAt(geometry::Se2::new(
                    0.001 * f64::from(*x_mm),
                    0.001 * f64::from(*y_mm),
                    heading_from_deg(f64::from(*heading_deg)),
                )));
            }
            Command::SimReset => {
                self.motion.stop_at_once();
                self.odometry.reset();
                self.ask_simulator(SimRequest::Reset);
            }
            Command::SimStat(wanted) => self.streams.sim_stat = Stream::asked(*wanted),
            Command::SimMessage(text) => {
                self.ask_simulator(SimRequest::Say(String::from_utf8_lossy(text).into_owned()));
            }
            Command::SimExit(code) => self.ask_simulator(SimRequest::Exit(*code)),
            _ => {}
        }
    }

    /// SETO: a heading that is held stays where it is in the world.
    fn zero_odometry(&mut self) {
        self.motion.turn_frame(self.odometry.odom_from_base().se2().yaw_rad);
        self.odometry.reset();
    }

    fn obey_motion(&mut self, command: &Command) {
        match *command {
            Command::SetV(mmps) => self.set_speed_limit(mmps),
            Command::SetA(mmps2) => self.set_acceleration(mmps2),
            Command::SetRv(degps) => self.set_turn_rate_limit(degps),
            Command::SetRa(degps2) => self.set_turn_acceleration(degps2),
            Command::Stop => self.motion.stop(),
            Command::EStop => self.motion.stop_at_once(),
            // Motors that are off forget what they are asked.
            _ if !self.motors_enabled => {}
            Command::Vel(mmps) => self.motion.set_speed(0.001 * f64::from(mmps)),
            Command::Move(mm) => self.motion.move_by(0.001 * f64::from(mm), self.odometer_m),
            Command::RVel(degps) | Command::Rotate(degps) => {
                self.motion.set_turn_rate(f64::from(degps).to_radians());
            }
            Command::Head(deg) => self.motion.set_heading(heading_from_deg(deg.into())),
            Command::DHead(deg) => {
                let heading_rad = self.odometry.odom_from_base().se2().yaw_rad;
                self.motion.set_heading(heading_rad + heading_from_deg(deg.into()));
            }
            Command::DcHead(deg) => {
                let heading_rad = self.odometry.odom_from_base().se2().yaw_rad;
                let setpoint_rad = self.motion.heading_setpoint_rad().unwrap_or(heading_rad);
                self.motion.set_heading(setpoint_rad + heading_from_deg(deg.into()));
            }
            Command::Vel2 { left, right } => self.motion.set_wheels(WheelSpeeds {
                left_mps: VEL2_STEP_MPS * f64::from(left),
                right_mps: VEL2_STEP_MPS * f64::from(right),
            }),
            _ => self.counters.n_unknown += 1,
        }
    }

    /// Motors on, unless the battery is empty, or off.
    pub(super) fn enable(&mut self, on: bool) {
        if !on {
            self.motion.stop_at_once();
        }
        self.motors_enabled = on && !self.battery.is_empty();
    }

    fn set_speed_limit(&mut self, mmps: i16) {
        if mmps > 0 {
            let top_mps = self.model.limits.speed_max_mps;
            self.motion.limits.speed_mps = (0.001 * f64::from(mmps)).min(top_mps);
        }
    }

    fn set_turn_rate_limit(&mut self, degps: i16) {
        if degps > 0 {
            let top_radps = self.model.limits.turn_rate_max_radps;
            self.motion.limits.turn_rate_radps = f64::from(degps).to_radians().min(top_radps);
        }
    }

    fn set_acceleration(&mut self, mmps2: i16) {
        let mps2 = (0.001 * f64::from(mmps2).abs()).min(TOP_ACCELERATION_MPS2);
        match mmps2.signum() {
            1 => self.motion.limits.acceleration_mps2 = mps2,
            -1 => self.motion.limits.deceleration_mps2 = mps2,
            _ => {}
        }
    }

    fn set_turn_acceleration(&mut self, degps2: i16) {
        let radps2 = f64::from(degps2).abs().min(TOP_TURN_ACCELERATION_DEGPS2.into()).to_radians();
        match degps2.signum() {
            1 => self.motion.limits.turn_acceleration_radps2 = radps2,
            -1 => self.motion.limits.turn_deceleration_radps2 = radps2,
            _ => {}
        }
    }
}
