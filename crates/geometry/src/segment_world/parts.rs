//! Walls and blocks as queries want them, and the nearest one so far.

use super::probe::Probe;
use crate::{Aabb, RayHit, Segment, Vec2};

/// A solid rectangle that stands for one or more points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) bounds: Aabb,
    pub(super) tag: u32,
    /// The lowest of its points' indices; once indexed, counted on from the last wall's.
    pub(super) index: u32,
}

/// A segment, with what a query would compute anew each time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) segment: Segment,
    /// Unit vector to the left of a→b; zero for a wall without length.
    pub(super) normal: Vec2,
    pub(super) tag: u32,
    /// Its place in the list that was given.
    pub(super) index: u32,
}

/// A wall or a block, by its place in [`Parts`]: a bit for the kind, thirty for the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part(pub(super) u32);

impl Part {
    const PLACE_BITS: u32 = 30;
    const PLACE_MAX: u32 = (1 << Self::PLACE_BITS) - 1;
    const NONE: Self = Self(u32::MAX);

    pub(super) fn wall(place: usize) -> Self {
        Self(place as u32)
    }

    pub(super) fn block(place: usize) -> Self {
        Self(1 << Self::PLACE_BITS | place as u32)
    }

    #[inline]
    fn is_wall(self) -> bool {
        self.0 >> Self::PLACE_BITS & 1 == 0
    }

    #[inline]
    fn place(self) -> usize {
        (self.0 & Self::PLACE_MAX) as usize
    }
}

/// Everything that can be met; neighbours in the plane are neighbours here, more or less.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) walls: Vec<Wall>,
    pub(super) blocks: Vec<Block>,
    pub(super) bounds: Aabb,
}

/// The nearest part on a ray so far.
pub(super) struct Nearest {
    pub(super) distance_m: f64,
    index: u32,
    part: Part,
}

impl Nearest {
    /// Nothing, up to a range (m).
    #[inline]
    pub(super) fn none_within(range_max_m: f64) -> Self {
        Self { distance_m: range_max_m, index: u32::MAX, part: Part::NONE }
    }

    /// Ties are exact ones; the lower index wins them, in whatever order the two are met.
    #[inline]
    fn offer(&mut self, distance_m: f64, index: u32, part: Part) {
        let nearer =
            distance_m < self.distance_m || (distance_m <= self.distance_m && index < self.index);
        if nearer {
            *self = Self { distance_m, index, part };
        }
    }
}

impl Parts {
    /// Tests one part exactly and keeps it if it is the nearest so far.
    #[inline]
    pub(super) fn offer(&self, part: Part, probe: &Probe, nearest: &mut Nearest) {
        let (distance_m, index) = if part.is_wall() {
            let wall = &self.walls[part.place()];
            (probe.distance_to_wall(wall.segment), wall.index)
        } else {
            let block = &self.blocks[part.place()];
            (probe.distance_to_block(block.bounds), block.index)
        };
        if let Some(distance_m) = distance_m {
            nearest.offer(distance_m, index, part);
        }
    }

    /// What a ray reports of the part that was nearest.
    #[inline]
    pub(super) fn hit(&self, probe: &Probe, nearest: &Nearest) -> Option<RayHit> {
        let part = nearest.part;
        if part == Part::NONE {
            return None;
        }
        let (normal, tag) = if part.is_wall() {
            let wall = &self.walls[part.place()];
            (probe.facing(wall.normal), wall.tag)
        } else {
            let block = &self.blocks[part.place()];
            (probe.entry_normal(block.bounds), block.tag)
        };
        Some(RayHit { distance_m: nearest.distance_m, normal, tag })
    }
}
