//! How much room a robot has.

use geometry::{Aabb, Vec2};

use crate::{
    body::Body,
    collide,
    spec::BodyId,
    world::{Thing, World},
};

/// [`World::clearance_m`] sees no farther, metres.
const CLEARANCE_CAP_M: f64 = 5.0;

impl World {
    /// From a robot's footprint to the nearest wall, thing, person or robot, metres, from 0 to 5.
    pub fn clearance_m(&self, id: BodyId) -> f64 {
        let body = &self.bodies[id.0];
        let to_wall_m = self.static_map.polygon_distance(&body.corners, CLEARANCE_CAP_M);
        let mut best_m = to_wall_m.unwrap_or(CLEARANCE_CAP_M);
        for thing in &self.things {
            let reach = body_box(body).grown(best_m);
            if reach.overlaps(thing.bounds) {
                best_m = best_m.min(thing_distance_m(thing, &body.corners));
            }
        }
        for person in &self.people {
            let closest = collide::closest_point(&body.corners, person.position);
            let gap_m = (closest - person.position).norm() - person.spec.radius_m;
            best_m = best_m.min(gap_m.max(0.0));
        }
        for (i, other) in self.bodies.iter().enumerate() {
            let apart_m = (other.position() - body.position()).norm();
            let gap_m = apart_m - other.bounding_radius_m - body.bounding_radius_m;
            if i != id.0 && gap_m < best_m {
                best_m = best_m.min(convex_distance_m(&body.corners, &other.corners));
            }
        }
        best_m
    }
}

fn body_box(body: &Body) -> Aabb {
    Aabb::around(body.corners.iter().copied())
}

fn thing_distance_m(thing: &Thing, corners: &[Vec2]) -> f64 {
    if collide::polygon_meets_convex(&thing.spec.polygon, corners) {
        return 0.0;
    }
    collide::borders_distance(thing.spec.polygon.corners(), corners)
}

fn convex_distance_m(first: &[Vec2], second: &[Vec2]) -> f64 {
    if collide::convex_meet(first, second) { 0.0 } else { collide::borders_distance(first, second) }
}
