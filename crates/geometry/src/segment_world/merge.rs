//! Joins squares that lie on a common raster and touch into larger rectangles.
//!
//! Squares are solid, so the nearest of several that touch is as near as their union: no distance
//! changes, and a scanned wall of hundreds of squares becomes a few boxes. The cover is greedy, not
//! the smallest there is.

use super::parts::Block;
use crate::{Aabb, Vec2};

/// How far, in parts of a square's side, a centre may lie off the raster and still count as on it.
/// Coordinates read from a file in millimetres are good to 1e-12 of a side; a gap of 1e-9 of a
/// side is nothing any ray of a sensor could find.
const OFF_RASTER_MAX_RATIO: f64 = 1e-9;

/// A square on the raster. The order is row by row, from the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    tag: u32,
    row: i64,
    column: i64,
    /// Which point it was.
    index: u32,
}

/// The cells of a raster rectangle, borders included.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    tag: u32,
    rows: [i64; 2],
    columns: [i64; 2],
}

/// All cells, sorted and without repetition, and for each the ends of its run in its row and in
/// its column.
struct Raster {
    cells: Vec<Cell>,
    columns_of_run: Vec<[i64; 2]>,
    rows_of_run: Vec<[i64; 2]>,
}

/// The blocks for `points` (m) that stand for squares with sides of `size_m`. Points that are not
/// finite give none. O(n log n) time.
pub(super) fn blocks(points: &[(Vec2, u32)], size_m: f64) -> Vec<Block> {
    let finite = |p: &Vec2| p.x.is_finite() && p.y.is_finite();
    let Some(&(first, _)) = points.iter().find(|(p, _)| finite(p)) else { return Vec::new() };
    let half = Vec2::new(0.5 * size_m, 0.5 * size_m);
    let mut cells = Vec::new();
    let mut loose = Vec::new();
    for (index, &(point, tag)) in (0_u32..).zip(points) {
        if !finite(&point) {
            continue;
        }
        if let Some((column, row)) = raster_cell(point - first, size_m) {
            cells.push(Cell { tag, row, column, index });
        } else {
            let bounds = Aabb { min: point - half, max: point + half };
            loose.push(Block { bounds, tag, index });
        }
    }
    let raster = Raster::new(cells);
    let mut joined = raster.cover(|cell| {
        let centre = points[cell.index as usize].0;
        Aabb { min: centre - half, max: centre + half }
    });
    joined.append(&mut loose);
    joined
}

/// Column and row of a centre relative to the first one, when it lies on the raster.
fn raster_cell(offset: Vec2, size_m: f64) -> Option<(i64, i64)> {
    /// Beyond this many squares a coordinate has no digits left for the test.
    const CELLS_MAX: f64 = 1e6;
    let on_raster = |x: f64| {
        let cells = x / size_m;
        let whole = cells.round();
        let near = (cells - whole).abs() <= OFF_RASTER_MAX_RATIO && whole.abs() <= CELLS_MAX;
        near.then_some(whole as i64)
    };
    Some((on_raster(offset.x)?, on_raster(offset.y)?))
}

impl Raster {
    fn new(mut cells: Vec<Cell>) -> Self {
        cells.sort_unstable();
        cells.dedup_by_key(|c| (c.tag, c.row, c.column));
        let in_rows: Vec<usize> = (0..cells.len()).collect();
        let mut in_columns = in_rows.clone();
        in_columns.sort_by_key(|&i| (cells[i].tag, cells[i].column, cells[i].row));
        let columns_of_run = runs(&cells, &in_rows, |c| (c.row, c.column));
        let rows_of_run = runs(&cells, &in_columns, |c| (c.column, c.row));
        Self { cells, columns_of_run, rows_of_run }
    }

    /// Rectangles of cells that together cover all, the longest runs first. They may overlap, for
    /// what is solid may be so twice.
    fn cover(&self, square: impl Fn(&Cell) -> Aabb) -> Vec<Block> {
        let length = |run: [i64; 2]| run[1] - run[0];
        let longest = |i: usize| length(self.columns_of_run[i]).max(length(self.rows_of_run[i]));
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by_key(|&i| (-longest(i), i));
        let mut covered = vec![false; self.cells.len()];
        let mut blocks = Vec::new();
        for i in order {
            if covered[i] {
                continue;
            }
            let rectangle = self.rectangle_around(i);
            let mut bounds = Aabb::EMPTY;
            let mut index = u32::MAX;
            for row in rectangle.rows[0]..=rectangle.rows[1] {
                let Some(first) = self.find(rectangle.tag, row, rectangle.columns[0]) else {
                    continue;
                };
                let last = first + length(rectangle.columns) as usize;
                bounds = bounds.union(square(&self.cells[first]));
                bounds = bounds.union(square(&self.cells[last]));
                covered[first..=last].fill(true);
                let lowest = self.cells[first..=last].iter().map(|c| c.index).min();
                index = index.min(lowest.unwrap_or(u32::MAX));
            }
            blocks.push(Block { bounds, tag: rectangle.tag, index });
        }
        blocks
    }

    /// The longer run of a cell, widened for as long as the runs beside it reach as far.
    fn rectangle_around(&self, i: usize) -> Rectangle {
        let Cell { tag, row, column, .. } = self.cells[i];
        let (columns, rows) = (self.columns_of_run[i], self.rows_of_run[i]);
        if columns[1] - columns[0] >= rows[1] - rows[0] {
            let row_is_full = |row: i64| {
                self.find(tag, row, columns[0])
                    .is_some_and(|i| self.columns_of_run[i][1] >= columns[1])
            };
            Rectangle { tag, rows: widened(row, row_is_full), columns }
        } else {
            let column_is_full = |column: i64| {
                self.find(tag, rows[0], column).is_some_and(|i| self.rows_of_run[i][1] >= rows[1])
            };
            Rectangle { tag, rows, columns: widened(column, column_is_full) }
        }
    }

    fn find(&self, tag: u32, row: i64, column: i64) -> Option<usize> {
        self.cells.binary_search_by_key(&(tag, row, column), |c| (c.tag, c.row, c.column)).ok()
    }
}

/// From `line` outwards both ways for as long as lines are full.
fn widened(line: i64, is_full: impl Fn(i64) -> bool) -> [i64; 2] {
    let (mut first, mut last) = (line, line);
    while is_full(first - 1) {
        first -= 1;
    }
    while is_full(last + 1) {
        last += 1;
    }
    [first, last]
}

/// For each cell the first and last place of its run, where `order` goes along the runs and
/// `line_and_place` tells them apart.
fn runs(
    cells: &[Cell],
    order: &[usize],
    line_and_place: impl Fn(&Cell) -> (i64, i64),
) -> Vec<[i64; 2]> {
    let mut found = vec![[0, 0]; cells.len()];
    let follows = |&i: &usize, &j: &usize| {
        let (line, place) = line_and_place(&cells[i]);
        cells[i].tag == cells[j].tag && line_and_place(&cells[j]) == (line, place + 1)
    };
    for run in order.chunk_by(follows) {
        let ends = [run[0], run[run.len() - 1]].map(|i| line_and_place(&cells[i]).1);
        for &i in run {
            found[i] = ends;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(cells: &[(i32, i32)], tag: u32) -> Vec<(Vec2, u32)> {
        let centre = |&(x, y): &(i32, i32)| Vec2::new(f64::from(x) * 0.02, f64::from(y) * 0.02);
        cells.iter().map(|c| (centre(c), tag)).collect()
    }

    #[test]
    fn a_filled_rectangle_becomes_one_block_and_a_hole_is_kept() {
        let filled: Vec<_> = (0..12).map(|i| (i % 4, i / 4)).collect();
        let one = blocks(&at(&filled, 3), 0.02);
        assert_eq!(one.len(), 1);
        assert!((one[0].bounds.size() - Vec2::new(0.08, 0.06)).norm() < 1e-12);
        assert_eq!((one[0].tag, one[0].index), (3, 0));

        let ring: Vec<_> = filled.into_iter().filter(|&c| c != (1, 1)).collect();
        let parts = blocks(&at(&ring, 3), 0.02);
        let is_covered = |x: f64, y: f64| parts.iter().any(|b| b.bounds.contains(Vec2::new(x, y)));
        for (column, row) in (-1..=4).flat_map(|x| (-1..=3).map(move |y| (x, y))) {
            let inside =
                (0..4).contains(&column) && (0..3).contains(&row) && (column, row) != (1, 1);
            let (x, y) = (f64::from(column) * 0.02, f64::from(row) * 0.02);
            assert_eq!(is_covered(x, y), inside, "{column}, {row}");
        }
        assert_eq!(parts.len(), 4);
    }

    #[test]
    fn other_tags_other_rasters_and_repeated_points_are_told_apart() {
        let mut points = at(&[(0, 0), (1, 0), (1, 0)], 1);
        points.extend(at(&[(2, 0)], 2));
        points.push((Vec2::new(0.071, 0.0), 2));
        points.push((Vec2::new(f64::NAN, 0.0), 2));
        let found = blocks(&points, 0.02);
        let summary: Vec<_> = found.iter().map(|b| (b.tag, b.index)).collect();
        assert_eq!(summary, [(1, 0), (2, 3), (2, 4)]);
        assert!((found[0].bounds.size() - Vec2::new(0.04, 0.02)).norm() < 1e-12);
    }

    #[test]
    fn points_without_size_stay_points() {
        assert_eq!(blocks(&at(&[(0, 0), (1, 0)], 1), 0.0).len(), 2);
        assert!(blocks(&[], 0.02).is_empty());
    }
}
