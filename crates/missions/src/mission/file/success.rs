//! `[success]`: what counts as success.

use serde::{Deserialize, Serialize};

/// `[success]`: every requirement must hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SuccessFile {
    /// No robot touches anything.
    pub no_contact: bool,
    /// The decision program sends exactly this many MOVE.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves_sent: Option<u64>,
    /// `EVENT` writes exactly this many entries into the decision node's log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events_logged: Option<u64>,
    /// The watchdog restarts the decision program exactly so often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub watchdog_resets: Option<u64>,
    /// Every robot keeps at least this distance from everything, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance_min_m: Option<f64>,
    /// Root mean square distance of the first robot from the trail at most, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_track_rms_max_m: Option<f64>,
    /// `[[success.arrived]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrived: Vec<ArrivedFile>,
    /// `[[success.switched_on]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub switched_on: Vec<SwitchedOnFile>,
    /// `[[success.stayed]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stayed: Vec<StayedFile>,
    /// `[[success.gave_up]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gave_up: Vec<GaveUpFile>,
}

/// `[[success.arrived]]`: a robot reports arrival and truly stands there.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArrivedFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// x, y (m), yaw (degrees).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// The same relative to where each robot started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_from_start: Option<[f64; 3]>,
    /// Allowed distance, m.
    pub within_m: f64,
    /// Allowed heading error, degrees.
    pub within_deg: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
    /// Part of the robots of that name that must arrive.
    pub min_ratio: f64,
}

impl Default for ArrivedFile {
    fn default() -> Self {
        Self {
            robot: String::new(),
            pose: None,
            pose_from_start: None,
            within_m: 0.3,
            within_deg: 15.0,
            by_s: 0.0,
            min_ratio: 1.0,
        }
    }
}

/// `[[success.switched_on]]`: a latch opens or a lamp is lit.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SwitchedOnFile {
    /// The device.
    pub device: String,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// `[[success.gave_up]]`: a robot reports that it gave up, and truly stands.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GaveUpFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// Why it must have given up, such as `link_lost` or `server_silent`; empty: whatever the reason.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// How far it may drive after one of its lines was last cut, until its next order, m; 0: any way.
    pub way_max_m: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// `[[success.stayed]]`: a robot never leaves its start.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct StayedFile {
    /// The robot.
    pub robot: String,
    /// Allowed distance from the start, m.
    pub within_m: f64,
}

impl Default for StayedFile {
    fn default() -> Self {
        Self { robot: String::new(), within_m: 0.05 }
    }
}
