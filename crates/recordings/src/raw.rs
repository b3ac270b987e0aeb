//! Rows as they stand in a file, before they are in order.

use std::collections::BTreeMap;

use geometry::Se2;

use crate::{complaints::Place, recording::Rig};

/// A scan as it stands in a file.
#[derive(Clone, Debug)]
pub(crate) struct RawScan {
    pub(crate) place: Place,
    pub(crate) stamp_ns: i64,
    pub(crate) odom: Option<Se2>,
    pub(crate) reference: Option<Se2>,
    pub(crate) truth: Option<Se2>,
    pub(crate) ranges_m: Vec<f64>,
    /// For each reading, or empty.
    pub(crate) stamps_ns: Vec<i64>,
    /// Readings of unknown sonars, or empty.
    pub(crate) extra_m: Vec<f64>,
}

impl Default for RawScan {
    fn default() -> Self {
        Self {
            place: Place::File,
            stamp_ns: 0,
            odom: None,
            reference: None,
            truth: None,
            ranges_m: Vec::new(),
            stamps_ns: Vec::new(),
            extra_m: Vec::new(),
        }
    }
}

/// A pose as it stands in a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RawPose {
    pub(crate) place: Place,
    pub(crate) stamp_ns: i64,
    pub(crate) pose: Se2,
}

/// What was read from a file, in its order.
#[derive(Clone, Debug)]
pub(crate) struct RawRecording {
    pub(crate) rig: Rig,
    pub(crate) scans: Vec<RawScan>,
    /// Odometry lines of their own.
    pub(crate) odometry: Vec<RawPose>,
    /// True poses with stamps of their own, for scans that carry none.
    pub(crate) truth: Vec<RawPose>,
}

impl RawRecording {
    pub(crate) fn new(rig: Rig, scans: Vec<RawScan>) -> Self {
        Self { rig, scans, odometry: Vec::new(), truth: Vec::new() }
    }
}

/// The number of readings that most scans have; the first one met, of equally frequent ones.
pub(crate) fn usual_count(scans: &[RawScan]) -> usize {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for scan in scans {
        *counts.entry(scan.ranges_m.len()).or_insert(0) += 1;
    }
    let most = counts.values().copied().max().unwrap_or(0);
    let usual = scans.iter().map(|s| s.ranges_m.len()).find(|n| counts.get(n) == Some(&most));
    usual.unwrap_or(0)
}
