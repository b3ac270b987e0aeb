//! Laws that turn an error into wheel speeds: along a straight line, and along a trail.

use std::time::Duration;

use geometry::{Se2, Segment, Twist, Vec2, wrap_to_pi};
use path_following::{
    SettingError, TrailFollower, TrailSense, WheelReference,
    fuzzy::{FuzzyConfig, FuzzyController},
    signed_line_error_m,
};
use robot_models::{DriveGeometry, WheelSpeeds};

/// Error at which the line's outermost fuzzy set is fully true, metres.
///
/// With L/M/H as 1/2/3 and the change below the loop is damped to about 0.9 of critical, whatever
/// the speed: θ′ = −(2.6 e/M + 5.3 θ) per metre.
const LINE_ERROR_FULL_M: f64 = 0.3;

/// The same for the error's change in one control period at cruising speed, metres.
const LINE_CHANGE_FULL_M: f64 = 0.03;

/// Steers along the straight line between two points.
///
/// Source: the thesis, 7.5 and (5.30). Differences: the change of the error (5.31) is taken from
/// the heading, V·Δt·sin of the error in heading, so that slowing down does not change the damping.
#[derive(Clone, Debug)]
pub(crate) struct LineSteering {
    controller: FuzzyController,
    pub(crate) error_m: f64,
    pub(crate) saturated: bool,
}

/// The fraction of the greatest difference between the wheels that counts as saturated.
const SATURATED_RATIO: f64 = 0.98;

impl LineSteering {
    pub(crate) fn new() -> Result<Self, SettingError> {
        let config = FuzzyConfig {
            error_full: LINE_ERROR_FULL_M,
            change_full: LINE_CHANGE_FULL_M,
            ..FuzzyConfig::default()
        };
        let controller = FuzzyController::new(config)?;
        Ok(Self { controller, error_m: 0.0, saturated: false })
    }

    /// Wheel speeds at `pose` towards `to` along the line from `from`, around `speed_mps`.
    pub(crate) fn step(
        &mut self,
        pose: Se2,
        from: Vec2,
        to: Vec2,
        speed_mps: f64,
    ) -> WheelReference {
        let along = to - from;
        if along.norm() < 0.05 {
            // Too short a line to have a direction: steer for its end.
            return self.steer_for(pose, to, speed_mps);
        }
        // Negative on the left, so that positive means: turn left.
        let error_m = signed_line_error_m(Segment { a: from, b: to }, pose.position());
        let off_rad = wrap_to_pi(pose.yaw_rad - along.y.atan2(along.x));
        if off_rad.abs() > 1.2 {
            return self.steer_for(pose, to, speed_mps);
        }
        self.apply(error_m, off_rad, speed_mps)
    }

    fn steer_for(&mut self, pose: Se2, to: Vec2, speed_mps: f64) -> WheelReference {
        let way = to - pose.position();
        let off_rad = wrap_to_pi(pose.yaw_rad - way.y.atan2(way.x));
        self.apply(0.0, off_rad, speed_mps)
    }

    fn apply(&mut self, error_m: f64, off_rad: f64, speed_mps: f64) -> WheelReference {
        self.error_m = error_m;
        // e′ = −V Δt sin(θ − θ_line), at 0.3 m/s and 0.2 s.
        let change_m = -0.06 * off_rad.clamp(-1.5, 1.5).sin();
        let wheels = self.controller.step(error_m, change_m, speed_mps);
        let difference = (wheels.right_mps - wheels.left_mps).abs();
        self.saturated = difference >= SATURATED_RATIO * speed_mps && off_rad.abs() > 0.7;
        wheels
    }
}

/// Steers along a trail by what the two antennas smell.
///
/// Source: the thesis, (5.45) e = P_L − P_R and Annex B2; the other laws are those of crate
/// `path_following`.
#[derive(Clone, Debug)]
pub(crate) struct TrailSteering {
    law: Law,
    previous: Option<f64>,
}

#[derive(Clone, Debug)]
enum Law {
    /// The default law; the change of the error is scaled by the pace.
    Fuzzy(FuzzyController),
    /// Any other, with its control period.
    Follower(TrailFollower, Duration),
}

impl TrailSteering {
    /// With the default sets and rules.
    pub(crate) fn new() -> Result<Self, SettingError> {
        Self::fuzzy(FuzzyConfig::default())
    }

    pub(crate) fn fuzzy(config: FuzzyConfig) -> Result<Self, SettingError> {
        let controller = FuzzyController::new(config)?;
        Ok(Self { law: Law::Fuzzy(controller), previous: None })
    }

    pub(crate) fn of_follower(follower: TrailFollower, period_s: f64) -> Self {
        let period = Duration::from_secs_f64(period_s);
        Self { law: Law::Follower(follower, period), previous: None }
    }

    pub(crate) fn forget(&mut self) {
        self.previous = None;
        if let Law::Follower(follower, _) = &mut self.law {
            follower.restart();
        }
    }

    /// Wheel speeds around `speed_mps`; `pace` is the present speed as a fraction of the cruising
    /// speed. A slow robot's error changes slowly, so its change is scaled up, at most threefold.
    pub(crate) fn step(
        &mut self,
        left: f64,
        right: f64,
        speed_mps: f64,
        pace: f64,
    ) -> WheelReference {
        let error = left - right;
        let change = self.previous.map_or(0.0, |previous| error - previous);
        self.previous = Some(error);
        match &mut self.law {
            Law::Fuzzy(fuzzy) => fuzzy.step(error, change / pace.clamp(0.34, 1.0), speed_mps),
            Law::Follower(follower, period) => {
                follower.step(TrailSense { left, right, equivalent: None }, speed_mps, *period)
            }
        }
    }
}

/// Where a robot with these wheels is after `seconds`.
pub(crate) fn advance(
    pose: Se2,
    wheels: WheelReference,
    drive: &DriveGeometry,
    seconds: f64,
) -> Se2 {
    let velocity = drive.body_velocity(to_wheels(wheels));
    let dx_m = velocity.linear_mps * seconds;
    pose.compose(Se2::exp(Twist { dx_m, dy_m: 0.0, dyaw_rad: velocity.angular_radps * seconds }))
}

/// The same speeds as the robots' crate names them.
pub(crate) fn to_wheels(wheels: WheelReference) -> WheelSpeeds {
    WheelSpeeds { left_mps: wheels.left_mps, right_mps: wheels.right_mps }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.38,
        wheel_diameter_m: 0.195,
        encoder_ticks_per_turn: 500.0,
        gear_ratio: 38.3,
    };

    fn settle(start: Se2, speed_mps: f64) -> (f64, f64) {
        let mut steering = LineSteering::new().unwrap();
        let (mut pose, mut worst_m) = (start, 0.0_f64);
        let n_steps = (6.0 / speed_mps / 0.2) as usize;
        for k in 0..n_steps {
            let wheels = steering.step(pose, Vec2::zeros(), Vec2::new(10.0, 0.0), speed_mps);
            pose = advance(pose, wheels, &DRIVE, 0.2);
            if 2 * k > n_steps {
                worst_m = worst_m.max(pose.y_m.abs());
            }
        }
        (worst_m, pose.yaw_rad)
    }

    #[test]
    fn the_line_is_regained_from_both_sides_at_every_speed() {
        for speed_mps in [0.08, 0.15, 0.3, 0.5] {
            for (y, yaw) in [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.7), (0.1, -0.7)] {
                let (worst_m, yaw_rad) = settle(Se2::new(0.0, y, yaw), speed_mps);
                assert!(
                    worst_m < 0.02 && yaw_rad.abs() < 0.03,
                    "{speed_mps} {y} {yaw}: {worst_m} {yaw_rad}"
                );
            }
        }
    }

    #[test]
    fn more_on_the_left_turns_left() {
        let mut steering = TrailSteering::new().unwrap();
        let wheels = steering.step(80.0, 40.0, 0.3, 1.0);
        assert!(wheels.right_mps > wheels.left_mps);
        steering.forget();
        let wheels = steering.step(40.0, 80.0, 0.3, 1.0);
        assert!(wheels.right_mps < wheels.left_mps);
    }
}
