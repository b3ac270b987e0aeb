//! CARMEN logs: the traps of lines, and the real logs.
#![expect(clippy::float_cmp, reason = "these values are read, not computed")]

use std::fmt::Write as _;

use super::*;
use crate::{Loaded, RecordingError, read};

/// The five logs: scans, beams, metres that the odometry travels (computed apart, with numpy), odometry lines out of
/// reach (the files carry some of another moment).
const LOGS: [(&str, usize, usize, f64, usize); 5] = [
    ("belgioioso", 395, 361, 221.813_030_326_554_4, 0),
    ("csail", 406, 361, 369.795_974_835_393_3, 0),
    ("fhw", 488, 180, 398.330_966_041_978_1, 5),
    ("freiburg-079", 4791, 360, 392.908_727_694_673_4, 19),
    ("seattle", 241, 361, 190.014_947_696_937_67, 0),
];

fn log(name: &str) -> Option<Loaded> {
    let path = testkit::data_folder(&format!("laser/{name}.clf.gz"))?;
    let bytes = std::fs::read(path).unwrap();
    Some(read(name, &bytes, &ReadOptions::default()).unwrap())
}

#[test]
fn the_five_logs_are_read_whole() {
    for (name, n_scans, n_beams, length_m, n_jumps) in LOGS {
        let Some(loaded) = log(name) else { return };
        let recording = &loaded.recording;
        println!(
            "{name}: {} scans, {:.1} m, {:.1} s, {} odometry\n{}",
            recording.scans.len(),
            recording.path_length_m(),
            recording.duration().as_secs_f64(),
            recording.odometry.len(),
            loaded.complaints
        );
        assert_eq!(loaded.format, Format::Carmen);
        assert_eq!(recording.scans.len(), n_scans, "{name}");
        assert_eq!(recording.rig.n_readings(), n_beams, "{name}");
        assert_eq!(recording.reference.len(), n_scans, "{name}");
        assert!((recording.path_length_m() - length_m).abs() < 1e-9, "{name}");
        assert_eq!(loaded.complaints.count(Trouble::OdometryJump), n_jumps, "{name}");
        let has_time = !["belgioioso", "csail"].contains(&name);
        assert_eq!(loaded.complaints.count(Trouble::StampsUseless), usize::from(!has_time));
        assert_eq!(recording.odometry.is_empty(), !has_time, "{name}");
        for pair in recording.odometry.windows(2) {
            let step_m = (pair[1].pose.position() - pair[0].pose.position()).norm();
            let time_s = pair[1].stamp.since(pair[0].stamp).as_secs_f64();
            assert!(step_m < 1.0 + 2.5 * time_s, "{name}: {step_m} m in {time_s} s");
        }
    }
}

#[test]
fn numbers_of_the_freiburg_log_are_those_of_its_lines() {
    let Some(loaded) = log("freiburg-079") else { return };
    let recording = loaded.recording;
    let scan = &recording.scans[1];
    // Line 12 of the file.
    assert_eq!(scan.ranges_m[..3], [1.66, 1.66, 1.63]);
    assert_eq!(
        scan.odom_from_base,
        Some(Se2 { x_m: 0.001_282, y_m: 0.000_040, yaw_rad: -0.000_987 })
    );
    let reference = recording.reference[1].pose;
    assert_eq!(reference, Se2 { x_m: -0.000_537, y_m: -0.000_339, yaw_rad: 0.000_575 });
    assert_eq!(scan.stamp.as_nanos() as i64 + recording.epoch_ns, 468_274_000);
    let Rig::Laser(laser) = &recording.rig else { panic!("a laser was expected") };
    assert_eq!((laser.first_beam_rad, laser.beam_spacing_rad), (-FRAC_PI_2, PI / 360.0));
    let n_far = recording.scans.iter().flat_map(|s| &s.ranges_m).filter(|r| r.is_infinite());
    assert_eq!(n_far.count(), 36_004);
}

/// A good line of four beams.
fn flaser(time: &str, x: f64) -> String {
    format!("FLASER 4 1 2 3 81.91 {x} 0.5 0.25 {x} 0 0 {time} host {time}\n")
}

/// Six good lines, a tenth of a second and a tenth of a metre apart.
fn good() -> Vec<String> {
    (0..6).map(|i| flaser(&format!("10.{i}"), f64::from(i) * 0.1)).collect()
}

fn loaded(text: &[u8]) -> Loaded {
    read("test.clf", text, &ReadOptions::default()).unwrap()
}

#[test]
fn each_bad_line_is_named_by_its_number() {
    use Action::{Repaired, Skipped};
    let cases: &[(&[u8], Trouble, Action)] = &[
        (b"FLASER 4 1 2 3", Trouble::Truncated, Skipped),
        (b"FLASER 4 1 2 3 4 0 0 0 0 0 0 10.25", Trouble::Truncated, Skipped),
        (b"FLASER 4 1 2 x 4 0 0 0 0 0 0 10.25 host 1", Trouble::Unreadable, Skipped),
        (b"FLASER 4 1 2 3 4 nan 0 0 0 0 0 10.25 host 1", Trouble::NotFinite, Skipped),
        (b"FLASER 4 1 2 3 4 0 0 0 0 inf 0 10.25 host 1", Trouble::NotFinite, Skipped),
        (b"FLASER 4 1 2 3 4 0 0 0 0 0 0 inf host 1", Trouble::NotFinite, Skipped),
        (b"FLASER 4 nan 2 3 4 0 0 0 0.2 0 0 10.25 host 1", Trouble::NotFinite, Repaired),
        (b"FLASER 4 -1 2 3 4 0 0 0 0.2 0 0 10.25 host 1", Trouble::NotFinite, Repaired),
        (b"FLASER 4 nan nan 3 nan 0 0 0 0 0 0 10.25 host 1", Trouble::NotFinite, Skipped),
        (b"FLASER 3 1 2 3 0 0 0 0.2 0 0 10.25 host 1", Trouble::BeamCount, Skipped),
        (b"FLASER 3 1 2 3 4 0 0 0 0 0 0 10.25 host 1", Trouble::Unreadable, Skipped),
        (b"FLASER 0 0 0 0 0 0 0 10.25 host 1", Trouble::BeamCount, Skipped),
        (b"FLASER 99999999999 1", Trouble::Truncated, Skipped),
        (b"FLASER -4 1", Trouble::Unreadable, Skipped),
        (b"FLASER", Trouble::Truncated, Skipped),
        (b"FLASER 4 1 2 3 4 0 0 0 0.2 0 0 10.2 h 1 FLASER 4 1", Trouble::BeamCount, Skipped),
        (b"FLASER 4 1 2 \xff\xfe 4 0 0 0 0 0 0 10.25 h 1", Trouble::Unreadable, Skipped),
        (b"ODOM 1 2", Trouble::Truncated, Skipped),
        (b"ODOM 1 2 zero 0 0 0 10.25 host 1", Trouble::Unreadable, Skipped),
        (b"ODOM 1 2 nan 0 0 0 10.25 host 1", Trouble::NotFinite, Skipped),
        (b"ODOM 99 0 0 0 0 0 10.25 host 1", Trouble::OdometryJump, Skipped),
    ];
    for (line, trouble, action) in cases {
        for at in 0..=6 {
            let mut text = b"# CARMEN Logfile\n\n".to_vec();
            for (index, good) in good().iter().enumerate() {
                if index == at {
                    text.extend_from_slice(line);
                    text.push(b'\n');
                }
                text.extend(good.bytes());
            }
            if at == 6 {
                text.extend_from_slice(line);
            }
            let loaded = loaded(&text);
            let shown = String::from_utf8_lossy(line);
            let bad: Vec<_> =
                loaded.complaints.kept().iter().filter(|c| c.trouble != Trouble::Assumed).collect();
            assert!(!bad.is_empty(), "{shown}");
            let complaint = bad[0];
            assert_eq!(complaint.place, Place::Line(at + 3), "{shown}: {complaint}");
            assert_eq!((complaint.trouble, complaint.action), (*trouble, *action), "{shown}");
            // Scans of 10.25 s may have to be sorted in, nothing else may happen.
            assert!(bad[1..].iter().all(|c| c.trouble == Trouble::OutOfOrder), "{shown}: {bad:?}");
            let n_expected = if *action == Repaired { 7 } else { 6 };
            assert_eq!(loaded.recording.scans.len(), n_expected, "{shown}");
        }
    }
}

#[test]
fn a_repeated_line_is_taken_once_but_equal_stamps_are_not_repeats() {
    let lines = good();
    let text = [&lines[0], &lines[1], &lines[1], &lines[2], &lines[0]].map(String::as_str).concat();
    let found = loaded(text.as_bytes());
    assert_eq!(found.recording.scans.len(), 3);
    let places: Vec<_> = found
        .complaints
        .kept()
        .iter()
        .filter(|c| c.trouble == Trouble::Duplicate)
        .map(|c| c.place)
        .collect();
    assert_eq!(places, [Place::Line(3), Place::Line(5)]);
    // Equal stamps, another place each: all are kept, in the order of the file.
    let text: String = (0..5).map(|i| flaser("1134860000.0", f64::from(i % 3))).collect();
    let text = format!("ODOM 0 0 0 0 0 0 1134860000.0 h 1\n{text}");
    let found = loaded(text.as_bytes());
    let xs: Vec<f64> =
        found.recording.scans.iter().map(|s| s.odom_from_base.unwrap().x_m).collect();
    assert_eq!(xs, [0.0, 1.0, 2.0], "the fourth and fifth repeat the first and second");
    assert!(found.recording.odometry.is_empty());
    assert_eq!(found.complaints.count(Trouble::StampsUseless), 1);
    assert_eq!(found.complaints.count(Trouble::OdometryUnusable), 1);
    assert!(found.recording.scans.iter().all(|s| s.stamp.as_nanos() == 0));
}

#[test]
fn the_number_of_beams_tells_the_angle() {
    let cases = [
        (180, -90.0, 1.0),
        (181, -90.0, 1.0),
        (360, -90.0, 0.5),
        (361, -90.0, 0.5),
        (400, -50.0, 0.25),
        (401, -50.0, 0.25),
        (5, -90.0, 45.0),
    ];
    for (n, first_deg, spacing_deg) in cases {
        let text = format!("FLASER {n} {} 0 0 0 1 0 0 1.0 h 1\n", "2 ".repeat(n));
        let found = loaded(text.as_bytes());
        let Rig::Laser(laser) = &found.recording.rig else { panic!("a laser was expected") };
        assert!((laser.first_beam_rad.to_degrees() - first_deg).abs() < 1e-12, "{n}");
        assert!((laser.beam_spacing_rad.to_degrees() - spacing_deg).abs() < 1e-12, "{n}");
        assert_eq!(found.complaints.count(Trouble::Assumed), usize::from(n == 5), "{n}");
        let options = ReadOptions { field_of_view_rad: Some(PI * 1.5), ..ReadOptions::default() };
        let found = read("x", text.as_bytes(), &options).unwrap();
        assert!(found.complaints.is_empty());
        let Rig::Laser(laser) = &found.recording.rig else { panic!("a laser was expected") };
        assert_eq!(laser.first_beam_rad, -PI * 0.75);
        assert!((laser.bearing_rad(n - 1) - PI * 0.75).abs() < 1e-12);
    }
    let (first, spacing) = spread(4, TAU);
    assert_eq!((first, spacing), (-PI, PI / 2.0));
}

#[test]
fn what_came_back_from_nowhere_is_infinite() {
    let text = "FLASER 6 0 0.01 49.99 50 81.91 inf 1 0 0 0 0 0 1.0 h 1\n";
    let ranges = |options: &ReadOptions<'_>| {
        read("x", text.as_bytes(), options).unwrap().recording.scans[0].ranges_m.clone()
    };
    let inf = f64::INFINITY;
    assert_eq!(ranges(&ReadOptions::default()), [inf, 0.01, 49.99, inf, inf, inf]);
    let options = ReadOptions { range_max_m: Some(60.0), ..ReadOptions::default() };
    assert_eq!(ranges(&options), [inf, 0.01, 49.99, 50.0, inf, inf]);
}

#[test]
fn the_first_pose_is_the_lasers_place_or_a_reference() {
    // A laser 0.2 m ahead of the robot's middle, in a raw log.
    let raw = "FLASER 3 1 1 1 1.2 0 0 1 0 0 1.0 h 1\n\
               FLASER 3 1 1 2 1 2.2 1.5707963 1 2 1.5707963 2.0 h 1\n";
    let found = loaded(raw.as_bytes());
    let Rig::Laser(laser) = &found.recording.rig else { panic!("a laser was expected") };
    assert!((laser.base_from_sensor.x_m - 0.2).abs() < 1e-6);
    assert!(laser.base_from_sensor.y_m.abs() < 1e-6);
    assert!(found.recording.reference.is_empty());
    let corrected = raw.replace("2 1 2.2", "2 1.01 2.2");
    let found = loaded(corrected.as_bytes());
    let Rig::Laser(laser) = &found.recording.rig else { panic!("a laser was expected") };
    assert_eq!(laser.base_from_sensor, Se2::IDENTITY);
    assert_eq!(found.recording.reference[1].pose.x_m, 1.01);
}

/// laser type, start, field of view, resolution, maximum, accuracy, mode; readings; remissions.
const LASER: &str = "0 -1.0 2.0 0.5 20.0 0.01 0 5 1 2 3 4 25 2 0.1 nan";

#[test]
fn the_new_messages_describe_their_laser() {
    let text = format!(
        "ROBOTLASER1 {LASER} 1.3 0 0 1 0 0 0.1 0.2 0.3 0.4 0.5 7.0 host 7.1\n\
         ROBOTLASER1 {LASER} 2.3 0 0 2 0 0 0.1 0.2 0.3 0.4 0.5 8.0 host 8.1\n\
         ROBOTLASER1 {} 3.3 0 0 3 0 0 0.1 0.2 0.3 0.4 0.5 9.0 host 9.1\n",
        LASER.replace("-1.0 2.0 0.5", "-0.9 2.0 0.5")
    );
    let found = loaded(text.as_bytes());
    let Rig::Laser(laser) = &found.recording.rig else { panic!("a laser was expected") };
    assert_eq!((laser.first_beam_rad, laser.beam_spacing_rad), (-1.0, 0.5));
    assert_eq!((laser.n_beams, laser.range_max_m), (5, 20.0));
    assert!((laser.base_from_sensor.x_m - 0.3).abs() < 1e-12);
    assert_eq!(found.recording.scans.len(), 2);
    assert_eq!(found.recording.scans[0].ranges_m, [1.0, 2.0, 3.0, 4.0, f64::INFINITY]);
    assert_eq!(found.complaints.kept()[0].place, Place::Line(3));
    assert_eq!(found.complaints.count(Trouble::RigChanges), 1);
    assert_eq!(found.recording.epoch_ns, 7_000_000_000);
}

#[test]
fn raw_scans_take_the_odometry_of_their_time() {
    let text = format!(
        "PARAM robot_length 0.5 1 h 1\n\
         ODOM 0 0 0 0 0 0 1.0 h 1\nODOM 1 0 0 0 0 0 2.0 h 1\n\
         TRUEPOS 5 0 0 0 0 0 1.0 h 1\nTRUEPOS 6 0 0 0 0 0 2.0 h 1\n\
         RAWLASER1 {LASER} 1.25 h 1\nRAWLASER1 {LASER} 3.0 h 1\nSYNC x 1 h 1\n"
    );
    let found = loaded(text.as_bytes());
    assert_eq!(found.recording.scans.len(), 1);
    assert_eq!(found.recording.scans[0].odom_from_base, Some(Se2::new(0.25, 0.0, 0.0)));
    assert_eq!(found.recording.truth[0].pose, Se2::new(5.25, 0.0, 0.0));
    assert_eq!(found.complaints.kept()[0].place, Place::Line(7));
    assert_eq!(found.complaints.count(Trouble::OdometryUnusable), 1);
    // None of the scans has odometry of its time.
    let text = format!("ODOM 0 0 0 0 0 0 1.0 h 1\nRAWLASER1 {LASER} 1.25 h 1\n");
    let error = read("x.log", text.as_bytes(), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("line 2: a scan at whose time"), "{error}");
}

#[test]
fn the_same_laser_under_two_names_is_read_once() {
    let robot = format!("ROBOTLASER1 {LASER} 1 0 0 1 0 0 0 0 0 0 0 7.0 h 7\n").repeat(3);
    let raw = format!("RAWLASER1 {LASER} 7.0 h 7\n").repeat(4);
    assert_eq!(chosen_kind(format!("{raw}{robot}").as_bytes()), Some("ROBOTLASER1"));
    let one = flaser("1", 1.0);
    assert_eq!(chosen_kind(format!("{robot}{one}").as_bytes()), Some("ROBOTLASER1"));
    assert_eq!(chosen_kind(format!("{robot}{one}{one}").as_bytes()), Some("FLASER"));
    assert_eq!(chosen_kind(b"RLASER 1 2\nODOM 1\n"), None);
}

#[test]
fn a_log_without_scans_says_what_it_holds() {
    let error = read("a.log", b"ODOM 0 0 0 0 0 0 1 h 1\nODOM 1 0\n# x\n", &ReadOptions::default());
    let error = error.unwrap_err();
    assert!(matches!(error, RecordingError::NoScans { format: Format::Carmen, .. }), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("2 × \"ODOM\"") && text.contains("a.log"), "{text}");
    // Only broken scans: the first complaints are part of the message.
    let error = read("a.log", b"FLASER 4 1\n", &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("line 1"), "{error}");
}

/// A log of 300 scans with odometry between them.
pub(crate) fn log_of_300() -> String {
    let mut text = "# CARMEN Logfile\n".to_owned();
    for i in 0..300 {
        let x = f64::from(i) * 0.01;
        let readings: Vec<String> =
            (0..5).map(|b| format!("{:.2}", 2.0 + x * f64::from(b))).collect();
        let t = format!("{}.{:03}", 100 + i / 10, 100 * (i % 10));
        writeln!(text, "ODOM {x} 0 0 0 0 0 {t} h 0").unwrap();
        let readings = readings.join(" ");
        writeln!(text, "FLASER 5 {readings} 0 {x} 0 {x} 0 0 {t} h 0").unwrap();
    }
    text
}

/// A small file, for tests of every format.
pub(crate) fn sample() -> (Vec<u8>, Option<Vec<u8>>) {
    (log_of_300().as_bytes()[..1000].to_vec(), None)
}
