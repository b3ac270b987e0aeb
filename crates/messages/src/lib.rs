//! What the nodes of a robot tell each other: plain data, no wire, no clock.
//!
//! An [`Observation`] is what one sensor, or one other node, said about one instant. It is about a *sensor* and not
//! about a robot: a Pioneer's packet becomes five of them, a laser's telegram one, and whoever needs only the wheels
//! reads only [`OdometryReading`]. What passes in a step is kept in [`Observations`]: a list, and beside it the beams
//! of scans, so that nothing is allocated once it has run a while. What comes back is a [`Command`].
//!
//! Drivers make observations of bytes and bytes of commands; a navigator does the reverse; neither knows the other.
//!
//! A new kind of sensor is a variant of [`Sensed`] here, a model, a board and a driver: nothing else has to
//! change until somebody uses it.

mod base;
mod command;
mod observation;
mod order;
mod sensed;

pub use base::BaseState;
pub use command::{Command, FailureReason, Report};
pub use observation::{DeviceId, Observation, Observations};
pub use order::Order;
pub use sensed::{
    Battery, Contacts, LinkState, Motors, N_RING_MAX, OdometryReading, Ring, Scan, Sensed, Smell,
    TagRead, age_ms,
};
