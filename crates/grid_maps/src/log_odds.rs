//! Occupancy as evidence that adds up: log-odds in tiles, unknown until touched.

use std::ops::Range;

use geometry::{Se2, Vec2};

use crate::{Cell, CellBox, Lattice, MapError, TileGrid, Window};

/// What is known about a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    /// Never observed, or observed without a verdict.
    Unknown,
    /// Probably empty.
    Free,
    /// Probably an obstacle.
    Occupied,
}

/// Where verdicts begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Cells above it are occupied; from 0.5 to 1.
    pub occupied_prob: f64,
    /// Cells below it are free; from 0 to 0.5.
    pub free_prob: f64,
}

/// How much one observation says, and how much all of them may say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvidenceModel {
    /// Added to a cell where a beam ended; above 0.
    pub hit_logodds: f64,
    /// Added to a cell that a beam passed; below 0.
    pub miss_logodds: f64,
    /// No cell gets more certainly free; from −31 to below 0.
    pub min_logodds: f64,
    /// No cell gets more certainly occupied; above 0, up to 31.
    pub max_logodds: f64,
}

/// Uncertainty of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entropy {
    /// Sum of −p log₂ p − (1−p) log₂ (1−p) over the known cells.
    pub sum_bits: f64,
    /// Cells that were observed.
    pub n_known: usize,
}

/// An occupancy map that grows wherever it is written.
///
/// A cell takes two bytes: its log-odds in steps of 1/1024 (0.001), or a mark for "never
/// observed". Whoever only reads may work on the raw steps of [`grid`](Self::grid) and
/// [`STEPS_PER_LOGODDS`].
///
/// Source: Moravec and Elfes (1985), "High resolution maps from wide angle sonar", ICRA, for the
/// grid; Thrun, Burgard and Fox (2005), "Probabilistic Robotics", table 9.1, for the sum.
#[derive(Clone, Debug)]
pub struct LogOddsMap {
    lattice: Lattice,
    model: EvidenceModel,
    steps: Steps,
    grid: TileGrid<i16>,
}

/// [`EvidenceModel`] in steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    pub(crate) hit: i16,
    pub(crate) miss: i16,
    min: i16,
    max: i16,
}

/// Steps of the stored numbers in one unit of log-odds.
pub const STEPS_PER_LOGODDS: f64 = 1024.0;

/// The stored number of a cell that was never observed.
pub const UNKNOWN_STEP: i16 = i16::MIN;

/// Largest magnitude of evidence that a cell can hold.
const LOGODDS_LIMIT: f64 = 31.0;

/// Log-odds of a probability in (0, 1): ln(p / (1 − p)).
pub fn logodds_of(prob: f64) -> f64 {
    (prob / (1.0 - prob)).ln()
}

/// The probability that belongs to log-odds: 1 / (1 + e^(−l)).
pub fn prob_of(logodds: f64) -> f64 {
    1.0 / (1.0 + (-logodds).exp())
}

/// Entropy of a cell that is occupied with `prob`, bits; 0 at 0 and 1, 1 at one half.
pub fn entropy_bits(prob: f64) -> f64 {
    let term = |p: f64| if p > 0.0 { -p * p.log2() } else { 0.0 };
    term(prob) + term(1.0 - prob)
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { occupied_prob: 0.65, free_prob: 0.35 }
    }
}

impl Thresholds {
    /// The verdict on a probability; no verdict on what is not a number.
    pub fn state_of(&self, prob: f64) -> State {
        if prob > self.occupied_prob {
            State::Occupied
        } else if prob < self.free_prob {
            State::Free
        } else {
            State::Unknown
        }
    }
}

impl Default for EvidenceModel {
    /// A hit is p = 0.70, a miss p = 0.40, and certainty ends at p = 0.018 and 0.982: ten hits and
    /// ten misses.
    fn default() -> Self {
        Self { hit_logodds: 0.85, miss_logodds: -0.4, min_logodds: -4.0, max_logodds: 4.0 }
    }
}

impl EvidenceModel {
    fn steps(&self) -> Result<Steps, MapError> {
        let Self { hit_logodds, miss_logodds, min_logodds, max_logodds } = *self;
        let checked = |key, value: f64, positive: bool| {
            let size = if positive { value } else { -value };
            let requirement = if positive { "above 0, up to 31" } else { "from -31 to below 0" };
            if size > 0.0 && size <= LOGODDS_LIMIT {
                Ok(step_of(value))
            } else {
                Err(MapError::Setting { key, value, requirement })
            }
        };
        Ok(Steps {
            hit: checked("hit_logodds", hit_logodds, true)?,
            miss: checked("miss_logodds", miss_logodds, false)?,
            min: checked("min_logodds", min_logodds, false)?,
            max: checked("max_logodds", max_logodds, true)?,
        })
    }
}

impl Entropy {
    /// Bits of an average known cell; 0 for an empty map.
    pub fn mean_bits(&self) -> f64 {
        if self.n_known == 0 { 0.0 } else { self.sum_bits / self.n_known as f64 }
    }
}

impl LogOddsMap {
    /// A map in which nothing was observed.
    ///
    /// # Errors
    ///
    /// [`MapError::Setting`] for weights of the wrong sign, beyond ±31 or not finite.
    pub fn new(lattice: Lattice, model: EvidenceModel) -> Result<Self, MapError> {
        let steps = model.steps()?;
        Ok(Self { lattice, model, steps, grid: TileGrid::new(UNKNOWN_STEP) })
    }

    /// Where its cells lie.
    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// How its evidence is weighed.
    pub const fn model(&self) -> &EvidenceModel {
        &self.model
    }

    /// The stored steps; [`UNKNOWN_STEP`] where nothing was observed.
    pub const fn grid(&self) -> &TileGrid<i16> {
        &self.grid
    }

    /// Log-odds of a cell, or `None` when it was never observed.
    pub fn logodds(&self, cell: Cell) -> Option<f64> {
        let step = self.grid.get(cell);
        (step != UNKNOWN_STEP).then(|| f64::from(step) / STEPS_PER_LOGODDS)
    }

    /// Probability that a cell is occupied, or `None` when it was never observed.
    pub fn prob(&self, cell: Cell) -> Option<f64> {
        self.logodds(cell).map(prob_of)
    }

    /// The verdict on a cell.
    pub fn state(&self, cell: Cell, thresholds: &Thresholds) -> State {
        self.prob(cell).map_or(State::Unknown, |prob| thresholds.state_of(prob))
    }

    /// Counts a beam that ended in `cell`.
    pub fn add_hit(&mut self, cell: Cell) {
        let step = self.steps.hit;
        self.add_step(cell, step);
    }

    /// Counts a beam that passed through `cell`.
    pub fn add_miss(&mut self, cell: Cell) {
        let step = self.steps.miss;
        self.add_step(cell, step);
    }

    /// Adds evidence to a cell; what is not a number adds nothing but makes the cell known.
    pub fn add(&mut self, cell: Cell, logodds: f64) {
        self.add_step(cell, step_of(logodds));
    }

    /// Writes the log-odds of a cell, or makes it unknown again.
    pub fn set(&mut self, cell: Cell, logodds: Option<f64>) {
        let Steps { min, max, .. } = self.steps;
        let step = logodds.map_or(UNKNOWN_STEP, |logodds| step_of(logodds).max(min).min(max));
        self.grid.set(cell, step);
    }

    /// The smallest rectangle around all observed cells. Looks at every tile.
    pub fn bounds(&self) -> Option<CellBox> {
        self.grid.bounds()
    }

    /// Log-odds of the cells of `area`, NaN where nothing was observed.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn logodds_window(&self, area: CellBox) -> Result<Window<f32>, MapError> {
        let logodds = |step: i16| match step {
            UNKNOWN_STEP => f32::NAN,
            _ => f32::from(step) / STEPS_PER_LOGODDS as f32,
        };
        Ok(self.grid.crop(area)?.map(logodds))
    }

    /// Probabilities of the cells of `area`, NaN where nothing was observed.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn prob_window(&self, area: CellBox) -> Result<Window<f64>, MapError> {
        let prob = |step: i16| match step {
            UNKNOWN_STEP => f64::NAN,
            _ => prob_of(f64::from(step) / STEPS_PER_LOGODDS),
        };
        Ok(self.grid.crop(area)?.map(prob))
    }

    /// Verdicts on the cells of `area`.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn state_window(
        &self,
        area: CellBox,
        thresholds: &Thresholds,
    ) -> Result<Window<State>, MapError> {
        let state = |step: i16| match step {
            UNKNOWN_STEP => State::Unknown,
            _ => thresholds.state_of(prob_of(f64::from(step) / STEPS_PER_LOGODDS)),
        };
        Ok(self.grid.crop(area)?.map(state))
    }

    /// Uncertainty of the observed cells. O(cells of the tiles).
    pub fn entropy(&self) -> Entropy {
        // Cells that are equally sure are counted together: one logarithm for each value, and a
        // sum that does not depend on the order of the tiles.
        let mut counts = vec![0_usize; 1 << 16];
        for tile in self.grid.tiles() {
            for &step in tile.values {
                counts[usize::from(step as u16)] += 1;
            }
        }
        let mut entropy = Entropy { sum_bits: 0.0, n_known: 0 };
        for step in UNKNOWN_STEP + 1..=i16::MAX {
            let n = counts[usize::from(step as u16)];
            if n > 0 {
                entropy.n_known += n;
                let prob = prob_of(f64::from(step) / STEPS_PER_LOGODDS);
                entropy.sum_bits += n as f64 * entropy_bits(prob);
            }
        }
        entropy
    }

    /// Adds the evidence of `other`, whose cells lie `shift` columns and rows further here.
    ///
    /// For maps of the same resolution. O(cells of the other's tiles).
    pub fn merge(&mut self, other: &Self, shift: Cell) {
        for (cell, step) in other.grid.known() {
            self.add_step(cell.offset(shift.column, shift.row), step);
        }
    }

    /// Adds the evidence of `other`, whose frame lies at `map_from_other` in the frame of this map.
    ///
    /// Each cell here takes what lies at its centre there, so none is left out or counted twice.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`] when the other map does not fit a window.
    pub fn merge_at(&mut self, other: &Self, map_from_other: Se2) -> Result<(), MapError> {
        let Some(bounds) = other.bounds() else { return Ok(()) };
        let there = other.grid.crop(bounds)?;
        let area = self.area_of(other, bounds, map_from_other);
        Window::<i16>::checked(area)?;
        let other_from_map = map_from_other.inverse();
        for cell in area.cells() {
            let centre = other_from_map.transform_point(self.lattice.centre_of(cell));
            match there.get(other.lattice.cell_of(centre)) {
                None | Some(UNKNOWN_STEP) => {}
                Some(step) => self.add_step(cell, step),
            }
        }
        Ok(())
    }

    /// Forgets everything but keeps the memory for the next use at the same place.
    pub fn clear(&mut self) {
        self.grid.clear();
    }

    /// Memory held, bytes.
    pub fn memory_bytes(&self) -> usize {
        self.grid.memory_bytes()
    }

    pub(crate) const fn steps(&self) -> Steps {
        self.steps
    }

    pub(crate) const fn grid_mut(&mut self) -> &mut TileGrid<i16> {
        &mut self.grid
    }

    /// Adds a step to the cells of a row.
    pub(crate) fn add_step_to_span(&mut self, row: i32, columns: Range<i32>, step: i16) {
        let steps = self.steps;
        self.grid.change_span(row, columns, |cells| {
            for cell in cells {
                *cell = steps.sum(*cell, step);
            }
        });
    }

    pub(crate) fn add_step(&mut self, cell: Cell, step: i16) {
        let steps = self.steps;
        let value = self.grid.value_mut(cell);
        *value = steps.sum(*value, step);
    }

    /// The cells that `bounds` of `other` may touch here.
    fn area_of(&self, other: &Self, bounds: CellBox, map_from_other: Se2) -> CellBox {
        let low = other.lattice.corner_of(bounds.min);
        let high =
            low + Vec2::new(bounds.width as f64, bounds.height as f64) * other.lattice.resolution_m;
        let corners = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)]
            .map(|corner| self.lattice.cell_of(map_from_other.transform_point(corner)));
        let around = corners.map(|cell| CellBox::spanning(cell, cell));
        around.iter().skip(1).fold(around[0], |all, one| all.union(one))
    }
}

impl Steps {
    /// Old evidence and new, within the limits; never observed counts as nothing.
    pub(crate) fn sum(self, old: i16, step: i16) -> i16 {
        let old = if old == UNKNOWN_STEP { 0 } else { old };
        // Not `clamp`: that checks its limits, and keeps the loop from being vectorised.
        old.saturating_add(step).max(self.min).min(self.max)
    }
}

/// The nearest step; stops at the ends of the range, and is 0 for what is not a number.
pub(crate) fn step_of(logodds: f64) -> i16 {
    let limit = LOGODDS_LIMIT * STEPS_PER_LOGODDS;
    (logodds * STEPS_PER_LOGODDS).round().clamp(-limit, limit) as i16
}

#[cfg(test)]
mod tests {
    use super::*;
    use State::{Free, Occupied, Unknown};
    use proptest::{collection::vec, prelude::*};

    fn map() -> LogOddsMap {
        let lattice = Lattice::new(Vec2::zeros(), 0.5).unwrap();
        LogOddsMap::new(lattice, EvidenceModel::default()).unwrap()
    }

    #[test]
    fn unknown_is_not_the_same_as_undecided() {
        let mut map = map();
        let cell = Cell::new(-3, 7);
        assert_eq!((map.logodds(cell), map.prob(cell)), (None, None));
        map.add(cell, 0.0);
        assert_eq!((map.logodds(cell), map.prob(cell)), (Some(0.0), Some(0.5)));
        assert_eq!(map.state(cell, &Thresholds::default()), State::Unknown);
        map.set(cell, None);
        assert_eq!(map.logodds(cell), None);
        assert_eq!(map.bounds(), None);
    }

    #[test]
    fn evidence_adds_up_and_ends_at_the_limits() {
        let mut map = map();
        let (wall, floor) = (Cell::new(0, 0), Cell::new(1, 0));
        map.add_hit(wall);
        map.add_miss(floor);
        // 0.85 and -0.4 to the nearest 1/1024.
        assert_eq!(map.logodds(wall), Some(870.0 / 1024.0));
        assert_eq!(map.logodds(floor), Some(-410.0 / 1024.0));
        for _ in 0..20 {
            map.add_hit(wall);
            map.add_miss(floor);
        }
        assert_eq!((map.logodds(wall), map.logodds(floor)), (Some(4.0), Some(-4.0)));
        let thresholds = Thresholds::default();
        assert_eq!(map.state(wall, &thresholds), State::Occupied);
        assert_eq!(map.state(floor, &thresholds), State::Free);
        map.add(wall, f64::NEG_INFINITY);
        map.add(floor, f64::NAN);
        assert_eq!((map.logodds(wall), map.logodds(floor)), (Some(-4.0), Some(-4.0)));
    }

    #[test]
    fn weights_of_the_wrong_sign_or_size_are_refused() {
        let lattice = *map().lattice();
        let good = EvidenceModel::default();
        for bad in [
            EvidenceModel { hit_logodds: 0.0, ..good },
            EvidenceModel { hit_logodds: f64::NAN, ..good },
            EvidenceModel { miss_logodds: 0.1, ..good },
            EvidenceModel { min_logodds: -32.0, ..good },
            EvidenceModel { max_logodds: f64::INFINITY, ..good },
        ] {
            assert!(
                matches!(LogOddsMap::new(lattice, bad), Err(MapError::Setting { .. })),
                "{bad:?}"
            );
        }
    }

    #[test]
    fn verdicts_begin_beyond_the_thresholds() {
        let thresholds = Thresholds::default();
        let states = [0.65, 0.65_f64.next_up(), 0.35, 0.35_f64.next_down(), f64::NAN]
            .map(|prob| thresholds.state_of(prob));
        assert_eq!(states, [Unknown, Occupied, Unknown, Free, Unknown]);
    }

    #[test]
    fn entropy_counts_known_cells_only() {
        let mut map = map();
        assert_eq!(map.entropy(), Entropy { sum_bits: 0.0, n_known: 0 });
        assert!(map.entropy().mean_bits().abs() < 1e-300);
        map.add(Cell::new(0, 0), 0.0);
        // p = 0.8 has 0.721928 bits.
        map.set(Cell::new(400, -3), Some(4.0_f64.ln()));
        let entropy = map.entropy();
        assert_eq!(entropy.n_known, 2);
        assert!((entropy.sum_bits - 1.721_928).abs() < 1e-3, "{entropy:?}");
        assert!((entropy.mean_bits() - 0.860_964).abs() < 1e-3);
        assert_eq!((entropy_bits(0.0), entropy_bits(0.5), entropy_bits(1.0)), (0.0, 1.0, 0.0));
        assert!((entropy_bits(0.8) - 0.721_928_094_887_362_4).abs() < 1e-15);
    }

    #[test]
    fn windows_show_the_same_cells() {
        let mut map = map();
        map.add_hit(Cell::new(0, 0));
        map.add_miss(Cell::new(1, 1));
        let area = CellBox::spanning(Cell::new(0, 0), Cell::new(1, 1));
        let states =
            map.state_window(area, &Thresholds { free_prob: 0.45, ..Thresholds::default() });
        assert_eq!(states.unwrap().values(), &[Occupied, Unknown, Unknown, Free]);
        let logodds = map.logodds_window(area).unwrap();
        assert_eq!(logodds.get(Cell::new(0, 0)), Some(870.0 / 1024.0));
        assert!(logodds.get(Cell::new(1, 0)).unwrap().is_nan());
        let probs = map.prob_window(area).unwrap();
        assert_eq!(probs.get(Cell::new(1, 1)), map.prob(Cell::new(1, 1)));
        assert!(probs.get(Cell::new(0, 1)).unwrap().is_nan());
    }

    #[test]
    fn merging_a_turned_map_moves_its_cells() {
        let mut small = map();
        small.add_hit(Cell::new(2, 0));
        small.add_miss(Cell::new(1, 0));
        let mut all = map();
        all.add_hit(Cell::new(-1, 6));
        // A quarter turn to the left about the origin, then 3 m up: column 2 becomes row 2 + 6.
        all.merge_at(&small, Se2::new(0.0, 3.0, std::f64::consts::FRAC_PI_2)).unwrap();
        let known: Vec<_> = all.grid().known().map(|(cell, _)| (cell.column, cell.row)).collect();
        assert_eq!(known, [(-1, 6), (-1, 7), (-1, 8)]);
        assert_eq!(all.logodds(Cell::new(-1, 8)), small.logodds(Cell::new(2, 0)));
        all.merge(&small, Cell::new(-3, 8));
        assert_eq!(all.logodds(Cell::new(-1, 8)), Some(2.0 * 870.0 / 1024.0));
    }

    proptest! {
        #[test]
        fn probabilities_and_log_odds_are_each_others_inverse(l in -20.0..20.0_f64) {
            prop_assert!((logodds_of(prob_of(l)) - l).abs() < 1e-6);
        }

        #[test]
        fn spans_add_like_cells(
            steps in vec((-30..30_i32, 0..90_i32, -1500..1500_i16), 1..12),
        ) {
            let (mut spans, mut cells) = (map(), map());
            for (start, n, step) in steps {
                spans.add_step_to_span(5, start..start + n, step);
                for column in start..start + n {
                    // The definition in wide numbers.
                    let cell = Cell::new(column, 5);
                    let old = cells.logodds(cell).unwrap_or(0.0) * 1024.0;
                    let sum = (old + f64::from(step)).clamp(-4096.0, 4096.0);
                    cells.set(cell, Some(sum / 1024.0));
                }
            }
            let known = |map: &LogOddsMap| map.grid().known().collect::<Vec<_>>();
            prop_assert_eq!(known(&spans), known(&cells));
        }
    }
}
