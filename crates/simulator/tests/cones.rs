//! An ideal sonar hears the nearest of everything in its cone: walls, legs of furniture, people and robots.
//!
//! Oracle: 4001 rays cast one by one into the same scene, by other code than that of cones.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{sync::Arc, time::Duration};

use geometry::{Polygon, Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use proptest::prelude::*;
use robot_models::{OdometryErrors, RobotModel};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{BodyId, PersonSpec, RobotPlacement, ThingKind, ThingSpec, World, WorldSpec};

const N_RAYS: i32 = 2000;

fn leg(i: usize, centre: Vec2, side_m: f64, yaw_rad: f64) -> ThingSpec {
    let place = Se2::new(centre.x, centre.y, yaw_rad);
    let corner = |x: f64, y: f64| place.transform_point(0.5 * side_m * Vec2::new(x, y));
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    ThingSpec {
        name: format!("leg-{i}"),
        kind: ThingKind::Furniture,
        polygon: Polygon::new(corners).unwrap(),
        material: 2,
        movable: false,
    }
}

fn placement(name: &str, at: Se2) -> RobotPlacement {
    RobotPlacement {
        name: name.to_owned(),
        model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
        world_from_base: at,
        errors: OdometryErrors::default(),
        sonar: SonarModel { range_min_m: 0.0, ..SonarModel::ideal() },
    }
}

/// The least distance along rays over the cone of a sonar, widened by `extra_rad` on both sides.
fn swept_m(world: &World, id: BodyId, sensor: usize, extra_rad: f64) -> f64 {
    let body = world.body(id);
    let at = (body.world_from_base * body.model.sonars[sensor].base_from_sensor).se2();
    let half_rad = 15_f64.to_radians() + extra_rad;
    let cast = |i: i32| {
        let yaw_rad = at.yaw_rad + half_rad * f64::from(i) / f64::from(N_RAYS);
        let ray = Ray { origin: at.position(), direction: Vec2::new(yaw_rad.cos(), yaw_rad.sin()) };
        world.scene(Some(id)).cast(&ray, 5.0).map_or(5.0, |hit| hit.distance_m)
    };
    (-N_RAYS..=N_RAYS).map(cast).fold(5.0, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_nearest_of_everything_in_the_cone_is_heard(
        legs in proptest::collection::vec((0.75..4.0, -3.1..3.1, 0.005..0.06, 0.0..1.5), 0..25),
        people in proptest::collection::vec((1.0..4.0, -3.1..3.1), 0..3),
        robots in proptest::collection::vec((1.2..3.5, -3.1..3.1, -3.0..3.0), 0..3),
        wall_m in 2.0..4.5,
    ) {
        let polar = |r: f64, a: f64| Vec2::new(r * a.cos(), r * a.sin());
        let wall = Segment { a: Vec2::new(wall_m, -6.0), b: Vec2::new(wall_m + 1.0, 6.0) };
        let mut spec = WorldSpec::of_walls(SegmentWorld::new([(wall, 0)]));
        let free = |p: Vec2| people.iter().all(|&(r, a)| (polar(r, a) - p).norm() > 0.3);
        for (i, &(r, a, side_m, yaw)) in legs.iter().enumerate() {
            if free(polar(r, a)) {
                spec.things.push(leg(i, polar(r, a), side_m, yaw));
            }
        }
        for (i, &(r, a)) in people.iter().enumerate() {
            let place = polar(r, a);
            spec.people.push(PersonSpec {
                name: format!("person-{i}"),
                route: vec![place],
                speed_mps: 0.0,
                starts_at: Stamp::ZERO,
                repeats: false,
                yields: true,
                radius_m: 0.25,
            });
        }
        let mut world = World::new(spec, RunSeed(1), Duration::from_millis(10)).unwrap();
        let id = world.add_robot(placement("rover", Se2::IDENTITY)).unwrap();
        for (i, &(r, a, yaw)) in robots.iter().enumerate() {
            let at = polar(r, a);
            // One that would stand in something is left out.
            let _taken = world.add_robot(placement(&format!("r{i}"), Se2::new(at.x, at.y, yaw)));
        }
        world.step();
        let mut rng = RunSeed(1).stream("sonar");
        let spacing_rad = 15_f64.to_radians() / f64::from(N_RAYS);
        for sensor in 0..16 {
            let echo = world.ping(id, sensor, &mut rng);
            let within = swept_m(&world, id, sensor, 0.0);
            let about = swept_m(&world, id, sensor, 2.0 * spacing_rad);
            prop_assert!(echo.range_m <= within + 1e-9, "{sensor}: {:?}, swept {}", echo, within);
            prop_assert!(echo.range_m >= about - 0.01, "{sensor}: {:?}, swept {}", echo, about);
            prop_assert!((echo.range_m - echo.nearest_in_cone_m).abs() < 1e-12);
        }
    }
}
