//! What `cairn map` is given: files, settings, values.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use anyhow::{Context, bail};
use grid_maps::{
    EvidenceModel,
    files::{MapYaml, map_server, read_pgm, read_png},
};
use recordings::{Complaints, Format, Loaded, ReadOptions, Recording, Rig, Takes};
use surveys::{Known, SurveyConfig, SurveyPrior};

use super::args::Args;
use crate::given;

/// Logs on standard input are read whole; far larger ones than any public log still fit.
const STDIN_BYTES_MAX: u64 = 1 << 30;

/// Everything that was read.
pub(super) struct Inputs {
    pub(super) name: String,
    /// What the log was read as, and what it holds.
    pub(super) source: String,
    pub(super) format: Format,
    pub(super) recording: Arc<Recording>,
    pub(super) known: Known,
    pub(super) complaints: Vec<(String, Complaints)>,
    /// What was found out while reading, a line each.
    pub(super) notes: Vec<String>,
}

impl Inputs {
    pub(super) fn read(args: &Args, log: &Path) -> anyhow::Result<Self> {
        let bytes = file(log, "the recording")?;
        let second = args.log2.as_deref().map(|path| file(path, "the second file")).transpose()?;
        let truth = args.truth.as_deref().map(|path| file(path, "the true poses")).transpose()?;
        let options = ReadOptions {
            robot: args.robot.as_deref(),
            poses: second.as_deref(),
            truth: truth.as_deref().or(second.as_deref()),
            ring: args.ring.clone().unwrap_or_default(),
            ..ReadOptions::default()
        };
        let Loaded { recording, format, complaints } =
            recordings::read(&log.display().to_string(), &bytes, &options)
                .map_err(|e| crate::input::another(log, &bytes, "robot's log", e))?;
        drop(bytes);
        if let (Some(path), None) = (&args.log2, format.second()) {
            bail!("{}: a {format} has no second file; leave {} out", log.display(), path.display());
        }
        if let (Some(robot), false) = (&args.robot, format.understands(Takes::Robot)) {
            let what = "only a recording (MCAP) names its robots";
            bail!("{}: {what}, and a {format} does not: leave --robot {robot} out", log.display());
        }
        if let (Some(ring), false) = (&args.ring, format.understands(Takes::Ring)) {
            let what = format!("a {format} says itself what took its readings");
            bail!("{}: {what}: leave --ring {} out", log.display(), ring.name());
        }
        let name = file_name(log);
        let mut complaints = vec![(name.clone(), complaints)];
        let mut known = Known::default();
        let mut notes = Vec::new();
        if let (Some(path), Some(bytes)) = (&args.truth, &truth)
            && recording.truth.is_empty()
        {
            let read = surveys::read_truth(&path.display().to_string(), bytes, &recording)?;
            known.truth = read.poses;
            complaints.push((file_name(path), read.complaints));
        }
        if let Some(path) = &args.relations {
            let bytes = file(path, "the relations")?;
            let shown = path.display().to_string();
            let shift_s = args.relations_shift_s;
            let read = surveys::read_known_relations(&shown, &bytes, &recording, shift_s)?;
            if read.clock_shift_s.abs() > 1e-3 {
                known.clock_is_free = shift_s.is_none();
                notes.push(format!(
                    "The relations' clock is about {:.1} s off the log's; set right.",
                    -read.clock_shift_s
                ));
            }
            known.relations = read.relations;
            complaints.push((file_name(path), read.complaints));
        }
        let source = source(&recording, format);
        let recording = Arc::new(recording);
        Ok(Self { name, source, format, recording, known, complaints, notes })
    }

    /// The map that is known already, if one was given.
    pub(super) fn prior(args: &Args, config: &SurveyConfig) -> anyhow::Result<Option<SurveyPrior>> {
        let Some((path, yaml)) = prior_yaml(args)? else { return Ok(None) };
        let name = path.display();
        let image_path = beside(path, &yaml);
        let what = "the known map's picture";
        let bytes = files::read(&image_path, what, files::Limit::PICTURE, &mut |_, _| ())?;
        let is_png = bytes.starts_with(b"\x89PNG");
        let image = if is_png { read_png(&bytes) } else { read_pgm(&bytes) };
        let image = image.with_context(|| image_path.display().to_string())?;
        let settings = config.map();
        let model = EvidenceModel {
            hit_logodds: settings.hit_logodds,
            miss_logodds: settings.miss_logodds,
            min_logodds: -settings.limit_logodds,
            max_logodds: settings.limit_logodds,
        };
        let map = map_server::read(&image, &yaml)
            .and_then(|served| served.to_log_odds(model))
            .with_context(|| name.to_string())?;
        Ok(Some(SurveyPrior { map, start: args.start }))
    }
}

/// The settings: file, then the options with names of their own, then `--set`.
///
/// With them, what the command line sets, as `table.key=value`.
pub(super) fn config(args: &Args) -> anyhow::Result<(SurveyConfig, Vec<String>)> {
    let (origin, text) = match &args.config {
        Some(path) => {
            let text = files::read_text(path, "the settings")?;
            (path.display().to_string(), text)
        }
        None => ("the settings".to_owned(), String::new()),
    };
    let mut overrides = Vec::new();
    overrides.extend(args.method.iter().map(|word| format!("survey.method={word}")));
    overrides.extend(args.mode.iter().map(|word| format!("survey.mode={word}")));
    overrides.extend(args.overrides.iter().cloned());
    Ok((SurveyConfig::parse(&origin, &text, &overrides)?, overrides))
}

/// Refuses what was asked for on the command line and this recording's survey would not obey.
pub(super) fn refuse_unread(
    config: &SurveyConfig,
    asked: &[String],
    inputs: &Inputs,
) -> anyhow::Result<()> {
    let unread = config.unread(&inputs.recording.rig, asked);
    if !unread.is_empty() {
        bail!("{}: {}", inputs.name, unread.join("; "));
    }
    Ok(())
}

/// The log's name without its endings, with `-map`.
pub(super) fn default_folder(log: &Path) -> PathBuf {
    if given::is_stdin(log) {
        return PathBuf::from("recording-map");
    }
    let name = file_name(log);
    let stem = name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("recording");
    PathBuf::from(format!("{stem}-map"))
}

fn file(path: &Path, what: &str) -> anyhow::Result<Vec<u8>> {
    if given::is_stdin(path) {
        return given::stdin(STDIN_BYTES_MAX);
    }
    Ok(crate::input::read(path, what)?)
}

/// The text of the map that is known already, if one was given.
///
/// # Errors
///
/// When it cannot be read, is none, or its cells are of a size in which nothing is mapped.
pub(super) fn prior_yaml(args: &Args) -> anyhow::Result<Option<(&Path, MapYaml)>> {
    let Some(path) = args.prior.as_deref() else { return Ok(None) };
    let text = files::read_text(path, "the known map (YAML)")?;
    let yaml = MapYaml::parse(&text).with_context(|| path.display().to_string())?;
    if !PRIOR_RESOLUTION_M.contains(&yaml.resolution_m) {
        bail!(
            "{}: resolution: {}: a map that is known already must have pixels from {} to {} m",
            path.display(),
            yaml.resolution_m,
            PRIOR_RESOLUTION_M.start(),
            PRIOR_RESOLUTION_M.end()
        );
    }
    Ok(Some((path, yaml)))
}

/// Sides of cells that a survey maps in, as `map.resolution_m`.
const PRIOR_RESOLUTION_M: std::ops::RangeInclusive<f64> = 0.005..=1.0;

/// The picture of a map, which lies beside its text.
fn beside(path: &Path, yaml: &MapYaml) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(&yaml.image)
}

/// The picture that the known map names, which is an input too.
pub(super) fn prior_picture(args: &Args) -> anyhow::Result<Option<PathBuf>> {
    Ok(prior_yaml(args)?.map(|(path, yaml)| beside(path, &yaml)))
}

fn file_name(path: &Path) -> String {
    if given::is_stdin(path) {
        return given::STDIN_NAME.to_owned();
    }
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// What a recording is, in a sentence.
fn source(recording: &Recording, format: Format) -> String {
    let n_readings = recording.rig.n_readings();
    let rig = match &recording.rig {
        Rig::Laser(_) => format!("of {n_readings} beams"),
        Rig::Ring(_) => format!("of {n_readings} sonars"),
    };
    let duration_s = recording.duration().as_secs_f64();
    let way = match recording.path_length_m() {
        way_m if way_m > 0.0 => format!("{way_m:.0} m by odometry"),
        _ => "without odometry".to_owned(),
    };
    format!(
        "A {format}: {} scans {rig}, {} of time, {way}.",
        recording.scans.len(),
        time(duration_s)
    )
}

/// A time for people.
pub(super) fn time(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.1} s") } else { format!("{:.1} min", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_named_for_the_log() {
        let name = |log: &str| default_folder(Path::new(log)).display().to_string();
        assert_eq!(name("/data/freiburg-079.clf.gz"), "freiburg-079-map");
        assert_eq!(name("robot_state"), "robot_state-map");
        assert_eq!(name(".hidden"), "recording-map");
    }
}
