//! Two public logs of real buildings, against the trajectory that comes with them, in one configuration.
//!
//! `cargo run --release -p cairn_slam --example laser_logs` prints the figures for all of them.

#![expect(clippy::unwrap_used, reason = "a helper of tests may panic as they do")]

use geometry::Se2;
use recordings::{ReadOptions, Rig, read};
use slam::{
    evaluate::absolute_errors,
    laser::{LaserConfig, LaserSlam},
};

/// Mean distance to the log's reference trajectory after alignment, metres; `None` without the data.
fn mean_error_m(name: &str) -> Option<f64> {
    let path = testkit::data_folder(&format!("laser/{name}.clf.gz"))?;
    let bytes = std::fs::read(path).unwrap();
    let recording = read(name, &bytes, &ReadOptions::default()).unwrap().recording;
    let Rig::Laser(rig) = &recording.rig else { panic!("{name} was taken by a laser") };
    let mut slam = LaserSlam::new(rig.clone(), LaserConfig::default());
    for scan in &recording.scans {
        slam.step(scan);
    }
    slam.finish();
    let found: Vec<Se2> = slam.trajectory().iter().map(|p| p.pose).collect();
    let reference: Vec<Se2> = recording.reference.iter().map(|p| p.pose).collect();
    assert_eq!(found.len(), reference.len());
    Some(absolute_errors(&found, &reference).mean_m)
}

#[test]
fn seattle_with_its_lifted_robot_keeps_its_shape() {
    let Some(mean_m) = mean_error_m("seattle") else { return };
    assert!(mean_m < 0.06, "{mean_m} m");
}

#[test]
fn belgioioso_closes_its_loops() {
    let Some(mean_m) = mean_error_m("belgioioso") else { return };
    assert!(mean_m < 0.10, "{mean_m} m");
}
