//! The course against bounds written out anew.

use geometry::Vec2;

use super::*;

const PIONEER: CourseLimits = CourseLimits {
    cruise_mps: 1.0,
    wheel_speed_max_mps: 1.6,
    acceleration_mps2: 0.3,
    wheelbase_m: 0.38,
    lag_s: 0.35,
};

fn course(points: &[(f64, f64)]) -> Course {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Course::new(Path::polyline(&points).unwrap(), &PIONEER)
}

#[test]
fn right_angles_on_either_side_are_corners_where_the_robot_stands() {
    for side in [1.0, -1.0] {
        let course = course(&[(0.0, 0.0), (4.0, 0.0), (4.0, side * 4.0)]);
        let [corner] = course.corners() else { panic!("{:?}", course.corners()) };
        assert!((corner.along_m - 4.0).abs() < 1e-12);
        assert!((corner.turn_rad - side * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(course.leg(0), Leg { from_m: 0.0, to_m: 4.0 });
        assert_eq!(course.leg(1), Leg { from_m: 4.0, to_m: 8.0 });
        assert_eq!((course.leg_at(3.99), course.leg_at(4.0)), (0, 1));
        // It can be stopped for with the wheels' acceleration: v² ≤ 2 a s.
        for k in 0..80 {
            let along_m = 0.05 * f64::from(k);
            let (speed_mps, left_m) = (course.speed_at_mps(along_m), 4.0 - along_m);
            assert!(speed_mps * speed_mps <= 0.6 * left_m + 1e-9, "{along_m}: {speed_mps}");
        }
        assert!(course.speed_at_mps(0.5) > 0.9 && course.speed_at_mps(3.99) < 0.15);
    }
}

#[test]
fn a_way_back_on_itself_is_a_corner_of_half_a_turn() {
    let course = course(&[(0.0, 0.0), (3.0, 0.0), (0.0, 0.0)]);
    assert_eq!(course.n_legs(), 2);
    assert!((course.corners()[0].turn_rad.abs() - std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn gentle_turns_are_curves_and_many_small_ones_a_corner() {
    // 30° is a curve of 0.52 rad over 0.3 m.
    let bend = course(&[(0.0, 0.0), (2.0, 0.0), (2.0 + 3.0_f64.sqrt(), 1.0)]);
    assert_eq!(bend.n_legs(), 1);
    assert!((bend.curvature_at_per_m(2.0) - 30.0_f64.to_radians() / 0.3).abs() < 1e-9);
    assert!(bend.curvature_at_per_m(1.7).abs() < 1e-12);
    assert!(bend.speed_at_mps(2.0) < 0.35 && bend.speed_at_mps(2.0) > 0.2);
    // Four times 22.5° within 12 cm are a right angle; to and fro within 10 cm are two.
    let steps =
        [(0.0, 0.0), (2.0, 0.0), (2.04, 0.016), (2.068, 0.044), (2.084, 0.084), (2.084, 2.0)];
    assert_eq!(course(&steps).n_legs(), 2);
    assert_eq!(course(&[(0.0, 0.0), (2.0, 0.0), (2.0, 0.1), (4.0, 0.1)]).n_legs(), 3);
}

#[test]
fn an_arc_and_the_polyline_that_stands_for_it_are_driven_alike() {
    let round = Path::rounded(&[Vec2::zeros(), Vec2::new(4.0, 0.0), Vec2::new(4.0, 4.0)], 1.0);
    let round = Course::new(round.unwrap(), &PIONEER);
    let points: Vec<(f64, f64)> = (0..=120)
        .map(|k| round.path().point_at(round.path().length_m() * f64::from(k) / 120.0))
        .map(|p| (p.x, p.y))
        .collect();
    let chopped = course(&points);
    assert_eq!((round.n_legs(), chopped.n_legs()), (1, 1));
    // In the middle of the arc.
    let at_m = 3.0 + std::f64::consts::FRAC_PI_4;
    assert!((round.curvature_at_per_m(at_m) - 1.0).abs() < 0.2);
    assert!((chopped.curvature_at_per_m(at_m) - 1.0).abs() < 0.2);
    assert!((round.speed_at_mps(at_m) - chopped.speed_at_mps(at_m)).abs() < 0.06);
}

#[test]
fn no_two_places_ask_for_more_than_the_acceleration() {
    let zigzag: Vec<(f64, f64)> =
        (0..9).map(|k| (f64::from(k), if k % 2 == 0 { 0.0 } else { 0.6 })).collect();
    let course = course(&zigzag);
    let n = (course.path().length_m() / 0.05) as u32;
    for k in 0..n {
        let (a, b) = (0.05 * f64::from(k), 0.05 * f64::from(k + 1));
        let (va, vb) = (course.speed_at_mps(a), course.speed_at_mps(b));
        // A sample further, as the least of two is asked for.
        assert!((va * va - vb * vb).abs() <= 2.0 * 0.3 * 0.1 + 1e-9, "{a}: {va} {vb}");
        assert!(course.speed_until_mps(a, b) <= va.min(vb));
    }
}

#[test]
fn a_slow_brain_drives_slowly() {
    let path = || Path::polyline(&[Vec2::zeros(), Vec2::new(9.0, 0.0)]).unwrap();
    let at = |lag_s| Course::new(path(), &CourseLimits { lag_s, ..PIONEER }).speed_at_mps(4.5);
    assert!((at(0.0) - 1.0).abs() < 1e-12);
    assert!((at(2.15) - 0.35 / 2.15).abs() < 1e-12);
}
