//! A raster over the world: which parts lie in which cell, and how far it is empty around.
//!
//! A ray leaps from one empty rectangle to the next, tests what lies in the cells that are not
//! empty, and stops behind the nearest hit. The coarse work (cells, boxes) is done with margins
//! that exceed its rounding errors; whether and where a part is met is decided by [`Probe`] alone,
//! so the raster changes no result.

use super::{
    parts::{Nearest, Part, Parts},
    probe::{Probe, larger, smaller},
};
use crate::{Aabb, Vec2};

mod build;
mod empty;

/// Columns and rows of the empty rectangles that a cell can name. Roughly a geometric series: a
/// rectangle is rounded down by a fifth on average, which costs a step now and then.
const EXTENTS: [u8; 15] = [1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 22, 28, 36, 48, 64];

/// How far beyond the border of a rectangle, in cells, a ray is taken to leave it. Much more than
/// all rounding errors, so each step leads into another cell.
const OVERSHOOT_CELLS: f64 = 1.0 / 16384.0;

/// How far a part reaches beyond itself, in cells, when the cells that it lies in are listed. More
/// than the overshoot, so that what is skipped there was met before.
const MARGIN_CELLS: f64 = 4.0 * OVERSHOOT_CELLS;

/// Width and height of an empty rectangle, in cells, by its code.
static SHAPES: [[f64; 2]; 256] = shapes();

const fn shapes() -> [[f64; 2]; 256] {
    let mut shapes = [[1.0; 2]; 256];
    let mut code = 0;
    while code < 256 {
        if code % 16 < 15 && code / 16 < 15 {
            shapes[code] = [EXTENTS[code % 16] as f64, EXTENTS[code / 16] as f64];
        }
        code += 1;
    }
    shapes
}

/// Of an empty cell, for rays into each quadrant, the code of an empty rectangle in that direction
/// with the cell in its corner, one byte each; of another cell, [`Cell::OCCUPIED`] and where its
/// list begins.
#[derive(Clone, Copy, Debug)]
struct Cell(u32);

impl Cell {
    /// No empty rectangle has 15 as the upper half of its code.
    const OCCUPIED: u32 = 15 << 28;

    #[inline]
    fn list(self) -> Option<usize> {
        self.0.checked_sub(Self::OCCUPIED).map(|list| list as usize)
    }

    #[inline]
    fn shape(self, quadrant: usize) -> [f64; 2] {
        SHAPES[(self.0 >> (8 * quadrant) & 255) as usize]
    }
}

/// Parts of a list that are tested together.
const LANES: usize = 4;

/// Four parts of a cell and the boxes around what of them lies in it. Two fit in a line of the
/// cache.
#[derive(Clone, Debug)]
#[repr(align(32))]
struct Group {
    /// Min x, min y, max x, max y of each lane, in levels, rounded outwards. An unused
    /// lane has an empty box.
    boxes: [[u8; LANES]; 4],
    /// In the last group of a list the first is marked so, by a bit that parts leave free.
    parts: [Part; LANES],
}

impl Group {
    const LAST: u32 = 1 << 31;
    const EMPTY: Self = Self {
        boxes: [[255; LANES], [255; LANES], [0; LANES], [0; LANES]],
        parts: [Part(0); LANES],
    };

    #[inline]
    fn part(&self, lane: usize) -> Part {
        Part(self.parts[lane].0 & !Self::LAST)
    }

    #[inline]
    fn is_last(&self) -> bool {
        self.parts[0].0 >= Self::LAST
    }
}

/// Where level 0 is, from the lower border of a cell, and how far the 256 levels are apart, in
/// cells. They reach a little beyond the cell on both sides, further than the margin of its parts.
const LEVEL_0: f32 = -1.0 / 64.0;
const LEVEL_STEP: f32 = (1.0 + 2.0 / 64.0) / 255.0;

/// A ray within one cell.
struct Within {
    /// Along the ray to the level 0 of either axis, and from a level to the next; metres.
    zero: [f32; 2],
    step: [f32; 2],
    near: [usize; 2],
}

impl Within {
    /// The ray from `along` (m) on in a cell.
    #[inline]
    fn new(axes: [&Axis; 2], place: [u32; 2], along: f64) -> Self {
        let mut within = Self { zero: [0.0; 2], step: [0.0; 2], near: [0, 1] };
        for i in 0..2 {
            let Axis { start, slope, turned, inverse_given, .. } = *axes[i];
            let turned_inside = start + along * slope - f64::from(place[i]);
            let inside = (turned as f64 - turned_inside).abs() as f32;
            within.zero[i] = (LEVEL_0 - inside) * inverse_given;
            within.step[i] = LEVEL_STEP * inverse_given;
            within.near[i] = i + 2 * turned;
        }
        within
    }

    /// The lanes whose boxes the ray meets, one bit each.
    #[inline]
    fn lanes(&self, group: &Group) -> u32 {
        let [near_x, near_y] = self.near.map(|plane| &group.boxes[plane & 3]);
        let [far_x, far_y] = self.near.map(|plane| &group.boxes[(plane ^ 2) & 3]);
        let [zero_x, zero_y] = self.zero;
        let [step_x, step_y] = self.step;
        let mut met = [0_u32; LANES];
        for lane in 0..LANES {
            let in_x = f32::from(near_x[lane]) * step_x + zero_x;
            let in_y = f32::from(near_y[lane]) * step_y + zero_y;
            let out_x = f32::from(far_x[lane]) * step_x + zero_x;
            let out_y = f32::from(far_y[lane]) * step_y + zero_y;
            let enter = larger(larger(in_x, in_y), 0.0);
            met[lane] = u32::from(enter <= smaller(out_x, out_y)) << lane;
        }
        met[0] | met[1] | met[2] | met[3]
    }
}

/// A raster over walls and blocks.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// The corner with the smallest coordinates (m).
    corner: Vec2,
    /// Around everything, a little grown.
    bounds: Aabb,
    cells_per_m: f64,
    cell_m: f64,
    columns: usize,
    rows: usize,
    /// Row by row.
    cells: Vec<Cell>,
    groups: Vec<Group>,
}

/// One axis of a ray, turned so that it goes towards larger numbers. In cells.
struct Axis {
    start: f64,
    /// Per metre of the ray.
    slope: f64,
    inverse_slope: f64,
    /// From a cell to the next, and the first, in [`Grid::cells`].
    stride: usize,
    base: usize,
    /// Whether the axis was turned: 0 or 1.
    turned: usize,
    /// With the sign that it had.
    inverse_given: f32,
}

impl Axis {
    #[inline]
    fn new(n_cells: usize, stride: usize, start: f64, slope: f64, inverse: f64) -> Self {
        let span = n_cells as f64;
        let start = smaller(larger(start, 0.0), span);
        let inverse_given = inverse as f32;
        // A branch, though every other one is guessed wrong: without it all rays wait for the
        // arithmetic that stands in for it, which was measured to be slower.
        if slope.is_sign_negative() {
            Self {
                start: span - start,
                slope: -slope,
                inverse_slope: -inverse,
                stride: stride.wrapping_neg(),
                base: (n_cells - 1) * stride,
                turned: 1,
                inverse_given,
            }
        } else {
            Self { start, slope, inverse_slope: inverse, stride, base: 0, turned: 0, inverse_given }
        }
    }

    /// The share of one axis in the place of a cell in [`Grid::cells`].
    #[inline]
    fn place(&self, cell: u32) -> usize {
        self.base.wrapping_add((cell as usize).wrapping_mul(self.stride))
    }

    /// Metres of the ray to where it is taken to leave a row of cells that ends at `border`.
    #[inline]
    fn leaving(&self, border: f64) -> f64 {
        (border - (self.start - OVERSHOOT_CELLS)) * self.inverse_slope
    }
}

impl Grid {
    /// Looks for something nearer than what is known.
    #[inline]
    pub(super) fn cast(&self, parts: &Parts, probe: &Probe, nearest: &mut Nearest) {
        let Some(skipped_m) = probe.distance_to_block(self.bounds) else { return };
        let start = probe.origin + skipped_m * probe.direction - self.corner;
        let start = start * self.cells_per_m;
        let slope = probe.direction * self.cells_per_m;
        let inverse = probe.inverse * self.cell_m;
        let x = Axis::new(self.columns, 1, start.x, slope.x, inverse.x);
        let y = Axis::new(self.rows, self.columns, start.y, slope.y, inverse.y);
        let quadrant = x.turned | y.turned << 1;
        let end = smaller(x.leaving(self.columns as f64), y.leaving(self.rows as f64));
        let mut limit = smaller(end, nearest.distance_m - skipped_m);
        let (mut column, mut row) = (x.start as u32, y.start as u32);
        let mut along = 0.0;
        // Ends, because each step leads at least one cell on along one axis, and none back.
        loop {
            let place = x.place(column).wrapping_add(y.place(row));
            let Some(&cell) = self.cells.get(place) else { break };
            let mut shape = [1.0, 1.0];
            if let Some(list) = cell.list() {
                let within = Within::new([&x, &y], [column, row], along);
                self.offer_list(list, &within, parts, probe, nearest);
                limit = smaller(limit, nearest.distance_m - skipped_m);
            } else {
                shape = cell.shape(quadrant);
            }
            along = smaller(
                x.leaving(f64::from(column) + shape[0]),
                y.leaving(f64::from(row) + shape[1]),
            );
            if along > limit {
                break;
            }
            column = (x.start + along * x.slope) as u32;
            row = (y.start + along * y.slope) as u32;
        }
    }

    /// Tests the parts of a list.
    #[inline]
    fn offer_list(
        &self,
        list: usize,
        within: &Within,
        parts: &Parts,
        probe: &Probe,
        nearest: &mut Nearest,
    ) {
        for group in &self.groups[list..] {
            let mut lanes = within.lanes(group);
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % LANES;
                parts.offer(group.part(lane), probe, nearest);
                lanes &= lanes - 1;
            }
            if group.is_last() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests;
