//! What of a map is solid, and the straight pieces of border around it.
//!
//! The border runs along the sides of cells, so it is exact: a piece begins and ends at corners of
//! the lattice, pieces in one line are joined, and where two meet they share the corner. Cells that
//! touch at a corner only are two bodies, and the corner belongs to the border of both.

use geometry::{Segment, Vec2};

use crate::{Cell, Window};

/// Cells in a word.
const WORD: usize = u64::BITS as usize;

/// The solid cells of a window, one bit each.
///
/// ```
/// use grid_maps::{Cell, CellBox, SolidCells, Window};
///
/// let area = CellBox { min: Cell::new(0, 0), width: 4, height: 3 };
/// let mut picture = Window::filled(area, '.')?;
/// picture.row_mut(1).copy_from_slice(&['.', '#', '#', '.']);
/// let solid = SolidCells::new(&picture, |c| c == '#', false);
/// // Two long sides and two short ones.
/// assert_eq!(solid.borders().len(), 4);
/// # Ok::<(), grid_maps::MapError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SolidCells {
    width: usize,
    height: usize,
    /// Row by row from the bottom, with one more bit than cells in a row: what is beyond.
    words: Vec<u64>,
    beyond: bool,
}

/// A straight piece of border, between corners of cells counted from the window's lower left
/// corner. What is solid lies to its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Border {
    /// Column and row of the corner where it begins.
    pub from: [u32; 2],
    /// Column and row of the corner where it ends; in the same column or row.
    pub to: [u32; 2],
}

impl Border {
    /// The piece where cells have sides of `side_m` and the window's lower left corner is the origin.
    pub fn segment(self, side_m: f64) -> Segment {
        let corner = |[x, y]: [u32; 2]| Vec2::new(f64::from(x) * side_m, f64::from(y) * side_m);
        Segment { a: corner(self.from), b: corner(self.to) }
    }
}

impl SolidCells {
    /// The cells for which `is_solid` says so; `beyond` is whether everything outside of the window
    /// is solid, too. O(cells).
    pub fn new<T: Copy>(cells: &Window<T>, is_solid: impl Fn(T) -> bool, beyond: bool) -> Self {
        let (width, height) = (cells.area().width, cells.area().height);
        let n_words = width / WORD + 1;
        let mut words = vec![if beyond { u64::MAX } else { 0 }; n_words * height];
        if width > 0 {
            let rows = cells.values().chunks_exact(width).zip(words.chunks_exact_mut(n_words));
            for (row, words) in rows {
                for (word, cells) in words.iter_mut().zip(row.chunks(WORD)) {
                    let solid =
                        |bits: u64, (i, &cell): (usize, &T)| bits | u64::from(is_solid(cell)) << i;
                    let rest = if cells.len() < WORD { *word << cells.len() } else { 0 };
                    *word = cells.iter().enumerate().fold(rest, solid);
                }
            }
        }
        Self { width, height, words, beyond }
    }

    /// Cells of a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub const fn height(&self) -> usize {
        self.height
    }

    /// Whether a cell, counted from the window's lower left one, is solid.
    pub fn is_solid(&self, cell: Cell) -> bool {
        let (Ok(column), Ok(row)) = (usize::try_from(cell.column), usize::try_from(cell.row))
        else {
            return self.beyond;
        };
        if column >= self.width || row >= self.height {
            return self.beyond;
        }
        self.row(row)[column / WORD] >> (column % WORD) & 1 == 1
    }

    /// How many cells of the window are solid. O(cells / 64).
    pub fn n_solid(&self) -> usize {
        let ones =
            |words: &[u64]| words.iter().map(|word| word.count_ones() as usize).sum::<usize>();
        let padding = if self.beyond { self.n_words() * WORD - self.width } else { 0 };
        ones(&self.words) - padding * self.height
    }

    /// The border between what is solid and what is not, in as few pieces as there can be: those
    /// along rows from below, then those along columns.
    ///
    /// O(cells / 64 + pieces); the order depends on the cells alone.
    pub fn borders(&self) -> Vec<Border> {
        let mut borders = Vec::new();
        self.along_rows(&mut borders);
        self.along_columns(&mut borders);
        borders
    }

    const fn n_words(&self) -> usize {
        self.width / WORD + 1
    }

    fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.n_words()..(row + 1) * self.n_words()]
    }

    /// Where of two rows only one is solid: runs of equal bits.
    fn along_rows(&self, borders: &mut Vec<Border>) {
        let outside = vec![if self.beyond { u64::MAX } else { 0 }; self.n_words()];
        for y in 0..=self.height {
            let below = if y == 0 { &outside[..] } else { self.row(y - 1) };
            let above = if y == self.height { &outside[..] } else { self.row(y) };
            let y = y as u32;
            // To the right with what is above it on the left, and back with what is below.
            runs(above.iter().zip(below).map(|(above, below)| above & !below), |from, to| {
                borders.push(Border { from: [from, y], to: [to, y] });
            });
            runs(above.iter().zip(below).map(|(above, below)| below & !above), |from, to| {
                borders.push(Border { from: [to, y], to: [from, y] });
            });
        }
    }

    /// Where a cell and its left neighbour differ: columns of equal bits, followed upwards.
    fn along_columns(&self, borders: &mut Vec<Border>) {
        let n_words = self.n_words();
        // Of borders with the solid cell to the left and to the right: which are open, and since when.
        let mut open = [vec![0_u64; n_words], vec![0_u64; n_words]];
        let mut since = [vec![0_u32; self.width + 1], vec![0_u32; self.width + 1]];
        for y in 0..=self.height {
            let mut left = u64::from(self.beyond);
            for i in 0..n_words {
                let here = if y < self.height { self.row(y)[i] } else { 0 };
                let there = here << 1 | left;
                left = here >> (WORD - 1);
                let now = if y < self.height { [there & !here, here & !there] } else { [0, 0] };
                for (side, now) in now.into_iter().enumerate() {
                    let before = std::mem::replace(&mut open[side][i], now);
                    for_ones(before & !now, |bit| {
                        let x = i * WORD + bit;
                        let (low, high) = ([x as u32, since[side][x]], [x as u32, y as u32]);
                        let (from, to) = if side == 0 { (low, high) } else { (high, low) };
                        borders.push(Border { from, to });
                    });
                    for_ones(now & !before, |bit| since[side][i * WORD + bit] = y as u32);
                }
            }
        }
    }
}

fn for_ones(mut word: u64, mut tell: impl FnMut(usize)) {
    while word != 0 {
        tell(word.trailing_zeros() as usize);
        word &= word - 1;
    }
}

/// Tells begin and end of each run of ones, counted over all words.
fn runs(words: impl Iterator<Item = u64>, mut tell: impl FnMut(u32, u32)) {
    let mut begin = None;
    let mut at = 0_u32;
    for word in words {
        let mut bit = 0;
        while bit < u64::BITS {
            let rest = word >> bit;
            if begin.is_some() {
                let n = (!rest).trailing_zeros();
                // Shifted in from above are zeros, which end a run only if they are bits of the word.
                if bit + n >= u64::BITS {
                    break;
                }
                if let Some(from) = begin.take() {
                    tell(from, at + bit + n);
                }
                bit += n;
            } else {
                if rest == 0 {
                    break;
                }
                bit += rest.trailing_zeros();
                begin = Some(at + bit);
            }
        }
        at += u64::BITS;
    }
    if let Some(from) = begin {
        tell(from, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellBox;
    use proptest::{collection::vec, prelude::*};

    fn window(width: usize, values: Vec<bool>) -> Window<bool> {
        let area = CellBox { min: Cell::new(-3, 5), width, height: values.len() / width };
        Window::from_values(area, values).unwrap()
    }

    /// Sides of cells that are border: (corner, whether along x, whether the solid cell is to the left).
    type Side = (u32, u32, bool, bool);

    fn sides_of(borders: &[Border]) -> Vec<Side> {
        let mut sides = Vec::new();
        for Border { from, to } in borders {
            let along_x = from[1] == to[1];
            let axis = usize::from(!along_x);
            let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
            for i in low..high {
                let corner = if along_x { (i, from[1]) } else { (from[0], i) };
                sides.push((corner.0, corner.1, along_x, from[axis] < to[axis]));
            }
        }
        sides.sort_unstable();
        sides
    }

    proptest! {
        /// Oracle: each side of each cell, looked at on its own.
        #[test]
        fn borders_are_the_sides_between_solid_and_free(
            width in prop_oneof![1..9_usize, 60..70_usize, 126..131_usize],
            bits in vec(prop_oneof![Just(true), Just(false), Just(true)], 131 * 5),
            height in 1..6_usize,
            beyond: bool,
        ) {
            let cells = window(width, bits[..width * height].to_vec());
            let solid = SolidCells::new(&cells, |bit| bit, beyond);
            let at = |x: i32, y: i32| cells.get(Cell::new(x - 3, y + 5)).unwrap_or(beyond);
            let mut expected = Vec::new();
            let mut n_solid = 0;
            for y in 0..=height as i32 {
                for x in 0..=width as i32 {
                    prop_assert_eq!(solid.is_solid(Cell::new(x, y)), at(x, y));
                    n_solid += usize::from(x < width as i32 && y < height as i32 && at(x, y));
                    if x < width as i32 && at(x, y) != at(x, y - 1) {
                        expected.push((x as u32, y as u32, true, at(x, y)));
                    }
                    if y < height as i32 && at(x, y) != at(x - 1, y) {
                        expected.push((x as u32, y as u32, false, at(x - 1, y)));
                    }
                }
            }
            expected.sort_unstable();
            let borders = solid.borders();
            prop_assert_eq!(sides_of(&borders), expected);
            prop_assert_eq!(solid.n_solid(), n_solid);
            // None can be joined to another: no two with the same direction meet end to end.
            for one in &borders {
                let way = |b: &Border| (b.from[0].cmp(&b.to[0]), b.from[1].cmp(&b.to[1]));
                prop_assert!(!borders.iter().any(|two| one.to == two.from && way(one) == way(two)));
            }
        }
    }

    #[test]
    fn a_ring_is_two_squares_and_its_hole_is_inside_out() {
        let mut bits = vec![true; 25];
        for i in [6, 7, 8, 11, 12, 13, 16, 17, 18] {
            bits[i] = false;
        }
        let solid = SolidCells::new(&window(5, bits), |bit| bit, false);
        let borders = solid.borders();
        assert_eq!((borders.len(), solid.n_solid()), (8, 16));
        let has = |from, to| borders.contains(&Border { from, to });
        assert!(has([0, 0], [5, 0]) && has([5, 0], [5, 5]), "outside: counter-clockwise");
        assert!(has([4, 1], [1, 1]) && has([1, 1], [1, 4]), "inside: clockwise");
        // Twice the area within, by the shoelace formula: of the material only.
        let area: f64 = borders.iter().map(|b| b.segment(0.5)).map(|s| s.a.perp(&s.b)).sum();
        assert!((area / 2.0 - 16.0 * 0.25).abs() < 1e-12);
    }

    #[test]
    fn nothing_outside_is_border_when_all_is_solid() {
        let all = window(64, vec![true; 128]);
        assert_eq!(SolidCells::new(&all, |bit| bit, true).borders(), []);
        assert_eq!(SolidCells::new(&all, |bit| bit, false).borders().len(), 4);
        assert_eq!(SolidCells::new(&all, |bit| !bit, true).borders().len(), 4);
        let none = Window::filled(CellBox { min: Cell::new(0, 0), width: 0, height: 0 }, true);
        assert_eq!(SolidCells::new(&none.unwrap(), |bit| bit, true).borders(), []);
    }
}
