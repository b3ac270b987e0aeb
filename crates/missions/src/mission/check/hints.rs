//! What a mission may say and its author hardly meant.

use decision::Mnemonic;
use geometry::wrap_to_pi;
use navigator::{Method, TrailController};
use settings::Choice as _;

use crate::mission::{
    Parts,
    file::MissionFile,
    plan::{Action, DecisionPlan, DeviceWiring, GoalPose, Requirement},
    words::EventKind,
};

/// A sentence for each oddity, in the order of the file's tables.
pub(in crate::mission) fn warnings(file: &MissionFile, parts: &Parts) -> Vec<String> {
    let mut found = Vec::new();
    program(parts, &mut found);
    events(file, parts, &mut found);
    super::unused::unused(file, &parts.devices, &parts.events, &mut found);
    if parts.success.is_empty() {
        found.push(
            "[success] asks for nothing: every run that ends counts as passed; add for example \
             [[success.arrived]] or no_contact = true"
                .to_owned(),
        );
    }
    deadlines(file, &mut found);
    arrivals(parts, &mut found);
    never(parts, &mut found);
    let notes = parts.world.map.iter().flat_map(|map| &map.notes);
    found.extend(notes.map(|note| format!("world.map: {note}")));
    starts(file, parts, &mut found);
    tags(file, parts, &mut found);
    laws(file, &mut found);
    found
}

/// Tags that nobody reads, and readers over a floor without any.
fn tags(file: &MissionFile, parts: &Parts, found: &mut Vec<String>) {
    let read = parts.robots.iter().any(|robot| robot.tag_readers.is_some());
    if parts.tags.is_some() && !read {
        let what = "no robot has readers; add [robots.tag_readers] or mind.how.method = \"tags\"";
        found.push(format!("[tags]: {what}"));
    }
    for (i, _) in file.robots.iter().enumerate().filter(|(_, r)| r.tag_readers.is_some()) {
        if parts.tags.is_none() {
            let what = "the floor has no tags to read; add [tags]";
            found.push(format!("robots[{i}].tag_readers: {what}"));
        }
    }
}

/// Laws on a trail that nothing fits to a higher speed than the thesis's.
fn laws(file: &MissionFile, found: &mut Vec<String>) {
    for (i, robot) in file.robots.iter().enumerate() {
        let (on_trail, follow) = (robot.mind.how.method == Method::Trail.key(), &robot.mind.follow);
        let Some(law) = TrailController::by_key(&follow.trail_law) else { continue };
        if on_trail && follow.speed_mps > 0.3 && !law.fits_to_speed() {
            let (speed_mps, word) = (follow.speed_mps, law.key());
            let what =
                if law.has_own_speeds() { "has its own speeds" } else { "is tuned for 0.3 m/s" };
            let fitting = TrailController::ALL.iter().filter(|law| law.fits_to_speed());
            let fitting: Vec<&str> = fitting.map(|law| law.key()).collect();
            found.push(format!(
                "robots[{i}].mind.follow.speed_mps = {speed_mps}: trail_law `{word}` {what}, and fit_to_speed \
                 does not change that; above 0.3 m/s use {}",
                fitting.join(" or ")
            ));
        }
    }
}

/// Robots outside of what the studio draws.
fn starts(file: &MissionFile, parts: &Parts, found: &mut Vec<String>) {
    let [x0, y0, x1, y1] = parts.world.bounds;
    for (i, robot) in file.robots.iter().enumerate() {
        let [x, y, _] = robot.start;
        if !((x0..=x1).contains(&x) && (y0..=y1).contains(&y)) {
            found.push(format!(
                "robots[{i}].start = [{x}, {y}, …]: outside world.bounds_m = {:?}, so nobody will see it",
                parts.world.bounds
            ));
        }
    }
}

fn program(parts: &Parts, found: &mut Vec<String>) {
    let Some(plan) = &parts.decision else { return };
    let warning = |d: &decision::Diagnostic| {
        format!("decision.program, line {}: {}: {}", d.line, d.code.id(), d.message)
    };
    let mode = if plan.listing_mode { decision::Mode::Listing } else { decision::Mode::Corrected };
    found.extend(decision::compile_as(&plan.source, mode).diagnostics.iter().map(warning));
}

fn events(file: &MissionFile, parts: &Parts, found: &mut Vec<String>) {
    let end_s = parts.duration_max.as_secs_f64();
    for (i, event) in file.events.iter().enumerate().filter(|(_, e)| e.at_s >= end_s) {
        found.push(format!(
            "events[{i}].at_s = {}: `{}` never happens, because the mission ends after {end_s} s \
             (mission.duration_max_s)",
            event.at_s, event.action
        ));
    }
    let placed = file
        .events
        .iter()
        .filter(|e| e.action == EventKind::PlaceBox.key())
        .map(|e| e.thing.as_str());
    let things = file.world.things.iter().map(|t| t.name.as_str());
    let boxes: Vec<String> = file.world.random_boxes.iter().flat_map(names_of).collect();
    let known: Vec<&str> = things.chain(placed).chain(boxes.iter().map(String::as_str)).collect();
    for (i, event) in
        file.events.iter().enumerate().filter(|(_, e)| e.action == EventKind::Remove.key())
    {
        if event.thing != "box" && !known.contains(&event.thing.as_str()) {
            let meant = settings::did_you_mean(&event.thing, known.iter().copied());
            let meant = meant.map(|m| format!("; did you mean `{m}`?")).unwrap_or_default();
            let thing = &event.thing;
            found.push(format!(
                "events[{i}].thing = \"{thing}\": the mission has no such thing{meant}"
            ));
        }
    }
}

/// Several boxes of one table are numbered.
fn names_of(boxes: &crate::mission::file::RandomBoxesFile) -> Vec<String> {
    let numbered = (1..=boxes.count).map(|k| format!("{} {k}", boxes.name));
    std::iter::once(boxes.name.clone()).chain(numbered).collect()
}

/// Deadlines after the end.
fn deadlines(file: &MissionFile, found: &mut Vec<String>) {
    let (success, end_s) = (&file.success, file.mission.duration_max_s);
    let arrived = success.arrived.iter().map(|a| a.by_s).enumerate();
    let switched_on = success.switched_on.iter().map(|s| s.by_s).enumerate();
    let gave_up = success.gave_up.iter().map(|g| g.by_s).enumerate();
    let all = arrived
        .map(|of| ("arrived", of))
        .chain(switched_on.map(|of| ("switched_on", of)))
        .chain(gave_up.map(|of| ("gave_up", of)));
    for (table, (i, by_s)) in all.filter(|(_, (_, by_s))| *by_s > end_s) {
        found.push(format!(
            "success.{table}[{i}].by_s = {by_s}: the mission ends before, after {end_s} s \
             (mission.duration_max_s)"
        ));
    }
}

/// Whether somebody who says nothing of it beforehand may send a robot anywhere: a program with MOVE, or a person
/// who drives it by hand.
fn may_go_anywhere(parts: &Parts, robot: usize) -> bool {
    let moves = |d: &DecisionPlan| d.robot == Some(robot) && has_function(d, Mnemonic::Move);
    parts.decision.as_ref().is_some_and(moves) || parts.robots[robot].teleoperator.is_some()
}

fn has_function(plan: &DecisionPlan, mnemonic: Mnemonic) -> bool {
    plan.program.functions().iter().any(|function| function.mnemonic == mnemonic)
}

/// The goals that the mission's events give a robot.
fn goals(parts: &Parts, robot: usize) -> impl Iterator<Item = GoalPose> {
    parts.events.iter().filter_map(move |event| match &event.action {
        Action::Goal { robots, pose } if robots.contains(&robot) => Some(*pose),
        _ => None,
    })
}

/// Robots that must arrive, but nobody sends them anywhere, or not there.
fn arrivals(parts: &Parts, found: &mut Vec<String>) {
    for (i, requirement) in parts.success.iter().filter(|r| is_arrival(r)).enumerate() {
        let Requirement::Arrived { robots, group, pose, within_m, within_rad, min_ratio, .. } =
            requirement
        else {
            continue;
        };
        let sent =
            |robot: usize| may_go_anywhere(parts, robot) || goals(parts, robot).next().is_some();
        if !robots.iter().any(|&robot| sent(robot)) {
            found.push(format!(
                "[[success.arrived]] of `{group}`: nothing sends it anywhere; add an event with \
                 do = \"goal\", or a decision program with MOVE"
            ));
            continue;
        }
        let leads_there = |robot: usize| {
            let plan = &parts.robots[robot];
            let settings = plan.navigator.settings();
            let wanted = pose.resolve(plan.start);
            let is_near = |goal: GoalPose| {
                let goal = goal.resolve(plan.start);
                let turn_rad = wrap_to_pi(goal.yaw_rad - wanted.yaw_rad).abs();
                (goal.position() - wanted.position()).norm() <= within_m + settings.goal_tolerance_m
                    && turn_rad <= within_rad + settings.heading_tolerance_rad
            };
            may_go_anywhere(parts, robot) || goals(parts, robot).any(is_near)
        };
        let n = robots.iter().filter(|&&robot| leads_there(robot)).count();
        if (n as f64) < min_ratio * robots.len() as f64 {
            found.push(format!(
                "success.arrived[{i}] of `{group}`: no event with do = \"goal\" sends it there (within \
                 {within_m} m and {:.0}°), so it cannot be met",
                within_rad.to_degrees()
            ));
        }
    }
}

fn is_arrival(requirement: &Requirement) -> bool {
    matches!(requirement, Requirement::Arrived { .. })
}

/// Requirements that cannot be met, and goals that are never sent, for other reasons.
fn never(parts: &Parts, found: &mut Vec<String>) {
    let is_cut = |robots: &[usize]| {
        let cuts = |action: &Action| match action {
            Action::Link { robots: of, cut: true, .. } => robots.iter().all(|r| of.contains(r)),
            _ => false,
        };
        parts.events.iter().any(|event| cuts(&event.action))
    };
    let decision = parts.decision.as_ref();
    let lacks = |function| decision.is_some_and(|plan| !has_function(plan, function));
    for requirement in &parts.success {
        let why = match requirement {
            Requirement::MovesSent(1..) if lacks(Mnemonic::Move) => {
                "success.moves_sent: the decision program has no MOVE"
            }
            Requirement::EventsLogged(1..) if lacks(Mnemonic::Event) => {
                "success.events_logged: the decision program has no EVENT"
            }
            Requirement::WatchdogResets(1..) if decision.is_some_and(|d| d.watchdog.is_zero()) => {
                "success.watchdog_resets: decision.watchdog_s = 0 switches the watchdog off"
            }
            Requirement::CrossTrackRmsMax(_) if !first_follows(parts) => {
                "success.cross_track_rms_max_m: the first robot has mind.how.method = \"straight\" and follows nothing"
            }
            Requirement::SwitchedOn { device, .. } if decision.is_none() => {
                let device = &parts.devices[*device];
                let driven =
                    matches!(device.wiring, DeviceWiring::Latch { .. } | DeviceWiring::Lamp { .. });
                if driven {
                    let name = &device.name;
                    found.push(format!(
                        "[[success.switched_on]] of `{name}`: the mission has no [decision], whose program \
                         would switch it on, so it cannot be met"
                    ));
                }
                continue;
            }
            Requirement::GaveUp { robots, way_max_m: Some(_), .. } if !is_cut(robots) => {
                "[[success.gave_up]]: way_max_m counts from a cut, and no event cuts a line of that robot"
            }
            _ => continue,
        };
        found.push(format!("{why}, so it cannot be met"));
    }
    let mut sent = vec![false; parts.robots.len()];
    for event in &parts.events {
        let Action::Goal { robots, .. } = &event.action else { continue };
        for &robot in robots {
            if event.after_arrival && !sent[robot] && !may_go_anywhere(parts, robot) {
                let name = &parts.robots[robot].name;
                found.push(format!(
                    "the first goal of `{name}` has after_arrival = true: it is sent when the robot has arrived \
                     at a goal before, and there is none"
                ));
            }
            sent[robot] = true;
        }
    }
}

/// Whether the first robot has something that it follows, or a person who drives it along a path.
fn first_follows(parts: &Parts) -> bool {
    parts.robots.first().is_some_and(|robot| {
        robot.teleoperator.is_some() || robot.navigator.settings().method != Method::Direct
    })
}
