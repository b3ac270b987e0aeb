//! What can be set about a survey: every key with its range, its default and a sentence.
//!
//! Settings are a TOML file of tables and keys; single keys are changed by `table.key=value`. One list of keys
//! ([`SurveyConfig::keys`]) is behind reading, checking, printing, sweeping and the studio's form, so that none of
//! them can know another set of keys than the others. Lengths are metres, times seconds, angles degrees.

mod error;
pub(crate) mod key;
mod keys;
mod method;
mod presets;
mod read;
mod used;
pub(crate) mod values;

pub use error::ConfigError;
pub use key::{Key, KeyKind};
pub use method::{Method, Mode};
pub use values::MapSettings;

use values::Values;

/// A checked configuration.
///
/// ```
/// use surveys::SurveyConfig;
///
/// let config = SurveyConfig::default().with(&["map.resolution_m=0.1".to_owned()])?;
/// assert_eq!(config.get("map.resolution_m").as_deref(), Some("0.1"));
/// assert!(SurveyConfig::default().with(&["map.resolution_m=-1".to_owned()]).is_err());
/// # Ok::<(), surveys::ConfigError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurveyConfig {
    values: Values,
}

impl SurveyConfig {
    pub(crate) fn values(&self) -> &Values {
        &self.values
    }

    /// Who is asked to make the map.
    pub fn method(&self) -> Method {
        self.values.method
    }

    /// Which form of the sonar method.
    pub fn mode(&self) -> Mode {
        self.values.mode
    }

    /// How the map is drawn.
    pub fn map(&self) -> &MapSettings {
        &self.values.map
    }
}
