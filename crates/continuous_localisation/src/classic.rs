//! The source's continuous localisation, in its programmed and its printed form.
//!
//! Rows of readings are fused into a short-term map at odometry's poses until it is mature; the map
//! is laid on the long-term one at some headings and shifts; the best is where the robot is taken to
//! be, and there the short-term map is fused in. [`ClassicConfig::listing`] is the annex's program to
//! the last bit that matters, [`ClassicConfig::thesis`] what the text describes. Neither is what one
//! should use: both are for comparison, and the first for exactness.
//!
//! Everything here is in the source's own units (millimetres, degrees, cells counted from 1) because
//! the result depends on how numbers are rounded; [`ClassicLog::from_recording`] converts.
//!
//! Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială limitată",
//! MSc dissertation, Univ. Dunărea de Jos Galați, eq. (14) to (18), §2.4, §4.1, annex 8.2.
//! Differences: maps grow where the program would stop with an index error; candidates that repeat an
//! earlier one are not computed again, because the first of equals is chosen.

mod board;
mod log;
mod model;
mod score;
mod two_maps;

use sensor_models::{ArcProfile, bayes::fused_prob};

pub use board::{Board, BoardCounts};
pub use log::{ClassicError, ClassicLog};
pub use model::{ClassicSonar, LISTING_RING, LocalMap, ModelShape};
pub use score::Score;
pub use two_maps::TwoMaps;

use crate::maturity::{Collected, Maturity};
use score::Piece;

/// The nine shifts of a short-term map, in the source's order.
pub const NINE_SHIFTS: [[i64; 2]; 9] =
    [[0, 0], [-1, -1], [1, 1], [1, -1], [-1, 1], [0, -1], [0, 1], [-1, 0], [1, 0]];

/// All parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassicConfig {
    /// The ring; its first sonar has the first reading of a row.
    pub ring: Vec<ClassicSonar>,
    /// How a row of readings becomes a local map.
    pub shape: ModelShape,
    /// Side of a cell of the long-term map, by which poses are divided. In the program it differs
    /// from the model's (50 or 20 against 35): then maps are distorted.
    pub pose_scale_mm: f64,
    /// Rows and columns of the long-term map to begin with; even. Sets where the origin lies.
    pub n_world_cells: usize,
    /// Cells by which the window of a short-term map is larger than a local map, on each side.
    pub n_margin_cells: usize,
    /// When a short-term map is registered.
    pub maturity: Maturity,
    /// A reading counts for [`Maturity::Readings`] when it is below this.
    pub valid_below_mm: f64,
    /// Headings to be tried, in this order; the first should be 0.
    pub headings_deg: Vec<f64>,
    /// Shifts to be tried at each heading.
    pub shifts: ShiftSearch,
    /// What turning a short-term map turns.
    pub turn: StmTurn,
    /// What decides.
    pub score: Score,
    /// Cells from here on count as occupied in the end.
    pub occupied_from_prob: f64,
}

/// Which shifts are really tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShiftSearch {
    /// Every candidate takes the first, (0, 0): the program's digit one where a letter l was meant.
    DigitOne,
    /// All of [`NINE_SHIFTS`].
    All,
}

/// What turning a short-term map by a candidate's heading turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StmTurn {
    /// The heading of each scan, but not where it was taken: as programmed.
    Headings,
    /// Headings and places, about the first scan's place.
    Whole,
}

/// One short-term map and where it went.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassicStep {
    /// First row of the log that is in it, counted from 0.
    pub first_row: usize,
    /// Rows in it.
    pub n_rows: usize,
    /// Valid readings that were counted.
    pub n_readings: usize,
    /// Row and column of the long-term map before its first cell.
    pub position: [i64; 2],
    /// Chosen shift, cells.
    pub shift: [i64; 2],
    /// Chosen heading.
    pub heading_deg: f64,
    /// Score of every candidate, heading by heading and shift by shift; `None` where the overlap
    /// was too small.
    pub scores: Vec<Option<f64>>,
    /// Index of the chosen candidate; `None` when no candidate had enough overlap, and nothing was
    /// corrected.
    pub chosen: Option<usize>,
}

/// What a run over a log found.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassicRun {
    /// The long-term map.
    pub world: Board,
    /// Every short-term map in order.
    pub steps: Vec<ClassicStep>,
    /// Corrected poses, one for each row: x mm, y mm, heading degrees.
    pub poses: Vec<[f64; 3]>,
}

impl ClassicConfig {
    /// The annex's program: no search, 45 readings, its cone and range. Scale and world size were
    /// 50 and 800 in the hall, 20 and 600 in the room.
    pub fn listing(pose_scale_mm: f64, n_world_cells: usize) -> Self {
        Self {
            ring: LISTING_RING.to_vec(),
            shape: ModelShape::listing(),
            pose_scale_mm,
            n_world_cells,
            n_margin_cells: 5,
            maturity: Maturity::Readings(45),
            valid_below_mm: 6000.0,
            headings_deg: vec![0.0; 7],
            shifts: ShiftSearch::DigitOne,
            turn: StmTurn::Headings,
            score: Score::WholeWindow,
            occupied_from_prob: 0.7,
        }
    }

    /// What the text describes: ±1 cell and ±3° (63 candidates), equation (18) over common cells,
    /// 35 mm throughout; short-term maps of 20 scans, and a range that fits.
    pub fn thesis() -> Self {
        Self {
            shape: ModelShape { profile: ArcProfile::fixed(), ..ModelShape::listing() },
            n_margin_cells: 60,
            maturity: Maturity::Scans(20),
            headings_deg: headings_deg(3),
            shifts: ShiftSearch::All,
            turn: StmTurn::Whole,
            score: Score::CommonCells { n_cells_min: 100 },
            ..Self::listing(35.0, 800)
        }
    }

    /// Candidates for one short-term map.
    pub fn n_candidates(&self) -> usize {
        self.headings_deg.len() * NINE_SHIFTS.len()
    }

    /// Row and column (from 1) of the long-term map in which the robot is at a pose; a cell's
    /// upper border belongs to it.
    pub fn cell_of_robot(&self, x_mm: f64, y_mm: f64) -> [i64; 2] {
        let half = (self.shape.n_cells / 2) as i64;
        self.position(x_mm, y_mm, 0).map(|first| first + half)
    }

    /// Row and column before the first cell of a local map at a pose.
    fn position(&self, x_mm: f64, y_mm: f64, margin: i64) -> [i64; 2] {
        let half = (self.n_world_cells / 2) as f64;
        [x_mm, y_mm].map(|mm| (mm / self.pose_scale_mm + half - 40.0).ceil() as i64 - margin)
    }
}

/// 0, then 1, -1, 2, -2 … degrees up to the given one: the source's ±1, ±3 and ±6.
pub fn headings_deg(max_deg: u32) -> Vec<f64> {
    let both = (1..=max_deg).flat_map(|deg| [f64::from(deg), -f64::from(deg)]);
    std::iter::once(0.0).chain(both).collect()
}

/// Runs over a whole log. O(rows × (headings × cone cells + candidates × window cells)).
///
/// # Errors
///
/// [`ClassicError`] when a row is too short for the ring or holds a number that is not finite, or
/// when poses lead so far away that the map would become too large.
pub fn run(log: &ClassicLog, config: &ClassicConfig) -> Result<ClassicRun, ClassicError> {
    log.check(config)?;
    let mut run = Run::new(log, config);
    let mut first = 0;
    // The program's rows begin at 1, and it uses the row after the one that it counts.
    while first + 1 < log.n_rows() {
        let collected = run.collect(first);
        run.register(first, collected)?;
        first += collected.n_scans;
    }
    Ok(ClassicRun { world: run.world, steps: run.steps, poses: run.poses })
}

struct Run<'a> {
    log: &'a ClassicLog,
    config: &'a ClassicConfig,
    poses: Vec<[f64; 3]>,
    world: Board,
    steps: Vec<ClassicStep>,
    local: LocalMap,
    window: Window,
    best_window: Window,
}

/// The square in which a short-term map is drawn.
#[derive(Clone)]
struct Window {
    first: [i64; 2],
    n_cells: usize,
    probs: Vec<f64>,
}

impl<'a> Run<'a> {
    fn new(log: &'a ClassicLog, config: &'a ClassicConfig) -> Self {
        let n_cells = config.shape.n_cells + 2 * config.n_margin_cells;
        let window = Window { first: [0, 0], n_cells, probs: vec![0.5; n_cells * n_cells] };
        Self {
            log,
            config,
            poses: log.poses.clone(),
            world: Board::square(config.n_world_cells),
            steps: Vec::new(),
            local: LocalMap::new(config.shape.n_cells),
            best_window: window.clone(),
            window,
        }
    }

    /// Rows from `first` on until they are enough, at least one and not the last of the log.
    fn collect(&self, first: usize) -> Collected {
        let mut collected = Collected::default();
        while first + collected.n_scans + 1 < self.log.n_rows() {
            let row = first + collected.n_scans;
            let readings = self.log.readings_mm(row);
            collected.n_readings +=
                readings.iter().filter(|&&mm| mm < self.config.valid_below_mm).count();
            collected.n_scans += 1;
            collected.duration_s = self.log.period_s * (collected.n_scans - 1) as f64;
            if collected.n_scans > 1 {
                let [from, to] = [self.poses[row - 1], self.poses[row]];
                collected.distance_m += (to[0] - from[0]).hypot(to[1] - from[1]) * 1e-3;
            }
            if self.config.maturity.is_reached(&collected) {
                break;
            }
        }
        collected
    }

    fn register(&mut self, first: usize, collected: Collected) -> Result<(), ClassicError> {
        let config = self.config;
        let start = first + 1;
        let [x, y, _] = self.poses[start];
        let position = config.position(x, y, config.n_margin_cells as i64);
        let too_far = ClassicError::TooFar { row: start + 1, x_mm: x, y_mm: y };
        let n_reach = self.window.n_cells + 2;
        if !self.world.reach(position[0], position[1], n_reach) {
            return Err(too_far);
        }

        let mut scores = Vec::with_capacity(config.n_candidates());
        let mut best: Option<(usize, f64)> = None;
        for (turn, &heading_deg) in config.headings_deg.iter().enumerate() {
            if let Some(same) = self.earlier_heading(turn) {
                let from = same * NINE_SHIFTS.len();
                scores.extend_from_within(from..from + NINE_SHIFTS.len());
                continue;
            }
            self.draw(start, collected.n_scans, heading_deg, position);
            let before = best;
            for shift in NINE_SHIFTS {
                let index = scores.len();
                let repeated =
                    config.shifts == ShiftSearch::DigitOne && index % NINE_SHIFTS.len() > 0;
                let score = if repeated { scores[index - 1] } else { self.score(position, shift) };
                if let Some(score) = score
                    && best.is_none_or(|(_, least)| score < least)
                {
                    best = Some((index, score));
                }
                scores.push(score);
            }
            // The zero pose is kept for the case that nothing overlaps.
            if best != before || turn == 0 {
                std::mem::swap(&mut self.window, &mut self.best_window);
            }
        }

        let chosen = best.map(|(index, _)| index);
        let index = chosen.unwrap_or(0);
        let heading_deg =
            config.headings_deg.get(index / NINE_SHIFTS.len()).copied().unwrap_or(0.0);
        let shift = match config.shifts {
            ShiftSearch::DigitOne => NINE_SHIFTS[0],
            ShiftSearch::All => NINE_SHIFTS[index % NINE_SHIFTS.len()],
        };
        let position = [position[0] + shift[0], position[1] + shift[1]];
        self.fuse_best(position);
        self.correct(start, collected.n_scans, shift, heading_deg);
        self.steps.push(ClassicStep {
            first_row: start,
            n_rows: collected.n_scans,
            n_readings: collected.n_readings,
            position,
            shift,
            heading_deg,
            scores,
            chosen,
        });
        Ok(())
    }

    /// The index of an equal heading before this one.
    fn earlier_heading(&self, turn: usize) -> Option<usize> {
        let headings = &self.config.headings_deg;
        headings[..turn].iter().position(|h| h.to_bits() == headings[turn].to_bits())
    }

    /// Draws the short-term map of `n` rows from `start` on, turned by `heading_deg`.
    fn draw(&mut self, start: usize, n: usize, heading_deg: f64, first: [i64; 2]) {
        let config = self.config;
        self.window.first = first;
        self.window.probs.fill(0.5);
        let pivot = self.poses[start];
        for row in start..start + n {
            let [mut x, mut y, heading] = self.poses[row];
            if config.turn == StmTurn::Whole {
                [x, y] = turned_about(pivot, [x, y], heading_deg);
            }
            let readings = self.log.readings_mm(row);
            self.local.fill(&config.shape, &config.ring, readings, heading + heading_deg);
            self.window.fuse(&self.local, config.shape.n_cells, config.position(x, y, 0));
        }
    }

    fn score(&self, position: [i64; 2], shift: [i64; 2]) -> Option<f64> {
        let at = [position[0] + shift[0], position[1] + shift[1]];
        let piece = Piece { probs: &self.window.probs, n_cells: self.window.n_cells };
        self.config.score.of(&self.world, piece, at)
    }

    fn fuse_best(&mut self, position: [i64; 2]) {
        let Window { n_cells, probs, .. } = &self.best_window;
        for (row, ours) in probs.chunks_exact(*n_cells).enumerate() {
            let theirs =
                self.world.row_mut(position[0] + 1 + row as i64, position[1] + 1, *n_cells);
            for (world, &stm) in theirs.iter_mut().zip(ours) {
                *world = fused_prob(*world, stm);
            }
        }
    }

    /// Moves the rest of the log as the best candidate was moved.
    fn correct(&mut self, start: usize, n: usize, shift: [i64; 2], heading_deg: f64) {
        let pivot = self.poses[start];
        let scale_mm = self.config.pose_scale_mm;
        // The last row of this map is the first of the rest: the program's counting again.
        for row in start + n - 1..self.poses.len() {
            let [x, y, heading] = self.poses[row];
            let [x, y] = turned_about(pivot, [x, y], heading_deg);
            self.poses[row] = [
                x + scale_mm * shift[0] as f64,
                y + scale_mm * shift[1] as f64,
                heading + heading_deg,
            ];
        }
    }
}

impl Window {
    /// Fuses what is known in a local map whose first cell lies behind `at`; cells outside the
    /// window are lost.
    fn fuse(&mut self, local: &LocalMap, n_local: usize, at: [i64; 2]) {
        let [row_0, column_0] = [at[0] - self.first[0], at[1] - self.first[1]];
        let n = self.n_cells as i64;
        for row in 0..n_local {
            let to_row = row_0 + row as i64;
            if !(0..n).contains(&to_row) {
                continue;
            }
            let cells = &mut self.probs[to_row as usize * self.n_cells..][..self.n_cells];
            for (column, &model) in local.row(row).iter().enumerate() {
                let to_column = column_0 + column as i64;
                if !model.is_nan() && (0..n).contains(&to_column) {
                    let cell = &mut cells[to_column as usize];
                    *cell = fused_prob(*cell, model);
                }
            }
        }
    }
}

fn turned_about(pivot: [f64; 3], [x, y]: [f64; 2], turn_deg: f64) -> [f64; 2] {
    if turn_deg == 0.0 {
        return [x, y];
    }
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let [dx, dy] = [x - pivot[0], y - pivot[1]];
    [pivot[0] + cos * dx - sin * dy, pivot[1] + sin * dx + cos * dy]
}

#[cfg(test)]
mod tests;
