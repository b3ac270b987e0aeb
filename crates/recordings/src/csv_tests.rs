//! CSV: back bit by bit, and the traps of its rows.

use super::*;
use crate::{Loaded, RingRig, read};
use expect_test::expect;
use proptest::prelude::*;
use run_context::Stamp;

const RIG_LINE: &str = "# rig: {\"kind\":\"ring\",\"base_from_sensors\":[[0.1,0,0],[0.1,0,1]],\
    \"half_angle_rad\":0.26,\"range_min_m\":0.1,\"range_max_m\":5}\n";
const HEADER: &str = "stamp_s,odom_x_m,odom_y_m,odom_yaw_rad,range_0_m,range_1_m\n";

fn loaded(text: &str) -> Loaded {
    read("x.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

#[test]
fn rows_are_scans_or_odometry() {
    let text = format!(
        "{RIG_LINE}{HEADER}# a remark\n\
         1700000000.25,0.1,0,0,1.35,inf\n\
         1700000000.3,0.12,0,0,,\n\
         1700000000.5,0.2,0,-0.5, 2 ,5.0\n"
    );
    let found = loaded(&text);
    assert_eq!(found.format, Format::Csv);
    assert!(found.complaints.is_empty(), "{}", found.complaints);
    let recording = found.recording;
    assert_eq!(recording.scans.len(), 2);
    assert_eq!(recording.odometry.len(), 1);
    assert_eq!(recording.scans[0].ranges_m, [1.35, f64::INFINITY]);
    assert_eq!(recording.scans[1].ranges_m, [2.0, 5.0], "a ring keeps its numbers");
    assert!(!recording.rig.is_echo(5.0));
    assert_eq!(recording.scans[1].odom_from_base, Some(Se2::new(0.2, 0.0, -0.5)));
    assert_eq!(recording.epoch_ns, 1_700_000_000_250_000_000);
    assert_eq!(recording.scans[1].stamp, Stamp::from_millis(250));
}

#[test]
fn rows_are_written_in_order_of_time() {
    let text = format!(
        "{RIG_LINE}{HEADER}\
         5,0,0,0,1,2\n5.5,0.01,0,0,,\n6,0.1,0,0,inf,0.25\n7.125,0.2,0,0,,\n"
    );
    expect![[r#"
        # rig: {"kind":"ring","base_from_sensors":[[0.1,0.0,0.0],[0.1,0.0,1.0]],"half_angle_rad":0.26,"range_min_m":0.1,"range_max_m":5.0}
        stamp_s,odom_x_m,odom_y_m,odom_yaw_rad,range_0_m,range_1_m
        5.000000000,0,0,0,1,2
        5.500000000,0.01,0,0,,
        6.000000000,0.1,0,0,inf,0.25
        7.125000000,0.2,0,0,,
    "#]]
    .assert_eq(&write(&loaded(&text).recording));
}

#[test]
fn each_bad_row_is_named_by_its_number() {
    use Action::{Repaired, Skipped};
    let cases = [
        ("10.1,0,0,0,1", Trouble::Truncated, Skipped),
        ("10.1,0,0,0,1,2,3", Trouble::BeamCount, Skipped),
        ("x,0,0,0,1,2", Trouble::Unreadable, Skipped),
        ("nan,0,0,0,1,2", Trouble::NotFinite, Skipped),
        ("10.1,0,,0,1,2", Trouble::Unreadable, Skipped),
        ("10.1,0,inf,0,1,2", Trouble::NotFinite, Skipped),
        ("10.1,0,0,0,1,", Trouble::Unreadable, Skipped),
        ("10.1,,,,,", Trouble::Truncated, Skipped),
        ("10.1,0,0,0,nan,2", Trouble::NotFinite, Repaired),
        ("10.1,0,0,0,nan,-2", Trouble::NotFinite, Skipped),
    ];
    for (row, trouble, action) in cases {
        for at in 0..3 {
            let mut rows = vec!["10.0,0,0,0,1,2", "10.2,0,0,0,1,3"];
            rows.insert(at, row);
            let found = loaded(&format!("{RIG_LINE}{HEADER}{}", rows.join("\n")));
            let complaint = &found.complaints.kept()[0];
            assert_eq!(complaint.place, Place::Line(at + 3), "{row}: {complaint}");
            assert_eq!((complaint.trouble, complaint.action), (trouble, action), "{row}");
            let n = if action == Repaired { 3 } else { 2 };
            assert_eq!(found.recording.scans.len(), n, "{row}");
        }
    }
}

#[test]
fn the_rig_comes_from_the_file_or_the_options() {
    let rows = "1,0,0,0,1,2\n";
    let error =
        read("x", format!("{HEADER}{rows}").as_bytes(), &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, RecordingError::NoRig { .. }), "{error}");
    let ring = RingRig {
        base_from_sensors: vec![Se2::IDENTITY; 2],
        half_angle_rad: 0.2,
        range_min_m: 0.2,
        range_max_m: 3.0,
    };
    let options = ReadOptions { ring: Ring::Custom(ring.clone()), ..ReadOptions::default() };
    let found = read("x", format!("{HEADER}{rows}").as_bytes(), &options).unwrap();
    assert_eq!(found.recording.rig, Rig::Ring(ring));
    let broken = RIG_LINE.replace("5}", "-5}");
    let error = read("x", format!("{broken}{HEADER}{rows}").as_bytes(), &ReadOptions::default());
    assert!(matches!(error, Err(RecordingError::NoRig { .. })));
    // Columns of unknown names are left aside, loudly.
    let text = format!("{RIG_LINE}{}{}", HEADER.replace("odom_y_m", "ody_m"), rows);
    let found = loaded(&text);
    assert_eq!(found.recording.scans[0].odom_from_base, None);
    let complaint = &found.complaints.kept()[0];
    assert_eq!((complaint.place, complaint.trouble), (Place::Line(2), Trouble::NotSupported));
    assert!(complaint.found.contains("ody_m"), "{complaint}");
}

#[test]
fn real_recordings_come_back_bit_by_bit() {
    for name in ["laser/freiburg-079.clf.gz", "laser/csail.clf.gz", "artemic/robot_state_U.mat"] {
        let Some(path) = testkit::data_folder(name) else { return };
        let bytes = std::fs::read(path).unwrap();
        let first = read(name, &bytes, &ReadOptions::default()).unwrap().recording;
        let text = write(&first);
        let second = loaded(&text).recording;
        assert_eq!(second.scans, first.scans, "{name}");
        assert!(second == first, "{name}");
    }
}

fn pose(x: f64, yaw: f64) -> Se2 {
    Se2::new(x, x / 3.0, yaw)
}

proptest! {
    #[test]
    fn any_recording_comes_back(
        // Hours of a clock, and rows of time since the last, ranges and headings.
        epoch_ns in 0..2_000_000_000_000_000_000_i64,
        rows in prop::collection::vec((1..9_000_000_000_u64, 0.0..9.0_f64, -3.1..3.1_f64), 1..12),
        has_odom: bool,
        has_truth: bool,
        has_stamps: bool,
        n_extra in 0..3_usize,
    ) {
        let mut now = 0;
        let mut recording = Recording {
            rig: Rig::Ring(RingRig {
                base_from_sensors: vec![pose(0.1, 0.3), pose(0.2, -3.0)],
                half_angle_rad: 0.3,
                range_min_m: 0.1,
                range_max_m: 6.0,
            }),
            scans: Vec::new(),
            odometry: Vec::new(),
            reference: Vec::new(),
            truth: Vec::new(),
            extra_columns_m: Vec::new(),
            epoch_ns,
        };
        for (index, (after, range, yaw)) in rows.into_iter().enumerate() {
            now += if index == 0 { 0 } else { after };
            let stamp = Stamp::from_nanos(now);
            recording.scans.push(Scan {
                stamp,
                odom_from_base: has_odom.then(|| pose(range, yaw)),
                ranges_m: vec![range, f64::INFINITY],
                stamps: if has_stamps { vec![stamp, Stamp::from_nanos(now + 5)] } else { Vec::new() },
            });
            if has_odom {
                recording.odometry.push(StampedPose { stamp, pose: pose(range + 0.1, yaw) });
            }
            if has_truth {
                recording.truth.push(StampedPose { stamp, pose: pose(1.0, yaw) });
                recording.reference.push(StampedPose { stamp, pose: pose(2.0, yaw) });
            }
            if n_extra > 0 {
                recording.extra_columns_m.push(vec![range; n_extra]);
            }
        }
        let found = loaded(&write(&recording));
        prop_assert!(found.complaints.is_empty(), "{}", found.complaints);
        prop_assert_eq!(found.recording, recording);
    }
}

/// A small file, for tests of every format.
pub(crate) fn sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let (log, _) = crate::carmen::tests::sample();
    let recording = crate::read("x", &log, &ReadOptions::default()).unwrap().recording;
    (write(&recording).into_bytes(), None)
}
