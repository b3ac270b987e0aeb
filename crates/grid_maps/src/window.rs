//! A dense rectangle of cells, for kernels that want rows of memory.

use crate::{Cell, CellBox, MapError};

/// Cells that a [`Window`] may have: 2²⁸, a square of 16 384.
pub const WINDOW_CELLS_MAX: usize = 1 << 28;

/// One value for each cell of a rectangle, row by row from the bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Window<T> {
    area: CellBox,
    values: Vec<T>,
}

impl<T: Copy> Window<T> {
    /// A window with the same value everywhere.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`] above [`WINDOW_CELLS_MAX`] cells.
    pub fn filled(area: CellBox, value: T) -> Result<Self, MapError> {
        Self::checked(area)?;
        Ok(Self { area, values: vec![value; area.n_cells()] })
    }

    /// A window of the given values, row by row from the bottom.
    ///
    /// # Errors
    ///
    /// [`MapError::Length`] when there are not as many values as cells, and
    /// [`MapError::TooLarge`] above [`WINDOW_CELLS_MAX`] cells.
    pub fn from_values(area: CellBox, values: Vec<T>) -> Result<Self, MapError> {
        Self::checked(area)?;
        if values.len() != area.n_cells() {
            return Err(MapError::Length {
                format: "window",
                found: values.len(),
                expected: area.n_cells(),
                unit: "values",
            });
        }
        Ok(Self { area, values })
    }

    /// Whether a window may cover `area`.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`] above [`WINDOW_CELLS_MAX`] cells.
    pub(crate) fn checked(area: CellBox) -> Result<(), MapError> {
        let last = i64::from(i32::MAX);
        let beyond = area.column_end() > last || area.row_end() > last;
        if beyond || area.n_cells() > WINDOW_CELLS_MAX {
            let CellBox { width, height, .. } = area;
            return Err(MapError::TooLarge { width, height, n_max: WINDOW_CELLS_MAX });
        }
        Ok(())
    }

    /// The cells it covers.
    pub const fn area(&self) -> CellBox {
        self.area
    }

    /// All values, row by row from the bottom.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, to be changed.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The value of a cell, or `None` outside.
    pub fn get(&self, cell: Cell) -> Option<T> {
        self.area.index_of(cell).map(|index| self.values[index])
    }

    /// The value of a cell, to be changed, or `None` outside.
    pub fn get_mut(&mut self, cell: Cell) -> Option<&mut T> {
        self.area.index_of(cell).map(|index| &mut self.values[index])
    }

    /// The values of a row from left to right; empty outside.
    pub fn row(&self, row: i32) -> &[T] {
        match self.area.index_of(Cell { column: self.area.min.column, row }) {
            Some(start) => &self.values[start..start + self.area.width],
            None => &[],
        }
    }

    /// The values of a row, to be changed; empty outside.
    pub fn row_mut(&mut self, row: i32) -> &mut [T] {
        match self.area.index_of(Cell { column: self.area.min.column, row }) {
            Some(start) => &mut self.values[start..start + self.area.width],
            None => &mut [],
        }
    }

    /// Cells and values, row by row from the bottom.
    pub fn iter(&self) -> impl Iterator<Item = (Cell, T)> + '_ {
        self.area.cells().zip(self.values.iter().copied())
    }

    /// A window of the same cells with other values.
    #[must_use]
    pub fn map<U: Copy>(&self, value_of: impl FnMut(T) -> U) -> Window<U> {
        Window { area: self.area, values: self.values.iter().copied().map(value_of).collect() }
    }

    /// The same values under other cells: the lower left one becomes `min`.
    #[must_use]
    pub fn moved_to(mut self, min: Cell) -> Self {
        self.area.min = min;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered() -> Window<usize> {
        let area = CellBox::spanning(Cell::new(-1, 4), Cell::new(1, 5));
        Window::from_values(area, (0..6).collect()).unwrap()
    }

    #[test]
    fn rows_lie_one_above_the_other() {
        let mut window = numbered();
        assert_eq!((window.row(4), window.row(5)), (&[0, 1, 2][..], &[3, 4, 5][..]));
        assert_eq!((window.row(3), window.row(6)), (&[][..], &[][..]));
        assert_eq!(window.get(Cell::new(1, 4)), Some(2));
        assert_eq!(window.get(Cell::new(2, 4)), None);
        *window.get_mut(Cell::new(-1, 5)).unwrap() = 9;
        window.row_mut(4)[1] = 7;
        assert_eq!(window.values(), &[0, 7, 2, 9, 4, 5]);
        assert!(window.row_mut(9).is_empty());
        assert_eq!(window.iter().nth(3), Some((Cell::new(-1, 5), 9)));
    }

    #[test]
    fn a_window_may_be_renamed_and_rewritten() {
        let window = numbered().moved_to(Cell::new(10, 20)).map(|v| v as f64 * 0.5);
        assert_eq!(window.get(Cell::new(11, 21)), Some(2.0));
    }

    #[test]
    fn too_many_or_too_few_values_are_refused() {
        let area = CellBox { min: Cell::new(0, 0), width: 1 << 20, height: 1 << 20 };
        let refused = Window::filled(area, 0_u8).unwrap_err();
        assert!(refused.to_string().starts_with("1048576 × 1048576 cells at once"), "{refused}");
        let endless = CellBox { min: Cell::new(0, 0), width: usize::MAX, height: 2 };
        assert!(Window::filled(endless, 0_u8).is_err());
        let small = CellBox { min: Cell::new(0, 0), width: 2, height: 2 };
        assert!(Window::from_values(small, vec![1, 2, 3]).is_err());
    }
}
