//! A drive through a hospital ward that nobody built, as a CARMEN log: what the map of the mission `ward-call` was made of.
//!
//! ```text
//! cargo run -p cairn_surveys --example ward_log > ward.clf
//! cairn map ward.clf --output ward
//! ```
//!
//! The ward is 16 m × 9 m with a corridor and six rooms. The laser has 181 beams of up to 12 m with a standard deviation
//! of 1 cm; odometry turns 1 % too far and drifts by 0.3° for each metre. Everything follows from one seed.
#![allow(
    clippy::print_stdout,
    clippy::allow_attributes,
    reason = "an example prints what it makes"
)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use geometry::{Ray, RayCaster as _, Se2, Segment, SegmentWorld, Vec2, wrap_to_pi};
use rand_core::Rng as _;
use run_context::{RandomStream, RunSeed};

const RANGE_MAX_M: f64 = 12.0;
const RANGE_STD_M: f64 = 0.01;
const STEP_M: f64 = 0.08;
const TURN_RAD: f64 = 0.12;

/// Walls and what stands there, corner after corner (m).
const LINES: [&[[f64; 2]]; 21] = [
    &[[0.0, 0.0], [16.0, 0.0], [16.0, 9.0], [0.0, 9.0], [0.0, 0.0]],
    // The corridor's south wall, with three doors.
    &[[0.0, 3.6], [2.0, 3.6]],
    &[[3.1, 3.6], [7.0, 3.6]],
    &[[8.1, 3.6], [12.0, 3.6]],
    &[[13.1, 3.6], [16.0, 3.6]],
    // Its north wall.
    &[[0.0, 5.4], [3.0, 5.4]],
    &[[4.1, 5.4], [8.0, 5.4]],
    &[[9.1, 5.4], [13.0, 5.4]],
    &[[14.1, 5.4], [16.0, 5.4]],
    // Between the rooms.
    &[[5.0, 0.0], [5.0, 3.6]],
    &[[10.0, 0.0], [10.0, 3.6]],
    &[[5.5, 5.4], [5.5, 9.0]],
    &[[11.0, 5.4], [11.0, 9.0]],
    // Beds against the outer walls, a desk that stands at an angle, a cupboard.
    &[[0.4, 0.0], [0.4, 2.0], [1.3, 2.0], [1.3, 0.0]],
    &[[8.8, 0.0], [8.8, 2.0], [9.7, 2.0], [9.7, 0.0]],
    &[[14.6, 0.0], [14.6, 2.0], [15.5, 2.0], [15.5, 0.0]],
    &[[0.5, 9.0], [0.5, 7.0], [1.4, 7.0], [1.4, 9.0]],
    &[[9.7, 9.0], [9.7, 7.0], [10.6, 7.0], [10.6, 9.0]],
    &[[5.6, 1.3], [6.7, 0.7], [7.0, 1.2], [5.9, 1.8], [5.6, 1.3]],
    &[[11.0, 7.4], [11.5, 7.4], [11.5, 8.6], [11.0, 8.6]],
    &[[0.0, 4.3], [0.25, 4.3], [0.25, 4.7], [0.0, 4.7]],
];
/// A column in the corridor: centre and radius (m).
const COLUMN: ([f64; 2], f64) = ([14.8, 4.9], 0.22);
/// Where the robot goes (m).
const ROUTE: [[f64; 2]; 22] = [
    [1.2, 4.5],
    [2.55, 4.3],
    [2.55, 2.0],
    [3.6, 1.4],
    [2.55, 4.3],
    [3.55, 4.7],
    [3.5, 7.0],
    [3.55, 4.7],
    [7.5, 4.4],
    [7.6, 2.4],
    [7.55, 4.4],
    [8.55, 4.7],
    [8.0, 7.2],
    [8.55, 4.7],
    [12.5, 4.3],
    [12.6, 2.0],
    [12.55, 4.3],
    [13.55, 4.6],
    [13.4, 7.2],
    [13.55, 4.6],
    [8.0, 4.5],
    [1.2, 4.5],
];

fn walls() -> SegmentWorld {
    let point = |[x, y]: [f64; 2]| Vec2::new(x, y);
    let straight = LINES.iter().flat_map(|line| line.windows(2));
    let straight = straight.map(|pair| Segment { a: point(pair[0]), b: point(pair[1]) });
    let around = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / 24.0).sin_cos();
        point(COLUMN.0) + Vec2::new(cos, sin) * COLUMN.1
    };
    let column = (0..24).map(|i| Segment { a: around(i), b: around(i + 1) });
    SegmentWorld::new(straight.chain(column).map(|segment| (segment, 0)))
}

/// A turn on the spot towards each corner, and the way to it.
fn drive() -> Vec<Se2> {
    let mut poses = vec![Se2::new(ROUTE[0][0], ROUTE[0][1], 0.0)];
    for &[x, y] in &ROUTE[1..] {
        let from = poses[poses.len() - 1];
        let way = Vec2::new(x, y) - from.position();
        let heading_rad = way.y.atan2(way.x);
        let turn_rad = wrap_to_pi(heading_rad - from.yaw_rad);
        let n_turns = (turn_rad.abs() / TURN_RAD).ceil().max(1.0);
        let turned = |i| from.yaw_rad + turn_rad * f64::from(i) / n_turns;
        poses.extend((1..=n_turns as u32).map(|i| Se2::new(from.x_m, from.y_m, turned(i))));
        let n_steps = (way.norm() / STEP_M).ceil().max(1.0);
        let at = |i| from.position() + way * (f64::from(i) / n_steps);
        poses.extend((1..=n_steps as u32).map(|i| Se2::new(at(i).x, at(i).y, heading_rad)));
    }
    poses
}

/// Nearly normal, with a standard deviation of 1: twelve even draws.
fn normal(rng: &mut RandomStream) -> f64 {
    (0..12).map(|_| f64::from(rng.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
}

fn main() {
    let world = walls();
    let mut rng = RunSeed(1).stream("ward");
    let poses = drive();
    let (mut odom, mut before) = (Se2::new(0.0, 0.0, 0.0), poses[0]);
    for (i, pose) in poses.iter().enumerate() {
        let step = before.inverse().compose(*pose);
        let drift_rad = 0.3_f64.to_radians() * step.position().norm();
        odom = odom.compose(Se2::new(step.x_m, step.y_m, 1.01 * step.yaw_rad + drift_rad));
        before = *pose;
        let range = |beam: u32| {
            let angle_rad = pose.yaw_rad - FRAC_PI_2 + PI / 180.0 * f64::from(beam);
            let direction = Vec2::new(angle_rad.cos(), angle_rad.sin());
            let hit = world.cast(&Ray { origin: pose.position(), direction }, RANGE_MAX_M);
            // What no beam finds has the range of this laser's silence.
            hit.map(|hit| hit.distance_m)
        };
        let ranges: Vec<String> = (0..181)
            .map(|beam| match range(beam) {
                Some(range_m) => format!("{:.3}", range_m + RANGE_STD_M * normal(&mut rng)),
                None => "81.83".to_owned(),
            })
            .collect();
        let place = format!("{:.5} {:.5} {:.6}", odom.x_m, odom.y_m, odom.yaw_rad);
        let time_s = 1_000_000.0 + 0.2 * i as f64;
        let ranges = ranges.join(" ");
        println!("FLASER 181 {ranges} {place} {place} {time_s:.3} ward {time_s:.3}");
    }
}
