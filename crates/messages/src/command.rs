//! What a mind asks of the world, and what it tells the ground.

use geometry::{Base, Map, Transform2};
use robot_models::WheelSpeeds;

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
    /// The answer to [`Order::LinkTest`](crate::Order::LinkTest).
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
    /// The goal is solid, outside or too narrow on the map that is planned on.
    GoalBlocked,
    /// No way leads to the goal on the map that is planned on.
    NoWay,
}

impl FailureReason {
    /// All of them.
    pub const ALL: [Self; 13] = [
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
        Self::GoalBlocked,
        Self::NoWay,
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
            Self::GoalBlocked => "goal_blocked",
            Self::NoWay => "no_way",
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
            Self::GoalBlocked => "the goal has no room for it on its map",
            Self::NoWay => "no way leads there on its map",
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
