//! Exact circular arcs, measured by the distance along them.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::{Se2, Vec2, wrap_to_pi};

/// A piece of a circle, travelled from its start to its end.
///
/// Points on it are named by their distance from the start along the curve. It may be more than a
/// full turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The centre of the circle (m).
    pub centre: Vec2,
    /// Radius, metres; positive.
    pub radius_m: f64,
    /// Direction from the centre to the start, radians.
    pub start_rad: f64,
    /// Angle travelled about the centre, radians; positive turns left (counter-clockwise), not
    /// wrapped.
    pub sweep_rad: f64,
}

impl Arc {
    /// The arc that leaves `start` along its heading and turns by `sweep_rad` (positive to the
    /// left) on a circle of `radius_m` (positive).
    pub fn from_pose(start: Se2, radius_m: f64, sweep_rad: f64) -> Self {
        // The centre lies to the left of a left turn and to the right of a right one.
        let towards_centre = FRAC_PI_2.copysign(sweep_rad);
        let (s, c) = (start.yaw_rad + towards_centre).sin_cos();
        Self {
            centre: start.position() + radius_m * Vec2::new(c, s),
            radius_m,
            start_rad: wrap_to_pi(start.yaw_rad - towards_centre),
            sweep_rad,
        }
    }

    /// Length along the curve, metres.
    pub fn length(self) -> f64 {
        self.radius_m * self.sweep_rad.abs()
    }

    /// The point `along_m` metres from the start along the curve (m). Below 0 and beyond
    /// [`length`](Self::length) the circle goes on.
    pub fn point_at(self, along_m: f64) -> Vec2 {
        let (s, c) = self.angle_at(along_m).sin_cos();
        self.centre + self.radius_m * Vec2::new(c, s)
    }

    /// Point and direction of travel `along_m` metres from the start along the curve.
    pub fn pose_at(self, along_m: f64) -> Se2 {
        let point = self.point_at(along_m);
        let heading_rad = self.angle_at(along_m) + FRAC_PI_2.copysign(self.sweep_rad);
        Se2::new(point.x, point.y, heading_rad)
    }

    /// How far along the curve its point nearest to `point` (m) lies, in [0, length], metres. Of
    /// equally near points the one first travelled; so the centre answers 0.
    pub fn closest_along(self, point: Vec2) -> f64 {
        let offset = point - self.centre;
        if offset.norm_squared() <= 0.0 || self.radius_m <= 0.0 {
            return 0.0;
        }
        // Angle travelled until the arc points at `point`, in [0, 2π).
        let turned = (offset.y.atan2(offset.x) - self.start_rad) * self.sweep_rad.signum();
        let turned = turned.rem_euclid(TAU);
        let sweep = self.sweep_rad.abs();
        if turned <= sweep {
            return self.radius_m * turned;
        }
        // Off the arc the nearer end wins; on a circle that is the end at the smaller angle.
        if TAU - turned <= turned - sweep { 0.0 } else { self.length() }
    }

    /// The point of the arc nearest to `point` (both m).
    pub fn closest_point(self, point: Vec2) -> Vec2 {
        self.point_at(self.closest_along(point))
    }

    /// From `point` (m) to the nearest point of the arc, metres.
    pub fn distance(self, point: Vec2) -> f64 {
        (point - self.closest_point(point)).norm()
    }

    fn angle_at(self, along_m: f64) -> f64 {
        self.start_rad + along_m / self.radius_m * self.sweep_rad.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Twist;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn near(p: Vec2, x: f64, y: f64) {
        assert!((p - Vec2::new(x, y)).norm() < 1e-12, "{p} is not ({x}, {y})");
    }

    #[test]
    fn a_quarter_turn_to_either_side_ends_where_it_must() {
        let left = Arc::from_pose(Se2::IDENTITY, 2.0, FRAC_PI_2);
        near(left.centre, 0.0, 2.0);
        near(left.point_at(0.0), 0.0, 0.0);
        near(left.point_at(left.length()), 2.0, 2.0);
        assert!((left.pose_at(left.length()).yaw_rad - FRAC_PI_2).abs() < 1e-12);
        let right = Arc::from_pose(Se2::IDENTITY, 2.0, -FRAC_PI_2);
        near(right.point_at(right.length()), 2.0, -2.0);
        assert!((right.pose_at(right.length()).yaw_rad + FRAC_PI_2).abs() < 1e-12);
        assert!((right.length() - PI).abs() < 1e-12);
    }

    #[test]
    fn beside_the_arc_an_end_is_nearest_and_the_centre_answers_the_start() {
        let arc = Arc { centre: Vec2::zeros(), radius_m: 1.0, start_rad: 0.0, sweep_rad: 1.0 };
        assert!(arc.closest_along(Vec2::new(2.0, -0.1)).abs() < 1e-15);
        assert!((arc.closest_along(Vec2::new(-1.0, 1.0)) - 1.0).abs() < 1e-15);
        assert!(arc.closest_along(Vec2::zeros()).abs() < 1e-15);
        assert!((arc.closest_along(3.0 * arc.point_at(0.4)) - 0.4).abs() < 1e-12);
    }

    proptest! {
        /// Oracle: the exponential of a constant twist, which was tested against small steps.
        #[test]
        fn a_pose_on_the_arc_is_where_a_constant_twist_leads(
            (x, y, yaw) in (-5.0..5.0, -5.0..5.0, -3.0..3.0),
            (radius, sweep, part) in (0.1..20.0, -6.0..6.0, 0.0..1.0),
        ) {
            let start = Se2::new(x, y, yaw);
            let arc = Arc::from_pose(start, radius, sweep);
            let along = part * arc.length();
            let twist = Twist { dx_m: along, dy_m: 0.0, dyaw_rad: part * sweep };
            let apart = arc.pose_at(along).inverse().compose(start.compose(Se2::exp(twist)));
            prop_assert!(apart.x_m.hypot(apart.y_m) + apart.yaw_rad.abs() < 1e-9);
        }

        /// Oracle: the best of many points, tried one by one.
        #[test]
        fn no_point_of_the_arc_is_nearer(
            (start, sweep) in (-4.0..4.0, -7.0..7.0),
            (x, y) in (-3.0..3.0, -3.0..3.0),
        ) {
            let arc = Arc { centre: Vec2::new(0.3, -0.2), radius_m: 1.5, start_rad: start, sweep_rad: sweep };
            let tried = (0..=2000).map(|i| {
                let angle: f64 = start + sweep * f64::from(i) / 2000.0;
                f64::hypot(0.3 + 1.5 * angle.cos() - x, -0.2 + 1.5 * angle.sin() - y)
            });
            let best = tried.fold(f64::INFINITY, f64::min);
            let found = arc.distance(Vec2::new(x, y));
            prop_assert!(found <= best + 1e-12 && found >= best - 0.01);
        }
    }
}
