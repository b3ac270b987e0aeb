//! A sheet of probabilities that grows where it is written, up to a limit.

/// Most cells that a board may have: 128 MiB.
const CELLS_MAX: i64 = 1 << 24;
/// Cells added beyond what is needed when a board grows.
const BORDER_CELLS: i64 = 128;

/// Probabilities of being occupied by row (along x) and column (along y), both counted from 1 as in
/// the source; cells never written are 0.5.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    first_row: i64,
    first_column: i64,
    n_rows: i64,
    n_columns: i64,
    unknown_prob: f64,
    probs: Vec<f64>,
}

impl Board {
    /// Rows and columns 1 to `n_cells`, all unknown.
    pub(super) fn square(n_cells: usize) -> Self {
        Self::square_of(n_cells, 0.5)
    }

    /// The same with another value of what is unknown.
    pub(super) fn square_of(n_cells: usize, unknown_prob: f64) -> Self {
        let n = n_cells as i64;
        let probs = vec![unknown_prob; n_cells * n_cells];
        Self { first_row: 1, first_column: 1, n_rows: n, n_columns: n, unknown_prob, probs }
    }

    /// Probability that the cell is occupied; that of the unknown also outside.
    pub fn prob(&self, row: i64, column: i64) -> f64 {
        self.index(row, column).map_or(self.unknown_prob, |i| self.probs[i])
    }

    /// First row and column, and how many of each.
    pub fn extent(&self) -> (i64, i64, usize, usize) {
        (self.first_row, self.first_column, self.n_rows as usize, self.n_columns as usize)
    }

    /// All cells, rows first.
    pub fn probs(&self) -> &[f64] {
        &self.probs
    }

    /// Cells that are known, at least `threshold_prob`, and at most one minus that.
    pub fn counts(&self, threshold_prob: f64) -> BoardCounts {
        let count = |test: &dyn Fn(f64) -> bool| self.probs.iter().filter(|&&p| test(p)).count();
        BoardCounts {
            n_known: count(&is_known),
            n_occupied: count(&|p| p >= threshold_prob),
            n_free: count(&|p| p <= 1.0 - threshold_prob),
        }
    }

    /// Makes sure that `n` rows and columns from (`row`, `column`) exist; false when the board
    /// would become too large.
    pub(super) fn reach(&mut self, row: i64, column: i64, n: usize) -> bool {
        let n = n as i64;
        let (last_row, last_column) =
            (self.first_row + self.n_rows - 1, self.first_column + self.n_columns - 1);
        let inside = row >= self.first_row
            && column >= self.first_column
            && row + n - 1 <= last_row
            && column + n - 1 <= last_column;
        if inside {
            return true;
        }
        let low = |first: i64, at: i64| if at < first { at - BORDER_CELLS } else { first };
        let high = |last: i64, at: i64| if at > last { at + BORDER_CELLS } else { last };
        let (row_0, column_0) = (low(self.first_row, row), low(self.first_column, column));
        let n_rows = high(last_row, row + n - 1) - row_0 + 1;
        let n_columns = high(last_column, column + n - 1) - column_0 + 1;
        if n_rows.checked_mul(n_columns).is_none_or(|cells| cells > CELLS_MAX) {
            return false;
        }
        let mut grown = Self {
            first_row: row_0,
            first_column: column_0,
            n_rows,
            n_columns,
            unknown_prob: self.unknown_prob,
            probs: vec![self.unknown_prob; (n_rows * n_columns) as usize],
        };
        for (old, values) in self.probs.chunks_exact(self.n_columns.max(1) as usize).enumerate() {
            let row = self.first_row + old as i64;
            if let Some(start) = grown.index(row, self.first_column) {
                grown.probs[start..start + values.len()].copy_from_slice(values);
            }
        }
        *self = grown;
        true
    }

    /// `n` cells of a row, from (`row`, `column`) on.
    pub(super) fn row(&self, row: i64, column: i64, n: usize) -> &[f64] {
        self.index(row, column).map_or(&[], |start| &self.probs[start..start + n])
    }

    /// The same, to be written.
    pub(super) fn row_mut(&mut self, row: i64, column: i64, n: usize) -> &mut [f64] {
        match self.index(row, column) {
            Some(start) => &mut self.probs[start..start + n],
            None => &mut [],
        }
    }

    fn index(&self, row: i64, column: i64) -> Option<usize> {
        let (r, c) = (row - self.first_row, column - self.first_column);
        let inside = (0..self.n_rows).contains(&r) && (0..self.n_columns).contains(&c);
        inside.then_some((r * self.n_columns + c) as usize)
    }
}

/// How many cells of a board are what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardCounts {
    /// Not exactly 0.5.
    pub n_known: usize,
    /// At or above the threshold.
    pub n_occupied: usize,
    /// At or below one minus the threshold.
    pub n_free: usize,
}

/// A cell is unknown while it is what it began as.
#[expect(clippy::float_cmp, reason = "unknown cells were never written, or only with 0.5")]
pub(super) fn is_known(prob: f64) -> bool {
    prob != 0.5
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are kept, not computed")]
mod tests {
    use super::*;

    #[test]
    fn it_grows_to_all_sides_and_keeps_what_it_knows() {
        let mut board = Board::square(10);
        board.row_mut(3, 4, 1)[0] = 0.9;
        board.row_mut(10, 10, 1)[0] = 0.2;
        for (row, column) in [(-20, 5), (5, -20), (30, 5), (5, 30)] {
            assert!(board.reach(row, column, 5));
            board.row_mut(row, column, 5)[4] = 0.7;
        }
        assert_eq!(board.prob(3, 4), 0.9);
        assert_eq!(board.prob(10, 10), 0.2);
        assert_eq!(board.prob(-20, 9), 0.7);
        assert_eq!(board.prob(30, 9), 0.7);
        assert_eq!(board.prob(999, 9), 0.5);
        let counts = board.counts(0.7);
        assert_eq!((counts.n_known, counts.n_occupied, counts.n_free), (6, 5, 1));
    }

    #[test]
    fn it_refuses_to_grow_without_bounds_and_stays_as_it_was() {
        let mut board = Board::square(10);
        let before = board.clone();
        assert!(!board.reach(1_000_000, 1_000_000, 5));
        assert!(!board.reach(i64::MAX / 8, i64::MIN / 8, 5));
        assert_eq!(board, before);
    }
}
