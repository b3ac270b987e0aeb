//! The list of keys.

use std::fmt::Write as _;

use super::{
    SurveyConfig,
    key::{Key, choice, count, degrees, number},
    method::{Method, Mode},
};
use crate::sonar::KEYS as SONAR;

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
    SURVEY.iter().chain(&MAP).chain(laser).chain(SONAR)
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
