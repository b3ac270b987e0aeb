//! `[[robots.lasers]]`: scanning lasers on a robot.

use serde::{Deserialize, Serialize};

use super::lines::{LineFile, laser_line};

/// A scanning laser on a robot's body, with a line of its own.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LaserFile {
    /// Its name, unique on its robot.
    pub name: String,
    /// Which laser, and so which bytes: `sick`, `rplidar` or `ld06`.
    pub kind: String,
    /// Where its sensor is: x ahead of the point midway between the wheels and y to the left (m).
    pub at_m: [f64; 2],
    /// Where its x axis looks, counter-clockwise from the robot's (degrees).
    pub yaw_deg: f64,
    /// `[robots.lasers.line]`: its cable.
    #[serde(deserialize_with = "laser_line")]
    pub line: LineFile,
}

impl Default for LaserFile {
    fn default() -> Self {
        Self {
            name: "laser".into(),
            kind: "sick".into(),
            at_m: [0.0; 2],
            yaw_deg: 0.0,
            line: LineFile::laser(),
        }
    }
}
