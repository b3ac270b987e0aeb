//! Tests of paths: hand-checkable places, a brute-force projection, the line error of the thesis.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use proptest::prelude::*;

use super::*;

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn corner() -> Path {
    Path::polyline(&[v(0.0, 0.0), v(4.0, 0.0), v(4.0, 3.0)]).unwrap()
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

#[test]
fn left_of_the_path_is_positive() {
    let path = corner();
    let seen = [v(1.0, 0.5), v(1.0, -0.5), v(3.5, 1.0), v(4.5, 1.0)].map(|p| path.project(p));
    let errors = seen.map(|seen| seen.cross_track_m);
    assert_eq!(errors, [0.5, -0.5, 0.5, -0.5]);
    assert_eq!(seen.map(|seen| seen.arc_length_m), [1.0, 1.0, 5.0, 5.0]);
    near(seen[2].heading_rad, FRAC_PI_2);
}

#[test]
fn outside_a_corner_the_corner_is_nearest() {
    let seen = corner().project(v(4.3, -0.4));
    assert_eq!((seen.arc_length_m, seen.point), (4.0, v(4.0, 0.0)));
    near(seen.cross_track_m, -0.5);
}

#[test]
fn beyond_the_ends_the_tangent_counts() {
    let before = corner().project(v(-2.0, 0.3));
    assert_eq!((before.arc_length_m, before.cross_track_m), (0.0, 0.3));
    let after = corner().project(v(4.2, 5.0));
    near(after.arc_length_m, 7.0);
    near(after.cross_track_m, -0.2);
}

#[test]
fn places_along_it_are_where_they_should_be() {
    let path = corner();
    assert_eq!((path.point_at(-1.0), path.point_at(1.5)), (v(0.0, 0.0), v(1.5, 0.0)));
    assert_eq!((path.point_at(6.0), path.point_at(99.0)), (v(4.0, 2.0), v(4.0, 3.0)));
    assert_eq!(
        (path.extended_point_at(8.0), path.extended_point_at(-1.0)),
        (v(4.0, 4.0), v(-1.0, 0.0))
    );
    near(path.end_heading(), FRAC_PI_2);
    near(path.pose_at(4.0).yaw_rad, FRAC_PI_2);
}

/// A figure of eight as a polyline: at the crossing the window decides which branch is meant.
#[test]
fn a_window_keeps_to_its_branch() {
    let eight = Path::polyline(&[v(-1.0, -1.0), v(1.0, 1.0), v(1.0, -1.0), v(-1.0, 1.0)]).unwrap();
    let diagonal = 8.0_f64.sqrt();
    let crossing = v(0.01, 0.0);
    let first = eight.project_within(crossing, 0.0, diagonal);
    let second = eight.project_within(crossing, diagonal + 2.0, eight.length_m());
    near(first.heading_rad, FRAC_PI_4);
    near(second.heading_rad, 3.0 * FRAC_PI_4);
    assert!(first.cross_track_m < 0.0 && second.cross_track_m < 0.0);
    near(first.arc_length_m, 0.5 * diagonal + 0.01 / 2.0_f64.sqrt());
}

#[test]
fn a_circle_is_followed_by_its_radius() {
    let arc = Arc::from_pose(Se2::IDENTITY, 2.0, PI);
    let path = Path::new(vec![Piece::Arc(arc)]).unwrap();
    near(path.length_m(), 2.0 * PI);
    let inside = path.project(v(1.0, 2.0));
    near(inside.cross_track_m, 1.0); // the centre is on the left
    near(inside.arc_length_m, PI);
    near(path.end_heading().abs(), PI);
    // A window within the arc has its own nearest point.
    near(path.project_within(v(1.0, 2.0), 0.0, 1.0).arc_length_m, 1.0);
    near(path.project_within(v(1.0, 2.0), 4.0, 5.0).arc_length_m, 4.0);
}

#[test]
fn rounding_replaces_corners_by_tangent_arcs() {
    let path = Path::rounded(&[v(0.0, 0.0), v(4.0, 0.0), v(4.0, 3.0)], 1.0).unwrap();
    assert_eq!(path.pieces().len(), 3);
    near(path.length_m(), 3.0 + FRAC_PI_2 + 2.0);
    let middle = path.pose_at(3.0 + FRAC_PI_4);
    near((middle.position() - v(3.0, 1.0)).norm(), 1.0);
    near(middle.yaw_rad, FRAC_PI_4);
    // A right turn, and a radius that does not fit.
    let tight =
        Path::rounded(&[v(0.0, 0.0), v(1.0, 0.0), v(1.0, -1.0), v(2.0, -1.0)], 9.0).unwrap();
    assert!(Path::new(tight.pieces().to_vec()).is_ok(), "pieces meet");
    near(tight.end_heading(), 0.0);
    near(tight.length_m(), 0.5 + FRAC_PI_2 + 0.5);
    // There and back again, and straight on: nothing to round.
    let folded = Path::rounded(&[v(0.0, 0.0), v(1.0, 0.0), v(2.0, 0.0), v(0.5, 0.0)], 0.3).unwrap();
    near(folded.length_m(), 3.5);
}

#[test]
fn what_cannot_be_a_path_is_refused() {
    let message = |points: &[Vec2]| Path::polyline(points).unwrap_err().to_string();
    assert_eq!(message(&[]), "a path needs two different points; 0 given, all the same");
    assert_eq!(
        message(&[v(1.0, 1.0); 3]),
        "a path needs two different points; 3 given, all the same"
    );
    assert_eq!(
        message(&[v(0.0, 0.0), v(f64::NAN, 0.0)]),
        "piece or point 1 of the path is not finite or has no positive size"
    );
    let line = |a, b| Piece::Line(Segment { a, b });
    assert_eq!(Path::new(vec![]).unwrap_err(), PathError::TooShort { n_points: 0 });
    let gap = Path::new(vec![line(v(0.0, 0.0), v(1.0, 0.0)), line(v(1.0, 0.5), v(2.0, 0.0))]);
    assert_eq!(gap.unwrap_err(), PathError::Gap { index: 1, gap_m: 0.5 });
    let flat =
        Piece::Arc(Arc { centre: v(0.0, 0.0), radius_m: 0.0, start_rad: 0.0, sweep_rad: 1.0 });
    assert_eq!(Path::new(vec![flat]).unwrap_err(), PathError::NotFinite { index: 0 });
    assert!(Path::rounded(&[v(0.0, 0.0), v(1.0, 0.0)], 0.0).is_err());
}

#[test]
fn repeated_points_are_one() {
    let path = Path::polyline(&[v(0.0, 0.0), v(0.0, 0.0), v(1.0, 0.0), v(1.0, 0.0)]).unwrap();
    assert_eq!((path.pieces().len(), path.length_m()), (1, 1.0));
}

/// "For the +x axis e = −y": on the left e < 0.
#[test]
fn the_line_error_has_the_sign_of_the_thesis() {
    let axis = Segment { a: v(0.0, 0.0), b: v(5.0, 0.0) };
    assert_eq!([v(1.0, 0.3), v(2.0, -0.3)].map(|p| signed_line_error_m(axis, p)), [-0.3, 0.3]);
    assert!(signed_line_error_m(Segment { a: axis.a, b: axis.a }, v(1.0, 1.0)).is_nan());
}

#[test]
fn nowhere_is_projected_onto_the_beginning() {
    let seen = corner().project(v(f64::NAN, 0.0));
    assert!(seen.arc_length_m.is_finite());
}

fn points(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec2>> {
    proptest::collection::vec((-5.0..5.0, -5.0..5.0).prop_map(|(x, y)| v(x, y)), n)
}

proptest! {
    /// Against two thousand points tried one by one.
    #[test]
    fn no_point_of_the_path_is_nearer(
        corners in points(2..7),
        radius in prop_oneof![Just(0.0), 0.1..2.0],
        (x, y) in (-6.0..6.0, -6.0..6.0),
    ) {
        let path = if radius > 0.0 { Path::rounded(&corners, radius) } else { Path::polyline(&corners) };
        let path = path.unwrap();
        let seen = path.project(v(x, y));
        let found = (seen.point - v(x, y)).norm();
        let tried = (0..=2000).map(|i| path.point_at(path.length_m() * f64::from(i) / 2000.0));
        let best = tried.map(|p| (p - v(x, y)).norm()).fold(f64::INFINITY, f64::min);
        prop_assert!(found < best + 1e-9, "{} but {} is possible", found, best);
        prop_assert!((path.point_at(seen.arc_length_m) - seen.point).norm() < 1e-9);
        prop_assert!(seen.cross_track_m.abs() < found + 1e-9);
    }

    #[test]
    fn the_cross_track_error_is_minus_that_of_the_thesis((ax, ay, bx, by) in (-5.0..5.0, -5.0..5.0, -5.0..5.0, -5.0..5.0), (x, y) in (-9.0..9.0, -9.0..9.0)) {
        let (a, b) = (v(ax, ay), v(bx, by));
        prop_assume!((b - a).norm() > 0.01);
        let seen = Path::polyline(&[a, b]).unwrap().project(v(x, y));
        let line = Segment { a, b };
        prop_assert!((seen.cross_track_m + signed_line_error_m(line, v(x, y))).abs() < 1e-6);
    }

    #[test]
    fn a_rounded_path_has_no_kinks(corners in points(3..7), radius in 0.05..2.0) {
        let path = Path::rounded(&corners, radius).unwrap();
        prop_assert!(Path::new(path.pieces().to_vec()).is_ok());
        for pair in path.pieces().windows(2) {
            let turn = wrap_to_pi(pair[1].pose_at(0.0).yaw_rad - pair[0].pose_at(pair[0].length_m()).yaw_rad);
            prop_assert!(turn.abs() < 1e-4);
        }
    }
}

fn polyline(points: &[(f64, f64)]) -> Path {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Path::polyline(&points).unwrap()
}

const SQUARE: [(f64, f64); 5] = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0), (0.0, 0.0)];

#[test]
fn a_loop_is_taken_up_at_its_beginning_and_reaches_its_goal_at_its_end() {
    let square = polyline(&SQUARE);
    for at in [Vec2::zeros(), Vec2::new(-0.1, 0.2), Vec2::new(0.05, -0.2)] {
        assert!(square.first_near_m(at, 0.0, 12.0, 0.3) < 0.1, "{at}");
        assert!(square.reaches_m(at, 0.7, 0.3) > 11.7, "{at}");
    }
    // In the middle of the third side: there, not earlier and not later.
    let at = square.first_near_m(Vec2::new(1.5, 3.2), 0.0, 12.0, 0.3);
    assert!((at - 7.5).abs() < 1e-9, "{at}");
    // An end that stops short of the goal is the end all the same.
    let open = polyline(&[(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0), (0.0, 0.4)]);
    assert!((open.reaches_m(Vec2::zeros(), 0.7, 0.3) - 11.6).abs() < 1e-9);
}

#[test]
fn a_path_that_passes_its_goal_reaches_it_at_the_last_passage() {
    let line = polyline(&[(0.0, 0.0), (6.0, 0.0)]);
    assert!((line.reaches_m(Vec2::new(3.0, 0.1), 0.7, 0.3) - 3.0).abs() < 1e-9);
    let crossing = polyline(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -3.0)]);
    assert!((crossing.reaches_m(Vec2::new(2.0, 0.0), 0.7, 0.3) - 10.0).abs() < 1e-9);
    // There and back: on the way out where it is met first, at the goal on the way back.
    let back = polyline(&[(0.0, 0.0), (3.0, 0.0), (0.0, 0.0)]);
    assert!((back.first_near_m(Vec2::new(1.0, 0.0), 0.0, 6.0, 0.0) - 1.0).abs() < 1e-9);
    assert!((back.reaches_m(Vec2::new(0.0, 0.0), 0.7, 0.3) - 6.0).abs() < 1e-9);
}

/// A robot beside a corner, seen from the leg after it, has that leg's direction, and from the leg before that one's,
/// whatever the lengths round to.
#[test]
fn a_stretch_has_the_direction_of_the_piece_inside_it_at_its_ends() {
    for hundredths in 20..400 {
        let length_m = f64::from(hundredths) * 0.01;
        let path = polyline(&[(0.1, 0.0), (0.1 + length_m, 0.0), (0.1 + length_m, 1.93)]);
        let before_corner = Vec2::new(0.07 + length_m, 0.02 - 0.05);
        let corner_m = (path.pieces()[0].length_m()).clamp(0.0, path.length_m());
        for rounded_m in [corner_m, length_m, corner_m - 1e-15, corner_m + 1e-15] {
            let after = path.project_within(before_corner, rounded_m, rounded_m + 1.0);
            assert!((after.heading_rad - FRAC_PI_2).abs() < 1e-9, "{length_m}: {after:?}");
            let beyond = Vec2::new(0.1 + length_m, 0.5);
            let before = path.project_within(beyond, rounded_m - 0.1, rounded_m);
            assert!(before.heading_rad.abs() < 1e-9, "{length_m}: {before:?}");
        }
    }
}
