//! `[[success.on_path]]`: a robot keeps to the trail or the path that it follows.

use std::sync::Arc;

use navigator::Method;
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
    key: "on_path",
    text: "a robot keeps so near to the trail or path that it follows, root mean square; of one elsewhere, by its own reports",
    template: r#"[[success.on_path]]      # keeps to the trail or path that it follows
robot = "robot"          # e.g. one robot or all of a table
rms_max_m = 0.1          # root mean square distance, 0.001 to 10 m
"#,
};

/// `[[success.on_path]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OnPathFile {
    /// The robot; of many robots of one name, every one.
    pub robot: String,
    /// Root mean square distance from what it follows at most, m.
    pub rms_max_m: f64,
}

impl Default for OnPathFile {
    fn default() -> Self {
        Self { robot: String::new(), rms_max_m: 0.1 }
    }
}

/// The requirement as it is relied on.
#[derive(Debug)]
struct OnPath {
    key: String,
    robots: Vec<usize>,
    rms_max_m: f64,
}

pub(super) fn requirements(
    file: &[OnPathFile],
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let one = |(i, o): (usize, &OnPathFile)| -> Checked<Arc<dyn Requirement>> {
        let key = format!("success.on_path[{i}]");
        let at = format!("{key}.rms_max_m");
        let rms_max_m = range(at, o.rms_max_m, 0.001..=10.0, "from 0.001 to 10 m")?;
        let robots = robots_named(&key, &o.robot, cast.robots)?;
        Ok(Arc::new(OnPath { key, robots, rms_max_m }))
    };
    file.iter().enumerate().map(one).collect()
}

impl Requirement for OnPath {
    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        let what = |robot: usize| if facts.has_path(robot) { "path" } else { "trail" };
        let who = |robot: usize| match self.robots.len() {
            1 => String::new(),
            _ => format!("{}: ", facts.name(robot)),
        };
        let mut worst: Option<(usize, f64)> = None;
        for &robot in &self.robots {
            let Some(rms_m) = facts.cross_track_rms_m(robot) else {
                let text = format!("{}the {} was never followed", who(robot), what(robot));
                return check("cross track", false, text);
            };
            if worst.is_none_or(|(_, most_m)| rms_m > most_m) {
                worst = Some((robot, rms_m));
            }
        }
        let Some((robot, rms_m)) = worst else {
            return check("cross track", false, "there is no such robot");
        };
        let allowed_m = self.rms_max_m;
        let (who, what) = (who(robot), what(robot));
        let text = format!("{who}{rms_m:.3} m off the {what}, rms (allowed {allowed_m:.3} m)");
        check("cross track", rms_m <= allowed_m, text)
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        let follows = |robot: usize| {
            let plan = &cast.robots[robot];
            plan.teleoperator.is_some() || plan.navigator.settings().method != Method::Direct
        };
        let idle = self.robots.iter().find(|&&robot| !follows(robot));
        let told = idle.map(|&robot| {
            format!(
                "{}: `{}` has mind.how.method = \"straight\" and follows nothing, so it cannot be met",
                self.key, cast.robots[robot].name
            )
        });
        told.into_iter().collect()
    }
}
