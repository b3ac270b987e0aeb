//! Small recordings made by arithmetic, for tests and examples: a room whose walls and poses are known exactly.

use std::{
    f64::consts::{FRAC_PI_2, PI, TAU},
    fmt::Write as _,
};

use geometry::{Ray, RayCaster as _, Se2, Segment, SegmentWorld, Vec2};
use recordings::{LaserRig, Recording, Rig, RingRig, Scan, StampedPose};
use run_context::Stamp;

/// Between two scans, milliseconds.
const PERIOD_MS: u64 = 200;
/// Farther walls are not seen, metres.
const RANGE_MAX_M: f64 = 20.0;

/// A room of 8 m × 6 m with a cupboard and a partition, driven through twice on an ellipse, with a laser of 181 beams.
/// Odometry drifts by about 2°/m; the truth is exact.
pub fn room(n_scans: usize) -> Recording {
    let laser = LaserRig {
        base_from_sensor: Se2::IDENTITY,
        first_beam_rad: -FRAC_PI_2,
        beam_spacing_rad: PI / 180.0,
        n_beams: 181,
        range_max_m: RANGE_MAX_M,
    };
    let bearings = (0..laser.n_beams).map(|i| laser.bearing_rad(i)).collect::<Vec<_>>();
    let world = walls();
    drive(n_scans, Rig::Laser(laser.clone()), |pose| {
        let sensor = pose.compose(laser.base_from_sensor);
        bearings.iter().map(|&b| range_m(&world, sensor.compose(Se2::new(0.0, 0.0, b)))).collect()
    })
}

/// The same room and way with eight sonars, whose cones see the nearest wall within 15° that is not too slanted.
pub fn sonar_room(n_scans: usize) -> Recording {
    let faces_deg = [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0_f64];
    let mount = |deg: f64| {
        let bearing_rad = deg.to_radians();
        Se2::new(0.15 * bearing_rad.cos(), 0.15 * bearing_rad.sin(), bearing_rad)
    };
    let ring = RingRig {
        base_from_sensors: faces_deg.map(mount).to_vec(),
        half_angle_rad: 15.0_f64.to_radians(),
        range_min_m: 0.1,
        range_max_m: 5.0,
    };
    let world = walls();
    let range_max_m = ring.range_max_m;
    drive(n_scans, Rig::Ring(ring.clone()), |pose| {
        let echo = |mount: &Se2| {
            let face = pose.compose(*mount);
            let beam = |i: i32| face.compose(Se2::new(0.0, 0.0, f64::from(i).to_radians()));
            let nearest =
                (-15..=15).map(|i| range_m(&world, beam(i))).fold(f64::INFINITY, f64::min);
            if nearest < range_max_m { nearest } else { f64::INFINITY }
        };
        ring.base_from_sensors.iter().map(echo).collect()
    })
}

fn drive(n_scans: usize, rig: Rig, see: impl Fn(Se2) -> Vec<f64>) -> Recording {
    let mut scans = Vec::new();
    let mut truth = Vec::new();
    let mut odom = Se2::IDENTITY;
    let mut before = None;
    for i in 0..n_scans {
        let stamp = Stamp::from_millis(i as u64 * PERIOD_MS);
        let pose = pose(2.0 * TAU * i as f64 / n_scans.max(1) as f64);
        if let Some(before) = before.replace(pose) {
            let step = before.inverse().compose(pose);
            let drift_rad = 2.0_f64.to_radians() * step.position().norm();
            odom = odom.compose(Se2::new(1.01 * step.x_m, step.y_m, step.yaw_rad + drift_rad));
        }
        scans.push(Scan {
            stamp,
            odom_from_base: Some(odom),
            ranges_m: see(pose),
            stamps: Vec::new(),
        });
        truth.push(StampedPose { stamp, pose });
    }
    Recording {
        rig,
        scans,
        odometry: Vec::new(),
        reference: Vec::new(),
        truth,
        extra_columns_m: Vec::new(),
        epoch_ns: 0,
    }
}

/// Where the robot is after a part of the ellipse.
fn pose(angle_rad: f64) -> Se2 {
    let (sin, cos) = angle_rad.sin_cos();
    let heading_rad = (1.6 * cos).atan2(-2.4 * sin);
    Se2::new(4.0 + 2.4 * cos, 3.0 + 1.6 * sin, heading_rad)
}

/// The walls of the room, in the frame of the truth; the first pose of its recordings is the origin of their map.
pub fn walls() -> SegmentWorld {
    let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [0.0, 6.0], [0.0, 0.0]];
    let cupboard = [[0.0, 2.0], [0.8, 2.0], [0.8, 3.1], [0.0, 3.1]];
    let partition = [[5.2, 6.0], [5.2, 5.3], [5.4, 5.3], [5.4, 6.0]];
    let table = [[3.7, 2.8], [4.4, 2.8], [4.4, 3.3], [3.7, 3.3], [3.7, 2.8]];
    let point = |[x, y]: [f64; 2]| Vec2::new(x, y);
    let lines: [&[[f64; 2]]; 4] = [&corners, &cupboard, &partition, &table];
    let segments = lines.iter().flat_map(|line| line.windows(2));
    let segment = |pair: &[[f64; 2]]| (Segment { a: point(pair[0]), b: point(pair[1]) }, 0);
    SegmentWorld::new(segments.map(segment).collect::<Vec<_>>())
}

fn range_m(world: &SegmentWorld, beam: Se2) -> f64 {
    let ray = Ray { origin: beam.position(), direction: beam.heading() };
    world.cast(&ray, RANGE_MAX_M).map_or(f64::INFINITY, |hit| hit.distance_m)
}

/// The recording as a CARMEN log with raw odometry in both places of the pose.
pub fn to_carmen(recording: &Recording) -> String {
    let mut text = String::from("# made by arithmetic\n");
    for scan in &recording.scans {
        let odom = scan.odom_from_base.unwrap_or(Se2::IDENTITY);
        let ranges = scan.ranges_m.iter().map(|&r| format!("{:.4}", r.min(81.83)));
        let ranges: Vec<String> = ranges.collect();
        let pose = format!("{:.6} {:.6} {:.6}", odom.x_m, odom.y_m, odom.yaw_rad);
        let time = format!("{:.6}", scan.stamp.as_secs_f64() + 1_000_000.0);
        let (n, ranges) = (ranges.len(), ranges.join(" "));
        // Writing to a string cannot fail.
        let _infallible = writeln!(text, "FLASER {n} {ranges} {pose} {pose} {time} room {time}");
    }
    text
}
