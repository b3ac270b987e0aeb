//! What a person may do to a running mission. Every intervention is recorded with its step, so that a
//! replay repeats it.

use geometry::{Se2, Vec2};
use serde::{Deserialize, Serialize};

use crate::cut::{Direction, Line};

/// An interference from outside.
#[derive(Clone, Debug, PartialEq)]
pub enum Intervention {
    /// Presses a button for half a second.
    PressButton {
        /// Name of the device.
        device: String,
    },
    /// Puts down a box with sides of `size_m`.
    PlaceBox {
        /// Centre (m).
        at: Vec2,
        /// Side, m, from 0.05 to 3.
        size_m: f64,
    },
    /// Takes away a thing that was put down during the run.
    RemoveThing {
        /// Its number.
        id: u64,
    },
    /// Sends a robot to a pose, as the ground station does.
    SendGoal {
        /// Index of the robot.
        robot: usize,
        /// The pose in the map.
        goal_in_map: Se2,
    },
    /// Stops a robot.
    Stop {
        /// Index of the robot.
        robot: usize,
    },
    /// Drives a robot by hand for [`DRIVE_HOLD`](crate::DRIVE_HOLD); to drive on, say it again. The robot forgets its
    /// task. What it may not do is scaled down, both numbers together, so that the curve stays.
    Drive {
        /// Index of the robot.
        robot: usize,
        /// Forwards, m/s; kept in steps of 1 mm/s.
        speed_mps: f64,
        /// Counter-clockwise, rad/s; kept in steps of 1 mrad/s.
        turn_rate_radps: f64,
    },
    /// Cuts one of a robot's lines: nothing passes any more.
    CutLink {
        /// Index of the robot.
        robot: usize,
        /// Which line.
        line: Line,
        /// Which way.
        direction: Direction,
    },
    /// Mends it.
    RestoreLink {
        /// Index of the robot.
        robot: usize,
        /// Which line.
        line: Line,
        /// Which way.
        direction: Direction,
    },
    /// Ends the task of every robot for good: they stop, and take no more orders.
    Halt,
}

/// Why an intervention was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InterventionError {
    /// No such button.
    #[error("there is no button `{device}`; buttons: {buttons}")]
    NoSuchButton {
        /// What was asked for.
        device: String,
        /// What there is.
        buttons: String,
    },
    /// No such robot.
    #[error("there is no robot {robot}; the mission has {n_robots}, counted from 0")]
    NoSuchRobot {
        /// What was asked for.
        robot: usize,
        /// How many there are.
        n_robots: usize,
    },
    /// Nothing with that number was put down during the run.
    #[error("there is no thing {id} that may be taken away")]
    NoSuchThing {
        /// What was asked for.
        id: u64,
    },
    /// The box would stand on something.
    #[error("a box of {size_m:.2} m cannot stand at ({x_m:.2}, {y_m:.2}) m: {reason}")]
    NoRoom {
        /// Centre, m.
        x_m: f64,
        /// Centre, m.
        y_m: f64,
        /// Side, m.
        size_m: f64,
        /// What is in the way.
        reason: String,
    },
    /// The mission has no such line.
    #[error("{robot} has no line to a pheromone server: the mission has no [pheromones]")]
    NoSuchLine {
        /// The robot.
        robot: String,
    },
    /// The robot has no such laser.
    #[error("{robot} has no laser {number}, counted from 0")]
    NoSuchLaser {
        /// The robot.
        robot: String,
        /// What was asked for.
        number: u8,
    },
    /// Every robot was told to stand, for good.
    #[error("the run is over: every robot was told to stand")]
    Halted,
    /// A number that makes no sense.
    #[error("{what} must be {allowed}")]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// What it must be.
        allowed: &'static str,
    },
}

/// An intervention and when it came.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedIntervention {
    /// Before this step was taken.
    pub step: u64,
    /// What it was.
    pub intervention: Intervention,
}

/// The form in which recordings hold it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "do", deny_unknown_fields)]
pub(crate) enum InterventionRecord {
    Press { step: u64, device: String },
    Place { step: u64, x_m: f64, y_m: f64, size_m: f64 },
    Remove { step: u64, id: u64 },
    Goal { step: u64, robot: usize, x_m: f64, y_m: f64, yaw_rad: f64 },
    Stop { step: u64, robot: usize },
    Drive { step: u64, robot: usize, speed_mmps: i32, turn_rate_mradps: i32 },
    CutLink { step: u64, robot: usize, line: Line, direction: Direction },
    RestoreLink { step: u64, robot: usize, line: Line, direction: Direction },
    Halt { step: u64 },
}

impl From<&RecordedIntervention> for InterventionRecord {
    fn from(r: &RecordedIntervention) -> Self {
        let step = r.step;
        match &r.intervention {
            Intervention::PressButton { device } => Self::Press { step, device: device.clone() },
            Intervention::PlaceBox { at, size_m } => {
                Self::Place { step, x_m: at.x, y_m: at.y, size_m: *size_m }
            }
            Intervention::RemoveThing { id } => Self::Remove { step, id: *id },
            Intervention::SendGoal { robot, goal_in_map: g } => {
                Self::Goal { step, robot: *robot, x_m: g.x_m, y_m: g.y_m, yaw_rad: g.yaw_rad }
            }
            Intervention::Stop { robot } => Self::Stop { step, robot: *robot },
            Intervention::Drive { robot, speed_mps, turn_rate_radps } => Self::Drive {
                step,
                robot: *robot,
                speed_mmps: thousandths(*speed_mps),
                turn_rate_mradps: thousandths(*turn_rate_radps),
            },
            &Intervention::CutLink { robot, line, direction } => {
                Self::CutLink { step, robot, line, direction }
            }
            &Intervention::RestoreLink { robot, line, direction } => {
                Self::RestoreLink { step, robot, line, direction }
            }
            Intervention::Halt => Self::Halt { step },
        }
    }
}

impl From<InterventionRecord> for RecordedIntervention {
    fn from(r: InterventionRecord) -> Self {
        let (step, intervention) = match r {
            InterventionRecord::Press { step, device } => {
                (step, Intervention::PressButton { device })
            }
            InterventionRecord::Place { step, x_m, y_m, size_m } => {
                (step, Intervention::PlaceBox { at: Vec2::new(x_m, y_m), size_m })
            }
            InterventionRecord::Remove { step, id } => (step, Intervention::RemoveThing { id }),
            InterventionRecord::Goal { step, robot, x_m, y_m, yaw_rad } => {
                let goal_in_map =
                    Se2::new(x_m, y_m, if yaw_rad.is_finite() { yaw_rad } else { 0.0 });
                (step, Intervention::SendGoal { robot, goal_in_map })
            }
            InterventionRecord::Stop { step, robot } => (step, Intervention::Stop { robot }),
            InterventionRecord::Drive { step, robot, speed_mmps, turn_rate_mradps } => {
                let [speed_mps, turn_rate_radps] =
                    [speed_mmps, turn_rate_mradps].map(from_thousandths);
                (step, Intervention::Drive { robot, speed_mps, turn_rate_radps })
            }
            InterventionRecord::CutLink { step, robot, line, direction } => {
                (step, Intervention::CutLink { robot, line, direction })
            }
            InterventionRecord::RestoreLink { step, robot, line, direction } => {
                (step, Intervention::RestoreLink { robot, line, direction })
            }
            InterventionRecord::Halt { step } => (step, Intervention::Halt),
        };
        Self { step, intervention }
    }
}

/// A number as recordings hold it: text of a whole number comes back as the same bits.
fn thousandths(value: f64) -> i32 {
    // Casts from floats saturate.
    (1e3 * value).round() as i32
}

fn from_thousandths(value: i32) -> f64 {
    f64::from(value) / 1e3
}

/// What a run takes and its recording gives back.
pub(crate) fn to_thousandths(value: f64) -> f64 {
    from_thousandths(thousandths(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is driven is what is recorded, bit for bit, through the text of the recording.
    #[test]
    fn a_drive_comes_back_from_its_text_as_it_was_driven() {
        for (speed_mps, turn_rate_radps) in [(0.3, -0.7), (-0.123_456_7, 1.0 / 3.0), (0.0, 0.0)] {
            let [speed_mps, turn_rate_radps] = [speed_mps, turn_rate_radps].map(to_thousandths);
            let intervention = Intervention::Drive { robot: 1, speed_mps, turn_rate_radps };
            let recorded = RecordedIntervention { step: 7, intervention };
            let text = serde_json::to_string(&InterventionRecord::from(&recorded)).unwrap();
            let read: InterventionRecord = serde_json::from_str(&text).unwrap();
            assert_eq!(RecordedIntervention::from(read), recorded, "{text}");
        }
    }
}
