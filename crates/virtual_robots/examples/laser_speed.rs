//! How many times real time 100 robots with 360 beams each can be simulated on one thread.
//!
//! `cargo run --release -p cairn_virtual_robots --example laser_speed [ROBOTS]`. All drive circles in a room of
//! 80 m with rows of pillars; ten scans a second, each beam fired from where its robot is then; wheels, contacts, and LD06
//! packets included.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "an example that measures and prints"
)]
#![expect(clippy::disallowed_methods, reason = "it measures real time")]

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::RunSeed;
use sensor_models::{LaserKind, LaserModel, SonarModel};
use simulator::{BodyId, RobotPlacement, World, WorldSpec};
use virtual_robots::{Board, LaserConfig, Port, laser_board};

const TICK: Duration = Duration::from_millis(10);

/// A room of 80 m, and pillars of half a metre every 8 m.
fn room() -> SegmentWorld {
    let square = |x: f64, y: f64, half: f64| {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(dx, dy)| Vec2::new(x + dx, y + dy));
        (0..4).map(move |i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0))
    };
    let pillars = (0..81).flat_map(|i| {
        let at = |k: i32| 8.0 * f64::from(k) - 32.0;
        square(at(i % 9), at(i / 9), 0.25)
    });
    SegmentWorld::new(square(0.0, 0.0, 40.0).chain(pillars))
}

fn main() {
    let n: usize = std::env::args().nth(1).map_or(100, |text| text.parse().unwrap());
    let mut world = World::new(WorldSpec::of_walls(room()), RunSeed(1), TICK).unwrap();
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let side = (n as f64).sqrt().ceil() as usize;
    let mut boards: Vec<(BodyId, Box<dyn Board>)> = Vec::new();
    for i in 0..n {
        let at = |k: usize| (k as f64 - 0.5 * (side - 1) as f64) * 3.2 + 0.9;
        let body = world
            .add_robot(RobotPlacement {
                name: format!("r{i}"),
                model: Arc::clone(&model),
                world_from_base: Se2::new(at(i % side), at(i / side), i as f64),
                errors: OdometryErrors::default(),
                sonar: SonarModel::default(),
            })
            .unwrap();
        world.set_wheel_reference(body, WheelSpeeds { left_mps: 0.25, right_mps: 0.35 });
        let laser = LaserModel {
            beam_spacing_rad: -1.0_f64.to_radians(),
            n_beams: 360,
            ..LaserKind::Ld06.model()
        };
        let config =
            LaserConfig { model: laser, ..LaserConfig::new(LaserKind::Ld06, Se2::IDENTITY) };
        boards.push((body, laser_board(config, RunSeed(1).stream(&format!("r{i}/laser")))));
    }
    let mut out = Vec::new();
    let mut run = |n_ticks: u32| {
        let (began, mut n_bytes) = (Instant::now(), 0);
        for _ in 0..n_ticks {
            for (body, board) in &mut boards {
                out.clear();
                let port = Port { received: &[], out: &mut out };
                board.step(world.now(), &world, *body, &mut [port]);
                n_bytes += out.len();
            }
            world.step();
        }
        (began.elapsed(), n_bytes)
    };
    run(100);
    let (took, n_bytes) = run(1000);
    let n_beams = n_bytes / 47 * 12;
    println!(
        "{n} robots, 360 beams, 10 scans/s: {:.1} times real time ({:.0} ns a beam, {n_beams} beams in {:.2} s)",
        10.0 / took.as_secs_f64(),
        1e9 * took.as_secs_f64() / n_beams as f64,
        took.as_secs_f64()
    );
}
