//! The grid of sources: geometry and values.

use std::collections::BTreeMap;

use geometry::Vec2;
use run_context::StateHash;

use crate::deposit::Deposit;

/// The strongest source. Larger cell values are reserved (walls, by convention) and smell of nothing.
pub const VALUE_MAX: u8 = 127;

/// The most cells a field may have: 2²⁶, 64 MB of memory.
pub(crate) const CELLS_MAX: usize = 1 << 26;

/// A rectangular grid of pheromone sources, fixed to the map frame.
///
/// Cell values: 0 is empty, 1..=127 the intensity of a source at the cell's centre, 128..=255 reserved:
/// kept, shown, but perceived as nothing.
///
/// Geometry: columns count from the left (−x), **rows from the top (+y)**, as the matrix stands in a
/// text file. The map's origin is the centre of the cell in column ⌊width/2⌋ and row ⌊height/2⌋.
///
/// Memory: one byte and one bit per cell, and 24 bytes per evaporating deposit.
///
/// Source: the thesis, Annex B1. Differences: rectangular maps as well as square ones; metres.
///
/// ```
/// use geometry::Se2;
/// use pheromones::{Field, SenseConfig};
///
/// let field = Field::from_text("0 0 0\n1 1 1\n0 0 0", 0.2).unwrap();
/// let left_of_it = Se2::new(-0.2, 0.05, 0.0);
/// let smell = field.sense(left_of_it, &SenseConfig::default());
/// assert!(smell.right > smell.left, "the trail is on the right");
/// ```
#[derive(Clone, Debug)]
pub struct Field {
    width: usize,
    height: usize,
    cell_size_m: f64,
    /// Row-major, first row on top.
    values: Vec<u8>,
    /// One bit per cell that is a source; rows start at a word, so that empty stretches can be skipped.
    occupancy: Vec<u64>,
    n_sources: usize,
    revision: u64,
    /// The evaporating part, by cell index.
    pub(crate) deposits: BTreeMap<usize, Deposit>,
}

/// Equal in size, values and deposits; the revision does not count.
impl PartialEq for Field {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width
            && self.height == other.height
            && self.cell_size_m.total_cmp(&other.cell_size_m).is_eq()
            && self.values == other.values
            && self.deposits == other.deposits
    }
}

/// One cell that smells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Column, from the left.
    pub col: usize,
    /// Row, from the top.
    pub row: usize,
    /// The cell's centre in the map frame (m).
    pub in_map: Vec2,
    /// Intensity, 1..=127.
    pub value: u8,
}

/// A field that cannot be made, or a cell that is not there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// No cells, or too many.
    #[error(
        "a pheromone field of {width} x {height} cells: each side must be at least 1 and the whole at \
         most {CELLS_MAX} cells; use larger cells"
    )]
    Size {
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
    },
    /// Cells of no usable size.
    #[error("pheromone cell size {cell_size_m} m: must be from 0.001 to 100 m")]
    CellSize {
        /// The size asked for, metres.
        cell_size_m: f64,
    },
    /// A cell beyond the border.
    #[error("cell (column {col}, row {row}) is outside the field of {width} x {height} cells")]
    Outside {
        /// The column asked for.
        col: usize,
        /// The row asked for.
        row: usize,
        /// Columns there are.
        width: usize,
        /// Rows there are.
        height: usize,
    },
}

impl Field {
    /// Makes an empty field.
    ///
    /// # Errors
    ///
    /// [`FieldError::Size`] and [`FieldError::CellSize`].
    pub fn new(width: usize, height: usize, cell_size_m: f64) -> Result<Self, FieldError> {
        let n_cells = width.checked_mul(height).filter(|&n| (1..=CELLS_MAX).contains(&n));
        let Some(n_cells) = n_cells else {
            return Err(FieldError::Size { width, height });
        };
        if !(0.001..=100.0).contains(&cell_size_m) {
            return Err(FieldError::CellSize { cell_size_m });
        }
        Ok(Self {
            width,
            height,
            cell_size_m,
            values: vec![0; n_cells],
            occupancy: vec![0; height * width.div_ceil(64)],
            n_sources: 0,
            revision: 0,
            deposits: BTreeMap::new(),
        })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Side of a cell, metres.
    pub fn cell_size_m(&self) -> f64 {
        self.cell_size_m
    }

    /// Grows with every change of any value; two equal revisions of one field mean equal values.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Cells with a value of 1..=127.
    pub fn n_sources(&self) -> usize {
        self.n_sources
    }

    /// All values, row-major, first row on top.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    /// A cell's value; 0 outside the field.
    pub fn value(&self, col: usize, row: usize) -> u8 {
        if col < self.width && row < self.height { self.values[row * self.width + col] } else { 0 }
    }

    /// Writes a cell, any value. What was deposited there is gone.
    ///
    /// # Errors
    ///
    /// [`FieldError::Outside`]; nothing is changed.
    pub fn set(&mut self, col: usize, row: usize, value: u8) -> Result<(), FieldError> {
        let cell_index = self.cell_index(col, row)?;
        self.deposits.remove(&cell_index);
        self.put(cell_index, value);
        Ok(())
    }

    /// Empties every cell.
    pub fn clear(&mut self) {
        self.values.fill(0);
        self.occupancy.fill(0);
        self.deposits.clear();
        self.n_sources = 0;
        self.revision += 1;
    }

    /// The same trail on a grid of another size, the origin kept; what falls outside is lost.
    ///
    /// # Errors
    ///
    /// [`FieldError::Size`].
    pub fn resized(&self, width: usize, height: usize) -> Result<Self, FieldError> {
        let mut resized = Self::new(width, height, self.cell_size_m)?;
        for (cell_index, &value) in self.values.iter().enumerate().filter(|&(_, &v)| v != 0) {
            let (col, row) = (cell_index % self.width, cell_index / self.width);
            let new_col = (col + width / 2).checked_sub(self.width / 2).filter(|&c| c < width);
            let new_row = (row + height / 2).checked_sub(self.height / 2).filter(|&r| r < height);
            if let (Some(new_col), Some(new_row)) = (new_col, new_row) {
                let new_index = new_row * width + new_col;
                resized.put(new_index, value);
                if let Some(&deposit) = self.deposits.get(&cell_index) {
                    resized.deposits.insert(new_index, deposit);
                }
            }
        }
        Ok(resized)
    }

    /// The centre of a cell in the map frame (m); cells beyond the border have centres as well.
    pub fn cell_centre(&self, col: usize, row: usize) -> Vec2 {
        Vec2::new(self.column_x_m(col), self.row_y_m(row))
    }

    /// The column and row of the cell that holds a point (m, map frame), or `None` outside. A point on
    /// an edge belongs to the cell with the larger x, or y.
    pub fn cell_at(&self, point_in_map: Vec2) -> Option<(usize, usize)> {
        let col = (point_in_map.x / self.cell_size_m + 0.5).floor() + (self.width / 2) as f64;
        let row = (self.height / 2) as f64 - (point_in_map.y / self.cell_size_m + 0.5).floor();
        let inside =
            (0.0..self.width as f64).contains(&col) && (0.0..self.height as f64).contains(&row);
        inside.then_some((col as usize, row as usize))
    }

    /// All sources, row by row from the top. O(cells / 64 + sources).
    pub fn sources(&self) -> impl Iterator<Item = Source> + '_ {
        let words_per_row = self.words_per_row();
        self.occupancy.iter().enumerate().flat_map(move |(word_index, &word)| {
            let (row, first_col) = (word_index / words_per_row, word_index % words_per_row * 64);
            ones(word).map(move |bit| self.source(first_col + bit, row))
        })
    }

    /// Mixes size, values and deposits into `hash`.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.width as u64);
        hash.absorb_u64(self.height as u64);
        hash.absorb(self.cell_size_m);
        hash.absorb_bytes(&self.values);
        for (&cell_index, deposit) in &self.deposits {
            hash.absorb_u64(cell_index as u64);
            hash.absorb_u64(u64::from(deposit.base) << 8 | u64::from(deposit.peak));
            hash.absorb_u64(deposit.age_ns);
        }
    }

    pub(crate) fn cell_index(&self, col: usize, row: usize) -> Result<usize, FieldError> {
        if col < self.width && row < self.height {
            Ok(row * self.width + col)
        } else {
            Err(FieldError::Outside { col, row, width: self.width, height: self.height })
        }
    }

    /// Writes a value and keeps bits, count and revision true.
    pub(crate) fn put(&mut self, cell_index: usize, value: u8) {
        let old = self.values[cell_index];
        if old == value {
            return;
        }
        self.values[cell_index] = value;
        self.revision += 1;
        let (col, row) = (cell_index % self.width, cell_index / self.width);
        let word_index = row * self.words_per_row() + col / 64;
        let bit = 1_u64 << (col % 64);
        match (is_source(old), is_source(value)) {
            (false, true) => {
                self.occupancy[word_index] |= bit;
                self.n_sources += 1;
            }
            (true, false) => {
                self.occupancy[word_index] &= !bit;
                self.n_sources -= 1;
            }
            _ => {}
        }
    }

    pub(crate) fn column_x_m(&self, col: usize) -> f64 {
        (col as f64 - (self.width / 2) as f64) * self.cell_size_m
    }

    pub(crate) fn row_y_m(&self, row: usize) -> f64 {
        ((self.height / 2) as f64 - row as f64) * self.cell_size_m
    }

    /// The occupancy words of a row: bit `col % 64` of word `col / 64`.
    pub(crate) fn occupancy_row(&self, row: usize) -> &[u64] {
        let words_per_row = self.words_per_row();
        &self.occupancy[row * words_per_row..][..words_per_row]
    }

    fn words_per_row(&self) -> usize {
        self.width.div_ceil(64)
    }

    fn source(&self, col: usize, row: usize) -> Source {
        Source { col, row, in_map: self.cell_centre(col, row), value: self.value(col, row) }
    }
}

/// Whether a cell of this value smells.
pub(crate) fn is_source(value: u8) -> bool {
    (1..=VALUE_MAX).contains(&value)
}

/// The positions of the ones in a word, lowest first.
pub(crate) fn ones(word: u64) -> impl Iterator<Item = usize> {
    let mut rest = word;
    std::iter::from_fn(move || {
        (rest != 0).then(|| {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            bit
        })
    })
}

#[cfg(test)]
#[path = "field_tests.rs"]
mod tests;
