//! Checks of `[[robots.lasers]]`.

use geometry::{Se2, Vec2};
use navigator::LaserMount;
use robot_models::RobotModel;
use sensor_models::LaserKind;
use settings::{Choice as _, chosen};

use super::super::{
    error::Wrong,
    file::{LaserFile, RobotFile},
    plan::{LaserPlan, LinkPlan},
    words::LineKind,
};
use super::common::{Checked, line, range, unique};
use crate::{cut::Line, node::laser::device};

/// Lasers of one robot at most.
const N_LASERS_MAX: usize = 4;
/// What a SICK is asked to speak at where nothing is said: the fastest of a usual serial port.
const SICK_BAUD: u32 = 38_400;

/// The lasers of a robot of that model, whose own line is `base`.
pub(super) fn lasers(
    key: &str,
    file: &RobotFile,
    model: &RobotModel,
    base: &LinkPlan,
) -> Checked<Vec<LaserPlan>> {
    let table = format!("{key}.lasers");
    unique(&table, file.lasers.iter().map(|laser| laser.name.as_str()))?;
    if file.lasers.len() > N_LASERS_MAX {
        let allowed = format!("at most {N_LASERS_MAX} on one robot");
        return Err(Wrong::prose(table, format!("{} lasers", file.lasers.len()), allowed));
    }
    let one = |(i, laser)| laser_plan(&format!("{table}[{i}]"), laser, model, base);
    file.lasers.iter().enumerate().map(one).collect()
}

/// Where a robot's mind has its lasers.
pub(super) fn mounts(lasers: &[LaserPlan]) -> Vec<LaserMount> {
    let mount = |(number, laser): (usize, &LaserPlan)| LaserMount {
        device: device(number),
        base_from_sensor: laser.base_from_sensor,
    };
    lasers.iter().enumerate().map(mount).collect()
}

fn laser_plan(
    key: &str,
    file: &LaserFile,
    model: &RobotModel,
    base: &LinkPlan,
) -> Checked<LaserPlan> {
    let at = |name: &str| format!("{key}.{name}");
    if Line::ALL.iter().any(|line| line.key() == file.name) {
        let allowed = "another name: this is the word for another line of the robot";
        return Err(Wrong::new(at("name"), &file.name, allowed));
    }
    let kind: LaserKind = chosen(&at("kind"), &file.kind)?;
    for (axis, value_m) in file.at_m.into_iter().enumerate() {
        range(format!("{key}.at_m[{axis}]"), value_m, -5.0..=5.0, "from -5 to 5 m")?;
    }
    let [x_m, y_m] = file.at_m;
    if !model.footprint.contains(Vec2::new(x_m, y_m)) {
        let corners = model.footprint.corners();
        let ends = |of: fn(&Vec2) -> f64| {
            let values = corners.iter().map(of);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((x0, x1), (y0, y1)) = (ends(|c| c.x), ends(|c| c.y));
        let allowed = format!(
            "a place on the robot: the outline of {} reaches from {x0:.2} to {x1:.2} m along x, from {y0:.2} to {y1:.2} m along y",
            model.title
        );
        return Err(Wrong::prose(at("at_m"), format!("[{x_m}, {y_m}]"), allowed));
    }
    let yaw_deg = range(at("yaw_deg"), file.yaw_deg, -360.0..=360.0, "from -360 to 360 degrees")?;
    Ok(LaserPlan {
        name: file.name.clone(),
        kind,
        model: kind.model(),
        base_from_sensor: Se2::new(x_m, y_m, geometry::wrap_to_pi(yaw_deg.to_radians())),
        link: cable(&at("line"), file, kind, base)?,
    })
}

/// Its cable; a laser is simulated where its robot is.
fn cable(key: &str, file: &LaserFile, kind: LaserKind, base: &LinkPlan) -> Checked<LinkPlan> {
    let mut cable = file.line.clone();
    let is_elsewhere = matches!(base, LinkPlan::Tcp { .. } | LinkPlan::Serial { .. });
    if cable.baud == 0 {
        let is_simulated = cable.kind == LineKind::Memory.key();
        let is_sick = kind == LaserKind::SickLms;
        let usual = virtual_robots::laser_baud(kind);
        cable.baud = if is_sick && is_simulated { SICK_BAUD } else { usual };
    }
    let plan = line(key, &cable, LineKind::ALL)?;
    let is_here = matches!(plan, LinkPlan::Memory(_) | LinkPlan::Direct);
    if is_here == is_elsewhere {
        let allowed = if is_elsewhere {
            "`tcp` or `serial`, as the robot's own line: it is elsewhere"
        } else {
            "`memory` or `direct`, as the robot's own line: it is simulated here"
        };
        return Err(Wrong::new(format!("{key}.kind"), &file.line.kind, allowed));
    }
    let baud = plan.baud();
    if kind == LaserKind::SickLms && baud != 0 && wire::sick_lms::Baud::of(baud).is_none() {
        let allowed = "9600, 19200, 38400 or 500000, which a SICK can speak at";
        return Err(Wrong::new(format!("{key}.baud"), baud, allowed));
    }
    Ok(plan)
}
