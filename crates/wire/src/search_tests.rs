//! A toy frame (`7`, length, bytes, their sum) and every decoder, against what finds frames in the whole of the bytes.

use proptest::prelude::*;

use super::*;
use crate::{arcos, create_oi, ld06, rplidar, sick_lms};

fn toy(bytes: &[u8]) -> Found<Vec<u8>> {
    let Some(&len) = bytes.get(1) else { return Found::Unfinished };
    if len > 9 {
        return Found::Noise;
    }
    let whole = usize::from(len) + 3;
    let Some(frame) = bytes.get(..whole) else { return Found::Unfinished };
    let (sum, body) = frame.split_last().unwrap();
    let body = &body[2..];
    if body.iter().fold(0_u8, |s, b| s.wrapping_add(*b)) == *sum {
        Found::Whole(body.to_vec(), whole)
    } else {
        Found::Noise
    }
}

fn framed(body: &[u8]) -> Vec<u8> {
    let sum = body.iter().fold(0_u8, |s, b| s.wrapping_add(*b));
    [&[7, u8::try_from(body.len()).unwrap()], body, &[sum]].concat()
}

/// Frames in bytes that are all there, by plain recursion from the front; and what is left over as noise.
fn by_hand(bytes: &[u8]) -> (Vec<Vec<u8>>, usize) {
    let mut frames = Vec::new();
    let (mut at, mut n_noise) = (0, 0);
    while at < bytes.len() {
        match (bytes[at] == 7).then(|| toy(&bytes[at..])) {
            Some(Found::Whole(body, len)) => {
                frames.push(body);
                at += len;
            }
            Some(Found::Unfinished) => break,
            Some(Found::Noise) | None => {
                n_noise += 1;
                at += 1;
            }
        }
    }
    (frames, n_noise)
}

/// Pieces of a stream: frames, damaged frames, noise with many headers in it.
fn stream() -> impl Strategy<Value = Vec<u8>> {
    let body = prop::collection::vec(0_u8..20, 0..9);
    let piece = prop_oneof![
        3 => body.clone().prop_map(|body| framed(&body)),
        1 => (body, any::<prop::sample::Index>(), any::<u8>()).prop_map(|(body, at, byte)| {
            let mut bytes = framed(&body);
            let at = at.index(bytes.len());
            bytes[at] = byte;
            bytes
        }),
        1 => prop::collection::vec(prop_oneof![Just(7_u8), 0_u8..12], 0..12),
    ];
    prop::collection::vec(piece, 0..30).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn however_bytes_are_cut_the_same_frames_and_noise_are_found(
        bytes in stream(),
        cuts in prop::collection::vec(1_usize..9, 1..40),
    ) {
        let (frames, n_noise) = by_hand(&bytes);
        let mut search = Search::keeping(1 << 14);
        let mut found = Vec::new();
        let (mut rest, mut cuts) = (&bytes[..], cuts.iter().cycle());
        while !rest.is_empty() {
            let (part, behind) = rest.split_at(rest.len().min(*cuts.next().unwrap()));
            search.push(part);
            found.extend(std::iter::from_fn(|| search.next(|byte| byte == 7, toy)));
            rest = behind;
        }
        prop_assert_eq!(found, frames);
        prop_assert_eq!(search.n_skipped(), n_noise as u64);
    }

    /// Each real decoder finds what it finds in one piece, in pieces too, and no byte is lost without being counted.
    #[test]
    fn every_decoder_finds_the_same_however_bytes_are_cut(
        noise in prop::collection::vec(
            prop_oneof![Just(0xFA_u8), Just(0xFB), Just(19), Just(0x54), Just(0x2C), Just(0xA5), Just(2), any::<u8>()],
            0..60,
        ),
        damage in prop::option::of((any::<prop::sample::Index>(), any::<u8>())),
        cuts in prop::collection::vec(1_usize..50, 1..20),
    ) {
        let mut bytes = noise.clone();
        arcos::Sip::AT_REST.encode(&mut bytes);
        create_oi::write_frame(&[7, 19, 14], &create_oi::Readings::default(), &mut bytes);
        bytes.extend(ld06::Packet::default().encode());
        rplidar::Request::MotorPwm(600).encode(&mut bytes);
        sick_lms::Request::Status.encode(0, &mut bytes);
        bytes.extend(&noise);
        if let Some((at, byte)) = damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let (whole, pieces) = (all(&[&bytes]), all(&parts(&bytes, &cuts)));
        prop_assert_eq!(&whole, &pieces);
        for (name, found, n_understood, n_skipped, n_waiting) in whole {
            let n = n_understood + n_skipped + n_waiting;
            prop_assert_eq!(n, bytes.len() as u64, "{} {:?}", name, found);
        }
    }
}

fn parts<'b>(bytes: &'b [u8], cuts: &[usize]) -> Vec<&'b [u8]> {
    let (mut rest, mut cuts, mut parts) = (bytes, cuts.iter().cycle(), Vec::new());
    while !rest.is_empty() {
        let (part, behind) = rest.split_at(rest.len().min(*cuts.next().unwrap()));
        parts.push(part);
        rest = behind;
    }
    parts
}

/// Name, what was found, bytes understood, skipped, and still waiting.
type Result = (&'static str, Vec<String>, u64, u64, u64);

fn all(parts: &[&[u8]]) -> Vec<Result> {
    let mut pioneer = arcos::Decoder::new();
    let mut create = create_oi::StreamDecoder::new();
    let mut lidar = ld06::Decoder::new();
    let mut requests = rplidar::RequestDecoder::new();
    let mut host = sick_lms::Decoder::new(sick_lms::Side::FromHost);
    let mut found: [Vec<String>; 5] = Default::default();
    let mut n = [0_usize; 5];
    for part in parts {
        pioneer.push(part);
        while let Some(packet) = pioneer.next_packet() {
            n[0] += packet.body().len() + 5;
            found[0].push(format!("{packet:?}"));
        }
        create.push(part);
        while let Some(frame) = create.next_frame() {
            n[1] += frame.n_bytes;
            found[1].push(format!("{frame:?}"));
        }
        lidar.push(part);
        while let Some(packet) = lidar.next_packet() {
            n[2] += ld06::PACKET_LEN;
            found[2].push(format!("{packet:?}"));
        }
        requests.push(part);
        while let Some(request) = requests.next_request() {
            let mut bytes = Vec::new();
            request.encode(&mut bytes);
            n[3] += bytes.len();
            found[3].push(format!("{request:?}"));
        }
        host.push(part);
        while let Some(item) = host.next_item() {
            if let sick_lms::Item::Telegram { payload, .. } = item {
                n[4] += payload.len() + 6;
            }
            found[4].push(format!("{item:?}"));
        }
    }
    let [a, b, c, d, e] = found;
    let skipped = [
        pioneer.bytes_skipped(),
        create.bytes_skipped(),
        lidar.n_bytes_skipped(),
        requests.n_bytes_skipped(),
        host.n_bytes_skipped(),
    ];
    let waiting = [
        pioneer.n_unread(),
        create.n_unread(),
        lidar.n_unread(),
        requests.n_unread(),
        host.n_unread(),
    ];
    let names = ["arcos", "create", "ld06", "rplidar", "sick"];
    let rows = names.into_iter().zip([a, b, c, d, e]).zip(n).zip(skipped).zip(waiting);
    rows.map(|((((name, found), n), s), w)| (name, found, n as u64, s, w as u64)).collect()
}

#[test]
fn a_damaged_length_is_given_up_and_what_it_hid_is_found() {
    let mut search = Search::new();
    search.push(&[7, 9, 1]);
    search.push(&framed(&[3]));
    assert!(search.next(|byte| byte == 7, toy).is_none());
    assert!(search.has_unfinished() && search.give_up_unfinished());
    assert_eq!(search.next(|byte| byte == 7, toy), Some(vec![3]));
    assert_eq!(search.n_skipped(), 3);
    assert!(!search.give_up_unfinished());
}

#[test]
fn no_more_bytes_wait_than_may() {
    let mut search = Search::keeping(1 << 14);
    search.push(&vec![7; 100_000]);
    assert_eq!((search.unread().len(), search.n_skipped()), (1 << 14, 100_000 - (1 << 14)));
    search.push(&[1, 2, 3]);
    assert_eq!((search.unread().len(), search.unread().last()), (1 << 14, Some(&3)));
    assert!(search.capacity() < 1 << 17, "{}", search.capacity());
    search.skip_all();
    assert_eq!(search.n_skipped(), 100_003);
    search.push(&[1, 2, 3]);
    search.clear();
    assert_eq!((search.n_skipped(), search.unread()), (100_003, &[][..]));
}
