//! What the firmware remembers between two steps.

use std::{sync::Arc, time::Duration};

use robot_models::{RobotModel, WheelSpeeds};
use run_context::Stamp;
use simulator::{BodyId, World};
use wire::create_oi::{CommandDecoder, Radius};

use super::power::Power;
use crate::{NumberSet, SimRequest, bumpers::Bumpers};

/// What it feels in every step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Feel {
    /// Bit 0 right, bit 1 left, as the packet has them.
    pub(super) bumps: u8,
    /// Right and left wheel.
    pub(super) drops: [bool; 2],
    /// Left, front left, front right, right.
    pub(super) cliffs: [bool; 4],
    /// Left and right.
    pub(super) stalled: [bool; 2],
    pub(super) is_docked: bool,
    pub(super) hears_wall: bool,
}

/// Time between two frames of a stream.
pub(super) const STREAM_PERIOD: Duration = Duration::from_millis(15);
/// Time in passive mode after which it falls asleep.
pub(super) const AWAKE_MAX: Duration = Duration::from_mins(5);
/// Speed of its line when it has been switched on, where the catalogue says nothing, bits per second.
pub(super) const BAUD: u32 = 115_200;
/// Songs that it can keep.
pub(super) const N_SONGS: usize = 5;
/// Notes for those who watch that may wait; the rest are dropped.
pub(super) const N_NOTES_MAX: usize = 16;
/// Charge below which it is low, percent.
pub(super) const LOW_PERCENT: f64 = 20.0;

/// What it lets a client do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mode {
    Off,
    Passive,
    Safe,
    Full,
}

/// What was asked of the wheels last, as the packets say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Requested {
    pub(super) velocity_mmps: i16,
    pub(super) radius: Radius,
    pub(super) right_mmps: i16,
    pub(super) left_mmps: i16,
}

pub(super) const REST: Requested =
    Requested { velocity_mmps: 0, radius: Radius::Straight, right_mmps: 0, left_mmps: 0 };

/// One Create's firmware.
#[derive(Clone, Debug)]
pub struct CreateFirmware {
    pub(super) model: Arc<RobotModel>,
    pub(super) decoder: CommandDecoder,
    pub(super) mode: Mode,
    pub(super) is_asleep: bool,
    pub(super) passive_since: Stamp,
    pub(super) requested: Requested,
    pub(super) wheels: WheelSpeeds,
    /// What the encoders say, before they wrap.
    pub(super) counts: [i64; 2],
    /// Which way the wheels are taken to turn.
    pub(super) signs: [i64; 2],
    pub(super) ticks: Option<[i64; 2]>,
    pub(super) distance_m: f64,
    pub(super) angle_rad: f64,
    pub(super) bumpers: Bumpers,
    pub(super) feel: Feel,
    pub(super) power: Power,
    pub(super) stream: Vec<u8>,
    pub(super) is_streaming: bool,
    pub(super) next_frame: Stamp,
    pub(super) songs: [Vec<[u8; 2]>; N_SONGS],
    pub(super) song_number: u8,
    pub(super) song_ends: Stamp,
    pub(super) buttons: u8,
    pub(super) buttons_end: Stamp,
    pub(super) baud: u32,
    pub(super) n_heard: u64,
    pub(super) unknown: NumberSet,
    /// Commands that were told of in this mode already, because they came in the wrong one.
    pub(super) unexpected: NumberSet,
    pub(super) notes: Vec<SimRequest>,
    pub(super) now: Stamp,
    pub(super) last_step: Option<Stamp>,
}

/// Where the firmware is: what its devices may be asked about.
#[derive(Clone, Copy)]
pub(super) struct Site<'a> {
    pub(super) world: &'a World,
    pub(super) body_id: BodyId,
}
