//! Builds the hierarchy from the top, by the surface area heuristic over bins.

use std::ops::Range;

use super::{
    super::parts::{Block, Parts, Wall},
    Boxes, Bvh, Child, LEVELS_MAX, Leads, Links, WIDTH,
    coarse::margin_m,
};
use crate::{Aabb, Segment, Vec2};

/// Bins along each axis; more hardly improve the tree (Wald 2007, section 4.1, used 16).
const N_BINS: usize = 16;

/// A primitive on its way into the tree.
#[derive(Clone, Copy)]
struct Primitive {
    bounds: Aabb,
    source: Source,
}

#[derive(Clone, Copy)]
enum Source {
    Wall(u32),
    Block(u32),
}

/// One bin: what has its centre in it.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, count: 0 };

    fn with(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    /// In the plane the chance to meet a box grows with its perimeter.
    fn cost(self) -> f64 {
        if self.count == 0 { 0.0 } else { half_perimeter(self.bounds) * self.count as f64 }
    }
}

struct Builder<'a> {
    segments: &'a [(Segment, u32)],
    given_blocks: &'a [Block],
    primitives: Vec<Primitive>,
    /// What is subtracted from coordinates, and added to sizes, of boxes.
    middle: Vec2,
    margin_m: f64,
    boxes: Vec<Boxes>,
    links: Vec<Links>,
    walls: Vec<Wall>,
    blocks: Vec<Block>,
}

impl Bvh {
    pub(in super::super) fn build(segments: &[(Segment, u32)], blocks: &[Block]) -> Self {
        let most = 1 << Child::INDEX_BITS;
        assert!(segments.len() < most && blocks.len() < most, "at most 2^30 walls and points");
        let primitives = primitives(segments, blocks);
        let bounds = primitives.iter().fold(Aabb::EMPTY, |grown, p| grown.union(p.bounds));
        let all = 0..primitives.len();
        let mut builder = Builder {
            segments,
            given_blocks: blocks,
            primitives,
            middle: bounds.centre(),
            margin_m: margin_m(bounds),
            boxes: Vec::new(),
            links: Vec::new(),
            walls: Vec::new(),
            blocks: Vec::new(),
        };
        if !all.is_empty() {
            builder.add_node(all, 0);
        }
        let Builder { boxes, links, walls, blocks, .. } = builder;
        Self { boxes, links, parts: Parts { walls, blocks, bounds } }
    }
}

/// Everything with finite coordinates.
fn primitives(segments: &[(Segment, u32)], blocks: &[Block]) -> Vec<Primitive> {
    let walls = (0_u32..).zip(segments).filter_map(|(index, (segment, _))| {
        let finite = segment.a.iter().chain(segment.b.iter()).all(|x| x.is_finite());
        let bounds = Aabb::around([segment.a, segment.b]);
        finite.then_some(Primitive { bounds, source: Source::Wall(index) })
    });
    let blocks = (0_u32..).zip(blocks);
    let blocks =
        blocks.map(|(i, block)| Primitive { bounds: block.bounds, source: Source::Block(i) });
    walls.chain(blocks).collect()
}

impl Builder<'_> {
    /// Adds the node for a range of primitives and everything below it; returns its index.
    fn add_node(&mut self, range: Range<usize>, level: usize) -> usize {
        // Halving by count needs this many levels; as long as more are left, cost decides.
        let balanced = level + levels_to_halve(range.len()) + 1 >= LEVELS_MAX;
        let parts = self.split_in_four(range, balanced);
        let lane_bounds: Vec<Aabb> = parts.iter().map(|p| self.bounds_of(p.clone())).collect();
        let node = self.boxes.len();
        self.boxes.push(self.rounded_outwards(&lane_bounds));
        let orders = lane_orders(&lane_bounds);
        self.links.push(Links { children: [Child::NOWHERE; WIDTH], orders });
        for (lane, part) in parts.into_iter().enumerate() {
            let leads = if part.len() == 1 {
                self.add_primitive(part.start)
            } else {
                Leads::ToNode(self.add_node(part, level + 1))
            };
            self.links[node].children[lane] = Child::new(leads);
        }
        node
    }

    fn rounded_outwards(&self, lane_bounds: &[Aabb]) -> Boxes {
        let (high, low) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut boxes = Boxes([[high; WIDTH], [high; WIDTH], [low; WIDTH], [low; WIDTH]]);
        for (lane, bounds) in lane_bounds.iter().enumerate() {
            let Aabb { min, max } = bounds.grown(self.margin_m);
            let (min, max) = (min - self.middle, max - self.middle);
            for (plane, value) in boxes.0.iter_mut().zip([min.x, min.y, max.x, max.y]) {
                plane[lane] = value as f32;
            }
        }
        boxes
    }

    fn add_primitive(&mut self, place: usize) -> Leads {
        match self.primitives[place].source {
            Source::Wall(index) => {
                let (segment, tag) = self.segments[index as usize];
                let along = segment.b - segment.a;
                let normal = Vec2::new(-along.y, along.x).try_normalize(0.0);
                let normal = normal.unwrap_or_else(Vec2::zeros);
                self.walls.push(Wall { segment, normal, tag, index });
                Leads::ToWall(self.walls.len() - 1)
            }
            Source::Block(index) => {
                let block = self.given_blocks[index as usize];
                let index = self.segments.len() as u32 + block.index;
                self.blocks.push(Block { index, ..block });
                Leads::ToBlock(self.blocks.len() - 1)
            }
        }
    }

    fn bounds_of(&self, range: Range<usize>) -> Aabb {
        self.primitives[range].iter().fold(Aabb::EMPTY, |grown, p| grown.union(p.bounds))
    }

    /// Splits a range into up to four parts, always the part next that costs most.
    fn split_in_four(&mut self, range: Range<usize>, balanced: bool) -> Vec<Range<usize>> {
        let mut parts = vec![range];
        while parts.len() < WIDTH {
            let weight = |part: &Range<usize>| match (part.len(), balanced) {
                (1, _) => 0.0,
                (n, true) => n as f64,
                (n, false) => half_perimeter(self.bounds_of(part.clone())) * n as f64,
            };
            let splittable = (0..parts.len()).filter(|&i| parts[i].len() > 1);
            let heaviest = splittable
                .max_by(|&i, &j| weight(&parts[i]).total_cmp(&weight(&parts[j])).then(j.cmp(&i)));
            let Some(i) = heaviest else { break };
            let part = parts[i].clone();
            let middle = self.split(part.clone(), balanced);
            parts[i] = part.start..middle;
            parts.insert(i + 1, middle..part.end);
        }
        parts
    }

    /// Reorders a range of at least two so that both sides of the returned place are not empty.
    fn split(&mut self, range: Range<usize>, balanced: bool) -> usize {
        let primitives = &mut self.primitives[range.clone()];
        let centres = Aabb::around(primitives.iter().map(|p| p.bounds.centre()));
        let cheapest = if balanced { None } else { cheapest_cut(primitives, centres) };
        if let Some((axis, first_bin_right)) = cheapest {
            let mut n_left = 0;
            for i in 0..primitives.len() {
                if bin_of(&primitives[i], centres, axis) < first_bin_right {
                    primitives.swap(i, n_left);
                    n_left += 1;
                }
            }
            return range.start + n_left;
        }
        let axis = usize::from(centres.size().y > centres.size().x);
        let middle = primitives.len() / 2;
        primitives.select_nth_unstable_by(middle, |p, q| {
            p.bounds.centre()[axis].total_cmp(&q.bounds.centre()[axis])
        });
        range.start + middle
    }
}

/// The lanes from far to near for rays into each quadrant, packed as [`Links`] says; unused ones
/// anywhere.
fn lane_orders(lane_bounds: &[Aabb]) -> [u8; 4] {
    [0, 1, 2, 3].map(|quadrant| {
        let sign = |bit: usize| if quadrant & bit == 0 { 1.0 } else { -1.0 };
        let forwards = Vec2::new(sign(1), sign(2));
        let ahead = |lane: usize| lane_bounds.get(lane).map_or(0.0, |b| b.centre().dot(&forwards));
        let mut lanes = [0, 1, 2, 3];
        lanes.sort_by(|&i, &j| ahead(j).total_cmp(&ahead(i)));
        lanes.iter().rev().fold(0, |packed, &lane| packed << 2 | lane as u8)
    })
}

/// The axis and the first bin of the right side that make the two sides cheapest; `None` when all
/// centres coincide.
fn cheapest_cut(primitives: &[Primitive], centres: Aabb) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..2 {
        if centres.size()[axis] <= 0.0 {
            continue;
        }
        let mut bins = [Bin::EMPTY; N_BINS];
        for primitive in primitives {
            let bin = &mut bins[bin_of(primitive, centres, axis)];
            *bin = bin.with(Bin { bounds: primitive.bounds, count: 1 });
        }
        let mut right_costs = [0.0; N_BINS];
        let mut right = Bin::EMPTY;
        for i in (1..N_BINS).rev() {
            right = right.with(bins[i]);
            right_costs[i] = right.cost();
        }
        let mut left = Bin::EMPTY;
        for i in 1..N_BINS {
            left = left.with(bins[i - 1]);
            let cost = left.cost() + right_costs[i];
            let both_sides = left.count > 0 && left.count < primitives.len();
            if both_sides && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

fn bin_of(primitive: &Primitive, centres: Aabb, axis: usize) -> usize {
    let part = (primitive.bounds.centre()[axis] - centres.min[axis]) / centres.size()[axis];
    ((part * N_BINS as f64) as usize).min(N_BINS - 1)
}

fn half_perimeter(bounds: Aabb) -> f64 {
    bounds.size().sum()
}

/// Levels of nodes that hold `n` primitives when every split halves them.
fn levels_to_halve(n: usize) -> usize {
    let mut levels = 0;
    let mut held = 1;
    while held < n {
        held *= WIDTH;
        levels += 1;
    }
    levels.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels of nodes from here down.
    fn depth(bvh: &Bvh, node: usize) -> usize {
        let below = bvh.links[node].children.iter().map(|child| match child.leads() {
            Leads::ToNode(below) => depth(bvh, below),
            _ => 0,
        });
        1 + below.max().unwrap_or(0)
    }

    #[test]
    fn the_tree_is_never_deeper_than_the_stack_allows() {
        // Each wall half as far as the one before: the cheapest cut peels off a few at a time.
        let shrinking = (0..900_i32).map(|i| {
            let x = 2.0_f64.powi(-i);
            (Segment { a: Vec2::new(x, -x), b: Vec2::new(x, x) }, 0)
        });
        // No cut at all tells these apart.
        let same = Segment { a: Vec2::new(1.0, -1.0), b: Vec2::new(1.0, 1.0) };
        for n_same in [0, 3, 5000] {
            let walls: Vec<_> = shrinking.clone().chain(vec![(same, 1); n_same]).collect();
            let bvh = Bvh::build(&walls, &[]);
            assert!(depth(&bvh, 0) <= LEVELS_MAX, "{} levels", depth(&bvh, 0));
            assert_eq!(bvh.parts.walls.len(), walls.len());
        }
    }

    #[test]
    fn halving_by_four_counts_levels() {
        let levels = [1, 2, 4, 5, 16, 17, 1 << 30].map(levels_to_halve);
        assert_eq!(levels, [1, 1, 1, 2, 2, 3, 15]);
    }
}
