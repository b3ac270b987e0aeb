//! Which keys belong to which kind of event, and what needs a decision program.

use super::super::{
    error::Wrong,
    file::{EventFile, MissionFile},
};
use crate::asked::Asked;
use settings::choose;

/// A kind of event, the keys that it reads beside `at_s` and `do`, and whether it is about the decision program.
struct Kind {
    name: &'static str,
    keys: &'static [&'static str],
    needs_program: bool,
}

const fn kind(name: &'static str, keys: &'static [&'static str]) -> Kind {
    Kind { name, keys, needs_program: false }
}

const fn of_program(name: &'static str, keys: &'static [&'static str]) -> Kind {
    Kind { name, keys, needs_program: true }
}

/// Every kind of event. Its place in this list is what [`index_of`] gives.
const KINDS: [Kind; 14] = [
    kind("press", &["device"]),
    kind("release", &["device"]),
    kind("goal", &["robot", "pose", "pose_from_start", "after_arrival"]),
    kind("stop", &["robot"]),
    kind("place_box", &["at_m", "size_m", "thing"]),
    kind("cut_link", &["robot", "line", "direction"]),
    kind("restore_link", &["robot", "line", "direction"]),
    of_program("stop_program", &[]),
    of_program("run_program", &[]),
    of_program("stall_program", &["for_s"]),
    kind("remove", &["thing"]),
    kind(Asked::Link.name(), &["robot"]),
    kind(Asked::Sonar.name(), &["robot"]),
    kind(Asked::Restart.name(), &["robot"]),
];

/// The place of an event's kind in the list of kinds; every key that is given is one of that kind's.
pub(super) fn index_of(key: &str, file: &EventFile, has_program: bool) -> Result<usize, Wrong> {
    let names = KINDS.each_ref().map(|kind| kind.name);
    let at = format!("{key}.do");
    let index = choose(&at, &file.action, &names)?;
    let Some(kind) = KINDS.get(index) else { return Ok(index) };
    for (name, found) in given(file) {
        if !kind.keys.contains(&name) {
            return Err(Wrong::prose(format!("{key}.{name}"), found, absent(kind, name)));
        }
    }
    if kind.needs_program && !has_program {
        let allowed =
            "something else, because the mission has no [decision], whose program it is about";
        return Err(Wrong::new(at, &file.action, allowed));
    }
    Ok(index)
}

/// Why a key must be absent from an event: what that kind takes, and which kinds take the key.
fn absent(kind: &Kind, name: &str) -> String {
    let takes = match kind.keys {
        [] => "no key of its own".to_owned(),
        keys => keys.join(", "),
    };
    let others: Vec<String> = KINDS
        .iter()
        .filter(|other| other.keys.contains(&name))
        .map(|other| format!("`{}`", other.name))
        .collect();
    format!("absent: `{}` takes {takes}; `{name}` belongs to {}", kind.name, others.join(", "))
}

/// The keys that are given beside `at_s` and `do`, each with what stands there.
fn given(file: &EventFile) -> impl Iterator<Item = (&'static str, String)> {
    let text = |text: &str| (!text.is_empty()).then(|| format!("{text:?}"));
    let EventFile {
        at_s: _,
        action: _,
        device,
        robot,
        pose,
        pose_from_start,
        after_arrival,
        at_m,
        size_m,
        thing,
        line,
        direction,
        for_s,
    } = file;
    [
        ("device", text(device)),
        ("robot", text(robot)),
        ("pose", pose.map(|p| format!("{p:?}"))),
        ("pose_from_start", pose_from_start.map(|p| format!("{p:?}"))),
        ("after_arrival", after_arrival.then(|| "true".to_owned())),
        ("at_m", at_m.map(|p| format!("{p:?}"))),
        ("size_m", size_m.map(|m| format!("{m:?}"))),
        ("thing", text(thing)),
        ("line", text(line)),
        ("direction", text(direction)),
        ("for_s", for_s.map(|s| format!("{s:?}"))),
    ]
    .into_iter()
    .filter_map(|(name, found)| Some((name, found?)))
}

/// What counts the doings of a decision program needs one.
pub(super) fn counts_need_a_program(file: &MissionFile) -> Result<(), Wrong> {
    if file.decision.is_some() {
        return Ok(());
    }
    let success = &file.success;
    let counts = [
        ("moves_sent", success.moves_sent),
        ("events_logged", success.events_logged),
        ("watchdog_resets", success.watchdog_resets),
    ];
    for (name, count) in counts {
        if let Some(count) = count {
            let allowed = "absent, because the mission has no [decision], whose program it counts";
            return Err(Wrong::new(format!("success.{name}"), count, allowed));
        }
    }
    Ok(())
}
