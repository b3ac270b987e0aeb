//! Robots with a planar laser and without sonars: they go around things, and stand while they see nothing.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use std::time::Duration;

use bed::{Bed, LASER, Laser, Person, boxed, trail, wall};
use geometry::{Base, Map, Se2, Segment, Transform2, Vec2};
use messages::{Order, Report, Sensed};
use navigator::{Avoidance, LaserMount, Method, NavigatorSettings, Phase};
use pheromones::Field;
use run_context::Stamp;

/// A bed whose robot has a laser for sonars.
fn laser_bed(
    change: impl FnOnce(NavigatorSettings) -> NavigatorSettings,
    walls: Vec<(Segment, u32)>,
    field: Field,
    seed: u64,
) -> Bed {
    let laser = Laser::new();
    let settings = |s: NavigatorSettings| {
        let mount = LaserMount { device: LASER, base_from_sensor: laser.base_from_sensor };
        change(NavigatorSettings {
            sensors: Vec::new(),
            bubble_gains: Vec::new(),
            bubble_floors_m: Vec::new(),
            lasers: vec![mount],
            ..s
        })
    };
    let mut bed = Bed::new(settings, walls, field, Se2::IDENTITY, seed);
    bed.n_sonars = 0;
    bed.laser = Some(laser);
    bed
}

fn corridor_with_box() -> Vec<(Segment, u32)> {
    let mut walls = vec![
        wall(-2.0, 1.2, 12.0, 1.2),
        wall(-2.0, -1.2, 12.0, -1.2),
        wall(-2.0, -1.2, -2.0, 1.2),
        wall(12.0, -1.2, 12.0, 1.2),
    ];
    walls.extend(boxed(Vec2::new(4.0, 0.1), Vec2::new(0.4, 0.4), 0.2));
    walls
}

#[test]
fn a_box_on_the_trail_is_passed_by_what_a_laser_sees() {
    for seed in 1..=5 {
        let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
        let mut bed = laser_bed(|s| s, corridor_with_box(), field, seed);
        let figures = bed.run_to(Se2::new(8.0, 0.0, 0.5), 200.0);
        println!(
            "{seed}: {:?} {:.1} s {:.3} m",
            figures.phase, figures.time_s, figures.clearance_min_m
        );
        assert_eq!(figures.phase, Phase::Arrived, "{seed}");
        assert_eq!(figures.n_touched, 0, "{seed}");
        assert!(figures.clearance_min_m > 0.03, "{seed}: {}", figures.clearance_min_m);
        assert!(figures.goal_error_m < 0.08, "{seed}: {}", figures.goal_error_m);
    }
}

/// The thesis's rebound needs nothing but ranges: the sectors of a laser do.
#[test]
fn the_bubble_rebounds_from_the_sectors_of_a_laser() {
    let settings = |s: NavigatorSettings| NavigatorSettings {
        method: Method::Direct,
        avoidance: Avoidance::Rebound,
        ..s
    };
    let walls = boxed(Vec2::new(4.0, 0.2), Vec2::new(0.4, 0.4), 0.2);
    let mut bed = laser_bed(settings, walls, Field::new(3, 3, 0.2).unwrap(), 1);
    let figures = bed.run_to(Se2::new(8.0, 0.0, 0.0), 200.0);
    assert_eq!((figures.phase, figures.n_touched), (Phase::Arrived, 0));
    let rebounded = figures.reports.contains(&Report::StateEntered(5));
    assert!(rebounded, "{:?}", figures.reports);
}

/// What stood in the way and left is forgotten with the next scan: the robot waits no longer than it must.
#[test]
fn a_person_who_has_passed_is_not_gone_around() {
    let mut n_waited = 0;
    for starts_ms in [8_000, 8_500, 9_000, 9_500, 10_000] {
        let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
        // Something ends every beam: one that does not come back frees nothing.
        let mut walls = vec![wall(-2.0, 2.0, 9.5, 2.0), wall(-2.0, -2.0, 9.5, -2.0)];
        walls.push(wall(9.5, -2.0, 9.5, 2.0));
        let mut bed = laser_bed(|s| s, walls, field, 3);
        bed.person = Some(Person {
            from: Vec2::new(3.0, 1.8),
            to: Vec2::new(3.0, -1.8),
            speed_mps: 0.5,
            starts: Stamp::from_millis(starts_ms),
            yields: false,
        });
        let figures = bed.run_to(Se2::new(8.0, 0.0, 0.0), 120.0);
        let entered = |state: u8| figures.reports.contains(&Report::StateEntered(state));
        println!("{starts_ms}: {:.1} s, waited {}", figures.time_s, entered(4));
        assert_eq!((figures.phase, figures.n_touched), (Phase::Arrived, 0), "{starts_ms}");
        assert!(!entered(6), "{starts_ms}: went around somebody who had passed");
        n_waited += u32::from(entered(4));
    }
    assert!(n_waited > 0);
}

/// A laser that is silent sees nothing: the robot stands within half a second and a little, says so, and goes on when
/// it is back. The wall that has come near meanwhile stops it.
#[test]
fn a_robot_whose_laser_is_silent_stands_until_it_is_back() {
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = laser_bed(|s| s, corridor_with_box(), field, 1);
    let silent = (Stamp::from_millis(16_000), Stamp::from_millis(24_000));
    bed.laser.as_mut().unwrap().silent = Some(silent);
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(8.0, 0.0, 0.5));
    (0..100).for_each(|_| bed.tick());
    bed.tell(Sensed::Order(Order::GoTo { goal_in_map }));
    let (mut blind_since, mut moved) = (None, false);
    let mut drove_before = false;
    while bed.now < Stamp::from_millis(150_000) && bed.navigator.phase() != Phase::Arrived {
        bed.tick();
        let still = bed.wheels.left_mps.abs() < 1e-9 && bed.wheels.right_mps.abs() < 1e-9;
        drove_before |= bed.now < silent.0 && !still;
        if bed.navigator.phase() == Phase::Blind {
            blind_since.get_or_insert(bed.now);
            // 0.3 m/s are braked in a second.
            moved |= !still && bed.now > silent.0 + Duration::from_secs(2);
        }
    }
    let blind_since = blind_since.unwrap();
    let after = blind_since.since(silent.0);
    println!("blind {after:?} after the last scan");
    assert!(drove_before && !moved);
    assert!(
        after >= Duration::from_millis(400) && after <= Duration::from_millis(800),
        "{after:?}"
    );
    assert_eq!(bed.navigator.phase(), Phase::Arrived);
    assert_eq!(bed.figures.n_touched, 0);
    // One that has never sent a scan is silent from the beginning.
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = laser_bed(|s| s, corridor_with_box(), field, 1);
    bed.laser.as_mut().unwrap().silent = Some((Stamp::ZERO, Stamp::from_millis(1_000_000)));
    let figures = bed.run_to(Se2::new(8.0, 0.0, 0.5), 30.0);
    assert_eq!((figures.phase, figures.way_m), (Phase::Blind, 0.0));
}

#[test]
fn scans_allocate_nothing() {
    let field = trail(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut bed = laser_bed(|s| s, corridor_with_box(), field, 1);
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(8.0, 0.0, 0.5));
    bed.tell(Sensed::Order(Order::GoTo { goal_in_map }));
    bed.count_allocations = true;
    let mut n_allocations = 0;
    for k in 0..20_000 {
        bed.tick();
        n_allocations += if k > 100 { bed.n_allocations } else { 0 };
        if bed.navigator.phase() == Phase::Arrived {
            break;
        }
    }
    assert_eq!((bed.navigator.phase(), n_allocations), (Phase::Arrived, 0));
}
