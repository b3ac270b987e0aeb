//! The robot's side of the ARCOS protocol.
//!
//! **Connecting.** SYNC0, SYNC1, SYNC2 in this order are echoed, the last with name, class and
//! subclass; then OPEN (or a bare 1) opens the session. A step repeated is answered again, so a
//! lost echo costs nothing; a step out of order is ignored. In an open session a bare 0 is PULSE
//! and a bare 2 is CLOSE, because they are the same bytes; a bare 1 can only be the SYNC1 of a
//! client that lost track, and the robot closes the old session and answers it.
//!
//! **Open.** Information packets leave every 100 ms (the model's period) with the sonar readings new
//! since the last one. Without any packet from the client for the watchdog's time (2 s) the motors
//! stop; at the next packet, whatever it says, the robot goes on with what it was doing. CLOSE
//! switches the motors off, ends the packets and returns what the client has set to its defaults;
//! odometry goes on.
//!
//! **Motion.** See the `motion` module: VEL and MOVE set the translation, RVEL, ROTATE, HEAD, DHEAD
//! and DCHEAD the rotation, both at the same time; VEL2 takes both over, and the next command of
//! the other kinds takes over again, from a stand in what it does not set itself. SETO moves a held
//! heading along with the odometry's frame.
//!
//! **Bumpers.** Five segments in front and five behind are always reported. With BUMPSTALL a
//! pressed ring ends motion in its own direction, so that the robot can be backed out.
//!
//! Source: the manufacturer's public manuals of the Pioneer 2 and 3; the thesis, Annex C; the
//! simulator's commands (numbers from 224) from the manufacturer's wiki and its simulator's README.
//! Differences: stalls are reported but do not switch the motors off; there is no gripper, and a
//! client that asks is told so; tones and auxiliary ports are accepted and do nothing.

mod as_board;
mod battery;
mod bumper_places;
mod commands;
mod device_state;
mod motion;
mod reports;
mod sonar_ring;
#[cfg(test)]
mod tests;

use std::{sync::Arc, time::Duration};

use geometry::{Base, Odom, Se2, Transform2};
use robot_models::{Odometry, RobotModel, WheelSpeeds};
use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};
use wire::arcos::Decoder;

use self::{
    battery::Battery,
    bumper_places::{N_SEGMENTS, bumper_bearings_deg},
    device_state::{N_REQUESTS_MAX, Stream, Streams},
    motion::{Motion, MotionLimits},
    sonar_ring::SonarRing,
};
use crate::{BatteryConfig, MotorReference, NumberSet, SimRequest, bumpers::Bumpers};

/// A packet that stays unfinished for this long is noise; the manufacturer's library waits as long.
const UNFINISHED_MAX: Duration = Duration::from_millis(100);

/// The front of a pair of front and rear.
const FRONT: usize = 0;
/// The rear of such a pair.
const REAR: usize = 1;

/// What one robot of a model has of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct PioneerConfig {
    /// The name it reports.
    pub name: String,
    /// The serial number it reports.
    pub serial: String,
    /// Time without a packet after which the motors stop; zero switches the watchdog off.
    pub watchdog: Duration,
    /// The battery.
    pub battery: BatteryConfig,
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
    /// Bumper segments that are pressed, front and rear: bit 0 is the first, counted clockwise.
    pub bumpers: [u8; 2],
}

/// What a simulator knows of a robot and the robot does not.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SimTruth {
    world_from_base: Se2,
    /// Smallest x and y, largest x and y of the walls, metres; `None` without walls.
    bounds_m: Option<[f64; 4]>,
    /// Length of a step of the world.
    step: Duration,
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
    /// Every echo so far, in order.
    heard: StateHash,
    /// Way since switching on, forwards less backwards.
    odometer_m: f64,
    travel_since_sip_m: [f64; 2],
    wheel_speeds: WheelSpeeds,
    feedback: MotorFeedback,
    motors_enabled: bool,
    battery: Battery,
    bumpers: Bumpers,
    /// Whether a pressed bumper of the front, of the rear, is a stall.
    bump_stall: [bool; 2],
    streams: Streams,
    digital_out: u8,
    analogue_port: u8,
    last_step: Option<Stamp>,
    last_byte: Stamp,
    /// `None` once the watchdog has stopped the motors.
    last_packet: Option<Stamp>,
    last_sip: Stamp,
    /// Known while somebody asks for it.
    truth: Option<SimTruth>,
    last_interval: Option<Duration>,
    sim_requests: Vec<SimRequest>,
    unknown: NumberSet,
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
            watchdog: Duration::from_secs(2),
            battery: BatteryConfig::default(),
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
        let sonar = SonarRing::new(model.sonars.len(), model.ring, config.sonar_on);
        Self {
            battery: Battery::new(config.battery),
            bumpers: Bumpers::new(model.footprint.corners(), bumper_bearings_deg()),
            odometry: Odometry::new(model.drive),
            model,
            config,
            rng,
            decoder: Decoder::new(),
            session: Session::Closed,
            motion: Motion::new(limits),
            sonar,
            heard: StateHash::new(),
            odometer_m: 0.0,
            travel_since_sip_m: [0.0; 2],
            wheel_speeds: WheelSpeeds::ZERO,
            feedback: MotorFeedback::default(),
            motors_enabled: false,
            bump_stall: [false; 2],
            streams: Streams::default(),
            digital_out: 0,
            analogue_port: 0,
            last_step: None,
            last_byte: Stamp::ZERO,
            last_packet: None,
            last_sip: Stamp::ZERO,
            truth: None,
            last_interval: None,
            sim_requests: Vec::new(),
            unknown: NumberSet::default(),
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
            // Nothing lies against a body that touches nothing.
            bumpers: if body.touching { self.pressed(world, body_id) } else { [0; 2] },
        };
        self.truth = self.streams.sim_stat.is_wanted().then(|| truth(world, body_id));
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
        self.feel(feedback, now.since(before));
        if self.session == Session::Open {
            let heard = &mut self.heard;
            let mut ping = |sensor_index| {
                let range_m = ping(sensor_index);
                heard.absorb_u64(range_m.to_bits());
                range_m
            };
            self.sonar.fire(before, now, &mut ping);
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

    /// The real time that the last turn of the simulator's loop took: clients can ask for it.
    pub fn note_interval(&mut self, interval: Duration) {
        self.last_interval = Some(interval);
    }

    /// Time without a packet after which the motors stop; zero when the watchdog is off.
    pub fn watchdog(&self) -> Duration {
        self.config.watchdog
    }

    /// Charge of the battery, percent of full.
    pub fn charge_percent(&self) -> f64 {
        self.battery.charge_percent()
    }

    /// Whether the battery's voltage is below what the configuration packet calls low, 11 V.
    pub fn battery_is_low(&self) -> bool {
        self.battery.is_low()
    }

    /// Voltage of the battery, V.
    pub fn battery_v(&self) -> f64 {
        self.battery.voltage_v()
    }

    /// What became of the packets received.
    pub fn counters(&self) -> FirmwareCounters {
        self.counters
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    /// Adds what decides the firmware's future to `hash`, and what its sonars have heard.
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
        hash.absorb(self.battery.charge_percent());
        hash.absorb_u64(self.heard.value());
    }

    fn feel(&mut self, feedback: MotorFeedback, dt: Duration) {
        let [left, right] = feedback.encoder_ticks;
        if self.last_step.is_none() {
            self.odometry.set_ticks(left, right);
        }
        let travel = self.odometry.update(left, right);
        self.odometer_m += 0.5 * (travel.left_m + travel.right_m);
        self.travel_since_sip_m[0] += travel.left_m;
        self.travel_since_sip_m[1] += travel.right_m;
        self.feedback = feedback;
        let way_m = 0.5 * (travel.left_m.abs() + travel.right_m.abs());
        self.battery.drain(dt, self.motors_enabled, way_m);
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
        let stalls = self.bump_stalls();
        if stalls != [false; 2] {
            self.motion.hold_back(stalls, self.odometer_m);
        }
        if self.motors_enabled && self.battery.is_empty() {
            self.enable(false);
        }
    }

    /// Whether a pressed bumper of the front, of the rear, counts as a stall now.
    fn bump_stalls(&self) -> [bool; 2] {
        [FRONT, REAR].map(|ring| self.bump_stall[ring] && self.feedback.bumpers[ring] != 0)
    }

    /// Ends the session: what the client has set returns to its default.
    fn close(&mut self) {
        self.session = Session::Closed;
        self.motors_enabled = false;
        self.bump_stall = [false; 2];
        self.streams = Streams::default();
        self.sonar = SonarRing::new(self.model.sonars.len(), self.model.ring, self.config.sonar_on);
        self.motion.stop_at_once();
        self.motion.limits = starting_limits(&self.model);
    }

    fn ask_simulator(&mut self, request: SimRequest) {
        if self.sim_requests.len() < N_REQUESTS_MAX {
            self.sim_requests.push(request);
        } else {
            self.counters.n_unexpected += 1;
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

/// What the world knows of a robot.
fn truth(world: &World, body_id: BodyId) -> SimTruth {
    let bounds = world.static_map().bounds();
    let bounds_m = (!world.static_map().is_empty()).then_some([
        bounds.min.x,
        bounds.min.y,
        bounds.max.x,
        bounds.max.y,
    ]);
    let world_from_base = world.body(body_id).world_from_base.se2();
    SimTruth { world_from_base, bounds_m, step: world.step_duration() }
}
