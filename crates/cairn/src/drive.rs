//! `cairn drive`: a person, or a script, at the wheel of a robot.
//!
//! The robot's speeds hold for half a second and are renewed ten times a second while something is asked for. So
//! silence stops it, whether a key was released, the terminal was closed or the script has ended.

mod keys;
mod script;

use std::{fmt::Write as _, io::Write as _, path::PathBuf, process::ExitCode, time::Instant};

use anyhow::{Context, bail, ensure};
use files::{Kind, Outputs};
use missions::{DRIVE_HOLD, Intervention, LogLevel, Mission, Recorder, Run, ViewState};
use robot_models::RobotModel;
use run_context::RunSeed;
use serde_json::json;

use crate::{
    given,
    interrupt::{self, Interrupt},
    output::{Format, say},
    parse,
    run::wait_for_tick,
};
use keys::Keys;
use script::{Next, Piece, Script};

/// What is at the other end of a line unless somebody says otherwise.
const MODEL: &str = "pioneer3dx";
/// Steps between two renewals of a speed.
const STEPS_PER_RENEWAL: u64 = 10;
/// Steps between two lines of state in a terminal.
const STEPS_PER_LINE: u64 = 20;
/// How long a robot at the other end of a line may take to answer.
const ANSWER_PATIENCE_S: f64 = 10.0;
/// How long it may take to stand at the end.
const STAND_PATIENCE_S: f64 = 5.0;
/// Wheels slower than this stand, m/s.
const STANDING_MPS: f64 = 0.005;

/// Drives a robot by hand: with the keys of this terminal, or by a script
#[derive(Debug, clap::Args)]
#[command(after_help = "Keys, held:\n  \
    W or up forwards, S or down backwards, A or left and D or right turn, Q and E arcs; + and - change the pace;\n  \
    Space stops, Esc or X ends\n\n\
    Released keys stop the robot within 0.8 s, in terminals that report releases within 0.3 s; so does a closed terminal.\n\
    Ctrl-C, a request to terminate and a closed terminal leave the robot standing and the recording whole (exit code 130).\n\n\
    A script has one piece a line: seconds, m/s, rad/s (counter-clockwise), and # before remarks.\n\n\
    Examples:\n  cairn drive doorbell\n  \
    cairn drive one-obstacle --piece 2,0.3,0 --piece 1.5,0.2,0.8\n  \
    printf '2 0.3 0\\n1 0 0.8\\n2 0.3 0\\n' | cairn drive one-obstacle --script -\n  \
    cairn drive one-obstacle --script square.txt --record by-hand.mcap\n  \
    cairn drive --connect 127.0.0.1:8101\n  cairn drive --serial /dev/ttyUSB0 --baud 9600\n  \
    cairn drive --serial /dev/ttyUSB0 --model create2")]
pub(crate) struct Args {
    /// The mission in whose world it is driven; `doorbell` unless given
    #[arg(conflicts_with_all = ["connect", "serial"])]
    mission: Option<String>,
    /// Name of the robot; the mission's first unless given
    #[arg(long, value_name = "NAME", conflicts_with_all = ["connect", "serial"])]
    robot: Option<String>,
    /// Drives a robot, or its simulator, behind this TCP port; a Pioneer unless --model names another
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "serial")]
    connect: Option<String>,
    /// Drives a robot on this serial line; a Pioneer unless --model names another
    #[arg(long, value_name = "DEVICE")]
    serial: Option<String>,
    /// Speed of the serial line, bits per second; the robot's own unless given
    #[arg(long, value_name = "BITS", requires = "serial")]
    baud: Option<u32>,
    /// Which robot is at the other end of the line
    #[arg(long, value_name = "NAME", value_parser = parse::model)]
    model: Option<String>,
    /// Drives by this script (`-`: standard input) instead of keys; in simulation as fast as it can
    #[arg(long, value_name = "FILE")]
    script: Option<String>,
    /// The same on the command line, one piece each; may be given several times
    #[arg(
        long = "piece",
        value_name = "SECONDS,MPS,RADPS",
        allow_hyphen_values = true,
        conflicts_with = "script"
    )]
    pieces: Vec<String>,
    /// Seed of everything random; the mission's own unless given
    #[arg(long, value_name = "N", value_parser = parse::seed)]
    seed: Option<u64>,
    /// Changes one key of the mission; may be given several times
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE", conflicts_with_all = ["connect", "serial"])]
    overrides: Vec<String>,
    /// Records the drive (MCAP); `cairn replay` shows it again
    #[arg(long, value_name = "FILE", conflicts_with_all = ["connect", "serial"])]
    record: Option<PathBuf>,
    /// Replaces a recording of that name
    #[arg(long, requires = "record")]
    force: bool,
    /// How the end is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let script = match &args.script {
        Some(name) => Some(Script::open(name)?),
        None if args.pieces.is_empty() => None,
        None => Some(Script::of(&args.pieces)?),
    };
    if script.is_none() {
        keys::ensure_terminal()?;
    }
    let mission = mission(args)?;
    let seed = args.seed.map_or_else(|| mission.seed(), RunSeed);
    let is_elsewhere = mission.has_real_robot();
    let read = mission.read_from().iter().cloned().chain(script_file(args));
    let outputs = Outputs::new(args.force).keeping(read.collect::<Vec<PathBuf>>());
    if let Some(path) = &args.record {
        outputs.check(path, Kind::RECORDING)?;
    }
    let interrupt = Interrupt::listen()?;
    let run = Run::new(mission, seed)?;
    let robot = index_of(&run, args.robot.as_deref())?;
    let begin = |path: &PathBuf| Recorder::create(path, &run, &outputs);
    let recorder = args.record.as_ref().map(begin).transpose()?;
    let mut car = Car {
        run,
        robot,
        recorder,
        pace: (is_elsewhere || script.is_none()).then(Instant::now),
        is_elsewhere,
        is_quiet: args.format == Format::Json,
        interrupt,
    };
    car.wait_for_answer()?;
    let driven = match script {
        Some(script) => car.by_script(script),
        None => car.by_keys(),
    };
    // Whatever ended it: the robot stands first, and what was recorded is whole.
    let stood = car.stand();
    let recorded = car.recorder.take().map(|recorder| recorder.finish(&car.run)).transpose();
    driven.and(stood)?;
    let recorded = recorded?;
    car.tell_end(args.format);
    if let Some(path) = recorded {
        car.say(format_args!("Recorded in {}", path.display()));
    }
    if car.interrupt.happened() {
        interrupt::tell("interrupted; the drive ends here");
        return Ok(ExitCode::from(interrupt::EXIT_CODE));
    }
    Ok(ExitCode::SUCCESS)
}

/// The mission that was asked for, or one that holds nothing but a robot at the end of a line.
fn mission(args: &Args) -> anyhow::Result<Mission> {
    let model = RobotModel::by_name(args.model.as_deref().unwrap_or(MODEL))?;
    let link = match (&args.connect, &args.serial) {
        (Some(address), _) => json!({ "kind": "tcp", "address": address }),
        (_, Some(device)) => {
            let own = model.line.as_ref().map(|line| line.baud);
            let baud = args.baud.or(own).context("give the speed of the line with --baud")?;
            json!({ "kind": "serial", "device": device, "baud": baud })
        }
        _ => {
            ensure!(
                args.model.is_none(),
                "--model says what is at the other end of --connect or --serial; a mission names its robots itself"
            );
            let name = args.mission.as_deref().unwrap_or("doorbell");
            ensure!(
                name != "-" || args.script.as_deref() != Some("-"),
                "the mission and the script cannot both come from standard input"
            );
            return given::mission(name, &args.overrides);
        }
    };
    // The hand decides; but a mind that is to avoid things wants to hear them.
    let avoidance = if model.sonars.is_empty() { "off" } else { "checked" };
    let file = json!({
        "mission": { "name": "drive", "title": "Driven by hand", "duration_max_s": 3600.0 },
        "world": { "bounds_m": [-32.0, -32.0, 32.0, 32.0] },
        "robots": [{
            "name": "robot", "model": model.name,
            "mind": { "how": { "method": "straight" }, "guard": { "method": avoidance } }, "line": link,
        }],
    });
    let text = toml::to_string(&file).context("cannot write the mission of a single robot")?;
    Ok(Mission::parse("a robot on a line", &text, &[])?)
}

fn script_file(args: &Args) -> Option<PathBuf> {
    args.script.as_deref().filter(|name| *name != "-").map(PathBuf::from)
}

fn index_of(run: &Run, name: Option<&str>) -> anyhow::Result<usize> {
    let robots = run.scene().robots;
    ensure!(!robots.is_empty(), "mission `{}` has no robot to drive", run.mission().name());
    let Some(name) = name else { return Ok(0) };
    robots.iter().position(|robot| robot.name == name).with_context(|| {
        let names: Vec<&str> = robots.iter().take(20).map(|robot| &*robot.name).collect();
        format!(
            "mission `{}` has no robot `{name}`; robots: {}",
            run.mission().name(),
            names.join(", ")
        )
    })
}

/// A robot under way with somebody at the wheel.
struct Car {
    run: Run,
    robot: usize,
    recorder: Option<Recorder>,
    /// The next tick of real time, where time is real.
    pace: Option<Instant>,
    is_elsewhere: bool,
    is_quiet: bool,
    /// Whoever wants the drive to end before its time.
    interrupt: Interrupt,
}

impl Car {
    fn say(&self, text: std::fmt::Arguments<'_>) {
        if !self.is_quiet {
            // Nobody may read any more: no reason to leave the robot on its way.
            let _unread = writeln!(std::io::stdout(), "{text}");
        }
    }

    fn view(&self) -> ViewState {
        self.run.view_of_first(self.robot + 1)
    }

    /// One step of 10 ms; what is worth telling on the way is told.
    fn step(&mut self) -> anyhow::Result<()> {
        self.run.step();
        if let Some(next) = &mut self.pace {
            wait_for_tick(next);
        }
        let said = self.run.drain_log();
        if let Some(recorder) = &mut self.recorder {
            recorder.record(&self.run, &said)?;
        }
        for item in said {
            if matches!(item.level, LogLevel::Warn | LogLevel::Bad) {
                self.say(format_args!("{:8.2} s  {}\r", item.step as f64 * 0.01, item.text));
            }
        }
        Ok(())
    }

    fn drive(&mut self, speed_mps: f64, turn_rate_radps: f64) -> anyhow::Result<()> {
        let robot = self.robot;
        Ok(self.run.apply(Intervention::Drive { robot, speed_mps, turn_rate_radps })?)
    }

    /// Until the robot has reported once, commands before that would be lost; or until somebody interrupts.
    fn wait_for_answer(&mut self) -> anyhow::Result<()> {
        while self.view().robots[self.robot].battery_v.is_none() && !self.interrupt.happened() {
            if self.run.now().as_secs_f64() > ANSWER_PATIENCE_S {
                bail!(
                    "the robot did not answer within {ANSWER_PATIENCE_S} s: is it switched on, is nobody else \
                     connected to it, and is the speed of the line right?"
                );
            }
            self.step()?;
        }
        Ok(())
    }

    fn by_script(&mut self, mut script: Script) -> anyhow::Result<()> {
        let limits = self.run.scene().robots.swap_remove(self.robot);
        let most = [limits.hand_speed_max_mps, limits.hand_turn_rate_max_radps];
        // Where time is real, a script that has nothing to say for a while leaves the robot standing.
        while !self.interrupt.happened() {
            let Piece { line, seconds, speed_mps, turn_rate_radps } =
                match script.next(self.pace.is_none())? {
                    Next::Piece(piece) => piece,
                    Next::Nothing => {
                        if self.pace.is_some() {
                            self.step()?;
                        }
                        continue;
                    }
                    Next::End => break,
                };
            if speed_mps.abs() > most[0] || turn_rate_radps.abs() > most[1] {
                self.say(format_args!(
                    "line {line}: more than {:.2} m/s and {:.2} rad/s by hand: both are scaled down",
                    most[0], most[1]
                ));
            }
            // A number of steps that a cast cannot lose: the script's seconds are bounded.
            let n_steps = (seconds * 100.0).round() as u64;
            for step in 0..n_steps {
                if self.interrupt.happened() {
                    break;
                }
                if step % STEPS_PER_RENEWAL == 0 {
                    self.drive(speed_mps, turn_rate_radps)?;
                }
                self.step()?;
            }
        }
        Ok(())
    }

    fn by_keys(&mut self) -> anyhow::Result<()> {
        let scene = self.run.scene().robots.swap_remove(self.robot);
        self.say(format_args!(
            "Driving {}: hold W A S D or the arrows, Q and E for arcs; + and - for the pace; Space stops, Esc ends",
            scene.name
        ));
        let mut keys = Keys::open()?;
        let mut was_moving = false;
        while !self.interrupt.happened() && keys.read(Instant::now())? {
            let (forwards, left) = keys.wanted(Instant::now());
            let moves = forwards != 0.0 || left != 0.0;
            let steps = self.run.steps();
            if moves != was_moving || (moves && steps.is_multiple_of(STEPS_PER_RENEWAL)) {
                let share = keys.pace();
                let speed_mps = share * forwards * scene.hand_speed_max_mps;
                self.drive(speed_mps, share * left * scene.hand_turn_rate_max_radps)?;
                was_moving = moves;
            }
            self.step()?;
            if steps.is_multiple_of(STEPS_PER_LINE) {
                keys::show(&self.line());
            }
        }
        Ok(())
    }

    /// Lets go, and waits until it stands.
    fn stand(&mut self) -> anyhow::Result<()> {
        self.drive(0.0, 0.0)?;
        let begin_s = self.run.now().as_secs_f64();
        loop {
            self.step()?;
            let waited_s = self.run.now().as_secs_f64() - begin_s;
            let wheels_mps = self.view().robots[self.robot].wheels_mps;
            let stands = wheels_mps.iter().all(|wheel_mps| wheel_mps.abs() < STANDING_MPS);
            // The hand is off it only after its hold.
            if waited_s > DRIVE_HOLD.as_secs_f64() + 0.1 && (stands || waited_s > STAND_PATIENCE_S)
            {
                break;
            }
        }
        Ok(())
    }

    /// The state in a line.
    fn line(&self) -> String {
        let view = self.view();
        let robot = &view.robots[self.robot];
        let [left_mps, right_mps] = robot.wheels_mps;
        let mut line = format!(
            "{:7.1} s  at ({:.2}, {:.2}) m, {:.0}°  {:.2} m/s",
            view.t_s,
            robot.truth.x_m,
            robot.truth.y_m,
            robot.truth.yaw_rad.to_degrees(),
            f64::midpoint(left_mps, right_mps)
        );
        if let Some(clearance_m) = robot.clearance_m {
            // Writing to a string cannot fail.
            let _written = write!(line, "  {clearance_m:.2} m clear");
        }
        if robot.touching {
            line.push_str("  TOUCHES SOMETHING");
        }
        line
    }

    fn tell_end(&self, format: Format) {
        let view = self.view();
        let robot = &view.robots[self.robot];
        let pose = [robot.truth.x_m, robot.truth.y_m, robot.truth.yaw_rad];
        // Ways and contacts are kept of a mission's first robot.
        let figures = (self.robot == 0).then_some(view.figures);
        let way_m = figures.and_then(|f| f.path_length_m);
        let contacts = view.figures.contacts;
        match format {
            Format::Json => say!(
                "{}",
                json!({
                    "robot": self.run.scene().robots[self.robot].name, "time_s": view.t_s, "pose": pose,
                    "path_length_m": way_m, "contacts": contacts, "battery_v": robot.battery_v,
                    "state_hash": self.run.state_hash().to_string(),
                })
            ),
            Format::Text => {
                let whose = if self.is_elsewhere { "by its own reckoning " } else { "" };
                let way = way_m.map_or_else(String::new, |way_m| format!("{way_m:.2} m driven, "));
                let contacts =
                    contacts.map_or("contacts not known".to_owned(), |n| format!("{n} contacts"));
                say!(
                    "{way}{whose}at ({:.2}, {:.2}) m, {:.0}°, after {:.1} s; {contacts}",
                    pose[0],
                    pose[1],
                    pose[2].to_degrees(),
                    view.t_s
                );
            }
        }
    }
}
