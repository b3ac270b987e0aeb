//! What a mission may say and its author hardly meant.

use navigator::{Method, TrailController};
use settings::Choice as _;

use crate::mission::{file::MissionFile, parts::Parts, plan::Action, words::EventKind};

/// A sentence for each oddity, in the order of the file's tables.
pub(crate) fn warnings(file: &MissionFile, parts: &Parts) -> Vec<String> {
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
    let cast = parts.cast();
    found.extend(parts.success.iter().flat_map(|requirement| requirement.warnings(&cast)));
    unsent(parts, &mut found);
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

/// Goals that are never sent.
fn unsent(parts: &Parts, found: &mut Vec<String>) {
    let cast = parts.cast();
    let mut sent = vec![false; parts.robots.len()];
    for event in &parts.events {
        let Action::Goal { robots, .. } = &event.action else { continue };
        for &robot in robots {
            if event.after_arrival && !sent[robot] && !cast.may_go_anywhere(robot) {
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
