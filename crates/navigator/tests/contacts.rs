//! Robots that hear and see nothing: what they touch stops them, and they go around it by feeling.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, Skin, boxed, wall};
use geometry::{Se2, Segment, Vec2};
use messages::FailureReason;
use navigator::{Avoidance, Method, NavigatorSettings, Phase};
use pheromones::Field;

/// A Create 2 that drives straight to its goal among walls, on a floor that ends at an x (m).
fn create(walls: Vec<(Segment, u32)>, floor_ends_m: f64) -> Bed {
    let settings = |s: NavigatorSettings| NavigatorSettings {
        method: Method::Direct,
        avoidance: Avoidance::Contact,
        speed_mps: 0.2,
        detour_m: 0.6,
        ..s
    };
    let field = Field::new(3, 3, 0.2).unwrap();
    let mut bed = Bed::of("create2", settings, walls, field, Se2::IDENTITY, 1);
    bed.n_sonars = 0;
    bed.feels = Some(Skin { floor_ends_m });
    bed
}

/// The furthest forward that the robot's middle came, metres.
fn furthest_m(track: &[Se2]) -> f64 {
    track.iter().map(|pose| pose.x_m).fold(f64::NEG_INFINITY, f64::max)
}

/// Left and right of its middle, and right before it.
#[test]
fn a_box_on_the_way_is_felt_and_gone_around() {
    for y_m in [0.27, -0.27, 0.02, -0.02] {
        let walls = boxed(Vec2::new(1.5, y_m), Vec2::new(0.3, 0.3), 0.0);
        let mut bed = create(walls, f64::INFINITY);
        let figures = bed.run_to(Se2::new(3.0, 0.0, 0.0), 200.0);
        let sides: Vec<f64> = figures.track.iter().map(|pose| pose.y_m).collect();
        let aside =
            sides.iter().copied().fold(0.0, |a: f64, y| if y.abs() > a.abs() { y } else { a });
        println!("{y_m}: {:?} {:.1} s, {aside:.2} m aside", figures.phase, figures.time_s);
        assert_eq!(figures.phase, Phase::Arrived, "{y_m}");
        assert!(figures.goal_error_m < 0.08, "{y_m}: {}", figures.goal_error_m);
        // What was felt on the left is passed on the right.
        assert!(y_m.abs() < 0.1 || aside * y_m < 0.0, "{y_m}: {aside}");
    }
}

/// A wall across the whole way: after the attempts that are allowed the robot says that it is blocked.
#[test]
fn a_wall_across_the_way_ends_the_task_as_blocked() {
    let walls = vec![
        wall(1.5, -1.0, 1.5, 1.0),
        wall(-0.6, 1.0, 1.5, 1.0),
        wall(-0.6, -1.0, 1.5, -1.0),
        wall(-0.6, -1.0, -0.6, 1.0),
    ];
    let mut bed = create(walls, f64::INFINITY);
    let figures = bed.run_to(Se2::new(3.0, 0.0, 0.0), 400.0);
    println!("{:?} {:.1} s", figures.phase, figures.time_s);
    let blocked = Phase::Failed(FailureReason::Blocked);
    let no_progress = Phase::Failed(FailureReason::NoProgress);
    assert!(figures.phase == blocked || figures.phase == no_progress, "{:?}", figures.phase);
    assert!(furthest_m(&figures.track) < 1.5);
}

/// The edge of a table across the way: no wheel ever comes to it.
#[test]
fn a_cliff_stops_the_robot_before_its_wheels_are_there() {
    let mut bed = create(Vec::new(), 1.5);
    let figures = bed.run_to(Se2::new(3.0, 0.0, 0.0), 400.0);
    let furthest = furthest_m(&figures.track);
    println!("{:?} {:.1} s, {furthest:.3} m", figures.phase, figures.time_s);
    assert!(matches!(figures.phase, Phase::Failed(_)), "{:?}", figures.phase);
    assert!(furthest > 1.2 && furthest < 1.45, "{furthest}");
}
