//! A ray prepared for many tests: coarse ones of boxes, exact ones of walls and blocks.
//!
//! Boxes are tested in single precision, four at a time. They were rounded outwards by more than
//! all errors of the test (see [`margin_m`]), so a box may be entered in vain but never missed.

use super::{Boxes, WIDTH};
use crate::{Aabb, Ray, Segment, Vec2};

/// Outward rounding of boxes, in parts of the world's larger half side H.
///
/// With ε = 2⁻²⁴ the box test errs by at most 8 ε H along either axis: ε for the rounding of the
/// plane, ε for that of the origin, 2 ε for their difference, 4 ε for reciprocal and product. This
/// is four times that.
const MARGIN_RATIO: f64 = 1.0 / 524_288.0;

/// A component of a direction smaller than this is replaced by it, so that no product of 0 and
/// infinity arises; in any world with single-precision boxes it moves nothing.
const DIRECTION_MIN: f64 = 1e-30;

/// Factor on the far end of a block, so that rounding cannot open its corners.
///
/// Source: Ize (2013), "Robust BVH ray traversal", JCGT 2(2): 1 + 2 γ₃ with γₙ = n ε / (1 - n ε).
const FAR_SLACK_RATIO: f64 = 1.0 + 4.0 * f64::EPSILON;

/// By how much boxes of a world are rounded outwards, metres.
pub(super) fn margin_m(bounds: Aabb) -> f64 {
    MARGIN_RATIO * 0.5 * bounds.size().max()
}

/// The ray, as it was given and as the box test wants it.
pub(super) struct Probe {
    origin: Vec2,
    direction: Vec2,
    /// One over each component of the direction; never infinite.
    inverse: Vec2,
    /// Metres from the origin to where the coarse ray starts: at the world's border, or 0.
    skipped_m: f64,
    /// Start of the coarse ray, from the middle of the world.
    coarse_origin: [f32; 2],
    coarse_inverse: [f32; 2],
    /// Which planes are met first and last, in x and in y.
    near: [usize; 2],
    far: [usize; 2],
}

impl Probe {
    /// `None` when the ray misses `bounds`, is not finite or has no direction of about unit length.
    pub(super) fn new(ray: &Ray, bounds: Aabb) -> Option<Self> {
        let Ray { origin, direction } = *ray;
        let sound = origin.x.is_finite()
            && origin.y.is_finite()
            && (0.25..=4.0).contains(&direction.norm_squared());
        if !sound || bounds.is_empty() {
            return None;
        }
        let inverse = direction.map(|d| 1.0 / d.abs().max(DIRECTION_MIN).copysign(d));
        let order = |d: f64, low: usize, high: usize| {
            if d.is_sign_negative() { (high, low) } else { (low, high) }
        };
        let (near_x, far_x) = order(direction.x, 0, 2);
        let (near_y, far_y) = order(direction.y, 1, 3);
        let mut probe = Self {
            origin,
            direction,
            inverse,
            skipped_m: 0.0,
            coarse_origin: [0.0; 2],
            coarse_inverse: [inverse.x as f32, inverse.y as f32],
            near: [near_x, near_y],
            far: [far_x, far_y],
        };
        // A far origin would have no digits left in single precision: start at the border.
        probe.skipped_m = probe.distance_to_block(bounds.grown(0.5 * margin_m(bounds)))?;
        let start = origin + probe.skipped_m * direction - bounds.centre();
        probe.coarse_origin = [start.x as f32, start.y as f32];
        Some(probe)
    }

    /// The quadrant of the direction: bit 0 to the left, bit 1 down.
    pub(super) fn quadrant(&self) -> usize {
        self.near[0] >> 1 | (self.near[1] & 2)
    }

    /// Distance from the origin as a limit of the coarse ray.
    pub(super) fn limit(&self, distance_m: f64) -> f32 {
        (distance_m - self.skipped_m) as f32
    }

    /// Where the coarse ray enters and leaves each lane's box, not before its start and not beyond
    /// `limit`; a box is met where the first is at most the second.
    ///
    /// Source: Williams, Barrus, Morley, Shirley (2005), "An efficient and robust ray-box
    /// intersection algorithm", Journal of Graphics Tools 10(1).
    #[inline]
    pub(super) fn spans(&self, boxes: &Boxes, limit: f32) -> ([f32; WIDTH], [f32; WIDTH]) {
        // `if` and not `f32::min`: it is one instruction, and no number here is NaN.
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let smaller = |a: f32, b: f32| if a < b { a } else { b };
        let [x, y] = self.coarse_origin;
        let [inverse_x, inverse_y] = self.coarse_inverse;
        let [near_x, near_y] = self.near.map(|plane| &boxes.0[plane]);
        let [far_x, far_y] = self.far.map(|plane| &boxes.0[plane]);
        let (mut enter, mut leave) = ([0.0; WIDTH], [0.0; WIDTH]);
        for lane in 0..WIDTH {
            let in_x = (near_x[lane] - x) * inverse_x;
            let in_y = (near_y[lane] - y) * inverse_y;
            let out_x = (far_x[lane] - x) * inverse_x;
            let out_y = (far_y[lane] - y) * inverse_y;
            enter[lane] = larger(larger(in_x, in_y), 0.0);
            leave[lane] = smaller(smaller(out_x, out_y), limit);
        }
        (enter, leave)
    }

    /// Distance to a wall, if the ray meets it; never negative.
    ///
    /// In the ray's own frame, x along it: the wall is met where it crosses the axis. Both walls of
    /// a corner compute its place from the same numbers, so no ray slips between them.
    pub(super) fn distance_to_wall(&self, wall: Segment) -> Option<f64> {
        let (a, b) = (wall.a - self.origin, wall.b - self.origin);
        let (a_across, b_across) = (self.direction.perp(&a), self.direction.perp(&b));
        if (a_across > 0.0 && b_across > 0.0) || (a_across < 0.0 && b_across < 0.0) {
            return None;
        }
        let (a_along, b_along) = (self.direction.dot(&a), self.direction.dot(&b));
        let on_axis = |across: f64| across.abs() <= 0.0;
        let distance = if on_axis(a_across) && on_axis(b_across) {
            // The wall lies in the ray's line: its nearer end, or here when it spans the origin.
            let (first, last) = (a_along.min(b_along), a_along.max(b_along));
            if first < 0.0 && last >= 0.0 { 0.0 } else { first }
        } else if on_axis(b_across) {
            b_along
        } else {
            a_along + (b_along - a_along) * (a_across / (a_across - b_across))
        };
        // Also turns -0.0 into 0.0; false for NaN, which only overflow can bring.
        (distance >= 0.0).then_some(distance.abs())
    }

    /// Distance to a solid block, if the ray meets it; 0 when it starts inside.
    pub(super) fn distance_to_block(&self, block: Aabb) -> Option<f64> {
        let [in_x, in_y] = self.entries(block);
        let planes = [block.min.x, block.min.y, block.max.x, block.max.y];
        let out_x = (planes[self.far[0]] - self.origin.x) * self.inverse.x;
        let out_y = (planes[self.far[1]] - self.origin.y) * self.inverse.y;
        let enter = in_x.max(in_y).max(0.0);
        (enter <= out_x.min(out_y) * FAR_SLACK_RATIO).then_some(enter)
    }

    /// The normal of a wall, turned towards the origin of the ray.
    pub(super) fn facing(&self, normal: Vec2) -> Vec2 {
        let along = normal.dot(&self.direction);
        if along < 0.0 {
            normal
        } else if along > 0.0 {
            -normal
        } else {
            // A wall in line with the ray is met at its end, which has no side of its own.
            -self.direction
        }
    }

    /// The normal of the side by which the ray enters a block.
    pub(super) fn entry_normal(&self, block: Aabb) -> Vec2 {
        let [in_x, in_y] = self.entries(block);
        if in_x.max(in_y) < 0.0 {
            // The origin is inside.
            -self.direction
        } else if in_x >= in_y {
            Vec2::new(-1.0_f64.copysign(self.direction.x), 0.0)
        } else {
            Vec2::new(0.0, -1.0_f64.copysign(self.direction.y))
        }
    }

    /// Where the ray passes the near planes of a box in x and in y.
    fn entries(&self, bounds: Aabb) -> [f64; 2] {
        let planes = [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y];
        [
            (planes[self.near[0]] - self.origin.x) * self.inverse.x,
            (planes[self.near[1]] - self.origin.y) * self.inverse.y,
        ]
    }
}
