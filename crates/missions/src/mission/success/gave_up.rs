//! `[[success.gave_up]]`: a robot reports that it gave up, and truly stands.

use std::sync::Arc;

use messages::FailureReason;
use run_context::Stamp;
use serde::{Deserialize, Serialize};

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, State, check},
};
use crate::{
    mission::{
        check::common::{Checked, chosen, range, robots_named},
        plan::Action,
    },
    verdict::Check,
};

pub(super) const ABOUT: About = About {
    key: "gave_up",
    text: "a robot reports that it gave up, for a reason if one is named, and truly stands; after so much way since a line was cut",
    template: r#"[[success.gave_up]]      # e.g. reports that it gave up, and truly stands
robot = "robot"          # e.g. one robot or all of a table
reason = "link_lost"     # e.g. {success.gave_up.reason}; empty: any
way_max_m = 0.8          # e.g. driven at most after one of its lines was cut, until its next order; 0: any way
by_s = 0.0               # e.g.
"#,
};

/// `[[success.gave_up]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GaveUpFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// Why it must have given up, such as `link_lost` or `server_silent`; empty: whatever the reason.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// How far it may drive after one of its lines was last cut, until its next order, m; 0: any way.
    pub way_max_m: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// The requirement as it is relied on.
#[derive(Debug)]
struct GaveUp {
    key: String,
    robots: Vec<usize>,
    reason: Option<FailureReason>,
    way_max_m: Option<f64>,
    by: Stamp,
}

pub(super) fn requirements(
    file: &[GaveUpFile],
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let one = |(i, g): (usize, &GaveUpFile)| -> Checked<Arc<dyn Requirement>> {
        let key = format!("success.gave_up[{i}]");
        let at = |name: &str| format!("{key}.{name}");
        let by = cast.deadline(at("by_s"), g.by_s)?;
        let way_max_m = range(at("way_max_m"), g.way_max_m, 0.0..=1000.0, "from 0 to 1000 m")?;
        let reason = match g.reason.as_str() {
            "" => None,
            word => Some(chosen(&at("reason"), word)?),
        };
        let robots = robots_named(&key, &g.robot, cast.robots)?;
        let way_max_m = (way_max_m > 0.0).then_some(way_max_m);
        Ok(Arc::new(GaveUp { key, robots, reason, way_max_m, by }))
    };
    file.iter().enumerate().map(one).collect()
}

impl GaveUp {
    fn has_happened(&self, robot: usize, facts: &dyn Facts) -> bool {
        facts.has_given_up(robot, self.reason)
            && facts.stands(robot) == Some(true)
            && self.way_max_m.is_none_or(|max_m| way_since_cut_m(robot, facts) <= max_m)
    }

    /// Of one robot what it did, of many how many did.
    fn text(&self, state: State, facts: &dyn Facts) -> String {
        let &[robot] = &self.robots[..] else {
            let n = self.robots.iter().filter(|&&r| facts.has_given_up(r, None)).count();
            return format!("{n} of {} robots gave up (wanted: all)", self.robots.len());
        };
        let said = match (state, facts.failure(robot)) {
            (State::Done(t), Some(reason)) => format!("at {t} ({reason})"),
            (State::Done(t), None) => format!("at {t}"),
            (_, Some(reason)) => {
                format!("for another reason or too late ({reason}; by {})", self.by)
            }
            _ => format!("not by {}", self.by),
        };
        let rest = match facts.stands(robot) {
            Some(true) => "stands",
            Some(false) => "still rolls",
            None => "may roll or stand",
        };
        let way_m = way_since_cut_m(robot, facts);
        let way = match self.way_max_m {
            Some(max_m) if way_m.is_finite() => {
                format!(", {way_m:.2} m after the cut (allowed {max_m:.2} m)")
            }
            Some(_) => ", no line was cut".to_owned(),
            None => String::new(),
        };
        format!("{said}, {rest}{way}")
    }
}

/// Way that a robot has driven since one of its lines was cut, m; infinite if none was.
fn way_since_cut_m(robot: usize, facts: &dyn Facts) -> f64 {
    facts.way_since_cut_m(robot).unwrap_or(f64::INFINITY)
}

impl Requirement for GaveUp {
    fn happened(&self, progress: Progress, facts: &dyn Facts) -> Option<(bool, Stamp)> {
        let all = || self.robots.iter().all(|&robot| self.has_happened(robot, facts));
        Some((progress.is_done() || all(), self.by))
    }

    fn check(&self, progress: Progress, facts: &dyn Facts) -> Check {
        check("gave up", progress.is_done(), self.text(progress.state, facts))
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        let mut found: Vec<String> = cast.late(&self.key, self.by).into_iter().collect();
        let cuts = |action: &Action| match action {
            Action::Link { robots: of, cut: true, .. } => {
                self.robots.iter().all(|robot| of.contains(robot))
            }
            _ => false,
        };
        if self.way_max_m.is_some() && !cast.events.iter().any(|event| cuts(&event.action)) {
            found.push(
                "[[success.gave_up]]: way_max_m counts from a cut, and no event cuts a line of that robot, so it cannot \
                 be met"
                    .to_owned(),
            );
        }
        found
    }
}
