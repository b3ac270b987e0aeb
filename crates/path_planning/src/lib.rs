//! Shortest ways on maps, and what to say when there is none.
//!
//! | to do | use |
//! | --- | --- |
//! | say where one may go on a map of cells | [`FreeFloor`], also for a disc of some radius |
//! | find the shortest way | [`GridSearch::find`] with a [`GridMethod`] |
//! | plan for a robot, in metres | [`MapPlanner`] |
//! | read queries with known lengths | [`scenario`] |
//!
//! Nothing here knows a robot, a file or a clock.

mod grid;
mod map_planner;
pub mod scenario;

pub use grid::{Budget, Effort, FreeFloor, GridMethod, GridOutcome, GridPath, GridSearch};
pub use map_planner::{MapPlanner, MapWay, NoWay};
