//! Bytes of lasers in a room of 10 m by 8 m, against geometry.

use std::{sync::Arc, time::Duration};

use geometry::{Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel};
use run_context::RunSeed;
use sensor_models::SonarModel;
use simulator::{RobotPlacement, WorldSpec};
use wire::{
    rplidar::{Answer, AnswerKind, Request as Asked},
    sick_lms::{self, Baud, Config, Item, Reading, Reply, Request, Unit, Variant},
};

use super::*;
use crate::Port;

const TICK: Duration = Duration::from_millis(10);
/// Where the robot stands, and its sensor on it: 0.1 m ahead.
const ROBOT: Se2 = Se2 { x_m: 0.5, y_m: -0.3, yaw_rad: 0.4 };

struct Bed {
    world: World,
    body: BodyId,
    board: Box<dyn Board>,
}

/// Room from (−4, −3) to (6, 5) m.
fn room() -> (World, BodyId) {
    let corners =
        [(-4.0, -3.0), (6.0, -3.0), (6.0, 5.0), (-4.0, 5.0)].map(|(x, y)| Vec2::new(x, y));
    let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0));
    let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
    let mut world = World::new(spec, RunSeed(1), TICK).unwrap();
    let body = world
        .add_robot(RobotPlacement {
            name: "robot".to_owned(),
            model: Arc::new(RobotModel::by_name("pioneer3dx").unwrap()),
            world_from_base: ROBOT,
            errors: OdometryErrors::default(),
            sonar: SonarModel::ideal(),
        })
        .unwrap();
    (world, body)
}

impl Bed {
    fn new(kind: LaserKind, is_paced: bool) -> Self {
        let (world, body) = room();
        let config = LaserConfig {
            model: kind.model().without_errors(),
            is_paced,
            ..LaserConfig::new(kind, Se2::new(0.1, 0.0, 0.0))
        };
        Self { world, body, board: laser_board(config, RunSeed(1).stream("laser")) }
    }

    /// So many ticks; `bytes` arrive at the first. What it says.
    fn run(&mut self, bytes: &[u8], n_ticks: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for tick in 0..n_ticks {
            let received = if tick == 0 { bytes } else { &[] };
            let port = Port { received, out: &mut out };
            let motors = self.board.step(self.world.now(), &self.world, self.body, &mut [port]);
            assert_eq!(motors, None);
            self.world.step();
        }
        out
    }
}

/// Range to the room's walls at a bearing from the sensor's x axis, by the four wall equations.
fn expected_m(bearing_rad: f64) -> f64 {
    let sensor = ROBOT.compose(Se2::new(0.1, 0.0, 0.0));
    let (s, c) = (sensor.yaw_rad + bearing_rad).sin_cos();
    let along = |wall: f64, from: f64, part: f64| {
        let distance = (wall - from) / part;
        if distance > 0.0 { distance } else { f64::INFINITY }
    };
    let x = along(-4.0, sensor.x_m, c).min(along(6.0, sensor.x_m, c));
    x.min(along(-3.0, sensor.y_m, s)).min(along(5.0, sensor.y_m, s))
}

#[test]
fn an_ld06_tells_what_it_sees_clockwise_and_wraps_its_clock() {
    let mut bed = Bed::new(LaserKind::Ld06, false);
    let mut decoder = wire::ld06::Decoder::new();
    let mut last_clock_ms = None;
    let (mut n_packets, mut n_wraps) = (0_u64, 0);
    for _ in 0..31 {
        decoder.push(&bed.run(&[], 100));
        while let Some(packet) = decoder.next_packet() {
            n_packets += 1;
            assert_eq!((packet.speed_degps, packet.span_cdeg()), (3600, 880));
            for (i, point) in packet.points.iter().enumerate() {
                let range_m = expected_m(-packet.angle_deg(i).to_radians());
                let error_mm = f64::from(point.distance_mm) - 1000.0 * range_m;
                assert!(error_mm.abs() < 0.6, "{packet:?} {i}: {error_mm}");
            }
            if let Some(last) = last_clock_ms.replace(packet.clock_ms) {
                let step_ms = (30_000 + packet.clock_ms - last) % 30_000;
                assert!((2..=3).contains(&step_ms), "{step_ms}");
                n_wraps += u32::from(packet.clock_ms < last);
            }
        }
    }
    // 4500 points a second for 31 s, of which the last packet is not yet full.
    assert_eq!(n_packets, 31 * 375 - 4);
    assert_eq!((n_wraps, decoder.n_bytes_skipped()), (1, 0));
}

fn asked(requests: &[Asked]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for request in requests {
        request.encode(&mut bytes);
    }
    bytes
}

#[test]
fn an_rplidar_is_asked_and_then_sends_samples_until_it_is_stopped() {
    let mut bed = Bed::new(LaserKind::RplidarA1, false);
    let mut decoder = wire::rplidar::Decoder::new();
    // Nothing unasked.
    assert_eq!(bed.run(&[], 50), []);
    decoder.push(&bed.run(&asked(&[Asked::Info, Asked::Health, Asked::SampleTimes]), 1));
    let answers: Vec<Answer> = std::iter::from_fn(|| decoder.next_answer()).collect();
    assert!(matches!(answers[1], Answer::Info(info) if info.model == 0x18), "{answers:?}");
    assert!(matches!(answers[3], Answer::Health(health) if health.status == 0));
    assert!(matches!(answers[5], Answer::SampleTimes(times) if times.standard_us == 508));
    decoder.push(&bed.run(&asked(&[Asked::Scan]), 100));
    assert_eq!(decoder.next_answer(), Some(Answer::Announced(AnswerKind::Nodes)));
    let mut nodes = Vec::new();
    while let Some(Answer::Node(node)) = decoder.next_answer() {
        let range_m = expected_m(-f64::from(node.angle_q6).to_radians() / 64.0);
        let error_m = f64::from(node.distance_q2) / 4000.0 - range_m;
        assert!(error_m.abs() < 2e-4, "{node:?}: {error_m}");
        assert!(node.quality > 0);
        nodes.push(node);
    }
    // 0.99 s at 508 µs.
    assert_eq!(nodes.len(), 990_000 / 508 + 1);
    let firsts: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i].is_first).collect();
    assert_eq!(firsts, [0, 360, 720, 1080, 1440, 1800]);
    // Stopped: silence. An unknown request is noted, and has no answer.
    assert_eq!(bed.run(&asked(&[Asked::Stop, Asked::Other(0x82, vec![0; 5])]), 20), []);
    assert_eq!(bed.board.status().unknown.iter().collect::<Vec<_>>(), [0x82]);
    // Without a motor no samples; with one after a second.
    let motorless = bed.run(&asked(&[Asked::MotorPwm(0), Asked::Scan]), 50);
    assert_eq!(motorless, AnswerKind::Nodes.descriptor());
    assert_eq!(bed.run(&asked(&[Asked::MotorPwm(660)]), 99), []);
    assert!(bed.run(&[], 10).len() > 500);
    // A reset ends everything and hears nothing for half a second.
    let reset = [Asked::Reset, Asked::Health];
    bed.run(&asked(&reset), 1);
    assert_eq!(bed.run(&asked(&[Asked::Info]), 40), []);
    assert!(!bed.run(&[], 10).is_empty() || !bed.run(&asked(&[Asked::Info]), 10).is_empty());
}

/// All telegrams' payloads, with 06 and 15 as one byte.
fn said(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut decoder = sick_lms::Decoder::new(sick_lms::Side::FromDevice);
    decoder.push(bytes);
    let mut all = Vec::new();
    while let Some(item) = decoder.next_item() {
        all.push(match item {
            Item::Ack => vec![sick_lms::ACK],
            Item::Nak => vec![sick_lms::NAK],
            Item::Telegram { payload, .. } => payload.to_vec(),
        });
    }
    assert_eq!(decoder.n_bytes_skipped(), 0);
    all
}

fn telegram(request: &Request) -> Vec<u8> {
    let mut bytes = Vec::new();
    request.encode(0, &mut bytes);
    bytes
}

/// One request, answered by 06 and that.
#[track_caller]
fn ask(bed: &mut Bed, request: &Request, expected: &Reply<'_>) {
    let all = said(&bed.run(&telegram(request), 1));
    assert_eq!(all[0], [sick_lms::ACK]);
    assert_eq!(Reply::decode(&all[1]), Some((*expected, sick_lms::STATUS_OK)), "{request:?}");
}

const HALF_DEGREES: Variant = Variant { angle_deg: 180, resolution_cdeg: 50 };

/// The way AriaCoda starts one, with half degrees.
fn started(bed: &mut Bed) -> Config {
    let config = Config::delivered().with(Unit::Mm, 5);
    let power_on = said(&bed.run(&[], 1));
    assert!(matches!(Reply::decode(&power_on[0]), Some((Reply::PowerOn(_), _))));
    ask(bed, &Request::Baud(Baud::B38400), &Reply::Mode(0));
    assert_eq!(bed.board.status().baud, Some(38_400));
    ask(bed, &Request::Variant(HALF_DEGREES), &Reply::Variant(true, HALF_DEGREES));
    ask(bed, &Request::INSTALLATION, &Reply::Mode(0));
    ask(bed, &Request::WriteConfig(config), &Reply::ConfigWritten(true, config));
    ask(bed, &Request::Continuous, &Reply::Mode(0));
    config
}

#[test]
fn a_sick_is_configured_and_sends_scans_without_end() {
    let mut bed = Bed::new(LaserKind::SickLms, false);
    started(&mut bed);
    let scans = said(&bed.run(&[], 100));
    // 37.5 a second.
    assert!((37..=38).contains(&scans.len()), "{}", scans.len());
    for payload in &scans {
        let Some((Reply::Scan(scan), _)) = Reply::decode(payload) else { panic!() };
        assert_eq!((scan.len(), scan.unit), (361, Unit::Mm));
        let field = sick_lms::RangeField::of_mode(5).unwrap();
        for (i, bits) in scan.bits().enumerate() {
            let range_m = expected_m((0.5 * i as f64 - 90.0).to_radians());
            let Reading::Range(mm) = field.decode(bits) else { panic!("{bits:04X}") };
            assert!((f64::from(mm) - 1000.0 * range_m).abs() < 0.6, "{i}: {mm} {range_m}");
        }
    }
    ask(&mut bed, &Request::OnRequest, &Reply::Mode(0));
    assert_eq!(bed.run(&[], 50), []);
    let one = said(&bed.run(&telegram(&Request::OneScan), 50));
    assert_eq!((one.len(), one[1].len()), (2, 726));
}

#[test]
fn a_sick_refuses_what_does_not_suit_its_state() {
    let mut bed = Bed::new(LaserKind::SickLms, false);
    bed.run(&[], 1);
    let delivered = Config::delivered();
    let degrees = Variant::ALL[0];
    let impossible = Variant { angle_deg: 180, resolution_cdeg: 25 };
    ask(&mut bed, &Request::Variant(impossible), &Reply::Variant(false, degrees));
    ask(&mut bed, &Request::WriteConfig(delivered.with(Unit::Mm, 0)), &Reply::Refused);
    ask(&mut bed, &Request::Installation(*b"PLS_SICK"), &Reply::Mode(1));
    ask(&mut bed, &Request::OtherMode(0x50), &Reply::Mode(1));
    ask(&mut bed, &Request::Other(0x44), &Reply::Refused);
    ask(&mut bed, &Request::INSTALLATION, &Reply::Mode(0));
    let no_ranges = delivered.with(Unit::Mm, 0x3F);
    ask(&mut bed, &Request::WriteConfig(no_ranges), &Reply::ConfigWritten(false, delivered));
    // A wrong checksum is answered by 15, half a telegram by nothing, and both are got over.
    let mut damaged = telegram(&Request::Type);
    damaged[4] ^= 1;
    assert_eq!(bed.run(&damaged, 20), [sick_lms::NAK]);
    assert_eq!(bed.run(&telegram(&Request::INSTALLATION)[..9], 20), []);
    ask(&mut bed, &Request::Type, &Reply::Type(b"LMS200;301063;V02.10 "));
    // Reset: silence, then it tells what it is, at 9600 baud again.
    ask(&mut bed, &Request::Baud(Baud::B38400), &Reply::Mode(0));
    ask(&mut bed, &Request::Reset, &Reply::WillReset);
    assert_eq!(bed.run(&telegram(&Request::Type), 290), []);
    assert_eq!(said(&bed.run(&[], 20)).len(), 1);
    assert_eq!(bed.board.status().baud, Some(9600));
}

/// A line of 38 400 bits per second could carry 5.2 scans of 361 readings a second; as a scan takes two turns and only
/// whole ones are sent, 4.7 come, which is what users of real ones report.
#[test]
fn a_slow_line_carries_few_scans() {
    let mut bed = Bed::new(LaserKind::SickLms, true);
    started(&mut bed);
    let scans = said(&bed.run(&[], 1000)).len();
    assert!((46..=48).contains(&scans), "{scans}");
}

#[test]
fn nothing_is_allocated_while_a_laser_runs() {
    for kind in LaserKind::ALL {
        let mut bed = Bed::new(kind, false);
        match kind {
            LaserKind::SickLms => drop(started(&mut bed)),
            LaserKind::RplidarA1 => drop(bed.run(&asked(&[Asked::Scan]), 1)),
            LaserKind::Ld06 => {}
        }
        bed.run(&[], 20);
        let mut out = Vec::with_capacity(1 << 20);
        let Bed { world, body, board } = &mut bed;
        let info = allocation_counter::measure(|| {
            for _ in 0..100 {
                let port = Port { received: &[], out: &mut out };
                board.step(world.now(), world, *body, &mut [port]);
                world.step();
            }
        });
        assert_eq!(info.count_total, 0, "{}", kind.name());
        assert!(out.len() > 5000);
    }
}
