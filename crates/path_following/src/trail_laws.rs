//! Following a trail that is only smelled: from two intensities to wheel speeds.
//!
//! What arrives each control period are `P_L` and `P_R` of the two antennas (100 per unit source), and
//! perhaps the direction of the equivalent source; there is no map and no pose here. A positive
//! difference `P_L − P_R` means that the trail is on the left.
//!
//! Which one: the fuzzy law is the one the thesis tested and the most robust here. Pure pursuit is the
//! smoothest when the server also tells the equivalent source. The bio-mimetic law is for lessons.

use std::time::Duration;

use crate::{
    SettingError, WheelReference,
    fuzzy::{FuzzyConfig, FuzzyController, Sets},
    fuzzy_listing::{ListingConfig, ListingFuzzy},
    law_table::law_table,
    path_laws::widths,
    wheels::check_range,
};

/// What the robot perceives of the trail.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrailSense {
    /// Left antenna, ≥ 0; 100 is one unit source at the antenna.
    pub left: f64,
    /// Right antenna, the same.
    pub right: f64,
    /// The equivalent source, where it is known. Laws that steer for it otherwise guess it from
    /// the two antennas, see [`TwoAntennas`].
    pub equivalent: Option<EquivalentPoint>,
}

/// A point seen from the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquivalentPoint {
    /// From the heading, radians, left positive.
    pub bearing_rad: f64,
    /// From the robot, metres.
    pub distance_m: f64,
}

/// What is assumed of the antennas when the equivalent source must be guessed from them alone.
///
/// With one source of intensity N p₀ each antenna is at the distance d = σ (1 − P / (N p₀)) from it
/// (5.48); the difference of the two distances gives the bearing, their mean the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoAntennas {
    /// Reach of an antenna (σ), metres, 0.05 to 10.
    pub sigma_m: f64,
    /// Between the antennas (b), metres, 0.01 to 5.
    pub spacing_m: f64,
    /// N p₀ of the sources usually within reach in front, 100 per unit source, 1 to 1e6.
    pub total_intensity: f64,
}

impl Default for TwoAntennas {
    /// The thesis's antennas on a one-cell trail of unit sources in cells of 0.2 m: three are in reach.
    fn default() -> Self {
        Self { sigma_m: 0.6, spacing_m: 0.38, total_intensity: 300.0 }
    }
}

/// Which reading of the bio-mimetic law (5.44), whose wheel subscripts are illegible in print.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BioMimeticReading {
    /// `v_L` = K (1 − max(0, `P_L − P_R`)), `v_R` = K (1 − max(0, `P_R` − `P_L`)): steers rightly throughout.
    #[default]
    Repaired,
    /// As printed with the first formula for the left wheel: steers rightly for differences above a
    /// half only, and stands still on the trail.
    PrintedLeft,
    /// As printed with the first formula for the right wheel: steers rightly below a half only.
    PrintedRight,
}

law_table! {
    /// A law that keeps a robot on a trail it smells, by its name.
    ///
    /// This table is the list of trail laws: missions, the guide and the tests of every law read it.
    pub enum TrailController: fn(TrailTuning) -> TrailLaw {
        #[default]
        Fuzzy = "fuzzy", "fuzzy on the difference of the two antennas (5.45), three sets", |t| TrailLaw::Fuzzy { fuzzy: t.fuzzy };
        FuzzyFine = "fuzzy_fine", "the same with five sets", |t| TrailLaw::Fuzzy { fuzzy: FuzzyConfig { sets: Sets::Five, ..t.fuzzy } };
        Listing = "listing", "the same in the integer arithmetic of the thesis's program, at speeds of its own", |t| TrailLaw::Listing { config: t.listing };
        BioMimetic = "bio_mimetic", "the nearer antenna brakes its own wheel (5.44)", |_| TrailLaw::bio_mimetic();
        FuzzyAngle = "fuzzy_angle", "fuzzy on the direction of the equivalent source (5.46)", |_| TrailLaw::fuzzy_angle();
        PurePursuit = "pure_pursuit", "drives the arc through the equivalent source (5.47), (5.48)", |_| TrailLaw::pure_pursuit();
    }
}

/// Sets, rules and constants that a mission may set, for the laws that have some.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrailTuning {
    /// Of the fuzzy laws on the difference of the antennas, in intensity units.
    pub fuzzy: FuzzyConfig,
    /// Of the integer controller.
    pub listing: ListingConfig,
}

impl TrailController {
    /// The law, tuned so as far as it can be.
    pub fn law(self, tuning: TrailTuning) -> TrailLaw {
        (self.maker())(tuning)
    }

    /// Whether it reads the sets and rules of [`TrailTuning`].
    pub fn has_rules(self) -> bool {
        match self.law(TrailTuning::default()) {
            TrailLaw::Fuzzy { .. } | TrailLaw::Listing { .. } => true,
            TrailLaw::BioMimetic { .. }
            | TrailLaw::FuzzyAngle { .. }
            | TrailLaw::PurePursuit { .. } => false,
        }
    }

    /// Whether it has speeds of its own and does not heed the speed asked for.
    pub fn has_own_speeds(self) -> bool {
        matches!(self.law(TrailTuning::default()), TrailLaw::Listing { .. })
    }

    /// Whether its sets fit speeds above the 0.3 m/s that all are tuned for, see [`TrailFollower::step_at_pace`].
    pub fn fits_to_speed(self) -> bool {
        matches!(self.law(TrailTuning::default()), TrailLaw::Fuzzy { .. })
    }
}

/// How a trail is followed, and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrailLaw {
    /// Fuzzy on e = `P_L − P_R` (5.45).
    Fuzzy {
        /// Sets and rules, in intensity units.
        fuzzy: FuzzyConfig,
    },
    /// The same in the thesis's integer arithmetic. Has its own speeds and ignores the speed asked for.
    Listing {
        /// The program's constants.
        config: ListingConfig,
    },
    /// The nearer antenna brakes its own wheel (5.44).
    BioMimetic {
        /// The intensity that counts as 1, 1 to 1e6.
        intensity_full: f64,
        /// Which reading of the print.
        reading: BioMimeticReading,
    },
    /// Fuzzy on the direction of the equivalent source, `e = φ_R − θ₀` (5.46).
    FuzzyAngle {
        /// Sets and rules, in radians.
        fuzzy: FuzzyConfig,
        /// For when the equivalent source must be guessed.
        antennas: TwoAntennas,
    },
    /// Pure pursuit of the equivalent source (5.47), (5.48), (5.12).
    PurePursuit {
        /// For when the equivalent source must be guessed.
        antennas: TwoAntennas,
        /// A source nearer than this is pursued as if it were so far, metres, 0.02 to 5.
        lookahead_min_m: f64,
    },
}

impl TrailLaw {
    /// Fuzzy with three sets and the default tuning.
    pub fn fuzzy() -> Self {
        Self::Fuzzy { fuzzy: FuzzyConfig::default() }
    }

    /// The integer controller with the default constants.
    pub fn listing() -> Self {
        Self::Listing { config: ListingConfig::default() }
    }

    /// The repaired bio-mimetic law.
    pub fn bio_mimetic() -> Self {
        Self::BioMimetic { intensity_full: 100.0, reading: BioMimeticReading::default() }
    }

    /// Fuzzy on the equivalent source's direction.
    pub fn fuzzy_angle() -> Self {
        Self::FuzzyAngle {
            fuzzy: FuzzyConfig { error_full: 0.8, change_full: 0.4, ..FuzzyConfig::default() },
            antennas: TwoAntennas::default(),
        }
    }

    /// Pure pursuit of the equivalent source.
    pub fn pure_pursuit() -> Self {
        Self::PurePursuit { antennas: TwoAntennas::default(), lookahead_min_m: 0.25 }
    }
}

/// A law and what goes with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailFollowerConfig {
    /// How the trail is followed.
    pub law: TrailLaw,
    /// Between the wheels (b), metres, 0.02 to 5.
    pub wheelbase_m: f64,
    /// No wheel is asked for more, metres per second, 0.01 to 10.
    pub wheel_speed_max_mps: f64,
    /// Speed straight on while nothing is perceived, metres per second, 0 to 10.
    pub lost_speed_mps: f64,
}

impl Default for TrailFollowerConfig {
    /// Fuzzy, b = 0.38 m, 80 mm/s when lost (`V_L` = `V_R` = 4 units of 20 mm/s in the thesis's program).
    fn default() -> Self {
        Self {
            law: TrailLaw::fuzzy(),
            wheelbase_m: 0.38,
            wheel_speed_max_mps: 0.75,
            lost_speed_mps: 0.08,
        }
    }
}

/// Sets fit a robot between so many times the speed that its law was tuned at.
const PACE_MIN_RATIO: f64 = 0.34;
const PACE_MAX_RATIO: f64 = 4.0;

/// A controller that keeps a robot on a trail it smells.
///
/// ```
/// use std::time::Duration;
/// use path_following::{TrailFollower, TrailFollowerConfig, TrailSense};
///
/// let mut follower = TrailFollower::new(TrailFollowerConfig::default()).unwrap();
/// let sensed = TrailSense { left: 140.0, right: 120.0, equivalent: None };
/// let wheels = follower.step(sensed, 0.3, Duration::from_millis(200));
/// assert!(wheels.right_mps > wheels.left_mps, "the trail is on the left");
/// ```
#[derive(Clone, Debug)]
pub struct TrailFollower {
    config: TrailFollowerConfig,
    machine: Machine,
    previous_error: Option<f64>,
    lost_for: Duration,
}

#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one per robot, and boxing it would cost a fetch per step"
)]
enum Machine {
    Float(FuzzyController),
    Listing(ListingFuzzy),
    None,
}

impl TrailFollower {
    /// Checks the settings.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: TrailFollowerConfig) -> Result<Self, SettingError> {
        check_range("wheelbase_m", config.wheelbase_m, 0.02..=5.0, "from 0.02 to 5 m")?;
        let speed_max = config.wheel_speed_max_mps;
        check_range("wheel_speed_max_mps", speed_max, 0.01..=10.0, "from 0.01 to 10 m/s")?;
        check_range("lost_speed_mps", config.lost_speed_mps, 0.0..=10.0, "from 0 to 10 m/s")?;
        let machine = match config.law {
            TrailLaw::Fuzzy { fuzzy } => Machine::Float(FuzzyController::new(fuzzy)?),
            TrailLaw::FuzzyAngle { fuzzy, antennas } => {
                antennas.check()?;
                Machine::Float(FuzzyController::new(fuzzy)?)
            }
            TrailLaw::Listing { config } => Machine::Listing(ListingFuzzy::new(config)?),
            TrailLaw::BioMimetic { intensity_full, .. } => {
                check_range("intensity_full", intensity_full, 1.0..=1e6, "from 1 to 1e6")?;
                Machine::None
            }
            TrailLaw::PurePursuit { antennas, lookahead_min_m } => {
                antennas.check()?;
                check_range("lookahead_min_m", lookahead_min_m, 0.02..=5.0, "from 0.02 to 5 m")?;
                Machine::None
            }
        };
        Ok(Self { config, machine, previous_error: None, lost_for: Duration::ZERO })
    }

    /// Wheel speeds for what is perceived now, `dt` after the last step, around the speed wanted (m/s, ≥ 0).
    ///
    /// When neither antenna perceives anything the robot goes slowly straight on; how far that may go is
    /// the caller's decision, see [`lost_for`](Self::lost_for). Stops for arguments that are not finite.
    /// O(1), allocates nothing.
    pub fn step(&mut self, sensed: TrailSense, speed_mps: f64, dt: Duration) -> WheelReference {
        self.step_at_pace(sensed, speed_mps, 1.0, dt)
    }

    /// The same for a robot whose present speed is `pace_ratio` times the one that its law was tuned at.
    ///
    /// A slow robot's error changes slowly, so that [`TrailLaw::Fuzzy`] scales the change up, at most threefold; for a
    /// fast one both its sets are wider, see [`widths`]. Other laws have no sets that fit.
    pub fn step_at_pace(
        &mut self,
        sensed: TrailSense,
        speed_mps: f64,
        pace_ratio: f64,
        dt: Duration,
    ) -> WheelReference {
        if !(sensed.left + sensed.right + speed_mps).is_finite() {
            return WheelReference::STOP;
        }
        let lost = sensed.left <= 0.0 && sensed.right <= 0.0;
        self.lost_for = if lost { self.lost_for.saturating_add(dt) } else { Duration::ZERO };
        if let Machine::Listing(listing) = &mut self.machine {
            let out = listing.step(to_byte(sensed.left), to_byte(sensed.right));
            return out.wheels().limited(self.config.wheel_speed_max_mps);
        }
        if lost {
            // A difference to what was smelled before the gap would be no rate of change.
            self.previous_error = None;
            return WheelReference::straight(self.config.lost_speed_mps)
                .limited(self.config.wheel_speed_max_mps);
        }
        let wheels = match self.config.law {
            TrailLaw::Fuzzy { .. } => {
                let sets = widths(pace_ratio.clamp(PACE_MIN_RATIO, PACE_MAX_RATIO), 1.0);
                self.infer(sensed.left - sensed.right, sets, speed_mps)
            }
            TrailLaw::FuzzyAngle { antennas, .. } => {
                self.infer(antennas.equivalent(&sensed).bearing_rad, (1.0, 1.0), speed_mps)
            }
            TrailLaw::BioMimetic { intensity_full, reading } => {
                let difference = (sensed.left - sensed.right) / intensity_full;
                bio_mimetic(difference.clamp(-1.0, 1.0), reading, speed_mps)
            }
            TrailLaw::PurePursuit { antennas, lookahead_min_m } => {
                let seen = antennas.equivalent(&sensed);
                // γ = 2 y / L² with y = L sin φ.
                let lookahead_m = seen.distance_m.max(lookahead_min_m);
                let curvature_per_m = 2.0 * seen.bearing_rad.sin() / lookahead_m;
                WheelReference::along_arc(speed_mps, curvature_per_m, self.config.wheelbase_m)
            }
            // Answered above.
            TrailLaw::Listing { .. } => WheelReference::STOP,
        };
        wheels.limited(self.config.wheel_speed_max_mps)
    }

    /// For how long nothing has been perceived, up to and including the last step; zero on the trail.
    pub fn lost_for(&self) -> Duration {
        self.lost_for
    }

    /// Forgets everything, as before the first step.
    pub fn restart(&mut self) {
        self.previous_error = None;
        self.lost_for = Duration::ZERO;
        if let TrailLaw::Listing { config } = self.config.law
            && let Ok(listing) = ListingFuzzy::new(config)
        {
            self.machine = Machine::Listing(listing);
        }
    }

    /// `wider` and `faster`: how much wider the sets of the error and of its change are.
    fn infer(&mut self, error: f64, (wider, faster): (f64, f64), speed_mps: f64) -> WheelReference {
        let change = self.previous_error.map_or(0.0, |previous| error - previous);
        self.previous_error = Some(error);
        match &self.machine {
            Machine::Float(fuzzy) => fuzzy.step(error / wider, change / faster, speed_mps),
            Machine::Listing(_) | Machine::None => WheelReference::STOP,
        }
    }
}

impl TwoAntennas {
    fn check(&self) -> Result<(), SettingError> {
        check_range("sigma_m", self.sigma_m, 0.05..=10.0, "from 0.05 to 10 m")?;
        check_range("spacing_m", self.spacing_m, 0.01..=5.0, "from 0.01 to 5 m")?;
        check_range("total_intensity", self.total_intensity, 1.0..=1e6, "from 1 to 1e6")
    }

    /// The equivalent source as told, or as guessed from the two intensities.
    pub fn equivalent(&self, sensed: &TrailSense) -> EquivalentPoint {
        if let Some(told) = sensed.equivalent
            && told.bearing_rad.is_finite()
            && told.distance_m.is_finite()
        {
            return told;
        }
        // d = σ (1 − P / (N p₀)), (5.48)
        let distance_m = |intensity: f64| {
            self.sigma_m * (1.0 - intensity / self.total_intensity).clamp(0.0, 1.0)
        };
        let (left_m, right_m) = (distance_m(sensed.left), distance_m(sensed.right));
        let sine = ((right_m - left_m) / self.spacing_m).clamp(-1.0, 1.0);
        EquivalentPoint { bearing_rad: sine.asin(), distance_m: 0.5 * (left_m + right_m) }
    }
}

/// (5.44) for a difference `P_L − P_R` in [−1, 1].
fn bio_mimetic(difference: f64, reading: BioMimeticReading, speed_mps: f64) -> WheelReference {
    let size = difference.abs();
    // "K (1 − |ΔP|) for P_L > P_R, K |ΔP| otherwise", and its mirror image.
    let first = if difference > 0.0 { 1.0 - size } else { size };
    let second = if difference >= 0.0 { size } else { 1.0 - size };
    let (left, right) = match reading {
        BioMimeticReading::Repaired => (1.0 - difference.max(0.0), 1.0 - (-difference).max(0.0)),
        BioMimeticReading::PrintedLeft => (first, second),
        BioMimeticReading::PrintedRight => (second, first),
    };
    WheelReference { left_mps: speed_mps * left, right_mps: speed_mps * right }
}

/// As the server sends it.
fn to_byte(intensity: f64) -> u8 {
    intensity.clamp(0.0, 255.0) as u8
}

#[cfg(test)]
#[path = "trail_laws_tests.rs"]
mod tests;
