//! What is driven, and what mapping it takes.

use super::method::Method;

pub(super) const FIVE: &str = "artemic5";
pub(super) const EIGHT: &str = "artemic8";

/// A drive, and how its recordings are mapped.
#[derive(Debug)]
pub(super) struct Task {
    /// Index of the room.
    pub(super) room: usize,
    /// To the left; the second of two runs takes it to the right.
    pub(super) drift_degpm: f64,
    pub(super) is_half_speed: bool,
    pub(super) methods: Vec<Method>,
}

/// What mapping a recording takes.
#[derive(Clone, Debug)]
pub(super) struct Timing {
    pub(super) label: String,
    pub(super) took_s: f64,
    pub(super) drive_s: f64,
    pub(super) n_maps: usize,
}
