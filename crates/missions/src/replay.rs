//! Replays: a recording run again, compared step by step.

use std::path::{Path, PathBuf};

use files::{InputError, Limit};
use recordings::mcap_file::{Integrity, MAGIC, messages};
use run_context::RunSeed;

use crate::{
    intervention::{Intervention, InterventionRecord, RecordedIntervention},
    mission::{Mission, MissionError},
    record::{BUILD, END, EndRecord, FORMATS_READ, HASH, HEAD, Head, INTERVENTIONS},
    run::{Run, RunError},
};

/// Problems of a file that are named.
const DAMAGE_MAX: usize = 8;

/// A recording that cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The file cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
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
         robots.line.kind=memory replays it in simulation"
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
    /// What is damaged in the file, a sentence each; then a difference says nothing about the run.
    pub damage: Vec<String>,
    /// The program that wrote the recording, if it is another build than this one: the same steps are promised only
    /// within one build.
    pub other_build: Option<String>,
    /// Interventions that were repeated.
    pub interventions_repeated: u64,
    /// Interventions that this run refused, because it differs from the recorded one: step, what and why.
    pub interventions_refused: Vec<String>,
    /// Interventions for which this run ended too early.
    pub interventions_left: u64,
    /// Interventions that a run with changed settings does not repeat: the order to stand with which the recorded run
    /// ended. It would never come to a verdict of its own.
    pub interventions_not_repeated: u64,
    /// What is missing at the end of the file, if it was cut off.
    pub truncation: Option<String>,
}

impl ReplayReport {
    /// Whether every recorded step came out the same: all of those that the file says it has, in a file that is not
    /// damaged.
    pub fn is_identical(&self) -> bool {
        self.divergence.is_none()
            && self.damage.is_empty()
            && self.steps_recorded.is_none_or(|recorded| recorded == self.steps)
    }
}

/// How far [`Replay::seek`] got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seek {
    /// The run is at the target.
    There,
    /// So many steps are left until it is; ask again.
    OnTheWay {
        /// Steps.
        steps_left: u64,
    },
}

/// A recording that is run again.
#[derive(Debug)]
pub struct Replay {
    head: Head,
    run: Run,
    /// The recorded hash after each step, from the first on.
    hashes: Vec<u64>,
    interventions: Vec<RecordedIntervention>,
    /// Of the interventions, how many were tried.
    n_tried: usize,
    refused: Vec<String>,
    /// Of those tried, how many were left out because settings were changed.
    n_left_out: u64,
    n_compared: u64,
    steps_recorded: Option<u64>,
    divergence: Option<Divergence>,
    damage: Vec<String>,
    truncation: Option<String>,
    /// Whether settings were changed: then it runs to its own verdict.
    is_changed: bool,
    /// Keys and words of its mission that are called otherwise today.
    n_old_words: usize,
}

impl Replay {
    /// Reads a recording and puts its mission in place. A file that was cut off or damaged is read as far as it
    /// goes; [`Replay::notes`] and [`ReplayReport`] say so.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] when the file is unreadable, is no recording, or holds a mission that this version
    /// cannot load.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        Self::open_with(path, &[])
    }

    /// As [`Replay::open`], with settings overridden (`table.key=value`): the same events and interventions
    /// under other parameters, and the same seed unless `mission.seed` is among them. Differences are then expected, and it runs on to a verdict of its own; the
    /// order to stand with which the recorded run ended ([`Intervention::Halt`]) is left out.
    ///
    /// # Errors
    ///
    /// As [`Replay::open`].
    pub fn open_with(path: &Path, overrides: &[String]) -> Result<Self, ReplayError> {
        let bytes = files::read(path, "the recording", Limit::LOG, &mut |_, _| ())?;
        Self::from_bytes(path, &bytes, overrides)
    }

    /// As [`Replay::open_with`], with the bytes of the file read already; `path` is what errors call them.
    ///
    /// # Errors
    ///
    /// As [`Replay::open`].
    pub fn from_bytes(
        path: &Path,
        bytes: &[u8],
        overrides: &[String],
    ) -> Result<Self, ReplayError> {
        let contents = Contents::read(bytes);
        let wrong = |problem: String| ReplayError::NotARecording {
            path: path.to_owned(),
            problem: contents.explain(problem),
        };
        if !bytes.starts_with(MAGIC) {
            return Err(match files::Sort::of(path, bytes) {
                Some(sort) if sort != files::Sort::RECORDING => ReplayError::NotARecording {
                    path: path.to_owned(),
                    problem: format!("it is {sort}"),
                },
                _ => wrong("it is not an MCAP file".to_owned()),
            });
        }
        let Some(head) = contents.head.clone() else {
            return Err(wrong(contents.without_head()));
        };
        if !FORMATS_READ.contains(&head.format) {
            let (oldest, newest) = (FORMATS_READ.start(), FORMATS_READ.end());
            let problem = format!(
                "its layout is {}, this version reads {oldest} to {newest}; a newer version wrote it",
                head.format
            );
            return Err(wrong(problem));
        }
        // A recording stays one, whatever keys are called today.
        let (text, n_old_words) =
            Mission::translated(&head.mission).unwrap_or_else(|| (head.mission.clone(), 0));
        let mission = Mission::parse("the recorded mission", &text, overrides);
        let mission = match mission {
            // A mission that was loaded when it was recorded is unreadable because its text is not what it was.
            Err(e) if overrides.is_empty() && !contents.damage.is_empty() => {
                return Err(wrong(format!("its mission cannot be loaded ({e})")));
            }
            mission => mission?,
        };
        if mission.has_real_robot() {
            return Err(ReplayError::RealRobot);
        }
        // A seed that is asked for is one of the changed settings.
        let recorded = RunSeed(head.seed);
        let seed = settings::setter(overrides, "mission.seed").map_or(recorded, |_| mission.seed());
        let run = Run::new(mission, seed)?;
        Ok(Self {
            head,
            run,
            hashes: contents.hashes,
            interventions: contents.interventions,
            n_tried: 0,
            refused: Vec::new(),
            n_left_out: 0,
            n_compared: 0,
            steps_recorded: contents.end.map(|e| e.steps),
            divergence: None,
            damage: contents.damage,
            truncation: contents.truncation,
            is_changed: !overrides.is_empty(),
            n_old_words,
        })
    }

    /// The version that wrote the recording.
    pub fn recorded_by(&self) -> &str {
        &self.head.cairn
    }

    /// What is to be known before it is looked at: whether the file is damaged, not finished, or of another build.
    pub fn notes(&self) -> Vec<String> {
        let damage = self.damage.iter().map(|found| format!("The recording is damaged: {found}."));
        let cut = self.truncation.iter().map(|cut| format!("The recording is not whole: {cut}."));
        let build = self.other_build().into_iter().map(|other| {
            format!("It was recorded by {other}; this is another build, in which steps may come out differently.")
        });
        damage.chain(cut).chain(build).collect()
    }

    /// Who wrote the recording, if it was not this build.
    fn other_build(&self) -> Option<String> {
        let Head { cairn, build, format, .. } = &self.head;
        let words = match self.n_old_words {
            0 => String::new(),
            n => format!(
                ", in whose mission {n} keys or words had other names, which were read as those of today"
            ),
        };
        match build.as_str() {
            BUILD => None,
            "" => Some(format!("Cairn {cairn}, an earlier build (layout {format}){words}")),
            build => Some(format!("Cairn {cairn}, build {build}{words}")),
        }
    }

    /// The run as far as it has been repeated.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// The same, for draining logs and traces; do not interfere.
    pub fn run_mut(&mut self) -> &mut Run {
        &mut self.run
    }

    /// Steps that the recording holds.
    pub fn n_steps(&self) -> u64 {
        self.hashes.len() as u64
    }

    /// Repeats one step with its interventions and compares; `false` at the end: of the recording, or, with changed
    /// settings, of the run.
    pub fn step(&mut self) -> bool {
        let at = self.run.steps();
        let recorded = usize::try_from(at).ok().and_then(|at| self.hashes.get(at).copied());
        let goes_on = if self.is_changed {
            // Its greatest duration bounds every mission; that this one ends is not left to its verdict alone.
            self.run.finished().is_none() && self.run.now() <= self.run.mission().end()
        } else {
            recorded.is_some()
        };
        if !goes_on {
            return false;
        }
        while let Some(next) = self.interventions.get(self.n_tried)
            && next.step <= at
        {
            self.n_tried += 1;
            if self.is_changed && matches!(next.intervention, Intervention::Halt) {
                self.n_left_out += 1;
                continue;
            }
            // What the recorded run accepted is refused only by a run that differs from it.
            if let Err(why) = self.run.apply(next.intervention.clone()) {
                self.refused.push(format!("at {:.2} s: {why}", at as f64 * 0.01));
            }
        }
        self.run.step();
        if let Some(recorded) = recorded {
            self.n_compared = self.n_compared.max(at + 1);
            let replayed = self.run.state_hash().value();
            if replayed != recorded && self.divergence.is_none() {
                self.divergence = Some(Divergence { step: at + 1, recorded, replayed });
            }
        }
        true
    }

    /// Goes to the state after `target` steps (at most [`Replay::n_steps`]), forwards or backwards, taking no more
    /// than `steps_max` steps now: a caller that must not be late asks again until it is [`Seek::There`].
    ///
    /// The state at a step is the same however it was reached. The way back leads over the beginning: it costs as
    /// many steps as the target has. The log and the packets of the steps on the way are there to be drained, as ever.
    ///
    /// # Errors
    ///
    /// [`ReplayError::Run`] when the mission cannot be started again; the replay stays where it is.
    pub fn seek(&mut self, target: u64, steps_max: u64) -> Result<Seek, ReplayError> {
        let target = target.min(self.n_steps());
        if target < self.run.steps() {
            self.run = Run::new(self.run.mission().clone(), RunSeed(self.head.seed))?;
            self.n_tried = 0;
            self.refused.clear();
            self.n_left_out = 0;
        }
        for _ in 0..steps_max {
            if self.run.steps() >= target || !self.step() {
                break;
            }
        }
        match target.saturating_sub(self.run.steps()) {
            0 => Ok(Seek::There),
            steps_left => Ok(Seek::OnTheWay { steps_left }),
        }
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
            damage: self.damage.clone(),
            other_build: self.other_build(),
            interventions_repeated: (self.n_tried - self.refused.len()) as u64 - self.n_left_out,
            interventions_refused: self.refused.clone(),
            interventions_left: (self.interventions.len() - self.n_tried) as u64,
            interventions_not_repeated: self.n_left_out,
            truncation: self.truncation.clone(),
        }
    }
}

impl Replay {
    /// All of it in brief.
    pub fn outline(&self) -> crate::Outline {
        crate::outline::outline(self.run.mission(), self.n_steps(), &self.interventions)
    }
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    head: Option<Head>,
    hashes: Vec<u64>,
    interventions: Vec<RecordedIntervention>,
    end: Option<EndRecord>,
    damage: Vec<String>,
    truncation: Option<String>,
    n_messages: u64,
    n_scans: u64,
}

impl Contents {
    /// Reads messages as far as there are any, and what is wrong with the file.
    fn read(bytes: &[u8]) -> Self {
        let integrity = Integrity::of(bytes);
        let mut contents = Self::default();
        contents.damage.extend(integrity.damage.iter().map(ToString::to_string));
        for message in messages(bytes) {
            contents.n_messages += 1;
            if let Err(problem) = contents.take(message.topic, message.data) {
                contents.say(format!("{problem} (byte {})", message.byte));
            }
        }
        let n = contents.hashes.len() as u64;
        match &contents.end {
            Some(end) if end.steps != n => {
                let said = end.steps;
                contents.say(format!("it says that it has {said} steps, but {n} are in it"));
            }
            Some(_) => {}
            None if integrity.finished => {
                contents.truncation =
                    Some(format!("it ends after {n} steps without the word of how the run ended"));
            }
            None => {
                contents.truncation = Some(format!(
                    "it was not finished, as when the program is killed: it ends after {n} steps ({:.2} s) and is \
                     replayed so far",
                    n as f64 * 0.01
                ));
            }
        }
        contents
    }

    fn say(&mut self, problem: String) {
        if self.damage.len() < DAMAGE_MAX {
            self.damage.push(problem);
        }
    }

    /// A problem with what is known to be damaged.
    fn explain(&self, problem: String) -> String {
        match self.damage.first() {
            Some(damage) if !problem.contains("MCAP") => {
                format!("{problem}; the file is damaged: {damage}")
            }
            _ => problem,
        }
    }

    /// What is there when the mission is not.
    fn without_head(&self) -> String {
        let n = self.n_messages;
        let scans = match self.n_scans {
            0 => String::new(),
            n => format!("; its {n} scans can be mapped: cairn map"),
        };
        format!(
            "it has no head, so its mission and seed are not known ({n} messages are in it{scans})"
        )
    }

    fn take(&mut self, topic: &str, data: &[u8]) -> Result<(), String> {
        let bad = |e: serde_json::Error| format!("a message on {topic} makes no sense: {e}");
        match topic {
            HEAD => self.head = Some(serde_json::from_slice(data).map_err(bad)?),
            END => self.end = Some(serde_json::from_slice(data).map_err(bad)?),
            INTERVENTIONS => {
                let record: InterventionRecord = serde_json::from_slice(data).map_err(bad)?;
                self.interventions.push(record.into());
            }
            HASH => {
                let Ok(pair) = <[u8; 16]>::try_from(data) else {
                    return Err(format!("a hash of {} bytes instead of 16", data.len()));
                };
                let (step, hash) = pair.split_at(8);
                let number = |b: &[u8]| b.first_chunk().map_or(0, |b| u64::from_le_bytes(*b));
                let (step, due) = (number(step), self.hashes.len() as u64 + 1);
                self.hashes.push(number(hash));
                if step != due {
                    return Err(format!(
                        "where the hash of step {due} is due stands one of step {step}"
                    ));
                }
            }
            _ => self.n_scans += u64::from(topic.starts_with("/cairn/scan/")),
        }
        Ok(())
    }
}
