//! Checks of `[tags]`, `[robots.tag_readers]` and `[robots.mind.follow.tags]`.

use geometry::Vec2;
use navigator::{Method, N_TAG_READERS_MAX, TagController, TagSettings};
use path_following::{TagFollowerConfig, fuzzy::FuzzyConfig};
use sensor_models::TagReaderModel;
use settings::Choice as _;
use simulator::FloorTags;

use super::super::{
    error::Wrong,
    file::{MissionFile, RobotFile, TagsFile},
    plan::{LinkPlan, TagReadersPlan, TagsPlan},
};
use super::common::{Checked, chosen, point, range, seconds};

/// Farthest that a reader may sit from its robot's centre, metres.
const READER_AWAY_MAX_M: f64 = 1.0;

/// Under the front of a Pioneer, two and a half tags of 0.1 m apart: one reader passes over a row where the other
/// passes between two.
const TWO_M: [[f64; 2]; 2] = [[0.18, 0.125], [0.18, -0.125]];
const ONE_M: [[f64; 2]; 1] = [[0.18, 0.0]];

/// `[tags]`.
pub(super) fn tags(mission: &MissionFile, file: &TagsFile) -> Checked<TagsPlan> {
    let area_m = match *file.area_m.as_slice() {
        [] => mission.world.bounds_m,
        [x0, y0, x1, y1] if x0 < x1 && y0 < y1 => [x0, y0, x1, y1],
        _ => {
            let allowed = "x0, y0, x1, y1 with x0 < x1 and y0 < y1, or none for world.bounds_m";
            return Err(Wrong::new("tags.area_m", &file.area_m, allowed));
        }
    };
    if !(1..=9).contains(&file.width_cells) {
        return Err(Wrong::new("tags.width_cells", file.width_cells, "from 1 to 9"));
    }
    if file.peak == 0 {
        return Err(Wrong::new("tags.peak", file.peak, "from 1 to 255"));
    }
    let pitch_m = range("tags.pitch_m", file.pitch_m, 0.02..=2.0, "from 0.02 to 2 m")?;
    // As many places as there will be tags: refuses what does not fit into memory.
    FloorTags::new(area_m, pitch_m, |_| None)
        .map_err(|e| Wrong::prose("tags.pitch_m", e.to_string(), "a floor with fewer tags"))?;
    Ok(TagsPlan {
        trails: trails(file, area_m)?,
        width_cells: file.width_cells,
        peak: file.peak,
        pitch_m,
        area_m,
        missing_ratio: range("tags.missing_ratio", file.missing_ratio, 0.0..=1.0, "from 0 to 1")?,
        look_ahead_m: range("tags.look_ahead_m", file.look_ahead_m, 0.0..=5.0, "from 0 to 5 m")?,
    })
}

fn trails(file: &TagsFile, [x0, y0, x1, y1]: [f64; 4]) -> Checked<Vec<Vec<Vec2>>> {
    let check = |(i, trail): (usize, &Vec<[f64; 2]>)| {
        let key = format!("tags.trails_m[{i}]");
        let same =
            |ends: &[[f64; 2]]| (0..2).all(|axis| (ends[0][axis] - ends[1][axis]).abs() < 1e-9);
        if trail.len() < 2 || trail.windows(2).any(same) {
            return Err(Wrong::new(key, trail, "two or more corners, neighbours different"));
        }
        let corner = |(j, &at): (usize, &[f64; 2])| {
            let key = format!("{key}[{j}]");
            let corner = point(key.clone(), at)?;
            let inside = (x0..=x1).contains(&corner.x) && (y0..=y1).contains(&corner.y);
            let allowed =
                format!("a corner where there are tags, from ({x0}, {y0}) to ({x1}, {y1}) m");
            inside.then_some(corner).ok_or_else(|| Wrong::new(key, at, allowed))
        };
        trail.iter().enumerate().map(corner).collect::<Checked<Vec<Vec2>>>()
    };
    file.trails_m.iter().enumerate().map(check).collect()
}

fn law(key: &str, robot: &RobotFile) -> Checked<TagController> {
    chosen(&format!("{key}.mind.follow.tags.law"), &robot.mind.follow.tags.law)
}

/// `[robots.tag_readers]`: those of a robot that has any, or that follows tags.
pub(super) fn readers(
    key: &str,
    robot: &RobotFile,
    link: &LinkPlan,
) -> Checked<Option<TagReadersPlan>> {
    let follows = robot.mind.how.method == Method::Tags.key();
    if robot.tag_readers.is_none() && !follows {
        return Ok(None);
    }
    if !matches!(link, LinkPlan::Memory(_) | LinkPlan::Direct) {
        let allowed = "`memory` or `direct`: the tags are simulated, and the robot is elsewhere";
        return Err(Wrong::new(format!("{key}.line.kind"), &robot.line.kind, allowed));
    }
    let file = robot.tag_readers.clone().unwrap_or_default();
    let at = |name: &str| format!("{key}.tag_readers.{name}");
    let controller = law(key, robot)?;
    let places = match (file.at_m.as_slice(), controller) {
        ([], TagController::Gradient) => &TWO_M[..],
        ([], TagController::LookAhead) => &ONE_M[..],
        (given, _) => given,
    };
    let n = places.len();
    if n > N_TAG_READERS_MAX || follows && controller == TagController::Gradient && n != 2 {
        let allowed = "two places, left and right; one or two for look_ahead";
        return Err(Wrong::prose(at("at_m"), format!("{n} places"), allowed));
    }
    for (i, place) in places.iter().enumerate() {
        if !place.iter().all(|m| m.abs() <= READER_AWAY_MAX_M) {
            let allowed = "within 1 m of the robot's centre";
            return Err(Wrong::new(format!("{}[{i}]", at("at_m")), place, allowed));
        }
    }
    if let [left, right] = places
        && left[1] <= right[1]
    {
        let allowed = "the left reader first: its y must be greater than that of the right one";
        return Err(Wrong::new(at("at_m"), places, allowed));
    }
    let read_ms = range(at("read_ms"), file.read_ms, 1.0..=5000.0, "from 1 to 5000 ms")?;
    Ok(Some(TagReadersPlan {
        in_base: places.iter().map(|&[x, y]| Vec2::new(x, y)).collect(),
        model: TagReaderModel {
            range_m: range(at("range_m"), file.range_m, 0.005..=1.0, "from 0.005 to 1 m")?,
            read_time: seconds(read_ms * 1e-3),
            miss_prob: range(at("miss_prob"), file.miss_prob, 0.0..=1.0, "from 0 to 1")?,
            anti_collision: file.anti_collision,
        },
        amplify: file.amplify,
    }))
}

/// `[robots.mind.follow.tags]`.
pub(super) fn following(
    key: &str,
    robot: &RobotFile,
    readers: Option<&TagReadersPlan>,
) -> Checked<TagSettings> {
    let file = &robot.mind.follow.tags;
    let at = |name: &str| format!("{key}.mind.follow.tags.{name}");
    for (name, value) in [("error_full", file.error_full), ("change_full", file.change_full)] {
        if !(1..=100_000).contains(&value) {
            return Err(Wrong::new(at(name), value, "from 1 to 100000"));
        }
    }
    let fuzzy = FuzzyConfig {
        error_full: f64::from(file.error_full),
        change_full: f64::from(file.change_full),
        slow_ratio: range(at("slow_ratio"), file.slow_ratio, -1.0..=1.0, "from -1 to 1")?,
        fast_ratio: range(at("fast_ratio"), file.fast_ratio, 1.0..=3.0, "from 1 to 3")?,
        ..FuzzyConfig::default()
    };
    let follower = TagFollowerConfig {
        fuzzy,
        smooth_m: range(at("smooth_m"), file.smooth_m, 0.001..=1.0, "from 0.001 to 1 m")?,
        hold_m: range(at("hold_m"), file.hold_m, 0.05..=2.0, "from 0.05 to 2 m")?,
        ..TagFollowerConfig::default()
    };
    let controller = law(key, robot)?;
    Ok(match readers {
        Some(readers) if readers.in_base.len() == 2 || controller == TagController::LookAhead => {
            let readers_in_base = readers.in_base.clone();
            TagSettings { controller, readers_in_base, follower }
        }
        // Without readers, or with fewer than the law wants, it does not follow tags.
        _ => TagSettings { follower, ..TagSettings::default() },
    })
}
