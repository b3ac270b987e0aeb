//! Tests of wall following: single steps, and a drive around a room by an ideal robot.

use geometry::Segment;
use std::f64::consts::PI;

use super::*;

/// The eight front sonars of the thesis's robot.
fn mounts() -> [Se2; 8] {
    [
        (0.069, 0.136, 90.0_f64),
        (0.114, 0.119, 50.0),
        (0.148, 0.078, 30.0),
        (0.166, 0.027, 10.0),
        (0.166, -0.027, -10.0),
        (0.148, -0.078, -30.0),
        (0.114, -0.119, -50.0),
        (0.069, -0.136, -90.0),
    ]
    .map(|(x, y, deg)| Se2::new(x, y, deg.to_radians()))
}

/// Ideal ranges in a set of walls, by intersecting lines.
fn readings(walls: &[Segment], world_from_base: Se2) -> Vec<RangeReading> {
    let range = |mount: Se2| {
        let sensor = world_from_base.compose(mount);
        let (o, d) = (sensor.position(), sensor.heading());
        walls.iter().fold(5.0_f64, |nearest, wall| {
            let s = wall.b - wall.a;
            let denominator = d.perp(&s);
            let (t, u) = ((wall.a - o).perp(&s) / denominator, (wall.a - o).perp(&d) / denominator);
            if t > 0.0 && (0.0..=1.0).contains(&u) { nearest.min(t) } else { nearest }
        })
    };
    mounts().iter().map(|&m| RangeReading { base_from_sensor: m, range_m: range(m) }).collect()
}

fn room(width: f64, height: f64) -> Vec<Segment> {
    let c =
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)].map(|(x, y)| Vec2::new(x, y));
    (0..4).map(|i| Segment { a: c[i], b: c[(i + 1) % 4] }).collect()
}

fn follower(side: Side) -> WallFollower {
    WallFollower::new(WallFollowerConfig::along(side)).unwrap()
}

fn drive(pose: Se2, wheels: WheelReference, dt_s: f64) -> Se2 {
    let (v, w) = (wheels.linear_mps(), wheels.angular_radps(0.38));
    let middle = pose.yaw_rad + 0.5 * w * dt_s;
    Se2::new(
        pose.x_m + v * dt_s * middle.cos(),
        pose.y_m + v * dt_s * middle.sin(),
        pose.yaw_rad + w * dt_s,
    )
}

#[test]
fn settles_at_its_distance_from_near_and_far_on_both_sides() {
    let wall = [Segment { a: Vec2::new(-50.0, 0.0), b: Vec2::new(50.0, 0.0) }];
    for (side, sign) in [(Side::Right, 1.0), (Side::Left, -1.0)] {
        for (start_m, yaw_rad) in [(0.4, 0.0), (1.2, 0.0), (0.7, 0.4), (0.7, -0.4)] {
            let mut pose = Se2::new(0.0, sign * start_m, yaw_rad);
            for _ in 0..300 {
                let wheels = follower(side).step(&readings(&wall, pose), 0.3);
                pose = drive(pose, wheels, 0.1);
            }
            assert!(
                (pose.y_m.abs() - 0.6).abs() < 0.02,
                "{side:?} from {start_m}, {yaw_rad}: {pose:?}"
            );
            assert!(pose.yaw_rad.abs() < 0.02 && pose.x_m > 7.0, "{pose:?}");
        }
    }
}

/// Once around a room of 6 m by 4 m, four inner corners, never nearer than 0.3 m to a wall.
#[test]
fn goes_around_a_room_without_touching_it() {
    for (side, turn) in [(Side::Right, 1.0), (Side::Left, -1.0)] {
        let walls = room(6.0, 4.0);
        let mut pose = Se2::new(3.0, 2.0 - turn * 1.4, 0.0);
        let (mut turned, mut nearest) = (0.0, f64::INFINITY);
        for _ in 0..1000 {
            let wheels = follower(side).step(&readings(&walls, pose), 0.3);
            turned += wheels.angular_radps(0.38) * 0.1;
            pose = drive(pose, wheels, 0.1);
            nearest = nearest.min(pose.x_m).min(pose.y_m).min(6.0 - pose.x_m).min(4.0 - pose.y_m);
        }
        assert!(turn * turned > 2.0 * PI, "{side:?} turned {turned}");
        assert!(nearest > 0.3, "{side:?} came as near as {nearest}");
    }
}

#[test]
fn mirrored_readings_swap_the_wheels() {
    let walls = room(6.0, 4.0);
    for (x, y, yaw) in [(1.0, 0.7, 0.3), (5.2, 0.8, 0.1), (3.0, 0.4, -0.2), (3.0, 2.0, 0.0)] {
        let here = follower(Side::Right).step(&readings(&walls, Se2::new(x, y, yaw)), 0.3);
        let there = follower(Side::Left).step(&readings(&walls, Se2::new(x, 4.0 - y, -yaw)), 0.3);
        assert!((here.left_mps - there.right_mps).abs() < 1e-9, "{here:?} {there:?}");
        assert!((here.right_mps - there.left_mps).abs() < 1e-9, "{here:?} {there:?}");
    }
}

#[test]
fn without_a_wall_it_looks_for_one_on_its_side() {
    let wheels = follower(Side::Left).step(&[], 0.3);
    assert!((wheels.angular_radps(0.38) - 0.5).abs() < 1e-9, "an arc of 0.6 m radius");
    assert!(follower(Side::Right).step(&[], 0.3).angular_radps(0.38) < 0.0);
    let silent = mounts().map(|m| RangeReading { base_from_sensor: m, range_m: f64::NAN });
    assert_eq!(follower(Side::Left).step(&silent, 0.3), wheels);
}

#[test]
fn settings_out_of_range_are_named() {
    let config = WallFollowerConfig { distance_m: 0.0, ..WallFollowerConfig::along(Side::Left) };
    let refused = WallFollower::new(config).unwrap_err().to_string();
    assert_eq!(refused, "distance_m = 0: must be from 0.1 to 5 m");
}
