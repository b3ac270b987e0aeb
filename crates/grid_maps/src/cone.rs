//! Sonar readings: a cone of space at once, free inside, evidence along the arc of the echo.
//!
//! What a cell gets depends on its distance r from the sonar and its angle α off the axis, by a
//! profile that the caller chooses. For a reading s with tolerance t, cells whose centre has
//! α ≤ β are
//!
//! - **free** when r < s − t,
//! - **on the arc** when s − t ≤ r ≤ s + t,
//! - left alone beyond, and outside the cone.
//!
//! [`for_each_cell`] is the definition, exact and for any use; [`ConeInserter`] is the fast path
//! into a [`LogOddsMap`], with the profile in a table.
//!
//! Source for the regions: Elfes (1989), "Using occupancy grids for mobile robot perception and
//! navigation", IEEE Computer 22(6).

use std::ops::Range;

use geometry::{Se2, Vec2};

use crate::{
    CELL_LIMIT, Cell, Lattice, LogOddsMap, MapError, TILE_SIDE_CELLS,
    lattice::floor,
    log_odds::{Steps, step_of},
};

/// Bins of the table for one cell, along the axis and across.
const BINS_PER_CELL: f32 = 2.0;
/// A cone does not reach further, cells; it bounds the table.
const REACH_MAX_CELLS: f64 = 1024.0;
/// The shape of a sonar's readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeShape {
    /// Half of the opening, radians; above 0, up to 1.2 (69°).
    pub half_angle_rad: f64,
    /// Longer readings are taken for this one, metres.
    pub range_max_m: f64,
    /// Half of the arc's thickness, metres.
    pub tolerance_m: f64,
}

/// Puts sonar readings into maps of one resolution.
#[derive(Clone, Debug)]
pub struct ConeInserter {
    shape: ConeShape,
    resolution_m: f64,
    tan_half_angle: f64,
    /// Steps for free cells, then as many for cells on the arc, by the place in the cone: one line
    /// across the axis for each bin along it.
    table: Vec<i16>,
    n_across: usize,
}

/// A cone over a lattice: coordinates in cells from its apex.
#[derive(Clone, Copy)]
struct Sector {
    apex: Vec2,
    axis: Vec2,
    tan: f64,
    reach: f64,
}

/// Calls `visit` for every cell whose centre lies within `reach_m` of the sonar and within
/// `half_angle_rad` (to 1.2) of its axis: with the cell, its distance (m) and its angle off the axis
/// (rad, from 0). From bottom to top, each row from left to right.
///
/// Nothing happens for a pose or reach that is not finite or too far.
pub fn for_each_cell(
    lattice: &Lattice,
    map_from_sonar: Se2,
    half_angle_rad: f64,
    reach_m: f64,
    mut visit: impl FnMut(Cell, f64, f64),
) {
    let reach = reach_m / lattice.resolution_m;
    let tan = half_angle_rad.clamp(0.0, 1.2).tan();
    let Some(sector) = Sector::new(lattice, map_from_sonar, tan, reach) else { return };
    sector.for_each_span(|row, columns| {
        for column in columns {
            let centre = Vec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let away = centre - sector.apex;
            let side = sector.axis.perp(&away).abs();
            let alpha_rad = side.atan2(sector.axis.dot(&away));
            visit(Cell { column, row }, away.norm() * lattice.resolution_m, alpha_rad);
        }
    });
}

impl ConeInserter {
    /// An inserter for maps of the given resolution.
    ///
    /// `free_logodds` and `arc_logodds` give the evidence at distance r (m) and angle α off the axis
    /// (rad, from 0 to the half angle). They are asked once, for bins of half a cell along the axis
    /// and across. O((range / resolution)²) calls and memory.
    ///
    /// # Errors
    ///
    /// [`MapError::Resolution`], and [`MapError::Setting`] for a shape out of range.
    pub fn new(
        shape: ConeShape,
        resolution_m: f64,
        free_logodds: impl Fn(f64, f64) -> f64,
        arc_logodds: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, MapError> {
        Lattice::new(Vec2::zeros(), resolution_m)?;
        let ConeShape { half_angle_rad, range_max_m, tolerance_m } = shape;
        let reach_cells = (range_max_m + tolerance_m) / resolution_m;
        let checks = [
            (
                "half_angle_rad",
                half_angle_rad,
                "above 0, up to 1.2",
                half_angle_rad > 0.0 && half_angle_rad <= 1.2,
            ),
            ("tolerance_m", tolerance_m, "0 or more", tolerance_m >= 0.0),
            (
                "range_max_m",
                range_max_m,
                "above 0, up to 1024 cells with the tolerance",
                range_max_m > 0.0 && reach_cells <= REACH_MAX_CELLS,
            ),
        ];
        for (key, value, requirement, holds) in checks {
            if !holds {
                return Err(MapError::Setting { key, value, requirement });
            }
        }
        let n_bins = |cells: f64| (cells * f64::from(BINS_PER_CELL)).ceil() as usize + 2;
        let (n_along, n_across) = (n_bins(reach_cells), n_bins(reach_cells * half_angle_rad.sin()));
        let bin_m = resolution_m / f64::from(BINS_PER_CELL);
        let steps = |logodds: &dyn Fn(f64, f64) -> f64| -> Vec<i16> {
            let bin = |i: usize| {
                let (along, across) = ((i / n_across) as f64, (i % n_across) as f64);
                let alpha_rad = across.atan2(along).min(half_angle_rad);
                step_of(logodds(along.hypot(across) * bin_m, alpha_rad))
            };
            (0..n_along * n_across).map(bin).collect()
        };
        let mut table = steps(&free_logodds);
        table.extend(steps(&arc_logodds));
        Ok(Self { shape, resolution_m, tan_half_angle: half_angle_rad.tan(), table, n_across })
    }

    /// The shape of its cones.
    pub const fn shape(&self) -> &ConeShape {
        &self.shape
    }

    /// Counts an echo at `range_m` from a sonar at `map_from_sonar` (x along its axis), its evidence
    /// multiplied by `weight_ratio` (to 100). Returns how many cells changed.
    ///
    /// Nothing happens when the map has another resolution than the table, or for numbers without
    /// sense. O(cells of the cone), without allocation but for new tiles.
    pub fn insert_echo(
        &self,
        map: &mut LogOddsMap,
        map_from_sonar: Se2,
        range_m: f64,
        weight_ratio: f64,
    ) -> usize {
        let ConeShape { range_max_m, tolerance_m, .. } = self.shape;
        if range_m.is_nan() || range_m < 0.0 {
            return 0;
        }
        let range_m = range_m.min(range_max_m);
        let [near_m, far_m] = [range_m - tolerance_m, range_m + tolerance_m];
        self.insert(map, map_from_sonar, [near_m, far_m], weight_ratio)
    }

    /// Counts silence: free up to `free_m`, no arc. Otherwise as [`insert_echo`](Self::insert_echo).
    pub fn insert_silence(
        &self,
        map: &mut LogOddsMap,
        map_from_sonar: Se2,
        free_m: f64,
        weight_ratio: f64,
    ) -> usize {
        if free_m.is_nan() || free_m < 0.0 {
            return 0;
        }
        let free_m = free_m.min(self.shape.range_max_m);
        self.insert(map, map_from_sonar, [f64::INFINITY, free_m], weight_ratio)
    }

    /// Free up to the first limit, on the arc up to the second.
    fn insert(
        &self,
        map: &mut LogOddsMap,
        map_from_sonar: Se2,
        limits_m: [f64; 2],
        weight_ratio: f64,
    ) -> usize {
        let lattice = *map.lattice();
        let [near, far] = limits_m.map(|limit_m| limit_m / lattice.resolution_m);
        let sensible = (0.0..=100.0).contains(&weight_ratio);
        if !sensible || (lattice.resolution_m - self.resolution_m).abs() > 1e-9 {
            return 0;
        }
        let sector = Sector::new(&lattice, map_from_sonar, self.tan_half_angle, far);
        let Some(sector) = sector else { return 0 };
        let per_cell = f64::from(BINS_PER_CELL);
        let row_of = RowOfCone {
            table: &self.table,
            n_across: self.n_across as f32,
            n_free: (self.table.len() / 2) as u32,
            steps: map.steps(),
            near2: if near > 0.0 { (near * near) as f32 } else { 0.0 },
            axis: [(sector.axis.x * per_cell) as f32, (sector.axis.y * per_cell) as f32],
            weight: (weight_ratio * 256.0).round() as i32,
        };
        let mut lanes = Lanes { bins: [0; TILE_SIDE_CELLS], added: [0; TILE_SIDE_CELLS] };
        let mut n_cells = 0;
        let grid = map.grid_mut();
        sector.for_each_span(|row, columns| {
            n_cells += columns.len();
            let dy = (f64::from(row) + 0.5 - sector.apex.y) as f32;
            let mut dx = (f64::from(columns.start) + 0.5 - sector.apex.x) as f32;
            grid.change_span(row, columns, |cells| {
                row_of.add(cells, dx, dy, &mut lanes);
                dx += cells.len() as f32;
            });
        });
        n_cells
    }
}

/// Scratch for the cells of one row of a tile.
struct Lanes {
    bins: [u32; TILE_SIDE_CELLS],
    added: [i16; TILE_SIDE_CELLS],
}

/// What the cells of a row need to know.
struct RowOfCone<'a> {
    table: &'a [i16],
    n_across: f32,
    n_free: u32,
    steps: Steps,
    /// Nearer cells are free; cells².
    near2: f32,
    /// Unit vector along the axis, in bins for a cell.
    axis: [f32; 2],
    /// 256 for one.
    weight: i32,
}

impl RowOfCone<'_> {
    /// Adds to cells of one tile, the first of them at (`dx`, `dy`) from the apex.
    ///
    /// Bins first, for all cells together, in arithmetic that the compiler can vectorise; then the
    /// look-ups; then the sums, together again.
    fn add(&self, cells: &mut [i16], dx: f32, dy: f32, lanes: &mut Lanes) {
        // Eight at a time: a loop whose length changes with each row costs more than its work.
        let n = cells.len().next_multiple_of(8).min(TILE_SIDE_CELLS);
        let (bins, added) = (&mut lanes.bins[..n], &mut lanes.added[..n]);
        self.find_bins(bins, dx, dy);
        for (step, bin) in added.iter_mut().zip(&*bins) {
            *step = self.table.get(*bin as usize).copied().unwrap_or(0);
        }
        if self.weight != 256 {
            for step in &mut *added {
                let scaled = (i32::from(*step) * self.weight) >> 8;
                *step = scaled.clamp(-31_000, 31_000) as i16;
            }
        }
        for (cell, step) in cells.iter_mut().zip(added) {
            *cell = self.steps.sum(*cell, *step);
        }
    }

    /// The places in the table of neighbouring cells, without a branch.
    fn find_bins(&self, bins: &mut [u32], dx: f32, dy: f32) {
        let [axis_x, axis_y] = self.axis;
        let (along_y, across_y, dy2) = (dy * axis_y, dy * axis_x, dy * dy - self.near2);
        for (i, bin) in (0_i32..).zip(bins) {
            let dx = dx + i as f32;
            let along = rounded(dx * axis_x + along_y);
            let across = rounded((across_y - dx * axis_y).abs());
            // Whole numbers in floating point multiply in one instruction; exact below 2²³.
            let place = (along * self.n_across + across + SHIFT).to_bits() & SHIFT_MASK;
            // The sign of r² − near² chooses the half: all bits for free, none for the arc.
            let is_free = ((dx * dx + dy2).to_bits() as i32 >> 31) as u32;
            *bin = place + (!is_free & self.n_free);
        }
    }
}

/// 2²³ has no digits left behind the point: adding it rounds, and the sum's lowest bits are the
/// whole number. A conversion with all its checks is not vectorised.
const SHIFT: f32 = 8_388_608.0;
const SHIFT_MASK: u32 = 0x007f_ffff;

/// Rounds a number from 0 to 2²².
fn rounded(x: f32) -> f32 {
    (x + SHIFT) - SHIFT
}

impl Sector {
    fn new(lattice: &Lattice, map_from_sonar: Se2, tan: f64, reach: f64) -> Option<Self> {
        lattice.cell_at(map_from_sonar.position())?;
        let sensible = tan > 0.0 && (0.0..=REACH_MAX_CELLS).contains(&reach);
        if !sensible || !map_from_sonar.yaw_rad.is_finite() {
            return None;
        }
        let apex = lattice.in_cells(map_from_sonar.position());
        Some(Self { apex, axis: map_from_sonar.heading(), tan, reach })
    }

    /// Its rows, and in each the columns whose centres are in the cone. A cone that opens less than
    /// half a turn is convex, so each row has one span.
    fn for_each_span(&self, mut span: impl FnMut(i32, Range<i32>)) {
        /// Some rows ahead: the roots of several rows are found at the same time, but not while a
        /// row is being worked on.
        const N_AHEAD: usize = 16;
        let Self { apex, axis, tan, reach } = *self;
        // Edges of the cone, to the left and right of the axis, not of unit length.
        let left = Vec2::new(axis.x - tan * axis.y, axis.y + tan * axis.x);
        let right = Vec2::new(axis.x + tan * axis.y, axis.y - tan * axis.x);
        let end = |edge: Vec2| edge.y * reach / edge.norm();
        let mut low = end(left).min(end(right)).min(0.0);
        let mut high = end(left).max(end(right)).max(0.0);
        // Where the axis is nearly along y, the arc is higher than its ends.
        if axis.x.abs() <= tan * axis.y.abs() {
            if axis.y > 0.0 { high = reach } else { low = -reach }
        }
        // A place (x, y) is right of the left edge when x · left.y ≥ y · left.x, and left of the
        // right edge when x · right.y ≤ y · right.x.
        let limits = [Limit::new(left.y, left.x), Limit::new(-right.y, -right.x)];
        let (row_low, row_high) = (ceil(apex.y + low - 0.5), floor(apex.y + high - 0.5));
        let columns_of = |row: i32| {
            let dy = f64::from(row) + 0.5 - apex.y;
            let half = (reach * reach - dy * dy).max(0.0).sqrt();
            let mut range = [-half, half];
            for limit in limits {
                limit.cut(&mut range, dy);
            }
            ceil(apex.x + range[0] - 0.5)..floor(apex.x + range[1] - 0.5) + 1
        };
        let mut spans = [const { 0..0 }; N_AHEAD];
        let row_end = row_high.min(CELL_LIMIT) + 1;
        let mut first = row_low.max(-CELL_LIMIT);
        while first < row_end {
            let rows = first..row_end.min(first + N_AHEAD as i32);
            first = rows.end;
            for (row, columns) in rows.clone().zip(&mut spans) {
                *columns = columns_of(row);
            }
            for (row, columns) in rows.zip(&spans) {
                if columns.start < columns.end {
                    span(row, columns.clone());
                }
            }
        }
    }
}

/// Where `factor` · x ≥ `least` · y.
#[derive(Clone, Copy)]
enum Limit {
    /// x is at least this times y.
    Above(f64),
    /// x is at most this times y.
    Below(f64),
    /// x does not matter: this times y must not be above 0.
    Row(f64),
}

impl Limit {
    fn new(factor: f64, least: f64) -> Self {
        if factor > 0.0 {
            Self::Above(least / factor)
        } else if factor < 0.0 {
            Self::Below(least / factor)
        } else {
            Self::Row(least)
        }
    }

    fn cut(self, range: &mut [f64; 2], y: f64) {
        match self {
            Self::Above(slope) => range[0] = range[0].max(slope * y),
            Self::Below(slope) => range[1] = range[1].min(slope * y),
            Self::Row(least) if least * y > 0.0 => *range = [0.0, -2.0],
            Self::Row(_) => {}
        }
    }
}

fn ceil(x: f64) -> i32 {
    -floor(-x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EvidenceModel;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const SHAPE: ConeShape =
        ConeShape { half_angle_rad: 0.26, range_max_m: 3.0, tolerance_m: 0.05 };
    const RESOLUTION_M: f64 = 0.035;

    fn map() -> LogOddsMap {
        let lattice = Lattice::new(Vec2::new(0.01, -0.02), RESOLUTION_M).unwrap();
        let model =
            EvidenceModel { min_logodds: -20.0, max_logodds: 20.0, ..EvidenceModel::default() };
        LogOddsMap::new(lattice, model).unwrap()
    }

    /// Plain numbers, so that each cell shows its region.
    fn inserter(shape: ConeShape) -> ConeInserter {
        ConeInserter::new(shape, RESOLUTION_M, |_, _| -1.0, |_, _| 2.0).unwrap()
    }

    proptest! {
        /// Every cell near the cone against distance and angle by arc tangents; cells within a
        /// millionth of a border may fall on either side.
        #[test]
        fn regions_are_where_distance_and_angle_say(
            x in -1.0..1.0_f64, y in -1.0..1.0_f64,
            yaw in prop_oneof![
                3 => -PI..PI, 1 => (-4..4_i32).prop_map(|q| f64::from(q) * PI / 4.0)
            ],
            range_m in prop_oneof![0.0..0.2_f64, 0.0..3.5_f64],
            half_angle_rad in prop_oneof![Just(0.12), Just(0.26), Just(0.79), Just(1.2)],
            silent: bool,
        ) {
            let shape = ConeShape { half_angle_rad, ..SHAPE };
            let sonar = Se2::new(x, y, yaw);
            let mut map = map();
            let inserter = inserter(shape);
            let n = if silent {
                inserter.insert_silence(&mut map, sonar, range_m, 1.0)
            } else {
                inserter.insert_echo(&mut map, sonar, range_m, 1.0)
            };
            prop_assert_eq!(n, map.grid().known().count());
            let s = range_m.min(3.0);
            let (near, far) = if silent { (s, s) } else { (s - 0.05, s + 0.05) };
            for column in -130..130 {
                for row in -130..130 {
                    let cell = Cell::new(column, row);
                    let away = map.lattice().centre_of(cell) - sonar.position();
                    let r = away.x.hypot(away.y);
                    let off = (away.y.atan2(away.x) - yaw).rem_euclid(2.0 * PI);
                    let alpha = off.min(2.0 * PI - off);
                    let unsure = [r - near, r - far, alpha - half_angle_rad, r]
                        .iter().any(|difference| difference.abs() < 1e-6);
                    let expected = if alpha > half_angle_rad || r > far { None }
                        else if r < near { Some(-1.0) } else { Some(2.0) };
                    if !unsure {
                        prop_assert_eq!(map.logodds(cell), expected, "{:?}", cell);
                    }
                }
            }
        }

        /// The table against the profile at each cell, within what half a bin can make.
        #[test]
        fn the_table_follows_the_profile(
            x in -1.0..1.0_f64, y in -1.0..1.0_f64, yaw in -PI..PI, range_m in 0.5..3.0_f64,
            weight_ratio in prop_oneof![Just(1.0), 0.0..3.0_f64],
        ) {
            // A slope of 1 for a metre and 4 for a radian.
            let free = |r: f64, alpha: f64| -3.0 + r - 4.0 * alpha;
            let arc = |r: f64, alpha: f64| 4.0 - r - 4.0 * alpha;
            let inserter = ConeInserter::new(SHAPE, RESOLUTION_M, free, arc).unwrap();
            let mut map = map();
            let sonar = Se2::new(x, y, yaw);
            inserter.insert_echo(&mut map, sonar, range_m, weight_ratio);
            let mut n = 0;
            let lattice = *map.lattice();
            for_each_cell(&lattice, sonar, 0.26, range_m + 0.05, |cell, r, alpha| {
                n += 1;
                let expected = if r < range_m - 0.05 { free(r, alpha) } else { arc(r, alpha) };
                let found = map.logodds(cell).unwrap_or(f64::NAN);
                // Half the diagonal of a bin moves the distance, and turns near cells more.
                let half_bin_m = 0.25 * 2.0_f64.sqrt() * RESOLUTION_M;
                let turned_rad = (half_bin_m / (r - half_bin_m)).clamp(0.0, 0.26);
                let bin = half_bin_m + 4.0 * if r > half_bin_m { turned_rad } else { 0.26 } + 1e-3;
                let unsure = (r - range_m + 0.05).abs() < 1e-6;
                let error = (found - weight_ratio * expected).abs();
                assert!(unsure || error < bin * weight_ratio + 0.01 * weight_ratio.max(1.0), "{error} at {r} {alpha}");
            });
            prop_assert_eq!(n, map.grid().known().count());
        }

        #[test]
        fn a_visited_cell_comes_with_its_distance_and_angle(yaw in -PI..PI) {
            let lattice = *map().lattice();
            let sonar = Se2::new(0.3, -0.4, yaw);
            for_each_cell(&lattice, sonar, 0.5, 1.0, |cell, r_m, alpha_rad| {
                let there = sonar.inverse().transform_point(lattice.centre_of(cell));
                assert!((r_m - there.norm()).abs() < 1e-12);
                assert!((alpha_rad - there.y.atan2(there.x).abs()).abs() < 1e-9);
                assert!(alpha_rad <= 0.5 + 1e-9 && r_m <= 1.0 + 1e-9);
            });
        }
    }

    #[test]
    fn numbers_without_sense_change_nothing() {
        let mut map = map();
        let inserter = inserter(SHAPE);
        for (x, yaw) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (1e300, 0.0), (0.0, f64::NAN)] {
            let sonar = Se2 { x_m: x, y_m: 0.0, yaw_rad: yaw };
            assert_eq!(inserter.insert_echo(&mut map, sonar, 1.0, 1.0), 0);
        }
        for bad in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            assert_eq!(inserter.insert_echo(&mut map, Se2::IDENTITY, bad, 1.0), 0);
            assert_eq!(inserter.insert_silence(&mut map, Se2::IDENTITY, bad, 1.0), 0);
            assert_eq!(inserter.insert_echo(&mut map, Se2::IDENTITY, 1.0, bad), 0);
        }
        let lattice = Lattice::new(Vec2::zeros(), 0.05).unwrap();
        let mut other = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        assert_eq!(inserter.insert_echo(&mut other, Se2::IDENTITY, 1.0, 1.0), 0);
        assert_eq!(map.bounds(), None);
        // Longer readings are taken for the longest.
        assert!(inserter.insert_echo(&mut map, Se2::IDENTITY, f64::INFINITY, 1.0) > 1000);
        for_each_cell(&lattice, Se2::IDENTITY, f64::NAN, 1.0, |_, _, _| panic!("no angle"));
        for_each_cell(&lattice, Se2::IDENTITY, 0.3, f64::NAN, |_, _, _| panic!("no reach"));
    }

    #[test]
    fn shapes_out_of_range_are_refused() {
        let refused = |shape, resolution_m| {
            ConeInserter::new(shape, resolution_m, |_, _| -1.0, |_, _| 1.0).is_err()
        };
        assert!(!refused(SHAPE, 0.035));
        for bad in [0.0, -0.1, 1.3, f64::NAN] {
            assert!(refused(ConeShape { half_angle_rad: bad, ..SHAPE }, 0.035));
        }
        for bad in [0.0, -0.1, f64::INFINITY, f64::NAN] {
            assert!(refused(ConeShape { range_max_m: bad, ..SHAPE }, 0.035));
            assert!(refused(SHAPE, bad));
        }
        assert!(refused(ConeShape { tolerance_m: -0.1, ..SHAPE }, 0.035));
        assert!(refused(SHAPE, 1e-4));
    }

    #[test]
    fn the_second_reading_allocates_nothing() {
        let mut map = map();
        let inserter = inserter(SHAPE);
        inserter.insert_echo(&mut map, Se2::IDENTITY, 2.0, 1.0);
        let measured = allocation_counter::measure(|| {
            inserter.insert_echo(&mut map, Se2::IDENTITY, 2.0, 0.5);
        });
        assert_eq!(measured.count_total, 0);
    }
}
