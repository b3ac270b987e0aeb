//! Why a recording cannot be read at all.

use crate::Format;

/// A recording that cannot be read. What is merely damaged is read, with complaints.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// There is nothing in the file.
    #[error("{name}: the file is empty")]
    Empty {
        /// The file's name.
        name: String,
    },
    /// The content is of no known kind.
    #[error(
        "{name}: unknown format, the file begins with {beginning}; a log is a {}, each also as gzip",
        Format::listed()
    )]
    UnknownFormat {
        /// The file's name.
        name: String,
        /// The first bytes, readable.
        beginning: String,
    },
    /// The content is known, but this kind of it cannot be read.
    #[error("{name}: {problem}")]
    Unsupported {
        /// The file's name.
        name: String,
        /// What it is, and what to do.
        problem: String,
    },
    /// No scan could be read.
    #[error("{name}: no usable scan in this {format}; it contains {contains}")]
    NoScans {
        /// The file's name.
        name: String,
        /// What it was read as.
        format: Format,
        /// What is there instead, with the first complaints.
        contains: String,
    },
    /// No line of a file of poses or relations could be read.
    #[error("{name}: no usable line of {what}; it contains {contains}")]
    NoLines {
        /// The file's name.
        name: String,
        /// What was looked for, with its fields.
        what: &'static str,
        /// What is there instead, with the first complaints.
        contains: String,
    },
    /// A gzip file of which nothing can be unpacked.
    #[error("{name}: nothing of this gzip file can be unpacked: {problem}")]
    Gzip {
        /// The file's name.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// The content grows beyond the limit when it is unpacked.
    #[error(
        "{name}: unpacks to more than {bytes_max} bytes; raise the limit if the file is to be trusted"
    )]
    TooLarge {
        /// The file's name.
        name: String,
        /// The limit.
        bytes_max: usize,
    },
    /// The recording would take more memory than it may.
    #[error(
        "{name}: reading it takes about {} MB of memory, of which at most {} MB may be taken here",
        needed.div_ceil(1 << 20), most >> 20
    )]
    TooMuchMemory {
        /// The file's name.
        name: String,
        /// Bytes that it takes.
        needed: usize,
        /// The limit, bytes.
        most: usize,
    },
    /// A format of two files was given only one.
    #[error("{name}: {what} come in a second file; give that too")]
    SecondFileMissing {
        /// The file's name.
        name: String,
        /// What the second file holds.
        what: &'static str,
    },
    /// Which of the robots?
    #[error("{name}: recordings of several robots: {}; choose one by its name", robots.join(", "))]
    SeveralRobots {
        /// The file's name.
        name: String,
        /// Their names.
        robots: Vec<String>,
    },
    /// The chosen robot is not there.
    #[error("{name}: no robot {robot:?}; there are: {}", robots.join(", "))]
    NoSuchRobot {
        /// The file's name.
        name: String,
        /// Which was asked for.
        robot: String,
        /// Those that are there.
        robots: Vec<String>,
    },
    /// The ring has more sonars than the file has readings in a row.
    #[error(
        "{name}: {columns} readings in a row, but the ring {ring} has {mounts} sonars; choose another ring"
    )]
    RingTooLarge {
        /// The file's name.
        name: String,
        /// Readings in a row.
        columns: usize,
        /// The ring that was chosen.
        ring: &'static str,
        /// Its sonars.
        mounts: usize,
    },
    /// The file does not say what took the readings.
    #[error("{name}: {problem}")]
    NoRig {
        /// The file's name.
        name: String,
        /// What is missing, and what to do.
        problem: String,
    },
    /// An option is out of its range.
    #[error("option {option} = {value}: must be {requirement}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        requirement: &'static str,
    },
}
