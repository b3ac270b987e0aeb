//! The alternative way to compose readings: one map of emptiness, one of occupancy.

use sensor_models::{
    Region,
    elfes_moravec::{Cancellation, CellState, cancelled_prob, decide, superposed_prob},
};

use super::{ClassicConfig, ClassicError, ClassicLog, board::Board, model::ConeCell};

/// How far each cell is known empty, and how far occupied; counted like the cells of a [`Board`].
///
/// Source: Axenie (2011), eq. (6) to (8), as in [`sensor_models::elfes_moravec`]; probabilities of a
/// reading by the configuration's profile, of which what is above one half in the arc counts as
/// occupied, and what is below it before the arc as empty, both from 0 at one half to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoMaps {
    empty: Board,
    occupied: Board,
    cancellation: Cancellation,
}

impl TwoMaps {
    /// Draws all rows of a log at `poses` (x mm, y mm, heading degrees; one for each row): those of
    /// odometry ([`ClassicLog::poses`]) or those that a run corrected.
    ///
    /// # Errors
    ///
    /// As [`run`](super::run); also [`ClassicError::Shape`] when there are not as many poses as rows.
    pub fn draw(
        log: &ClassicLog,
        poses: &[[f64; 3]],
        config: &ClassicConfig,
        cancellation: Cancellation,
    ) -> Result<Self, ClassicError> {
        log.check(config)?;
        if poses.len() != log.n_rows() {
            let n_readings = log.n_rows() * config.ring.len();
            let (n_poses, n_columns) = (poses.len(), config.ring.len());
            return Err(ClassicError::Shape { n_poses, n_columns, n_readings });
        }
        let board = Board::square_of(config.n_world_cells, 0.0);
        let mut maps = Self { empty: board.clone(), occupied: board, cancellation };
        let mut arc = Vec::new();
        for (row, &[x_mm, y_mm, heading_deg]) in poses.iter().enumerate() {
            let at = config.position(x_mm, y_mm, 0);
            let n = config.shape.n_cells + 2;
            if !(maps.empty.reach(at[0], at[1], n) && maps.occupied.reach(at[0], at[1], n)) {
                return Err(ClassicError::TooFar { row: row + 1, x_mm, y_mm });
            }
            for (sonar, &mm) in config.ring.iter().zip(log.readings_mm(row)) {
                if mm < config.shape.reading_below_mm {
                    arc.clear();
                    config.shape.visit_cone(sonar, mm, heading_deg, |cell| {
                        maps.take(config, at, &cell, &mut arc);
                    });
                    maps.take_arc(&arc);
                }
            }
        }
        Ok(maps)
    }

    /// Which value is greater in a cell, and how great it is.
    pub fn state(&self, row: i64, column: i64) -> CellState {
        decide(self.empty.prob(row, column), self.occupied.prob(row, column))
    }

    /// First row and column, and how many of each.
    pub fn extent(&self) -> (i64, i64, usize, usize) {
        self.empty.extent()
    }

    /// Empty evidence is added at once; cells of the arc are kept with theirs.
    fn take(
        &mut self,
        config: &ClassicConfig,
        at: [i64; 2],
        cell: &ConeCell,
        arc: &mut Vec<(i64, i64, f64)>,
    ) {
        let Some(prob) = config.shape.occupied_prob(cell) else { return };
        let (row, column) = (at[0] + cell.row as i64, at[1] + cell.column as i64);
        let sure = (2.0 * (prob - 0.5).abs()).min(1.0);
        match config.shape.region(cell) {
            Region::Before if prob < 0.5 => {
                if let [empty] = self.empty.row_mut(row, column, 1) {
                    *empty = superposed_prob(*empty, sure);
                }
            }
            Region::Arc if prob > 0.5 => {
                let empty = self.empty.prob(row, column);
                let occupied = self.occupied.prob(row, column);
                let left = cancelled_prob(sure, empty, occupied, self.cancellation);
                arc.push((row, column, left));
            }
            _ => {}
        }
    }

    /// One reflector made the echo: what is left of the arc's cells sums to one.
    fn take_arc(&mut self, arc: &[(i64, i64, f64)]) {
        let sum: f64 = arc.iter().map(|cell| cell.2).sum();
        if sum <= 0.0 {
            return;
        }
        for &(row, column, left) in arc {
            if let [occupied] = self.occupied.row_mut(row, column, 1) {
                *occupied = superposed_prob(*occupied, left / sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::ClassicSonar;

    const SONAR: ClassicSonar = ClassicSonar { x_mm: 0.0, y_mm: 0.0, azimuth_deg: 0.0 };

    /// A sonar that looks along x from the origin, one reading for each row.
    fn drawn(readings_mm: &[f64], cancellation: Cancellation) -> TwoMaps {
        let config = ClassicConfig { ring: vec![SONAR], ..ClassicConfig::thesis() };
        let poses = vec![[0.0; 3]; readings_mm.len()];
        let log = ClassicLog::new(poses.clone(), readings_mm.to_vec(), 1, 0.05).unwrap();
        TwoMaps::draw(&log, &poses, &config, cancellation).unwrap()
    }

    /// The cell that lies so many cells ahead of the robot.
    fn ahead(maps: &TwoMaps, cells: i64) -> CellState {
        let [row, column] = ClassicConfig::thesis().cell_of_robot(0.0, 0.0);
        maps.state(row + cells, column)
    }

    #[test]
    fn before_the_echo_is_empty_at_it_occupied_and_behind_unknown() {
        let maps = drawn(&[700.0], Cancellation::ByEmpty);
        assert!(matches!(ahead(&maps, 10), CellState::Empty(p) if p > 0.5));
        assert!(matches!(ahead(&maps, 20), CellState::Occupied(p) if p > 0.1));
        assert_eq!(ahead(&maps, 25), CellState::Unknown);
        assert_eq!(ahead(&maps, -10), CellState::Unknown);
    }

    /// One arc is one reflector: its cells share a probability of one.
    #[test]
    fn the_arc_of_a_single_reading_sums_to_one() {
        let maps = drawn(&[700.0], Cancellation::ByEmpty);
        let (_, _, rows, columns) = maps.extent();
        let sum: f64 = (1..=rows as i64)
            .flat_map(|r| (1..=columns as i64).map(move |c| (r, c)))
            .map(|(r, c)| maps.occupied.prob(r, c))
            .sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }

    /// A nearer echo after many farther ones lies where all is known empty: its evidence is cancelled
    /// there only by the empty map.
    #[test]
    fn what_is_known_empty_takes_from_a_later_arc_unless_the_print_is_followed() {
        let mut readings = vec![1400.0; 3];
        readings.push(700.0);
        let occupied = |cancellation| {
            let maps = drawn(&readings, cancellation);
            let [row, column] = ClassicConfig::thesis().cell_of_robot(0.0, 0.0);
            let share = |side: i64| maps.occupied.prob(row + 20, column + side);
            // The middle of the arc is known empty more surely than its edge.
            share(0) / share(2)
        };
        assert!(occupied(Cancellation::ByEmpty) < 0.5 * occupied(Cancellation::Literal));
    }

    #[test]
    fn poses_and_rows_have_to_agree() {
        let config = ClassicConfig { ring: vec![SONAR], ..ClassicConfig::thesis() };
        let log = ClassicLog::new(vec![[0.0; 3]; 2], vec![700.0; 2], 1, 0.05).unwrap();
        assert!(TwoMaps::draw(&log, &[[0.0; 3]], &config, Cancellation::ByEmpty).is_err());
        let far = [[0.0; 3], [1e9, 0.0, 0.0]];
        let error = TwoMaps::draw(&log, &far, &config, Cancellation::ByEmpty).unwrap_err();
        assert!(error.to_string().starts_with("row 2:"), "{error}");
    }
}
