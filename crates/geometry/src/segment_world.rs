//! An immutable world of walls and blocks that answers ray casts and distance queries quickly.
//!
//! Walls are segments. Blocks are the occupied points of a scanned map: small squares, solid.
//!
//! Rays walk a uniform grid. A cell that is empty names, for rays into each quadrant, an empty
//! rectangle that begins there, and the ray leaps to its far side; a cell that is not leads to the
//! parts in it, in groups of four behind boxes of one byte a side, so that few are tested exactly.
//! Distances and overlaps, and rays where parts crowd in a small piece of a wide world and cells
//! would be too coarse, use a bounding volume hierarchy, four children to a node. Either way a
//! query allocates nothing, and the exact tests alone decide what it answers.
//!
//! Memory: 8 bytes of cells for each part (16 KiB at least, 16 MiB at most), 8 for each cell that a
//! part lies in (twice that where few share one; at most 16 such cells for each part on average),
//! 40 to 56 for the part, about 48 for its share of the hierarchy.
//!
//! Source: Amanatides, Woo (1987), "A fast voxel traversal algorithm for ray tracing",
//! Eurographics, for walking a grid; Cohen, Sheffer (1994), "Proximity clouds – an acceleration
//! technique for 3D grid traversal", The Visual Computer 11, for leaping over its empty space;
//! Wald, Benthin, Boulos (2008), "Getting rid of packets", IEEE Symposium on Interactive Ray
//! Tracing, doi:10.1109/RT.2008.4634620, for the wide hierarchy that is built by pulling up the
//! children of a binary one; Wald (2007), "On fast construction of SAH-based bounding volume
//! hierarchies", doi:10.1109/RT.2007.4342588, for binning. Ize (2013), "Robust BVH ray traversal",
//! JCGT 2(2), for the slack that makes the box test safe under rounding.
//!
//! Differences: a leap is as long as a rectangle in the ray's quadrant allows, not a ball, which
//! would be small beside every wall; in the plane the chance that a ray meets a box grows with its
//! perimeter, not its surface; the depth is bounded, because the stack is; squares that lie on a
//! common raster and touch are merged into rectangles first, which changes no distance, as they
//! are solid.
//!
//! Not for worlds that change: build a new one, or keep what moves beside it. The tests' oracles
//! are loops over all primitives with formulas of their own, and parry2d.

mod bvh;
mod convex;
mod grid;
mod merge;
mod parts;
mod probe;

use crate::{Aabb, ConeScene, ConeView, Ray, RayCaster, RayHit, Segment, Vec2};
use bvh::Bvh;
use grid::Grid;
use parts::Nearest;
use probe::Probe;

/// With so many blocks a world counts as a scanned map, in which cones show crowds of them.
const CROWDED_FROM: usize = 1000;

/// Walls and solid squares, indexed for queries.
///
/// Primitives with a coordinate that is not finite are kept in [`segments`](Self::segments) or
/// [`points`](Self::points), but nothing ever meets them.
#[derive(Clone, Debug)]
pub struct SegmentWorld {
    segments: Vec<(Segment, u32)>,
    points: Vec<(Vec2, u32)>,
    point_size_m: f64,
    bvh: Bvh,
    /// For rays; `None` where it does not pay.
    grid: Option<Grid>,
}

impl SegmentWorld {
    /// Indexes walls, each with a tag that its hits carry. O(n log n) time and O(n) memory.
    ///
    /// # Panics
    ///
    /// With more than 2³⁰ walls.
    pub fn new(segments: impl IntoIterator<Item = (Segment, u32)>) -> Self {
        Self::with_points(segments, [], 0.0)
    }

    /// Indexes walls and points; a point is a solid square with sides of `point_size_m` along the
    /// axes, centred on it. O(n log n) time and O(n) memory.
    ///
    /// A `point_size_m` that is negative or not finite counts as 0.
    ///
    /// # Panics
    ///
    /// With more than 2³⁰ walls or points.
    pub fn with_points(
        segments: impl IntoIterator<Item = (Segment, u32)>,
        points: impl IntoIterator<Item = (Vec2, u32)>,
        point_size_m: f64,
    ) -> Self {
        let segments: Vec<_> = segments.into_iter().collect();
        let points: Vec<_> = points.into_iter().collect();
        let point_size_m = if point_size_m.is_finite() { point_size_m.max(0.0) } else { 0.0 };
        let blocks = merge::blocks(&points, point_size_m);
        let bvh = Bvh::build(&segments, &blocks);
        let grid = Grid::build(bvh.parts());
        Self { segments, points, point_size_m, bvh, grid }
    }

    /// Whether something lies on the straight way between two points (m), ends included.
    ///
    /// Cost as for a ray cast.
    pub fn is_blocked(&self, from: Vec2, to: Vec2) -> bool {
        let way = to - from;
        let length_m = way.norm();
        if length_m > 0.0 {
            self.cast(&Ray { origin: from, direction: way / length_m }, length_m).is_some()
        } else {
            self.nearest_distance(from, 0.0).is_some()
        }
    }

    /// From `point` (m) to the nearest wall or block, metres, when that is at most `within_m`; 0
    /// inside a block. `None` also for a point that is not finite.
    ///
    /// About O(log n); a small `within_m` makes it cheaper.
    pub fn nearest_distance(&self, point: Vec2, within_m: f64) -> Option<f64> {
        self.bvh.nearest_distance(point, within_m)
    }

    /// From a convex polygon (corners in m, counter-clockwise) to the nearest wall or block, metres,
    /// when that is at most `within_m`; 0 when they touch. `None` also for fewer than three corners
    /// or corners that are not finite.
    ///
    /// About O(log n + k m) for k primitives near the polygon and its m corners.
    pub fn polygon_distance(&self, convex: &[Vec2], within_m: f64) -> Option<f64> {
        self.bvh.polygon_distance(convex, within_m)
    }

    /// Whether a wall or block meets a convex polygon (corners in m, counter-clockwise), or lies
    /// in it; touching counts. Fewer than three corners touch nothing.
    ///
    /// About O(log n + k m) for k primitives near the polygon and its m corners.
    pub fn touches_polygon(&self, convex: &[Vec2]) -> bool {
        self.bvh.touches_convex(convex)
    }

    /// The smallest box around everything in it; [`Aabb::EMPTY`] for an empty world.
    pub fn bounds(&self) -> Aabb {
        self.bvh.parts().bounds
    }

    /// The walls and their tags, as given.
    pub fn segments(&self) -> &[(Segment, u32)] {
        &self.segments
    }

    /// The centres of the squares (m) and their tags, as given.
    pub fn points(&self) -> &[(Vec2, u32)] {
        &self.points
    }

    /// Side of the square that stands for a point, metres.
    pub fn point_size_m(&self) -> f64 {
        self.point_size_m
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many walls and points it was given.
    pub fn len(&self) -> usize {
        self.segments.len() + self.points.len()
    }
}

impl RayCaster for SegmentWorld {
    /// The nearest wall or block on the ray within `range_max_m`, that distance included.
    ///
    /// A ray that starts on a wall or in a block meets it at 0; one that runs along a wall meets
    /// its nearer end, and the normal then points back along the ray. Of equally near walls the
    /// one with the lower index answers, and walls come before points. `None` when the direction
    /// is not a unit vector to within a factor of two, or a number is not finite.
    ///
    /// Cost: a step for each empty rectangle and each occupied cell on the way; about 4 in a
    /// building, hardly more for a longer range. O(log n) where the world has no grid.
    fn cast(&self, ray: &Ray, range_max_m: f64) -> Option<RayHit> {
        let probe = Probe::new(ray)?;
        if range_max_m.is_nan() || range_max_m < 0.0 {
            return None;
        }
        let parts = self.bvh.parts();
        let mut nearest = Nearest::none_within(range_max_m);
        match &self.grid {
            Some(grid) => grid.cast(parts, &probe, &mut nearest),
            None => self.bvh.cast(&probe, &mut nearest),
        }
        parts.hit(&probe, &nearest)
    }
}

impl ConeScene for SegmentWorld {
    /// Scanned maps are.
    fn is_crowded(&self) -> bool {
        self.bvh.parts().blocks.len() >= CROWDED_FROM
    }

    /// Walks the hierarchy from near to far, and not behind a front that is closed: about O(log n)
    /// for each surface in sight.
    fn show(&self, view: &mut ConeView) {
        if view.wants_crowds() || !self.is_crowded() {
            self.bvh.show(view);
        }
    }
}

#[cfg(test)]
mod tests;
