//! The world: one fixed step after another.

use std::{fmt, time::Duration};

use geometry::{Aabb, Polygon, Se2, SegmentWorld, Vec2};
use robot_models::WheelSpeeds;
use run_context::{RunSeed, Stamp, StateHash};
use sensor_models::{Material, materials};

use crate::{
    body::{Body, transform_into},
    fixtures::Fixtures,
    floor_tags::FloorTags,
    neighbours::Neighbours,
    people::Person,
    spec::{BodyId, RobotPlacement, ThingId, ThingSpec, WorldError, WorldSpec},
};

/// Faster than any wheel accelerates, metres per second squared; keeps the state finite.
const ACCELERATION_MAX_MPS2: f64 = 1e3;

/// The true world of one run.
pub struct World {
    pub(crate) static_map: SegmentWorld,
    pub(crate) materials: Vec<Material>,
    pub(crate) things: Vec<Thing>,
    pub(crate) fixtures: Fixtures,
    pub(crate) next_thing: u64,
    pub(crate) people: Vec<Person>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) floor_tags: Option<FloorTags>,
    pub(crate) neighbours: Neighbours,
    pub(crate) seed: RunSeed,
    pub(crate) now: Stamp,
    pub(crate) step: Duration,
    pub(crate) scratch: Vec<Vec2>,
}

/// A thing in the world.
#[derive(Clone, Debug)]
pub struct Thing {
    /// Its identity.
    pub id: ThingId,
    /// What it is and where.
    pub spec: ThingSpec,
    pub(crate) bounds: Aabb,
}

impl World {
    /// A world without robots at time zero; `step` (1 to 100 ms) is the time that
    /// [`step`](Self::step) takes.
    ///
    /// # Errors
    ///
    /// [`WorldError`] naming what is wrong with the step, a thing or a person.
    pub fn new(spec: WorldSpec, seed: RunSeed, step: Duration) -> Result<Self, WorldError> {
        if !(Duration::from_millis(1)..=Duration::from_millis(100)).contains(&step) {
            return Err(WorldError::Step { step_ms: step.as_secs_f64() * 1e3 });
        }
        let people = spec.people.into_iter().map(Person::new).collect::<Result<_, _>>()?;
        let mut world = Self {
            static_map: spec.static_map,
            materials: materials().to_vec(),
            things: Vec::with_capacity(spec.things.len()),
            fixtures: Fixtures::default(),
            next_thing: 0,
            people,
            bodies: Vec::new(),
            floor_tags: None,
            neighbours: Neighbours::new(),
            seed,
            now: Stamp::ZERO,
            step,
            scratch: Vec::new(),
        };
        for thing in spec.things {
            world.check_thing(&thing)?;
            world.insert_thing(thing);
        }
        Ok(world)
    }

    /// Replaces what surfaces do to sound. Indices keep their meaning: `materials[0]` is what walls
    /// of tag 0 are made of. An empty list changes nothing.
    pub fn set_materials(&mut self, materials: Vec<Material>) {
        if !materials.is_empty() {
            self.materials = materials;
        }
    }

    /// Replaces what is in the world beside solid things.
    pub fn set_fixtures(&mut self, fixtures: Fixtures) {
        self.fixtures = fixtures;
    }

    /// What is in the world beside solid things.
    pub fn fixtures(&self) -> &Fixtures {
        &self.fixtures
    }

    /// The surfaces' materials; tags are indices into them.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Lays tags into the floor, in place of those that are there.
    pub fn set_floor_tags(&mut self, tags: FloorTags) {
        self.floor_tags = Some(tags);
    }

    /// The tags in the floor, if there are any.
    pub fn floor_tags(&self) -> Option<&FloorTags> {
        self.floor_tags.as_ref()
    }

    /// A robot over a tag writes the tag's intensity.
    pub fn write_tag_strength(&mut self, place: u32, strength: u8) {
        if let Some(tags) = &mut self.floor_tags {
            tags.write_strength(place, strength);
        }
    }

    /// Time of the state: the number of steps times their length.
    pub fn now(&self) -> Stamp {
        self.now
    }

    /// The length of a step.
    pub fn step_duration(&self) -> Duration {
        self.step
    }

    /// The walls, world frame.
    pub fn static_map(&self) -> &SegmentWorld {
        &self.static_map
    }

    /// The robots, in the order in which they came.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// One robot.
    ///
    /// # Panics
    ///
    /// When `id` is of another world.
    pub fn body(&self, id: BodyId) -> &Body {
        &self.bodies[id.0]
    }

    /// The robot of that name.
    pub fn body_by_name(&self, name: &str) -> Option<BodyId> {
        self.bodies.iter().position(|body| body.name == name).map(BodyId)
    }

    /// The things there are now, in the order in which they came.
    pub fn things(&self) -> &[Thing] {
        &self.things
    }

    /// The people, in the order of the specification.
    pub fn people(&self) -> &[Person] {
        &self.people
    }

    pub(crate) fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    /// Puts a robot into the world.
    ///
    /// # Errors
    ///
    /// [`WorldError`] when its numbers make no sense, its name is taken, it stands more than 2 m
    /// outside the walls' bounding box (10 m where that is narrower than 3 m), or its footprint meets something; the world is unchanged.
    pub fn add_robot(&mut self, placement: RobotPlacement) -> Result<BodyId, WorldError> {
        if self.body_by_name(&placement.name).is_some() {
            return Err(WorldError::DuplicateName { name: placement.name });
        }
        self.check_place(&placement.name, placement.world_from_base)?;
        let body = Body::new(placement, self.seed)?;
        self.check_free(&body.name, body.world_from_base.se2(), &body.corners, None)?;
        let move_max_m = body.model.limits.speed_max_mps * self.step.as_secs_f64();
        self.neighbours.admit(body.bounding_radius_m, move_max_m);
        self.bodies.push(body);
        self.rebuild_neighbours();
        Ok(BodyId(self.bodies.len() - 1))
    }

    /// Lifts a robot to another place; its wheels and counters do not notice.
    ///
    /// # Errors
    ///
    /// [`WorldError`] when it cannot stand there; it then stays where it is.
    pub fn relocate_robot(&mut self, id: BodyId, world_from_base: Se2) -> Result<(), WorldError> {
        let body = &self.bodies[id.0];
        self.check_place(&body.name, world_from_base)?;
        let mut corners = Vec::new();
        transform_into(world_from_base, body.model.footprint.corners(), &mut corners);
        self.check_free(&body.name, world_from_base, &corners, Some(id.0))?;
        let body = &mut self.bodies[id.0];
        body.place(world_from_base);
        body.wall_slack_m = -1.0;
        self.rebuild_neighbours();
        Ok(())
    }

    /// Sets what a robot's wheels should reach; scaled down together to the model's limits.
    pub fn set_wheel_reference(&mut self, id: BodyId, reference: WheelSpeeds) {
        let body = &mut self.bodies[id.0];
        body.wheel_reference = body.model.drive.limited(reference, &body.model.limits);
    }

    /// Sets how fast a robot's wheels may change, metres per second squared; at least 0, and
    /// nonsense is 0: the wheels then keep their speeds.
    pub fn set_acceleration(&mut self, id: BodyId, acceleration_mps2: f64) {
        let is_number = !acceleration_mps2.is_nan();
        self.bodies[id.0].acceleration_mps2 =
            if is_number { acceleration_mps2.clamp(0.0, ACCELERATION_MAX_MPS2) } else { 0.0 };
    }

    /// Moves everything on by one step: people first, then the robots in order.
    ///
    /// Does not allocate once every robot is in. With few things and people, the cost per robot
    /// does not depend on how many there are.
    pub fn step(&mut self) {
        self.now += self.step;
        self.rebuild_neighbours();
        for i in 0..self.people.len() {
            self.step_person(i);
        }
        let mut corners = std::mem::take(&mut self.scratch);
        for i in 0..self.bodies.len() {
            self.step_body(i, &mut corners);
        }
        self.scratch = corners;
    }

    /// Adds a thing during the run.
    ///
    /// # Errors
    ///
    /// [`WorldError`] when a robot or person stands there, or the material is unknown.
    pub fn place_thing(&mut self, spec: ThingSpec) -> Result<ThingId, WorldError> {
        self.check_thing(&spec)?;
        Ok(self.insert_thing(spec))
    }

    /// Takes a thing away; says whether it was there.
    pub fn remove_thing(&mut self, id: ThingId) -> bool {
        let before = self.things.len();
        self.things.retain(|thing| thing.id != id);
        self.things.len() < before
    }

    /// The thing of that name, the first if there are several.
    pub fn thing_by_name(&self, name: &str) -> Option<ThingId> {
        self.things.iter().find(|thing| thing.spec.name == name).map(|thing| thing.id)
    }

    /// Whether a person moves (faster than 0.1 m/s) inside `zone`: what a passive infrared
    /// detector sees. Any part of the person's circle counts.
    pub fn motion_in(&self, zone: &Polygon) -> bool {
        self.people.iter().any(|person| {
            person.is_moving() && zone.distance(person.position) <= person.spec.radius_m
        })
    }

    /// Whether a robot moves (a wheel faster than 0.1 m/s) with its centre inside `zone`.
    pub fn robot_motion_in(&self, zone: &Polygon) -> bool {
        self.bodies.iter().any(|body| {
            let WheelSpeeds { left_mps, right_mps } = body.wheel_speeds;
            left_mps.abs().max(right_mps.abs()) > crate::people::MOVING_FROM_MPS
                && zone.contains(body.position())
        })
    }

    /// Absorbs everything that changes.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.now.as_nanos());
        self.bodies.iter().for_each(|body| body.absorb(hash));
        for person in &self.people {
            hash.absorb(person.position.x);
            hash.absorb(person.position.y);
            hash.absorb(person.speed_mps);
        }
        self.floor_tags.iter().for_each(|tags| tags.absorb(hash));
        for thing in &self.things {
            hash.absorb_u64(thing.id.0);
            for corner in thing.spec.polygon.corners() {
                hash.absorb(corner.x);
                hash.absorb(corner.y);
            }
        }
    }

    fn rebuild_neighbours(&mut self) {
        self.neighbours.rebuild(self.bodies.iter().map(Body::position));
    }

    fn insert_thing(&mut self, spec: ThingSpec) -> ThingId {
        let id = ThingId(self.next_thing);
        self.next_thing += 1;
        let bounds = spec.polygon.bounds();
        self.things.push(Thing { id, spec, bounds });
        id
    }
}

impl fmt::Debug for World {
    /// Counts, not contents: a world may hold tens of thousands of walls.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("now", &self.now)
            .field("n_walls", &self.static_map.len())
            .field("n_things", &self.things.len())
            .field("n_people", &self.people.len())
            .field("n_robots", &self.bodies.len())
            .finish_non_exhaustive()
    }
}
