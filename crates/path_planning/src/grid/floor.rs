//! Where one may go: a bit for each cell, row by row and column by column.

use std::cmp::Ordering;

use grid_maps::{Cell, SolidCells, Window, squared_distances};

/// Cells in a word.
pub(crate) const WORD: u32 = 64;

/// Which neighbours of a cell can be stepped to, by the 3 × 3 cells around it: bit k of the index is blocked cell
/// k, row by row from below; bit d of the value is direction d of [`STEPS`].
static OPEN_STEPS: [u8; 512] = open_steps();

/// Steps to the eight neighbours, counter-clockwise from +x: columns and rows.
pub(crate) const STEPS: [(i32, i32); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

const fn open_steps() -> [u8; 512] {
    let mut table = [0; 512];
    let mut around = 0;
    while around < 512 {
        let mut d = 0;
        while d < 8 {
            let (dx, dy) = STEPS[d];
            let to = around >> ((dy + 1) * 3 + dx + 1) & 1;
            // No corner is cut: both cells beside a diagonal step are free.
            let beside_x = around >> (3 + dx + 1) & 1;
            let beside_y = around >> ((dy + 1) * 3 + 1) & 1;
            let here = around >> 4 & 1;
            let closed = if dx != 0 && dy != 0 { to | beside_x | beside_y } else { to };
            if closed == 0 && here == 0 {
                table[around] |= 1 << d;
            }
            d += 1;
        }
        around += 1;
    }
    table
}

/// Where one may go on a map of cells.
///
/// One may step to the eight neighbours of a free cell that are free; a diagonal step needs both cells beside it
/// free, too: no corner is cut. Everything outside is blocked.
///
/// Memory: two bits for each cell.
#[derive(Clone, Debug)]
pub struct FreeFloor {
    width: usize,
    height: usize,
    /// Blocked cells, with a border of them around, row by row.
    pub(crate) rows: BitRows,
    /// The same with rows and columns exchanged.
    pub(crate) columns: BitRows,
}

/// Rows of bits, each beginning with a word.
#[derive(Clone, Debug)]
pub(crate) struct BitRows {
    pub(crate) words: Vec<u64>,
    /// Words of a row.
    pub(crate) n_words: u32,
}

impl BitRows {
    fn blocked(width: usize, height: usize) -> Self {
        let n_words = (width + 2).div_ceil(WORD as usize);
        // A row more above and below: words beside a row are looked at without asking whether they exist.
        let words = vec![u64::MAX; n_words * (height + 4)];
        Self { words, n_words: n_words as u32 }
    }

    /// The number of a bit; the first row and column are borders.
    fn bit(&self, column: usize, row: usize) -> u32 {
        (row as u32 + 2) * self.n_words * WORD + column as u32 + 1
    }

    fn free(&mut self, bit: u32) {
        self.words[(bit / WORD) as usize] &= !(1 << (bit % WORD));
    }

    fn block(&mut self, bit: u32) {
        self.words[(bit / WORD) as usize] |= 1 << (bit % WORD);
    }

    #[inline]
    pub(crate) fn is_blocked(&self, bit: u32) -> bool {
        self.words[(bit / WORD) as usize] >> (bit % WORD) & 1 != 0
    }

    /// The bits before, at and after a bit.
    #[inline]
    fn three(&self, bit: u32) -> usize {
        let (word, at) = ((bit / WORD) as usize, bit % WORD);
        let here = self.words[word];
        let three = match at {
            0 => here << 1 | self.words[word - 1] >> 63,
            63 => here >> 62 | self.words[word + 1] << 2,
            at => here >> (at - 1),
        };
        (three & 7) as usize
    }
}

impl FreeFloor {
    /// Of cells, some of which are blocked; the lower left one is cell (0, 0) here. O(cells).
    ///
    /// `None` for more cells than a number of 32 bits can count, 60 000 × 60 000.
    pub fn new<T: Copy>(cells: &Window<T>, is_blocked: impl Fn(T) -> bool) -> Option<Self> {
        let (width, height) = (cells.area().width, cells.area().height);
        let padded = |n: usize| n.checked_next_multiple_of(64)?.checked_add(128);
        let n_bits =
            padded(width)?.checked_mul(height + 8)?.max(padded(height)?.checked_mul(width + 8)?);
        u32::try_from(n_bits).ok()?;
        let mut rows = BitRows::blocked(width, height);
        let mut columns = BitRows::blocked(height, width);
        for (index, &value) in cells.values().iter().enumerate() {
            if !is_blocked(value) {
                let (column, row) = (index % width, index / width);
                rows.free(rows.bit(column, row));
                columns.free(columns.bit(row, column));
            }
        }
        Some(Self { width, height, rows, columns })
    }

    /// Of the solid cells of a map.
    pub fn of_solid(solid: &SolidCells) -> Option<Self> {
        Self::new(&window_of(solid)?, |is_solid| is_solid)
    }

    /// For a disc of `radius_cells` around its middle: blocked is a cell at whose middle the disc would reach into a
    /// solid one. What is outside of the map counts as the map's own rule says. O(cells).
    pub fn of_solid_for_disc(solid: &SolidCells, radius_cells: f64) -> Option<Self> {
        let window = window_of(solid)?;
        let squared = squared_distances(&window, |is_solid| is_solid);
        // From a cell's middle to the nearest side of another one it is half a cell less than to its middle.
        let limit = (radius_cells + 0.5).max(0.0).powi(2);
        Self::new(&squared, |squared| {
            squared == 0 || radius_cells > 0.0 && f64::from(squared) < limit
        })
    }

    /// Blocks the cells whose middles are within so many cells of the middle of a cell; those outside are anyway.
    pub fn block_disc(&mut self, centre: Cell, radius_cells: f64) {
        let reach = radius_cells.clamp(0.0, 1e4).floor() as i32;
        for row in -reach..=reach {
            for column in -reach..=reach {
                let (dx, dy) = (f64::from(column), f64::from(row));
                let there = Cell {
                    column: centre.column.saturating_add(column),
                    row: centre.row.saturating_add(row),
                };
                if dx * dx + dy * dy <= radius_cells * radius_cells
                    && let Some(node) = self.node(there)
                {
                    let turned = self.turned(node);
                    self.rows.block(node);
                    self.columns.block(turned);
                }
            }
        }
    }

    /// Cells of a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether a cell is inside and free.
    pub fn is_free(&self, cell: Cell) -> bool {
        self.node(cell).is_some_and(|node| !self.rows.is_blocked(node))
    }

    /// The number of a cell; `None` outside.
    pub(crate) fn node(&self, cell: Cell) -> Option<u32> {
        let (column, row) = (usize::try_from(cell.column).ok()?, usize::try_from(cell.row).ok()?);
        (column < self.width && row < self.height).then(|| self.rows.bit(column, row))
    }

    /// Numbers that cells can have are below this.
    pub(crate) fn n_nodes(&self) -> usize {
        self.rows.words.len() * WORD as usize
    }

    /// From one row to the next, in numbers of cells.
    #[inline]
    pub(crate) fn stride(&self) -> u32 {
        self.rows.n_words * WORD
    }

    #[inline]
    pub(crate) fn cell(&self, node: u32) -> Cell {
        let stride = self.stride();
        Cell { column: (node % stride) as i32 - 1, row: (node / stride) as i32 - 2 }
    }

    /// The number of the cell's bit in [`columns`](Self::columns).
    #[inline]
    pub(crate) fn turned(&self, node: u32) -> u32 {
        let stride = self.stride();
        let (column, row) = (node % stride - 1, node / stride - 2);
        (column + 2) * self.columns.n_words * WORD + row + 1
    }

    /// The number of the cell by that of its bit in [`columns`](Self::columns).
    #[inline]
    pub(crate) fn turned_back(&self, bit: u32) -> u32 {
        let stride = self.columns.n_words * WORD;
        let (row, column) = (bit % stride - 1, bit / stride - 2);
        (row + 2) * self.stride() + column + 1
    }

    /// The directions in which one may step from a cell, a bit each.
    #[inline]
    pub(crate) fn open_steps(&self, node: u32) -> u8 {
        let stride = self.stride();
        let around = self.rows.three(node - stride)
            | self.rows.three(node) << 3
            | self.rows.three(node + stride) << 6;
        OPEN_STEPS[around]
    }

    /// How the number of a cell changes in each direction.
    pub(crate) fn offsets(&self) -> [u32; 8] {
        let stride = self.stride() as i32;
        // Wrapping sums of unsigned numbers stand for signed steps.
        STEPS.map(|(dx, dy)| (dy * stride + dx) as u32)
    }

    /// Whether the straight line between the middles of two cells crosses free cells only. Where it passes exactly through a
    /// corner, both cells beside it must be free. O(cells crossed).
    pub fn sees(&self, from: Cell, to: Cell) -> bool {
        if !self.is_free(from) || !self.is_free(to) {
            return false;
        }
        let (dx, dy) = ((to.column - from.column).abs(), (to.row - from.row).abs());
        let (step_x, step_y) = ((to.column - from.column).signum(), (to.row - from.row).signum());
        let mut at = from;
        // Twice the signed area: positive when the next border that is met is a vertical one.
        let mut ahead = i64::from(dx) - i64::from(dy);
        let mut left = dx + dy;
        while left > 0 {
            match ahead.cmp(&0) {
                Ordering::Greater => {
                    at.column += step_x;
                    ahead -= 2 * i64::from(dy);
                    left -= 1;
                }
                Ordering::Less => {
                    at.row += step_y;
                    ahead += 2 * i64::from(dx);
                    left -= 1;
                }
                Ordering::Equal => {
                    let beside = [
                        Cell { column: at.column + step_x, row: at.row },
                        Cell { column: at.column, row: at.row + step_y },
                    ];
                    if beside.iter().any(|&cell| !self.is_free(cell)) {
                        return false;
                    }
                    at = Cell { column: at.column + step_x, row: at.row + step_y };
                    ahead += 2 * (i64::from(dx) - i64::from(dy));
                    left -= 2;
                }
            }
            if !self.is_free(at) {
                return false;
            }
        }
        true
    }
}

fn window_of(solid: &SolidCells) -> Option<Window<bool>> {
    let area =
        grid_maps::CellBox { min: Cell::new(0, 0), width: solid.width(), height: solid.height() };
    let mut window = Window::filled(area, false).ok()?;
    for row in 0..solid.height() as i32 {
        for (column, value) in (0..).zip(window.row_mut(row)) {
            *value = solid.is_solid(Cell::new(column, row));
        }
    }
    Some(window)
}

#[cfg(test)]
mod tests {
    use grid_maps::CellBox;
    use proptest::prelude::*;

    use super::*;

    fn floor(width: usize, blocked: &[bool]) -> FreeFloor {
        let area = CellBox { min: Cell::new(0, 0), width, height: blocked.len() / width };
        FreeFloor::new(&Window::from_values(area, blocked.to_vec()).unwrap(), |b| b).unwrap()
    }

    proptest! {
        /// Oracle: every neighbour asked one by one; rows longer than a word and shorter.
        #[test]
        fn open_steps_are_those_that_cut_no_corner(
            width in prop_oneof![1_usize..9, 60_usize..70, 125_usize..131],
            bits in proptest::collection::vec(prop::bool::weighted(0.3), 131 * 5),
        ) {
            let floor = floor(width, &bits[..5 * width]);
            let free = |x: i32, y: i32| {
                (0..width as i32).contains(&x) && (0..5).contains(&y) && !bits[(y as usize) * width + x as usize]
            };
            for y in 0..5 {
                for x in 0..width as i32 {
                    let node = floor.node(Cell::new(x, y)).unwrap();
                    prop_assert_eq!(floor.cell(node), Cell::new(x, y));
                    prop_assert_eq!(floor.turned_back(floor.turned(node)), node);
                    prop_assert_eq!(floor.columns.is_blocked(floor.turned(node)), !free(x, y));
                    prop_assert_eq!(floor.is_free(Cell::new(x, y)), free(x, y));
                    for (d, (dx, dy)) in STEPS.into_iter().enumerate() {
                        let open = free(x, y) && free(x + dx, y) && free(x, y + dy) && free(x + dx, y + dy);
                        prop_assert_eq!(floor.open_steps(node) >> d & 1 == 1, open, "{} {} {}", x, y, d);
                    }
                }
            }
        }

        /// Oracle: exact crossing of the segment with each cell's open square, in whole numbers.
        #[test]
        fn a_line_sees_where_no_blocked_cell_is_entered(
            bits in proptest::collection::vec(prop::bool::weighted(0.15), 12 * 9),
            (x0, y0, x1, y1) in (0..12_i32, 0..9_i32, 0..12_i32, 0..9_i32),
        ) {
            let floor = floor(12, &bits);
            let (dx, dy) = (i64::from(x1 - x0), i64::from(y1 - y0));
            let touches = |x: i32, y: i32| {
                // The square in coordinates of twice the cells, its corners against the line; then the boxes.
                let side = |cx: i64, cy: i64| dx * (cy - 2 * i64::from(y0)) - dy * (cx - 2 * i64::from(x0));
                let (cx, cy) = (2 * i64::from(x), 2 * i64::from(y));
                let sides = [(1, 1), (1, -1), (-1, 1), (-1, -1)].map(|(a, b)| side(cx + a, cy + b));
                let apart = sides.iter().all(|s| *s > 0) || sides.iter().all(|s| *s < 0);
                let within = (x0.min(x1)..=x0.max(x1)).contains(&x) && (y0.min(y1)..=y0.max(y1)).contains(&y);
                // A corner alone blocks where the line goes on through it, that is within the box of its ends.
                !apart && within
            };
            let open = (0..9).all(|y| (0..12).all(|x| !touches(x, y) || !bits[(y * 12 + x) as usize]));
            prop_assert_eq!(floor.sees(Cell::new(x0, y0), Cell::new(x1, y1)), open);
        }
    }
}
