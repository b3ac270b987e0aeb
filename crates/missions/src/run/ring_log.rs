//! What one robot reported and measured in the last step: poses of its dead reckoning, and whole rows of its ring.
//!
//! It reads along behind the driver, so a row holds what the navigator was told, with the times that the
//! navigator was told. The true pose beside it is for whoever judges; nothing here goes back into the run.

use std::{collections::VecDeque, time::Duration};

use geometry::{Se2, Twist};
use messages::{LinkState, N_RING_MAX, Observations, OdometryReading, Ring, Sensed};
use recordings::{Rig, RingRig};
use run_context::Stamp;

use crate::{
    mission::plan::{LinkPlan, RobotPlan},
    sensing::step::{PoseReport, RingRow, SensedStep},
};

/// A report over a link is about a moment that is past by its latency and the time of its bytes; so much more is kept.
const HISTORY_MARGIN: Duration = Duration::from_secs(1);

/// The way of a scan: a turn of the slowest laser, its bytes at 9600 baud, and the margin.
const SCAN_HISTORY: Duration = Duration::from_secs(2);

/// Reads along with one robot.
#[derive(Debug)]
pub(super) struct RingLog {
    n_sonars: usize,
    /// Where it truly was, as far back as a report can be about; the newest last.
    history: VecDeque<(Stamp, Se2)>,
    history_max: Duration,
    pending: RingRow,
    /// Bit i: sonar i has a reading in the pending row.
    read: u16,
    /// Where it was by its last report.
    last_report: PoseReport,
    reports: Vec<PoseReport>,
    rows: Vec<RingRow>,
}

/// What a robot's ring is, as its readings are recorded.
pub(crate) fn rig(plan: &RobotPlan) -> Rig {
    let mounts = plan.model.sonars.iter().take(N_RING_MAX);
    Rig::Ring(RingRig {
        base_from_sensors: mounts.map(|mount| mount.base_from_sensor.se2()).collect(),
        half_angle_rad: plan.sonar.half_angle_rad,
        range_min_m: plan.sonar.range_min_m,
        range_max_m: plan.sonar.range_max_m,
    })
}

impl RingLog {
    pub(super) fn new(plan: &RobotPlan) -> Self {
        let n_sonars = plan.model.sonars.len().min(N_RING_MAX);
        let history_max = match &plan.link {
            LinkPlan::Memory(link) => link.latency + HISTORY_MARGIN,
            // Handed over at once, or never known.
            LinkPlan::Direct | LinkPlan::Tcp { .. } | LinkPlan::Serial { .. } => Duration::ZERO,
        };
        let history_max =
            if plan.lasers.is_empty() { history_max } else { history_max.max(SCAN_HISTORY) };
        Self {
            n_sonars,
            history: VecDeque::new(),
            history_max,
            pending: RingRow::empty(n_sonars),
            read: 0,
            last_report: RingRow::empty(0).report,
            reports: Vec::with_capacity(4),
            rows: Vec::with_capacity(4),
        }
    }

    /// Takes what reached the navigator in this step. `truth` is where the robot is now.
    pub(super) fn step(&mut self, now: Stamp, truth: Option<Se2>, observations: &Observations) {
        self.reports.clear();
        self.rows.clear();
        if let Some(truth) = truth {
            self.history.push_back((now, truth));
            while let Some(&(stamp, _)) = self.history.front()
                && now.since(stamp) > self.history_max
            {
                self.history.pop_front();
            }
        }
        for observation in observations {
            match &observation.value {
                Sensed::Odometry(odometry) => self.take_pose(observation.about, odometry),
                Sensed::Ring(ring) => self.take_ring(observation.about, ring),
                // A new session begins: what was heard before it is of another round.
                Sensed::Link(LinkState::Up) => self.read = 0,
                _ => {}
            }
        }
    }

    /// What the last step brought.
    pub(super) fn sensed(&self) -> SensedStep<'_> {
        SensedStep { reports: &self.reports, rows: &self.rows, scans: &[] }
    }

    fn take_pose(&mut self, about: Stamp, odometry: &OdometryReading) {
        let report = PoseReport {
            stamp: about,
            odom_from_base: odometry.odom_from_base.se2(),
            world_from_base: self.truth_at(about),
        };
        self.last_report = report;
        self.reports.push(report);
    }

    fn take_ring(&mut self, about: Stamp, ring: &Ring) {
        if self.n_sonars == 0 {
            return;
        }
        for i in 0..self.n_sonars.min(ring.n_sensors) {
            if !ring.is_fresh(i) {
                continue;
            }
            // A sonar that comes round again before the row is whole replaces its reading: a packet was lost.
            let age = Duration::from_millis(ring.ages_ms[i].into());
            self.pending.set(i, ring.ranges_m[i], before(about, age));
            self.read |= 1 << i;
        }
        let whole = u16::MAX >> (N_RING_MAX - self.n_sonars);
        if self.read == whole {
            self.pending.report = self.last_report;
            self.rows.push(self.pending);
            self.read = 0;
        }
    }

    /// Where it truly was, between two steps on the arc that leads from one to the other.
    pub(super) fn truth_at(&self, at: Stamp) -> Option<Se2> {
        let after = self.history.iter().position(|&(stamp, _)| stamp >= at);
        let Some(after) = after else { return self.history.back().map(|&(_, pose)| pose) };
        let (end, to) = self.history[after];
        let (begin, from) = self.history[after.saturating_sub(1)];
        let span_s = end.since(begin).as_secs_f64();
        if end == at || span_s == 0.0 {
            return Some(to);
        }
        let part = at.since(begin).as_secs_f64() / span_s;
        let Twist { dx_m, dy_m, dyaw_rad } = from.inverse().compose(to).log();
        let twist = Twist { dx_m: part * dx_m, dy_m: part * dy_m, dyaw_rad: part * dyaw_rad };
        Some(from.compose(Se2::exp(twist)))
    }
}

/// The time that was `age` before `stamp`, or the beginning.
fn before(stamp: Stamp, age: Duration) -> Stamp {
    let nanos = u64::try_from(age.as_nanos()).unwrap_or(u64::MAX);
    Stamp::from_nanos(stamp.as_nanos().saturating_sub(nanos))
}

#[cfg(test)]
#[path = "ring_log_tests.rs"]
mod tests;
