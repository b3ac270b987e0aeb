//! Whether what the mission asks for has happened.
//!
//! Requirements that something happens are decided when it does or when its deadline passes;
//! requirements that something never happens hold until the end. A run ends when its greatest duration
//! is over, when something that must happen has missed its deadline, or half a second after everything that must
//! happen has.

use std::sync::Arc;

use geometry::Se2;
use messages::FailureReason;
use run_context::Stamp;
use simulator::World;

use super::{metrics::RobotMetrics, vehicle::Vehicle};
use crate::{
    mission::{
        plan::RobotPlan,
        success::{self, Progress, Requirement, State},
    },
    node::devices::Devices,
    verdict::Verdict,
};

/// Steps between the last thing that must happen and the end: what goes wrong at once still counts.
const AFTERMATH_STEPS: u32 = 50;

/// What is judged.
pub(super) struct Facts<'a> {
    pub(super) now: Stamp,
    pub(super) is_over: bool,
    pub(super) n_moves: u64,
    pub(super) n_events: u64,
    pub(super) n_watchdog_resets: u64,
    pub(super) vehicles: &'a [Vehicle],
    pub(super) metrics: &'a [RobotMetrics],
    pub(super) devices: &'a Devices,
    pub(super) robots: &'a [RobotPlan],
    pub(super) world: &'a World,
}

/// Follows the requirements of a mission.
#[derive(Debug)]
pub(super) struct Judge {
    items: Vec<Item>,
    aftermath: u32,
}

#[derive(Debug)]
struct Item {
    requirement: Arc<dyn Requirement>,
    progress: Progress,
}

impl Judge {
    pub(super) fn new(requirements: &[Arc<dyn Requirement>]) -> Self {
        let item = |requirement: &Arc<dyn Requirement>| Item {
            requirement: Arc::clone(requirement),
            progress: Progress { state: State::Open, reached: None },
        };
        Self { items: requirements.iter().map(item).collect(), aftermath: 0 }
    }

    /// The verdict, once it is certain.
    pub(super) fn step(&mut self, facts: &Facts<'_>) -> Option<Verdict> {
        let mut n_events = 0;
        let (mut all_done, mut any_missed) = (true, false);
        for Item { requirement, progress } in &mut self.items {
            let Some((happened, by)) = requirement.happened(*progress, facts) else { continue };
            n_events += 1;
            if progress.state == State::Open && happened {
                let reached = requirement.note(facts);
                *progress = Progress { state: State::Done(facts.now), reached };
            } else if progress.state == State::Open && facts.now >= by {
                progress.state = State::Missed;
            }
            all_done &= progress.is_done();
            any_missed |= progress.state == State::Missed;
        }
        if n_events > 0 && all_done {
            self.aftermath += 1;
        }
        let ends = facts.is_over || any_missed || self.aftermath > AFTERMATH_STEPS;
        let check = |item: &Item| item.requirement.check(item.progress, facts);
        ends.then(|| Verdict::from_checks(self.items.iter().map(check).collect()))
    }
}

impl success::Facts for Facts<'_> {
    fn n_robots(&self) -> usize {
        self.robots.len()
    }

    fn n_moves(&self) -> u64 {
        self.n_moves
    }

    fn n_events(&self) -> u64 {
        self.n_events
    }

    fn n_watchdog_resets(&self) -> u64 {
        self.n_watchdog_resets
    }

    fn device_label(&self, device: usize) -> &str {
        self.devices.label(device)
    }

    fn first_on(&self, device: usize) -> Option<Stamp> {
        self.devices.first_on(device)
    }

    fn name(&self, robot: usize) -> &str {
        &self.robots[robot].name
    }

    fn start(&self, robot: usize) -> Se2 {
        self.robots[robot].start
    }

    fn pose(&self, robot: usize) -> Se2 {
        self.metrics[robot].pose()
    }

    fn is_simulated(&self, robot: usize) -> bool {
        self.metrics[robot].is_simulated()
    }

    fn stands(&self, robot: usize) -> Option<bool> {
        self.vehicles[robot].stands(self.world)
    }

    fn phase_name(&self, robot: usize) -> &'static str {
        self.vehicles[robot].phase_name()
    }

    fn failure(&self, robot: usize) -> Option<String> {
        self.vehicles[robot].failure()
    }

    fn has_arrived(&self, robot: usize) -> bool {
        self.vehicles[robot].has_arrived()
    }

    fn has_given_up(&self, robot: usize, reason: Option<FailureReason>) -> bool {
        self.vehicles[robot].has_given_up(reason)
    }

    fn contacts(&self, robot: usize) -> u64 {
        self.metrics[robot].contacts
    }

    fn clearance_min_m(&self, robot: usize) -> f64 {
        self.metrics[robot].clearance_min_m()
    }

    fn clearance_seen_m(&self, robot: usize) -> Option<f64> {
        self.metrics[robot].clearance_seen_m()
    }

    fn strayed_max_m(&self, robot: usize) -> f64 {
        self.metrics[robot].strayed_max_m
    }

    fn way_since_cut_m(&self, robot: usize) -> Option<f64> {
        self.metrics[robot].way_since_cut_m()
    }

    fn has_path(&self, robot: usize) -> bool {
        let plan = &self.robots[robot];
        plan.path.is_some() || plan.teleoperator.is_some()
    }

    fn cross_track_rms_m(&self, robot: usize) -> Option<f64> {
        self.metrics[robot].cross_track_rms_m()
    }

    fn has_driven_all(&self, robot: usize) -> bool {
        self.metrics[robot].sides().is_none_or(super::sides::Sides::is_driven)
    }

    fn driven_m(&self, robot: usize) -> (f64, f64) {
        let sides = self.metrics[robot].sides();
        sides.map_or((0.0, 0.0), |sides| (sides.passed_m(), sides.way_m()))
    }
}
