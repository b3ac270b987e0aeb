//! `[[success.arrived]]`: a robot reports arrival and truly stands there.

use std::sync::Arc;

use geometry::wrap_to_pi;
use run_context::Stamp;
use serde::{Deserialize, Serialize};

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, State, check},
};
use crate::{
    mission::{
        check::common::{Checked, goal, range, robots_named},
        plan::GoalPose,
    },
    verdict::Check,
};

pub(super) const ABOUT: About = About {
    key: "arrived",
    text: "a robot, or a part of the robots of one name, reports that it has arrived and truly stands there",
    template: r#"[[success.arrived]]      # reports arrival and truly stands there
robot = "robot"          # e.g. one robot or all of a table
pose = [3.0, 0.0, 0.0]   # e.g. or pose_from_start
within_m = 0.3
within_deg = 15.0
by_s = 0.0               # deadline; 0: the end of the mission
min_ratio = 1.0          # part of the robots that must arrive
[[success.arrived]]
robot = "robot"          # e.g.
pose_from_start = [3.0, 0.0, 0.0] # e.g.
"#,
};

/// Of a group that did not arrive, so many robots are named with their reasons.
const N_REASONS_MAX: usize = 3;

/// `[[success.arrived]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArrivedFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// x, y (m), yaw (degrees).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// The same relative to where each robot started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_from_start: Option<[f64; 3]>,
    /// Allowed distance, m.
    pub within_m: f64,
    /// Allowed heading error, degrees.
    pub within_deg: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
    /// Part of the robots of that name that must arrive.
    pub min_ratio: f64,
}

impl Default for ArrivedFile {
    fn default() -> Self {
        Self {
            robot: String::new(),
            pose: None,
            pose_from_start: None,
            within_m: 0.3,
            within_deg: 15.0,
            by_s: 0.0,
            min_ratio: 1.0,
        }
    }
}

/// The requirement as it is relied on.
#[derive(Debug)]
struct Arrived {
    key: String,
    robots: Vec<usize>,
    group: String,
    pose: GoalPose,
    within_m: f64,
    within_rad: f64,
    by: Stamp,
    min_ratio: f64,
}

pub(super) fn requirements(
    file: &[ArrivedFile],
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let one = |(i, a): (usize, &ArrivedFile)| -> Checked<Arc<dyn Requirement>> {
        let key = format!("success.arrived[{i}]");
        let at = |name: &str| format!("{key}.{name}");
        let by = cast.deadline(at("by_s"), a.by_s)?;
        let deg = range(at("within_deg"), a.within_deg, 0.1..=180.0, "from 0.1 to 180 degrees")?;
        Ok(Arc::new(Arrived {
            robots: robots_named(&key, &a.robot, cast.robots)?,
            group: a.robot.clone(),
            pose: goal(&key, a.pose, a.pose_from_start)?,
            within_m: range(at("within_m"), a.within_m, 0.001..=100.0, "from 0.001 to 100 m")?,
            within_rad: deg.to_radians(),
            by,
            min_ratio: range(at("min_ratio"), a.min_ratio, 0.0..=1.0, "from 0 to 1")?,
            key,
        }))
    };
    file.iter().enumerate().map(one).collect()
}

impl Arrived {
    /// Whether a robot says that it has arrived and truly stands where it should, having driven its path if it
    /// was given one.
    fn stands_there(&self, robot: usize, facts: &dyn Facts) -> bool {
        facts.has_arrived(robot) && facts.has_driven_all(robot) && {
            let (distance_m, turn_rad) = self.error(robot, facts);
            distance_m <= self.within_m && turn_rad <= self.within_rad
        }
    }

    /// True distance (m) and turn (rad, ≥ 0) of a robot from where it should be.
    fn error(&self, robot: usize, facts: &dyn Facts) -> (f64, f64) {
        let goal = self.pose.resolve(facts.start(robot));
        let at = facts.pose(robot);
        let distance_m = (goal.position() - at.position()).norm();
        (distance_m, wrap_to_pi(goal.yaw_rad - at.yaw_rad).abs())
    }

    /// Of many robots, how many are there.
    fn group_text(&self, state: State, facts: &dyn Facts) -> String {
        let is_absent = |&robot: &usize| !self.stands_there(robot, facts);
        let absent: Vec<usize> = self.robots.iter().copied().filter(is_absent).collect();
        let (n_all, allowed_deg) = (self.robots.len(), self.within_rad.to_degrees());
        let needed = (self.min_ratio * n_all as f64).ceil();
        let mut text = format!(
            "{} of {n_all} robots within {:.2} m, {allowed_deg:.0}° (at least {needed:.0})",
            n_all - absent.len(),
            self.within_m
        );
        if state == State::Missed {
            let reasons = absent.iter().take(N_REASONS_MAX).map(|&robot| {
                let reason = facts.failure(robot);
                let reason = reason.unwrap_or_else(|| facts.phase_name(robot).to_owned());
                format!("; {}: {reason}", facts.name(robot))
            });
            text.extend(reasons);
            if absent.len() > N_REASONS_MAX {
                text.push_str("; …");
            }
        }
        text
    }

    /// Of one robot, what it did.
    fn lone_text(&self, robot: usize, progress: Progress, facts: &dyn Facts) -> String {
        let (distance_m, turn_rad) = progress.reached.unwrap_or_else(|| self.error(robot, facts));
        let said = match (progress.state, facts.failure(robot)) {
            (State::Done(t), _) => format!("at {t}"),
            (_, Some(reason)) => format!("gave up ({reason})"),
            _ if facts.has_arrived(robot) && !facts.has_driven_all(robot) => {
                let (passed_m, way_m) = facts.driven_m(robot);
                format!("but only {passed_m:.1} m of {way_m:.1} m of its path were driven")
            }
            _ => format!("not arrived by {}, {}", self.by, facts.phase_name(robot)),
        };
        format!(
            "{}: {distance_m:.2} m, {:.0}° from the goal, {said} (allowed {:.2} m, {:.0}°)",
            facts.name(robot),
            turn_rad.to_degrees(),
            self.within_m,
            self.within_rad.to_degrees()
        )
    }

    /// Whether an event sends a robot there, or somebody may.
    fn is_sent_there(&self, robot: usize, cast: &Cast<'_>) -> bool {
        let plan = &cast.robots[robot];
        let settings = plan.navigator.settings();
        let wanted = self.pose.resolve(plan.start);
        let is_near = |goal: GoalPose| {
            let goal = goal.resolve(plan.start);
            let turn_rad = wrap_to_pi(goal.yaw_rad - wanted.yaw_rad).abs();
            let way_m = (goal.position() - wanted.position()).norm();
            way_m <= self.within_m + settings.goal_tolerance_m
                && turn_rad <= self.within_rad + settings.heading_tolerance_rad
        };
        cast.may_go_anywhere(robot) || cast.goals(robot).any(is_near)
    }
}

impl Requirement for Arrived {
    fn happened(&self, progress: Progress, facts: &dyn Facts) -> Option<(bool, Stamp)> {
        if progress.is_done() {
            return Some((true, self.by));
        }
        let n = self.robots.iter().filter(|&&robot| self.stands_there(robot, facts)).count();
        Some((n as f64 >= self.min_ratio * self.robots.len() as f64, self.by))
    }

    fn note(&self, facts: &dyn Facts) -> Option<(f64, f64)> {
        match self.robots[..] {
            [robot] => Some(self.error(robot, facts)),
            _ => None,
        }
    }

    fn check(&self, progress: Progress, facts: &dyn Facts) -> Check {
        let text = match self.robots[..] {
            [robot] => self.lone_text(robot, progress, facts),
            _ => self.group_text(progress.state, facts),
        };
        check(ABOUT.key, progress.is_done(), text)
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        let mut found: Vec<String> = cast.late(&self.key, self.by).into_iter().collect();
        let sent = |robot: usize| cast.may_go_anywhere(robot) || cast.goals(robot).next().is_some();
        if !self.robots.iter().any(|&robot| sent(robot)) {
            found.push(format!(
                "[[success.arrived]] of `{}`: nothing sends it anywhere; add an event with do = \"goal\", or a decision \
                 program with MOVE",
                self.group
            ));
            return found;
        }
        let n = self.robots.iter().filter(|&&robot| self.is_sent_there(robot, cast)).count();
        if (n as f64) < self.min_ratio * self.robots.len() as f64 {
            found.push(format!(
                "{} of `{}`: no event with do = \"goal\" sends it there (within {} m and {:.0}°), so it cannot be met",
                self.key,
                self.group,
                self.within_m,
                self.within_rad.to_degrees()
            ));
        }
        found
    }

    fn arrival_within_m(&self, robot: usize) -> Option<f64> {
        self.robots.contains(&robot).then_some(self.within_m)
    }
}
