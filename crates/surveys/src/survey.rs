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
    mapper::{Closed, Counter, Event, Mapper, Registration, ShortTerm, SurveyError},
    odometry::OdometryMapper,
    outcome::{Outcome, dead_reckoning},
    sonar::{self, SurveyPrior},
};

/// How far a survey is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Scans taken.
    pub n_done: usize,
    /// All scans.
    pub n_scans: usize,
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
