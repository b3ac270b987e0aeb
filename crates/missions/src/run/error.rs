//! Why a mission cannot be started.

use crate::{mission::SettingError, transport::TransportError};

/// A mission that cannot be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The simulator refuses the world.
    #[error("{place}: the world cannot be built: {source}")]
    World {
        /// Where the mission says it: file, line and column as far as they are known, and the key.
        place: String,
        /// Why.
        source: simulator::WorldError,
    },
    /// A value with which this seed cannot be run: a random box finds no place.
    #[error(transparent)]
    Setting(Box<SettingError>),
    /// A robot elsewhere cannot be reached.
    #[error("robot `{robot}`: {source}")]
    Transport {
        /// The robot.
        robot: String,
        /// Why.
        source: TransportError,
    },
    /// A navigator or link refuses its settings.
    #[error("robot `{robot}`: {problem}")]
    Settings {
        /// The robot.
        robot: String,
        /// What is wrong.
        problem: String,
    },
}
