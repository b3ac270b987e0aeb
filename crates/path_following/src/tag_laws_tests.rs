//! Tests of the laws for tags, with an ideal robot.

use geometry::{Se2, Twist};

use super::*;

const B_M: f64 = 0.38;

/// Readers of the ideal robot of these tests: left and right (m, base frame).
const READERS_M: [(f64, f64); 2] = [(0.18, 0.125), (0.18, -0.125)];

fn follower() -> TagFollower {
    TagFollower::new(TagFollowerConfig::default()).unwrap()
}

/// A tag under each reader, read in every step of 10 ms: the nearest on a grid of 0.1 m, if within 6 cm.
fn drive(start: Se2, strength: impl Fn(Vec2) -> u8, way_m: f64) -> Vec<Se2> {
    let mut follower = follower();
    let (mut pose, mut poses) = (start, Vec::new());
    let mut wheels = WheelReference::STOP;
    let mut driven_m = 0.0;
    for step in 0..20_000 {
        for ((x, y), side) in READERS_M.into_iter().zip([Side::Left, Side::Right]) {
            let reader = pose.transform_point(Vec2::new(x, y));
            let tag = (reader * 10.0).map(f64::round) * 0.1;
            if (tag - reader).norm() <= 0.06 {
                follower.read(side, strength(tag));
            }
        }
        if step % 20 == 0 {
            wheels = match follower.step(0.3) {
                TagStep::Drive(wheels) => wheels,
                TagStep::Lost(None) => WheelReference::straight(0.08),
                TagStep::Lost(Some(Side::Left)) => WheelReference { left_mps: 0.0, right_mps: 0.2 },
                TagStep::Lost(Some(Side::Right)) => {
                    WheelReference { left_mps: 0.2, right_mps: 0.0 }
                }
            };
        }
        let dx_m = 0.01 * wheels.linear_mps();
        let dyaw_rad = 0.01 * wheels.angular_radps(B_M);
        pose = pose.compose(Se2::exp(Twist { dx_m, dy_m: 0.0, dyaw_rad }));
        follower.roll(dx_m);
        poses.push(pose);
        driven_m += dx_m;
        if driven_m > way_m {
            break;
        }
    }
    poses
}

/// The profile of a trail three tags wide along the x axis, written out anew.
fn along_x(tag: Vec2) -> u8 {
    (200.0 * (1.0 - tag.y.abs() / 0.2)).max(0.0).round() as u8
}

#[test]
fn a_straight_trail_is_kept_from_both_sides_and_wherever_the_grid_lies() {
    for (y, yaw_rad) in [(0.0, 0.0), (0.1, 0.3), (-0.1, -0.3), (0.12, -0.5), (-0.12, 0.5)] {
        for shift_m in [0.0, 0.03, 0.05, 0.08] {
            // The grid is fixed to the origin, so the trail is shifted against it.
            let shifted = |tag: Vec2| along_x(tag - Vec2::new(0.0, shift_m));
            let way = drive(Se2::new(0.013, y + shift_m, yaw_rad), shifted, 6.0);
            let late = way.iter().filter(|pose| pose.x_m > 2.0);
            let worst_m = late.map(|p| (p.y_m - shift_m).abs()).fold(0.0, f64::max);
            assert!(worst_m < 0.05, "{y} {yaw_rad} {shift_m}: {worst_m}");
            assert!(way.last().unwrap().x_m > 5.0, "{y} {yaw_rad} {shift_m}");
        }
    }
}

/// A right angle to either side: lost for a moment, found by the side that smelled it last.
#[test]
fn a_right_angle_is_taken_to_the_left_and_to_the_right() {
    for side in [1.0, -1.0] {
        let corner = |tag: Vec2| {
            let tag = Vec2::new(tag.x, side * tag.y);
            let first_m = if tag.x <= 3.0 { tag.y.abs() } else { f64::INFINITY };
            let second_m = if tag.y >= 0.0 { (tag.x - 3.0).abs() } else { f64::INFINITY };
            let corner_m = (tag - Vec2::new(3.0, 0.0)).norm();
            let away_m = first_m.min(second_m).min(corner_m);
            (200.0 * (1.0 - away_m / 0.2)).max(0.0).round() as u8
        };
        let way = drive(Se2::new(0.0, 0.0, 0.0), corner, 6.5);
        let end = way.last().unwrap();
        assert!(side * end.y_m > 2.0 && (end.x_m - 3.0).abs() < 0.1, "{side}: {end:?}");
        let worst_m = way.iter().map(|p| p.x_m).fold(0.0, f64::max);
        assert!(worst_m < 3.4, "{worst_m}");
    }
}

#[test]
fn mirrored_reads_give_mirrored_wheels() {
    let wheels = |left: u8, right: u8| {
        let mut follower = follower();
        follower.read(Side::Left, left);
        follower.read(Side::Right, right);
        follower.roll(0.03);
        match follower.step(0.3) {
            TagStep::Drive(wheels) => wheels,
            TagStep::Lost(_) => panic!("there is a trail"),
        }
    };
    for (left, right) in [(200, 200), (200, 100), (100, 0), (30, 180)] {
        let (one, other) = (wheels(left, right), wheels(right, left));
        assert!((one.left_mps - other.right_mps).abs() < 1e-12, "{left} {right}");
        assert_eq!(one.right_mps > one.left_mps, left > right, "{left} {right}");
    }
}

#[test]
fn a_trail_is_lost_on_white_tags_and_without_any_tag() {
    let mut white = follower();
    white.read(Side::Left, 100);
    white.read(Side::Right, 0);
    white.roll(0.1);
    assert!(matches!(white.step(0.3), TagStep::Drive(_)));
    white.read(Side::Left, 0);
    assert_eq!(white.step(0.3), TagStep::Lost(Some(Side::Left)), "one white tag is enough");
    white.roll(0.41);
    assert_eq!(white.step(0.3), TagStep::Lost(None), "the side is forgotten");

    let mut silent = follower();
    silent.read(Side::Left, 100);
    silent.read(Side::Right, 100);
    silent.roll(0.29);
    assert!(matches!(silent.step(0.3), TagStep::Drive(_)), "a missing tag or two are held over");
    silent.roll(0.02);
    assert_eq!(silent.step(0.3), TagStep::Lost(None));
    assert!(!silent.smells());
}

/// What is left of a step after the smoothing length is 1/e, however the way is cut.
#[test]
fn antennas_smooth_over_the_way() {
    for n in [1, 7, 50] {
        let mut follower = follower();
        follower.read(Side::Left, 200);
        (0..n).for_each(|_| follower.roll(0.05 / f64::from(n)));
        let expected = 200.0 * (1.0 - (-1.0_f64).exp());
        assert!((follower.levels()[0] - expected).abs() < 1e-9, "{n}: {:?}", follower.levels());
    }
}

#[test]
fn settings_outside_their_ranges_are_refused() {
    let default = TagFollowerConfig::default();
    for config in [
        TagFollowerConfig { smooth_m: 0.0, ..default },
        TagFollowerConfig { hold_m: f64::NAN, ..default },
        TagFollowerConfig { wheel_speed_max_mps: 11.0, ..default },
        TagFollowerConfig { fuzzy: FuzzyConfig { error_full: 0.0, ..default.fuzzy }, ..default },
    ] {
        assert!(TagFollower::new(config).is_err(), "{config:?}");
    }
}

/// The arc that is driven leads through the point: checked by driving it.
#[test]
fn a_pursued_point_is_reached() {
    for (x, y) in [(0.5, 0.0), (0.5, 0.2), (0.4, -0.35), (0.1, 0.3)] {
        let target = Vec2::new(x, y);
        let wheels = pursue(target, 0.3, 0.1, B_M);
        let twist = Twist {
            dx_m: 0.001 * wheels.linear_mps(),
            dy_m: 0.0,
            dyaw_rad: 0.001 * wheels.angular_radps(B_M),
        };
        let mut pose = Se2::IDENTITY;
        let mut nearest_m = f64::INFINITY;
        for _ in 0..6000 {
            pose = pose.compose(Se2::exp(twist));
            nearest_m = nearest_m.min((pose.position() - target).norm());
        }
        assert!(nearest_m < 1e-3, "({x}, {y}): {nearest_m}");
    }
    let behind =
        [pursue(Vec2::new(-1.0, 0.1), 0.3, 0.2, B_M), pursue(Vec2::new(-1.0, -0.1), 0.3, 0.2, B_M)];
    for (wheels, sign) in behind.into_iter().zip([1.0, -1.0]) {
        assert!((wheels.angular_radps(B_M) - sign * 0.3 / 0.2).abs() < 1e-12);
    }
}
