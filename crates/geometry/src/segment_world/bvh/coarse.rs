//! Tests a ray against the boxes of the hierarchy, in single precision, four at a time.
//!
//! The boxes were rounded outwards by more than all errors of the test (see [`margin_m`]), so a box
//! may be entered in vain but never missed.

use super::{
    super::probe::{Probe, larger, smaller},
    boxes::{Boxes, WIDTH},
};
use crate::Aabb;

/// Outward rounding of boxes, in parts of the world's larger half side H.
///
/// With ε = 2⁻²⁴ the box test errs by at most 8 ε H along either axis: ε for the rounding of the
/// plane, ε for that of the origin, 2 ε for their difference, 4 ε for reciprocal and product. This
/// is four times that.
const MARGIN_RATIO: f64 = 1.0 / 524_288.0;

/// By how much boxes of a world are rounded outwards, metres.
pub(super) fn margin_m(bounds: Aabb) -> f64 {
    MARGIN_RATIO * 0.5 * bounds.size().max()
}

/// The ray as the box test wants it.
pub(super) struct CoarseRay {
    /// Metres from the origin to where the coarse ray starts: at the world's border, or 0.
    skipped_m: f64,
    /// Start of the coarse ray, from the middle of the world.
    origin: [f32; 2],
    inverse: [f32; 2],
    /// Which planes are met first and last, in x and in y.
    near: [usize; 2],
    far: [usize; 2],
}

impl CoarseRay {
    /// `None` when the ray misses `bounds`.
    pub(super) fn new(probe: &Probe, bounds: Aabb) -> Option<Self> {
        if bounds.is_empty() {
            return None;
        }
        // A far origin would have no digits left in single precision: start at the border.
        let skipped_m = probe.distance_to_block(bounds.grown(0.5 * margin_m(bounds)))?;
        let start = probe.origin + skipped_m * probe.direction - bounds.centre();
        let order = |d: f64, low: usize, high: usize| {
            if d.is_sign_negative() { (high, low) } else { (low, high) }
        };
        let (near_x, far_x) = order(probe.direction.x, 0, 2);
        let (near_y, far_y) = order(probe.direction.y, 1, 3);
        Some(Self {
            skipped_m,
            origin: [start.x as f32, start.y as f32],
            inverse: [probe.inverse.x as f32, probe.inverse.y as f32],
            near: [near_x, near_y],
            far: [far_x, far_y],
        })
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
        let [x, y] = self.origin;
        let [inverse_x, inverse_y] = self.inverse;
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
}
