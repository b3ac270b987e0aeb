//! The client of an iRobot Create 2: begins its interface, reads its stream, drives.
//!
//! **Connecting.** START and STREAM, until a frame comes. The robot is in passive mode then, whatever it was doing before: START
//! is also the surest way to stop it, and only a robot that reports it has heard it. Some firmware reports modes one too high: one
//! that stands and keeps to 2 whatever it is told is taken to mean passive by it. Then SAFE, until it reports that.
//!
//! **Driving.** The robot has no watchdog: it goes on with its last speeds for ever. So every motion command holds for
//! [`CreateDriverConfig::hold_max`] and must be renewed, except a turn, which ends by itself; and when steps of this driver
//! are farther apart than [`CreateDriverConfig::gap_max`] (the computer slept), the robot is stopped before anything else.
//! The speeds that the robot reports as asked for are compared with those that were, and sent again.
//!
//! **Turning** to a heading is done here, by the encoders; the robot knows no such command.
//!
//! **Odometry** is worked out here: differences of two counters modulo 65 536, taken as signed. After a time without
//! frames a difference that the wheels could not have made is passed over (the robot was switched off and on).
//!
//! **Cliffs, dropped wheels, chargers** put the robot into passive mode. The motion is forgotten then, what it stands at is
//! reported as a stall, and it is asked for safe mode again twice a second; while it sees a cliff it is driven backwards
//! and on the spot only.
//!
//! **Lost.** Whoever loses sight stops first: a robot that is not heard for [`CreateDriverConfig::silence_max`], or whose
//! reported speeds do not follow the commands for as long (it hears nothing), is told to stand and put into passive mode by
//! START, over and over, until it is heard again. If the line towards it is cut, nothing stops it: that is the robot.
//!
//! Source: iRobot Create 2 Open Interface Specification (2016); order of the start, and the end by a stop, START and STOP:
//! `AutonomyLab/libcreate`. Differences: that one takes counters to wrap at 65 535.

mod connection;
mod driving;
mod motion;
mod odometer;
mod state;

use messages::{
    Battery, Command, Contacts, LinkState, Motors, Observations, OdometryReading, Sensed,
};
use robot_models::{RobotModel, WheelSpeeds};
use run_context::Stamp;
use wire::create_oi::{Command as Packet, Frame, Readings, StreamDecoder, ids};

pub use self::state::{CreateCounters, CreateDriver, CreateDriverConfig};
use self::{
    motion::Motion,
    odometer::Odometer,
    state::{N_HOLDS, Phase, STANDING_MPS, Seen, UNFINISHED_MAX, send, stand},
};
use crate::{Driver, DriverConfig};

impl CreateDriver {
    /// A driver that will connect at its first step, with motors to be switched on.
    pub fn new(config: CreateDriverConfig) -> Self {
        Self {
            decoder: StreamDecoder::new(),
            phase: Phase::Looking,
            phase_since: Stamp::ZERO,
            last_step: None,
            last_byte: Stamp::ZERO,
            last_frame: Stamp::ZERO,
            mode_offset: None,
            n_looks: 0,
            n_wishes: 0,
            motors_wanted: true,
            motion: Motion::default(),
            odometer: Odometer::new(config.drive),
            seen: Seen::default(),
            counters: CreateCounters::default(),
            config,
        }
    }

    /// The driver for a robot of the catalogue.
    pub(crate) fn for_robot(model: &RobotModel, config: &DriverConfig) -> Box<dyn Driver> {
        let mut limits = model.limits;
        limits.acceleration_max_mps2 = config.acceleration_mps2.min(limits.acceleration_max_mps2);
        Box::new(Self::new(CreateDriverConfig {
            line: config.line,
            ..CreateDriverConfig::new(model.drive, limits)
        }))
    }

    /// What the driver did and met.
    pub fn counters(&self) -> CreateCounters {
        self.counters
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &StreamDecoder {
        &self.decoder
    }

    fn take(
        &mut self,
        now: Stamp,
        frame: &Frame,
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        let about = self.config.line.sent_at(now, frame.n_bytes);
        let r = &frame.readings;
        let get = |id| r.get(id).unwrap_or(0);
        // A frame of another client's stream tells too little.
        let (Some(left), Some(right)) = (r.get(ids::ENCODER_LEFT), r.get(ids::ENCODER_RIGHT))
        else {
            return;
        };
        self.counters.n_frames += 1;
        self.last_frame = now;
        if !self.odometer.take(about, [left, right], self.config.limits.speed_max_mps) {
            self.counters.n_jumps += 1;
        }
        self.see(r);
        self.keep_mode(now, get(ids::MODE), out);
        if self.phase == Phase::Looking {
            if !self.has_stopped(get(ids::MODE)) {
                return;
            }
            self.enter_safe(now, out);
            self.seen.is_drivable = false;
            self.phase = Phase::Connected;
            self.counters.n_connections += 1;
            self.motion = Motion::at_rest(now);
            observations.push(now, Sensed::Link(LinkState::Up));
        }
        self.tell(about, get(ids::VOLTAGE), observations);
        self.keep_driving(now, out);
    }

    fn see(&mut self, r: &Readings) {
        let get = |id| r.get(id).unwrap_or(0);
        let bumps = get(ids::BUMPS_AND_DROPS);
        let overcurrents = get(ids::OVERCURRENTS);
        let bit = |of: i32, n: i32| of >> n & 1 != 0;
        self.seen.contacts = Contacts {
            stalled: [bit(overcurrents, 4), bit(overcurrents, 3)],
            // The packets number from the right, everybody else from the left.
            bumpers: u16::from(bit(bumps, 1)) | u16::from(bit(bumps, 0)) << 1,
            cliffs: (0..4)
                .fold(0, |bits, place| bits | u8::from(get(ids::CLIFF_LEFT + place) != 0) << place),
            dropped: [bit(bumps, 3), bit(bumps, 2)],
        };
        let mode = get(ids::MODE) - self.mode_offset.unwrap_or(0);
        let was_drivable = std::mem::replace(&mut self.seen.is_drivable, mode >= 2);
        self.seen.asked_mmps = [get(ids::REQUESTED_LEFT), get(ids::REQUESTED_RIGHT)];
        self.seen.charges = get(ids::CHARGING_SOURCES) != 0;
        if was_drivable && !self.seen.is_drivable && self.phase == Phase::Connected {
            self.counters.n_safety_stops += 1;
            self.motion.forget();
        }
    }

    /// What the frame says, device by device.
    fn tell(&self, about: Stamp, millivolts: i32, observations: &mut Observations) {
        let enabled = self.seen.is_drivable;
        observations.push(about, Sensed::Motors(Motors { enabled }));
        let voltage_v = 0.001 * f64::from(millivolts);
        observations.push(about, Sensed::Battery(Battery { voltage_v }));
        observations.push(about, Sensed::Contact(self.seen.contacts));
        let wheel_speeds = self.odometer.wheel_speeds();
        let WheelSpeeds { left_mps, right_mps } = wheel_speeds;
        let odometry = OdometryReading {
            odom_from_base: self.odometer.odom_from_base(),
            wheel_speeds,
            moving: left_mps.abs() > STANDING_MPS || right_mps.abs() > STANDING_MPS,
        };
        observations.push(about, Sensed::Odometry(odometry));
    }
}

impl Driver for CreateDriver {
    /// Does not allocate between one connection and the next.
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        let before = self.last_step.replace(now);
        if before.is_some_and(|before| now.since(before) >= self.config.gap_max)
            && self.motion.moves()
        {
            // It drove on unseen: first of all it stands.
            self.counters.n_dead_man_stops += 1;
            self.motion.forget();
            stand(out);
        }
        if !received.is_empty() {
            self.decoder.push(received);
            self.last_byte = now;
        } else if self.decoder.has_unfinished() && now.since(self.last_byte) >= UNFINISHED_MAX {
            self.decoder.give_up_unfinished();
        }
        while let Some(frame) = self.decoder.next_frame() {
            self.take(now, &frame, observations, out);
        }
        self.keep_up(now, before.is_none(), observations, out);
    }

    fn command(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        match *command {
            Command::EnableMotors(on) => self.enable(on, out),
            Command::Drive(_) | Command::TurnTo { .. } | Command::Stop => {
                if self.phase == Phase::Connected {
                    self.move_as(now, command, out);
                }
            }
            Command::QueryPheromones { .. } | Command::Report(_) => {}
        }
    }

    fn disconnect(&mut self, now: Stamp, out: &mut Vec<u8>) {
        stand(out);
        send(&Packet::Start, out);
        send(&Packet::Stop, out);
        self.begin_looking(now);
    }

    fn hold(&self, out: &mut Vec<u8>) {
        for _ in 0..N_HOLDS {
            stand(out);
        }
    }

    fn is_connected(&self) -> bool {
        self.phase == Phase::Connected
    }
}
