//! The pheromone client against a server written in the test.

use std::time::Duration;

use geometry::{Se2, Transform2};
use messages::{Command, Observations, Sensed, Smell};
use run_context::{RunSeed, Stamp};
use wire::{
    dle::{ByteOrder, Framing, Receiver},
    link::{End, Link, LinkConfig},
    pheromone_link::{Reply, Request},
};

use crate::{PheromoneClient, PheromoneClientConfig};

fn query(query: u8, x_m: f64, y_m: f64, yaw_rad: f64) -> Command {
    Command::QueryPheromones { query, map_from_base: Transform2::new(Se2::new(x_m, y_m, yaw_rad)) }
}

fn requests(bytes: &[u8]) -> Vec<Request> {
    let mut receiver = Receiver::default();
    bytes
        .iter()
        .filter_map(|&b| {
            receiver.push(b).map(|p| Request::decode(p, ByteOrder::BigEndian).unwrap())
        })
        .collect()
}

fn framed(reply: Reply) -> Vec<u8> {
    let mut out = Vec::new();
    reply.encode(Framing::Stuffed, &mut out);
    out
}

struct Bench {
    client: PheromoneClient,
    seen: Observations,
    out: Vec<u8>,
}

impl Bench {
    fn new() -> Self {
        let client = PheromoneClient::new(PheromoneClientConfig::default());
        Self { client, seen: Observations::new(), out: Vec::new() }
    }

    /// What it asks when given that command.
    fn ask(&mut self, millis: u64, command: &Command) -> Vec<Request> {
        self.out.clear();
        self.client.command(Stamp::from_millis(millis), command, &mut self.out);
        requests(&self.out)
    }

    /// What it asks when it hears that.
    fn hear(&mut self, millis: u64, bytes: &[u8]) -> Vec<Request> {
        self.out.clear();
        self.client.step(Stamp::from_millis(millis), bytes, &mut self.seen, &mut self.out);
        requests(&self.out)
    }
}

#[test]
fn a_question_carries_the_pose_in_millimetres_and_degrees() {
    let mut bench = Bench::new();
    let asked = bench.ask(0, &query(9, 0.3, -0.2, std::f64::consts::FRAC_PI_2));
    let expected = Request { opcode: 1, robot_id: 1, x_mm: 300, y_mm: -200, heading_deg: 90 };
    assert_eq!(asked, [expected]);
    let mut far = Bench::new();
    let asked = far.ask(0, &query(9, 99.0, -99.0, -1.0)).pop().unwrap();
    assert_eq!((asked.x_mm, asked.y_mm, asked.heading_deg), (i16::MAX, i16::MIN, -57));
    assert_eq!(far.ask(0, &Command::Stop), []);
}

#[test]
fn an_answer_is_about_the_time_of_its_question() {
    let mut bench = Bench::new();
    let request = bench.ask(100, &query(42, 0.0, 0.0, 0.0)).pop().unwrap();
    bench.hear(160, &framed(request.reply(74, 16)));
    let value = Sensed::Smell(Smell { query: 42, left: 74.0, right: 16.0 });
    let seen: Vec<_> = bench.seen.iter().map(|o| (o.about, o.value)).collect();
    assert_eq!(seen, [(Stamp::from_millis(100), value)]);
    assert!(!bench.client.is_waiting());
}

#[test]
fn one_question_is_under_way_and_the_newest_waits() {
    let mut bench = Bench::new();
    let first = bench.ask(0, &query(1, 1.0, 0.0, 0.0)).pop().unwrap();
    assert_eq!(bench.ask(10, &query(2, 2.0, 0.0, 0.0)), []);
    assert_eq!(bench.ask(20, &query(3, 3.0, 0.0, 0.0)), []);
    let next = bench.hear(30, &framed(first.reply(1, 2)));
    assert_eq!(next.iter().map(|request| request.x_mm).collect::<Vec<_>>(), [3000]);
    let counters = bench.client.counters();
    assert_eq!((counters.n_asked, counters.n_answered, counters.n_replaced), (2, 1, 1));
}

#[test]
fn late_and_foreign_replies_are_dropped() {
    let mut bench = Bench::new();
    let first = bench.ask(0, &query(1, 0.0, 0.0, 0.0)).pop().unwrap();
    bench.hear(390, &[]);
    assert!(bench.client.is_waiting());
    bench.hear(400, &[]);
    assert!(!bench.client.is_waiting());
    let second = bench.ask(410, &query(2, 0.0, 0.0, 0.0)).pop().unwrap();
    bench.hear(420, &framed(first.reply(9, 9)));
    bench.hear(430, &framed(Reply { robot_id: 7, ..second.reply(9, 9) }));
    bench.hear(430, &framed(second.reply(9, 9))[..4]);
    assert!(bench.seen.is_empty());
    bench.hear(435, &framed(second.reply(5, 6)));
    bench.hear(440, &framed(second.reply(5, 6)));
    bench.hear(445, &framed(second.reply(5, 6)));
    assert_eq!(bench.seen.len(), 1);
    let counters = bench.client.counters();
    assert_eq!((counters.n_timeouts, counters.n_answered), (1, 1));
    assert!(counters.n_dropped >= 3, "{counters:?}");
}

/// The thesis, 7.4: at 9600 baud a question and its answer take 27.1 ms on the wire, so that with
/// 20 ms latency each way several fit a control period of 200 ms.
#[test]
fn a_round_trip_at_9600_baud_fits_the_control_period() {
    let config = LinkConfig {
        baud: Some(9600),
        latency: Duration::from_millis(20),
        ..LinkConfig::default()
    };
    let mut link = Link::new(&config, RunSeed(1).stream("radio")).unwrap();
    let (mut bench, mut server) = (Bench::new(), Receiver::default());
    let (mut asked_at, mut longest) = (Stamp::ZERO, Duration::ZERO);
    for tick in 0..500 {
        let now = Stamp::from_millis(10 * tick);
        let mut heard = Vec::new();
        link.receive(End::B, now, &mut heard);
        for byte in heard {
            if let Some(payload) = server.push(byte) {
                let request = Request::decode(payload, ByteOrder::BigEndian).unwrap();
                link.send(End::B, now, &framed(request.reply(10, 16)));
            }
        }
        let mut received = Vec::new();
        link.receive(End::A, now, &mut received);
        bench.hear(10 * tick, &received);
        if !bench.client.is_waiting() {
            longest = longest.max(now.since(asked_at));
            asked_at = now;
            bench.ask(10 * tick, &query(0, 4.096, 0.1, 0.0));
            link.send(End::A, now, &bench.out);
        }
    }
    let counters = bench.client.counters();
    assert!(counters.n_answered >= 50 && counters.n_timeouts == 0, "{counters:?}");
    assert!(longest <= Duration::from_millis(100), "{longest:?}");
}
