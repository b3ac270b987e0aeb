//! The sonar methods behind a survey's face.

mod classic;
mod continuous;
mod graph;
mod keys;
mod prior;
mod settings;

pub(crate) use keys::KEYS;
pub use prior::SurveyPrior;
pub(crate) use settings::SonarSettings;

use recordings::{Recording, Rig};

use crate::{
    config::{Mode, SurveyConfig},
    mapper::{Mapper, SurveyError},
};
use classic::ClassicMapper;
use continuous::ContinuousMapper;
use graph::GraphMapper;

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
