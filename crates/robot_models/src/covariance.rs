//! How uncertain dead reckoning is: a covariance carried along the path.
//!
//! Assumes that the two wheels' random errors are independent and Gaussian with variances that
//! grow with the way. Systematic errors (unequal diameters, wheelbase) are not in it: calibrate
//! them, or enlarge the ratios.

use geometry::{Se2, Twist};
use nalgebra::{Matrix2, Matrix3, Matrix3x2};

use crate::drive::{DriveGeometry, WheelTravel};

/// Below this |turn| (rad) the derivatives of the arc are taken from their series; its error
/// there is under 1e-12.
const SMALL_ANGLE_RAD: f64 = 1e-3;

/// Random errors of the two wheels' ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryNoise {
    /// Standard deviation of the left wheel's way after rolling 1 m, as a ratio; it grows with
    /// the root of the way.
    pub left_std_ratio: f64,
    /// The same of the right wheel.
    pub right_std_ratio: f64,
}

/// Covariance of a planar pose; order x (m), y (m), yaw (rad), all in the frame of the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseCovariance(pub Matrix3<f64>);

/// An ellipse around a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertaintyEllipse {
    /// Longer half axis, metres.
    pub semi_major_m: f64,
    /// Shorter half axis, metres.
    pub semi_minor_m: f64,
    /// Direction of the longer axis, radians, in [−π/2, π/2].
    pub yaw_rad: f64,
}

impl Default for OdometryNoise {
    /// Three millimetres per root metre and wheel: an indoor robot on a hard floor.
    fn default() -> Self {
        Self { left_std_ratio: 0.003, right_std_ratio: 0.003 }
    }
}

impl PoseCovariance {
    /// A pose known exactly.
    pub fn zero() -> Self {
        Self(Matrix3::zeros())
    }

    /// The covariance after the position was measured with a standard deviation of `position_std_m` (m) in every
    /// direction, and the heading, if it was, with `heading_std_rad` (rad). Nothing becomes less certain.
    #[must_use]
    pub fn fixed(&self, position_std_m: f64, heading_std_rad: Option<f64>) -> Self {
        let least = |known: f64, std: Option<f64>| std.map_or(known, |std| known.min(std * std));
        let position = Some(position_std_m);
        Self(Matrix3::from_diagonal(&nalgebra::Vector3::new(
            least(self.0[(0, 0)], position),
            least(self.0[(1, 1)], position),
            least(self.0[(2, 2)], heading_std_rad),
        )))
    }

    /// The covariance after the wheels rolled by `left_m` and `right_m` (m) from a pose with
    /// heading `yaw_rad`.
    ///
    /// Constant time. `P ← F P Fᵀ + G Q Gᵀ`, with the Jacobians F (by the pose) and G (by the two
    /// wheels' ways) of the exact arc.
    ///
    /// Source: own derivation, from p' = p · exp(ΔS, Δθ) with (3.4) and (3.5); the thesis shows
    /// the ellipses (Fig. 3.1) without equations.
    #[must_use]
    pub fn propagated(
        &self,
        yaw_rad: f64,
        left_m: f64,
        right_m: f64,
        drive: &DriveGeometry,
        noise: &OdometryNoise,
    ) -> Self {
        let travel = WheelTravel { left_m, right_m };
        let (f, g) = jacobians(yaw_rad, travel, drive);
        let q = Matrix2::new(
            noise.left_std_ratio.powi(2) * left_m.abs(),
            0.0,
            0.0,
            noise.right_std_ratio.powi(2) * right_m.abs(),
        );
        let p = f * self.0 * f.transpose() + g * q * g.transpose();
        // Rounding must not make it lopsided: later steps would amplify that.
        Self(0.5 * (p + p.transpose()))
    }

    /// The ellipse that holds the position with the certainty of `n_sigma` standard deviations
    /// along each axis: 39 %, 86 %, 99 % for 1, 2, 3.
    pub fn ellipse(&self, n_sigma: f64) -> UncertaintyEllipse {
        let (a, b, d) = (self.0[(0, 0)], self.0[(0, 1)], self.0[(1, 1)]);
        // Eigenvalues of [a b; b d]: mean ± radius.
        let mean = 0.5 * (a + d);
        let radius = (0.5 * (a - d)).hypot(b);
        UncertaintyEllipse {
            semi_major_m: n_sigma * (mean + radius).max(0.0).sqrt(),
            semi_minor_m: n_sigma * (mean - radius).max(0.0).sqrt(),
            yaw_rad: 0.5 * (2.0 * b).atan2(a - d),
        }
    }

    /// Standard deviation of the heading, radians.
    pub fn yaw_std_rad(&self) -> f64 {
        self.0[(2, 2)].max(0.0).sqrt()
    }
}

impl UncertaintyEllipse {
    /// Point of the outline (x, y in m) around `centre` at the parameter `phase_rad`; a whole
    /// turn of it draws the ellipse.
    pub fn outline_point(&self, centre: geometry::Vec2, phase_rad: f64) -> geometry::Vec2 {
        let (s, c) = phase_rad.sin_cos();
        let along = Se2::new(0.0, 0.0, self.yaw_rad);
        centre + along.rotate(geometry::Vec2::new(self.semi_major_m * c, self.semi_minor_m * s))
    }
}

/// Jacobians of the pose after a step: by the pose before, and by (left, right) way.
fn jacobians(
    yaw_rad: f64,
    travel: WheelTravel,
    drive: &DriveGeometry,
) -> (Matrix3<f64>, Matrix3x2<f64>) {
    let Twist { dx_m: ds, dyaw_rad: turn, .. } = drive.body_twist(travel);
    let heading = Se2::new(0.0, 0.0, yaw_rad);
    // The step in the frame before: ds · (a, c) with a = sin t / t, c = (1 − cos t) / t.
    let (a, c, a_dot, c_dot) = arc_shape(turn);
    let step = heading.rotate(geometry::Vec2::new(ds * a, ds * c));
    // A heading error turns the step about its start.
    let f = Matrix3::new(1.0, 0.0, -step.y, 0.0, 1.0, step.x, 0.0, 0.0, 1.0);
    let by_way = heading.rotate(geometry::Vec2::new(a, c));
    let by_turn = heading.rotate(geometry::Vec2::new(ds * a_dot, ds * c_dot));
    // ds = (l + r) / 2, t = (r − l) / b
    let per_base = 1.0 / drive.wheelbase_m;
    let left = 0.5 * by_way - per_base * by_turn;
    let right = 0.5 * by_way + per_base * by_turn;
    let g = Matrix3x2::new(left.x, right.x, left.y, right.y, -per_base, per_base);
    (f, g)
}

/// sin t / t, (1 − cos t) / t and their derivatives by t.
fn arc_shape(turn: f64) -> (f64, f64, f64, f64) {
    if turn.abs() < SMALL_ANGLE_RAD {
        let squared = turn * turn;
        return (
            1.0 - squared / 6.0,
            0.5 * turn * (1.0 - squared / 12.0),
            -turn / 3.0 * (1.0 - squared / 10.0),
            0.5 - squared / 8.0,
        );
    }
    let (s, c) = turn.sin_cos();
    let versine = 2.0 * (0.5 * turn).sin().powi(2);
    (s / turn, versine / turn, (turn * c - s) / (turn * turn), (turn * s - versine) / (turn * turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vec2;
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use rand_distr::{Distribution, StandardNormal};
    use run_context::{RandomStream, RunSeed};

    #[test]
    fn a_fix_bounds_what_it_measures_and_nothing_else() {
        let wide = PoseCovariance(Matrix3::from_diagonal(&Vector3::new(0.04, 1e-6, 0.01)));
        let position = wide.fixed(0.1, None);
        assert_eq!(position.0.diagonal(), Vector3::new(0.1 * 0.1, 1e-6, 0.01));
        let both = wide.fixed(0.1, Some(0.05));
        assert_eq!(both.0.diagonal(), Vector3::new(0.1 * 0.1, 1e-6, 0.05 * 0.05));
        assert_eq!(wide.fixed(9.0, Some(9.0)), wide);
    }

    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.38,
        wheel_diameter_m: 0.1953,
        encoder_ticks_per_turn: 500.0,
        gear_ratio: 38.3,
    };
    const NOISE: OdometryNoise = OdometryNoise { left_std_ratio: 0.01, right_std_ratio: 0.015 };

    /// A step of the exact arc, by the textbook's radius and centre; shares no code.
    fn step(pose: Vector3<f64>, left_m: f64, right_m: f64) -> Vector3<f64> {
        let (ds, turn) = (0.5 * (left_m + right_m), (right_m - left_m) / 0.38);
        let (x, y, yaw) = (pose.x, pose.y, pose.z);
        if turn.abs() < 1e-9 {
            return Vector3::new(x + ds * yaw.cos(), y + ds * yaw.sin(), yaw + turn);
        }
        let r = ds / turn;
        let end = yaw + turn;
        Vector3::new(x + r * (end.sin() - yaw.sin()), y - r * (end.cos() - yaw.cos()), end)
    }

    /// Both signs, both sides of the series' limit, and straight ahead.
    fn ways() -> impl Strategy<Value = (f64, f64)> {
        let by_turn = |(ds, turn): (f64, f64)| (ds - 0.19 * turn, ds + 0.19 * turn);
        let turns = prop_oneof![Just(0.0), -2e-3..2e-3, -1.0..1.0, Just(0.999e-3), Just(-1.001e-3)];
        (-0.5..0.5, turns).prop_map(by_turn)
    }

    proptest! {
        #[test]
        fn jacobians_match_central_differences((l, r) in ways(), yaw in -3.0..3.0) {
            let (f, g) = jacobians(yaw, WheelTravel { left_m: l, right_m: r }, &DRIVE);
            let pose = Vector3::new(1.0, -2.0, yaw);
            let h = 1e-5;
            for axis in 0..3 {
                let mut nudge = Vector3::zeros();
                nudge[axis] = h;
                let slope = (step(pose + nudge, l, r) - step(pose - nudge, l, r)) / (2.0 * h);
                prop_assert!((f.column(axis) - slope).norm() < 1e-5, "F{axis} {slope}");
            }
            let by_left = (step(pose, l + h, r) - step(pose, l - h, r)) / (2.0 * h);
            let by_right = (step(pose, l, r + h) - step(pose, l, r - h)) / (2.0 * h);
            prop_assert!((g.column(0) - by_left).norm() < 1e-5, "left {by_left} {g}");
            prop_assert!((g.column(1) - by_right).norm() < 1e-5, "right {by_right} {g}");
        }

        #[test]
        fn covariance_stays_symmetric_positive_and_never_forgets(
            steps in proptest::collection::vec(ways(), 1..30),
        ) {
            let mut p = PoseCovariance::zero();
            let mut yaw = 0.0;
            for (l, r) in steps {
                let next = p.propagated(yaw, l, r, &DRIVE, &NOISE);
                prop_assert!(next.0 == next.0.transpose());
                prop_assert!(next.0.symmetric_eigenvalues().min() > -1e-12);
                prop_assert!(next.yaw_std_rad() >= p.yaw_std_rad());
                p = next;
                yaw += (r - l) / 0.38;
            }
        }
    }

    fn gauss(rng: &mut RandomStream) -> f64 {
        StandardNormal.sample(rng)
    }

    /// An S of 3 m in 60 steps.
    fn path() -> impl Iterator<Item = (f64, f64)> {
        (0..60).map(|k| if k < 30 { (0.048, 0.052) } else { (0.052, 0.048) })
    }

    /// 20 000 seeded noisy drives against the propagated covariance. A sample variance of n
    /// Gaussians has the relative deviation √(2/n) = 1 %, a correlation at most 1/√n = 0.7 %;
    /// bounds are 5 of those plus 1 % for curvature: false alarm below 1e-5.
    #[test]
    fn twenty_thousand_drives_scatter_as_predicted() {
        let mut predicted = PoseCovariance::zero();
        let mut mean = Vector3::zeros();
        for (l, r) in path() {
            predicted = predicted.propagated(mean.z, l, r, &DRIVE, &NOISE);
            mean = step(mean, l, r);
        }
        let n = 20_000;
        let mut rng = RunSeed(17).stream("drives");
        let ends: Vec<Vector3<f64>> = (0..n)
            .map(|_| {
                path().fold(Vector3::zeros(), |pose, (l, r)| {
                    let noisy_l = l + 0.01 * l.sqrt() * gauss(&mut rng);
                    step(pose, noisy_l, r + 0.015 * r.sqrt() * gauss(&mut rng))
                })
            })
            .collect();
        let centre: Vector3<f64> = ends.iter().sum::<Vector3<f64>>() / f64::from(n);
        let sampled =
            ends.iter().map(|e| (e - centre) * (e - centre).transpose()).sum::<Matrix3<f64>>()
                / f64::from(n - 1);
        for i in 0..3 {
            for j in 0..3 {
                let scale = (predicted.0[(i, i)] * predicted.0[(j, j)]).sqrt();
                let gap = (sampled[(i, j)] - predicted.0[(i, j)]) / scale;
                assert!(gap.abs() < 0.06, "({i}, {j}): {sampled} {}", predicted.0);
            }
        }

        // The ellipse of n σ holds 1 − exp(−n²/2) of the ends: 5 σ of a binomial is 1.7 %.
        for (n_sigma, share) in [(1.0, 0.3935), (2.0, 0.8647), (3.0, 0.9889)] {
            let ellipse = predicted.ellipse(n_sigma);
            let inside = ends.iter().filter(|e| {
                let offset = Vec2::new(e.x - mean.x, e.y - mean.y);
                let (s, c) = ellipse.yaw_rad.sin_cos();
                let (u, v) = (c * offset.x + s * offset.y, -s * offset.x + c * offset.y);
                (u / ellipse.semi_major_m).powi(2) + (v / ellipse.semi_minor_m).powi(2) <= 1.0
            });
            let inside = inside.count() as f64 / f64::from(n);
            assert!((inside - share).abs() < 0.025, "{n_sigma} σ: {inside}");
        }
    }

    #[test]
    fn straight_driving_is_less_sure_sideways_than_along() {
        // σ_yaw = √2 · 0.01 · √s / b; sideways it has integrated: ∫ gives s·σ_yaw/√3.
        let noise = OdometryNoise { left_std_ratio: 0.01, right_std_ratio: 0.01 };
        let mut p = PoseCovariance::zero();
        for _ in 0..1000 {
            p = p.propagated(0.0, 0.01, 0.01, &DRIVE, &noise);
        }
        let yaw_std = 2.0_f64.sqrt() * 0.01 * 10.0_f64.sqrt() / 0.38;
        assert!((p.yaw_std_rad() / yaw_std - 1.0).abs() < 1e-9);
        let sideways = p.0[(1, 1)].sqrt();
        assert!((sideways / (10.0 * yaw_std / 3.0_f64.sqrt()) - 1.0).abs() < 0.01);
        let ellipse = p.ellipse(1.0);
        assert!(ellipse.semi_major_m > 10.0 * ellipse.semi_minor_m);
        assert!((ellipse.yaw_rad.abs() - std::f64::consts::FRAC_PI_2).abs() < 0.01);
    }

    #[test]
    fn an_ellipse_is_drawn_along_its_axes() {
        let p = PoseCovariance(Matrix3::new(0.04, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0));
        let ellipse = p.ellipse(2.0);
        assert!((ellipse.semi_major_m - 0.4).abs() < 1e-12);
        assert!((ellipse.semi_minor_m - 0.2).abs() < 1e-12);
        let quarter = ellipse.outline_point(Vec2::new(1.0, 1.0), std::f64::consts::FRAC_PI_2);
        assert!((quarter - Vec2::new(1.0, 1.2)).norm() < 1e-12);
        assert!(PoseCovariance::zero().ellipse(3.0).semi_major_m.abs() < 1e-12);
    }
}
