//! Promises of the codec: golden frames, round trips, what noise and cuts may not do.

use proptest::{collection::vec, prelude::*};

use super::*;

fn frame(command: &Command) -> Vec<u8> {
    let mut out = Vec::new();
    command.encode(&mut out).unwrap();
    out
}

fn packet(body: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    write_packet(body, &mut out).unwrap();
    out
}

fn drain(decoder: &mut Decoder) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| decoder.next_packet()).map(|p| p.body().to_vec()).collect()
}

fn decode_all(chunks: &[&[u8]]) -> Vec<Vec<u8>> {
    let mut decoder = Decoder::new();
    let mut bodies = Vec::new();
    for chunk in chunks {
        decoder.push(chunk);
        bodies.extend(drain(&mut decoder));
    }
    bodies
}

fn hex(text: &str) -> Vec<u8> {
    text.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

/// The sum, the slow way: one pair at a time in wide numbers.
fn checksum_by_definition(body: &[u8]) -> u16 {
    let mut sum = 0_u64;
    let mut bytes = body.iter();
    while let Some(&high) = bytes.next() {
        match bytes.next() {
            Some(&low) => sum = (sum + 256 * u64::from(high) + u64::from(low)) % 65_536,
            None => sum ^= u64::from(high),
        }
    }
    u16::try_from(sum).unwrap()
}

#[test]
fn commands_have_their_golden_frames() {
    let goldens = [
        (Command::Sync0, "FA FB 03 00 00 00"),
        (Command::Sync1, "FA FB 03 01 00 01"),
        (Command::Sync2, "FA FB 03 02 00 02"),
        (Command::Pulse, "FA FB 03 00 00 00"),
        (Command::Enable(1), "FA FB 06 04 3B 01 00 05 3B"),
        (Command::Head(45), "FA FB 06 0C 3B 2D 00 39 3B"),
        (Command::Vel2 { left: 15, right: 15 }, "FA FB 06 20 3B 0F 0F 2F 4A"),
        (Command::RVel(0), "FA FB 06 15 3B 00 00 15 3B"),
        (Command::Move(0), "FA FB 06 08 3B 00 00 08 3B"),
        // Reckoned by hand: a negative argument is a magnitude of type 1B; 0B1B + 2C01 = 371C.
        (Command::Vel(-300), "FA FB 06 0B 1B 2C 01 37 1C"),
        // Left in the high byte: F60A is −2550 as a number, of magnitude 09F6; 201B + F609 = 1624.
        (Command::Vel2 { left: -10, right: 10 }, "FA FB 06 20 1B F6 09 16 24"),
        // The digits of a mask with the top bit set: 8001 is −32767, of magnitude 7FFF.
        (Command::DigOut(0x8001), "FA FB 06 1E 1B FF 7F 1D 9A"),
        // Two tones: 0F2B + 0205 + 40xx, the odd last byte exclusive-ored.
        (Command::Say(vec![5, 64]), "FA FB 07 0F 2B 02 05 40 11 70"),
    ];
    for (command, golden) in goldens {
        assert_eq!(frame(&command), hex(golden), "{command:?}");
    }
}

#[test]
fn every_command_has_its_number() {
    let numbers = [
        (Command::Polling(vec![1]), 3),
        (Command::SetA(1), 5),
        (Command::SetV(1), 6),
        (Command::SetO, 7),
        (Command::Rotate(1), 9),
        (Command::SetRv(1), 10),
        (Command::DHead(1), 13),
        (Command::Config, 18),
        (Command::Encoder(1), 19),
        (Command::DcHead(1), 22),
        (Command::SetRa(1), 23),
        (Command::Sonar(1), 28),
        (Command::Stop, 29),
        (Command::DigOut(1), 30),
        (Command::AdSel(1), 35),
        (Command::IoRequest(1), 40),
        (Command::BumpStall(1), 44),
        (Command::HostBaud(1), 50),
        (Command::EStop, 55),
        (Command::BatteryInfo(1), 62),
        (Command::Sound(1), 90),
        (Command::SoundTog(1), 92),
        (Command::SimSetPose { x_mm: 1, y_mm: 2, heading_deg: 3 }, 224),
        (Command::SimReset, 225),
        (Command::Gripper(1), 33),
        (Command::GripperVal(1), 36),
        (Command::GripRequest(1), 37),
        (Command::SimStat(1), 237),
        (Command::SimMessage(vec![1]), 238),
        (Command::SimExit(1), 239),
        (Command::BatTest(1), 250),
    ];
    for (command, number) in numbers {
        assert_eq!(frame(&command).get(3), Some(&number), "{command:?}");
    }
}

#[test]
fn open_and_close_differ_from_the_syncs_by_their_argument() {
    assert_eq!(Command::decode(&[1]), Ok(Command::Sync1));
    assert_eq!(Command::decode(&[1, 0x3B, 0, 0]), Ok(Command::Open));
    assert_eq!(Command::decode(&[2]), Ok(Command::Sync2));
    assert_eq!(Command::decode(&[2, 0x3B, 1, 0]), Ok(Command::Close));
    assert_eq!(Command::decode(&[0]), Ok(Command::Sync0));
}

#[test]
fn wheel_bytes_sent_as_a_negative_number_mean_the_same() {
    // −10 left, 10 right is 0xF60A; as a signed number −2550, of magnitude 0x09F6.
    let expected = Command::Vel2 { left: -10, right: 10 };
    assert_eq!(Command::decode(&[32, 0x1B, 0xF6, 0x09]), Ok(expected.clone()));
    assert_eq!(Command::decode(&[32, 0x3B, 0x0A, 0xF6]), Ok(expected));
}

#[test]
fn what_is_wrong_with_a_command_is_said() {
    let cases: [(&[u8], &str); 6] = [
        (&[], "empty body; a command begins with its number"),
        (&[11], "command 11: the body ends inside its argument, which is missing or cut short"),
        (
            &[11, 0x3B, 1],
            "command 11: the body ends inside its argument, which is missing or cut short",
        ),
        (
            &[11, 0x2B, 1, 0],
            "command 11: argument type 0x2b; it takes an integer (0x3b positive, 0x1b negative)",
        ),
        (&[11, 0x3B, 0x00, 0x80], "command 11: argument 32768 is outside -32768 to 32767"),
        (
            &[15, 0x2B, 3, 1],
            "command 15: the body ends inside its argument, which is missing or cut short",
        ),
    ];
    for (body, message) in cases {
        assert_eq!(Command::decode(body).unwrap_err().to_string(), message);
    }
    assert_eq!(Command::decode(&[11, 0x1B, 0x00, 0x80]), Ok(Command::Vel(i16::MIN)));
    assert_eq!(Command::decode(&[200, 9, 9]), Ok(Command::Other { number: 200 }));
}

#[test]
fn a_string_that_fits_no_packet_is_refused_whole() {
    let mut out = vec![7];
    assert_eq!(Command::Say(vec![0; 196]).encode(&mut out), Err(BodyLength { len: 199 }));
    assert_eq!(Command::Say(vec![0; 300]).encode(&mut out), Err(BodyLength { len: 303 }));
    assert_eq!(write_packet(&[], &mut out), Err(BodyLength { len: 0 }));
    assert_eq!(out, [7]);
    assert!(Command::Say(vec![0; 195]).encode(&mut out).is_ok());
    assert_eq!(decode_all(&[&out]).len(), 1);
}

/// An information packet written out by hand, after the table in the manual.
const SIP: [u8; 44] = [
    0x33, // moving
    0xE8, 0x03, // x 1000
    0x0C, 0x7E, // y 0x7E0C: −500 in 15 bits
    0x00, 0xFC, // heading −1024: −90°
    0x2C, 0x01, // left 300
    0xD4, 0xFE, // right −300
    0x7B, // 12.3 V
    0x01, 0x00, // left stalled
    0x00, 0x04, // control 1024: 90°
    0x03, 0x00, // motors, first array
    0x2D, // compass 90°
    0x02, // two readings
    0x00, 0x10, 0x27, // sonar 0: 10 000
    0x07, 0x96, 0x00, // sonar 7: 150
    0x01, 0x00, 0x80, 0x0F, 0xF0, // ports
    0x7C, 0x00, 0x02, 0x4A, 0xFF, // 12.4 V, overcharge, −18.2 deg/s
    0x34, 0x12, // faults
    0x99, 0x99, 0x99, 0x99, 0x99, 0x99, // more than this codec knows
];

#[test]
fn an_information_packet_written_by_hand_is_read() {
    let sip = Sip::decode(&SIP).unwrap();
    let expected =
        [SonarReading { sensor: 0, range_mm: 10_000 }, SonarReading { sensor: 7, range_mm: 150 }];
    assert_eq!(sip.sonar(), expected);
    assert!(sip.moving && sip.stalled());
    assert_eq!((sip.x_mm, sip.y_mm, sip.left_mmps, sip.right_mmps), (1000, 0x7E0C, 300, -300));
    assert!((sip.heading_rad() + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!((sip.control_rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((sip.flags, sip.compass, sip.battery_decivolts), (3, 45, 123));
    let io = IoFields { analogue_port: 1, analogue: 0x80, digital_in: 0x0F, digital_out: 0xF0 };
    let power = PowerFields { battery_decivolts: 124, charge_state: 2, rotation_decidegps: -182 };
    assert_eq!((sip.io, sip.power, sip.faults), (Some(io), Some(power), Some(0x1234)));
}

#[test]
fn an_information_packet_may_end_after_its_sonars_but_not_before() {
    let short = SIP.get(..26).unwrap();
    let sip = Sip::decode(short).unwrap();
    assert_eq!((sip.io, sip.power, sip.faults, sip.sonar().len()), (None, None, None, 2));
    for len in 1..26 {
        let error = Sip::decode(SIP.get(..len).unwrap()).unwrap_err();
        assert!(matches!(error, ReportError::CutShort { kind: 0x33, len: l, .. } if l == len));
    }
    assert_eq!(Sip::decode(&[]), Err(ReportError::Empty));
    assert!(matches!(Sip::decode(&[0x34; 60]), Err(ReportError::Kind { kind: 0x34, .. })));
}

#[test]
fn headings_come_back_within_half_a_unit() {
    use std::f64::consts::{PI, TAU};
    for heading_rad in [0.0, 1e-4, -1e-4, 1.0, -1.0, PI - 1e-9, -PI, PI, 3.0 * PI, -7.5] {
        let units = Sip::heading_to_units(heading_rad);
        assert!((-2048..2048).contains(&units), "{heading_rad}");
        let back = Sip { heading_units: units, ..Sip::AT_REST }.heading_rad();
        let error = ((back - heading_rad) / TAU).fract();
        let error = error - error.round();
        assert!(error.abs() <= 0.5 / 4096.0 + 1e-12, "{heading_rad} {back}");
    }
}

#[test]
fn the_configuration_packet_keeps_the_order_of_the_table() {
    let config =
        ConfigPac { serial: "S1".to_owned(), name: "n".to_owned(), ..ConfigPac::default() };
    let mut out = Vec::new();
    config.encode(&mut out).unwrap();
    let bodies = decode_all(&[&out]);
    let [body] = bodies.as_slice() else { panic!("one packet") };
    // Type and three strings, 4mots, 500 deg/s, 2200 mm/s, 600 deg/s², 4000 mm/s², PWM 500, name,
    // cycle.
    let mut start = vec![0x20];
    start.extend_from_slice(b"Pioneer\0p3dx-sh\0S1\0\0");
    start.extend_from_slice(&[0xF4, 0x01, 0x98, 0x08, 0x58, 0x02, 0xA0, 0x0F, 0xF4, 0x01]);
    start.extend_from_slice(b"n\0\x64");
    assert!(body.starts_with(&start), "{body:02x?}");
    assert_eq!(ConfigPac::decode(body), Ok(config.clone()));
    // Older firmware stops earlier; what it did not send keeps its default.
    let cut = ConfigPac::decode(body.get(..start.len()).unwrap()).unwrap();
    assert_eq!((cut.serial.as_str(), cut.watchdog_ms), ("S1", 2000));
    assert!(matches!(ConfigPac::decode(&[0x20]), Err(ReportError::CutShort { .. })));
}

#[test]
fn the_third_echo_carries_three_strings() {
    let mut out = Vec::new();
    let echo =
        Report::Sync2 { name: "a".into(), class: "Pioneer".into(), subclass: "p3dx-sh".into() };
    echo.encode(&mut out).unwrap();
    assert_eq!(decode_all(&[&out]), [b"\x02a\0Pioneer\0p3dx-sh\0".to_vec()]);
    assert_eq!(Report::decode(b"\x02a\0Pioneer\0p3dx-sh\0"), Ok(echo));
    assert!(Report::decode(b"\x02a\0Pioneer\0").is_err());
}

#[test]
fn encoder_counts_are_two_little_endian_numbers() {
    let mut out = Vec::new();
    EncoderPac { left_ticks: 258, right_ticks: -2 }.encode(&mut out);
    let body = [0x90, 0x02, 0x01, 0, 0, 0xFE, 0xFF, 0xFF, 0xFF];
    assert_eq!(decode_all(&[&out]), [body]);
    assert_eq!(EncoderPac::decode(&body), Ok(EncoderPac { left_ticks: 258, right_ticks: -2 }));
    assert!(EncoderPac::decode(body.get(..8).unwrap()).is_err());
}

#[test]
fn a_bad_checksum_is_counted_and_costs_no_following_packet() {
    let mut bad = frame(&Command::Head(45));
    *bad.last_mut().unwrap() ^= 1;
    let good = frame(&Command::Enable(1));
    let mut decoder = Decoder::new();
    decoder.push(&[bad.clone(), good.clone()].concat());
    assert_eq!(drain(&mut decoder), [vec![4, 0x3B, 1, 0]]);
    assert_eq!(decoder.bad_checksums(), 1);
    assert_eq!(decoder.bytes_skipped(), bad.len() as u64);
}

#[test]
fn a_count_too_large_swallows_no_following_packet() {
    // The damaged count reaches into the two packets that follow.
    let damaged = [0xFA, 0xFB, 0x0E, 0x0C, 0x3B, 0x2D, 0x00, 0x39, 0x3B];
    let good = frame(&Command::Enable(1));
    let stream = [damaged.to_vec(), good.clone(), good.clone()].concat();
    assert_eq!(decode_all(&[&stream]).len(), 2);
    // A whole packet, header and all, in what the count claims as body and checksum.
    let stream = [vec![0xFA, 0xFB, 0x06], frame(&Command::Stop)].concat();
    assert_eq!(decode_all(&[&stream]), [[29]]);
}

#[test]
fn impossible_counts_and_stray_headers_are_noise() {
    let good = frame(&Command::Stop);
    let mut decoder = Decoder::new();
    for noise in
        [&[0xFA][..], &[0xFA, 0xFA], &[0xFA, 0xFB, 201], &[0xFA, 0xFB, 2], &[0xFB, 0, 0xFA]]
    {
        decoder.push(&[noise, &good].concat());
        assert_eq!(drain(&mut decoder), [[29]], "{noise:02x?}");
    }
    assert_eq!(decoder.impossible_counts(), 2);
    assert_eq!(decoder.bytes_skipped(), 1 + 2 + 3 + 3 + 3);
}

#[test]
fn a_header_that_never_ends_can_be_given_up() {
    let good = frame(&Command::Stop);
    let mut decoder = Decoder::new();
    decoder.push(&[&[0xFA, 0xFB, 100][..], &good].concat());
    assert_eq!(decoder.next_packet(), None);
    assert!(decoder.has_unfinished());
    decoder.give_up_unfinished();
    assert_eq!(drain(&mut decoder), [[29]]);
    assert!(!decoder.has_unfinished());
    decoder.give_up_unfinished();
}

#[test]
fn memory_and_work_stay_bounded_under_the_worst_noise() {
    // Headers that all promise the longest packet.
    let noise = [0xFA, 0xFB, 200].repeat(40_000);
    let mut decoder = Decoder::new();
    decoder.push(&noise);
    assert_eq!(drain(&mut decoder).len(), 0);
    assert!(decoder.bytes_skipped() >= noise.len() as u64 - 202);
    for _ in 0..1000 {
        decoder.push(&[0x55; 1000]);
        assert_eq!(decoder.next_packet(), None);
    }
    assert!(decoder.capacity() < 4 * 65_536, "{}", decoder.capacity());
}

#[test]
fn steady_traffic_allocates_nothing() {
    let mut sip = Sip::AT_REST;
    assert!(sip.push_sonar(SonarReading { sensor: 3, range_mm: 1234 }));
    let mut decoder = Decoder::new();
    let mut out = Vec::with_capacity(256);
    let mut n_good = 0;
    let allocations = allocation_counter::measure(|| {
        for _ in 0..1000 {
            out.clear();
            sip.encode(&mut out);
            let _fits = Command::Vel2 { left: 3, right: -3 }.encode(&mut out);
            decoder.push(&out);
            while let Some(packet) = decoder.next_packet() {
                n_good += usize::from(Sip::decode(packet.body()).is_ok());
                n_good += usize::from(Command::decode(packet.body()).is_ok());
            }
        }
    });
    // A SIP's type byte 0x32 is also a command's number (HOSTBAUD), whose argument it lacks.
    assert_eq!((n_good, allocations.count_total), (2000, 0));
}

#[test]
fn each_packet_is_described_in_one_line() {
    let line = |command: &Command| describe(decode_all(&[&frame(command)]).first().unwrap(), false);
    assert_eq!(
        line(&Command::Vel2 { left: -10, right: 10 }),
        "VEL2 left -200 mm/s, right 200 mm/s"
    );
    assert_eq!(line(&Command::Enable(0)), "ENABLE motors off");
    assert_eq!(line(&Command::Other { number: 99 }), "command 99, not known here");
    assert_eq!(describe(&[11], false).split(':').next(), Some("bad command"));
    assert_eq!(
        describe(&SIP, true),
        "SIP moving at 1000 mm, 32268 mm, -90.0 deg; wheels 300 / -300 mm/s; 12.3 V; stalled; \
         sonar 0: 10000 mm, 7: 150 mm"
    );
    assert_eq!(describe(b"\x02a\0Pioneer\0p3dx-sh\0", true), "SYNC2 echo: \"a\", Pioneer p3dx-sh");
    assert_eq!(describe(b"\x02a\nb\0c\nd\0e\0", true), "SYNC2 echo: \"a\\nb\", c\\nd e");
}

fn any_command() -> impl Strategy<Value = Command> {
    let int = prop_oneof![any::<i16>(), Just(i16::MIN), Just(-1_i16), Just(0), Just(i16::MAX)];
    let bare = proptest::sample::select(vec![
        Command::Sync0,
        Command::Sync1,
        Command::Sync2,
        Command::Open,
        Command::Close,
        Command::SetO,
        Command::Config,
        Command::Stop,
        Command::EStop,
        Command::SimReset,
        Command::Other { number: 251 },
    ]);
    let constructors: Vec<fn(i16) -> Command> = vec![
        Command::Enable,
        Command::SetA,
        Command::SetV,
        Command::Move,
        Command::Rotate,
        Command::SetRv,
        Command::Vel,
        Command::Head,
        Command::DHead,
        Command::Encoder,
        Command::RVel,
        Command::DcHead,
        Command::SetRa,
        Command::Sonar,
        Command::Gripper,
        Command::GripperVal,
        Command::GripRequest,
        Command::SimStat,
        Command::SimExit,
        Command::BatTest,
        Command::AdSel,
        Command::IoRequest,
        Command::BumpStall,
        Command::HostBaud,
        Command::BatteryInfo,
        Command::Sound,
        Command::SoundTog,
    ];
    let with_int = (proptest::sample::select(constructors), int).prop_map(|(make, n)| make(n));
    prop_oneof![
        2 => bare,
        6 => with_int,
        1 => vec(any::<u8>(), 0..=195).prop_map(Command::Say),
        1 => vec(any::<u8>(), 0..=195).prop_map(Command::Polling),
        1 => vec(any::<u8>(), 0..=195).prop_map(Command::SimMessage),
        1 => any::<u16>().prop_map(Command::DigOut),
        1 => any::<(i8, i8)>().prop_map(|(left, right)| Command::Vel2 { left, right }),
        1 => any::<(i32, i32, i32)>().prop_map(|(x_mm, y_mm, heading_deg)| {
            Command::SimSetPose { x_mm, y_mm, heading_deg }
        }),
    ]
}

fn any_sip() -> impl Strategy<Value = Sip> {
    let io = any::<(u16, u8, u8, u8)>().prop_map(
        |(analogue_port, analogue, digital_in, digital_out)| IoFields {
            analogue_port,
            analogue,
            digital_in,
            digital_out,
        },
    );
    let power = any::<(u16, u8, i16)>().prop_map(
        |(battery_decivolts, charge_state, rotation_decidegps)| PowerFields {
            battery_decivolts,
            charge_state,
            rotation_decidegps,
        },
    );
    let motion = any::<(bool, u16, u16, i16, i16, i16, i16)>();
    let rest = any::<(u8, u8, u8, u16, u8)>();
    let readings = vec(any::<(u8, u16)>(), 0..=54);
    (motion, rest, readings, 0..4, (io, power, any::<u16>())).prop_map(
        |(
            (moving, x_mm, y_mm, heading_units, left_mmps, right_mmps, control_units),
            rest,
            readings,
            tail,
            (io, power, faults),
        )| {
            let (battery_decivolts, stall_left, stall_right, flags, compass) = rest;
            let mut sip = Sip {
                moving,
                x_mm,
                y_mm,
                heading_units,
                left_mmps,
                right_mmps,
                control_units,
                battery_decivolts,
                stall_left,
                stall_right,
                flags,
                compass,
                io: (tail > 0).then_some(io),
                power: (tail > 1).then_some(power),
                faults: (tail > 2).then_some(faults),
                readings: SonarReadings::NONE,
            };
            for (sensor, range_mm) in readings {
                assert!(sip.push_sonar(SonarReading { sensor, range_mm }));
            }
            sip
        },
    )
}

#[test]
fn a_full_packet_takes_no_more_readings() {
    let mut sip = Sip::AT_REST;
    assert_eq!((0..60).filter(|_| sip.push_sonar(SonarReading::default())).count(), 54);
    sip.clear_sonar();
    assert_eq!(sip, Sip::AT_REST);
}

proptest! {
    #[test]
    fn the_checksum_is_what_its_definition_says(body in vec(any::<u8>(), 0..200)) {
        prop_assert_eq!(checksum(&body), checksum_by_definition(&body));
    }

    #[test]
    fn every_command_comes_back(command in any_command()) {
        let bodies = decode_all(&[&frame(&command)]);
        prop_assert_eq!(bodies.len(), 1);
        prop_assert_eq!(Command::decode(bodies.first().unwrap()), Ok(command));
    }

    #[test]
    fn every_information_packet_comes_back(sip in any_sip()) {
        let mut out = Vec::new();
        sip.encode(&mut out);
        let bodies = decode_all(&[&out]);
        prop_assert_eq!(bodies.len(), 1);
        prop_assert_eq!(Sip::decode(bodies.first().unwrap()), Ok(sip));
    }

    #[test]
    fn cuts_change_nothing(bytes in noisy_stream(), cuts in vec(0_usize..600, 0..5)) {
        let mut decoder = Decoder::new();
        let mut cuts = cuts;
        cuts.sort_unstable();
        let (mut pieces, mut done) = (Vec::new(), 0);
        for cut in cuts {
            let end = cut.clamp(done, bytes.len());
            decoder.push(bytes.get(done..end).unwrap());
            pieces.extend(drain(&mut decoder));
            done = end;
        }
        decoder.push(bytes.get(done..).unwrap());
        pieces.extend(drain(&mut decoder));
        prop_assert_eq!(pieces, decode_all(&[&bytes]));
    }

    #[test]
    fn noise_costs_no_packet_behind_it(noise in vec(any::<u8>(), 0..100), command in any_command()) {
        // 250 more bytes satisfy whatever count the noise may have promised.
        let stream = [noise, frame(&command), vec![0; 250]].concat();
        let found = decode_all(&[&stream]);
        let body = decode_all(&[&frame(&command)]).remove(0);
        prop_assert!(found.contains(&body), "{found:02x?}");
    }

    #[test]
    fn no_bytes_make_a_reader_fail(body in vec(any::<u8>(), 0..200)) {
        let _outcome = (Command::decode(&body), Report::decode(&body));
        prop_assert!(!describe(&body, true).contains('\n') && !describe(&body, false).contains('\n'));
    }

    #[test]
    fn a_single_wrong_byte_is_never_taken_for_the_packet(
        command in any_command(), place in any::<proptest::sample::Index>(), flip in 1_u8..,
    ) {
        let mut bytes = frame(&command);
        let place = place.index(bytes.len());
        *bytes.get_mut(place).unwrap() ^= flip;
        let body = decode_all(&[&frame(&command)]).remove(0);
        prop_assert!(!decode_all(&[&bytes, &[0; 250]]).contains(&body));
    }
}

/// Packets, damaged packets and noise in any order.
fn noisy_stream() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        vec(any::<u8>(), 0..20),
        any_command().prop_map(|command| frame(&command)),
        vec(any::<u8>(), 1..20).prop_map(|body| packet(&body)),
        Just(vec![0xFA]),
        Just(vec![0xFA, 0xFB, 20]),
    ];
    vec(piece, 0..12).prop_map(|pieces| pieces.concat())
}
