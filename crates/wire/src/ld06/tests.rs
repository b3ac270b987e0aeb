//! Packets of the LD06 as they are measured, cut and damaged.

use proptest::{array::uniform12, collection::vec, prelude::*};

use super::*;

/// The example of the LD19 manual, one recorded on a unit, and a packet across the turn's end.
const MANUAL: &str = "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 \
    E2 C7 00 E9 C5 00 E5 C2 00 E5 C0 00 E5 BE 82 3A 1A 50";
const RECORDED: &str = "54 2C 74 08 B0 86 00 00 D4 00 00 D4 00 00 D4 00 00 D4 00 00 D4 00 00 D5 00 00 D5 00 \
    00 49 00 00 5F 00 00 B0 00 00 D2 00 00 D4 02 89 1E 09 1F";
const ACROSS: &str = "54 2C 10 0E 3C 8C E8 03 C8 F2 03 C8 FC 03 C8 06 04 C8 10 04 C8 1A 04 C8 24 04 C8 2E 04 \
    C8 38 04 C8 42 04 C8 4C 04 C8 56 04 C8 0C 03 2F 75 57";

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect()
}

fn packets(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Packet> {
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next_packet()).collect()
}

fn only(hex: &str) -> Packet {
    let mut decoder = Decoder::new();
    let found = packets(&mut decoder, &bytes(hex));
    assert_eq!((found.len(), decoder.n_bytes_skipped(), decoder.n_bad_checksums()), (1, 0, 0));
    assert_eq!(found[0].encode().to_vec(), bytes(hex));
    found[0]
}

#[test]
fn the_manual_s_example_is_read_and_written() {
    let packet = only(MANUAL);
    assert_eq!((packet.speed_degps, packet.clock_ms), (2152, 6714));
    assert_eq!((packet.start_cdeg, packet.end_cdeg), (32_427, 33_470));
    assert_eq!(packet.points[0], Point { distance_mm: 224, intensity: 228 });
    assert_eq!(packet.points[11], Point { distance_mm: 192, intensity: 229 });
    for (index, expected) in [(0, 324.27), (1, 325.218), (11, 334.70)] {
        assert!((packet.angle_deg(index) - expected).abs() < 5e-4, "{index}");
    }
    assert!(packet.is_plausible());
}

#[test]
fn a_unit_s_recorded_packet_saw_nothing() {
    let packet = only(RECORDED);
    assert!(packet.points.iter().all(|point| point.distance_mm == 0));
    assert_eq!(packet.points[7].intensity, 0x49);
}

#[test]
fn angles_go_on_across_the_turn_s_end() {
    let packet = only(ACROSS);
    assert_eq!((packet.span_cdeg(), packet.clock_ms), (880, 29_999));
    assert!((packet.angle_deg(0) - 359.0).abs() < 1e-9);
    assert!((packet.angle_deg(1) - 359.8).abs() < 1e-9);
    assert!((packet.angle_deg(2) - 0.6).abs() < 1e-9);
    assert!((packet.angle_deg(11) - 7.8).abs() < 1e-9);
    assert_eq!(packet.points[11].distance_mm, 1110);
}

#[test]
fn spans_that_twelve_points_cannot_have_are_implausible() {
    let packet = only(ACROSS);
    assert!(packet.is_plausible());
    assert!(Packet { end_cdeg: 2900, ..packet }.is_plausible());
    assert!(!Packet { end_cdeg: 2901, ..packet }.is_plausible());
    // Backwards is nearly a whole turn.
    assert!(!Packet { end_cdeg: 35_800, ..packet }.is_plausible());
    assert!(!Packet { start_cdeg: 36_000, ..packet }.is_plausible());
}

/// The maker's driver does not find this one.
#[test]
fn a_header_byte_before_the_header_costs_one_byte() {
    let mut decoder = Decoder::new();
    let stream = [vec![0x54], bytes(MANUAL)].concat();
    assert_eq!(packets(&mut decoder, &stream), [only(MANUAL)]);
    assert_eq!((decoder.n_bytes_skipped(), decoder.n_bad_checksums()), (1, 0));
}

#[test]
fn half_and_damaged_packets_are_counted_and_the_next_is_found() {
    let (whole, mut decoder) = (bytes(MANUAL), Decoder::new());
    let mut damaged = whole.clone();
    damaged[20] ^= 4;
    let stream = [&whole[..30], &damaged, &whole].concat();
    assert_eq!(packets(&mut decoder, &stream), [only(MANUAL)]);
    assert_eq!(decoder.n_bytes_skipped(), 30 + 47);
    assert_eq!(decoder.n_bad_checksums(), 2);
    assert_eq!(decoder.n_packets(), 1);
}

fn packet() -> impl Strategy<Value = Packet> {
    let point = (any::<u16>(), any::<u8>())
        .prop_map(|(distance_mm, intensity)| Point { distance_mm, intensity });
    (any::<u16>(), any::<u16>(), uniform12(point), any::<u16>(), any::<u16>()).prop_map(
        |(speed_degps, start_cdeg, points, end_cdeg, clock_ms)| Packet {
            speed_degps,
            start_cdeg,
            points,
            end_cdeg,
            clock_ms,
        },
    )
}

proptest! {
    #[test]
    fn what_is_written_is_read(packet in packet(), noise in vec(0..0x54_u8, 0..30), cut in 0..77_usize) {
        let stream = [&noise[..], &packet.encode()].concat();
        let mut decoder = Decoder::new();
        let cut = cut.min(stream.len());
        let mut found = packets(&mut decoder, &stream[..cut]);
        found.extend(packets(&mut decoder, &stream[cut..]));
        prop_assert_eq!(found, vec![packet]);
        prop_assert_eq!(decoder.n_bytes_skipped(), noise.len() as u64);
    }

    /// Any garbage before loses at most what it swallows: after a packet's length of silence all is found.
    #[test]
    fn garbage_never_hides_what_comes_after(
        garbage in vec(prop_oneof![any::<u8>(), Just(0x54), Just(0x2C)], 0..200), packet in packet(),
    ) {
        let mut decoder = Decoder::new();
        let stream = [&garbage[..], &[0; PACKET_LEN], &packet.encode()].concat();
        let found = packets(&mut decoder, &stream);
        prop_assert_eq!(found.last(), Some(&packet));
        decoder.clear();
        let seen = decoder.n_packets() * PACKET_LEN as u64 + decoder.n_bytes_skipped();
        prop_assert_eq!(seen, stream.len() as u64);
    }

    #[test]
    fn one_wrong_bit_is_noticed(packet in packet(), at in 2..PACKET_LEN, bit in 0..8_u32) {
        let mut bytes = packet.encode();
        bytes[at] ^= 1 << bit;
        let mut decoder = Decoder::new();
        prop_assert!(!packets(&mut decoder, &bytes).contains(&packet));
        prop_assert_eq!(decoder.n_packets(), 0);
    }
}
