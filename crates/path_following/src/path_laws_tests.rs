//! Tests of single steps; driving is in `tests/driving/followers.rs`.

use super::*;

const DT: Duration = Duration::from_millis(200);

fn x_axis() -> Path {
    Path::polyline(&[Vec2::new(0.0, 0.0), Vec2::new(10.0, 0.0)]).unwrap()
}

fn follower(law: PathLaw) -> PathFollower {
    PathFollower::new(PathFollowerConfig { law, ..PathFollowerConfig::default() }).unwrap()
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-6, "{a} is not {b}");
}

/// L = 600 mm, target 200 mm to the left: γ = 1/900 mm, so 236.67 and 363.33 mm/s at 300 mm/s, b = 380 mm.
#[test]
fn pure_pursuit_has_the_golden_wheel_speeds() {
    let follower = follower(PathLaw::PurePursuit { lookahead_m: 0.6 });
    let forward_m = (0.6_f64.powi(2) - 0.2_f64.powi(2)).sqrt();
    let left = follower.pursue(Vec2::new(forward_m, 0.2), 0.3);
    near(left.left_mps, 0.236_666_667);
    near(left.right_mps, 0.363_333_333);
    let right = follower.pursue(Vec2::new(forward_m, -0.2), 0.3);
    assert_eq!((right.left_mps, right.right_mps), (left.right_mps, left.left_mps));
}

/// The same through the whole step: 200 mm right of a line the target on it is 200 mm to the left.
#[test]
fn pure_pursuit_finds_its_target_on_the_path() {
    let wheels = follower(PathLaw::PURE_PURSUIT).step(&x_axis(), Se2::new(1.0, -0.2, 0.0), 0.3, DT);
    near(wheels.left_mps, 0.236_666_667);
    near(wheels.right_mps, 0.363_333_333);
}

#[test]
fn the_target_is_one_lookahead_away_around_corners_as_well() {
    let path = Path::polyline(&[Vec2::zeros(), Vec2::new(2.0, 0.0), Vec2::new(2.0, 5.0)]).unwrap();
    let (from, whole) = (Vec2::new(1.5, 0.1), Leg { from_m: 0.0, to_m: 7.0 });
    let target = point_ahead(&path, whole, from, 1.5, 0.8);
    near((target - from).norm(), 0.8);
    assert!(target.x > 1.999 && target.y > 0.5, "{target}");
    // Far from the path: its nearest point. Past the end: on the extended line.
    assert_eq!(point_ahead(&path, whole, Vec2::new(1.0, 3.0), 1.0, 0.8), Vec2::new(1.0, 0.0));
    near(
        (point_ahead(&path, whole, Vec2::new(2.0, 4.9), 6.9, 0.8) - Vec2::new(2.0, 5.7)).norm(),
        0.0,
    );
}

#[test]
fn the_carrot_turns_in_proportion_to_its_bearing() {
    let law = PathLaw::Carrot { lookahead_m: 0.5, gain_per_s: 2.0 };
    let wheels = follower(law).step(&x_axis(), Se2::new(1.0, -0.3, 0.0), 0.3, DT);
    let bearing_rad = (0.3_f64 / 0.5).asin();
    near(wheels.angular_radps(0.38), 2.0 * bearing_rad);
    near(wheels.linear_mps(), 0.3 * bearing_rad.cos());
}

#[test]
fn stanley_steers_back_by_the_arctangent() {
    let law = PathLaw::Stanley { cross_track_gain_per_s: 1.5, heading_gain_per_s: 1.0 };
    let wheels = follower(law).step(&x_axis(), Se2::new(1.0, 0.2, 0.1), 0.3, DT);
    // Heading error 0.1 to the left, and arctan(1.5 · 0.2 / 0.3) = 45° to the right.
    near(wheels.angular_radps(0.38), -(0.1 + FRAC_PI_4));
}

#[test]
fn fuzzy_turns_right_on_the_left_and_notes_the_change() {
    let law = PathLaw::Fuzzy {
        fuzzy: FuzzyConfig { error_full: 0.2, change_full: 0.1, ..FuzzyConfig::default() },
    };
    let mut follower = follower(law);
    // e = −0.1: N and Z at a half each, e′ = 0: v_L halfway between fast and mean.
    let first = follower.step(&x_axis(), Se2::new(1.0, 0.1, 0.0), 0.3, DT);
    near(first.left_mps, 0.375);
    near(first.right_mps, 0.225);
    // e′ = +0.1 per 200 ms: fully P, which undoes the turn.
    let second = follower.step(&x_axis(), Se2::new(1.1, 0.0, 0.0), 0.3, DT);
    near(second.left_mps, 0.15);
    // The same change in 400 ms counts half.
    let mut slow =
        PathFollower::new(PathFollowerConfig { law, ..PathFollowerConfig::default() }).unwrap();
    slow.step(&x_axis(), Se2::new(1.0, 0.1, 0.0), 0.3, 2 * DT);
    near(slow.step(&x_axis(), Se2::new(1.1, 0.0, 0.0), 0.3, 2 * DT).left_mps, 0.225);
}

#[test]
fn a_robot_that_looks_away_turns_on_the_spot() {
    for law in PathController::ALL.iter().map(|law| law.law()) {
        for yaw_rad in [3.0, -3.0] {
            let wheels = follower(law).step(&x_axis(), Se2::new(1.0, 0.0, yaw_rad), 0.3, DT);
            near(wheels.linear_mps(), 0.0);
            assert!(wheels.angular_radps(0.38) * yaw_rad < -0.1, "{law:?} {wheels:?}");
        }
    }
}

#[test]
fn stops_past_the_end_and_says_so() {
    let mut follower = follower(PathLaw::PURE_PURSUIT);
    assert!(follower.progress().is_none());
    follower.step(&x_axis(), Se2::new(9.5, 0.0, 0.0), 0.3, DT);
    let before = follower.progress().unwrap();
    near(before.remaining_m, 0.5);
    assert!(!before.finished);
    let wheels = follower.step(&x_axis(), Se2::new(10.01, 0.1, 0.0), 0.3, DT);
    assert_eq!(wheels, WheelReference::STOP);
    assert!(follower.progress().unwrap().finished);
    follower.restart();
    assert!(follower.progress().is_none());
}

/// Back and forth on lines 0.4 m apart: the robot on the first one must not jump to the last.
#[test]
fn a_hairpin_path_is_not_cut_short() {
    let hairpin = [Vec2::zeros(), Vec2::new(5.0, 0.0), Vec2::new(5.0, 0.4), Vec2::new(0.0, 0.4)];
    let path = Path::polyline(&hairpin).unwrap();
    let mut follower = follower(PathLaw::PURE_PURSUIT);
    follower.step(&path, Se2::new(1.0, 0.0, 0.0), 0.3, DT);
    follower.step(&path, Se2::new(1.1, 0.3, 0.0), 0.3, DT);
    near(follower.progress().unwrap().arc_length_m, 1.1);
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |law| {
        let config = PathFollowerConfig { law, ..PathFollowerConfig::default() };
        PathFollower::new(config).unwrap_err().to_string()
    };
    let law = PathLaw::PurePursuit { lookahead_m: 0.0 };
    assert_eq!(refused(law), "lookahead_m = 0: must be from 0.05 to 10 m");
    let law = PathLaw::Carrot { lookahead_m: 0.6, gain_per_s: f64::NAN };
    assert_eq!(refused(law), "gain_per_s = NaN: must be from 0.05 to 20 1/s");
    let law = PathLaw::Stanley { cross_track_gain_per_s: -1.0, heading_gain_per_s: 1.0 };
    assert_eq!(refused(law), "cross_track_gain_per_s = -1: must be from 0.05 to 20 1/s");
    let config = PathFollowerConfig { wheelbase_m: 0.0, ..PathFollowerConfig::default() };
    assert_eq!(
        PathFollower::new(config).unwrap_err().to_string(),
        "wheelbase_m = 0: must be from 0.02 to 5 m"
    );
}
