//! The bytes of scanning lasers.

use wire::{
    ld06, rplidar,
    sick_lms::{self, Item, Reply, Request, Side},
};

use crate::shown;

/// Packets of an LD06: found in the same places however the bytes are cut; each byte is part of a packet,
/// skipped or waiting; each packet is written as it was read.
pub fn ld06_decoder(bytes: &[u8]) {
    let decode = |pieces: [&[u8]; 2]| {
        let mut decoder = ld06::Decoder::new();
        let mut packets = Vec::new();
        for piece in pieces {
            decoder.push(piece);
            packets.extend(std::iter::from_fn(|| decoder.next_packet()));
        }
        decoder.clear();
        (packets, decoder.n_bytes_skipped(), decoder.n_bad_checksums())
    };
    let (head, tail) = bytes.split_at(bytes.len() / 2);
    let whole = decode([bytes, &[]]);
    assert_eq!(whole, decode([head, tail]), "a cut changes what is found");
    let (packets, n_skipped, _) = whole;
    let n_read = packets.len() * ld06::PACKET_LEN;
    assert_eq!(n_read as u64 + n_skipped, bytes.len() as u64, "a byte is not accounted for");
    for packet in packets {
        let again = packet.encode();
        assert!(bytes.windows(again.len()).any(|window| window == again));
        assert!((0..12).all(|index| (0.0..720.0).contains(&packet.angle_deg(index))));
    }
}

/// An RPLIDAR's answers, and a host's requests to it.
pub fn rplidar_decoder(bytes: &[u8]) {
    let (head, tail) = bytes.split_at(bytes.len() / 2);
    let answers = |pieces: [&[u8]; 2]| {
        let mut decoder = rplidar::Decoder::new();
        let mut found = Vec::new();
        for piece in pieces {
            decoder.push(piece);
            found.extend(std::iter::from_fn(|| decoder.next_answer()));
        }
        decoder.clear();
        (found, decoder.n_bytes_skipped())
    };
    let whole = answers([bytes, &[]]);
    assert_eq!(whole, answers([head, tail]), "a cut changes what is found");
    for answer in whole.0 {
        if let rplidar::Answer::Node(node) = answer {
            assert_eq!(rplidar::Node::decode(node.encode()), Some(node));
        }
    }
    let mut decoder = rplidar::RequestDecoder::new();
    decoder.push(bytes);
    loop {
        while let Some(request) = decoder.next_request() {
            let mut again = Vec::new();
            request.encode(&mut again);
            assert!(again.len() >= 2);
        }
        if !decoder.give_up_unfinished() {
            break;
        }
    }
    assert!(decoder.n_bytes_skipped() <= bytes.len() as u64);
}

/// Telegrams of a SICK LMS, from the device and from its host.
pub fn sick_decoder(bytes: &[u8]) {
    let (head, tail) = bytes.split_at(bytes.len() / 2);
    for side in [Side::FromHost, Side::FromDevice] {
        let decode = |pieces: [&[u8]; 2]| {
            let mut decoder = sick_lms::Decoder::new(side);
            let mut found: Vec<Option<Vec<u8>>> = Vec::new();
            for piece in pieces {
                decoder.push(piece);
                while let Some(item) = decoder.next_item() {
                    found.push(match item {
                        Item::Telegram { payload, .. } => Some(payload.to_vec()),
                        Item::Ack | Item::Nak => None,
                    });
                }
            }
            (found, decoder.n_bytes_skipped(), decoder.n_bad_checksums())
        };
        let whole = decode([bytes, &[]]);
        assert_eq!(whole, decode([head, tail]), "a cut changes what is found");
        for payload in whole.0.iter().flatten() {
            understood(payload);
        }
        let mut decoder = sick_lms::Decoder::new(side);
        decoder.push(bytes);
        loop {
            while decoder.next_item().is_some() {}
            if !decoder.give_up_unfinished() {
                break;
            }
        }
        assert!(!decoder.has_unfinished());
    }
}

fn understood(payload: &[u8]) {
    let request = Request::decode(payload);
    let mut again = Vec::new();
    request.encode(0, &mut again);
    assert!(!again.is_empty());
    if let Some((reply, status)) = Reply::decode(payload) {
        shown(&reply);
        if let Reply::Scan(scan) = reply {
            assert_eq!(scan.bits().count(), scan.len());
        } else {
            reply.encode(0, status, &mut again);
        }
    }
}
