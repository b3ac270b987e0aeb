//! The fuzzy controller: an error and its change in, two wheel speeds out.
//!
//! Memberships are triangles with shoulders over [−M, M]; rules join them by the smaller truth, and
//! the output is the weighted mean of the rules' speeds:
//!
//! ```text
//! z = min(μ(e), μ′(e′))        (5.25)
//! u = Σ zᵢ Sᵢ / Σ zᵢ           (5.26)
//! ```
//!
//! An error is positive when the robot must turn left. Source: the thesis, §5.2.3, (5.24)–(5.32), Figs 5.10,
//! 5.11. Differences: its tables are damaged in print; three readings are shipped as data, see [`Table`].
//! Its rule (5.32) turns the wrong way for both of its own errors and is not used.
//!
//! [`crate::fuzzy_listing`] has the same controller in the integer arithmetic of the thesis's program.

use crate::{SettingError, WheelReference, wheels::check_range};

/// A speed named by a rule, between slow and fast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// Low, L.
    Slow,
    /// Medium, M.
    Mean,
    /// High, H.
    Fast,
}

use Speed::{Fast, Mean, Slow};

/// What the nine rules say of one wheel, at 3 × (set of e) + (set of e′), sets in the order N, Z, P.
pub type RuleTable = [Speed; 9];

/// Which reading of the damaged rule tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Table {
    /// Mirrored errors give mirrored wheels. Holds the trail with every tuning tried; use this one.
    #[default]
    Antisymmetric,
    /// The right wheel's table as printed, the left one with slow and fast exchanged. Not the same to both
    /// sides, and loses the trail with narrow speed ranges.
    LiteralMirror,
    /// Table 5.1 of the thesis, read with e outside and mirrored for the right wheel. Not the same to
    /// both sides.
    Table51,
    /// Rules of one's own.
    Own {
        /// What they say of the left wheel.
        left: RuleTable,
        /// What they say of the right wheel.
        right: RuleTable,
    },
}

/// Which of the rule tables: what a mission chooses by a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableKind {
    /// [`Table::Antisymmetric`].
    #[default]
    Antisymmetric,
    /// [`Table::LiteralMirror`].
    LiteralMirror,
    /// [`Table::Table51`].
    Table51,
    /// [`Table::Own`].
    Own,
}

settings::choices!(TableKind {
    Antisymmetric = "antisymmetric": "mirrored errors give mirrored wheels",
    LiteralMirror = "literal_mirror": "the right wheel's table as printed, the left one its mirror",
    Table51 = "table_5_1": "table 5.1 as printed",
    Own = "own": "rules of one's own",
});

/// The rules that nine letters spell: L, M and H for slow, mean and fast, at 3 × (set of e) + (set of
/// e′), sets in the order N, Z, P; blanks between them do not count. `None` for anything else.
pub fn rules_of_letters(letters: &str) -> Option<RuleTable> {
    let mut rules = [Mean; 9];
    let mut n = 0;
    for letter in letters.chars().filter(|letter| !letter.is_whitespace()) {
        *rules.get_mut(n)? = match letter {
            'L' => Slow,
            'M' => Mean,
            'H' => Fast,
            _ => return None,
        };
        n += 1;
    }
    (n == rules.len()).then_some(rules)
}

impl Table {
    /// The rules of the left and of the right wheel.
    pub fn rules(self) -> (RuleTable, RuleTable) {
        let left = match self {
            Self::Antisymmetric => [Fast, Fast, Mean, Fast, Mean, Slow, Mean, Slow, Slow],
            Self::LiteralMirror => [Fast, Fast, Mean, Mean, Mean, Slow, Fast, Mean, Slow],
            Self::Table51 => [Fast, Fast, Mean, Slow, Mean, Mean, Slow, Mean, Slow],
            Self::Own { left, right } => return (left, right),
        };
        (left, left.map(Speed::opposite))
    }
}

impl Speed {
    /// Slow for fast and fast for slow.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Slow => Fast,
            Mean => Mean,
            Fast => Slow,
        }
    }
}

/// How many fuzzy sets each input has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sets {
    /// N, Z, P with peaks at −M, 0, M.
    #[default]
    Three,
    /// NB, NS, Z, PS, PB with peaks at −M, −M/2, 0, M/2, M; five output speeds. Finer near zero.
    Five,
}

/// Tuning of a [`FuzzyController`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuzzyConfig {
    /// Sets per input. Five go with [`Table::Antisymmetric`] only.
    pub sets: Sets,
    /// Which rules.
    pub table: Table,
    /// M: the error from which on the outermost set is fully true; unit of the error, > 0. On a thesis
    /// trail (unit sources, intensities in hundredths) 50.
    pub error_full: f64,
    /// M′: the same for the change of the error from step to step; 25 with the above.
    pub change_full: f64,
    /// L as a fraction of the mean speed, from −1 to 1.
    pub slow_ratio: f64,
    /// H as a fraction of the mean speed, from 1 to 3.
    pub fast_ratio: f64,
}

impl Default for FuzzyConfig {
    /// For trails: M = 50, M′ = 25, L/M/H as 150/300/450.
    fn default() -> Self {
        Self {
            sets: Sets::default(),
            table: Table::default(),
            error_full: 50.0,
            change_full: 25.0,
            slow_ratio: 0.5,
            fast_ratio: 1.5,
        }
    }
}

/// The fuzzy controller without memory: error and change are the caller's.
///
/// ```
/// use path_following::fuzzy::{FuzzyConfig, FuzzyController};
///
/// let controller = FuzzyController::new(FuzzyConfig::default()).unwrap();
/// let wheels = controller.step(25.0, 0.0, 0.3);
/// assert!(wheels.right_mps > wheels.left_mps, "more on the left: turn left");
/// ```
#[derive(Clone, Debug)]
pub struct FuzzyController {
    config: FuzzyConfig,
    n_sets: usize,
    /// Speeds of (left, right) as fractions of the mean one, at n × (set of e) + (set of e′).
    singletons: [[f64; 2]; 25],
}

impl FuzzyController {
    /// Checks the tuning and lays out the rules.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range, or five sets with a table that has three.
    pub fn new(config: FuzzyConfig) -> Result<Self, SettingError> {
        check_range("error_full", config.error_full, 1e-9..=1e9, "from 1e-9 to 1e9")?;
        check_range("change_full", config.change_full, 1e-9..=1e9, "from 1e-9 to 1e9")?;
        check_range("slow_ratio", config.slow_ratio, -1.0..=1.0, "from -1 to 1")?;
        check_range("fast_ratio", config.fast_ratio, 1.0..=3.0, "from 1 to 3")?;
        let n_sets = match config.sets {
            Sets::Three => 3,
            Sets::Five if config.table == Table::Antisymmetric => 5,
            Sets::Five => {
                return Err(SettingError {
                    key: "sets",
                    value: 5.0,
                    requirement: "3 with the literal tables; 5 goes with the antisymmetric one",
                });
            }
        };
        Ok(Self { singletons: singletons(&config, n_sets), config, n_sets })
    }

    /// Wheel speeds for an error and its change, around the mean speed given (m/s).
    ///
    /// Always between the slow and the fast speed; stops when an argument is not finite. O(1): only the
    /// two sets on either side of each input have any truth, so four rules fire at most.
    pub fn step(&self, error: f64, change: f64, mean_mps: f64) -> WheelReference {
        if !(error.is_finite() && change.is_finite() && mean_mps.is_finite()) {
            return WheelReference::STOP;
        }
        let (i, outer_i) = self.place(error / self.config.error_full);
        let (j, outer_j) = self.place(change / self.config.change_full);
        let (mut sum_z, mut left, mut right) = (0.0, 0.0, 0.0);
        for (set_i, mu_i) in [(i, 1.0 - outer_i), (i + 1, outer_i)] {
            for (set_j, mu_j) in [(j, 1.0 - outer_j), (j + 1, outer_j)] {
                // z = min(μ, μ′);  u = Σ z S / Σ z
                let z = mu_i.min(mu_j);
                let [left_ratio, right_ratio] = self.singletons[set_i * self.n_sets + set_j];
                sum_z += z;
                left += z * left_ratio;
                right += z * right_ratio;
            }
        }
        // Of each input's two truths one is at least a half, so the sum is too.
        WheelReference { left_mps: mean_mps * left / sum_z, right_mps: mean_mps * right / sum_z }
    }

    /// The truth of each set for an input, from the most negative set on; they sum to 1. Of three sets the last two
    /// entries are unused.
    pub fn memberships(&self, input: f64, full: f64) -> [f64; 5] {
        let mut truths = [0.0; 5];
        let (set, outer) = self.place(input / full);
        truths[set] += 1.0 - outer;
        truths[set + 1] += outer;
        truths
    }

    /// The set below an input (never the last one) and how far towards the next it lies, 0..=1.
    fn place(&self, normalised: f64) -> (usize, f64) {
        let last = (self.n_sets - 1) as f64;
        // Measured from the middle set, so that mirrored inputs have mirrored rounding.
        let half = 0.5 * last;
        let from_middle = (normalised * half).clamp(-half, half);
        let below = from_middle.floor().min(half - 1.0);
        ((below + half) as usize, from_middle - below)
    }
}

fn singletons(config: &FuzzyConfig, n_sets: usize) -> [[f64; 2]; 25] {
    let mut singletons = [[1.0; 2]; 25];
    if n_sets == 3 {
        let ratio = |speed: Speed| match speed {
            Slow => config.slow_ratio,
            Mean => 1.0,
            Fast => config.fast_ratio,
        };
        let (left, right) = config.table.rules();
        for (rule, entry) in singletons.iter_mut().take(9).enumerate() {
            *entry = [ratio(left[rule]), ratio(right[rule])];
        }
        return singletons;
    }
    // The antisymmetric table of three sets is "right wheel at level e + e′, cut to the outermost". The
    // same with five levels: slow, halfway, mean, halfway, fast.
    let ratio = |level: i32| match level {
        ..0 => 1.0 + f64::from(level) * 0.5 * (1.0 - config.slow_ratio),
        0.. => 1.0 + f64::from(level) * 0.5 * (config.fast_ratio - 1.0),
    };
    for (rule, entry) in singletons.iter_mut().enumerate() {
        let (e, change) = ((rule / 5) as i32 - 2, (rule % 5) as i32 - 2);
        let level = (e + change).clamp(-2, 2);
        *entry = [ratio(-level), ratio(level)];
    }
    singletons
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// L/M/H of the golden values, mm/s.
    const GOLDEN: FuzzyConfig = FuzzyConfig {
        sets: Sets::Three,
        table: Table::Antisymmetric,
        error_full: 50.0,
        change_full: 25.0,
        slow_ratio: 2.0 / 3.0,
        fast_ratio: 4.0 / 3.0,
    };

    fn controller(config: FuzzyConfig) -> FuzzyController {
        FuzzyController::new(config).unwrap()
    }

    fn configs() -> Vec<FuzzyConfig> {
        let three = FuzzyConfig { slow_ratio: 0.2, fast_ratio: 1.6, ..FuzzyConfig::default() };
        vec![
            GOLDEN,
            three,
            FuzzyConfig { table: Table::LiteralMirror, ..three },
            FuzzyConfig { table: Table::Table51, ..three },
            FuzzyConfig { sets: Sets::Five, ..three },
        ]
    }

    /// The textbook way, for three sets: all memberships by formula, all nine rules.
    fn by_definition(config: &FuzzyConfig, e: f64, change: f64) -> [f64; 2] {
        let sets = |x: f64, m: f64| {
            let x = (x / m).clamp(-1.0, 1.0);
            [(-x).max(0.0), 1.0 - x.abs(), x.max(0.0)]
        };
        let speed = |s: Speed| match s {
            Slow => config.slow_ratio,
            Mean => 1.0,
            Fast => config.fast_ratio,
        };
        let (mu, mu_change) = (sets(e, config.error_full), sets(change, config.change_full));
        let (left, right) = config.table.rules();
        let mut sums = [0.0; 3];
        for i in 0..3 {
            for j in 0..3 {
                let z = mu[i].min(mu_change[j]);
                sums[0] += z;
                sums[1] += z * speed(left[3 * i + j]);
                sums[2] += z * speed(right[3 * i + j]);
            }
        }
        [sums[1] / sums[0], sums[2] / sums[0]]
    }

    /// The golden values were derived with whole numbers rounded down, so the float controller may lie
    /// up to 4 mm/s beside them.
    #[test]
    fn comes_near_the_listings_golden_values() {
        let golden = [
            (0.0, 0.0, 300.0, 300.0),
            (-38.0, 0.0, 376.0, 224.0),
            (-38.0, 10.0, 324.0, 275.0),
            (25.0, -5.0, 278.0, 321.0),
            (60.0, 30.0, 200.0, 400.0),
            (10.0, -40.0, 380.0, 220.0),
        ];
        for (e, change, left, right) in golden {
            let wheels = controller(GOLDEN).step(e, change, 0.3);
            let off = (1000.0 * wheels.left_mps - left)
                .abs()
                .max((1000.0 * wheels.right_mps - right).abs());
            assert!(off < 1.0, "({e}, {change}): {wheels:?}");
        }
    }

    /// The default table, spelt out, is the default table; another one drives otherwise.
    #[test]
    fn rules_of_ones_own_are_spelt_in_nine_letters() {
        let own = |left: &str, right: &str| FuzzyConfig {
            table: Table::Own {
                left: rules_of_letters(left).unwrap(),
                right: rules_of_letters(right).unwrap(),
            },
            ..GOLDEN
        };
        let same = controller(own("HHM HML MLL", "LLM LMH MHH"));
        // Mean wherever the error is small, whatever its change.
        let dull = controller(own("HHM MMM MLL", "LLM MMM MHH"));
        for (e, change) in [(0.0, 0.0), (-38.0, 10.0), (25.0, -5.0), (60.0, 30.0), (0.0, 20.0)] {
            let expected = controller(GOLDEN).step(e, change, 0.3);
            assert_eq!(same.step(e, change, 0.3), expected, "({e}, {change})");
        }
        assert_eq!(dull.step(0.0, 20.0, 0.3), WheelReference::straight(0.3));
        assert_ne!(controller(GOLDEN).step(0.0, 20.0, 0.3), WheelReference::straight(0.3));
        for wrong in ["", "HHMHMLML", "HHMHMLMLLL", "HHX HML MLL", "hhm hml mll"] {
            assert_eq!(rules_of_letters(wrong), None, "{wrong:?}");
        }
    }

    #[test]
    fn five_sets_have_the_peaks_and_levels_they_should() {
        let five = controller(FuzzyConfig { sets: Sets::Five, ..GOLDEN });
        let truths = |e| five.memberships(e, 50.0);
        assert_eq!(truths(-60.0), [1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(truths(-25.0), [0.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(truths(0.0), [0.0, 0.0, 1.0, 0.0, 0.0]);
        assert_eq!(truths(37.5), [0.0, 0.0, 0.0, 0.5, 0.5]);
        assert_eq!(truths(50.0), [0.0, 0.0, 0.0, 0.0, 1.0]);
        let left = |e, change| (3000.0 * five.step(e, change, 0.3).left_mps).round() / 3.0;
        assert_eq!([left(-50.0, 0.0), left(-25.0, 0.0), left(0.0, 0.0)], [400.0, 350.0, 300.0]);
        assert_eq!([left(25.0, 0.0), left(50.0, 0.0), left(25.0, -12.5)], [250.0, 200.0, 300.0]);
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let refused = |config| FuzzyController::new(config).unwrap_err().to_string();
        let with = FuzzyConfig::default();
        assert_eq!(
            refused(FuzzyConfig { error_full: 0.0, ..with }),
            "error_full = 0: must be from 1e-9 to 1e9"
        );
        assert_eq!(
            refused(FuzzyConfig { change_full: f64::NAN, ..with }),
            "change_full = NaN: must be from 1e-9 to 1e9"
        );
        assert_eq!(
            refused(FuzzyConfig { slow_ratio: 1.1, ..with }),
            "slow_ratio = 1.1: must be from -1 to 1"
        );
        assert_eq!(
            refused(FuzzyConfig { fast_ratio: 0.9, ..with }),
            "fast_ratio = 0.9: must be from 1 to 3"
        );
        assert_eq!(
            refused(FuzzyConfig { sets: Sets::Five, table: Table::Table51, ..with }),
            "sets = 5: must be 3 with the literal tables; 5 goes with the antisymmetric one"
        );
    }

    #[test]
    fn nonsense_stops() {
        for (e, change, mean) in
            [(f64::NAN, 0.0, 0.3), (0.0, f64::INFINITY, 0.3), (0.0, 0.0, f64::NAN)]
        {
            assert_eq!(controller(GOLDEN).step(e, change, mean), WheelReference::STOP);
        }
    }

    proptest! {
        #[test]
        fn three_sets_match_the_definition(e in -80.0..80.0, change in -40.0..40.0, which in 0_usize..4) {
            let config = configs()[which];
            let wheels = controller(config).step(e, change, 1.0);
            let [left, right] = by_definition(&config, e, change);
            prop_assert!((wheels.left_mps - left).abs() < 1e-12);
            prop_assert!((wheels.right_mps - right).abs() < 1e-12);
        }

        #[test]
        fn memberships_sum_to_one(input in -3.0..3.0, which in 0_usize..5) {
            let truths = controller(configs()[which]).memberships(input, 1.0);
            prop_assert!((truths.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            prop_assert!(truths.iter().all(|mu| (0.0..=1.0).contains(mu)));
        }

        #[test]
        fn speeds_stay_between_slow_and_fast(e in -200.0..200.0, change in -99.0..99.0, which in 0_usize..5) {
            let wheels = controller(configs()[which]).step(e, change, 0.5);
            for speed in [wheels.left_mps, wheels.right_mps] {
                prop_assert!((0.099_999..=0.800_001).contains(&speed));
            }
        }

        #[test]
        fn mirrored_errors_swap_the_wheels_exactly(e in -80.0..80.0, change in -40.0..40.0, five in any::<bool>()) {
            let sets = if five { Sets::Five } else { Sets::Three };
            let controller = controller(FuzzyConfig { sets, ..FuzzyConfig::default() });
            let (here, there) = (controller.step(e, change, 0.3), controller.step(-e, -change, 0.3));
            prop_assert!((here.left_mps - there.right_mps).abs() < 1e-15);
            prop_assert!((here.right_mps - there.left_mps).abs() < 1e-15);
        }
    }
}
