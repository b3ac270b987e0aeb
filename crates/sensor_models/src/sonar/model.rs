//! The properties of a kind of sonar, and their ranges.

use std::f64::consts::FRAC_PI_2;

/// The properties of one kind of sonar. [`Default`] is the Pioneer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarModel {
    /// Nearer echoes are reported as this range, metres.
    pub range_min_m: f64,
    /// Farther echoes are not heard, metres; also the reading when nothing came back.
    pub range_max_m: f64,
    /// Half of the cone's opening, radians, up to π/4.
    pub half_angle_rad: f64,
    /// Rays over the cone along which echoes are sampled, beside the nearest point of every surface
    /// in sight, and mirrored sound is followed; at least 1, odd, so that one runs along the axis.
    pub n_rays: usize,
    /// Strength that an echo needs at the greatest range, in units of a wall's on the axis; it
    /// falls linearly to zero with the range. From 0 (hears everything) to 10.
    pub threshold_ratio: f64,
    /// Sensitivity at the edge of the cone relative to the axis, from 0 (excluded) to 1.
    pub edge_sensitivity_ratio: f64,
    /// Standard deviation of the range that does not depend on it, metres.
    pub range_std_m: f64,
    /// Standard deviation of the range per metre of range, a ratio.
    pub range_std_ratio: f64,
    /// Readings are the nearest whole number of these, metres; 0 for readings as fine as measured.
    pub range_step_m: f64,
    /// Standard deviation of the natural logarithm of an echo's strength from ping to ping.
    pub strength_std_ratio: f64,
    /// Probability that a mirrored ray is followed to a ghost.
    pub ghost_prob: f64,
    /// Probability that a ping hears nothing although an echo came.
    pub dropout_prob: f64,
    /// Probability that a ping hears another sensor instead: a uniform range up to the true one.
    pub crosstalk_prob: f64,
}

/// A setting of [`SonarModel`] outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: must be {requirement}")]
pub struct ModelRange {
    /// The field.
    pub key: &'static str,
    /// What it is.
    pub value: f64,
    /// What it must be, as prose.
    pub requirement: &'static str,
}

impl Default for SonarModel {
    /// The Pioneer's ring: 0.15 to 5 m, ±15 degrees, about a centimetre and a percent.
    fn default() -> Self {
        Self {
            range_min_m: 0.15,
            range_max_m: 5.0,
            half_angle_rad: 15.0_f64.to_radians(),
            n_rays: 9,
            threshold_ratio: 1.0,
            edge_sensitivity_ratio: 0.1,
            range_std_m: 0.005,
            range_std_ratio: 0.005,
            range_step_m: 0.0,
            strength_std_ratio: 0.25,
            ghost_prob: 0.5,
            dropout_prob: 0.01,
            crosstalk_prob: 0.001,
        }
    }
}

impl SonarModel {
    /// A sonar without any error: the nearest surface in its cone, exactly, whatever it is made of.
    pub fn ideal() -> Self {
        Self {
            threshold_ratio: 0.0,
            edge_sensitivity_ratio: 1.0,
            range_std_m: 0.0,
            range_std_ratio: 0.0,
            strength_std_ratio: 0.0,
            ghost_prob: 0.0,
            dropout_prob: 0.0,
            crosstalk_prob: 0.0,
            ..Self::default()
        }
    }

    /// Refuses settings outside the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// [`ModelRange`] for the first such setting; NaN is outside every range.
    pub fn checked(self) -> Result<Self, ModelRange> {
        let n_rays = self.n_rays as f64;
        let checks = [
            ("range_min_m", self.range_min_m, 0.0, 100.0, "from 0 to 100 m"),
            ("range_max_m", self.range_max_m, self.range_min_m, 100.0, "from range_min_m to 100 m"),
            ("half_angle_rad", self.half_angle_rad, 0.0, 0.5 * FRAC_PI_2, "from 0 to 0.785 rad"),
            ("n_rays", n_rays, 1.0, 999.0, "from 1 to 999"),
            ("threshold_ratio", self.threshold_ratio, 0.0, 10.0, "from 0 to 10"),
            (
                "edge_sensitivity_ratio",
                self.edge_sensitivity_ratio,
                1e-6,
                1.0,
                "from 0.000001 to 1",
            ),
            ("range_std_m", self.range_std_m, 0.0, 1.0, "from 0 to 1 m"),
            ("range_std_ratio", self.range_std_ratio, 0.0, 1.0, "from 0 to 1"),
            ("range_step_m", self.range_step_m, 0.0, 1.0, "from 0 to 1 m"),
            ("strength_std_ratio", self.strength_std_ratio, 0.0, 10.0, "from 0 to 10"),
            ("ghost_prob", self.ghost_prob, 0.0, 1.0, "from 0 to 1"),
            ("dropout_prob", self.dropout_prob, 0.0, 1.0, "from 0 to 1"),
            ("crosstalk_prob", self.crosstalk_prob, 0.0, 1.0, "from 0 to 1"),
        ];
        for (key, value, min, max, requirement) in checks {
            if !(min..=max).contains(&value) {
                return Err(ModelRange { key, value, requirement });
            }
        }
        Ok(self)
    }
}
