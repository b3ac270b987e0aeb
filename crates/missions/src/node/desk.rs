//! A desk at the ground: what somebody there wants of one robot, and what is known of it there.
//!
//! Whoever answers at the ground's end of a line reads and writes it; the run puts orders on it.

use drivers::{GoalNews, GroundStationEvent, failure_text};
use geometry::Se2;

use crate::asked::Asked;

/// An order from the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GroundOrder {
    GoTo(Se2),
    Stop,
    /// To forget its goal and connect to the robot anew.
    Restart,
}

/// What the ground knows of the last goal that it sent a robot to, from the robot's reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Telemetry {
    /// There is none: nothing was sent yet, or the last order was to stop.
    #[default]
    NoGoal,
    /// No report of its end has come.
    UnderWay,
    /// The robot stands there.
    Arrived,
    /// It will not come there; why, in the words of the ground's table.
    Failed(&'static str),
}

/// The desk of one robot.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    /// An order that leaves at the next step.
    pub(crate) order: Option<GroundOrder>,
    /// A question that leaves at the next step.
    pub(crate) question: Option<Asked>,
    pub(crate) telemetry: Telemetry,
    /// What the ground learnt in this step.
    pub(crate) events: Vec<GroundStationEvent>,
}

impl Telemetry {
    /// The robot has not answered for as long as the ground waits.
    pub(crate) const SILENT: Self = Self::Failed("the robot does not answer the ground");

    pub(crate) fn hear(&mut self, event: GroundStationEvent) {
        // The station lets through only what is about its last goal.
        let GroundStationEvent::Goal { news, .. } = event else { return };
        match news {
            GoalNews::UnderWay => {}
            GoalNews::Arrived => self.end(Self::Arrived),
            GoalNews::Failed(code) => self.end(Self::Failed(failure_text(code))),
            GoalNews::Forgotten => self.end(Self::Failed("the robot does not know of it any more")),
            GoalNews::Silent => self.end(Self::SILENT),
        }
    }

    /// The end of the goal that is under way; without one there is nothing to end.
    pub(crate) fn end(&mut self, end: Self) {
        if *self == Self::UnderWay {
            *self = end;
        }
    }
}
