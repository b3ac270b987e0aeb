//! Serves one simulated Pioneer on a TCP port, in real time: `serve_pioneer [port [recording]]`.
//!
//! Clients of the real robot connect to it unchanged. With a second argument the bytes of the first
//! session are written to `recording.client.bin` and `recording.robot.bin`: records of tick
//! number (u32), length (u16), both little endian, and the bytes.

#![expect(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "the edge: real time, a terminal"
)]

use std::{
    error::Error,
    fs::File,
    io::{ErrorKind, Read, Write},
    net::{TcpListener, TcpStream},
    sync::Arc,
    time::{Duration, Instant},
};

use geometry::{Se2, Segment, SegmentWorld, Vec2};
use robot_models::{OdometryErrors, RobotModel};
use run_context::RunSeed;
use sensor_models::SonarModel;
use simulator::{RobotPlacement, World, WorldSpec};
use virtual_robots::{Exchange, PioneerConfig, PioneerFirmware, ServedWorld};

const STEP: Duration = Duration::from_millis(10);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let port = arguments.next().map_or(Ok(8101), |text| text.parse())?;
    let mut recording = arguments.next();
    let mut robot = robot_in_a_room()?;
    let listener = TcpListener::bind(("127.0.0.1", port))?;
    println!("a simulated Pioneer answers on {}", listener.local_addr()?);
    loop {
        let (stream, client) = listener.accept()?;
        println!("{client} is here");
        let mut recorder = recording.take().map(Recorder::create).transpose()?;
        match serve(stream, &mut robot, recorder.as_mut()) {
            Ok(()) => println!("{client} is gone"),
            Err(error) => println!("{client} is gone: {error}"),
        }
        robot.hang_up(0);
        println!("{:?}", robot.boards()[0].board().status());
    }
}

fn robot_in_a_room() -> Result<ServedWorld, Box<dyn Error>> {
    let corners =
        [(-4.0, -3.0), (6.0, -3.0), (6.0, 5.0), (-4.0, 5.0)].map(|(x, y)| Vec2::new(x, y));
    let walls = (0..4).map(|i| (Segment { a: corners[i], b: corners[(i + 1) % 4] }, 0));
    let mut world = World::new(WorldSpec::of_walls(SegmentWorld::new(walls)), RunSeed(1), STEP)?;
    let model = Arc::new(RobotModel::by_name("pioneer3dx")?);
    let body_id = world.add_robot(RobotPlacement {
        name: "pioneer".to_owned(),
        model: Arc::clone(&model),
        world_from_base: Se2::IDENTITY,
        errors: OdometryErrors::default(),
        sonar: SonarModel::default(),
    })?;
    let firmware =
        PioneerFirmware::new(model, PioneerConfig::default(), RunSeed(1).stream("sonar/pioneer"));
    let mut served = ServedWorld::new(world);
    served.admit(body_id, Box::new(firmware));
    Ok(served)
}

/// Carries bytes between the socket and the robot until the client leaves.
fn serve(
    mut stream: TcpStream,
    robot: &mut ServedWorld,
    mut recorder: Option<&mut Recorder>,
) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    // A read waits for the client at most half a tick; so this is also what paces the loop.
    stream.set_read_timeout(Some(STEP / 2))?;
    let began = Instant::now();
    let (mut exchange, mut events, mut buffer) = ([Exchange::default()], Vec::new(), [0; 4096]);
    let mut tick = 0;
    loop {
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(n) => exchange[0].received.extend_from_slice(&buffer[..n]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
        while STEP * tick < began.elapsed() {
            robot.tick(&mut exchange, &mut events);
            events.clear();
            let [Exchange { received, out }] = &mut exchange;
            if let Some(recorder) = &mut recorder {
                recorder.record(tick, received, out)?;
            }
            stream.write_all(out)?;
            received.clear();
            out.clear();
            tick += 1;
        }
    }
}

struct Recorder {
    client: File,
    robot: File,
}

impl Recorder {
    fn create(stem: String) -> std::io::Result<Self> {
        Ok(Self {
            client: File::create(format!("{stem}.client.bin"))?,
            robot: File::create(stem + ".robot.bin")?,
        })
    }

    fn record(&mut self, tick: u32, received: &[u8], sent: &[u8]) -> std::io::Result<()> {
        for (file, bytes) in [(&mut self.client, received), (&mut self.robot, sent)] {
            if let Ok(len) = u16::try_from(bytes.len())
                && len > 0
            {
                file.write_all(&tick.to_le_bytes())?;
                file.write_all(&len.to_le_bytes())?;
                file.write_all(bytes)?;
            }
        }
        Ok(())
    }
}
