//! Every row of the tables of moved keys and words, in files and as settings.

use super::*;
use crate::mission::{Mission, MissionError, file::MissionFile};

/// A mission in which nothing stands at `key` (tables of arrays as in a mission) but `value`.
fn with(key: &str, value: &str) -> String {
    let (tables, last) = key.rsplit_once('.').unwrap();
    let first = tables.split('.').next().unwrap();
    let array = matches!(first, "robots" | "events");
    let head = if array { format!("[[{first}]]\n") } else { String::new() };
    let rest = tables.strip_prefix(first).unwrap();
    let table = if array && rest.is_empty() { String::new() } else { format!("[{tables}]\n") };
    format!("{head}{table}{last} = {value}\n")
}

fn refusal(text: &str, overrides: &[&str]) -> String {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    match Mission::parse("old.toml", text, &overrides) {
        Err(MissionError::Moved { lines }) => lines.join("\n"),
        Err(error) => format!("another error: {error}"),
        Ok(_) => "accepted".to_owned(),
    }
}

/// Whether a mission file has a key, whatever its value may be.
fn exists(key: &str) -> bool {
    let text = match key.strip_prefix("success.on_path") {
        Some(last) => format!("[[success.on_path]]\n{} = [[[[]]]]\n", &last[1..]),
        None => with(key, "[[[[]]]]"),
    };
    let error = toml::from_str::<MissionFile>(&text).unwrap_err().to_string();
    !error.contains("unknown field")
}

#[test]
fn every_old_key_is_refused_with_its_new_name_and_place() {
    for Key { old, new } in KEYS {
        let (_, last) = old.rsplit_once('.').unwrap();
        let text = with(old, "7");
        let line = text.lines().count();
        let shown = old.replacen("robots", "robots[0]", 1);
        let said = refusal(&text, &[]);
        assert_eq!(said, format!("old.toml:{line}:1: {shown}: this key is now {new}"), "{last}");
        let set = format!("{old}=7");
        let expected = format!("--set {set}: {old}: this key is now {new}");
        assert_eq!(refusal("[[robots]]\n", &[&set]), expected);
        assert!(exists(new), "{new} is no key");
        assert!(!exists(old), "{old} is a key still");
    }
}

#[test]
fn every_old_word_is_refused_with_its_new_name_and_place() {
    for Word { key, old, new } in WORDS {
        let text = with(key, &format!("\"{old}\""));
        let said = refusal(&text, &[]);
        assert!(said.starts_with("old.toml:"), "{said}");
        assert!(said.ends_with(&format!(" = \"{old}\": this word is now \"{new}\"")), "{said}");
        let set = format!("{key}={old}");
        let said = refusal("[[robots]]\n[[events]]\n", &[&set]);
        let expected = format!("--set {set}: {key} = \"{old}\": this word is now \"{new}\"");
        assert_eq!(said, expected);
        // The new word is one.
        let said = refusal(&with(key, &format!("\"{new}\"")), &[]);
        assert!(!said.contains(new), "{said}");
    }
}

#[test]
fn all_old_keys_of_a_mission_are_told_at_once_with_their_words() {
    let text = "[mission]\nname = \"a\"\n[[robots]]\nlink.kind = \"direct\"\n[robots.navigator]\nroute = \"direct\"\n\
                tags.corrects_pose = false\n[[robots]]\nname = \"b\"\nnavigator = { avoidance = \"off\" }\n\
                [[events]]\ndo = \"cut_link\"\n";
    let expected = "old.toml:4:1: robots[0].link: this key is now robots.line\n\
                    old.toml:6:1: robots[0].navigator.route: this key is now robots.mind.how.method, and `direct` is \
                    now `straight`\n\
                    old.toml:7:6: robots[0].navigator.tags.corrects_pose: this key is now \
                    robots.mind.where_am_i.method, and `false` is now `dead_reckoning`\n\
                    old.toml:10:15: robots[1].navigator.avoidance: this key is now robots.mind.guard.method\n\
                    old.toml:12:6: events[0].do = \"cut_link\": this word is now \"cut_line\"";
    assert_eq!(refusal(text, &[]), expected);
    // Of a table that has nothing in it, the table is told; of one with a key that never was, too.
    for inside in ["", "colour = 3\n"] {
        let said = refusal(&format!("[[robots]]\n[robots.navigator]\n{inside}"), &[]);
        assert_eq!(said, "old.toml:2:9: robots[0].navigator: this key is now robots.mind");
    }
    let set = ["robots[3].link.kind=tcp", "robots.navigator.route='direct'"];
    let said = refusal("", &set);
    assert_eq!(
        said,
        "--set robots[3].link.kind=tcp: robots[3].link.kind: this key is now robots.line.kind\n\
         --set robots.navigator.route='direct': robots.navigator.route: this key is now robots.mind.how.method, and \
         `direct` is now `straight`"
    );
}

#[test]
fn words_of_today_are_no_old_ones() {
    for name in Mission::shipped() {
        let mission = Mission::load(name, &[]).unwrap();
        assert_eq!(in_text(name, &mission.to_toml()), Vec::<String>::new());
    }
    assert_eq!(in_text("template", Mission::template()), Vec::<String>::new());
    // `direct` is a word for a line still.
    assert_eq!(in_text("x", "[[robots]]\nline.kind = \"direct\"\n"), Vec::<String>::new());
    assert_eq!(in_text("x", "no = = toml"), Vec::<String>::new());
}

/// What every old key says is found again at its new place.
#[test]
fn every_old_key_and_word_is_translated() {
    for Key { old, new } in KEYS {
        let (text, n_old) = translated(&with(old, "7")).unwrap();
        assert_eq!((n_old, in_text("x", &text).len()), (1, 0), "{old}: {text}");
        let root = Value::Table(toml::from_str(&text).unwrap());
        let place = new.split('.').try_fold(&root, |at, name| match at.get(name)? {
            Value::Array(array) => array.first(),
            inner => Some(inner),
        });
        assert_eq!(place.and_then(Value::as_integer), Some(7), "{new}: {text}");
    }
    for Word { key, old, new } in WORDS {
        let (text, _) = translated(&with(key, &format!("\"{old}\""))).unwrap();
        assert!(text.contains(&format!("\"{new}\"")) && in_text("x", &text).is_empty(), "{text}");
    }
    let old = "[[robots]]\nname = \"a\"\n[robots.navigator]\nspeed_mps = 0.2\nfuzzy.error_full = 9\ntags.corrects_pose = \
               false\ntags.hold_m = 0.4\n[[robots]]\nname = \"b\"\n[success]\ncross_track_rms_max_m = 0.1\n";
    let (text, n_old) = translated(old).unwrap();
    assert_eq!(n_old, 4);
    let file: MissionFile = toml::from_str(&text).unwrap();
    let mind = &file.robots[0].mind;
    assert_eq!(
        (mind.follow.fuzzy.error_full, mind.where_am_i.method.as_str()),
        (9, "dead_reckoning")
    );
    assert!((mind.follow.speed_mps - 0.2).abs() + (mind.follow.tags.hold_m - 0.4).abs() < 1e-12);
    assert_eq!(file.success.on_path[0].robot, "a");
    // Nothing is done where nothing is old, or nothing is TOML.
    assert_eq!(translated(&text), None);
    assert_eq!(translated("no = = toml"), None);
}
