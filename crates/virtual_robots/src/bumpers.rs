//! Bumpers in segments, pressed by what lies against them.

use geometry::Vec2;
use simulator::{BodyId, World};

/// How far the segments stand out of the body, metres: more than the gap at which the world takes
/// a contact for over.
const STANDS_OUT_M: f64 = 2e-3;

/// The segments' outlines.
#[derive(Clone, Debug)]
pub(crate) struct Bumpers {
    /// Base frame, metres; convex, counter-clockwise, from the robot's centre out.
    segments: Vec<Vec<Vec2>>,
    scratch: Vec<Vec2>,
}

impl Bumpers {
    /// Around a convex footprint that holds the origin: a segment for each pair of bearings, degrees, the right
    /// one first; each less than 180° wide, and at most 32 of them.
    pub(crate) fn new(
        footprint: &[Vec2],
        bearings_deg: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        let outside: Vec<Vec2> = footprint
            .iter()
            .map(|corner| corner * (1.0 + STANDS_OUT_M / corner.norm().max(STANDS_OUT_M)))
            .collect();
        let segments =
            bearings_deg.into_iter().map(|[right, left]| sector(&outside, right, left)).collect();
        Self { segments, scratch: Vec::with_capacity(16) }
    }

    /// Bits of the segments that something lies against; bit 0 is the first.
    pub(crate) fn pressed(&mut self, world: &World, body_id: BodyId) -> u32 {
        let Self { segments, scratch } = self;
        segments.iter().enumerate().fold(0, |bits, (index, outline)| {
            bits | (u32::from(world.meets(body_id, outline, scratch)) << index)
        })
    }

    #[cfg(test)]
    pub(crate) fn outlines(&self) -> &[Vec<Vec2>] {
        &self.segments
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
