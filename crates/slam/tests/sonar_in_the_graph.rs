//! Sonar with submaps in a graph: laps of a flat whose walls are known, with drifting wheels.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as they do")]

use std::f64::consts::FRAC_PI_2;

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use recordings::{RingRig, Scan};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use slam::{
    evaluate::{Errors, absolute_errors},
    sonar_graph::{SonarGraph, SonarGraphConfig},
};

const RANGE_MAX_M: f64 = 5.0;

/// A room of 7 × 5 m with a cupboard, a niche and a pillar.
fn flat() -> SegmentWorld {
    let mut walls = Vec::new();
    let mut add = |corners: &[(f64, f64)]| {
        for pair in corners.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|(x, y)| Vec2::new(x, y));
            walls.push((Segment { a, b }, 0));
        }
    };
    add(&[(0.0, 0.0), (3.0, 0.0), (3.0, -0.5), (4.2, -0.5), (4.2, 0.0), (7.0, 0.0)]);
    add(&[(7.0, 0.0), (7.0, 5.0), (1.5, 5.0), (1.5, 4.4), (0.0, 4.4), (0.0, 0.0)]);
    add(&[(2.6, 2.0), (4.4, 2.0), (4.4, 3.0), (2.6, 3.0), (2.6, 2.0)]);
    SegmentWorld::new(walls)
}

fn ring() -> RingRig {
    let mounts = [90.0_f64, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0];
    let mount = |deg: f64| {
        let yaw_rad = deg.to_radians();
        Se2::new(0.15 * yaw_rad.cos(), 0.15 * yaw_rad.sin(), yaw_rad)
    };
    RingRig {
        base_from_sensors: mounts.map(mount).to_vec(),
        half_angle_rad: 15.0_f64.to_radians(),
        range_min_m: 0.15,
        range_max_m: RANGE_MAX_M,
    }
}

/// Two laps along the walls, 5 cm or 5° at a time.
fn truth() -> Vec<Se2> {
    let mut poses = vec![Se2::new(1.2, 1.0, 0.0)];
    for side_m in [4.7, 2.7, 4.7, 2.7].repeat(2) {
        for _ in 0..(side_m / 0.05_f64).round() as usize {
            poses.push(poses[poses.len() - 1].compose(Se2::new(0.05, 0.0, 0.0)));
        }
        for _ in 0..18 {
            poses.push(poses[poses.len() - 1].compose(Se2::new(0.0, 0.0, FRAC_PI_2 / 18.0)));
        }
    }
    poses
}

/// Rows along the truth, with odometry that turns by `drift_radpm` too much for each metre.
fn rows(drift_radpm: f64) -> Vec<Scan> {
    let (world, truth, ring) = (flat(), truth(), ring());
    let sonar = SonarModel { range_max_m: RANGE_MAX_M, ..SonarModel::default() };
    let materials = sensor_models::materials();
    let mut rng = RunSeed(5).stream("ring");
    let mut odom = truth[0];
    let mut rows = Vec::new();
    for (i, pose) in truth.iter().enumerate() {
        if i > 0 {
            let step = truth[i - 1].inverse().compose(*pose);
            let drift_rad = drift_radpm * step.position().norm();
            odom = odom.compose(step).compose(Se2::new(0.0, 0.0, drift_rad));
        }
        let hear =
            |mount: &Se2| sonar.ping(pose.compose(*mount), &world, materials, &mut rng).range_m;
        rows.push(Scan {
            stamp: Stamp::from_millis(250 * i as u64),
            odom_from_base: Some(odom),
            ranges_m: ring.base_from_sensors.iter().map(hear).collect(),
            stamps: Vec::new(),
        });
    }
    rows
}

fn run(rows: &[Scan]) -> SonarGraph {
    let mut slam = SonarGraph::new(&ring(), SonarGraphConfig::default()).unwrap();
    for row in rows {
        slam.step(row).unwrap();
    }
    slam.finish().unwrap();
    slam
}

/// Errors of odometry and of the graph at the rows that the graph placed.
fn judged(slam: &SonarGraph, rows: &[Scan]) -> (Errors, Errors) {
    let truth = truth();
    let (mut placed, mut odometry, mut known) = (Vec::new(), Vec::new(), Vec::new());
    for row in slam.trajectory() {
        let i = rows.iter().position(|scan| scan.stamp == row.stamp).unwrap();
        placed.push(row.pose);
        odometry.extend(rows[i].odom_from_base);
        known.push(truth[i]);
    }
    (absolute_errors(&odometry, &known), absolute_errors(&placed, &known))
}

#[test]
fn loops_hold_a_drifting_robot_in_its_room() {
    for drift_radpm in [0.02, -0.02] {
        let rows = rows(drift_radpm);
        let slam = run(&rows);
        let (before, after) = judged(&slam, &rows);
        assert!(after.n > rows.len() / 2, "{} of {} rows placed", after.n, rows.len());
        assert!(before.rms_m > 0.3, "{before:?}");
        assert!(after.rms_m < 0.25 * before.rms_m, "{after:?} of {before:?}");
        assert!(!slam.loops().is_empty(), "{} tries, no loop", slam.n_tried());
        assert!(slam.map().unwrap().bounds().is_some());
    }
}

#[test]
fn without_drift_loops_do_no_harm() {
    let rows = rows(0.0);
    let (_, after) = judged(&run(&rows), &rows);
    assert!(after.rms_m < 0.05, "{after:?}");
}

#[test]
fn the_same_rows_give_the_same_bits() {
    let mut rows = rows(0.01);
    rows.truncate(400);
    let bits = |slam: &SonarGraph| -> Vec<[u64; 3]> {
        let poses = slam.trajectory();
        poses.iter().map(|p| [p.pose.x_m, p.pose.y_m, p.pose.yaw_rad].map(f64::to_bits)).collect()
    };
    assert_eq!(bits(&run(&rows)), bits(&run(&rows)));
}
