//! The scout against fields of the pheromones' crate: what it finds, what it refuses, what it costs.

use pheromones::{Field, SenseConfig};

use super::*;

/// Trails of unit sources, one cell of 0.2 m wide.
fn field(trails: &[&[(f64, f64)]]) -> Field {
    let mut field = Field::new(101, 101, 0.2).unwrap();
    for trail in trails {
        let points: Vec<Vec2> = trail.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        field.draw_trail(&points, 1);
    }
    field
}

/// Asks until there is nothing to ask; answers as the server sends them, in bytes.
fn search(field: &Field, start: Se2, goal: (f64, f64), way_max_m: f64) -> Scout {
    let mut scout = Scout::new().with_room();
    scout.begin(start, Vec2::new(goal.0, goal.1), way_max_m);
    while let Some(pose) = scout.question() {
        let felt = field.sense(pose, &SenseConfig::default());
        let byte = |p: f64| p.min(255.0).floor();
        scout.answer((byte(felt.left), byte(felt.right)));
        assert!(scout.n_questions <= N_QUESTIONS_MAX + 7);
    }
    scout
}

/// The route's points every 0.12 m and which are near branches.
fn route(scout: &mut Scout) -> (Vec<Vec2>, Vec<bool>) {
    let (mut points, mut is_mixed) = (Vec::with_capacity(1024), Vec::new());
    let (end, from_goal_m) = scout.route_end().unwrap();
    let goal = Some(scout.goal).filter(|_| from_goal_m < 0.5);
    scout.route(end, goal, 0.12, &mut points, &mut is_mixed);
    (points, is_mixed)
}

fn length_m(points: &[Vec2]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Whether the route comes within 0.25 m of a point.
fn passes(points: &[Vec2], x: f64, y: f64) -> bool {
    points.iter().any(|p| (p - Vec2::new(x, y)).norm() < 0.25)
}

#[test]
fn a_straight_trail_is_walked_with_three_questions_a_step() {
    let mut scout = search(&field(&[&[(0.0, 0.0), (8.0, 0.0)]]), Se2::IDENTITY, (8.0, 0.0), 60.0);
    assert_eq!(scout.status(), Search::Found);
    let (points, is_mixed) = route(&mut scout);
    assert!(points.iter().all(|p| p.y.abs() < 0.06), "{points:?}");
    assert!(is_mixed.iter().all(|mixed| !mixed), "nothing branches off");
    assert!((length_m(&points) - 8.0).abs() < 0.4, "{}", length_m(&points));
    // Eight around the robot, then 24 places.
    assert!(scout.n_questions < 8 + 3 * 27, "{}", scout.n_questions);
}

#[test]
fn every_kind_of_junction_is_taken_in_every_direction() {
    let t: &[&[(f64, f64)]] = &[&[(-4.0, 0.0), (4.0, 0.0)], &[(0.0, 0.0), (0.0, 4.0)]];
    let x: &[&[(f64, f64)]] = &[&[(-4.0, 0.0), (4.0, 0.0)], &[(0.0, -4.0), (0.0, 4.0)]];
    let acute: &[&[(f64, f64)]] = &[&[(-4.0, 0.0), (4.0, 0.0)], &[(0.0, 0.0), (3.4, 2.1)]];
    let star: &[&[(f64, f64)]] =
        &[&[(0.0, 0.0), (4.0, 0.0)], &[(0.0, 0.0), (-2.0, 3.4)], &[(0.0, 0.0), (-2.0, -3.4)]];
    for (name, trails) in [("T", t), ("X", x), ("acute", acute), ("star", star)] {
        let field = field(trails);
        let ends: Vec<(f64, f64)> = trails.iter().flat_map(|t| [t[0], t[t.len() - 1]]).collect();
        let ends: Vec<_> = ends.into_iter().filter(|end| *end != (0.0, 0.0)).collect();
        for from in &ends {
            for to in ends.iter().filter(|to| *to != from) {
                for yaw_rad in [0.3, 2.2, -1.5] {
                    let mut scout = search(&field, Se2::new(from.0, from.1, yaw_rad), *to, 60.0);
                    assert_eq!(scout.status(), Search::Found, "{name}: {from:?} to {to:?}");
                    let (points, is_mixed) = route(&mut scout);
                    let length_m = length_m(&points);
                    assert!(passes(&points, to.0, to.1), "{name}: {from:?} to {to:?}: {points:?}");
                    assert!(length_m < 9.5, "{name}: {from:?} to {to:?}: {length_m} m");
                    assert!(is_mixed.iter().any(|mixed| *mixed), "{name}: {from:?} to {to:?}");
                }
            }
        }
    }
}

#[test]
fn of_two_ways_the_shorter_one_is_taken() {
    // A rectangle with the goal on its far side, nearer by one way around.
    let ring: &[(f64, f64)] = &[(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0)];
    let field = field(&[ring]);
    for (goal, by) in [((6.0, 1.6), (3.0, 0.0)), ((2.0, 4.0), (0.0, 2.0)), ((6.0, 3.2), (6.0, 2.0))]
    {
        let mut scout = search(&field, Se2::IDENTITY, goal, 60.0);
        assert_eq!(scout.status(), Search::Found);
        let (points, _) = route(&mut scout);
        assert!(passes(&points, by.0, by.1), "{goal:?}: {points:?}");
        assert!(length_m(&points) < 10.0);
    }
}

#[test]
fn loops_dead_ends_and_trails_that_pass_the_start_twice_are_searched_once() {
    let comb: Vec<Vec<(f64, f64)>> = (0..5)
        .map(|k| vec![(f64::from(k) * 1.6, 0.0), (f64::from(k) * 1.6, 3.0)])
        .chain([vec![(-2.0, 0.0), (8.0, 0.0)]])
        .collect();
    let comb: Vec<&[(f64, f64)]> = comb.iter().map(Vec::as_slice).collect();
    let eight: &[(f64, f64)] = &[
        (0.0, 0.0),
        (3.0, 0.0),
        (3.0, 3.0),
        (0.0, 3.0),
        (0.0, -3.0),
        (-3.0, -3.0),
        (-3.0, 0.0),
        (0.0, 0.0),
    ];
    for (trails, length) in [(comb.as_slice(), 25.0), (&[eight], 24.0)] {
        let field = field(trails);
        let scout = search(&field, Se2::new(0.0, 0.0, 0.4), (0.0, -9.0), 60.0);
        assert_eq!(scout.status(), Search::Exhausted);
        let Scouting { searched_m, n_questions, .. } = scout.figures();
        assert!(searched_m < 1.25 * length, "{searched_m} m of {length} m");
        assert!(f64::from(n_questions) < 20.0 * length, "{n_questions} for {length} m");
    }
}

#[test]
fn a_gap_of_a_cell_or_two_is_crossed_and_wider_ones_end_a_trail() {
    for (gap_m, found) in [(0.2, true), (0.4, true), (1.3, false), (2.0, false)] {
        let field = field(&[&[(0.0, 0.0), (3.0, 0.0)], &[(3.2 + gap_m, 0.0), (8.0, 0.0)]]);

        let scout = search(&field, Se2::IDENTITY, (8.0, 0.0), 60.0);
        assert_eq!(scout.status() == Search::Found, found, "{gap_m} m");
    }
}

#[test]
fn trails_side_by_side_are_two_from_a_metre_on() {
    for aside_m in [1.0, 1.2, 2.0] {
        // The second one begins out of the robot's reach.
        let field = field(&[&[(0.0, 0.0), (6.0, 0.0)], &[(3.0, aside_m), (9.0, aside_m)]]);
        let scout = search(&field, Se2::IDENTITY, (9.0, aside_m), 60.0);
        assert_eq!(scout.status(), Search::Exhausted, "{aside_m}");
        let nearest_m = scout.figures().nearest_m.unwrap();
        assert!((nearest_m - 3.0_f64.hypot(aside_m)).abs() < 0.5, "{nearest_m}");
    }
}

#[test]
fn a_robot_beside_the_trail_finds_it_from_both_sides() {
    for (y, found) in [(0.3, true), (-0.8, true), (1.5, true), (-1.5, true), (2.6, false)] {
        let field = field(&[&[(-4.0, 0.0), (4.0, 0.0)]]);
        let mut scout = search(&field, Se2::new(0.0, y, 1.0), (4.0, 0.0), 60.0);
        assert_eq!(scout.has_found_trails(), found, "{y}");
        if found {
            assert_eq!(scout.status(), Search::Found);
            let (points, _) = route(&mut scout);
            assert!(points[0].y.abs() <= y.abs() + 1e-9 && passes(&points, 4.0, 0.0), "{points:?}");
        }
    }
}

#[test]
fn a_way_beyond_the_limit_is_begun() {
    let field = field(&[&[(-8.0, 0.0), (9.0, 0.0)], &[(-8.0, 0.0), (-8.0, 6.0)]]);
    let mut scout = search(&field, Se2::new(-8.0, 0.0, 0.0), (9.0, 0.0), 6.0);
    assert_eq!(scout.status(), Search::LimitReached);
    assert!(scout.figures().is_cut_short);
    let (points, _) = route(&mut scout);
    let end = points.last().unwrap();
    assert!(
        (end - Vec2::new(-2.0, 0.0)).norm() < 0.6,
        "as far towards the goal as permitted: {end}"
    );
}

#[test]
fn the_nearest_point_of_the_trails_is_known_when_there_is_no_way() {
    let field = field(&[&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)]]);
    let scout = search(&field, Se2::IDENTITY, (4.0, 5.0), 60.0);
    assert_eq!(scout.status(), Search::Exhausted);
    let nearest_m = scout.figures().nearest_m.unwrap();
    assert!((nearest_m - 3.0).abs() < 0.4, "{nearest_m}");
    let nothing = search(&field, Se2::new(-6.0, 6.0, 0.0), (4.0, 0.0), 60.0);
    assert_eq!(nothing.figures().nearest_m, None);
    assert!(!nothing.has_found_trails());
}

/// A bend is no junction: there the antennas lead, and cut it as far as their reach has it.
#[test]
fn nothing_branches_off_a_bend() {
    for (bend, yaw_rad) in [((4.0, 4.0), 0.0), ((6.8, 2.8), 0.4), ((6.0, -3.5), -0.3)] {
        let field = field(&[&[(0.0, 0.0), (4.0, 0.0), bend]]);
        let mut scout = search(&field, Se2::new(0.0, 0.0, yaw_rad), bend, 60.0);
        assert_eq!(scout.status(), Search::Found);
        let (points, is_mixed) = route(&mut scout);
        let mixed: Vec<_> = points.iter().zip(&is_mixed).filter(|(_, m)| **m).collect();
        assert!(mixed.is_empty(), "{bend:?}: {mixed:?}");
    }
}
