//! Mission files: written, checked, shipped.
//!
//! A mission is a TOML file ([`file::MissionFile`]); [`Mission`] is the same after every range, name and
//! reference has been checked, in SI units. The resolved text ([`Mission::to_toml`]) has programs
//! and maps inlined and overrides applied, so that it stands alone at the head of a recording.

mod check;
mod error;
pub mod file;
mod inline;
mod moved;
pub(crate) mod parts;
pub(crate) mod plan;
mod shipped;
pub(crate) mod success;
mod template;
mod words;

use std::{
    cell::RefCell,
    path::{Path, PathBuf},
    time::Duration,
};

use run_context::{RunSeed, Stamp};

pub(crate) use check::{overlap, rectangle};
pub(crate) use error::Wrong;
pub use error::{MissionError, SettingError};
use file::MissionFile;
use inline::Shelf;
use parts::Parts;
use plan::RobotPlan;
pub use template::WordList;

/// A mission that was checked: it can be run.
///
/// ```
/// use missions::Mission;
///
/// let mission = Mission::load("doorbell", &[])?;
/// assert_eq!(mission.name(), "doorbell");
/// let slower = Mission::load("doorbell", &["robots.mind.follow.speed_mps=0.2".to_owned()])?;
/// assert!(slower.to_toml().contains("speed_mps = 0.2"));
/// # Ok::<(), missions::MissionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mission {
    file: MissionFile,
    parts: Parts,
    /// The files that it was read from.
    read_from: Vec<PathBuf>,
    /// What had to be guessed when they were read, a sentence each.
    guesses: Vec<String>,
    source: Source,
}

/// The text that a mission was read from, so that a later error can say where.
#[derive(Clone, Debug)]
struct Source {
    origin: String,
    text: String,
    overrides: Vec<String>,
}

impl Source {
    /// Of a mission that was put together in memory.
    fn none() -> Self {
        Self { origin: "the mission".to_owned(), text: String::new(), overrides: Vec::new() }
    }

    fn locate(&self, wrong: error::Wrong) -> SettingError {
        wrong.located(&self.origin, &self.text, &self.overrides)
    }
}

/// Name, title and description of a shipped mission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShippedInfo {
    /// What [`Mission::load`] takes.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// What happens.
    pub about: String,
}

/// A verdict that a shipped mission is expected to end with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedVerdict {
    /// Name of the mission.
    pub name: String,
    /// Seed of the run.
    pub seed: RunSeed,
    /// Whether it must pass.
    pub passed: bool,
}

impl Mission {
    /// Loads a shipped mission by its name, or a file by its path, with `overrides` of the form
    /// `table.key=value` applied in order.
    ///
    /// # Errors
    ///
    /// [`MissionError`]: no such mission, an unreadable file, text that is not a mission, or a value
    /// that is not allowed; each says where, what was found and what is allowed.
    pub fn load(name_or_path: &str, overrides: &[String]) -> Result<Self, MissionError> {
        if let Some(shipped) = shipped::MISSIONS.iter().find(|m| m.name == name_or_path) {
            let origin = format!("missions/{}.toml", shipped.name);
            return Self::build(&origin, shipped.text, overrides, &Shelf::Shipped);
        }
        let path = Path::new(name_or_path);
        if !path.exists() {
            let meant = settings::did_you_mean(name_or_path, Self::shipped());
            return Err(MissionError::Unknown {
                name: name_or_path.to_owned(),
                meant: meant.map(|m| format!("did you mean `{m}`? ")).unwrap_or_default(),
                shipped: Self::shipped().join(", "),
            });
        }
        let text = files::read_text(path, "the mission")?;
        let folder = path.parent().map(PathBuf::from).unwrap_or_default();
        let mut mission = Self::parse_in(&folder, name_or_path, &text, overrides)?;
        mission.read_from.insert(0, path.to_owned());
        Ok(mission)
    }

    /// Checks a mission given as text, such as one from standard input; files that it names are relative to `folder`.
    ///
    /// `origin` is what errors call the text.
    ///
    /// # Errors
    ///
    /// As [`Mission::load`].
    pub fn parse_in(
        folder: &Path,
        origin: &str,
        text: &str,
        overrides: &[String],
    ) -> Result<Self, MissionError> {
        let (read_from, guesses) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
        let shelf = Shelf::Folder { folder, read_from: &read_from, guesses: &guesses };
        let mut mission = Self::build(origin, text, overrides, &shelf)?;
        (mission.read_from, mission.guesses) = (read_from.take(), guesses.take());
        Ok(mission)
    }

    /// Checks a mission given as text; files that it names are looked for among the shipped ones.
    ///
    /// `origin` is what errors call the text.
    ///
    /// # Errors
    ///
    /// As [`Mission::load`].
    pub fn parse(origin: &str, text: &str, overrides: &[String]) -> Result<Self, MissionError> {
        Self::build(origin, text, overrides, &Shelf::Shipped)
    }

    /// The text of a mission of an older version in the words of today, and how many it had otherwise; `None` if none.
    pub(crate) fn translated(text: &str) -> Option<(String, usize)> {
        moved::translated(text)
    }

    /// A decision program or map that shipped missions name, such as `doorbell.rdpl`.
    pub fn shipped_file(name: &str) -> Option<&'static str> {
        shipped::FILES.iter().find(|file| file.path == name).and_then(shipped::ShippedFile::text)
    }

    /// The names of what [`Mission::shipped_file`] gives.
    pub fn shipped_files() -> Vec<&'static str> {
        shipped::FILES.iter().filter(|file| file.text().is_some()).map(|file| file.path).collect()
    }

    /// The names of the shipped missions; the first is the one to start with.
    pub fn shipped() -> Vec<&'static str> {
        shipped::MISSIONS.iter().map(|m| m.name).collect()
    }

    /// Names, titles and descriptions of the shipped missions, for a list.
    pub fn shipped_infos() -> Vec<ShippedInfo> {
        let info = |name: &&str| {
            let mission = Self::load(name, &[]).ok()?;
            let head = mission.file.mission;
            Some(ShippedInfo { name: head.name, title: head.title, about: head.about })
        };
        Self::shipped().iter().filter_map(info).collect()
    }

    /// The verdicts that the shipped missions are expected to end with (`missions/expected.tsv`).
    pub fn expected_verdicts() -> Vec<ExpectedVerdict> {
        let line = |line: &str| {
            let mut fields = line.split('\t');
            let name = fields.next()?.to_owned();
            let seed = RunSeed(fields.next()?.parse().ok()?);
            Some(ExpectedVerdict { name, seed, passed: fields.next()? == "pass" })
        };
        shipped::EXPECTED.lines().skip(1).filter_map(line).collect()
    }

    /// A mission file with every key, its default and a sentence on it.
    pub fn template() -> &'static str {
        template::template()
    }

    /// Every key of `[success]` and what it asks for.
    pub fn requirement_texts() -> Vec<(&'static str, &'static str)> {
        success::texts()
    }

    /// The words of every key that chooses among a few, each with what it is.
    pub fn word_lists() -> Vec<WordList> {
        template::word_lists()
    }

    /// The files that it was read from: its own, unless it was given as text, and those that it names; none for a shipped mission. What is
    /// written must not replace them.
    pub fn read_from(&self) -> &[PathBuf] {
        &self.read_from
    }

    /// Short name.
    pub fn name(&self) -> &str {
        &self.file.mission.name
    }

    /// One line for people; the name when there is no title.
    pub fn title(&self) -> &str {
        let head = &self.file.mission;
        if head.title.is_empty() { &head.name } else { &head.title }
    }

    /// What happens and what to look at.
    pub fn about(&self) -> &str {
        &self.file.mission.about
    }

    /// The seed used unless another is asked for.
    pub fn seed(&self) -> RunSeed {
        RunSeed(self.file.mission.seed)
    }

    /// When the run ends at the latest.
    pub fn duration_max(&self) -> Duration {
        self.parts.duration_max
    }

    /// Names and models of the robots, in order.
    pub fn robots(&self) -> impl Iterator<Item = (&str, &str)> {
        self.parts.robots.iter().map(|robot| (robot.name.as_str(), robot.model.name.as_str()))
    }

    /// How many requirements `[success]` has.
    pub fn n_requirements(&self) -> usize {
        self.parts.success.len()
    }

    /// How many robots it has.
    pub fn n_robots(&self) -> usize {
        self.parts.robots.len()
    }

    /// Whether a robot of it is elsewhere, at the end of a socket or a serial line: then virtual time
    /// must pass as real time does.
    pub fn has_real_robot(&self) -> bool {
        self.parts.robots.iter().any(RobotPlan::is_elsewhere)
    }

    /// The source of the decision program, if there is one.
    pub fn program_source(&self) -> Option<&str> {
        self.parts.decision.as_ref().map(|d| d.source.as_str())
    }

    /// What is allowed and yet hardly meant, a sentence each: nothing that could fail, events that never happen, robots that
    /// must arrive and are never sent, warnings of the decision program, an encoding that had to be guessed.
    pub fn warnings(&self) -> Vec<String> {
        let found = check::warnings(&self.file, &self.parts);
        self.guesses.iter().cloned().chain(found).collect()
    }

    /// The mission as TOML that stands alone: files inlined, overrides applied, defaults written
    /// out. [`Mission::parse`] makes an equal mission of it.
    pub fn to_toml(&self) -> String {
        // Every type of the file is a plain table that TOML can hold.
        toml::to_string(&self.file).unwrap_or_default()
    }

    /// The mission as written, with files inlined.
    pub fn file(&self) -> &MissionFile {
        &self.file
    }

    pub(crate) fn from_parts(file: MissionFile, parts: Parts) -> Self {
        Self { file, parts, read_from: Vec::new(), guesses: Vec::new(), source: Source::none() }
    }

    /// Puts what is wrong at its place in the text that the mission was read from.
    pub(crate) fn locate(&self, wrong: error::Wrong) -> SettingError {
        self.source.locate(wrong)
    }

    pub(crate) fn parts(&self) -> &Parts {
        &self.parts
    }

    /// The end as a stamp.
    pub(crate) fn end(&self) -> Stamp {
        Stamp::ZERO + self.parts.duration_max
    }

    fn build(
        origin: &str,
        text: &str,
        overrides: &[String],
        shelf: &Shelf<'_>,
    ) -> Result<Self, MissionError> {
        let syntax = |e: toml::de::Error| MissionError::Syntax {
            origin: origin.to_owned(),
            message: match files::Sort::of(Path::new(origin), text.as_bytes()) {
                Some(sort) if sort != files::Sort::MISSION => {
                    format!("is no mission: it is {sort}")
                }
                _ => settings::told(&e, text),
            },
        };
        let mut moved = moved::in_text(origin, text);
        moved.extend(moved::in_overrides(overrides));
        if !moved.is_empty() {
            return Err(MissionError::Moved { lines: moved });
        }
        let mut file: MissionFile = toml::from_str(text).map_err(syntax)?;
        if !overrides.is_empty() {
            let mut table: toml::Table = toml::from_str(text).map_err(syntax)?;
            overrides.iter().try_for_each(|given| settings::apply(&mut table, given))?;
            file = table.try_into().map_err(|e: toml::de::Error| MissionError::Override {
                given: overrides.join(" --set "),
                problem: unknown_override(e.to_string().trim_end(), overrides),
            })?;
        }
        let source = Source {
            origin: origin.to_owned(),
            text: text.to_owned(),
            overrides: overrides.to_vec(),
        };
        let locate = |wrong: error::Wrong| MissionError::Setting(Box::new(source.locate(wrong)));
        let files = inline::inline(&mut file, shelf).map_err(|fault| match fault {
            inline::Fault::Named(wrong) => locate(*wrong),
            inline::Fault::Within(error) => MissionError::Setting(error),
        })?;
        let parts = check::check(&file).map_err(|wrong| {
            match files.iter().find(|(key, _)| *key == wrong.key) {
                Some((_, named)) => MissionError::Setting(Box::new(wrong.in_file(named))),
                None => locate(wrong),
            }
        })?;
        Ok(Self { source, ..Self::from_parts(file, parts) })
    }
}

/// What is wrong with overrides, with the key that was meant where one of them names an unknown one.
fn unknown_override(message: &str, overrides: &[String]) -> String {
    let said = settings::clarified(message);
    let word = message.split("unknown field `").nth(1).and_then(|rest| rest.split('`').next());
    let Some(word) = word.filter(|_| !said.contains("did you mean")) else { return said };
    let is_word = |part: &str| part.split('[').next() == Some(word);
    let meant = overrides.iter().find_map(|given| {
        let key = given.split_once('=')?.0.trim();
        let n_parts = 1 + key.split('.').position(is_word)?;
        let written: Vec<&str> = key.split('.').take(n_parts).collect();
        settings::meant_key(&written.join("."), template::template())
    });
    match meant {
        Some(meant) => format!("unknown field `{word}`: did you mean `{meant}`?"),
        None => said,
    }
}

impl TryFrom<MissionFile> for Mission {
    type Error = MissionError;

    /// Checks a mission that was put together in memory; programs and maps must be inline.
    fn try_from(file: MissionFile) -> Result<Self, MissionError> {
        match check::check(&file) {
            Ok(parts) => Ok(Self::from_parts(file, parts)),
            Err(wrong) => {
                let located = wrong.located("the mission", "", &[]);
                Err(MissionError::Setting(Box::new(located)))
            }
        }
    }
}
