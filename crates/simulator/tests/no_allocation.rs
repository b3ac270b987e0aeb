//! Once everything is in place, neither a step nor a ping asks the heap for anything.

use std::{sync::Arc, time::Duration};

use geometry::{Polygon, Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{PersonSpec, RobotPlacement, ThingKind, ThingSpec, World, WorldSpec};

#[test]
fn steps_pings_and_clearances_do_not_allocate() {
    let wall = |x1, y1, x2, y2| (Segment { a: Vec2::new(x1, y1), b: Vec2::new(x2, y2) }, 0);
    let spec = WorldSpec {
        static_map: SegmentWorld::new([wall(2.0, -3.0, 2.0, 3.0), wall(-4.0, -3.0, -4.0, 3.0)]),
        things: vec![ThingSpec {
            name: "crate".to_owned(),
            kind: ThingKind::Box,
            polygon: Polygon::rectangle(Vec2::new(-2.0, 1.0), Vec2::new(-1.5, 1.5)).unwrap(),
            material: 5,
            movable: true,
        }],
        people: vec![PersonSpec {
            name: "Ana".to_owned(),
            route: vec![Vec2::new(-3.0, -2.0), Vec2::new(1.0, -2.0)],
            speed_mps: 1.0,
            starts_at: Stamp::ZERO,
            repeats: true,
            yields: true,
            radius_m: 0.25,
        }],
    };
    let mut world = World::new(spec, RunSeed(1), Duration::from_millis(10)).unwrap();
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let errors = OdometryErrors { slip_std_ratio: 0.01, ..OdometryErrors::default() };
    let robots: Vec<_> = [(0.0, 0.0), (-1.2, 0.0), (0.0, -1.0)]
        .into_iter()
        .enumerate()
        .map(|(i, (x_m, y_m))| {
            let placement = RobotPlacement {
                name: format!("r{i}"),
                model: Arc::clone(&model),
                world_from_base: Se2::new(x_m, y_m, 0.0),
                errors,
                sonar: SonarModel::default(),
            };
            world.add_robot(placement).unwrap()
        })
        .collect();
    for &id in &robots {
        world.set_wheel_reference(id, WheelSpeeds { left_mps: 0.5, right_mps: 0.45 });
    }
    let mut rng = RunSeed(2).stream("test");
    world.step();

    let counted = allocation_counter::measure(|| {
        // Free driving, contact with the wall and with each other.
        for k in 0..2000 {
            world.step();
            for &id in &robots {
                world.ping(id, k % 16, &mut rng);
            }
            if k % 100 == 0 {
                assert!(world.clearance_m(robots[0]) <= 5.0);
            }
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(world.bodies().iter().any(|body| body.contacts > 0), "nothing was touched");
}
