//! Follow the wall: keep a distance to what the side sensors see.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_6};

use geometry::{Se2, Vec2};

use crate::{SettingError, WheelReference, wheels::check_range};

/// Which side the wall is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the left.
    Left,
    /// On the right.
    Right,
}

/// One range sensor's reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeReading {
    /// Where the sensor sits and looks.
    pub base_from_sensor: Se2,
    /// What it measures, metres; not finite or not positive for nothing.
    pub range_m: f64,
}

/// Tuning of a [`WallFollower`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallFollowerConfig {
    /// Which side the wall is on.
    pub side: Side,
    /// Distance to keep from the robot's centre to the wall, metres, 0.1 to 5.
    pub distance_m: f64,
    /// Anything further away is not the wall, metres, 0.2 to 10.
    pub range_max_m: f64,
    /// Something this near in front of the robot's centre makes it turn on the spot, metres, 0.1 to 5.
    pub front_clearance_m: f64,
    /// Half the width that must be free in front, metres, 0.05 to 2.
    pub half_width_m: f64,
    /// Angle of approach per distance from the wanted one, rad/m, 0.1 to 10.
    pub offset_gain_rad_per_m: f64,
    /// Turn rate per angle, 1/s, 0.05 to 20.
    pub heading_gain_per_s: f64,
    /// Between the wheels, metres, 0.02 to 5.
    pub wheelbase_m: f64,
    /// No wheel is asked for more, metres per second, 0.01 to 10.
    pub wheel_speed_max_mps: f64,
}

impl WallFollowerConfig {
    /// Settings for a robot of the Pioneer's size at 0.3 m/s.
    pub fn along(side: Side) -> Self {
        Self {
            side,
            distance_m: 0.6,
            range_max_m: 2.0,
            front_clearance_m: 0.7,
            half_width_m: 0.3,
            offset_gain_rad_per_m: 1.2,
            heading_gain_per_s: 1.2,
            wheelbase_m: 0.38,
            wheel_speed_max_mps: 0.75,
        }
    }
}

/// Keeps a robot beside a wall: along it, around inner corners by turning, around outer ones by an arc.
///
/// The points that the side sensors hit are joined by a line (least squares); the robot steers for
/// the line's direction plus an angle in proportion to how far it is from the distance to keep.
/// Source of the idea: the thesis, §5.2.1 ("follow the wall"), which gives no law; this one is our own.
#[derive(Clone, Debug)]
pub struct WallFollower {
    config: WallFollowerConfig,
}

impl WallFollower {
    /// Checks the settings.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: WallFollowerConfig) -> Result<Self, SettingError> {
        check_range("distance_m", config.distance_m, 0.1..=5.0, "from 0.1 to 5 m")?;
        check_range("range_max_m", config.range_max_m, 0.2..=10.0, "from 0.2 to 10 m")?;
        let clearance = config.front_clearance_m;
        check_range("front_clearance_m", clearance, 0.1..=5.0, "from 0.1 to 5 m")?;
        check_range("half_width_m", config.half_width_m, 0.05..=2.0, "from 0.05 to 2 m")?;
        let offset_gain = config.offset_gain_rad_per_m;
        check_range("offset_gain_rad_per_m", offset_gain, 0.1..=10.0, "from 0.1 to 10 rad/m")?;
        let heading_gain = config.heading_gain_per_s;
        check_range("heading_gain_per_s", heading_gain, 0.05..=20.0, "from 0.05 to 20 1/s")?;
        check_range("wheelbase_m", config.wheelbase_m, 0.02..=5.0, "from 0.02 to 5 m")?;
        let speed_max = config.wheel_speed_max_mps;
        check_range("wheel_speed_max_mps", speed_max, 0.01..=10.0, "from 0.01 to 10 m/s")?;
        Ok(Self { config })
    }

    /// Wheel speeds for what the sensors see now, around the speed wanted (m/s, ≥ 0).
    ///
    /// Without anything on the wall's side the robot drives an arc towards that side, of the radius that
    /// keeps the distance around a sharp corner. O(readings), allocates nothing.
    pub fn step(&self, readings: &[RangeReading], speed_mps: f64) -> WheelReference {
        let config = &self.config;
        // Everything is worked out for a wall on the left, in a world mirrored if need be.
        let mirror = if config.side == Side::Left { 1.0 } else { -1.0 };
        let turning = |forward_mps: f64, turn_rate_radps: f64| {
            WheelReference::turning(forward_mps, mirror * turn_rate_radps, config.wheelbase_m)
                .limited(config.wheel_speed_max_mps)
        };
        let mut line = LineFit::default();
        for reading in readings {
            let is_echo = reading.range_m > 0.0 && reading.range_m < config.range_max_m;
            if !is_echo {
                continue;
            }
            let hit = reading.base_from_sensor.transform_point(Vec2::new(reading.range_m, 0.0));
            let hit = Vec2::new(hit.x, mirror * hit.y);
            if hit.x > 0.0 && hit.x < config.front_clearance_m && hit.y.abs() < config.half_width_m
            {
                return turning(0.0, -speed_mps / (0.5 * config.wheelbase_m));
            }
            let looks_rad = mirror * reading.base_from_sensor.yaw_rad;
            if (FRAC_PI_6 - 1e-9..=FRAC_PI_2 + FRAC_PI_3).contains(&looks_rad) && hit.y > 0.0 {
                line.add(hit);
            }
        }
        let Some((distance_m, direction_rad)) = line.distance_and_direction() else {
            return turning(speed_mps, speed_mps / config.distance_m);
        };
        let approach_rad = config.offset_gain_rad_per_m * (distance_m - config.distance_m);
        // At most 45° towards the wall or away from it.
        let wanted_rad = direction_rad + approach_rad.clamp(-0.79, 0.79);
        turning(speed_mps * wanted_rad.cos().max(0.0), config.heading_gain_per_s * wanted_rad)
    }
}

/// Least squares of y = a + b x, updated point by point.
#[derive(Default)]
struct LineFit {
    n: f64,
    sum: Vec2,
    sum_xx: f64,
    sum_xy: f64,
}

impl LineFit {
    fn add(&mut self, point: Vec2) {
        self.n += 1.0;
        self.sum += point;
        self.sum_xx += point.x * point.x;
        self.sum_xy += point.x * point.y;
    }

    /// Of the line from the origin (m, ≥ 0) and of its direction from the x axis (rad).
    fn distance_and_direction(&self) -> Option<(f64, f64)> {
        if self.n < 1.0 {
            return None;
        }
        let mean = self.sum / self.n;
        let spread = self.sum_xx - self.n * mean.x * mean.x;
        // One point, or all at one x: nothing says how the wall runs, so it is taken as parallel.
        let slope =
            if spread > 1e-6 { (self.sum_xy - self.n * mean.x * mean.y) / spread } else { 0.0 };
        let direction_rad = slope.atan();
        Some(((mean.y - slope * mean.x).abs() * direction_rad.cos(), direction_rad))
    }
}

#[cfg(test)]
#[path = "wall_tests.rs"]
mod tests;
