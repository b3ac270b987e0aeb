//! What can be wrong with a model file.

/// A model file that cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Not the TOML that a model is.
    #[error("{0}")]
    Syntax(#[from] toml::de::Error),
    /// A number outside its range.
    #[error("{key} = {value}: must be {requirement}")]
    Range {
        /// The key in the file.
        key: String,
        /// What it says.
        value: f64,
        /// What it must be, as prose.
        requirement: &'static str,
    },
    /// The outline is no simple polygon.
    #[error("footprint_m: {0}")]
    Footprint(#[from] geometry::PolygonError),
    /// The outline is not convex at a corner.
    #[error("footprint_m: must be convex, but turns inwards at corner {corner} ({x_m}, {y_m}) m")]
    NotConvex {
        /// Index of the corner in the outline, which may be reversed to run counter-clockwise.
        corner: usize,
        /// Its place, metres.
        x_m: f64,
        /// Its place, metres.
        y_m: f64,
    },
    /// No name of a protocol.
    #[error(
        "line.protocol = `{protocol}`: must be a name of small letters, digits and `_`, such as `arcos`"
    )]
    Protocol {
        /// What the file says.
        protocol: String,
    },
    /// Sonars are numbered from 0 without gaps.
    #[error("sonars: entry {index} has number {number}: numbers must run from 0 without gaps")]
    SonarNumber {
        /// Position in the file.
        index: usize,
        /// Its number.
        number: usize,
    },
}

/// Whether a number of the file is within its range.
pub(crate) fn check_range(
    key: &str,
    value: f64,
    min: f64,
    max: f64,
    requirement: &'static str,
) -> Result<(), ModelError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(ModelError::Range { key: key.to_owned(), value, requirement })
}
