//! From what a run shows to what the page reads.

use geometry::{Se2, Vec2};
use missions::{
    LogItem as RunLog, Run, Scene, SceneRobot, SceneThing, TraceItem as RunTrace, ViewDecision,
    ViewPose, ViewRobot,
};

use crate::protocol::{
    AvoiderState, Brief, CheckInfo, CrowdInfo, DecisionState, DeviceInfo, DeviceState, Edge,
    FunctionInfo, Hello, LinkInfo, LogItem, MissionInfo, MissionName, OperandInfo, PROTOCOL,
    PersonState, PheromoneInfo, Point, Pose, ProgramInfo, RobotInfo, RobotState, RoomInfo, Scan,
    ScannerInfo, SonarInfo, State, TagsInfo, ThingInfo, TimerState, TraceItem, VerdictInfo,
    WorldInfo,
};
use crate::{beams, crowd::n_robots_in_full, description};

/// Seconds per step of a run.
const STEP_S: f64 = 0.01;
/// The page needs no more digits than a tenth of a millimetre, and numbers are most of a message.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn point(p: Vec2) -> Point {
    [rounded(p.x), rounded(p.y)]
}

fn points(list: &[Vec2]) -> Vec<Point> {
    list.iter().map(|&p| point(p)).collect()
}

fn pose(p: missions::Pose) -> Pose {
    [rounded(p.x_m), rounded(p.y_m), rounded(p.yaw_rad)]
}

fn pose_of(se2: Se2) -> Pose {
    [rounded(se2.x_m), rounded(se2.y_m), rounded(se2.yaw_rad)]
}

/// The greeting: everything that stays.
pub(crate) fn hello(
    run: String,
    mission: MissionInfo,
    missions: &[MissionName],
    scene: &Scene,
) -> Hello {
    let in_full = n_robots_in_full(scene);
    let [robot_signals, run_signals] = description::signals();
    Hello {
        protocol: PROTOCOL,
        cairn: env!("CARGO_PKG_VERSION"),
        run,
        mission,
        missions: missions.to_vec(),
        world: world(scene),
        robots: scene.robots.iter().take(in_full).enumerate().map(robot_info).collect(),
        crowd: scene.robots.get(in_full).map(|first| CrowdInfo {
            first_id: in_full,
            n_robots: scene.robots.len() - in_full,
            footprint_m: points(&first.footprint_m),
        }),
        pheromones: scene.pheromones.as_ref().map(|field| PheromoneInfo {
            cell_m: field.cell_m,
            width: field.width,
            height: field.height,
            origin_m: point(field.origin_m),
            values: field.values.clone(),
            sigma_m: field.sigma_m,
            antenna_spacing_m: field.antenna_spacing_m,
        }),
        tags: scene.tags.as_ref().map(tags),
        planned_path_m: points(&scene.planned_path_m),
        program: scene.program.as_ref().map(|program| ProgramInfo {
            source: program.source.clone(),
            mode: program.mode.to_owned(),
            functions: program.functions.iter().map(function_info).collect(),
        }),
        // A crowd has no links to look at.
        links: if in_full < scene.robots.len() {
            Vec::new()
        } else {
            scene.links.iter().enumerate().map(link_info).collect()
        },
        offer: description::of_run(scene),
        plots: description::plots(scene),
        robot_signals,
        run_signals,
    }
}

fn tags(tags: &missions::SceneTags) -> TagsInfo {
    let tag = |&(at, strength): &(Vec2, u8)| (rounded(at.x), rounded(at.y), strength);
    TagsInfo { pitch_m: tags.pitch_m, tags: tags.strengths.iter().map(tag).collect() }
}

fn world(scene: &Scene) -> WorldInfo {
    let wall = |w: &missions::SceneWall| {
        let ([x0, y0], [x1, y1]) = (point(w.a), point(w.b));
        (x0, y0, x1, y1, w.material.clone())
    };
    let device = |d: &missions::SceneDevice| DeviceInfo {
        name: d.name.clone(),
        label: d.label.clone(),
        kind: d.kind.to_owned(),
        at_m: point(d.at_m),
        area_m: (!d.area_m.is_empty()).then(|| points(&d.area_m)),
        input: d.input,
        output: d.output,
    };
    WorldInfo {
        bounds_m: scene.bounds_m,
        walls: scene.walls.iter().map(wall).collect(),
        points: points(&scene.points_m),
        things: scene.things.iter().map(thing).collect(),
        rooms: scene
            .rooms
            .iter()
            .map(|(name, at)| RoomInfo { name: name.clone(), at_m: point(*at) })
            .collect(),
        devices: scene.devices.iter().map(device).collect(),
    }
}

fn thing(thing: &SceneThing) -> ThingInfo {
    ThingInfo {
        id: thing.id,
        name: thing.name.clone(),
        kind: thing.kind.to_owned(),
        material: thing.material.clone(),
        corners_m: points(&thing.corners_m),
        removable: thing.removable,
    }
}

fn robot_info((id, robot): (usize, &missions::SceneRobot)) -> RobotInfo {
    let sonar = |s: &missions::SceneSonar| SonarInfo {
        at: pose_of(s.base_from_sensor),
        half_angle_rad: s.half_angle_rad,
        range_max_m: s.range_max_m,
    };
    let scanner = |s: &missions::SceneScanner| ScannerInfo {
        name: s.name.clone(),
        at: pose_of(s.base_from_sensor),
        first_angle_rad: s.first_angle_rad,
        step_rad: s.step_rad,
        n_beams: s.n_beams,
        range_max_m: s.range_max_m,
    };
    RobotInfo {
        id,
        name: robot.name.clone(),
        model: robot.model.clone(),
        footprint_m: points(&robot.footprint_m),
        sonars: robot.sonars.iter().map(sonar).collect(),
        scanners: robot.scanners.iter().map(scanner).collect(),
        tag_readers_m: points(&robot.tag_readers_m),
        tag_range_m: robot.tag_range_m,
        start: pose_of(robot.start),
        is_elsewhere: robot.is_elsewhere,
        hand_speed_max_mps: robot.hand_speed_max_mps,
        hand_turn_rate_max_radps: robot.hand_turn_rate_max_radps,
    }
}

fn function_info(function: &missions::SceneFunction) -> FunctionInfo {
    let operand = |o: &missions::SceneOperand| OperandInfo {
        text: o.text.clone(),
        resource: o.resource.clone(),
        line: function.line,
        column: o.column,
        length: o.length,
    };
    FunctionInfo {
        line: function.line,
        mnemonic: function.mnemonic.clone(),
        operands: function.operands.iter().map(operand).collect(),
    }
}

fn link_info((id, link): (usize, &missions::SceneLink)) -> LinkInfo {
    LinkInfo {
        id,
        name: link.name.clone(),
        ends: link.ends.map(ToOwned::to_owned),
        baud: (link.baud > 0).then_some(link.baud),
        robot: link.robot,
        line: link.line,
    }
}

/// How time runs, as the page shows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    pub playing: bool,
    pub speed_ratio: f64,
    pub achieved_ratio: f64,
}

/// What changes.
pub(crate) fn state(run: &Run, scene: &Scene, pace: Pace, edges: Vec<Edge>) -> State {
    let in_full = n_robots_in_full(scene);
    let view = &run.view_of_first(in_full);
    let devices = scene.devices.iter().zip(&view.devices_on);
    State {
        t_s: rounded(view.t_s),
        step: view.step,
        playing: pace.playing,
        speed_ratio: pace.speed_ratio,
        achieved_ratio: rounded(pace.achieved_ratio),
        verdict: view.verdict.as_ref().map(|verdict| VerdictInfo {
            passed: verdict.passed,
            text: verdict.text.clone(),
            checks: verdict.checks.iter().map(check).collect(),
        }),
        robots: view.robots.iter().zip(&scene.robots).enumerate().map(robot_state).collect(),
        crowd: run.poses().skip(in_full).map(brief).collect(),
        people: view
            .people
            .iter()
            .map(|p| PersonState { name: p.name.clone(), at: pose(p.at), radius_m: p.radius_m })
            .collect(),
        things: view.things.iter().map(thing).collect(),
        devices: devices.map(|(d, &on)| DeviceState { name: d.name.clone(), on }).collect(),
        decision: view.decision.as_ref().map(|d| decision(d, edges)),
        signals: values(&view.signals),
    }
}

fn check(check: &missions::Check) -> CheckInfo {
    CheckInfo { name: check.name.clone(), passed: check.passed, text: check.text.clone() }
}

/// A millimetre and a hundredth of a radian are enough for a dot among a thousand.
fn brief(robot: ViewPose) -> Brief {
    let missions::Pose { x_m, y_m, yaw_rad } = robot.truth;
    let mark = u8::from(robot.touching) + 2 * u8::from(robot.arrived);
    let [x, y] = [x_m, y_m].map(|value| (value * 1e3).round() / 1e3);
    (x, y, (yaw_rad * 1e2).round() / 1e2, mark)
}

fn robot_state((id, (robot, info)): (usize, (&ViewRobot, &SceneRobot))) -> RobotState {
    let ranges = |list: &[f64]| list.iter().map(|&r| rounded(r)).collect();
    RobotState {
        id,
        truth: pose(robot.truth),
        estimate: pose(robot.estimate),
        ellipse: robot.ellipse.map(rounded),
        wheels_mps: robot.wheels_mps.map(rounded),
        sonar_m: ranges(&robot.sonar_m),
        bubble_m: ranges(&robot.bubble_m),
        phase: robot.phase.to_owned(),
        task: robot.task.clone(),
        avoider: AvoiderState { state: robot.avoider_state, name: robot.avoider_name.to_owned() },
        goal: robot.goal.map(pose),
        goal_tolerance_m: info.goal_tolerance_m,
        target: robot.target_m.map(point),
        preview_m: points(&robot.preview_m),
        intensities: robot.intensities.map(|pair| pair.map(rounded)),
        scans: robot.scans.iter().map(scan).collect(),
        stalled: robot.stalled,
        touching: robot.touching,
        signals: values(&robot.signals),
        failure: robot.failure.clone(),
    }
}

fn decision(decision: &ViewDecision, edges: Vec<Edge>) -> DecisionState {
    let timer = |t: &missions::ViewTimer| TimerState {
        index: u8::try_from(t.index).unwrap_or(u8::MAX),
        remaining_s: t.remaining_ms as f64 / 1e3,
        total_s: t.total_ms as f64 / 1e3,
        on: t.on,
    };
    DecisionState {
        scans: decision.scans,
        resources: decision.resources.iter().cloned().collect(),
        timers: decision.timers.iter().map(timer).collect(),
        run: decision.run,
        drives_outputs: decision.drives_outputs,
        fault: decision.fault,
        clock: decision.clock.clone(),
        n_watchdog_resets: decision.n_watchdog_resets,
        n_events: decision.n_events,
        last_move: decision.last_move,
        edges,
    }
}

/// Signals; null where there is none, or where it is not known.
fn values(signals: &[Option<f64>]) -> Vec<Option<f64>> {
    signals.iter().map(|value| value.map(rounded)).collect()
}

fn scan(scan: &missions::ViewScan) -> Scan {
    (scan.scanner, pose(scan.at), beams::packed(&scan.ranges_m))
}

/// A packet that passed.
pub(crate) fn trace_item(item: &RunTrace) -> TraceItem {
    let hex: Vec<String> = item.bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    TraceItem {
        t_s: item.step as f64 * STEP_S,
        link: item.link,
        to: item.to.to_owned(),
        hex: hex.join(" "),
        text: item.text.clone(),
    }
}

/// An event in words.
pub(crate) fn log_item(item: &RunLog) -> LogItem {
    LogItem { t_s: item.step as f64 * STEP_S, level: item.level.name(), text: item.text.clone() }
}

#[cfg(test)]
mod tests {
    use missions::Mission;

    use super::*;

    fn run(mission: &str) -> Run {
        let mission = Mission::load(mission, &[]).unwrap();
        let seed = mission.seed();
        Run::new(mission, seed).unwrap()
    }

    fn greeting(run: &Run) -> Hello {
        let info = MissionInfo {
            name: "x".to_owned(),
            title: "x".to_owned(),
            about: "x".to_owned(),
            seed: 1,
            duration_max_s: 1.0,
            kind: "live",
            recording: None,
            length_s: None,
            marks: Vec::new(),
        };
        hello("1".to_owned(), info, &[], &run.scene())
    }

    fn state_of(run: &Run) -> State {
        let pace = Pace { playing: true, speed_ratio: 1.0, achieved_ratio: 1.0 };
        state(run, &run.scene(), pace, Vec::new())
    }

    /// Distance from a point to a polyline, m.
    fn distance_m([x, y]: Point, line: &[Point]) -> f64 {
        let to = |w: &[Point]| {
            let ([x0, y0], [x1, y1]) = (w[0], w[1]);
            let (dx, dy) = (x1 - x0, y1 - y0);
            let along = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy).max(1e-12);
            let along = along.clamp(0.0, 1.0);
            (x - x0 - along * dx).hypot(y - y0 - along * dy)
        };
        line.windows(2).map(to).fold(f64::INFINITY, f64::min)
    }

    /// Rows up or down, origin at this corner or that: whatever the field does, the picture of the
    /// trail must lie where the trail was drawn.
    #[test]
    fn the_pheromones_lie_on_the_trail_that_was_drawn() {
        let hello = greeting(&run("doorbell"));
        let field = hello.pheromones.unwrap();
        assert!(field.values.len() > 30);
        for &(col, row, _) in &field.values {
            let at = [col, row].map(|i| (i as f64 + 0.5) * field.cell_m);
            let centre = [at[0] + field.origin_m[0], at[1] + field.origin_m[1]];
            let off_m = distance_m(centre, &hello.planned_path_m);
            assert!(off_m < 2.5 * field.cell_m, "cell ({col}, {row}) is {off_m:.2} m off");
        }
    }

    #[test]
    fn every_operand_stands_where_its_column_says() {
        let program = greeting(&run("doorbell")).program.unwrap();
        let lines: Vec<&str> = program.source.lines().collect();
        let mut n_timers = 0;
        for function in &program.functions {
            for operand in &function.operands {
                let line = lines[operand.line - 1];
                let text: String =
                    line.chars().skip(operand.column - 1).take(operand.length).collect();
                assert_eq!(text, operand.text, "line {}", operand.line);
            }
            if function.mnemonic == "TIMER" {
                n_timers += 1;
                let [first, second] = [0, 1].map(|i| &function.operands[i]);
                assert_eq!(first.resource.clone().unwrap(), format!("YTMR{}", first.text));
                assert_eq!(second.resource, None, "only the first operand is the timer");
            }
        }
        assert!(n_timers > 0);
    }

    #[test]
    fn every_lit_operand_has_a_value_in_each_state() {
        let run = run("doorbell");
        let program = greeting(&run).program.unwrap();
        let known = state_of(&run).decision.unwrap().resources;
        let named =
            program.functions.iter().flat_map(|f| &f.operands).filter_map(|o| o.resource.as_ref());
        for name in named {
            assert!(known.contains_key(name), "{name} is missing");
        }
    }

    #[test]
    fn a_robot_says_how_near_its_goal_counts() {
        let state = state_of(&run("doorbell"));
        assert_eq!(state.robots[0].goal_tolerance_m, Some(0.3));
        assert!(state.crowd.is_empty());
    }

    /// A thousand robots in full would be 15 MB/s; the page draws dots.
    #[test]
    fn a_crowd_is_told_in_brief() {
        let run = run("swarm");
        let hello = greeting(&run);
        let crowd = hello.crowd.as_ref().unwrap();
        assert_eq!((hello.robots.len(), crowd.first_id, crowd.n_robots), (1, 1, 999));
        assert!(serde_json::to_string(&hello).unwrap().len() < 20_000);
        let state = state_of(&run);
        assert_eq!((state.robots.len(), state.crowd.len()), (1, 999));
        let size = serde_json::to_string(&state).unwrap().len();
        assert!(size < 40_000, "{size} bytes");
    }
}
