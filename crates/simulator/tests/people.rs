//! How people walk, wait and are seen.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{sync::Arc, time::Duration};

use geometry::{Polygon, Se2, Vec2};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{PersonSpec, RobotPlacement, World, WorldSpec};

const STEP: Duration = Duration::from_millis(10);

fn walker(route: &[[f64; 2]]) -> PersonSpec {
    PersonSpec {
        name: "Ana".to_owned(),
        route: route.iter().map(|&[x, y]| Vec2::new(x, y)).collect(),
        speed_mps: 1.0,
        starts_at: Stamp::ZERO,
        repeats: false,
        yields: true,
        radius_m: 0.25,
    }
}

fn world_of(person: PersonSpec) -> World {
    let spec = WorldSpec { people: vec![person], ..WorldSpec::empty() };
    World::new(spec, RunSeed(1), STEP).unwrap()
}

fn robot(x_m: f64, y_m: f64, yaw_rad: f64) -> RobotPlacement {
    RobotPlacement {
        name: "rover".to_owned(),
        model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
        world_from_base: Se2::new(x_m, y_m, yaw_rad),
        errors: OdometryErrors::default(),
        sonar: SonarModel::ideal(),
    }
}

fn place_after(world: &mut World, seconds: u32) -> (f64, f64) {
    (0..seconds * 100).for_each(|_| world.step());
    let place = world.people()[0].position;
    // Centimetres: what a person who reads the test can check.
    ((place.x * 100.0).round() / 100.0 + 0.0, (place.y * 100.0).round() / 100.0 + 0.0)
}

#[test]
fn a_walk_starts_in_time_turns_corners_and_ends() {
    let late = PersonSpec {
        starts_at: Stamp::from_millis(2000),
        ..walker(&[[0., 0.], [2., 0.], [2., 3.]])
    };
    let mut world = world_of(late);
    assert_eq!(place_after(&mut world, 2), (0.0, 0.0));
    assert_eq!(place_after(&mut world, 1), (1.0, 0.0));
    assert_eq!(place_after(&mut world, 2), (2.0, 1.0));
    assert_eq!(place_after(&mut world, 9), (2.0, 3.0));
    assert!(!world.people()[0].is_moving());
}

#[test]
fn an_open_route_is_walked_to_and_fro_and_a_closed_one_round() {
    let to_and_fro = PersonSpec { repeats: true, ..walker(&[[0., 0.], [2., 0.], [2., 1.]]) };
    let mut world = world_of(to_and_fro);
    let places: Vec<_> = (0..7).map(|_| place_after(&mut world, 1)).collect();
    assert_eq!(places, [(1., 0.), (2., 0.), (2., 1.), (2., 0.), (1., 0.), (0., 0.), (1., 0.)]);

    let ring =
        PersonSpec { repeats: true, ..walker(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.]]) };
    let mut world = world_of(ring);
    let places: Vec<_> = (0..5).map(|_| place_after(&mut world, 1)).collect();
    assert_eq!(places, [(1., 0.), (1., 1.), (0., 1.), (0., 0.), (1., 0.)]);
}

#[test]
fn odd_routes_are_walked_or_refused() {
    // No length at all, repeated for ever: stands, and the step ends.
    let still = PersonSpec { repeats: true, ..walker(&[[1., 1.], [1., 1.], [1., 1.]]) };
    assert_eq!(place_after(&mut world_of(still), 1), (1.0, 1.0));
    // A double corner in the middle.
    assert_eq!(
        place_after(&mut world_of(walker(&[[0., 0.], [1., 0.], [1., 0.], [9., 0.]])), 3),
        (3.0, 0.0)
    );
    assert_eq!(place_after(&mut world_of(walker(&[[1., 2.]])), 1), (1.0, 2.0));

    let refused = |person| {
        let spec = WorldSpec { people: vec![person], ..WorldSpec::empty() };
        World::new(spec, RunSeed(1), STEP).unwrap_err().to_string()
    };
    assert_eq!(
        refused(walker(&[])),
        "person `Ana` has an empty route: give at least the place where they stand"
    );
    assert_eq!(
        refused(PersonSpec { speed_mps: -1.0, ..walker(&[[0., 0.]]) }),
        "`Ana`: speed_mps = -1: must be from 0 to 10 m/s"
    );
    assert_eq!(
        refused(walker(&[[0., f64::NAN]])),
        "`Ana`: route = NaN: must be a finite place within 1000 km"
    );
}

#[test]
fn a_yielding_person_waits_45_cm_before_a_robot_and_goes_on_when_it_is_gone() {
    let mut world = world_of(walker(&[[0., 0.], [9., 0.]]));
    let id = world.add_robot(robot(3.0, 0.0, std::f64::consts::FRAC_PI_2)).unwrap();
    // The robot's side is at 3 − 0.2125; the circle ends 0.45 before it.
    let (x_m, _) = place_after(&mut world, 6);
    assert!((x_m - (3.0 - 0.2125 - 0.45 - 0.25)).abs() < 0.011, "{x_m}");
    assert!(!world.people()[0].is_moving());
    assert_eq!(world.body(id).contacts, 0);

    world.set_wheel_reference(id, WheelSpeeds { left_mps: 0.6, right_mps: 0.6 });
    let (x_m, _) = place_after(&mut world, 12);
    assert!((x_m - 9.0).abs() < 1e-9, "{x_m}");
}

#[test]
fn a_yielding_person_does_not_mind_a_robot_behind() {
    let mut world = world_of(walker(&[[0., 0.], [9., 0.]]));
    world.add_robot(robot(-0.6, 0.0, 0.0)).unwrap();
    assert_eq!(place_after(&mut world, 2), (2.0, 0.0));
}

#[test]
fn even_who_does_not_yield_stops_at_the_touch_which_counts_once() {
    let stubborn = PersonSpec { yields: false, ..walker(&[[0., 0.], [9., 0.]]) };
    let mut world = world_of(stubborn);
    let id = world.add_robot(robot(3.0, 0.0, std::f64::consts::FRAC_PI_2)).unwrap();
    let (x_m, _) = place_after(&mut world, 6);
    assert!((x_m - (3.0 - 0.2125 - 0.25)).abs() < 0.011, "{x_m}");
    assert_eq!(world.body(id).contacts, 1);
}

#[test]
fn a_robot_does_not_drive_through_a_person() {
    let mut world = world_of(walker(&[[2., 0.]]));
    let id = world.add_robot(robot(0.0, 0.0, 0.0)).unwrap();
    world.set_wheel_reference(id, WheelSpeeds { left_mps: 0.3, right_mps: 0.3 });
    (0..1000).for_each(|_| world.step());
    let x_m = world.body(id).world_from_base.se2().x_m;
    assert!((x_m - (2.0 - 0.25 - 0.21)).abs() < 1e-3, "{x_m}");
    assert_eq!((world.body(id).contacts, world.body(id).touching), (1, true));
    assert!(world.clearance_m(id) < 1e-3);
}

#[test]
fn a_sonar_sees_a_person_come() {
    let mut world = world_of(walker(&[[4., 0.], [1., 0.]]));
    let id = world.add_robot(robot(0.0, 0.0, 0.0)).unwrap();
    let mut rng = RunSeed(2).stream("test");
    let range_m = |world: &World, rng: &mut _| world.ping(id, 3, rng).range_m;
    // 4 m − 0.25 m radius − the sensor's 0.166 m, a little more because the ray is askew.
    let far = range_m(&world, &mut rng);
    place_after(&mut world, 2);
    let near = range_m(&world, &mut rng);
    assert!((far - 3.584).abs() < 0.02 && (near - 1.584).abs() < 0.02, "{far} {near}");
}

#[test]
fn motion_is_detected_inside_the_zone_and_only_while_moving() {
    let mut world = world_of(walker(&[[0., 0.], [4., 0.]]));
    let zone = Polygon::rectangle(Vec2::new(2.0, -1.0), Vec2::new(6.0, 1.0)).unwrap();
    place_after(&mut world, 1);
    assert!(!world.motion_in(&zone), "walks outside");
    place_after(&mut world, 2);
    assert!(world.motion_in(&zone));
    place_after(&mut world, 2);
    assert!(!world.motion_in(&zone), "stands inside");

    let id = world.add_robot(robot(2.5, 0.0, 0.0)).unwrap();
    world.set_wheel_reference(id, WheelSpeeds { left_mps: -0.2, right_mps: -0.2 });
    place_after(&mut world, 1);
    assert!(!world.motion_in(&zone), "robots are not people");
    assert!(world.robot_motion_in(&zone));
}
