//! Files of poses and relations.
#![expect(clippy::float_cmp, reason = "these values are read, not computed")]

use super::*;
use expect_test::expect;

fn at(nanos: u64, x_m: f64, y_m: f64, yaw_rad: f64) -> StampedPose {
    StampedPose { stamp: Stamp::from_nanos(nanos), pose: Se2::new(x_m, y_m, yaw_rad) }
}

#[test]
fn a_trajectory_is_written_with_every_nanosecond() {
    let poses = [at(0, 1.5, -2.0, 0.0), at(123_456_789, 0.0, 0.25, std::f64::consts::FRAC_PI_2)];
    let text = write_tum(&poses, 1_464_602_099_941_193_001);
    expect![[r#"
        1464602099.941193001 1.5 -2 0 0 0 0 1
        1464602100.064649790 0 0.25 0 0 0 0.7071067811865475 0.7071067811865476
    "#]]
    .assert_eq(&text);
    let found = read_poses("t.tum", text.as_bytes()).unwrap();
    assert_eq!(found.epoch_ns, 1_464_602_099_941_193_001);
    assert!(found.complaints.is_empty());
    for (found, wanted) in found.poses.iter().zip(&poses) {
        assert_eq!(found.stamp, wanted.stamp);
        assert_eq!(found.pose.position(), wanted.pose.position());
        assert!((found.pose.yaw_rad - wanted.pose.yaw_rad).abs() < 1e-15);
    }
    assert_eq!(write_tum(&[at(0, 0.0, 0.0, 0.0)], -958_593_000), "-0.958593000 0 0 0 0 0 0 1\n");
}

#[test]
fn bad_lines_of_poses_are_named() {
    let text = "# t x y yaw\n\
                2.0 1 1 0.5\n1.0 0 0 7\n3.0 0 0\n4 0 0 0 0\nx 0 0 0\n5 nan 0 0\n\
                6 0 0 0 0 0 0 0\n7 0 0 0 0 0 1 0\n8 0 0 0 0 0 0 1 9\n9 0 0 0 0.5 0.5 0.5 0.5\n";
    let found = read_poses("p", text.as_bytes()).unwrap();
    let places: Vec<_> = found.complaints.kept().iter().map(|c| (c.place, c.trouble)).collect();
    assert_eq!(
        places,
        [
            (Place::Line(4), Trouble::Truncated),
            (Place::Line(5), Trouble::Truncated),
            (Place::Line(6), Trouble::Unreadable),
            (Place::Line(7), Trouble::NotFinite),
            (Place::Line(8), Trouble::Unreadable),
            (Place::Line(10), Trouble::BeamCount),
            (Place::Line(3), Trouble::OutOfOrder),
        ]
    );
    let yaws: Vec<f64> = found.poses.iter().map(|p| p.pose.yaw_rad).collect();
    assert_eq!(found.epoch_ns, 1_000_000_000);
    assert!((yaws[0] - (7.0 - std::f64::consts::TAU)).abs() < 1e-12);
    assert_eq!(yaws[1], 0.5);
    assert_eq!(yaws[2], -std::f64::consts::PI, "half a turn, in [-π, π)");
    assert!((yaws[3] - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "turned over x, y and z");
    let error = read_poses("p", b"# nothing\n").unwrap_err();
    assert!(error.to_string().contains("t x y yaw"), "{error}");
}

#[test]
fn the_freiburg_relations_are_read() {
    let Some(path) = testkit::data_folder("relations/fr079.relations.gz") else { return };
    let found = read_relations("fr079", &std::fs::read(path).unwrap()).unwrap();
    assert!(found.complaints.is_empty(), "{}", found.complaints);
    assert_eq!(found.relations.len(), 1685);
    assert_eq!(
        found.relations[0],
        Relation {
            first_ns: 1_216_630_413_000,
            second_ns: 1_217_490_267_000,
            first_from_second: Se2 { x_m: 0.407_95, y_m: -0.016_33, yaw_rad: -0.069_62 },
        }
    );
}

#[test]
fn bad_relations_are_named() {
    let text =
        "1 2 0 0 0 0 0 0.5\n1 2 0 0\n1 2 0 0 0.5 0 0 0\n1 2 0 0 0 0 0 0 0\n1 2 inf 0 0 0 0 0\n";
    let found = read_relations("r", text.as_bytes()).unwrap();
    let places: Vec<_> = found.complaints.kept().iter().map(|c| (c.place, c.trouble)).collect();
    assert_eq!(
        places,
        [
            (Place::Line(2), Trouble::Truncated),
            (Place::Line(3), Trouble::NotSupported),
            (Place::Line(4), Trouble::BeamCount),
            (Place::Line(5), Trouble::NotFinite),
        ]
    );
    assert_eq!(found.relations.len(), 2);
    assert!(matches!(read_relations("r", b"1 2"), Err(RecordingError::NoLines { .. })));
}

#[test]
fn the_simulators_truth_is_read() {
    let Some(path) = testkit::data_folder("laser/simul.rawlog.GT.txt") else { return };
    let found = read_poses("gt", &std::fs::read(path).unwrap()).unwrap();
    assert_eq!(found.poses.len(), 1734);
    assert!(found.complaints.is_empty(), "{}", found.complaints);
    assert_eq!(found.epoch_ns, 1_464_600_320_989_009_000);
}
