//! `cairn rdpl` and `cairn explain` from end to end.

mod support;

use std::fs;

use support::{Place, shipped};

const RIGHT: &str = "AND Y0,I0,I1,1L,1L\nOR O0,Y0,I2,0L,0L\n";
const WRONG: &str = "AND Y0,I0,I1,1L,1L\nOR O0,IO,I2,0L,0L\n";

#[test]
fn compiling_leaves_an_image_and_a_listing() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    let run = place.cairn("rdpl lamp").fine();
    assert!(run.out.contains("Lines compiled: 2. Total errors 0."), "{}", run.out);
    assert_eq!(fs::read(place.path("lamp.bin")).unwrap().last(), Some(&0x0F));
    assert!(place.read("lamp.lst").contains("OR O0,Y0,I2"));
}

#[test]
fn an_error_removes_the_outdated_image() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    place.cairn("rdpl lamp.src").fine();
    place.write("lamp.src", WRONG);
    let image = fs::read(place.path("lamp.bin")).unwrap();
    place.cairn("rdpl lamp.src").refused(2, &["lamp.bin", "exists already", "--force"]);
    assert_eq!(fs::read(place.path("lamp.bin")).unwrap(), image);
    let forced = place.cairn("rdpl lamp.src --force");
    forced.refused(1, &["R2001", "lamp.src:2:7", "did you mean `I0`?"]);
    assert!(!place.path("lamp.bin").exists(), "an image of the version before is left");
    assert!(place.path("lamp.lst").exists(), "the listing shows the errors");
}

#[test]
fn the_results_of_another_program_stay() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    place.write("lamp.rdpl", WRONG);
    place.cairn("rdpl lamp.src").fine();
    let all = || (fs::read(place.path("lamp.bin")).unwrap(), place.read("lamp.lst"));
    let before = all();
    place.cairn("rdpl lamp.rdpl").refused(2, &["lamp.bin", "exists already"]);
    place.cairn("rdpl lamp.rdpl --force").refused(2, &["lamp.src", "another program", "-o"]);
    assert_eq!(all(), before);
    // A listing that does not say whose it is, and none at all.
    let without = before.1.lines().filter(|line| !line.starts_with("Source: "));
    let without = without.collect::<Vec<_>>().join("\n") + "\n";
    place.write("lamp.lst", &without);
    place
        .cairn("rdpl lamp.src --force")
        .refused(2, &["lamp.bin", "no listing", "names its source"]);
    assert_eq!(all(), (before.0.clone(), without));
    fs::remove_file(place.path("lamp.lst")).unwrap();
    for source in ["lamp.src", "lamp.rdpl"] {
        let forced = place.cairn(&format!("rdpl {source} --force"));
        forced.refused(2, &["lamp.bin", "no listing", "remove it"]);
        assert_eq!(fs::read(place.path("lamp.bin")).unwrap(), before.0);
        assert!(!place.path("lamp.lst").exists());
    }
}

/// One name in two folders is two programs; which one a listing is of does not depend on how the path is spelt.
#[test]
fn programs_of_one_name_in_two_folders_do_not_replace_each_other() {
    let place = Place::new();
    for folder in ["a", "b", "out"] {
        fs::create_dir(place.path(folder)).unwrap();
    }
    place.write("a/x.rdpl", RIGHT);
    place.write("b/x.rdpl", "OR O1,I0,I2,0L,0L\n");
    place.cairn("rdpl a/x.rdpl -o out").fine();
    assert!(place.read("out/x.lst").ends_with("\nSource: ../a/x.rdpl\n"));
    let before = (fs::read(place.path("out/x.bin")).unwrap(), place.read("out/x.lst"));
    place.cairn("rdpl b/x.rdpl -o out --force").refused(2, &["../a/x.rdpl", "another program"]);
    assert_eq!((fs::read(place.path("out/x.bin")).unwrap(), place.read("out/x.lst")), before);
    place.cairn("rdpl ./b/../a/x.rdpl -o a/../out --force").fine();
    place.cairn("rdpl b/x.rdpl").fine();
    assert!(place.read("b/x.lst").ends_with("\nSource: x.rdpl\n"));
    place.cairn("rdpl b/x.rdpl --force").fine();
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    for with in ["--check", "--run 1"] {
        place.cairn(&format!("rdpl lamp.src {with} -o .")).refused(2, &["cannot be used with"]);
        place.cairn(&format!("rdpl lamp.src {with} --force")).refused(2, &["--force", "leave it"]);
        place.cairn(&format!("rdpl lamp.src {with} --force --gates lamp.svg")).fine();
    }
    place.piped("rdpl - --check", RIGHT).fine();
    place.piped("rdpl -", RIGHT).refused(2, &["standard input", "--check"]);
    for command in ["robot pioneer3dx --world doorbell", "pheromone-server trail.txt"] {
        place.cairn(&format!("{command} --baud 9600")).refused(2, &["--serial"]);
    }
}

#[test]
fn checking_writes_nothing() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    let run = place.cairn("rdpl lamp.src --check").fine();
    assert!(!run.out.contains("Image"), "{}", run.out);
    assert!(!place.path("lamp.bin").exists() && !place.path("lamp.lst").exists());
}

#[test]
fn json_is_one_object_without_colours() {
    let place = Place::new();
    place.write("lamp.src", WRONG);
    let run = place.cairn("rdpl lamp.src --check --format json");
    let object = run.json();
    assert_eq!((run.code, &object["errors"], &object["lines"]), (1, &1.into(), &2.into()));
    let problem = &object["diagnostics"][0];
    assert_eq!((&problem["code"], &problem["line"]), (&"R2001".into(), &2.into()));
    assert!(!place.cairn("rdpl lamp.src --check").err.contains('\u{1b}'), "colours in a pipe");
}

#[test]
fn gates_are_drawn() {
    let place = Place::new();
    let program = shipped("doorbell.rdpl");
    let run = place.cairn(&format!("rdpl {program} --check --gates doorbell.svg")).fine();
    assert!(run.out.contains("Gates: doorbell.svg"), "{}", run.out);
    let svg = place.read("doorbell.svg");
    assert!(svg.starts_with("<svg") && svg.contains("MOVE"), "{svg}");
    place.write("lamp.src", WRONG);
    place.cairn("rdpl lamp.src --check --gates lamp.svg").refused(1, &["R2001"]);
    assert!(!place.path("lamp.svg").exists());
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let place = Place::new();
    place.cairn("rdpl absent").refused(2, &["cannot read the program absent.src"]);
    place.write("lamp.src", RIGHT);
    place
        .cairn("rdpl lamp.src --output no/such")
        .refused(2, &["no/such/lamp", "cannot be written"]);
}

#[test]
fn every_code_is_explained() {
    let place = Place::new();
    let list = place.cairn("explain --format json").fine().json();
    let codes = list["codes"].as_array().unwrap();
    assert!(codes.len() > 30);
    let page = place.cairn("explain r2001").fine().out;
    assert!(page.starts_with("# R2001") && page.contains("## Right"), "{page}");
    let object = place.cairn("explain R2001 --format json").fine().json();
    assert_eq!(object["severity"], "error");
    place.cairn("explain R77").refused(2, &["R77", "cairn explain"]);
}

/// Two seconds into the program the bell rings; the MOVE goes out 15 s later and is done 10 s after that.
#[test]
fn a_program_is_run_alone() {
    let place = Place::new();
    fs::copy(shipped("doorbell.rdpl"), place.path("doorbell.rdpl")).unwrap();
    let options =
        "rdpl doorbell.rdpl --run 40 --points done=4 --move-takes 10 --watch I0,Y2,YTMR16,I4,O0";
    let run = |more: &[&str]| {
        let mut command = place.command();
        command.args(options.split_whitespace()).args(["--input", "2 I0=1; 2.5 I0=0"]).args(more);
        Place::ended(&mut command).fine()
    };
    let text = run(&[]).out;
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(rows[0][..6], ["time_s", "I0", "Y2", "YTMR16", "I4", "O0"]);
    // The whole trace, row by row as the guide prints it.
    let times: Vec<&str> = rows[1..9].iter().map_while(|row| row.first().copied()).collect();
    assert_eq!(times, ["0.00", "2.00", "2.50", "17.00", "27.00", "32.00", "40.00"]);
    assert_eq!(rows[2][..6], ["2.00", "1", "1", "1", "0", "0"]);
    let at = |time: &str| rows.iter().find(|row| row.first() == Some(&time)).unwrap().clone();
    assert_eq!(at("17.00")[6..], ["MOVE", "1", "to", "(5000,", "3500)", "mm,", "45", "deg"]);
    assert_eq!(
        (at("27.00")[4], at("27.00")[5], at("27.00")[6..].join(" ")),
        ("1", "1", "MOVE 1 is done".into())
    );
    assert_eq!(at("32.00")[5], "0", "the latch is held for 5 s");
    assert!(text.contains("the end: the outputs go to their fail-safe values"), "{text}");
    let object = run(&["--format", "json"]).json();
    assert_eq!((&object["moves"], &object["last_move"]), (&1.into(), &"done".into()));
    let news: Vec<String> = object["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| !row["news"].as_array().unwrap().is_empty())
        .map(|row| format!("{} {}", row["t_s"], row["news"][0].as_str().unwrap()))
        .collect();
    assert_eq!(news[..2], ["17.0 MOVE 1 to (5000, 3500) mm, 45 deg", "27.0 MOVE 1 is done"]);
    // Nothing is written.
    assert!(!place.path("doorbell.bin").exists() && !place.path("doorbell.lst").exists());
}

#[test]
fn three_errands_are_rehearsed_from_a_table() {
    let place = Place::new();
    fs::copy(shipped("errands.rdpl"), place.path("errands.rdpl")).unwrap();
    place
        .write("day.txt", "# the day\n2 I0=1\n3 I0=0\n20 done # the kitchen\n30 failed\n45 done\n");
    let options =
        "rdpl errands.rdpl --run 60 --points busy=6,done=4,failed=5 --watch STATUS --format json";
    let statuses = |object: &serde_json::Value| -> Vec<(f64, u64)> {
        let rows = object["rows"].as_array().unwrap().iter();
        let mut seen: Vec<(f64, u64)> = Vec::new();
        for row in rows {
            let status = row["values"]["STATUS"].as_u64().unwrap();
            if seen.last().is_none_or(|(_, last)| *last != status) {
                seen.push((row["t_s"].as_f64().unwrap(), status));
            }
        }
        seen
    };
    let expected = [(0.0, 0), (2.0, 1), (20.0, 2), (30.0, 3), (45.0, 4)];
    let from_file = place.cairn(&format!("{options} --inputs day.txt")).fine().json();
    assert_eq!(statuses(&from_file), expected);
    let mut command = place.command();
    command.args(options.split_whitespace()).args(["--inputs", "-"]);
    command.stdin(fs::File::open(place.path("day.txt")).unwrap());
    assert_eq!(Place::ended(&mut command).fine().json(), from_file, "from standard input");
}

#[test]
fn clock_log_watchdog_and_fail_safe_outputs_are_seen_on_the_bench() {
    let place = Place::new();
    fs::copy(shipped("night-watch.rdpl"), place.path("watch.rdpl")).unwrap();
    let mut command = place.command();
    command.args("rdpl watch.rdpl --run 20 --failsafe O2=on --watchdog 1 --format json".split(' '));
    command.args(["--clock", "2026-03-01 21:59:55"]);
    command.args(["--input", "6 I0=1; 7 stop; 10 run; 13 stall=5; 0 A0=20 A1=23"]);
    let object = Place::ended(&mut command).fine().json();
    assert_eq!(object["watchdog_resets"], 1);
    assert_eq!(object["clock"], "2026-03-01 22:00:15.00");
    let text = object.to_string();
    for words in ["EVENT 1: I0 at 2026-03-01 22:00:01", "R8004", "the program is stopped (QRUN 0)"]
    {
        assert!(text.contains(words), "`{words}` is missing in {text}");
    }
    let outputs_at = |t: f64| {
        let rows = object["rows"].as_array().unwrap();
        rows.iter().rfind(|row| row["t_s"].as_f64().unwrap() <= t).unwrap()["outputs"].clone()
    };
    assert_eq!([6.5, 8.0, 11.0].map(|t| outputs_at(t).as_u64().unwrap()), [0b011, 0b100, 0b010]);
}

#[test]
fn wrong_options_of_a_rehearsal_say_what_is_allowed() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    for (option, value, words) in [
        ("--input", "I0=1", "begins with a time in seconds"),
        ("--input", "1 I0=2", "I0 is 0 or 1"),
        ("--input", "1 O0=1", "O0 is no input"),
        ("--input", "1 A0=256", "A0 is 0 to 255"),
        ("--input", "1 I16=1", "the last one is I15"),
        ("--input", "1 I0=1; 2 jump", "entry 2, `2 jump`"),
        ("--points", "busy=16", "an input from 0 to 15"),
        ("--points", "busy=1,done=1", "an input of its own"),
        ("--points", "ready=1", "none of busy, done, failed and pulse"),
        ("--failsafe", "I0=on", "`I0` is no output"),
        ("--failsafe", "O0=dim", "off, on or hold"),
        ("--clock", "25:00", "07:30"),
        ("--watch", "Q1", "`Q1`"),
        ("--inputs", "absent.txt", "absent.txt"),
    ] {
        let mut command = place.command();
        command.args(["rdpl", "lamp.src", "--run", "1", option, value]);
        Place::ended(&mut command).refused(2, &[words]);
    }
    place.cairn("rdpl lamp.src --run=-1").refused(2, &["--run", "from 0 to 604800 s"]);
    place.cairn("rdpl lamp.src --watch all").refused(2, &["--run"]);
}

#[test]
fn files_that_are_no_programs_are_refused_and_nothing_is_touched() {
    let place = Place::new();
    fs::copy(shipped("doorbell.toml"), place.path("doorbell.toml")).unwrap();
    place.write("doorbell.bin", "an image that is somebody's");
    place.cairn("rdpl doorbell.toml").refused(2, &["doorbell.toml is a mission"]);
    place.cairn("rdpl doorbell.toml --force").refused(2, &["doorbell.toml is a mission"]);
    place.cairn("rdpl doorbell.bin").refused(2, &["is an image"]);
    assert_eq!(place.read("doorbell.bin"), "an image that is somebody's");
    assert!(!place.path("doorbell.lst").exists());
    let large = "AND O0,I0,1L,1L,1L ; so wide\n".repeat(700_000);
    assert!(large.len() > 20_000_000);
    place.write("large.rdpl", &large);
    place
        .cairn("rdpl large.rdpl --check")
        .refused(2, &["large.rdpl", "20.3 MB, at most 4194.3 kB are allowed"]);
}

/// Of four megabytes of errors, two hundred are shown with their lines, and nothing grows with the text.
#[test]
fn problems_of_a_large_text_are_printed_in_little() {
    let place = Place::new();
    place.write("bad.rdpl", &"QQQQ ZZZZ,RRRR\n".repeat(270_000));
    let run = place.cairn("rdpl bad.rdpl --check");
    assert_eq!(run.code, 1);
    assert!(run.err.len() < 200_000, "{} bytes of messages", run.err.len());
    assert!(run.err.contains("bad.rdpl:200:1") && run.err.contains("269800 further problems"));
    place.write("long.rdpl", &format!("{}AND", "x".repeat(1_000_000)));
    let run = place.cairn("rdpl long.rdpl --check");
    assert!(run.code == 1 && run.err.len() < 4000, "{} bytes", run.err.len());
}

#[test]
fn the_cases_of_other_editors_are_read_or_named() {
    let place = Place::new();
    let case = |name: &str| {
        let folder =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../decision/tests/cases");
        fs::copy(folder.join(name), place.path(name)).unwrap();
        place.cairn(&format!("rdpl {name}")).fine()
    };
    for name in ["bom.rdpl", "cr-only.rdpl"] {
        let run = case(name);
        assert!(run.err.is_empty() && run.out.contains("2 functions"), "{name}: {}", run.err);
    }
    assert!(case("latin1.rdpl").err.contains("latin1.rdpl:1:1"));
    let twice = case("sixth-operand.rdpl").err;
    assert!(
        twice.contains("sixth-operand.rdpl:1:20") && twice.contains("sixth-operand.rdpl:2:20"),
        "{twice}"
    );
}

#[test]
fn the_help_lists_every_function_of_the_language() {
    let help = Place::new().cairn("rdpl --help").fine().out;
    for function in decision::Mnemonic::ALL {
        let line = help.lines().find(|line| line.trim_start().starts_with(&function.syntax()));
        assert!(line.is_some_and(|line| line.ends_with(function.about())), "{function}:\n{help}");
    }
}
