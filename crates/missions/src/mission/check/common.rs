//! What every check of a mission's tables uses: coordinates, times, names, lines.

use std::time::Duration;

use geometry::{Se2, Vec2};

use super::super::{
    error::Wrong,
    file::LineFile,
    plan::{GoalPose, LinkPlan, RobotPlan},
    words::LineKind,
};

pub(crate) use settings::{chosen, chosen_of, picked, range};

pub(crate) type Checked<T> = Result<T, Wrong>;

/// A point whose coordinates are within 10 km of the origin.
pub(crate) fn point(key: impl Into<String>, [x, y]: [f64; 2]) -> Checked<Vec2> {
    let ok = |v: f64| v.abs() <= 10_000.0;
    if ok(x) && ok(y) {
        Ok(Vec2::new(x, y))
    } else {
        Err(Wrong::new(key, [x, y], "two coordinates from -10000 to 10000 m"))
    }
}

/// A pose written as x, y (m), yaw (degrees).
pub(crate) fn pose(key: &str, [x, y, yaw_deg]: [f64; 3]) -> Checked<Se2> {
    let position = point(key, [x, y])?;
    let yaw =
        range(key, yaw_deg, -360.0..=360.0, "x and y (m) and a yaw from -360 to 360 degrees")?;
    Ok(Se2::new(position.x, position.y, yaw.to_radians()))
}

/// A duration in seconds that was checked to be finite and not negative.
pub(crate) fn seconds(value_s: f64) -> Duration {
    Duration::try_from_secs_f64(value_s).unwrap_or_default()
}

/// Names must not be empty and must differ.
pub(crate) fn unique<'a>(table: &str, names: impl Iterator<Item = &'a str>) -> Checked<()> {
    let mut seen: Vec<&str> = Vec::new();
    for (i, name) in names.enumerate() {
        if name.is_empty() {
            return Err(Wrong::new(format!("{table}[{i}].name"), name, "a name"));
        }
        if let Some(first) = seen.iter().position(|&s| s == name) {
            let allowed = format!("a name of its own; {table}[{first}] has this one");
            return Err(Wrong::new(format!("{table}[{i}].name"), name, allowed));
        }
        seen.push(name);
    }
    Ok(())
}

/// The index of the thing that is named; the error lists what exists.
pub(crate) fn named(key: &str, name: &str, names: &[&str]) -> Checked<usize> {
    names.iter().position(|&n| n == name).ok_or_else(|| {
        let list = if names.is_empty() { "there are none".to_owned() } else { names.join(", ") };
        let meant = settings::did_you_mean(name, names.iter().copied());
        let meant = meant.map(|meant| format!(" (did you mean `{meant}`?)")).unwrap_or_default();
        Wrong::new(key, name, format!("one of the mission's names: {list}{meant}"))
    })
}

/// The robots of a group or the one robot of that name.
pub(crate) fn robots_named(key: &str, name: &str, robots: &[RobotPlan]) -> Checked<Vec<usize>> {
    let found: Vec<usize> =
        (0..robots.len()).filter(|&i| robots[i].group == name || robots[i].name == name).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let mut groups: Vec<&str> = robots.iter().map(|r| r.group.as_str()).collect();
    groups.dedup();
    named(&format!("{key}.robot"), name, &groups).map(|i| vec![i])
}

pub(crate) fn goal(
    key: &str,
    in_map: Option<[f64; 3]>,
    from_start: Option<[f64; 3]>,
) -> Checked<GoalPose> {
    match (in_map, from_start) {
        (Some(p), None) => pose(&format!("{key}.pose"), p).map(GoalPose::InMap),
        (None, Some(p)) => pose(&format!("{key}.pose_from_start"), p).map(GoalPose::FromStart),
        (found, _) => {
            let found = if found.is_some() { "given with pose_from_start" } else { "absent" };
            let allowed = "x, y (m), yaw (degrees), either here or in pose_from_start";
            Err(Wrong::prose(format!("{key}.pose"), found, allowed))
        }
    }
}

/// A line of one of these kinds.
pub(crate) fn line(key: &str, file: &LineFile, kinds: &[LineKind]) -> Checked<LinkPlan> {
    let at = |name: &str| format!("{key}.{name}");
    range(at("latency_ms"), file.latency_ms, 0.0..=10_000.0, "from 0 to 10000 ms")?;
    range(at("jitter_ms"), file.jitter_ms, 0.0..=10_000.0, "from 0 to 10000 ms")?;
    range(at("loss_prob"), file.loss_prob, 0.0..=1.0, "from 0 to 1")?;
    range(at("corruption_prob"), file.corruption_prob, 0.0..=1.0, "from 0 to 1")?;
    match chosen_of(&at("kind"), &file.kind, kinds)? {
        LineKind::Memory => Ok(LinkPlan::Memory(wire::link::LinkConfig {
            baud: (file.baud > 0).then_some(file.baud),
            latency: seconds(file.latency_ms * 1e-3),
            jitter: seconds(file.jitter_ms * 1e-3),
            loss_prob: file.loss_prob,
            corruption_prob: file.corruption_prob,
        })),
        LineKind::Direct => Ok(LinkPlan::Direct),
        LineKind::Tcp => {
            let port = file.address.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
            if !matches!(port, Some(Ok(_))) {
                let allowed = "host:port, such as \"127.0.0.1:8101\"";
                return Err(Wrong::new(at("address"), &file.address, allowed));
            }
            Ok(LinkPlan::Tcp { address: file.address.clone() })
        }
        LineKind::Serial => {
            if file.device.is_empty() {
                let allowed = "a device, such as \"/dev/ttyUSB0\"";
                return Err(Wrong::new(at("device"), &file.device, allowed));
            }
            if file.baud == 0 {
                return Err(Wrong::new(at("baud"), file.baud, "a rate above 0 baud"));
            }
            Ok(LinkPlan::Serial { device: file.device.clone(), baud: file.baud })
        }
    }
}
