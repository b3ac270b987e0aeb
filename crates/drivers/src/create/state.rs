//! What the driver remembers between two steps.

use std::time::Duration;

use messages::Contacts;
use robot_models::{DriveGeometry, DriveLimits};
use run_context::Stamp;
use wire::create_oi::{Command as Packet, StreamDecoder, ids};

use super::{motion::Motion, odometer::Odometer};
use crate::LineTiming;

/// The packets that are streamed.
pub(super) const STREAM: [u8; 17] = [
    ids::BUMPS_AND_DROPS,
    ids::CLIFF_LEFT,
    ids::CLIFF_LEFT + 1,
    ids::CLIFF_LEFT + 2,
    ids::CLIFF_LEFT + 3,
    ids::VIRTUAL_WALL,
    ids::OVERCURRENTS,
    ids::CHARGING_STATE,
    ids::VOLTAGE,
    ids::CHARGING_SOURCES,
    ids::MODE,
    ids::REQUESTED_RIGHT,
    ids::REQUESTED_LEFT,
    ids::ENCODER_LEFT,
    ids::ENCODER_RIGHT,
    ids::LIGHT_BUMPER,
    ids::STASIS,
];

/// Time without a byte after which a frame that has begun is noise.
pub(super) const UNFINISHED_MAX: Duration = Duration::from_millis(100);

/// Wheels slower than this stand, m/s: a count in 100 ms is 4 mm/s.
pub(super) const STANDING_MPS: f64 = 0.005;

/// How to talk to one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreateDriverConfig {
    /// Its wheels.
    pub drive: DriveGeometry,
    /// What its wheels can do.
    pub limits: DriveLimits,
    /// How long a motion command holds without being renewed; a turn ends by itself.
    pub hold_max: Duration,
    /// Time between two steps after which the robot drove unseen and is stopped first.
    pub gap_max: Duration,
    /// Time without a frame after which the connection counts as lost.
    pub silence_max: Duration,
    /// What a packet's way takes.
    pub line: LineTiming,
}

/// What the driver did and met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CreateCounters {
    /// Frames understood.
    pub n_frames: u64,
    /// Connections made.
    pub n_connections: u64,
    /// Times that connecting had to be begun again.
    pub n_retries: u64,
    /// Speeds sent again because the robot reported others.
    pub n_mended: u64,
    /// Times that the robot left safe mode by itself.
    pub n_safety_stops: u64,
    /// Times that motion was ended because nobody renewed it, or because steps were far apart.
    pub n_dead_man_stops: u64,
    /// Times that the robot was lost.
    pub n_losses: u64,
    /// Jumps of the counters that wheels could not have made.
    pub n_jumps: u64,
}

/// The driver of one Create.
#[derive(Clone, Debug)]
pub struct CreateDriver {
    pub(super) config: CreateDriverConfig,
    pub(super) decoder: StreamDecoder,
    pub(super) phase: Phase,
    /// When the phase's last packet was sent.
    pub(super) phase_since: Stamp,
    pub(super) last_step: Option<Stamp>,
    pub(super) last_byte: Stamp,
    pub(super) last_frame: Stamp,
    /// By how much the modes that the robot reports are too high; `None` before it is known.
    pub(super) mode_offset: Option<i32>,
    /// How often START was sent since the robot was lost, and SAFE since it was drivable.
    pub(super) n_looks: u32,
    pub(super) n_wishes: u32,
    pub(super) motors_wanted: bool,
    pub(super) motion: Motion,
    pub(super) odometer: Odometer,
    /// Modes, contacts and speeds as the last frame had them.
    pub(super) seen: Seen,
    pub(super) counters: CreateCounters,
}

/// What the last frame said, as far as it decides something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) is_drivable: bool,
    pub(super) contacts: Contacts,
    pub(super) asked_mmps: [i32; 2],
    pub(super) charges: bool,
}

impl CreateDriverConfig {
    /// For a robot with these wheels.
    pub fn new(drive: DriveGeometry, limits: DriveLimits) -> Self {
        Self {
            drive,
            limits,
            hold_max: Duration::from_millis(2500),
            gap_max: Duration::from_millis(500),
            silence_max: Duration::from_millis(500),
            line: LineTiming::default(),
        }
    }
}

/// How far the connection has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// START and STREAM were sent; a frame is awaited.
    Looking,
    /// Frames come in.
    Connected,
}

/// Stops for a robot that will hear nothing for a while: one may be lost.
pub(super) const N_HOLDS: usize = 3;

/// Appends the command to stand.
pub(super) fn stand(out: &mut Vec<u8>) {
    send(&Packet::DriveDirect { right_mmps: 0, left_mmps: 0 }, out);
}

pub(super) fn send(packet: &Packet, out: &mut Vec<u8>) {
    packet.encode(out);
}
