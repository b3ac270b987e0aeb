//! A ray prepared for many exact tests of walls and blocks.

use crate::{Aabb, Ray, Segment, Vec2};

/// A component of a direction smaller than this is replaced by it where one is divided by it, so
/// that no product of 0 and infinity arises; in any world it moves nothing.
const DIRECTION_MIN: f64 = 1e-30;

/// Factor on the far end of a block, so that rounding cannot open its corners.
///
/// Source: Ize (2013), "Robust BVH ray traversal", JCGT 2(2): 1 + 2 γ₃ with γₙ = n ε / (1 - n ε).
const FAR_SLACK_RATIO: f64 = 1.0 + 4.0 * f64::EPSILON;

/// The ray, and what every test would compute anew.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    pub(super) origin: Vec2,
    pub(super) direction: Vec2,
    /// One over each component of the direction; never infinite.
    pub(super) inverse: Vec2,
}

/// `if` and not `f64::min`: it is one instruction, and no number here is NaN.
#[inline]
pub(super) fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// As [`smaller`].
#[inline]
pub(super) fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

impl Probe {
    /// `None` when the ray is not finite or has no direction of about unit length.
    #[inline]
    pub(super) fn new(ray: &Ray) -> Option<Self> {
        let Ray { origin, direction } = *ray;
        let sound = origin.x.is_finite()
            && origin.y.is_finite()
            && (0.25..=4.0).contains(&direction.norm_squared());
        let inverse = |d: f64| 1.0 / larger(d.abs(), DIRECTION_MIN).copysign(d);
        let inverse = Vec2::new(inverse(direction.x), inverse(direction.y));
        sound.then_some(Self { origin, direction, inverse })
    }

    /// Distance to a wall, if the ray meets it; never negative.
    ///
    /// In the ray's own frame, x along it: the wall is met where it crosses the axis. Both walls of
    /// a corner compute its place from the same numbers, so no ray slips between them.
    #[inline]
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
    #[inline]
    pub(super) fn distance_to_block(&self, block: Aabb) -> Option<f64> {
        let ([in_x, in_y], [out_x, out_y]) = self.crossings(block);
        let enter = larger(larger(in_x, in_y), 0.0);
        (enter <= smaller(out_x, out_y) * FAR_SLACK_RATIO).then_some(enter)
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
        let ([in_x, in_y], _) = self.crossings(block);
        if larger(in_x, in_y) < 0.0 {
            // The origin is inside.
            -self.direction
        } else if in_x >= in_y {
            Vec2::new(-1.0_f64.copysign(self.direction.x), 0.0)
        } else {
            Vec2::new(0.0, -1.0_f64.copysign(self.direction.y))
        }
    }

    /// Where the ray passes the nearer and the farther planes of a box in x and in y.
    #[inline]
    fn crossings(&self, bounds: Aabb) -> ([f64; 2], [f64; 2]) {
        let (mut enter, mut leave) = ([0.0; 2], [0.0; 2]);
        for axis in 0..2 {
            let low = (bounds.min[axis] - self.origin[axis]) * self.inverse[axis];
            let high = (bounds.max[axis] - self.origin[axis]) * self.inverse[axis];
            (enter[axis], leave[axis]) = (smaller(low, high), larger(low, high));
        }
        (enter, leave)
    }
}
