//! What requirements of success can be about: the robots, devices and events of a mission.

use decision::Mnemonic;
use run_context::Stamp;

use crate::mission::{
    check::common::{Checked, named, range, seconds},
    plan::{Action, DecisionPlan, DevicePlan, EventPlan, GoalPose, RobotPlan},
};

/// The checked tables that `[success]` speaks of.
#[derive(Clone, Copy)]
pub(crate) struct Cast<'a> {
    /// The mission's greatest duration, s.
    pub(crate) duration_max_s: f64,
    pub(crate) robots: &'a [RobotPlan],
    pub(crate) devices: &'a [DevicePlan],
    pub(crate) events: &'a [EventPlan],
    pub(crate) decision: Option<&'a DecisionPlan>,
}

impl Cast<'_> {
    /// The deadline that is written at `key`, s; 0 is the end of the mission.
    pub(super) fn deadline(&self, key: String, by_s: f64) -> Checked<Stamp> {
        let by_s = range(key, by_s, 0.0..=86_400.0, "from 0 to 86400 s")?;
        let by_s = if by_s > 0.0 { by_s } else { self.duration_max_s };
        Ok(Stamp::ZERO + seconds(by_s))
    }

    /// A sentence when a deadline comes after the end.
    pub(super) fn late(&self, key: &str, by: Stamp) -> Option<String> {
        let (by_s, end_s) = (by.since(Stamp::ZERO).as_secs_f64(), self.duration_max_s);
        (by_s > end_s).then(|| {
            format!(
                "{key}.by_s = {by_s}: the mission ends before, after {end_s} s (mission.duration_max_s)"
            )
        })
    }

    /// The device of that name.
    pub(super) fn device(&self, key: &str, name: &str) -> Checked<usize> {
        let names: Vec<&str> = self.devices.iter().map(|d| d.name.as_str()).collect();
        named(key, name, &names)
    }

    /// Whether somebody who says nothing of it beforehand may send a robot anywhere: a program with MOVE, or a person
    /// who drives it by hand.
    pub(crate) fn may_go_anywhere(&self, robot: usize) -> bool {
        let moves = |d: &DecisionPlan| d.robot == Some(robot) && d.has_function(Mnemonic::Move);
        self.decision.is_some_and(moves) || self.robots[robot].teleoperator.is_some()
    }

    /// The goals that the mission's events give a robot.
    pub(super) fn goals(&self, robot: usize) -> impl Iterator<Item = GoalPose> {
        self.events.iter().filter_map(move |event| match &event.action {
            Action::Goal { robots, pose } if robots.contains(&robot) => Some(*pose),
            _ => None,
        })
    }

    /// Why nobody here knows what `what` asks of all these robots: some are elsewhere.
    pub(super) fn unseen(&self, what: &str, robots: &[usize]) -> Vec<String> {
        let names = |of: &mut dyn Iterator<Item = &RobotPlan>| {
            of.map(|robot| format!("`{}`", robot.name)).collect::<Vec<_>>().join(", ")
        };
        let mut elsewhere =
            robots.iter().map(|&robot| &self.robots[robot]).filter(|robot| robot.is_elsewhere());
        let names = names(&mut elsewhere);
        if names.is_empty() {
            return Vec::new();
        }
        vec![format!(
            "{what}: {names} is elsewhere, and nobody here knows what it touches or how near it comes to things, so it \
             cannot be met"
        )]
    }

    /// The numbers of all robots.
    pub(super) fn all_robots(&self) -> Vec<usize> {
        (0..self.robots.len()).collect()
    }
}
