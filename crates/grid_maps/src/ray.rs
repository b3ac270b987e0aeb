//! The cells that a straight line crosses, each exactly once.

use geometry::Vec2;

use crate::{Cell, Lattice, LogOddsMap};

/// Cells from one end of a segment to the other, both included.
///
/// A step goes to the cell on the other side of the border that the line reaches next; where it
/// passes exactly through a corner it steps along x first, so that a diagonal wall has no holes.
///
/// Source: Amanatides and Woo (1987), "A fast voxel traversal algorithm for ray tracing",
/// Eurographics. Differences: the place of a border on the line is computed afresh at each step
/// instead of being added up, so no error grows; and the number of steps along each axis is known
/// from the ends, so the walk always arrives.
#[derive(Clone, Debug)]
pub struct RayWalk {
    next: Option<Cell>,
    x: Axis,
    y: Axis,
}

/// One coordinate of a walk.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// +1 or −1.
    step: i32,
    /// Steps left.
    n_left: u32,
    /// The next border, and where the line begins; cells.
    border: f64,
    from: f64,
    /// Fraction of the line for one cell.
    per_cell: f64,
}

impl RayWalk {
    /// The walk from `from` to `to` (m). Ends beyond the limits of cells are moved to them.
    pub fn new(lattice: &Lattice, from: Vec2, to: Vec2) -> Self {
        let (first, last) = (lattice.cell_of(from), lattice.cell_of(to));
        let (a, b) = (lattice.in_cells(from), lattice.in_cells(to));
        Self {
            next: Some(first),
            x: Axis::new(first.column, last.column, a.x, b.x),
            y: Axis::new(first.row, last.row, a.y, b.y),
        }
    }
}

impl Iterator for RayWalk {
    type Item = Cell;

    fn next(&mut self) -> Option<Cell> {
        let cell = self.next?;
        let Self { x, y, .. } = self;
        self.next = match (x.n_left, y.n_left) {
            (0, 0) => None,
            (_, 0) => Some(cell.offset(x.advance(), 0)),
            (0, _) => Some(cell.offset(0, y.advance())),
            _ if x.fraction() <= y.fraction() => Some(cell.offset(x.advance(), 0)),
            _ => Some(cell.offset(0, y.advance())),
        };
        Some(cell)
    }
}

impl Axis {
    fn new(first: i32, last: i32, from: f64, to: f64) -> Self {
        let step = if last < first { -1 } else { 1 };
        let border = f64::from(first) + if last < first { 0.0 } else { 1.0 };
        Self { step, n_left: first.abs_diff(last), border, from, per_cell: 1.0 / (to - from) }
    }

    /// How far along the line the next border is; 0 at its begin, 1 at its end.
    fn fraction(&self) -> f64 {
        (self.border - self.from) * self.per_cell
    }

    fn advance(&mut self) -> i32 {
        self.n_left -= 1;
        self.border += f64::from(self.step);
        self.step
    }
}

impl LogOddsMap {
    /// Counts one beam: a miss for every cell from `from` to `to` (m), and for the last one a hit
    /// when the beam ended there on something.
    ///
    /// Nothing happens when an end lies beyond the limits of cells. O(cells crossed).
    pub fn insert_ray(&mut self, from: Vec2, to: Vec2, hit: bool) {
        let lattice = *self.lattice();
        let (Some(_), Some(end)) = (lattice.cell_at(from), lattice.cell_at(to)) else { return };
        for cell in RayWalk::new(&lattice, from, to) {
            if cell == end && hit {
                self.add_hit(cell);
            } else {
                self.add_miss(cell);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EvidenceModel;
    use proptest::prelude::*;

    fn walk(from: [f64; 2], to: [f64; 2]) -> Vec<(i32, i32)> {
        let lattice = Lattice::new(Vec2::zeros(), 1.0).unwrap();
        let walk = RayWalk::new(&lattice, from.into(), to.into());
        walk.map(|cell| (cell.column, cell.row)).collect()
    }

    /// Length of the line inside a cell, by cutting it with the four sides (Liang and Barsky).
    fn length_inside(from: [f64; 2], to: [f64; 2], cell: (i32, i32)) -> f64 {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (i, low) in [(0, f64::from(cell.0)), (1, f64::from(cell.1))] {
            let d = to[i] - from[i];
            if d == 0.0 {
                if from[i] < low || from[i] >= low + 1.0 {
                    return -1.0;
                }
                continue;
            }
            let (a, b) = ((low - from[i]) / d, (low + 1.0 - from[i]) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        leave - enter
    }

    #[test]
    fn straight_lines_and_points() {
        assert_eq!(walk([0.5, 0.5], [3.2, 0.5]), [(0, 0), (1, 0), (2, 0), (3, 0)]);
        assert_eq!(walk([0.5, 0.5], [0.5, -1.5]), [(0, 0), (0, -1), (0, -2)]);
        assert_eq!(walk([0.5, 0.5], [0.6, 0.7]), [(0, 0)]);
        assert_eq!(walk([0.5, 0.5], [0.5, 0.5]), [(0, 0)]);
    }

    #[test]
    fn through_a_corner_the_walk_goes_along_x_first() {
        assert_eq!(walk([0.5, 0.5], [2.5, 2.5]), [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)]);
        assert_eq!(walk([0.5, 0.5], [-0.5, -0.5]), [(0, 0), (-1, 0), (-1, -1)]);
        assert_eq!(walk([0.5, 0.5], [-0.5, 1.5]), [(0, 0), (-1, 0), (-1, 1)]);
    }

    #[test]
    fn a_beam_misses_its_way_and_hits_its_end() {
        let lattice = Lattice::new(Vec2::zeros(), 1.0).unwrap();
        let mut map = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        map.insert_ray(Vec2::new(0.5, 0.5), Vec2::new(2.5, 0.5), true);
        map.insert_ray(Vec2::new(0.5, 0.5), Vec2::new(-1.5, 0.5), false);
        map.insert_ray(Vec2::new(0.5, 0.5), Vec2::new(f64::NAN, 0.5), true);
        map.insert_ray(Vec2::new(0.5, 0.5), Vec2::new(0.5, 1e300), true);
        let miss = -410.0 / 1024.0;
        let row: Vec<_> = (-3..4).map(|c| map.logodds(Cell::new(c, 0))).collect();
        let expected = [
            None,
            Some(miss),
            Some(miss),
            Some(2.0 * miss),
            Some(miss),
            Some(870.0 / 1024.0),
            None,
        ];
        assert_eq!(row, expected);
        assert_eq!(map.grid().known().count(), 5);
    }

    proptest! {
        #[test]
        fn every_crossed_cell_comes_exactly_once(
            from in [-9.0..9.0_f64, -9.0..9.0_f64],
            to in [-9.0..9.0_f64, -9.0..9.0_f64],
        ) {
            let cells = walk(from, to);
            let mut unique = cells.clone();
            unique.sort_unstable();
            unique.dedup();
            prop_assert_eq!(unique.len(), cells.len());
            for pair in cells.windows(2) {
                prop_assert_eq!((pair[0].0 - pair[1].0).abs() + (pair[0].1 - pair[1].1).abs(), 1);
            }
            for column in -10..10 {
                for row in -10..10 {
                    let length = length_inside(from, to, (column, row));
                    if length.abs() > 1e-9 {
                        let crossed = cells.contains(&(column, row));
                        prop_assert_eq!(crossed, length > 0.0, "{:?}", (column, row));
                    }
                }
            }
        }
    }
}
