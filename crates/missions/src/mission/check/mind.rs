//! Checks of `[robots.mind]`.

use geometry::Vec2;
use navigator::{Avoidance, LaserMount, Method, NavigatorConfig, NavigatorSettings, PoseMethod};
use obstacle_avoidance::Variant;
use path_following::{Path, PathController, TrailController};
use robot_models::RobotModel;
use settings::Choice as _;

use super::super::{
    error::Wrong,
    file::{FollowFile, HealthFile, HowFile, MindFile, RobotFile},
    plan::TagReadersPlan,
    words::LineKind,
};
use super::{
    common::{Checked, chosen, point, range},
    ring, tags,
};

/// A robot without a watchdog that goes deaf is believed to go on for so long, seconds: until somebody stops it.
const UNWATCHED_S: f64 = 2.0;

/// The navigator looks no farther ahead than a robot gets that goes on for so long, seconds.
const WATCHDOG_MAX_S: f64 = 10.0;

/// Longest control period along a path, ms.
const PATH_PERIOD_MAX_MS: u32 = 500;

/// The methods of a robot and their settings.
pub(super) fn mind(
    key: &str,
    robot: &RobotFile,
    model: &RobotModel,
    readers: Option<&TagReadersPlan>,
    lasers: Vec<LaserMount>,
) -> Checked<NavigatorConfig> {
    let file = &robot.mind;
    let (where_to, how, follow, guard) = (&file.where_to, &file.how, &file.follow, &file.guard);
    let at = |name: &str| format!("{key}.mind.{name}");
    let method = chosen(&at("how.method"), &how.method)?;
    let within_deg = range(
        at("where_to.within_deg"),
        where_to.within_deg,
        0.5..=50.0,
        "from 0.5 to 50 degrees",
    )?;
    let (trail_fuzzy, trail_listing) = ring::fuzzy(key, &follow.fuzzy)?;
    let settings = NavigatorSettings {
        trail_fuzzy,
        trail_listing,
        method,
        pose_method: pose_method(&at("where_am_i.method"), &file.where_am_i.method, &lasers)?,
        tags: tags::following(key, robot, readers)?,
        path_controller: chosen::<PathController>(&at("follow.path_law"), &follow.path_law)?,
        trail_controller: chosen::<TrailController>(&at("follow.trail_law"), &follow.trail_law)?,
        avoidance: chosen::<Avoidance>(&at("guard.method"), &guard.method)?,
        variant: chosen::<Variant>(&at("guard.aims_again"), &guard.aims_again)?,
        speed_mps: speed_mps(&at("follow.speed_mps"), follow.speed_mps, model)?,
        control_period_s: f64::from(control_period_ms(key, file, method)?) * 1e-3,
        acceleration_mps2: acceleration_mps2(key, follow)?,
        turn_first: follow.turn_first,
        fit_to_speed: follow.fit_to_speed,
        wait_s: range(at("guard.wait_s"), guard.wait_s, 0.0..=60.0, "from 0 to 60 s")?,
        preview_m: range(at("how.preview_m"), how.preview_m, 0.0..=20.0, "from 0 to 20 m")?,
        approach_m: range(at("how.approach_m"), how.approach_m, 0.1..=5.0, "from 0.1 to 5 m")?,
        attempts_max: attempts_max(&at("guard.attempts_max"), guard.attempts_max)?,
        goal_tolerance_m: range(
            at("where_to.within_m"),
            where_to.within_m,
            0.01..=1.0,
            "from 0.01 to 1 m",
        )?,
        heading_tolerance_rad: within_deg.to_radians(),
        range_max_m: robot.sonar.range_max_m,
        lasers,
        watchdog_s: watchdog_s(robot, model),
        ..with_limits(key, &file.health, NavigatorSettings::for_robot(model))?
    };
    // What the ranges above let through and the navigator still refuses is said in its own words.
    NavigatorConfig::try_from(settings).map_err(|e| {
        Wrong::prose(format!("{key}.mind"), e.to_string(), "settings that fit together")
    })
}

/// How long the robot goes on with its last command when its line is cut; a line without bytes loses nothing.
fn watchdog_s(robot: &RobotFile, model: &RobotModel) -> f64 {
    if robot.line.kind == LineKind::Direct.key() {
        return 0.0;
    }
    let watchdog = model.line.as_ref().and_then(|line| line.watchdog);
    watchdog.map_or(UNWATCHED_S, |watchdog| watchdog.as_secs_f64().min(WATCHDOG_MAX_S))
}

/// What says where the robot is; particles are weighed by lasers.
fn pose_method(key: &str, word: &str, lasers: &[LaserMount]) -> Checked<PoseMethod> {
    let method: PoseMethod = chosen(key, word)?;
    if method == PoseMethod::Particles && lasers.is_empty() {
        let allowed = "another method, or a robot with [[robots.lasers]]: particles are weighed by what a laser sees";
        return Err(Wrong::new(key, word, allowed));
    }
    Ok(method)
}

fn control_period_ms(key: &str, file: &MindFile, method: Method) -> Checked<u32> {
    let (at, period_ms) = (format!("{key}.mind.control_period_ms"), file.control_period_ms);
    if !(50..=2000).contains(&period_ms) || !period_ms.is_multiple_of(10) {
        return Err(Wrong::new(at, period_ms, "a multiple of 10 from 50 to 2000 ms"));
    }
    if matches!(method, Method::Path | Method::Map) && period_ms > PATH_PERIOD_MAX_MS {
        let allowed = "at most 500 ms where how.method = \"path\" or \"map\": seen more seldom, a path is left by metres";
        return Err(Wrong::new(at, period_ms, allowed));
    }
    Ok(period_ms)
}

/// `[robots.mind.health]`.
fn with_limits(
    key: &str,
    file: &HealthFile,
    settings: NavigatorSettings,
) -> Checked<NavigatorSettings> {
    let at = |name: &str| format!("{key}.mind.health.{name}");
    Ok(NavigatorSettings {
        task_limit_s: range(
            at("task_limit_s"),
            file.task_limit_s,
            1.0..=36_000.0,
            "from 1 to 36000 s",
        )?,
        progress_limit_s: range(
            at("progress_limit_s"),
            file.progress_limit_s,
            1.0..=3600.0,
            "from 1 to 3600 s",
        )?,
        link_limit_s: range(at("link_limit_s"), file.link_limit_s, 0.2..=60.0, "from 0.2 to 60 s")?,
        server_limit_s: range(
            at("server_limit_s"),
            file.server_limit_s,
            0.5..=60.0,
            "from 0.5 to 60 s",
        )?,
        ..settings
    })
}

fn attempts_max(key: &str, attempts_max: u32) -> Checked<u32> {
    let within = (1..=100).contains(&attempts_max);
    within.then_some(attempts_max).ok_or_else(|| Wrong::new(key, attempts_max, "from 1 to 100"))
}

/// What the wheels are told to accelerate with.
pub(super) fn acceleration_mps2(key: &str, file: &FollowFile) -> Checked<f64> {
    let at = format!("{key}.mind.follow.acceleration_mps2");
    range(at, file.acceleration_mps2, 0.05..=4.0, "from 0.05 to 4 m/s²")
}

/// The path of the path method; other methods have none.
pub(super) fn path(key: &str, file: &HowFile) -> Checked<Option<Path>> {
    if file.method != Method::Path.key() {
        return Ok(None);
    }
    let corners: Vec<Vec2> = file.path_m.iter().map(|&[x, y]| Vec2::new(x, y)).collect();
    Path::polyline(&corners).map(Some).map_err(|e| {
        let needed = "at least two different corners, finite, for method = \"path\"";
        Wrong::prose(format!("{key}.mind.how.path_m"), e.to_string(), needed)
    })
}

/// The places that the straight method visits before every goal; other methods have none.
pub(super) fn via(key: &str, file: &MindFile) -> Checked<Vec<Vec2>> {
    let (at, via_m) = (format!("{key}.mind.where_to.via_m"), &file.where_to.via_m);
    let straight = Method::Direct.key();
    if !via_m.is_empty() && file.how.method != straight {
        let found = format!("{} places, and how.method = \"{}\"", via_m.len(), file.how.method);
        let allowed = format!("absent: only how.method = \"{straight}\" visits places on its way");
        return Err(Wrong::prose(at, found, allowed));
    }
    let place = |(i, &place): (usize, &[f64; 2])| point(format!("{at}[{i}]"), place);
    via_m.iter().enumerate().map(place).collect()
}

/// The cruising speed: within the range of the laws, and what the robot can do.
fn speed_mps(key: &str, speed_mps: f64, model: &RobotModel) -> Checked<f64> {
    let speed_mps = range(key, speed_mps, 0.05..=1.0, "from 0.05 to 1 m/s")?;
    let most_mps = model.limits.speed_max_mps;
    if speed_mps > most_mps {
        let allowed = format!("at most {most_mps} m/s, the fastest that {} is", model.title);
        return Err(Wrong::new(key, speed_mps, allowed));
    }
    Ok(speed_mps)
}
