//! `[[devices]]`: what the smart environment can sense and do.

use serde::{Deserialize, Serialize};

/// `[[devices]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeviceFile {
    /// Unique name, used by events and success.
    pub name: String,
    /// `button`, `motion`, `latch` or `lamp`.
    pub kind: String,
    /// What people read.
    pub label: String,
    /// Where it is drawn, x and y (m).
    pub at_m: [f64; 2],
    /// What a motion detector watches: corners, x and y (m).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub area_m: Vec<[f64; 2]>,
    /// Digital input of the decision program (`button`, `motion`), 0 to 15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<u8>,
    /// Digital output of the decision program (`latch`, `lamp`), 0 to 15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<u8>,
    /// What it does while no program drives it (`latch`, `lamp`): `off`, `on` or `hold`.
    pub failsafe: String,
}

impl Default for DeviceFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: "button".into(),
            label: String::new(),
            at_m: [0.0, 0.0],
            area_m: Vec::new(),
            input: None,
            output: None,
            failsafe: "off".into(),
        }
    }
}
