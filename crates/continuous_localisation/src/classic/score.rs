//! How badly a short-term map fits a long-term one: the source's two scores, and evidence.

use sensor_models::bayes::logodds;

use super::board::{Board, is_known};

/// Log-odds beyond this count as this: certainty of one cell must not decide alone.
const EVIDENCE_MAX_LOGODDS: f64 = 4.0;

/// What is compared; less is better for all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Score {
    /// The annex's program: the sum of differences over the whole window, known or not; 0 when the
    /// maps have no known cell in common.
    ///
    /// A pose without overlap always wins, and so does one that covers less of the known world:
    /// with the search switched on it diverges.
    WholeWindow,
    /// Equation (18), read as a mean: the mean difference over the cells known in both, where there
    /// are at least so many.
    CommonCells {
        /// Fewer cells in common, and the pose is not a candidate.
        n_cells_min: usize,
    },
    /// One minus the correlation of log-odds over the cells known in both: 0 where the maps say the
    /// same, 1 where one says nothing about the other, 2 where they contradict each other.
    Evidence {
        /// Fewer cells in common, and the pose is not a candidate.
        n_cells_min: usize,
    },
}

/// A square piece of a map, its rows one after another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<'a> {
    pub probs: &'a [f64],
    pub n_cells: usize,
}

impl Score {
    /// Of `piece` laid on `world` with its first cell behind row and column `at`; `None` without
    /// enough overlap. The board must reach that far. O(cells of the piece).
    pub(super) fn of(self, world: &Board, piece: Piece<'_>, at: [i64; 2]) -> Option<f64> {
        let mut sums = Sums::default();
        for (row, ours) in piece.probs.chunks_exact(piece.n_cells).enumerate() {
            let theirs = world.row(at[0] + 1 + row as i64, at[1] + 1, piece.n_cells);
            match self {
                Self::Evidence { .. } => sums.add_evidence(ours, theirs),
                _ => sums.add_differences(ours, theirs),
            }
        }
        match self {
            Self::WholeWindow => Some(if sums.n_common == 0 { 0.0 } else { sums.all }),
            Self::CommonCells { n_cells_min } => {
                let enough = sums.n_common >= n_cells_min.max(1);
                enough.then(|| sums.common / sums.n_common as f64)
            }
            Self::Evidence { n_cells_min } => {
                let norm = (sums.ours_squared * sums.theirs_squared).sqrt();
                let enough = sums.n_common >= n_cells_min.max(1) && norm > 0.0;
                enough.then(|| 1.0 - sums.product / norm)
            }
        }
    }
}

#[derive(Default)]
struct Sums {
    n_common: usize,
    all: f64,
    common: f64,
    product: f64,
    ours_squared: f64,
    theirs_squared: f64,
}

impl Sums {
    fn add_differences(&mut self, ours: &[f64], theirs: &[f64]) {
        for (&a, &b) in ours.iter().zip(theirs) {
            let difference = (b - a).abs();
            self.all += difference;
            if is_known(a) && is_known(b) {
                self.n_common += 1;
                self.common += difference;
            }
        }
    }

    fn add_evidence(&mut self, ours: &[f64], theirs: &[f64]) {
        let bounded = |p: f64| logodds(p).clamp(-EVIDENCE_MAX_LOGODDS, EVIDENCE_MAX_LOGODDS);
        for (&a, &b) in ours.iter().zip(theirs) {
            if is_known(a) && is_known(b) {
                let (a, b) = (bounded(a), bounded(b));
                self.n_common += 1;
                self.product += a * b;
                self.ours_squared += a * a;
                self.theirs_squared += b * b;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board of 3 × 3 with these cells, and a piece of the same size.
    fn score(score: Score, world: [f64; 9], piece: [f64; 9]) -> Option<f64> {
        let mut board = Board::square(3);
        for row in 0..3 {
            board.row_mut(row as i64 + 1, 1, 3).copy_from_slice(&world[3 * row..3 * row + 3]);
        }
        score.of(&board, Piece { probs: &piece, n_cells: 3 }, [0, 0])
    }

    const U: f64 = 0.5;

    #[test]
    fn the_programmed_score_counts_unknown_cells_and_loves_emptiness() {
        let world = [0.9, 0.1, U, U, U, U, U, U, 0.8];
        let piece = [0.8, U, 0.7, U, U, U, U, U, U];
        let found = score(Score::WholeWindow, world, piece).unwrap();
        assert!((found - (0.1 + 0.4 + 0.2 + 0.3)).abs() < 1e-12, "{found}");
        let apart = [U, U, 0.7, U, U, U, U, U, U];
        assert_eq!(score(Score::WholeWindow, world, apart), Some(0.0));
    }

    #[test]
    fn the_printed_score_is_a_mean_over_common_cells() {
        let world = [0.9, 0.1, U, U, U, U, U, U, 0.8];
        let piece = [0.8, 0.4, 0.7, U, U, U, U, U, U];
        let common = |n_cells_min| score(Score::CommonCells { n_cells_min }, world, piece);
        assert!((common(2).unwrap() - 0.2).abs() < 1e-12);
        assert_eq!(common(3), None);
        assert_eq!(score(Score::CommonCells { n_cells_min: 0 }, world, [U; 9]), None);
    }

    #[test]
    fn evidence_is_a_correlation() {
        let world = [0.9, 0.1, U, U, U, U, U, U, 0.8];
        let opposite = [0.1, 0.9, U, U, U, U, U, U, 0.2];
        let evidence = |piece| score(Score::Evidence { n_cells_min: 2 }, world, piece).unwrap();
        assert!(evidence(world).abs() < 1e-12);
        assert!((evidence(opposite) - 2.0).abs() < 1e-12);
        // Orthogonal: one agrees, one contradicts, equally strongly.
        let half = [0.9, 0.9, U, U, U, U, U, U, U];
        assert!((evidence(half) - 1.0).abs() < 1e-12);
    }
}
