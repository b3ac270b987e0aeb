//! Where cells lie: from coordinates to columns and rows and back, exact at the borders.

use geometry::Vec2;

use crate::MapError;

/// No cell lies beyond ± this column or row, so that sums of two never overflow: 2³⁰, which is
/// 53 000 km at 5 cm.
pub const CELL_LIMIT: i32 = 1 << 30;

/// One cell: column along x, row along y. Row 0 is at the bottom; negative cells are cells too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Along x.
    pub column: i32,
    /// Along y.
    pub row: i32,
}

/// A square lattice in the plane: cell (c, r) covers [origin + c·res, origin + (c+1)·res) along x,
/// and alike along y.
///
/// The borders are the floating-point values of those expressions, and [`cell_of`](Self::cell_of)
/// agrees with them to the last bit: a point on a border belongs to the upper cell, and the next
/// number below it to the lower one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Lower left corner of cell (0, 0), metres.
    pub origin: Vec2,
    /// Side of a cell, metres, positive.
    pub resolution_m: f64,
}

/// A rectangle of cells: columns from `min.column` up to and without `min.column + width`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellBox {
    /// Lower left cell.
    pub min: Cell,
    /// Cells along x.
    pub width: usize,
    /// Cells along y.
    pub height: usize,
}

impl Cell {
    /// The cell in that column and row.
    pub const fn new(column: i32, row: i32) -> Self {
        Self { column, row }
    }

    /// The cell so many columns to the right and rows up; stops at the ends of `i32`.
    #[must_use]
    pub const fn offset(self, columns: i32, rows: i32) -> Self {
        Self { column: self.column.saturating_add(columns), row: self.row.saturating_add(rows) }
    }
}

impl Lattice {
    /// A lattice whose cell (0, 0) has its lower left corner at `origin` (m).
    ///
    /// # Errors
    ///
    /// [`MapError::Resolution`] and [`MapError::Origin`] for numbers that are not finite, and for
    /// a side of zero or less.
    pub fn new(origin: Vec2, resolution_m: f64) -> Result<Self, MapError> {
        if !(resolution_m.is_finite() && resolution_m > 0.0) {
            return Err(MapError::Resolution { value: resolution_m });
        }
        if !(origin.x.is_finite() && origin.y.is_finite()) {
            return Err(MapError::Origin { x_m: origin.x, y_m: origin.y });
        }
        Ok(Self { origin, resolution_m })
    }

    /// The cell that covers `point` (m).
    ///
    /// Far points give the last cell, ±[`CELL_LIMIT`]; what is not a number gives −`CELL_LIMIT`, so
    /// that it never lands in a building. Ask [`cell_at`](Self::cell_at) to be told instead.
    pub fn cell_of(&self, point: Vec2) -> Cell {
        Cell {
            column: index_of(point.x, self.origin.x, self.resolution_m),
            row: index_of(point.y, self.origin.y, self.resolution_m),
        }
    }

    /// The cell that covers `point` (m), or `None` when it is not finite or beyond
    /// ±[`CELL_LIMIT`] cells.
    pub fn cell_at(&self, point: Vec2) -> Option<Cell> {
        let cell = self.cell_of(point);
        let inside = |i: i32| -CELL_LIMIT < i && i < CELL_LIMIT;
        (inside(cell.column) && inside(cell.row)).then_some(cell)
    }

    /// The lower left corner of `cell`, metres.
    pub fn corner_of(&self, cell: Cell) -> Vec2 {
        Vec2::new(
            border(cell.column, self.origin.x, self.resolution_m),
            border(cell.row, self.origin.y, self.resolution_m),
        )
    }

    /// The centre of `cell`, metres.
    pub fn centre_of(&self, cell: Cell) -> Vec2 {
        let centre = Vec2::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
        self.origin + centre * self.resolution_m
    }

    /// `point` (m) counted in cells from the origin: cell (0, 0) is [0, 1) × [0, 1).
    pub fn in_cells(&self, point: Vec2) -> Vec2 {
        (point - self.origin) / self.resolution_m
    }
}

/// Where the cell `index` begins, metres.
fn border(index: i32, origin_m: f64, resolution_m: f64) -> f64 {
    origin_m + f64::from(index) * resolution_m
}

/// The cell index of a coordinate (m).
fn index_of(at_m: f64, origin_m: f64, resolution_m: f64) -> i32 {
    let scaled = (at_m - origin_m) / resolution_m;
    let limit = f64::from(CELL_LIMIT);
    if scaled >= limit {
        return CELL_LIMIT;
    }
    if scaled.is_nan() || scaled <= -limit {
        return -CELL_LIMIT;
    }
    let guess = floor(scaled);
    // The quotient is rounded, so beside a border it may fall on the wrong side. The border itself
    // decides.
    if at_m < border(guess, origin_m, resolution_m) {
        guess - 1
    } else if at_m >= border(guess + 1, origin_m, resolution_m) {
        guess + 1
    } else {
        guess
    }
}

/// Rounds down, to the ends of the type at most. `f64::floor` is a call into the mathematics library on processors of the
/// oldest 64-bit kind, which is what we build for; the conversion is one instruction.
pub(crate) fn floor(x: f64) -> i32 {
    let towards_zero = x as i32;
    towards_zero.saturating_sub(i32::from(f64::from(towards_zero) > x))
}

impl CellBox {
    /// The rectangle from `min` to `max`, both inside; empty when `max` lies left of or below
    /// `min`.
    pub fn spanning(min: Cell, max: Cell) -> Self {
        let side = |from: i32, to: i32| (i64::from(to) - i64::from(from) + 1).max(0) as usize;
        Self { min, width: side(min.column, max.column), height: side(min.row, max.row) }
    }

    /// Whether no cell is in it.
    pub const fn is_empty(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// How many cells are in it; stops at the largest number.
    pub const fn n_cells(&self) -> usize {
        self.width.saturating_mul(self.height)
    }

    /// One past the last column.
    pub const fn column_end(&self) -> i64 {
        self.min.column as i64 + self.width as i64
    }

    /// One past the last row.
    pub const fn row_end(&self) -> i64 {
        self.min.row as i64 + self.height as i64
    }

    /// Whether `cell` is in it.
    pub fn contains(&self, cell: Cell) -> bool {
        self.index_of(cell).is_some()
    }

    /// Where `cell` stands among the cells row by row, or `None` outside.
    pub fn index_of(&self, cell: Cell) -> Option<usize> {
        // A difference below zero wraps to a huge one, so one comparison per axis does for two.
        let x = (i64::from(cell.column) - i64::from(self.min.column)) as usize;
        let y = (i64::from(cell.row) - i64::from(self.min.row)) as usize;
        (x < self.width && y < self.height).then(|| y * self.width + x)
    }

    /// The cells in both.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let min = Cell {
            column: self.min.column.max(other.min.column),
            row: self.min.row.max(other.min.row),
        };
        let side = |from: i32, to: i64| (to - i64::from(from)).max(0) as usize;
        let width = side(min.column, self.column_end().min(other.column_end()));
        let height = side(min.row, self.row_end().min(other.row_end()));
        Self { min, width, height }
    }

    /// The smallest rectangle around both; an empty one adds nothing.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.is_empty() {
            return *other;
        }
        if other.is_empty() {
            return *self;
        }
        let min = Cell {
            column: self.min.column.min(other.min.column),
            row: self.min.row.min(other.min.row),
        };
        let side = |from: i32, to: i64| (to - i64::from(from)) as usize;
        let width = side(min.column, self.column_end().max(other.column_end()));
        let height = side(min.row, self.row_end().max(other.row_end()));
        Self { min, width, height }
    }

    /// Larger by `by_cells` on each side; an empty rectangle stays empty.
    #[must_use]
    pub fn grown(&self, by_cells: u16) -> Self {
        if self.is_empty() {
            return *self;
        }
        let by = i32::from(by_cells);
        let wider = 2 * usize::from(by_cells);
        Self {
            min: self.min.offset(-by, -by),
            width: self.width.saturating_add(wider),
            height: self.height.saturating_add(wider),
        }
    }

    /// Its cells, row by row from the bottom, each from left to right.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let Self { min, width, height } = *self;
        let row_of = move |y: usize| {
            (0..width).map(move |x| {
                let column = (i64::from(min.column) + x as i64) as i32;
                Cell { column, row: (i64::from(min.row) + y as i64) as i32 }
            })
        };
        (0..height).flat_map(row_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lattice(x: f64, y: f64, resolution_m: f64) -> Lattice {
        Lattice::new(Vec2::new(x, y), resolution_m).unwrap()
    }

    #[test]
    fn a_border_belongs_to_the_upper_cell_and_the_number_below_it_to_the_lower() {
        // 0.3 / 0.1 is 2.999…96 in doubles, and 0.1 * 3 is 0.300…04: the border decides.
        let tenth = lattice(0.0, 0.0, 0.1);
        assert_eq!(tenth.cell_of(Vec2::new(0.1 * 3.0, -0.1)), Cell::new(3, -1));
        assert_eq!(tenth.cell_of(Vec2::new((0.1_f64 * 3.0).next_down(), 0.0)), Cell::new(2, 0));
        assert_eq!(tenth.cell_of(Vec2::new(-0.0, 0.0_f64.next_down())), Cell::new(0, -1));
    }

    #[test]
    fn far_and_broken_coordinates_stop_at_the_limit() {
        let l = lattice(0.0, 0.0, 0.05);
        let limit = CELL_LIMIT;
        assert_eq!(l.cell_of(Vec2::new(1e300, -1e300)), Cell::new(limit, -limit));
        assert_eq!(
            l.cell_of(Vec2::new(f64::INFINITY, f64::NEG_INFINITY)),
            Cell::new(limit, -limit)
        );
        assert_eq!(l.cell_of(Vec2::new(f64::NAN, 0.0)), Cell::new(-limit, 0));
        for bad in [f64::NAN, f64::INFINITY, -1e12, 1e12] {
            assert_eq!(l.cell_at(Vec2::new(bad, 0.0)), None);
            assert_eq!(l.cell_at(Vec2::new(0.0, bad)), None);
        }
        assert_eq!(l.cell_at(Vec2::new(5e7, -5e7)), Some(Cell::new(1_000_000_000, -1_000_000_000)));
    }

    #[test]
    fn a_lattice_without_measure_or_place_is_refused() {
        for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            let refused = Lattice::new(Vec2::zeros(), bad).unwrap_err();
            assert!(matches!(refused, MapError::Resolution { .. }), "{refused}");
        }
        assert!(Lattice::new(Vec2::new(f64::NAN, 0.0), 0.1).is_err());
        assert!(Lattice::new(Vec2::new(0.0, f64::INFINITY), 0.1).is_err());
    }

    #[test]
    fn boxes_keep_their_corners() {
        let a = CellBox::spanning(Cell::new(-2, -1), Cell::new(1, 3));
        assert_eq!((a.width, a.height, a.n_cells()), (4, 5, 20));
        let b = CellBox::spanning(Cell::new(0, 2), Cell::new(9, 9));
        assert_eq!(a.intersection(&b), CellBox::spanning(Cell::new(0, 2), Cell::new(1, 3)));
        assert_eq!(a.union(&b), CellBox::spanning(Cell::new(-2, -1), Cell::new(9, 9)));
        let apart = CellBox::spanning(Cell::new(5, 5), Cell::new(6, 6));
        assert!(a.intersection(&apart).is_empty());
        let empty = CellBox::spanning(Cell::new(3, 3), Cell::new(2, 9));
        assert!(empty.is_empty() && empty.grown(4).is_empty());
        assert_eq!((a.union(&empty), empty.union(&a)), (a, a));
        assert_eq!(a.grown(1), CellBox::spanning(Cell::new(-3, -2), Cell::new(2, 4)));
        assert_eq!(a.cells().count(), 20);
        for (i, cell) in a.cells().enumerate() {
            assert_eq!(a.index_of(cell), Some(i));
        }
        let (l, r) = (Cell::new(-3, 0), Cell::new(2, 0));
        assert!(!a.contains(l) && !a.contains(r) && !a.contains(Cell::new(0, 4)));
        let whole = CellBox::spanning(Cell::new(i32::MIN, 0), Cell::new(i32::MAX, 0));
        assert_eq!(whole.index_of(Cell::new(i32::MAX, 0)), Some(u32::MAX as usize));
    }

    proptest! {
        #[test]
        fn corners_and_the_numbers_below_them_are_told_apart(
            column in -2_000_000..2_000_000_i32,
            row in -2_000_000..2_000_000_i32,
            x in -1e3..1e3_f64,
            y in -1e3..1e3_f64,
            resolution_m in 1e-3..2.0_f64,
        ) {
            let l = lattice(x, y, resolution_m);
            let corner = l.corner_of(Cell::new(column, row));
            prop_assert_eq!(l.cell_of(corner), Cell::new(column, row));
            let below = Vec2::new(corner.x.next_down(), corner.y.next_down());
            prop_assert_eq!(l.cell_of(below), Cell::new(column - 1, row - 1));
            prop_assert_eq!(l.cell_of(l.centre_of(Cell::new(column, row))), Cell::new(column, row));
        }

        #[test]
        fn every_point_lies_in_its_cell(
            x in -1e4..1e4_f64, y in -1e4..1e4_f64, resolution_m in 1e-3..2.0_f64,
        ) {
            let l = lattice(-0.7, 0.31, resolution_m);
            let cell = l.cell_of(Vec2::new(x, y));
            let (low, high) = (l.corner_of(cell), l.corner_of(cell.offset(1, 1)));
            prop_assert!(low.x <= x && x < high.x && low.y <= y && y < high.y);
        }

        #[test]
        fn floor_is_the_floor(x in -1e9..1e9_f64, whole in -1000..1000_i32) {
            prop_assert_eq!(i64::from(floor(x)), x.floor() as i64);
            prop_assert_eq!(floor(f64::from(whole)), whole);
        }
    }
}
