//! What a navigator is told and what it answers: plain data, no wire, no clock.

use geometry::{Base, Map, Odom, Transform2};
use robot_models::WheelSpeeds;
use run_context::Stamp;
use sensor_models::TagMemory;

/// Greatest number of range sensors in one [`RobotStatus`].
pub const N_SONARS_MAX: usize = 16;

/// Something that was sensed or received, and the time it is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// When it was true; not when it was handled.
    pub about: Stamp,
    /// What it is.
    pub value: Sensed,
}

/// Everything a navigator can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensed {
    /// The vehicle's own report.
    Robot(RobotStatus),
    /// The pheromone server's answer to [`Command::QueryPheromones`] with the same `query`.
    Pheromones {
        /// The number of the question, echoed.
        query: u8,
        /// Intensity at the left antenna, 0–255 on the wire.
        left: f64,
        /// Intensity at the right antenna, 0–255 on the wire.
        right: f64,
    },
    /// A reader has read a tag in the floor.
    Tag(TagRead),
    /// An order from the ground.
    Ground(GroundCommand),
    /// The vehicle answers (again).
    LinkUp,
    /// The vehicle does not answer any more; what was known of it is old.
    LinkDown,
}

/// A tag in the floor that a reader has read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagRead {
    /// Which reader: its place in [`TagSettings::readers_in_base`](crate::TagSettings::readers_in_base), the left one first.
    pub reader: u8,
    /// The tag's own number.
    pub tag: u32,
    /// What it stores.
    pub memory: TagMemory,
}

/// What the vehicle says about itself; a decoded server information packet, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotStatus {
    /// Dead-reckoned pose: (0, 0, 0) where the robot was switched on.
    pub odom_from_base: Transform2<Odom, Base>,
    /// Measured wheel speeds.
    pub wheel_speeds: WheelSpeeds,
    /// Latest range of each sensor, metres; the range limit where nothing was heard.
    pub sonar_ranges_m: [f64; N_SONARS_MAX],
    /// How old each of them was at the time that the status is about, as well as the driver knows, milliseconds; what is
    /// older than 65 s is 65 535.
    pub sonar_ages_ms: [u16; N_SONARS_MAX],
    /// How many of `sonar_ranges_m` exist.
    pub n_sonars: usize,
    /// Bit i: sensor i was measured anew since the last status.
    pub sonar_fresh: u16,
    /// The left and right wheel are driven but do not turn, or a bumper is pressed.
    pub stalled: [bool; 2],
    /// The robot itself says that it moves.
    pub moving: bool,
    /// The motors answer references.
    pub motors_enabled: bool,
    /// Battery, volts.
    pub battery_v: f64,
}

/// Whole milliseconds from `measured` to `about`, as [`RobotStatus::sonar_ages_ms`] holds them.
pub fn age_ms(measured: Stamp, about: Stamp) -> u16 {
    u16::try_from(about.since(measured).as_millis()).unwrap_or(u16::MAX)
}

/// An order from the ground station or from the decision program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroundCommand {
    /// Go to that pose.
    GoTo {
        /// Where to stand in the end, and which way to look.
        goal_in_map: Transform2<Map, Base>,
    },
    /// Stop now and forget the goal.
    Stop,
    /// Forget everything but the pose, switch the motors on again.
    Restart,
    /// Send the latest sonar ranges once.
    ReportSonar,
    /// Say something.
    LinkTest,
}

/// Everything a navigator can ask of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Turn the wheels at these speeds until told otherwise.
    Drive(WheelSpeeds),
    /// Turn in place to this heading, then stand.
    TurnTo {
        /// The heading in the robot's own dead reckoning, radians, in [−π, π).
        heading_in_odom_rad: f64,
    },
    /// Stand.
    Stop,
    /// Switch the motors on or off.
    EnableMotors(bool),
    /// Ask the pheromone server what a robot at that pose would smell.
    QueryPheromones {
        /// A number to tell the answers apart.
        query: u8,
        /// The pose; not necessarily where the robot is.
        map_from_base: Transform2<Map, Base>,
    },
    /// Tell the ground.
    Report(Report),
}

/// What a navigator tells the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Report {
    /// The avoider's machine entered this state, 0–8.
    StateEntered(u8),
    /// The robot stands at its goal, looking the right way.
    Arrived,
    /// The navigator gave up and stands.
    Failed(FailureReason),
    /// The latest sonar ranges, metres, of sensors 0–7; the sender fills the packet from these.
    Sonar([f64; 8]),
    /// The answer to [`GroundCommand::LinkTest`].
    LinkEcho,
}

/// Why a navigator gave up. Every limit of every phase ends here, visibly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FailureReason {
    /// No pheromone was found within reach of the robot.
    NoTrail,
    /// Trails exist here, but none leads to the goal.
    NoTrailToGoal,
    /// The trail was lost on the way and not found again.
    TrailLost,
    /// The way stayed blocked after all permitted attempts.
    Blocked,
    /// The robot cannot turn or move here without touching something, or its wheels stall.
    Stuck,
    /// A phase took longer than it may.
    TimedOut,
    /// No progress towards the goal for too long.
    NoProgress,
    /// The vehicle stopped answering.
    LinkLost,
    /// The pheromone server stopped answering.
    ServerSilent,
    /// The order itself makes no sense, such as a goal that is not finite.
    BadGoal,
    /// The robot stands beside its goal and does not get within the tolerance.
    MissedGoal,
}

impl FailureReason {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::NoTrail,
        Self::NoTrailToGoal,
        Self::TrailLost,
        Self::Blocked,
        Self::Stuck,
        Self::TimedOut,
        Self::NoProgress,
        Self::LinkLost,
        Self::ServerSilent,
        Self::BadGoal,
        Self::MissedGoal,
    ];

    /// The word for it in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::NoTrail => "no_trail",
            Self::NoTrailToGoal => "no_trail_to_goal",
            Self::TrailLost => "trail_lost",
            Self::Blocked => "blocked",
            Self::Stuck => "stuck",
            Self::TimedOut => "timed_out",
            Self::NoProgress => "no_progress",
            Self::LinkLost => "link_lost",
            Self::ServerSilent => "server_silent",
            Self::BadGoal => "bad_goal",
            Self::MissedGoal => "missed_goal",
        }
    }

    /// A few words for people.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::NoTrail => "no trail within reach",
            Self::NoTrailToGoal => "no trail leads to the goal",
            Self::TrailLost => "the trail was lost",
            Self::Blocked => "the way stayed blocked",
            Self::Stuck => "stuck: no room to move",
            Self::TimedOut => "a phase took too long",
            Self::NoProgress => "no progress",
            Self::LinkLost => "the vehicle does not answer",
            Self::ServerSilent => "the pheromone server does not answer",
            Self::BadGoal => "the goal is not a pose",
            Self::MissedGoal => "cannot stand as near to its goal as asked",
        }
    }
}

impl settings::Choice for FailureReason {
    const ALL: &'static [Self] = &Self::ALL;

    fn key(self) -> &'static str {
        self.key()
    }

    fn about(self) -> &'static str {
        self.as_str()
    }
}
