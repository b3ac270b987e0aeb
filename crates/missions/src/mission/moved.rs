//! Keys and words that were called otherwise: each is refused with its new name.
//!
//! A recording of an older version has them in the mission at its head.

use toml::{
    Spanned, Table, Value,
    de::{DeTable, DeValue},
};

/// A key, with the tables on the way to it and without indices, and what it is called now.
struct Key {
    old: &'static str,
    new: &'static str,
}

/// A word at a key of today, and what it is called now.
struct Word {
    key: &'static str,
    old: &'static str,
    new: &'static str,
}

const fn key(old: &'static str, new: &'static str) -> Key {
    Key { old, new }
}

const fn word(key: &'static str, old: &'static str, new: &'static str) -> Word {
    Word { key, old, new }
}

/// What is in a table comes before the table.
const KEYS: &[Key] = &[
    key("robots.link", "robots.line"),
    key("pheromones.link", "pheromones.line"),
    key("decision.link", "decision.line"),
    key("robots.navigator.control_period_ms", "robots.mind.control_period_ms"),
    key("robots.navigator.goal_within_m", "robots.mind.where_to.within_m"),
    key("robots.navigator.goal_within_deg", "robots.mind.where_to.within_deg"),
    key("robots.navigator.route", "robots.mind.how.method"),
    key("robots.navigator.path_m", "robots.mind.how.path_m"),
    key("robots.navigator.preview_m", "robots.mind.how.preview_m"),
    key("robots.navigator.approach_m", "robots.mind.how.approach_m"),
    key("robots.navigator.speed_mps", "robots.mind.follow.speed_mps"),
    key("robots.navigator.acceleration_mps2", "robots.mind.follow.acceleration_mps2"),
    key("robots.navigator.trail_controller", "robots.mind.follow.trail_law"),
    key("robots.navigator.path_controller", "robots.mind.follow.path_law"),
    key("robots.navigator.turn_first", "robots.mind.follow.turn_first"),
    key("robots.navigator.fit_to_speed", "robots.mind.follow.fit_to_speed"),
    key("robots.navigator.fuzzy", "robots.mind.follow.fuzzy"),
    key("robots.navigator.tags.controller", "robots.mind.follow.tags.law"),
    key("robots.navigator.tags.corrects_pose", "robots.mind.where_am_i.method"),
    key("robots.navigator.tags", "robots.mind.follow.tags"),
    key("robots.navigator.avoidance", "robots.mind.guard.method"),
    key("robots.navigator.rebound", "robots.mind.guard.aims_again"),
    key("robots.navigator.wait_s", "robots.mind.guard.wait_s"),
    key("robots.navigator.attempts_max", "robots.mind.guard.attempts_max"),
    key("robots.navigator", "robots.mind"),
    key("success.cross_track_rms_max_m", "success.on_path.rms_max_m"),
];

const WORDS: &[Word] = &[
    word("robots.mind.how.method", "direct", "straight"),
    word("robots.mind.where_am_i.method", "true", "tag_fixes"),
    word("robots.mind.where_am_i.method", "false", "dead_reckoning"),
    word("events.do", "cut_link", "cut_line"),
    word("events.do", "restore_link", "restore_line"),
    word("events.do", "test_link", "test_line"),
];

/// A sentence for each old key and word in the text of a mission, at its place; nothing for a text that is no TOML.
pub(super) fn in_text(origin: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    if let Ok(table) = DeTable::parse(text) {
        walk(table.get_ref(), &Way::default(), &mut |old: &Found| {
            let before = text.get(..old.offset).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
            found.push((old.offset, format!("{origin}:{line}:{column}: {}", old.text)));
        });
    }
    found.sort();
    found.into_iter().map(|(_, text)| text).collect()
}

/// The same of settings of the form `table.key=value`.
pub(super) fn in_overrides(overrides: &[String]) -> Vec<String> {
    let old = |given: &String| {
        let (key, value) = given.split_once('=')?;
        let (key, value) = (key.trim(), value.trim().trim_matches(['"', '\'']));
        let plain: String = without_indices(key);
        let text = match now(&plain) {
            Some(new) => moved(key, &new, Some(value)),
            None => renamed(key, &plain, value)?,
        };
        Some(format!("--set {given}: {text}"))
    };
    overrides.iter().filter_map(old).collect()
}

fn without_indices(key: &str) -> String {
    key.split('.').map(|part| part.split('[').next().unwrap_or(part)).collect::<Vec<_>>().join(".")
}

/// What a key is called now, if it was moved itself or with its table.
fn now(plain: &str) -> Option<String> {
    let row = |row: &&Key| {
        plain.strip_prefix(row.old).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let row = KEYS.iter().find(row)?;
    Some(format!("{}{}", row.new, &plain[row.old.len()..]))
}

/// Says where a key is now; its word as well, if that has another name too.
fn moved(shown: &str, new: &str, value: Option<&str>) -> String {
    let word = WORDS.iter().find(|word| word.key == new && Some(word.old) == value);
    let word = word.map(|word| format!(", and `{}` is now `{}`", word.old, word.new));
    format!("{shown}: this key is now {new}{}", word.unwrap_or_default())
}

/// Says what a word at a key of today is called now.
fn renamed(shown: &str, plain: &str, value: &str) -> Option<String> {
    let word = WORDS.iter().find(|word| word.key == plain && word.old == value)?;
    Some(format!("{shown} = \"{}\": this word is now \"{}\"", word.old, word.new))
}

/// An old key or word and where it begins.
struct Found {
    offset: usize,
    text: String,
}

/// The names on the way to a value.
#[derive(Default)]
struct Way {
    /// As they are shown, with indices.
    shown: String,
    /// Without indices.
    plain: String,
}

impl Way {
    fn to(&self, name: &str) -> Self {
        let dot = if self.plain.is_empty() { "" } else { "." };
        let Self { shown, plain } = self;
        Self { shown: format!("{shown}{dot}{name}"), plain: format!("{plain}{dot}{name}") }
    }

    fn at(&self, index: usize) -> Self {
        Self { shown: format!("{}[{index}]", self.shown), plain: self.plain.clone() }
    }
}

/// Tells of every old key and word in a table; whether there was one.
fn walk(table: &DeTable<'_>, way: &Way, tell: &mut dyn FnMut(&Found)) -> bool {
    table.iter().fold(false, |any, (name, value)| {
        tell_of(name.span().start, value, &way.to(name.get_ref()), tell) || any
    })
}

/// The same of one key, which stands at an offset.
fn tell_of(
    offset: usize,
    value: &Spanned<DeValue<'_>>,
    way: &Way,
    tell: &mut dyn FnMut(&Found),
) -> bool {
    let word = word_of(value.get_ref());
    let text = word.as_deref().and_then(|word| renamed(&way.shown, &way.plain, word));
    if let Some(text) = text {
        tell(&Found { offset: value.span().start, text });
        return true;
    }
    let any = match value.get_ref() {
        DeValue::Table(inner) => walk(inner, way, tell),
        DeValue::Array(array) => array.iter().enumerate().fold(false, |any, (i, one)| {
            let DeValue::Table(inner) = one.get_ref() else { return any };
            walk(inner, &way.at(i), tell) || any
        }),
        _ => false,
    };
    // What is within a moved table has told more exactly.
    if any {
        return true;
    }
    let Some(row) = KEYS.iter().find(|row| row.old == way.plain) else { return false };
    tell(&Found { offset, text: moved(&way.shown, row.new, word.as_deref()) });
    true
}

/// A value that may be a word, as it is written without quotes.
fn word_of(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Boolean(truth) => Some(truth.to_string()),
        _ => None,
    }
}

/// The mission of an older recording in the words of today, and how many were others; `None` if none was, or it is no TOML.
pub(super) fn translated(text: &str) -> Option<(String, usize)> {
    let n_old = in_text("", text).len();
    if n_old == 0 {
        return None;
    }
    let mut root: Table = toml::from_str(text).ok()?;
    let first_robot = root.get("robots").and_then(|robots| robots.get(0)?.get("name"));
    let first_robot = first_robot.cloned().unwrap_or_else(|| Value::String("robot".to_owned()));
    for row in KEYS {
        let (old, new): (Vec<&str>, Vec<&str>) =
            (row.old.split('.').collect(), row.new.split('.').collect());
        let ([head, old @ ..], [_, new @ ..]) = (&old[..], &new[..]) else { continue };
        for table in tables_of(&mut root, head) {
            let Some(value) = take(table, old) else { continue };
            if *new == ["on_path", "rms_max_m"] {
                // It spoke of the first robot only.
                let one =
                    [("robot".to_owned(), first_robot.clone()), ("rms_max_m".to_owned(), value)];
                put(table, &new[..1], Value::Array(vec![Value::Table(one.into_iter().collect())]));
            } else {
                put(table, new, value);
            }
        }
    }
    for word in WORDS {
        let key: Vec<&str> = word.key.split('.').collect();
        let [head, key @ ..] = &key[..] else { continue };
        for table in tables_of(&mut root, head) {
            match take(table, key) {
                Some(Value::String(text)) if text == word.old => put(table, key, word.new.into()),
                Some(Value::Boolean(is)) if is.to_string() == word.old => {
                    put(table, key, word.new.into());
                }
                Some(other) => put(table, key, other),
                None => {}
            }
        }
    }
    Some((toml::to_string(&root).ok()?, n_old))
}

/// The table of that name, or all of an array.
fn tables_of<'t>(root: &'t mut Table, name: &str) -> Vec<&'t mut Table> {
    match root.get_mut(name) {
        Some(Value::Table(table)) => vec![table],
        Some(Value::Array(array)) => array.iter_mut().filter_map(Value::as_table_mut).collect(),
        _ => Vec::new(),
    }
}

/// Takes what stands at a key, with the tables on the way to it, out of a table.
fn take(table: &mut Table, key: &[&str]) -> Option<Value> {
    match key {
        [] => None,
        [last] => table.remove(*last),
        [first, rest @ ..] => take(table.get_mut(*first)?.as_table_mut()?, rest),
    }
}

/// Puts a value there; a table's keys are added to those of a table.
fn put(table: &mut Table, key: &[&str], value: Value) {
    match (key, value) {
        ([], _) => {}
        ([last], Value::Table(more)) => {
            let there = table.entry(*last).or_insert_with(|| Value::Table(Table::new()));
            if let Value::Table(there) = there {
                there.extend(more);
            }
        }
        ([last], value) => {
            table.insert((*last).to_owned(), value);
        }
        ([first, rest @ ..], value) => {
            let inner = table.entry(*first).or_insert_with(|| Value::Table(Table::new()));
            if let Value::Table(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

#[cfg(test)]
mod tests;
