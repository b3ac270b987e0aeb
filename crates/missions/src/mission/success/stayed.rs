//! `[[success.stayed]]`: a robot never leaves its start.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, check},
};
use crate::{
    mission::check::common::{Checked, range, robots_named},
    verdict::Check,
};

pub(super) const ABOUT: About = About {
    key: "stayed",
    text: "a robot never leaves its start; of one elsewhere, by its own reports, and it must be heard at the end",
    template: r#"[[success.stayed]]       # never leaves its start
robot = "robot"          # e.g.
within_m = 0.05
"#,
};

/// `[[success.stayed]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct StayedFile {
    /// The robot.
    pub robot: String,
    /// Allowed distance from the start, m.
    pub within_m: f64,
}

impl Default for StayedFile {
    fn default() -> Self {
        Self { robot: String::new(), within_m: 0.05 }
    }
}

/// The requirement as it is relied on.
#[derive(Debug)]
struct Stayed {
    robots: Vec<usize>,
    within_m: f64,
}

pub(super) fn requirements(
    file: &[StayedFile],
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let one = |(i, s): (usize, &StayedFile)| -> Checked<Arc<dyn Requirement>> {
        let key = format!("success.stayed[{i}]");
        let at = format!("{key}.within_m");
        Ok(Arc::new(Stayed {
            robots: robots_named(&key, &s.robot, cast.robots)?,
            within_m: range(at, s.within_m, 0.001..=100.0, "from 0.001 to 100 m")?,
        }))
    };
    file.iter().enumerate().map(one).collect()
}

impl Requirement for Stayed {
    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        // A robot that is not heard is believed to be where it started.
        let is_unheard = |&&robot: &&usize| facts.stands(robot).is_none();
        if let Some(&robot) = self.robots.iter().find(is_unheard) {
            let name = facts.name(robot);
            return check(
                ABOUT.key,
                false,
                format!("not known: {name} is elsewhere and not heard"),
            );
        }
        let most_m = self.robots.iter().map(|&robot| facts.strayed_max_m(robot));
        let most_m = most_m.fold(0.0, f64::max);
        let within_m = self.within_m;
        let text = format!("{most_m:.2} m from the start at most (allowed {within_m:.2} m)");
        check(ABOUT.key, most_m <= within_m, text)
    }

    fn warnings(&self, _cast: &Cast<'_>) -> Vec<String> {
        Vec::new()
    }
}
