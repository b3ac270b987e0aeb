//! Keys that are given and that nothing reads, because another key or table makes them idle.
//!
//! A key counts as given when it differs from its default: the resolved text of a mission has all of them.

use navigator::{Method, TrailController};
use settings::Choice as _;

use crate::mission::{
    file::{
        DecisionFile, LineFile, MindFile, MissionFile, PersonFile, PheromonesFile, RandomBoxesFile,
        RobotFile, WorldFile,
    },
    plan::{Action, DevicePlan, DeviceWiring, EventPlan},
    words::{DeviceKind, EventKind, LineKind},
};

/// A sentence for each group of keys that do nothing, in the order of the file's tables.
pub(super) fn unused(
    file: &MissionFile,
    devices: &[DevicePlan],
    events: &[EventPlan],
    found: &mut Vec<String>,
) {
    world(&file.world, found);
    wiring(file, devices, found);
    for (i, one) in file.robots.iter().enumerate() {
        robot(&format!("robots[{i}]"), one, found);
    }
    pheromones(file, events, found);
    if let Some(decision) = &file.decision {
        line("decision.line", &decision.line, &DecisionFile::default().line, found);
    }
}

/// One sentence about those of the keys that are given; `why` follows "because".
fn idle(table: &str, keys: &[(&str, bool)], why: &str, found: &mut Vec<String>) {
    let given: Vec<&str> = keys.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
    let does = if given.len() == 1 { "does" } else { "do" };
    if !given.is_empty() {
        found.push(format!("{table}: {} {does} nothing, because {why}", given.join(", ")));
    }
}

/// Whether two numbers are written alike.
fn differs(one: f64, other: f64) -> bool {
    one.to_bits() != other.to_bits()
}

fn world(file: &WorldFile, found: &mut Vec<String>) {
    let usual = WorldFile::default();
    if file.map.is_none() {
        let at = file.map_at.iter().zip(usual.map_at).any(|(&a, b)| differs(a, b));
        let keys = [("unknown", file.unknown != usual.unknown), ("map_at", at)];
        idle("world", &keys, "there is no world.map, which they are about", found);
    }
    for (i, person) in file.people.iter().enumerate().filter(|(_, p)| p.route_m.len() == 1) {
        let usual = PersonFile::default();
        let keys = [
            ("speed_mps", differs(person.speed_mps, usual.speed_mps)),
            ("speed_spread_mps", differs(person.speed_spread_mps, usual.speed_spread_mps)),
            ("starts_at_s", differs(person.starts_at_s, usual.starts_at_s)),
            ("starts_spread_s", differs(person.starts_spread_s, usual.starts_spread_s)),
            ("repeats", person.repeats),
        ];
        let why = "route_m has one place: who has nowhere to go stands";
        idle(&format!("world.people[{i}]"), &keys, why, found);
    }
    for (i, boxes) in file.random_boxes.iter().enumerate() {
        let offset = differs(boxes.offset_max_m, RandomBoxesFile::default().offset_max_m);
        let keys = [("offset_max_m", offset && !boxes.area_m.is_empty())];
        let why = "the boxes lie in area_m, and it is about along_trail_m";
        idle(&format!("world.random_boxes[{i}]"), &keys, why, found);
    }
}

fn wiring(file: &MissionFile, devices: &[DevicePlan], found: &mut Vec<String>) {
    for (i, device) in
        file.devices.iter().enumerate().filter(|(_, d)| d.kind != DeviceKind::Motion.key())
    {
        let why = format!("only a motion detector watches an area, and this is a {}", device.kind);
        idle(&format!("devices[{i}]"), &[("area_m", !device.area_m.is_empty())], &why, found);
    }
    for (i, event) in file.events.iter().enumerate() {
        let pressed =
            [EventKind::Press, EventKind::Release].iter().any(|kind| event.action == kind.key());
        let device = devices.iter().find(|d| pressed && d.name == event.device);
        let Some(DeviceWiring::Button { input }) = device.map(|d| &d.wiring) else { continue };
        let why = match (input, &file.decision) {
            (None, _) => "the button has no input",
            (_, None) => "the mission has no [decision], whose program would read the button",
            _ => continue,
        };
        found.push(format!("events[{i}]: `{}` changes nothing, because {why}", event.action));
    }
}

fn robot(key: &str, file: &RobotFile, found: &mut Vec<String>) {
    let usual = RobotFile::default();
    if file.count == 1 {
        let apart = file.spacing_m.iter().zip(usual.spacing_m).any(|(&a, b)| differs(a, b));
        let keys = [("spacing_m", apart), ("row_length", file.row_length != usual.row_length)];
        idle(key, &keys, "count = 1: there are no rows of robots", found);
    }
    line(&format!("{key}.line"), &file.line, &LineFile::default(), found);
    for (i, laser) in file.lasers.iter().enumerate() {
        line(&format!("{key}.lasers[{i}].line"), &laser.line, &LineFile::laser(), found);
    }
    mind(&format!("{key}.mind"), &file.mind, found);
}

/// `usual`: what a line of that place is when nothing is given.
fn line(key: &str, file: &LineFile, usual: &LineFile, found: &mut Vec<String>) {
    let Ok(kind) = settings::chosen::<LineKind>(key, &file.kind) else { return };
    let (is_memory, is_serial) = (kind == LineKind::Memory, kind == LineKind::Serial);
    let keys = [
        ("baud", file.baud != usual.baud && !is_memory && !is_serial),
        ("latency_ms", differs(file.latency_ms, usual.latency_ms) && !is_memory),
        ("jitter_ms", differs(file.jitter_ms, usual.jitter_ms) && !is_memory),
        ("loss_prob", differs(file.loss_prob, usual.loss_prob) && !is_memory),
        ("corruption_prob", differs(file.corruption_prob, usual.corruption_prob) && !is_memory),
        ("address", !file.address.is_empty() && kind != LineKind::Tcp),
        ("device", !file.device.is_empty() && !is_serial),
    ];
    let why = match kind {
        LineKind::Memory => {
            "kind = \"memory\" is a line that is simulated here; address is for `tcp`, device for `serial`"
        }
        LineKind::Direct => {
            "kind = \"direct\" carries no bytes; `memory` has them, with baud rate, delay and faults"
        }
        LineKind::Tcp => {
            "kind = \"tcp\" is a real line, which takes its own time; it reads address"
        }
        LineKind::Serial => {
            "kind = \"serial\" is a real line, which takes its own time; it reads device and baud"
        }
    };
    idle(key, &keys, why, found);
}

fn mind(key: &str, file: &MindFile, found: &mut Vec<String>) {
    let usual = MindFile::default();
    let (how, follow) = (&file.how, &file.follow);
    let Ok(method) = settings::chosen::<Method>(key, &how.method) else { return };
    let word = method.key();
    if method != Method::Path {
        let why = format!("how.method = \"{word}\"; `path` reads them");
        idle(key, &[("how.path_m", !how.path_m.is_empty())], &why, found);
    }
    if !matches!(method, Method::Path | Method::Map) {
        let why = format!("how.method = \"{word}\"; `path` and `map` read them");
        let own_law = follow.path_law != usual.follow.path_law;
        idle(key, &[("follow.path_law", own_law)], &why, found);
    }
    if method != Method::Tags {
        let why = format!("how.method = \"{word}\"; `tags` reads them");
        idle(key, &[("follow.tags", follow.tags != usual.follow.tags)], &why, found);
    }
    if method != Method::Trail {
        let why = format!("how.method = \"{word}\"; `trail` reads them");
        let keys = [
            ("follow.trail_law", follow.trail_law != usual.follow.trail_law),
            ("follow.fuzzy", follow.fuzzy != usual.follow.fuzzy),
        ];
        idle(key, &keys, &why, found);
        return;
    }
    let Some(law) = TrailController::by_key(&follow.trail_law) else { return };
    let (word, fuzzy) = (law.key(), &follow.fuzzy);
    if !law.has_rules() {
        let why = format!("trail_law = \"{word}\"; {} have sets and rules", with_rules());
        idle(key, &[("follow.fuzzy", *fuzzy != usual.follow.fuzzy)], &why, found);
    } else if !law.has_own_speeds() {
        let given = fuzzy.listing_mean_mmps != usual.follow.fuzzy.listing_mean_mmps;
        let why = format!("trail_law = \"{word}\"; `listing` has a speed of its own");
        idle(&format!("{key}.follow.fuzzy"), &[("listing_mean_mmps", given)], &why, found);
    }
}

/// The laws on a trail that have sets and rules, in words.
fn with_rules() -> String {
    let laws = TrailController::ALL.iter().filter(|law| law.has_rules());
    let words: Vec<String> = laws.map(|law| format!("`{}`", law.key())).collect();
    let (last, others) = words.split_last().map_or(("", &words[..]), |(l, o)| (l.as_str(), o));
    format!("{} and {last}", others.join(", "))
}

fn pheromones(file: &MissionFile, events: &[EventPlan], found: &mut Vec<String>) {
    let Some(table) = &file.pheromones else { return };
    let usual = PheromonesFile::default();
    if table.map.is_some() {
        let keys = [
            ("width_cells", table.width_cells != usual.width_cells),
            ("value", table.value != usual.value),
            ("width", table.width != usual.width),
            ("height", table.height != usual.height),
        ];
        idle("pheromones", &keys, "the matrix of map has its own values and size", found);
    }
    line("pheromones.line", &table.line, &usual.line, found);
    let smells = file.robots.iter().any(|robot| robot.mind.how.method == Method::Trail.key());
    let holds_boxes = file.world.random_boxes.iter().any(|b| !b.along_trail_m.is_empty());
    let is_cut =
        |action: &Action| matches!(action, Action::Link { line: crate::cut::Line::Pheromones, .. });
    if !smells && !holds_boxes && !events.iter().any(|event| is_cut(&event.action)) {
        found.push(
            "[pheromones]: nobody asks the server, because no robot has mind.how.method = \"trail\""
                .to_owned(),
        );
    }
}
