//! `cairn run`, `replay`, `missions`, `config`, `reproduce` from end to end.

mod support;

use std::fs;

use serde_json::Value;
use support::{Place, short_drive};

#[test]
fn a_passed_run_ends_with_0_and_prints_its_figures() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    let run = place.cairn("run drive.toml --headless").fine();
    for word in ["short-drive (seed 5): passed", "ok", "arrived", "state_hash", "contacts"] {
        assert!(run.out.contains(word), "`{word}` is missing in: {}", run.out);
    }
    assert_eq!(run.err, "", "no progress bar where there is no terminal");
}

#[test]
fn a_failed_run_ends_with_1() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.001));
    let run = place.cairn("run drive.toml --headless --format json");
    assert_eq!((run.code, &run.json()["verdict"]), (1, &Value::from("fail")));
}

#[test]
fn a_seed_repeats_its_bits_on_any_number_of_threads() {
    let place = Place::new();
    let hash = |seed: u64, threads: &str| {
        let mut command = place.command();
        command.env("RAYON_NUM_THREADS", threads);
        let seed = seed.to_string();
        command.args(["run", "one-obstacle", "--headless", "--format", "json", "--seed", &seed]);
        let object = Place::ended(&mut command).json();
        assert!(object["figures"]["drive_time_s"].as_f64().unwrap() > 10.0);
        object["state_hash"].as_str().unwrap().to_owned()
    };
    assert_eq!(hash(3, "1"), hash(3, "4"));
    assert_ne!(hash(3, "1"), hash(4, "1"));
}

#[test]
fn what_cannot_be_run_is_refused_with_2() {
    let place = Place::new();
    let run = |rest: &str| place.cairn(&format!("run {rest}"));
    run("nosuch --headless").refused(2, &["nosuch", "doorbell", "no such file"]);
    run("doorbell --headless --set nonsense").refused(2, &["nonsense", "table.key=value"]);
    run("doorbell --headless --set robots.mind.follow.speed_mps=9")
        .refused(2, &["speed_mps = 9", "from 0.05 to 1 m/s"]);
    run("doorbell --headless --set robots.mind.follow.sped_mps=0.2")
        .refused(2, &["sped_mps", "speed_mps"]);
    run("doorbell --headless --seed x").refused(2, &["'x'", "whole number from 0"]);
    run("doorbell --speed 500").refused(2, &["500", "0.1 to 20"]);
    run("doorbell --format json").refused(2, &["--headless"]);
    run("doorbell --headless --record no/such/out.mcap").refused(2, &["no/such/out.mcap"]);
    place.write("broken.toml", "[mission]\nname = \"x\"\nfoo = 1\n");
    run("broken.toml --headless").refused(2, &["broken.toml", "line 3", "foo", "duration_max_s"]);
    let folder = run(". --headless");
    folder.refused(2, &["it is a folder"]);
    assert_eq!(folder.err.matches("folder").count(), 1, "said twice: {}", folder.err);
}

#[test]
fn set_changes_the_run() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    let time_s = |rest: &str| {
        let run = place.cairn(&format!("run drive.toml --headless --format json {rest}"));
        run.fine().json()["figures"]["drive_time_s"].as_f64().unwrap()
    };
    assert!(time_s("--set robots.mind.follow.speed_mps=0.15") > 1.3 * time_s(""));
}

#[test]
fn a_recording_replays_step_by_step() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    let run =
        place.cairn("run drive.toml --headless --format json --record out.mcap").fine().json();
    let replay = place.cairn("replay out.mcap --headless --format json").fine().json();
    assert_eq!(replay["state_hash"], run["state_hash"]);
    assert_eq!(replay["steps_compared"], run["steps"]);
    assert_eq!(replay["first_difference"], Value::Null);
    let text = place.cairn("replay out.mcap --headless").fine().out;
    assert!(text.contains("steps, each with the recorded state"), "{text}");
}

/// Public cases: an own recording with one byte of a topic's name changed, and what a killed studio left.
#[test]
fn damaged_and_killed_recordings_of_earlier_builds_say_what_they_are() {
    let place = Place::new();
    if let Some(damaged) = testkit::data_folder("../cases/recordings/hash-topic-1byte.mcap") {
        let ended = place.cairn(&format!("replay {} --headless", damaged.display()));
        assert_eq!(ended.code, 1, "{}{}", ended.out, ended.err);
        let said = [
            "The recording is damaged",
            "checksum",
            "it says that it has",
            "0 are in it",
            "None of the",
            "an earlier build",
        ];
        for word in said {
            assert!(ended.out.contains(word), "`{word}` is missing in {}", ended.out);
        }
        assert!(!ended.out.contains("each with the recorded state"), "{}", ended.out);
        let mapped = place.cairn(&format!("map {} -o damaged", damaged.display())).fine();
        assert!(format!("{}{}", mapped.out, mapped.err).contains("checksum"), "{}", mapped.out);
    }
    if let Some(killed) = testkit::data_folder("../cases/recordings/studio-killed-12s.mcap.part") {
        let ended = place.cairn(&format!("replay {} --headless --format json", killed.display()));
        let object = ended.json();
        assert!(object["steps_compared"].as_u64().unwrap() > 100, "{object}");
        assert!(object["truncation"].as_str().unwrap().contains("was not finished"), "{object}");
        assert!(object["other_build"].as_str().unwrap().contains("an earlier build"), "{object}");
        place.cairn(&format!("map {} -o killed", killed.display())).fine();
    }
}

#[test]
fn what_would_have_happened_ends_with_a_verdict() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    place.cairn("run drive.toml --headless --record out.mcap").fine();
    let changed = "replay out.mcap --headless --set robots.mind.follow.speed_mps=0.15";
    let text = place.cairn(changed).fine().out;
    assert!(text.contains("another one from step") && text.contains("passed"), "{text}");
    let object = place.cairn(&format!("{changed} --format json")).fine().json();
    assert_eq!(object["verdict"], "pass");
    assert!(object["steps"].as_u64() > object["steps_compared"].as_u64(), "{object}");
    let never = "replay out.mcap --headless --set mission.duration_max_s=2.0";
    assert_eq!(place.cairn(never).code, 1, "a failed verdict");
}

#[test]
fn a_damaged_recording_says_so() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    place.cairn("run drive.toml --headless --record out.mcap").fine();
    let whole = fs::read(place.path("out.mcap")).unwrap();
    fs::write(place.path("cut.mcap"), &whole[..whole.len() * 3 / 4]).unwrap();
    let cut = place.cairn("replay cut.mcap --headless");
    assert_eq!(cut.code, 1, "it was cut within a piece: {}{}", cut.out, cut.err);
    assert!(
        cut.out.contains("was not written whole") && cut.out.contains("not finished"),
        "{}",
        cut.out
    );
    // Every byte counts, also those that no reader of MCAP looks at.
    for at in [3, whole.len() / 2, whole.len() - 300, whole.len() - 30, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x20;
        fs::write(place.path("bad.mcap"), &bytes).unwrap();
        let ended = place.cairn("replay bad.mcap --headless");
        assert!(ended.code == 1 || ended.code == 2, "byte {at}: {}", ended.out);
        let said = format!("{}{}", ended.out, ended.err);
        assert!(said.contains("damaged") || said.contains("MCAP"), "byte {at}: {said}");
        assert!(!said.contains("each with the recorded state"), "byte {at}: {said}");
    }
    place.write("empty.mcap", "");
    place.cairn("replay empty.mcap --headless").refused(2, &["empty.mcap", "no recording"]);
    place.cairn("replay drive.toml --headless").refused(2, &["drive.toml", "no recording"]);
    place.cairn("replay absent.mcap --headless").refused(2, &["absent.mcap", "No such file"]);
}

#[test]
fn a_shown_mission_runs_like_the_shipped_one() {
    let place = Place::new();
    let list = place.cairn("missions --format json").fine().json();
    assert!(list["missions"].as_array().unwrap().iter().any(|m| m["name"] == "trail-corner"));
    assert!(place.cairn("missions").fine().out.starts_with("doorbell "));
    place.write("own.toml", &place.cairn("missions trail-corner").fine().out);
    let hash = |mission: &str| {
        let run = place.cairn(&format!("run {mission} --headless --format json"));
        run.json()["state_hash"].as_str().unwrap().to_owned()
    };
    assert_eq!(hash("own.toml"), hash("trail-corner"));
    place.cairn("missions nosuch").refused(2, &["nosuch", "trail-corner"]);
}

#[test]
fn the_printed_configuration_is_a_mission() {
    let place = Place::new();
    let reference = place.cairn("config").fine().out;
    let table: toml::Table = reference.parse().unwrap();
    for key in ["mission", "world", "robots", "pheromones", "decision", "events", "success"] {
        assert!(table.contains_key(key), "[{key}] is missing");
    }
    // It holds examples that need not fit together, so only its keys are tried: none is unknown.
    place.write("reference.toml", &reference);
    let run = place.cairn("run reference.toml --headless --set mission.duration_max_s=1");
    assert!(!run.err.contains("unknown field") && !run.err.contains("parse error"), "{}", run.err);
}

#[test]
fn the_words_of_a_key_are_printed_with_what_they_are() {
    let place = Place::new();
    let words = place.cairn("config robots.mind.how.method").fine().out;
    assert_eq!(place.cairn("config how.method").fine().out, words);
    let rows: Vec<Vec<&str>> = words.lines().map(|row| row.split_whitespace().collect()).collect();
    let first: Vec<&str> = rows.iter().map(|row| row[1]).collect();
    assert_eq!(first, ["trail", "straight", "path", "tags", "map"], "{words}");
    assert!(rows.iter().all(|row| row[0] == "robots.mind.how.method" && row.len() > 3), "{words}");
    // Three lines, the words of each.
    assert_eq!(place.cairn("config line.kind").fine().out.lines().count(), 4 + 2 + 2);
    place.cairn("config guard.methd").refused(2, &["guard.methd", "did you mean `guard.method`?"]);
    place.cairn("config mission.seed").refused(2, &["mission.seed", "world.unknown"]);
}

#[test]
fn old_words_are_refused_with_their_new_names() {
    let place = Place::new();
    place.write("old.toml", "[[robots]]\n[robots.navigator]\nroute = \"direct\"\n");
    place.cairn("check old.toml").refused(
        2,
        &[
            "old.toml:3:1: robots[0].navigator.route",
            "robots.mind.how.method",
            "`direct` is now `straight`",
        ],
    );
    place
        .cairn("run one-obstacle --headless --set robots.link.kind=direct")
        .refused(2, &["robots.link.kind: this key is now robots.line.kind"]);
}

#[test]
fn experiments_are_listed_and_repeat_their_tables_on_any_number_of_threads() {
    let place = Place::new();
    let list = place.cairn("reproduce").fine().out;
    assert!(list.contains("assistant-7.4") && list.contains("assistant-7.5"), "{list}");
    place.cairn("reproduce nosuch").refused(2, &["nosuch", "assistant-7.4"]);
    place.cairn("reproduce assistant-7.4 --runs 0").refused(2, &["--runs"]);
    let report = |threads: u32, folder: &str| {
        let run = format!("reproduce assistant-7.4 --runs 1 --threads {threads} --report markdown");
        let out = place.cairn(&format!("{run} --output {folder}")).fine().out;
        assert!(out.contains("settled, rms (mm)") && out.contains("report.md"), "{out}");
        place.read(&format!("{folder}/report.md"))
    };
    let alone = report(1, "one");
    assert_eq!(alone, report(2, "two"));
    assert_eq!(place.read("one/corner.svg"), place.read("two/corner.svg"));
    assert!(alone.contains("![") && alone.contains("| reported by the document |"), "{alone}");
}

#[test]
fn each_part_of_a_mind_says_a_sentence() {
    let place = Place::new();
    let told = place.cairn("run one-obstacle --headless --verbose").fine().err;
    for part in ["where am I", "around", "where to", "how", "follow", "guard", "health"] {
        let line = told.lines().find(|line| line.contains(&format!(", {part}: ")));
        assert!(line.is_some_and(|line| line.len() > part.len() + 12), "{part}: {told}");
    }
    let json = place.cairn("run one-obstacle --headless --verbose --format json").fine().json();
    let minds = json["minds"].as_object().unwrap();
    assert!(minds.values().all(|mind| mind.as_object().unwrap().len() == 7), "{minds:?}");
}
