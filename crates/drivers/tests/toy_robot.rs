//! A robot that none of our crates knows: its own catalogue file, bytes, firmware and driver, and it drives.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{sync::Arc, time::Duration};

use drivers::Driver;
use geometry::Se2;
use messages::{BaseState, Command, LinkState, Observations, OdometryReading, Sensed};
use robot_models::{Odometry, OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp, StateHash};
use sensor_models::SonarModel;
use simulator::{BodyId, RobotPlacement, World, WorldSpec};
use virtual_robots::{
    BatteryConfig, Board, BoardConfig, BoardStatus, Exchange, MotorReference, Port, ServedWorld,
};

const TICK: Duration = Duration::from_millis(10);

/// A table of 30 by 20 cm on two wheels. On its line: `w LEFT RIGHT` in mm/s to it, `e LEFT RIGHT` in pulses from it,
/// ten times a second; it stands when it has heard nothing for half a second.
const FILE: &str = r#"
name = "table"
title = "The table"
radius_m = 0.18
footprint_m = [[-0.15, -0.1], [0.15, -0.1], [0.15, 0.1], [-0.15, 0.1]]

[line]
protocol = "table"
baud = 9600
watchdog_ms = 500

[drive]
wheelbase_m = 0.18
wheel_diameter_m = 0.1
encoder_ticks_per_turn = 360
gear_ratio = 1.0

[limits]
speed_max_mps = 0.4
turn_rate_max_degps = 180
acceleration_mps2 = 1.0
turn_acceleration_degps2 = 400
"#;

/// Whole lines of text with their words, as they come in.
#[derive(Debug, Default)]
struct Lines(String);

impl Lines {
    fn push(&mut self, bytes: &[u8]) -> Vec<(char, [i64; 2])> {
        self.0.push_str(&String::from_utf8_lossy(bytes));
        let mut found = Vec::new();
        while let Some((line, rest)) = self.0.split_once('\n') {
            let words: Vec<&str> = line.split(' ').collect();
            if let [kind, left, right] = words[..]
                && let (Some(kind), Ok(left), Ok(right)) =
                    (kind.chars().next(), left.parse(), right.parse())
            {
                found.push((kind, [left, right]));
            }
            self.0 = rest.to_owned();
        }
        found
    }
}

#[derive(Debug, Default)]
struct TableFirmware {
    lines: Lines,
    wheels: WheelSpeeds,
    heard: Stamp,
    next: Stamp,
    n_heard: u64,
}

impl Board for TableFirmware {
    fn ports(&self) -> &'static [&'static str] {
        &["under the table top"]
    }

    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        let port = ports.first_mut()?;
        for (kind, [left, right]) in self.lines.push(port.received) {
            if kind == 'w' {
                self.heard = now;
                self.n_heard += 1;
                self.wheels =
                    WheelSpeeds { left_mps: 1e-3 * left as f64, right_mps: 1e-3 * right as f64 };
            }
        }
        if now.since(self.heard) >= Duration::from_millis(500) {
            self.wheels = WheelSpeeds::ZERO;
        }
        if now >= self.next {
            self.next = now + Duration::from_millis(100);
            let [left, right] = world.body(body_id).encoder_ticks;
            port.out.extend_from_slice(format!("e {left} {right}\n").as_bytes());
        }
        Some(MotorReference { wheels: self.wheels, acceleration_mps2: 1.0 })
    }

    fn hang_up(&mut self, _port_index: usize) {
        self.wheels = WheelSpeeds::ZERO;
    }

    fn status(&self) -> BoardStatus {
        BoardStatus { n_heard: self.n_heard, motors_enabled: true, ..BoardStatus::default() }
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.n_heard);
    }
}

#[derive(Debug)]
struct TableDriver {
    lines: Lines,
    odometry: Odometry,
    is_up: bool,
}

impl Driver for TableDriver {
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        _out: &mut Vec<u8>,
    ) {
        for (_, [left, right]) in self.lines.push(received) {
            if !std::mem::replace(&mut self.is_up, true) {
                observations.push(now, Sensed::Link(LinkState::Up));
            }
            self.odometry.update(left, right);
            let odometry = OdometryReading {
                odom_from_base: self.odometry.odom_from_base(),
                wheel_speeds: WheelSpeeds::ZERO,
                moving: false,
            };
            observations.push(now, Sensed::Odometry(odometry));
        }
    }

    fn command(&mut self, _now: Stamp, command: &Command, out: &mut Vec<u8>) {
        match command {
            Command::Drive(wheels) => {
                let [left, right] =
                    [wheels.left_mps, wheels.right_mps].map(|mps| (1e3 * mps).round());
                out.extend_from_slice(format!("w {left} {right}\n").as_bytes());
            }
            Command::Stop => self.hold(out),
            _ => {}
        }
    }

    fn disconnect(&mut self, _now: Stamp, out: &mut Vec<u8>) {
        self.hold(out);
        self.is_up = false;
    }

    fn hold(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(b"w 0 0\n");
    }

    fn is_connected(&self) -> bool {
        self.is_up
    }
}

/// The table in a world, and whoever steps it: it holds a board and a driver and knows no robot.
struct Loop {
    served: ServedWorld,
    exchange: [Exchange; 1],
    driver: Box<dyn Driver>,
    status: BaseState,
}

impl Loop {
    fn new(model: &Arc<RobotModel>, board: Box<dyn Board>, driver: Box<dyn Driver>) -> Self {
        let mut world = World::new(WorldSpec::empty(), RunSeed(1), TICK).unwrap();
        let body = world
            .add_robot(RobotPlacement {
                name: model.name.clone(),
                model: Arc::clone(model),
                world_from_base: Se2::IDENTITY,
                errors: OdometryErrors::default(),
                sonar: SonarModel::default(),
            })
            .unwrap();
        let mut served = ServedWorld::new(world);
        served.admit(body, board);
        Self { served, exchange: [Exchange::default()], driver, status: BaseState::default() }
    }

    fn pass_ms(&mut self, millis: u64, wish: Option<Command>) {
        for _ in 0..millis / 10 {
            let now = self.served.now();
            self.served.tick(&mut self.exchange, &mut Vec::new());
            let [Exchange { received, out }] = &mut self.exchange;
            received.clear();
            let mut observations = Observations::new();
            self.driver.step(now, out, &mut observations, received);
            out.clear();
            if let Some(wish) = &wish {
                self.driver.command(now, wish, received);
            }
            observations.iter().for_each(|observation| self.status.take(observation));
        }
    }

    fn truth(&self) -> Se2 {
        self.served.body_of(&self.served.boards()[0]).world_from_base.se2()
    }
}

#[test]
fn a_robot_from_outside_drives_through_the_same_traits() {
    let model = Arc::new(RobotModel::from_toml(FILE).unwrap());
    let driver =
        TableDriver { lines: Lines::default(), odometry: Odometry::new(model.drive), is_up: false };
    let mut run = Loop::new(&model, Box::new(TableFirmware::default()), Box::new(driver));
    run.pass_ms(200, None);
    assert!(run.driver.is_connected());
    let arc = Command::Drive(WheelSpeeds { left_mps: 0.2, right_mps: 0.3 });
    run.pass_ms(3000, Some(arc));
    run.pass_ms(2000, Some(Command::Stop));
    let (truth, believed) = (run.truth(), run.status.odometry.unwrap().odom_from_base.se2());
    assert!(truth.position().norm() > 0.4 && truth.yaw_rad > 1.0, "{truth:?}");
    assert!((truth.position() - believed.position()).norm() < 0.005, "{truth:?} {believed:?}");
    // Its own watchdog, which the traits know nothing of.
    run.pass_ms(500, Some(arc));
    run.pass_ms(1500, None);
    let stands = run.truth();
    run.pass_ms(500, None);
    assert_eq!(run.truth(), stands);
}

/// Its file names a protocol that is in no list, and whoever asks is told which ones are.
#[test]
fn the_lists_say_what_they_do_not_know() {
    let model = Arc::new(RobotModel::from_toml(FILE).unwrap());
    assert!(!virtual_robots::has_board(&model) && !drivers::has_driver(&model));
    let config = BoardConfig { name: "table".to_owned(), battery: BatteryConfig::default() };
    let refused = virtual_robots::board(&model, &config, RunSeed(1).stream("x")).unwrap_err();
    let refused = refused.to_string();
    for word in ["The table", "`table`", "`arcos`", "`create_oi`"] {
        assert!(refused.contains(word), "{refused}");
    }
}
