//! What a mission may say and its author hardly meant.

use crate::mission::{
    Parts,
    file::MissionFile,
    plan::{Action, Requirement},
};

/// A sentence for each oddity, in the order of the file's tables.
pub(in crate::mission) fn warnings(file: &MissionFile, parts: &Parts) -> Vec<String> {
    let mut found = Vec::new();
    program(parts, &mut found);
    events(file, parts, &mut found);
    if parts.success.is_empty() {
        found.push(
            "[success] asks for nothing: every run that ends counts as passed; add for example \
             [[success.arrived]] or no_contact = true"
                .to_owned(),
        );
    }
    arrivals(parts, &mut found);
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
        let what = "no robot has readers; add [robots.tag_readers] or route = \"tags\"";
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
        let navigator = &robot.navigator;
        let law = navigator.trail_controller.as_str();
        let fitted = matches!(law, "fuzzy" | "fuzzy_fine");
        if navigator.route == "trail" && navigator.speed_mps > 0.3 && !fitted {
            let speed_mps = navigator.speed_mps;
            let what = if law == "listing" { "has its own speeds" } else { "is tuned for 0.3 m/s" };
            found.push(format!(
                "robots[{i}].navigator.speed_mps = {speed_mps}: trail_controller `{law}` {what}, and fit_to_speed \
                 does not change that; above 0.3 m/s use fuzzy or fuzzy_fine"
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
    let placed = file.events.iter().filter(|e| e.action == "place_box").map(|e| e.thing.as_str());
    let things = file.world.things.iter().map(|t| t.name.as_str());
    let boxes: Vec<String> = file.world.random_boxes.iter().flat_map(names_of).collect();
    let known: Vec<&str> = things.chain(placed).chain(boxes.iter().map(String::as_str)).collect();
    for (i, event) in file.events.iter().enumerate().filter(|(_, e)| e.action == "remove") {
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

/// Robots that must arrive, but nobody sends them anywhere.
fn arrivals(parts: &Parts, found: &mut Vec<String>) {
    let sent = |robot: usize| {
        let by_event = |action: &Action| match action {
            Action::Goal { robots, .. } => robots.contains(&robot),
            _ => false,
        };
        parts.events.iter().any(|e| by_event(&e.action))
            || parts.decision.as_ref().is_some_and(|d| d.robot == Some(robot))
            || parts.robots[robot].teleoperator.is_some()
    };
    for requirement in &parts.success {
        let Requirement::Arrived { robots, group, .. } = requirement else { continue };
        if !robots.iter().any(|&robot| sent(robot)) {
            found.push(format!(
                "[[success.arrived]] of `{group}`: nothing sends it anywhere; add an event with \
                 do = \"goal\", or a decision program with MOVE"
            ));
        }
    }
}
