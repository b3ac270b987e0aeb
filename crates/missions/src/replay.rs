//! Replays: a recording run again, compared step by step.

use std::{
    collections::VecDeque,
    fs,
    path::{Path, PathBuf},
};

use mcap::read::{MessageStream, Options};
use run_context::RunSeed;

use crate::{
    intervention::{InterventionRecord, RecordedIntervention},
    mission::{Mission, MissionError},
    record::{END, EndRecord, FORMATS_READ, HASH, HEAD, Head, INTERVENTIONS},
    run::{Run, RunError},
};

/// A recording that cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is no recording of a mission.
    #[error("{}: is no recording of a mission: {problem}", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// The recorded mission cannot be loaded.
    #[error("the recorded mission cannot be loaded: {0}")]
    Mission(#[from] MissionError),
    /// The recording is of a robot elsewhere, which a replay would move.
    #[error(
        "the recording is of a robot elsewhere, which a replay would move again; --set \
         robots.link.kind=memory replays it in simulation"
    )]
    RealRobot,
    /// The recorded mission cannot be started.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// The first step at which a replay differs from its recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// The step, from 1.
    pub step: u64,
    /// Hash in the recording.
    pub recorded: u64,
    /// Hash of the replay.
    pub replayed: u64,
}

/// What a replay found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplayReport {
    /// Steps compared.
    pub steps: u64,
    /// Steps that the recording says it has; `None` when it was cut off.
    pub steps_recorded: Option<u64>,
    /// The first difference.
    pub divergence: Option<Divergence>,
    /// Interventions that this run refused, because it differs from the recorded one.
    pub interventions_refused: u64,
    /// What is missing at the end of the file, if it was cut off.
    pub truncation: Option<String>,
}

impl ReplayReport {
    /// Whether every recorded step came out the same.
    pub fn is_identical(&self) -> bool {
        self.divergence.is_none()
    }
}

/// A recording that is run again.
#[derive(Debug)]
pub struct Replay {
    head: Head,
    run: Run,
    hashes: VecDeque<(u64, u64)>,
    interventions: VecDeque<RecordedIntervention>,
    n_compared: u64,
    n_refused: u64,
    steps_recorded: Option<u64>,
    divergence: Option<Divergence>,
    truncation: Option<String>,
}

impl Replay {
    /// Reads a recording and puts its mission in place. A file that was cut off is read as far as it
    /// goes; [`ReplayReport::truncation`] says so.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] when the file is unreadable, is no recording, or holds a mission that this version
    /// cannot load.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let bytes =
            fs::read(path).map_err(|source| ReplayError::Io { path: path.to_owned(), source })?;
        Self::from_bytes(path, &bytes, &[])
    }

    /// As [`Replay::open`], with settings overridden (`table.key=value`): the same events, seed and
    /// interventions under other parameters. Differences are then expected.
    ///
    /// # Errors
    ///
    /// As [`Replay::open`].
    pub fn open_with(path: &Path, overrides: &[String]) -> Result<Self, ReplayError> {
        let bytes =
            fs::read(path).map_err(|source| ReplayError::Io { path: path.to_owned(), source })?;
        Self::from_bytes(path, &bytes, overrides)
    }

    fn from_bytes(path: &Path, bytes: &[u8], overrides: &[String]) -> Result<Self, ReplayError> {
        let wrong = |problem: String| ReplayError::NotARecording { path: path.to_owned(), problem };
        let contents = Contents::read(bytes).map_err(wrong)?;
        let head = contents.head.ok_or_else(|| wrong("it has no head".to_owned()))?;
        if !FORMATS_READ.contains(&head.format) {
            let (oldest, newest) = (FORMATS_READ.start(), FORMATS_READ.end());
            let problem = format!(
                "its layout is {}, this version reads {oldest} to {newest}; a newer version wrote it",
                head.format
            );
            return Err(wrong(problem));
        }
        let mission = Mission::parse("the recorded mission", &head.mission, overrides)?;
        if mission.has_real_robot() {
            return Err(ReplayError::RealRobot);
        }
        let run = Run::new(mission, RunSeed(head.seed))?;
        Ok(Self {
            head,
            run,
            hashes: contents.hashes,
            interventions: contents.interventions,
            n_compared: 0,
            n_refused: 0,
            steps_recorded: contents.end.map(|e| e.steps),
            divergence: None,
            truncation: contents.truncation,
        })
    }

    /// The version that wrote the recording.
    pub fn recorded_by(&self) -> &str {
        &self.head.cairn
    }

    /// The run as far as it has been repeated.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// The same, for draining logs and traces; do not interfere.
    pub fn run_mut(&mut self) -> &mut Run {
        &mut self.run
    }

    /// Repeats one step with its interventions and compares; `false` at the end of the recording.
    pub fn step(&mut self) -> bool {
        let Some((step, recorded)) = self.hashes.pop_front() else { return false };
        while let Some(next) = self.interventions.front()
            && next.step <= self.run.steps()
        {
            // What the recorded run accepted is refused only by a run that has diverged, which the hash
            // shows.
            if self.run.apply(next.intervention.clone()).is_err() {
                self.n_refused += 1;
            }
            self.interventions.pop_front();
        }
        self.run.step();
        self.n_compared += 1;
        let replayed = self.run.state_hash().value();
        if self.divergence.is_none() && (replayed != recorded || self.run.steps() != step) {
            self.divergence = Some(Divergence { step, recorded, replayed });
        }
        true
    }

    /// Repeats all of it.
    pub fn run_to_end(&mut self) -> ReplayReport {
        while self.step() {}
        self.report()
    }

    /// What was found so far.
    pub fn report(&self) -> ReplayReport {
        ReplayReport {
            steps: self.n_compared,
            steps_recorded: self.steps_recorded,
            divergence: self.divergence,
            interventions_refused: self.n_refused,
            truncation: self.truncation.clone(),
        }
    }
}

impl Replay {
    /// What is left of it in brief: all of it before the first step.
    pub fn outline(&mut self) -> crate::Outline {
        let n_steps = self.run.steps() + self.hashes.len() as u64;
        let coming = self.interventions.make_contiguous();
        crate::outline::outline(self.run.mission(), n_steps, coming)
    }
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    head: Option<Head>,
    hashes: VecDeque<(u64, u64)>,
    interventions: VecDeque<RecordedIntervention>,
    end: Option<EndRecord>,
    truncation: Option<String>,
}

impl Contents {
    /// Reads messages until the file ends or breaks off.
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut contents = Self::default();
        let options = Options::IgnoreEndMagic.into();
        let stream = MessageStream::new_with_options(bytes, options)
            .map_err(|e| format!("it is not an MCAP file ({e})"))?;
        for message in stream {
            match message {
                Ok(message) => contents.take(&message.channel.topic, &message.data)?,
                Err(error) => {
                    contents.truncation = Some(format!(
                        "the recording breaks off after {} steps ({error}); it is replayed as far as it goes",
                        contents.hashes.len()
                    ));
                    break;
                }
            }
        }
        if contents.end.is_none() && contents.truncation.is_none() {
            contents.truncation = Some(format!(
                "the recording was not finished: it ends after {} steps",
                contents.hashes.len()
            ));
        }
        Ok(contents)
    }

    fn take(&mut self, topic: &str, data: &[u8]) -> Result<(), String> {
        let bad = |e: serde_json::Error| format!("a message on {topic} makes no sense ({e})");
        match topic {
            HEAD => self.head = Some(serde_json::from_slice(data).map_err(bad)?),
            END => self.end = Some(serde_json::from_slice(data).map_err(bad)?),
            INTERVENTIONS => {
                let record: InterventionRecord = serde_json::from_slice(data).map_err(bad)?;
                self.interventions.push_back(record.into());
            }
            HASH => {
                let (step, hash) = data.split_at_checked(8).unwrap_or_default();
                let number = |b: &[u8]| <[u8; 8]>::try_from(b).map(u64::from_le_bytes);
                let pair = number(step).and_then(|s| number(hash).map(|h| (s, h)));
                self.hashes
                    .push_back(pair.map_err(|e| format!("a hash has a wrong length ({e})"))?);
            }
            _ => {}
        }
        Ok(())
    }
}
