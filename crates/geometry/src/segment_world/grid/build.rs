//! Chooses the raster and lists the parts of each cell.

use super::{
    super::parts::{Part, Parts},
    Cell, Grid, Group, LANES, LEVEL_0, LEVEL_STEP, MARGIN_CELLS, empty,
};
use crate::{Aabb, Segment, Vec2};

/// Cells for each part. More make a ray test fewer parts, but take more memory than caches hold:
/// in a scanned building of 18 000 parts, 1 to 4 are equally quick and 8 is slower.
const CELLS_PER_PART: usize = 2;

/// Cells that a small world has nevertheless: a flat with thirty walls is best with so many.
const CELLS_MIN: usize = 4096;

/// Cells at most, 16 MiB of them. More parts share larger cells.
pub(super) const CELLS_MAX: usize = 1 << 22;

/// Cells along the longer side at most: a world on one line has no area to go by.
const SIDE_MAX: usize = 8192;

/// Entries of lists for each part at most, and those that a small world may have nevertheless.
/// With more, cells are made larger; it takes many long walls across each other.
const ENTRIES_PER_PART: usize = 16;
const ENTRIES_MIN: usize = 1 << 14;

/// Entries at most: their groups must be numbered in the bits that [`Cell`] has for it.
const ENTRIES_MAX: u64 = 1 << 28;

/// Length of the list that an entry is in, on average, beyond which a raster does not pay: the
/// parts are crowded in a small part of the world, and a hierarchy suits them better.
const CROWD_MAX: f64 = 16.0;

/// Sides of cells that single precision copes with, metres.
const CELL_MIN_M: f64 = 1e-6;
const CELL_MAX_M: f64 = 1e6;

/// A step between the sizes of cells that are tried.
const COARSER_RATIO: f64 = 1.25;

/// Where the cells are.
struct Raster {
    corner: Vec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// `None` where a raster does not pay: for an empty world, one whose parts crowd in a small
    /// part of it, or one of a size that its numbers can hardly express.
    pub(in super::super) fn build(parts: &Parts) -> Option<Self> {
        let raster = Raster::choose(parts)?;
        let mut lengths = vec![0_u32; raster.columns * raster.rows];
        raster.each_entry(parts, |cell, _, _| lengths[cell] += 1);
        let n_entries: u64 = lengths.iter().map(|&n| u64::from(n)).sum();
        let shared: f64 = lengths.iter().map(|&n| f64::from(n) * f64::from(n)).sum();
        if n_entries >= ENTRIES_MAX || shared > CROWD_MAX * n_entries as f64 {
            return None;
        }
        let mut cells = empty::rectangles(&lengths, raster.columns);
        let groups = raster.lists(parts, &mut lengths, &mut cells);
        Some(Self {
            corner: raster.corner,
            bounds: parts.bounds.grown(MARGIN_CELLS * raster.cell_m),
            cells_per_m: 1.0 / raster.cell_m,
            cell_m: raster.cell_m,
            columns: raster.columns,
            rows: raster.rows,
            cells,
            groups,
        })
    }
}

impl Raster {
    fn choose(parts: &Parts) -> Option<Self> {
        let n_parts = parts.walls.len() + parts.blocks.len();
        let Aabb { min, max } = parts.bounds;
        let size = parts.bounds.size();
        if n_parts == 0 || !(size.x * size.y).is_finite() {
            return None;
        }
        let n_cells = (CELLS_PER_PART * n_parts).clamp(CELLS_MIN, CELLS_MAX / 2) as f64;
        let n_entries_max = (ENTRIES_PER_PART * n_parts).max(ENTRIES_MIN) as f64;
        // Coordinates must tell points apart that are a small part of the margin from each other.
        let resolved_m = 64.0 * f64::EPSILON * min.abs().sup(&max.abs()).max() / MARGIN_CELLS;
        let by_area_m = (size.x * size.y / n_cells).sqrt();
        let by_side_m = size.max() / (SIDE_MAX - 1) as f64;
        let mut cell_m = by_area_m.max(by_side_m).max(resolved_m).max(CELL_MIN_M);
        while cell_m <= CELL_MAX_M {
            let along = |length_m: f64| (length_m / cell_m + 4.0 * MARGIN_CELLS).ceil();
            let (columns, rows) = (along(size.x), along(size.y));
            if columns * rows <= CELLS_MAX as f64 && entries_bound(parts, cell_m) <= n_entries_max {
                // What the cells are too large by is shared out to both sides.
                let corner = min - 0.5 * (Vec2::new(columns, rows) * cell_m - size);
                return Some(Self {
                    corner,
                    cell_m,
                    columns: columns as usize,
                    rows: rows as usize,
                });
            }
            cell_m *= COARSER_RATIO;
        }
        None
    }

    /// Writes the lists of all cells, and into the cells where they begin. Takes their lengths.
    fn lists(&self, parts: &Parts, lengths: &mut [u32], cells: &mut [Cell]) -> Vec<Group> {
        let mut n_groups = 0;
        for (cell, &length) in cells.iter_mut().zip(&*lengths) {
            if length > 0 {
                *cell = Cell(Cell::OCCUPIED | n_groups);
                n_groups += length.div_ceil(LANES as u32);
            }
        }
        let mut groups = vec![Group::EMPTY; n_groups as usize];
        // Each list is filled from its end.
        self.each_entry(parts, |cell, part, bounds| {
            let Some(list) = cells[cell].list() else { return };
            lengths[cell] -= 1;
            let entry = lengths[cell] as usize;
            let (group, lane) = (&mut groups[list + entry / LANES], entry % LANES);
            group.parts[lane] = part;
            self.enter_box(group, lane, cell, bounds);
        });
        // A list ends where the next one begins.
        let lists = cells.iter().filter_map(|cell| cell.list());
        for end in lists.skip(1).chain([groups.len()]) {
            groups[end - 1].parts[0].0 |= Group::LAST;
        }
        groups
    }

    /// Calls `enter` with each cell that a part grown by the margin reaches, the part, and a box
    /// around what of it lies in the cell.
    fn each_entry(&self, parts: &Parts, mut enter: impl FnMut(usize, Part, Aabb)) {
        for (place, wall) in parts.walls.iter().enumerate() {
            self.each_cell_of_wall(wall.segment, |cell, bounds| {
                enter(cell, Part::wall(place), bounds);
            });
        }
        for (place, block) in parts.blocks.iter().enumerate() {
            let [columns, rows] = self.cells_of(block.bounds);
            for row in rows[0]..=rows[1] {
                for column in columns[0]..=columns[1] {
                    enter(row * self.columns + column, Part::block(place), block.bounds);
                }
            }
        }
    }

    /// Goes row by row, from where the wall enters the row to where it leaves it.
    fn each_cell_of_wall(&self, wall: Segment, mut enter: impl FnMut(usize, Aabb)) {
        let [_, rows] = self.cells_of(Aabb::around([wall.a, wall.b]));
        for row in rows[0]..=rows[1] {
            let in_row = self.cut(wall, 1, row);
            let [columns, _] = self.cells_of(Aabb::around([in_row.a, in_row.b]));
            for column in columns[0]..=columns[1] {
                let in_cell = self.cut(in_row, 0, column);
                enter(row * self.columns + column, Aabb::around([in_cell.a, in_cell.b]));
            }
        }
    }

    /// The piece of a wall in one column (axis 0) or row (axis 1), grown by twice the margin.
    fn cut(&self, wall: Segment, axis: usize, cell: usize) -> Segment {
        let along = wall.b[axis] - wall.a[axis];
        if along.abs() <= 0.0 {
            return wall;
        }
        let ratio_at = |cells: f64| {
            let line_m = self.corner[axis] + cells * self.cell_m;
            ((line_m - wall.a[axis]) / along).clamp(0.0, 1.0)
        };
        let low = ratio_at(cell as f64 - 2.0 * MARGIN_CELLS);
        let high = ratio_at(cell as f64 + 1.0 + 2.0 * MARGIN_CELLS);
        Segment { a: wall.point_at(low), b: wall.point_at(high) }
    }

    /// First and last column, and first and last row, that a box grown by the margin reaches.
    fn cells_of(&self, bounds: Aabb) -> [[usize; 2]; 2] {
        let of_axis = |axis: usize, n_cells: usize| {
            let cell = |x_m: f64, grown: f64| {
                let cells = (x_m - self.corner[axis]) / self.cell_m + grown;
                // A negative number becomes 0.
                (cells as usize).min(n_cells - 1)
            };
            [cell(bounds.min[axis], -MARGIN_CELLS), cell(bounds.max[axis], MARGIN_CELLS)]
        };
        [of_axis(0, self.columns), of_axis(1, self.rows)]
    }

    /// Writes the box (m) around a part, grown by the margin, into a lane of a group, as far as the
    /// levels of the cell reach.
    fn enter_box(&self, group: &mut Group, lane: usize, cell: usize, bounds: Aabb) {
        let cell = Vec2::new((cell % self.columns) as f64, (cell / self.columns) as f64);
        for axis in 0..2 {
            let level = |x_m: f64, grown: f64| {
                let inside = (x_m - self.corner[axis]) / self.cell_m - cell[axis] + grown;
                (inside - f64::from(LEVEL_0)) / f64::from(LEVEL_STEP)
            };
            // The conversion also cuts off at 0 and 255.
            group.boxes[axis][lane] = level(bounds.min[axis], -MARGIN_CELLS).floor() as u8;
            group.boxes[axis + 2][lane] = level(bounds.max[axis], MARGIN_CELLS).ceil() as u8;
        }
    }
}

/// No fewer entries than there will be with cells of that size.
fn entries_bound(parts: &Parts, cell_m: f64) -> f64 {
    let along = |length_m: f64| (length_m / cell_m).floor() + 2.0;
    let blocks = parts.blocks.iter().map(|block| {
        let size = block.bounds.size();
        along(size.x) * along(size.y)
    });
    let walls = parts.walls.iter().map(|wall| {
        let size = (wall.segment.b - wall.segment.a).abs();
        // Twice, because it may run along a border.
        2.0 * (along(size.x) + along(size.y))
    });
    blocks.chain(walls).sum()
}
