//! Whether something can be put where it should be.

use geometry::{Se2, Vec2};

use crate::{
    collide,
    contact::Obstacle,
    place::is_place,
    spec::{ThingSpec, WorldError},
    world::World,
};

/// Walls whose bounding box is narrower than this are no room, but a strip to drive along, metres.
const STRIP_M: f64 = 3.0;
/// A robot may be put this far outside the walls' bounding box, metres: before a door, say.
const SPARE_AROUND_ROOM_M: f64 = 2.0;
/// The same around a strip.
const SPARE_AROUND_STRIP_M: f64 = 10.0;

impl World {
    pub(crate) fn check_place(&self, name: &str, pose: Se2) -> Result<(), WorldError> {
        let numbers = [("x_m", pose.x_m), ("y_m", pose.y_m), ("yaw_rad", pose.yaw_rad)];
        for (what, value) in numbers {
            if !is_place(value) {
                let requirement = "a finite number within 1000 km";
                return Err(WorldError::Range { name: name.to_owned(), what, value, requirement });
            }
        }
        let bounds = self.static_map.bounds();
        let size = bounds.size();
        let spare_m =
            if size.x.min(size.y) < STRIP_M { SPARE_AROUND_STRIP_M } else { SPARE_AROUND_ROOM_M };
        let near = bounds.grown(spare_m);
        if !self.static_map.is_empty() && !near.contains(pose.position()) {
            return Err(WorldError::SpawnOutside {
                name: name.to_owned(),
                x_m: pose.x_m,
                y_m: pose.y_m,
                min_x_m: bounds.min.x,
                min_y_m: bounds.min.y,
                max_x_m: bounds.max.x,
                max_y_m: bounds.max.y,
            });
        }
        Ok(())
    }

    pub(crate) fn check_free(
        &self,
        name: &str,
        pose: Se2,
        corners: &[Vec2],
        except: Option<usize>,
    ) -> Result<(), WorldError> {
        let obstacle = if self.static_map.touches_polygon(corners) {
            Some(Obstacle::Wall)
        } else {
            self.movable_obstacle(except, corners)
        };
        let Some(obstacle) = obstacle else { return Ok(()) };
        Err(WorldError::SpawnBlocked {
            name: name.to_owned(),
            x_m: pose.x_m,
            y_m: pose.y_m,
            yaw_deg: pose.yaw_rad.to_degrees(),
            obstacle: self.describe(obstacle),
        })
    }

    pub(crate) fn check_thing(&self, spec: &ThingSpec) -> Result<(), WorldError> {
        if spec.material as usize >= self.materials.len() {
            return Err(WorldError::Material {
                name: spec.name.clone(),
                material: spec.material,
                n_materials: self.materials.len(),
            });
        }
        let bounds = spec.polygon.bounds();
        for value in [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y] {
            if !is_place(value) {
                return Err(WorldError::Range {
                    name: spec.name.clone(),
                    what: "polygon",
                    value,
                    requirement: "a finite place within 1000 km",
                });
            }
        }
        let robot = self
            .bodies
            .iter()
            .position(|body| collide::polygon_meets_convex(&spec.polygon, &body.corners))
            .map(Obstacle::Robot);
        let person = self
            .people
            .iter()
            .position(|person| spec.polygon.distance(person.position) <= person.spec.radius_m)
            .map(Obstacle::Person);
        let Some(obstacle) = robot.or(person) else { return Ok(()) };
        let centre = spec.polygon.centroid();
        Err(WorldError::ThingBlocked {
            name: spec.name.clone(),
            x_m: centre.x,
            y_m: centre.y,
            obstacle: self.describe(obstacle),
        })
    }

    fn describe(&self, obstacle: Obstacle) -> String {
        match obstacle {
            Obstacle::Wall => "a wall".to_owned(),
            Obstacle::Thing(i) => format!("the thing `{}`", self.things[i].spec.name),
            Obstacle::Person(i) => format!("the person `{}`", self.people[i].spec.name),
            Obstacle::Robot(i) => format!("the robot `{}`", self.bodies[i].name),
        }
    }
}
