//! A survey in a slot of the player: where it is, when it is painted, and what pages are told about it.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use super::{board::Board, job::Job, protocol::RunState, stage::Stage};

/// A map is looked through for changes at most this often, and no more than a fifth of the time.
const MAP_PERIOD: Duration = Duration::from_millis(100);
/// See [`MAP_PERIOD`].
const MAP_REST_RATIO: u32 = 4;

/// Where a run is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Phase {
    UnderWay,
    /// All scans are in; the rest of the work is done in the next frame.
    Finishing,
    Finished,
    Failed(String),
}

/// A survey under way, in the slot of its index.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) number: u32,
    pub(crate) job: Job,
    pub(crate) values: BTreeMap<String, String>,
    pub(crate) phase: Phase,
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
        let values = job.values();
        let map_due = Instant::now();
        (Self { number, job, values, phase: Phase::UnderWay, map_due, is_stale: true }, board)
    }

    /// Does what can only be done when all scans are in.
    pub(crate) fn finish(&mut self) {
        self.phase = match self.job.finish() {
            Ok(()) => Phase::Finished,
            Err(problem) => Phase::Failed(problem),
        };
        self.is_stale = true;
        self.map_due = Instant::now();
    }

    /// Whether it has something left to do.
    pub(crate) fn goes_on(&self) -> bool {
        matches!(self.phase, Phase::UnderWay | Phase::Finishing)
    }

    /// Takes the next scan.
    pub(crate) fn step(&mut self) {
        self.is_stale = true;
        if let Err(problem) = self.job.step() {
            self.phase = Phase::Failed(problem);
        }
    }

    /// Brings its board up to date; the map only when it is due, or when time stands still.
    pub(crate) fn paint(&mut self, slot: usize, stage: &Stage, whole: bool) {
        if !self.is_stale {
            return;
        }
        let now = Instant::now();
        let map_is_due = whole || now >= self.map_due || !self.goes_on();
        let painted = stage.paint(slot, |board| {
            self.job.paint(board);
            if map_is_due { self.job.paint_map(board) } else { Ok(()) }
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
        RunState {
            run: self.number,
            phase,
            problem,
            scan: self.job.n_done(),
            n_scans: self.job.n_scans(),
            t_s: self.job.t_s(),
            pose: self.job.pose(),
            odometry: self.job.odometry(),
            tracking: self.job.tracking(),
            counters: self.job.counters(),
            stages: self.job.stages(),
            figures: self.job.figures().to_vec(),
            values: self.values.clone(),
            is_cut: stage.paint(slot, |board| board.is_cut()).unwrap_or(false),
        }
    }
}
