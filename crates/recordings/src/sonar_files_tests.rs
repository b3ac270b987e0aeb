//! Sonar recordings: real files, traps, and that what is written is read again.
#![expect(clippy::float_cmp, reason = "these values are read, not computed")]

use super::*;
use crate::{Loaded, read};

fn artemic(name: &str) -> Option<Loaded> {
    let path = testkit::data_folder(&format!("artemic/{name}.mat"))?;
    Some(read(name, &std::fs::read(path).unwrap(), &ReadOptions::default()).unwrap())
}

/// Last poses and first readings as scipy reads them; lengths as the specification gives them.
#[test]
fn artemics_recordings_are_read() {
    let files = [
        ("robot_state", [4_111.83, 3_701.52, 120.939_012_93], 29.2),
        ("robot_state_U", [4_458.605, -11_854.37, 18.984_612_49], 44.5),
        ("robot_state_camera", [313.795, 1_246.935, -1.933_617_94], 55.5),
    ];
    for (name, [x, y, heading], length_m) in files {
        let Some(loaded) = artemic(name) else { return };
        assert!(loaded.complaints.is_empty(), "{}", loaded.complaints);
        assert_eq!(loaded.format, Format::Mat);
        let recording = loaded.recording;
        assert_eq!(recording.scans.len(), 720);
        assert_eq!(recording.rig.n_readings(), 8);
        assert!(recording.extra_columns_m.iter().all(|row| row.len() == 8));
        assert_eq!(recording.extra_columns_m.len(), 720);
        assert_eq!(recording.scans[719].stamp.as_nanos(), 719 * 250_000_000);
        let last = recording.scans[719].odom_from_base.unwrap();
        assert!((last.x_m - x / 1000.0).abs() < 1e-12 && (last.y_m - y / 1000.0).abs() < 1e-12);
        assert!((last.yaw_rad.to_degrees() - heading).abs() < 1e-7);
        let length = recording.path_length_m();
        assert!((length - length_m).abs() < 0.05, "{name}: {length} m");
    }
    let recording = artemic("robot_state_U").unwrap().recording;
    let row: Vec<f64> =
        recording.scans[0].ranges_m.iter().chain(&recording.extra_columns_m[0]).copied().collect();
    let expected = [
        1077.0, 1502.0, 2568.0, 4271.0, 4359.0, 1984.0, 1308.0, 1035.0, 1047.0, 121.0, 100.0,
        100.0, 100.0, 100.0, 194.0, 1064.0,
    ]
    .map(|mm| mm / 1000.0);
    assert_eq!(row, expected);
    let all = recording.scans.iter().flat_map(|s| &s.ranges_m);
    let all = all.chain(recording.extra_columns_m.iter().flatten());
    assert_eq!(all.filter(|r| !recording.rig.is_echo(**r)).count(), 881);
}

#[test]
fn a_mat_file_comes_back_bit_by_bit() {
    for name in ["robot_state", "robot_state_U", "robot_state_camera", "matlab"] {
        let Some(loaded) = artemic(name) else { return };
        let written = write_mat(&loaded.recording);
        let again = read(name, &written, &ReadOptions::default()).unwrap();
        assert!(again.recording == loaded.recording, "{name}");
        let file = MatFile::parse(&written, 1 << 24).unwrap();
        let readings = file.matrix(READINGS).unwrap();
        assert_eq!((readings.n_rows(), readings.n_columns()), (720, 16));
        assert!(readings.values.iter().all(|v| v.fract() == 0.0), "whole millimetres stay whole");
    }
}

#[test]
fn the_ring_may_be_chosen() {
    let Some(path) = testkit::data_folder("artemic/robot_state_U.mat") else { return };
    let bytes = std::fs::read(path).unwrap();
    let options = ReadOptions {
        ring: Ring::Pioneer16,
        period_s: Some(0.05),
        range_max_m: Some(4.0),
        ..ReadOptions::default()
    };
    let recording = read("x", &bytes, &options).unwrap().recording;
    assert_eq!(recording.rig.n_readings(), 16);
    assert!(recording.extra_columns_m.is_empty());
    assert_eq!(recording.scans[2].stamp.as_nanos(), 100_000_000);
    assert_eq!(recording.rig.range_max_m(), 4.0);
    assert_eq!(recording.scans[0].ranges_m[3], 4.271, "a ring keeps its numbers");
}

fn mat(readings: &[Vec<f64>], poses: &[Vec<f64>]) -> Vec<u8> {
    mat::write(&[matrix(READINGS, readings), matrix(POSES, poses)])
}

#[test]
fn bad_rows_of_a_mat_file_are_named() {
    let good = vec![1000.0; 8];
    let mut one_bad = good.clone();
    one_bad[3] = f64::NAN;
    let readings = [good.clone(), one_bad, vec![-1.0; 8], good.clone(), good.clone(), good.clone()];
    let mut poses = vec![vec![0.0, 0.0, 90.0]; 5];
    poses[3][1] = f64::INFINITY;
    let loaded = read("x", &mat(&readings, &poses), &ReadOptions::default()).unwrap();
    let found: Vec<_> =
        loaded.complaints.kept().iter().map(|c| (c.place, c.trouble, c.action)).collect();
    assert_eq!(
        found,
        [
            (Place::Row(6), Trouble::EndsEarly, Action::Skipped),
            (Place::Row(2), Trouble::NotFinite, Action::Repaired),
            (Place::Row(3), Trouble::NotFinite, Action::Skipped),
            (Place::Row(4), Trouble::NotFinite, Action::Skipped),
        ]
    );
    let scans = &loaded.recording.scans;
    assert_eq!(scans.len(), 3);
    assert_eq!(scans[2].stamp.as_nanos(), 1_000_000_000, "rows that are left out take their time");
    assert_eq!(scans[1].ranges_m[3], f64::INFINITY);
    assert_eq!(scans[0].odom_from_base.unwrap().yaw_rad, std::f64::consts::FRAC_PI_2);
}

#[test]
fn a_mat_file_without_its_matrices_says_what_it_has() {
    let other = mat::write(&[matrix("world", &[vec![1.0, 2.0]])]);
    let error = read("x.mat", &other, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("world (1×2 double)"), "{error}");
    let narrow = mat(&[vec![1.0; 5]], &[vec![0.0; 3]]);
    let error = read("x.mat", &narrow, &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, RecordingError::RingTooLarge { columns: 5, mounts: 8, .. }), "{error}");
    let flat = mat(&[vec![1.0; 8]], &[vec![0.0; 2]]);
    let error = read("x.mat", &flat, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("2 columns"), "{error}");
}

#[test]
fn artemics_texts_are_read_and_written() {
    let readings = "62 | 124 | 249 | 319 | 634 \n645 | 1 | 2 | 3 | 646 \n";
    let poses = "0.000000 0.000000 0.000000 \n0.100000 -0.200000 3.100000 \n";
    let options = ReadOptions { poses: Some(poses.as_bytes()), ..ReadOptions::default() };
    let loaded = read("saved_readings", readings.as_bytes(), &options).unwrap();
    assert!(loaded.complaints.is_empty(), "{}", loaded.complaints);
    assert_eq!(loaded.format, Format::ArtemicText);
    let recording = &loaded.recording;
    assert_eq!(recording.scans[0].ranges_m, [0.62, 1.24, 2.49, 3.19, 6.34]);
    assert_eq!(recording.scans[1].odom_from_base, Some(exact_pose(0.1, -0.2, 3.1)));
    assert_eq!(recording.scans[1].stamp.as_nanos(), 50_000_000);
    assert!(recording.rig.is_echo(6.45) && !recording.rig.is_echo(6.46));
    let (readings_again, poses_again) = write_artemic_text(recording);
    // 646 cm mean nothing; the ring reaches to 645.
    assert_eq!(readings_again, readings.replace("646", "645"));
    assert_eq!(poses_again, poses);
    let error = read("r", readings.as_bytes(), &ReadOptions::default()).unwrap_err();
    assert!(
        matches!(error, RecordingError::SecondFileMissing { what: "the poses", .. }),
        "{error}"
    );
}

#[test]
fn rows_of_two_texts_belong_together_by_their_number() {
    let readings = "1 | 1 | 1 | 1 | 1\n2 | x | 2 | 2 | 2\n3 | 3 | 3 | 3 | 3\n4 | 4 | 4\n5 | 5 | 5 | 5 | 5\n6 | 6 | 6 | 6 | 6\n7 | 7 | 7 | 7 | 7\n";
    let poses = "1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0\n6 0 0\n";
    let options = ReadOptions { poses: Some(poses.as_bytes()), ..ReadOptions::default() };
    let loaded = read("r", readings.as_bytes(), &options).unwrap();
    let found: Vec<_> = loaded.complaints.kept().iter().map(|c| (c.place, c.trouble)).collect();
    assert_eq!(
        found,
        [
            (Place::Line(2), Trouble::Unreadable),
            (Place::Line(7), Trouble::EndsEarly),
            (Place::Line(4), Trouble::Truncated),
            (Place::SecondFileLine(5), Trouble::Truncated),
        ]
    );
    let rows: Vec<_> = loaded
        .recording
        .scans
        .iter()
        .map(|s| (s.ranges_m[0], s.odom_from_base.unwrap().x_m, s.stamp.as_nanos() / 50_000_000))
        .collect();
    assert_eq!(rows, [(0.01, 1.0, 0), (0.03, 3.0, 2), (0.06, 6.0, 5)]);
}

#[test]
fn the_sonar_texts_are_read() {
    let Some(folder) = testkit::data_folder("sonar") else { return };
    let poses = std::fs::read(folder.join("poses.txt")).unwrap();
    let options = ReadOptions { poses: Some(&poses), ..ReadOptions::default() };
    let bytes = std::fs::read(folder.join("measurement.txt")).unwrap();
    let loaded = read("measurement.txt", &bytes, &options).unwrap();
    assert!(loaded.complaints.is_empty(), "{}", loaded.complaints);
    let recording = loaded.recording;
    println!("{:.2} m in {:.1} s", recording.path_length_m(), recording.duration().as_secs_f64());
    assert_eq!(recording.scans.len(), 413);
    assert_eq!(recording.epoch_ns, 1_686_487_000_000);
    assert!((recording.path_length_m() - 24.964).abs() < 1e-3);
    let last = recording.scans[412].odom_from_base.unwrap();
    let expected = Se2::new(16.842, -9.437, 263.1_f64.to_radians());
    assert!(
        (last.x_m - expected.x_m).abs() < 1e-9 && (last.yaw_rad - expected.yaw_rad).abs() < 1e-9
    );
    let echoes = recording.scans.iter().flat_map(|s| &s.ranges_m);
    let n_silent = echoes.filter(|r| !recording.rig.is_echo(**r)).count();
    // A third of the readings are out of range.
    assert!((900..1300).contains(&n_silent), "{n_silent}");
}

#[test]
fn rows_of_a_sonar_text_belong_together_by_their_stamp() {
    let line = |t: u32| format!("{t} 1000 2000 3000 4000 1 2 3 5110\n");
    let text = [line(100), line(300), line(200), line(400)].concat();
    let poses = "400 4 0 0\n100 1000 0 900\n200 2000 0 3599\n250 nan 0 0\nx\n";
    let options = ReadOptions { poses: Some(poses.as_bytes()), ..ReadOptions::default() };
    let loaded = read("m", text.as_bytes(), &options).unwrap();
    let found: Vec<_> = loaded.complaints.kept().iter().map(|c| (c.place, c.trouble)).collect();
    assert_eq!(
        found,
        [
            (Place::SecondFileLine(5), Trouble::Unreadable),
            (Place::SecondFileLine(4), Trouble::NotFinite),
            (Place::Line(2), Trouble::OdometryUnusable),
        ]
    );
    let xs: Vec<_> = loaded.recording.scans.iter().map(|s| s.odom_from_base.unwrap().x_m).collect();
    assert_eq!(xs, [1.0, 2.0, 0.004]);
    let yaw = loaded.recording.scans[1].odom_from_base.unwrap().yaw_rad;
    assert!((yaw.to_degrees() + 0.1).abs() < 1e-9, "359.9 degrees are -0.1: {yaw}");
}

fn six(line: impl Fn(u32) -> String) -> Vec<u8> {
    (0..6).map(line).collect::<Vec<_>>().concat().into_bytes()
}

/// A small file and its second one, for tests of every format.
pub(crate) fn artemic_sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let readings = six(|i| format!("{} | 2 | 3 | 4 | 5 \n", 10 + i));
    (readings, Some(six(|i| format!("{i} 0 0 \n"))))
}

/// The same of sonar texts.
pub(crate) fn sonar_sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let readings = six(|i| format!("{i}00 {} 2 3 4 5 6 7 5110\n", 10 + i));
    (readings, Some(six(|i| format!("{i}00 0 0 {i}\n"))))
}

/// The same of MAT files, which have no second one.
pub(crate) fn mat_sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let (readings, poses) = sonar_sample();
    let options = ReadOptions { poses: poses.as_deref(), ..ReadOptions::default() };
    (write_mat(&read("x", &readings, &options).unwrap().recording), None)
}
