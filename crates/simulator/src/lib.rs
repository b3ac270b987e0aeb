//! The true world: walls, things, people, robots, and what the robots' sensors return.
//!
//! [`World`] moves everything by a fixed step, deterministically: the same specification, seed and
//! commands give the same bits. It is kinematic: bodies roll without inertia beyond the
//! acceleration limit of their wheels, stop where they touch something, and push nothing. A
//! navigator never sees a [`World`]; it talks to a robot's firmware, which does.
//!
//! [`floor_plan`] makes walls of maps; [`activmedia_map`] reads and writes those of the Pioneer's own tools.
//!
//! ```
//! use std::{sync::Arc, time::Duration};
//! use geometry::{Se2, SegmentWorld, Segment, Transform2, Vec2};
//! use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
//! use run_context::RunSeed;
//! use sensor_models::SonarModel;
//! use simulator::{RobotPlacement, World, WorldSpec};
//!
//! let wall = Segment { a: Vec2::new(2.0, -5.0), b: Vec2::new(2.0, 5.0) };
//! let spec = WorldSpec::of_walls(SegmentWorld::new([(wall, 0)]));
//! let mut world = World::new(spec, RunSeed(1), Duration::from_millis(10))?;
//! let robot = world.add_robot(RobotPlacement {
//!     name: "rover".to_owned(),
//!     model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
//!     world_from_base: Se2::IDENTITY,
//!     errors: OdometryErrors::default(),
//!     sonar: SonarModel::default(),
//! })?;
//! world.set_wheel_reference(robot, WheelSpeeds { left_mps: 0.3, right_mps: 0.3 });
//! (0..2000).for_each(|_| world.step());
//! // It ran into the wall and stands there, its front 0.21 m before its centre.
//! assert_eq!(world.body(robot).contacts, 1);
//! assert!((world.body(robot).world_from_base.se2().x_m - 1.79).abs() < 1e-3);
//! # Ok::<(), simulator::WorldError>(())
//! ```

pub mod activmedia_map;
mod body;
mod clearance;
mod collide;
mod contact;
mod fixtures;
pub mod floor_plan;
mod floor_tags;
mod neighbours;
mod people;
mod place;
mod placing;
mod scene;
mod spec;
mod world;

pub use body::Body;
pub use fixtures::{Fixtures, VIRTUAL_WALL_REACH_M};
pub use floor_tags::{FloorTags, FloorTagsError};
pub use people::Person;
pub use scene::Scene;
pub use spec::{
    BodyId, PersonSpec, RobotPlacement, ThingId, ThingKind, ThingSpec, WorldError, WorldSpec,
};
pub use world::{Thing, World};
