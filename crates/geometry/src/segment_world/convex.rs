//! Does a wall or block meet a convex polygon? By separating lines.
//!
//! Two convex figures of which one has an inside are apart exactly when a line along an edge of
//! one of them has them on different sides. Source: Ericson (2005), "Real-Time Collision
//! Detection", section 5.2.1.

use crate::{Aabb, Segment, Vec2};

/// Whether `wall` meets the polygon (m, counter-clockwise, at least three corners); touching counts.
pub(super) fn meets_wall(convex: &[Vec2], wall: Segment) -> bool {
    let along = wall.b - wall.a;
    let side = |p: &Vec2| along.perp(&(p - wall.a));
    let split_by_wall =
        !(convex.iter().all(|p| side(p) > 0.0) || convex.iter().all(|p| side(p) < 0.0));
    split_by_wall && !outside_an_edge(convex, &[wall.a, wall.b])
}

/// Whether the block meets the polygon; touching counts. The caller has compared the boxes around
/// the two, which are the separating lines that the block brings.
pub(super) fn meets_block(convex: &[Vec2], block: Aabb) -> bool {
    let (low, high) = (block.min, block.max);
    !outside_an_edge(convex, &[low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)])
}

/// Whether all `points` lie to the right of one edge.
fn outside_an_edge(convex: &[Vec2], points: &[Vec2]) -> bool {
    let last = convex.len() - 1;
    (0..=last).any(|i| {
        let (a, b) = (convex[if i == 0 { last } else { i - 1 }], convex[i]);
        points.iter().all(|p| (b - a).perp(&(p - a)) < 0.0)
    })
}
