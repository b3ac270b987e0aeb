//! Telegrams of the SICK LMS as they are published, cut and damaged.

use proptest::{collection::vec, prelude::*};

use super::*;

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect()
}

fn asked(request: &Request) -> Vec<u8> {
    let mut out = Vec::new();
    request.encode(0, &mut out);
    out
}

/// Everything found: telegrams with address and payload, bare bytes by themselves.
fn found(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Vec<u8>> {
    decoder.push(bytes);
    let mut all = Vec::new();
    while let Some(item) = decoder.next_item() {
        all.push(match item {
            Item::Ack => vec![ACK],
            Item::Nak => vec![NAK],
            Item::Telegram { address, payload } => [&[address][..], payload].concat(),
        });
    }
    all
}

/// The only telegram in these bytes, without its address.
fn payload(side: Side, bytes: &[u8]) -> Vec<u8> {
    let mut decoder = Decoder::new(side);
    let all = found(&mut decoder, bytes);
    assert_eq!((all.len(), decoder.n_bytes_skipped()), (1, 0), "{bytes:02X?}");
    all[0][1..].to_vec()
}

const HALF_DEGREES: Variant = Variant { angle_deg: 180, resolution_cdeg: 50 };

#[test]
fn the_checksum_has_its_worked_values() {
    // Step by step, and once with a carry.
    let steps = [0x0002, 0x0204, 0x0409, 0x0912, 0x1215];
    for (n, crc) in (1..).zip(steps) {
        assert_eq!(checksum(&bytes("02 00 01 00 31")[..n]), crc);
    }
    assert_eq!(checksum(&bytes("02 00 05 00 3B B4 00 64 00")), 0x4997);
}

#[test]
fn requests_have_the_published_bytes() {
    let variant =
        |angle_deg, resolution_cdeg| Request::Variant(Variant { angle_deg, resolution_cdeg });
    let aria = Config::from_bytes(&bytes(
        "00 00 46 00 00 05 01 00 00 02 02 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00",
    ));
    let aria_telegram =
        format!("02 00 21 00 77 00 00 46 00 00 05 01 00 00 02 02 {}5B 51", "00 ".repeat(21));
    let cases = [
        (Request::Status, "02 00 01 00 31 15 12"),
        (Request::Type, "02 00 01 00 3A 1E 12"),
        (Request::ReadConfig, "02 00 01 00 74 50 12"),
        (Request::Errors, "02 00 01 00 32 16 12"),
        (Request::Baud(Baud::B9600), "02 00 02 00 20 42 52 08"),
        (Request::Baud(Baud::B19200), "02 00 02 00 20 41 51 08"),
        (Request::Baud(Baud::B38400), "02 00 02 00 20 40 50 08"),
        (Request::Baud(Baud::B500000), "02 00 02 00 20 48 58 08"),
        (Request::Continuous, "02 00 02 00 20 24 34 08"),
        (Request::OnRequest, "02 00 02 00 20 25 35 08"),
        (Request::OneScan, "02 00 02 00 30 01 31 18"),
        (variant(180, 100), "02 00 05 00 3B B4 00 64 00 97 49"),
        (variant(180, 50), "02 00 05 00 3B B4 00 32 00 3B 1F"),
        (variant(100, 25), "02 00 05 00 3B 64 00 19 00 E7 72"),
        (variant(100, 100), "02 00 05 00 3B 64 00 64 00 1D 0F"),
        (variant(100, 50), "02 00 05 00 3B 64 00 32 00 B1 59"),
        (Request::INSTALLATION, "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5"),
        (Request::Reset, "02 00 01 00 10 34 12"),
        (Request::WriteConfig(aria.unwrap()), &aria_telegram),
    ];
    for (request, hex) in cases {
        assert_eq!(asked(&request), bytes(hex), "{request:?}");
        assert_eq!(Request::decode(&payload(Side::FromHost, &bytes(hex))), request);
    }
    assert_eq!((aria.unwrap().measuring_mode(), aria.unwrap().unit()), (5, Some(Unit::Mm)));
}

#[test]
fn replies_have_the_published_bytes() {
    let cases = [
        (Reply::Mode(0), STATUS_OK, 0, "02 80 03 00 A0 00 10 16 0A"),
        (Reply::Mode(0), STATUS_OK, 1, "02 81 03 00 A0 00 10 36 1A"),
        (Reply::WillReset, STATUS_OK, 0, "02 80 02 00 91 10 79 30"),
        (
            Reply::Variant(true, HALF_DEGREES),
            STATUS_OK,
            0,
            "02 80 07 00 BB 01 B4 00 32 00 10 03 9D",
        ),
        (Reply::Refused, STATUS_OK, 0, "02 80 02 00 92 10 7F 33"),
        (
            Reply::PowerOn(b"LMS200;301063;V02.06 "),
            0x13,
            1,
            "02 81 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 30 36 20 13 64 5A",
        ),
        (
            Reply::PowerOn(b"LMS200;301063;V02.10 "),
            STATUS_OK,
            0,
            "02 80 17 00 90 4C 4D 53 32 30 30 3B 33 30 31 30 36 33 3B 56 30 32 2E 31 30 20 10 63 5E",
        ),
    ];
    for (reply, status, address, hex) in cases {
        let mut out = Vec::new();
        reply.encode(address, status, &mut out);
        assert_eq!(out, bytes(hex), "{reply:?}");
        let payload = payload(Side::FromDevice, &out);
        assert_eq!(Reply::decode(&payload), Some((reply, status)));
    }
}

#[test]
fn a_scan_has_the_published_bytes() {
    let field = RangeField::of_mode(0).unwrap();
    let values = [0x03E8, 0x1FFF, 0x1FF7, 0x1234, 0];
    let mut payload = Vec::new();
    ScanReply::write(Unit::Mm, values.into_iter(), &mut payload);
    let mut out = Vec::new();
    write_telegram(0x80, &payload, &mut out);
    assert_eq!(out, bytes("02 80 0E 00 B0 05 40 E8 03 FF 1F F7 1F 34 12 00 00 10 53 BC"));
    let Some((Reply::Scan(scan), STATUS_OK)) = Reply::decode(&payload) else { panic!() };
    assert_eq!((scan.unit, scan.part, scan.len()), (Unit::Mm, None, 5));
    let readings: Vec<Reading> = scan.bits().map(|bits| field.decode(bits)).collect();
    let expected = [
        Reading::Range(1000),
        Reading::NoReturn,
        Reading::Beyond,
        Reading::Range(0x1234),
        Reading::Range(0),
    ];
    assert_eq!(readings, expected);
    // A count that does not fit its values is no scan.
    payload[1] = 6;
    assert_eq!(Reply::decode(&payload), Some((Reply::Other(0xB0), STATUS_OK)));
}

/// Frame lengths: 372 for 181 readings, 732 for 361, 812 for 401.
#[test]
fn scans_have_the_published_lengths() {
    let lengths = [(0, 181, 372), (1, 361, 732), (2, 101, 212), (3, 201, 412), (4, 401, 812)];
    for (index, n, len) in lengths {
        let variant = Variant::ALL[index];
        assert_eq!(variant.n_readings(), n);
        let (mut payload, mut out) = (Vec::new(), Vec::new());
        ScanReply::write(Unit::Cm, vec![0; n].into_iter(), &mut payload);
        write_telegram(0x80, &payload, &mut out);
        assert_eq!(out.len(), len);
    }
    assert_eq!(Variant::ALL.map(Variant::n_turns), [1, 2, 1, 2, 4]);
    assert!(!Variant { angle_deg: 180, resolution_cdeg: 25 }.is_known());
}

#[test]
fn a_field_s_greatest_numbers_mean_something_else() {
    let field = RangeField::of_mode(1).unwrap();
    assert_eq!(field.range_max(), 8182);
    let meanings = [
        (8182, Reading::Range(8182)),
        (0x1FF7, Reading::Beyond),
        (0x1FFA, Reading::Invalid),
        (0x1FFB, Reading::WeakSignal),
        (0x1FFD, Reading::Invalid),
        (0x1FFE, Reading::Invalid),
        (0x1FFF, Reading::NoReturn),
        // The bits above are fields and reflectors.
        (0xE000 | 0x004D, Reading::Range(77)),
    ];
    for (bits, reading) in meanings {
        assert_eq!(field.decode(bits), reading, "{bits:04X}");
    }
    let wide = RangeField::of_mode(5).unwrap();
    assert_eq!((wide.range_max(), wide.encode(Reading::NoReturn)), (0x7FF6, 0x7FFF));
    assert_eq!(wide.decode(0x8000 | 0x1FF7), Reading::Range(8183));
    assert_eq!(RangeField::of_mode(3).unwrap().encode(Reading::Range(u16::MAX)), 0x3FF7);
    assert_eq!(RangeField::of_mode(0x3F), None);
}

/// 161 bytes with the bare byte before it, as reported from hardware.
#[test]
fn a_status_has_its_fields_at_the_published_offsets() {
    let status = StatusReply {
        firmware: *b"V02.10 ",
        mode: 0x25,
        is_defective: false,
        measuring_mode: 5,
        variant: HALF_DEGREES,
        baud: Some(Baud::B38400),
        address: 0,
        unit: Some(Unit::Mm),
    };
    let mut out = vec![ACK];
    Reply::Status(status).encode(0, STATUS_OK, &mut out);
    assert_eq!(out.len(), 161);
    let payload = payload(Side::FromDevice, &out[1..]);
    assert_eq!(payload[107..111], bytes("B4 00 32 00"));
    assert_eq!(payload[116..118], bytes("19 80"));
    assert_eq!((payload[8], payload[102], payload[122]), (0x25, 5, 1));
    assert_eq!(Reply::decode(&payload), Some((Reply::Status(status), STATUS_OK)));
}

#[test]
fn bare_bytes_are_told_apart_and_payloads_may_hold_them() {
    let mut stream = vec![ACK];
    let (mut payload, mut decoder) = (Vec::new(), Decoder::new(Side::FromDevice));
    ScanReply::write(Unit::Cm, [0x0602, 0x1506, 0x0202].into_iter(), &mut payload);
    write_telegram(0x80, &payload, &mut stream);
    stream.push(NAK);
    let all = found(&mut decoder, &stream);
    assert_eq!(all[0], [ACK]);
    assert_eq!(all[1][1..], payload);
    assert_eq!(all[2], [NAK]);
    assert_eq!((all.len(), decoder.n_bytes_skipped()), (3, 0));
    // A host sends none.
    let mut host = Decoder::new(Side::FromHost);
    assert_eq!(found(&mut host, &[ACK, NAK]).len(), 0);
    assert_eq!(host.n_bytes_skipped(), 2);
}

#[test]
fn half_and_damaged_telegrams_are_counted_and_the_next_is_found() {
    let whole = asked(&Request::Type);
    let mut damaged = asked(&Request::INSTALLATION);
    damaged[7] ^= 1;
    let mut decoder = Decoder::new(Side::FromHost);
    let all = found(&mut decoder, &[&damaged[..], &whole].concat());
    assert_eq!(all, [[0, 0x3A]]);
    assert_eq!((decoder.n_bad_checksums(), decoder.n_bytes_skipped()), (1, 16));
    // Half of one hides the next until the line falls silent.
    let all = found(&mut decoder, &[&damaged[..9], &whole[..5]].concat());
    assert_eq!(all.len(), 0);
    assert!(decoder.give_up_unfinished());
    assert_eq!(found(&mut decoder, &whole[5..]), [[0, 0x3A]]);
    assert_eq!((decoder.n_unfinished(), decoder.n_telegrams()), (1, 2));
    assert!(!decoder.give_up_unfinished());
}

proptest! {
    #[test]
    fn every_telegram_arrives(
        payloads in vec(vec(any::<u8>(), 1..60), 1..5), address in 0x80_u8.., cut in 0..200_usize,
    ) {
        let mut stream = Vec::new();
        for payload in &payloads {
            write_telegram(address, payload, &mut stream);
        }
        let (head, tail) = stream.split_at(cut.min(stream.len()));
        let mut decoder = Decoder::new(Side::FromDevice);
        let mut all = found(&mut decoder, head);
        all.extend(found(&mut decoder, tail));
        let expected: Vec<_> = payloads.iter().map(|p| [&[address][..], p].concat()).collect();
        prop_assert_eq!(all, expected);
        prop_assert_eq!(decoder.n_bytes_skipped(), 0);
    }

    #[test]
    fn one_wrong_bit_is_noticed(payload in vec(any::<u8>(), 1..60), at in 0..60_usize, bit in 0..8_u32) {
        let mut stream = Vec::new();
        write_telegram(0x80, &payload, &mut stream);
        let at = at % payload.len();
        stream[4 + at] ^= 1 << bit;
        let mut decoder = Decoder::new(Side::FromDevice);
        let all = found(&mut decoder, &stream);
        prop_assert!(!all.iter().any(|one| one.len() > 1 && one[1..].len() == payload.len()));
        prop_assert!(decoder.n_bad_checksums() > 0);
    }

    #[test]
    fn after_garbage_and_silence_a_telegram_is_found(
        garbage in vec(prop_oneof![any::<u8>(), Just(STX), Just(0x80), Just(0)], 0..60),
        payload in vec(any::<u8>(), 1..60),
    ) {
        let mut decoder = Decoder::new(Side::FromDevice);
        let mut stream = garbage;
        write_telegram(0x80, &payload, &mut stream);
        let mut all = found(&mut decoder, &stream);
        while decoder.give_up_unfinished() {
            all.extend(found(&mut decoder, &[]));
        }
        let expected = [&[0x80][..], &payload].concat();
        prop_assert!(all.contains(&expected));
    }

    #[test]
    fn configurations_and_variants_read_back(
        fields in vec(any::<u8>(), 32..=34), ok: bool, angle_deg: u16, resolution_cdeg: u16,
    ) {
        let config = Config::from_bytes(&fields).unwrap();
        let variant = Variant { angle_deg, resolution_cdeg };
        for reply in [Reply::Config(config), Reply::ConfigWritten(ok, config), Reply::Variant(ok, variant)] {
            let mut out = Vec::new();
            reply.encode(3, 0x11, &mut out);
            let payload = payload(Side::FromDevice, &out);
            prop_assert_eq!(Reply::decode(&payload), Some((reply, 0x11)));
        }
        let request = Request::WriteConfig(config);
        let payload = payload(Side::FromHost, &asked(&request));
        prop_assert_eq!(Request::decode(&payload), request);
    }
}
