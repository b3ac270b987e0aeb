//! What is known before.

use geometry::Se2;
use grid_maps::LogOddsMap;

/// A map that is known before the survey begins.
#[derive(Clone, Debug)]
pub struct SurveyPrior {
    /// Its evidence.
    pub map: LogOddsMap,
    /// Where the robot is in it at the first scan, within about 0.1 m and 3°; `None`: where its odometry says.
    pub start: Option<Se2>,
}
