//! One robot's or person's step: motion up to whatever is in the way.

use geometry::{Aabb, Se2, SegmentWorld, Twist, Vec2};
use robot_models::WheelSpeeds;

use crate::{
    body::{Body, transform_into},
    collide,
    people::YIELD_DISTANCE_M,
    spec::BodyId,
    world::World,
};

/// A contact ends when this much lies between, metres.
const CONTACT_SKIN_M: f64 = 1e-3;
/// Halvings of a refused step: a step of 22 mm ends within 0.2 mm of the contact.
const CONTACT_HALVINGS: u32 = 7;
/// How far the distance to walls is looked up ahead of need, metres.
const WALL_LOOKAHEAD_M: f64 = 2.0;

/// What keeps a robot from a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Obstacle {
    Wall,
    Thing(usize),
    Person(usize),
    Robot(usize),
}

impl World {
    pub(crate) fn step_person(&mut self, i: usize) {
        let person = &self.people[i];
        let Some(stride) = person.stride(self.now, self.step) else {
            self.people[i].speed_mps = 0.0;
            return;
        };
        let radius_m = person.spec.radius_m;
        let (mut waits, mut presses) = (false, false);
        for body_index in self.neighbours.near_within(stride.position, radius_m + YIELD_DISTANCE_M)
        {
            let body = &mut self.bodies[body_index];
            let closest = collide::closest_point(&body.corners, stride.position);
            let gap_m = (closest - stride.position).norm() - radius_m;
            if gap_m <= 0.0 {
                // Walking away from a robot that touches is always allowed.
                let before_m = (closest - person.position).norm() - radius_m;
                if gap_m < before_m {
                    if !person.is_pressing {
                        body.touch();
                    }
                    presses = true;
                }
            } else if person.spec.yields && gap_m <= YIELD_DISTANCE_M {
                waits |= (closest - stride.position).dot(&stride.heading) > 0.0;
            }
        }
        let person = &mut self.people[i];
        person.is_pressing = presses;
        if waits || presses {
            person.speed_mps = 0.0;
        } else {
            person.take(stride, self.step);
        }
    }

    pub(crate) fn step_body(&mut self, i: usize, corners: &mut Vec<Vec2>) {
        if self.bodies[i].touching {
            self.end_contact(i, corners);
        }
        let dt = self.step;
        let body = &mut self.bodies[i];
        let (mean, end) = body.next_speeds(dt);
        if mean.is_zero() {
            body.wheel_speeds = end;
            body.drivetrain.commit(mean, dt, 0.0);
            body.encoder_ticks = body.drivetrain.ticks();
            return;
        }
        let twist = body.drivetrain.propose(mean, dt, &mut body.rng);
        let way_m = twist.dx_m.hypot(twist.dy_m);
        let target = body.ahead(twist, 1.0);
        transform_into(target, body.model.footprint.corners(), corners);
        let far_from_walls = body.wall_slack_m > way_m;
        body.wall_slack_m -= way_m;

        let mut granted_ratio = 1.0;
        let mut speeds = end;
        if self.obstacle(i, corners, far_from_walls).is_some() {
            self.bodies[i].stalled = self.blocked_sides(i, target, corners);
            granted_ratio = self.bisect(i, twist, corners);
            speeds = WheelSpeeds::ZERO;
            self.bodies[i].touch();
        }
        let body = &mut self.bodies[i];
        let pose = if granted_ratio < 1.0 { body.ahead(twist, granted_ratio) } else { target };
        body.place(pose);
        body.travelled_m += granted_ratio * way_m;
        body.wheel_speeds = speeds;
        body.drivetrain.commit(mean, dt, granted_ratio);
        body.encoder_ticks = body.drivetrain.ticks();
        if !far_from_walls {
            body.wall_slack_m = wall_slack_m(&self.static_map, body);
        }
    }

    /// Ends a robot's contact when nothing is within the skin of its footprint, and its stall when
    /// nobody asks its wheels to turn.
    fn end_contact(&mut self, i: usize, corners: &mut Vec<Vec2>) {
        let body = &mut self.bodies[i];
        if body.wheel_reference.is_zero() {
            body.stalled = [false; 2];
        }
        let centre = body.position();
        corners.clear();
        corners.extend(body.corners.iter().map(|c| c + CONTACT_SKIN_M * (c - centre).normalize()));
        if self.obstacle(i, corners, false).is_none() {
            let body = &mut self.bodies[i];
            body.touching = false;
            body.stalled = [false; 2];
        }
    }

    /// The first thing that a footprint of robot `i` at `corners` would meet.
    fn obstacle(&self, i: usize, corners: &[Vec2], far_from_walls: bool) -> Option<Obstacle> {
        if !far_from_walls && self.static_map.touches_polygon(corners) {
            return Some(Obstacle::Wall);
        }
        self.movable_obstacle(Some(i), corners)
    }

    /// Whether a convex outline that is fixed to a robot (base frame, metres, counter-clockwise)
    /// meets anything but the robot itself; touching counts. Uses `scratch` instead of allocating.
    ///
    /// # Panics
    ///
    /// When `id` is of another world.
    pub fn meets(&self, id: BodyId, outline_in_base: &[Vec2], scratch: &mut Vec<Vec2>) -> bool {
        let world_from_base = self.body(id).world_from_base.se2();
        transform_into(world_from_base, outline_in_base, scratch);
        scratch.len() > 2 && self.obstacle(id.0, scratch, false).is_some()
    }

    pub(crate) fn movable_obstacle(
        &self,
        except: Option<usize>,
        corners: &[Vec2],
    ) -> Option<Obstacle> {
        let around = Aabb::around(corners.iter().copied());
        let thing = self.things.iter().position(|thing| {
            around.overlaps(thing.bounds)
                && collide::polygon_meets_convex(&thing.spec.polygon, corners)
        });
        if let Some(thing) = thing {
            return Some(Obstacle::Thing(thing));
        }
        let person = self.people.iter().position(|person| {
            around.grown(person.spec.radius_m).contains(person.position)
                && collide::circle_meets_convex(person.position, person.spec.radius_m, corners)
        });
        if let Some(person) = person {
            return Some(Obstacle::Person(person));
        }
        let centre = around.centre();
        let robot = self.neighbours.near(centre).find(|&other| {
            let body = &self.bodies[other];
            Some(other) != except
                && around.grown(body.bounding_radius_m).contains(body.position())
                && collide::convex_meet(corners, &body.corners)
        });
        robot.map(Obstacle::Robot)
    }

    /// Which sides of robot `i` would meet something at `target`; both if neither half alone does.
    fn blocked_sides(&self, i: usize, target: Se2, corners: &mut Vec<Vec2>) -> [bool; 2] {
        let sides = [0, 1].map(|side| {
            let half = &self.bodies[i].halves[side];
            transform_into(target, half, corners);
            half.len() > 2 && self.obstacle(i, corners, false).is_some()
        });
        if sides == [false, false] { [true, true] } else { sides }
    }

    /// The part of a refused motion that is free, to within a halving.
    fn bisect(&self, i: usize, twist: Twist, corners: &mut Vec<Vec2>) -> f64 {
        let body = &self.bodies[i];
        let (mut free, mut blocked) = (0.0, 1.0);
        for _ in 0..CONTACT_HALVINGS {
            let middle = 0.5 * (free + blocked);
            let pose = body.ahead(twist, middle);
            transform_into(pose, body.model.footprint.corners(), corners);
            if self.obstacle(i, corners, false).is_some() {
                blocked = middle;
            } else {
                free = middle;
            }
        }
        free
    }
}

/// How far the centre of a robot may move before its footprint can reach a wall, metres.
fn wall_slack_m(walls: &SegmentWorld, body: &Body) -> f64 {
    let within_m = body.bounding_radius_m + WALL_LOOKAHEAD_M;
    let nearest_m = walls.nearest_distance(body.position(), within_m);
    nearest_m.unwrap_or(within_m) - body.bounding_radius_m
}
