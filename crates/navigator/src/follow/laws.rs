//! Laws that turn an error into wheel speeds: along a straight line, and along a trail.

use std::time::Duration;

use geometry::{Se2, Segment, Vec2, wrap_to_pi};
use path_following::{
    SettingError, TrailFollower, TrailSense, WheelReference,
    fuzzy::{FuzzyConfig, FuzzyController},
    signed_line_error_m, widths,
};
use run_context::Stamp;

/// Error at which the line's outermost fuzzy set is fully true, metres, at up to [`LAYOUT_MPS`].
///
/// With L/M/H as 1/2/3 and the change below the loop is damped to about 0.9 of critical:
/// θ′ = −(2.6 e/M + 5.3 θ) per metre.
const LINE_ERROR_FULL_M: f64 = 0.3;

/// The same for the error's change (5.31) in [`CHANGE_PERIOD_S`] at [`LAYOUT_MPS`], metres.
const LINE_CHANGE_FULL_M: f64 = 0.038;

/// The speed that both are laid out for, metres per second; at others they are as wide as `widths` says.
const LAYOUT_MPS: f64 = 0.38;

/// The time that the change is counted over, seconds: the thesis's control period.
const CHANGE_PERIOD_S: f64 = 0.2;

/// What is seen of the robot against its line: its reported pose and when that was true.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    pub(crate) pose: Se2,
    pub(crate) about: Stamp,
}

/// The error against a line at one time.
#[derive(Clone, Copy, Debug)]
struct Seen {
    line: (Vec2, Vec2),
    error_m: f64,
    about: Stamp,
}

/// Steers along the straight line between two points.
///
/// Source: the thesis, 7.5, (5.30) and (5.31). Differences: the change is counted over the time between the
/// two reports and scaled to 200 ms, since reports do not come in step with control; after
/// the first sight of a line, which has no change, and far off the line's direction the robot steers by its
/// heading.
#[derive(Clone, Debug)]
pub(crate) struct LineSteering {
    controller: FuzzyController,
    error_m: f64,
    saturated: bool,
    seen: Option<Seen>,
    change_m: f64,
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
        Ok(Self { controller, error_m: 0.0, saturated: false, seen: None, change_m: 0.0 })
    }

    /// The last error, metres, positive to the right of the line.
    pub(crate) fn error_m(&self) -> f64 {
        self.error_m
    }

    /// Whether a step since the last [`forget_saturation`](Self::forget_saturation) turned as sharply as it can, far off
    /// its line.
    pub(crate) fn is_saturated(&self) -> bool {
        self.saturated
    }

    pub(crate) fn forget_saturation(&mut self) {
        self.saturated = false;
    }

    /// Wheel speeds for a robot seen so, towards `to` along the line from `from`, around `speed_mps`.
    pub(crate) fn step(
        &mut self,
        sight: Sight,
        from: Vec2,
        to: Vec2,
        speed_mps: f64,
    ) -> WheelReference {
        let (pose, along) = (sight.pose, to - from);
        let off_rad = wrap_to_pi(pose.yaw_rad - along.y.atan2(along.x));
        if along.norm() < 0.05 || off_rad.abs() > 1.2 {
            // Too short a line to have a direction, or far off it: steer for its end.
            return self.steer_for(pose, to, speed_mps);
        }
        // Negative on the left, so that positive means: turn left.
        let error_m = signed_line_error_m(Segment { a: from, b: to }, pose.position());
        self.note_change((from, to), error_m, sight.about, off_rad, speed_mps);
        self.apply(error_m, self.change_m, off_rad, speed_mps)
    }

    /// (5.31): e′(t_k) = e(t_k) − e(t_k−1), over 200 ms.
    fn note_change(
        &mut self,
        line: (Vec2, Vec2),
        error_m: f64,
        about: Stamp,
        off_rad: f64,
        speed_mps: f64,
    ) {
        let before = self.seen.filter(|seen| seen.line == line);
        match before {
            Some(seen) if about > seen.about => {
                let periods = about.since(seen.about).as_secs_f64() / CHANGE_PERIOD_S;
                self.change_m = (error_m - seen.error_m) / periods;
            }
            // No report has come since: what was known still holds.
            Some(_) => return,
            // The first sight of this line: what its direction says.
            None => self.change_m = heading_change_m(off_rad, speed_mps),
        }
        self.seen = Some(Seen { line, error_m, about });
    }

    fn steer_for(&mut self, pose: Se2, to: Vec2, speed_mps: f64) -> WheelReference {
        let way = to - pose.position();
        let off_rad = wrap_to_pi(pose.yaw_rad - way.y.atan2(way.x));
        self.seen = None;
        self.apply(0.0, heading_change_m(off_rad, speed_mps), off_rad, speed_mps)
    }

    fn apply(
        &mut self,
        error_m: f64,
        change_m: f64,
        off_rad: f64,
        speed_mps: f64,
    ) -> WheelReference {
        self.error_m = error_m;
        let (wider, faster) = widths(speed_mps, LAYOUT_MPS);
        let wheels = self.controller.step(error_m / wider, change_m / faster, speed_mps);
        let difference = (wheels.right_mps - wheels.left_mps).abs();
        self.saturated = difference >= SATURATED_RATIO * speed_mps && off_rad.abs() > 0.7;
        wheels
    }
}

/// The change that the error will have: e′ = −V Δt sin(θ − θ_line).
fn heading_change_m(off_rad: f64, speed_mps: f64) -> f64 {
    -speed_mps * CHANGE_PERIOD_S * off_rad.clamp(-1.5, 1.5).sin()
}

/// Steers along a trail by what the two antennas smell: a law of crate `path_following`, with its control period.
#[derive(Clone, Debug)]
pub(crate) struct TrailSteering {
    follower: TrailFollower,
    period: Duration,
}

impl TrailSteering {
    pub(crate) fn new(follower: TrailFollower, period_s: f64) -> Self {
        Self { follower, period: Duration::from_secs_f64(period_s) }
    }

    pub(crate) fn forget(&mut self) {
        self.follower.restart();
    }

    /// Wheel speeds around `speed_mps`; `pace` is the present speed as a fraction of the one the law was tuned at.
    pub(crate) fn step(
        &mut self,
        left: f64,
        right: f64,
        speed_mps: f64,
        pace: f64,
    ) -> WheelReference {
        let sensed = TrailSense { left, right, equivalent: None };
        self.follower.step_at_pace(sensed, speed_mps, pace, self.period)
    }
}

#[cfg(test)]
mod tests {
    use geometry::Twist;
    use robot_models::DriveGeometry;

    use super::*;
    use crate::values::to_wheels;

    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.38,
        wheel_diameter_m: 0.195,
        encoder_ticks_per_turn: 500.0,
        gear_ratio: 38.3,
    };

    /// Where a robot with these wheels is after `seconds`.
    fn advance(pose: Se2, wheels: WheelReference, drive: &DriveGeometry, seconds: f64) -> Se2 {
        let velocity = drive.body_velocity(to_wheels(wheels));
        let dx_m = velocity.linear_mps * seconds;
        pose.compose(Se2::exp(Twist {
            dx_m,
            dy_m: 0.0,
            dyaw_rad: velocity.angular_radps * seconds,
        }))
    }

    fn seen(pose: Se2, step: usize, period_ms: u64) -> Sight {
        Sight { pose, about: Stamp::from_millis(period_ms * step as u64) }
    }

    /// Drives along the x axis for so many metres; the worst error of the second half, and the last heading.
    fn settle(start: Se2, speed_mps: f64, period_ms: u64, way_m: f64) -> (f64, f64) {
        let mut steering = LineSteering::new().unwrap();
        let (mut pose, mut worst_m) = (start, 0.0_f64);
        let period_s = 1e-3 * period_ms as f64;
        let n_steps = (way_m / speed_mps / period_s) as usize;
        for k in 0..n_steps {
            let sight = seen(pose, k, period_ms);
            let wheels = steering.step(sight, Vec2::zeros(), Vec2::new(30.0, 0.0), speed_mps);
            pose = advance(pose, wheels, &DRIVE, period_s);
            if 2 * k > n_steps {
                worst_m = worst_m.max(pose.y_m.abs());
            }
        }
        (worst_m, pose.yaw_rad)
    }

    #[test]
    fn the_line_is_regained_from_both_sides_at_every_speed() {
        for speed_mps in [0.08, 0.15, 0.3, 0.5, 0.8, 1.0] {
            for (y, yaw) in [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.7), (0.1, -0.7)] {
                for period_ms in [50, 100, 200] {
                    let way_m = 6.0_f64.max(16.0 * speed_mps);
                    let start = Se2::new(0.0, y, yaw);
                    let (worst_m, yaw_rad) = settle(start, speed_mps, period_ms, way_m);
                    assert!(
                        worst_m < 0.02 && yaw_rad.abs() < 0.03,
                        "{speed_mps} {y} {yaw} {period_ms}: {worst_m} {yaw_rad}"
                    );
                }
            }
        }
    }

    /// (5.31) in numbers: from 100 mm to 70 mm on the right of the line within 200 ms the change is −30 mm,
    /// whatever the speed and the heading, and the same in 100 ms counts twice.
    #[test]
    fn the_change_is_the_difference_of_two_errors() {
        for (speed_mps, yaw_rad) in [(0.1, 0.0), (0.3, 0.5), (1.0, -0.5)] {
            for (period_ms, change_m) in [(200, -0.03), (100, -0.06)] {
                let mut steering = LineSteering::new().unwrap();
                let line = (Vec2::zeros(), Vec2::new(9.0, 0.0));
                for (k, y_m) in [-0.1, -0.07].into_iter().enumerate() {
                    let sight = seen(Se2::new(1.0, y_m, yaw_rad), k, period_ms);
                    steering.step(sight, line.0, line.1, speed_mps);
                }
                assert!((steering.error_m - 0.07).abs() < 1e-12, "{}", steering.error_m);
                assert!((steering.change_m - change_m).abs() < 1e-12, "{}", steering.change_m);
                // Without a new report nothing has changed.
                steering.step(seen(Se2::new(1.0, -0.07, 0.0), 1, period_ms), line.0, line.1, 0.3);
                assert!((steering.change_m - change_m).abs() < 1e-12, "{}", steering.change_m);
                // Another line begins anew: no jump of the error counts as a change.
                let sight = seen(Se2::new(1.0, -0.07, 0.0), 2, period_ms);
                steering.step(sight, Vec2::new(0.0, 5.0), Vec2::new(9.0, 5.0), 0.3);
                assert!(steering.change_m.abs() < 1e-12, "{}", steering.change_m);
            }
        }
    }

    #[test]
    fn more_on_the_left_turns_left() {
        let follower = TrailFollower::new(path_following::TrailFollowerConfig::default()).unwrap();
        let mut steering = TrailSteering::new(follower, 0.2);
        let wheels = steering.step(80.0, 40.0, 0.3, 1.0);
        assert!(wheels.right_mps > wheels.left_mps);
        steering.forget();
        let wheels = steering.step(40.0, 80.0, 0.3, 1.0);
        assert!(wheels.right_mps < wheels.left_mps);
    }
}
