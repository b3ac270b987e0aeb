//! The same driver drives a robot over memory and over a socket.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use drivers::{PioneerDriver, PioneerDriverConfig};
use geometry::Se2;
use messages::{BaseState, Command, Observations};
use missions::{MemoryTransport, Mission, Run, TcpTransport, Transport};
use robot_models::{OdometryErrors, RobotModel, WheelSpeeds};
use run_context::{RunSeed, Stamp};
use sensor_models::SonarModel;
use simulator::{RobotPlacement, World, WorldSpec};
use virtual_robots::{Exchange, PioneerConfig, PioneerFirmware, ServedWorld};
use wire::link::{End, Link, LinkConfig};

fn lonely_robot() -> ServedWorld {
    let model = Arc::new(RobotModel::by_name("pioneer3dx").unwrap());
    let mut world = World::new(WorldSpec::empty(), RunSeed(1), Duration::from_millis(10)).unwrap();
    let placement = RobotPlacement {
        name: "rover".to_owned(),
        model: Arc::clone(&model),
        world_from_base: Se2::IDENTITY,
        errors: OdometryErrors::default(),
        sonar: SonarModel::default(),
    };
    let body = world.add_robot(placement).unwrap();
    let rng = RunSeed(1).stream("rover");
    let mut served = ServedWorld::new(world);
    let firmware = PioneerFirmware::new(model, PioneerConfig::default(), rng);
    served.admit(body, Box::new(firmware));
    served
}

/// One tick of the lonely robot, which hears `received`; what it answers is appended to `out`.
fn tick(robot: &mut ServedWorld, received: &[u8], out: &mut Vec<u8>) {
    let received = received.to_vec();
    let mut exchange = [Exchange { received, out: std::mem::take(out) }];
    robot.tick(&mut exchange, &mut Vec::new());
    let [exchange] = exchange;
    *out = exchange.out;
}

/// Connects, then drives at 0.2 m/s; `pass` lets the other side take a step of 10 ms.
fn drive(transport: &mut dyn Transport, mut pass: impl FnMut(Stamp, &mut dyn Transport)) -> f64 {
    let mut driver = PioneerDriver::new(PioneerDriverConfig::default());
    let (mut received, mut out) = (Vec::new(), Vec::new());
    let mut observations = Observations::new();
    let mut last = BaseState::default();
    let mut started = false;
    for step in 0..600 {
        let now = Stamp::from_millis(step * 10);
        received.clear();
        out.clear();
        observations.clear();
        transport.receive(now, &mut received).unwrap();
        driver.step(now, &received, &mut observations, &mut out);
        for observation in &observations {
            last.take(observation);
        }
        if !started && last.motors.is_some_and(|motors| motors.enabled) {
            started = true;
            let wheels = WheelSpeeds { left_mps: 0.2, right_mps: 0.2 };
            driver.command(now, &Command::Drive(wheels), &mut out);
        }
        transport.send(now, &out).unwrap();
        pass(now, transport);
    }
    last.odometry.map_or(0.0, |odometry| odometry.odom_from_base.se2().x_m)
}

#[test]
fn the_driver_drives_a_robot_over_memory() {
    let mut robot = lonely_robot();
    let mut link = Link::new(&LinkConfig::default(), RunSeed(1).stream("link")).unwrap();
    let (mut to_robot, mut from_robot) = (Vec::new(), Vec::new());
    let mut driver = PioneerDriver::new(PioneerDriverConfig::default());
    let mut connected = false;
    for step in 0..300 {
        let now = Stamp::from_millis(step * 10);
        let (mut received, mut out) = (Vec::new(), Vec::new());
        let mut observations = Observations::new();
        let mut transport = MemoryTransport::new(&mut link, End::A);
        transport.receive(now, &mut received).unwrap();
        driver.step(now, &received, &mut observations, &mut out);
        transport.send(now, &out).unwrap();
        to_robot.clear();
        from_robot.clear();
        link.receive(End::B, now, &mut to_robot);
        tick(&mut robot, &to_robot, &mut from_robot);
        link.send(End::B, now, &from_robot);
        connected |= driver.is_connected();
    }
    assert!(connected);
}

/// Serves a robot on a socket, one tick per request byte burst; ends when told to.
fn serve(listener: &TcpListener, stop: &AtomicBool) -> f64 {
    let (mut stream, _) = listener.accept().unwrap();
    stream.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
    let mut robot = lonely_robot();
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let n = read_some(&mut stream, &mut buffer);
        let mut out = Vec::new();
        tick(&mut robot, &buffer[..n], &mut out);
        if stream.write_all(&out).is_err() {
            break;
        }
    }
    robot.body_of(&robot.boards()[0]).position().x
}

fn read_some(stream: &mut TcpStream, buffer: &mut [u8]) -> usize {
    stream.read(buffer).unwrap_or(0)
}

#[test]
fn the_same_driver_drives_a_robot_over_tcp() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let stop = Arc::new(AtomicBool::new(false));
    let stop_server = Arc::clone(&stop);
    let server = thread::spawn(move || serve(&listener, &stop_server));

    let mut transport = TcpTransport::connect(&address).unwrap();
    // The driver's clock must not run away from the robot's: a peer that answers every millisecond
    // is waited for by reading with patience.
    let reported_m = drive(&mut transport, |_now, _transport| {
        thread::park_timeout(Duration::from_millis(3));
    });
    stop.store(true, Ordering::Relaxed);
    let true_m = server.join().unwrap();
    assert!(reported_m > 0.1, "the robot reports {reported_m} m");
    assert!(true_m >= reported_m - 0.01, "it is at {true_m} m");
}

#[test]
fn a_robot_that_is_not_there_is_named() {
    // Bound and dropped: nobody listens there any more.
    let address = {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.local_addr().unwrap().to_string()
    };
    let overrides =
        ["robots.line.kind=tcp".to_owned(), format!("robots.line.address=\"{address}\"")];
    let mission = Mission::load("one-obstacle", &overrides).unwrap();
    let said = Run::new(mission, RunSeed(1)).unwrap_err().to_string();
    assert!(said.starts_with(&format!("robot `robot`: cannot connect to {address}")), "{said}");

    let serial = ["robots.line.kind=serial", "robots.line.device=/dev/no-such-port"];
    let serial: Vec<String> = serial.iter().map(|&s| s.to_owned()).collect();
    let mission = Mission::load("one-obstacle", &serial).unwrap();
    let said = Run::new(mission, RunSeed(1)).unwrap_err().to_string();
    assert!(said.contains("cannot connect to /dev/no-such-port"), "{said}");
}
