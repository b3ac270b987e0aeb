//! The keys of `[sonar]`.

use crate::config::key::{Key, choice, count, degrees, flag, number};

use super::settings::{MaturityUnit, ScoreKind};

const UNITS: [MaturityUnit; 4] =
    [MaturityUnit::Distance, MaturityUnit::Readings, MaturityUnit::Scans, MaturityUnit::Seconds];
const SCORES: [ScoreKind; 3] =
    [ScoreKind::Evidence, ScoreKind::CommonCells, ScoreKind::WholeWindow];

/// Every key of the sonar methods, table by table.
pub(crate) const KEYS: &[Key] = &[
    number("sonar.resolution_m", "side of a cell", (0.01, 0.5), |v| &mut v.sonar.resolution_m),
    flag("sonar.correct", "whether the pose is corrected at all", |v| &mut v.sonar.is_correcting),
    choice(
        "sonar.maturity",
        "what tells that a short-term map is compared: its way, echoes, rows or time",
        &["distance", "readings", "scans", "seconds"],
        |v| UNITS.iter().position(|u| *u == v.sonar.maturity.unit).unwrap_or(0),
        |v, i| v.sonar.maturity.unit = UNITS[i],
    ),
    number("sonar.maturity_distance_m", "with maturity = \"distance\"", (0.01, 100.0), |v| {
        &mut v.sonar.maturity.distance_m
    }),
    count("sonar.maturity_readings", "with maturity = \"readings\"", (1, 100_000), |v| {
        &mut v.sonar.maturity.n_readings
    }),
    count("sonar.maturity_scans", "with maturity = \"scans\"", (1, 100_000), |v| {
        &mut v.sonar.maturity.n_scans
    }),
    number("sonar.maturity_s", "with maturity = \"seconds\"", (0.01, 3600.0), |v| {
        &mut v.sonar.maturity.duration_s
    }),
    count("sonar.echoes_min", "a short-term map waits for so many echoes", (0, 10_000), |v| {
        &mut v.sonar.n_echoes_min
    }),
    number("sonar.life_max_m", "but not longer than this way", (0.1, 100.0), |v| {
        &mut v.sonar.life_max_m
    }),
    choice(
        "sonar.score",
        "what decides: correlation of evidence, mean difference of common cells, or the program's sum",
        &["evidence", "common_cells", "whole_window"],
        |v| SCORES.iter().position(|s| *s == v.sonar.score).unwrap_or(0),
        |v, i| v.sonar.score = SCORES[i],
    ),
    count("sonar.score_cells_min", "cells in common that a score needs", (0, 1_000_000), |v| {
        &mut v.sonar.n_cells_min
    }),
    count("sonar.search.shifts", "to each side, along x and y", (0, 50), |v| {
        &mut v.sonar.search.n_shifts
    }),
    number("sonar.search.shift_step_cells", "from one shift to the next", (0.1, 20.0), |v| {
        &mut v.sonar.search.shift_step_cells
    }),
    count("sonar.search.headings", "to each side; thesis and listing: degrees", (0, 45), |v| {
        &mut v.sonar.search.n_headings
    }),
    degrees("sonar.search.heading_step_deg", "from one heading to the next", (0.01, 20.0), |v| {
        &mut v.sonar.search.heading_step_rad
    }),
    number("sonar.distinct.rise_min_ratio", "rise of scores around the best", (0.0, 10.0), |v| {
        &mut v.sonar.distinct.rise_min_ratio
    }),
    number("sonar.distinct.score_max_ratio", "a worse best is no measurement", (0.0, 10.0), |v| {
        &mut v.sonar.distinct.score_max_ratio
    }),
    number("sonar.distinct.shift_std_m", "of a shift one cell steep", (0.0001, 10.0), |v| {
        &mut v.sonar.distinct.shift_std_m
    }),
    degrees("sonar.distinct.heading_std_deg", "of such a heading", (0.001, 90.0), |v| {
        &mut v.sonar.distinct.heading_std_rad
    }),
    degrees("sonar.cone.half_angle_deg", "half of the cone's opening", (0.6, 44.0), |v| {
        &mut v.sonar.cone.half_angle_rad
    }),
    number("sonar.cone.free_logodds", "what a cell before the sensor loses", (0.0, 20.0), |v| {
        &mut v.sonar.cone.free_logodds
    }),
    number("sonar.cone.free_range_m", "where that has fallen to nothing", (0.1, 20.0), |v| {
        &mut v.sonar.cone.free_range_m
    }),
    number("sonar.cone.occupied_logodds", "what a whole arc gains", (0.0, 20.0), |v| {
        &mut v.sonar.cone.occupied_logodds
    }),
    number("sonar.cone.occupied_range_m", "where that has fallen to nothing", (0.1, 20.0), |v| {
        &mut v.sonar.cone.occupied_range_m
    }),
    number("sonar.cone.whole_arc_m", "shorter arcs are not shared out", (0.001, 20.0), |v| {
        &mut v.sonar.cone.whole_arc_m
    }),
    number("sonar.cone.tolerance_m", "half of the arc's thickness", (0.001, 1.0), |v| {
        &mut v.sonar.cone.tolerance_m
    }),
    number("sonar.filter.standstill_m", "readings that moved less are dropped", (0.0, 1.0), |v| {
        &mut v.sonar.filter.standstill_m
    }),
    degrees("sonar.filter.standstill_deg", "and turned less", (0.0, 57.0), |v| {
        &mut v.sonar.filter.standstill_rad
    }),
    number("sonar.filter.silence_clears_m", "how far silence clears", (0.0, 20.0), |v| {
        &mut v.sonar.filter.silence_clears_m
    }),
    number("sonar.filter.wait_m", "unsupported echoes wait so long", (0.0, 100.0), |v| {
        &mut v.sonar.filter.wait_m
    }),
    number("sonar.filter.contradiction_logodds", "evidence that contradicts", (0.0, 20.0), |v| {
        &mut v.sonar.filter.contradiction_logodds
    }),
    degrees("sonar.odometry.heading_std_deg", "after one metre", (0.0001, 170.0), |v| {
        &mut v.sonar.odometry.heading_std_rad
    }),
    number("sonar.odometry.position_std_m", "after one metre", (0.000_001, 3.0), |v| {
        &mut v.sonar.odometry.position_std_m
    }),
    number("sonar.odometry.turn_std_ratio", "per radian turned", (0.0, 3.0), |v| {
        &mut v.sonar.odometry.turn_std_rad
    }),
    degrees("sonar.odometry.drift_std_deg", "systematic, per metre", (0.000_001, 170.0), |v| {
        &mut v.sonar.odometry.drift_std_radpm
    }),
    degrees("sonar.odometry.drift_walk_std_deg", "its change within a metre", (0.0, 170.0), |v| {
        &mut v.sonar.odometry.drift_walk_std_radpm
    }),
    flag("sonar.walls.use", "straight walls as landmarks", |v| &mut v.sonar.uses_walls),
    number("sonar.walls.length_min_m", "shorter pieces are no walls", (0.05, 10.0), |v| {
        &mut v.sonar.walls.length_min_m
    }),
    count("sonar.walls.echoes_min", "echoes that a wall needs", (2, 1000), |v| {
        &mut v.sonar.walls.n_echoes_min
    }),
    number("sonar.walls.straight_within_m", "deviation of its echoes", (0.001, 1.0), |v| {
        &mut v.sonar.walls.straight_within_m
    }),
    number("sonar.walls.goes_on_m", "beyond what was seen of it", (0.0, 10.0), |v| {
        &mut v.sonar.walls.goes_on_m
    }),
    number(
        "sonar.walls.gate_m",
        "a piece of wall from where it is predicted, at most",
        (0.001, 2.0),
        |v| &mut v.sonar.walls.gate_m,
    ),
    number(
        "sonar.walls.lone_gate_m",
        "a lone echo from where it is predicted, at most",
        (0.001, 2.0),
        |v| &mut v.sonar.walls.lone_gate_m,
    ),
    number("sonar.walls.range_std_m", "of an echo from a wall", (0.001, 1.0), |v| {
        &mut v.sonar.walls.range_std_m
    }),
    number("sonar.walls.range_max_m", "farther echoes are not used", (0.1, 20.0), |v| {
        &mut v.sonar.walls.range_max_m
    }),
    number("sonar.classic.pose_scale_m", "cell of the long-term map", (0.001, 1.0), |v| {
        &mut v.sonar.classic.pose_scale_m
    }),
    count("sonar.classic.world_cells", "rows and columns at first; even", (0, 4000), |v| {
        &mut v.sonar.classic.n_world_cells
    }),
    count("sonar.classic.margin_cells", "around a short-term map", (0, 500), |v| {
        &mut v.sonar.classic.n_margin_cells
    }),
    number("sonar.classic.valid_below_m", "readings that count as such", (0.01, 100.0), |v| {
        &mut v.sonar.classic.valid_below_m
    }),
    number("sonar.classic.used_below_m", "readings that are drawn", (0.01, 100.0), |v| {
        &mut v.sonar.classic.used_below_m
    }),
    degrees("sonar.classic.half_angle_deg", "half of the cone's opening", (0.1, 90.0), |v| {
        &mut v.sonar.classic.half_angle_rad
    }),
    number("sonar.classic.certain_range_m", "R of the profile", (0.035, 100.0), |v| {
        &mut v.sonar.classic.certain_range_m
    }),
    flag("sonar.classic.shifts", "whether shifts are really tried", |v| {
        &mut v.sonar.classic.tries_shifts
    }),
    flag("sonar.classic.turn_places", "a turn moves places, not headings only", |v| {
        &mut v.sonar.classic.turns_places
    }),
    number("sonar.classic.occupied_from_prob", "cells that count in the end", (0.5, 1.0), |v| {
        &mut v.sonar.classic.occupied_from_prob
    }),
];
