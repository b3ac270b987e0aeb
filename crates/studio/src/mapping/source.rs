//! How a recording reaches the page: given by the program, brought by a page, or made on the spot.

use std::{collections::BTreeMap, sync::Arc};

use missions::{Mission, sense};
use recordings::{Complaints, ReadOptions, Recording, RecordingError, Rig};
use surveys::{Known, SurveyConfig, SurveyPrior};

use super::{
    parameters::values_of,
    protocol::{RecordingInfo, SampleInfo},
};

/// The sample that needs no mission.
pub(crate) const LASER_ROOM: &str = "laser-room";
/// Scans of it: two rounds through the room.
const N_LASER_ROOM_SCANS: usize = 600;

/// Largest recording that a page may bring, bytes. It is kept in memory until it is read, and one at a time.
pub(crate) const UPLOAD_BYTES_MAX: usize = 10 * 1024 * 1024;
/// Bytes that a compressed log of a page may unpack to.
const UNPACKED_BYTES_MAX: usize = UPLOAD_BYTES_MAX;
/// Bytes of memory that a page's log may take while it is read: a building seen by a laser for an hour.
const MEMORY_BYTES_MAX: usize = 20 << 20;
/// A recording above this is put away when a page brings another one: two would not fit, bytes.
const KEPT_BESIDE_BYTES_MAX: usize = 6 << 20;

/// A recording to be shown on the mapping page, and how it is to be mapped.
#[derive(Clone, Debug)]
pub struct Exhibit {
    /// What the page calls it: the file's name.
    pub name: String,
    /// What the file was read as, for people.
    pub format: String,
    /// The recording.
    pub recording: Arc<Recording>,
    /// What the results are judged by, beside what the recording brings along.
    pub known: Known,
    /// A map that is known already.
    pub prior: Option<SurveyPrior>,
    /// What was wrong in each file.
    pub complaints: Vec<(String, Complaints)>,
    /// How the first run is made.
    pub config: SurveyConfig,
}

/// A recording with its parameters for the first run.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) name: String,
    format: String,
    pub(crate) recording: Arc<Recording>,
    pub(crate) known: Known,
    pub(crate) prior: Option<SurveyPrior>,
    complaints: Vec<(String, Complaints)>,
    /// Parameters that were set, by key.
    pub(crate) values: BTreeMap<String, String>,
    /// The program gave it, no page did.
    is_given: bool,
}

impl From<Exhibit> for Loaded {
    fn from(exhibit: Exhibit) -> Self {
        let Exhibit { name, format, recording, known, prior, complaints, config } = exhibit;
        Self {
            name,
            format,
            recording,
            known,
            prior,
            complaints,
            values: values_of(&config),
            is_given: true,
        }
    }
}

impl Loaded {
    fn new(name: &str, format: String, recording: Recording, complaints: Complaints) -> Self {
        Self {
            name: name.to_owned(),
            format,
            recording: Arc::new(recording),
            known: Known::default(),
            prior: None,
            complaints: vec![(name.to_owned(), complaints)],
            values: BTreeMap::new(),
            is_given: false,
        }
    }

    /// Whether it must be put away before a page brings another one.
    pub(crate) fn gives_way(&self) -> bool {
        !self.is_given && self.recording.memory_bytes() > KEPT_BESIDE_BYTES_MAX
    }

    /// What the page says about it.
    pub(crate) fn info(&self) -> RecordingInfo {
        let Self { recording, known, complaints, .. } = self;
        // With several files each line says which one it is about.
        let lines = |of: fn(&Complaints) -> Vec<String>| {
            let about = |(name, complaints): &(String, Complaints)| {
                let head =
                    if self.complaints.len() > 1 { format!("{name}: ") } else { String::new() };
                of(complaints).into_iter().map(|line| format!("{head}{line}")).collect::<Vec<_>>()
            };
            complaints.iter().flat_map(about).collect()
        };
        RecordingInfo {
            format: self.format.clone(),
            rig: if matches!(recording.rig, Rig::Laser(_)) { "laser" } else { "sonar" },
            n_readings: recording.rig.n_readings(),
            n_scans: recording.scans.len(),
            duration_s: recording.duration().as_secs_f64(),
            path_length_m: recording.path_length_m(),
            has_truth: !recording.truth.is_empty() || !known.truth.is_empty(),
            n_complaints: complaints.iter().map(|(_, complaints)| complaints.total()).sum(),
            complaint_counts: lines(|c| c.to_string().lines().map(str::to_owned).collect()),
            complaints: lines(|c| c.kept().iter().map(ToString::to_string).collect()),
        }
    }
}

/// Reads a log that a page brought.
///
/// # Errors
///
/// A sentence for the person at the page, with line numbers as the reader gives them.
pub(crate) fn read(
    name: &str,
    log: &[u8],
    poses: Option<&[u8]>,
    truth: Option<&[u8]>,
) -> Result<Loaded, String> {
    let (bytes_max, memory_max_bytes) = (UNPACKED_BYTES_MAX, MEMORY_BYTES_MAX);
    let options =
        ReadOptions { poses, truth, bytes_max, memory_max_bytes, ..ReadOptions::default() };
    let read = recordings::read(name, log, &options).map_err(|error| match error {
        RecordingError::TooMuchMemory { .. } | RecordingError::TooLarge { .. } => {
            format!("{error}; give it to the program: cairn map FILE --show")
        }
        error => error.to_string(),
    })?;
    Ok(Loaded::new(name, read.format.to_string(), read.recording, read.complaints))
}

/// Makes a recording on the spot: runs its mission to the end, or computes what a laser sees in a room.
///
/// # Errors
///
/// A sentence for the person at the page.
pub(crate) fn sample(sample: &SampleInfo) -> Result<Loaded, String> {
    if sample.name == LASER_ROOM {
        let recording = surveys::testing::room(N_LASER_ROOM_SCANS);
        return Ok(made(sample, "made by arithmetic".to_owned(), recording));
    }
    let mission = Mission::load(sample.name, &[]).map_err(|error| error.to_string())?;
    let seed = mission.seed();
    let sensed = sense(mission, seed).map_err(|error| error.to_string())?;
    let mut recordings = sensed.recordings.into_iter();
    let (_, recording) = recordings.next().ok_or("this mission has no robot that senses")?;
    if recording.scans.is_empty() {
        return Err(format!("{}: the robot sensed nothing", sample.title));
    }
    Ok(made(sample, format!("mission {}", sample.name), recording))
}

fn made(sample: &SampleInfo, format: String, recording: Recording) -> Loaded {
    Loaded::new(sample.title, format, recording, Complaints::default())
}
