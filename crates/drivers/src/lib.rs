//! The client side of the wire: bytes to observations, commands to bytes.
//!
//! A driver is a pure state machine: it is stepped with the time and the bytes that came in,
//! appends [`messages::Observation`]s and bytes to send, and takes [`messages::Command`]s.
//! Whether the bytes travel over a simulated link, a socket or a serial port is the caller's
//! business, and the driver cannot tell.
//!
//! A [`Driver`] is the host's end of a line, whatever is at the other one. For a robot [`driver`] builds the one that a robot of the catalogue needs, by the
//! protocol that its file names:
//!
//! - [`PioneerDriver`]: a Pioneer robot ([`wire::arcos`]);
//! - [`CreateDriver`]: an iRobot Create 2 ([`wire::create_oi`]).
//!
//! A [`LaserDriver`] is the client of a scanning laser; [`laser_driver`] builds it, and [`LaserClient`] makes it a [`Driver`]:
//!
//! - [`SickLmsDriver`], [`RplidarDriver`], [`Ld06Driver`].
//!
//! Beside them are the clients of other nodes:
//!
//! - [`PheromoneClient`]: the pheromone server ([`wire::pheromone_link`]);
//! - [`GroundClient`] and [`GroundStation`]: the two ends of [`wire::ground_link`].

mod create;
mod driver;
mod ground;
mod laser;
mod pheromones;
mod pioneer;
mod registry;
#[cfg(test)]
mod tests;

pub use create::{CreateCounters, CreateDriver, CreateDriverConfig};
pub use driver::{Driver, DriverConfig, LineTiming, Trouble};
pub use ground::{
    GoalNews, GroundClient, GroundLinkConfig, GroundStation, GroundStationEvent, failure_code,
    failure_text, sonar_report,
};
pub use laser::{
    LaserClient, LaserDriver, LaserDriverConfig, LaserNews, LaserTrouble, Ld06Driver,
    RplidarDriver, SickLmsDriver, TakeNews, laser_driver,
};
pub use pheromones::{PheromoneClient, PheromoneClientConfig, PheromoneCounters};
pub use pioneer::{
    DriveCommand, PioneerCounters, PioneerDriver, PioneerDriverConfig, PioneerSettings,
};
pub use registry::{NoDriver, driver, has_driver};
