//! Settings of the filter.

use robot_models::{DriveGeometry, OdometryNoise};

/// How many particles there are and how they move and are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterConfig {
    /// Fewest particles, from 10 to 1 000 000.
    pub n_min: usize,
    /// Most particles, from `n_min` to 1 000 000.
    pub n_max: usize,
    /// The wheels.
    pub drive: DriveGeometry,
    /// How their ways err, at random.
    pub noise: OdometryNoise,
    /// Of a whole scan counts as much as so many beams seen apart would, from 1 to 100.
    pub n_independent: f64,
    /// Largest error of the particles' distribution that their number is chosen for, as a Kullback–Leibler distance, from
    /// 0.001 to 1; it is kept with a probability of 99 %.
    pub kld_max_ratio: f64,
    /// How quickly the two averages of agreement follow, per correction, from 0 to 1: when the quick one falls below the
    /// slow one, random particles are mixed in.
    pub recovery: [f64; 2],
    /// A beam that ends farther than this from everything on the map, at the best guess, is not used as long as
    /// most beams fit: somebody stands in its way. Metres, from 0.05 to 10.
    pub surprise_m: f64,
}

impl Default for FilterConfig {
    /// For an indoor robot with the wheels of a Pioneer 3-DX.
    fn default() -> Self {
        Self {
            n_min: 300,
            n_max: 20_000,
            drive: DriveGeometry {
                wheelbase_m: 0.38,
                wheel_diameter_m: 0.195,
                encoder_ticks_per_turn: 500.0,
                gear_ratio: 38.3,
            },
            noise: OdometryNoise { left_std_ratio: 0.02, right_std_ratio: 0.02 },
            n_independent: 6.0,
            kld_max_ratio: 0.02,
            recovery: [0.02, 0.3],
            surprise_m: 0.4,
        }
    }
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("localisation.{key} = {value}: must be {requirement}")]
pub struct ConfigError {
    /// The key.
    pub key: &'static str,
    /// What was given.
    pub value: f64,
    /// What is allowed.
    pub requirement: &'static str,
}

impl FilterConfig {
    /// The settings, if they hold together.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] for the first that does not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let ranges = [
            ("n_min", self.n_min as f64, 10.0, 1e6, "from 10 to 1 000 000"),
            ("n_max", self.n_max as f64, self.n_min as f64, 1e6, "from n_min to 1 000 000"),
            ("wheelbase_m", self.drive.wheelbase_m, 0.01, 2.0, "from 0.01 to 2 m"),
            ("noise.left_std_ratio", self.noise.left_std_ratio, 0.0, 1.0, "from 0 to 1"),
            ("noise.right_std_ratio", self.noise.right_std_ratio, 0.0, 1.0, "from 0 to 1"),
            ("n_independent", self.n_independent, 1.0, 100.0, "from 1 to 100"),
            ("kld_max_ratio", self.kld_max_ratio, 0.001, 1.0, "from 0.001 to 1"),
            ("recovery[0]", self.recovery[0], 0.0, 1.0, "from 0 to 1"),
            ("recovery[1]", self.recovery[1], 0.0, 1.0, "from 0 to 1"),
            ("surprise_m", self.surprise_m, 0.05, 10.0, "from 0.05 to 10 m"),
        ];
        for (key, value, least, most, requirement) in ranges {
            if !(least..=most).contains(&value) {
                return Err(ConfigError { key, value, requirement });
            }
        }
        Ok(self)
    }
}
