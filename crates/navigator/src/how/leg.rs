//! What a route says is to be done next.

use messages::FailureReason;
use path_following::{Course, WheelReference};

use geometry::Vec2;

/// What a route says is to be done next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leg {
    /// Nothing new.
    Rest,
    /// Stand for now.
    Stop,
    /// A corner was reached: stand, and begin the next piece.
    Corner,
    /// The goal lies straight ahead.
    ToGoal,
    /// Drive straight to the target of the task.
    Straight,
    /// Stand and look for the way from here.
    Look,
    /// Stand, and look for the way anew.
    LookAgain,
    /// The way begins beside: drive to this point (m, map) first.
    Join(Vec2),
    /// Turn to this heading (rad, map), in an arc where there is no room on the spot, and set out.
    TurnOut { heading_rad: f64, within_rad: f64 },
    /// Turn to this heading (rad, map) on the spot.
    Turn { heading_rad: f64, within_rad: f64 },
    /// The way lies ahead, or was found again: follow it.
    Follow,
    /// The same, after the way was left or turned to: its laws begin anew.
    TakeUp,
    /// The way was lost.
    Lost,
    /// Something is in the way.
    Blocked,
    /// Steer by what the antennas smell; stand meanwhile if they have smelled nothing for long.
    ByAntennas { stand: bool },
    /// Steer by tags.
    ByTags,
    /// Steer along the given path.
    ByCourse,
    /// Turn the wheels so.
    Wheels(WheelReference),
    /// There is no way.
    Failed(FailureReason),
}

/// A piece of a given path, and how fast the robot may be where it is on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CourseLeg<'a> {
    pub(crate) course: &'a Course,
    pub(crate) leg: usize,
    pub(crate) speed_mps: f64,
}

/// What an answer about the robot's own pose means for its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scent {
    /// The trail, and it leads on.
    Trail,
    /// The way is known better than it smells: drive along this line (m, map).
    Line { from: Vec2, to: Vec2 },
    /// Nothing: drive on slowly with these wheels.
    Nothing(WheelReference),
}
