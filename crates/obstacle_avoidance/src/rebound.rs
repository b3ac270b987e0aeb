//! The rebound: which way to leave when something is inside the bubble.

use std::f64::consts::FRAC_PI_2;

use crate::RangeSensor;

/// The mean of mirrored readings may differ from zero by so much in rounding, radians.
const STRAIGHT_RAD: f64 = 1e-9;

/// Bearings that differ by less from a right angle look exactly aside, radians.
const ASIDE_RAD: f64 = 1e-6;

/// Whether a sensor is of the front ring: it looks ahead, or aside from the front half of the robot.
/// The sensors of a rear ring that look aside belong to that.
fn is_in_front_ring(sensor: &RangeSensor) -> bool {
    let beyond_rad = sensor.bearing_rad.abs() - FRAC_PI_2;
    beyond_rad < -ASIDE_RAD || (beyond_rad <= ASIDE_RAD && sensor.in_base.x >= 0.0)
}

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
        } else if angle_rad >= -STRAIGHT_RAD {
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

/// The rebound relative to the robot's heading, radians, left positive: the mean of the directions
/// (rad) of the front ring's sensors weighted by their ranges (m), one range per sensor. `None` without
/// sensors in front or when all their ranges are 0.
///
/// Only sensors that look ahead, or aside from the front half, take part: a wall behind the robot says
/// nothing about where to go. Negative and non-finite ranges count as 0. O(n), no allocation.
///
/// Source: the thesis, (6.3): `α_R = Σ α_i D_i / Σ D_i`, over the sensors that (6.1) and (6.2) spread over
/// the half circle in front. Differences: the sensors' true directions, not steps of π/N; Annex C adds
/// 1 cm to every range of the lower sum and rounds down, which changes less than a degree.
pub fn rebound_angle_rad(sensors: &[RangeSensor], ranges_m: &[f64]) -> Option<f64> {
    let (mut weighted, mut total) = (0.0, 0.0);
    for (sensor, &range_m) in sensors.iter().zip(ranges_m) {
        if !is_in_front_ring(sensor) {
            continue;
        }
        let weight = if range_m.is_finite() { range_m.max(0.0) } else { 0.0 };
        weighted += sensor.bearing_rad * weight;
        total += weight;
    }
    (total > 0.0).then(|| weighted / total)
}

/// The turn that a rebound asks for, radians, left positive: the weighted mean (6.3), or straight
/// ahead where nothing is known, swung out by `swing` when the front is blocked.
///
/// Source: the thesis, Annex C, `check_for_free_area`.
pub fn rebound_turn_rad(
    sensors: &[RangeSensor],
    ranges_m: &[f64],
    front_blocked: bool,
    swing: &ForcedSwing,
) -> f64 {
    swing.apply(rebound_angle_rad(sensors, ranges_m).unwrap_or(0.0), front_blocked)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A whole ring: the thesis's eight in front, and eight behind them that look back.
    fn ring() -> [RangeSensor; 16] {
        std::array::from_fn(|i| {
            let front_rad = nominal_bearing_rad(i % 8, 8);
            let (x, turn_rad) = if i < 8 { (0.1, 0.0) } else { (-0.2, std::f64::consts::PI) };
            let bearing_rad = geometry::wrap_to_pi(turn_rad + front_rad);
            RangeSensor { in_base: geometry::Vec2::new(x, 0.0), bearing_rad }
        })
    }

    /// The turn that the machine orders, in degrees; `front_cm` as the listing has them, and all of
    /// the rear at `rear_m`.
    fn turn_deg(front_cm: [i32; 8], limit_cm: i32, rear_m: f64) -> f64 {
        let mut ranges_m = [rear_m; 16];
        for (range_m, cm) in ranges_m.iter_mut().zip(front_cm) {
            *range_m = f64::from(cm) / 100.0;
        }
        let blocked = front_cm[3] <= limit_cm || front_cm[4] <= limit_cm;
        rebound_turn_rad(&ring(), &ranges_m, blocked, &ForcedSwing::default()).to_degrees()
    }

    /// Oracle: the listing's program, in whole degrees and centimetres. Its table of weights is
    /// printed by name only; these are consistent with its unit of 180°/8.
    fn listing_deg(sonar_cm: [i32; 8], front_limit_cm: i32) -> i32 {
        let weights = [4, 3, 2, 1, -1, -2, -3, -4];
        let sigma1: i64 =
            sonar_cm.iter().zip(weights).map(|(&s, w)| i64::from(s) * i64::from(w)).sum();
        let sigma2: i64 = sonar_cm.iter().map(|&s| i64::from(s) + 1).sum();
        let angle_deg = (180 * sigma1).div_euclid(8 * sigma2) as i32;
        let front_blocked = sonar_cm[3] <= front_limit_cm || sonar_cm[4] <= front_limit_cm;
        match angle_deg {
            _ if angle_deg.abs() >= 30 || !front_blocked => angle_deg,
            0.. => angle_deg + 45,
            _ => angle_deg - 50,
        }
    }

    /// Golden values of the listing (AT11), for the function that the machine calls, whatever is
    /// behind the robot. The listing rounds down: a degree.
    #[test]
    fn the_turn_has_the_golden_angles_whatever_is_behind() {
        let golden = [
            ([500; 8], 0),
            ([500, 500, 500, 60, 60, 500, 500, 500], 45),
            ([100, 80, 60, 50, 300, 500, 500, 500], -43),
            ([500, 500, 500, 300, 50, 60, 80, 100], 42),
            ([50, 60, 70, 50, 50, 400, 500, 500], -51),
        ];
        for (front_cm, expected_deg) in golden {
            assert_eq!(listing_deg(front_cm, 80), expected_deg, "the oracle itself");
            for rear_m in [0.0, 0.2, 5.0, f64::NAN] {
                let turn_deg = turn_deg(front_cm, 80, rear_m);
                let apart_deg = turn_deg - f64::from(expected_deg);
                assert!((-1e-9..1.0).contains(&apart_deg.abs()), "{front_cm:?}: {turn_deg}");
            }
        }
    }

    /// A ring that has nothing in front, or nothing at all, rebounds straight ahead, swung out.
    #[test]
    fn a_ring_without_a_front_turns_by_the_swing_alone() {
        let (rear, swing) = (&ring()[8..], ForcedSwing::default());
        assert_eq!(rebound_angle_rad(rear, &[1.0; 8]), None);
        assert_eq!(rebound_turn_rad(rear, &[1.0; 8], false, &swing), 0.0);
        assert!((rebound_turn_rad(&[], &[], true, &swing) - swing.left_rad).abs() < 1e-12);
    }

    #[test]
    fn small_angles_swing_only_before_a_blocked_front() {
        let slightly_right = [450, 450, 500, 500, 79, 500, 500, 500];
        let raw = turn_deg(slightly_right, 78, 1.0);
        assert!((0.0..30.0).contains(&raw), "{raw}");
        assert!((turn_deg(slightly_right, 79, 1.0) - raw - 45.0).abs() < 1e-9);
        let slightly_left = [500, 500, 500, 79, 500, 500, 450, 450];
        let raw = turn_deg(slightly_left, 78, 1.0);
        assert!((-30.0..0.0).contains(&raw), "{raw}");
        assert!((turn_deg(slightly_left, 79, 1.0) - raw + 50.0).abs() < 1e-9);
    }

    #[test]
    fn equation_6_3_agrees_with_a_calculation_by_hand() {
        // Two sensors at ±1 rad; the left sees 3 m, the right 1 m: (3 − 1) / 4.
        let sensor = |bearing_rad| RangeSensor { in_base: geometry::Vec2::zeros(), bearing_rad };
        let pair = [sensor(1.0), sensor(-1.0)];
        assert_eq!(rebound_angle_rad(&pair, &[3.0, 1.0]), Some(0.5));
        assert_eq!(rebound_angle_rad(&pair, &[0.0, 0.0]), None);
        assert_eq!(rebound_angle_rad(&[], &[]), None);
        assert_eq!(rebound_angle_rad(&pair, &[f64::NAN, 2.0]), Some(-1.0));
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
            let mirrored: Vec<f64> = ranges.iter().rev().copied().collect();
            let angle = |ranges: &[f64]| rebound_angle_rad(&ring()[..8], ranges).unwrap();
            prop_assert!((angle(&ranges) + angle(&mirrored)).abs() < 1e-9);
        }

        #[test]
        fn it_never_leaves_the_fan_of_the_sensors(ranges in proptest::collection::vec(0.1..5.0_f64, 16)) {
            let angle = rebound_angle_rad(&ring(), &ranges).unwrap();
            prop_assert!(angle.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9);
        }

        #[test]
        fn the_listing_agrees_within_its_rounding(
            cm in proptest::collection::vec(31..500_i32, 8), rear_m in 0.1..5.0,
        ) {
            // (s + 1) in the listing's sum and the floor: under 3° together for ranges over 30 cm.
            let cm: [i32; 8] = cm.try_into().unwrap();
            let apart = turn_deg(cm, 0, rear_m) - f64::from(listing_deg(cm, 0));
            prop_assert!(apart.abs() < 3.5, "{}", apart);
        }
    }
}
