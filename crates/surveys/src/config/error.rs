//! Settings that cannot be used.

use settings::{OverrideError, SettingError};

/// Settings that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The text is not TOML; the parser's own message shows line and column.
    #[error("{origin}: {message}")]
    Syntax {
        /// The file.
        origin: String,
        /// The parser's message.
        message: String,
    },
    /// A `--set` that cannot be applied.
    #[error(transparent)]
    Override(#[from] OverrideError),
    /// A value that is not allowed, or a key that does not exist.
    #[error("{0}")]
    Setting(Box<SettingError>),
}
