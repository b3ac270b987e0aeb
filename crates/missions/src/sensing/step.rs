//! What one robot reported and measured in a step.

use geometry::Se2;
use messages::N_RING_MAX;
use recordings::{Scan, StampedPose};
use run_context::Stamp;

/// A robot's report of its pose, and where it truly was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReport {
    /// The time that it is about.
    pub stamp: Stamp,
    /// Dead reckoning as the navigator was told: (0, 0, 0) where the robot was switched on.
    pub odom_from_base: Se2,
    /// The truth at that time; `None` for a robot elsewhere. For judging only.
    pub world_from_base: Option<Se2>,
}

/// One reading of every sonar of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingRow {
    /// The report that made the row whole.
    pub report: PoseReport,
    ranges_m: [f64; N_RING_MAX],
    stamps: [Stamp; N_RING_MAX],
    n_sonars: usize,
}

/// What one robot reported and measured during one step of a run.
#[derive(Clone, Copy, Debug)]
pub struct SensedStep<'a> {
    /// Its reports, oldest first; most steps have none.
    pub reports: &'a [PoseReport],
    /// The rows that became whole, oldest first.
    pub rows: &'a [RingRow],
    /// The scans of its lasers that can be dated now, oldest first.
    pub scans: &'a [ScanRow],
}

/// One scan of a laser, with a range for each beam of its fan, counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScanRow {
    /// Which of the robot's lasers, from 0.
    pub laser: usize,
    /// When its first beam was fired, as well as the driver knows.
    pub stamp: Stamp,
    /// Dead reckoning at that time, as the navigator was told of it; `None` while that is not known.
    pub odom_from_base: Option<Se2>,
    /// The truth at that time; `None` for a robot elsewhere. For judging only.
    pub world_from_base: Option<Se2>,
    /// The ranges, metres; infinite where nothing came back or nothing is known.
    pub ranges_m: Vec<f64>,
    /// When each beam was fired.
    pub stamps: Vec<Stamp>,
}

impl ScanRow {
    /// The scan as recordings hold it.
    pub fn to_scan(&self) -> Scan {
        Scan {
            stamp: self.stamp,
            odom_from_base: self.odom_from_base,
            ranges_m: self.ranges_m.clone(),
            stamps: self.stamps.clone(),
        }
    }
}

impl RingRow {
    /// A row without readings.
    pub(crate) fn empty(n_sonars: usize) -> Self {
        let pose = Se2::IDENTITY;
        let report = PoseReport { stamp: Stamp::ZERO, odom_from_base: pose, world_from_base: None };
        let (ranges_m, stamps) = ([0.0; N_RING_MAX], [Stamp::ZERO; N_RING_MAX]);
        Self { report, ranges_m, stamps, n_sonars: n_sonars.min(N_RING_MAX) }
    }

    /// Puts in the reading of sonar `index`, which the robot has.
    pub(crate) fn set(&mut self, index: usize, range_m: f64, stamp: Stamp) {
        self.ranges_m[index] = range_m;
        self.stamps[index] = stamp;
    }

    /// The readings in the order of the sonars, metres; the ring's greatest range where nothing came back.
    pub fn ranges_m(&self) -> &[f64] {
        &self.ranges_m[..self.n_sonars]
    }

    /// When each reading was taken, as well as the driver knows; none is later than the report.
    pub fn stamps(&self) -> &[Stamp] {
        &self.stamps[..self.n_sonars]
    }

    /// The row as recordings hold it.
    pub fn to_scan(&self) -> Scan {
        Scan {
            stamp: self.report.stamp,
            odom_from_base: Some(self.report.odom_from_base),
            ranges_m: self.ranges_m().to_vec(),
            stamps: self.stamps().to_vec(),
        }
    }
}

impl PoseReport {
    /// Its dead reckoning as recordings hold it.
    pub fn odometry(&self) -> StampedPose {
        StampedPose { stamp: self.stamp, pose: self.odom_from_base }
    }

    /// The truth as recordings hold it; `None` for a robot elsewhere.
    pub fn truth(&self) -> Option<StampedPose> {
        self.world_from_base.map(|pose| StampedPose { stamp: self.stamp, pose })
    }
}
