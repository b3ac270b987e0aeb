//! Order and time: what is shuffled is sorted, what went back goes on.

use super::*;
use crate::raw::usual_count;
use crate::{order::longest_ascending, recording::LaserRig};
use proptest::prelude::*;

const MS: i64 = 1_000_000;

fn rig() -> Rig {
    Rig::Laser(LaserRig {
        base_from_sensor: Se2::IDENTITY,
        first_beam_rad: 0.0,
        beam_spacing_rad: 0.1,
        n_beams: 2,
        range_max_m: 50.0,
    })
}

/// A scan every 200 ms of a robot that drives 0.1 m between them around a bend.
fn scan(index: i64) -> RawScan {
    let x_m = index as f64 * 0.1;
    RawScan {
        place: Place::Line(1 + index as usize),
        stamp_ns: 1000 * MS + index * 200 * MS,
        odom: Some(Se2::new(x_m, 0.01 * x_m * x_m, 0.0)),
        ranges_m: vec![2.0 + 0.05 * x_m, 9.0 - 0.05 * x_m],
        ..RawScan::default()
    }
}

fn drive(n: i64) -> Vec<RawScan> {
    (0..n).map(scan).collect()
}

fn without_odometry(scans: Vec<RawScan>) -> Vec<RawScan> {
    scans.into_iter().map(|s| RawScan { odom: None, ..s }).collect()
}

/// Lines are numbered in the order of the file.
fn numbered(mut scans: Vec<RawScan>) -> Vec<RawScan> {
    for (index, scan) in scans.iter_mut().enumerate() {
        scan.place = Place::Line(index + 1);
    }
    scans
}

fn assembled(scans: Vec<RawScan>) -> (Recording, Complaints) {
    let mut complaints = Complaints::default();
    let raw = RawRecording::new(rig(), numbered(scans));
    (assemble(raw, &mut complaints).unwrap(), complaints)
}

fn stamps_ms(recording: &Recording) -> Vec<i64> {
    let own = |s: &Scan| (recording.epoch_ns + s.stamp.as_nanos() as i64) / MS;
    recording.scans.iter().map(own).collect()
}

#[test]
fn good_lines_come_through_untouched() {
    let (recording, complaints) = assembled(drive(30));
    assert!(complaints.is_empty());
    assert_eq!(recording.epoch_ns, 1000 * MS);
    assert_eq!(stamps_ms(&recording), (0..30).map(|i| 1000 + 200 * i).collect::<Vec<_>>());
}

proptest! {
    #[test]
    fn shuffled_lines_are_sorted(order in Just((0..40_i64).collect::<Vec<_>>()).prop_shuffle()) {
        let (expected, _) = assembled(drive(40));
        let (found, complaints) = assembled(order.iter().map(|&i| scan(i)).collect());
        prop_assert_eq!(&found, &expected);
        let n_late = order.iter().scan(-1, |latest, &i| {
            let is_late = i < *latest;
            *latest = i.max(*latest);
            Some(usize::from(is_late))
        });
        prop_assert_eq!(complaints.count(Trouble::OutOfOrder), n_late.sum::<usize>());
        prop_assert_eq!(complaints.total(), complaints.count(Trouble::OutOfOrder));
    }

    #[test]
    fn the_longest_ascending_row_is_as_long_as_it_can_be(values in prop::collection::vec(0..9_i64, 0..11)) {
        let chosen = longest_ascending(&values);
        let kept: Vec<i64> =
            values.iter().zip(&chosen).filter(|(_, c)| **c).map(|(v, _)| *v).collect();
        prop_assert!(kept.is_sorted());
        let longest = (0..1_u32 << values.len())
            .filter(|set| {
                let row: Vec<i64> = (0..values.len()).filter(|i| set & (1 << i) != 0).map(|i| values[i]).collect();
                row.is_sorted()
            })
            .map(u32::count_ones)
            .max();
        prop_assert_eq!(longest, Some(u32::try_from(kept.len()).unwrap()));
    }
}

#[test]
fn two_swapped_lines_are_named() {
    let mut scans = drive(10);
    scans.swap(4, 5);
    let (recording, complaints) = assembled(scans);
    assert_eq!(recording, assembled(drive(10)).0);
    let [complaint] = complaints.kept() else { panic!("{complaints}") };
    assert_eq!(complaint.place, Place::Line(6));
    assert_eq!((complaint.trouble, complaint.action), (Trouble::OutOfOrder, Action::Repaired));
    assert!(complaint.found.contains("1.800000000 s after 2.000000000 s"), "{complaint}");
}

#[test]
fn a_clock_that_is_set_back_goes_on() {
    let original = drive(40);
    let set_back = |mut scans: Vec<RawScan>| {
        for scan in &mut scans[25..] {
            scan.stamp_ns -= 4000 * MS;
        }
        scans
    };
    for scans in [set_back(original.clone()), without_odometry(set_back(original.clone()))] {
        let (recording, complaints) = assembled(scans);
        let [complaint] = complaints.kept() else { panic!("{complaints}") };
        assert_eq!(
            (complaint.place, complaint.trouble),
            (Place::Line(26), Trouble::StampJumpsBack)
        );
        assert!(complaint.found.contains("4.000000000 s are added"), "{complaint}");
        assert_eq!(stamps_ms(&recording), (0..40).map(|i| 1000 + 200 * i).collect::<Vec<_>>());
        let ranges: Vec<_> = recording.scans.iter().map(|s| &s.ranges_m).collect();
        assert_eq!(ranges, original.iter().map(|s| &s.ranges_m).collect::<Vec<_>>());
    }
}

#[test]
fn odometry_follows_the_clock() {
    let mut scans = drive(40);
    for scan in &mut scans[25..] {
        scan.stamp_ns -= 4000 * MS;
    }
    let scans = numbered(scans);
    // One line of odometry behind each scan, 10 ms later: lines 1.5, so to say.
    let odometry = scans
        .iter()
        .map(|s| RawPose { place: s.place, stamp_ns: s.stamp_ns + 10 * MS, pose: s.odom.unwrap() })
        .collect();
    let mut complaints = Complaints::default();
    let raw = RawRecording { odometry, ..RawRecording::new(rig(), scans) };
    let recording = assemble(raw, &mut complaints).unwrap();
    assert_eq!(complaints.total(), 1, "{complaints}");
    for (scan, pose) in recording.scans.iter().zip(&recording.odometry) {
        assert_eq!(pose.stamp.since(scan.stamp).as_millis(), 10);
        assert_eq!(Some(pose.pose), scan.odom_from_base);
    }
}

#[test]
fn one_wrong_stamp_changes_no_other() {
    for wrong_ms in [-999_000, 999_000] {
        let mut scans = drive(20);
        scans[7].stamp_ns += wrong_ms * MS;
        let (recording, complaints) = assembled(scans);
        let [complaint] = complaints.kept() else { panic!("{complaints}") };
        assert_eq!((complaint.place, complaint.trouble), (Place::Line(8), Trouble::StampJumpsBack));
        let mut expected: Vec<i64> = (0..20).map(|i| 1000 + 200 * i).collect();
        expected[7] = expected[6];
        assert_eq!(stamps_ms(&recording), expected, "{wrong_ms}");
        let xs = recording.scans.iter().map(|s| s.odom_from_base.unwrap().x_m);
        assert!(xs.is_sorted(), "the order of the file is kept");
    }
}

#[test]
fn equal_stamps_keep_the_order_of_the_file() {
    let scans = drive(9).into_iter().map(|s| RawScan { stamp_ns: 5 * MS, ..s }).collect();
    let (recording, complaints) = assembled(scans);
    assert_eq!(complaints.count(Trouble::StampsUseless), 1);
    assert!(recording.scans.iter().map(|s| s.odom_from_base.unwrap().x_m).is_sorted());
    assert_eq!(stamps_ms(&recording), [5; 9]);
}

#[test]
fn odometry_out_of_reach_is_left_out() {
    let scans = numbered(drive(20));
    let at = |line: usize, ms: i64, x_m: f64| RawPose {
        place: Place::Line(100 + line),
        stamp_ns: ms * MS,
        pose: Se2::new(x_m, 0.0, 0.0),
    };
    // Before, between and after the scans; the speed is 0.5 m/s, so 1 m/s are granted and 0.5 m at once.
    let odometry = vec![
        at(1, 0, -0.4),
        at(2, 100, 40.0),
        at(3, 900, -0.1),
        at(4, 2010, 0.5),
        at(5, 2020, 9.0),
        at(6, 4900, 2.0),
        at(7, 5000, 2.3),
        at(8, 5010, -30.0),
        at(9, 9000, 5.0),
    ];
    let mut complaints = Complaints::default();
    let raw = RawRecording { odometry, ..RawRecording::new(rig(), scans) };
    let recording = assemble(raw, &mut complaints).unwrap();
    let places: Vec<_> = complaints.kept().iter().map(|c| c.place).collect();
    assert_eq!(places, [102, 105, 108].map(Place::Line));
    assert_eq!(complaints.count(Trouble::OdometryJump), 3);
    assert_eq!(recording.odometry.len(), 6);
    assert_eq!(recording.epoch_ns, 0, "time begins with the first odometry");
}

#[test]
fn the_usual_number_of_readings_is_that_of_most() {
    let of = |n: usize| RawScan { ranges_m: vec![1.0; n], ..RawScan::default() };
    assert_eq!(usual_count(&[of(3), of(2), of(2)]), 2);
    assert_eq!(usual_count(&[of(3), of(2)]), 3, "the first of equally frequent ones");
    assert_eq!(usual_count(&[]), 0);
}

#[test]
fn stamps_of_readings_move_with_their_scan() {
    let mut scans = drive(30);
    for scan in &mut scans {
        scan.stamps_ns = vec![scan.stamp_ns - 30 * MS, scan.stamp_ns - 10 * MS];
    }
    for scan in &mut scans[20..] {
        scan.stamp_ns -= 10_000 * MS;
        scan.stamps_ns.iter_mut().for_each(|s| *s -= 10_000 * MS);
    }
    let (recording, _) = assembled(scans);
    for scan in &recording.scans {
        assert_eq!(scan.stamp.since(scan.stamps[0]).as_millis(), 30);
        assert_eq!(scan.stamp.since(scan.stamps[1]).as_millis(), 10);
    }
    assert_eq!(recording.epoch_ns, 970 * MS, "the first reading is before the first scan");
}
