//! What the robots of a run sensed, as recordings that can be mapped afterwards and judged against the truth.
//!
//! A row is one reading of every sonar of a robot. It is complete with the report of the robot that brings the last
//! of them, and holds what the navigator was told: ranges, each with its own time, and dead reckoning with
//! all its errors. The true pose stands beside it, for judging only.

pub(crate) mod step;

use recordings::{Recording, Rig, StampedPose};
use run_context::RunSeed;

use crate::{
    mission::Mission,
    run::{Run, RunError, laser_rig, rig},
    summary::Summary,
};
pub use step::{PoseReport, RingRow, ScanRow, SensedStep};

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

impl SensorLog {
    /// An empty log of every robot of a run, and of every laser beside.
    pub fn new(run: &Run) -> Self {
        let mut robots = Vec::new();
        for plan in &run.mission().parts().robots {
            robots.push((plan.name.clone(), empty(rig(plan))));
            let lasers = plan.lasers.iter();
            robots.extend(lasers.map(|l| (sensor_name(&plan.name, &l.name), empty(laser_rig(l)))));
        }
        Self { robots }
    }

    /// Takes what the last step brought; call it after every [`Run::step`].
    pub fn take(&mut self, run: &Run) {
        let mut rest = self.robots.as_mut_slice();
        for (sensed, plan) in run.sensed().zip(&run.mission().parts().robots) {
            let (ours, others) = rest.split_at_mut(1 + plan.lasers.len());
            rest = others;
            let Some(((_, ring), lasers)) = ours.split_first_mut() else { continue };
            ring.odometry.extend(sensed.reports.iter().map(PoseReport::odometry));
            for row in sensed.rows {
                ring.scans.push(row.to_scan());
                ring.truth.extend(row.report.truth());
            }
            for (_, laser) in &mut *lasers {
                laser.odometry.extend(sensed.reports.iter().map(PoseReport::odometry));
            }
            for row in sensed.scans {
                let (_, laser) = &mut lasers[row.laser];
                laser.scans.push(row.to_scan());
                laser
                    .truth
                    .extend(row.world_from_base.map(|pose| StampedPose { stamp: row.stamp, pose }));
            }
        }
    }

    /// Each robot's name and recording, in the robots' order; behind a robot its lasers, named `robot/laser`.
    pub fn into_recordings(self) -> Vec<(String, Recording)> {
        self.robots
    }
}

/// What a laser of a robot is called in a recording.
pub(crate) fn sensor_name(robot: &str, laser: &str) -> String {
    format!("{robot}/{laser}")
}

fn empty(rig: Rig) -> Recording {
    Recording {
        rig,
        scans: Vec::new(),
        odometry: Vec::new(),
        reference: Vec::new(),
        truth: Vec::new(),
        extra_columns_m: Vec::new(),
        epoch_ns: 0,
    }
}
