//! One step of a mind: a report of the wheels with eight sonars, and a scan of a planar laser, in a corridor with posts.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up has to stop")]

use std::f64::consts::PI;

use divan::Bencher;
use geometry::{Base, Map, Odom, Ray, RayCaster, Se2, Segment, SegmentWorld, Transform2, Vec2};
use messages::{DeviceId, Observations, OdometryReading, Order, Sensed};
use navigator::{LaserMount, Method, Navigator, NavigatorConfig, NavigatorSettings};
use robot_models::{RobotModel, WheelSpeeds};
use run_context::Stamp;
use sensor_models::{BeamSight, PlanarScan, ScanBeam};

const LASER: DeviceId = DeviceId(1);
const RANGE_MAX_M: f64 = 8.0;

fn main() {
    divan::main();
}

/// A corridor 2.4 m wide with a post of 0.2 m every 2 m at its sides.
fn corridor() -> SegmentWorld {
    let segment = |x0, y0, x1, y1| Segment { a: Vec2::new(x0, y0), b: Vec2::new(x1, y1) };
    let mut walls = vec![segment(-3.0, 1.2, 60.0, 1.2), segment(-3.0, -1.2, 60.0, -1.2)];
    for k in 0..30 {
        let (x, side) = (2.0 * f64::from(k), if k % 2 == 0 { 1.2_f64 } else { -1.2 });
        let inner = side - 0.2 * side.signum();
        walls.push(segment(x, side, x, inner));
        walls.push(segment(x, inner, x + 0.2, inner));
        walls.push(segment(x + 0.2, inner, x + 0.2, side));
    }
    SegmentWorld::new(walls.into_iter().map(|wall| (wall, 0)))
}

fn scan(world: &SegmentWorld, pose: Se2, about: Stamp, n_beams: usize) -> PlanarScan {
    let beam = |k: usize| {
        let bearing_rad = PI * (k as f64 / (n_beams - 1) as f64 - 0.5);
        let direction = pose.rotate(Se2::new(0.0, 0.0, bearing_rad).heading());
        let hit = world.cast(&Ray { origin: pose.position(), direction }, RANGE_MAX_M);
        let sight = hit.map_or(BeamSight::NoReturn, |hit| BeamSight::Surface(hit.distance_m));
        ScanBeam { bearing_rad, after_s: 0.0, sight, strength_ratio: 0.0 }
    };
    PlanarScan {
        about,
        number: 0,
        range_min_m: 0.05,
        range_max_m: RANGE_MAX_M,
        beams: (0..n_beams).map(beam).collect(),
    }
}

/// Ten seconds of a robot that drives at 0.3 m/s towards a goal 50 m ahead: a hundred reports of its wheels, a hundred
/// scans, fifty control steps, a thousand calls.
#[divan::bench(args = [0, 361, 450])]
fn ten_seconds_of_a_mind(bencher: Bencher<'_, '_>, n_beams: usize) {
    let model = RobotModel::by_name("pioneer3dx").expect("a Pioneer");
    let mount = LaserMount { device: LASER, base_from_sensor: Se2::IDENTITY };
    let settings = NavigatorSettings {
        method: Method::Direct,
        sensors: Vec::new(),
        bubble_gains: Vec::new(),
        bubble_floors_m: Vec::new(),
        lasers: if n_beams > 0 { vec![mount] } else { Vec::new() },
        task_limit_s: 36_000.0,
        ..NavigatorSettings::for_robot(&model)
    };
    let config = NavigatorConfig::try_from(settings).expect("settings");
    let mut mind = Navigator::new(config, Transform2::<Map, Odom>::new(Se2::IDENTITY));
    let world = corridor();
    let ticks: Vec<Observations> = (0..1000_u64)
        .map(|tick| {
            let mut seen = Observations::new();
            let about = Stamp::from_millis(10 * tick);
            let pose = Se2::new(0.003 * tick as f64, 0.0, 0.0);
            if tick.is_multiple_of(10) {
                let wheel_speeds = WheelSpeeds { left_mps: 0.3, right_mps: 0.3 };
                let odom_from_base = Transform2::<Odom, Base>::new(pose);
                let odometry = OdometryReading { odom_from_base, wheel_speeds, moving: true };
                seen.push(about, Sensed::Odometry(odometry));
            }
            if tick % 10 == 5 && n_beams > 0 {
                seen.push_scan(LASER, &scan(&world, pose, about, n_beams));
            }
            seen
        })
        .collect();
    let goal_in_map = Transform2::<Map, Base>::new(Se2::new(50.0, 0.0, 0.0));
    let mut go = Observations::new();
    go.push(Stamp::ZERO, Sensed::Order(Order::GoTo { goal_in_map }));
    let mut commands = Vec::with_capacity(64);
    mind.step(Stamp::ZERO, &go, &mut commands);
    bencher.with_inputs(|| mind.clone()).bench_local_values(|mut mind| {
        for (tick, seen) in (0_u64..).zip(&ticks) {
            commands.clear();
            mind.step(Stamp::from_millis(10 * tick), seen, &mut commands);
        }
        mind
    });
}
