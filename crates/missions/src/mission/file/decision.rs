//! `[decision]`: the decision program and the node that runs it.

use serde::{Deserialize, Serialize};

use super::lines::{LineFile, radio_line};

/// `[decision]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecisionFile {
    /// Program file, relative to the mission file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program_file: Option<String>,
    /// The program itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// `corrected` or `listing`.
    pub mode: String,
    /// Robot that MOVE commands; empty: none (the decision rig alone).
    pub robot: String,
    /// Digital input that is 1 from a MOVE until its end is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub busy_input: Option<u8>,
    /// Digital input that is 1 when the robot stands where the last MOVE sent it; also `done_input`.
    #[serde(alias = "done_input", skip_serializing_if = "Option::is_none")]
    pub arrived_input: Option<u8>,
    /// Digital input that is 1 when the last MOVE will not be done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed_input: Option<u8>,
    /// How these two appear: `level`, until the next MOVE, or `pulse`, in one scan.
    pub completion: String,
    /// How long the ground waits for the robot's answers before a MOVE counts as failed, s; the way
    /// there and back over the link comes on top.
    pub answer_within_s: f64,
    /// Whether a robot that is on its way for a MOVE stops when the program does.
    pub failsafe_stops_robot: bool,
    /// The node's clock when the run begins: `07:30`, or with a date `2026-03-01 07:30:00`.
    pub clock: String,
    /// After this time the watchdog restarts a program whose loop stands still, s; 0: never.
    pub watchdog_s: f64,
    /// `[decision.line]`: the radio modem to the robot.
    #[serde(deserialize_with = "radio_line")]
    pub line: LineFile,
}

impl Default for DecisionFile {
    fn default() -> Self {
        Self {
            program_file: None,
            program: None,
            mode: "corrected".into(),
            robot: String::new(),
            busy_input: None,
            arrived_input: None,
            failed_input: None,
            completion: "level".into(),
            answer_within_s: 5.0,
            failsafe_stops_robot: true,
            clock: "2000-01-01 00:00:00".into(),
            watchdog_s: 2.0,
            line: LineFile::radio(),
        }
    }
}
