//! A navigator that runs allocates nothing: it must keep its period on a small computer.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, boxed, trail, wall};
use geometry::{Base, Map, Se2, Transform2, Vec2};
use messages::{Order, Sensed};
use navigator::{Method, NavigatorSettings, Phase};
use path_following::{Path, PathController};
use pheromones::Field;

#[test]
fn steps_on_the_trail_and_around_an_obstacle_allocate_nothing() {
    let mut walls = vec![wall(-2.0, 1.2, 12.0, 1.2), wall(-2.0, -1.2, 12.0, -1.2)];
    walls.extend(boxed(Vec2::new(4.0, 0.1), Vec2::new(0.4, 0.4), 0.2));
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = Bed::new(|s| s, walls, field, Se2::IDENTITY, 1);
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(8.0, 0.0, 0.5));
    bed.tell(Sensed::Order(Order::GoTo { goal_in_map }));
    let (mut n_allocations, mut phases) = (0, Vec::new());
    bed.count_allocations = true;
    for k in 0..20_000 {
        bed.tick();
        // The first second warms up buffers.
        if k > 100 {
            n_allocations += bed.n_allocations;
        }
        let phase = bed.navigator.phase();
        if phases.last() != Some(&phase) {
            phases.push(phase);
        }
        if phase == Phase::Arrived {
            break;
        }
    }
    assert!(phases.contains(&Phase::Avoid) && phases.contains(&Phase::Arrived), "{phases:?}");
    assert_eq!(n_allocations, 0);
}

#[test]
fn steps_along_a_path_around_its_corners_and_to_its_goal_allocate_nothing() {
    for path_controller in [PathController::Fuzzy, PathController::PurePursuit] {
        let settings = |s: NavigatorSettings| NavigatorSettings {
            method: Method::Path,
            path_controller,
            speed_mps: 0.6,
            ..s
        };
        let walls = vec![wall(-2.0, 4.0, 12.0, 4.0)];
        let field = Field::new(3, 3, 0.2).unwrap();
        let mut bed = Bed::new(settings, walls, field, Se2::IDENTITY, 1);
        let corners = [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        bed.navigator.set_path(Path::polyline(&corners).unwrap());
        let goal_in_map = Transform2::<Map, Base>::new(Se2::new(0.0, 0.0, 1.0));
        bed.count_allocations = true;
        let mut n_allocations = 0;
        for k in 0..12_000 {
            if k == 100 {
                bed.tell(Sensed::Order(Order::GoTo { goal_in_map }));
            }
            bed.tick();
            n_allocations += if k > 50 { bed.n_allocations } else { 0 };
            if bed.navigator.phase() == Phase::Arrived {
                break;
            }
        }
        assert_eq!(bed.navigator.phase(), Phase::Arrived);
        assert!(bed.figures.way_m > 9.7, "{}", bed.figures.way_m);
        assert_eq!(n_allocations, 0);
    }
}
