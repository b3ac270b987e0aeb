//! Where a robot is on a map that it was given.
//!
//! A [`LikelihoodField`] says of each place how likely a beam is to end there. A [`ParticleFilter`] keeps some hundreds
//! or thousands of poses that the robot may have, moves them as the wheels say, and believes those whose beams end
//! where the map has something. What it found is an [`Estimate`]: pose, covariance, and a word for how sure it is
//! ([`Health`]).
//!
//! It draws random numbers from the stream that it was given, in an order that depends on its inputs alone: equal
//! inputs give equal bits. It knows no robot, no laser and no clock, and allocates nothing once it runs.
//!
//! Source: Thrun, Burgard, Fox (2005), *Probabilistic Robotics*: likelihood fields (6.4, table 6.3), the filter
//! and its low-variance resampling (4.3, table 4.4), random particles after disagreement (8.3.3, table 8.3); Fox (2003),
//! "Adapting the sample size in particle filters through KLD-sampling", IJRR 22(12), for their number. Differences:
//! likelihoods are kept as 256 steps of their logarithm; beams of one scan err together, so their likelihoods are
//! multiplied as if fewer had been seen; wheels err with the root of their way, each for itself; beams that end
//! where the map is empty around the best guess are left out, as those of people are.

mod config;
mod estimate;
mod field;
mod filter;
mod spread;

pub use config::{ConfigError, FilterConfig};
pub use estimate::{Estimate, Health};
pub use field::{FieldModel, LikelihoodField};
pub use filter::{Correction, ParticleFilter};
