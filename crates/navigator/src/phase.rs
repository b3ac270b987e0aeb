//! What a mind is busy with: one word for people, which the order of its steps follows.

use messages::FailureReason;

/// What a navigator is busy with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// No goal.
    #[default]
    Idle,
    /// Standing; asks the server around itself where a trail is and where it leads.
    AimAtTrail,
    /// Drives towards the trail, or to its target, in a straight line.
    DriveToTarget,
    /// Follows the trail.
    FollowTrail,
    /// Stands before an obstacle and waits for it to go away (extension).
    Wait,
    /// Stands because what it looks with is silent (extension).
    Blind,
    /// Goes around an obstacle.
    Avoid,
    /// Drives back to the trail beyond an obstacle.
    Rejoin,
    /// Lost the trail: drives on slowly, then looks around.
    LostTrail,
    /// Drives straight to the goal.
    Approach,
    /// Turns to the goal's heading.
    AlignHeading,
    /// Stands at the goal.
    Arrived,
    /// Gave up and stands.
    Failed(FailureReason),
}

impl Phase {
    /// A few words for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::AimAtTrail => "looking for the trail",
            Self::DriveToTarget => "driving to the target",
            Self::FollowTrail => "following the trail",
            Self::Wait => "waiting for the way to clear",
            Self::Blind => "waiting for its range sensors, which are silent",
            Self::Avoid => "avoiding an obstacle",
            Self::Rejoin => "rejoining the trail",
            Self::LostTrail => "trail lost",
            Self::Approach => "approaching the goal",
            Self::AlignHeading => "turning to the goal's heading",
            Self::Arrived => "arrived",
            Self::Failed(_) => "failed",
        }
    }
}
