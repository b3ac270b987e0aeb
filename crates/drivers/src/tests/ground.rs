//! Ground station and vehicle, at the two ends of a link.

use std::time::Duration;

use navigator::{Command, FailureReason, GroundCommand, Observation, Report, Sensed};
use run_context::{RunSeed, Stamp};
use wire::{
    ground_link::{ToGround, ToVehicle},
    link::{End, Link, LinkConfig},
};

use crate::{
    GroundClient, GroundLinkConfig, GroundStation, GroundStationEvent, failure_code, failure_text,
};

const GOAL: ToVehicle = ToVehicle::GoTo { x_mm: 5000, y_mm: -3500, heading_deg: Some(45) };

struct Bench {
    station: GroundStation,
    vehicle: GroundClient,
    link: Link,
    now: Stamp,
    events: Vec<GroundStationEvent>,
    seen: Vec<Observation>,
}

impl Bench {
    fn new(link: &LinkConfig, seed: u64) -> Self {
        Self {
            station: GroundStation::new(GroundLinkConfig::default()),
            vehicle: GroundClient::new(GroundLinkConfig::default()),
            link: Link::new(link, RunSeed(seed).stream("radio")).unwrap(),
            now: Stamp::ZERO,
            events: Vec::new(),
            seen: Vec::new(),
        }
    }

    fn order(&mut self, order: ToVehicle) {
        let mut out = Vec::new();
        self.station.send(self.now, order, &mut out);
        self.link.send(End::A, self.now, &out);
    }

    fn report(&mut self, report: Report) {
        let mut out = Vec::new();
        self.vehicle.command(self.now, &Command::Report(report), &mut out);
        self.link.send(End::B, self.now, &out);
    }

    fn pass_ms(&mut self, millis: u64) {
        for _ in 0..millis / 10 {
            let (mut received, mut out) = (Vec::new(), Vec::new());
            self.link.receive(End::B, self.now, &mut received);
            self.vehicle.step(self.now, &received, &mut self.seen, &mut out);
            self.link.send(End::B, self.now, &out);
            received.clear();
            out.clear();
            self.link.receive(End::A, self.now, &mut received);
            self.station.step(self.now, &received, &mut self.events, &mut out);
            self.link.send(End::A, self.now, &out);
            self.now += Duration::from_millis(10);
        }
    }

    fn heard(&self) -> Vec<ToGround> {
        self.events
            .iter()
            .filter_map(|e| if let GroundStationEvent::Heard(m) = e { Some(*m) } else { None })
            .collect()
    }

    fn orders_seen(&self) -> Vec<GroundCommand> {
        self.seen
            .iter()
            .filter_map(|o| if let Sensed::Ground(order) = o.value { Some(order) } else { None })
            .collect()
    }
}

#[test]
fn a_goal_reaches_the_navigator_once_and_is_acknowledged_once() {
    let mut bench = Bench::new(&LinkConfig { baud: Some(9600), ..LinkConfig::default() }, 1);
    bench.order(GOAL);
    bench.pass_ms(100);
    let orders = bench.orders_seen();
    let [GroundCommand::GoTo { goal_in_map }] = orders.as_slice() else { panic!("{orders:?}") };
    let goal = goal_in_map.se2();
    assert!((goal.x_m - 5.0).abs() < 1e-12 && (goal.y_m + 3.5).abs() < 1e-12);
    assert!((goal.yaw_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    // The navigator's own report of state 1 is the acknowledgement already sent.
    for state in [1, 2, 3, 1] {
        bench.report(Report::StateEntered(state));
        bench.pass_ms(50);
    }
    bench.report(Report::Arrived);
    bench.pass_ms(50);
    let states = [1, 2, 3, 1].map(ToGround::State);
    assert_eq!(bench.heard(), [&states[..], &[ToGround::Arrived]].concat());
    assert_eq!(bench.station.unanswered(), None);
    // After the arrival the same goal is a new order.
    bench.order(GOAL);
    bench.pass_ms(100);
    assert_eq!(bench.orders_seen().len(), 2);
}

#[test]
fn over_a_bad_line_the_order_comes_through_and_is_obeyed_once() {
    let line = LinkConfig {
        baud: Some(9600),
        loss_prob: 0.01,
        corruption_prob: 0.01,
        ..LinkConfig::default()
    };
    // A goal gets through and is answered with probability 0.98²⁰ = 0.66 at each of five tries.
    let mut n_answered = 0;
    for seed in 0..100 {
        let mut bench = Bench::new(&line, seed);
        bench.order(GOAL);
        bench.pass_ms(6000);
        n_answered += usize::from(!bench.events.contains(&GroundStationEvent::Unanswered(GOAL)));
        // Whatever the line did to it: the goal comes once and undamaged, or not at all.
        let orders = bench.orders_seen();
        let goals: Vec<_> =
            orders.iter().filter(|order| matches!(order, GroundCommand::GoTo { .. })).collect();
        assert!(goals.len() <= 1, "seed {seed}: {goals:?}");
        for goal in goals {
            let GroundCommand::GoTo { goal_in_map } = goal else { continue };
            assert!((goal_in_map.se2().x_m - 5.0).abs() < 1e-12, "seed {seed}: {goal:?}");
        }
    }
    assert!(n_answered >= 95, "{n_answered}");
}

#[test]
fn an_order_nobody_answers_is_given_up() {
    let mut bench = Bench::new(&LinkConfig { loss_prob: 1.0, ..LinkConfig::default() }, 1);
    bench.order(GOAL);
    bench.pass_ms(4900);
    assert_eq!(bench.events, []);
    bench.pass_ms(200);
    assert_eq!(bench.events, [GroundStationEvent::Unanswered(GOAL)]);
    // Five times 14 bytes: header 4, eight of payload of which none is a DLE, end 2.
    assert_eq!(bench.link.counters(End::A).n_sent, 5 * 14);
}

#[test]
fn stop_is_said_twice_and_makes_the_next_goal_new() {
    let mut bench = Bench::new(&LinkConfig::default(), 1);
    bench.order(GOAL);
    bench.pass_ms(50);
    bench.order(ToVehicle::Stop);
    bench.pass_ms(50);
    bench.order(GOAL);
    bench.pass_ms(50);
    let orders = bench.orders_seen();
    assert!(matches!(
        orders.as_slice(),
        [
            GroundCommand::GoTo { .. },
            GroundCommand::Stop,
            GroundCommand::Stop,
            GroundCommand::GoTo { .. }
        ]
    ));
}

#[test]
fn stop_is_repeated_until_it_is_answered_however_long_the_link_is_cut() {
    let mut bench = Bench::new(&LinkConfig { baud: Some(9600), ..LinkConfig::default() }, 1);
    bench.order(GOAL);
    bench.pass_ms(100);
    for end in [End::A, End::B] {
        bench.events.clear();
        bench.seen.clear();
        bench.link.set_cut(end, true);
        bench.order(ToVehicle::Stop);
        bench.pass_ms(20_000);
        // It was said in time that nobody answers, once.
        assert_eq!(bench.events, [GroundStationEvent::Unanswered(ToVehicle::Stop)]);
        // Whether the order or only its answer is lost: it is never the ground that gives up.
        assert_eq!(bench.seen.is_empty(), end == End::A);
        bench.link.set_cut(end, false);
        bench.pass_ms(400);
        assert_eq!(bench.orders_seen().last(), Some(&GroundCommand::Stop));
        assert_eq!(bench.station.unanswered(), None);
        let n_sent = bench.link.counters(End::A).n_sent;
        bench.pass_ms(5000);
        assert_eq!(bench.link.counters(End::A).n_sent, n_sent);
    }
}

/// Twice at once is not enough on a bad line: of a hundred stops some were lost for good.
#[test]
fn over_a_bad_line_every_stop_comes_through() {
    let line = LinkConfig {
        baud: Some(9600),
        loss_prob: 0.03,
        corruption_prob: 0.03,
        ..LinkConfig::default()
    };
    for seed in 0..100 {
        let mut bench = Bench::new(&line, seed);
        bench.order(ToVehicle::Stop);
        bench.pass_ms(6000);
        assert!(bench.orders_seen().contains(&GroundCommand::Stop), "seed {seed}");
        assert_eq!(bench.station.unanswered(), None, "seed {seed}");
    }
}

#[test]
fn the_other_orders_have_their_answers() {
    let mut bench = Bench::new(&LinkConfig::default(), 1);
    bench.order(ToVehicle::Restart);
    bench.pass_ms(50);
    assert_eq!(bench.heard(), [ToGround::Restarted]);
    bench.order(ToVehicle::LinkTest);
    bench.pass_ms(50);
    bench.report(Report::LinkEcho);
    bench.pass_ms(50);
    bench.order(ToVehicle::ReportSonar);
    bench.pass_ms(50);
    bench.report(Report::Sonar([0.5, 1.0, 1.234, 5.0, 5.0, 5.0, 999.0, 0.0]));
    bench.pass_ms(50);
    let sonar = ToGround::Sonar([50, 100, 123, 500, 500, 500, 65_535, 0]);
    assert_eq!(bench.heard(), [ToGround::Restarted, ToGround::LinkTest, sonar]);
    assert_eq!(bench.station.unanswered(), None);
    let orders = [GroundCommand::Restart, GroundCommand::LinkTest, GroundCommand::ReportSonar];
    assert_eq!(bench.orders_seen(), orders);
}

#[test]
fn failures_keep_their_reason() {
    let mut bench = Bench::new(&LinkConfig::default(), 1);
    bench.report(Report::Failed(FailureReason::Blocked));
    bench.pass_ms(50);
    assert_eq!(bench.heard(), [ToGround::Failed(4)]);
    assert_eq!(failure_text(4), "the way stayed blocked");
    assert_eq!(failure_code(FailureReason::NoTrail), 1);
    assert_eq!(failure_text(0), failure_text(255));
}
