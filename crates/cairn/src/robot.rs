//! `cairn robot`: simulated robots for anybody's clients.

mod lasers;
mod memory;
mod numbers;
mod places;

use std::{
    net::SocketAddr, num::NonZeroU16, path::Path, process::ExitCode, sync::Arc, time::Duration,
};

use anyhow::{Context, bail};
use geometry::{Polygon, Se2, Vec2};
use robot_models::RobotModel;
use run_context::RunSeed;
use serde_json::{Value, json};
use simulator::{Fixtures, World, WorldSpec, activmedia_map, floor_plan::MapFormat};
use virtual_robots::{
    BatteryConfig, BoardConfig, BoardStatus, Exchange, ServedBoard, ServedEvent, ServedWorld,
};

use crate::{
    output::{Format, complain, say},
    parse,
    serve::{self, Door, Log, Peer},
    world_map,
};
use memory::RobotLine;
use numbers::{numbers, parse_pose};

/// One tick of the simulated world.
const TICK: Duration = Duration::from_millis(10);
/// How long the client of a robot without a watchdog may be silent before another may take its place.
const PATIENCE: Duration = Duration::from_secs(2);
/// The name that a single robot reports.
const NAME: &str = "cairn";
/// Messages of one robot's clients that are told in one second; the rest are counted.
const N_MESSAGES_MAX: u32 = 10;

/// Simulates robots that answer the real ones' bytes, each on a TCP port or one on a serial line
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn robot pioneer3dx --world office.map\n  \
    cairn robot peoplebot --world doorbell --start -2.6,-3.1,90 --listen 127.0.0.1:8102\n  \
    cairn robot pioneer3dx --world doorbell --robots 3\n  \
    cairn robot pioneer3dx --world doorbell --laser sick\n  \
    cairn robot create2 --world one-obstacle --pty\n\n\
    Programs written for the robot connect to the port, or to the serial line, as to the robot itself.")]
pub(crate) struct Args {
    #[arg(value_parser = parse::model, help = parse::model_help())]
    model: String,
    /// A map (a ROS map's .yaml; .map of ActivMedia or Moving AI), a mission file (.toml), or the name of a shipped
    /// mission
    #[arg(long, value_name = "FILE")]
    world: String,
    /// How many robots share the world; each has its own port, the first the one of --listen, the
    /// second the next one, and so on
    #[arg(long, value_name = "N", default_value = "1", value_parser = parse::n_robots)]
    robots: NonZeroU16,
    /// Where clients of the first robot connect
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        default_value = "127.0.0.1:8101",
        value_parser = parse::address
    )]
    listen: SocketAddr,
    /// Talk over this serial line instead of a TCP port
    #[arg(long, value_name = "DEVICE", conflicts_with_all = ["listen", "robots"])]
    serial: Option<String>,
    /// Talk over a pseudo-terminal, whose name is printed: a serial line for programs on this computer
    #[arg(long, conflicts_with_all = ["listen", "robots", "serial"])]
    pty: bool,
    /// Speed of the serial line, bits per second; the robot's own unless given
    #[arg(long, value_name = "BITS", requires = "serial")]
    baud: Option<u32>,
    /// Where it stands: x and y in metres, heading in degrees; else the map's RobotHome, else the
    /// start of the mission's first robot, else the widest place of the map, else the middle of the
    /// world. Once for each robot; those
    /// without one stand beside the first
    #[arg(long, value_name = "X,Y,DEG", allow_hyphen_values = true)]
    start: Vec<String>,
    /// A rectangle without floor, m; may be given several times
    #[arg(long = "cliff", value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true)]
    cliffs: Vec<String>,
    /// Where a virtual wall stands and which way it sends its beam; may be given several times
    #[arg(long = "virtual-wall", value_name = "X,Y,DEG", allow_hyphen_values = true)]
    virtual_walls: Vec<String>,
    /// Where a robot stands that charges, and which way it looks; may be given several times
    #[arg(long = "dock", value_name = "X,Y,DEG", allow_hyphen_values = true)]
    docks: Vec<String>,
    #[command(flatten)]
    laser: lasers::LaserArgs,
    /// Charge of the battery, percent; below 20 it is low, at 0 the motors are off
    #[arg(long, value_name = "PERCENT", default_value_t = 100.0, value_parser = parse::percent)]
    battery: f64,
    /// How much faster than a real battery it drains; 0: never
    #[arg(long, value_name = "RATIO", default_value_t = 1.0, value_parser = parse::drain_ratio)]
    drain: f64,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::seed)]
    seed: u64,
    /// What is told of clients: lines for people, or one JSON object a line
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let model = Arc::new(RobotModel::by_name(&args.model)?);
    anyhow::ensure!(
        virtual_robots::has_board(&model),
        "{} speaks no protocol that is simulated here; {} do",
        model.title,
        parse::served()
    );
    let names: Vec<String> = match args.robots.get() {
        1 => vec![args.model.clone()],
        n => (1..=n).map(|number| format!("{}-{number}", args.model)).collect(),
    };
    let mut robots = Robots::new(args, &model, &names)?;
    let mut doors = doors(args, &model)?;
    doors.extend(args.laser.doors(args.listen, args.robots.get(), args.pty)?);
    for ((board, line), door) in robots.served.boards().iter().zip(&robots.lines).zip(&doors) {
        if line.is_laser {
            args.laser.tell(args.format, robots.name_of(board), &door.name());
        } else {
            tell_door(args, &model, robots.name_of(board), board.start(), &door.name());
        }
    }
    serve::forever(doors, &mut robots, TICK, Log::new(args.format))?;
    Ok(ExitCode::SUCCESS)
}

/// One door for each robot, on consecutive ports.
fn doors(args: &Args, model: &RobotModel) -> anyhow::Result<Vec<Door>> {
    if args.pty {
        return Ok(vec![Door::pty()?]);
    }
    if let Some(device) = &args.serial {
        let own = model.line.as_ref().map(|line| line.baud);
        let baud = args.baud.or(own).context("give the speed of the line with --baud")?;
        return Ok(vec![Door::serial(device, baud)?]);
    }
    let first = args.listen.port();
    let n = args.robots.get();
    let Some(last) = first.checked_add(n - 1) else {
        bail!(
            "--robots {n} needs the ports from {first} on, which end at 65535; --listen a lower one"
        )
    };
    let door = |number: u16| {
        let mut address = args.listen;
        // Port 0 lets the computer choose, for each.
        address.set_port(if first == 0 { 0 } else { first + number });
        let opened = Door::tcp(address);
        if n > 1 {
            opened.with_context(|| format!("{n} robots need the ports {first} to {last}"))
        } else {
            opened
        }
    };
    (0..n).map(door).collect()
}

fn tell_door(args: &Args, model: &RobotModel, name: &str, start: Se2, door: &str) {
    let Se2 { x_m, y_m, yaw_rad } = start;
    let heading_deg = yaw_rad.to_degrees();
    let title =
        if args.robots.get() > 1 { format!("{} {name}", model.title) } else { model.title.clone() };
    let text = format!(
        "{title} at ({x_m:.2}, {y_m:.2}) m, {heading_deg:.0}°, in {}: connect to {door}; Ctrl-C ends it",
        args.world
    );
    match args.format {
        Format::Text => say!("{text}"),
        Format::Json => Log::new(args.format).event(
            name,
            "listening",
            &text,
            json!({
                "address": door, "world": args.world, "model": args.model,
                "x_m": x_m, "y_m": y_m, "heading_deg": heading_deg,
            }),
        ),
    }
}

/// The robots behind the doors.
struct Robots {
    served: ServedWorld,
    lines: Vec<RobotLine>,
    events: Vec<(usize, ServedEvent)>,
    several: bool,
    /// How long a client may be silent before another may take its place.
    patience: Duration,
}

impl Robots {
    fn new(args: &Args, model: &Arc<RobotModel>, names: &[String]) -> anyhow::Result<Self> {
        let seed = RunSeed(args.seed);
        let (mut world, home) = load_world(&args.world, seed)?;
        world.set_fixtures(fixtures(args)?);
        let given = poses("--start", &args.start)?;
        anyhow::ensure!(
            given.len() <= names.len(),
            "--start is given {} times for {} robot(s): once for each at most; --robots says how many",
            given.len(),
            names.len()
        );
        let home = home.unwrap_or_else(|| places::middle(&world));
        let bodies = places::place(&mut world, model, names, &given, home)
            .with_context(|| format!("no place in {}; choose one with --start", args.world))?;
        let mut served = ServedWorld::new(world);
        for (body_id, name) in bodies.into_iter().zip(names) {
            let config = BoardConfig {
                name: if names.len() > 1 { name.clone() } else { NAME.to_owned() },
                battery: BatteryConfig { charge_percent: args.battery, drain_ratio: args.drain },
            };
            let stream =
                if names.len() > 1 { format!("{name}/sensors") } else { "robot/sensors".into() };
            served.admit(body_id, virtual_robots::board(model, &config, seed.stream(&stream))?);
        }
        let watchdog = model.line.as_ref().and_then(|line| line.watchdog);
        let line = |name: &String| RobotLine { name: name.clone(), ..RobotLine::default() };
        let mut lines: Vec<RobotLine> = names.iter().map(line).collect();
        args.laser.admit(&mut served, &mut lines, seed)?;
        Ok(Self {
            served,
            several: lines.len() > 1,
            lines,
            events: Vec::new(),
            patience: watchdog.unwrap_or(PATIENCE),
        })
    }

    fn name_of(&self, robot: &ServedBoard) -> &str {
        &self.served.body_of(robot).name
    }

    /// Tells what a client wants whoever watches to know, but not more than a person can read.
    fn tell(&mut self, log: &Log) {
        let second = self.served.now().as_nanos() / 1_000_000_000;
        let mut events = std::mem::take(&mut self.events);
        for (index, event) in events.drain(..) {
            let name = if self.several { self.lines[index].name.clone() } else { String::new() };
            let line = &mut self.lines[index];
            if line.second != second {
                (line.second, line.n_told) = (second, 0);
            }
            if line.n_told >= N_MESSAGES_MAX {
                line.n_untold += 1;
                continue;
            }
            line.n_told += 1;
            let (kind, text, facts) = describe(&event);
            log.event(&name, kind, &text, facts);
        }
        self.events = events;
    }

    fn watch_batteries(&mut self, log: &Log) {
        for (robot, line) in self.served.boards().iter().zip(&mut self.lines) {
            let Some(battery) = robot.board().status().battery else { continue };
            let is_low = battery.is_low;
            if is_low && !line.battery_was_low {
                let (charge_percent, battery_v) = (battery.charge_percent, battery.voltage_v);
                let text = format!("battery low: {charge_percent:.0} %, {battery_v:.1} V");
                let name = if self.several { line.name.as_str() } else { "" };
                let facts = json!({"charge_percent": charge_percent, "battery_v": battery_v});
                log.event(name, "battery_low", &text, facts);
            }
            line.battery_was_low = is_low;
        }
    }
}

impl Peer for Robots {
    fn tick(&mut self, exchanges: &mut [Exchange], log: &mut Log) {
        self.served.tick(exchanges, &mut self.events);
        self.tell(log);
        self.watch_batteries(log);
    }

    fn hang_up(&mut self, line: usize) {
        self.served.hang_up(line);
        let robot = &self.served.boards()[line];
        let memory = &mut self.lines[line];
        memory.travelled_m = self.served.body_of(robot).travelled_m;
        memory.n_packets = robot.board().status().n_heard;
        memory.n_untold = 0;
    }

    fn name(&self, line: usize) -> Option<&str> {
        self.several.then(|| self.lines[line].name.as_str())
    }

    fn n_heard(&self, line: usize) -> u64 {
        self.served.boards()[line].board().status().n_heard
    }

    fn baud(&self, line: usize) -> Option<u32> {
        self.served.boards()[line].board().status().baud
    }

    /// Who reads a laser may be silent for ever; others wait until it leaves.
    fn patience(&self, line: usize) -> Option<Duration> {
        (!self.lines[line].is_laser).then_some(self.patience)
    }

    fn farewell(&self, line: usize) -> (String, Value) {
        let robot = &self.served.boards()[line];
        let (status, memory): (BoardStatus, _) = (robot.board().status(), &self.lines[line]);
        let body = self.served.body_of(robot);
        let Se2 { x_m, y_m, yaw_rad } = body.world_from_base.se2();
        let driven_m = body.travelled_m - memory.travelled_m;
        let n_packets = status.n_heard - memory.n_packets;
        let unknown: Vec<u8> = status.unknown.iter().collect();
        if memory.is_laser {
            return laser_farewell(n_packets, &unknown);
        }
        let mut text = format!(
            " and {n_packets} packets; the robot drove {driven_m:.3} m and stands at \
             ({x_m:.3}, {y_m:.3}) m, {:.1}°",
            yaw_rad.to_degrees()
        );
        text.push_str(&meaningless(&unknown));
        if memory.n_untold > 0 {
            text.push_str("; messages not shown: ");
            text.push_str(&memory.n_untold.to_string());
        }
        let facts = json!({
            "n_packets": n_packets, "driven_m": driven_m,
            "x_m": x_m, "y_m": y_m, "heading_deg": yaw_rad.to_degrees(),
            "unknown_commands": unknown, "n_messages_not_shown": memory.n_untold,
        });
        (text, facts)
    }

    fn note_interval(&mut self, interval: Duration) {
        self.served.note_interval(interval);
    }
}

/// What there is to tell of a laser's client that leaves.
fn laser_farewell(n_packets: u64, unknown: &[u8]) -> (String, Value) {
    let text = format!(" and {n_packets} requests{}", meaningless(unknown));
    (text, json!({"n_packets": n_packets, "unknown_commands": unknown}))
}

fn meaningless(unknown: &[u8]) -> String {
    if unknown.is_empty() {
        return String::new();
    }
    let numbers: Vec<String> = unknown.iter().map(u8::to_string).collect();
    format!("; commands that mean nothing to it: {}", numbers.join(", "))
}

/// Kind, text and facts of what a client asked of the simulator.
fn describe(event: &ServedEvent) -> (&'static str, String, Value) {
    let pose = |pose: &Se2| {
        let Se2 { x_m, y_m, yaw_rad } = *pose;
        let heading_deg = yaw_rad.to_degrees();
        (
            format!("({x_m:.3}, {y_m:.3}) m, {heading_deg:.0}°"),
            json!({"x_m": x_m, "y_m": y_m, "heading_deg": heading_deg}),
        )
    };
    match event {
        ServedEvent::Placed(at) => {
            let (place, facts) = pose(at);
            ("placed", format!("its client put it at {place}"), facts)
        }
        ServedEvent::PlaceRefused(at, why) => {
            let (place, facts) = pose(at);
            ("place_refused", format!("its client cannot put it at {place}: {why}"), facts)
        }
        // Strings come from strangers: escaped, they stay on their line.
        ServedEvent::Said(text) => {
            ("said", format!("its client says \"{}\"", text.escape_debug()), json!({"said": text}))
        }
        ServedEvent::Noted(text) => ("noted", text.clone(), json!({"note": text})),
        ServedEvent::ExitAsked(code) => (
            "exit_asked",
            format!("its client asks the simulator to end with code {code}; Ctrl-C does that here"),
            json!({"code": code}),
        ),
    }
}

/// The world, and where a robot would begin in it.
fn load_world(name: &str, seed: RunSeed) -> anyhow::Result<(World, Option<Se2>)> {
    let path = Path::new(name);
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("map")) {
        let text = files::read(path, "the map", files::Limit::TEXT, &mut |_, _| ())?;
        let text = String::from_utf8_lossy(&text);
        if MapFormat::of(&text) != Some(MapFormat::MovingAi) {
            // A mission knows nothing of the map's home.
            let map = activmedia_map::parse(&text)
                .with_context(|| format!("{name} is not an ActivMedia 2-D map"))?;
            map.warnings.iter().for_each(|warning| complain!("{name}: {warning}"));
            let world = World::new(WorldSpec::of_walls(map.to_segment_world()), seed, TICK)?;
            return Ok((world, map.home));
        }
    }
    let mission = world_map::mission(name)?;
    let (world, start) = missions::world_of(&mission, seed)?;
    Ok((world, start))
}

/// What is in the world beside what the map says.
fn fixtures(args: &Args) -> anyhow::Result<Fixtures> {
    let hole = |text: &String| {
        let [x0, y0, x1, y1] = numbers("--cliff", text, "four numbers, such as 1,-1,2,1 (m)")?;
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Vec2::new(x, y));
        Polygon::new(corners.to_vec()).with_context(|| format!("--cliff {text} has no area"))
    };
    Ok(Fixtures {
        holes: args.cliffs.iter().map(hole).collect::<anyhow::Result<_>>()?,
        virtual_walls: poses("--virtual-wall", &args.virtual_walls)?,
        docks: poses("--dock", &args.docks)?,
    })
}

fn poses(option: &str, texts: &[String]) -> anyhow::Result<Vec<Se2>> {
    texts.iter().map(|text| parse_pose(option, text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_three_numbers() {
        let pose = parse_pose("--start", "-2.6, -3.1,90").unwrap();
        assert!((pose.x_m + 2.6).abs() < 1e-12 && (pose.y_m + 3.1).abs() < 1e-12);
        assert!((pose.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        for wrong in ["", "1,2", "1,2,x", "1,x,2,3", "1,2,3,4", "1,2,nan", "1,inf,3"] {
            assert!(parse_pose("--start", wrong).is_err(), "{wrong}");
        }
    }
}
