//! What a robot sensed, as recorded: range readings with the odometry of their moment.
//!
//! A [`Recording`] is the one shape in which measured and simulated runs reach the mappers, whatever
//! file they came from. [`read`] takes the bytes of a file, finds out what they are, and gives the recording
//! with a list of [`Complaints`]: what was wrong, at which line, and what was done about it. Only a file
//! of which nothing can be used is an error.
//!
//! What it reads is [`Format::ALL`], a table. Written are MAT files and ARTEMIC's texts ([`sonar_files`]), CSV
//! ([`csv`]), cairn's MCAP ([`cairn_mcap`]), MCAP for viewers ([`foxglove`]), poses as TUM lines and relations between
//! poses ([`trajectories`], which also reads both).
//!
//! # What happens to bad lines
//!
//! A line that cannot be read is skipped and counted. A reading that is NaN or negative becomes "nothing
//! came back"; a line of which more than half is like that is skipped. Scans of another number of
//! readings than most are skipped. The same scan twice (equal stamp, ranges and odometry) is taken once.
//!
//! Stamps that go back: of the two orders, that of the file and that of the stamps, the one is taken in which
//! the robot's odometry travels less (without odometry, in which the ranges change less); so lines
//! that were shuffled are sorted, and a clock that was set back does not mix two parts of a run. Where the
//! order of the file is right, time goes on from the line before. Where most stamps are equal, they order
//! nothing: the order of the file is kept and odometry lines of their own are left out.

mod assemble;
pub mod cairn_mcap;
mod carmen;
mod complaints;
mod contents;
pub mod csv;
mod error;
mod format;
pub mod foxglove;
mod integrity;
pub mod mat;
pub mod mcap_file;
mod mcap_records;
mod memory;
mod mrpt;
mod numbers;
mod options;
mod order;
mod raw;
mod read;
mod recording;
mod rings;
pub mod sonar_files;
pub mod trajectories;
mod unpack;

pub use complaints::{Action, Complaint, Complaints, Place, Trouble};
pub use error::RecordingError;
pub use format::{Format, Takes};
pub use options::ReadOptions;
pub use read::{Loaded, read};
pub use recording::{LaserRig, Recording, Rig, RingRig, Scan, StampedPose, interpolate_pose};
pub use rings::Ring;
