//! `success.no_contact` and `success.clearance_min_m`: what no robot may touch or come near to.

use std::sync::Arc;

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, check},
};
use crate::{
    mission::check::common::{Checked, range},
    verdict::Check,
};

pub(super) const NO_CONTACT: About = About {
    key: "no_contact",
    text: "no robot touches anything; of a robot elsewhere that is not known, and then it does not hold",
    template: "no_contact = false       # no robot touches anything\n",
};

pub(super) const CLEARANCE: About = About {
    key: "clearance_min_m",
    text: "every robot keeps at least this distance from everything; of a robot elsewhere that is not known, and then it does not hold",
    template: "clearance_min_m = 0.05   # e.g. every robot keeps this distance from everything, 0 to 5 m\n",
};

#[derive(Debug)]
struct NoContact;

#[derive(Debug)]
struct Clearance {
    min_m: f64,
}

pub(super) fn no_contact(wanted: bool) -> Vec<Arc<dyn Requirement>> {
    if wanted { vec![Arc::new(NoContact)] } else { Vec::new() }
}

pub(super) fn clearance(min_m: Option<f64>) -> Checked<Vec<Arc<dyn Requirement>>> {
    let Some(min_m) = min_m else { return Ok(Vec::new()) };
    let min_m = range("success.clearance_min_m", min_m, 0.0..=5.0, "from 0 to 5 m")?;
    Ok(vec![Arc::new(Clearance { min_m })])
}

/// Why nobody knows of all robots: the first that is elsewhere.
fn unknown(facts: &dyn Facts) -> Option<String> {
    let elsewhere = (0..facts.n_robots()).find(|&robot| !facts.is_simulated(robot))?;
    Some(format!("not known of a robot elsewhere ({})", facts.name(elsewhere)))
}

/// Why it cannot fail, or not be met.
fn warnings(about: &About, cast: &Cast<'_>) -> Vec<String> {
    let key = format!("success.{}", about.key);
    if cast.robots.is_empty() {
        return vec![format!("{key}: the mission has no robot, so it cannot fail")];
    }
    cast.unseen(&key, &cast.all_robots())
}

impl Requirement for NoContact {
    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        let n: u64 = (0..facts.n_robots()).map(|robot| facts.contacts(robot)).sum();
        match unknown(facts) {
            Some(text) if n == 0 => check("no contact", false, text),
            _ => check("no contact", n == 0, format!("{n} contacts (allowed 0)")),
        }
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        warnings(&NO_CONTACT, cast)
    }
}

impl Requirement for Clearance {
    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        if let Some(text) = unknown(facts) {
            return check("clearance", false, text);
        }
        let robots = || 0..facts.n_robots();
        let least_m = robots().map(|robot| facts.clearance_min_m(robot));
        let least_m = least_m.fold(f64::INFINITY, f64::min);
        let seen_m = robots().filter_map(|robot| facts.clearance_seen_m(robot));
        let text = match seen_m.reduce(f64::min) {
            Some(seen_m) => format!("nearest surface {seen_m:.2} m away"),
            None => "no surface within 5 m".to_owned(),
        };
        let min_m = self.min_m;
        check("clearance", least_m >= min_m, format!("{text} (at least {min_m:.2} m)"))
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        warnings(&CLEARANCE, cast)
    }
}
