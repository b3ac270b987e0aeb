//! Codecs of the Open Interface against the specification's printed bytes and against themselves.

use proptest::prelude::*;

use super::*;
use crate::{Reader, Towards};

fn bytes_of(command: &Command) -> Vec<u8> {
    let mut out = Vec::new();
    command.encode(&mut out);
    out
}

fn commands_in(bytes: &[u8]) -> (Vec<Command>, u64) {
    let mut decoder = CommandDecoder::new();
    decoder.push(bytes);
    let found = std::iter::from_fn(|| decoder.next_command()).collect();
    (found, decoder.bytes_dropped())
}

fn frames_in(pieces: &[&[u8]]) -> (Vec<Readings>, [u64; 3]) {
    let mut decoder = StreamDecoder::new();
    let mut found = Vec::new();
    for piece in pieces {
        decoder.push(piece);
        found.extend(std::iter::from_fn(|| decoder.next_frame()).map(|frame| frame.readings));
    }
    (found, [decoder.bytes_skipped(), decoder.bad_sums(), decoder.n_unreadable()])
}

/// The examples of the specification, and two worked out by hand.
#[test]
fn drive_commands_are_the_printed_bytes() {
    let back = Command::Drive { speed_mmps: -200, radius: Radius::Arc(500) };
    assert_eq!(bytes_of(&back), [0x89, 0xFF, 0x38, 0x01, 0xF4]);
    let spin = Command::DriveDirect { right_mmps: 200, left_mmps: -200 };
    assert_eq!(bytes_of(&spin), [0x91, 0x00, 0xC8, 0xFF, 0x38]);
    assert_eq!(bytes_of(&Command::Baud(7)), [129, 7]);
    assert_eq!(BAUDS[7], 19_200);
    for (radius, wire) in [
        (Radius::Straight, [0x80, 0x00]),
        (Radius::Clockwise, [0xFF, 0xFF]),
        (Radius::CounterClockwise, [0x00, 0x01]),
    ] {
        let bytes = bytes_of(&Command::Drive { speed_mmps: 100, radius });
        assert_eq!(bytes[3..], wire);
    }
    assert_eq!(Radius::of_wire(0x7FFF), Radius::Straight);
}

#[test]
fn the_printed_stream_frame_is_read() {
    // Its prose says 549; 0x0219 is 537.
    let (found, noise) = frames_in(&[&[0x13, 0x05, 0x1D, 0x02, 0x19, 0x0D, 0x00, 0xA3]]);
    assert_eq!(noise, [0, 0, 0]);
    assert_eq!((found[0].get(29), found[0].get(13), found[0].get(7)), (Some(537), Some(0), None));
}

#[test]
fn frames_are_written_as_worked_out_by_hand() {
    let mut readings = Readings::default();
    readings.set(ids::ENCODER_LEFT, 300);
    readings.set(ids::ENCODER_RIGHT, 0xFFF6);
    let mut out = Vec::new();
    write_frame(&[43, 44], &readings, &mut out);
    assert_eq!(out, [0x13, 0x06, 0x2B, 0x01, 0x2C, 0x2C, 0xFF, 0xF6, 0x6E]);
    out.clear();
    write_frame(&[7], &readings, &mut out);
    assert_eq!(out, [0x13, 0x02, 0x07, 0x00, 0xE4]);
}

/// The sizes that the specification prints for its groups.
#[test]
fn groups_have_their_published_sizes() {
    for (id, size) in [
        (0, 26),
        (1, 10),
        (2, 6),
        (3, 10),
        (4, 14),
        (5, 12),
        (6, 52),
        (100, 80),
        (101, 28),
        (106, 12),
        (107, 9),
        (7, 1),
        (19, 2),
        (24, 1),
        (58, 1),
    ] {
        assert_eq!(data_len(id), Some(size), "{id}");
    }
    for id in [59, 99, 102, 105, 108, 255] {
        assert_eq!(data_len(id), None, "{id}");
    }
}

#[test]
fn values_keep_their_sign_and_their_limits() {
    let mut readings = Readings::default();
    for (id, value, kept) in [
        (ids::DISTANCE, -32_769, -32_768),
        (ids::ANGLE, -90, -90),
        (ids::TEMPERATURE, -5, -5),
        (ids::CURRENT, 40_000, 32_767),
        (ids::VOLTAGE, 65_536, 65_535),
        (ids::BUMPS_AND_DROPS, -1, 0),
        (ids::ENCODER_LEFT, 65_535, 65_535),
    ] {
        readings.set(id, value);
        assert_eq!(readings.get(id), Some(kept), "{id}");
        let mut data = Vec::new();
        assert!(readings.write(id, &mut data));
        let mut again = Readings::default();
        assert_eq!(again.read(id, &data), Some(&[][..]));
        assert_eq!(again.get(id), Some(kept), "{id}");
    }
    readings.set(200, 1);
    assert!(readings.get(200).is_none() && !readings.write(200, &mut Vec::new()));
}

#[test]
fn noise_is_dropped_counted_and_survived() {
    let good = [0x13, 0x02, 0x07, 0x02, 0xE2];
    // A false header in front swallows the good frame at first; a wrong sum; an unknown packet.
    for (bytes, noise) in [
        ([&[0x13, 0x03][..], &good].concat(), [2, 1, 0]),
        ([&[0x13, 0x02, 0x07, 0x02, 0xE3][..], &good].concat(), [5, 1, 0]),
        ([&[0x13, 0x02, 0x5A, 0x00, 0x91][..], &good].concat(), [5, 0, 1]),
        ([&[0x13, 0xFF][..], &good].concat(), [2, 0, 0]),
        ([&[0x00, 0x55][..], &good].concat(), [2, 0, 0]),
    ] {
        let (found, counted) = frames_in(&[&bytes]);
        assert_eq!((found.len(), counted), (1, noise), "{bytes:02x?}");
        assert_eq!(found[0].get(ids::BUMPS_AND_DROPS), Some(2));
    }
    let (found, dropped) = commands_in(&[0x00, 0x42, 128, 200, 131, 137, 0]);
    assert_eq!((found, dropped), (vec![Command::Start, Command::Safe], 3));
}

#[test]
fn a_frame_that_is_too_long_is_cut_and_has_no_right_sum() {
    let mut out = Vec::new();
    // 81 bytes each with the id.
    write_frame(&[100, 100, 100], &Readings::default(), &mut out);
    assert_eq!(out.len(), FRAME_LEN_MAX);
    let (found, _) = frames_in(&[&out]);
    assert!(found.is_empty(), "{found:?}");
    out.clear();
    write_frame(&[100, 100], &Readings::default(), &mut out);
    assert_eq!(frames_in(&[&out]).0.len(), 1);
}

#[test]
fn whoever_reads_along_is_told_what_passes_and_what_does_not() {
    let told = |towards, bytes: &[u8]| {
        let mut reader: Box<dyn Reader> = reader(towards);
        let mut lines = Vec::new();
        reader.push(bytes, &mut |_, text| lines.push(text));
        lines
    };
    assert_eq!(
        told(Towards::Robot, &[128, 131, 0x91, 0, 0xC8, 0xFF, 0x38, 3, 164, b'a', 10, b'c', b'd']),
        [
            "START: passive",
            "SAFE",
            "DRIVE DIRECT left -200 mm/s, right 200 mm/s",
            "DIGIT LEDS \"a\\ncd\"",
            "1 bytes that are no opcode",
        ]
    );
    assert_eq!(
        told(Towards::Client, &[9, 9, 0x13, 0x02, 35, 1, 0xC7]),
        ["2 bytes outside of any frame", "STREAM mode passive"]
    );
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        Just(Command::Start),
        Just(Command::Safe),
        Just(Command::Stop),
        Just(Command::Reset),
        any::<u8>().prop_map(Command::Sensors),
        (any::<i16>(), any::<i16>()).prop_map(|(speed_mmps, radius)| Command::Drive {
            speed_mmps,
            radius: Radius::of_wire(radius),
        }),
        (any::<i16>(), any::<i16>())
            .prop_map(|(right_mmps, left_mmps)| Command::DriveDirect { right_mmps, left_mmps }),
        (any::<i16>(), any::<i16>()).prop_map(|(right, left)| Command::DrivePwm { right, left }),
        proptest::collection::vec(any::<u8>(), 0..20).prop_map(Command::Stream),
        proptest::collection::vec(any::<u8>(), 0..20).prop_map(Command::QueryList),
        (any::<u8>(), proptest::collection::vec(any::<[u8; 2]>(), 0..17))
            .prop_map(|(number, notes)| Command::Song { number, notes }),
        any::<[u8; 15]>().prop_map(Command::Schedule),
        any::<[u8; 4]>().prop_map(Command::DigitLedsAscii),
        any::<bool>().prop_map(|streams| Command::Pause { streams }),
    ]
}

proptest! {
    #[test]
    fn commands_survive_the_wire_however_they_are_cut(
        commands in proptest::collection::vec(any_command(), 1..12), cut in 0_usize..200,
    ) {
        let bytes: Vec<u8> = commands.iter().flat_map(bytes_of).collect();
        let (head, tail) = bytes.split_at(cut.min(bytes.len()));
        let mut decoder = CommandDecoder::new();
        let mut found = Vec::new();
        for piece in [head, tail] {
            decoder.push(piece);
            found.extend(std::iter::from_fn(|| decoder.next_command()));
        }
        prop_assert_eq!(found, commands);
        prop_assert!(decoder.bytes_dropped() == 0 && !decoder.has_unfinished());
    }

    #[test]
    fn a_good_frame_is_found_behind_any_noise(
        noise in proptest::collection::vec(any::<u8>(), 0..300), value in 0_i32..65_536,
    ) {
        let mut readings = Readings::default();
        readings.set(ids::ENCODER_LEFT, value);
        let mut bytes = noise;
        write_frame(&[43], &readings, &mut bytes);
        // What noise began would swallow what follows, so much of it there must be.
        bytes.resize(bytes.len() + FRAME_LEN_MAX, 0);
        let (found, _) = frames_in(&[&bytes]);
        prop_assert!(found.iter().any(|found| found.get(ids::ENCODER_LEFT) == Some(value)));
    }

    #[test]
    fn cuts_change_nothing(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let (head, tail) = bytes.split_at(bytes.len() / 2);
        prop_assert_eq!(frames_in(&[&bytes]), frames_in(&[head, tail]));
    }
}
