//! `[[events]]`: what happens at which time.

use serde::{Deserialize, Serialize};

/// `[[events]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct EventFile {
    /// When, seconds.
    pub at_s: f64,
    /// `press`, `release`, `goal`, `stop`, `place_box`, `remove`, `cut_line`, `restore_line`, `stop_program`,
    /// `run_program`, `stall_program`, `test_line`, `report_sonar` or `restart`.
    #[serde(rename = "do")]
    pub action: String,
    /// `press`, `release`: the device.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub device: String,
    /// `goal`, `stop`, `cut_line`, `restore_line`, `test_line`, `report_sonar`, `restart`: the robot.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub robot: String,
    /// `goal`: x, y (m), yaw (degrees).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// `goal`: x, y (m) and yaw (degrees) relative to where each robot started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_from_start: Option<[f64; 3]>,
    /// `goal`: sent as soon as the robot arrives at the goal before, not before `at_s`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub after_arrival: bool,
    /// `place_box`: where, x and y (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_m: Option<[f64; 2]>,
    /// `place_box`: side, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
    /// `remove`, `place_box`: the thing's name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub thing: String,
    /// `cut_line`, `restore_line`: `robot`, `pheromones` or `ground`, the other end of the line of the
    /// robot's navigation node.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub line: String,
    /// `cut_line`, `restore_line`: `both` unless given; one way `to_robot` or `from_robot`,
    /// `to_server` or `from_server`, `to_ground` or `from_ground`, by the line.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub direction: String,
    /// `stall_program`: how long the loop of the decision node stands still, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}
