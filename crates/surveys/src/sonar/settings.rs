//! What can be set about the sonar methods.

use continuous_localisation::{
    Distinctness, LocaliserConfig, Maturity, OdometryTrust, ReadingFilter, SearchLevel, WallTrust,
    classic::{ClassicConfig, ClassicSonar, Score, ShiftSearch, StmTurn, headings_deg},
};
use sensor_models::{ArcProfile, ConeModel};

use crate::config::Mode;

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
