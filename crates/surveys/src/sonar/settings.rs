//! What can be set about the sonar methods.

use continuous_localisation::{
    Distinctness, LocaliserConfig, Maturity, OdometryTrust, ReadingFilter, SearchLevel, WallTrust,
    classic::{ClassicConfig, ClassicSonar, Score, ShiftSearch, StmTurn, headings_deg},
};
use sensor_models::{ArcProfile, ConeModel};

use crate::config::{
    Mode,
    keys::{Key, choice, count, degrees, flag, number},
};

/// Everything about the sonar methods.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SonarSettings {
    pub(crate) resolution_m: f64,
    pub(crate) maturity: MaturitySettings,
    pub(crate) n_echoes_min: usize,
    pub(crate) life_max_m: f64,
    pub(crate) is_correcting: bool,
    pub(crate) search: SearchLevel,
    pub(crate) score: ScoreKind,
    pub(crate) n_cells_min: usize,
    pub(crate) distinct: Distinctness,
    pub(crate) cone: ConeModel,
    pub(crate) filter: ReadingFilter,
    pub(crate) odometry: OdometryTrust,
    pub(crate) uses_walls: bool,
    pub(crate) walls: WallTrust,
    pub(crate) classic: ClassicSettings,
}

/// When a short-term map is compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaturitySettings {
    pub(crate) unit: MaturityUnit,
    pub(crate) n_readings: usize,
    pub(crate) n_scans: usize,
    pub(crate) duration_s: f64,
    pub(crate) distance_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaturityUnit {
    Distance,
    Readings,
    Scans,
    Seconds,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScoreKind {
    Evidence,
    CommonCells,
    WholeWindow,
}

/// What only the thesis's method and its program have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClassicSettings {
    pub(crate) pose_scale_m: f64,
    pub(crate) n_world_cells: usize,
    pub(crate) n_margin_cells: usize,
    pub(crate) valid_below_m: f64,
    pub(crate) used_below_m: f64,
    pub(crate) half_angle_rad: f64,
    pub(crate) certain_range_m: f64,
    pub(crate) tries_shifts: bool,
    pub(crate) turns_places: bool,
    pub(crate) occupied_from_prob: f64,
}

impl SonarSettings {
    /// What a mode begins with.
    pub(crate) fn of(mode: Mode) -> Self {
        match mode {
            Mode::Default | Mode::Graph => Self::ours(),
            // The hall's values of the program; the thesis's text where it differs.
            Mode::Listing => Self::source(&ClassicConfig::listing(50.0, 800)),
            Mode::Thesis => Self::source(&ClassicConfig::thesis()),
        }
    }

    fn ours() -> Self {
        let ours = LocaliserConfig::default();
        let thesis = ClassicConfig::thesis();
        let n_cells_min = match ours.score {
            Score::Evidence { n_cells_min } | Score::CommonCells { n_cells_min } => n_cells_min,
            Score::WholeWindow => 0,
        };
        let mut maturity = MaturitySettings {
            unit: MaturityUnit::Distance,
            n_readings: 45,
            n_scans: 20,
            duration_s: 5.0,
            distance_m: 0.5,
        };
        maturity.take(ours.maturity);
        Self {
            resolution_m: ours.resolution_m,
            maturity,
            n_echoes_min: ours.n_echoes_min,
            life_max_m: ours.life_max_m,
            is_correcting: ours.is_correcting,
            search: ours.search.first().copied().unwrap_or_else(|| SearchLevel::source(3)),
            score: score_kind(ours.score),
            n_cells_min,
            distinct: ours.distinct,
            cone: ours.cone,
            filter: ours.filter,
            odometry: ours.odometry,
            uses_walls: ours.walls.is_some(),
            walls: ours.walls.unwrap_or_default(),
            classic: ClassicSettings::of(&thesis),
        }
    }

    /// The values of one of the source's forms; what it does not have stays ours.
    fn source(config: &ClassicConfig) -> Self {
        let ours = Self::ours();
        let mut maturity = ours.maturity;
        maturity.take(config.maturity);
        let n_cells_min = match config.score {
            Score::CommonCells { n_cells_min } | Score::Evidence { n_cells_min } => n_cells_min,
            Score::WholeWindow => ours.n_cells_min,
        };
        let most_deg = config.headings_deg.iter().fold(0.0_f64, |most, deg| most.max(*deg));
        Self {
            maturity,
            search: SearchLevel::source(most_deg.round() as usize),
            score: score_kind(config.score),
            n_cells_min,
            classic: ClassicSettings::of(config),
            ..ours
        }
    }

    /// For our own method.
    pub(crate) fn localiser(&self) -> LocaliserConfig {
        LocaliserConfig {
            resolution_m: self.resolution_m,
            maturity: self.maturity.value(),
            n_echoes_min: self.n_echoes_min,
            life_max_m: self.life_max_m,
            cone: self.cone,
            filter: self.filter,
            odometry: self.odometry,
            search: vec![self.search],
            score: self.score(),
            distinct: self.distinct,
            walls: self.uses_walls.then_some(self.walls),
            is_correcting: self.is_correcting,
            ..LocaliserConfig::default()
        }
    }

    /// For the source's method, in its own units.
    pub(crate) fn classic(&self, ring: Vec<ClassicSonar>) -> ClassicConfig {
        let classic = &self.classic;
        let listing = ClassicConfig::listing(mm(classic.pose_scale_m), classic.n_world_cells);
        let mut shape = listing.shape;
        shape.reading_below_mm = mm(classic.used_below_m);
        shape.half_angle_deg = tidy(classic.half_angle_rad.to_degrees());
        shape.profile = profile(shape.profile, mm(classic.certain_range_m) / shape.scale_mm);
        ClassicConfig {
            ring,
            shape,
            n_margin_cells: classic.n_margin_cells,
            maturity: self.maturity.value(),
            valid_below_mm: mm(classic.valid_below_m),
            // Whole degrees, as in the source.
            headings_deg: headings_deg(self.search.n_headings as u32),
            shifts: if classic.tries_shifts { ShiftSearch::All } else { ShiftSearch::DigitOne },
            turn: if classic.turns_places { StmTurn::Whole } else { StmTurn::Headings },
            score: self.score(),
            occupied_from_prob: classic.occupied_from_prob,
            ..listing
        }
    }

    fn score(&self) -> Score {
        let n_cells_min = self.n_cells_min;
        match self.score {
            ScoreKind::Evidence => Score::Evidence { n_cells_min },
            ScoreKind::CommonCells => Score::CommonCells { n_cells_min },
            ScoreKind::WholeWindow => Score::WholeWindow,
        }
    }
}

impl Default for SonarSettings {
    fn default() -> Self {
        Self::ours()
    }
}

impl MaturitySettings {
    fn take(&mut self, maturity: Maturity) {
        match maturity {
            Maturity::Distance(m) => (self.unit, self.distance_m) = (MaturityUnit::Distance, m),
            Maturity::Readings(n) => (self.unit, self.n_readings) = (MaturityUnit::Readings, n),
            Maturity::Scans(n) => (self.unit, self.n_scans) = (MaturityUnit::Scans, n),
            Maturity::Seconds(s) => (self.unit, self.duration_s) = (MaturityUnit::Seconds, s),
        }
    }

    fn value(&self) -> Maturity {
        match self.unit {
            MaturityUnit::Distance => Maturity::Distance(self.distance_m),
            MaturityUnit::Readings => Maturity::Readings(self.n_readings),
            MaturityUnit::Scans => Maturity::Scans(self.n_scans),
            MaturityUnit::Seconds => Maturity::Seconds(self.duration_s),
        }
    }
}

impl ClassicSettings {
    fn of(config: &ClassicConfig) -> Self {
        Self {
            pose_scale_m: config.pose_scale_mm / 1e3,
            n_world_cells: config.n_world_cells,
            n_margin_cells: config.n_margin_cells,
            valid_below_m: config.valid_below_mm / 1e3,
            used_below_m: config.shape.reading_below_mm / 1e3,
            half_angle_rad: config.shape.half_angle_deg.to_radians(),
            certain_range_m: config.shape.profile.certain_range_cells * config.shape.scale_mm / 1e3,
            tries_shifts: config.shifts == ShiftSearch::All,
            turns_places: config.turn == StmTurn::Whole,
            occupied_from_prob: config.occupied_from_prob,
        }
    }
}

fn score_kind(score: Score) -> ScoreKind {
    match score {
        Score::Evidence { .. } => ScoreKind::Evidence,
        Score::CommonCells { .. } => ScoreKind::CommonCells,
        Score::WholeWindow => ScoreKind::WholeWindow,
    }
}

/// The source's profile with another range; a range that is one of its own keeps its bits.
fn profile(listing: ArcProfile, certain_range_cells: f64) -> ArcProfile {
    let own = [listing, ArcProfile::fixed()];
    let near = own.iter().find(|p| (p.certain_range_cells - certain_range_cells).abs() < 1e-9);
    near.copied().unwrap_or(ArcProfile { certain_range_cells, ..listing })
}

/// Millimetres, without the last digits of a conversion.
fn mm(m: f64) -> f64 {
    tidy(m * 1e3)
}

fn tidy(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

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
