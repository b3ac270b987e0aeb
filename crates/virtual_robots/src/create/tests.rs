//! The firmware in a world, and its packets against what the world is.

use std::time::Duration;

use geometry::{Polygon, Se2, Segment, SegmentWorld, Vec2};
use robot_models::OdometryErrors;
use run_context::RunSeed;
use sensor_models::SonarModel;
use simulator::{Fixtures, RobotPlacement, WorldSpec};
use wire::create_oi::{BAUDS, Command, Radius, Readings, StreamDecoder, data_len, ids};

use super::*;
use crate::{Exchange, ServedEvent, ServedWorld};

/// A Create in a room from (−2, −2) to (2, 2) m, with a client.
struct Bench {
    served: ServedWorld,
    exchange: [Exchange; 1],
    decoder: StreamDecoder,
    frames: Vec<Readings>,
    notes: Vec<String>,
    n_frames: usize,
}

impl Bench {
    fn with(start: Se2, battery: BatteryConfig, fixtures: Fixtures) -> Self {
        let corners =
            [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| Vec2::new(x, y));
        let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0));
        let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
        let mut world = World::new(spec, RunSeed(1), Duration::from_millis(10)).unwrap();
        world.set_fixtures(fixtures);
        let model = Arc::new(RobotModel::by_name("create2").unwrap());
        let placement = RobotPlacement {
            name: "create".to_owned(),
            model: Arc::clone(&model),
            world_from_base: start,
            errors: OdometryErrors::default(),
            sonar: SonarModel::default(),
        };
        let body = world.add_robot(placement).unwrap();
        let mut served = ServedWorld::new(world);
        served.admit(body, Box::new(CreateFirmware::new(model, battery)));
        Self {
            served,
            exchange: [Exchange::default()],
            decoder: StreamDecoder::new(),
            frames: Vec::new(),
            notes: Vec::new(),
            n_frames: 0,
        }
    }

    fn at(start: Se2) -> Self {
        Self::with(start, BatteryConfig::default(), Fixtures::default())
    }

    /// Sends commands and passes a tick; bytes that came back.
    fn send(&mut self, commands: &[Command]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for command in commands {
            command.encode(&mut bytes);
        }
        self.send_bytes(&bytes)
    }

    fn send_bytes(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.exchange[0].received = bytes.to_vec();
        let mut events = Vec::new();
        self.served.tick(&mut self.exchange, &mut events);
        self.notes.extend(events.into_iter().filter_map(|(_, event)| match event {
            ServedEvent::Noted(text) => Some(text),
            _ => None,
        }));
        self.exchange[0].received.clear();
        let out = std::mem::take(&mut self.exchange[0].out);
        self.decoder.push(&out);
        while let Some(frame) = self.decoder.next_frame() {
            self.frames.push(frame.readings);
            self.n_frames += 1;
        }
        out
    }

    fn pass_ms(&mut self, millis: u64) {
        (0..millis / 10).for_each(|_| drop(self.send(&[])));
    }

    /// What a packet says, asked for once.
    fn ask(&mut self, id: u8) -> i32 {
        let answer = self.send(&[Command::Sensors(id)]);
        assert_eq!(Some(answer.len()), data_len(id), "{answer:02x?}");
        let mut readings = Readings::default();
        readings.read(id, &answer).unwrap();
        readings.get(id).unwrap()
    }

    fn drive(&mut self, left_mmps: i16, right_mmps: i16) {
        self.send(&[Command::DriveDirect { right_mmps, left_mmps }]);
    }

    fn pose(&self) -> Se2 {
        self.served.body_of(&self.served.boards()[0]).world_from_base.se2()
    }

    /// Speeds of the true wheels, µm/s.
    fn wheels_umps(&self) -> [i64; 2] {
        let wheels = self.served.body_of(&self.served.boards()[0]).wheel_speeds;
        [wheels.left_mps, wheels.right_mps].map(|mps| (1e6 * mps).round() as i64)
    }
}

fn awake(start: Se2) -> Bench {
    let mut bench = Bench::at(start);
    bench.send(&[Command::Start, Command::Safe]);
    assert_eq!(bench.ask(ids::MODE), 2);
    bench
}

#[test]
fn it_goes_through_its_modes_and_moves_in_the_right_ones_only() {
    let mut bench = Bench::at(Se2::IDENTITY);
    // Off: nothing is answered and nothing moves.
    assert_eq!(bench.send(&[Command::Safe, Command::Sensors(35)]), []);
    bench.drive(100, 100);
    bench.pass_ms(100);
    assert_eq!(bench.wheels_umps(), [0, 0]);
    assert!(bench.notes[0].contains("131") && bench.notes[0].contains("128"), "{:?}", bench.notes);
    bench.send(&[Command::Start]);
    assert_eq!(bench.ask(ids::MODE), 1);
    bench.drive(100, 100);
    bench.pass_ms(100);
    assert_eq!(bench.wheels_umps(), [0, 0]);
    for (command, mode) in [(Command::Safe, 2), (Command::Full, 3)] {
        bench.send(&[command]);
        assert_eq!(bench.ask(ids::MODE), mode);
        bench.drive(100, 100);
        bench.pass_ms(500);
        assert_eq!(bench.wheels_umps(), [100_000; 2]);
    }
    // START stops it and takes it back; STOP ends the interface.
    bench.send(&[Command::Start]);
    bench.pass_ms(500);
    assert_eq!((bench.ask(ids::MODE), bench.wheels_umps()), (1, [0, 0]));
    bench.send(&[Command::Stop]);
    assert_eq!(bench.send(&[Command::Sensors(35)]), []);
}

#[test]
fn drive_takes_radii_as_printed() {
    let mut bench = awake(Se2::IDENTITY);
    // v (1 ∓ 117.5 / R): worked out by hand.
    for (speed_mmps, radius, left_right) in [
        (-200, Radius::Arc(500), [-153, -247]),
        (200, Radius::Arc(-1000), [224, 177]),
        (200, Radius::Straight, [200, 200]),
        (200, Radius::Clockwise, [200, -200]),
        (200, Radius::CounterClockwise, [-200, 200]),
        (900, Radius::Straight, [500, 500]),
        (400, Radius::Arc(200), [165, 500]),
        (100, Radius::Arc(32_000), [94, 106]),
    ] {
        bench.send(&[Command::Drive { speed_mmps, radius }]);
        let asked = [bench.ask(ids::REQUESTED_LEFT), bench.ask(ids::REQUESTED_RIGHT)];
        assert_eq!(asked, left_right, "{speed_mmps} {radius:?}");
        let shown = radius.to_wire();
        assert_eq!(bench.ask(ids::REQUESTED_RADIUS), i32::from(shown));
    }
    bench.send(&[Command::DrivePwm { right: 255, left: -51 }]);
    assert_eq!([bench.ask(ids::REQUESTED_LEFT), bench.ask(ids::REQUESTED_RIGHT)], [-100, 500]);
}

#[test]
fn it_drives_on_without_a_word_for_there_is_no_watchdog() {
    let mut bench = awake(Se2::new(-1.5, 0.0, 0.0));
    bench.drive(50, 50);
    bench.pass_ms(30_000);
    assert!(bench.pose().x_m > -0.05, "{:?}", bench.pose());
    bench.served.hang_up(0);
    bench.pass_ms(2000);
    assert_eq!(bench.wheels_umps(), [50_000; 2]);
    assert!(bench.notes.iter().any(|note| note.contains("no watchdog")), "{:?}", bench.notes);
}

#[test]
fn encoders_wrap_and_know_no_direction_but_the_one_asked_for() {
    let mut bench = awake(Se2::IDENTITY);
    bench.drive(-100, 100);
    bench.pass_ms(3000);
    let (left, right) = (bench.ask(ids::ENCODER_LEFT), bench.ask(ids::ENCODER_RIGHT));
    // A count is 0.44456 mm: 3 s of 100 mm/s less the time of the ramp.
    assert!((670..690).contains(&right), "{right}");
    assert!((65_536 - left - right).abs() <= 1, "{left} {right}");
    // The wheel still rolls backwards while forwards is asked for: it counts forwards.
    let before = bench.ask(ids::ENCODER_LEFT);
    bench.drive(400, 400);
    bench.send(&[]);
    let body = bench.served.body_of(&bench.served.boards()[0]);
    assert!(body.wheel_speeds.left_mps < 0.0);
    let after = bench.ask(ids::ENCODER_LEFT);
    assert!(after >= before, "{before} {after}");
}

#[test]
fn way_and_angle_start_anew_when_they_are_read() {
    let mut bench = awake(Se2::new(-1.0, 0.0, 0.0));
    bench.drive(200, 200);
    bench.pass_ms(2000);
    bench.drive(0, 0);
    bench.pass_ms(500);
    let way_mm = bench.ask(ids::DISTANCE);
    assert!((i32::abs(way_mm - (1000.0 * (bench.pose().x_m + 1.0)) as i32)) <= 1, "{way_mm}");
    assert_eq!(bench.ask(ids::DISTANCE), 0);
    bench.drive(-200, 200);
    bench.pass_ms(500);
    bench.drive(0, 0);
    bench.pass_ms(500);
    let turned_deg = bench.ask(ids::ANGLE);
    let truly_deg = bench.pose().yaw_rad.to_degrees();
    assert!((f64::from(turned_deg) - truly_deg).abs() < 1.5, "{turned_deg} {truly_deg}");
    assert_eq!((bench.ask(ids::ANGLE), bench.ask(ids::DISTANCE).abs() <= 1), (0, true));
    // A group reads them too.
    bench.drive(-200, -200);
    bench.pass_ms(500);
    let answer = bench.send(&[Command::Sensors(2)]);
    let mut readings = Readings::default();
    readings.read(2, &answer).unwrap();
    assert!(readings.get(ids::DISTANCE).unwrap() < -50, "{readings:?}");
    bench.drive(0, 0);
}

#[test]
fn a_stream_keeps_its_beat_its_order_and_pauses() {
    let mut bench = awake(Se2::IDENTITY);
    let out = bench.send(&[Command::Stream(vec![43, 7, 35])]);
    assert_eq!(out, []);
    bench.pass_ms(1500);
    assert_eq!(bench.n_frames, 100);
    // Two frames fall due in 30 ms.
    let out: Vec<u8> = (0..3).flat_map(|_| bench.send(&[])).collect();
    assert_eq!(out[..10], [19, 7, 43, 0, 0, 7, 0, 35, 2, 0_u8.wrapping_sub(113)]);
    assert_eq!(out.len(), 20);
    bench.send(&[Command::Pause { streams: false }]);
    let n = bench.n_frames;
    bench.pass_ms(500);
    assert_eq!(bench.n_frames, n);
    bench.send(&[Command::Pause { streams: true }]);
    bench.pass_ms(150);
    assert!(bench.n_frames >= n + 9);
    bench.send(&[Command::Stop]);
    let n = bench.n_frames;
    bench.pass_ms(150);
    assert_eq!(bench.n_frames, n);
    // More than a frame holds: nothing whole comes.
    bench.send(&[Command::Start, Command::Stream(vec![100, 100, 100])]);
    bench.pass_ms(300);
    assert_eq!(bench.n_frames, n);
}

#[test]
fn bumper_wall_and_light_tell_what_is_ahead() {
    let mut bench = awake(Se2::new(1.2, 0.0, 0.0));
    assert_eq!((bench.ask(ids::BUMPS_AND_DROPS), bench.ask(ids::LIGHT_BUMPER)), (0, 0));
    bench.drive(300, 300);
    bench.pass_ms(1600);
    // Its front is 0.17 m before the wall: the two in the middle see it within their 0.2 m.
    assert!((1.63..1.7).contains(&bench.pose().x_m), "{:?}", bench.pose());
    assert_eq!(bench.ask(ids::LIGHT_BUMPER) & 0b00_1100, 0b00_1100);
    let far = bench.ask(ids::LIGHT_LEFT_SIGNAL + 2);
    bench.pass_ms(2000);
    assert_eq!(bench.ask(ids::BUMPS_AND_DROPS), 0b11);
    assert!(bench.ask(ids::LIGHT_LEFT_SIGNAL + 2) > far);
    assert_eq!(bench.ask(ids::OVERCURRENTS), 0b11000);
    assert_eq!(bench.ask(ids::STASIS), 0);
    // A wall at its right side, none at its left.
    let mut bench = awake(Se2::new(0.0, -1.78, 0.0));
    assert_eq!(bench.ask(ids::WALL), 1);
    assert!(bench.ask(ids::WALL_SIGNAL) > 0);
    let mut bench = awake(Se2::new(0.0, 1.78, 0.0));
    assert_eq!(bench.ask(ids::WALL), 0);
    // Left and right segment at walls met aslant.
    for (yaw, bit) in [(-0.6, 0b10), (0.6, 0b01)] {
        let mut bench = awake(Se2::new(1.4, 0.0, yaw));
        bench.drive(300, 300);
        bench.pass_ms(3000);
        assert_eq!(bench.ask(ids::BUMPS_AND_DROPS), bit, "{yaw}");
    }
}

fn square(x_m: f64, y_m: f64, half_m: f64) -> Polygon {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corner = |(x, y)| Vec2::new(x_m + half_m * x, y_m + half_m * y);
    Polygon::new(corners.map(corner).to_vec()).unwrap()
}

#[test]
fn safe_mode_stops_at_a_cliff_and_full_mode_does_not() {
    let holes = || Fixtures { holes: vec![square(1.0, 0.0, 0.5)], ..Fixtures::default() };
    let start = Se2::new(-0.5, 0.0, 0.0);
    let mut bench = Bench::with(start, BatteryConfig::default(), holes());
    bench.send(&[Command::Start, Command::Safe]);
    bench.drive(200, 200);
    bench.pass_ms(6000);
    // Its front sensors are 0.15 m ahead of it.
    assert!((0.35..0.40).contains(&bench.pose().x_m), "{:?}", bench.pose());
    assert_eq!((bench.ask(ids::MODE), bench.wheels_umps()), (1, [0, 0]));
    assert_eq!([9, 10, 11, 12].map(|id| bench.ask(id)), [0, 1, 1, 0]);
    assert!(bench.ask(29) < 100 && bench.ask(28) > 1000);
    assert!(bench.notes.iter().any(|note| note.contains("cliff")), "{:?}", bench.notes);
    // Backwards it may go.
    bench.send(&[Command::Safe]);
    bench.drive(-200, -200);
    bench.pass_ms(1000);
    assert_eq!(bench.ask(ids::MODE), 2);
    assert!(bench.pose().x_m < 0.25);
    // Full mode drives on, and its wheels drop.
    bench.send(&[Command::Full]);
    bench.drive(200, 200);
    bench.pass_ms(4000);
    assert_eq!((bench.ask(ids::MODE), bench.ask(ids::BUMPS_AND_DROPS)), (3, 0b1100));
    // In safe mode a dropped wheel stops it, whichever way it goes.
    bench.send(&[Command::Safe]);
    assert_eq!(bench.ask(ids::MODE), 1);
}

#[test]
fn a_virtual_wall_is_heard_and_a_charger_charges() {
    let fixtures = Fixtures {
        virtual_walls: vec![Se2::new(-1.9, 0.0, 0.0)],
        docks: vec![Se2::new(0.0, 1.5, 0.0)],
        ..Fixtures::default()
    };
    let half = BatteryConfig { charge_percent: 50.0, drain_ratio: 1.0 };
    let mut bench = Bench::with(Se2::new(-0.5, 0.0, 0.0), half, fixtures.clone());
    bench.send(&[Command::Start]);
    assert_eq!((bench.ask(ids::VIRTUAL_WALL), bench.ask(ids::IR_OMNI)), (1, 162));
    assert_eq!((bench.ask(ids::CHARGING_STATE), bench.ask(ids::CHARGING_SOURCES)), (0, 0));
    assert!(bench.ask(ids::CURRENT) < -100);
    assert_eq!((bench.ask(ids::CAPACITY), bench.ask(ids::CHARGE)), (3000, 1500));
    let mut bench = Bench::with(Se2::new(0.0, 1.5, 0.0), half, fixtures);
    bench.send(&[Command::Start]);
    assert_eq!((bench.ask(ids::VIRTUAL_WALL), bench.ask(ids::IR_OMNI)), (0, 161));
    assert_eq!((bench.ask(ids::CHARGING_STATE), bench.ask(ids::CHARGING_SOURCES)), (2, 2));
    let before = bench.ask(ids::CHARGE);
    bench.pass_ms(60_000);
    assert!(bench.ask(ids::CHARGE) > before + 10);
    // On the charger safe mode falls back at once, and it does not fall asleep.
    bench.send(&[Command::Safe]);
    assert_eq!(bench.ask(ids::MODE), 1);
    bench.pass_ms(400_000);
    assert_eq!(bench.ask(ids::MODE), 1);
}

#[test]
fn it_falls_asleep_in_passive_mode_and_never_in_safe() {
    let mut bench = awake(Se2::IDENTITY);
    bench.pass_ms(310_000);
    assert_eq!(bench.ask(ids::MODE), 2);
    bench.send(&[Command::Start]);
    bench.pass_ms(299_000);
    assert_eq!(bench.ask(ids::MODE), 1);
    bench.pass_ms(2000);
    assert_eq!(bench.send(&[Command::Start, Command::Sensors(35)]), []);
    assert!(bench.notes.iter().any(|note| note.contains("asleep")), "{:?}", bench.notes);
    bench.served.hang_up(0);
    bench.send(&[Command::Start]);
    assert_eq!(bench.ask(ids::MODE), 1);
}

#[test]
fn an_empty_battery_ends_everything() {
    let nearly = BatteryConfig { charge_percent: 0.01, drain_ratio: 10.0 };
    let mut bench = Bench::with(Se2::IDENTITY, nearly, Fixtures::default());
    assert!(bench.served.boards()[0].board().status().battery.unwrap().is_low);
    bench.send(&[Command::Start, Command::Safe]);
    bench.drive(100, 100);
    bench.pass_ms(10_000);
    assert_eq!(bench.wheels_umps(), [0, 0]);
    assert_eq!(bench.send(&[Command::Start, Command::Sensors(35)]), []);
}

#[test]
fn what_does_nothing_is_swallowed_whole() {
    let mut bench = awake(Se2::IDENTITY);
    bench.send(&[
        Command::Leds { bits: 4, colour: 128, intensity: 137 },
        Command::Motors(7),
        Command::Schedule([137; 15]),
        Command::DigitLedsAscii(*b"HALT"),
        Command::SetDayTime([1, 2, 3]),
    ]);
    let song = Command::Song { number: 2, notes: vec![[60, 32], [62, 32]] };
    bench.send(&[song, Command::Play(2)]);
    // A second of tones.
    assert_eq!((bench.ask(ids::SONG_PLAYING), bench.ask(ids::SONG_NUMBER)), (1, 2));
    bench.pass_ms(1000);
    assert_eq!(bench.ask(ids::SONG_PLAYING), 0);
    bench.send(&[Command::Buttons(0b101)]);
    assert_eq!(bench.ask(ids::BUTTONS), 5);
    bench.pass_ms(200);
    assert_eq!(bench.ask(ids::BUTTONS), 0);
    bench.send(&[Command::Baud(7)]);
    assert_eq!(bench.served.boards()[0].board().status().baud, Some(BAUDS[7]));
    assert_eq!((bench.ask(ids::MODE), bench.wheels_umps()), (2, [0, 0]));
    // Bytes that are no opcode are told of.
    bench.send_bytes(&[3, 200]);
    let unknown: Vec<u8> = bench.served.boards()[0].board().status().unknown.iter().collect();
    assert_eq!(unknown, [3, 200]);
    bench.send(&[Command::Clean]);
    assert_eq!(bench.ask(ids::MODE), 1);
}
