//! What a world is made of, and what can be wrong with that.

use std::sync::Arc;

use geometry::{Polygon, Se2, SegmentWorld, Vec2};
use robot_models::{ErrorRange, OdometryErrors, RobotModel};
use run_context::Stamp;
use sensor_models::{ModelRange, SonarModel};

/// Everything in a world except its robots.
#[derive(Clone, Debug)]
pub struct WorldSpec {
    /// Walls and all else that never changes; tags are material indices. World frame.
    pub static_map: SegmentWorld,
    /// Things that may come, go or move.
    pub things: Vec<ThingSpec>,
    /// People and their ways.
    pub people: Vec<PersonSpec>,
}

/// A solid thing with an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct ThingSpec {
    /// The name in missions and on screens.
    pub name: String,
    /// What it is, for screens.
    pub kind: ThingKind,
    /// Its outline, world frame, metres.
    pub polygon: Polygon,
    /// Index into the world's materials.
    pub material: u32,
    /// Whether a mission or a user may move it.
    pub movable: bool,
}

/// What a thing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThingKind {
    /// A cupboard, table, chair or the like.
    Furniture,
    /// A box that somebody put there.
    Box,
    /// A closed door; remove it to open.
    Door,
    /// Anything else.
    Other,
}

/// A person who walks along a polyline.
#[derive(Clone, Debug, PartialEq)]
pub struct PersonSpec {
    /// The name in missions and on screens.
    pub name: String,
    /// Corners of the way, world frame, metres; a single one for somebody who stands.
    pub route: Vec<Vec2>,
    /// Walking speed, metres per second, from 0 to 10.
    pub speed_mps: f64,
    /// When the walk begins; until then the person stands at the first corner.
    pub starts_at: Stamp,
    /// Whether the walk goes on for ever: round and round when the last corner is the first, to
    /// and fro otherwise.
    pub repeats: bool,
    /// Whether the person waits while a robot is close ahead.
    pub yields: bool,
    /// Radius of the circle that stands for the person, metres, from 0.05 to 1.
    pub radius_m: f64,
}

/// A robot to be put into the world.
#[derive(Clone, Debug)]
pub struct RobotPlacement {
    /// The name; its random stream follows from it, so it must be unique.
    pub name: String,
    /// What kind of robot.
    pub model: Arc<RobotModel>,
    /// Where it stands in the world frame.
    pub world_from_base: Se2,
    /// How its drive differs from the model.
    pub errors: OdometryErrors,
    /// Its sonars, all alike.
    pub sonar: SonarModel,
}

/// Which robot of a world; its position in [`World::bodies`](crate::World::bodies).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub usize);

/// Which thing of a world; never used twice in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ThingId(pub u64);

/// What a world refuses.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A step that is zero or too long to catch a robot before a wall.
    #[error("time step of {step_ms} ms: must be from 1 to 100 ms")]
    Step {
        /// What was asked for, milliseconds.
        step_ms: f64,
    },
    /// A number about a robot, person or thing that is no place or size.
    #[error("`{name}`: {what} = {value}: must be {requirement}")]
    Range {
        /// Whose.
        name: String,
        /// Which number.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it must be, as prose.
        requirement: &'static str,
    },
    /// Two robots of one name.
    #[error("there is already a robot named `{name}`: give this one another name")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// Something stands where a robot should.
    #[error(
        "robot `{name}` cannot stand at ({x_m:.3}, {y_m:.3}) m, {yaw_deg:.1} deg: its footprint \
         meets {obstacle}: choose a free place"
    )]
    SpawnBlocked {
        /// The robot's name.
        name: String,
        /// Where, metres, world frame.
        x_m: f64,
        /// Where, metres, world frame.
        y_m: f64,
        /// Its heading, degrees.
        yaw_deg: f64,
        /// What it meets, as prose.
        obstacle: String,
    },
    /// A robot far outside the walls' bounding box.
    #[error(
        "robot `{name}` cannot stand at ({x_m:.3}, {y_m:.3}) m: the walls reach from \
         ({min_x_m:.3}, {min_y_m:.3}) to ({max_x_m:.3}, {max_y_m:.3}) m"
    )]
    SpawnOutside {
        /// The robot's name.
        name: String,
        /// Where, metres, world frame.
        x_m: f64,
        /// Where, metres, world frame.
        y_m: f64,
        /// Least x of the walls, metres.
        min_x_m: f64,
        /// Least y of the walls, metres.
        min_y_m: f64,
        /// Greatest x of the walls, metres.
        max_x_m: f64,
        /// Greatest y of the walls, metres.
        max_y_m: f64,
    },
    /// Somebody stands where a thing should.
    #[error("`{name}` cannot be put at ({x_m:.3}, {y_m:.3}) m: {obstacle} is there")]
    ThingBlocked {
        /// The thing's name.
        name: String,
        /// Its centre, metres, world frame.
        x_m: f64,
        /// Its centre, metres, world frame.
        y_m: f64,
        /// Who is there, as prose.
        obstacle: String,
    },
    /// A material index beyond the world's list.
    #[error("`{name}`: material {material} is unknown: there are {n_materials}, counted from 0")]
    Material {
        /// The thing's name.
        name: String,
        /// Its material.
        material: u32,
        /// How many there are.
        n_materials: usize,
    },
    /// A person without a way.
    #[error("person `{name}` has an empty route: give at least the place where they stand")]
    EmptyRoute {
        /// The person's name.
        name: String,
    },
    /// An error parameter of a robot's drive outside its range.
    #[error("robot `{name}`: errors.{source}")]
    Errors {
        /// The robot's name.
        name: String,
        /// Which parameter.
        source: ErrorRange,
    },
    /// A parameter of a robot's sonar outside its range.
    #[error("robot `{name}`: sonar.{source}")]
    Sonar {
        /// The robot's name.
        name: String,
        /// Which parameter.
        source: ModelRange,
    },
}

impl WorldSpec {
    /// A world of walls only.
    pub fn of_walls(static_map: SegmentWorld) -> Self {
        Self { static_map, things: Vec::new(), people: Vec::new() }
    }

    /// An endless empty floor.
    pub fn empty() -> Self {
        Self::of_walls(SegmentWorld::new([]))
    }
}
