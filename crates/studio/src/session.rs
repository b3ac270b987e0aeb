//! What the studio shows: a live run, possibly recorded, or a recording that is run again.

use std::path::PathBuf;

use missions::{Intervention, LogItem, Mission, Recorder, Replay, Run};
use run_context::RunSeed;

/// What to show.
#[derive(Clone, Debug)]
pub enum Show {
    /// A mission, run live.
    Mission {
        /// The mission.
        mission: Box<Mission>,
        /// The seed of the run.
        seed: RunSeed,
        /// Where to record it; a restart ends the recording.
        record: Option<PathBuf>,
    },
    /// A recording, run again.
    Replay(PathBuf),
}

impl Show {
    pub(crate) fn is_replay(&self) -> bool {
        matches!(self, Self::Replay(_))
    }
}

/// A show under way. Its errors are sentences for the person at the page.
#[derive(Debug)]
pub(crate) enum Session {
    Live { run: Box<Run>, recorder: Option<Box<Recorder>> },
    Replay(Box<Replay>),
}

impl Session {
    pub(crate) fn start(show: &Show) -> Result<Self, String> {
        match show {
            Show::Mission { mission, seed, record } => {
                let run = Run::new(Mission::clone(mission), *seed).map_err(|e| e.to_string())?;
                let recorder = record.as_deref().map(|path| Recorder::create(path, &run));
                let recorder = recorder.transpose().map_err(|e| e.to_string())?.map(Box::new);
                Ok(Self::Live { run: Box::new(run), recorder })
            }
            Show::Replay(path) => {
                let replay = Replay::open(path).map_err(|e| e.to_string())?;
                Ok(Self::Replay(Box::new(replay)))
            }
        }
    }

    pub(crate) fn run(&self) -> &Run {
        match self {
            Self::Live { run, .. } => run,
            Self::Replay(replay) => replay.run(),
        }
    }

    pub(crate) fn run_mut(&mut self) -> &mut Run {
        match self {
            Self::Live { run, .. } => run,
            Self::Replay(replay) => replay.run_mut(),
        }
    }

    /// One step; what it had to say is appended to `log`. `false` at the end of a recording.
    pub(crate) fn step(&mut self, log: &mut Vec<LogItem>) -> Result<bool, String> {
        match self {
            Self::Live { run, recorder } => {
                run.step();
                let said = run.drain_log();
                let recorded = recorder.as_mut().map(|recorder| recorder.record(run, &said));
                log.extend(said);
                if let Some(Err(error)) = recorded {
                    *recorder = None;
                    return Err(format!("the recording stops here: {error}"));
                }
                Ok(true)
            }
            Self::Replay(replay) => {
                let more = replay.step();
                log.extend(replay.run_mut().drain_log());
                Ok(more)
            }
        }
    }

    /// Lets a person interfere.
    pub(crate) fn apply(&mut self, intervention: Intervention) -> Result<(), String> {
        match self {
            Self::Live { run, .. } => run.apply(intervention).map_err(|error| error.to_string()),
            Self::Replay(_) => {
                Err("a replay shows what was recorded; nothing can be changed in it".to_owned())
            }
        }
    }

    /// Completes the recording, if there is one; its path.
    pub(crate) fn finish(self) -> Result<Option<PathBuf>, String> {
        match self {
            Self::Live { run, recorder: Some(recorder) } => {
                recorder.finish(&run).map(Some).map_err(|error| error.to_string())
            }
            _ => Ok(None),
        }
    }
}
