//! What a sensor can see: walls, things, people and the other robots.

use geometry::{ConeScene, ConeView, Ray, RayCaster, RayHit};
use run_context::RandomStream;
use sensor_models::{Echo, EchoCause, PERSON_TAG, ROBOT_TAG};

use crate::{collide, spec::BodyId, world::World};

/// The world as rays meet it; see [`World::scene`].
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub(crate) world: &'a World,
    pub(crate) seen_by: Option<BodyId>,
}

impl World {
    /// Fires one sonar of a robot: it meets walls, things, people and other robots.
    ///
    /// Draws from the caller's `rng`, so robots may be asked in parallel. A sensor that the robot
    /// does not have hears nothing.
    pub fn ping(&self, id: BodyId, sensor_index: usize, rng: &mut RandomStream) -> Echo {
        let body = &self.bodies[id.0];
        let Some(mount) = body.model.sonars.get(sensor_index) else {
            let range_m = body.sonar.range_max_m;
            return Echo { range_m, cause: EchoCause::Nothing, nearest_in_cone_m: range_m };
        };
        let world_from_sensor = body.world_from_base * mount.base_from_sensor;
        body.sonar.ping(world_from_sensor.se2(), &self.scene(Some(id)), &self.materials, rng)
    }

    /// The world as a sensor meets it; of the robot `seen_by`, which does not see itself.
    pub fn scene(&self, seen_by: Option<BodyId>) -> Scene<'_> {
        Scene { world: self, seen_by }
    }
}

impl RayCaster for Scene<'_> {
    /// The nearest wall, thing, person or other robot. Does not allocate; the cost grows with the
    /// things and people of the world, and with the robots along the ray only.
    fn cast(&self, ray: &Ray, range_max_m: f64) -> Option<RayHit> {
        let mut nearest = self.world.static_map().cast(ray, range_max_m);
        let mut offer = |hit: Option<(f64, geometry::Vec2)>, tag: u32| {
            if let Some((distance_m, normal)) = hit
                && nearest.is_none_or(|n| distance_m < n.distance_m)
            {
                nearest = Some(RayHit { distance_m, normal, tag });
            }
        };
        for thing in self.world.things() {
            if ray_meets_box(ray, range_max_m, thing.bounds) {
                let corners = thing.spec.polygon.corners();
                offer(collide::ray_meets_outline(ray, corners, range_max_m), thing.spec.material);
            }
        }
        for person in self.world.people() {
            let radius_m = person.spec.radius_m;
            let hit = collide::ray_meets_circle(ray, person.position, radius_m, range_max_m);
            offer(hit, PERSON_TAG);
        }
        for body_index in self.world.neighbours().along(ray, range_max_m) {
            let body = &self.world.bodies()[body_index];
            let is_self = self.seen_by == Some(BodyId(body_index));
            let to_body = body.position() - ray.origin;
            let beside_m = to_body.perp(&ray.direction).abs();
            if !is_self && beside_m <= body.bounding_radius_m {
                let hit = collide::ray_meets_outline(ray, &body.corners, range_max_m);
                offer(hit, ROBOT_TAG);
            }
        }
        nearest
    }
}

impl ConeScene for Scene<'_> {
    fn is_crowded(&self) -> bool {
        self.world.static_map().is_crowded()
    }

    /// Walls, things, people and the other robots near the cone. Does not allocate.
    fn show(&self, view: &mut ConeView) {
        self.world.static_map().show(view);
        for thing in self.world.things() {
            if view.depth_of_box(thing.bounds).is_some() {
                for edge in thing.spec.polygon.edges() {
                    view.offer_segment(edge, thing.spec.material);
                }
            }
        }
        for person in self.world.people() {
            view.offer_disc(person.position, person.spec.radius_m, PERSON_TAG);
        }
        for body_index in self.world.neighbours().in_box(view.bounds()) {
            let body = &self.world.bodies()[body_index];
            let is_self = self.seen_by == Some(BodyId(body_index));
            if !is_self && view.may_see_disc(body.position(), body.bounding_radius_m) {
                for edge in collide::edges(&body.corners) {
                    view.offer_segment(edge, ROBOT_TAG);
                }
            }
        }
    }
}

/// Whether the box around a ray of that length overlaps `bounds`: a quick refusal, no more.
fn ray_meets_box(ray: &Ray, range_m: f64, bounds: geometry::Aabb) -> bool {
    let end = ray.origin + range_m * ray.direction;
    geometry::Aabb { min: ray.origin.inf(&end), max: ray.origin.sup(&end) }.overlaps(bounds)
}
