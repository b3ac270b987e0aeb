//! What somebody meets in the first hour: slips of the finger, wrong files, runs that fail, pipes and shells.

mod support;

use serde_json::Value;
use support::{Place, short_drive};

#[test]
fn who_forgets_the_subcommand_is_told_it() {
    let place = Place::new();
    for (word, meant) in [
        ("doorbell", "cairn run doorbell"),
        ("dorbell", "cairn run doorbell"),
        ("my-flat.toml", "cairn run my-flat.toml"),
        ("out.mcap", "cairn replay out.mcap"),
        ("bell.rdpl", "cairn rdpl bell.rdpl"),
        ("intel.g2o", "cairn graph intel.g2o"),
        ("log.clf.gz", "cairn map log.clf.gz"),
        ("mission", "cairn missions"),
        ("rn", "cairn run"),
    ] {
        place.cairn(word).refused(2, &[&format!("`{word}`"), &format!("did you mean `{meant}`?")]);
    }
    let other = place.cairn("xyzzy");
    other.refused(2, &["`xyzzy`", "cairn --help"]);
    assert!(!other.err.contains("did you mean"), "{}", other.err);
}

#[test]
fn a_slip_in_a_name_gets_a_suggestion() {
    let place = Place::new();
    place.cairn("run dorbell --headless").refused(2, &["`dorbell`", "did you mean `doorbell`?"]);
    place.cairn("missions swarn").refused(2, &["`swarn`", "did you mean `swarm`?"]);
    let run = |set: &str| place.cairn(&format!("run doorbell --headless --set {set}"));
    run("robots.mind.follow.sped_mps=0.2").refused(2, &["did you mean `speed_mps`?"]);
    run("robots.mind.how.method=trial").refused(2, &["did you mean `trail`?"]);
    run("seed=3").refused(2, &["--set seed=3", "did you mean `mission.seed`?"]);
    run("robots.speed=3").refused(2, &["did you mean `robots.mind.follow.speed_mps`?"]);
    run("colour.x=3").refused(2, &["unknown field `colour`", "expected one of"]);
    place.write("a.rdpl", "AND O0,I0,1L,1L,1L\n");
    place
        .cairn("rdpl a.rdpl --run 1 --points doen=4")
        .refused(2, &["`doen`", "did you mean `done`?"]);
    place.cairn("map a.mat --ring fivee").refused(2, &["did you mean five?"]);
    place.cairn("map a.mat --ring five").refused(2, &["a.mat"]);
    place.write("slip.toml", &short_drive(0.3).replace("duration_max_s", "duration_maxs"));
    place
        .cairn("check slip.toml")
        .refused(2, &["slip.toml", "line", "did you mean `duration_max_s`?"]);
}

#[test]
fn an_error_names_the_file_and_the_line_that_is_wrong() {
    let place = Place::new();
    let mission =
        "[mission]\nname = \"own\"\n[decision]\nprogram_file = \"own.rdpl\"\nrobot = \"\"\n";
    place.write("own.toml", mission);
    place.cairn("check own.toml").refused(2, &["own.toml:4:", "program_file", "own.rdpl"]);
    place.write("own.rdpl", "; fine\nAND O0,I0,1L,1L,1L\nNAD O1,I0,1L,1L,1L\n");
    place.cairn("check own.toml").refused(2, &["own.rdpl:3:", "NAD"]);
    place.write("own.toml", "[mission]\nname = \"own\"\n[world]\nmap = \"own.map\"\n");
    place.write("own.map", "no map at all\n");
    place.cairn("check own.toml").refused(2, &["own.map:1:", "no map at all"]);
}

#[test]
fn another_sort_of_file_is_named_with_who_takes_it() {
    let place = Place::new();
    place.write("own.toml", &short_drive(0.3));
    place.write("typo.rdpl", "ADN O0,I0,1L,1L,1L\n");
    place.write("old.toml", &short_drive(0.3).replace('\n', "\r"));
    let wide: Vec<u8> = short_drive(0.3).encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(place.path("wide.toml"), wide).unwrap();
    std::fs::write(place.path("out.mcap.gz"), b"\x1f\x8b\x08\x00\xff\xff").unwrap();
    std::fs::write(place.path("out.mcap"), b"\x89MCAP0\r\n\xff").unwrap();
    for (arguments, word) in [
        ("check typo.rdpl", "`cairn rdpl`"),
        ("robot pioneer3dx --world typo.rdpl", "`cairn rdpl`"),
        ("run out.mcap --headless", "`cairn replay`"),
        ("run out.mcap.gz --headless", "gunzip"),
        ("check wide.toml", "UTF-16"),
        ("check old.toml", "carriage return"),
        ("replay out.mcap.gz --headless", "gunzip"),
        ("replay own.toml --headless", "`cairn run`"),
        ("graph own.toml", "`cairn run`"),
        ("graph typo.rdpl", "`cairn rdpl`"),
        ("map own.toml", "`cairn run`"),
        ("rdpl out.mcap.gz --check", "gunzip"),
    ] {
        let ended = place.cairn(arguments);
        ended.refused(2, &[word]);
        assert!(ended.err.len() < 400 && !ended.err.contains("damaged"), "{}", ended.err);
    }
    std::fs::copy(place.path("own.toml"), place.path("own.rdpl")).unwrap();
    place.cairn("rdpl own.rdpl --check").refused(2, &["a mission", "`cairn run`"]);
    place.piped("check -", "AND O0,I0,1L,1L,1L\n").refused(2, &["standard input", "`cairn rdpl`"]);
    place
        .cairn("rdpl doorbell.rdpl --check")
        .refused(2, &["cairn missions doorbell.rdpl > doorbell.rdpl"]);
    place.write("no.toml", "[mission]\nname = \"own\"\n[decision]\nprogram_file = \"no.src\"\n");
    place.cairn("check no.toml").refused(2, &["no.toml:4:", "the decision program no.src"]);
}

/// Whoever closes the ears of a program gets its exit code still; what could not be printed is no success.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_either_output_is_no_panic() {
    let place = Place::new();
    place.write("odd.rdpl", "AND O0,I0,1L,1L,1L\nAND O0,I1,1L,1L,1L\n");
    place.write("bad.rdpl", "AND O0,I0\n");
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let code = |arguments: &str, to_err: bool| {
        let mut command = place.command();
        command.args(arguments.split_whitespace());
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        if to_err {
            command.stderr(full())
        } else {
            command.stdout(full())
        };
        command.status().unwrap().code()
    };
    assert_eq!(code("rdpl odd.rdpl --check", true), Some(0));
    assert_eq!(code("rdpl bad.rdpl --check", true), Some(1));
    assert_eq!(code("run nosuch --headless", true), Some(2));
    assert_eq!(code("--nosuch", true), Some(2));
    for arguments in ["--help", "--version", "run --help", "missions"] {
        assert_eq!(code(arguments, false), Some(2), "{arguments}");
    }
}

#[test]
fn a_mission_is_checked_without_being_run() {
    let place = Place::new();
    for name in ["doorbell", "swarm", "decision-rig", "path-slalom"] {
        let check = place.cairn(&format!("check {name} --format json")).fine().json();
        assert_eq!(check["mission"], name);
        assert_eq!(check["warnings"], Value::Array(Vec::new()), "{name}");
    }
    assert_eq!(
        place.cairn("check swarm --format json").json()["robots"].as_array().unwrap().len(),
        1000
    );
    let text = place.cairn("check doorbell").fine().out;
    assert!(text.contains("1 pioneer3dx") && text.contains("It can be run."), "{text}");
    place.cairn("check nosuch").refused(2, &["nosuch"]);
    place.cairn("check doorbell --set robots.start=[5.7,-2.9,0]").refused(2, &["start", "counter"]);
    // What a run would refuse, the check does.
    let too_far = ["robots[0].start", "the walls reach"];
    place.cairn("check doorbell --set robots.start=[100,100,0]").refused(2, &too_far);
    let far = place.cairn("check doorbell --set robots.start=[7.5,0,0]").fine().out;
    assert!(far.contains("robots[0].start") && far.contains("world.bounds_m"), "{far}");
}

#[test]
fn a_mission_that_asks_for_nothing_or_too_late_is_warned_about() {
    let place = Place::new();
    let text = "[mission]\nname = \"own\"\nduration_max_s = 2.0\n[[robots]]\nname = \"r\"\n\
        mind.how.method = \"straight\"\n[[events]]\nat_s = 5.0\ndo = \"goal\"\nrobot = \"r\"\npose = [1.0, 0.0, 0.0]\n\
        [[events]]\nat_s = 1.0\ndo = \"place_box\"\nthing = \"parcel\"\nat_m = [3.0, 0.0]\n\
        [[events]]\nat_s = 1.5\ndo = \"remove\"\nthing = \"parcle\"\n";
    place.write("own.toml", text);
    let said = place.cairn("check own.toml").fine().out;
    for part in [
        "asks for nothing",
        "events[0].at_s = 5",
        "never happens",
        "did you mean `parcel`?",
        "3 warnings",
    ] {
        assert!(said.contains(part), "`{part}` is missing in: {said}");
    }
    let run = place.cairn("run own.toml --headless").fine();
    assert!(run.err.contains("warning: own.toml: [success]"), "{}", run.err);
    assert!(run.out.contains("asks for nothing"), "{}", run.out);
    let never = format!(
        "{}[[success.arrived]]\nrobot = \"r\"\npose = [1.0, 0.0, 0.0]\n",
        text.split("[[events]]").next().unwrap()
    );
    place.write("never.toml", &never);
    let said = place.cairn("check never.toml").fine().out;
    assert!(said.contains("nothing sends it anywhere") && said.contains("1 warning."), "{said}");
}

#[test]
fn a_run_says_why_it_failed_and_which_robot() {
    let place = Place::new();
    // A wall stands between start and goal, and closes the room.
    let text = "[mission]\nname = \"walled\"\nduration_max_s = 60.0\n[[world.walls]]\n\
        line_m = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]\nclosed = true\n[[robots]]\nname = \"hetty\"\n\
        mind.how.method = \"straight\"\n[[events]]\nat_s = 0.5\ndo = \"goal\"\nrobot = \"hetty\"\npose = [3.0, 0.0, 0.0]\n\
        [[success.arrived]]\nrobot = \"hetty\"\npose = [3.0, 0.0, 0.0]\n";
    place.write("walled.toml", text);
    let run = place.cairn("run walled.toml --headless --verbose");
    assert_eq!(run.code, 1, "{}", run.out);
    let first = run.out.lines().next().unwrap();
    assert!(
        first.contains("FAILED: arrived: hetty:") && first.contains("from the goal"),
        "{first}"
    );
    assert!(run.err.contains("goal for hetty") && run.err.contains(" s  info"), "{}", run.err);
    let json = place.cairn("run walled.toml --headless --verbose --format json").json();
    let events = json["events"].as_array().unwrap();
    assert!(events.iter().any(|e| e["text"].as_str().unwrap().contains("hetty")), "{json}");
    let silent = place.cairn("run walled.toml --headless --quiet");
    assert_eq!((silent.code, silent.out.as_str(), silent.err.as_str()), (1, "", ""));
    place.cairn("run walled.toml --headless --quiet --verbose").refused(2, &["--verbose"]);
}

#[test]
fn a_dash_is_standard_input() {
    let place = Place::new();
    let drive = short_drive(0.3);
    let run = place.piped("run - --headless", &drive).fine();
    assert!(run.out.contains("short-drive (seed 5): passed"), "{}", run.out);
    place.piped("check -", &drive).fine();
    place.piped("check -", "[mission]\nnam = \"x\"\n").refused(2, &["standard input", "line 2"]);
    let graph = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
    assert!(place.piped("graph -", graph).fine().out.contains("2 vertices"));
}

#[test]
fn shells_get_their_completions() {
    let place = Place::new();
    for (shell, mark) in
        [("bash", "complete -F"), ("zsh", "#compdef cairn"), ("fish", "complete -c cairn")]
    {
        let script = place.cairn(&format!("completions {shell}")).fine().out;
        assert!(script.contains(mark) && script.contains("headless"), "{shell}");
    }
    place.cairn("completions tcsh").refused(2, &["tcsh", "fish"]);
}

#[test]
fn an_option_that_would_change_nothing_is_refused() {
    let place = Place::new();
    place.cairn("run artemic-e1 --headless --record e1.mcap").fine();
    place
        .cairn("map e1.mcap --set map.resolution_m=0.2")
        .refused(2, &["map.resolution_m", "sonar.resolution_m"]);
    place
        .cairn("map e1.mcap --mode thesis --set map.resolution_m=0.2")
        .refused(2, &["pose_scale_m"]);
    place
        .cairn("map e1.mcap --method odometry --mode thesis")
        .refused(2, &["survey.mode", "sonar method"]);
    place
        .cairn("map e1.mcap --set laser.loops.radius_m=3")
        .refused(2, &["laser.loops.radius_m", "[sonar]"]);
    assert!(!place.path("e1-map").exists(), "a refusal comes before anything is written");
}

#[test]
fn one_thing_has_one_spelling() {
    let place = Place::new();
    let help = place.cairn("pheromone-server --help").fine().out;
    assert!(help.contains("scalar_sum") && help.contains("vector_atan2"), "{help}");
    let json = place.cairn("missions doorbell --format json").fine().json();
    assert_eq!(json["toml"], place.cairn("missions doorbell").fine().out);
    let seed =
        place.cairn("run decision-rig --headless --format json --set mission.seed=77").json();
    assert_eq!(seed["seed"], 77);
}

#[test]
fn colours_are_not_forced_on_anybody() {
    let place = Place::new();
    place.write("bad.rdpl", "NAD O1,I0,1L,1L,1L\n");
    for (name, value) in [("NO_COLOR", "1"), ("TERM", "dumb")] {
        let mut command = place.command();
        command.env(name, value).args(["rdpl", "bad.rdpl", "--check"]);
        let said = Place::ended(&mut command);
        assert!(said.code == 1 && !said.err.contains('\u{1b}'), "{}", said.err);
    }
}

/// What would have happened with another seed: the run goes on with that one, and says so.
#[test]
fn a_replay_with_another_seed_runs_with_it() {
    let place = Place::new();
    place.cairn("run one-obstacle --headless --seed 2 --record a.mcap").fine();
    let same = place.cairn("replay a.mcap --headless");
    assert_eq!(same.code, 0, "{}", same.err);
    assert!(format!("{}{}", same.out, same.err).contains("seed 2"), "{}", same.out);
    let other = place.cairn("replay a.mcap --headless --set mission.seed=3");
    assert!(format!("{}{}", other.out, other.err).contains("seed 3"), "{}", other.out);
}

/// An option that would do nothing is refused with the reason.
#[test]
fn a_robot_is_not_chosen_in_a_log_that_names_none() {
    let place = Place::new();
    place.write("log.clf", "FLASER 2 1.5 2.5 0 0 0 0 0 0 10.25 host 10.25\n");
    place.cairn("map log.clf --robot x").refused(2, &["--robot"]);
}
