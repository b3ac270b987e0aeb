//! What a run shows: plain structs for screens and recordings, never read back.
//!
//! Coordinates are in the map frame, metres, x right, y up; poses are [`Se2`] (m, m, rad).

use geometry::{Se2, Vec2};

use crate::{cut::Line, verdict::Verdict};

/// What does not change during a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// x0, y0, x1, y1 (m).
    pub bounds_m: [f64; 4],
    /// Walls.
    pub walls: Vec<SceneWall>,
    /// Wall points of a scanned map (m).
    pub points_m: Vec<Vec2>,
    /// Things that were there at the beginning.
    pub things: Vec<SceneThing>,
    /// Names of rooms and where to write them (m).
    pub rooms: Vec<(String, Vec2)>,
    /// Devices of the smart environment, in the order of [`ViewState::devices_on`].
    pub devices: Vec<SceneDevice>,
    /// Robots, in the order of [`ViewState::robots`].
    pub robots: Vec<SceneRobot>,
    /// The pheromone field.
    pub pheromones: Option<ScenePheromones>,
    /// The tags in the floor.
    pub tags: Option<SceneTags>,
    /// The trails or, without them, the straight lines to the goals (m).
    pub planned_path_m: Vec<Vec2>,
    /// The decision program.
    pub program: Option<SceneProgram>,
    /// The links, by index, as [`TraceItem::link`] names them.
    pub links: Vec<SceneLink>,
}

/// A piece of wall.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWall {
    /// One end (m).
    pub a: Vec2,
    /// The other end (m).
    pub b: Vec2,
    /// Name of its material.
    pub material: String,
}

/// A thing that stands somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneThing {
    /// Number that [`Intervention::RemoveThing`](crate::Intervention::RemoveThing) takes.
    pub id: u64,
    /// Its name.
    pub name: String,
    /// `furniture`, `box` or `door`.
    pub kind: &'static str,
    /// Name of its material.
    pub material: String,
    /// Corners, counter-clockwise (m).
    pub corners_m: Vec<Vec2>,
    /// Whether it may be taken away: it was put down during the run.
    pub removable: bool,
}

/// A device of the smart environment.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDevice {
    /// Its name.
    pub name: String,
    /// What people read.
    pub label: String,
    /// `button`, `motion`, `latch` or `lamp`.
    pub kind: &'static str,
    /// Where it is (m).
    pub at_m: Vec2,
    /// What a motion detector watches (m); empty for others.
    pub area_m: Vec<Vec2>,
    /// Digital input of the decision program.
    pub input: Option<u8>,
    /// Digital output of the decision program.
    pub output: Option<u8>,
}

/// A robot's fixed features.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRobot {
    /// Its name.
    pub name: String,
    /// Title of its model.
    pub model: String,
    /// Outline in its base frame (m).
    pub footprint_m: Vec<Vec2>,
    /// Its sonars.
    pub sonars: Vec<SceneSonar>,
    /// Its planar scanners, in the order that [`ViewScan::scanner`] counts.
    pub scanners: Vec<SceneScanner>,
    /// Where it started.
    pub start: Se2,
    /// Its readers of tags in its base frame (m), and the radius of their recognition areas, m.
    pub tag_readers_m: Vec<Vec2>,
    /// Zero without readers, m.
    pub tag_range_m: f64,
    /// How near it has to come to its goal, if the mission demands that it arrives, m.
    pub goal_tolerance_m: Option<f64>,
    /// It is no body of this simulation but at the end of a socket or a serial line: what cannot be measured from
    /// outside is not known of it.
    pub is_elsewhere: bool,
    /// Greatest speed by hand, m/s.
    pub hand_speed_max_mps: f64,
    /// Greatest turning rate by hand, rad/s.
    pub hand_turn_rate_max_radps: f64,
}

/// One sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSonar {
    /// Pose in the robot's base frame.
    pub base_from_sensor: Se2,
    /// Half the opening of its cone, rad.
    pub half_angle_rad: f64,
    /// Greatest range, m.
    pub range_max_m: f64,
}

/// One planar scanner, such as a laser.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneScanner {
    /// Its name in the mission.
    pub name: String,
    /// Pose in the robot's base frame.
    pub base_from_sensor: Se2,
    /// Where its first beam looks in its own frame, rad.
    pub first_angle_rad: f64,
    /// From a beam to the next, counter-clockwise, rad; negative for a scanner that turns clockwise.
    pub step_rad: f64,
    /// Beams of a scan.
    pub n_beams: usize,
    /// Greatest range, m.
    pub range_max_m: f64,
}

/// Tags in the floor, as they are when the scene is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneTags {
    /// Between neighbours, m.
    pub pitch_m: f64,
    /// Where each tag that answers is (m), and the intensity that it stores.
    pub strengths: Vec<(Vec2, u8)>,
}

/// The pheromone field.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenePheromones {
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Lower left corner of cell (0, 0), which is the lowest row (m).
    pub origin_m: Vec2,
    /// Column, row (upwards) and value of every cell that is not empty.
    pub values: Vec<(usize, usize, u8)>,
    /// Perception radius, m.
    pub sigma_m: f64,
    /// Distance between the antennas, m.
    pub antenna_spacing_m: f64,
}

/// The decision program.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneProgram {
    /// Its source.
    pub source: String,
    /// `corrected` or `listing`.
    pub mode: &'static str,
    /// Its functions in program order.
    pub functions: Vec<SceneFunction>,
}

/// One function of the decision program.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFunction {
    /// Line in the source, from 1.
    pub line: usize,
    /// `AND`, `FF`, ….
    pub mnemonic: String,
    /// Its operands.
    pub operands: Vec<SceneOperand>,
}

/// One operand.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneOperand {
    /// As written.
    pub text: String,
    /// The resource's name; `None` for a number.
    pub resource: Option<String>,
    /// Column in its line, from 1.
    pub column: usize,
    /// Characters.
    pub length: usize,
}

/// A byte link between two nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneLink {
    /// What runs over it: `robot`, `pheromones` or `ground`, with the robot's name when there are several.
    pub name: String,
    /// The node that asks and the node that answers.
    pub ends: [&'static str; 2],
    /// Bits per second; 0: no limit.
    pub baud: u32,
    /// The robot whose line it is: index into [`Scene::robots`].
    pub robot: usize,
    /// Which line of the robot.
    pub line: Line,
}

/// What changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewState {
    /// Time since the beginning, s.
    pub t_s: f64,
    /// Steps of 10 ms since the beginning.
    pub step: u64,
    /// The verdict, once the run has ended.
    pub verdict: Option<Verdict>,
    /// The robots.
    pub robots: Vec<ViewRobot>,
    /// The people.
    pub people: Vec<ViewPerson>,
    /// Things put down during the run.
    pub things: Vec<SceneThing>,
    /// Whether each device is on, in the order of [`Scene::devices`].
    pub devices_on: Vec<bool>,
    /// The decision node.
    pub decision: Option<ViewDecision>,
    /// Figures so far.
    pub figures: ViewFigures,
    /// In the order of [`Signal::of_run`](crate::Signal::of_run); empty slots are not known, or not yet.
    pub signals: Vec<Option<f64>>,
}

/// A robot at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewRobot {
    /// Where it really is.
    pub truth: Pose,
    /// Where it believes it is.
    pub estimate: Pose,
    /// 95 % ellipse of that belief: semi-major, semi-minor (m), yaw (rad).
    pub ellipse: [f64; 3],
    /// True wheel speeds, left and right, m/s.
    pub wheels_mps: [f64; 2],
    /// What its sonars report, m.
    pub sonar_m: Vec<f64>,
    /// The newest scan of each planar scanner that has scanned and is not silent.
    pub scans: Vec<ViewScan>,
    /// Boundary of the sensitivity bubble per sonar, m; empty when there is none.
    pub bubble_m: Vec<f64>,
    /// What it is busy with.
    pub phase: &'static str,
    /// What it does about its goal, or why it gave it up, in a sentence; empty without a goal.
    pub task: String,
    /// State of the avoider's machine, 0 to 8.
    pub avoider_state: u8,
    /// The same in words.
    pub avoider_name: &'static str,
    /// Its goal.
    pub goal: Option<Pose>,
    /// The point that it drives to at present (m).
    pub target_m: Option<Vec2>,
    /// The path ahead as far as it knows it (m).
    pub preview_m: Vec<Vec2>,
    /// Intensities at its antennas: left, right.
    pub intensities: Option<[f64; 2]>,
    /// Distance to the left of the trail, m; true, not believed.
    pub cross_track_m: Option<f64>,
    /// Whether a wheel is stalled.
    pub stalled: bool,
    /// Whether it touches something.
    pub touching: bool,
    /// Distance from its footprint to the nearest surface, m; not known of a robot elsewhere.
    pub clearance_m: Option<f64>,
    /// Battery, V, once it was reported.
    pub battery_v: Option<f64>,
    /// Why it gave up, if it did.
    pub failure: Option<String>,
    /// In the order of [`Signal::of_robots`](crate::Signal::of_robots); empty slots are not known, or not yet.
    pub signals: Vec<Option<f64>>,
}

/// A planar scan, as the robot's program was given it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewScan {
    /// Which scanner: index into [`SceneRobot::scanners`].
    pub scanner: usize,
    /// Where the scanner truly was, and whither it looked, when its first beam measured: a scan is drawn where it was taken,
    /// not where the robot has driven since.
    pub at: Pose,
    /// By beam, m, at most [`SceneScanner::range_max_m`]: an echo; or [`ViewScan::FREE`], or [`ViewScan::UNSEEN`].
    pub ranges_m: Vec<f32>,
}

impl ViewScan {
    /// The beam came back from nothing: free as far as the scanner sees.
    pub const FREE: f32 = f32::INFINITY;
    /// The beam says nothing: it did not measure, was dazzled or got lost in glass. Unseen is not free.
    pub const UNSEEN: f32 = 0.0;
}

/// A robot in brief.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewPose {
    /// Where it really is.
    pub truth: Pose,
    /// Whether it touches something.
    pub touching: bool,
    /// Whether it has reported its arrival.
    pub arrived: bool,
}

/// A pose that has a default: x (m), y (m), yaw (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// x, m.
    pub x_m: f64,
    /// y, m.
    pub y_m: f64,
    /// Yaw, rad, in [−π, π).
    pub yaw_rad: f64,
}

impl From<Se2> for Pose {
    fn from(se2: Se2) -> Self {
        Self { x_m: se2.x_m, y_m: se2.y_m, yaw_rad: se2.yaw_rad }
    }
}

/// A person at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewPerson {
    /// The person's name.
    pub name: String,
    /// Where the person is, looking ahead.
    pub at: Pose,
    /// Radius of the body, m.
    pub radius_m: f64,
}

/// The decision node at one instant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ViewDecision {
    /// Scans since the beginning.
    pub scans: u64,
    /// The resources that the program names, with their bytes.
    pub resources: Vec<(String, u8)>,
    /// The timers that the program uses.
    pub timers: Vec<ViewTimer>,
    /// Whether the program runs.
    pub run: bool,
    /// The outputs in the field; bit n is output n.
    pub outputs: u16,
    /// Whether the program drives them; otherwise they have their fail-safe values.
    pub drives_outputs: bool,
    /// Code of the error that it stands on.
    pub fault: Option<&'static str>,
    /// What its clock shows: `2026-03-01 07:30:00.00`.
    pub clock: String,
    /// Restarts by its watchdog.
    pub n_watchdog_resets: u64,
    /// Events logged so far.
    pub n_events: u64,
    /// Number of the last MOVE, 0 before the first, and what became of it: `idle`, `busy`, `done` or
    /// `failed`.
    pub last_move: (u64, &'static str),
}

/// A timer at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewTimer {
    /// 0 to 31.
    pub index: usize,
    /// What is left, ms.
    pub remaining_ms: u64,
    /// What it was set to last, ms.
    pub total_ms: u64,
    /// Its output.
    pub on: bool,
}

/// Figures of the first robot, and contacts of all; none without a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewFigures {
    /// Way driven, m.
    pub path_length_m: Option<f64>,
    /// Time since the goal was given, or until arrival, s; none before the first goal.
    pub time_s: Option<f64>,
    /// Least clearance so far, m; none of a robot elsewhere, and while nothing has been within 5 m.
    pub clearance_min_m: Option<f64>,
    /// Contacts of all robots; not known when one of them is elsewhere.
    pub contacts: Option<u64>,
    /// Root mean square distance from the trail while following it, m.
    pub cross_track_rms_m: Option<f64>,
    /// Greatest distance from the trail while following it, m.
    pub cross_track_max_m: Option<f64>,
}

/// One packet that passed a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceItem {
    /// Step of 10 ms at which it was complete.
    pub step: u64,
    /// Index into [`Scene::links`].
    pub link: usize,
    /// The node that received it.
    pub to: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What they say.
    pub text: String,
}

/// How a log entry is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogLevel {
    /// News.
    Info,
    /// Something to look at.
    Warn,
    /// A success.
    Good,
    /// A failure.
    Bad,
}

impl LogLevel {
    /// `info`, `warn`, `good` or `bad`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warn => "warn",
            Self::Good => "good",
            Self::Bad => "bad",
        }
    }
}

/// An event in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogItem {
    /// Step of 10 ms at which it happened.
    pub step: u64,
    /// How it is meant.
    pub level: LogLevel,
    /// What happened.
    pub text: String,
}
