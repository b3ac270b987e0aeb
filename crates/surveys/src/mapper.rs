//! A method behind one face, and what it tells.

use geometry::Se2;
use least_squares::PoseGraph;
use recordings::{Recording, StampedPose};

use crate::{clock::Stages, drawing::SurveyMap};

/// A survey that cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SurveyError {
    /// There is nothing to map.
    #[error("the recording has no scan")]
    NoScans,
    /// The method does not fit the recording.
    #[error("{0}")]
    Unsuitable(String),
    /// The map cannot be made.
    #[error("the map cannot be made: {0}")]
    Map(#[from] grid_maps::MapError),
    /// The thesis's method refuses.
    #[error(transparent)]
    Classic(#[from] continuous_localisation::classic::ClassicError),
    /// A setting is refused.
    #[error(transparent)]
    Config(#[from] crate::config::ConfigError),
    /// A figure of the report cannot be drawn.
    #[error(transparent)]
    Figure(#[from] figures::FigureError),
}

/// Something that happened in a step.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A scan was placed; the map may have grown around it.
    Placed {
        /// Index of the scan.
        scan: usize,
        /// Where, in `Map`.
        map_from_base: Se2,
        /// How, in a word: `first`, `standing`, `matched`, `lost`, `dead reckoning`.
        how: &'static str,
    },
    /// The scan became a vertex of the graph.
    Vertex {
        /// Index of the scan.
        scan: usize,
    },
    /// Two places were found to be the same: an edge that closes a loop.
    Closed(Closed),
    /// A short-term map was compared with the map.
    Registered(Registration),
    /// Earlier poses moved: trajectory, graph and map are to be looked at anew.
    Moved,
}

/// A closed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closed {
    /// Index of the earlier scan.
    pub from_scan: usize,
    /// Index of the later scan.
    pub to_scan: usize,
    /// How far the estimate was off, metres.
    pub shift_m: f64,
    /// The same, radians.
    pub shift_rad: f64,
}

/// How a short-term map was compared with the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Registration {
    /// First scan of the short-term map.
    pub first_scan: usize,
    /// Its last scan.
    pub last_scan: usize,
    /// The poses that were tried.
    pub candidates: Vec<Candidate>,
    /// Index of the best one.
    pub best: Option<usize>,
    /// Whether the pose was corrected.
    pub applied: bool,
    /// What was corrected, or why nothing was.
    pub verdict: String,
    /// What the scores are, in words, and whether less or more is better.
    pub score: &'static str,
    /// The correction that was made, in the frame of the map: metres and radians.
    pub correction: Option<Se2>,
}

/// A pose that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// From where dead reckoning puts the robot, in the axes of the map.
    pub offset: Se2,
    /// Its score, in the unit that the registration's `score` tells; `None` where too little overlapped.
    pub score_ratio: Option<f64>,
}

/// The short-term map under way: probabilities by cell.
#[derive(Clone, Debug, PartialEq)]
pub struct ShortTerm {
    /// Its frame in `Map`.
    pub map_from_patch: Se2,
    /// The cells, in its own frame.
    pub map: SurveyMap,
}

/// A number that grows during a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    /// Short name.
    pub name: &'static str,
    /// The same for people.
    pub label: &'static str,
    /// How many.
    pub n: usize,
}

/// A method, behind one face.
pub(crate) trait Mapper: std::fmt::Debug + Send {
    /// Takes scan `index`.
    fn step(
        &mut self,
        recording: &Recording,
        index: usize,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError>;
    /// Does what can only be done when all scans are in.
    fn finish(
        &mut self,
        recording: &Recording,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError>;
    /// One pose in `Map` for each scan so far.
    fn trajectory(&self) -> Vec<StampedPose>;
    /// Where the newest scan is.
    fn map_from_base(&self) -> Option<Se2>;
    /// The map of the scans so far.
    fn map(&mut self, recording: &Recording) -> Result<&SurveyMap, SurveyError>;
    /// Where dead reckoning's frame lies in `Map` at the first scan; `None`: so that the first scan is at the origin.
    fn map_from_odom(&self) -> Option<Se2> {
        None
    }
    /// The pose graph, if there is one, with the scan of each vertex.
    fn graph(&self) -> Option<(&PoseGraph, Vec<usize>)> {
        None
    }
    /// The short-term map under way.
    fn short_term(&self) -> Option<ShortTerm> {
        None
    }
    /// Numbers of things.
    fn counters(&self) -> Vec<Counter>;
}
