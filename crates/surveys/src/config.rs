//! What can be set about a survey: every key with its range, its default and a sentence.
//!
//! Settings are a TOML file of tables and keys; single keys are changed by `table.key=value`. One list of keys
//! ([`SurveyConfig::keys`]) is behind reading, checking, printing, sweeping and the studio's form, so that none of
//! them can know another set of keys than the others. Lengths are metres, times seconds, angles degrees.

pub(crate) mod keys;
mod presets;
mod read;
mod used;

pub use keys::{Key, KeyKind};
pub use read::ConfigError;

use slam::laser::LaserConfig;

/// Who makes the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The rig decides: a laser is mapped by [`Method::Laser`], a ring by [`Method::Sonar`].
    #[default]
    Auto,
    /// Scan matching, keyframes and loop closure.
    Laser,
    /// Short-term maps and continuous localisation.
    Sonar,
    /// Dead reckoning as it is: what the other methods are compared with.
    Odometry,
}

/// Which form of the sonar method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Our own.
    #[default]
    Default,
    /// Our own, with its short-term maps as submaps of a pose graph and loops between them.
    Graph,
    /// As ARTEMIC's thesis describes it.
    Thesis,
    /// As its printed program computes it, number by number.
    Listing,
}

/// How the map is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// A laser's reading beyond this is not drawn, metres.
    pub range_max_m: f64,
    /// What one reading adds to the cell where it ends.
    pub hit_logodds: f64,
    /// What one reading adds to the cells before it, negative.
    pub miss_logodds: f64,
    /// Certainty at most, either way.
    pub limit_logodds: f64,
    /// Above this a cell is written as occupied.
    pub occupied_prob: f64,
    /// Below this a cell is written as free.
    pub free_prob: f64,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            resolution_m: 0.05,
            range_max_m: 30.0,
            hit_logodds: 0.85,
            miss_logodds: -0.4,
            limit_logodds: 4.0,
            occupied_prob: 0.65,
            free_prob: 0.35,
        }
    }
}

/// Everything that can be set, by table; checked by [`SurveyConfig`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Values {
    pub(crate) method: Method,
    pub(crate) mode: Mode,
    pub(crate) map: MapSettings,
    pub(crate) laser: LaserConfig,
    pub(crate) sonar: crate::sonar::SonarSettings,
}

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
