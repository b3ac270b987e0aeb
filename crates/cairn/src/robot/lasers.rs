//! Lasers on served robots: one each, with a line of its own.

use std::net::SocketAddr;

use anyhow::{Context, bail};
use run_context::RunSeed;
use sensor_models::LaserKind;
use serde_json::json;
use virtual_robots::{LaserConfig, ServedWorld, laser_baud, laser_board};

use super::{memory::RobotLine, numbers::parse_pose};
use crate::{
    output::{Format, say},
    serve::{Door, Log},
};

/// What is asked of lasers.
#[derive(Debug, clap::Args)]
pub(super) struct LaserArgs {
    #[arg(long, value_name = "KIND", value_parser = kind, help = kind_help())]
    laser: Option<LaserKind>,
    /// Where clients of the first robot's laser connect; the port after the robots' unless given, with --pty a second
    /// pseudo-terminal
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = crate::parse::address, requires = "laser")]
    laser_listen: Option<SocketAddr>,
    /// The laser talks over this serial line instead of a TCP port, at the speed of its cable
    #[arg(long, value_name = "DEVICE", requires = "laser", conflicts_with_all = ["laser_listen", "robots"])]
    laser_serial: Option<String>,
    /// Where the laser's sensor is on the robot: x ahead of the point midway between the wheels and y to its left in
    /// metres, heading in degrees
    #[arg(
        long,
        value_name = "X,Y,DEG",
        allow_hyphen_values = true,
        requires = "laser",
        default_value = "0.018,0,0"
    )]
    laser_at: String,
}

impl LaserArgs {
    /// Puts a laser on each robot, after the robots' own boards.
    pub(super) fn admit(
        &self,
        served: &mut ServedWorld,
        lines: &mut Vec<RobotLine>,
        seed: RunSeed,
    ) -> anyhow::Result<()> {
        let Some(kind) = self.laser else { return Ok(()) };
        let base_from_sensor = parse_pose("--laser-at", &self.laser_at)?;
        if base_from_sensor.position().norm() > 2.0 {
            bail!("--laser-at {}: at most 2 m from the robot's middle", self.laser_at);
        }
        let bodies: Vec<_> =
            served.boards().iter().map(virtual_robots::ServedBoard::body_id).collect();
        for (number, body_id) in bodies.into_iter().enumerate() {
            let name = lines.get(number).map_or_else(String::new, |line| line.name.clone());
            let name = format!("{name}/laser");
            let mut config = LaserConfig::new(kind, base_from_sensor);
            config.is_paced = self.laser_serial.is_some();
            served.admit(body_id, laser_board(config, seed.stream(&name)));
            lines.push(RobotLine { name, is_laser: true, ..RobotLine::default() });
        }
        Ok(())
    }

    /// A door for the laser of each of `n` robots, of which the first listens there; with `pty` a pseudo-terminal.
    pub(super) fn doors(&self, listen: SocketAddr, n: u16, pty: bool) -> anyhow::Result<Vec<Door>> {
        let Some(kind) = self.laser else { return Ok(Vec::new()) };
        if pty && self.laser_serial.is_none() && self.laser_listen.is_none() {
            return Ok(vec![Door::pty()?]);
        }
        if let Some(device) = &self.laser_serial {
            return Ok(vec![Door::serial(device, laser_baud(kind))?]);
        }
        let mut first = self.laser_listen.unwrap_or(listen);
        if self.laser_listen.is_none() && first.port() != 0 {
            let after = listen.port().checked_add(n);
            first.set_port(after.context("no port is left for the laser: give --laser-listen")?);
        }
        let door = |number: u16| {
            let mut address = first;
            // Port 0 lets the computer choose, for each.
            if first.port() != 0 {
                let port = first.port().checked_add(number);
                address.set_port(port.context("the lasers' ports end at 65535")?);
            }
            Door::tcp(address)
                .context("the laser needs a port of its own: choose it with --laser-listen")
        };
        (0..n).map(door).collect()
    }

    /// Tells where a laser is found.
    pub(super) fn tell(&self, format: Format, name: &str, door: &str) {
        let Some(kind) = self.laser else { return };
        let text = format!("{} of {name}: connect to {door}; Ctrl-C ends it", kind.title());
        match format {
            Format::Text => say!("{text}"),
            Format::Json => Log::new(format).event(
                name,
                "listening",
                &text,
                json!({"address": door, "laser": kind.name()}),
            ),
        }
    }
}

fn kind(text: &str) -> Result<LaserKind, String> {
    LaserKind::by_name(text).ok_or_else(|| {
        let hint = settings::did_you_mean(text, LaserKind::ALL.map(LaserKind::name));
        let hint = hint.map(|name| format!("; did you mean {name}?")).unwrap_or_default();
        format!("there are {}{hint}", kinds("and"))
    })
}

fn kinds(word: &str) -> String {
    crate::parse::listed(&LaserKind::ALL.map(|kind| kind.name().to_owned()), word)
}

fn kind_help() -> String {
    let titles: Vec<String> =
        LaserKind::ALL.iter().map(|kind| format!("{} ({})", kind.name(), kind.title())).collect();
    format!("Put a laser on each robot: {}", crate::parse::listed(&titles, "or"))
}
