//! The rebound: which way to leave when something is inside the bubble.

/// Sensor weights of the listing: half-steps of π/8 away from straight ahead, left positive.
///
/// The listing prints the table's name only; these are the values consistent with its unit 180°/8.
pub const LISTING_WEIGHTS: [i32; 8] = [4, 3, 2, 1, -1, -2, -3, -4];

/// The least swing of a rebound that would lead straight back into what is ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcedSwing {
    /// Rebounds smaller than this (absolute) are enlarged when the front is blocked, radians.
    pub below_rad: f64,
    /// What is added to a rebound to the left (or of zero), radians.
    pub left_rad: f64,
    /// What is taken from a rebound to the right, radians.
    pub right_rad: f64,
}

impl Default for ForcedSwing {
    /// The thesis's values: below 30°, 45° to the left, 50° to the right (Annex C).
    fn default() -> Self {
        Self {
            below_rad: 30.0_f64.to_radians(),
            left_rad: 45.0_f64.to_radians(),
            right_rad: 50.0_f64.to_radians(),
        }
    }
}

impl ForcedSwing {
    /// Enlarges a small rebound (rad, left positive) if the front is blocked; else returns it.
    ///
    /// Source: the thesis, Annex C, `check_for_free_area`: +45 for angles ≥ 0, else −50; unequal on
    /// purpose, so that two robots that meet head-on do not mirror each other for ever.
    pub fn apply(&self, angle_rad: f64, front_blocked: bool) -> f64 {
        if !front_blocked || angle_rad.abs() >= self.below_rad {
            angle_rad
        } else if angle_rad >= 0.0 {
            angle_rad + self.left_rad
        } else {
            angle_rad - self.right_rad
        }
    }
}

/// Direction αᵢ of sensor `index` of `n_sensors` spread over a half circle, radians, left positive.
///
/// Source: the thesis, (6.1) α₀ = π/N and (6.2) αᵢ = i·α₀, i from N/2 down to −N/2. As in its
/// listing, i skips 0 when N is even, so that the directions are symmetric.
pub fn nominal_bearing_rad(index: usize, n_sensors: usize) -> f64 {
    let half = (n_sensors / 2) as f64;
    let mut i = half - index as f64;
    if n_sensors.is_multiple_of(2) && i <= 0.0 {
        i -= 1.0;
    }
    i * std::f64::consts::PI / n_sensors as f64
}

/// The rebound relative to the robot's heading, radians, left positive: the mean of the sensors'
/// directions (rad) weighted by their ranges (m). `None` without sensors or when all ranges are 0.
///
/// Negative and non-finite ranges count as 0. O(n), no allocation.
///
/// Source: the thesis, (6.3): `α_R = Σ α_i D_i / Σ D_i`.
pub fn rebound_angle_rad(readings: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let (mut weighted, mut total) = (0.0, 0.0);
    for (bearing_rad, range_m) in readings {
        let weight = if range_m.is_finite() { range_m.max(0.0) } else { 0.0 };
        weighted += bearing_rad * weight;
        total += weight;
    }
    (total > 0.0).then(|| weighted / total)
}

/// The listing's rebound in whole degrees, left positive, from eight ranges in centimetres.
///
/// `front_limit_cm` is the boundary of sensors 3 and 4; when either reads no more, small angles are
/// swung out by +45 or −50.
///
/// Source: the thesis, Annex C, `check_for_free_area`: `⌊Σ w_i s_i / Σ (s_i + 1) · 180 / 8⌋`.
pub fn listing_rebound_deg(sonar_cm: [i32; 8], front_limit_cm: i32) -> i32 {
    let sigma1: i64 =
        sonar_cm.iter().zip(LISTING_WEIGHTS).map(|(&s, w)| i64::from(s) * i64::from(w)).sum();
    let sigma2: i64 = sonar_cm.iter().map(|&s| i64::from(s) + 1).sum();
    let angle_deg = if sigma2 > 0 { (180 * sigma1).div_euclid(8 * sigma2) as i32 } else { 0 };
    let front_blocked = sonar_cm[3] <= front_limit_cm || sonar_cm[4] <= front_limit_cm;
    match angle_deg {
        _ if angle_deg.abs() >= 30 || !front_blocked => angle_deg,
        0.. => angle_deg + 45,
        _ => angle_deg - 50,
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL_FREE: [i32; 8] = [500; 8];

    #[test]
    fn listing_gives_the_golden_angles() {
        assert_eq!(listing_rebound_deg(ALL_FREE, 80), 0);
        assert_eq!(listing_rebound_deg([500, 500, 500, 60, 60, 500, 500, 500], 80), 45);
        assert_eq!(listing_rebound_deg([100, 80, 60, 50, 300, 500, 500, 500], 80), -43);
        assert_eq!(listing_rebound_deg([500, 500, 500, 300, 50, 60, 80, 100], 80), 42);
        assert_eq!(listing_rebound_deg([50, 60, 70, 50, 50, 400, 500, 500], 80), -51);
    }

    #[test]
    fn small_listing_angles_swing_only_before_a_blocked_front() {
        let slightly_right = [450, 450, 500, 500, 79, 500, 500, 500];
        let raw = listing_rebound_deg(slightly_right, 78);
        assert!((0..30).contains(&raw), "{raw}");
        assert_eq!(listing_rebound_deg(slightly_right, 79), raw + 45);
        let slightly_left = [500, 500, 500, 79, 500, 500, 450, 450];
        let raw = listing_rebound_deg(slightly_left, 78);
        assert!((-29..0).contains(&raw), "{raw}");
        assert_eq!(listing_rebound_deg(slightly_left, 79), raw - 50);
    }

    #[test]
    fn equation_6_3_agrees_with_a_calculation_by_hand() {
        // Two sensors at ±1 rad; the left sees 3 m, the right 1 m: (3 − 1) / 4.
        assert_eq!(rebound_angle_rad([(1.0, 3.0), (-1.0, 1.0)]), Some(0.5));
        assert_eq!(rebound_angle_rad([(1.0, 0.0), (-1.0, 0.0)]), None);
        assert_eq!(rebound_angle_rad([]), None);
        assert_eq!(rebound_angle_rad([(1.0, f64::NAN), (-1.0, 2.0)]), Some(-1.0));
    }

    #[test]
    fn nominal_bearings_are_symmetric_steps_of_pi_over_n() {
        let degrees: Vec<f64> = (0..8).map(|i| nominal_bearing_rad(i, 8).to_degrees()).collect();
        let expected = [90.0, 67.5, 45.0, 22.5, -22.5, -45.0, -67.5, -90.0];
        assert!(degrees.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{degrees:?}");
        let odd: Vec<f64> = (0..3).map(|i| nominal_bearing_rad(i, 3).to_degrees()).collect();
        assert!(odd.iter().zip([60.0, 0.0, -60.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{odd:?}");
    }

    #[test]
    fn forced_swing_has_both_sides() {
        let swing = ForcedSwing::default();
        let deg = |d: f64| d.to_radians();
        assert!((swing.apply(0.0, true) - deg(45.0)).abs() < 1e-12);
        assert!((swing.apply(deg(-1.0), true) - deg(-51.0)).abs() < 1e-12);
        assert_eq!(swing.apply(deg(29.0), false), deg(29.0));
        assert_eq!(swing.apply(deg(-31.0), true), deg(-31.0));
    }

    proptest! {
        #[test]
        fn the_mirror_image_rebounds_to_the_other_side(ranges in proptest::collection::vec(0.1..5.0_f64, 8)) {
            let readings = |mirrored: bool| {
                let ranges = ranges.clone();
                (0..8).map(move |i| (nominal_bearing_rad(i, 8), ranges[if mirrored { 7 - i } else { i }]))
            };
            let (a, b) = (rebound_angle_rad(readings(false)).unwrap(), rebound_angle_rad(readings(true)).unwrap());
            prop_assert!((a + b).abs() < 1e-9);
        }

        #[test]
        fn it_never_leaves_the_fan_of_the_sensors(ranges in proptest::collection::vec(0.1..5.0_f64, 8)) {
            let angle = rebound_angle_rad((0..8).map(|i| (nominal_bearing_rad(i, 8), ranges[i]))).unwrap();
            prop_assert!(angle.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9);
        }

        #[test]
        fn float_and_listing_agree_within_their_rounding(cm in proptest::collection::vec(31..500_i32, 8)) {
            // (s + 1) in the listing's sum and the floor: under 3° together for ranges over 30 cm.
            let cm: [i32; 8] = cm.try_into().unwrap();
            let float = rebound_angle_rad((0..8).map(|i| (nominal_bearing_rad(i, 8), f64::from(cm[i])))).unwrap();
            let listing = listing_rebound_deg(cm, 0);
            prop_assert!((float.to_degrees() - f64::from(listing)).abs() < 3.5);
        }
    }
}
