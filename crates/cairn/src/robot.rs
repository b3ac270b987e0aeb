//! `cairn robot`: one simulated robot for anybody's client.

use std::{fs, net::SocketAddr, path::Path, process::ExitCode, sync::Arc, time::Duration};

use anyhow::{Context, bail};
use geometry::Se2;
use missions::Mission;
use robot_models::{OdometryErrors, RobotModel};
use run_context::RunSeed;
use simulator::{RobotPlacement, World, WorldSpec, activmedia_map};
use virtual_robots::{PioneerConfig, PioneerFirmware, SoloRobot};

use crate::output::say;
use crate::parse;
use crate::serve::{self, Door, Peer};

/// One tick of the simulated world.
const TICK: Duration = Duration::from_millis(10);

/// Simulates one robot that answers the real one's bytes on a TCP port or a serial line
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn robot pioneer3dx --world office.map\n  \
    cairn robot peoplebot --world doorbell --start -2.6,-3.1,90 --listen 127.0.0.1:8102\n\n\
    Programs written with the manufacturer's library connect to the port as to a simulator.")]
pub(crate) struct Args {
    /// Which robot: pioneer3dx or peoplebot
    model: String,
    /// An ActivMedia 2-D map (.map), a mission file (.toml), or the name of a shipped mission
    #[arg(long, value_name = "FILE")]
    world: String,
    /// Where clients connect
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        default_value = "127.0.0.1:8101",
        value_parser = parse::address
    )]
    listen: SocketAddr,
    /// Talk over this serial line instead of a TCP port
    #[arg(long, value_name = "DEVICE", conflicts_with = "listen")]
    serial: Option<String>,
    /// Speed of the serial line, bits per second
    #[arg(long, value_name = "BITS", default_value_t = 9600)]
    baud: u32,
    /// Where it stands: x and y in metres, heading in degrees; else the map's RobotHome, else the
    /// start of the mission's first robot, else the middle of the world
    #[arg(long, value_name = "X,Y,DEG", allow_hyphen_values = true)]
    start: Option<String>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::seed)]
    seed: u64,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let model = Arc::new(RobotModel::by_name(&args.model)?);
    anyhow::ensure!(
        model.speaks_arcos(),
        "{} does not speak the protocol that is served here; pioneer3dx and peoplebot do",
        model.title
    );
    let seed = RunSeed(args.seed);
    let (mut world, home) = load_world(&args.world, seed)?;
    let start = match &args.start {
        Some(text) => parse_pose(text)?,
        None => home.unwrap_or_else(|| middle(&world)),
    };
    let placement = RobotPlacement {
        name: args.model.clone(),
        model: model.clone(),
        world_from_base: start,
        errors: OdometryErrors::default(),
        sonar: sensor_models::SonarModel::default(),
    };
    let body_id = world.add_robot(placement).with_context(|| {
        format!("the robot cannot stand in {}; choose a place with --start", args.world)
    })?;
    let firmware =
        PioneerFirmware::new(model.clone(), PioneerConfig::default(), seed.stream("robot/sensors"));
    let mut robot = Robot(SoloRobot::new(world, body_id, firmware));
    let door = match &args.serial {
        Some(device) => Door::serial(device, args.baud)?,
        None => Door::tcp(args.listen)?,
    };
    let Se2 { x_m, y_m, yaw_rad } = start;
    say!(
        "{} at ({x_m:.2}, {y_m:.2}) m, {:.0}°, in {}: connect to {}; Ctrl-C ends it",
        model.title,
        yaw_rad.to_degrees(),
        args.world,
        door.name()
    );
    serve::forever(door, &mut robot, TICK)?;
    Ok(ExitCode::SUCCESS)
}

struct Robot(SoloRobot);

impl Peer for Robot {
    fn tick(&mut self, received: &[u8], out: &mut Vec<u8>) {
        self.0.tick(received, out);
    }

    fn hang_up(&mut self) {
        self.0.hang_up();
    }
}

/// The world, and where a robot would begin in it.
fn load_world(name: &str, seed: RunSeed) -> anyhow::Result<(World, Option<Se2>)> {
    if name.to_ascii_lowercase().ends_with(".map.gz") {
        bail!("{name} is packed: unpack it first (gunzip --keep {name}) and give the .map file");
    }
    if Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("map")) {
        let text = fs::read(name).with_context(|| format!("cannot read the map {name}"))?;
        let map = activmedia_map::parse(&String::from_utf8_lossy(&text))
            .with_context(|| format!("{name} is not an ActivMedia 2-D map"))?;
        map.warnings.iter().for_each(|warning| eprintln!("{name}: {warning}"));
        let world = World::new(WorldSpec::of_walls(map.to_segment_world()), seed, TICK)?;
        return Ok((world, map.home));
    }
    let mission = Mission::load(name, &[])?;
    let (world, start) = missions::world_of(&mission, seed)?;
    Ok((world, start))
}

fn middle(world: &World) -> Se2 {
    let bounds = world.static_map().bounds();
    let middle = (bounds.min + bounds.max) / 2.0;
    if middle.x.is_finite() && middle.y.is_finite() {
        Se2::new(middle.x, middle.y, 0.0)
    } else {
        Se2::IDENTITY
    }
}

fn parse_pose(text: &str) -> anyhow::Result<Se2> {
    let parts = text.split(',').map(|n| n.trim().parse::<f64>());
    let numbers = parts.collect::<Result<Vec<f64>, _>>().unwrap_or_default();
    match numbers.as_slice() {
        &[x_m, y_m, heading_deg] if numbers.iter().all(|n| n.is_finite()) => {
            Ok(Se2::new(x_m, y_m, heading_deg.to_radians()))
        }
        _ => bail!("--start {text}: give three numbers, such as -2.6,-3.1,90 (m, m, degrees)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_three_numbers() {
        let pose = parse_pose("-2.6, -3.1,90").unwrap();
        assert!((pose.x_m + 2.6).abs() < 1e-12 && (pose.y_m + 3.1).abs() < 1e-12);
        assert!((pose.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        for wrong in ["", "1,2", "1,2,x", "1,x,2,3", "1,2,3,4", "1,2,nan", "1,inf,3"] {
            assert!(parse_pose(wrong).is_err(), "{wrong}");
        }
    }
}
