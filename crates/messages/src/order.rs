//! What the ground asks of a robot.

use geometry::{Base, Map, Transform2};

/// An order from the ground station or from the decision program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
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
