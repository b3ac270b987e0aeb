//! Checks of `[decision]` and `[[events]]`.

use decision::{DateTime, Diagnostic, Failsafe, Mode, MovePoints, Program, Severity};
use run_context::Stamp;

use super::super::{
    error::Wrong,
    file::{DecisionFile, EventFile, MissionFile},
    plan::{
        Action, DecisionPlan, DevicePlan, DeviceWiring, EventPlan, FailsafeOutput, GoalPose,
        LinkPlan, ProgramAction, RobotPlan,
    },
    words::{EventKind, LineKind},
};
use crate::{
    asked::Asked,
    cut::{Direction, Line},
};

use super::common::{
    Checked, chosen, goal, line, named, picked, point, range, robots_named, seconds,
};
use super::keys;

/// Greatest coordinate of a goal that a link with bytes carries, metres: 32 767 mm, rounded down.
const GOAL_MAX_M: f64 = 32.0;

/// `[decision]`: the program compiles, the robot exists, the inputs are free.
pub(super) fn decision(
    file: &DecisionFile,
    devices: &[DevicePlan],
    robots: &[RobotPlan],
) -> Checked<DecisionPlan> {
    let Some(source) = &file.program else {
        let allowed = "the program, or instead program_file with the name of its file";
        return Err(Wrong::prose("decision.program", "absent", allowed));
    };
    let mode: Mode = chosen("decision.mode", &file.mode)?;
    let program = compiled(source, mode)?;
    let names: Vec<&str> = robots.iter().map(|r| r.name.as_str()).collect();
    let robot = match file.robot.as_str() {
        "" => None,
        name => Some(named("decision.robot", name, &names)?),
    };
    let watchdog_s =
        range("decision.watchdog_s", file.watchdog_s, 0.0..=3600.0, "from 0 to 3600 s")?;
    let answer_s =
        range("decision.answer_within_s", file.answer_within_s, 0.1..=600.0, "from 0.1 to 600 s")?;
    Ok(DecisionPlan {
        source: source.clone(),
        program,
        listing_mode: mode == Mode::Listing,
        robot,
        points: points(file, devices)?,
        failsafe: failsafe(devices),
        stops_robot: file.failsafe_stops_robot,
        clock: clock(&file.clock, mode)?,
        watchdog: seconds(watchdog_s),
        answer_within: seconds(answer_s),
        link: line("decision.line", &file.line, LineKind::SIMULATED)?,
    })
}

fn compiled(source: &str, mode: Mode) -> Checked<Program> {
    let compilation = decision::compile_as(source, mode);
    compilation.program.ok_or_else(|| {
        let n = compilation.n_errors;
        let is_error = |d: &&Diagnostic| d.severity == Severity::Error;
        let mut all = compilation.diagnostics.iter().filter(is_error);
        let parts: Vec<String> = all
            .clone()
            .take(3)
            .map(|d| format!("line {}, column {}: {}", d.line, d.column, d.message))
            .collect();
        let errors = if n == 1 { "error" } else { "errors" };
        let found = format!("a program with {n} {errors} ({})", parts.join("; "));
        let wrong = Wrong::prose("decision.program", found, "a program that compiles");
        match all.next() {
            Some(first) => wrong.within(first.line, first.column),
            None => wrong,
        }
    })
}

/// The inputs that say what became of a MOVE: free, and different.
fn points(file: &DecisionFile, devices: &[DevicePlan]) -> Checked<MovePoints> {
    let keys = [
        ("busy_input", file.busy_input),
        ("arrived_input", file.arrived_input),
        ("failed_input", file.failed_input),
    ];
    for (i, (key, input)) in keys.into_iter().enumerate() {
        let key = format!("decision.{key}");
        input_is_free(&key, input, devices)?;
        let Some(number) = input else { continue };
        if let Some((other, _)) = keys.iter().take(i).find(|(_, n)| *n == input) {
            return Err(Wrong::new(key, number, format!("another input than {other}")));
        }
    }
    let signal = chosen("decision.completion", &file.completion)?;
    let (busy, done, failed) = (file.busy_input, file.arrived_input, file.failed_input);
    Ok(MovePoints { busy, done, failed, signal })
}

/// What the devices want their outputs to do while no program drives them.
fn failsafe(devices: &[DevicePlan]) -> Failsafe {
    devices.iter().fold(Failsafe::default(), |mut all, device| {
        if let DeviceWiring::Latch { output, failsafe } | DeviceWiring::Lamp { output, failsafe } =
            device.wiring
        {
            match failsafe {
                FailsafeOutput::Off => {}
                FailsafeOutput::On => all.on |= 1 << output,
                FailsafeOutput::Hold => all.hold |= 1 << output,
            }
        }
        all
    })
}

fn clock(text: &str, mode: Mode) -> Checked<DateTime> {
    let clock = DateTime::parse(text).filter(|clock| clock.is_valid(mode));
    let allowed = "a time such as 07:30, or a date and a time such as 2026-03-01 07:30:00";
    clock.ok_or_else(|| Wrong::new("decision.clock", text, allowed))
}

fn input_is_free(key: &str, input: Option<u8>, devices: &[DevicePlan]) -> Checked<()> {
    let Some(number) = input else { return Ok(()) };
    if number > 15 {
        return Err(Wrong::new(key, number, "from 0 to 15"));
    }
    let taken = devices.iter().find(|d| match &d.wiring {
        DeviceWiring::Button { input } | DeviceWiring::Motion { input, .. } => {
            *input == Some(number)
        }
        DeviceWiring::Latch { .. } | DeviceWiring::Lamp { .. } => false,
    });
    match taken {
        Some(device) => {
            let allowed = format!("an input of its own; `{}` has this one", device.name);
            Err(Wrong::new(key, number, allowed))
        }
        None => Ok(()),
    }
}

/// `[[events]]`, in order of time; equal times keep the order of the file.
pub(super) fn events(
    file: &MissionFile,
    devices: &[DevicePlan],
    robots: &[RobotPlan],
) -> Checked<Vec<EventPlan>> {
    let has = (file.pheromones.is_some(), file.decision.is_some());
    let check =
        |(i, e): (usize, &EventFile)| event(&format!("events[{i}]"), e, devices, robots, has);
    let mut events = file.events.iter().enumerate().map(check).collect::<Checked<Vec<_>>>()?;
    events.sort_by_key(|e| e.at);
    Ok(events)
}

/// `cut_line`, `restore_line`: the robots, the line, which way.
fn line_event(
    key: &str,
    file: &EventFile,
    robots: &[RobotPlan],
    has_server: bool,
) -> Checked<(Vec<usize>, Line, Direction)> {
    let at = |name: &str| format!("{key}.{name}");
    let named = robots_named(key, &file.robot, robots)?;
    let line = match laser(&at("line"), &file.line, named.iter().map(|&robot| &robots[robot]))? {
        Some(laser) => laser,
        None => chosen(&at("line"), &file.line)?,
    };
    if line == Line::Pheromones && !has_server {
        let allowed = "another line, because the mission has no [pheromones]";
        return Err(Wrong::new(at("line"), &file.line, allowed));
    }
    let direction = match file.direction.as_str() {
        "" => Direction::Both,
        given => {
            let words = Direction::ALL.into_iter().map(|d| (line.direction_name(d), d));
            picked(&at("direction"), given, words)?
        }
    };
    Ok((named, line, direction))
}

/// The line of the laser of that name, if one of these robots has it; then all of them must.
fn laser<'r>(
    key: &str,
    name: &str,
    mut robots: impl Iterator<Item = &'r RobotPlan>,
) -> Checked<Option<Line>> {
    let of = |robot: &RobotPlan| robot.lasers.iter().position(|laser| laser.name == name);
    let Some(first) = robots.next() else { return Ok(None) };
    let number = of(first);
    if let Some(other) = robots.find(|robot| of(robot) != number) {
        let allowed = format!(
            "a line that each of these robots has in the same place; `{}` and `{}` differ",
            first.name, other.name
        );
        return Err(Wrong::new(key, name, allowed));
    }
    // A robot has a handful of lasers.
    Ok(number.and_then(|number| u8::try_from(number).ok()).map(Line::Laser))
}

fn event(
    key: &str,
    file: &EventFile,
    devices: &[DevicePlan],
    robots: &[RobotPlan],
    (has_server, has_program): (bool, bool),
) -> Checked<EventPlan> {
    let at_s = range(format!("{key}.at_s"), file.at_s, 0.0..=86_400.0, "from 0 to 86400 s")?;
    let kind = keys::kind_of(key, file, has_program)?;
    let action = match kind {
        EventKind::Press => Action::Button { device: button(key, file, devices)?, pressed: true },
        EventKind::Release => {
            Action::Button { device: button(key, file, devices)?, pressed: false }
        }
        EventKind::Goal => {
            let sent = robots_named(key, &file.robot, robots)?;
            let pose = goal(key, file.pose, file.pose_from_start)?;
            goal_fits_the_link(key, pose, sent.iter().map(|&i| &robots[i]))?;
            Action::Goal { robots: sent, pose }
        }
        EventKind::Stop => Action::Stop { robots: robots_named(key, &file.robot, robots)? },
        EventKind::PlaceBox => {
            let Some(at) = file.at_m else {
                return Err(Wrong::prose(format!("{key}.at_m"), "absent", "x and y (m)"));
            };
            let size = file.size_m.unwrap_or(0.4);
            Action::PlaceBox {
                name: if file.thing.is_empty() { "box".into() } else { file.thing.clone() },
                at: point(format!("{key}.at_m"), at)?,
                size_m: range(format!("{key}.size_m"), size, 0.05..=3.0, "from 0.05 to 3 m")?,
            }
        }
        EventKind::CutLine | EventKind::RestoreLine => {
            let (robots, line, direction) = line_event(key, file, robots, has_server)?;
            Action::Link { robots, line, direction, cut: kind == EventKind::CutLine }
        }
        EventKind::StopProgram => Action::Program(ProgramAction::Stop),
        EventKind::RunProgram => Action::Program(ProgramAction::Run),
        EventKind::StallProgram => {
            let Some(for_s) = file.for_s else {
                return Err(Wrong::prose(format!("{key}.for_s"), "absent", "from 0.01 to 3600 s"));
            };
            range(format!("{key}.for_s"), for_s, 0.01..=3600.0, "from 0.01 to 3600 s")?;
            Action::Program(ProgramAction::Stall { n_steps: (for_s * 100.0).round() as u64 })
        }
        EventKind::TestLine => ask(key, file, robots, Asked::Link)?,
        EventKind::ReportSonar => ask(key, file, robots, Asked::Sonar)?,
        EventKind::Restart => ask(key, file, robots, Asked::Restart)?,
        EventKind::Remove if file.thing.is_empty() => {
            return Err(Wrong::new(format!("{key}.thing"), "", "the name of a thing"));
        }
        EventKind::Remove => Action::Remove { name: file.thing.clone() },
    };
    Ok(EventPlan { at: Stamp::ZERO + seconds(at_s), after_arrival: file.after_arrival, action })
}

/// `press`, `release`: the button.
fn button(key: &str, file: &EventFile, devices: &[DevicePlan]) -> Checked<usize> {
    let names: Vec<&str> = devices.iter().map(|d| d.name.as_str()).collect();
    let device = named(&format!("{key}.device"), &file.device, &names)?;
    if !matches!(devices[device].wiring, DeviceWiring::Button { .. }) {
        return Err(Wrong::new(format!("{key}.device"), &file.device, "a button"));
    }
    Ok(device)
}

/// `test_line`, `report_sonar`, `restart`: what the ground asks robots.
fn ask(key: &str, file: &EventFile, robots: &[RobotPlan], asked: Asked) -> Checked<Action> {
    Ok(Action::Ask { robots: robots_named(key, &file.robot, robots)?, asked })
}

/// Links with bytes carry a coordinate as millimetres in 16 bits.
fn goal_fits_the_link<'a>(
    key: &str,
    pose: GoalPose,
    mut robots: impl Iterator<Item = &'a RobotPlan>,
) -> Checked<()> {
    let fits = |robot: &RobotPlan| {
        let goal = pose.resolve(robot.start).position();
        matches!(robot.link, LinkPlan::Direct) || goal.amax() <= GOAL_MAX_M
    };
    if robots.all(fits) {
        return Ok(());
    }
    let name = if matches!(pose, GoalPose::InMap(_)) { "pose" } else { "pose_from_start" };
    let allowed = "within 32 m of the origin, because the link carries millimetres in 16 bits";
    Err(Wrong::prose(format!("{key}.{name}"), "a goal farther away", allowed))
}
