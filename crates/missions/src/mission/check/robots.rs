//! Checks of `[[robots]]`.

use std::sync::Arc;

use geometry::{Se2, Vec2};
use path_following::Path;
use robot_models::{OdometryErrors, RobotModel};
use run_context::Stamp;
use sensor_models::SonarModel;
use settings::Choice as _;

use super::super::{
    error::Wrong,
    file::{MissionFile, OdometryFile, RobotFile, SonarFile, TeleoperatorFile},
    plan::{LinkPlan, RobotPlan, TeleoperatorPlan},
    words::LineKind,
};
use super::{
    common::{Checked, line, point, pose, range, seconds, unique},
    lasers, mind, ring, tags,
};

/// Times that a path may be driven.
const LAPS_MAX: u32 = 100;

/// `[[robots]]`, each table with a count above one laid out in rows.
pub(super) fn robots(file: &MissionFile) -> Checked<Vec<RobotPlan>> {
    unique("robots", file.robots.iter().map(|r| r.name.as_str()))?;
    let mut plans = Vec::new();
    for (i, robot) in file.robots.iter().enumerate() {
        plans.extend(group(&format!("robots[{i}]"), robot)?);
    }
    Ok(plans)
}

fn group(key: &str, file: &RobotFile) -> Checked<Vec<RobotPlan>> {
    let mut model = RobotModel::by_name(&file.model).map_err(|_unknown| {
        let names: Vec<String> =
            RobotModel::catalogue().iter().map(|m| format!("`{}`", m.name)).collect();
        Wrong::new(format!("{key}.model"), &file.model, format!("one of {}", names.join(", ")))
    })?;
    if !(1..=10_000).contains(&file.count) {
        return Err(Wrong::new(format!("{key}.count"), file.count, "from 1 to 10000"));
    }
    if file.row_length == 0 {
        return Err(Wrong::new(format!("{key}.row_length"), 0, "at least 1"));
    }
    for (axis, spacing_m) in file.spacing_m.into_iter().enumerate() {
        range(format!("{key}.spacing_m[{axis}]"), spacing_m, -100.0..=100.0, "from -100 to 100 m")?;
    }
    let first = pose(&format!("{key}.start"), file.start)?;
    let errors = odometry(key, &file.odometry, model.drive.wheelbase_m)?;
    let sonar = sonar(key, &file.sonar)?;
    ring::fit(key, &file.sonar, &mut model)?;
    ring::hears_ahead(key, &file.mind.guard, &model, file.lasers.len())?;
    let link = line(&format!("{key}.line"), &file.line, LineKind::ALL)?;
    let (here, there) = (virtual_robots::has_board(&model), drivers::has_driver(&model));
    let refused = match link {
        LinkPlan::Direct => None,
        LinkPlan::Memory(_) => (!(here && there)).then_some("simulated"),
        LinkPlan::Tcp { .. } | LinkPlan::Serial { .. } => (!there).then_some("known here"),
    };
    if let Some(what) = refused {
        let allowed = format!("`direct`: the line of {} is not {what}", model.title);
        return Err(Wrong::new(format!("{key}.line.kind"), &file.line.kind, allowed));
    }
    let baud_min = model.line.as_ref().map_or(0, |line| line.baud_min);
    if link.baud() != 0 && link.baud() < baud_min {
        let allowed =
            format!("at least {baud_min} baud, so that the reports of {} fit", model.title);
        return Err(Wrong::new(format!("{key}.line.baud"), file.line.baud, allowed));
    }
    let teleoperator = file.teleoperator.as_ref();
    let teleoperator = teleoperator.map(|t| teleoperator_plan(key, t, file, &link)).transpose()?;
    if matches!(link, LinkPlan::Direct) {
        // There is no SETA without bytes.
        model.limits.acceleration_max_mps2 = mind::acceleration_mps2(key, &file.mind.follow)?;
    }
    let model = Arc::new(model);
    let tag_readers = tags::readers(key, file, &link)?;
    let lasers = lasers::lasers(key, file, &model, &link)?;
    let mounts = lasers::mounts(&lasers);
    let navigator = Arc::new(mind::mind(key, file, &model, tag_readers.as_ref(), mounts)?);
    let path = mind::path(key, &file.mind.how)?;
    let via = mind::via(key, &file.mind)?;
    let one = |n: usize| {
        let (column, row) = (n % file.row_length, n / file.row_length);
        let shift = Vec2::new(column as f64 * file.spacing_m[0], row as f64 * file.spacing_m[1]);
        RobotPlan {
            name: if file.count == 1 { file.name.clone() } else { format!("{}-{n:04}", file.name) },
            group: file.name.clone(),
            model: Arc::clone(&model),
            start: Se2::new(first.x_m + shift.x, first.y_m + shift.y, first.yaw_rad),
            errors,
            sonar,
            link: link.clone(),
            navigator: Arc::clone(&navigator),
            path: path.clone(),
            via: via.clone(),
            tag_readers: tag_readers.clone(),
            lasers: lasers.clone(),
            teleoperator: teleoperator.clone(),
        }
    };
    Ok((0..file.count).map(one).collect())
}

/// `[robots.teleoperator]`.
fn teleoperator_plan(
    key: &str,
    file: &TeleoperatorFile,
    robot: &RobotFile,
    link: &LinkPlan,
) -> Checked<TeleoperatorPlan> {
    let at = |name: &str| format!("{key}.teleoperator.{name}");
    if !matches!(link, LinkPlan::Memory(_) | LinkPlan::Direct) {
        let allowed = "`memory` or `direct`: nobody here sees a robot that is elsewhere";
        return Err(Wrong::new(format!("{key}.line.kind"), &robot.line.kind, allowed));
    }
    if robot.count != 1 {
        let allowed = "1, because one person drives one robot";
        return Err(Wrong::new(format!("{key}.count"), robot.count, allowed));
    }
    if !(1..=LAPS_MAX).contains(&file.laps) {
        return Err(Wrong::new(at("laps"), file.laps, "from 1 to 100"));
    }
    let corner = |(i, &p): (usize, &[f64; 2])| point(format!("{}[{i}]", at("path_m")), p);
    let once = file.path_m.iter().enumerate().map(corner).collect::<Checked<Vec<Vec2>>>()?;
    if file.laps > 1 && once.first() != once.last() {
        let allowed = "1, or a path that ends where it begins";
        return Err(Wrong::new(at("laps"), file.laps, allowed));
    }
    let mut corners = once.clone();
    (1..file.laps).for_each(|_| corners.extend(once.iter().skip(1)));
    let radius_m =
        range(at("corner_radius_m"), file.corner_radius_m, 0.05..=5.0, "from 0.05 to 5 m")?;
    let path = Path::rounded(&corners, radius_m)
        .map_err(|e| Wrong::prose(at("path_m"), e.to_string(), "at least two different corners"))?;
    let starts_at_s =
        range(at("starts_at_s"), file.starts_at_s, 0.0..=86_400.0, "from 0 to 86400 s")?;
    Ok(TeleoperatorPlan {
        path,
        speed_mps: range(at("speed_mps"), file.speed_mps, 0.02..=1.0, "from 0.02 to 1 m/s")?,
        starts_at: Stamp::ZERO + seconds(starts_at_s),
    })
}

fn odometry(key: &str, file: &OdometryFile, wheelbase_m: f64) -> Checked<OdometryErrors> {
    let ratio = |name: &str, value: f64| {
        range(format!("{key}.odometry.{name}"), value, 0.8..=1.25, "from 0.8 to 1.25")
    };
    let drift_degpm = range(
        format!("{key}.odometry.drift_degpm"),
        file.drift_degpm,
        -5.0..=5.0,
        "from -5 to 5 degrees per metre",
    )?;
    let wheelbase_ratio = ratio("wheelbase_ratio", file.wheelbase_ratio)?;
    // Wheels that roll alike turn the body by (r_R − r_L) / (b r_b) per metre.
    let half_ratio = 0.5 * drift_degpm.to_radians() * wheelbase_m * wheelbase_ratio;
    let at = |name: &str| format!("{key}.odometry.{name}");
    let misalignment_deg = range(
        at("misalignment_deg"),
        file.misalignment_deg,
        -10.0..=10.0,
        "from -10 to 10 degrees",
    )?;
    let encoder_period_ms =
        range(at("encoder_period_ms"), file.encoder_period_ms, 0.0..=1000.0, "from 0 to 1000 ms")?;
    // Whole numbers of this size are exact.
    let n_pulses = f64::from(file.encoder_coarsening_ticks);
    range(at("encoder_coarsening_ticks"), n_pulses, 1.0..=100_000.0, "from 1 to 100000 pulses")?;
    Ok(OdometryErrors {
        left_diameter_ratio: ratio("left_diameter_ratio", file.left_diameter_ratio)? - half_ratio,
        right_diameter_ratio: ratio("right_diameter_ratio", file.right_diameter_ratio)?
            + half_ratio,
        wheelbase_ratio,
        misalignment_rad: misalignment_deg.to_radians(),
        encoder_coarsening_ticks: file.encoder_coarsening_ticks,
        encoder_period: seconds(0.001 * encoder_period_ms),
        slip_std_ratio: range(
            at("slip_std_ratio"),
            file.slip_std_ratio,
            0.0..=0.5,
            "from 0 to 0.5",
        )?,
        bump_rate_hz: range(
            at("bump_rate_hz"),
            file.bump_rate_hz,
            0.0..=100.0,
            "from 0 to 100 per second",
        )?,
        bump_std_m: range(at("bump_std_m"), file.bump_std_m, 0.0..=0.1, "from 0 to 0.1 m")?,
    })
}

fn sonar(key: &str, file: &SonarFile) -> Checked<SonarModel> {
    let at = |name: &str| format!("{key}.sonar.{name}");
    if !(1..=64).contains(&file.n_rays) {
        return Err(Wrong::new(at("n_rays"), file.n_rays, "from 1 to 64"));
    }
    let half_deg =
        range(at("half_angle_deg"), file.half_angle_deg, 1.0..=45.0, "from 1 to 45 degrees")?;
    Ok(SonarModel {
        range_min_m: range(at("range_min_m"), file.range_min_m, 0.0..=0.3, "from 0 to 0.3 m")?,
        range_step_m: range(at("range_step_m"), file.range_step_m, 0.0..=0.1, "from 0 to 0.1 m")?,
        range_max_m: range(at("range_max_m"), file.range_max_m, 0.3..=20.0, "from 0.3 to 20 m")?,
        half_angle_rad: half_deg.to_radians(),
        n_rays: file.n_rays,
        range_std_m: range(at("range_std_m"), file.range_std_m, 0.0..=1.0, "from 0 to 1 m")?,
        range_std_ratio: range(
            at("range_std_ratio"),
            file.range_std_ratio,
            0.0..=0.5,
            "from 0 to 0.5",
        )?,
        ghost_prob: range(at("ghost_prob"), file.ghost_prob, 0.0..=1.0, "from 0 to 1")?,
        dropout_prob: range(at("dropout_prob"), file.dropout_prob, 0.0..=1.0, "from 0 to 1")?,
        crosstalk_prob: range(at("crosstalk_prob"), file.crosstalk_prob, 0.0..=1.0, "from 0 to 1")?,
        ..SonarModel::default()
    })
}
