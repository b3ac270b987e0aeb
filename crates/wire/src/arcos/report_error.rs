//! Why a robot's packet cannot be read.

/// Why a body is no robot's packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// There is no type byte.
    #[error("empty body; a robot's packet begins with its type")]
    Empty,
    /// The body ends before its fields do.
    #[error("packet of type {kind:#04x}: {len} bytes end inside its {field}")]
    CutShort {
        /// The type byte.
        kind: u8,
        /// Length of the body, bytes.
        len: usize,
        /// The field that could not be read.
        field: &'static str,
    },
    /// The type byte is not the one asked for.
    #[error("packet of type {kind:#04x} where {expected} was expected")]
    Kind {
        /// The type byte.
        kind: u8,
        /// What the caller decodes.
        expected: &'static str,
    },
}
