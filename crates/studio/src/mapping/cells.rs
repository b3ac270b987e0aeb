//! Cells as bytes: 0 for unknown, else 1 + 254 × the probability, in tiles for the board.

use std::{collections::BTreeSet, sync::LazyLock};

use geometry::Se2;
use grid_maps::{Cell, Lattice, LogOddsMap, STEPS_PER_LOGODDS, UNKNOWN_STEP, Window, prob_of};
use surveys::{ShortTerm, SurveyMap};

use super::{
    board::{Board, Patch, TILE_SIDE},
    protocol::Pose,
};

/// Largest short-term map that is shown, cells.
const PATCH_CELLS_MAX: usize = 1 << 20;

/// A pose as messages hold it.
pub(crate) fn array(pose: Se2) -> Pose {
    [pose.x_m, pose.y_m, pose.yaw_rad]
}

/// Brings the map of a board up to date: looks at every cell.
pub(crate) fn paint(map: &SurveyMap, board: &mut Board) {
    board.set_lattice(origin(map.lattice()), map.lattice().resolution_m);
    match map {
        SurveyMap::Evidence(map) => paint_evidence(map, board),
        SurveyMap::Board(_, window) => paint_window(window, board),
    }
}

/// The short-term map as pages see it; `None` for one that is too large to be shown.
pub(crate) fn patch(short_term: &ShortTerm) -> Option<Patch> {
    let window = short_term.map.window().ok()?;
    let area = window.area();
    if area.n_cells() > PATCH_CELLS_MAX {
        return None;
    }
    let lattice = short_term.map.lattice();
    let corner = lattice.corner_of(area.min);
    Some(Patch {
        pose: array(short_term.map_from_patch),
        origin_m: [corner.x, corner.y],
        cell_m: lattice.resolution_m,
        columns: area.width,
        cells: window.values().iter().map(|&prob| byte_of(prob)).collect(),
    })
}

fn origin(lattice: &Lattice) -> [f64; 2] {
    let corner = lattice.corner_of(Cell::new(0, 0));
    [corner.x, corner.y]
}

/// The byte of a probability; NaN is unknown.
fn byte_of(prob: f64) -> u8 {
    if prob.is_nan() { 0 } else { 1 + (254.0 * prob.clamp(0.0, 1.0)).round() as u8 }
}

/// The bytes of all steps of evidence, by the step's bits.
static BYTE_OF_STEP: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let byte = |bits: u16| {
        let step = bits.cast_signed();
        if step == UNKNOWN_STEP { 0 } else { byte_of(prob_of(f64::from(step) / STEPS_PER_LOGODDS)) }
    };
    (0..=u16::MAX).map(byte).collect()
});

fn paint_evidence(map: &LogOddsMap, board: &mut Board) {
    let bytes = &*BYTE_OF_STEP;
    let mut cells = [0; TILE_SIDE * TILE_SIDE];
    let mut painted = BTreeSet::new();
    for tile in map.grid().tiles() {
        for (cell, step) in cells.iter_mut().zip(tile.values) {
            *cell = bytes[usize::from(step.cast_unsigned())];
        }
        board.set_tile(tile.min.row, tile.min.column, &cells);
        painted.insert((tile.min.row, tile.min.column));
    }
    board.clear_tiles_but(|row, column| painted.contains(&(row, column)));
}

fn paint_window(window: &Window<f64>, board: &mut Board) {
    let side = TILE_SIDE as i32;
    let area = window.area();
    let first_of = |at: i32| at.div_euclid(side) * side;
    let tiles_from = |at: i32, end: i64| {
        (i64::from(first_of(at))..end).step_by(TILE_SIDE).filter_map(|at| i32::try_from(at).ok())
    };
    let mut cells = [0; TILE_SIDE * TILE_SIDE];
    for row in tiles_from(area.min.row, area.row_end()) {
        for column in tiles_from(area.min.column, area.column_end()) {
            for (y, line) in (row..).zip(cells.chunks_exact_mut(TILE_SIDE)) {
                for (x, cell) in (column..).zip(line) {
                    let prob = window.get(Cell::new(x, y));
                    *cell = prob.map_or(0, byte_of);
                }
            }
            board.set_tile(row, column, &cells);
        }
    }
    board.clear_tiles_but(|row, column| {
        let holds = |at: i32, min: i32, end: i64| at >= first_of(min) && i64::from(at) < end;
        holds(row, area.min.row, area.row_end())
            && holds(column, area.min.column, area.column_end())
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::board::{Message, Seen};
    use geometry::Vec2;
    use grid_maps::{CellBox, EvidenceModel};

    /// The tiles of a board's first message: column, row, and cells, all of one value.
    fn uniform_tiles(board: &Board) -> Vec<(i32, i32, u8)> {
        let (messages, _) = board.news(0, &mut Seen::default());
        let [Message::Binary(bytes)] = messages.as_slice() else { panic!("{messages:?}") };
        let at = |i: usize| i32::from_le_bytes(bytes[i..i + 4].try_into().unwrap());
        let tile = |i: usize| {
            assert_eq!(bytes[i + 8..i + 10], [64, 0], "32 runs of one value");
            (at(i), at(i + 4), bytes[i + 11])
        };
        (36..bytes.len()).step_by(74).map(tile).collect()
    }

    #[test]
    fn probabilities_are_bytes_and_nan_is_unknown() {
        assert_eq!([f64::NAN, 0.0, 0.5, 1.0].map(byte_of), [0, 1, 128, 255]);
        assert_eq!([-0.1, 1.1].map(byte_of), [1, 255]);
        let of = |step: i16| BYTE_OF_STEP[usize::from(step.cast_unsigned())];
        assert_eq!([of(UNKNOWN_STEP), of(0)], [0, 128]);
        assert!(of(-4096) < 10 && of(4096) > 245 && of(1) >= of(-1));
    }

    #[test]
    fn a_window_across_the_origin_fills_its_tiles_and_leaves_the_rest_unknown() {
        let mut board = Board::new(0);
        let area = CellBox { min: Cell::new(-64, -64), width: 128, height: 64 };
        let window = Window::filled(area, 0.5).unwrap();
        paint_window(&window, &mut board);
        assert_eq!(uniform_tiles(&board), [(-64, -64, 128), (0, -64, 128)]);
        // A smaller window later: what it has no more is unknown.
        let area = CellBox { min: Cell::new(0, -64), width: 64, height: 64 };
        paint_window(&Window::filled(area, 1.0).unwrap(), &mut board);
        let mut tiles = uniform_tiles(&board);
        tiles.sort_unstable();
        assert_eq!(tiles, [(-64, -64, 0), (0, -64, 255)]);
    }

    #[test]
    fn evidence_is_painted_where_it_lies() {
        let lattice = Lattice::new(Vec2::new(1.0, 2.0), 0.1).unwrap();
        let mut map = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        for row in -64..0 {
            for column in 64..128 {
                map.add_hit(Cell::new(column, row));
            }
        }
        let mut board = Board::new(0);
        paint(&SurveyMap::Evidence(map.clone()), &mut board);
        let prob = map.prob(Cell::new(64, -1)).unwrap();
        assert_eq!(uniform_tiles(&board), [(64, -64, byte_of(prob))]);
    }
}
