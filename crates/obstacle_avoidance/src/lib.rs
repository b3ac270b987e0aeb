//! Reactive avoidance for robots with a few range sensors: the sensitivity bubble and its rebound.
//!
//! The problem: a robot that follows something else (a trail, a line to a goal) must stop before
//! what stands in its way and get around it, with eight sonars and very little computation. The
//! method is the thesis's *bubble rebound*: a boundary around the robot that grows with its speed
//! ([`Bubble`], 6.3.1), a new heading that is the mean of the sensors' directions weighted by what
//! they see ([`rebound_angle_rad`], 6.3), and a machine of nine states that strings both together
//! ([`Machine`], Annex C). It is cheap and near-sighted: it finds its way out of no labyrinth, so
//! feed it intermediate goals there.
//!
//! Two extensions of ours make it safe for a robot whose rear is longer than its front: a short
//! memory of echoes ([`EchoMemory`]) against which straight legs and turns in place can be checked
//! before they are driven, and [`find_detour`], which looks for a via-point that passes these
//! checks. Both are optional; the machine works without them.
//!
//! Nothing here knows one kind of robot: sensors are ranges with places and bearings
//! ([`RangeSensor`]), so infrared or laser rays do as well. There are no maps here, and no path
//! followers: when the machine says [`Motion::Follow`], its owner steers towards
//! [`Machine::target`]. The tests' oracles are the golden values of the thesis's listing, slow
//! definitions written anew, and laws (mirror symmetry, monotony).

mod bubble;
mod detour;
mod echoes;
mod footprint;
mod machine;
mod rebound;
mod sweep;

pub use bubble::{Bubble, BubbleError, Intrusion};
pub use detour::{Detour, DetourConfig, find_detour};
pub use echoes::{EchoMemory, EchoMemoryConfig, Ray, Rays};
pub use footprint::Footprint;
pub use machine::{
    HeadingCheck, Inputs, Machine, MachineConfig, MachineConfigError, Motion, N_STATES, Outcome,
    Output, State, Variant,
};
pub use rebound::{ForcedSwing, nominal_bearing_rad, rebound_angle_rad, rebound_turn_rad};
pub use sweep::{Arc, Hull};

use geometry::Vec2;

/// Where a range sensor sits on the robot and which way it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeSensor {
    /// Its place on the robot (m, base frame).
    pub in_base: Vec2,
    /// Its axis, radians from straight ahead, counter-clockwise.
    pub bearing_rad: f64,
}
