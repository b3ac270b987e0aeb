//! Paths and the controllers that keep a robot on them.
//!
//! | what is known | what follows it |
//! | --- | --- |
//! | a path of lines and arcs ([`Path`]) | [`PathFollower`] with a law of [`PathController::ALL`]; [`Course`]: how fast, and where to turn on the spot |
//! | two smelled intensities, no map | [`TrailFollower`] with a law of [`TrailController::ALL`] |
//! | intensities that two readers found in tags on the floor | [`TagFollower`]: fuzzy on their difference; for look-ahead points in tags, [`pursue`] |
//! | where the robot was led by hand | [`Past`], a recording that becomes a [`Path`] with speeds |
//! | sonar ranges along a wall | [`WallFollower`] |
//!
//! Every step is a function of its arguments and a few remembered numbers; none allocates. All give a
//! [`WheelReference`] for a differential drive. Left is positive everywhere.
//!
//! Source of the methods: I. Susnea (c. 2009), doctoral thesis, University of Galati ("the thesis"), chapter 5
//! and its Annex B2; equation numbers below are the thesis's unless another source is named. Tests drive
//! an ideal differential drive written in the tests, and compare with the thesis's and derived golden values.

mod course;
pub mod fuzzy;
pub mod fuzzy_listing;
mod law_table;
mod past;
mod path;
mod path_laws;
mod tag_laws;
mod trail_laws;
mod wall;
mod wheels;

pub use course::{Corner, Course, CourseLimits, Leg};
pub use past::{Past, PastConfig, Recorded};
pub use path::{Path, PathError, Piece, Projection, signed_line_error_m};
pub use path_laws::{PathController, PathFollower, PathFollowerConfig, PathLaw, Progress, widths};
pub use tag_laws::{TagFollower, TagFollowerConfig, TagStep, pursue};
pub use trail_laws::{
    BioMimeticReading, EquivalentPoint, TrailController, TrailFollower, TrailFollowerConfig,
    TrailLaw, TrailSense, TrailTuning, TwoAntennas,
};
pub use wall::{RangeReading, Side, WallFollower, WallFollowerConfig};
pub use wheels::{SettingError, WheelReference};
