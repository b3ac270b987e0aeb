//! The values that can be set, by table.

use slam::laser::LaserConfig;

use super::method::{Method, Mode};
use crate::sonar::SonarSettings;

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
    pub(crate) sonar: SonarSettings,
}
