//! What the robots of a run sensed, as recordings that can be mapped afterwards and judged against the truth.
//!
//! A row is one reading of every sonar of a robot. It is complete with the report of the robot that brings the last
//! of them, and holds what the navigator was told: ranges, each with its own time, and dead reckoning with
//! all its errors. The true pose stands beside it, for judging only.

use geometry::Se2;
use messages::N_RING_MAX;
use recordings::{Recording, Scan, StampedPose};
use run_context::{RunSeed, Stamp};

use crate::{
    mission::Mission,
    run::{Run, RunError, rig},
    summary::Summary,
};

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
}

/// Collects what the robots of a run sense, in memory.
///
/// ```
/// use missions::{Mission, Run, SensorLog};
///
/// let mission = Mission::load("one-obstacle", &[])?;
/// let seed = mission.seed();
/// let mut run = Run::new(mission, seed)?;
/// let mut log = SensorLog::new(&run);
/// for _ in 0..500 {
///     run.step();
///     log.take(&run);
/// }
/// let (name, recording) = &log.into_recordings()[0];
/// assert_eq!(name, "robot");
/// assert_eq!(recording.scans.len(), recording.truth.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SensorLog {
    robots: Vec<(String, Recording)>,
}

/// A run that has ended, and what its robots sensed.
#[derive(Clone, Debug)]
pub struct SensedRun {
    /// Each robot's name and recording, in the robots' order.
    pub recordings: Vec<(String, Recording)>,
    /// Verdict and figures.
    pub summary: Summary,
}

/// Runs a mission to its end, headless and without a file, and keeps what its robots sensed.
///
/// Memory grows by about 300 bytes a row; the time is that of the run.
///
/// ```
/// use missions::{Mission, sense};
/// use run_context::RunSeed;
///
/// let short = "mission.duration_max_s=20".to_owned();
/// let mission = Mission::load("artemic-e1", &[short])?;
/// let sensed = sense(mission, RunSeed(7))?;
/// let (name, recording) = &sensed.recordings[0];
/// assert_eq!((name.as_str(), recording.scans[0].ranges_m.len()), ("artemic", 5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`RunError`] when the mission cannot be started.
pub fn sense(mission: Mission, seed: RunSeed) -> Result<SensedRun, RunError> {
    let mut run = Run::new(mission, seed)?;
    let mut log = SensorLog::new(&run);
    while run.finished().is_none() {
        run.step();
        log.take(&run);
    }
    Ok(SensedRun { recordings: log.into_recordings(), summary: run.summary() })
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

impl SensorLog {
    /// An empty log of every robot of a run.
    pub fn new(run: &Run) -> Self {
        let empty = |plan: &crate::mission::plan::RobotPlan| {
            let recording = Recording {
                rig: rig(plan),
                scans: Vec::new(),
                odometry: Vec::new(),
                reference: Vec::new(),
                truth: Vec::new(),
                extra_columns_m: Vec::new(),
                epoch_ns: 0,
            };
            (plan.name.clone(), recording)
        };
        Self { robots: run.mission().parts().robots.iter().map(empty).collect() }
    }

    /// Takes what the last step brought; call it after every [`Run::step`].
    pub fn take(&mut self, run: &Run) {
        for ((_, recording), sensed) in self.robots.iter_mut().zip(run.sensed()) {
            recording.odometry.extend(sensed.reports.iter().map(PoseReport::odometry));
            for row in sensed.rows {
                recording.scans.push(row.to_scan());
                recording.truth.extend(row.report.truth());
            }
        }
    }

    /// Each robot's name and recording, in the robots' order.
    pub fn into_recordings(self) -> Vec<(String, Recording)> {
        self.robots
    }
}
