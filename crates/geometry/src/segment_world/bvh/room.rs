//! How far a point or a convex polygon is from everything.

use super::{Bvh, Child, Leads, STACK_SIZE, distance_to_box};
use crate::{Aabb, Segment, Vec2, segment_world::convex};

impl Bvh {
    pub(in super::super) fn nearest_distance(&self, point: Vec2, within_m: f64) -> Option<f64> {
        let sound = point.x.is_finite() && point.y.is_finite();
        let to_box = |bounds| distance_to_box(bounds, point);
        sound.then(|| self.least(within_m, to_box, |wall| wall.distance(point), to_box))?
    }

    pub(in super::super) fn polygon_distance(
        &self,
        polygon: &[Vec2],
        within_m: f64,
    ) -> Option<f64> {
        let sound =
            polygon.len() >= 3 && polygon.iter().all(|c| c.x.is_finite() && c.y.is_finite());
        let around = Aabb::around(polygon.iter().copied());
        let to_box = |bounds| gap_m(bounds, around);
        let to_wall = |wall| wall_distance_m(polygon, wall);
        let to_block = |block| block_distance_m(polygon, block);
        sound.then(|| self.least(within_m, to_box, to_wall, to_block))?
    }

    /// The least distance to any wall or block, when it is at most `within_m`.
    ///
    /// `to_box` must not say more than the distance to anything inside the box. The nearest child is
    /// looked into first, and a child farther away than the best so far never.
    fn least(
        &self,
        within_m: f64,
        to_box: impl Fn(Aabb) -> f64,
        to_wall: impl Fn(Segment) -> f64,
        to_block: impl Fn(Aabb) -> f64,
    ) -> Option<f64> {
        // Not a number is no distance either.
        let sound = within_m >= 0.0;
        if self.boxes.is_empty() || !sound {
            return None;
        }
        let mut best_m = within_m;
        let mut found = false;
        let mut waiting = [(0.0, Child::ROOT); STACK_SIZE];
        let mut n_waiting = 1;
        while n_waiting > 0 {
            n_waiting -= 1;
            let (bound_m, child) = waiting[n_waiting];
            if bound_m > best_m {
                continue;
            }
            let distance_m = match child.leads() {
                Leads::ToNode(node) => {
                    let floor = n_waiting;
                    for (lane, &child) in self.links[node].children.iter().enumerate() {
                        let box_m = to_box(self.lane_bounds(node, lane));
                        if box_m > best_m {
                            continue;
                        }
                        // Sorted in, so that the nearest of the four is on top.
                        let mut place = n_waiting;
                        while place > floor && waiting[place - 1].0 < box_m {
                            waiting[place] = waiting[place - 1];
                            place -= 1;
                        }
                        waiting[place] = (box_m, child);
                        n_waiting += 1;
                    }
                    continue;
                }
                Leads::ToWall(index) => to_wall(self.parts.walls[index].segment),
                Leads::ToBlock(index) => to_block(self.parts.blocks[index].bounds),
                Leads::Nowhere => continue,
            };
            if distance_m <= best_m {
                (best_m, found) = (distance_m, true);
            }
        }
        found.then_some(best_m)
    }
}

/// Distance between two boxes; 0 when they overlap.
fn gap_m(a: Aabb, b: Aabb) -> f64 {
    let x_m = (b.min.x - a.max.x).max(a.min.x - b.max.x).max(0.0);
    let y_m = (b.min.y - a.max.y).max(a.min.y - b.max.y).max(0.0);
    x_m.hypot(y_m)
}

fn wall_distance_m(polygon: &[Vec2], wall: Segment) -> f64 {
    if convex::meets_wall(polygon, wall) {
        return 0.0;
    }
    edges(polygon).map(|edge| edge.distance_to_segment(wall)).fold(f64::INFINITY, f64::min)
}

fn block_distance_m(polygon: &[Vec2], block: Aabb) -> f64 {
    let overlap = block.overlaps(Aabb::around(polygon.iter().copied()));
    if overlap && convex::meets_block(polygon, block) {
        return 0.0;
    }
    let Aabb { min, max } = block;
    let corners = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
    edges(&corners).map(|side| wall_distance_m(polygon, side)).fold(f64::INFINITY, f64::min)
}

fn edges(corners: &[Vec2]) -> impl Iterator<Item = Segment> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| Segment { a, b })
}
