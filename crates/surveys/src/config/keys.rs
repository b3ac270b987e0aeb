//! The list of keys.

use std::fmt::Write as _;

use super::{Method, Mode, SurveyConfig, Values};
use crate::sonar;

/// One thing that can be set.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Table and key, such as `map.resolution_m`; the unit ends it.
    pub name: &'static str,
    /// What it means.
    pub about: &'static str,
    /// What its values are.
    pub kind: KeyKind,
    pub(super) access: Access,
}

/// What the values of a key are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyKind {
    /// A number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Count(usize, usize),
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
}

/// Where a value lives.
#[derive(Clone, Copy, Debug)]
pub(super) enum Access {
    Number(fn(&mut Values) -> &mut f64),
    /// Degrees in files, radians inside.
    Degrees(fn(&mut Values) -> &mut f64),
    Count(fn(&mut Values) -> &mut usize),
    Flag(fn(&mut Values) -> &mut bool),
    Choice(fn(&Values) -> usize, fn(&mut Values, usize)),
}

impl Key {
    /// What a value must be, as prose.
    pub fn requirement(&self) -> String {
        match self.kind {
            KeyKind::Number(low, high) => format!("from {low} to {high}"),
            KeyKind::Count(low, high) => format!("a whole number from {low} to {high}"),
            KeyKind::Flag => "true or false".to_owned(),
            KeyKind::Choice(words) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("one of {}", quoted.join(", "))
            }
        }
    }

    /// The table that the key stands in.
    pub fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// The key without its table.
    pub fn short_name(&self) -> &'static str {
        self.name.rsplit_once('.').map_or(self.name, |(_, key)| key)
    }

    pub(super) fn read(&self, values: &Values) -> toml::Value {
        let mut copy = values.clone();
        match self.access {
            Access::Number(at) => toml::Value::Float(*at(&mut copy)),
            Access::Degrees(at) => toml::Value::Float(tidy_degrees(*at(&mut copy))),
            Access::Count(at) => toml::Value::Integer(*at(&mut copy) as i64),
            Access::Flag(at) => toml::Value::Boolean(*at(&mut copy)),
            Access::Choice(get, _) => {
                let KeyKind::Choice(words) = self.kind else { return toml::Value::Boolean(false) };
                toml::Value::String(words.get(get(values)).copied().unwrap_or_default().to_owned())
            }
        }
    }

    /// Writes a value; `None` when it is not what the key allows.
    pub(super) fn write(&self, values: &mut Values, found: &toml::Value) -> Option<()> {
        let number = found.as_float().or_else(|| found.as_integer().map(|i| i as f64));
        match (self.kind, self.access) {
            (KeyKind::Number(low, high), Access::Number(at)) => {
                *at(values) = number.filter(|v| (low..=high).contains(v))?;
            }
            (KeyKind::Number(low, high), Access::Degrees(at)) => {
                let degrees = number.filter(|v| (low..=high).contains(v))?;
                // A value that is printed and read again keeps its bits.
                if tidy_degrees(*at(values)).to_bits() != degrees.to_bits() {
                    *at(values) = degrees.to_radians();
                }
            }
            (KeyKind::Count(low, high), Access::Count(at)) => {
                let count = usize::try_from(found.as_integer()?).ok()?;
                *at(values) = Some(count).filter(|c| (low..=high).contains(c))?;
            }
            (KeyKind::Flag, Access::Flag(at)) => *at(values) = found.as_bool()?,
            (KeyKind::Choice(words), Access::Choice(_, set)) => {
                let found = found.as_str()?;
                set(values, words.iter().position(|&word| word == found)?);
            }
            _ => return None,
        }
        Some(())
    }
}

/// Degrees without the last digits of a conversion.
fn tidy_degrees(rad: f64) -> f64 {
    (rad.to_degrees() * 1e9).round() / 1e9
}

pub(crate) const fn number(
    name: &'static str,
    about: &'static str,
    range: (f64, f64),
    at: fn(&mut Values) -> &mut f64,
) -> Key {
    Key { name, about, kind: KeyKind::Number(range.0, range.1), access: Access::Number(at) }
}

pub(crate) const fn degrees(
    name: &'static str,
    about: &'static str,
    range: (f64, f64),
    at: fn(&mut Values) -> &mut f64,
) -> Key {
    Key { name, about, kind: KeyKind::Number(range.0, range.1), access: Access::Degrees(at) }
}

pub(crate) const fn count(
    name: &'static str,
    about: &'static str,
    range: (usize, usize),
    at: fn(&mut Values) -> &mut usize,
) -> Key {
    Key { name, about, kind: KeyKind::Count(range.0, range.1), access: Access::Count(at) }
}

pub(crate) const fn flag(
    name: &'static str,
    about: &'static str,
    at: fn(&mut Values) -> &mut bool,
) -> Key {
    Key { name, about, kind: KeyKind::Flag, access: Access::Flag(at) }
}

pub(crate) const fn choice(
    name: &'static str,
    about: &'static str,
    words: &'static [&'static str],
    get: fn(&Values) -> usize,
    set: fn(&mut Values, usize),
) -> Key {
    Key { name, about, kind: KeyKind::Choice(words), access: Access::Choice(get, set) }
}

const METHODS: [Method; 4] = [Method::Auto, Method::Laser, Method::Sonar, Method::Odometry];
const MODES: [Mode; 4] = [Mode::Default, Mode::Graph, Mode::Thesis, Mode::Listing];

pub(super) const MODE: &str = "survey.mode";

const SURVEY: [Key; 2] = [
    choice(
        "survey.method",
        "who makes the map; auto: laser or sonar, by the rig; odometry: dead reckoning as it is",
        &["auto", "laser", "sonar", "odometry"],
        |v| METHODS.iter().position(|m| *m == v.method).unwrap_or(0),
        |v, i| v.method = METHODS[i],
    ),
    choice(
        MODE,
        "form of the sonar method; graph: submaps and loops; thesis and listing set all keys of [sonar] to that source's values",
        &["default", "graph", "thesis", "listing"],
        |v| MODES.iter().position(|m| *m == v.mode).unwrap_or(0),
        |v, i| v.mode = MODES[i],
    ),
];

const MAP: [Key; 7] = [
    number("map.resolution_m", "side of a cell", (0.005, 1.0), |v| &mut v.map.resolution_m),
    number("map.range_max_m", "a laser's readings beyond it are not drawn", (0.5, 200.0), |v| {
        &mut v.map.range_max_m
    }),
    number("map.hit_logodds", "what a reading adds where it ends", (0.01, 10.0), |v| {
        &mut v.map.hit_logodds
    }),
    number("map.miss_logodds", "what a reading adds before its end", (-10.0, -0.01), |v| {
        &mut v.map.miss_logodds
    }),
    number("map.limit_logodds", "certainty at most, either way", (0.5, 30.0), |v| {
        &mut v.map.limit_logodds
    }),
    number("map.occupied_prob", "a cell above it is written as occupied", (0.5, 0.99), |v| {
        &mut v.map.occupied_prob
    }),
    number("map.free_prob", "a cell below it is written as free", (0.01, 0.5), |v| {
        &mut v.map.free_prob
    }),
];

const LASER_POINTS: [Key; 5] = [
    number("laser.points.range_min_m", "nearer readings are left out", (0.0, 5.0), |v| {
        &mut v.laser.points.range_min_m
    }),
    number("laser.points.range_max_m", "farther readings are left out", (1.0, 200.0), |v| {
        &mut v.laser.points.range_max_m
    }),
    number(
        "laser.points.spacing_m",
        "between the points kept along a surface",
        (0.005, 1.0),
        |v| &mut v.laser.points.spacing_m,
    ),
    number(
        "laser.points.normal_reach_m",
        "neighbours that make a point's line",
        (0.02, 2.0),
        |v| &mut v.laser.points.normal_reach_m,
    ),
    number(
        "laser.points.gap_m",
        "points farther apart are on different surfaces",
        (0.01, 2.0),
        |v| &mut v.laser.points.gap_m,
    ),
];

const LASER_REFINE: [Key; 5] = [
    count("laser.refine.iterations_max", "steps of laying a scan on the map", (1, 200), |v| {
        &mut v.laser.refine.iterations_max
    }),
    number(
        "laser.refine.reach_start_m",
        "from a point to its surface, at first",
        (0.02, 5.0),
        |v| &mut v.laser.refine.reach_start_m,
    ),
    number("laser.refine.reach_end_m", "from a point to its surface, at last", (0.01, 5.0), |v| {
        &mut v.laser.refine.reach_end_m
    }),
    number("laser.refine.robust_m", "errors beyond it count linearly", (0.001, 1.0), |v| {
        &mut v.laser.refine.robust_m
    }),
    number("laser.refine.point_std_m", "of a point across its surface", (0.001, 0.5), |v| {
        &mut v.laser.refine.point_std_m
    }),
];

const LASER_MOTION: [Key; 8] = [
    number("laser.motion.position_std_m", "dead reckoning, standing", (0.0, 1.0), |v| {
        &mut v.laser.motion.position_std_m
    }),
    number("laser.motion.position_std_ratio", "per metre driven", (0.0, 2.0), |v| {
        &mut v.laser.motion.position_std_ratio
    }),
    number("laser.motion.position_per_turn_std_m", "per radian turned", (0.0, 2.0), |v| {
        &mut v.laser.motion.position_per_turn_std_m
    }),
    degrees("laser.motion.yaw_std_deg", "dead reckoning, standing", (0.0, 45.0), |v| {
        &mut v.laser.motion.yaw_std_rad
    }),
    degrees("laser.motion.yaw_per_metre_std_deg", "per metre driven", (0.0, 45.0), |v| {
        &mut v.laser.motion.yaw_per_metre_std_rad
    }),
    number("laser.motion.yaw_std_ratio", "per turn", (0.0, 2.0), |v| {
        &mut v.laser.motion.yaw_std_ratio
    }),
    number("laser.motion.unknown_position_std_m", "a scan without odometry", (0.01, 5.0), |v| {
        &mut v.laser.motion.unknown_position_std_m
    }),
    degrees("laser.motion.unknown_yaw_std_deg", "a scan without odometry", (0.1, 90.0), |v| {
        &mut v.laser.motion.unknown_yaw_std_rad
    }),
];

const LASER_TRACKING: [Key; 8] = [
    number("laser.tracking.keyframe_distance_m", "a keyframe after this way", (0.02, 10.0), |v| {
        &mut v.laser.tracking.keyframe_distance_m
    }),
    degrees("laser.tracking.keyframe_turn_deg", "a keyframe after this turn", (1.0, 180.0), |v| {
        &mut v.laser.tracking.keyframe_turn_rad
    }),
    number(
        "laser.tracking.keyframe_inlier_ratio",
        "a keyframe when the map explains fewer points",
        (0.0, 1.0),
        |v| &mut v.laser.tracking.keyframe_inlier_ratio,
    ),
    count("laser.tracking.local_keyframes", "keyframes in the local map", (1, 200), |v| {
        &mut v.laser.tracking.local_keyframes
    }),
    number(
        "laser.tracking.surfel_cell_m",
        "cell in which surface points merge",
        (0.02, 1.0),
        |v| &mut v.laser.tracking.surfel_cell_m,
    ),
    number(
        "laser.tracking.inlier_min_ratio",
        "fewer: the match is not believed",
        (0.0, 1.0),
        |v| &mut v.laser.tracking.inlier_min_ratio,
    ),
    number("laser.tracking.grid_resolution_m", "cell of the search's grid", (0.01, 0.5), |v| {
        &mut v.laser.tracking.grid_resolution_m
    }),
    number("laser.tracking.grid_std_m", "width of a surface in that grid", (0.01, 1.0), |v| {
        &mut v.laser.tracking.grid_std_m
    }),
];

const LASER_LOOPS: [Key; 11] = [
    number(
        "laser.loops.way_min_m",
        "way between two visits that makes a loop",
        (0.5, 1000.0),
        |v| &mut v.laser.loops.way_min_m,
    ),
    number("laser.loops.radius_m", "places nearer than this are tried", (0.1, 100.0), |v| {
        &mut v.laser.loops.radius_m
    }),
    count(
        "laser.loops.candidates_max",
        "candidates for each keyframe; 0: no loops",
        (0, 50),
        |v| &mut v.laser.loops.candidates_max,
    ),
    count("laser.loops.side_keyframes", "keyframes beside a candidate in its map", (0, 100), |v| {
        &mut v.laser.loops.side_keyframes
    }),
    number("laser.loops.window_max_m", "greatest shift that is searched", (0.1, 50.0), |v| {
        &mut v.laser.loops.window_max_m
    }),
    degrees("laser.loops.window_max_deg", "greatest turn that is searched", (1.0, 180.0), |v| {
        &mut v.laser.loops.window_max_rad
    }),
    number("laser.loops.score_min_ratio", "mean likelihood that a match needs", (0.0, 1.0), |v| {
        &mut v.laser.loops.score_min_ratio
    }),
    number("laser.loops.inlier_min_ratio", "explained points that it needs", (0.0, 1.0), |v| {
        &mut v.laser.loops.inlier_min_ratio
    }),
    number("laser.loops.both_ways_m", "match there and back differ at most", (0.001, 5.0), |v| {
        &mut v.laser.loops.both_ways_m
    }),
    degrees(
        "laser.loops.both_ways_deg",
        "match there and back differ at most",
        (0.01, 45.0),
        |v| &mut v.laser.loops.both_ways_rad,
    ),
    number(
        "laser.loops.sure_std_m",
        "a guess less sure needs a second match",
        (0.01, 100.0),
        |v| &mut v.laser.loops.sure_std_m,
    ),
];

/// Every key, table by table.
pub(super) fn all() -> impl Iterator<Item = &'static Key> {
    let laser = LASER_POINTS.iter().chain(&LASER_REFINE).chain(&LASER_MOTION);
    let laser = laser.chain(&LASER_TRACKING).chain(&LASER_LOOPS);
    SURVEY.iter().chain(&MAP).chain(laser).chain(sonar::KEYS)
}

impl SurveyConfig {
    /// Every key, in the order of [`SurveyConfig::template`].
    pub fn keys() -> impl Iterator<Item = &'static Key> {
        all()
    }

    /// The value of a key as text; `None` if there is no such key.
    pub fn get(&self, name: &str) -> Option<String> {
        let value = all().find(|key| key.name == name)?.read(self.values());
        Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
    }

    /// The value of a key as TOML; `None` if there is no such key.
    pub fn get_value(&self, name: &str) -> Option<toml::Value> {
        all().find(|key| key.name == name).map(|key| key.read(self.values()))
    }

    /// The whole configuration as TOML. Reading it gives an equal one.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let mut table = "";
        for key in all() {
            if key.table() != table {
                table = key.table();
                let gap = if text.is_empty() { "" } else { "\n" };
                let _infallible = writeln!(text, "{gap}[{table}]");
            }
            let _infallible = writeln!(text, "{} = {}", key.short_name(), key.read(self.values()));
        }
        text
    }

    /// The default configuration as TOML with a sentence and the allowed values behind every key.
    pub fn template() -> String {
        let plain = Self::default().to_toml();
        let mut described = String::new();
        let mut keys = all();
        for line in plain.lines() {
            let key = if line.contains(" = ") { keys.next() } else { None };
            let said = key.map(|key| format!("# {}; {}", key.about, key.requirement()));
            let _infallible = match said {
                Some(said) => writeln!(described, "{line:<32} {said}"),
                None => writeln!(described, "{line}"),
            };
        }
        described
    }
}
