//! Tests of single steps; driving is in `tests/driving/trails.rs`.

use super::{
    BioMimeticReading::{PrintedLeft, PrintedRight, Repaired},
    *,
};

const DT: Duration = Duration::from_millis(200);

fn follower(law: TrailLaw) -> TrailFollower {
    TrailFollower::new(TrailFollowerConfig { law, ..TrailFollowerConfig::default() }).unwrap()
}

fn sensed(left: f64, right: f64) -> TrailSense {
    TrailSense { left, right, equivalent: None }
}

fn laws() -> impl Iterator<Item = TrailLaw> {
    TrailController::ALL.iter().map(|law| law.law(TrailTuning::default()))
}

/// The law that a mission gets unless it says otherwise is the one that is tested here.
#[test]
fn the_default_law_is_fuzzy() {
    let law = TrailController::default().law(TrailTuning::default());
    assert_eq!(law, TrailLaw::fuzzy());
    assert_eq!(law, TrailFollowerConfig::default().law);
}

/// e = 25 of M = 50 at twice the pace: the sets are four times as wide. At half the pace the change counts twice.
#[test]
fn the_sets_of_the_fuzzy_law_fit_the_pace() {
    let step = |follower: &mut TrailFollower, e: f64, pace_ratio: f64| {
        follower.step_at_pace(sensed(120.0 + e, 120.0), 0.3, pace_ratio, DT).left_mps
    };
    let mut fast = follower(TrailLaw::fuzzy());
    near(step(&mut fast, 25.0, 2.0), 0.3 - 0.15 * 0.125);
    let mut slow = follower(TrailLaw::fuzzy());
    near(step(&mut slow, 25.0, 0.5), 0.225);
    let mut usual = follower(TrailLaw::fuzzy());
    near(step(&mut usual, 25.0, 1.0), 0.225);
    // e from 25 to 12.5: e′ = −12.5, which counts as −25 at half the pace.
    assert!(step(&mut slow, 12.5, 0.5) > step(&mut usual, 12.5, 1.0) + 0.02);
    // Other laws have no sets that fit.
    let mut angle = follower(TrailLaw::fuzzy_angle());
    let mut other = follower(TrailLaw::fuzzy_angle());
    near(step(&mut angle, 25.0, 2.0), step(&mut other, 25.0, 1.0));
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

#[test]
fn a_lost_trail_means_slowly_straight_on_and_is_timed() {
    for law in laws() {
        let mut follower = follower(law);
        let on_trail = follower.step(sensed(130.0, 130.0), 0.3, DT);
        near(on_trail.angular_radps(0.38), 0.0);
        assert_eq!(follower.lost_for(), Duration::ZERO);
        for n in 1..4 {
            let lost = follower.step(sensed(0.0, 0.0), 0.3, DT);
            assert_eq!(lost, WheelReference::straight(0.08), "{law:?}");
            assert_eq!(follower.lost_for(), n * DT);
        }
        follower.step(sensed(0.0, 3.0), 0.3, DT);
        assert_eq!(follower.lost_for(), Duration::ZERO);
        follower.step(sensed(0.0, 0.0), 0.3, DT);
        follower.restart();
        assert_eq!(follower.lost_for(), Duration::ZERO);
    }
}

/// e = 25 with M = 50: half way to the slow and the fast speed; then e′ = −25 cancels a full e.
#[test]
fn fuzzy_uses_the_difference_and_its_change() {
    let mut follower = follower(TrailLaw::fuzzy());
    let first = follower.step(sensed(145.0, 120.0), 0.3, DT);
    near(first.left_mps, 0.225);
    near(first.right_mps, 0.375);
    let second = follower.step(sensed(200.0, 125.0), 0.3, DT);
    near(second.left_mps, 0.15);
    let third = follower.step(sensed(170.0, 120.0), 0.3, DT);
    near(third.left_mps, 0.3);
}

#[test]
fn after_a_gap_there_is_no_change_to_speak_of() {
    let mut follower = follower(TrailLaw::fuzzy());
    follower.step(sensed(0.0, 80.0), 0.3, DT);
    follower.step(sensed(0.0, 0.0), 0.3, DT);
    near(follower.step(sensed(25.0, 0.0), 0.3, DT).left_mps, 0.225);
}

#[test]
fn the_listing_gets_bytes_and_answers_in_steps_of_20_mm_per_s() {
    let mut follower = follower(TrailLaw::listing());
    // 300.7 is sent as 255, 230.9 as 230: e = 25, half way: 225 and 375 mm/s, as 11 and 18 units.
    let wheels = follower.step(sensed(300.7, 230.9), 0.3, DT);
    near(wheels.left_mps, 0.22);
    near(wheels.right_mps, 0.36);
}

/// (5.44) as repaired, and both readings of the print on either side of a half.
#[test]
fn the_bio_mimetic_law_and_its_printed_readings() {
    let wheels = |reading, left, right| {
        let law = TrailLaw::BioMimetic { intensity_full: 100.0, reading };
        let wheels = follower(law).step(sensed(left, right), 0.4, DT);
        ((1e6 * wheels.left_mps).round() / 1e6, (1e6 * wheels.right_mps).round() / 1e6)
    };
    assert_eq!(wheels(Repaired, 60.0, 30.0), (0.28, 0.4));
    assert_eq!(wheels(Repaired, 30.0, 60.0), (0.4, 0.28));
    assert_eq!(wheels(Repaired, 300.0, 30.0), (0.0, 0.4));
    assert_eq!(wheels(Repaired, 50.0, 50.0), (0.4, 0.4));
    // The trail on the left, by 0.3 and by 0.8: right turns are wrong.
    assert_eq!(wheels(PrintedLeft, 60.0, 30.0), (0.28, 0.12));
    assert_eq!(wheels(PrintedLeft, 90.0, 10.0), (0.08, 0.32));
    assert_eq!(wheels(PrintedRight, 60.0, 30.0), (0.12, 0.28));
    assert_eq!(wheels(PrintedRight, 90.0, 10.0), (0.32, 0.08));
    assert_eq!(wheels(PrintedLeft, 50.0, 50.0), (0.0, 0.0));
    assert_eq!(wheels(PrintedRight, 50.0, 50.0), (0.0, 0.0));
}

/// (5.48): σ = 0.6 m; P = 0.5 of one unit source is 0.3 m away, 2 of three are 0.2 m away.
#[test]
fn two_antennas_find_the_equivalent_source() {
    let antennas = |total_intensity| TwoAntennas { total_intensity, ..TwoAntennas::default() };
    let one = antennas(100.0).equivalent(&sensed(50.0, 50.0));
    near(one.distance_m, 0.3);
    near(one.bearing_rad, 0.0);
    near(antennas(300.0).equivalent(&sensed(200.0, 200.0)).distance_m, 0.2);
    // A real one: 0.4 m ahead and 0.1 m to the left, 100 (1 − d/σ) at each antenna.
    let at = |y: f64| 100.0 * (1.0 - f64::hypot(0.4, 0.1 - y) / 0.6);
    let seen = antennas(100.0).equivalent(&sensed(at(0.19), at(-0.19)));
    assert!((seen.bearing_rad - 0.1_f64.atan2(0.4)).abs() < 0.05, "{seen:?}");
    assert!((seen.distance_m - 0.412).abs() < 0.05, "{seen:?}");
    // What is told is believed, unless it is nonsense.
    let told = |bearing_rad| TrailSense {
        equivalent: Some(EquivalentPoint { bearing_rad, distance_m: 0.5 }),
        ..sensed(50.0, 50.0)
    };
    near(antennas(100.0).equivalent(&told(0.7)).bearing_rad, 0.7);
    near(antennas(100.0).equivalent(&told(f64::NAN)).bearing_rad, 0.0);
}

/// γ = 2 sin φ / L: 30° at 0.5 m is a curve of 0.5 m radius.
#[test]
fn pure_pursuit_drives_the_arc_through_the_source() {
    let wheels = |distance_m| {
        let equivalent = Some(EquivalentPoint { bearing_rad: 30_f64.to_radians(), distance_m });
        follower(TrailLaw::pure_pursuit()).step(
            TrailSense { equivalent, ..sensed(9.0, 9.0) },
            0.3,
            DT,
        )
    };
    near(wheels(0.5).angular_radps(0.38), 0.6);
    // Nearer than the least look-ahead of 0.25 m: as if it were there.
    near(wheels(0.1).angular_radps(0.38), 1.2);
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |law| {
        let config = TrailFollowerConfig { law, ..TrailFollowerConfig::default() };
        TrailFollower::new(config).unwrap_err().to_string()
    };
    let law = TrailLaw::BioMimetic { intensity_full: 0.0, reading: BioMimeticReading::Repaired };
    assert_eq!(refused(law), "intensity_full = 0: must be from 1 to 1e6");
    let antennas = TwoAntennas { sigma_m: f64::NAN, ..TwoAntennas::default() };
    let law = TrailLaw::PurePursuit { antennas, lookahead_min_m: 0.25 };
    assert_eq!(refused(law), "sigma_m = NaN: must be from 0.05 to 10 m");
    let config = TrailFollowerConfig { lost_speed_mps: -0.1, ..TrailFollowerConfig::default() };
    assert!(TrailFollower::new(config).is_err());
}
