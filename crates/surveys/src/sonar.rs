//! The sonar methods behind a survey's face.

mod classic;
mod continuous;
mod graph;
mod settings;

pub(crate) use settings::{KEYS, SonarSettings};

use geometry::Se2;
use grid_maps::LogOddsMap;
use recordings::{Recording, Rig};

use crate::{
    config::{Mode, SurveyConfig},
    survey::{Mapper, SurveyError},
};
use classic::ClassicMapper;
use continuous::ContinuousMapper;
use graph::GraphMapper;

/// A map that is known before the survey begins.
#[derive(Clone, Debug)]
pub struct SurveyPrior {
    /// Its evidence.
    pub map: LogOddsMap,
    /// Where the robot is in it at the first scan, within about 0.1 m and 3°; `None`: where its odometry says.
    pub start: Option<Se2>,
}

/// The form of the method that the mode names.
pub(crate) fn mapper(
    recording: &Recording,
    config: &SurveyConfig,
    prior: Option<SurveyPrior>,
) -> Result<Box<dyn Mapper>, SurveyError> {
    match (config.mode(), &recording.rig) {
        (Mode::Default, Rig::Ring(ring)) => {
            Ok(Box::new(ContinuousMapper::new(recording, ring, config, prior)?))
        }
        (Mode::Default | Mode::Graph, Rig::Laser(_)) => {
            Err(SurveyError::Unsuitable("the sonar method needs a ring of sonars".to_owned()))
        }
        (Mode::Graph | Mode::Thesis | Mode::Listing, _) if prior.is_some() => {
            let text = "a map that is known already is used by the default mode only";
            Err(SurveyError::Unsuitable(text.to_owned()))
        }
        (Mode::Graph, Rig::Ring(ring)) => Ok(Box::new(GraphMapper::new(ring, config)?)),
        (Mode::Thesis | Mode::Listing, _) => Ok(Box::new(ClassicMapper::new(recording, config)?)),
    }
}
