//! MRPT's texts: traps, and the two simulated logs.
#![expect(clippy::float_cmp, reason = "these values are read, not computed")]

use super::*;
use crate::{Loaded, RecordingError, Trouble, interpolate_pose, read};

fn log(name: &str, truth: &str) -> Option<Loaded> {
    let folder = testkit::data_folder("laser")?;
    let scans = std::fs::read(folder.join(name)).unwrap();
    let truth = std::fs::read(folder.join(truth)).unwrap();
    let options = ReadOptions { truth: Some(&truth), ..ReadOptions::default() };
    Some(read(name, &scans, &options).unwrap())
}

#[test]
fn the_simulated_logs_come_with_their_truth() {
    let logs = [
        ("range_030_bearing_015_LASER_SIM.txt.gz", "range_030_bearing_015.rawlog.GT.txt", 1459),
        ("simul_LASER_SIM.txt.gz", "simul.rawlog.GT.txt", 1732),
    ];
    for (name, truth, n_scans) in logs {
        let Some(loaded) = log(name, truth) else { return };
        let recording = loaded.recording;
        assert!(loaded.complaints.is_empty(), "{}", loaded.complaints);
        assert_eq!(loaded.format, Format::MrptLaser);
        assert_eq!(recording.scans.len(), n_scans, "{name}");
        assert_eq!(recording.truth.len(), n_scans, "{name}");
        assert_eq!(recording.rig.n_readings(), 361);
        assert!(recording.scans.iter().all(|s| s.odom_from_base.is_none()));
        let length: f64 = recording
            .truth
            .windows(2)
            .map(|w| (w[1].pose.position() - w[0].pose.position()).norm())
            .sum();
        println!("{name}: {length:.2} m in {:.1} s", recording.duration().as_secs_f64());
        assert_eq!(recording.truth[0].pose, Se2::IDENTITY);
        assert!(interpolate_pose(&recording.truth, recording.scans[7].stamp).is_some());
    }
}

/// Ten beams with their flags.
fn line(time: &str, first: &str, flags: &str) -> String {
    format!("{time} {first} 2 2 2 2 2 2 2 2 2 {flags}\n")
}

const ONES: &str = "1 1 1 1 1 1 1 1 1 1";

#[test]
fn flags_and_bad_lines_are_respected() {
    let text = [
        "% Time RANGES VALID\n".to_owned(),
        line("100.5", "1.5", "0 1 1 1 1 1 1 1 1 1"),
        line("100.6", "nan", ONES),
        line("100.7", "x", ONES),
        line("100.8", "1", "1 1 1"),
        line("inf", "1", ONES),
        line("100.9", "90", ONES),
        line("101", "1", "1 1 1 1 1 1 1 1 1 7"),
    ]
    .concat();
    let loaded = read("a.txt", text.as_bytes(), &ReadOptions::default()).unwrap();
    let places: Vec<_> =
        loaded.complaints.kept().iter().map(|c| (c.place, c.trouble, c.action)).collect();
    assert_eq!(
        places,
        [
            (Place::Line(3), Trouble::NotFinite, Action::Repaired),
            (Place::Line(4), Trouble::Unreadable, Action::Skipped),
            (Place::Line(5), Trouble::Truncated, Action::Skipped),
            (Place::Line(6), Trouble::NotFinite, Action::Skipped),
            (Place::Line(8), Trouble::Truncated, Action::Skipped),
        ]
    );
    let scans = &loaded.recording.scans;
    assert_eq!(scans.len(), 3);
    for scan in scans {
        assert_eq!(scan.ranges_m[0], f64::INFINITY);
        assert_eq!(scan.ranges_m[1], 2.0);
    }
    assert_eq!(loaded.recording.epoch_ns, 100_500_000_000);
    assert_eq!(scans[2].stamp.as_nanos(), 400_000_000);
    let Rig::Laser(laser) = &loaded.recording.rig else { panic!("a laser was expected") };
    assert_eq!(laser.first_beam_rad, -PI / 2.0);
    assert!((laser.bearing_rad(9) - PI / 2.0).abs() < 1e-15);
}

#[test]
fn truth_that_does_not_reach_is_left_out_and_said() {
    let text = [line("10", "1", ONES), line("20", "3", ONES)].concat();
    let truth = b"9 0 0 0\n19.95 1 0 0.5\nrubbish\n";
    let options = ReadOptions { truth: Some(truth), ..ReadOptions::default() };
    let loaded = read("a", text.as_bytes(), &options).unwrap();
    assert_eq!(loaded.recording.truth.len(), 2, "50 ms are still within reach");
    assert_eq!(loaded.recording.truth[1].pose, Se2::new(1.0, 0.0, 0.5));
    assert_eq!(loaded.complaints.kept()[0].place, Place::SecondFileLine(3));
    let options = ReadOptions { truth: Some(b"9 0 0 0\n19.8 1 0 0"), ..ReadOptions::default() };
    let loaded = read("a", text.as_bytes(), &options).unwrap();
    assert!(loaded.recording.truth.is_empty());
    assert_eq!(loaded.complaints.count(Trouble::TruthMissing), 1);
}

#[test]
fn a_file_of_remarks_says_what_it_holds() {
    let error = read("a.txt", b"% Time RANGES\n% x\n", &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, RecordingError::NoScans { .. }));
    let text = error.to_string();
    assert!(text.contains("2 lines") && text.contains("MRPT"), "{text}");
}

/// A small file and its second one, for tests of every format.
pub(crate) fn sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let scan = |i: u32| format!("1.{i} {} {}\n", "2.5 ".repeat(12), "1 ".repeat(12));
    let text = (0..6).map(scan).collect::<Vec<_>>().concat();
    let truth = (0..6).map(|i| format!("{i} 0 0 \n")).collect::<Vec<_>>().concat();
    (text.into_bytes(), Some(truth.into_bytes()))
}
