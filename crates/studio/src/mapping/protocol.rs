//! The messages between the studio and its mapping page, version 2.
//!
//! Text messages are JSON objects with `type` first: `hello`, `source`, `state`, `registration` and `error` to the
//! page, [`Request`] from it. What is large comes as binary messages, little-endian, each with the same head:
//!
//! | bytes | what |
//! | --- | --- |
//! | 0 | kind, see below |
//! | 1 | slot of the run: 0 for A, 1 for B |
//! | 2–3 | zero |
//! | 4–7 | number of the run (u32); a page forgets what it knew of the slot when it changes |
//!
//! | kind | what follows |
//! | --- | --- |
//! | 1 tiles | origin x, y and cell (f64, m), number of tiles (u32); each: column and row of its lower left cell (i32), length (u16), 64 × 64 cells from the bottom row, packed |
//! | 2 track | which (u32): 0 odometry, 1 corrected, 2 true; first pose (u32), number (u32); each x, y (m), yaw (rad) as f32. Poses from the first on replace what was there |
//! | 3 graph | vertices (u32), each x, y (f32, m); edges (u32), each from, to, kind (u32): 0 odometry, 1 closure |
//! | 4 scan | half angle (f32, rad; 0: points), number (u32), points: x, y; or cones: x, y, yaw, range, 1 for an echo; f32, m and rad |
//! | 5 patch | pose of its frame x, y, yaw, origin x, y, cell (f64, m and rad), columns and rows (u32), length (u32), cells from the bottom row, packed |
//!
//! A cell is one byte: 0 unknown, else 1 + 254 × the probability that it is occupied. Packed bytes are
//! runs: a byte n below 128 and then n + 1 bytes as they are; or n from 129, and one byte that stands 257 − n times.
//!
//! Poses and points are in the map frame. A page is sent what changed since it was last sent something, so a slow
//! page misses moments, never a part of the picture.

use std::collections::BTreeMap;

use recordings::Format;
use serde::{Deserialize, Serialize};

use crate::description::Offer;

/// The version in `hello`.
pub(crate) const PROTOCOL: u32 = 2;

/// x (m), y (m), yaw (rad).
pub(crate) type Pose = [f64; 3];

/// What the page may ask for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum Request {
    /// Let the recording play.
    Play,
    /// Hold it.
    Pause,
    /// Take one scan more, then hold.
    Step,
    /// Seconds of the recording per second, 0.1 to 200.
    Speed {
        /// The ratio.
        ratio: f64,
    },
    /// As fast as possible to a scan, from 0; beyond the last one: to the end.
    Seek {
        /// How many scans are done then.
        scan: usize,
    },
    /// Every run again from the first scan.
    Rewind,
    /// Map the recording again under other parameters; the run so far stays for comparison.
    Run {
        /// Parameters by key that differ from the defaults, as text.
        values: BTreeMap<String, String>,
        /// The slot whose run stays, 0 or 1.
        keep: usize,
    },
    /// Ends a comparison.
    Keep {
        /// The slot whose run stays, 0 or 1.
        slot: usize,
    },
    /// Make a recording on the spot and load it.
    Sample {
        /// Its name in `hello`.
        name: String,
    },
}

/// What stays the same while the program lasts.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "hello")]
pub(crate) struct Hello {
    pub protocol: u32,
    pub cairn: &'static str,
    /// Names this program; a page forgets everything when it changes.
    pub server: u32,
    /// Whether there is a mission page at `/`.
    pub has_mission: bool,
    pub upload_max_bytes: usize,
    pub samples: Vec<SampleInfo>,
    pub formats: Vec<FormatInfo>,
}

/// A format of logs that can be opened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FormatInfo {
    pub name: &'static str,
    /// What comes in a second file.
    pub second: Option<&'static str>,
}

impl FormatInfo {
    pub(super) fn all() -> Vec<Self> {
        let info = |format: &Format| Self { name: format.name(), second: format.second() };
        Format::ALL.iter().map(info).collect()
    }
}

/// A recording that can be made on the spot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SampleInfo {
    pub name: &'static str,
    pub title: &'static str,
    pub about: &'static str,
}

/// What is being mapped.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(tag = "type", rename = "source")]
pub(crate) struct Source {
    /// `empty`, `reading` or `ready`.
    pub phase: &'static str,
    /// What is being read, or was.
    pub name: String,
    /// Why the last one could not be read.
    pub problem: Option<String>,
    pub recording: Option<RecordingInfo>,
    pub parameters: Vec<Parameter>,
    /// Panels and layers that the recording has.
    #[serde(flatten)]
    pub offer: Offer,
}

/// The recording in `source`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordingInfo {
    pub format: String,
    /// `laser` or `sonar`.
    pub rig: &'static str,
    pub n_readings: usize,
    pub n_scans: usize,
    pub duration_s: f64,
    pub path_length_m: f64,
    pub has_truth: bool,
    pub n_complaints: usize,
    /// How many there are of each kind.
    pub complaint_counts: Vec<String>,
    /// The first ones in full.
    pub complaints: Vec<String>,
}

/// One parameter of a survey.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Parameter {
    /// Table and name; the unit ends it.
    pub key: &'static str,
    pub table: &'static str,
    pub name: &'static str,
    pub about: &'static str,
    /// `number`, `count`, `flag` or `choice`.
    pub kind: &'static str,
    /// What its values must be, as prose.
    pub allowed: String,
    pub default: String,
    /// The default in the modes in which it is another one.
    pub by_mode: BTreeMap<&'static str, String>,
    pub choices: Vec<&'static str>,
}

/// What changes with time.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "state")]
pub(crate) struct State {
    pub playing: bool,
    /// Playing as fast as possible.
    pub hurrying: bool,
    pub speed_ratio: f64,
    pub achieved_ratio: f64,
    pub runs: Vec<RunState>,
    /// Parameters in which the two runs differ: key, A's value, B's value.
    pub differences: Vec<[String; 3]>,
}

/// A run now.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct RunState {
    pub run: u32,
    /// `under way`, `finishing`, `finished` or `failed`.
    pub phase: &'static str,
    pub problem: Option<String>,
    /// Scans done.
    pub scan: usize,
    pub n_scans: usize,
    /// Time of the recording.
    pub t_s: f64,
    /// Where the robot is, and where odometry puts it.
    pub pose: Option<Pose>,
    pub odometry: Option<Pose>,
    /// How the last scan was placed, in words.
    pub tracking: &'static str,
    pub counters: Vec<Counter>,
    pub stages: Vec<StageInfo>,
    /// Named with their units; at the end.
    pub figures: Vec<(String, f64)>,
    /// Parameters that are not at the default of their mode, by key; the mode itself too.
    pub values: BTreeMap<String, String>,
    /// The map is larger than the page is sent.
    pub is_cut: bool,
}

/// A number that grows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Counter {
    pub name: &'static str,
    pub label: &'static str,
    pub value: usize,
}

/// Time spent on one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct StageInfo {
    pub name: &'static str,
    pub n_times: usize,
    pub total_s: f64,
    pub longest_s: f64,
}

/// How the last short-term map was compared with the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "type", rename = "registration")]
pub(crate) struct Registration {
    pub slot: usize,
    pub run: u32,
    /// Which one, from 1.
    pub number: usize,
    pub scan: usize,
    pub applied: bool,
    /// Why it was not applied, or what was corrected.
    pub verdict: String,
    /// What the scores are.
    pub score: String,
    /// Index of the chosen candidate.
    pub best: Option<usize>,
    pub candidates: Vec<Candidate>,
}

/// One pose that was tried: x (m), y (m), yaw (rad) from where odometry says, and its score, if it has one.
pub(crate) type Candidate = (f64, f64, f64, Option<f64>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_as_the_page_writes_them() {
        let read = |text| serde_json::from_str::<Request>(text);
        assert_eq!(read(r#"{"type":"rewind"}"#).unwrap(), Request::Rewind);
        assert_eq!(read(r#"{"type":"seek","scan":12}"#).unwrap(), Request::Seek { scan: 12 });
        let values = BTreeMap::from([("a.b".to_owned(), "0.5".to_owned())]);
        assert_eq!(
            read(r#"{"type":"run","values":{"a.b":"0.5"},"keep":0}"#).unwrap(),
            Request::Run { values, keep: 0 }
        );
    }

    #[test]
    fn unknown_requests_and_keys_are_refused() {
        for text in [
            r#"{"type":"fly"}"#,
            r#"{"type":"seek","scan":-1}"#,
            r#"{"type":"speed","ratio":1,"x":2}"#,
            "[]",
        ] {
            assert!(serde_json::from_str::<Request>(text).is_err(), "{text}");
        }
    }
}
