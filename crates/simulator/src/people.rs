//! People: circles that walk along polylines and do not walk into robots.

use std::time::Duration;

use geometry::Vec2;
use run_context::Stamp;

use crate::{
    place::is_place,
    spec::{PersonSpec, WorldError},
};

/// A yielding person waits while a robot's footprint is this close to their circle ahead, metres.
pub(crate) const YIELD_DISTANCE_M: f64 = 0.45;
/// Slower than this is standing, for whatever detects motion, metres per second.
pub(crate) const MOVING_FROM_MPS: f64 = 0.1;

/// A person in the world.
#[derive(Clone, Debug)]
pub struct Person {
    /// Who they are and where they want to walk.
    pub spec: PersonSpec,
    /// Where they are, world frame, metres.
    pub position: Vec2,
    /// Where they look: unit vector, world frame.
    pub heading: Vec2,
    /// How fast they walked in the last step, metres per second.
    pub speed_mps: f64,
    /// Whether a robot that they touch stopped them in the last step.
    pub(crate) is_pressing: bool,
    walk: Walk,
}

/// Progress along a route.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Walk {
    /// Index of the corner behind.
    leg: usize,
    /// Way from that corner, metres.
    along_m: f64,
    /// Whether the route is walked from its end to its beginning.
    backwards: bool,
    arrived: bool,
}

/// Where a person would be after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stride {
    walk: Walk,
    pub(crate) position: Vec2,
    pub(crate) heading: Vec2,
}

impl Person {
    pub(crate) fn new(spec: PersonSpec) -> Result<Self, WorldError> {
        let range = |what, value, requirement| {
            Err(WorldError::Range { name: spec.name.clone(), what, value, requirement })
        };
        if !(0.0..=10.0).contains(&spec.speed_mps) {
            return range("speed_mps", spec.speed_mps, "from 0 to 10 m/s");
        }
        if !(0.05..=1.0).contains(&spec.radius_m) {
            return range("radius_m", spec.radius_m, "from 0.05 to 1 m");
        }
        for value in spec.route.iter().flat_map(|corner| [corner.x, corner.y]) {
            if !is_place(value) {
                return range("route", value, "a finite place within 1000 km");
            }
        }
        let Some(&position) = spec.route.first() else {
            return Err(WorldError::EmptyRoute { name: spec.name });
        };
        let ahead = spec.route.iter().map(|corner| corner - position).find(|d| d.norm() > 0.0);
        let heading = ahead.map_or(Vec2::x(), |d| d.normalize());
        let walk = Walk { leg: 0, along_m: 0.0, backwards: false, arrived: false };
        Ok(Self { spec, position, heading, speed_mps: 0.0, is_pressing: false, walk })
    }

    /// Where a step that ends at `now` would lead; `None` for who stands, waits or has arrived.
    pub(crate) fn stride(&self, now: Stamp, dt: Duration) -> Option<Stride> {
        let walks = now > self.spec.starts_at && self.spec.speed_mps > 0.0 && !self.walk.arrived;
        if !walks || self.spec.route.len() < 2 {
            return None;
        }
        let (walk, position, heading) =
            self.walk.advanced(&self.spec, self.spec.speed_mps * dt.as_secs_f64());
        Some(Stride { walk, position, heading: heading.unwrap_or(self.heading) })
    }

    pub(crate) fn take(&mut self, stride: Stride, dt: Duration) {
        self.speed_mps = (stride.position - self.position).norm() / dt.as_secs_f64();
        self.position = stride.position;
        self.heading = stride.heading;
        self.walk = stride.walk;
    }

    /// Whether they moved in the last step as far as a motion detector is concerned.
    pub fn is_moving(&self) -> bool {
        self.speed_mps > MOVING_FROM_MPS
    }
}

impl Walk {
    /// The walk, place and heading (none if no leg had a length) after `way_m` more.
    fn advanced(mut self, spec: &PersonSpec, way_m: f64) -> (Self, Vec2, Option<Vec2>) {
        let n_legs = spec.route.len() - 1;
        let is_ring = spec.route[0] == spec.route[n_legs];
        self.along_m += way_m;
        let mut heading = None;
        // A step passes each leg at most once: twice round is a route shorter than a step.
        for _ in 0..=2 * n_legs {
            let (from, to) = self.ends(&spec.route);
            let length_m = (to - from).norm();
            if length_m > 0.0 {
                let along = (to - from) / length_m;
                heading = Some(along);
                if self.along_m <= length_m {
                    return (self, from + self.along_m * along, heading);
                }
            }
            self.along_m -= length_m;
            self.leg += 1;
            if self.leg == n_legs {
                if !spec.repeats {
                    self.arrived = true;
                    return (self, to, heading);
                }
                self.leg = 0;
                self.backwards ^= !is_ring;
            }
        }
        self.along_m = 0.0;
        let place = self.ends(&spec.route).0;
        (self, place, heading)
    }

    fn ends(self, route: &[Vec2]) -> (Vec2, Vec2) {
        let last = route.len() - 1;
        if self.backwards {
            (route[last - self.leg], route[last - self.leg - 1])
        } else {
            (route[self.leg], route[self.leg + 1])
        }
    }
}
