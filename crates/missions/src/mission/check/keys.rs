//! Which keys belong to which kind of event.

use super::super::{error::Wrong, file::EventFile, words::EventKind};
use super::common::chosen;
use settings::Choice as _;

/// An event's kind; every key that is given is one of that kind's.
pub(super) fn kind_of(key: &str, file: &EventFile, has_program: bool) -> Result<EventKind, Wrong> {
    let at = format!("{key}.do");
    let kind: EventKind = chosen(&at, &file.action)?;
    for (name, found) in given(file) {
        if !kind.keys().contains(&name) {
            return Err(Wrong::prose(format!("{key}.{name}"), found, absent(kind, name)));
        }
    }
    if kind.needs_program() && !has_program {
        let allowed =
            "something else, because the mission has no [decision], whose program it is about";
        return Err(Wrong::new(at, &file.action, allowed));
    }
    Ok(kind)
}

/// Why a key must be absent from an event: what that kind takes, and which kinds take the key.
fn absent(kind: EventKind, name: &str) -> String {
    let takes = match kind.keys() {
        [] => "no key of its own".to_owned(),
        keys => keys.join(", "),
    };
    let others: Vec<String> = EventKind::ALL
        .iter()
        .filter(|other| other.keys().contains(&name))
        .map(|other| format!("`{}`", other.key()))
        .collect();
    format!("absent: `{}` takes {takes}; `{name}` belongs to {}", kind.key(), others.join(", "))
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
