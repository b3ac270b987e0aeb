//! A survey in a slot of the player: where it is, when it is painted, and what pages are told about it.

use std::{
    collections::BTreeMap,
    sync::{Arc, mpsc},
    time::{Duration, Instant},
};

use surveys::SurveyConfig;

use super::{board::Board, job::Job, protocol::RunState, stage::Stage};

/// A map is looked through for changes at most this often, and no more than a fifth of the time.
const MAP_PERIOD: Duration = Duration::from_millis(100);
/// See [`MAP_PERIOD`].
const MAP_REST_RATIO: u32 = 4;

/// Where a run is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Phase {
    UnderWay,
    /// All scans are in; the rest of the work is done beside the player, which goes on answering.
    Finishing,
    Finished,
    Failed(String),
}

/// Counts the surveys that are being finished, those that nobody waits for any more included.
pub(crate) type Finishing = Arc<()>;

/// A survey that comes back, and why it could not be finished.
type Finished = (Box<Job>, Result<(), String>);

/// A survey under way, in the slot of its index.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) number: u32,
    pub(crate) values: BTreeMap<String, String>,
    pub(crate) phase: Phase,
    config: SurveyConfig,
    /// `None` while it is being finished.
    job: Option<Box<Job>>,
    /// How it stood when it was given away.
    before: Option<RunState>,
    back: Option<mpsc::Receiver<Finished>>,
    /// When its map is looked at next.
    map_due: Instant,
    /// Scans were taken since the last picture.
    is_stale: bool,
}

impl Run {
    /// A run that begins, and its board.
    pub(crate) fn begin(number: u32, job: Job) -> (Self, Board) {
        let mut board = Board::new(number);
        job.begin(&mut board);
        let run = Self {
            number,
            values: job.values(),
            phase: Phase::UnderWay,
            config: job.config().clone(),
            job: Some(Box::new(job)),
            before: None,
            back: None,
            map_due: Instant::now(),
            is_stale: true,
        };
        (run, board)
    }

    /// Scans done.
    pub(crate) fn n_done(&self) -> usize {
        let before = || self.before.as_ref().map_or(0, |state| state.scan);
        self.job.as_ref().map_or_else(before, |job| job.n_done())
    }

    /// Time of the newest scan since the first, s.
    pub(crate) fn t_s(&self) -> f64 {
        let before = || self.before.as_ref().map_or(0.0, |state| state.t_s);
        self.job.as_ref().map_or_else(before, |job| job.t_s())
    }

    /// Time of the next scan since the first, s; `None` when all are in.
    pub(crate) fn next_t_s(&self) -> Option<f64> {
        self.job.as_ref()?.next_t_s()
    }

    /// The value of a parameter.
    pub(crate) fn value(&self, key: &str) -> String {
        self.config.get(key).unwrap_or_default()
    }

    /// Begins what can only be done when all scans are in, on a thread of its own; [`Run::take_back`] ends it. Nothing
    /// while another survey is being finished.
    pub(crate) fn finish(&mut self, slot: usize, stage: &Stage, finishing: &Finishing) {
        if self.back.is_some() || Arc::strong_count(finishing) > 1 {
            return;
        }
        self.before = Some(self.state(slot, stage));
        let Some(mut job) = self.job.take() else { return };
        let (give_back, back) = mpsc::channel();
        let counted = finishing.clone();
        let work = move || {
            let outcome = job.finish();
            drop(counted);
            // A run that was begun again in the meantime wants it no more.
            drop(give_back.send((job, outcome)));
        };
        match std::thread::Builder::new().name("finish".to_owned()).spawn(work) {
            Ok(_detached) => self.back = Some(back),
            Err(error) => self.phase = Phase::Failed(format!("cannot be finished: {error}")),
        }
    }

    /// Whether it has come back from being finished, just now.
    pub(crate) fn take_back(&mut self) -> bool {
        let Some(back) = &self.back else { return false };
        match back.try_recv() {
            Ok((job, outcome)) => {
                self.phase = match outcome {
                    Ok(()) => Phase::Finished,
                    Err(problem) => Phase::Failed(problem),
                };
                self.job = Some(job);
            }
            Err(mpsc::TryRecvError::Empty) => return false,
            Err(mpsc::TryRecvError::Disconnected) => {
                self.phase = Phase::Failed("finishing it failed by a fault of ours".to_owned());
            }
        }
        self.back = None;
        self.is_stale = true;
        self.map_due = Instant::now();
        true
    }

    /// Whether it has something left to do.
    pub(crate) fn goes_on(&self) -> bool {
        matches!(self.phase, Phase::UnderWay | Phase::Finishing)
    }

    /// Takes the next scan.
    pub(crate) fn step(&mut self) {
        self.is_stale = true;
        if let Some(Err(problem)) = self.job.as_mut().map(|job| job.step()) {
            self.phase = Phase::Failed(problem);
        }
    }

    /// Brings its board up to date; the map only when it is due, or when time stands still.
    pub(crate) fn paint(&mut self, slot: usize, stage: &Stage, whole: bool) {
        let goes_on = self.goes_on();
        let Some(job) = self.job.as_mut().filter(|_| self.is_stale) else { return };
        let now = Instant::now();
        let map_is_due = whole || now >= self.map_due || !goes_on;
        let painted = stage.paint(slot, |board| {
            job.paint(board);
            if map_is_due { job.paint_map(board) } else { Ok(()) }
        });
        if let Some(Err(problem)) = painted {
            self.phase = Phase::Failed(problem);
        }
        if map_is_due {
            self.is_stale = false;
            let rest = now.elapsed() * MAP_REST_RATIO;
            self.map_due = Instant::now() + rest.max(MAP_PERIOD);
        }
    }

    /// How it stands, for the pages.
    pub(crate) fn state(&self, slot: usize, stage: &Stage) -> RunState {
        let (phase, problem) = match &self.phase {
            Phase::UnderWay => ("under way", None),
            Phase::Finishing => ("finishing", None),
            Phase::Finished => ("finished", None),
            Phase::Failed(problem) => ("failed", Some(problem.clone())),
        };
        let is_cut = stage.paint(slot, |board| board.is_cut()).unwrap_or(false);
        let Some(job) = &self.job else {
            let before = self.before.clone().unwrap_or_default();
            return RunState { phase, problem, is_cut, ..before };
        };
        RunState {
            run: self.number,
            phase,
            problem,
            scan: job.n_done(),
            n_scans: job.n_scans(),
            t_s: job.t_s(),
            pose: job.pose(),
            odometry: job.odometry(),
            tracking: job.tracking(),
            counters: job.counters(),
            stages: job.stages(),
            figures: job.figures().to_vec(),
            values: self.values.clone(),
            is_cut,
        }
    }
}
