//! Cairn's own recordings: a rig once and a scan for each row of readings, as messages of an MCAP file.
//!
//! | topic | encoding | content |
//! | --- | --- | --- |
//! | `/cairn/rig/<robot>` | `json` | what the ranges mean; once, before the scans |
//! | `/cairn/scan/<robot>` | `cairn.scan.v1` | one scan with odometry, truth and the stamp of each reading |
//!
//! A scan is little endian: `stamp_ns` u64; flags u8 (1 odometry, 2 truth, 4 a stamp for each reading); the
//! number of readings u32; odometry x, y, yaw f64 if flagged; truth likewise; the readings f64, metres,
//! infinite where nothing came back; a stamp u64 for each if flagged. Nothing follows. Stamps are of the
//! run, and so are the log times of the messages; every number comes back bit by bit.
//!
//! Other topics are left alone, so that one file can hold a whole mission. A file that was cut off reads
//! as far as it goes, into its last, unfinished chunk.

use std::{
    collections::{BTreeMap, BTreeSet},
    io::Cursor,
};

use geometry::Se2;
use mcap::{WriteOptions, Writer, records::MessageHeader};
use run_context::Stamp;
use serde::{Deserialize, Serialize};

use crate::{
    Format, ReadOptions, RecordingError,
    complaints::{Action, Complaints, Place, Trouble},
    integrity::Integrity,
    mcap_records::{self, Messages},
    numbers::{is_measurable, shown},
    raw::{RawRecording, RawScan},
    recording::{LaserRig, Recording, Rig, RingRig, Scan, exact_pose, is_wrapped},
};

/// Encoding of rig messages.
pub const RIG_ENCODING: &str = "json";
/// Encoding of scan messages.
pub const SCAN_ENCODING: &str = "cairn.scan.v1";

const RIG_TOPIC: &str = "/cairn/rig/";
const SCAN_TOPIC: &str = "/cairn/scan/";
const HAS_ODOMETRY: u8 = 1;
const HAS_TRUTH: u8 = 2;
const HAS_STAMPS: u8 = 4;

/// The topic on which a robot's rig is written.
pub fn rig_topic(robot: &str) -> String {
    format!("{RIG_TOPIC}{robot}")
}

/// The topic on which a robot's scans are written.
pub fn scan_topic(robot: &str) -> String {
    format!("{SCAN_TOPIC}{robot}")
}

/// A scan as a message holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanMessage {
    /// The scan.
    pub scan: Scan,
    /// The robot's true pose at its stamp, in the world frame, if it is known.
    pub truth: Option<Se2>,
}

/// A message that is none of ours.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MessageError {
    /// The bytes are fewer or more than the message says.
    #[error("{found} bytes where {needed} are needed")]
    Length {
        /// How many there are.
        found: usize,
        /// How many there should be.
        needed: usize,
    },
    /// The bytes say what no message says.
    #[error("{0}")]
    Content(String),
}

/// A rig as the bytes of a message.
pub fn encode_rig(rig: &Rig) -> Vec<u8> {
    // Numbers of a rig are finite, so that JSON can hold them; see `RigFile`.
    serde_json::to_vec(&RigFile::from(rig)).unwrap_or_default()
}

/// A rig from the bytes of a message.
///
/// # Errors
///
/// [`MessageError::Content`] when it is no rig.
pub fn decode_rig(bytes: &[u8]) -> Result<Rig, MessageError> {
    let file: RigFile =
        serde_json::from_slice(bytes).map_err(|e| MessageError::Content(e.to_string()))?;
    Rig::try_from(file).map_err(MessageError::Content)
}

/// Appends a scan as the bytes of a message to `out`; `truth` is the true pose in the world frame.
pub fn encode_scan(scan: &Scan, truth: Option<Se2>, out: &mut Vec<u8>) {
    let flag = |has, bit| if has { bit } else { 0 };
    let has_stamps = !scan.stamps.is_empty() && scan.stamps.len() == scan.ranges_m.len();
    out.extend(scan.stamp.as_nanos().to_le_bytes());
    out.push(
        flag(scan.odom_from_base.is_some(), HAS_ODOMETRY)
            | flag(truth.is_some(), HAS_TRUTH)
            | flag(has_stamps, HAS_STAMPS),
    );
    out.extend(u32::try_from(scan.ranges_m.len()).unwrap_or(u32::MAX).to_le_bytes());
    for pose in [scan.odom_from_base, truth].into_iter().flatten() {
        for value in [pose.x_m, pose.y_m, pose.yaw_rad] {
            out.extend(value.to_le_bytes());
        }
    }
    scan.ranges_m.iter().for_each(|range| out.extend(range.to_le_bytes()));
    if has_stamps {
        scan.stamps.iter().for_each(|stamp| out.extend(stamp.as_nanos().to_le_bytes()));
    }
}

/// A scan from the bytes of a message.
///
/// # Errors
///
/// [`MessageError`] when the bytes are too few or too many, have unknown flags, a pose that is not finite,
/// or a range that is NaN or negative.
pub fn decode_scan(bytes: &[u8]) -> Result<ScanMessage, MessageError> {
    const HEAD: usize = 13;
    let Some((head, rest)) = bytes.split_at_checked(HEAD) else {
        return Err(MessageError::Length { found: bytes.len(), needed: HEAD });
    };
    let flags = head[8];
    if flags & !(HAS_ODOMETRY | HAS_TRUTH | HAS_STAMPS) != 0 {
        return Err(MessageError::Content(format!("unknown flags {flags:#04x}")));
    }
    let n = word(&head[9..]) as usize;
    let has = |bit| usize::from(flags & bit != 0);
    let needed = 24 * (has(HAS_ODOMETRY) + has(HAS_TRUTH)) + 8 * n * (1 + has(HAS_STAMPS));
    if rest.len() != needed {
        return Err(MessageError::Length { found: bytes.len(), needed: HEAD + needed });
    }
    let mut numbers = rest.as_chunks::<8>().0.iter();
    let mut pose = |bit| -> Result<Option<Se2>, MessageError> {
        if flags & bit == 0 {
            return Ok(None);
        }
        let mut next = || numbers.next().map_or(f64::NAN, |b| f64::from_le_bytes(*b));
        let (x_m, y_m, yaw_rad) = (next(), next(), next());
        let is_pose = is_measurable(x_m) && is_measurable(y_m) && is_wrapped(yaw_rad);
        // Taken as it is, not through `Se2::new`: wrapping again could turn the last bit.
        is_pose
            .then_some(Some(Se2 { x_m, y_m, yaw_rad }))
            .ok_or_else(|| MessageError::Content(format!("({x_m}, {y_m}, {yaw_rad}) is no pose")))
    };
    let odom_from_base = pose(HAS_ODOMETRY)?;
    let truth = pose(HAS_TRUTH)?;
    let ranges_m: Vec<f64> = numbers.by_ref().take(n).map(|b| f64::from_le_bytes(*b)).collect();
    if let Some(range) = ranges_m.iter().find(|r| r.is_nan() || **r < 0.0) {
        return Err(MessageError::Content(format!("{range} is no range")));
    }
    let stamps = numbers.map(|b| Stamp::from_nanos(u64::from_le_bytes(*b))).collect();
    let stamp = Stamp::from_nanos(long(head));
    Ok(ScanMessage { scan: Scan { stamp, odom_from_base, ranges_m, stamps }, truth })
}

/// A whole recording of one robot as an MCAP file. Of the odometry only that of the scans is written; reference
/// poses and extra columns are not.
///
/// # Errors
///
/// [`RecordingError::Unsupported`] when the writer refuses.
pub fn write(recording: &Recording, robot: &str) -> Result<Vec<u8>, RecordingError> {
    let refuse = |e: mcap::McapError| RecordingError::Unsupported {
        name: robot.to_owned(),
        problem: format!("cannot be written as MCAP: {e}"),
    };
    let options = WriteOptions::new().compression(None).profile("cairn").library("cairn");
    let mut writer: Writer<Cursor<Vec<u8>>> = options.create(Cursor::default()).map_err(refuse)?;
    let rig =
        writer.add_channel(0, &rig_topic(robot), RIG_ENCODING, &BTreeMap::new()).map_err(refuse)?;
    let scans = writer
        .add_channel(0, &scan_topic(robot), SCAN_ENCODING, &BTreeMap::new())
        .map_err(refuse)?;
    let mut header = MessageHeader { channel_id: rig, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &encode_rig(&recording.rig)).map_err(refuse)?;
    header.channel_id = scans;
    let mut data = Vec::new();
    for (index, scan) in recording.scans.iter().enumerate() {
        header.sequence = header.sequence.wrapping_add(1);
        header.log_time = scan.stamp.as_nanos();
        header.publish_time = header.log_time;
        data.clear();
        encode_scan(scan, recording.truth.get(index).map(|t| t.pose), &mut data);
        writer.write_to_known_channel(&header, &data).map_err(refuse)?;
    }
    writer.finish().map_err(refuse)?;
    Ok(writer.into_inner().into_inner())
}

/// Reads the robot that the options name, or the only one.
pub(crate) fn read(
    name: &str,
    bytes: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    // What the reader of messages finds by itself, chunk by chunk, is not said twice.
    for damage in Integrity::of(bytes).damage {
        if !damage.found.contains("chunk") {
            let place = Place::Byte(damage.bytes.start);
            complaints.add(place, Trouble::Damaged, Action::Kept, || damage.to_string());
        }
    }
    let robots = robots_of(mcap_records::messages(bytes));
    let robot = chosen(name, &robots, options.robot)?;
    let (rig_topic, scan_topic) = (rig_topic(&robot), scan_topic(&robot));
    let mut rig: Option<Rig> = None;
    let mut scans = Vec::new();
    let mut messages = mcap_records::messages(bytes);
    for message in messages.by_ref() {
        let place = Place::Byte(message.byte);
        if message.topic == rig_topic {
            match decode_rig(message.data) {
                Ok(found) if rig.as_ref().is_some_and(|r| *r != found) => {
                    let text = || "another rig of the same robot".to_owned();
                    complaints.add(place, Trouble::RigChanges, Action::Skipped, text);
                }
                Ok(found) => rig = Some(found),
                Err(e) => {
                    let text = || format!("a rig that is none: {e}");
                    complaints.add(place, Trouble::Damaged, Action::Skipped, text);
                }
            }
        } else if message.topic == scan_topic {
            match decode_scan(message.data) {
                Ok(found) => scans.push(raw(place, found)),
                Err(e) => {
                    let text = || format!("a scan that is none: {e}");
                    complaints.add(place, Trouble::Damaged, Action::Skipped, text);
                }
            }
        }
    }
    messages.complain(complaints);
    let Some(rig) = rig else {
        let problem = format!("no readable message on {rig_topic}: what took the scans is unknown");
        return Err(RecordingError::NoRig { name: name.to_owned(), problem });
    };
    if scans.is_empty() {
        let contains = format!("{} message topics of robots: {}", robots.len(), robots.join(", "));
        let name = name.to_owned();
        return Err(RecordingError::NoScans { name, format: Format::CairnMcap, contains });
    }
    Ok(RawRecording::new(rig, scans))
}

fn raw(place: Place, message: ScanMessage) -> RawScan {
    let nanos = |stamp: Stamp| i64::try_from(stamp.as_nanos()).unwrap_or(i64::MAX);
    let scan = message.scan;
    RawScan {
        place,
        stamp_ns: nanos(scan.stamp),
        odom: scan.odom_from_base,
        truth: message.truth,
        ranges_m: scan.ranges_m,
        stamps_ns: scan.stamps.into_iter().map(nanos).collect(),
        ..RawScan::default()
    }
}

fn robots_of(messages: Messages<'_>) -> Vec<String> {
    let mut robots = BTreeSet::new();
    for message in messages {
        let topic = message.topic;
        let robot = topic.strip_prefix(SCAN_TOPIC).or_else(|| topic.strip_prefix(RIG_TOPIC));
        if let Some(robot) = robot
            && !robots.contains(robot)
        {
            robots.insert(robot.to_owned());
        }
    }
    robots.into_iter().collect()
}

fn chosen(name: &str, robots: &[String], wanted: Option<&str>) -> Result<String, RecordingError> {
    let name = name.to_owned();
    let shown = |r: &String| shown(r);
    match (wanted, robots) {
        (_, []) => Err(RecordingError::NoScans {
            name,
            format: Format::CairnMcap,
            contains: format!("no topic {SCAN_TOPIC}<robot>"),
        }),
        (None, [only]) => Ok(only.clone()),
        (None, _) => {
            Err(RecordingError::SeveralRobots { name, robots: robots.iter().map(shown).collect() })
        }
        (Some(robot), _) if robots.iter().any(|r| r == robot) => Ok(robot.to_owned()),
        (Some(robot), _) => Err(RecordingError::NoSuchRobot {
            name,
            robot: robot.to_owned(),
            robots: robots.iter().map(shown).collect(),
        }),
    }
}

fn word(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |b| u32::from_le_bytes(*b))
}

fn long(bytes: &[u8]) -> u64 {
    bytes.first_chunk().map_or(0, |b| u64::from_le_bytes(*b))
}

/// A rig in JSON: poses are x (m), y (m), yaw (rad).
#[derive(Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum RigFile {
    /// A scanning laser.
    Laser {
        base_from_sensor: [f64; 3],
        first_beam_rad: f64,
        beam_spacing_rad: f64,
        n_beams: usize,
        range_max_m: f64,
    },
    /// Sonars.
    Ring {
        base_from_sensors: Vec<[f64; 3]>,
        half_angle_rad: f64,
        range_min_m: f64,
        range_max_m: f64,
    },
}

impl RigFile {
    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let (poses, others) = match self {
            Self::Laser {
                base_from_sensor, first_beam_rad, beam_spacing_rad, range_max_m, ..
            } => (
                std::slice::from_ref(base_from_sensor),
                [*first_beam_rad, *beam_spacing_rad, *range_max_m],
            ),
            Self::Ring { base_from_sensors, half_angle_rad, range_min_m, range_max_m } => {
                (base_from_sensors.as_slice(), [*half_angle_rad, *range_min_m, *range_max_m])
            }
        };
        poses.iter().flatten().copied().chain(others)
    }
}

impl From<&Rig> for RigFile {
    fn from(rig: &Rig) -> Self {
        let pose = |p: &Se2| [p.x_m, p.y_m, p.yaw_rad];
        match rig {
            Rig::Laser(laser) => Self::Laser {
                base_from_sensor: pose(&laser.base_from_sensor),
                first_beam_rad: laser.first_beam_rad,
                beam_spacing_rad: laser.beam_spacing_rad,
                n_beams: laser.n_beams,
                range_max_m: laser.range_max_m,
            },
            Rig::Ring(ring) => Self::Ring {
                base_from_sensors: ring.base_from_sensors.iter().map(pose).collect(),
                half_angle_rad: ring.half_angle_rad,
                range_min_m: ring.range_min_m,
                range_max_m: ring.range_max_m,
            },
        }
    }
}

impl TryFrom<RigFile> for Rig {
    type Error = String;

    fn try_from(file: RigFile) -> Result<Self, String> {
        if let Some(value) = file.numbers().find(|v| !is_measurable(*v)) {
            return Err(format!("{value} is no measure of a rig"));
        }
        let pose = |[x_m, y_m, yaw_rad]: [f64; 3]| exact_pose(x_m, y_m, yaw_rad);
        let positive = |name: &str, value: f64| {
            if value > 0.0 { Ok(value) } else { Err(format!("{name} = {value}: must be above 0")) }
        };
        Ok(match file {
            RigFile::Laser {
                base_from_sensor,
                first_beam_rad,
                beam_spacing_rad,
                n_beams,
                range_max_m,
            } => Self::Laser(LaserRig {
                base_from_sensor: pose(base_from_sensor),
                first_beam_rad,
                beam_spacing_rad,
                n_beams,
                range_max_m: positive("range_max_m", range_max_m)?,
            }),
            RigFile::Ring { base_from_sensors, half_angle_rad, range_min_m, range_max_m } => {
                Self::Ring(RingRig {
                    base_from_sensors: base_from_sensors.into_iter().map(pose).collect(),
                    half_angle_rad: positive("half_angle_rad", half_angle_rad)?,
                    range_min_m,
                    range_max_m: positive("range_max_m", range_max_m)?,
                })
            }
        })
    }
}

#[cfg(test)]
#[path = "cairn_mcap_tests.rs"]
pub(crate) mod tests;
