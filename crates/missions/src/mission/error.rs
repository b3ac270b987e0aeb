//! What can be wrong with a mission, said so that its author can act on it.

use std::path::PathBuf;

pub use settings::SettingError;
pub(crate) use settings::Wrong;

/// A mission that cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MissionError {
    /// Neither a shipped mission nor a file.
    #[error(
        "no mission is called `{name}` and no such file exists; {meant}shipped missions: {shipped}"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// A question with the name that is most like it, or nothing.
        meant: String,
        /// The names that exist.
        shipped: String,
    },
    /// A file could not be read.
    #[error(transparent)]
    Input(#[from] files::InputError),
    /// A shipped file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not TOML, or a key is unknown or of the wrong type; the parser's own message
    /// shows line, column and what was expected.
    #[error("{origin}: {message}")]
    Syntax {
        /// The file.
        origin: String,
        /// The parser's message.
        message: String,
    },
    /// Keys or words that were called otherwise, each with its place and its new name.
    #[error("{}", lines.join("\n"))]
    Moved {
        /// A sentence for each.
        lines: Vec<String>,
    },
    /// A `--set` that cannot be applied.
    #[error("--set {given}: {problem}")]
    Override {
        /// What was given.
        given: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A value that is not allowed.
    #[error("{0}")]
    Setting(Box<SettingError>),
}

impl From<settings::OverrideError> for MissionError {
    fn from(error: settings::OverrideError) -> Self {
        Self::Override { given: error.given, problem: error.problem }
    }
}
