//! Virtual pheromones: the field, its perception by two antennas, its server.
//!
//! Trails live in a map that a ground server keeps, not on the floor. A robot sends its pose and gets
//! back what two antennas at its sides would smell there; a small controller (crate `path_following`)
//! turns the difference into wheel speeds. The robot stores no map and plans no path.
//!
//! - [`Field`]: a grid of sources, as text, drawn, deposited, evaporating, saved and restored;
//! - [`Field::sense`]: what the antennas perceive, in three modes ([`Perception`]);
//! - [`Server`]: the server as a state machine, bytes in and bytes out;
//! - [`model`]: diffusion, evaporation and aggregation as plain functions;
//! - [`TagTrail`]: a trail that lies in the floor, as intensities stored in tags;
//! - [`Synapse`]: the same perception seen as the weights of a neural network.
//!
//! Source of the method: I. Susnea (c. 2009), doctoral thesis, University of Galati ("the thesis"),
//! §5.3.1, §7.4 and its Annex B; equation numbers below are the thesis's. Tests compare with its
//! listing's golden values, with plain sums over all cells, and with laws (symmetry, additivity).
//!
//! When not to use it: obstacles are unknown to the field; pair it with an avoider.

mod deposit;
mod deposits;
mod drawing;
mod field;
mod map_text;
pub mod model;
mod sense;
mod server;
mod snapshot;
mod synapses;
mod tag_trail;

pub use field::{Field, FieldError, Source, VALUE_MAX};
pub use map_text::MapTextError;
pub use sense::{EquivalentSource, Intensities, Perception, SenseConfig};
pub use server::{Exchange, Server, ServerConfig, ServerCounters};
pub use snapshot::{SNAPSHOT_HEADER, SnapshotError};
pub use synapses::{Synapse, exo_synapses};
pub use tag_trail::{TagTrail, amplified};
