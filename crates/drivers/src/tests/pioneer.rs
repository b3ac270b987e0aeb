//! The Pioneer driver against packets written by the test.

use std::time::Duration;

use messages::{BaseState, Command, LinkState, Observations, Sensed};
use proptest::prelude::*;
use robot_models::WheelSpeeds;
use run_context::Stamp;
use wire::arcos::{Command as Packet, ConfigPac, Decoder, EncoderPac, Report, Sip, SonarReading};

use crate::{DriveCommand, LineTiming, PioneerDriver, PioneerDriverConfig};

/// On the wire a heartbeat is the first step of connecting.
const PULSE: Packet = Packet::Sync0;

/// How a search begins: whatever the robot was told before is taken back.
const SEARCH: [Packet; 3] = [Packet::Stop, Packet::Close, Packet::Sync0];

const STEP: Duration = Duration::from_millis(10);

/// The driver, and what it said and saw.
struct Bench {
    driver: PioneerDriver,
    now: Stamp,
    decoder: Decoder,
    said: Vec<Packet>,
    seen: Observations,
}

impl Bench {
    fn new(config: PioneerDriverConfig) -> Self {
        Self {
            driver: PioneerDriver::new(config),
            now: Stamp::ZERO,
            decoder: Decoder::new(),
            said: Vec::new(),
            seen: Observations::new(),
        }
    }

    fn connected(config: PioneerDriverConfig) -> Self {
        let mut bench = Self::new(config);
        bench.hear(&[]);
        bench.hear(&[Report::Sync0]);
        bench.hear(&[Report::Sync1]);
        bench.hear(&[identity()]);
        bench.hear(&[configuration(2000)]);
        bench.hear(&[good_sip()]);
        assert!(bench.driver.is_connected());
        bench.said.clear();
        bench.seen.clear();
        bench
    }

    /// What was said besides the questions whether the robot hears.
    fn said_but_questions(&self) -> Vec<Packet> {
        self.said.iter().filter(|&said| *said != Packet::Encoder(1)).cloned().collect()
    }

    fn hear(&mut self, reports: &[Report]) {
        let (mut received, mut out) = (Vec::new(), Vec::new());
        for report in reports {
            report.encode(&mut received).unwrap();
        }
        self.driver.step(self.now, &received, &mut self.seen, &mut out);
        self.listen(&out);
        self.now += STEP;
    }

    fn command(&mut self, command: &Command) -> Vec<Packet> {
        let mut out = Vec::new();
        self.driver.command(self.now, command, &mut out);
        self.said.clear();
        self.listen(&out);
        std::mem::take(&mut self.said)
    }

    fn listen(&mut self, out: &[u8]) {
        self.decoder.push(out);
        while let Some(packet) = self.decoder.next_packet() {
            self.said.push(Packet::decode(packet.body()).unwrap());
        }
    }

    /// Lets time pass while the robot reports `sip` every 100 ms, or nothing.
    fn pass_ms(&mut self, millis: u64, sip: Option<&Report>) {
        for tick in 0..millis / 10 {
            let due = sip.filter(|_| tick % 10 == 0);
            self.hear(due.map(std::slice::from_ref).unwrap_or_default());
        }
    }

    /// How the base stood after each report.
    fn statuses(&self) -> Vec<BaseState> {
        let mut base = BaseState::default();
        let mut statuses = Vec::new();
        for observation in &self.seen {
            base.take(observation);
            if matches!(observation.value, Sensed::Ring(_)) {
                statuses.push(base);
            }
        }
        statuses
    }
}

fn identity() -> Report {
    Report::Sync2 { name: "r".into(), class: "Pioneer".into(), subclass: "p3dx-sh".into() }
}

fn good_sip() -> Report {
    Report::Sip(Sip { flags: 0b111, ..Sip::AT_REST })
}

fn configuration(watchdog_ms: u16) -> Report {
    Report::Config(ConfigPac { watchdog_ms, ..ConfigPac::default() })
}

fn moving_sip(left_mmps: i16, right_mmps: i16) -> Report {
    Report::Sip(Sip { flags: 0b111, moving: true, left_mmps, right_mmps, ..Sip::AT_REST })
}

fn drive(left_mps: f64, right_mps: f64) -> Command {
    Command::Drive(WheelSpeeds { left_mps, right_mps })
}

#[test]
fn it_connects_step_by_step_and_each_step_waits_for_its_echo() {
    let mut bench = Bench::new(PioneerDriverConfig::default());
    bench.hear(&[]);
    bench.pass_ms(200, None);
    assert_eq!(bench.said, SEARCH);
    bench.hear(&[Report::Sync0]);
    assert_eq!(bench.said.pop(), Some(Packet::Sync1));
    bench.hear(&[Report::Sync1]);
    assert_eq!(bench.said.pop(), Some(Packet::Sync2));
    bench.said.clear();
    bench.hear(&[identity()]);
    assert_eq!(bench.said, [Packet::Open, Packet::Enable(1), Packet::Config]);
    assert!(!bench.driver.is_connected() && bench.seen.is_empty());
    bench.hear(&[good_sip()]);
    assert!(bench.driver.is_connected());
    assert_eq!(bench.seen.iter().next().map(|o| o.value), Some(Sensed::Link(LinkState::Up)));
    assert_eq!(bench.statuses().len(), 1);
}

#[test]
fn without_an_echo_it_begins_again() {
    let mut bench = Bench::new(PioneerDriverConfig::default());
    bench.hear(&[]);
    bench.hear(&[Report::Sync0]);
    bench.said.clear();
    bench.pass_ms(1700, None);
    // In between, the SYNC0 may have been a pulse for a robot that still knew a motion.
    let round = [&SEARCH[..], &SEARCH[..2]].concat();
    assert_eq!(bench.said, [&round[..], &round[..], &SEARCH[..]].concat());
    assert_eq!(bench.driver.counters().n_retries, 3);
    // A wrong echo is no echo.
    bench.said.clear();
    bench.hear(&[Report::Sync1]);
    assert_eq!(bench.said, []);
}

#[test]
fn an_old_session_is_closed_first() {
    let mut bench = Bench::new(PioneerDriverConfig::default());
    bench.hear(&[]);
    bench.hear(&[good_sip()]);
    bench.hear(&[good_sip()]);
    assert_eq!(bench.said, [&SEARCH[..], &SEARCH[..2]].concat());
    assert!(bench.seen.is_empty());
    bench.said.clear();
    bench.pass_ms(600, None);
    assert_eq!(bench.said, SEARCH);
}

#[test]
fn a_heartbeat_leaves_well_within_the_watchdog() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    bench.pass_ms(4000, Some(&good_sip()));
    let said = bench.said_but_questions();
    assert_eq!(said, vec![PULSE; 5].get(..said.len()).unwrap());
    assert!(said.len() >= 4);
}

#[test]
fn the_last_motion_is_repeated_with_the_heartbeat() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let vel2 = Packet::Vel2 { left: 10, right: 12 };
    assert_eq!(bench.command(&drive(0.2, 0.24)), std::slice::from_ref(&vel2));
    bench.pass_ms(900, Some(&good_sip()));
    // The motion first: a pulse alone would wake an older one.
    assert_eq!(bench.said_but_questions(), [vel2, PULSE]);
}

/// Lets the time pass in which nothing may be said, and what follows.
fn expect_silence_then_search(bench: &mut Bench, watchdog_ms: u64) {
    let told = bench.now;
    while bench.said.is_empty() {
        assert!(bench.now.since(told) < Duration::from_millis(watchdog_ms + 1000));
        bench.hear(&[]);
    }
    // The bench's clock is one step ahead of what was said.
    let silent_for = bench.now.since(told);
    assert!(silent_for > Duration::from_millis(watchdog_ms), "{silent_for:?}");
    assert_eq!(bench.said, SEARCH);
}

#[test]
fn who_loses_sight_stops_first_is_silent_then_and_only_then_looks_for_the_robot() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    bench.command(&drive(0.2, 0.2));
    bench.pass_ms(700, None);
    bench.said.clear();
    bench.pass_ms(500, None);
    assert!(!bench.driver.is_connected());
    assert_eq!(bench.seen.iter().last().map(|o| o.value), Some(Sensed::Link(LinkState::Down)));
    let stops = [Packet::Stop, Packet::Stop, Packet::Stop];
    let since_loss = bench.said.iter().position(|said| *said == Packet::Stop).unwrap();
    assert_eq!(bench.said.get(since_loss..).unwrap(), stops);
    for order in [drive(0.2, 0.2), Command::Stop, Command::TurnTo { heading_in_odom_rad: 1.0 }] {
        assert_eq!(bench.command(&order), []);
    }
    bench.said.clear();
    expect_silence_then_search(&mut bench, 2000);
    for report in [Report::Sync0, Report::Sync1, identity(), good_sip()] {
        bench.hear(&[report]);
    }
    bench.said.clear();
    bench.pass_ms(900, Some(&good_sip()));
    assert_eq!(bench.said_but_questions(), [PULSE]);
    let counters = bench.driver.counters();
    assert_eq!((counters.n_connections, counters.n_losses), (2, 1));
}

#[test]
fn the_silence_is_as_long_as_the_robot_says_that_its_watchdog_waits() {
    for watchdog_ms in [500, 6000] {
        let mut bench = Bench::connected(PioneerDriverConfig::default());
        bench.hear(&[configuration(watchdog_ms)]);
        bench.pass_ms(1300, None);
        bench.said.clear();
        expect_silence_then_search(&mut bench, watchdog_ms.into());
    }
}

#[test]
fn a_lost_robot_that_is_heard_rolling_is_told_again_and_one_that_stands_is_left_alone() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    bench.pass_ms(1300, None);
    bench.said.clear();
    bench.pass_ms(1200, Some(&moving_sip(200, 200)));
    assert_eq!(bench.said, [Packet::Stop, Packet::Stop]);
    bench.said.clear();
    // Nothing of what is heard now belongs to a session.
    let n_seen = bench.seen.len();
    bench.pass_ms(1500, Some(&good_sip()));
    assert_eq!((bench.said.len(), bench.seen.len()), (0, n_seen));
    bench.pass_ms(1500, None);
    assert_eq!(bench.said.get(..3), Some(&SEARCH[..]));
}

#[test]
fn a_robot_that_answers_no_more_questions_is_lost_although_it_is_heard() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let answer = Report::Encoder(EncoderPac { left_ticks: 1, right_ticks: 2 });
    for _ in 0..5 {
        bench.pass_ms(800, Some(&good_sip()));
        assert!(bench.said.contains(&Packet::Encoder(1)), "{:?}", bench.said);
        bench.said.clear();
        bench.hear(std::slice::from_ref(&answer));
    }
    bench.command(&drive(0.2, 0.2));
    bench.pass_ms(3000, Some(&good_sip()));
    assert!(bench.driver.is_connected());
    // It asks more often when it is not answered: a single loss is not taken for deafness.
    let n_questions = bench.said.iter().filter(|&said| *said == Packet::Encoder(1)).count();
    assert!((8..=12).contains(&n_questions), "{n_questions}");
    bench.pass_ms(1000, Some(&good_sip()));
    assert!(!bench.driver.is_connected());
    assert_eq!(bench.seen.iter().last().map(|o| o.value), Some(Sensed::Link(LinkState::Down)));
    assert_eq!(bench.said.last(), Some(&Packet::Stop));
}

#[test]
fn a_robot_that_never_answered_a_question_is_taken_to_hear() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    bench.pass_ms(20_000, Some(&good_sip()));
    assert!(bench.driver.is_connected());
}

#[test]
fn stop_is_repeated_until_the_robot_reports_that_it_stands() {
    let rolling = moving_sip(150, 150);
    for rest in [Command::Stop, drive(0.0, 0.009)] {
        let mut bench = Bench::connected(PioneerDriverConfig::default());
        bench.command(&drive(0.15, 0.15));
        bench.pass_ms(600, Some(&rolling));
        assert!(!bench.said.contains(&Packet::Stop), "{:?}", bench.said);
        bench.command(&rest);
        bench.said.clear();
        bench.pass_ms(1000, Some(&rolling));
        let n_stops = bench.said.iter().filter(|&said| *said == Packet::Stop).count();
        assert!(n_stops >= 3, "{rest:?}: {:?}", bench.said);
        bench.pass_ms(100, Some(&good_sip()));
        bench.said.clear();
        bench.pass_ms(700, Some(&good_sip()));
        let n_stops = bench.said.iter().filter(|&said| *said == Packet::Stop).count();
        assert!(n_stops <= 2, "once with the heartbeat: {:?}", bench.said);
    }
}

#[test]
fn a_robot_that_moves_although_nobody_asked_it_to_is_stopped() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    bench.pass_ms(300, Some(&moving_sip(-80, 80)));
    assert!(bench.said.contains(&Packet::Stop), "{:?}", bench.said);
}

#[test]
fn a_turn_of_which_half_was_lost_is_asked_for_again() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let turn = Command::TurnTo { heading_in_odom_rad: 1.5 };
    let packets = bench.command(&turn);
    bench.pass_ms(300, Some(&moving_sip(180, 200)));
    assert_eq!(bench.said_but_questions().get(..2), Some(&packets[..]));
    bench.said.clear();
    bench.pass_ms(300, Some(&moving_sip(-190, 200)));
    assert_eq!(bench.said_but_questions(), []);
}

#[test]
fn wheel_speeds_become_the_nearest_steps_of_vel2() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let cases = [
        (0.3, 0.3, 15, 15),
        (0.2367, 0.3633, 12, 18),
        (-0.1, 0.1, -5, 5),
        (0.009, -0.009, 0, 0),
        (0.011, -0.011, 1, -1),
        (9.0, -9.0, 127, -127),
        (f64::NAN, 0.0, 0, 0),
    ];
    for (left_mps, right_mps, left, right) in cases {
        let said = bench.command(&drive(left_mps, right_mps));
        assert_eq!(said, [Packet::Vel2 { left, right }], "{left_mps} {right_mps}");
    }
}

#[test]
fn wheel_speeds_can_become_a_speed_and_a_turn_rate() {
    let config = PioneerDriverConfig {
        drive_command: DriveCommand::VelAndRVel,
        ..PioneerDriverConfig::default()
    };
    let mut bench = Bench::connected(config);
    // (0.363 + 0.237) / 2 m/s; 0.126 / 0.38 rad/s = 19.0 deg/s.
    assert_eq!(bench.command(&drive(0.237, 0.363)), [Packet::Vel(300), Packet::RVel(19)]);
    assert_eq!(bench.command(&drive(0.1, -0.1)), [Packet::Vel(0), Packet::RVel(-30)]);
}

#[test]
fn turning_stopping_and_the_motors_have_their_packets() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let turn = |heading_in_odom_rad| Command::TurnTo { heading_in_odom_rad };
    assert_eq!(bench.command(&turn(-1.0)), [Packet::Vel(0), Packet::Head(303)]);
    assert_eq!(bench.command(&turn(0.789)), [Packet::Vel(0), Packet::Head(45)]);
    assert_eq!(bench.command(&turn(-0.001)), [Packet::Vel(0), Packet::Head(0)]);
    assert_eq!(bench.command(&Command::Stop), [Packet::Stop, Packet::Stop]);
    assert_eq!(bench.command(&Command::EnableMotors(false)), [Packet::Enable(0)]);
    assert_eq!(bench.command(&Command::EnableMotors(true)), [Packet::Enable(1)]);
}

#[test]
fn what_the_robot_reports_as_missing_is_sent_again() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let motors_off = Report::Sip(Sip { flags: 0b110, ..Sip::AT_REST });
    bench.pass_ms(700, Some(&motors_off));
    assert_eq!(bench.said_but_questions(), [Packet::Enable(1)]);
    bench.said.clear();
    let sonar_off = Report::Sip(Sip { flags: 1, ..Sip::AT_REST });
    bench.pass_ms(600, Some(&sonar_off));
    assert!(bench.said.contains(&Packet::Sonar(1)), "{:?}", bench.said);
    // Motors that were switched off on purpose stay off.
    bench.command(&Command::EnableMotors(false));
    bench.pass_ms(1500, Some(&motors_off));
    assert!(!bench.said.contains(&Packet::Enable(1)), "{:?}", bench.said);
}

#[test]
fn a_status_has_si_units_and_knows_what_is_new() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let mut sip = Sip {
        moving: true,
        x_mm: 1500,
        y_mm: 32_768 - 250,
        heading_units: -1024,
        left_mmps: 300,
        right_mmps: -20,
        battery_decivolts: 123,
        stall_right: 1,
        flags: 0b111,
        ..Sip::AT_REST
    };
    for (sensor, range_mm) in [(3, 1234), (7, 5000), (9, 60_000), (20, 100)] {
        assert!(sip.push_sonar(SonarReading { sensor, range_mm }));
    }
    bench.hear(&[Report::Sip(sip)]);
    let status = bench.statuses().pop().unwrap();
    let (odometry, ring) = (status.odometry.unwrap(), status.ring.unwrap());
    let pose = odometry.odom_from_base.se2();
    assert!((pose.x_m - 1.5).abs() < 1e-12 && (pose.y_m + 0.25).abs() < 1e-12, "{pose:?}");
    assert!((pose.yaw_rad + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(odometry.wheel_speeds, WheelSpeeds { left_mps: 0.3, right_mps: -0.02 });
    assert_eq!(
        (status.contacts.unwrap().stalled, odometry.moving, status.motors.unwrap().enabled),
        ([false, true], true, true)
    );
    assert_eq!(ring.fresh, 1 << 3 | 1 << 7 | 1 << 9);
    let heard = ring.ranges_m.get(3).copied().unwrap();
    assert!(
        (heard - 1.234).abs() < 1e-12 && (status.battery.unwrap().voltage_v - 12.3).abs() < 1e-12
    );
    // 60 m is beyond what the sensor can hear; sensor 20 does not exist for the navigator.
    assert_eq!(ring.ranges_m.get(9), Some(&5.0));
    bench.hear(&[good_sip()]);
    let next = bench.statuses().pop().unwrap();
    assert_eq!((next.ring.unwrap().fresh, next.ring.unwrap().ranges_m), (0, ring.ranges_m));
}

#[test]
fn a_status_is_dated_when_its_packet_left_the_robot() {
    let line = LineTiming { baud: Some(9600), latency: Duration::from_millis(7) };
    let mut bench =
        Bench::connected(PioneerDriverConfig { line, ..PioneerDriverConfig::default() });
    bench.now = Stamp::from_millis(500);
    bench.hear(&[good_sip()]);
    let about = bench.seen.iter().last().unwrap().about;
    // A packet of 25 bytes takes 26.04 ms.
    assert!((about.as_secs_f64() - (0.5 - 0.007 - 0.026_04)).abs() < 1e-4, "{about}");
}

#[test]
fn disconnecting_stops_the_robot_and_closes() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let mut out = Vec::new();
    bench.driver.disconnect(bench.now, &mut out);
    bench.listen(&out);
    assert_eq!(bench.said, [Packet::Stop, Packet::Close]);
    assert!(!bench.driver.is_connected());
    bench.said.clear();
    expect_silence_then_search(&mut bench, 2000);
}

#[test]
fn a_steady_connection_allocates_nothing() {
    let mut bench = Bench::connected(PioneerDriverConfig::default());
    let mut sip = Vec::new();
    good_sip().encode(&mut sip).unwrap();
    let (mut seen, mut out) = (Observations::new(), Vec::with_capacity(256));
    let (driver, mut now) = (&mut bench.driver, bench.now);
    let allocations = allocation_counter::measure(|| {
        for tick in 0..1000 {
            seen.clear();
            out.clear();
            let received: &[u8] = if tick % 10 == 0 { &sip } else { &[] };
            driver.step(now, received, &mut seen, &mut out);
            if tick % 20 == 0 {
                driver.command(now, &drive(0.2, 0.3), &mut out);
            }
            now += STEP;
        }
    });
    assert_eq!(allocations.count_total, 0);
    assert!(driver.is_connected());
}

proptest! {
    /// However far the robot goes, at up to 2.2 m/s and with packets lost for up to seven seconds,
    /// positions are unwrapped.
    #[test]
    fn positions_do_not_wrap(steps in proptest::collection::vec(-16_000_i64..16_000, 1..60)) {
        let mut bench = Bench::connected(PioneerDriverConfig::default());
        let mut x_mm = 0_i64;
        for step in steps {
            x_mm += step;
            let wrapped = u16::try_from(x_mm.rem_euclid(32_768)).unwrap();
            bench.hear(&[Report::Sip(Sip { flags: 7, x_mm: wrapped, ..Sip::AT_REST })]);
            let seen_m = bench.statuses().pop().unwrap().odometry.unwrap().odom_from_base.se2().x_m;
            prop_assert!((seen_m - 0.001 * x_mm as f64).abs() < 1e-9, "{} {}", seen_m, x_mm);
        }
    }

    #[test]
    fn no_bytes_make_it_fail(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let mut bench = Bench::connected(PioneerDriverConfig::default());
        let mut out = Vec::new();
        bench.driver.step(bench.now, &bytes, &mut bench.seen, &mut out);
        prop_assert!(bench.driver.is_connected());
    }
}
