//! `[[success.switched_on]]`: a latch opens or a lamp is lit.

use std::sync::Arc;

use run_context::Stamp;
use serde::{Deserialize, Serialize};

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, check},
};
use crate::{
    mission::{check::common::Checked, plan::DeviceWiring},
    verdict::Check,
};

pub(super) const ABOUT: About = About {
    key: "switched_on",
    text: "a latch opens, a lamp is lit, a button is pressed or a motion detector sees somebody",
    template: r#"[[success.switched_on]]  # a latch opens or a lamp is lit
device = "latch"         # e.g.
by_s = 0.0
"#,
};

/// `[[success.switched_on]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SwitchedOnFile {
    /// The device.
    pub device: String,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// The requirement as it is relied on.
#[derive(Debug)]
struct SwitchedOn {
    key: String,
    device: usize,
    by: Stamp,
}

pub(super) fn requirements(
    file: &[SwitchedOnFile],
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let one = |(i, s): (usize, &SwitchedOnFile)| -> Checked<Arc<dyn Requirement>> {
        let key = format!("success.switched_on[{i}]");
        let by = cast.deadline(format!("{key}.by_s"), s.by_s)?;
        let device = cast.device(&format!("{key}.device"), &s.device)?;
        Ok(Arc::new(SwitchedOn { key, device, by }))
    };
    file.iter().enumerate().map(one).collect()
}

impl Requirement for SwitchedOn {
    fn happened(&self, _progress: Progress, facts: &dyn Facts) -> Option<(bool, Stamp)> {
        Some((facts.first_on(self.device).is_some_and(|t| t <= self.by), self.by))
    }

    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        let (label, by) = (facts.device_label(self.device), self.by);
        match facts.first_on(self.device) {
            Some(t) => check("switched on", t <= by, format!("{label} at {t} (by {by})")),
            None => check("switched on", false, format!("{label} never (by {by})")),
        }
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        let mut found: Vec<String> = cast.late(&self.key, self.by).into_iter().collect();
        let device = &cast.devices[self.device];
        let driven =
            matches!(device.wiring, DeviceWiring::Latch { .. } | DeviceWiring::Lamp { .. });
        if cast.decision.is_none() && driven {
            let name = &device.name;
            found.push(format!(
                "[[success.switched_on]] of `{name}`: the mission has no [decision], whose program would switch it on, \
                 so it cannot be met"
            ));
        }
        found
    }
}
