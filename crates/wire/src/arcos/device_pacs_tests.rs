//! Packets of devices: golden bytes written by hand from the layout, cuts, round trips.

use proptest::{array, prelude::*};

use super::*;

fn body(report: &Report) -> Vec<u8> {
    let mut out = Vec::new();
    report.encode(&mut out).unwrap();
    let (head, rest) = out.split_at(3);
    assert_eq!(usize::from(head[2]), rest.len());
    rest[..rest.len() - 2].to_vec()
}

#[test]
fn no_gripper_is_four_bytes_whose_second_is_zero() {
    assert_eq!(body(&Report::Gripper(GripperPac::default())), [0xE0, 0, 0, 0]);
    assert_eq!(
        Report::decode(&[0xE0, 2, 0x31, 7]),
        Ok(Report::Gripper(GripperPac { kind: 2, switches: 0x31, grasp_time: 7 }))
    );
    let cut = Report::decode(&[0xE0, 2]).unwrap_err().to_string();
    assert_eq!(cut, "packet of type 0xe0: 2 bytes end inside its switches");
}

#[test]
fn ports_are_three_counted_groups() {
    let mut io = IoPac { digital_in: [1, 2, 4, 255], digital_out: [16, 0], ..IoPac::default() };
    io.analogue[8] = 0x0102;
    let mut golden = vec![0xF0, 4, 1, 2, 4, 255, 2, 16, 0, 9];
    golden.extend([0; 16]);
    golden.extend([2, 1]);
    assert_eq!(body(&Report::Io(io)), golden);
    // Another robot may have other counts.
    let short = IoPac::decode(&[0xF0, 1, 7, 0, 1, 5, 0]).unwrap();
    assert_eq!((short.digital_in, short.analogue[0]), ([7, 0, 0, 0], 5));
    let long = IoPac::decode(&[0xF0, 6, 1, 2, 3, 4, 5, 6, 0, 0]).unwrap();
    assert_eq!(long.digital_in, [1, 2, 3, 4]);
    assert!(IoPac::decode(&[0xF0, 4, 1, 2]).is_err() && IoPac::decode(&[0xF1]).is_err());
}

/// Offsets of the manufacturer's table: flags at 3, intervals at 7, 9, 11, the pose from 13 on.
#[test]
fn the_true_pose_stands_where_clients_look_for_it() {
    let stat = SimStatPac {
        has_map: true,
        sim_interval_ms: 10,
        real_interval_ms: 10,
        last_interval_ms: 12,
        x_mm: -2600,
        y_mm: 70_000,
        heading_deg: -90,
        bounds_mm: Some([-4000, -3000, 6000, 5000]),
    };
    let bytes = body(&Report::SimStat(stat));
    let int = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(bytes[..13], [0x62, 0, 0, 1, 0, 0, 0, 10, 0, 10, 0, 12, 0]);
    assert_eq!([int(13), int(17), int(21), int(25)], [-2600, 70_000, 0, -90]);
    // No place on Earth, no errors of odometry, and that is what the flags say.
    assert_eq!([int(29), int(33), int(37)], [0; 3]);
    assert_eq!((bytes[41], [int(42), int(46), int(50)]), (0xFF, [0; 3]));
    assert_eq!([int(54), int(58), int(62), int(66)], [-4000, -3000, 6000, 5000]);
    // A simulator that says less.
    let older = SimStatPac::decode(&bytes[..29]).unwrap();
    assert_eq!(older, SimStatPac { bounds_mm: None, ..stat });
    assert!(SimStatPac::decode(&bytes[..28]).is_err());
}

#[test]
fn a_bare_request_for_the_true_pose_means_one() {
    assert_eq!(Command::decode(&[237]), Ok(Command::SimStat(1)));
    assert_eq!(Command::decode(&[237, 0x3B, 2, 0]), Ok(Command::SimStat(2)));
    assert_eq!(Command::decode(&[37, 0x3B, 1, 0]), Ok(Command::GripRequest(1)));
    assert_eq!(Command::decode(&[238, 0x2B, 2, b'h', b'i']), Ok(Command::SimMessage(b"hi".into())));
    let line = |body: &[u8], from_robot| describe(body, from_robot);
    assert_eq!(line(&[238, 0x2B, 2, b'a', b'\n'], false), "SIM_MESSAGE \"a\\n\"");
    assert_eq!(line(&[250, 0x3B, 105, 0], false), "BATTEST 10.5 V");
    assert_eq!(line(&[0xE0, 0, 0, 0], true), "GRIPPER none");
}

#[test]
fn bumpers_of_the_front_are_in_the_right_wheel_s_byte() {
    let sip = Sip { stall_right: 0b0000_1010, stall_left: 0b0010_0001, ..Sip::AT_REST };
    assert_eq!(sip.bumpers(), [0b00101, 0b10000]);
    assert!(sip.stalled());
    let mut out = Vec::new();
    sip.encode(&mut out);
    // The client reads the two as one little-endian number: its high byte is the front.
    assert_eq!(out[3 + 12..3 + 14], [0b0010_0001, 0b0000_1010]);
}

proptest! {
    #[test]
    fn every_packet_comes_back(
        gripper in any::<[u8; 3]>(),
        (digital_in, digital_out, analogue) in
            (any::<[u8; 4]>(), any::<[u8; 2]>(), array::uniform9(any::<u16>())),
        has_map in any::<bool>(),
        intervals in any::<[u16; 3]>(),
        pose in any::<[i32; 3]>(),
        bounds_mm in proptest::option::of(any::<[i32; 4]>()),
    ) {
        let [kind, switches, grasp_time] = gripper;
        let [sim_interval_ms, real_interval_ms, last_interval_ms] = intervals;
        let [x_mm, y_mm, heading_deg] = pose;
        let reports = [
            Report::Gripper(GripperPac { kind, switches, grasp_time }),
            Report::Io(IoPac { digital_in, digital_out, analogue }),
            Report::SimStat(SimStatPac {
                has_map, sim_interval_ms, real_interval_ms, last_interval_ms,
                x_mm, y_mm, heading_deg, bounds_mm,
            }),
        ];
        for report in reports {
            prop_assert_eq!(Report::decode(&body(&report)).unwrap(), report);
        }
    }
}
