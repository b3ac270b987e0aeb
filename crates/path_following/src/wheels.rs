//! What every follower gives: two wheel speeds.

/// Speeds for the two wheels of a differential drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelReference {
    /// Left wheel, metres per second.
    pub left_mps: f64,
    /// Right wheel, metres per second.
    pub right_mps: f64,
}

impl WheelReference {
    /// Both wheels at rest.
    pub const STOP: Self = Self { left_mps: 0.0, right_mps: 0.0 };

    /// Both wheels at one speed.
    pub fn straight(speed_mps: f64) -> Self {
        Self { left_mps: speed_mps, right_mps: speed_mps }
    }

    /// An arc: `v_L` = v − γ v b/2, `v_R` = v + γ v b/2 for the curvature γ (1/m, positive to the left) and the
    /// wheelbase b (m).
    ///
    /// Source: the thesis, (5.13), (5.22). Differences: its (5.17) gives the left wheel the plus sign,
    /// which contradicts its (5.12).
    pub fn along_arc(speed_mps: f64, curvature_per_m: f64, wheelbase_m: f64) -> Self {
        Self::turning(speed_mps, curvature_per_m * speed_mps, wheelbase_m)
    }

    /// A speed and a turn rate (rad/s, positive to the left).
    pub fn turning(speed_mps: f64, turn_rate_radps: f64, wheelbase_m: f64) -> Self {
        let difference_mps = 0.5 * turn_rate_radps * wheelbase_m;
        Self { left_mps: speed_mps - difference_mps, right_mps: speed_mps + difference_mps }
    }

    /// Speed of the midpoint between the wheels, metres per second.
    pub fn linear_mps(self) -> f64 {
        0.5 * (self.left_mps + self.right_mps)
    }

    /// Turn rate, radians per second, positive to the left.
    pub fn angular_radps(self, wheelbase_m: f64) -> f64 {
        (self.right_mps - self.left_mps) / wheelbase_m
    }

    /// The same arc, slowed down so that no wheel exceeds `speed_max_mps` in size. Stops when a speed is not finite.
    #[must_use]
    pub fn limited(self, speed_max_mps: f64) -> Self {
        let fastest = self.left_mps.abs().max(self.right_mps.abs());
        if !(self.left_mps + self.right_mps).is_finite() {
            Self::STOP
        } else if fastest > speed_max_mps {
            let ratio = speed_max_mps / fastest;
            Self { left_mps: self.left_mps * ratio, right_mps: self.right_mps * ratio }
        } else {
            self
        }
    }
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: must be {requirement}")]
pub struct SettingError {
    /// The name of the setting, with its unit.
    pub key: &'static str,
    /// What was given.
    pub value: f64,
    /// What it must be.
    pub requirement: &'static str,
}

/// Checks that a setting is inside a range, ends included; not a number never is.
pub(crate) fn check_range(
    key: &'static str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    requirement: &'static str,
) -> Result<(), SettingError> {
    if range.contains(&value) { Ok(()) } else { Err(SettingError { key, value, requirement }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_left_arc_has_the_right_wheel_ahead() {
        // γ = 1/900 mm, v = 300 mm/s, b = 380 mm: Δv = 63.33 mm/s, by (5.22).
        let wheels = WheelReference::along_arc(0.3, 1.0 / 0.9, 0.38);
        assert!((wheels.left_mps - 0.236_667).abs() < 1e-6, "{wheels:?}");
        assert!((wheels.right_mps - 0.363_333).abs() < 1e-6, "{wheels:?}");
        assert!((wheels.linear_mps() - 0.3).abs() < 1e-15);
        assert!((wheels.angular_radps(0.38) - 0.3 / 0.9).abs() < 1e-12);
    }

    #[test]
    fn a_limit_keeps_the_arc() {
        let wheels = WheelReference { left_mps: -0.5, right_mps: 1.0 };
        assert_eq!(wheels.limited(0.5), WheelReference { left_mps: -0.25, right_mps: 0.5 });
        assert_eq!(wheels.limited(1.0), wheels);
        let backwards = WheelReference { left_mps: -1.0, right_mps: 0.5 };
        assert_eq!(backwards.limited(0.5), WheelReference { left_mps: -0.5, right_mps: 0.25 });
    }

    #[test]
    fn nonsense_stops() {
        let wheels = WheelReference { left_mps: f64::NAN, right_mps: 0.1 };
        assert_eq!(wheels.limited(1.0), WheelReference::STOP);
        let wheels = WheelReference { left_mps: 0.1, right_mps: f64::INFINITY };
        assert_eq!(wheels.limited(1.0), WheelReference::STOP);
    }

    #[test]
    fn a_range_refuses_what_is_no_number() {
        let error = check_range("gain", f64::NAN, 0.0..=1.0, "from 0 to 1").unwrap_err();
        assert_eq!(error.to_string(), "gain = NaN: must be from 0 to 1");
        assert!(check_range("gain", 1.0, 0.0..=1.0, "from 0 to 1").is_ok());
        assert!(check_range("gain", -0.1, 0.0..=1.0, "from 0 to 1").is_err());
    }
}
