//! What a step of the world and a ping of a sonar cost.
//!
//! `cargo bench -p cairn_bench_suite --bench simulator`. A `world_step` with n robots is one call of
//! `World::step`: divide by n for the cost of a robot. The Columbia map (63 311 points, 470 lines)
//! is read from `$CAIRN_DATA` or `../shared/data`; without it, its benchmarks run in a plain room.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up has to stop")]

use std::{fs, io::Read, path::PathBuf, sync::Arc, time::Duration};

use divan::{Bencher, black_box};
use geometry::{Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::RunSeed;
use sensor_models::SonarModel;
use simulator::{BodyId, RobotPlacement, World, WorldSpec, activmedia_map};

fn main() {
    divan::main();
}

fn wall(x1: f64, y1: f64, x2: f64, y2: f64) -> (Segment, u32) {
    (Segment { a: Vec2::new(x1, y1), b: Vec2::new(x2, y2) }, 0)
}

fn room(half_m: f64) -> SegmentWorld {
    let h = half_m;
    SegmentWorld::new([
        wall(-h, -h, h, -h),
        wall(h, -h, h, h),
        wall(h, h, -h, h),
        wall(-h, h, -h, -h),
    ])
}

fn columbia() -> Option<SegmentWorld> {
    let default = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("CAIRN_DATA").map_or(default, PathBuf::from);
    let bytes = fs::read(folder.join("maps/columbia.map.gz")).ok()?;
    let mut text = String::new();
    flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).ok()?;
    Some(activmedia_map::parse(&text).ok()?.to_segment_world())
}

/// `n` robots in rows a metre apart, driving circles of their own.
fn crowd(walls: SegmentWorld, n: usize, errors: OdometryErrors) -> World {
    let spec = WorldSpec::of_walls(walls);
    let mut world = World::new(spec, RunSeed(1), Duration::from_millis(10)).unwrap();
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let side = (n as f64).sqrt().ceil() as usize;
    for i in 0..n {
        let at = |k: usize| (k as f64 - 0.5 * (side - 1) as f64) * 1.5;
        let placement = RobotPlacement {
            name: format!("r{i}"),
            model: Arc::clone(&model),
            world_from_base: Se2::new(at(i % side), at(i / side), i as f64),
            errors,
            sonar: SonarModel::default(),
        };
        let id = world.add_robot(placement).unwrap();
        let turn_mps = 0.02 * (i % 7) as f64;
        let reference = WheelSpeeds { left_mps: 0.3 - turn_mps, right_mps: 0.3 + turn_mps };
        world.set_wheel_reference(id, reference);
    }
    (0..100).for_each(|_| world.step());
    world
}

#[divan::bench(args = [1, 10, 100, 1000])]
fn world_step(bencher: Bencher<'_, '_>, n: usize) {
    let mut world = crowd(room(40.0), n, OdometryErrors::default());
    bencher.counter(divan::counter::ItemsCount::new(n)).bench_local(|| world.step());
}

#[divan::bench(args = [1000])]
fn world_step_with_slip(bencher: Bencher<'_, '_>, n: usize) {
    let errors = OdometryErrors { slip_std_ratio: 0.01, ..OdometryErrors::default() };
    let mut world = crowd(room(40.0), n, errors);
    bencher.counter(divan::counter::ItemsCount::new(n)).bench_local(|| world.step());
}

#[divan::bench]
fn world_step_in_columbia(bencher: Bencher<'_, '_>) {
    let mut world = crowd(columbia().unwrap_or_else(|| room(40.0)), 1, OdometryErrors::default());
    // On the spot, in a corridor: walls stay near.
    let spin = WheelSpeeds { left_mps: -0.2, right_mps: 0.2 };
    world.set_wheel_reference(BodyId(0), spin);
    bencher.bench_local(|| world.step());
}

#[divan::bench]
fn sonar_ping_in_columbia(bencher: Bencher<'_, '_>) {
    let world = crowd(columbia().unwrap_or_else(|| room(40.0)), 1, OdometryErrors::default());
    let mut rng = RunSeed(2).stream("bench");
    let mut sensor = 0;
    bencher.bench_local(|| {
        sensor = (sensor + 1) % 16;
        black_box(world.ping(BodyId(0), sensor, &mut rng))
    });
}

#[divan::bench]
fn sonar_ping_in_a_crowd(bencher: Bencher<'_, '_>) {
    let world = crowd(room(40.0), 1000, OdometryErrors::default());
    let mut rng = RunSeed(2).stream("bench");
    let mut sensor = 0;
    bencher.bench_local(|| {
        sensor = (sensor + 1) % 16;
        black_box(world.ping(BodyId(500), sensor, &mut rng))
    });
}

#[divan::bench]
fn clearance_in_columbia(bencher: Bencher<'_, '_>) {
    let world = crowd(columbia().unwrap_or_else(|| room(40.0)), 1, OdometryErrors::default());
    bencher.bench_local(|| black_box(world.clearance_m(BodyId(0))));
}
