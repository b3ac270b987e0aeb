//! What the studio shows: a live run, possibly recorded, or a recording that is run again.

use std::path::PathBuf;

use files::{Outputs, Refusal};
use missions::{
    Intervention, LogItem, LogLevel, Mission, Outline, RecordError, Recorder, Replay, Run,
};
use run_context::RunSeed;

/// Names that are tried for the recording of a restart.
const NUMBER_MAX: u64 = 100_000;

/// What to show.
#[derive(Clone, Debug)]
pub enum Show {
    /// A mission, run live.
    Mission {
        /// The mission.
        mission: Box<Mission>,
        /// The seed of the run.
        seed: RunSeed,
        /// Where to record it; each restart is recorded in a file of its own.
        record: Option<Recordings>,
    },
    /// A recording, run again.
    Replay(PathBuf),
}

/// Where the runs of a studio are recorded: `out.mcap`, then `out-2.mcap`, `out-3.mcap` after restarts.
#[derive(Clone, Debug)]
pub struct Recordings {
    path: PathBuf,
    outputs: Outputs,
    n_begun: u64,
}

impl Recordings {
    /// The first is called `path`; `outputs` say whether it may replace what is there. Later ones replace nothing:
    /// names that are taken are left out.
    pub fn new(path: PathBuf, outputs: Outputs) -> Self {
        Self { path, outputs, n_begun: 0 }
    }

    /// Begins the next.
    fn begin(&mut self, run: &Run) -> Result<Recorder, RecordError> {
        if self.n_begun == 0 {
            let recorder = Recorder::create(&self.path, run, &self.outputs)?;
            self.n_begun = 1;
            return Ok(recorder);
        }
        let outputs = self.outputs.clone().never_replacing();
        loop {
            self.n_begun += 1;
            match Recorder::create(&files::numbered(&self.path, self.n_begun), run, &outputs) {
                Err(RecordError::Refused(Refusal::Exists { .. } | Refusal::Held { .. }))
                    if self.n_begun < NUMBER_MAX => {}
                done => return done,
            }
        }
    }
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
    Replay(Box<Replay>, Outline),
}

impl Session {
    pub(crate) fn start(show: &mut Show) -> Result<Self, String> {
        match show {
            Show::Mission { mission, seed, record } => {
                let run = Run::new(Mission::clone(mission), *seed).map_err(|e| e.to_string())?;
                let recorder = record.as_mut().map(|recordings| recordings.begin(&run));
                let recorder = recorder.transpose().map_err(|e| e.to_string())?.map(Box::new);
                Ok(Self::Live { run: Box::new(run), recorder })
            }
            Show::Replay(path) => {
                let replay = Replay::open(path).map_err(|e| e.to_string())?;
                let outline = replay.outline();
                Ok(Self::Replay(Box::new(replay), outline))
            }
        }
    }

    /// What a person should know at the beginning, a sentence each.
    pub(crate) fn notes(&self) -> Vec<(LogLevel, String)> {
        match self {
            Self::Live { recorder: Some(recorder), .. } => {
                let (path, part) = (recorder.path().display(), recorder.part().display());
                let text = format!("This run is recorded in {path} ({part} until it ends).");
                let left = recorder.left_behind().iter().map(|left| {
                    let text =
                        format!("{}, left by a program that was killed, is kept.", left.display());
                    (LogLevel::Warn, text)
                });
                std::iter::once((LogLevel::Info, text)).chain(left).collect()
            }
            Self::Live { .. } => Vec::new(),
            Self::Replay(replay, _) => {
                replay.notes().into_iter().map(|note| (LogLevel::Warn, note)).collect()
            }
        }
    }

    /// Puts a replay back to its beginning.
    pub(crate) fn rewind(&mut self) -> Result<(), String> {
        match self {
            Self::Live { .. } => Err("a run that is live has no other time".to_owned()),
            Self::Replay(replay, _) => {
                replay.seek(0, 0).map(|_there| ()).map_err(|e| e.to_string())
            }
        }
    }

    /// Writes out what was recorded; to be called once a second of real time.
    pub(crate) fn flush(&mut self) -> Result<(), String> {
        let Self::Live { recorder: place, .. } = self else { return Ok(()) };
        match place.as_mut().map_or(Ok(()), |recorder| recorder.flush()) {
            Ok(()) => Ok(()),
            Err(error) => {
                *place = None;
                Err(format!("the recording stops here: {error}"))
            }
        }
    }

    /// The file in which it is recorded.
    pub(crate) fn recording(&self) -> Option<&std::path::Path> {
        match self {
            Self::Live { recorder: Some(recorder), .. } => Some(recorder.path()),
            _ => None,
        }
    }

    pub(crate) fn is_replay(&self) -> bool {
        matches!(self, Self::Replay(..))
    }

    /// What the recording holds that is shown.
    pub(crate) fn outline(&self) -> Option<&Outline> {
        match self {
            Self::Replay(_, outline) => Some(outline),
            Self::Live { .. } => None,
        }
    }

    pub(crate) fn run(&self) -> &Run {
        match self {
            Self::Live { run, .. } => run,
            Self::Replay(replay, _) => replay.run(),
        }
    }

    pub(crate) fn run_mut(&mut self) -> &mut Run {
        match self {
            Self::Live { run, .. } => run,
            Self::Replay(replay, _) => replay.run_mut(),
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
            Self::Replay(replay, _) => {
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
            Self::Replay(..) => {
                Err("a replay shows what was recorded; nothing can be changed in it".to_owned())
            }
        }
    }

    /// Tells robots elsewhere to stand: nobody will step the run for a while.
    pub(crate) fn hold(&mut self) {
        if let Self::Live { run, .. } = self {
            run.hold_robots_elsewhere();
        }
    }

    /// Brings every robot to a stand and completes the recording, if there is one; its path. In real time
    /// where a robot is elsewhere.
    pub(crate) fn finish(self) -> Result<Option<PathBuf>, String> {
        let Self::Live { mut run, mut recorder } = self else { return Ok(None) };
        let is_real = run.mission().has_real_robot();
        while (is_real || recorder.is_some()) && run.step_to_rest() {
            if is_real {
                std::thread::sleep(missions::STEP);
            }
            if let Some(recorder) = &mut recorder {
                let said = run.drain_log();
                recorder.record(&run, &said).map_err(|error| error.to_string())?;
            }
        }
        let path = recorder.map(|recorder| recorder.finish(&run)).transpose();
        path.map_err(|error| error.to_string())
    }
}
