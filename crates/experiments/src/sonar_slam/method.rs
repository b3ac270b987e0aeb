//! Ways to make a map and a trajectory of a recording, and what each is worth.

use continuous_localisation::{
    LocaliserConfig, Maturity, Score, SearchLevel, SonarRun,
    classic::{self, ClassicConfig, ClassicLog, ClassicRun},
    metrics::{self, MapAgreement},
    run, run_on, run_twice,
};
use figures::Picture;
use geometry::{Se2, Vec2, wrap_to_pi};
use grid_maps::{
    Cell, LogOddsMap,
    files::{ColourScheme, write_coloured_png},
    logodds_of,
};
use recordings::{Recording, Rig};
use slam::evaluate::Errors;

use super::room::{Room, at_true_poses, empty_map, stations};
use crate::ExperimentError;

/// Cells from here on count as occupied, as in the document.
const OCCUPIED_PROB: f64 = 0.7;
/// A short-term map with fewer valid readings has nothing to be recognised by.
const FEW_READINGS: usize = 12;
/// Ends of the distances from the way by which a map is judged, metres.
pub(super) const BANDS_M: [f64; 3] = [1.0, 2.0, f64::INFINITY];
/// Rows between two points of a drawn line: a quarter of a metre.
const ROWS_PER_POINT: usize = 12;

/// How a recording is mapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Method {
    /// Dead reckoning alone.
    Odometry,
    /// The same at true poses: what the sensor and the drawing allow at best.
    TruePoses,
    /// Cairn's default, as it runs on the robot.
    Localised,
    /// The same over the recording once more, with the drift known from the beginning.
    SecondLook,
    /// Cairn's default with a map from an earlier visit.
    PriorMap,
    /// Evidence of grids alone, ±1 cell and so many degrees to each side.
    Grids(usize),
    /// Cairn's default without its care for empty short-term maps, mature by this instead.
    Matured(Maturity),
    /// What the document describes: ±1 cell and so many degrees to each side.
    Thesis(u32, Maturity),
    /// The same, ±3°, with the score of the document's program.
    Program,
    /// The same, ±3°, with our own score.
    Evidence,
}

/// What the document describes, with short-term maps of 20 rows.
pub(super) const fn thesis(degrees: u32) -> Method {
    Method::Thesis(degrees, Maturity::Scans(20))
}

/// What a method makes of a recording.
pub(super) struct Estimate {
    /// One for each row.
    poses: Vec<Se2>,
    map: LogOddsMap,
    /// Valid readings of each short-term map.
    readings: Vec<usize>,
    /// Short-term maps after which the pose was changed.
    n_moved: usize,
}

/// What it is worth.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    /// Of the position.
    pub(super) rms_m: f64,
    /// Of the position, of the first to the last quarter of the drive.
    pub(super) quarters_m: [f64; 4],
    /// Along the robot's own direction, RMS.
    pub(super) along_m: f64,
    /// Across it, RMS.
    pub(super) across_m: f64,
    /// Of the heading, mean.
    pub(super) heading_rad: f64,
    /// Against what can be seen from the way.
    pub(super) exposed: MapAgreement,
    /// Against what can be heard from the way.
    pub(super) heard: MapAgreement,
    /// Precision of what lies so far from the way, by [`BANDS_M`]; `None` where nothing does.
    pub(super) bands: [Option<f64>; 3],
    /// Recall of the room's parts.
    pub(super) parts: Vec<f64>,
    /// Mean of the known cells.
    pub(super) entropy_bits: f64,
    /// Of the floor, and of the floor near the way, known to be free.
    pub(super) covered: [f64; 2],
    /// Short-term maps.
    pub(super) n_maps: usize,
    /// Those with few valid readings.
    pub(super) n_poor: usize,
    /// Those that changed the pose.
    pub(super) n_moved: usize,
    /// For figures.
    pub(super) kept: Option<Kept>,
}

/// What figures need of one run.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// The estimated way, metres.
    pub(super) line: Vec<Vec2>,
    /// The true way, metres.
    pub(super) truth: Vec<Vec2>,
    /// Time (s) and error (m).
    pub(super) errors: Vec<(f64, f64)>,
    /// The map.
    pub(super) picture: Option<Picture>,
}

impl Method {
    /// Whether the document's way of searching is used, which is slow.
    pub(super) fn is_described(self) -> bool {
        matches!(self, Self::Thesis(..) | Self::Program | Self::Evidence)
    }

    /// What tables call it.
    pub(super) fn label(self) -> String {
        match self {
            Self::Odometry => "odometry alone".to_owned(),
            Self::TruePoses => "at true poses".to_owned(),
            Self::Localised => "localised".to_owned(),
            Self::SecondLook => "localised, second look".to_owned(),
            Self::PriorMap => "localised, with a prior map".to_owned(),
            Self::Grids(degrees) => format!("evidence, ±{degrees}°"),
            Self::Matured(maturity) => format!("ours, {}", until(maturity)),
            Self::Thesis(degrees, Maturity::Scans(20)) => format!("document, ±{degrees}°"),
            Self::Thesis(_, maturity) => format!("document, {}", until(maturity)),
            Self::Program => "document, ±3°, its program's score".to_owned(),
            Self::Evidence => "document, ±3°, our score".to_owned(),
        }
    }

    /// Maps a recording.
    pub(super) fn estimate(
        self,
        recording: &Recording,
        room: &Room,
    ) -> Result<Estimate, ExperimentError> {
        let default = LocaliserConfig::default();
        let found = match self {
            Self::Odometry => run(recording, LocaliserConfig::odometry_only())?,
            Self::TruePoses => {
                let known = at_true_poses(recording, room.world_from_map);
                run(&known, LocaliserConfig::odometry_only())?
            }
            Self::Localised => run(recording, default)?,
            Self::SecondLook => run_twice(recording, default)?,
            Self::PriorMap => with_prior(recording, room)?,
            Self::Grids(degrees) => {
                let search = vec![SearchLevel::source(degrees)];
                run(
                    recording,
                    LocaliserConfig { search, walls: None, squareness: None, ..default },
                )?
            }
            Self::Matured(maturity) => {
                let life_max_m = 20.0;
                let config = LocaliserConfig { maturity, n_echoes_min: 0, life_max_m, ..default };
                run(recording, config)?
            }
            Self::Thesis(degrees, maturity) => {
                let headings_deg = classic::headings_deg(degrees);
                let config = ClassicConfig { headings_deg, maturity, ..ClassicConfig::thesis() };
                return as_described(recording, config);
            }
            Self::Evidence => {
                let score = Score::Evidence { n_cells_min: 100 };
                return as_described(recording, ClassicConfig { score, ..ClassicConfig::thesis() });
            }
            Self::Program => {
                let config = ClassicConfig { score: Score::WholeWindow, ..ClassicConfig::thesis() };
                return as_described(recording, config);
            }
        };
        Ok(Estimate::of(&found))
    }
}

fn until(maturity: Maturity) -> String {
    match maturity {
        Maturity::Readings(n) => format!("until {n} readings"),
        Maturity::Scans(n) => format!("until {n} scans"),
        Maturity::Seconds(s) => format!("until {s} s"),
        Maturity::Distance(m) => format!("until {m} m"),
    }
}

fn with_prior(recording: &Recording, room: &Room) -> Result<SonarRun, ExperimentError> {
    let Rig::Ring(ring) = &recording.rig else {
        return Err(continuous_localisation::RunError::NotARing.into());
    };
    let localiser = continuous_localisation::Localiser::new(ring, LocaliserConfig::default());
    let mut localiser = localiser.map_err(continuous_localisation::RunError::from)?;
    let (map, walls) = room.prior.clone();
    localiser.set_prior(map, walls);
    Ok(run_on(localiser, recording))
}

fn as_described(recording: &Recording, config: ClassicConfig) -> Result<Estimate, ExperimentError> {
    let (log, ring) = ClassicLog::from_recording(recording)?;
    let config = ClassicConfig { ring, ..config };
    let ClassicRun { world, steps, poses } = classic::run(&log, &config)?;
    let mut map = empty_map()?;
    // Counted from 1, and a cell's upper border belongs to it: the origin is the upper corner of the
    // robot's cell there.
    let [row_0, column_0] = config.cell_of_robot(0.0, 0.0);
    let (first_row, first_column, _, n_columns) = world.extent();
    for (row, probs) in (first_row..).zip(world.probs().chunks_exact(n_columns.max(1))) {
        for (column, &prob) in (first_column..).zip(probs) {
            // One half is what nobody looked at.
            if (prob - 0.5).abs() > 0.0 {
                let cell =
                    Cell { column: (row - row_0 - 1) as i32, row: (column - column_0 - 1) as i32 };
                map.set(cell, Some(logodds_of(prob.clamp(1e-9, 1.0 - 1e-9))));
            }
        }
    }
    let pose = |&[x_mm, y_mm, deg]: &[f64; 3]| Se2::new(x_mm / 1e3, y_mm / 1e3, deg.to_radians());
    Ok(Estimate {
        poses: poses.iter().map(pose).collect(),
        map,
        readings: steps.iter().map(|step| step.n_readings).collect(),
        n_moved: steps.iter().filter(|s| s.shift != [0, 0] || s.heading_deg != 0.0).count(),
    })
}

impl Estimate {
    fn of(found: &SonarRun) -> Self {
        Self {
            poses: found.online.iter().map(|online| online.pose).collect(),
            map: found.localiser.map().clone(),
            readings: found.registrations.iter().map(|r| r.collected.n_readings).collect(),
            n_moved: found.registrations.iter().filter(|r| r.outcome.is_applied()).count(),
        }
    }

    /// Short-term maps.
    pub(super) fn n_maps(&self) -> usize {
        self.readings.len()
    }

    /// Compares it with the truth.
    pub(super) fn judge(
        &self,
        recording: &Recording,
        room: &Room,
        is_kept: bool,
    ) -> Result<Judged, ExperimentError> {
        let map_from_world = room.world_from_map.inverse();
        let truth: Vec<Se2> =
            recording.truth.iter().map(|t| map_from_world.compose(t.pose)).collect();
        let errors = |rows: std::ops::Range<usize>| {
            let pair = |(e, t): (&Se2, &Se2)| {
                ((e.position() - t.position()).norm(), wrap_to_pi(e.yaw_rad - t.yaw_rad).abs())
            };
            let found = self.poses.iter().zip(&truth).skip(rows.start).take(rows.len());
            Errors::of(&found.map(pair).collect::<Vec<_>>())
        };
        let n = self.poses.len().min(truth.len());
        let quarter = |k: usize| errors(k * n / 4..(k + 1) * n / 4).rms_m;
        let whole = errors(0..n);
        let off = |axis: fn(Se2) -> f64| {
            let pairs = self.poses.iter().zip(&truth);
            let squares = pairs.map(|(e, t)| axis(t.inverse().compose(*e)).powi(2));
            (squares.sum::<f64>() / n.max(1) as f64).sqrt()
        };
        let against =
            |asked: &[Cell]| metrics::agreement(&self.map, OCCUPIED_PROB, asked, &room.truth.all);
        Ok(Judged {
            rms_m: whole.rms_m,
            quarters_m: [0, 1, 2, 3].map(quarter),
            along_m: off(|e| e.x_m),
            across_m: off(|e| e.y_m),
            heading_rad: whole.mean_rad,
            exposed: against(&room.truth.exposed),
            heard: against(&room.truth.heard),
            bands: self.bands(&truth, room)?,
            parts: room.truth.parts.iter().map(|(_, part)| against(part).recall_ratio).collect(),
            entropy_bits: self.map.entropy().mean_bits(),
            covered: [&room.truth.floor, &room.truth.near_floor].map(|floor| self.covered(floor)),
            n_maps: self.n_maps(),
            n_poor: self.readings.iter().filter(|&&n| n < FEW_READINGS).count(),
            n_moved: self.n_moved,
            kept: if is_kept { Some(self.keep(recording, &truth)?) } else { None },
        })
    }

    fn covered(&self, floor: &[Vec2]) -> f64 {
        let is_free = |p: &&Vec2| {
            self.map.logodds(self.map.lattice().cell_of(**p)).is_some_and(|logodds| logodds < 0.0)
        };
        floor.iter().filter(is_free).count() as f64 / floor.len().max(1) as f64
    }

    /// Precision by distance from the way; where the room has parts, elsewhere it is not asked.
    fn bands(&self, truth: &[Se2], room: &Room) -> Result<[Option<f64>; 3], ExperimentError> {
        let mut bands = [None; 3];
        if room.truth.parts.is_empty() {
            return Ok(bands);
        }
        let stations = stations(truth);
        let mut maps = [empty_map()?, empty_map()?, empty_map()?];
        let threshold = logodds_of(OCCUPIED_PROB);
        for (cell, _) in self.map.grid().known() {
            let Some(logodds) = self.map.logodds(cell).filter(|&l| l >= threshold) else {
                continue;
            };
            let centre = self.map.lattice().centre_of(cell);
            let far_m = stations.iter().map(|s| (s - centre).norm()).fold(f64::INFINITY, f64::min);
            if let Some(band) = BANDS_M.iter().position(|&end_m| far_m < end_m) {
                maps[band].set(cell, Some(logodds));
            }
        }
        for (band, map) in bands.iter_mut().zip(&maps) {
            let all = &room.truth.all;
            let found = metrics::agreement(map, OCCUPIED_PROB, all, all);
            *band = (found.n_occupied > 0).then_some(found.precision_ratio);
        }
        Ok(bands)
    }

    fn keep(&self, recording: &Recording, truth: &[Se2]) -> Result<Kept, ExperimentError> {
        let every = |poses: &[Se2]| -> Vec<Vec2> {
            poses.iter().step_by(ROWS_PER_POINT).map(|pose| pose.position()).collect()
        };
        let error = |((scan, e), t): ((&recordings::Scan, &Se2), &Se2)| {
            (scan.stamp.as_secs_f64(), (e.position() - t.position()).norm())
        };
        let rows = recording.scans.iter().zip(&self.poses).zip(truth);
        let picture = match self.map.bounds() {
            None => None,
            Some(area) => {
                let window = self.map.prob_window(area)?;
                let far = area.min.offset(area.width as i32, area.height as i32);
                Some(Picture {
                    png: write_coloured_png(&window, &ColourScheme::default())?,
                    low: self.map.lattice().corner_of(area.min),
                    high: self.map.lattice().corner_of(far),
                })
            }
        };
        Ok(Kept {
            line: every(&self.poses),
            truth: every(truth),
            errors: rows.map(error).step_by(ROWS_PER_POINT).collect(),
            picture,
        })
    }
}
