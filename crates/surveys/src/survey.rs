//! A run over a recording, one scan at a time.

use std::sync::Arc;

use geometry::Se2;
use least_squares::PoseGraph;
use recordings::{Recording, Rig, StampedPose};

use crate::{
    clock::{Clock, Stages},
    config::{Method, SurveyConfig},
    drawing::SurveyMap,
    laser::LaserMapper,
    odometry::OdometryMapper,
    outcome::{Outcome, dead_reckoning},
    sonar::{self, SurveyPrior},
};

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

/// How far a survey is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Scans taken.
    pub n_done: usize,
    /// All scans.
    pub n_scans: usize,
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

/// A run over a recording: step by step, or to its end.
///
/// The same recording and configuration give the same bits. Memory: the recording, the map, and a pose for each scan.
///
/// ```
/// use std::sync::Arc;
/// use surveys::{Clock, Survey, SurveyConfig, testing};
///
/// let recording = Arc::new(testing::room(40));
/// let mut survey = Survey::new(recording, SurveyConfig::default(), Clock::stopped())?;
/// while survey.progress().n_done < survey.progress().n_scans {
///     let _events = survey.step()?;
/// }
/// let outcome = survey.finish()?;
/// assert_eq!(outcome.trajectory.len(), 40);
/// # Ok::<(), surveys::SurveyError>(())
/// ```
#[derive(Debug)]
pub struct Survey {
    recording: Arc<Recording>,
    config: SurveyConfig,
    method: Method,
    mapper: Box<dyn Mapper>,
    stages: Stages,
    n_done: usize,
    is_finished: bool,
    history: History,
}

/// What happened so far, for the outcome.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    /// Milliseconds that each scan took.
    pub(crate) scan_ms: Vec<f64>,
    pub(crate) closed: Vec<Closed>,
    pub(crate) registrations: Vec<Registration>,
    pub(crate) n_lost: usize,
}

impl Survey {
    /// Begins a survey; nothing is mapped yet.
    ///
    /// # Errors
    ///
    /// [`SurveyError`] when there is no scan, or the method does not fit the rig.
    pub fn new(
        recording: Arc<Recording>,
        config: SurveyConfig,
        clock: Clock,
    ) -> Result<Self, SurveyError> {
        Self::with_prior(recording, config, clock, None)
    }

    /// Begins a survey that knows a map already.
    ///
    /// # Errors
    ///
    /// As [`Survey::new`]; also when the method cannot use a map.
    pub fn with_prior(
        recording: Arc<Recording>,
        config: SurveyConfig,
        clock: Clock,
        prior: Option<SurveyPrior>,
    ) -> Result<Self, SurveyError> {
        if recording.scans.is_empty() {
            return Err(SurveyError::NoScans);
        }
        let method = method_for(&recording.rig, config.method())?;
        if prior.is_some() && method != Method::Sonar {
            let text = "a map that is known already is used by the sonar method only";
            return Err(SurveyError::Unsuitable(text.to_owned()));
        }
        let mapper: Box<dyn Mapper> = match method {
            Method::Laser => Box::new(LaserMapper::new(&recording, &config)?),
            Method::Sonar => sonar::mapper(&recording, &config, prior)?,
            Method::Odometry | Method::Auto => match &recording.rig {
                Rig::Laser(rig) => Box::new(OdometryMapper::new(&recording, rig, &config)?),
                // The same map, without any correction.
                Rig::Ring(_) => {
                    let off = ["sonar.correct=false".to_owned(), "survey.mode=default".to_owned()];
                    sonar::mapper(&recording, &config.with(&off)?, None)?
                }
            },
        };
        let history = History::default();
        let stages = Stages::new(clock);
        let (n_done, is_finished) = (0, false);
        Ok(Self { recording, config, method, mapper, stages, n_done, is_finished, history })
    }

    /// Takes the next scan; nothing when all are done.
    ///
    /// # Errors
    ///
    /// [`SurveyError`] when the map cannot grow any more; what was done so far stays.
    pub fn step(&mut self) -> Result<Vec<Event>, SurveyError> {
        let mut events = Vec::new();
        if self.n_done < self.recording.scans.len() {
            let begun = self.stages.now();
            self.mapper.step(&self.recording, self.n_done, &mut self.stages, &mut events)?;
            let spent = self.stages.now().saturating_sub(begun);
            self.history.scan_ms.push(spent.as_secs_f64() * 1e3);
            self.history.take(&events);
            self.n_done += 1;
        }
        Ok(events)
    }

    /// Does what can only be done when all scans are in; the survey may still be looked at. Once.
    ///
    /// # Errors
    ///
    /// As [`Survey::step`].
    pub fn complete(&mut self) -> Result<Vec<Event>, SurveyError> {
        let mut events = Vec::new();
        if !self.is_finished {
            self.is_finished = true;
            self.mapper.finish(&self.recording, &mut self.stages, &mut events)?;
            self.history.take(&events);
        }
        Ok(events)
    }

    /// Takes the scans that are left, and ends the survey.
    ///
    /// # Errors
    ///
    /// As [`Survey::step`].
    pub fn finish(mut self) -> Result<Outcome, SurveyError> {
        while self.n_done < self.recording.scans.len() {
            self.step()?;
        }
        self.complete()?;
        self.outcome_so_far()
    }

    /// The results as they are now: for a checkpoint, or for whoever looks on.
    ///
    /// # Errors
    ///
    /// [`SurveyError::Map`] when the map does not fit into memory.
    pub fn outcome_so_far(&mut self) -> Result<Outcome, SurveyError> {
        let begun = self.stages.now();
        let map = self.mapper.map(&self.recording)?.clone();
        self.stages.add("draw the map", self.stages.now().saturating_sub(begun));
        Ok(Outcome {
            method: self.method,
            mode: self.config.mode(),
            n_scans: self.recording.scans.len(),
            trajectory: self.mapper.trajectory(),
            odometry: self.dead_reckoning(),
            map,
            graph: self.mapper.graph().map(|(graph, scans)| (graph.clone(), scans)),
            closed: self.history.closed.clone(),
            registrations: self.history.registrations.clone(),
            n_lost: self.history.n_lost,
            counters: self.mapper.counters(),
            stages: self.stages.all().clone(),
            scan_ms: self.history.scan_ms.clone(),
        })
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        Progress { n_done: self.n_done, n_scans: self.recording.scans.len() }
    }

    /// Who makes the map; never [`Method::Auto`].
    pub fn method(&self) -> Method {
        self.method
    }

    /// How it was set up.
    pub fn config(&self) -> &SurveyConfig {
        &self.config
    }

    /// What is mapped.
    pub fn recording(&self) -> &Arc<Recording> {
        &self.recording
    }

    /// Where the newest scan is, in `Map`.
    pub fn map_from_base(&self) -> Option<Se2> {
        self.mapper.map_from_base()
    }

    /// One pose in `Map` for each scan so far.
    pub fn trajectory(&self) -> Vec<StampedPose> {
        self.mapper.trajectory()
    }

    /// Dead reckoning of the scans so far, in `Map`; `None` where the recording has none.
    pub fn dead_reckoning(&self) -> Vec<Option<Se2>> {
        dead_reckoning(&self.recording, self.n_done, self.mapper.map_from_odom())
    }

    /// The map of the scans so far, brought up to date now.
    ///
    /// # Errors
    ///
    /// [`SurveyError`] when it cannot be made.
    pub fn map(&mut self) -> Result<&SurveyMap, SurveyError> {
        self.mapper.map(&self.recording)
    }

    /// The pose graph, if the method has one, with the scan of each vertex.
    pub fn graph(&self) -> Option<(&PoseGraph, Vec<usize>)> {
        self.mapper.graph()
    }

    /// The loops closed so far.
    pub fn closed(&self) -> &[Closed] {
        &self.history.closed
    }

    /// The short-term map under way, if the method has one.
    pub fn short_term(&self) -> Option<ShortTerm> {
        self.mapper.short_term()
    }

    /// The newest comparison of a short-term map, if there was one.
    pub fn registration(&self) -> Option<&Registration> {
        self.history.registrations.last()
    }

    /// Numbers of things.
    pub fn counters(&self) -> Vec<Counter> {
        self.mapper.counters()
    }

    /// Time spent by stage.
    pub fn stages(&self) -> &Stages {
        &self.stages
    }
}

impl History {
    fn take(&mut self, events: &[Event]) {
        for event in events {
            match event {
                Event::Closed(closed) => self.closed.push(*closed),
                Event::Registered(registration) => self.registrations.push(registration.clone()),
                Event::Placed { how: "lost", .. } => self.n_lost += 1,
                _ => {}
            }
        }
    }
}

/// The method that is meant, if it fits the rig.
fn method_for(rig: &Rig, asked: Method) -> Result<Method, SurveyError> {
    match (rig, asked) {
        (_, Method::Odometry) => Ok(Method::Odometry),
        (Rig::Laser(_), Method::Auto | Method::Laser) => Ok(Method::Laser),
        (Rig::Ring(_), Method::Auto | Method::Sonar) => Ok(Method::Sonar),
        (Rig::Laser(_), Method::Sonar) => Err(SurveyError::Unsuitable(
            "this is a laser's recording: the sonar method needs a ring of sonars".to_owned(),
        )),
        (Rig::Ring(_), Method::Laser) => Err(SurveyError::Unsuitable(
            "this is a recording of sonars: the laser method needs a scanning laser".to_owned(),
        )),
    }
}
