//! What can be wrong with a map, or with the file that holds one.

use thiserror::Error;

/// Why a map could not be made, read or written.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MapError {
    /// A lattice needs a side that can be measured.
    #[error("resolution {value} m: must be a finite number above 0")]
    Resolution {
        /// What was given, metres.
        value: f64,
    },
    /// A lattice, or a map file, needs a place.
    #[error("origin ({x_m}, {y_m}) m: both must be finite numbers")]
    Origin {
        /// What was given for x, metres.
        x_m: f64,
        /// What was given for y, metres.
        y_m: f64,
    },
    /// A weight, threshold or limit that makes no sense.
    #[error("{key} = {value}: must be {requirement}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// What was given.
        value: f64,
        /// What would do.
        requirement: &'static str,
    },
    /// A dense piece of the map would need too much memory.
    #[error(
        "{width} × {height} cells at once: at most {n_max} cells; take a smaller piece, or look for \
         readings or poses that lie far outside"
    )]
    TooLarge {
        /// Cells along x.
        width: usize,
        /// Cells along y.
        height: usize,
        /// Cells allowed.
        n_max: usize,
    },
    /// A map without any cell cannot be written.
    #[error("the map has no cells: insert a scan before writing it")]
    Empty,
    /// A text does not say what its format asks for.
    #[error("{format}, line {line}: found {found}, expected {expected}")]
    Text {
        /// The format, as people call it.
        format: &'static str,
        /// Line, counted from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What would do.
        expected: String,
    },
    /// A file ends too early, or goes on after its end.
    #[error("{format}: {found} {unit}, expected {expected}: the file is damaged or cut short")]
    Length {
        /// The format, as people call it.
        format: &'static str,
        /// How many there are.
        found: usize,
        /// How many the head announces.
        expected: usize,
        /// Of what.
        unit: &'static str,
    },
    /// The picture could not be coded.
    #[error("PNG: {reason}")]
    Png {
        /// What the coder says.
        reason: String,
    },
}
