//! Codecs of every protocol of the system, and the byte pipes that carry them.
//!
//! Bytes go in, messages come out, and back. Nothing here opens a socket or reads a clock, so the
//! same code stands behind a TCP port, a serial port and a simulated link:
//!
//! - [`arcos`]: the packets between a Pioneer robot and its client;
//! - [`create_oi`]: commands and sensor packets of an iRobot Create 2;
//! - [`reader`]: whoever reads along on a robot's line, by the name of its protocol;
//! - [`dle`]: the DLE framing of the radio links, with [`pheromone_link`] (robot to pheromone
//!   server) and [`ground_link`] (decision unit and ground station to vehicle) on top of it;
//! - [`sick_lms`], [`rplidar`], [`ld06`]: scanning lasers;
//! - [`link`]: a byte pipe in virtual time with baud rate, latency and faults.
//!
//! Every decoder takes bytes from strangers: none panics, each does bounded work per byte and keeps
//! bounded memory, and what it throws away is counted.

#![cfg_attr(not(test), warn(clippy::indexing_slicing, clippy::arithmetic_side_effects))]

pub mod arcos;
pub mod create_oi;
pub mod dle;
pub mod ground_link;
pub mod ld06;
pub mod link;
pub mod pheromone_link;
mod readers;
pub mod rplidar;
mod search;
pub mod sick_lms;

pub use readers::{Reader, Take, Towards, reader};
