//! The hierarchy itself: ray cast, distance and overlap queries.

use super::{
    convex,
    parts::{Nearest, Part, Parts},
    probe::{Probe, larger},
};
use crate::{Aabb, Vec2};

mod boxes;
mod build;
mod coarse;
mod room;
mod show;

use boxes::{Boxes, WIDTH};
use coarse::CoarseRay;

/// Levels of nodes at most. Four to the power of this is more than can be numbered, so there is
/// always a tree that fits.
const LEVELS_MAX: usize = 16;

/// Children that wait on the way down: at each level at most all but the one walked into, so 48;
/// a power of two, because masking an index is quicker than checking it.
const STACK_SIZE: usize = 64;
const _: () = assert!(LEVELS_MAX * (WIDTH - 1) + 1 < STACK_SIZE);

/// What one lane of a node leads to: a kind in two bits, an index in thirty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Child(u32);

/// A decoded [`Child`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leads {
    Nowhere,
    ToNode(usize),
    ToWall(usize),
    ToBlock(usize),
}

impl Child {
    const INDEX_BITS: u32 = 30;
    const ROOT: Self = Self(0);
    const NOWHERE: Self = Self(3 << Self::INDEX_BITS);

    fn new(to: Leads) -> Self {
        let (kind, index) = match to {
            Leads::ToNode(index) => (0, index),
            Leads::ToWall(index) => (1, index),
            Leads::ToBlock(index) => (2, index),
            Leads::Nowhere => return Self::NOWHERE,
        };
        Self(kind << Self::INDEX_BITS | index as u32)
    }

    /// The node, if it leads to one; nodes are met most often and have the lowest numbers.
    #[inline]
    fn node(self) -> Option<usize> {
        (self.0 < 1 << Self::INDEX_BITS).then_some(self.0 as usize)
    }

    #[inline]
    fn leads(self) -> Leads {
        let index = (self.0 & ((1 << Self::INDEX_BITS) - 1)) as usize;
        match self.0 >> Self::INDEX_BITS {
            0 => Leads::ToNode(index),
            1 => Leads::ToWall(index),
            2 => Leads::ToBlock(index),
            _ => Leads::Nowhere,
        }
    }
}

/// What the four boxes of a node lead to.
#[derive(Clone, Debug)]
#[repr(align(32))]
struct Links {
    children: [Child; WIDTH],
    /// For rays into each quadrant, the lanes from far to near, two bits each, the first lowest.
    orders: [u8; 4],
}

impl Links {
    /// The lanes from far to near, for a ray into a quadrant.
    #[inline]
    fn lanes(&self, quadrant: usize) -> [usize; WIDTH] {
        let order = usize::from(self.orders[quadrant]);
        [order & 3, order >> 2 & 3, order >> 4 & 3, order >> 6]
    }
}

/// A bounding volume hierarchy over walls and blocks.
#[derive(Clone, Debug)]
pub(super) struct Bvh {
    /// Node by node, the root first; empty when there is nothing.
    boxes: Vec<Boxes>,
    links: Vec<Links>,
    /// In the order of the nodes that lead to them.
    parts: Parts,
}

impl Bvh {
    pub(super) fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Looks for something nearer than what is known.
    // Not part of the caller, which has a way of its own and wants the registers for it.
    #[inline(never)]
    pub(super) fn cast(&self, probe: &Probe, nearest: &mut Nearest) {
        let Some(coarse) = CoarseRay::new(probe, self.parts.bounds) else { return };
        // The stack is two arrays and a number of their own, not a struct: the number then stays in
        // a register. What waits is the child and where the ray enters its box.
        let mut waiting = [Child::ROOT; STACK_SIZE];
        let mut entries = [0.0_f32; STACK_SIZE];
        let mut n_waiting = 1;
        let mut limit = coarse.limit(nearest.distance_m);
        let quadrant = coarse.quadrant();
        while n_waiting > 0 {
            n_waiting -= 1;
            if entries[n_waiting % STACK_SIZE] > limit {
                continue;
            }
            let child = waiting[n_waiting % STACK_SIZE];
            if let Some(node) = child.node() {
                let (enter, leave) = coarse.spans(&self.boxes[node], limit);
                let links = &self.links[node];
                for lane in links.lanes(quadrant) {
                    // Written in any case and counted when it is met: a branch here could not be
                    // foreseen, and costs more.
                    waiting[n_waiting % STACK_SIZE] = links.children[lane];
                    entries[n_waiting % STACK_SIZE] = enter[lane];
                    n_waiting += usize::from(enter[lane] <= leave[lane]);
                }
                continue;
            }
            match child.leads() {
                Leads::ToWall(place) => self.parts.offer(Part::wall(place), probe, nearest),
                Leads::ToBlock(place) => self.parts.offer(Part::block(place), probe, nearest),
                Leads::ToNode(_) | Leads::Nowhere => continue,
            }
            limit = coarse.limit(nearest.distance_m);
        }
    }

    pub(super) fn touches_convex(&self, convex: &[Vec2]) -> bool {
        if self.boxes.is_empty() || convex.len() < 3 {
            return false;
        }
        let around = Aabb::around(convex.iter().copied());
        let mut waiting = [Child::ROOT; STACK_SIZE];
        let mut n_waiting = 1;
        while n_waiting > 0 {
            n_waiting -= 1;
            let meets = match waiting[n_waiting].leads() {
                Leads::ToNode(node) => {
                    for (lane, &child) in self.links[node].children.iter().enumerate() {
                        if self.lane_bounds(node, lane).overlaps(around) {
                            waiting[n_waiting] = child;
                            n_waiting += 1;
                        }
                    }
                    false
                }
                Leads::ToWall(index) => convex::meets_wall(convex, self.parts.walls[index].segment),
                Leads::ToBlock(index) => {
                    let bounds = self.parts.blocks[index].bounds;
                    bounds.overlaps(around) && convex::meets_block(convex, bounds)
                }
                Leads::Nowhere => false,
            };
            if meets {
                return true;
            }
        }
        false
    }

    /// The box of one lane, in the world's coordinates; contains all that the lane leads to.
    fn lane_bounds(&self, node: usize, lane: usize) -> Aabb {
        let middle = self.parts.bounds.centre();
        let [min_x, min_y, max_x, max_y] = self.boxes[node].0.map(|plane| f64::from(plane[lane]));
        Aabb { min: middle + Vec2::new(min_x, min_y), max: middle + Vec2::new(max_x, max_y) }
    }
}

/// From `point` to a box, metres; 0 inside; infinite for an empty box.
fn distance_to_box(bounds: Aabb, point: Vec2) -> f64 {
    let beyond = |low: f64, x: f64, high: f64| larger(larger(low - x, x - high), 0.0);
    let beyond_x = beyond(bounds.min.x, point.x, bounds.max.x);
    let beyond_y = beyond(bounds.min.y, point.y, bounds.max.y);
    (beyond_x * beyond_x + beyond_y * beyond_y).sqrt()
}
