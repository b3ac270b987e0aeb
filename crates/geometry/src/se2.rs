//! The group SE(2) of planar rigid motions: compose, invert, `exp`, `log`.

use std::f64::consts::{PI, TAU};

use crate::Vec2;

/// Below this |angle| (rad) the series is used; its error there is under 1e-17.
const SMALL_ANGLE_RAD: f64 = 1e-4;

/// A planar rigid motion: rotate by `yaw_rad`, then translate by (`x_m`, `y_m`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Se2 {
    /// Translation along x, metres.
    pub x_m: f64,
    /// Translation along y, metres.
    pub y_m: f64,
    /// Rotation, radians, counter-clockwise, in [-π, π).
    pub yaw_rad: f64,
}

/// A constant planar velocity held for one unit of time; a tangent vector of [`Se2`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Forward, metres.
    pub dx_m: f64,
    /// To the left, metres.
    pub dy_m: f64,
    /// Counter-clockwise, radians; not wrapped.
    pub dyaw_rad: f64,
}

impl Se2 {
    /// The motion that moves nothing.
    pub const IDENTITY: Self = Self { x_m: 0.0, y_m: 0.0, yaw_rad: 0.0 };

    /// Makes a motion; `yaw_rad` may be any finite angle and is wrapped.
    pub fn new(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self { x_m, y_m, yaw_rad: wrap_to_pi(yaw_rad) }
    }

    /// The translation (m).
    pub fn position(self) -> Vec2 {
        Vec2::new(self.x_m, self.y_m)
    }

    /// The unit vector along the rotated x axis.
    pub fn heading(self) -> Vec2 {
        let (s, c) = self.yaw_rad.sin_cos();
        Vec2::new(c, s)
    }

    /// Where a point (m) given in the inner frame lies in the outer one.
    pub fn transform_point(self, point: Vec2) -> Vec2 {
        self.position() + self.rotate(point)
    }

    /// A direction given in the inner frame, turned into the outer one.
    pub fn rotate(self, direction: Vec2) -> Vec2 {
        let (s, c) = self.yaw_rad.sin_cos();
        Vec2::new(c * direction.x - s * direction.y, s * direction.x + c * direction.y)
    }

    /// Applies `rhs` first, then `self`.
    #[must_use]
    pub fn compose(self, rhs: Self) -> Self {
        let (s, c) = self.yaw_rad.sin_cos();
        Self::new(
            self.x_m + c * rhs.x_m - s * rhs.y_m,
            self.y_m + s * rhs.x_m + c * rhs.y_m,
            self.yaw_rad + rhs.yaw_rad,
        )
    }

    /// The motion that undoes this one.
    #[must_use]
    pub fn inverse(self) -> Self {
        let (s, c) = self.yaw_rad.sin_cos();
        Self::new(-c * self.x_m - s * self.y_m, s * self.x_m - c * self.y_m, -self.yaw_rad)
    }

    /// Follows `twist` for one unit of time: an arc, or a line when it does not turn.
    ///
    /// Source: Solà, Deray, Atchuthan (2018), "A micro Lie theory for state estimation in
    /// robotics", arXiv:1812.01537, eq. (156) and (158).
    pub fn exp(twist: Twist) -> Self {
        let theta = twist.dyaw_rad;
        let half = 0.5 * theta;
        // V = [a, -b; b, a] with a = sin θ / θ and b = (1 - cos θ) / θ. Near zero both are
        // 0/0. We test |θ|, not θ, and write 1 - cos θ as 2 sin²(θ/2) to keep its digits.
        let (a, b) = if theta.abs() < SMALL_ANGLE_RAD {
            (1.0 - theta * theta / 6.0, half * (1.0 - theta * theta / 12.0))
        } else {
            (theta.sin() / theta, half.sin().powi(2) / half)
        };
        Self::new(a * twist.dx_m - b * twist.dy_m, b * twist.dx_m + a * twist.dy_m, theta)
    }

    /// The shortest twist whose [`exp`](Self::exp) is `self`; |`dyaw_rad`| ≤ π.
    ///
    /// Source: as for `exp`, with V⁻¹ in closed form: diagonal (θ/2) cot(θ/2), off-diagonal ±θ/2.
    pub fn log(self) -> Twist {
        let theta = self.yaw_rad;
        let half = 0.5 * theta;
        let diagonal = if theta.abs() < SMALL_ANGLE_RAD {
            1.0 - theta * theta / 12.0
        } else {
            half / half.tan()
        };
        Twist {
            dx_m: diagonal * self.x_m + half * self.y_m,
            dy_m: -half * self.x_m + diagonal * self.y_m,
            dyaw_rad: theta,
        }
    }
}

/// Wraps a finite angle (rad) into [-π, π).
pub fn wrap_to_pi(angle_rad: f64) -> f64 {
    debug_assert!(angle_rad.is_finite());
    let wrapped = (angle_rad + PI).rem_euclid(TAU) - PI;
    // rem_euclid may round up to TAU itself for tiny negative arguments.
    if wrapped < PI { wrapped } else { -PI }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Angles on both sides of every branch and of the wrap, both signs.
    fn corner_angles() -> impl Strategy<Value = f64> {
        let corners = [0.0, 1e-12, 0.999e-4, 1.001e-4, 1.0, PI - 1e-9, PI];
        let signed: Vec<f64> = corners.iter().flat_map(|&a| [a, -a]).collect();
        prop_oneof![proptest::sample::select(signed), -PI..PI]
    }

    fn motion() -> impl Strategy<Value = Se2> {
        (-10.0..10.0, -10.0..10.0, corner_angles()).prop_map(|(x, y, yaw)| Se2::new(x, y, yaw))
    }

    fn distance(p: Se2, q: Se2) -> f64 {
        let d = p.inverse().compose(q);
        d.x_m.hypot(d.y_m) + d.yaw_rad.abs()
    }

    proptest! {
        #[test]
        fn inverse_undoes(p in motion()) {
            prop_assert!(distance(p.compose(p.inverse()), Se2::IDENTITY) < 1e-12);
        }

        #[test]
        fn compose_is_associative(p in motion(), q in motion(), r in motion()) {
            let left = p.compose(q).compose(r);
            let right = p.compose(q.compose(r));
            prop_assert!(distance(left, right) < 1e-11);
        }

        #[test]
        fn exp_undoes_log(p in motion()) {
            prop_assert!(distance(Se2::exp(p.log()), p) < 1e-11);
        }

        #[test]
        fn exp_agrees_with_many_small_steps(dx in -2.0..2.0, dy in -2.0..2.0, dyaw in corner_angles()) {
            let step = Se2::exp(Twist { dx_m: dx / 1024.0, dy_m: dy / 1024.0, dyaw_rad: dyaw / 1024.0 });
            let walked = (0..1024).fold(Se2::IDENTITY, |p, _| p.compose(step));
            let jumped = Se2::exp(Twist { dx_m: dx, dy_m: dy, dyaw_rad: dyaw });
            prop_assert!(distance(walked, jumped) < 1e-9);
        }

        #[test]
        fn a_moved_point_agrees_with_composition(p in motion(), x in -5.0..5.0, y in -5.0..5.0) {
            let moved = p.transform_point(Vec2::new(x, y));
            let composed = p.compose(Se2::new(x, y, 0.0)).position();
            prop_assert!((moved - composed).norm() < 1e-12);
        }

        #[test]
        fn wrap_lands_in_range_and_keeps_the_direction(angle in -1e4..1e4) {
            let wrapped = wrap_to_pi(angle);
            prop_assert!((-PI..PI).contains(&wrapped));
            prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
            prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
        }
    }
}
