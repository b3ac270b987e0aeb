//! Checks of `[robots.sonar]`'s ring and of `[robots.mind.follow.fuzzy]`'s rules.

use std::time::Duration;

use geometry::{Polygon, Se2, Transform2, Vec2};
use messages::N_RING_MAX;
use navigator::Avoidance;
use path_following::{
    fuzzy::{FuzzyConfig, Table, TableKind, rules_of_letters},
    fuzzy_listing::ListingConfig,
};
use robot_models::{RingTiming, RobotModel, SonarMount};
use settings::Choice as _;

use super::super::{
    error::Wrong,
    file::{FuzzyFile, GuardFile, SonarFile},
    words::RingKind,
};
use super::common::{Checked, chosen, range};

/// How far outside of its robot's outline a sonar may sit, metres.
const OUTSIDE_MAX_M: f64 = 0.1;
/// A robot that avoids needs a sonar that looks at most so far aside, degrees; the bubble ends there.
const AHEAD_MAX_DEG: f64 = 60.0;

/// Gives the model the ring that the mission asks for.
pub(super) fn fit(key: &str, file: &SonarFile, model: &mut RobotModel) -> Checked<()> {
    let at = |name: &str| format!("{key}.sonar.{name}");
    let kind: RingKind = chosen(&at("ring"), &file.ring)?;
    if kind != RingKind::Own && !file.ring_at.is_empty() {
        let needed = "\"own\", because ring_at lists a ring of one's own";
        return Err(Wrong::new(at("ring"), &file.ring, needed));
    }
    match kind {
        RingKind::Model => {}
        RingKind::Five => adopt("artemic5", model),
        RingKind::Eight => adopt("artemic8", model),
        RingKind::Own => {
            model.sonars = own(&at("ring_at"), file, model)?;
            model.ring.chain_len = RingTiming::PIONEER.chain_len;
        }
    }
    if file.ring_period_ms != 0 {
        if !(10..=1000).contains(&file.ring_period_ms) {
            let allowed = "from 10 to 1000 ms, or 0 for the ring's own";
            return Err(Wrong::new(at("ring_period_ms"), file.ring_period_ms, allowed));
        }
        model.ring.ping_period = Duration::from_millis(u64::from(file.ring_period_ms));
    }
    if file.ring_chain > N_RING_MAX {
        let allowed = "from 1 to 16, or 0 for the ring's own";
        return Err(Wrong::new(at("ring_chain"), file.ring_chain, allowed));
    }
    if file.ring_chain != 0 {
        model.ring.chain_len = file.ring_chain;
    }
    Ok(())
}

/// Takes the ring of another robot of the catalogue.
fn adopt(name: &str, model: &mut RobotModel) {
    if let Ok(other) = RobotModel::by_name(name) {
        model.sonars = other.sonars;
        model.ring = other.ring;
    }
}

fn own(key: &str, file: &SonarFile, model: &RobotModel) -> Checked<Vec<SonarMount>> {
    let n = file.ring_at.len();
    if !(1..=N_RING_MAX).contains(&n) {
        let found = format!("{n} sonars");
        return Err(Wrong::prose(
            key,
            found,
            "from 1 to 16 sonars, each [x (m), y (m), bearing (degrees)]",
        ));
    }
    let mount = |(i, &[x_m, y_m, bearing_deg]): (usize, &[f64; 3])| {
        let key = format!("{key}[{i}]");
        let place = Vec2::new(x_m, y_m);
        if !(x_m.is_finite() && y_m.is_finite() && is_at_body(place, &model.footprint)) {
            let allowed = "a place on the robot, at most 0.1 m outside its outline";
            return Err(Wrong::prose(key, format!("({x_m}, {y_m}) m"), allowed));
        }
        let bearing_deg =
            range(key, bearing_deg, -180.0..=180.0, "a bearing from -180 to 180 degrees")?;
        let base_from_sensor = Transform2::new(Se2::new(x_m, y_m, bearing_deg.to_radians()));
        Ok(SonarMount { base_from_sensor })
    };
    file.ring_at.iter().enumerate().map(mount).collect()
}

fn is_at_body(place: Vec2, outline: &Polygon) -> bool {
    outline.contains(place) || outline.distance(place) <= OUTSIDE_MAX_M
}

/// A robot that shall avoid what is ahead must be able to hear it.
pub(super) fn hears_ahead(
    key: &str,
    file: &GuardFile,
    model: &RobotModel,
    n_lasers: usize,
) -> Checked<()> {
    let ahead = |mount: &SonarMount| {
        mount.base_from_sensor.se2().yaw_rad.abs().to_degrees() < AHEAD_MAX_DEG
    };
    let (off, contact) = (Avoidance::Off.key(), Avoidance::Contact.key());
    // A robot without sonars sees by its lasers.
    let sees = model.sonars.is_empty() && n_lasers > 0;
    if sees || file.method == off || file.method == contact || model.sonars.iter().any(ahead) {
        return Ok(());
    }
    let found = format!(
        "\"{}\" with {} sonars, none within 60° of straight ahead",
        file.method,
        model.sonars.len()
    );
    let allowed = format!(
        "\"{off}\", \"{contact}\", a ring with a sonar that looks ahead, or for a robot without sonars a laser"
    );
    Err(Wrong::prose(format!("{key}.mind.guard.method"), found, allowed))
}

/// Sets and rules of the fuzzy laws on a trail.
pub(super) fn fuzzy(key: &str, file: &FuzzyFile) -> Checked<(FuzzyConfig, ListingConfig)> {
    let at = |name: &str| format!("{key}.mind.follow.fuzzy.{name}");
    let kind: TableKind = chosen(&at("table"), &file.table)?;
    let given = !(file.left_rules.is_empty() && file.right_rules.is_empty());
    if kind != TableKind::Own && given {
        let needed = "\"own\", because left_rules or right_rules are given";
        return Err(Wrong::new(at("table"), &file.table, needed));
    }
    let rules = |name: &str, letters: &str| {
        let needed =
            "nine letters L, M or H: for e = N, Z, P each e' = N, Z, P, such as \"HHM HML MLL\"";
        rules_of_letters(letters).ok_or_else(|| Wrong::new(at(name), letters, needed))
    };
    let table = match kind {
        TableKind::Antisymmetric => Table::Antisymmetric,
        TableKind::LiteralMirror => Table::LiteralMirror,
        TableKind::Table51 => Table::Table51,
        TableKind::Own => Table::Own {
            left: rules("left_rules", &file.left_rules)?,
            right: rules("right_rules", &file.right_rules)?,
        },
    };
    let full = |name: &str, value: u32| {
        let within = (1..=100_000).contains(&value);
        within.then_some(value).ok_or_else(|| Wrong::new(at(name), value, "from 1 to 100000"))
    };
    let (error_full, change_full) =
        (full("error_full", file.error_full)?, full("change_full", file.change_full)?);
    let slow_ratio = range(at("slow_ratio"), file.slow_ratio, -1.0..=1.0, "from -1 to 1")?;
    let fast_ratio = range(at("fast_ratio"), file.fast_ratio, 1.0..=3.0, "from 1 to 3")?;
    let mean_mmps = f64::from(file.listing_mean_mmps);
    range(at("listing_mean_mmps"), mean_mmps, 20.0..=800.0, "from 20 to 800 mm/s")?;
    let mmps = |ratio: f64| (ratio * mean_mmps).round() as i32;
    Ok((
        FuzzyConfig {
            table,
            error_full: f64::from(error_full),
            change_full: f64::from(change_full),
            slow_ratio,
            fast_ratio,
            ..FuzzyConfig::default()
        },
        ListingConfig {
            table,
            error_full: error_full as i32,
            change_full: change_full as i32,
            slow_mmps: mmps(slow_ratio),
            mean_mmps: mmps(1.0),
            fast_mmps: mmps(fast_ratio),
            ..ListingConfig::default()
        },
    ))
}
