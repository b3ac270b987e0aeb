//! World, firmware, link and driver: what a run of the simulation does with one robot.

use std::{sync::Arc, time::Duration};

use geometry::{Se2, SegmentWorld, Vec2};
use messages::{BaseState, Command, LinkState, Observations, Sensed};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{BodyId, RobotPlacement, World, WorldSpec};
use virtual_robots::{PioneerConfig, PioneerFirmware};
use wire::link::{End, Link, LinkConfig};

use crate::{LineTiming, PioneerDriver, PioneerDriverConfig, PioneerSettings};

const STEP: Duration = Duration::from_millis(10);

/// 9600 baud that loses three bytes in a thousand and damages as many: about one packet in six of
/// the information packets.
fn bad_line() -> LinkConfig {
    LinkConfig {
        baud: Some(9600),
        latency: Duration::from_millis(5),
        jitter: Duration::from_millis(10),
        loss_prob: 0.003,
        corruption_prob: 0.003,
    }
}

struct Loop {
    world: World,
    body_id: BodyId,
    firmware: PioneerFirmware,
    link: Link,
    driver: PioneerDriver,
    observations: Observations,
    status: BaseState,
    n_link_up: usize,
    n_link_down: usize,
}

impl Loop {
    fn new(link: &LinkConfig, seed: u64) -> Self {
        let seed = RunSeed(seed);
        let mut world = World::new(WorldSpec::of_walls(walls()), seed, STEP).unwrap();
        let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
        let placement = RobotPlacement {
            name: "robot".to_owned(),
            model: Arc::clone(&model),
            world_from_base: Se2::IDENTITY,
            errors: OdometryErrors::default(),
            sonar: SonarModel::default(),
        };
        let body_id = world.add_robot(placement).unwrap();
        let settings =
            PioneerSettings { acceleration_mps2: Some(0.5), ..PioneerSettings::default() };
        let line = LineTiming { baud: link.baud, latency: link.latency };
        Self {
            world,
            body_id,
            firmware: PioneerFirmware::new(model, PioneerConfig::default(), seed.stream("sonar")),
            link: Link::new(link, seed.stream("link")).unwrap(),
            driver: PioneerDriver::new(PioneerDriverConfig {
                settings,
                line,
                ..PioneerDriverConfig::default()
            }),
            observations: Observations::new(),
            status: BaseState::default(),
            n_link_up: 0,
            n_link_down: 0,
        }
    }

    fn tick(&mut self, command: Option<&Command>) {
        let now = self.world.now();
        let (mut received, mut out) = (Vec::new(), Vec::new());
        self.link.receive(End::B, now, &mut received);
        let reference = self.firmware.step(now, &received, &self.world, self.body_id, &mut out);
        self.link.send(End::B, now, &out);
        received.clear();
        out.clear();
        self.link.receive(End::A, now, &mut received);
        self.observations.clear();
        self.driver.step(now, &received, &mut self.observations, &mut out);
        if let Some(command) = command {
            self.driver.command(now, command, &mut out);
        }
        self.link.send(End::A, now, &out);
        for observation in &self.observations {
            self.status.take(observation);
            match observation.value {
                Sensed::Odometry(_) => assert!(observation.about <= now),
                Sensed::Link(LinkState::Up) => self.n_link_up += 1,
                Sensed::Link(LinkState::Down) => self.n_link_down += 1,
                _ => {}
            }
        }
        self.world.set_acceleration(self.body_id, reference.acceleration_mps2);
        self.world.set_wheel_reference(self.body_id, reference.wheels);
        self.world.step();
    }

    fn pass_ms(&mut self, millis: u64) {
        (0..millis / 10).for_each(|_| self.tick(None));
    }

    /// Cuts the line to the robot, or from it, and mends it where it is not to be cut.
    fn cut(&mut self, [to_robot, from_robot]: [bool; 2]) {
        self.link.set_cut(End::A, to_robot);
        self.link.set_cut(End::B, from_robot);
    }

    fn connect(&mut self) {
        let deadline = self.world.now() + Duration::from_secs(20);
        while !self.driver.is_connected() {
            assert!(self.world.now() < deadline, "{:?}", self.driver);
            self.tick(None);
        }
    }

    fn true_pose(&self) -> Se2 {
        self.world.body(self.body_id).world_from_base.se2()
    }

    fn speed_mps(&self) -> f64 {
        self.world.body(self.body_id).wheel_speeds.left_mps.abs()
    }
}

fn walls() -> SegmentWorld {
    let corners =
        [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| Vec2::new(x, y));
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    SegmentWorld::new(ends.map(|(&a, &b)| (geometry::Segment { a, b }, 0)))
}

fn drive(mps: f64) -> Command {
    Command::Drive(WheelSpeeds { left_mps: mps, right_mps: mps })
}

#[test]
fn over_a_bad_line_it_connects_drives_two_metres_turns_and_stops_on_silence() {
    for seed in 0..20 {
        let mut run = Loop::new(&bad_line(), seed);
        run.connect();
        // Whatever was lost of the settings is sent again.
        run.pass_ms(4000);
        assert!(run.firmware.motors_enabled(), "seed {seed}");
        // Two metres, as a navigator would: a reference every 200 ms until the odometer says so.
        while run.status.odometry.unwrap().odom_from_base.se2().x_m < 1.9 {
            assert!(run.world.now() < Stamp::from_millis(60_000), "seed {seed}");
            run.tick(Some(&drive(0.3)));
            run.pass_ms(190);
        }
        run.tick(Some(&Command::Stop));
        run.pass_ms(3000);
        let pose = run.true_pose();
        // 0.06 m of it are one look at the odometer, 0.03 m each packet that was lost on the way there.
        assert!((pose.x_m - 2.0).abs() < 0.2 && pose.y_m.abs() < 0.02, "seed {seed}: {pose:?}");
        assert!(run.speed_mps() < 1e-9, "seed {seed}");
        // The robot's own report agrees with the truth: perfect odometry, whole millimetres.
        let odom = run.status.odometry.unwrap().odom_from_base.se2();
        assert!((odom.x_m - pose.x_m).abs() < 0.003, "seed {seed}: {odom:?} {pose:?}");
        // A turn is asked for once; the driver repeats it with its heartbeat.
        let heading_in_odom_rad = -2.0;
        run.tick(Some(&Command::TurnTo { heading_in_odom_rad }));
        run.pass_ms(6000);
        let turned = run.true_pose().yaw_rad;
        assert!((turned - heading_in_odom_rad).abs() < 0.02, "seed {seed}: {turned}");
        // Silence: the watchdog stops the robot, the driver notices and says so.
        run.tick(Some(&drive(0.2)));
        run.pass_ms(2000);
        assert!(run.speed_mps() > 0.15, "seed {seed}");
        run.cut([true, true]);
        run.pass_ms(3500);
        assert!(run.speed_mps() < 1e-9, "seed {seed}");
        assert!(run.n_link_down >= 1 && !run.driver.is_connected(), "seed {seed}");
        // And when the line is mended, they find each other again.
        run.cut([false, false]);
        run.connect();
        run.pass_ms(3000);
        assert!(run.driver.is_connected() && run.speed_mps() < 1e-9, "seed {seed}");
        assert!(run.n_link_up >= 2, "seed {seed}");
    }
}

/// The way of the watchdog: at the speed until it bites, then down its ramp, m.
fn watchdog_way_m(speed_mps: f64) -> f64 {
    let acceleration_mps2 = 0.5;
    2.0 * speed_mps + speed_mps * speed_mps / (2.0 * acceleration_mps2)
}

#[test]
fn whichever_direction_is_cut_the_robot_stops_within_the_watchdogs_way_and_stays_there() {
    let clean = LinkConfig { baud: Some(9600), ..LinkConfig::default() };
    for cut in [[true, false], [false, true], [true, true]] {
        for seed in 0..10 {
            let line = if seed % 2 == 0 { clean.clone() } else { bad_line() };
            let mut run = Loop::new(&line, seed);
            run.connect();
            run.pass_ms(3000);
            for _ in 0..10 + seed {
                run.tick(Some(&drive(0.3)));
                run.pass_ms(190 + 10 * (seed % 3));
            }
            let at_cut_m = run.true_pose().x_m;
            run.cut(cut);
            // The navigator goes on asking as long as it has not been told.
            while run.n_link_down == 0 && run.world.now() < Stamp::from_millis(30_000) {
                run.tick(Some(&drive(0.3)));
            }
            run.pass_ms(6000);
            let way_m = run.true_pose().x_m - at_cut_m;
            let case = format!("cut {cut:?}, seed {seed}: {way_m:.3} m");
            assert!(run.n_link_down >= 1 && run.speed_mps() < 1e-9, "{case}");
            assert!(way_m <= watchdog_way_m(0.3) + 0.02, "{case}");
            // Mended, the two find each other, and nobody remembers the motion.
            run.cut([false, false]);
            let at_rest_m = run.true_pose().x_m;
            run.connect();
            run.pass_ms(3000);
            let crept_m = (run.true_pose().x_m - at_rest_m).abs();
            assert!(crept_m < 0.02, "{case}, then {crept_m:.3} m");
        }
    }
}

/// A client died while its robot drove; the next one must not keep the old motion alive.
#[test]
fn a_driver_that_comes_to_a_driving_robot_stops_it_first() {
    let clean = LinkConfig { baud: Some(9600), ..LinkConfig::default() };
    for pause_ms in [0, 1000, 1900, 2100, 4000] {
        let mut run = Loop::new(&clean, 3);
        run.connect();
        run.pass_ms(1000);
        run.tick(Some(&drive(0.3)));
        run.pass_ms(2000);
        // Whatever was on its way to the new one is lost: it hears nothing of the robot at first.
        run.cut([true, true]);
        let config = PioneerDriverConfig::default();
        let dead = std::mem::replace(&mut run.driver, PioneerDriver::new(config));
        assert!(dead.is_connected());
        let at_death_m = run.true_pose().x_m;
        let mut new_one = PioneerDriver::new(PioneerDriverConfig::default());
        run.pass_ms(pause_ms);
        std::mem::swap(&mut run.driver, &mut new_one);
        run.cut([false, true]);
        run.pass_ms(5000);
        let way_m = run.true_pose().x_m - at_death_m;
        assert!(run.speed_mps() < 1e-9, "{pause_ms} ms");
        assert!(way_m <= watchdog_way_m(0.3) + 0.02, "{pause_ms} ms: {way_m:.3} m");
    }
}

#[test]
fn a_robot_that_was_switched_off_and_on_is_found_again_and_stands() {
    let clean = LinkConfig { baud: Some(9600), ..LinkConfig::default() };
    let mut run = Loop::new(&clean, 4);
    run.connect();
    run.pass_ms(1000);
    run.tick(Some(&drive(0.3)));
    run.pass_ms(2000);
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let rng = RunSeed(4).stream("sonar");
    run.firmware = PioneerFirmware::new(model, PioneerConfig::default(), rng);
    while run.driver.is_connected() {
        run.tick(Some(&drive(0.3)));
    }
    run.connect();
    run.pass_ms(3000);
    assert!(run.firmware.motors_enabled() && run.speed_mps() < 1e-9);
    assert_eq!((run.n_link_up, run.n_link_down), (2, 1));
}

#[test]
fn a_good_line_needs_no_second_try() {
    let line = LinkConfig { baud: Some(9600), ..LinkConfig::default() };
    let mut run = Loop::new(&line, 1);
    run.pass_ms(3000);
    let counters = run.driver.counters();
    assert_eq!((counters.n_connections, counters.n_retries, counters.n_mended), (1, 0, 0));
    assert_eq!(run.driver.robot_config().unwrap().acceleration_mmps2, 500);
    assert_eq!(run.driver.identity().unwrap().last().unwrap(), "p3dx-sh");
    assert!(counters.n_sips >= 26, "{counters:?}");
    assert_eq!(run.driver.decoder().bytes_skipped(), 0);
}

#[test]
fn every_sonar_is_heard_within_half_a_second() {
    let mut run = Loop::new(&LinkConfig::default(), 1);
    run.connect();
    let mut fresh = 0;
    for _ in 0..50 {
        run.tick(None);
        for observation in &run.observations {
            if let Sensed::Ring(ring) = observation.value {
                fresh |= ring.fresh;
                assert!(ring.ranges_m().iter().all(|range_m| (0.1..=5.0).contains(range_m)));
            }
        }
    }
    assert_eq!(fresh, 0xFFFF);
}

#[test]
fn the_same_seed_repeats_the_run() {
    let run = |seed| {
        let mut run = Loop::new(&bad_line(), seed);
        run.connect();
        run.tick(Some(&drive(0.3)));
        run.pass_ms(3000);
        (run.true_pose(), run.driver.counters(), run.world.now())
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5).1, run(6).1);
}
