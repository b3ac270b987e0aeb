//! What the world promises about motion, contact and sensing.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{sync::Arc, time::Duration};

use geometry::{Polygon, Se2, Segment, SegmentWorld, Vec2};
use proptest::prelude::*;
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, StateHash};
use sensor_models::{EchoCause, SonarModel};
use simulator::{
    BodyId, RobotPlacement, ThingId, ThingKind, ThingSpec, World, WorldError, WorldSpec,
};

const STEP: Duration = Duration::from_millis(10);

fn wall(x1: f64, y1: f64, x2: f64, y2: f64) -> (Segment, u32) {
    (Segment { a: Vec2::new(x1, y1), b: Vec2::new(x2, y2) }, 0)
}

fn room(half_m: f64) -> Vec<(Segment, u32)> {
    let h = half_m;
    vec![wall(-h, -h, h, -h), wall(h, -h, h, h), wall(h, h, -h, h), wall(-h, h, -h, -h)]
}

fn world_of(walls: Vec<(Segment, u32)>) -> World {
    World::new(WorldSpec::of_walls(SegmentWorld::new(walls)), RunSeed(1), STEP).unwrap()
}

fn placement(name: &str, x_m: f64, y_m: f64, yaw_rad: f64) -> RobotPlacement {
    RobotPlacement {
        name: name.to_owned(),
        model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
        world_from_base: Se2::new(x_m, y_m, yaw_rad),
        errors: OdometryErrors::default(),
        sonar: SonarModel::ideal(),
    }
}

fn add(world: &mut World, name: &str, x_m: f64, y_m: f64, yaw_rad: f64) -> BodyId {
    world.add_robot(placement(name, x_m, y_m, yaw_rad)).unwrap()
}

fn drive(world: &mut World, id: BodyId, left_mps: f64, right_mps: f64) {
    world.set_wheel_reference(id, WheelSpeeds { left_mps, right_mps });
}

fn steps(world: &mut World, n: usize) {
    (0..n).for_each(|_| world.step());
}

fn box_at(name: &str, x_m: f64, y_m: f64, half_m: f64) -> ThingSpec {
    let low = Vec2::new(x_m - half_m, y_m - half_m);
    let high = Vec2::new(x_m + half_m, y_m + half_m);
    ThingSpec {
        name: name.to_owned(),
        kind: ThingKind::Box,
        polygon: Polygon::rectangle(low, high).unwrap(),
        material: 5,
        movable: true,
    }
}

fn pose(world: &World, id: BodyId) -> Se2 {
    world.body(id).world_from_base.se2()
}

#[test]
fn a_start_from_rest_follows_the_acceleration() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    drive(&mut world, id, 0.3, 0.3);
    // 0.3 m/s² for a second: ½ a t² = 0.15 m; then a second at 0.3 m/s.
    steps(&mut world, 100);
    assert!((pose(&world, id).x_m - 0.15).abs() < 1e-9);
    steps(&mut world, 100);
    assert!((pose(&world, id).x_m - 0.45).abs() < 1e-9);
    assert_eq!(world.now().as_nanos(), 2_000_000_000);
    // 0.45 m in pulses of (3.2), rounded down.
    let per_tick_m = world.body(id).model.drive.metres_per_tick();
    let [left, right] = world.body(id).encoder_ticks;
    assert_eq!(left, right);
    assert!((0.45 / per_tick_m - left as f64).abs() <= 1.0, "{left}");
    // A stop takes another 0.15 m.
    drive(&mut world, id, 0.0, 0.0);
    steps(&mut world, 200);
    assert!((pose(&world, id).x_m - 0.60).abs() < 1e-9);
    assert!(world.body(id).wheel_speeds.is_zero());
}

#[test]
fn a_circle_of_known_radius_is_driven() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    world.set_acceleration(id, 1000.0);
    // R = (b/2)(v_R + v_L)/(v_R − v_L) = 0.38 m, (2.2); half a turn is at (0, 2 R).
    drive(&mut world, id, 0.1, 0.3);
    let half_turn_s = std::f64::consts::PI * 0.38 / 0.2;
    steps(&mut world, (half_turn_s * 100.0).round() as usize);
    let end = pose(&world, id);
    assert!((end.y_m - 0.76).abs() < 0.005 && end.x_m.abs() < 0.005, "{end:?}");
}

#[test]
fn an_entry_into_contact_counts_once_until_free_again() {
    let mut world = world_of(room(2.0));
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    drive(&mut world, id, 0.3, 0.3);
    steps(&mut world, 3000);
    let body = world.body(id);
    assert_eq!((body.contacts, body.touching, body.stalled), (1, true, [true, true]));
    assert!((pose(&world, id).x_m - 1.79).abs() < 1e-3);
    let counted = body.encoder_ticks[0] as f64 * body.model.drive.metres_per_tick();
    assert!((counted - 1.79).abs() < 2e-3, "stalled wheels do not count: {counted}");

    drive(&mut world, id, -0.3, -0.3);
    steps(&mut world, 200);
    assert_eq!((world.body(id).contacts, world.body(id).touching), (1, false));
    assert_eq!(world.body(id).stalled, [false, false]);

    drive(&mut world, id, 0.3, 0.3);
    steps(&mut world, 1000);
    assert_eq!(world.body(id).contacts, 2);
}

#[test]
fn the_side_that_touches_stalls() {
    for (y_m, stalled) in [(0.15, [true, false]), (-0.15, [false, true])] {
        // A post ahead of one side of the front.
        let mut world = world_of(vec![wall(1.0, y_m, 1.01, y_m), wall(-9.0, -9.0, -9.0, 9.0)]);
        let id = add(&mut world, "a", 0.0, 0.0, 0.0);
        drive(&mut world, id, 0.3, 0.3);
        steps(&mut world, 800);
        assert_eq!(world.body(id).stalled, stalled, "post at {y_m}");
        // Nobody asks the wheels to turn: no stall, still a contact.
        drive(&mut world, id, 0.0, 0.0);
        steps(&mut world, 2);
        assert_eq!(world.body(id).stalled, [false, false]);
        assert!(world.body(id).touching);
    }
}

#[test]
fn two_robots_stop_each_other_and_both_count() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    let a = add(&mut world, "a", -1.0, 0.0, 0.0);
    let b = add(&mut world, "b", 1.0, 0.0, std::f64::consts::PI);
    drive(&mut world, a, 0.3, 0.3);
    drive(&mut world, b, 0.3, 0.3);
    steps(&mut world, 1000);
    assert_eq!((world.body(a).contacts, world.body(b).contacts), (1, 1));
    let apart = pose(&world, b).x_m - pose(&world, a).x_m;
    assert!((apart - 0.42).abs() < 2e-3, "{apart}");
    assert!(world.clearance_m(a) < 2e-3);
}

#[test]
fn a_door_that_is_taken_away_lets_pass() {
    let mut world = world_of(vec![
        wall(1.0, -5.0, 1.0, -0.5),
        wall(1.0, 0.5, 1.0, 5.0),
        wall(-5.0, 5.0, 5.0, 5.0),
    ]);
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    let door = ThingSpec {
        kind: ThingKind::Door,
        polygon: Polygon::rectangle(Vec2::new(0.98, -0.5), Vec2::new(1.02, 0.5)).unwrap(),
        ..box_at("door", 0.0, 0.0, 1.0)
    };
    let door = world.place_thing(door).unwrap();
    drive(&mut world, id, 0.3, 0.3);
    steps(&mut world, 500);
    assert!((pose(&world, id).x_m - 0.77).abs() < 1e-3);
    assert!(world.remove_thing(door));
    assert!(!world.remove_thing(door));
    steps(&mut world, 500);
    assert!(pose(&world, id).x_m > 1.5);
    assert_eq!(world.body(id).contacts, 1);
}

#[test]
fn a_thing_is_not_put_onto_a_robot() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    add(&mut world, "rover", 0.0, 0.0, 0.0);
    let error = world.place_thing(box_at("crate", 0.3, 0.0, 0.2)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`crate` cannot be put at (0.300, 0.000) m: the robot `rover` is there"
    );
    assert!(world.things().is_empty());
    let placed = world.place_thing(box_at("crate", 0.5, 0.0, 0.2)).unwrap();
    assert_eq!(world.thing_by_name("crate"), Some(placed));
    let unknown = ThingSpec { material: 99, ..box_at("odd", 3.0, 0.0, 0.2) };
    assert_eq!(
        world.place_thing(unknown).unwrap_err().to_string(),
        "`odd`: material 99 is unknown: there are 8, counted from 0"
    );
    // Identities are never used twice.
    world.remove_thing(placed);
    assert_eq!(world.place_thing(box_at("crate", 0.5, 0.0, 0.2)).unwrap(), ThingId(1));
}

#[test]
fn a_robot_is_refused_where_it_cannot_stand() {
    let mut world = world_of(room(2.0));
    let refused = |world: &mut World, x_m, y_m| {
        world.add_robot(placement("r", x_m, y_m, 0.5)).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&mut world, 1.9, 0.0),
        "robot `r` cannot stand at (1.900, 0.000) m, 28.6 deg: its footprint meets a wall: \
         choose a free place"
    );
    assert_eq!(
        refused(&mut world, 4.5, 0.0),
        "robot `r` cannot stand at (4.500, 0.000) m: the walls reach from (-2.000, -2.000) to \
         (2.000, 2.000) m"
    );
    assert_eq!(
        refused(&mut world, f64::INFINITY, 0.0),
        "`r`: x_m = inf: must be a finite number within 1000 km"
    );
    world.place_thing(box_at("crate", -1.0, -1.0, 0.2)).unwrap();
    assert!(refused(&mut world, -1.0, -1.0).contains("meets the thing `crate`"));
    add(&mut world, "first", 0.0, 0.0, 0.0);
    assert!(refused(&mut world, 0.1, 0.1).contains("meets the robot `first`"));
    let again = world.add_robot(placement("first", 1.0, 1.0, 0.0)).unwrap_err();
    assert_eq!(again, WorldError::DuplicateName { name: "first".to_owned() });
    let broken = RobotPlacement {
        sonar: SonarModel { n_rays: 0, ..SonarModel::ideal() },
        ..placement("s", 1.0, 1.0, 0.0)
    };
    assert_eq!(
        world.add_robot(broken).unwrap_err().to_string(),
        "robot `s`: sonar.n_rays = 0: must be from 1 to 999"
    );
    assert_eq!(world.bodies().len(), 1, "a refusal changes nothing");
}

#[test]
fn steps_of_senseless_length_are_refused() {
    let new = |step| World::new(WorldSpec::empty(), RunSeed(1), step).map(|_| ());
    assert_eq!(
        new(Duration::ZERO).unwrap_err().to_string(),
        "time step of 0 ms: must be from 1 to 100 ms"
    );
    assert!(new(Duration::from_millis(101)).is_err());
    assert!(new(Duration::from_millis(100)).is_ok() && new(Duration::from_millis(1)).is_ok());
}

#[test]
fn a_lifted_robot_does_not_notice() {
    let mut world = world_of(room(3.0));
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    drive(&mut world, id, 0.3, 0.3);
    steps(&mut world, 100);
    let ticks = world.body(id).encoder_ticks;
    world.relocate_robot(id, Se2::new(-2.0, 1.0, 1.0)).unwrap();
    assert_eq!(world.body(id).encoder_ticks, ticks);
    assert!(world.relocate_robot(id, Se2::new(2.95, 0.0, 0.0)).is_err());
    assert!(world.relocate_robot(id, Se2::new(9.0, 0.0, 0.0)).is_err());
    assert_eq!(pose(&world, id), Se2::new(-2.0, 1.0, 1.0));
    // And the walls are where they were: nothing of the old place is remembered.
    world.relocate_robot(id, Se2::new(2.0, 0.0, 0.0)).unwrap();
    steps(&mut world, 500);
    assert!((pose(&world, id).x_m - 2.79).abs() < 1e-3);
}

#[test]
fn a_sonar_meets_walls_things_people_and_robots_but_not_its_own_body() {
    let mut world = world_of(room(3.0));
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    let mut rng = RunSeed(5).stream("test");
    // Sensor 0 looks left from y = 0.136; sensors 3 and 4 ahead by ±10 degrees.
    let wall_m = world.ping(id, 0, &mut rng);
    assert!((wall_m.range_m - 2.864).abs() < 1e-9, "{wall_m:?}");
    let thing = world.place_thing(box_at("crate", 0.069, 1.5, 0.25)).unwrap();
    assert!((world.ping(id, 0, &mut rng).range_m - 1.114).abs() < 1e-9);
    world.remove_thing(thing);
    add(&mut world, "b", 0.069, 1.2, 0.0);
    assert!((world.ping(id, 0, &mut rng).range_m - (1.2 - 0.2125 - 0.136)).abs() < 1e-9);
    // The rear ring's sensor 15 looks left too, and sees the same neighbour.
    assert!(world.ping(id, 15, &mut rng).range_m < 1.0);
    let missing = world.ping(id, 99, &mut rng);
    assert_eq!((missing.range_m, missing.cause), (5.0, EchoCause::Nothing));
}

#[test]
fn equal_seeds_give_equal_bits_and_strangers_disturb_nobody() {
    let run = |seed, with_stranger: bool| {
        let errors = OdometryErrors { slip_std_ratio: 0.02, ..OdometryErrors::default() };
        let spec = WorldSpec::of_walls(SegmentWorld::new(room(6.0)));
        let mut world = World::new(spec, RunSeed(seed), STEP).unwrap();
        if with_stranger {
            let stranger = RobotPlacement { errors, ..placement("stranger", -5.0, -5.0, 0.0) };
            world.add_robot(stranger).unwrap();
        }
        let id = world.add_robot(RobotPlacement { errors, ..placement("a", 0.0, 0.0, 0.3) });
        let id = id.unwrap();
        drive(&mut world, id, 0.25, 0.3);
        steps(&mut world, 500);
        let mut hash = StateHash::new();
        world.absorb_state(&mut hash);
        (hash.value(), pose(&world, id))
    };
    assert_eq!(run(1, false), run(1, false));
    assert_ne!(run(1, false).0, run(2, false).0);
    assert_eq!(run(1, false).1, run(1, true).1);
}

/// A crowd in a small room, driven about at random: an O(n²) judge finds no overlap, ever.
#[test]
fn a_crowd_never_overlaps() {
    let mut world = world_of(room(4.0));
    let mut ids = Vec::new();
    for i in 0..36 {
        let (column, row) = (i % 6, i / 6);
        let place = |k: i32| f64::from(k) * 1.2 - 3.0;
        ids.push(add(&mut world, &format!("r{i}"), place(column), place(row), f64::from(i)));
    }
    for &id in &ids {
        world.set_acceleration(id, 5.0);
    }
    for round in 0..40 {
        for (k, &id) in ids.iter().enumerate() {
            let phase = f64::from(round) * 1.7 + k as f64 * 0.9;
            drive(&mut world, id, 0.5 + phase.sin(), 0.5 + (phase * 1.3).cos());
        }
        steps(&mut world, 25);
        for (k, body) in world.bodies().iter().enumerate() {
            let outline = Polygon::new(body.footprint().to_vec()).unwrap();
            assert!(!world.static_map().touches_polygon(body.footprint()), "{} in wall", body.name);
            for other in &world.bodies()[k + 1..] {
                let theirs = Polygon::new(other.footprint().to_vec()).unwrap();
                let crosses = outline.edges().any(|e| theirs.edges().any(|f| e.intersects(f)));
                assert!(!crosses, "{} and {} overlap", body.name, other.name);
                assert!(!outline.contains(other.footprint()[0]));
            }
        }
    }
    let contacts: u64 = world.bodies().iter().map(|body| body.contacts).sum();
    assert!(contacts > 50, "the crowd hardly met: {contacts}");
}

fn random_walls() -> impl Strategy<Value = Vec<(Segment, u32)>> {
    let ends = (-3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0);
    let walls = ends.prop_map(|(x1, y1, x2, y2)| wall(x1, y1, x2, y2));
    proptest::collection::vec(walls, 1..12).prop_map(|walls| [walls, room(3.5)].concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_command_drives_a_footprint_into_a_wall(
        walls in random_walls(),
        commands in proptest::collection::vec((-2.5..2.5, -2.5..2.5), 1..12),
    ) {
        let mut world = world_of(walls);
        let Ok(id) = world.add_robot(placement("a", 0.0, 0.0, 0.7)) else { return Ok(()) };
        world.set_acceleration(id, 5.0);
        for (left_mps, right_mps) in commands {
            drive(&mut world, id, left_mps, right_mps);
            for _ in 0..40 {
                world.step();
                prop_assert!(!world.static_map().touches_polygon(world.body(id).footprint()));
            }
        }
    }

    /// The judge measures every footprint edge against every wall.
    #[test]
    fn clearance_is_the_distance_to_the_nearest_wall(
        walls in random_walls(), yaw in -3.0..3.0,
    ) {
        let mut world = world_of(walls.clone());
        let Ok(id) = world.add_robot(placement("a", 0.2, -0.1, yaw)) else { return Ok(()) };
        let outline = Polygon::new(world.body(id).footprint().to_vec()).unwrap();
        let expected = outline
            .edges()
            .flat_map(|edge| walls.iter().map(move |(wall, _)| edge.distance_to_segment(*wall)))
            .fold(f64::INFINITY, f64::min);
        let clearance = world.clearance_m(id);
        prop_assert!((clearance - expected).abs() <= 1e-9, "{clearance} {expected}");
    }
}

#[test]
fn clearance_sees_everything_and_ends_at_five_metres() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    let id = add(&mut world, "a", 0.0, 0.0, 0.0);
    assert!((world.clearance_m(id) - 5.0).abs() < 1e-12);
    add(&mut world, "b", 3.0, 0.0, 0.0);
    // Front 0.210, rear 0.301.
    assert!((world.clearance_m(id) - (3.0 - 0.511)).abs() < 1e-9);
    world.place_thing(box_at("crate", 0.0, -1.0, 0.3)).unwrap();
    assert!((world.clearance_m(id) - 0.4875).abs() < 1e-9);
}

#[test]
fn only_the_errors_part_the_truth_from_the_count() {
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), STEP).unwrap();
    let errors = OdometryErrors::unequal_diameters(0.01);
    let id = world.add_robot(RobotPlacement { errors, ..placement("a", 0.0, 0.0, 0.0) }).unwrap();
    world.set_acceleration(id, 1000.0);
    drive(&mut world, id, 0.5, 0.5);
    steps(&mut world, 2000);
    // The thesis, Fig. 3.2, with its b = 380 mm: 1308 mm to the side after 10 m.
    assert!((pose(&world, id).y_m - 1.308).abs() < 2e-3, "{:?}", pose(&world, id));
    let [left, right] = world.body(id).encoder_ticks;
    assert_eq!(left, right);
}
