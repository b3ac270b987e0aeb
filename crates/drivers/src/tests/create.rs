//! A Create and its driver over a link: world, firmware, bytes, driver.

use std::{f64::consts::PI, sync::Arc, time::Duration};

use geometry::{Polygon, Se2, Segment, SegmentWorld, Vec2};
use messages::{BaseState, Command, Contacts, LinkState, Observations, Sensed};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{BodyId, Fixtures, RobotPlacement, World, WorldSpec};
use virtual_robots::{BatteryConfig, Board, CreateFirmware, Port};
use wire::link::{End, Link, LinkConfig};

use crate::{CreateDriver, CreateDriverConfig, Driver, LineTiming};

struct Loop {
    world: World,
    body: BodyId,
    board: CreateFirmware,
    driver: CreateDriver,
    link: Link,
    status: BaseState,
    ups: u32,
    downs: u32,
    /// Repeated in every tick, as a navigator renews what it wants.
    wish: Option<Command>,
    to_robot: Vec<u8>,
}

impl Loop {
    fn with(config: &LinkConfig, fixtures: Fixtures, seed: u64) -> Self {
        let corners =
            [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)].map(|(x, y)| Vec2::new(x, y));
        let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0));
        let spec = WorldSpec::of_walls(SegmentWorld::new(walls));
        let mut world = World::new(spec, RunSeed(seed), Duration::from_millis(10)).unwrap();
        world.set_fixtures(fixtures);
        let model = Arc::new(RobotModel::by_name("create2").unwrap());
        let placement = RobotPlacement {
            name: "create".to_owned(),
            model: Arc::clone(&model),
            world_from_base: Se2::IDENTITY,
            errors: OdometryErrors::default(),
            sonar: SonarModel::default(),
        };
        let body = world.add_robot(placement).unwrap();
        let line = LineTiming { baud: config.baud, latency: config.latency };
        let driver =
            CreateDriverConfig { line, ..CreateDriverConfig::new(model.drive, model.limits) };
        Self {
            world,
            body,
            board: CreateFirmware::new(model, BatteryConfig::default()),
            driver: CreateDriver::new(driver),
            link: Link::new(config, RunSeed(seed).stream("link")).unwrap(),
            status: BaseState::default(),
            ups: 0,
            downs: 0,
            wish: None,
            to_robot: Vec::new(),
        }
    }

    fn clean() -> Self {
        let config = LinkConfig { baud: Some(115_200), ..LinkConfig::default() };
        Self::with(&config, Fixtures::default(), 1)
    }

    fn step_robot(&mut self) {
        let now = self.world.now();
        let (mut received, mut out) = (Vec::new(), Vec::new());
        self.link.receive(End::B, now, &mut received);
        let port = Port { received: &received, out: &mut out };
        if let Some(wanted) = self.board.step(now, &self.world, self.body, &mut [port]) {
            self.world.set_acceleration(self.body, wanted.acceleration_mps2);
            self.world.set_wheel_reference(self.body, wanted.wheels);
        }
        self.link.send(End::B, now, &out);
        self.to_robot.extend(received);
    }

    fn step_driver(&mut self) {
        let now = self.world.now();
        let (mut received, mut out) = (Vec::new(), Vec::new());
        let mut observations = Observations::new();
        self.link.receive(End::A, now, &mut received);
        self.driver.step(now, &received, &mut observations, &mut out);
        for observation in &observations {
            self.status.take(observation);
            assert!(observation.about <= now);
            match observation.value {
                Sensed::Link(LinkState::Up) => self.ups += 1,
                Sensed::Link(LinkState::Down) => self.downs += 1,
                _ => {}
            }
        }
        if let Some(wish) = self.wish {
            self.driver.command(now, &wish, &mut out);
        }
        self.link.send(End::A, now, &out);
    }

    fn pass_ms(&mut self, millis: u64) {
        for _ in 0..millis / 10 {
            self.step_robot();
            self.step_driver();
            self.world.step();
        }
    }

    /// The same while the driver's computer sleeps.
    fn pass_alone_ms(&mut self, millis: u64) {
        for _ in 0..millis / 10 {
            self.step_robot();
            self.world.step();
        }
    }

    fn command(&mut self, command: Command) {
        let mut out = Vec::new();
        self.driver.command(self.world.now(), &command, &mut out);
        self.link.send(End::A, self.world.now(), &out);
    }

    fn pose(&self) -> Se2 {
        self.world.body(self.body).world_from_base.se2()
    }

    fn speed_mps(&self) -> f64 {
        let wheels = self.world.body(self.body).wheel_speeds;
        wheels.left_mps.abs().max(wheels.right_mps.abs())
    }

    fn believed(&self) -> Se2 {
        self.status.odometry.unwrap().odom_from_base.se2()
    }
}

fn forwards(mps: f64) -> Command {
    Command::Drive(WheelSpeeds { left_mps: mps, right_mps: mps })
}

#[test]
fn it_connects_drives_and_knows_where_it_is() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    assert!(run.driver.is_connected() && run.status.motors.unwrap().enabled);
    assert!((run.status.battery.unwrap().voltage_v - 16.5).abs() < 0.01);
    run.wish = Some(Command::Drive(WheelSpeeds { left_mps: 0.2, right_mps: 0.3 }));
    run.pass_ms(4000);
    let speeds = run.status.wheel_speeds();
    assert!((speeds.left_mps - 0.2).abs() < 0.01 && (speeds.right_mps - 0.3).abs() < 0.01);
    assert!(run.status.is_moving());
    run.wish = None;
    run.command(Command::Stop);
    run.pass_ms(1000);
    let (pose, believed) = (run.pose(), run.believed());
    assert!(pose.x_m.hypot(pose.y_m) > 0.5 && pose.yaw_rad > 1.0, "{pose:?}");
    assert!((pose.position() - believed.position()).norm() < 0.003, "{pose:?} {believed:?}");
    assert!((pose.yaw_rad - believed.yaw_rad).abs() < 0.005);
    assert!(run.speed_mps() < 1e-9 && !run.status.is_moving());
    assert_eq!((run.ups, run.downs, run.driver.counters().n_mended), (1, 0, 0));
}

#[test]
fn it_turns_to_headings_of_both_signs_and_stands() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    for heading in [1.5, -1.0, PI - 0.01, -PI + 0.05, 0.0] {
        run.command(Command::TurnTo { heading_in_odom_rad: heading });
        run.pass_ms(5000);
        let off = geometry::wrap_to_pi(run.pose().yaw_rad - heading);
        assert!(off.abs() < 0.01 && run.speed_mps() < 1e-9, "{heading} {off}");
    }
    assert!(run.pose().x_m.hypot(run.pose().y_m) < 0.01);
    assert_eq!(run.driver.counters().n_dead_man_stops, 0);
}

#[test]
fn a_motion_that_nobody_renews_ends() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.command(forwards(0.2));
    run.pass_ms(2400);
    assert!(run.speed_mps() > 0.19);
    run.pass_ms(400);
    assert!(run.speed_mps() < 1e-9 && run.driver.counters().n_dead_man_stops == 1);
    // Renewed in time it goes on.
    run.wish = Some(forwards(0.2));
    run.pass_ms(6000);
    assert!(run.speed_mps() > 0.19);
    assert_eq!(run.driver.counters().n_dead_man_stops, 1);
}

#[test]
fn a_computer_that_slept_stops_the_robot_before_anything_else() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.command(forwards(0.2));
    run.pass_ms(500);
    // The robot drives on meanwhile: it has no watchdog.
    run.pass_alone_ms(1500);
    assert!(run.speed_mps() > 0.19);
    run.pass_ms(200);
    assert!(run.speed_mps() < 1e-9, "{}", run.speed_mps());
    assert!(run.driver.counters().n_dead_man_stops == 1 && run.driver.is_connected());
    assert!((run.believed().x_m - run.pose().x_m).abs() < 0.01);
}

#[test]
fn a_robot_that_is_not_heard_is_stopped_and_found_again() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.wish = Some(forwards(0.2));
    run.pass_ms(1000);
    run.link.set_cut(End::B, true);
    run.pass_ms(900);
    assert_eq!(run.downs, 1);
    assert!(run.speed_mps() < 1e-9 && !run.driver.is_connected());
    run.link.set_cut(End::B, false);
    run.wish = None;
    run.pass_ms(1500);
    assert!(run.driver.is_connected() && run.ups == 2);
    assert!(run.speed_mps() < 1e-9 && run.status.motors.unwrap().enabled);
    // It counted on while nobody heard.
    assert!((run.believed().x_m - run.pose().x_m).abs() < 0.005);
}

#[test]
fn a_robot_that_does_not_hear_is_noticed() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.wish = Some(forwards(0.2));
    run.pass_ms(1000);
    run.link.set_cut(End::A, true);
    run.wish = Some(forwards(0.1));
    run.pass_ms(1200);
    // Nothing stops it: it has no watchdog. But it is known.
    assert!(run.downs >= 1 && run.speed_mps() > 0.19);
    run.link.set_cut(End::A, false);
    run.wish = None;
    run.pass_ms(1500);
    assert!(run.speed_mps() < 1e-9, "{}", run.speed_mps());
    assert!(run.driver.is_connected());
}

#[test]
fn bytes_that_are_lost_are_mended() {
    let (mut n_mended, mut n_off, mut worst_m) = (0, 0, 0.0_f64);
    for seed in 0..20 {
        let config = LinkConfig {
            baud: Some(115_200),
            loss_prob: 0.003,
            corruption_prob: 0.003,
            ..LinkConfig::default()
        };
        let mut run = Loop::with(&config, Fixtures::default(), seed);
        run.pass_ms(3000);
        for step in 0..40 {
            run.wish = Some(forwards(0.14 + 0.01 * f64::from(step % 3)));
            run.pass_ms(200);
        }
        run.wish = Some(Command::Stop);
        run.pass_ms(2000);
        run.wish = None;
        run.pass_ms(1000);
        let counters = run.driver.counters();
        assert!(run.speed_mps() < 1e-9, "seed {seed}: {} m/s, {counters:?}", run.speed_mps());
        if !run.board.status().is_open {
            // A damaged opcode was POWER, RESET or STOP, and that is what the robot did.
            n_off += 1;
            continue;
        }
        assert!(run.driver.is_connected(), "seed {seed}: {counters:?}");
        assert!(run.pose().position().norm() > 0.3, "seed {seed}: {:?}", run.pose());
        let off_m = (run.pose().position() - run.believed().position()).norm();
        // Wheels that a damaged byte turns back for a moment are counted forwards.
        assert!(off_m < 0.1, "seed {seed}: {off_m}");
        worst_m = off_m.max(worst_m);
        n_mended += run.driver.counters().n_mended;
    }
    println!(
        "{n_mended} speeds mended, {n_off} robots off; odometry off by {worst_m:.3} m at most"
    );
    assert!(n_mended > 10 && n_off <= 2, "{n_mended} {n_off}");
}

#[test]
fn at_a_cliff_it_stands_says_so_and_backs_off() {
    let hole = [(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
    let fixtures =
        Fixtures { holes: vec![Polygon::new(hole.to_vec()).unwrap()], ..Fixtures::default() };
    let config = LinkConfig { baud: Some(115_200), ..LinkConfig::default() };
    let mut run = Loop::with(&config, fixtures, 1);
    run.pass_ms(500);
    // Whoever insists does not get it over the edge.
    run.wish = Some(forwards(0.2));
    run.pass_ms(10_000);
    assert!((0.8..0.95).contains(&run.pose().x_m), "{:?}", run.pose());
    let contacts = run.status.contacts.unwrap();
    // Only the front: the two sensors in the middle, or all four.
    assert!(contacts.cliffs & 0b0110 != 0 && contacts.bumpers == 0, "{contacts:?}");
    assert!(run.driver.counters().n_safety_stops == 1);
    assert!(run.status.motors.unwrap().enabled && run.speed_mps() < 1e-9);
    run.wish = Some(forwards(-0.2));
    run.pass_ms(1500);
    assert!(run.pose().x_m < 0.7 && run.status.contacts == Some(Contacts::default()));
}

#[test]
fn contacts_are_told_by_side() {
    for (yaw, aside) in [(0.6, 1), (-0.6, 0)] {
        let mut run = Loop::clean();
        run.world.relocate_robot(run.body, Se2::new(4.5, 0.0, yaw)).unwrap();
        run.pass_ms(500);
        run.wish = Some(forwards(0.2));
        run.pass_ms(4000);
        let found = run.status.contacts.unwrap();
        assert!(found.bumpers >> aside & 1 == 1 && found.any(), "{yaw} {found:?}");
    }
}

#[test]
fn it_ends_with_wheels_at_rest_and_the_interface_off() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.command(forwards(0.3));
    run.pass_ms(1000);
    let mut out = Vec::new();
    run.driver.disconnect(run.world.now(), &mut out);
    // Stand, START, STOP.
    assert_eq!(out, [145, 0, 0, 0, 0, 128, 173]);
    run.link.send(End::A, run.world.now(), &out);
    run.pass_alone_ms(1000);
    assert!(run.speed_mps() < 1e-9 && !run.board.status().is_open);
    let mut hold = Vec::new();
    run.driver.hold(&mut hold);
    assert_eq!(hold, [145, 0, 0, 0, 0].repeat(3));
}

#[test]
fn motors_that_are_off_are_passive_mode() {
    let mut run = Loop::clean();
    run.pass_ms(500);
    run.command(Command::EnableMotors(false));
    run.wish = Some(forwards(0.2));
    run.pass_ms(2000);
    assert!(!run.status.motors.unwrap().enabled && run.speed_mps() < 1e-9);
    run.command(Command::EnableMotors(true));
    run.pass_ms(1000);
    assert!(run.status.motors.unwrap().enabled && run.speed_mps() > 0.19);
}

#[test]
fn firmware_that_counts_its_modes_from_two_is_understood() {
    use wire::create_oi::{Readings, ids, write_frame};
    let model = RobotModel::by_name("create2").unwrap();
    for offset in [0, 1] {
        let mut driver = CreateDriver::new(CreateDriverConfig::new(model.drive, model.limits));
        let mut drivable = Vec::new();
        // 3 s in passive mode, whatever it is told, then in safe mode, then back.
        for (tick, mode) in [1; 200].into_iter().chain([2; 20]).chain([1; 2]).enumerate() {
            let mut readings = Readings::default();
            readings.set(ids::MODE, mode + offset);
            let mut bytes = Vec::new();
            write_frame(&[ids::MODE, ids::ENCODER_LEFT, ids::ENCODER_RIGHT], &readings, &mut bytes);
            let mut observations = Observations::new();
            let now = Stamp::from_millis(15 * tick as u64);
            driver.step(now, &bytes, &mut observations, &mut Vec::new());
            drivable.extend(observations.iter().filter_map(|seen| match seen.value {
                Sensed::Motors(motors) => Some(motors.enabled),
                _ => None,
            }));
        }
        let changes = drivable.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let n_drivable = drivable.iter().filter(|&&drivable| drivable).count();
        assert_eq!((drivable[0], changes, n_drivable), (false, 2, 20), "{offset}");
    }
}
