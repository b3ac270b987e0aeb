//! The folder that a survey fills: map, trajectory, graph, report, summary, settings; and its checkpoint.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use figures::FigureError;
use files::{Batch, Kind, Outputs, Refusal};
use geometry::Vec2;
use grid_maps::{
    Cell, MapError,
    files::{ColourScheme, map_server, write_coloured_png, write_pgm},
};
use least_squares::g2o;
use recordings::{Complaints, Recording, trajectories::write_tum};
use run_context::StateHash;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::{
    config::{ConfigError, SurveyConfig},
    mapper::SurveyError,
    outcome::{Figure, Judgement, Known, Outcome},
    page::{ReportInput, method_name, report},
};

/// Name of the folder of a survey under way.
pub const CHECKPOINT: &str = "checkpoint";
/// Name of the summary: where it is, there are results.
pub const SUMMARY: &str = "summary.json";
const STATE: &str = "state.json";
const SETTINGS: &str = "settings.toml";
const FORMAT: u32 = 1;

/// Results that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// A file is not written.
    #[error(transparent)]
    Write(#[from] Refusal),
    /// The map cannot be drawn.
    #[error("the map cannot be drawn: {0}")]
    Map(#[from] MapError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The results cannot be made.
    #[error(transparent)]
    Survey(#[from] SurveyError),
}

/// A checkpoint that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// There is none.
    #[error("{}: there is no checkpoint of an unfinished survey to go on from", folder.display())]
    Absent {
        /// Where it was looked for.
        folder: PathBuf,
    },
    /// It cannot be read.
    #[error("{}: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: String,
    },
    /// It is of another recording.
    #[error("{}: is the checkpoint of another recording; give the log that it was made from", folder.display())]
    AnotherLog {
        /// The folder.
        folder: PathBuf,
    },
    /// Its settings are refused.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The survey did not repeat itself.
    #[error(
        "at scan {scan} the survey is not where the checkpoint is: it was made by another version or on another \
         machine; begin again without --resume"
    )]
    Different {
        /// How many scans were done.
        scan: usize,
    },
}

/// What results are written from.
#[derive(Clone, Copy, Debug)]
pub struct FolderInput<'a> {
    /// The recording's name.
    pub name: &'a str,
    /// What it was read as, and what it holds, in a sentence.
    pub source: &'a str,
    /// The recording.
    pub recording: &'a Recording,
    /// How it was set up.
    pub config: &'a SurveyConfig,
    /// What the results are judged by.
    pub known: &'a Known,
    /// What was wrong with the files, by file.
    pub complaints: &'a [(String, Complaints)],
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// How far the results are from what is known.
    pub judgement: Judgement,
    /// Everything that is one number.
    pub figures: Vec<Figure>,
    /// The same as one object, as it stands in the file.
    pub summary: Value,
    /// Names of the files.
    pub names: Vec<String>,
}

/// Where a survey under way was.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SurveyState {
    format: u32,
    /// Tells recordings apart.
    pub recording: String,
    /// Scans done.
    pub n_done: usize,
    /// All scans.
    pub n_scans: usize,
    /// Hash of all poses so far.
    pub poses: String,
}

/// Whether the results of a survey may go into `folder`; to be asked before it begins.
///
/// # Errors
///
/// [`Refusal`] of the first file that stands in the way.
pub fn check_results(folder: &Path, outputs: &Outputs) -> Result<(), Refusal> {
    outputs.check_folder(folder, &NAMES)?;
    // Whatever else is in a folder of that name, a checkpoint would be written over it.
    let checkpoint = folder.join(CHECKPOINT);
    let Ok(entries) = fs::read_dir(&checkpoint) else {
        return match fs::symlink_metadata(&checkpoint) {
            Ok(_) => Outputs::new(true).check_folder(&checkpoint, &[]),
            Err(_) => Ok(()),
        };
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let path = entry.path();
        match kind_in_checkpoint(&name.to_string_lossy()) {
            None => return Err(Refusal::Foreign { path, kind: "part of a checkpoint" }),
            Some(_) if !outputs.replaces() => return Err(Refusal::Exists { path }),
            Some(kind) => outputs.check(&path, kind)?,
        }
    }
    Ok(())
}

/// What a file in a checkpoint is by its name, or by the name that it had not yet when its program was killed.
fn kind_in_checkpoint(name: &str) -> Option<Kind> {
    let whole = |known: &str| {
        let rest = name.strip_prefix(known);
        rest.is_some_and(|rest| {
            rest.is_empty()
                || (rest.starts_with('.')
                    && Path::new(rest).extension().is_some_and(|e| e == "part"))
        })
    };
    let names = NAMES.iter().chain(&[(STATE, Kind::JSON)]);
    names.into_iter().find(|(known, _)| whole(known)).map(|(_, kind)| *kind)
}

/// Writes all results into `folder`, beside their names first, and renames them at the end.
///
/// # Errors
///
/// [`FolderError`]; then nothing of it is left.
pub fn write_results(
    folder: &Path,
    input: &FolderInput<'_>,
    outcome: &Outcome,
    outputs: &Outputs,
) -> Result<Written, FolderError> {
    write(folder, input, outcome, None, outputs)
}

/// Writes the results so far into the checkpoint of `folder`, with what is needed to go on.
///
/// # Errors
///
/// [`FolderError`]; the checkpoint before it stays.
pub fn write_checkpoint(
    folder: &Path,
    input: &FolderInput<'_>,
    outcome: &Outcome,
) -> Result<(), FolderError> {
    let state = SurveyState {
        format: FORMAT,
        recording: recording_hash(input.recording),
        n_done: outcome.trajectory.len(),
        n_scans: outcome.n_scans,
        poses: pose_hash(outcome),
    };
    let state = json!(state).to_string();
    files::make_folder(folder)?;
    // The checkpoint before this one is our own; that nothing else is there was seen before the survey began.
    let outputs = Outputs::new(true);
    let folder = folder.join(CHECKPOINT);
    write(&folder, input, outcome, Some(state.as_bytes()), &outputs).map(|_written| ())
}

/// Removes the checkpoint of `folder`, if there is one: the files that a checkpoint has, and the folder if it is empty
/// then.
pub fn remove_checkpoint(folder: &Path) {
    let checkpoint = folder.join(CHECKPOINT);
    let Ok(entries) = fs::read_dir(&checkpoint) else { return };
    for entry in entries.flatten() {
        if kind_in_checkpoint(&entry.file_name().to_string_lossy()).is_some() {
            let _stays = fs::remove_file(entry.path());
        }
    }
    let _used = fs::remove_dir(checkpoint);
}

/// The state and settings of the unfinished survey in `folder`.
///
/// # Errors
///
/// [`ResumeError`] when there is none, or it is not of this recording.
pub fn read_checkpoint(
    folder: &Path,
    recording: &Recording,
) -> Result<(SurveyState, SurveyConfig), ResumeError> {
    let checkpoint = folder.join(CHECKPOINT);
    let path = checkpoint.join(STATE);
    let damaged =
        |path: &Path, problem: String| ResumeError::Damaged { path: path.to_owned(), problem };
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(ResumeError::Absent { folder: folder.to_owned() });
        }
        Err(error) => return Err(damaged(&path, error.to_string())),
    };
    let state: SurveyState =
        serde_json::from_str(&text).map_err(|e| damaged(&path, e.to_string()))?;
    if state.recording != recording_hash(recording) {
        return Err(ResumeError::AnotherLog { folder: folder.to_owned() });
    }
    let path = checkpoint.join(SETTINGS);
    let settings = fs::read_to_string(&path).map_err(|e| damaged(&path, e.to_string()))?;
    let config = SurveyConfig::parse(&path.display().to_string(), &settings, &[])?;
    Ok((state, config))
}

impl SurveyState {
    /// Whether a survey that has taken as many scans is at the same poses, bit by bit.
    ///
    /// # Errors
    ///
    /// [`ResumeError::Different`].
    pub fn check(&self, outcome: &Outcome) -> Result<(), ResumeError> {
        let same = outcome.trajectory.len() == self.n_done && pose_hash(outcome) == self.poses;
        if same { Ok(()) } else { Err(ResumeError::Different { scan: self.n_done }) }
    }
}

/// Tells recordings apart: a hash of every range and odometry pose.
pub fn recording_hash(recording: &Recording) -> String {
    let mut hash = StateHash::new();
    hash.absorb_u64(recording.scans.len() as u64);
    for scan in &recording.scans {
        hash.absorb_u64(scan.stamp.as_nanos());
        let odom = scan.odom_from_base.into_iter().flat_map(|p| [p.x_m, p.y_m, p.yaw_rad]);
        // Silence is infinite, so bits are absorbed, not numbers.
        odom.chain(scan.ranges_m.iter().copied()).for_each(|v| hash.absorb_u64(v.to_bits()));
    }
    hash.to_string()
}

fn pose_hash(outcome: &Outcome) -> String {
    let mut hash = StateHash::new();
    for p in &outcome.trajectory {
        for value in [p.pose.x_m, p.pose.y_m, p.pose.yaw_rad] {
            hash.absorb_u64(value.to_bits());
        }
    }
    hash.to_string()
}

/// Everything that results consist of.
const NAMES: [(&str, Kind); 8] = [
    ("map.pgm", Kind::PGM),
    ("map.yaml", Kind::MAP_YAML),
    ("map.png", Kind::PNG),
    ("trajectory.tum", Kind::TRAJECTORY),
    ("graph.g2o", Kind::GRAPH),
    ("report.html", Kind::HTML),
    (SETTINGS, Kind::SETTINGS),
    (SUMMARY, Kind::JSON),
];

fn write(
    folder: &Path,
    input: &FolderInput<'_>,
    outcome: &Outcome,
    state: Option<&[u8]>,
    outputs: &Outputs,
) -> Result<Written, FolderError> {
    let window = outcome.map.window()?;
    let lattice = outcome.map.lattice();
    let thresholds = input.config.map().thresholds();
    let states = window.map(|prob| thresholds.state_of(prob));
    let (image, yaml) = map_server::draw_states(&states, lattice, "map.pgm")?;
    let picture = write_coloured_png(&window, &ColourScheme::default())?;
    let area = window.area();
    let end = Cell {
        column: area.min.column + area.width as i32,
        row: area.min.row + area.height as i32,
    };
    let corners: [Vec2; 2] = [lattice.corner_of(area.min), lattice.corner_of(end)];
    let judgement = outcome.judge(input.recording, input.known);
    let figures = outcome.figures(&judgement, input.config.map())?;
    let page = report(&ReportInput {
        name: input.name,
        source: input.source,
        config: input.config,
        outcome,
        judgement: &judgement,
        complaints: input.complaints,
        picture: &picture,
        corners,
    })?;
    let summary = summary(input, outcome, &figures);
    let mut contents: Vec<(&str, Vec<u8>)> = vec![
        ("map.pgm", write_pgm(&image)),
        ("map.yaml", yaml.to_text().into_bytes()),
        ("map.png", picture),
        ("trajectory.tum", write_tum(&outcome.trajectory, input.recording.epoch_ns).into_bytes()),
        ("report.html", page.to_html().into_bytes()),
        (SETTINGS, input.config.to_toml().into_bytes()),
    ];
    if let Some((graph, _)) = &outcome.graph {
        let ids = g2o::Ids::consecutive(graph.poses().len());
        contents.push(("graph.g2o", g2o::write(graph, &ids).into_bytes()));
    }
    if let Some(state) = state {
        contents.push((STATE, state.to_vec()));
    }
    // The summary takes its name last: where it is, everything is.
    contents.push((SUMMARY, format!("{summary:#}\n").into_bytes()));
    let mut batch = Batch::new(folder, outputs)?;
    for (name, bytes) in &contents {
        let kind = kind_in_checkpoint(name).unwrap_or(Kind::JSON);
        batch.put(name, kind, bytes)?;
    }
    batch.commit()?;
    let names = contents.iter().map(|(name, _)| (*name).to_owned()).collect();
    Ok(Written { judgement, figures, summary, names })
}

fn summary(input: &FolderInput<'_>, outcome: &Outcome, figures: &[Figure]) -> Value {
    let figures: Map<String, Value> =
        figures.iter().map(|f| (f.name.clone(), json!(f.value))).collect();
    let stages: Map<String, Value> = outcome
        .stages
        .iter()
        .map(|(name, spent)| {
            let figures = json!({
                "times": spent.n_times,
                "total_s": spent.total.as_secs_f64(),
                "longest_s": spent.longest.as_secs_f64(),
            });
            ((*name).to_owned(), figures)
        })
        .collect();
    let complaints: Map<String, Value> = input
        .complaints
        .iter()
        .map(|(file, complaints)| {
            let kinds: Vec<Value> = complaints
                .counts()
                .map(|(what, done, n)| {
                    json!({"what": what.to_string(), "done": done.to_string(), "number": n})
                })
                .collect();
            let first: Vec<String> =
                complaints.kept().iter().take(20).map(ToString::to_string).collect();
            let object = json!({"total": complaints.total(), "kinds": kinds, "first": first});
            (file.clone(), object)
        })
        .collect();
    let parameters: BTreeMap<&str, String> = SurveyConfig::keys()
        .filter_map(|key| Some((key.name, input.config.get(key.name)?)))
        .collect();
    json!({
        "cairn": env!("CARGO_PKG_VERSION"),
        "recording": input.name,
        "source": input.source,
        "method": method_name(outcome.method, outcome.mode),
        "partial": !outcome.is_whole(),
        "scans_done": outcome.trajectory.len(),
        "scans": outcome.n_scans,
        "figures": figures,
        "stages": stages,
        "complaints": complaints,
        "parameters": parameters,
    })
}
