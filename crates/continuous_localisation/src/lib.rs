//! Sonar maps and where they fit: short-term maps, pose search, scores, correction.
//!
//! A robot with a poor ring of sonars and drifting odometry builds a map and knows where it is in it.
//! Readings of the last half metre or so form a short-term map, which odometry cannot have distorted
//! much; it is compared with the long-term map of everything before; the difference corrects the pose.
//! Small corrections often, none without evidence.
//!
//! | to | use |
//! | --- | --- |
//! | map and localise, online or from a recording | [`Localiser`], [`run`] |
//! | draw the map that odometry alone gives | [`run`] with [`LocaliserConfig::odometry_only`] |
//! | reproduce the source's program or text | [`classic`] |
//! | judge a map against the truth | [`metrics`] |
//!
//! ```
//! use continuous_localisation::{LocaliserConfig, run};
//! use recordings::{Recording, Rig, RingRig};
//!
//! let ring = RingRig {
//!     base_from_sensors: vec![geometry::Se2::IDENTITY],
//!     half_angle_rad: 0.26,
//!     range_min_m: 0.15,
//!     range_max_m: 5.0,
//! };
//! let recording = Recording {
//!     rig: Rig::Ring(ring),
//!     scans: Vec::new(),
//!     odometry: Vec::new(),
//!     reference: Vec::new(),
//!     truth: Vec::new(),
//!     extra_columns_m: Vec::new(),
//!     epoch_ns: 0,
//! };
//! let run = run(&recording, LocaliserConfig::default()).expect("the defaults are in range");
//! assert!(run.online.is_empty() && run.localiser.map().bounds().is_none());
//! ```
//!
//! Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială limitată",
//! MSc dissertation, Univ. Dunărea de Jos Galați, for the method; what [`Localiser`] adds to it is
//! ours: walls as landmarks, odometry's systematic error as an unknown, and corrections that weigh
//! what is known against what is measured.

mod chain;
pub mod classic;
mod config;
mod filter;
pub mod insertion;
mod localiser;
pub mod maturity;
pub mod metrics;
mod registration;
mod run;
pub mod search;
mod walls;

pub use classic::Score;
pub use config::{
    ConfigError, Distinctness, LocaliserConfig, OdometryTrust, ReadingFilter, SearchLevel,
    Squareness, WallTrust,
};
pub use localiser::{Localiser, ReadingCounts};
pub use maturity::{Collected, Maturity};
pub use registration::{Outcome, Registration};
pub use run::{RunError, SonarRun, run, run_on, run_twice};
pub use walls::Wall;
