//! What a robot carries beside wheels and sonars, as its file says.

use geometry::{Base, Se2, Sensor, Transform2, Vec2};
use serde::Deserialize;

use crate::model_error::{ModelError, check_range};

/// Beside wheels and sonars.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Devices {
    /// Segments of its bumper.
    pub bumpers: Vec<BumperMount>,
    /// What looks for the floor.
    pub cliffs: Vec<FloorSensorMount>,
    /// Infrared sensors that see things near by.
    pub infrareds: Vec<InfraredMount>,
    /// Its battery, if the catalogue knows it.
    pub battery: Option<BatteryModel>,
}

/// A segment of a bumper: pressed by what touches the outline between two bearings.
#[derive(Clone, Debug, PartialEq)]
pub struct BumperMount {
    /// Its name.
    pub name: String,
    /// The bearings at which it ends, right and left, degrees, counter-clockwise from straight ahead.
    pub between_deg: [f64; 2],
}

/// What looks down for the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorSensorMount {
    /// Its name.
    pub name: String,
    /// The place that it looks at, base frame, metres.
    pub place: Vec2,
}

/// An infrared sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct InfraredMount {
    /// Its name.
    pub name: String,
    /// Pose of the sensor (x along its axis) in the base frame.
    pub base_from_sensor: Transform2<Base, Sensor>,
    /// Farthest wall that it sees, metres.
    pub range_max_m: f64,
}

/// A battery, and what empties it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BatteryModel {
    /// What it holds, mAh.
    pub capacity_mah: f64,
    /// Voltage when full, V.
    pub full_v: f64,
    /// Voltage when empty, V.
    pub empty_v: f64,
    /// What the robot takes at rest, W.
    pub idle_w: f64,
    /// What driving takes besides, W, at full speed.
    pub driving_w: f64,
    /// What a charger gives, W.
    pub charging_w: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BumperFile {
    name: String,
    right_deg: f64,
    left_deg: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CliffFile {
    name: String,
    x_m: f64,
    y_m: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct InfraredFile {
    name: String,
    x_m: f64,
    y_m: f64,
    azimuth_deg: f64,
    range_max_m: f64,
}

impl BumperFile {
    pub(crate) fn mount(self, index: usize) -> Result<BumperMount, ModelError> {
        let key = |key: &str| format!("bumpers[{index}].{key}");
        check_range(&key("right_deg"), self.right_deg, -360.0, 360.0, "from -360 to 360 deg")?;
        let width_deg = self.left_deg - self.right_deg;
        let requirement = "above right_deg by 1 to 179 deg";
        if !(1.0..=179.0).contains(&width_deg) {
            let (key, value) = (key("left_deg"), self.left_deg);
            return Err(ModelError::Range { key, value, requirement });
        }
        Ok(BumperMount { name: self.name, between_deg: [self.right_deg, self.left_deg] })
    }
}

impl CliffFile {
    pub(crate) fn mount(self, index: usize) -> Result<FloorSensorMount, ModelError> {
        check_place(&format!("cliffs[{index}]"), self.x_m, self.y_m)?;
        Ok(FloorSensorMount { name: self.name, place: Vec2::new(self.x_m, self.y_m) })
    }
}

impl InfraredFile {
    pub(crate) fn mount(self, index: usize) -> Result<InfraredMount, ModelError> {
        let at = format!("infrareds[{index}]");
        check_place(&at, self.x_m, self.y_m)?;
        let requirement = "from -360 to 360 deg";
        check_range(&format!("{at}.azimuth_deg"), self.azimuth_deg, -360.0, 360.0, requirement)?;
        let requirement = "from 0.01 to 10 m";
        check_range(&format!("{at}.range_max_m"), self.range_max_m, 0.01, 10.0, requirement)?;
        let pose = Se2::new(self.x_m, self.y_m, self.azimuth_deg.to_radians());
        Ok(InfraredMount {
            name: self.name,
            base_from_sensor: Transform2::new(pose),
            range_max_m: self.range_max_m,
        })
    }
}

impl BatteryModel {
    pub(crate) fn checked(self) -> Result<Self, ModelError> {
        let requirement = "from 1 to 1000000 mAh";
        check_range("battery.capacity_mah", self.capacity_mah, 1.0, 1e6, requirement)?;
        check_range("battery.full_v", self.full_v, 0.5, 1e3, "from 0.5 to 1000 V")?;
        let requirement = "from 0.1 V to full_v";
        check_range("battery.empty_v", self.empty_v, 0.1, self.full_v, requirement)?;
        for (key, value) in [
            ("battery.idle_w", self.idle_w),
            ("battery.driving_w", self.driving_w),
            ("battery.charging_w", self.charging_w),
        ] {
            check_range(key, value, 0.0, 1e5, "from 0 to 100000 W")?;
        }
        Ok(self)
    }
}

fn check_place(at: &str, x_m: f64, y_m: f64) -> Result<(), ModelError> {
    check_range(&format!("{at}.x_m"), x_m, -5.0, 5.0, "from -5 to 5 m")?;
    check_range(&format!("{at}.y_m"), y_m, -5.0, 5.0, "from -5 to 5 m")
}
