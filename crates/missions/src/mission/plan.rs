//! What a checked mission consists of: SI units, names resolved to indices, nothing left to fail.

use std::{fmt, sync::Arc, time::Duration};

use decision::{DateTime, Failsafe, Mnemonic, MovePoints, Program};
use geometry::{Se2, Segment, Vec2};
use navigator::NavigatorConfig;
use path_following::Path;
use pheromones::{Field, SenseConfig};
use robot_models::{OdometryErrors, RobotModel};
use run_context::Stamp;
use sensor_models::{LaserKind, LaserModel, SonarModel, TagReaderModel};
use simulator::floor_plan::FloorPlan;
use wire::link::LinkConfig;

use crate::{
    asked::Asked,
    cut::{Direction, Line},
};

/// The static surroundings and everything in them.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorldPlan {
    pub(crate) bounds: [f64; 4],
    pub(crate) walls: Vec<(Segment, u32)>,
    /// So many of them, the first, are the borders of the map's solid cells.
    pub(crate) n_borders: usize,
    pub(crate) points: Vec<(Vec2, u32)>,
    pub(crate) point_size_m: f64,
    /// The map that walls and points came from, without them.
    pub(crate) map: Option<Arc<FloorPlan>>,
    pub(crate) rooms: Vec<(String, Vec2)>,
    pub(crate) things: Vec<ThingPlan>,
    pub(crate) people: Vec<PersonPlan>,
    pub(crate) random_boxes: Vec<RandomBoxes>,
}

impl WorldPlan {
    /// Whether a place (m) is within what the map has as solid.
    pub(crate) fn is_solid(&self, place: Vec2) -> bool {
        self.map.as_ref().is_some_and(|map| map.is_solid(place))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlannedKind {
    Furniture,
    Box,
    Door,
}

settings::choices!(PlannedKind {
    Furniture = "furniture": "stands where it is",
    Box = "box": "may be put down and taken away",
    Door = "door": "is part of the building",
});

#[derive(Clone, Debug)]
pub(crate) struct ThingPlan {
    pub(crate) name: String,
    pub(crate) kind: PlannedKind,
    pub(crate) corners: Vec<Vec2>,
    pub(crate) material: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct PersonPlan {
    pub(crate) name: String,
    pub(crate) route: Vec<Vec2>,
    pub(crate) speed_mps: f64,
    pub(crate) speed_spread_mps: f64,
    pub(crate) starts_at_s: f64,
    pub(crate) starts_spread_s: f64,
    pub(crate) repeats: bool,
    pub(crate) yields: bool,
    pub(crate) radius_m: f64,
}

/// Where random boxes may stand.
#[derive(Clone, Debug)]
pub(crate) enum BoxRegion {
    /// Arc lengths of the trail and the greatest distance from it, metres.
    AlongTrail { from_m: f64, to_m: f64, offset_max_m: f64 },
    /// x0, y0, x1, y1, metres.
    Area([f64; 4]),
}

#[derive(Clone, Debug)]
pub(crate) struct RandomBoxes {
    pub(crate) name: String,
    pub(crate) count: usize,
    pub(crate) size_m: Vec2,
    pub(crate) material: u32,
    pub(crate) region: BoxRegion,
    pub(crate) passage_m: f64,
    pub(crate) clearance_m: f64,
}

/// What a device is, and how it is wired.
#[derive(Clone, Debug)]
pub(crate) enum DeviceWiring {
    Button { input: Option<u8> },
    Motion { input: Option<u8>, zone: geometry::Polygon },
    Latch { output: u8, failsafe: FailsafeOutput },
    Lamp { output: u8, failsafe: FailsafeOutput },
}

/// What an output does while no program drives it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FailsafeOutput {
    #[default]
    Off,
    On,
    Hold,
}

settings::choices!(FailsafeOutput {
    Off = "off": "off",
    On = "on": "on",
    Hold = "hold": "as the program left it",
});

#[derive(Clone, Debug)]
pub(crate) struct DevicePlan {
    pub(crate) name: String,
    pub(crate) label: String,
    pub(crate) at: Vec2,
    pub(crate) wiring: DeviceWiring,
}

/// The line between two nodes.
#[derive(Clone, Debug)]
pub(crate) enum LinkPlan {
    /// Bytes in memory, in virtual time.
    Memory(LinkConfig),
    /// No bytes: messages are handed over at once.
    Direct,
    /// Bytes over a socket to a robot elsewhere.
    Tcp { address: String },
    /// Bytes over a serial line to a robot elsewhere.
    Serial { device: String, baud: u32 },
}

impl LinkPlan {
    /// Bits per second, 0 when there is no limit.
    pub(crate) fn baud(&self) -> u32 {
        match self {
            Self::Memory(config) => config.baud.unwrap_or(0),
            Self::Direct | Self::Tcp { .. } => 0,
            Self::Serial { baud, .. } => *baud,
        }
    }
}

/// One robot; tables with a count above one become several of these.
#[derive(Clone, Debug)]
pub(crate) struct RobotPlan {
    pub(crate) name: String,
    /// Name in the file, shared by all robots of one table.
    pub(crate) group: String,
    pub(crate) model: Arc<RobotModel>,
    pub(crate) start: Se2,
    pub(crate) errors: OdometryErrors,
    pub(crate) sonar: SonarModel,
    pub(crate) link: LinkPlan,
    pub(crate) navigator: Arc<NavigatorConfig>,
    pub(crate) lasers: Vec<LaserPlan>,
    /// What the path method follows.
    pub(crate) path: Option<Path>,
    /// Places (m, map) that the straight method visits before every goal.
    pub(crate) via: Vec<Vec2>,
    /// Its readers of tags, if it has any.
    pub(crate) tag_readers: Option<TagReadersPlan>,
    /// Who drives it by hand.
    pub(crate) teleoperator: Option<TeleoperatorPlan>,
}

impl RobotPlan {
    /// Whether it is at the end of a socket or a serial line, and has no body here.
    pub(crate) fn is_elsewhere(&self) -> bool {
        matches!(self.link, LinkPlan::Tcp { .. } | LinkPlan::Serial { .. })
    }
}

/// A laser on a robot.
#[derive(Clone, Debug)]
pub(crate) struct LaserPlan {
    pub(crate) name: String,
    pub(crate) kind: LaserKind,
    pub(crate) model: LaserModel,
    pub(crate) base_from_sensor: Se2,
    pub(crate) link: LinkPlan,
}

/// A person who drives a robot along a path over the floor.
#[derive(Clone, Debug)]
pub(crate) struct TeleoperatorPlan {
    pub(crate) path: Path,
    pub(crate) speed_mps: f64,
    pub(crate) starts_at: Stamp,
}

/// Readers of tags under a robot.
#[derive(Clone, Debug)]
pub(crate) struct TagReadersPlan {
    /// Where they are (m, base frame), the left one first.
    pub(crate) in_base: Vec<Vec2>,
    pub(crate) model: TagReaderModel,
    /// What the robot adds to a tag of the trail that it passes.
    pub(crate) amplify: u8,
}

/// Tags in the floor, and the trail in them.
#[derive(Clone, Debug)]
pub(crate) struct TagsPlan {
    pub(crate) trails: Vec<Vec<Vec2>>,
    pub(crate) width_cells: usize,
    pub(crate) peak: u8,
    pub(crate) pitch_m: f64,
    /// x0, y0, x1, y1, metres.
    pub(crate) area_m: [f64; 4],
    pub(crate) missing_ratio: f64,
    /// Zero: tags store no look-ahead points.
    pub(crate) look_ahead_m: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct PheromonePlan {
    pub(crate) field: Arc<Field>,
    pub(crate) trails: Vec<Vec<Vec2>>,
    pub(crate) sense: SenseConfig,
    pub(crate) scale_ratio: f64,
    pub(crate) link: LinkPlan,
}

#[derive(Clone, Debug)]
pub(crate) struct DecisionPlan {
    pub(crate) source: String,
    pub(crate) program: Program,
    pub(crate) listing_mode: bool,
    /// Index of the robot that MOVE commands.
    pub(crate) robot: Option<usize>,
    /// The inputs that say what became of the last MOVE.
    pub(crate) points: MovePoints,
    /// What the outputs do while the program does not drive them.
    pub(crate) failsafe: Failsafe,
    /// Whether the robot stops with the program.
    pub(crate) stops_robot: bool,
    /// The clock of the node at the beginning.
    pub(crate) clock: DateTime,
    /// Time after which the watchdog restarts a loop that stands; zero: never.
    pub(crate) watchdog: Duration,
    /// How long the ground waits for an answer of the robot, beside the way there and back.
    pub(crate) answer_within: Duration,
    pub(crate) link: LinkPlan,
}

impl DecisionPlan {
    /// Whether its program has such a function.
    pub(crate) fn has_function(&self, mnemonic: Mnemonic) -> bool {
        self.program.functions().iter().any(|function| function.mnemonic == mnemonic)
    }
}

/// What an operator does to the decision program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProgramAction {
    Stop,
    Run,
    /// The loop of the node stands still for so many steps of 10 ms.
    Stall {
        n_steps: u64,
    },
}

impl fmt::Display for ProgramAction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stop => f.write_str("the decision program is stopped (QRUN 0)"),
            Self::Run => f.write_str("the decision program is set running (QRUN 1)"),
            Self::Stall { n_steps } => {
                let seconds = *n_steps as f64 / 100.0;
                write!(f, "the loop of the decision node stands still for {seconds} s")
            }
        }
    }
}

/// Something that happens.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    Button {
        device: usize,
        pressed: bool,
    },
    Goal {
        robots: Vec<usize>,
        pose: GoalPose,
    },
    Stop {
        robots: Vec<usize>,
    },
    /// The ground asks these robots something, or to begin anew.
    Ask {
        robots: Vec<usize>,
        asked: Asked,
    },
    PlaceBox {
        name: String,
        at: Vec2,
        size_m: f64,
    },
    Remove {
        name: String,
    },
    /// Cuts the lines of these robots, or mends them.
    Link {
        robots: Vec<usize>,
        line: Line,
        direction: Direction,
        cut: bool,
    },
    Program(ProgramAction),
}

/// A pose in the map, or relative to where each robot started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GoalPose {
    InMap(Se2),
    FromStart(Se2),
}

impl GoalPose {
    /// The pose in the map for a robot that started at `start`.
    pub(crate) fn resolve(self, start: Se2) -> Se2 {
        match self {
            Self::InMap(pose) => pose,
            Self::FromStart(pose) => start.compose(pose),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EventPlan {
    pub(crate) at: Stamp,
    pub(crate) after_arrival: bool,
    pub(crate) action: Action,
}
