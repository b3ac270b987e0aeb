//! How good a map is against the truth.

use geometry::{Segment, Vec2};
use grid_maps::{Cell, LogOddsMap};
use sensor_models::bayes::logodds;
use std::collections::BTreeSet;

/// Agreement of occupied cells with true walls, within a tolerance of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapAgreement {
    /// Part of the map's occupied cells that lie within one cell of a true wall's cell.
    pub precision_ratio: f64,
    /// Part of the true cells that have an occupied cell within one cell.
    pub recall_ratio: f64,
    /// Matched cells over matched, false and missed ones: 1 / (1/precision + 1/recall − 1).
    pub iou_ratio: f64,
    /// Occupied cells of the map.
    pub n_occupied: usize,
    /// Cells of true walls that were asked about.
    pub n_truth: usize,
}

/// Cells that the walls pass through, each sampled four times a cell; without those that `is_asked`
/// leaves out (a point on the wall, metres). Sorted, without doubles.
pub fn wall_cells(
    map: &LogOddsMap,
    walls: &[Segment],
    mut is_asked: impl FnMut(Vec2) -> bool,
) -> Vec<Cell> {
    let step_m = map.lattice().resolution_m / 4.0;
    let mut cells = BTreeSet::new();
    for wall in walls {
        let n = (wall.length() / step_m).ceil().clamp(1.0, 1e7) as usize;
        for i in 0..=n {
            let point = wall.point_at(i as f64 / n as f64);
            if is_asked(point) {
                cells.insert(map.lattice().cell_of(point));
            }
        }
    }
    cells.into_iter().collect()
}

/// Compares cells from `occupied_prob` on with the cells of true walls. `asked` are those that must be
/// found (recall); `all` those that may be (precision). O((n + m) log m).
pub fn agreement(
    map: &LogOddsMap,
    occupied_prob: f64,
    asked: &[Cell],
    all: &[Cell],
) -> MapAgreement {
    let threshold = logodds(occupied_prob);
    let occupied: BTreeSet<Cell> = map
        .grid()
        .known()
        .map(|(cell, _)| cell)
        .filter(|&cell| map.logodds(cell).is_some_and(|l| l >= threshold))
        .collect();
    let all: BTreeSet<Cell> = all.iter().copied().collect();
    let n_right = occupied.iter().filter(|&&cell| has_near(&all, cell)).count();
    let n_found = asked.iter().filter(|&&cell| has_near(&occupied, cell)).count();
    let ratio =
        |part: usize, whole: usize| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    let (precision, recall) = (ratio(n_right, occupied.len()), ratio(n_found, asked.len()));
    let iou_ratio = if precision > 0.0 && recall > 0.0 {
        1.0 / (1.0 / precision + 1.0 / recall - 1.0)
    } else {
        0.0
    };
    MapAgreement {
        precision_ratio: precision,
        recall_ratio: recall,
        iou_ratio,
        n_occupied: occupied.len(),
        n_truth: asked.len(),
    }
}

fn has_near(cells: &BTreeSet<Cell>, cell: Cell) -> bool {
    let near = |dc: i32, dr: i32| Cell { column: cell.column + dc, row: cell.row + dr };
    (-1..=1).any(|dr| (-1..=1).any(|dc| cells.contains(&near(dc, dr))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid_maps::{EvidenceModel, Lattice};

    #[test]
    fn one_cell_beside_is_right_and_two_are_wrong() {
        let lattice = Lattice { origin: Vec2::zeros(), resolution_m: 0.1 };
        let mut map = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        let wall = Segment { a: Vec2::new(0.05, 0.05), b: Vec2::new(0.95, 0.05) };
        let truth = wall_cells(&map, &[wall], |_| true);
        assert_eq!(truth.len(), 10);
        // Half of the wall, one cell up; and as many wrong cells, two up.
        for column in 0..5 {
            map.set(Cell { column, row: 1 }, Some(2.0));
            map.set(Cell { column, row: 2 }, Some(2.0));
            map.set(Cell { column, row: 5 }, Some(-2.0));
        }
        let found = agreement(&map, 0.7, &truth, &truth);
        assert!((found.precision_ratio - 0.5).abs() < 1e-12);
        assert!((found.recall_ratio - 0.6).abs() < 1e-12, "the sixth cell touches the fifth");
        assert!((found.iou_ratio - 1.0 / (2.0 + 1.0 / 0.6 - 1.0)).abs() < 1e-12);
        assert_eq!((found.n_occupied, found.n_truth), (10, 10));
        let left = wall_cells(&map, &[wall], |p| p.x < 0.5);
        assert_eq!(left.len(), 5);
        let empty = agreement(&map, 0.99, &truth, &truth);
        assert!(empty.precision_ratio.abs() < 1e-12 && empty.iou_ratio.abs() < 1e-12);
    }
}
