//! The nodes beside a robot's navigation node, and the lines to them: one file for each kind.
//!
//! What a node knows (a firmware, the pheromone server, the ground's protocol) lives in a crate of its own; here it
//! is put at the far end of a line, with the driver that understands it at the near one.

mod base;
pub(crate) mod decision;
pub(crate) mod desk;
pub(crate) mod devices;
mod direct_ground;
mod direct_laser;
mod direct_robot;
mod ground;
pub(crate) mod inquiry;
pub(crate) mod laser;
mod pheromones;
mod pipe;
pub(crate) mod wiring;
