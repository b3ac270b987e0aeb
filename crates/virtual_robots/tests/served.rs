//! Robots in one world, each at its own line: the truth a client may ask for, bumpers at walls,
//! neighbours.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use std::{sync::Arc, time::Duration};

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel};
use run_context::RunSeed;
use sensor_models::SonarModel;
use simulator::{RobotPlacement, World, WorldSpec};
use virtual_robots::{Exchange, PioneerConfig, PioneerFirmware, ServedEvent, ServedWorld};
use wire::arcos::{Command, Decoder, Report, SimStatPac, Sip};

const TICK: Duration = Duration::from_millis(10);

/// A room from (−4, −3) to (6, 5) m with robots in it.
struct Room {
    served: ServedWorld,
    exchanges: Vec<Exchange>,
    decoders: Vec<Decoder>,
    reports: Vec<Vec<Report>>,
    events: Vec<(usize, ServedEvent)>,
}

impl Room {
    fn with(starts: &[Se2], errors: OdometryErrors) -> Self {
        let corners =
            [(-4.0, -3.0), (6.0, -3.0), (6.0, 5.0), (-4.0, 5.0)].map(|(x, y)| Vec2::new(x, y));
        let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0));
        let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
        let mut world = World::new(spec, RunSeed(1), TICK).unwrap();
        let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
        let bodies: Vec<_> = starts
            .iter()
            .enumerate()
            .map(|(i, &world_from_base)| {
                world.add_robot(RobotPlacement {
                    name: format!("robot{i}"),
                    model: Arc::clone(&model),
                    world_from_base,
                    errors,
                    sonar: SonarModel::ideal(),
                })
            })
            .collect();
        let mut served = ServedWorld::new(world);
        for body in bodies {
            let rng = RunSeed(1).stream("sonar");
            let config = PioneerConfig::default();
            let firmware = PioneerFirmware::new(Arc::clone(&model), config, rng);
            served.admit(body.unwrap(), Box::new(firmware));
        }
        let n = starts.len();
        Self {
            served,
            exchanges: vec![Exchange::default(); n],
            decoders: vec![Decoder::new(); n],
            reports: vec![Vec::new(); n],
            events: Vec::new(),
        }
    }

    fn at(start: Se2) -> Self {
        let mut room = Self::with(&[start], OdometryErrors::default());
        room.connect(0);
        room
    }

    fn connect(&mut self, robot: usize) {
        let greeting =
            [Command::Sync0, Command::Sync1, Command::Sync2, Command::Open, Command::Enable(1)];
        self.send(robot, &greeting);
        assert!(self.served.boards()[robot].board().status().is_open);
    }

    fn send(&mut self, robot: usize, commands: &[Command]) {
        for command in commands {
            command.encode(&mut self.exchanges[robot].received).unwrap();
        }
        self.tick();
    }

    fn tick(&mut self) {
        self.served.tick(&mut self.exchanges, &mut self.events);
        for (i, exchange) in self.exchanges.iter_mut().enumerate() {
            exchange.received.clear();
            self.decoders[i].push(&exchange.out);
            exchange.out.clear();
            while let Some(packet) = self.decoders[i].next_packet() {
                self.reports[i].push(Report::decode(packet.body()).unwrap());
            }
        }
    }

    fn pass_ms(&mut self, millis: u64) {
        for tick in 0..millis / 10 {
            for robot in 0..self.exchanges.len() {
                if tick % 100 == 50 {
                    Command::Pulse.encode(&mut self.exchanges[robot].received).unwrap();
                }
            }
            self.tick();
        }
    }

    fn truth(&mut self) -> SimStatPac {
        self.send(0, &[Command::SimStat(1)]);
        self.tick();
        let found = self.reports[0].iter().rev().find_map(|report| match report {
            Report::SimStat(stat) => Some(*stat),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("no true pose"))
    }

    fn last_sip(&self, robot: usize) -> Sip {
        let found = self.reports[robot].iter().rev().find_map(|report| match report {
            Report::Sip(sip) => Some(*sip),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("no information packet"))
    }
}

#[test]
fn a_client_may_ask_where_the_robot_truly_is() {
    let wrong = OdometryErrors { wheelbase_ratio: 1.1, ..OdometryErrors::default() };
    let start = Se2::new(-2.5, 1.25, 0.6_f64.to_radians());
    let mut room = Room::with(&[start], wrong);
    room.connect(0);
    let stat = room.truth();
    assert_eq!((stat.x_mm, stat.y_mm, stat.heading_deg), (-2500, 1250, 1));
    assert_eq!((stat.has_map, stat.bounds_mm), (true, Some([-4000, -3000, 6000, 5000])));
    assert_eq!((stat.sim_interval_ms, stat.last_interval_ms), (10, 10));
    room.served.note_interval(Duration::from_millis(17));
    // It believes to have turned by 90°, and is mistaken by the wheelbase's error.
    room.send(0, &[Command::Head(90)]);
    room.pass_ms(5000);
    let stat = room.truth();
    assert!((i32::abs(stat.heading_deg - (90.0_f64 / 1.1 + 0.5).round() as i32)) <= 1, "{stat:?}");
    assert!((room.last_sip(0).heading_rad().to_degrees() - 90.0).abs() < 0.5);
    assert_eq!(stat.last_interval_ms, 17);
}

#[test]
fn continuous_truth_comes_once_before_each_information_packet() {
    let mut room = Room::at(Se2::IDENTITY);
    room.reports[0].clear();
    room.send(0, &[Command::SimStat(2)]);
    room.pass_ms(990);
    let kinds: Vec<bool> =
        room.reports[0].iter().map(|report| matches!(report, Report::SimStat(_))).collect();
    assert!(kinds.len() >= 18, "{kinds:?}");
    let after_first = &kinds[kinds.iter().position(|&is_truth| is_truth).unwrap()..];
    assert!(after_first.chunks_exact(2).all(|pair| pair == [true, false]), "{kinds:?}");
    room.reports[0].clear();
    room.send(0, &[Command::SimStat(0)]);
    room.pass_ms(500);
    assert!(room.reports[0].iter().all(|report| matches!(report, Report::Sip(_))));
}

#[test]
fn a_client_moves_the_true_robot_and_its_odometry_does_not_notice() {
    let mut room = Room::at(Se2::new(1.0, 0.0, 0.0));
    room.send(0, &[Command::SimSetPose { x_mm: -2000, y_mm: 3000, heading_deg: -90 }]);
    let stat = room.truth();
    assert_eq!((stat.x_mm, stat.y_mm, stat.heading_deg), (-2000, 3000, -90));
    room.pass_ms(200);
    assert_eq!(room.last_sip(0).x_mm, 0);
    room.send(0, &[Command::Move(200)]);
    room.pass_ms(4000);
    // Into a wall it is not put, and that is told to whoever watches.
    room.events.clear();
    room.send(0, &[Command::SimSetPose { x_mm: 6000, y_mm: 0, heading_deg: 0 }]);
    assert!(
        matches!(&room.events[..], [(0, ServedEvent::PlaceRefused(pose, _))] if pose.x_m > 5.9),
        "{:?}",
        room.events
    );
    // Back to the start, with its odometry.
    room.send(0, &[Command::SimReset]);
    room.pass_ms(200);
    let stat = room.truth();
    assert_eq!((stat.x_mm, stat.y_mm, stat.heading_deg), (1000, 0, 0));
    assert_eq!((room.last_sip(0).x_mm, room.last_sip(0).heading_units), (0, 0));
}

#[test]
fn texts_and_the_wish_to_end_are_passed_on() {
    let mut room = Room::at(Se2::IDENTITY);
    room.events.clear();
    room.send(0, &[Command::SimMessage(b"hello \xFF".to_vec()), Command::SimExit(23)]);
    let [(0, ServedEvent::Said(text)), (0, ServedEvent::ExitAsked(23))] = &room.events[..] else {
        panic!("{:?}", room.events)
    };
    assert_eq!(text, "hello \u{FFFD}");
    // Not more than sixteen of one tick.
    room.events.clear();
    let many = vec![Command::SimReset; 40];
    room.send(0, &many);
    assert_eq!(room.events.len(), 16);
}

/// Drives at a wall from a heading; the bumpers that are pressed in the end.
fn bumpers_at_a_wall(start: Se2, speed_mmps: i16) -> [u8; 2] {
    let mut room = Room::at(start);
    room.send(0, &[Command::Vel(speed_mmps)]);
    room.pass_ms(6000);
    let sip = room.last_sip(0);
    assert!(sip.stalled(), "{sip:?}");
    sip.bumpers()
}

#[test]
fn the_segments_that_touch_are_the_ones_that_are_pressed() {
    let deg = |degrees: f64| degrees.to_radians();
    // The wall x = 6 m, met squarely: the flat front is as wide as the three middle segments.
    assert_eq!(bumpers_at_a_wall(Se2::new(5.0, 0.0, 0.0), 300), [0b01110, 0]);
    // Backwards: the rear's middle, which is numbered 3 of 5 as well.
    let [front, rear] = bumpers_at_a_wall(Se2::new(5.0, 0.0, deg(180.0)), -300);
    assert_eq!((front, rear & 0b00100), (0, 0b00100));
    let sides = |front: u8| (front & 0b00011 > 0, front & 0b11000 > 0);
    // At 45° with the wall on the left: segments of the left, bit 0 or 1, and none of the right.
    let [front, rear] = bumpers_at_a_wall(Se2::new(5.0, 0.0, deg(-45.0)), 300);
    assert!(sides(front) == (true, false) && rear == 0, "{front:05b}");
    let [front, rear] = bumpers_at_a_wall(Se2::new(5.0, 0.0, deg(45.0)), 300);
    assert!(sides(front) == (false, true) && rear == 0, "{front:05b}");
}

#[test]
fn with_bumpstall_the_robot_backs_out_of_a_wall_and_its_bumpers_are_free_again() {
    let mut room = Room::at(Se2::new(5.0, 0.0, 0.0));
    room.send(0, &[Command::BumpStall(3), Command::Vel(300)]);
    room.pass_ms(5000);
    assert!(room.last_sip(0).stalled() && !room.last_sip(0).moving);
    room.send(0, &[Command::Vel(-200)]);
    room.pass_ms(1500);
    let sip = room.last_sip(0);
    assert_eq!((sip.bumpers(), sip.stalled(), sip.left_mmps), ([0, 0], false, -200));
}

#[test]
fn robots_of_one_world_hear_each_other_and_are_served_apart() {
    let apart = [Se2::new(0.0, 0.0, 0.0), Se2::new(2.0, 0.0, 90_f64.to_radians())];
    let mut room = Room::with(&apart, OdometryErrors::default());
    room.connect(0);
    room.connect(1);
    room.pass_ms(1000);
    // The front sonars at ±10° of the first meet the side of the second, 2 m − 0.2125 m away.
    let ahead = room.last_readings(0).into_iter().find(|r| r.0 == 3).unwrap().1;
    assert!((1550..1750).contains(&ahead), "{ahead} mm");
    // Orders reach the robot at whose line they were given.
    room.send(1, &[Command::Vel(200)]);
    room.pass_ms(2000);
    assert_eq!((room.last_sip(0).y_mm, room.last_sip(0).left_mmps), (0, 0));
    assert_eq!(room.last_sip(1).left_mmps, 200);
    room.served.hang_up(1);
    room.pass_ms(500);
    assert!(room.served.boards()[0].board().status().is_open);
    assert!(!room.served.boards()[1].board().status().is_open);
}

impl Room {
    /// The newest reading of every sonar: number and range, mm.
    fn last_readings(&self, robot: usize) -> Vec<(u8, u16)> {
        let mut readings: Vec<(u8, u16)> = Vec::new();
        for report in self.reports[robot].iter().rev() {
            if let Report::Sip(sip) = report {
                for reading in sip.sonar() {
                    if readings.iter().all(|known| known.0 != reading.sensor) {
                        readings.push((reading.sensor, reading.range_mm));
                    }
                }
            }
        }
        readings
    }
}
