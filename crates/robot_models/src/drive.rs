//! Kinematics of two driven wheels and a castor, and the limits of their motors.
//!
//! Pure rolling on a plane. The wheels' speeds are held for a step, so the body moves on an arc
//! (or a line) about its instantaneous centre; nothing here knows of forces.

use std::{f64::consts::PI, time::Duration};

use geometry::Twist;

/// Speeds of the two wheels' rims over the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSpeeds {
    /// Left wheel, forward positive, metres per second.
    pub left_mps: f64,
    /// Right wheel, forward positive, metres per second.
    pub right_mps: f64,
}

/// Ways that the two wheels' rims roll during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTravel {
    /// Left wheel, forward positive, metres.
    pub left_m: f64,
    /// Right wheel, forward positive, metres.
    pub right_m: f64,
}

/// Velocity of the body: forward along its x axis, and turning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyVelocity {
    /// Forward, metres per second.
    pub linear_mps: f64,
    /// Counter-clockwise, radians per second.
    pub angular_radps: f64,
}

/// The measures of a differential drive that turn wheel rotations into motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGeometry {
    /// Distance `b` between the planes of the two wheels, metres, positive.
    pub wheelbase_m: f64,
    /// Nominal wheel diameter `D_n`, metres, positive.
    pub wheel_diameter_m: f64,
    /// Encoder pulses `C_e` per turn of the motor.
    pub encoder_ticks_per_turn: f64,
    /// Turns `η` of the motor per turn of the wheel.
    pub gear_ratio: f64,
}

/// What the motors can do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLimits {
    /// Greatest speed of the body, metres per second.
    pub speed_max_mps: f64,
    /// Greatest turning rate, radians per second.
    pub turn_rate_max_radps: f64,
    /// Acceleration of the body that the robot starts with, metres per second squared.
    pub acceleration_max_mps2: f64,
    /// Turning acceleration that the robot starts with, radians per second squared.
    pub turn_acceleration_max_radps2: f64,
}

impl WheelSpeeds {
    /// Both wheels at rest.
    pub const ZERO: Self = Self { left_mps: 0.0, right_mps: 0.0 };

    /// Whether neither wheel turns.
    pub fn is_zero(self) -> bool {
        self.left_mps == 0.0 && self.right_mps == 0.0
    }
}

impl DriveGeometry {
    /// The body's velocity when the wheels roll at `wheels` without slipping.
    ///
    /// Source: the thesis, eq. (2.1) and (2.3).
    pub fn body_velocity(&self, wheels: WheelSpeeds) -> BodyVelocity {
        BodyVelocity {
            // v = (v_R + v_L) / 2,  ω = (v_R − v_L) / b
            linear_mps: 0.5 * (wheels.right_mps + wheels.left_mps),
            angular_radps: (wheels.right_mps - wheels.left_mps) / self.wheelbase_m,
        }
    }

    /// The wheel speeds that give the body `velocity`; undoes [`body_velocity`](Self::body_velocity).
    pub fn wheel_speeds(&self, velocity: BodyVelocity) -> WheelSpeeds {
        let half_difference_mps = 0.5 * velocity.angular_radps * self.wheelbase_m;
        WheelSpeeds {
            left_mps: velocity.linear_mps - half_difference_mps,
            right_mps: velocity.linear_mps + half_difference_mps,
        }
    }

    /// The body's motion, in its own frame, while its wheels roll by `travel` in a fixed ratio.
    ///
    /// [`Se2::exp`](geometry::Se2::exp) of it is the new pose in the old one, exact for an arc of
    /// any length.
    ///
    /// Source: the thesis, eq. (2.5)–(2.6), integrated over a step in which the ratio of the two
    /// speeds does not change.
    pub fn body_twist(&self, travel: WheelTravel) -> Twist {
        Twist {
            dx_m: 0.5 * (travel.left_m + travel.right_m),
            dy_m: 0.0,
            dyaw_rad: (travel.right_m - travel.left_m) / self.wheelbase_m,
        }
    }

    /// How far a wheel rolls per encoder pulse, metres.
    ///
    /// Source: the thesis, eq. (3.2): `c_m = π D_n / (η C_e)`.
    pub fn metres_per_tick(&self) -> f64 {
        PI * self.wheel_diameter_m / (self.gear_ratio * self.encoder_ticks_per_turn)
    }

    /// Scales both wheels' speeds down by one factor until the body keeps `limits`.
    ///
    /// The path's curvature stays; speeds within the limits come back unchanged. Speeds that are
    /// not finite become zero.
    pub fn limited(&self, wheels: WheelSpeeds, limits: &DriveLimits) -> WheelSpeeds {
        if !(wheels.left_mps.is_finite() && wheels.right_mps.is_finite()) {
            return WheelSpeeds::ZERO;
        }
        let velocity = self.body_velocity(wheels);
        let excess = (velocity.linear_mps.abs() / limits.speed_max_mps)
            .max(velocity.angular_radps.abs() / limits.turn_rate_max_radps)
            .max(1.0);
        WheelSpeeds { left_mps: wheels.left_mps / excess, right_mps: wheels.right_mps / excess }
    }
}

/// Wheel speeds after `dt` of approaching `reference` under one acceleration limit.
///
/// The wheel that has more to change takes the whole limit `acceleration_max_mps2` (m/s², ≥ 0),
/// and the other changes in proportion. So both arrive together, and a robot that starts or
/// stops keeps the curvature of its path. A limit that is zero, negative or not a number
/// changes nothing.
///
/// Source: the thesis, section 2.2.2: one linear acceleration `a ∈ [0, a_max]` common to both wheels.
pub fn ramp(
    current: WheelSpeeds,
    reference: WheelSpeeds,
    acceleration_max_mps2: f64,
    dt: Duration,
) -> WheelSpeeds {
    let change_max_mps = acceleration_max_mps2 * dt.as_secs_f64();
    if change_max_mps.is_nan() || change_max_mps <= 0.0 {
        return current;
    }
    let left_mps = reference.left_mps - current.left_mps;
    let right_mps = reference.right_mps - current.right_mps;
    let greatest_mps = left_mps.abs().max(right_mps.abs());
    if greatest_mps <= change_max_mps {
        return reference;
    }
    let scale = change_max_mps / greatest_mps;
    WheelSpeeds {
        left_mps: current.left_mps + scale * left_mps,
        right_mps: current.right_mps + scale * right_mps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Se2;
    use proptest::prelude::*;

    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.38,
        wheel_diameter_m: 0.1953,
        encoder_ticks_per_turn: 500.0,
        gear_ratio: 38.3,
    };
    const LIMITS: DriveLimits = DriveLimits {
        speed_max_mps: 2.2,
        turn_rate_max_radps: 8.7,
        acceleration_max_mps2: 0.3,
        turn_acceleration_max_radps2: 1.7,
    };
    const STEP: Duration = Duration::from_millis(10);

    fn wheels(left_mps: f64, right_mps: f64) -> WheelSpeeds {
        WheelSpeeds { left_mps, right_mps }
    }

    #[test]
    fn a_faster_right_wheel_turns_to_the_left() {
        let velocity = DRIVE.body_velocity(wheels(0.25, 0.44));
        assert!((velocity.linear_mps - 0.345).abs() < 1e-12);
        assert!((velocity.angular_radps - 0.5).abs() < 1e-12);
    }

    #[test]
    fn pure_pursuit_golden_wheel_speeds_give_its_curvature() {
        // The thesis, (5.22): v = 300 mm/s, R = 900 mm, b = 380 mm gives 236.67 and 363.33 mm/s.
        let speeds = DRIVE.wheel_speeds(BodyVelocity { linear_mps: 0.3, angular_radps: 0.3 / 0.9 });
        assert!((speeds.left_mps - 0.236_667).abs() < 1e-6);
        assert!((speeds.right_mps - 0.363_333).abs() < 1e-6);
    }

    #[test]
    fn one_pulse_is_32_micrometres_on_the_pioneer() {
        // π · 195.3 mm / (38.3 · 500), worked out by hand.
        assert!((DRIVE.metres_per_tick() - 3.203_94e-5).abs() < 1e-9);
    }

    #[test]
    fn a_full_circle_comes_home() {
        let around = std::f64::consts::TAU;
        let travel = WheelTravel { left_m: around * (1.0 - 0.19), right_m: around * (1.0 + 0.19) };
        let end = Se2::exp(DRIVE.body_twist(travel));
        assert!(end.x_m.hypot(end.y_m) < 1e-12 && end.yaw_rad.abs() < 1e-12, "{end:?}");
    }

    #[test]
    fn the_ramp_stands_still_without_acceleration() {
        for limit in [0.0, -1.0, f64::NAN] {
            assert_eq!(ramp(wheels(0.1, 0.2), wheels(1.0, 1.0), limit, STEP), wheels(0.1, 0.2));
        }
    }

    #[test]
    fn references_beyond_all_limits_are_scaled_and_nonsense_stops() {
        assert_eq!(DRIVE.limited(wheels(4.4, 4.4), &LIMITS), wheels(2.2, 2.2));
        let spin = DRIVE.limited(wheels(-3.0, 3.0), &LIMITS);
        assert!((DRIVE.body_velocity(spin).angular_radps - 8.7).abs() < 1e-9);
        assert_eq!(DRIVE.limited(wheels(-0.3, 0.2), &LIMITS), wheels(-0.3, 0.2));
        assert_eq!(DRIVE.limited(wheels(f64::NAN, 0.2), &LIMITS), WheelSpeeds::ZERO);
        assert_eq!(DRIVE.limited(wheels(0.2, f64::INFINITY), &LIMITS), WheelSpeeds::ZERO);
    }

    /// (2.5)–(2.6) as printed, in many Euler steps: slow, obvious, no shared code.
    fn euler(travel: WheelTravel, steps: u32) -> (f64, f64, f64) {
        let (dl, dr) = (travel.left_m / f64::from(steps), travel.right_m / f64::from(steps));
        (0..steps).fold((0.0, 0.0, 0.0), |(x, y, theta), _| {
            // The heading in the middle of the small step makes the error quadratic.
            let middle: f64 = theta + 0.5 * (dr - dl) / DRIVE.wheelbase_m;
            let ds = 0.5 * (dl + dr);
            (x + ds * middle.cos(), y + ds * middle.sin(), theta + (dr - dl) / DRIVE.wheelbase_m)
        })
    }

    proptest! {
        #[test]
        fn speeds_survive_the_way_to_the_body_and_back(l in -2.0..2.0, r in -2.0..2.0) {
            let back = DRIVE.wheel_speeds(DRIVE.body_velocity(wheels(l, r)));
            prop_assert!((back.left_mps - l).abs() < 1e-12 && (back.right_mps - r).abs() < 1e-12);
        }

        #[test]
        fn the_arc_is_what_small_steps_of_2_6_add_up_to(l in -0.5..0.5, r in -0.5..0.5) {
            let travel = WheelTravel { left_m: l, right_m: r };
            let arc = Se2::exp(DRIVE.body_twist(travel));
            let (x, y, theta) = euler(travel, 4096);
            prop_assert!((arc.x_m - x).abs() < 1e-6 && (arc.y_m - y).abs() < 1e-6);
            prop_assert!(geometry::wrap_to_pi(arc.yaw_rad - theta).abs() < 1e-9);
        }

        #[test]
        fn the_ramp_keeps_the_limit_and_the_ratio(
            cl in -1.0..1.0, cr in -1.0..1.0, rl in -1.0..1.0, rr in -1.0..1.0, a in 0.01..200.0,
        ) {
            let next = ramp(wheels(cl, cr), wheels(rl, rr), a, STEP);
            let (dl, dr) = (next.left_mps - cl, next.right_mps - cr);
            prop_assert!(dl.abs() <= a * 0.01 + 1e-12 && dr.abs() <= a * 0.01 + 1e-12);
            // Changes are parallel to what is left to change, and never pass it.
            prop_assert!((dl * (rr - cr) - dr * (rl - cl)).abs() < 1e-12);
            prop_assert!(dl.abs() <= (rl - cl).abs() + 1e-12 && dl * (rl - cl) >= -1e-12);
        }

        #[test]
        fn the_ramp_arrives(l in -1.0..1.0, r in -1.0..1.0) {
            // 2 m/s apart at most, 0.003 m/s per step.
            let start = wheels(0.0, 0.0);
            let end = (0..340).fold(start, |w, _| ramp(w, wheels(l, r), 0.3, STEP));
            prop_assert_eq!(end, wheels(l, r));
        }
    }
}
