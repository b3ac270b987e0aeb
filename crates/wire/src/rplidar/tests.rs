//! Requests and answers of the RPLIDAR A1 as they are published, cut and damaged.

use proptest::{collection::vec, prelude::*};

use super::*;

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect()
}

fn encoded(request: &Request) -> Vec<u8> {
    let mut out = Vec::new();
    request.encode(&mut out);
    out
}

fn requests(decoder: &mut RequestDecoder, bytes: &[u8]) -> Vec<Request> {
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next_request()).collect()
}

fn answers(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Answer> {
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next_answer()).collect()
}

#[test]
fn requests_have_the_published_bytes() {
    let express = Request::Other(0x82, vec![0; 5]);
    let cases = [
        (Request::Stop, "A5 25"),
        (Request::Reset, "A5 40"),
        (Request::Scan, "A5 20"),
        (Request::ForceScan, "A5 21"),
        (Request::Info, "A5 50"),
        (Request::Health, "A5 52"),
        (Request::SampleTimes, "A5 59"),
        (express, "A5 82 05 00 00 00 00 00 22"),
        (Request::MotorPwm(660), "A5 F0 02 94 02 C1"),
        (Request::MotorPwm(0), "A5 F0 02 00 00 57"),
        (Request::MotorPwm(1023), "A5 F0 02 FF 03 AB"),
        (Request::AdapterFlags, "A5 FF 04 00 00 00 00 5E"),
    ];
    let mut decoder = RequestDecoder::new();
    for (request, hex) in cases {
        assert_eq!(encoded(&request), bytes(hex), "{request:?}");
        assert_eq!(requests(&mut decoder, &bytes(hex)), [request]);
    }
    assert_eq!((decoder.n_requests(), decoder.n_bytes_skipped()), (12, 0));
}

#[test]
fn descriptors_have_the_published_bytes() {
    let cases = [
        (AnswerKind::Nodes, "A5 5A 05 00 00 40 81"),
        (AnswerKind::Info, "A5 5A 14 00 00 00 04"),
        (AnswerKind::Health, "A5 5A 03 00 00 00 06"),
        (AnswerKind::SampleTimes, "A5 5A 04 00 00 00 15"),
        (AnswerKind::AdapterFlags, "A5 5A 04 00 00 00 FF"),
    ];
    for (kind, hex) in cases {
        assert_eq!(kind.descriptor().to_vec(), bytes(hex), "{kind:?}");
        let found = answers(&mut Decoder::new(), &bytes(hex));
        assert_eq!(found, [Answer::Announced(kind)]);
    }
}

#[test]
fn nodes_have_the_published_bytes() {
    let node = |is_first, quality, angle_q6, distance_q2| Node {
        is_first,
        quality,
        angle_q6,
        distance_q2,
    };
    let cases = [
        (node(true, 15, 32, 4000), "3D 41 00 A0 0F"),
        (node(false, 47, 90 * 64, 10_001), "BE 01 2D 11 27"),
        (node(false, 0, 23_039, 0), "02 FF B3 00 00"),
    ];
    for (node, hex) in cases {
        assert_eq!(node.encode().to_vec(), bytes(hex), "{node:?}");
        assert_eq!(Node::decode(node.encode()), Some(node));
    }
    // S = ¬S, no check bit, an angle beyond the turn.
    for hex in ["3F 41 00 A0 0F", "3C 41 00 A0 0F", "3D 40 00 A0 0F", "3D 01 B4 A0 0F"] {
        assert_eq!(Node::decode(bytes(hex).try_into().unwrap()), None, "{hex}");
    }
}

#[test]
fn a_session_is_read_in_order() {
    let info =
        Info { model: 0x18, firmware_minor: 24, firmware_major: 1, hardware: 5, serial: [7; 16] };
    let health = Health { status: 1, error: 0x8002 };
    let times = SampleTimes { standard_us: 508, express_us: 254 };
    let node = Node { is_first: true, quality: 15, angle_q6: 32, distance_q2: 4000 };
    let stream = [
        &AnswerKind::Info.descriptor()[..],
        &info.encode(),
        &AnswerKind::Health.descriptor(),
        &health.encode(),
        &AnswerKind::SampleTimes.descriptor(),
        &times.encode(),
        &AnswerKind::Nodes.descriptor(),
        &node.encode(),
        &node.encode(),
    ]
    .concat();
    let expected = [
        Answer::Announced(AnswerKind::Info),
        Answer::Info(info),
        Answer::Announced(AnswerKind::Health),
        Answer::Health(health),
        Answer::Announced(AnswerKind::SampleTimes),
        Answer::SampleTimes(times),
        Answer::Announced(AnswerKind::Nodes),
        Answer::Node(node),
        Answer::Node(node),
    ];
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for byte in stream {
        found.extend(answers(&mut decoder, &[byte]));
    }
    assert_eq!(found, expected);
    assert_eq!((decoder.n_answers(), decoder.n_nodes(), decoder.n_bytes_skipped()), (3, 2, 0));
}

/// A lost byte costs the node that it was of, and at most a few more until the check bits fit.
#[test]
fn a_lost_byte_costs_few_samples() {
    let node = |i: u16| Node {
        is_first: i == 0,
        quality: 12,
        angle_q6: i * 64,
        distance_q2: 4 * 1700 + i,
    };
    let mut stream = AnswerKind::Nodes.descriptor().to_vec();
    for i in 0..100 {
        stream.extend(node(i).encode());
    }
    stream.remove(7 + 50 * 5 + 2);
    let mut decoder = Decoder::new();
    let found = answers(&mut decoder, &stream);
    let good = (0..100).filter(|&i| found.contains(&Answer::Node(node(i)))).count();
    assert!(good >= 96, "{good}");
    assert!(decoder.n_bytes_skipped() >= 4);
}

#[test]
fn samples_after_a_stop_are_skipped_until_the_next_answer() {
    let node = Node { is_first: false, quality: 9, angle_q6: 640, distance_q2: 4000 };
    let mut decoder = Decoder::new();
    let scan = [&AnswerKind::Nodes.descriptor()[..], &node.encode()].concat();
    assert_eq!(answers(&mut decoder, &scan).len(), 2);
    assert!(decoder.is_scanning());
    decoder.expect_descriptor();
    let late = [&node.encode()[..], &node.encode()[..3], &AnswerKind::Health.descriptor(), &[0; 3]];
    let found = answers(&mut decoder, &late.concat());
    assert_eq!(
        found,
        [Answer::Announced(AnswerKind::Health), Answer::Health(Health { status: 0, error: 0 })]
    );
    assert_eq!(decoder.n_bytes_skipped(), 8);
}

#[test]
fn damaged_requests_are_counted() {
    let mut decoder = RequestDecoder::new();
    let mut damaged = encoded(&Request::MotorPwm(660));
    damaged[3] ^= 1;
    damaged.extend(encoded(&Request::Info));
    assert_eq!(requests(&mut decoder, &damaged), [Request::Info]);
    assert_eq!((decoder.n_bad_checksums(), decoder.n_bytes_skipped()), (1, 6));
    // Half a request waits, and is given up.
    assert_eq!(requests(&mut decoder, &[0xA5, 0xF0, 200, 1, 2]), []);
    assert!(decoder.give_up_unfinished());
    assert_eq!(requests(&mut decoder, &encoded(&Request::Stop)), [Request::Stop]);
    assert!(!decoder.give_up_unfinished());
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        Just(Request::Stop),
        Just(Request::Scan),
        Just(Request::AdapterFlags),
        any::<u16>().prop_map(Request::MotorPwm),
        (0x80..0xA5_u8, vec(any::<u8>(), 0..40)).prop_map(|(c, p)| Request::Other(c, p)),
    ]
}

proptest! {
    #[test]
    fn requests_survive_cuts(asked in vec(request(), 1..8), cut in 0..100_usize) {
        let stream: Vec<u8> = asked.iter().flat_map(encoded).collect();
        let (head, tail) = stream.split_at(cut.min(stream.len()));
        let mut decoder = RequestDecoder::new();
        let mut found = requests(&mut decoder, head);
        found.extend(requests(&mut decoder, tail));
        prop_assert_eq!(found, asked);
    }

    #[test]
    fn nodes_survive_cuts(
        samples in vec((any::<bool>(), 0..64_u8, 0..TURN_Q6, any::<u16>()), 0..60), cut in 0..300_usize,
    ) {
        let nodes: Vec<Node> = samples
            .into_iter()
            .map(|(is_first, quality, angle_q6, distance_q2)| Node {
                is_first, quality, angle_q6, distance_q2,
            })
            .collect();
        let body = nodes.iter().flat_map(Node::encode);
        let stream: Vec<u8> = AnswerKind::Nodes.descriptor().into_iter().chain(body).collect();
        let (head, tail) = stream.split_at(cut.min(stream.len()));
        let mut decoder = Decoder::new();
        let mut found = answers(&mut decoder, head);
        found.extend(answers(&mut decoder, tail));
        let expected: Vec<Answer> = std::iter::once(Answer::Announced(AnswerKind::Nodes))
            .chain(nodes.into_iter().map(Answer::Node))
            .collect();
        prop_assert_eq!(found, expected);
        prop_assert_eq!(decoder.n_bytes_skipped(), 0);
    }

    /// Whatever came before, a descriptor after a request is found.
    #[test]
    fn a_descriptor_is_found_in_noise(
        noise in vec(prop_oneof![any::<u8>(), Just(0xA5), Just(0x5A)], 0..100), status in 0..3_u8,
    ) {
        let mut decoder = Decoder::new();
        answers(&mut decoder, &noise);
        decoder.clear();
        decoder.expect_descriptor();
        let health = Health { status, error: 7 };
        let stream = [&noise[..], &[0; 24], &AnswerKind::Health.descriptor(), &health.encode()];
        let found = answers(&mut decoder, &stream.concat());
        prop_assert_eq!(found.last(), Some(&Answer::Health(health)));
    }
}
