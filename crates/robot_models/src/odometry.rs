//! Dead reckoning from two encoder counts.
//!
//! Drifts without bound and knows it only through [`PoseCovariance`](crate::PoseCovariance). Use
//! it between absolute fixes, not instead of them.

use geometry::{Base, Odom, Se2, Transform2, Twist};

use crate::drive::{DriveGeometry, WheelTravel};

/// How one step's two wheel ways become a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OdometryRule {
    /// Along the arc of the step: exact while the ratio of the wheels' speeds is constant.
    #[default]
    Arc,
    /// Straight along the heading in the middle of the step: error of third order in the turn.
    Midpoint,
    /// Straight along the heading before the step: (3.6) with the index read as k − 1; error of
    /// second order in the turn.
    Before,
}

/// A pose integrated from encoder counts, in [`Odom`]: (0, 0, 0) where it was switched on.
///
/// Source: the thesis, eq. (3.2)–(3.6). Differences: (3.5) is printed with the sign of a
/// clockwise angle, which contradicts (2.6); here `Δθ = (ΔS_R − ΔS_L) / b`. The index of θ in (3.6) is
/// unreadable; [`OdometryRule`] offers the readings, and the exact arc is the default.
#[derive(Clone, Debug)]
pub struct Odometry {
    drive: DriveGeometry,
    rule: OdometryRule,
    ticks: [i64; 2],
    odom_from_base: Se2,
    travelled_m: f64,
}

impl Odometry {
    /// Starts at (0, 0, 0) with both counters at zero, following arcs.
    pub fn new(drive: DriveGeometry) -> Self {
        Self::with_rule(drive, OdometryRule::Arc)
    }

    /// Starts at (0, 0, 0) with both counters at zero, following `rule`.
    pub fn with_rule(drive: DriveGeometry, rule: OdometryRule) -> Self {
        Self { drive, rule, ticks: [0; 2], odom_from_base: Se2::IDENTITY, travelled_m: 0.0 }
    }

    /// Moves on to new counter values (pulses since switching on) and returns the wheels' ways.
    ///
    /// Counters may jump by any amount within `i64`; a jump that overflows wraps as a counter does.
    pub fn update(&mut self, left_ticks: i64, right_ticks: i64) -> WheelTravel {
        // (3.3) ΔS = c_m ΔN
        let metres_per_tick = self.drive.metres_per_tick();
        let travel = WheelTravel {
            left_m: metres_per_tick * left_ticks.wrapping_sub(self.ticks[0]) as f64,
            right_m: metres_per_tick * right_ticks.wrapping_sub(self.ticks[1]) as f64,
        };
        self.ticks = [left_ticks, right_ticks];
        // (3.4), (3.5)
        let twist = self.drive.body_twist(travel);
        self.travelled_m += twist.dx_m.abs();
        self.odom_from_base = self.rule.step(self.odom_from_base, twist);
        travel
    }

    /// Where it believes to be.
    pub fn odom_from_base(&self) -> Transform2<Odom, Base> {
        Transform2::new(self.odom_from_base)
    }

    /// Way of the point midway between the wheels since the start, forwards and backwards
    /// counted alike, metres.
    pub fn travelled_m(&self) -> f64 {
        self.travelled_m
    }

    /// Calls the present place (0, 0, 0); counters go on.
    pub fn reset(&mut self) {
        self.odom_from_base = Se2::IDENTITY;
        self.travelled_m = 0.0;
    }

    /// Believes to be at `odom_from_base` from now on; counters go on.
    pub fn set_pose(&mut self, odom_from_base: Transform2<Odom, Base>) {
        self.odom_from_base = odom_from_base.se2();
    }

    /// Takes the present counter values as reference without moving, for a robot that was
    /// switched on earlier.
    pub fn set_ticks(&mut self, left_ticks: i64, right_ticks: i64) {
        self.ticks = [left_ticks, right_ticks];
    }
}

impl OdometryRule {
    fn step(self, pose: Se2, twist: Twist) -> Se2 {
        let heading_rad = match self {
            Self::Arc => return pose.compose(Se2::exp(twist)),
            Self::Midpoint => pose.yaw_rad + 0.5 * twist.dyaw_rad,
            Self::Before => pose.yaw_rad,
        };
        // (3.6)
        let (s, c) = heading_rad.sin_cos();
        Se2::new(
            pose.x_m + twist.dx_m * c,
            pose.y_m + twist.dx_m * s,
            pose.yaw_rad + twist.dyaw_rad,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// One pulse is one millimetre, the wheels stand half a metre apart.
    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.5,
        wheel_diameter_m: 0.1,
        encoder_ticks_per_turn: 100.0 * std::f64::consts::PI,
        gear_ratio: 1.0,
    };

    fn end(rule: OdometryRule, counts: &[(i64, i64)]) -> Se2 {
        let mut odometry = Odometry::with_rule(DRIVE, rule);
        for &(left, right) in counts {
            odometry.update(left, right);
        }
        odometry.odom_from_base().se2()
    }

    #[test]
    fn a_right_wheel_ahead_means_a_turn_to_the_left() {
        // Printed, (3.5) has the other sign; (2.6) and every robot have this one.
        let pose = end(OdometryRule::Arc, &[(1000, 1100)]);
        assert!((pose.yaw_rad - 0.2).abs() < 1e-12 && pose.y_m > 0.0, "{pose:?}");
        let pose = end(OdometryRule::Arc, &[(1100, 1000)]);
        assert!((pose.yaw_rad + 0.2).abs() < 1e-12 && pose.y_m < 0.0, "{pose:?}");
    }

    #[test]
    fn the_three_readings_of_3_6_differ_as_they_should() {
        // 1.05 m on an arc of 0.2 rad, worked out by hand: R = 5.25 m.
        let counts = [(1000, 1100)];
        let arc = end(OdometryRule::Arc, &counts);
        assert!((arc.x_m - 5.25 * 0.2_f64.sin()).abs() < 1e-12);
        assert!((arc.y_m - 5.25 * (1.0 - 0.2_f64.cos())).abs() < 1e-12);
        let midpoint = end(OdometryRule::Midpoint, &counts);
        assert!((midpoint.x_m - 1.05 * 0.1_f64.cos()).abs() < 1e-12);
        assert!((midpoint.y_m - 1.05 * 0.1_f64.sin()).abs() < 1e-12);
        let before = end(OdometryRule::Before, &counts);
        assert_eq!((before.x_m, before.y_m), (1.05, 0.0));
        assert!((before.yaw_rad - 0.2).abs() < 1e-12);
    }

    /// On the same arc cut into n and 2n steps, an error of order k shrinks by 2^k.
    #[test]
    fn halving_the_step_shows_the_order_of_each_rule() {
        let error = |rule, steps: i64| {
            let counts: Vec<_> =
                (1..=steps).map(|k| (k * 100_000 / steps, k * 120_000 / steps)).collect();
            let exact = end(OdometryRule::Arc, &[(100_000, 120_000)]);
            let pose = end(rule, &counts);
            (pose.x_m - exact.x_m).hypot(pose.y_m - exact.y_m)
        };
        let shrinks = |rule| error(rule, 1000) / error(rule, 2000);
        assert!((shrinks(OdometryRule::Before) - 2.0).abs() < 0.1);
        assert!((shrinks(OdometryRule::Midpoint) - 4.0).abs() < 0.1);
        assert!(error(OdometryRule::Arc, 1000) < 1e-9);
    }

    #[test]
    fn a_reset_keeps_the_counters() {
        let mut odometry = Odometry::new(DRIVE);
        odometry.update(1000, 1000);
        odometry.reset();
        assert_eq!(odometry.odom_from_base().se2(), Se2::IDENTITY);
        let travel = odometry.update(1500, 1400);
        assert!((travel.left_m - 0.5).abs() < 1e-12 && (travel.right_m - 0.4).abs() < 1e-12);
        odometry.set_pose(Transform2::new(Se2::new(3.0, 4.0, 0.0)));
        odometry.set_ticks(0, 0);
        odometry.update(-1000, -1000);
        let pose = odometry.odom_from_base().se2();
        assert!((pose.x_m - 2.0).abs() < 1e-12 && (pose.y_m - 4.0).abs() < 1e-12);
        assert!((odometry.travelled_m() - 1.45).abs() < 1e-12);
    }

    #[test]
    fn a_counter_that_overflows_goes_on() {
        let mut odometry = Odometry::new(DRIVE);
        odometry.set_ticks(i64::MAX, i64::MAX);
        let travel = odometry.update(i64::MIN + 9, i64::MIN + 9);
        assert!((travel.left_m - 0.01).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn driving_back_by_the_same_counts_comes_home(
            counts in proptest::collection::vec((-500_i64..500, -500_i64..500), 1..40),
        ) {
            // Prefix sums there, and the same values in reverse order back.
            let mut sums = vec![(0, 0)];
            for (l, r) in counts {
                let (a, b) = sums[sums.len() - 1];
                sums.push((a + l, b + r));
            }
            let back: Vec<_> = sums.iter().copied().chain(sums.iter().rev().copied()).collect();
            for rule in [OdometryRule::Arc, OdometryRule::Midpoint] {
                let pose = end(rule, &back);
                prop_assert!(pose.x_m.hypot(pose.y_m) < 1e-9 && pose.yaw_rad.abs() < 1e-9);
            }
        }
    }
}
