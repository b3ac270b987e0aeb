//! How likely a beam is to end at a place.

use geometry::{Se2, Vec2};
use grid_maps::{Cell, CellBox, NO_OBSTACLE, SolidCells, Window, squared_distances};

/// How beams err.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldModel {
    /// Standard deviation of where a beam ends around what it met, metres: the map's and the laser's errors together.
    pub hit_std_m: f64,
    /// Part of the beams that end somewhere at random, from 0.001 to 0.9.
    pub random_ratio: f64,
}

impl Default for FieldModel {
    /// For a map of 5 cm cells.
    fn default() -> Self {
        Self { hit_std_m: 0.08, random_ratio: 0.1 }
    }
}

/// The field: of each cell the logarithm of the likelihood, in 256 steps.
///
/// Memory: a byte for each cell, rows as long as a power of two.
#[derive(Clone, Debug)]
pub struct LikelihoodField {
    /// Rows of `1 << row_bits` bytes; the first and last row and column are outside.
    table: Vec<u8>,
    row_bits: u32,
    /// The last column and row that are inside, and a half: where places outside are moved to.
    last: [f32; 2],
    cells_per_m: f64,
    cell_m: f64,
    map_from_cells: Se2,
    cells_from_map: Se2,
    /// Natural logarithm of the likelihood per step.
    step: f64,
    hit_std_m: f64,
    width: usize,
    height: usize,
}

/// A number of this size has no digits after the point in single precision: adding it rounds.
const ROUNDER: f32 = 8_388_608.0;

impl LikelihoodField {
    /// Over the cells of a map with sides of `cell_m`, whose lower left corner lies at `map_from_cells`. O(cells).
    ///
    /// `None` for a map without cells, or with more than 2³⁰.
    pub fn new(
        solid: &SolidCells,
        cell_m: f64,
        map_from_cells: Se2,
        model: FieldModel,
    ) -> Option<Self> {
        let (width, height) = (solid.width(), solid.height());
        let area = CellBox { min: Cell::new(0, 0), width, height };
        if area.is_empty() || cell_m.is_nan() || cell_m <= 0.0 {
            return None;
        }
        let mut cells = Window::filled(area, false).ok()?;
        for row in 0..height as i32 {
            for (column, value) in (0..).zip(cells.row_mut(row)) {
                *value = solid.is_solid(Cell::new(column, row));
            }
        }
        let distances = squared_distances(&cells, |is_solid| is_solid);
        let row_bits = (width + 2).next_power_of_two().trailing_zeros();
        let n_bytes = (height + 2).checked_shl(row_bits).filter(|n| *n <= 1 << 30)?;
        let mut table = vec![0; n_bytes];
        let random = model.random_ratio.clamp(0.001, 0.9);
        let worst = random.ln();
        let step = -worst / 255.0;
        let score = |squared: u32| {
            if squared == NO_OBSTACLE {
                return 0;
            }
            let off = f64::from(squared).sqrt() * cell_m / model.hit_std_m.max(1e-6);
            let likelihood = random + (1.0 - random) * (-0.5 * off * off).exp();
            ((likelihood.ln() - worst) / step).round() as u8
        };
        for (cell, squared) in distances.iter() {
            let (column, row) = (cell.column as usize + 1, cell.row as usize + 1);
            table[(row << row_bits) + column] = score(squared);
        }
        Some(Self {
            table,
            row_bits,
            last: [width as f32 + 0.25, height as f32 + 0.25],
            cells_per_m: 1.0 / cell_m,
            cell_m,
            map_from_cells,
            cells_from_map: map_from_cells.inverse(),
            step,
            hit_std_m: model.hit_std_m.max(1e-6),
            width,
            height,
        })
    }

    /// Natural logarithm of a likelihood by its steps above the least one.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The pose of the map's frame of cells.
    pub(crate) fn map_from_cells(&self) -> Se2 {
        self.map_from_cells
    }

    /// Side of a cell, metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Points of a scan in cells, for [`score`](Self::score).
    pub(crate) fn scaled(&self, points_in_base: &[Vec2], into: &mut [Vec<f32>; 2]) {
        let [xs, ys] = into;
        xs.clear();
        ys.clear();
        xs.extend(points_in_base.iter().map(|p| (p.x * self.cells_per_m) as f32));
        ys.extend(points_in_base.iter().map(|p| (p.y * self.cells_per_m) as f32));
    }

    /// Steps of all points together for a robot at a pose in the map.
    #[inline]
    pub(crate) fn score(&self, map_from_base: Se2, [xs, ys]: [&[f32]; 2]) -> u32 {
        let at = self.cells_from_map.compose(map_from_base);
        let (s, c) = at.yaw_rad.sin_cos();
        let (s, c) = (s as f32, c as f32);
        // A half less, because what follows rounds to the nearest; one more, because of the border.
        let x0 = (at.x_m * self.cells_per_m + 0.5) as f32;
        let y0 = (at.y_m * self.cells_per_m + 0.5) as f32;
        let [last_x, last_y] = self.last;
        // Places outside, and whatever is not a number, are moved to the border, where nothing is likely.
        let number = |value: f32, last: f32| {
            (value.max(0.0).min(last + 1.0) + ROUNDER).to_bits() & 0x7F_FFFF
        };
        let mut sum = 0;
        for (&x, &y) in xs.iter().zip(ys) {
            let column = number(x0 + c * x - s * y, last_x);
            let row = number(y0 + s * x + c * y, last_y);
            let index = ((row as usize) << self.row_bits) | column as usize;
            sum += u32::from(self.table.get(index).copied().unwrap_or(0));
        }
        sum
    }

    /// Steps of a single place (map, m).
    pub(crate) fn steps_at(&self, place: Vec2) -> u8 {
        let at = self.cells_from_map.transform_point(place) * self.cells_per_m;
        self.cell(at.x.floor(), at.y.floor()).map_or(0, |index| self.table[index])
    }

    /// Whether a place (map, m) is inside, and not where beams end most often.
    pub(crate) fn is_open(&self, place: Vec2) -> bool {
        let at = self.cells_from_map.transform_point(place) * self.cells_per_m;
        self.cell(at.x.floor(), at.y.floor()).is_some_and(|index| self.table[index] < 255)
    }

    fn cell(&self, column: f64, row: f64) -> Option<usize> {
        let inside =
            (0.0..self.width as f64).contains(&column) && (0.0..self.height as f64).contains(&row);
        inside.then(|| ((row as usize + 1) << self.row_bits) + column as usize + 1)
    }

    /// How many steps a beam has that ends `off_m` from what it should have met.
    pub(crate) fn steps_of(&self, off_m: f64) -> u8 {
        let random = (-255.0 * self.step).exp();
        let off = off_m / self.hit_std_m;
        let likelihood = random + (1.0 - random) * (-0.5 * off * off).exp();
        ((likelihood / random).ln() / self.step).round() as u8
    }
}
