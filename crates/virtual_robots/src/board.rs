//! What every firmware is to those who run it: a board on a body, with ports.
//!
//! A trait and not an enum, because a robot can come from outside this crate; the call through it is one for
//! each board and step. Who steps boards (a mission, [`ServedWorld`](crate::ServedWorld), a test) needs no robot's name.

use std::{fmt::Debug, time::Duration};

use geometry::Se2;
use robot_models::WheelSpeeds;
use run_context::{Stamp, StateHash};
use simulator::{BodyId, World};

/// Firmware of a simulated body: it has a clock and ports, reads the devices of its body, drives its
/// motors and speaks bytes.
///
/// It may read of the world what the body's devices sense, and nothing else of it. It never opens a
/// socket and never panics on bytes, whatever they are.
pub trait Board: Debug + Send + Sync {
    /// Names of its ports, in the order in which [`step`](Self::step) takes them; always the same.
    fn ports(&self) -> &'static [&'static str] {
        &["host"]
    }

    /// One step at `now`, which never goes back: takes what came in at each port, appends what goes out, and says what
    /// the motors should do; `None` from a board that drives none. Steps of 10 ms are usual.
    ///
    /// A port that is missing in `ports` hears nothing and is not heard.
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference>;

    /// The client at that port is gone (a socket was closed). A serial line cannot tell, so firmware does here what
    /// its maker's simulator does; a robot that serves one port stops.
    fn hang_up(&mut self, port_index: usize);

    /// What can be told of it now to those who watch.
    fn status(&self) -> BoardStatus;

    /// Moves what clients asked of the simulator, in order, to the end of `_into`.
    fn take_requests(&mut self, _into: &mut Vec<SimRequest>) {}

    /// The real time that the last turn of the simulator's loop took.
    fn note_interval(&mut self, _interval: Duration) {}

    /// Adds what decides its future to `hash`, and what its devices have sensed.
    fn absorb_state(&self, hash: &mut StateHash);
}

/// One port of a board in one step.
#[derive(Debug)]
pub struct Port<'a> {
    /// What came in since the last step.
    pub received: &'a [u8],
    /// What goes out is appended here.
    pub out: &'a mut Vec<u8>,
}

/// What the firmware asks of the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorReference {
    /// Wheel speeds, already ramped under the limits the client set.
    pub wheels: WheelSpeeds,
    /// What the motors may accelerate with to get there, m/s².
    pub acceleration_mps2: f64,
}

/// What can be told of a board to those who watch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoardStatus {
    /// Whether a client has begun a session.
    pub is_open: bool,
    /// Whether its motors follow their reference.
    pub motors_enabled: bool,
    /// Messages understood so far, on all ports: a client for which this stands still is silent.
    pub n_heard: u64,
    /// Numbers of the commands of this session, or of the last one, that mean nothing to it.
    pub unknown: NumberSet,
    /// Its battery, if it has one of its own.
    pub battery: Option<BatteryStatus>,
    /// Speed at which it speaks now, bits per second, where a client may have changed that; else `None`.
    pub baud: Option<u32>,
}

/// How a battery stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryStatus {
    /// Charge, percent of full.
    pub charge_percent: f64,
    /// Voltage, V.
    pub voltage_v: f64,
    /// Whether the robot itself calls that low.
    pub is_low: bool,
}

/// How a robot's battery stands when it is switched on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryConfig {
    /// Charge, percent of full, from 0 to 100.
    pub charge_percent: f64,
    /// How much faster it empties than a real one; 0: never.
    pub drain_ratio: f64,
}

impl Default for BatteryConfig {
    fn default() -> Self {
        Self { charge_percent: 100.0, drain_ratio: 1.0 }
    }
}

/// What one robot of a model has of its own, whatever its firmware.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardConfig {
    /// The name it reports, where the protocol has a word for that.
    pub name: String,
    /// Its battery.
    pub battery: BatteryConfig,
}

/// What a client of a simulated robot wants of the simulator.
#[derive(Clone, Debug, PartialEq)]
pub enum SimRequest {
    /// That the true robot is put there, in the world.
    PlaceAt(Se2),
    /// That the true robot is put where it began.
    Reset,
    /// That whoever watches reads this; at most 195 bytes, from a stranger.
    Say(String),
    /// That the simulator ends with this exit code.
    Exit(i16),
    /// Nothing; the firmware tells whoever watches what a client could not see otherwise, such as why it stands.
    Note(String),
}

/// A set of numbers of commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NumberSet([u64; 4]);

impl NumberSet {
    /// Adds a number.
    pub fn insert(&mut self, number: u8) {
        self.0[usize::from(number >> 6)] |= 1 << (number & 63);
    }

    /// The numbers, the smallest first.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |n| self.0[usize::from(n >> 6)] >> (n & 63) & 1 != 0)
    }
}
