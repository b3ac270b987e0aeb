//! The client side of the wire: bytes to observations, commands to bytes.
//!
//! A driver is a pure state machine: it is stepped with the time and the bytes that came in,
//! appends [`navigator::Observation`]s and bytes to send, and takes [`navigator::Command`]s.
//! Whether the bytes travel over a simulated link, a socket or a serial port is the caller's
//! business, and the driver cannot tell.
//!
//! - [`PioneerDriver`]: a Pioneer robot ([`wire::arcos`]);
//! - [`PheromoneClient`]: the pheromone server ([`wire::pheromone_link`]);
//! - [`GroundClient`] and [`GroundStation`]: the two ends of [`wire::ground_link`].

mod ground;
mod pheromones;
mod pioneer;
#[cfg(test)]
mod tests;

pub use ground::{
    GoalNews, GroundClient, GroundLinkConfig, GroundStation, GroundStationEvent, failure_code,
    failure_text,
};
pub use pheromones::{PheromoneClient, PheromoneClientConfig, PheromoneCounters};
pub use pioneer::{
    DriveCommand, LineTiming, PioneerCounters, PioneerDriver, PioneerDriverConfig, PioneerSettings,
};
