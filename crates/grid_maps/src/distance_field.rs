//! How far it is to the nearest obstacle: exact, in time linear in the cells.

use geometry::Vec2;

use crate::{CellBox, Lattice, LogOddsMap, MapError, State, Thresholds, Window};

/// In [`squared_distances`]: no obstacle anywhere.
pub const NO_OBSTACLE: u32 = u32::MAX;

/// Squared distance from each cell to the nearest obstacle, centre to centre, in cells²; 0 in an
/// obstacle, [`NO_OBSTACLE`] where there is none at all.
///
/// O(cells) time and memory. Exact as long as the window's diagonal is under 65 535 cells; longer
/// distances stop there.
///
/// Source: Meijster, Roerdink and Hesselink (2000), "A general algorithm for computing distance
/// transforms in linear time", ISMM: first along columns, then the lower envelope of parabolas
/// along rows, all in integers. Differences: columns without an obstacle are left out of the
/// envelope instead of having a large number.
pub fn squared_distances<T: Copy>(
    cells: &Window<T>,
    is_obstacle: impl Fn(T) -> bool,
) -> Window<u32> {
    let area = cells.area();
    let mut field = cells.map(|value| if is_obstacle(value) { 0 } else { NO_OBSTACLE });
    if area.is_empty() {
        return field;
    }
    along_columns(field.values_mut(), area.width);
    let mut envelope = Envelope::default();
    for row in field.values_mut().chunks_exact_mut(area.width) {
        envelope.along_row(row);
    }
    field
}

/// Distance to the nearest obstacle as a smooth surface: metres, with its slope.
#[derive(Clone, Debug)]
pub struct DistanceField {
    lattice: Lattice,
    distances: Window<f32>,
    distance_max_m: f64,
}

/// A point of a [`DistanceField`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSample {
    /// To the nearest obstacle, metres.
    pub distance_m: f64,
    /// Its change with the point's x and y; metres for a metre.
    pub gradient: Vec2,
}

impl DistanceField {
    /// The field of the given obstacles. Distances stop at `distance_max_m`, so that far points
    /// pull at nothing.
    pub fn new<T: Copy>(
        lattice: Lattice,
        cells: &Window<T>,
        is_obstacle: impl Fn(T) -> bool,
        distance_max_m: f64,
    ) -> Self {
        let metres = |squared: u32| match squared {
            NO_OBSTACLE => distance_max_m as f32,
            _ => (f64::from(squared).sqrt() * lattice.resolution_m).min(distance_max_m) as f32,
        };
        let distances = squared_distances(cells, is_obstacle).map(metres);
        Self { lattice, distances, distance_max_m }
    }

    /// The field around the occupied cells of `map` within `area`.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn of_map(
        map: &LogOddsMap,
        area: CellBox,
        thresholds: &Thresholds,
        distance_max_m: f64,
    ) -> Result<Self, MapError> {
        let states = map.state_window(area, thresholds)?;
        let is_obstacle = |state| state == State::Occupied;
        Ok(Self::new(*map.lattice(), &states, is_obstacle, distance_max_m))
    }

    /// Where its cells lie.
    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Distances at the centres of the cells, metres.
    pub const fn distances(&self) -> &Window<f32> {
        &self.distances
    }

    /// What distances stop at, metres.
    pub const fn distance_max_m(&self) -> f64 {
        self.distance_max_m
    }

    /// Distance and slope at `point` (m): bilinear between the four centres around it, so that the
    /// slope is exactly that of the distance. `None` outside the outermost centres and for what
    /// is not a number, and in fields of a single row or column.
    pub fn sample(&self, point: Vec2) -> Option<FieldSample> {
        let area = self.distances.area();
        let at = self.lattice.in_cells(point);
        let x = at.x - f64::from(area.min.column) - 0.5;
        let y = at.y - f64::from(area.min.row) - 0.5;
        let (x_max, y_max) = (area.width as f64 - 1.0, area.height as f64 - 1.0);
        let inside = x >= 0.0 && y >= 0.0 && x <= x_max && y <= y_max;
        if !inside || area.width < 2 || area.height < 2 {
            return None;
        }
        // The last centre has no neighbour: there it is the end of the piece before.
        let (column, row) = ((x as usize).min(area.width - 2), (y as usize).min(area.height - 2));
        let start = row * area.width + column;
        let values = self.distances.values();
        let [a, b] = [values[start], values[start + 1]].map(f64::from);
        let start = start + area.width;
        let [c, d] = [values[start], values[start + 1]].map(f64::from);
        let (u, v) = (x - column as f64, y - row as f64);
        let (below, above) = (a + (b - a) * u, c + (d - c) * u);
        let per_m = 1.0 / self.lattice.resolution_m;
        let along_x = (b - a) + ((d - c) - (b - a)) * v;
        let gradient = Vec2::new(along_x, above - below) * per_m;
        Some(FieldSample { distance_m: below + (above - below) * v, gradient })
    }
}

/// Distance to the nearest obstacle of the same column, in cells; 0 in one, [`NO_OBSTACLE`] where
/// the column has none. Whole rows at a time, as they lie in memory.
fn along_columns(values: &mut [u32], width: usize) {
    let n_rows = values.len() / width;
    for row in 1..n_rows {
        let (before, here) = values.split_at_mut(row * width);
        let before = &before[(row - 1) * width..];
        for (value, below) in here[..width].iter_mut().zip(before) {
            *value = (*value).min(below.saturating_add(1));
        }
    }
    for row in (1..n_rows).rev() {
        let (here, above) = values.split_at_mut(row * width);
        let here = &mut here[(row - 1) * width..];
        for (value, above) in here.iter_mut().zip(&above[..width]) {
            *value = (*value).min(above.saturating_add(1));
        }
    }
}

/// Lower envelope of the parabolas of one row; keeps its memory from row to row.
#[derive(Default)]
struct Envelope {
    /// Parabolas of the envelope from left to right.
    pieces: Vec<Piece>,
}

/// The parabola (x − column)² + height² is lowest from `start` on.
#[derive(Clone, Copy)]
struct Piece {
    column: i64,
    height2: i64,
    start: i64,
}

impl Envelope {
    /// Turns distances along the columns into squared distances.
    fn along_row(&mut self, row: &mut [u32]) {
        self.pieces.clear();
        for (column, &height) in row.iter().enumerate() {
            // Saturated additions in the first pass end at or near the mark for none.
            if height < 1 << 30 {
                let height = i64::from(height);
                let column = column as i64;
                self.add(Piece { column, height2: height * height, start: 0 }, row.len() as i64);
            }
        }
        let mut pieces = self.pieces.iter().peekable();
        let Some(mut piece) = pieces.next() else {
            row.fill(NO_OBSTACLE);
            return;
        };
        for (x, value) in (0..).zip(row) {
            while let Some(next) = pieces.next_if(|next| next.start <= x) {
                piece = next;
            }
            let dx = x - piece.column;
            let squared = dx * dx + piece.height2;
            *value = u32::try_from(squared).unwrap_or(NO_OBSTACLE - 1);
        }
    }

    fn add(&mut self, mut new: Piece, width: i64) {
        while let Some(last) = self.pieces.last() {
            // From this column on the new parabola is lower: the first x at which
            // (x − c)² + h² < (x − c₀)² + h₀².
            let above =
                new.column * new.column - last.column * last.column + (new.height2 - last.height2);
            new.start = above.div_euclid(2 * (new.column - last.column)) + 1;
            if new.start > last.start {
                break;
            }
            self.pieces.pop();
        }
        if self.pieces.is_empty() {
            new.start = 0;
        }
        if new.start < width {
            self.pieces.push(new);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, EvidenceModel};
    use proptest::{collection::vec, prelude::*};

    /// Oracle: every obstacle is asked.
    fn by_definition(cells: &Window<bool>, at: Cell) -> u32 {
        let squared = |cell: Cell| {
            let (dx, dy) = (at.column - cell.column, at.row - cell.row);
            (dx * dx + dy * dy) as u32
        };
        let obstacles = cells.iter().filter(|(_, obstacle)| *obstacle);
        obstacles.map(|(cell, _)| squared(cell)).min().unwrap_or(NO_OBSTACLE)
    }

    fn field() -> DistanceField {
        let area = CellBox { min: Cell::new(-2, -2), width: 6, height: 5 };
        let mut cells = Window::filled(area, false).unwrap();
        *cells.get_mut(Cell::new(0, 0)).unwrap() = true;
        let lattice = Lattice::new(Vec2::new(10.0, 20.0), 0.5).unwrap();
        DistanceField::new(lattice, &cells, |obstacle| obstacle, 1.2)
    }

    #[test]
    fn at_centres_the_field_is_the_distance() {
        let field = field();
        let at = |column, row| {
            let centre = field.lattice().centre_of(Cell::new(column, row));
            field.sample(centre).map(|sample| sample.distance_m)
        };
        assert_eq!((at(0, 0), at(1, 0), at(0, -2)), (Some(0.0), Some(0.5), Some(1.0)));
        assert!((at(1, 1).unwrap() - 0.5 * 2.0_f64.sqrt()).abs() < 1e-7);
        // √5 cells are 1.118 m, 3 cells 1.5 m: over the limit. The last row and column count too.
        assert!((at(2, 1).unwrap() - 1.118_034).abs() < 1e-6);
        assert!((at(3, 0).unwrap() - 1.2).abs() < 1e-7 && (at(3, 2).unwrap() - 1.2).abs() < 1e-7);
        assert_eq!((at(4, 0), at(0, 3), at(-3, 0), at(0, -3)), (None, None, None, None));
        assert_eq!(field.sample(Vec2::new(f64::NAN, 20.0)), None);
        assert_eq!(field.sample(Vec2::new(1e300, 20.0)), None);
    }

    #[test]
    fn without_obstacles_everything_is_as_far_as_can_be() {
        let area = CellBox { min: Cell::new(0, 0), width: 3, height: 2 };
        let empty = Window::filled(area, false).unwrap();
        assert!(squared_distances(&empty, |o| o).values().iter().all(|d| *d == NO_OBSTACLE));
        let field = DistanceField::new(*field().lattice(), &empty, |o| o, 2.5);
        let sample = field.sample(Vec2::new(10.6, 20.4)).unwrap();
        assert_eq!((sample.distance_m, sample.gradient), (2.5, Vec2::zeros()));
        let nothing = Window::filled(CellBox { width: 0, ..area }, false).unwrap();
        assert!(squared_distances(&nothing, |o| o).values().is_empty());
        let field = DistanceField::new(*field.lattice(), &nothing, |o| o, 2.5);
        assert_eq!(field.sample(Vec2::new(10.6, 20.4)), None);
    }

    #[test]
    fn the_field_of_a_map_is_that_of_its_occupied_cells() {
        let mut map = LogOddsMap::new(*field().lattice(), EvidenceModel::default()).unwrap();
        map.add_hit(Cell::new(0, 0));
        map.add_miss(Cell::new(1, 0));
        let area = field().distances().area();
        let of_map = DistanceField::of_map(&map, area, &Thresholds::default(), 1.2).unwrap();
        assert_eq!(of_map.distances(), field().distances());
    }

    proptest! {
        #[test]
        fn distances_are_exact(
            width in 1..24_usize,
            seeds in vec(0..40_u8, 24 * 20),
            rare in 1..40_u8,
        ) {
            let area = CellBox { min: Cell::new(-5, 3), width, height: 20 };
            let cells: Vec<bool> = seeds[..20 * width].iter().map(|seed| *seed < rare / 2).collect();
            let cells = Window::from_values(area, cells).unwrap();
            for (cell, squared) in squared_distances(&cells, |obstacle| obstacle).iter() {
                prop_assert_eq!(squared, by_definition(&cells, cell), "{:?}", cell);
            }
        }

        /// The slope is the limit of differences, away from the lines where it jumps.
        #[test]
        fn the_slope_is_that_of_the_distance(x in 9.3..11.2_f64, y in 19.3..20.9_f64) {
            let field = field();
            let h = 1e-6;
            let at = |dx: f64, dy: f64| field.sample(Vec2::new(x + dx, y + dy)).unwrap();
            let inside = |v: f64| {
                let part = (v / 0.5 - 0.5).rem_euclid(1.0);
                part > 1e-5 && part < 1.0 - 1e-5
            };
            prop_assume!(inside(x - 10.0) && inside(y - 20.0));
            let gradient = at(0.0, 0.0).gradient;
            let dx = (at(h, 0.0).distance_m - at(-h, 0.0).distance_m) / (2.0 * h);
            let dy = (at(0.0, h).distance_m - at(0.0, -h).distance_m) / (2.0 * h);
            prop_assert!((gradient.x - dx).abs() < 1e-6 && (gradient.y - dy).abs() < 1e-6);
        }
    }
}
