//! What one run shares: integer time, one seed, random streams by name, a state hash.
//!
//! Nothing here reads a clock. [`Stamp`] is an argument wherever time matters; everything random
//! follows from one [`RunSeed`]; two runs are compared bit by bit through their [`StateHash`].

mod seed;
mod stamp;

pub use seed::{RandomStream, RunSeed, StateHash};
pub use stamp::Stamp;
