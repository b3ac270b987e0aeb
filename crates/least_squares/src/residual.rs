//! The error of one edge and its derivatives.
//!
//! e = z⁻¹ ∘ (x_i⁻¹ ∘ x_j): the translation, and the wrapped angle. This is the convention of the
//! published pose graphs, so sums of eᵀΩe compare. (With the logarithm of the motion in place of its
//! translation, as some solvers have it, the optima differ by a few parts in ten thousand.) Poses
//! are moved by adding to (x, y, yaw).

use std::f64::consts::PI;

use geometry::{Se2, wrap_to_pi};
use nalgebra::{Matrix3, Vector3};

/// Cosine and sine of an angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heading {
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl Heading {
    pub(crate) fn of(yaw_rad: f64) -> Self {
        let (sin, cos) = yaw_rad.sin_cos();
        Self { cos, sin }
    }
}

/// What the normal equations need of one edge; e and its derivatives in a factored form.
///
/// The derivative by x_j is J = [M 0; 0 1] with M = R(yaw_i + yaw_z)ᵀ, and that by x_i is -J T with
/// T = [I q; 0 1] and q = (-Δy, Δx), where Δ is the position of j less that of i.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linearised {
    pub(crate) error: Vector3<f64>,
    /// M = [cos sin; -sin cos].
    pub(crate) turn: Heading,
    /// q.
    pub(crate) lever: [f64; 2],
}

/// Linearises the edge that measured `z` from pose `i` to pose `j`.
#[inline]
pub(crate) fn linearise(
    i: Se2,
    i_heading: Heading,
    j: Se2,
    z: Se2,
    z_heading: Heading,
) -> Linearised {
    let (dx, dy) = (j.x_m - i.x_m, j.y_m - i.y_m);
    let turn = Heading {
        cos: i_heading.cos * z_heading.cos - i_heading.sin * z_heading.sin,
        sin: i_heading.sin * z_heading.cos + i_heading.cos * z_heading.sin,
    };
    // e_t = R_zᵀ (R_iᵀ Δ - t_z) = M Δ - R_zᵀ t_z.
    let error = Vector3::new(
        turn.cos * dx + turn.sin * dy - (z_heading.cos * z.x_m + z_heading.sin * z.y_m),
        -turn.sin * dx + turn.cos * dy - (-z_heading.sin * z.x_m + z_heading.cos * z.y_m),
        wrapped(j.yaw_rad - i.yaw_rad - z.yaw_rad),
    );
    Linearised { error, turn, lever: [-dy, dx] }
}

/// As `wrap_to_pi`, but quick and without a change of bits where nothing has to be done.
#[inline]
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    if (-PI..PI).contains(&angle_rad) || !angle_rad.is_finite() {
        angle_rad
    } else {
        wrap_to_pi(angle_rad)
    }
}

impl Linearised {
    /// J, the derivative of e by x_j.
    #[inline]
    pub(crate) fn by_to(&self) -> Matrix3<f64> {
        let Heading { cos, sin } = self.turn;
        Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0)
    }

    /// T; the derivative of e by x_i is -J T.
    #[inline]
    pub(crate) fn transport(&self) -> Matrix3<f64> {
        let [a, b] = self.lever;
        Matrix3::new(1.0, 0.0, a, 0.0, 1.0, b, 0.0, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pose() -> impl Strategy<Value = Se2> {
        (-20.0..20.0, -20.0..20.0, -PI..PI).prop_map(|(x, y, yaw)| Se2::new(x, y, yaw))
    }

    fn error(i: Se2, j: Se2, z: Se2) -> Vector3<f64> {
        linearise(i, Heading::of(i.yaw_rad), j, z, Heading::of(z.yaw_rad)).error
    }

    fn moved(p: Se2, axis: usize, by: f64) -> Se2 {
        let step = [0, 1, 2].map(|a| if a == axis { by } else { 0.0 });
        Se2::new(p.x_m + step[0], p.y_m + step[1], p.yaw_rad + step[2])
    }

    proptest! {
        #[test]
        fn the_error_is_the_composition(i in pose(), j in pose(), z in pose()) {
            let composed = z.inverse().compose(i.inverse().compose(j));
            let e = error(i, j, z);
            prop_assert!((e.x - composed.x_m).abs() < 1e-12);
            prop_assert!((e.y - composed.y_m).abs() < 1e-12);
            prop_assert!(wrap_to_pi(e.z - composed.yaw_rad).abs() < 1e-12);
        }

        #[test]
        fn derivatives_agree_with_central_differences(i in pose(), j in pose(), z in pose()) {
            let at = linearise(i, Heading::of(i.yaw_rad), j, z, Heading::of(z.yaw_rad));
            let (by_j, by_i) = (at.by_to(), -at.by_to() * at.transport());
            let h = 1e-6;
            for axis in 0..3 {
                let mut di = error(moved(i, axis, h), j, z) - error(moved(i, axis, -h), j, z);
                let mut dj = error(i, moved(j, axis, h), z) - error(i, moved(j, axis, -h), z);
                di.z = wrap_to_pi(di.z);
                dj.z = wrap_to_pi(dj.z);
                prop_assert!((di / (2.0 * h) - by_i.column(axis)).norm() < 1e-6);
                prop_assert!((dj / (2.0 * h) - by_j.column(axis)).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn wrapping_keeps_bits_in_range_and_lets_what_is_not_finite_through() {
        assert_eq!(wrapped(0.1).to_bits(), 0.1_f64.to_bits());
        assert_eq!(wrapped(-PI).to_bits(), (-PI).to_bits());
        assert!(
            (wrapped(PI) + PI).abs() < 1e-15 && (wrapped(-4.0) - (2.0 * PI - 4.0)).abs() < 1e-15
        );
        assert!(wrapped(f64::NAN).is_nan());
    }
}
