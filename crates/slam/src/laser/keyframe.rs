//! Scans that became part of the map.

use run_context::Stamp;

use super::{points::PointScan, sight::Sight};

/// A scan that became part of the map.
#[derive(Clone, Debug)]
pub struct Keyframe {
    /// Index of the scan.
    pub scan_index: usize,
    /// When.
    pub stamp: Stamp,
    /// What it saw, in `Base`.
    pub points: PointScan,
    /// How far it saw in each direction.
    pub(crate) sight: Sight,
    /// Way from the start, metres.
    pub travelled_m: f64,
}
