//! The bumpers: five segments in front and five behind, pressed by what lies against them.
//!
//! Segments are numbered clockwise as seen from above: the first of the front is the leftmost, the
//! first of the rear the rightmost. Each covers 27°, so that the sides, where the wheels are, have
//! none.
//!
//! Source: the client library AriaCoda (commit b0d02e0) places the readings of five segments in
//! this order over 135°.

use geometry::Vec2;
use simulator::{BodyId, World};

/// Segments in front, and as many behind.
pub(super) const N_SEGMENTS: u8 = 5;
/// Angle that one segment covers, degrees.
const SEGMENT_DEG: f64 = 27.0;
/// How far the segments stand out of the body, metres: more than the gap at which the world takes
/// a contact for over.
const STANDS_OUT_M: f64 = 2e-3;

/// The segments' outlines.
#[derive(Clone, Debug)]
pub(super) struct Bumpers {
    /// Front and rear, base frame, metres; convex, counter-clockwise, from the robot's centre out.
    segments: [Vec<Vec<Vec2>>; 2],
    scratch: Vec<Vec2>,
}

impl Bumpers {
    /// Around a convex footprint that holds the origin.
    pub(super) fn new(footprint: &[Vec2]) -> Self {
        let outside: Vec<Vec2> = footprint
            .iter()
            .map(|corner| corner * (1.0 + STANDS_OUT_M / corner.norm().max(STANDS_OUT_M)))
            .collect();
        let ring = |middle_deg: f64| {
            (0..N_SEGMENTS)
                .map(|index| {
                    let half_span = 0.5 * f64::from(N_SEGMENTS);
                    let left_deg = middle_deg + SEGMENT_DEG * (half_span - f64::from(index));
                    sector(&outside, left_deg - SEGMENT_DEG, left_deg)
                })
                .collect()
        };
        Self { segments: [ring(0.0), ring(180.0)], scratch: Vec::with_capacity(16) }
    }

    /// Bits of the segments that something lies against, front and rear; bit 0 is the first.
    pub(super) fn pressed(&mut self, world: &World, body_id: BodyId) -> [u8; 2] {
        let Self { segments, scratch } = self;
        segments.each_ref().map(|ring| {
            ring.iter().enumerate().fold(0, |bits, (index, outline)| {
                bits | (u8::from(world.meets(body_id, outline, scratch)) << index)
            })
        })
    }
}

/// The part of a convex outline around the origin between two bearings, less than 180° apart.
fn sector(outline: &[Vec2], right_deg: f64, left_deg: f64) -> Vec<Vec2> {
    let heading = |deg: f64| {
        let (s, c) = deg.to_radians().sin_cos();
        Vec2::new(c, s)
    };
    let (right, left) = (heading(right_deg), heading(left_deg));
    let inner = clip(outline, |point| right.perp(&point));
    clip(&inner, |point| -left.perp(&point))
}

/// The part of a convex outline where `side` is not negative.
fn clip(outline: &[Vec2], side: impl Fn(Vec2) -> f64) -> Vec<Vec2> {
    let mut part = Vec::new();
    for (&a, &b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        let (from, to) = (side(a), side(b));
        if from >= 0.0 {
            part.push(a);
        }
        if (from < 0.0) != (to < 0.0) && from != 0.0 && to != 0.0 {
            part.push(a + (b - a) * (from / (from - to)));
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_run_clockwise_and_leave_the_sides_out() {
        let square =
            [(0.2, -0.2), (0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2)].map(|(x, y)| Vec2::new(x, y));
        let bumpers = Bumpers::new(&square);
        let bearing = |outline: &[Vec2]| {
            let middle: Vec2 = outline.iter().filter(|c| c.norm() > 0.1).sum();
            middle.y.atan2(middle.x).to_degrees()
        };
        let [front, rear] = bumpers
            .segments
            .each_ref()
            .map(|ring| ring.iter().map(|s| bearing(s)).collect::<Vec<_>>());
        for (found, expected) in front.iter().zip([54.0, 27.0, 0.0, -27.0, -54.0]) {
            // Corners are not spread evenly over a segment, so its middle is only near.
            assert!((found - expected).abs() < 6.0, "{front:?}");
        }
        for (found, expected) in rear.iter().zip([-126.0, -153.0, 180.0, 153.0, 126.0]) {
            assert!(((found - expected + 540.0) % 360.0 - 180.0).abs() < 6.0, "{rear:?}");
        }
    }
}
