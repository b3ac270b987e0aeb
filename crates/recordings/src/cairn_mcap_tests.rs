//! Cairn's recordings: back bit by bit, of several robots, cut off anywhere.

use super::*;
use crate::{StampedPose, read};
use proptest::prelude::*;

fn ring() -> Rig {
    Rig::Ring(RingRig {
        base_from_sensors: vec![Se2::new(0.1, 0.2, 1.0), Se2::new(-0.1, 0.3, -3.0)],
        half_angle_rad: 0.26,
        range_min_m: 0.1,
        range_max_m: 5.0,
    })
}

fn recording(n: u64) -> Recording {
    let pose = |i: u64| Se2::new(i as f64 * 0.013, 0.1, 0.001 * i as f64);
    let scan = |i: u64| Scan {
        stamp: Stamp::from_nanos(i * 50_000_001),
        odom_from_base: Some(pose(i)),
        ranges_m: vec![1.0 / (i + 1) as f64, if i.is_multiple_of(3) { f64::INFINITY } else { 4.9 }],
        stamps: vec![Stamp::from_nanos(i * 50_000_001), Stamp::from_nanos(i * 50_000_001 + 7)],
    };
    let truth =
        |i: u64| StampedPose { stamp: Stamp::from_nanos(i * 50_000_001), pose: pose(i + 3) };
    Recording {
        rig: ring(),
        scans: (0..n).map(scan).collect(),
        odometry: Vec::new(),
        reference: Vec::new(),
        truth: (0..n).map(truth).collect(),
        extra_columns_m: Vec::new(),
        epoch_ns: 0,
    }
}

#[test]
fn a_recording_comes_back_bit_by_bit() {
    let original = recording(2000);
    let bytes = write(&original, "artemic").unwrap();
    let loaded = read("run.mcap", &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.format, Format::CairnMcap);
    assert!(loaded.complaints.is_empty(), "{}", loaded.complaints);
    assert_eq!(loaded.recording, original);
}

/// A foreign reader of the format finds the same messages.
#[test]
fn the_mcap_crate_reads_the_same_messages() {
    let bytes = write(&recording(300), "r").unwrap();
    let theirs: Vec<(String, Vec<u8>)> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(|m| m.map(|m| (m.channel.topic.clone(), m.data.to_vec())).unwrap())
        .collect();
    let ours: Vec<(String, Vec<u8>)> =
        mcap_records::messages(&bytes).map(|m| (m.topic.to_owned(), m.data.to_vec())).collect();
    assert_eq!(ours, theirs);
    assert_eq!(ours.len(), 301);
}

#[test]
fn a_robot_is_chosen_by_its_name() {
    let mut writer = WriteOptions::new().compression(None).create(Cursor::new(Vec::new())).unwrap();
    let mut data = Vec::new();
    for (robot, n) in [("b", 3), ("a", 5)] {
        let recording = recording(n);
        let rig = writer.add_channel(0, &rig_topic(robot), "json", &BTreeMap::new()).unwrap();
        let scans = writer.add_channel(0, &scan_topic(robot), "x", &BTreeMap::new()).unwrap();
        let mut header =
            MessageHeader { channel_id: rig, sequence: 0, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, &encode_rig(&recording.rig)).unwrap();
        header.channel_id = scans;
        for scan in &recording.scans {
            data.clear();
            encode_scan(scan, None, &mut data);
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let error = read("x", &bytes, &ReadOptions::default()).unwrap_err();
    assert_eq!(
        error,
        RecordingError::SeveralRobots { name: "x".into(), robots: vec!["a".into(), "b".into()] }
    );
    assert!(error.to_string().contains("a, b"), "{error}");
    let of =
        |robot| read("x", &bytes, &ReadOptions { robot: Some(robot), ..ReadOptions::default() });
    assert_eq!(of("a").unwrap().recording.scans.len(), 5);
    assert_eq!(of("b").unwrap().recording.scans.len(), 3);
    assert!(of("b").unwrap().recording.truth.is_empty());
    let error = of("c").unwrap_err();
    assert!(matches!(&error, RecordingError::NoSuchRobot { robots, .. } if robots.len() == 2));
}

#[test]
fn a_file_that_was_cut_reads_as_far_as_it_goes() {
    let original = recording(60);
    let bytes = write(&original, "r").unwrap();
    let mut before = 0;
    for end in 1..bytes.len() {
        match read("cut", &bytes[..end], &ReadOptions::default()) {
            Ok(loaded) => {
                let n = loaded.recording.scans.len();
                assert!(n == before || n == before + 1, "{n} scans after {before}");
                assert_eq!(loaded.recording.scans, original.scans[..n]);
                before = n;
                if end < bytes.len() - 1000 {
                    assert_eq!(loaded.complaints.count(Trouble::EndsEarly), 1, "at {end}");
                }
            }
            Err(_) => assert_eq!(before, 0, "at {end}"),
        }
    }
    assert_eq!(before, 60);
}

/// What a crash leaves behind: the chunk's length is not written yet.
#[test]
fn an_unfinished_chunk_is_read_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap.part");
    let original = recording(50);
    let file = std::fs::File::create(&path).unwrap();
    let mut writer = WriteOptions::new().compression(None).create(file).unwrap();
    let rig = writer.add_channel(0, &rig_topic("r"), "json", &BTreeMap::new()).unwrap();
    let scans = writer.add_channel(0, &scan_topic("r"), "x", &BTreeMap::new()).unwrap();
    let mut header = MessageHeader { channel_id: rig, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &encode_rig(&original.rig)).unwrap();
    header.channel_id = scans;
    let mut data = Vec::new();
    for scan in &original.scans {
        data.clear();
        encode_scan(scan, None, &mut data);
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    std::mem::forget(writer);
    let bytes = std::fs::read(&path).unwrap();
    let loaded = read("run.mcap.part", &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.recording.scans, original.scans);
    assert_eq!(loaded.complaints.count(Trouble::EndsEarly), 1);
}

#[test]
fn a_turned_bit_is_noticed() {
    let bytes = write(&recording(40), "r").unwrap();
    // A bit of a range in the middle of the chunk.
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 3] ^= 1;
    let loaded = read("x", &damaged, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.complaints.count(Trouble::Damaged), 1, "{}", loaded.complaints);
}

#[test]
fn messages_that_are_none_are_refused() {
    let scan = &recording(2).scans[1];
    let mut good = Vec::new();
    encode_scan(scan, Some(Se2::IDENTITY), &mut good);
    let message = decode_scan(&good).unwrap();
    assert_eq!((&message.scan, message.truth), (scan, Some(Se2::IDENTITY)));
    for end in 0..good.len() {
        assert!(decode_scan(&good[..end]).is_err(), "{end} bytes");
    }
    let with = |at: usize, value: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        decode_scan(&bytes)
    };
    assert!(matches!(with(8, &[0xff]), Err(MessageError::Content(_))), "flags");
    assert!(matches!(with(9, &u32::MAX.to_le_bytes()), Err(MessageError::Length { .. })));
    assert!(matches!(with(13, &f64::NAN.to_le_bytes()), Err(MessageError::Content(_))), "pose");
    assert!(matches!(with(29, &4.0_f64.to_le_bytes()), Err(MessageError::Content(_))), "heading");
    assert!(matches!(with(61, &(-1.0_f64).to_le_bytes()), Err(MessageError::Content(_))), "range");
    assert!(with(61, &f64::INFINITY.to_le_bytes()).is_ok());
    assert!(decode_rig(b"{}").is_err());
    assert!(decode_rig(br#"{"kind":"ring","base_from_sensors":[],"half_angle_rad":0.0,"range_min_m":0.1,"range_max_m":5.0}"#).is_err());
}

fn any_pose() -> impl Strategy<Value = Se2> {
    (-1e3..1e3_f64, -1e3..1e3_f64, -3.1..3.1_f64).prop_map(|(x, y, a)| Se2::new(x, y, a))
}

proptest! {
    #[test]
    fn any_scan_comes_back(
        nanos: u64,
        odom in prop::option::of(any_pose()),
        truth in prop::option::of(any_pose()),
        ranges_m in prop::collection::vec(0.0..1e4_f64, 0..20),
        has_stamps: bool,
    ) {
        let stamps = if has_stamps {
            (0..ranges_m.len() as u64).map(|i| Stamp::from_nanos(nanos ^ i)).collect()
        } else {
            Vec::new()
        };
        let scan = Scan { stamp: Stamp::from_nanos(nanos), odom_from_base: odom, ranges_m, stamps };
        let mut bytes = Vec::new();
        encode_scan(&scan, truth, &mut bytes);
        prop_assert_eq!(decode_scan(&bytes).unwrap(), ScanMessage { scan, truth });
    }

    #[test]
    fn any_rig_comes_back(mounts in prop::collection::vec(any_pose(), 0..9), angle in 0.01..1.0_f64) {
        let rig = Rig::Ring(RingRig {
            base_from_sensors: mounts,
            half_angle_rad: angle,
            range_min_m: angle / 3.0,
            range_max_m: angle * 7.0,
        });
        prop_assert_eq!(decode_rig(&encode_rig(&rig)).unwrap(), rig);
        let laser = Rig::Laser(LaserRig {
            base_from_sensor: Se2::new(angle, 0.1, angle),
            first_beam_rad: -angle,
            beam_spacing_rad: angle / 180.0,
            n_beams: 361,
            range_max_m: 1.0 / angle,
        });
        prop_assert_eq!(decode_rig(&encode_rig(&laser)).unwrap(), laser);
    }

    #[test]
    fn random_bytes_are_no_message(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        let _scan = decode_scan(&bytes);
        let _rig = decode_rig(&bytes);
    }
}

/// A small file, cut, for tests of every format.
pub(crate) fn sample() -> (Vec<u8>, Option<Vec<u8>>) {
    let log = crate::carmen::tests::log_of_300();
    let recording = crate::read("x", log.as_bytes(), &ReadOptions::default()).unwrap().recording;
    (write(&recording, "r").unwrap()[..2000].to_vec(), None)
}
