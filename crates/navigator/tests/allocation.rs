//! A navigator that runs allocates nothing: it must keep its period on a small computer.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, boxed, trail, wall};
use geometry::{Base, Map, Se2, Transform2, Vec2};
use navigator::{GroundCommand, Phase, Sensed};

#[test]
fn steps_on_the_trail_and_around_an_obstacle_allocate_nothing() {
    let mut walls = vec![wall(-2.0, 1.2, 12.0, 1.2), wall(-2.0, -1.2, 12.0, -1.2)];
    walls.extend(boxed(Vec2::new(4.0, 0.1), Vec2::new(0.4, 0.4), 0.2));
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = Bed::new(|s| s, walls, field, Se2::IDENTITY, 1);
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(8.0, 0.0, 0.5));
    bed.tell(Sensed::Ground(GroundCommand::GoTo { goal_in_map }));
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
