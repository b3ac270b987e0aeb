//! The messages between the studio and its page, version 2: JSON objects with `type` first.
//!
//! Coordinates are in the map frame, metres; a pose is `[x_m, y_m, yaw_rad]`. These are mirror types
//! of what `missions` shows of a run: the page's format may change without touching the closed loop.

use serde::{Deserialize, Serialize};

use crate::{
    description::{Offer, PlotInfo, SignalInfo},
    past::Kept,
};

/// The version in `hello`.
pub(crate) const PROTOCOL: u32 = 2;

/// x (m), y (m), yaw (rad).
pub(crate) type Pose = [f64; 3];
/// x (m), y (m).
pub(crate) type Point = [f64; 2];
/// When (s), which resource, and whether it went high.
pub(crate) type Edge = (f64, String, bool);
/// A robot of a crowd: x (m), y (m), yaw (rad), and 1 if it touches something plus 2 if it has arrived.
pub(crate) type Brief = (f64, f64, f64, u8);

/// What the page may ask for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum Request {
    /// Let time run.
    Play,
    /// Hold time.
    Pause,
    /// Hold time after one control period more.
    Step,
    /// Seconds simulated per second, 0.1 to 20.
    Speed {
        /// The ratio.
        ratio: f64,
    },
    /// Begin again, with another seed or mission if given.
    Restart {
        /// The seed; the present one when absent.
        seed: Option<u64>,
        /// The name of a shipped mission; the present mission when absent.
        mission: Option<String>,
    },
    /// Put a box on the floor.
    Place {
        /// Its centre.
        at_m: Point,
        /// Its side, metres.
        size_m: f64,
    },
    /// Take a removable thing away.
    Remove {
        /// Its number in `state`.
        id: u64,
    },
    /// Send a robot somewhere.
    Goal {
        /// Its number.
        robot: usize,
        /// Where to, and facing where.
        pose: Pose,
    },
    /// Stop a robot.
    Stop {
        /// Its number.
        robot: usize,
    },
    /// Go to a time of a recording, forwards or backwards.
    Seek {
        /// Time since its beginning, s.
        t_s: f64,
    },
    /// Drive a robot by hand for half a second of its time; to drive on, ask again.
    Drive {
        /// Its number.
        robot: usize,
        /// Forwards, m/s.
        speed_mps: f64,
        /// Counter-clockwise, rad/s.
        turn_rate_radps: f64,
    },
    /// Look back: what was shown at a time. The run goes on, and only the page that asks sees it.
    Past {
        /// Time since the beginning, s.
        t_s: f64,
    },
    /// Cut one of a robot's lines, or mend it.
    Cut {
        /// Its number.
        robot: usize,
        /// Which line.
        line: missions::Line,
        /// Cut, or mended.
        cut: bool,
    },
    /// Press a button of the smart home for half a second.
    Press {
        /// Its name.
        device: String,
    },
}

/// What stays the same while a run lasts.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "hello")]
pub(crate) struct Hello {
    pub protocol: u32,
    pub cairn: &'static str,
    /// Names this run; a page forgets what it knew when it changes.
    pub run: String,
    pub mission: MissionInfo,
    pub missions: Vec<MissionName>,
    pub world: WorldInfo,
    pub robots: Vec<RobotInfo>,
    pub crowd: Option<CrowdInfo>,
    pub pheromones: Option<PheromoneInfo>,
    pub tags: Option<TagsInfo>,
    pub planned_path_m: Vec<Point>,
    pub program: Option<ProgramInfo>,
    pub links: Vec<LinkInfo>,
    /// Panels and layers that the mission has.
    #[serde(flatten)]
    pub offer: Offer,
    pub plots: Vec<PlotInfo>,
    /// In the order of [`RobotState::signals`].
    pub robot_signals: Vec<SignalInfo>,
    /// In the order of [`State::signals`].
    pub run_signals: Vec<SignalInfo>,
}

/// The mission in `hello`.
#[derive(Debug, Serialize)]
pub(crate) struct MissionInfo {
    pub name: String,
    pub title: String,
    pub about: String,
    pub seed: u64,
    pub duration_max_s: f64,
    /// `live` or `replay`.
    pub kind: &'static str,
    /// The file in which this run is recorded.
    pub recording: Option<String>,
    /// How long the recording is that is shown, s.
    pub length_s: Option<f64>,
    /// When (s) something was done in it, whether a person did it, and what.
    pub marks: Vec<(f64, bool, String)>,
}

/// A mission that can be chosen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct MissionName {
    /// What `restart` takes.
    pub name: String,
    /// A line for people.
    pub title: String,
    /// A paragraph for people.
    pub about: String,
    /// It is not among the shipped ones.
    #[serde(rename = "own")]
    pub is_own: bool,
}

/// The fixed part of the world.
#[derive(Debug, Serialize)]
pub(crate) struct WorldInfo {
    pub bounds_m: [f64; 4],
    pub walls: Vec<(f64, f64, f64, f64, String)>,
    pub points: Vec<Point>,
    pub things: Vec<ThingInfo>,
    pub rooms: Vec<RoomInfo>,
    pub devices: Vec<DeviceInfo>,
}

/// A piece of furniture, a box, a door.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ThingInfo {
    pub id: u64,
    pub name: String,
    pub kind: String,
    pub material: String,
    pub corners_m: Vec<Point>,
    pub removable: bool,
}

/// A room's name and where to write it.
#[derive(Debug, Serialize)]
pub(crate) struct RoomInfo {
    pub name: String,
    pub at_m: Point,
}

/// A sensor or actuator of the smart home.
#[derive(Debug, Serialize)]
pub(crate) struct DeviceInfo {
    pub name: String,
    pub label: String,
    pub kind: String,
    pub at_m: Point,
    pub area_m: Option<Vec<Point>>,
    pub input: Option<u8>,
    pub output: Option<u8>,
}

/// A robot's fixed part.
#[derive(Debug, Serialize)]
pub(crate) struct RobotInfo {
    pub id: usize,
    pub name: String,
    pub model: String,
    pub footprint_m: Vec<Point>,
    pub sonars: Vec<SonarInfo>,
    pub scanners: Vec<ScannerInfo>,
    /// Where its readers of tags are in its own frame, and how near a tag must be to them.
    pub tag_readers_m: Vec<Point>,
    pub tag_range_m: f64,
    pub start: Pose,
    /// It is no body of this simulation: what cannot be measured from outside is not known.
    pub is_elsewhere: bool,
    pub hand_speed_max_mps: f64,
    pub hand_turn_rate_max_radps: f64,
}

/// The robots beyond those in `robots`, when there are too many to tell everything of each.
#[derive(Debug, Serialize)]
pub(crate) struct CrowdInfo {
    pub first_id: usize,
    pub n_robots: usize,
    pub footprint_m: Vec<Point>,
}

/// One sonar on a robot.
#[derive(Debug, Serialize)]
pub(crate) struct SonarInfo {
    pub at: Pose,
    pub half_angle_rad: f64,
    pub range_max_m: f64,
}

/// One planar scanner on a robot.
#[derive(Debug, Serialize)]
pub(crate) struct ScannerInfo {
    pub name: String,
    pub at: Pose,
    pub first_angle_rad: f64,
    pub step_rad: f64,
    pub n_beams: usize,
    pub range_max_m: f64,
}

/// Tags in the floor as the run began.
#[derive(Debug, Serialize)]
pub(crate) struct TagsInfo {
    pub pitch_m: f64,
    /// x, y (m) and what is stored.
    pub tags: Vec<(f64, f64, u8)>,
}

/// The pheromone field.
#[derive(Debug, Serialize)]
pub(crate) struct PheromoneInfo {
    pub cell_m: f64,
    pub width: usize,
    pub height: usize,
    pub origin_m: Point,
    pub values: Vec<(usize, usize, u8)>,
    pub sigma_m: f64,
    pub antenna_spacing_m: f64,
}

/// The decision program.
#[derive(Debug, Serialize)]
pub(crate) struct ProgramInfo {
    pub source: String,
    pub mode: String,
    pub functions: Vec<FunctionInfo>,
}

/// One function of the program.
#[derive(Debug, Serialize)]
pub(crate) struct FunctionInfo {
    pub line: usize,
    pub mnemonic: String,
    pub operands: Vec<OperandInfo>,
}

/// One operand: where it stands and what it shows.
#[derive(Debug, Serialize)]
pub(crate) struct OperandInfo {
    pub text: String,
    pub resource: Option<String>,
    pub line: usize,
    pub column: usize,
    pub length: usize,
}

/// A link and its two ends.
#[derive(Debug, Serialize)]
pub(crate) struct LinkInfo {
    pub id: usize,
    pub name: String,
    pub ends: [String; 2],
    pub baud: Option<u32>,
    /// The robot whose line it is, and which: what [`Request::Cut`] takes.
    pub robot: usize,
    pub line: missions::Line,
}

/// What changes with time.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "state")]
pub(crate) struct State {
    pub t_s: f64,
    pub step: u64,
    pub playing: bool,
    pub speed_ratio: f64,
    pub achieved_ratio: f64,
    pub verdict: Option<VerdictInfo>,
    pub robots: Vec<RobotState>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub crowd: Vec<Brief>,
    pub people: Vec<PersonState>,
    pub things: Vec<ThingInfo>,
    pub devices: Vec<DeviceState>,
    pub decision: Option<DecisionState>,
    /// In the order of [`Hello::run_signals`].
    pub signals: Vec<Option<f64>>,
}

/// A scan: which scanner, from where (m, m, rad), and its beams ([`crate::beams`]).
pub(crate) type Scan = (usize, Pose, String);

/// How it ended.
#[derive(Debug, Serialize)]
pub(crate) struct VerdictInfo {
    pub passed: bool,
    pub text: String,
    pub checks: Vec<CheckInfo>,
}

/// One requirement of the mission and how it went.
#[derive(Debug, Serialize)]
pub(crate) struct CheckInfo {
    pub name: String,
    pub passed: bool,
    pub text: String,
}

/// A robot now.
#[derive(Debug, Serialize)]
pub(crate) struct RobotState {
    pub id: usize,
    pub truth: Pose,
    pub estimate: Pose,
    pub ellipse: [f64; 3],
    pub wheels_mps: [f64; 2],
    pub sonar_m: Vec<f64>,
    pub bubble_m: Vec<f64>,
    pub phase: String,
    /// What it does about its goal, or why it gave it up, in a sentence; empty without a goal.
    pub task: String,
    pub avoider: AvoiderState,
    pub goal: Option<Pose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal_tolerance_m: Option<f64>,
    pub target: Option<Point>,
    pub preview_m: Vec<Point>,
    pub intensities: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scans: Vec<Scan>,
    pub stalled: bool,
    pub touching: bool,
    /// In the order of [`Hello::robot_signals`].
    pub signals: Vec<Option<f64>>,
    /// Why it gave up, if it did.
    pub failure: Option<String>,
}

/// The nine-state machine now.
#[derive(Debug, Serialize)]
pub(crate) struct AvoiderState {
    pub state: u8,
    pub name: String,
}

/// A person now.
#[derive(Debug, Serialize)]
pub(crate) struct PersonState {
    pub name: String,
    pub at: Pose,
    pub radius_m: f64,
}

/// A device now.
#[derive(Debug, Serialize)]
pub(crate) struct DeviceState {
    pub name: String,
    pub on: bool,
}

/// The decision machine now.
#[derive(Debug, Serialize)]
pub(crate) struct DecisionState {
    pub scans: u64,
    pub resources: std::collections::BTreeMap<String, u8>,
    pub timers: Vec<TimerState>,
    pub run: bool,
    /// False while the outputs have their fail-safe values.
    pub drives_outputs: bool,
    /// Code of the error that the program stands on.
    pub fault: Option<&'static str>,
    /// What the node's clock shows: `2026-03-01 07:30:00.00`.
    pub clock: String,
    pub n_watchdog_resets: u64,
    pub n_events: u64,
    /// Number of the last MOVE, 0 before the first, and what became of it.
    pub last_move: (u64, &'static str),
    pub edges: Vec<Edge>,
}

/// A timer that the program uses.
#[derive(Debug, Serialize)]
pub(crate) struct TimerState {
    pub index: u8,
    pub remaining_s: f64,
    pub total_s: f64,
    pub on: bool,
}

/// Decoded packets.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "trace")]
pub(crate) struct Trace {
    pub items: Vec<TraceItem>,
}

/// One decoded packet.
#[derive(Debug, Serialize)]
pub(crate) struct TraceItem {
    pub t_s: f64,
    pub link: usize,
    pub to: String,
    pub hex: String,
    pub text: String,
}

/// Events in words.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "log")]
pub(crate) struct Log {
    pub items: Vec<LogItem>,
}

/// One event.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LogItem {
    pub t_s: f64,
    pub level: &'static str,
    pub text: String,
}

/// What was shown before, for the page that asked: this, then `"state":` and the state of that time.
#[derive(Debug, Serialize)]
pub(crate) struct PastHead {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub asked_s: f64,
    pub kept: Kept,
}

/// The answer to a request that cannot be carried out.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "error")]
pub(crate) struct Refusal {
    pub text: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_as_the_page_writes_them() {
        let read = |text| serde_json::from_str::<Request>(text);
        assert_eq!(read(r#"{"type":"play"}"#).unwrap(), Request::Play);
        assert_eq!(
            read(r#"{"type":"restart","seed":7,"mission":null}"#).unwrap(),
            Request::Restart { seed: Some(7), mission: None }
        );
        assert_eq!(
            read(r#"{"type":"cut","robot":0,"line":"ground","cut":true}"#).unwrap(),
            Request::Cut { robot: 0, line: missions::Line::Ground, cut: true }
        );
        assert_eq!(
            read(r#"{"type":"place","at_m":[1.5,-2],"size_m":0.4}"#).unwrap(),
            Request::Place { at_m: [1.5, -2.0], size_m: 0.4 }
        );
    }

    #[test]
    fn unknown_requests_and_keys_are_refused() {
        for text in [r#"{"type":"fly"}"#, r#"{"type":"speed","ratio":1,"x":2}"#, "[]", ""] {
            assert!(serde_json::from_str::<Request>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_type_comes_first() {
        let text = serde_json::to_string(&Refusal { text: "no".to_owned() }).unwrap();
        assert_eq!(text, r#"{"type":"error","text":"no"}"#);
    }
}
