//! What is accepted is obeyed: keys that nothing would read are refused or warned of, and what cannot be run is
//! refused when it is checked.

use missions::{Mission, Run, can_start};
use run_context::RunSeed;

const HEAD: &str = "[mission]\nname = \"t\"\nduration_max_s = 30.0\n[world]\nbounds_m = [-10.0, -10.0, 10.0, 10.0]\n\
                    [[robots]]\nname = \"robot\"\n";
const DIRECT: &str = "[robots.mind]\nhow.method = \"straight\"\n";
const GOAL: &str =
    "[[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"robot\"\npose = [6.0, 0.0, 0.0]\n";
const ARRIVED: &str = "[[success.arrived]]\nrobot = \"robot\"\npose = [6.0, 0.0, 0.0]\n";

fn error(text: &str) -> String {
    match Mission::parse("t.toml", text, &[]) {
        Ok(mission) => format!("accepted: {}", mission.name()),
        Err(error) => error.to_string(),
    }
}

fn warnings(text: &str) -> String {
    match Mission::parse("t.toml", text, &[]) {
        Ok(mission) => mission.warnings().join("\n"),
        Err(error) => format!("refused: {error}"),
    }
}

#[test]
fn keys_of_another_kind_of_event_are_refused() {
    for (line, key) in [
        ("direction = \"from_robot\"", "direction"),
        ("for_s = 3.0", "for_s"),
        ("size_m = 0.4", "size_m"),
        ("at_m = [1.0, 1.0]", "at_m"),
        ("thing = \"x\"", "thing"),
        ("device = \"bell\"", "device"),
        ("line = \"robot\"", "line"),
    ] {
        let said = error(&format!("{HEAD}{DIRECT}{GOAL}{line}\n{ARRIVED}"));
        assert!(said.starts_with("t.toml:15:"), "{said}");
        assert!(said.contains(&format!("events[0].{key} = ")), "{said}");
        assert!(said.contains("must be absent: `goal` takes robot, pose"), "{said}");
    }
    // The kinds take the keys that the guide gives them, and no others.
    for (kind, key) in [
        ("stop", "pose = [1.0, 0.0, 0.0]"),
        ("restart", "line = \"robot\""),
        ("cut_line", "after_arrival = true"),
        ("place_box", "robot = \"robot\""),
        ("remove", "at_m = [0.0, 1.0]"),
    ] {
        let said = error(&format!("{HEAD}{DIRECT}[[events]]\ndo = \"{kind}\"\n{key}\n"));
        assert!(said.contains(&format!("absent: `{kind}` takes")), "{said}");
    }
}

#[test]
fn what_is_about_a_program_needs_one() {
    for kind in ["stop_program", "run_program", "stall_program"] {
        let said = error(&format!("{HEAD}{DIRECT}[[events]]\ndo = \"{kind}\"\n"));
        assert!(said.contains("events[0].do") && said.contains("[decision]"), "{said}");
    }
    for count in ["moves_sent", "events_logged", "watchdog_resets"] {
        let said = error(&format!("{HEAD}{DIRECT}[success]\n{count} = 1\n"));
        assert!(said.contains(&format!("success.{count} = 1")) && said.contains("[decision]"));
    }
    let program = "[decision]\nprogram = \"AND O0,I0,1L,1L,1L\"\n";
    let said = warnings(&format!("{HEAD}{DIRECT}{program}[success]\nmoves_sent = 1\n"));
    assert!(said.contains("the decision program has no MOVE"), "{said}");
}

#[test]
fn keys_that_nothing_reads_are_warned_of() {
    let link = "[robots.line]\nkind = \"direct\"\nbaud = 1200\nloss_prob = 0.5\n";
    let memory = "[robots.line]\naddress = \"1.2.3.4:80\"\n";
    let path = "how.path_m = [[0.0, 0.0], [6.0, 0.0]]\nfollow.path_law = \"pure_pursuit\"\n";
    let on_path = "[robots.mind]\nhow.method = \"path\"\nhow.path_m = [[0.0, 0.0], [6.0, 0.0]]\n";
    let server = "[pheromones]\ntrails_m = [[[0.0, 0.0], [3.0, 0.0]]]\n";
    let on_trail = "[robots.mind]\nfollow.trail_law = \"pure_pursuit\"\n[robots.mind.follow.fuzzy]\nerror_full = 9\n";
    for (middle, told) in [
        (format!("{link}{DIRECT}"), "robots[0].line: baud, loss_prob do nothing"),
        (format!("{memory}{DIRECT}"), "robots[0].line: address does nothing"),
        (format!("{DIRECT}{path}"), "robots[0].mind: how.path_m does nothing"),
        (format!("{DIRECT}{path}"), "robots[0].mind: follow.path_law does nothing"),
        (
            format!("{on_path}follow.trail_law = \"listing\"\n"),
            "robots[0].mind: follow.trail_law does nothing",
        ),
        (format!("{on_trail}{server}"), "robots[0].mind: follow.fuzzy does nothing"),
        (format!("{DIRECT}{server}"), "[pheromones]: nobody asks the server"),
        (format!("spacing_m = [3.0, 3.0]\n{DIRECT}"), "robots[0]: spacing_m does nothing"),
    ] {
        let said = warnings(&format!("{HEAD}{middle}{GOAL}{ARRIVED}"));
        assert!(said.contains(told), "{told}: {said}");
    }
    // None of them where they are read.
    let on_map = "[robots.mind]\nhow.method = \"map\"\nfollow.path_law = \"pure_pursuit\"\n[[world.walls]]\nline_m = [[0.0, 9.0], [9.0, 9.0]]\n";
    for middle in [
        format!("{on_path}follow.path_law = \"pure_pursuit\"\n"),
        on_map.to_owned(),
        DIRECT.to_owned(),
    ] {
        assert_eq!(warnings(&format!("{HEAD}{middle}{GOAL}{ARRIVED}")), "");
    }
}

#[test]
fn what_cannot_come_true_is_warned_of() {
    let late = warnings(&format!("{HEAD}{DIRECT}{GOAL}{ARRIVED}by_s = 100.0\n"));
    assert!(late.contains("success.arrived[0].by_s = 100: the mission ends before"), "{late}");
    let elsewhere = ARRIVED.replace("6.0", "7.0");
    let said = warnings(&format!("{HEAD}{DIRECT}{GOAL}{elsewhere}"));
    assert!(said.contains("success.arrived[0] of `robot`: no event"), "{said}");
    let said = warnings(&format!("{HEAD}{DIRECT}{GOAL}after_arrival = true\n{ARRIVED}"));
    assert!(said.contains("the first goal of `robot` has after_arrival"), "{said}");
}

#[test]
fn the_shipped_missions_have_no_key_that_does_nothing() {
    for name in Mission::shipped() {
        let mission = Mission::load(name, &[]).unwrap();
        for warning in mission.warnings() {
            assert!(!warning.contains("nothing, because"), "{name}: {warning}");
            assert!(!warning.contains("cannot be met"), "{name}: {warning}");
            assert!(!warning.contains("nobody asks"), "{name}: {warning}");
        }
        // The resolved text, in which every key is written, has the same.
        let resolved = Mission::parse(name, &mission.to_toml(), &[]).unwrap();
        assert_eq!(resolved.warnings(), mission.warnings(), "{name}");
    }
}

#[test]
fn who_stands_in_another_is_refused_with_the_line() {
    let person = "[[world.people]]\nname = \"a\"\nroute_m = [[0.0, 0.0]]\n";
    let said = error(&format!("{HEAD}{DIRECT}{person}"));
    assert!(said.starts_with("t.toml:6:1: robots[0].start = [0.0, 0.0, 0.0]"), "{said}");
    assert!(said.contains("does not touch the person `a`"), "{said}");
    let apart = person.replace("[[0.0, 0.0]]", "[[0.0, -0.6]]");
    assert!(Mission::parse("t.toml", &format!("{HEAD}{DIRECT}{apart}"), &[]).is_ok());
    let two = |y_m: f64| {
        format!("{HEAD}{DIRECT}[[robots]]\nname = \"bert\"\nstart = [0.1, {y_m}, 180.0]\n{DIRECT}")
    };
    let said = error(&two(0.1));
    assert!(said.starts_with("t.toml:12:9: robots[1].start"), "{said}");
    assert!(said.contains("`bert` does not touch the robot `robot`"), "{said}");
    assert!(Mission::parse("t.toml", &two(-0.8), &[]).is_ok());
    let thing = "[[world.things]]\nname = \"t\"\nat_m = [0.0, 2.0]\n";
    let inside = person.replace("[[0.0, 0.0]]", "[[0.0, 2.0]]");
    let said = error(&format!("{HEAD}{DIRECT}{thing}{inside}"));
    assert!(
        said.contains("world.people[0].route_m[0]") && said.starts_with("t.toml:15:"),
        "{said}"
    );
}

#[test]
fn boxes_without_a_place_are_refused_by_the_check_as_by_the_run() {
    let boxes =
        "[[world.random_boxes]]\nname = \"b\"\ncount = 1000\narea_m = [0.0, 0.0, 1.0, 1.0]\n";
    let mission = Mission::parse("t.toml", &format!("{HEAD}{DIRECT}{boxes}"), &[]).unwrap();
    let said = can_start(&mission, RunSeed(1)).unwrap_err().to_string();
    assert!(said.starts_with("t.toml:12:9: world.random_boxes[0].count = 1000"), "{said}");
    assert_eq!(Run::new(mission, RunSeed(1)).unwrap_err().to_string(), said);
    let far = format!(
        "{HEAD}start = [40.0, 0.0, 0.0]\n{DIRECT}[[world.walls]]\nline_m = [[-5.0, -5.0], [5.0, 5.0]]\n"
    );
    let mission = Mission::parse("t.toml", &far, &[]).unwrap();
    let said = can_start(&mission, RunSeed(1)).unwrap_err().to_string();
    assert!(said.starts_with("t.toml:8:9: robots[0].start: the world cannot be built"), "{said}");
}

/// Two MOVE in one scan: one is sent, and one is counted.
const TWO_MOVES: &str = "[[devices]]\nname = \"b\"\ninput = 0\n[decision]\nrobot = \"robot\"\nprogram = \"\"\"\n\
    MOVE I0,1000,0,0,RISE\nMOVE I0,2000,0,0,RISE\n\"\"\"\n[[events]]\nat_s = 1.0\ndo = \"press\"\ndevice = \"b\"\n";

#[test]
fn a_move_that_another_replaces_is_not_counted_as_sent() {
    let text = format!(
        "{HEAD}{DIRECT}{TWO_MOVES}[success]\nmoves_sent = 1\n[[success.arrived]]\nrobot = \"robot\"\npose = [2.0, 0.0, 0.0]\n"
    );
    let mission = Mission::parse("t.toml", &text, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    assert!(run.run_to_end().passed, "{:?}", run.finished());
    assert_eq!(run.summary().figure("moves_sent"), Some(1.0));
}

#[test]
fn a_watchdog_restart_ends_the_old_move_before_the_new_program_sends_its_own() {
    let text = format!(
        "{HEAD}{DIRECT}{TWO_MOVES}[[events]]\nat_s = 3.0\ndo = \"stall_program\"\nfor_s = 5.0\n\
         [[success.arrived]]\nrobot = \"robot\"\npose = [2.0, 0.0, 0.0]\n"
    );
    let mission = Mission::parse("t.toml", &text, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    let passed = run.run_to_end().passed;
    let log: Vec<String> = run.drain_log().into_iter().map(|item| item.text).collect();
    let at = |word: &str| log.iter().position(|text| text.contains(word)).unwrap();
    let told = log.join("\n");
    assert!(at("the watchdog restarts") < at("told to stop with the program"), "{told}");
    assert!(at("told to stop with the program") < at("MOVE 4 to"), "{told}");
    assert!(!told.contains("MOVE 4 is failed") && passed, "{told}");
    assert_eq!(run.summary().figure("moves_sent"), Some(2.0));
}

#[test]
fn an_empty_world_has_no_surface() {
    let text = format!("{HEAD}{DIRECT}{GOAL}[success]\nclearance_min_m = 0.05\n");
    let mut run = Run::new(Mission::parse("t.toml", &text, &[]).unwrap(), RunSeed(1)).unwrap();
    let check = run.run_to_end().checks[0].clone();
    assert!(check.passed && check.text == "no surface within 5 m (at least 0.05 m)", "{check:?}");
}

#[test]
fn a_robot_with_a_path_follows_no_trail() {
    let path = "[robots.mind]\nhow.method = \"path\"\nhow.path_m = [[0.0, 0.0], [6.0, 0.0]]\n";
    let text = format!("{HEAD}{path}{GOAL}{ARRIVED}");
    let mut run = Run::new(Mission::parse("t.toml", &text, &[]).unwrap(), RunSeed(1)).unwrap();
    run.run_to_end();
    let log: Vec<String> = run.drain_log().into_iter().map(|item| item.text).collect();
    let told = log.join("\n");
    assert!(told.contains("following its path") && !told.contains("trail"), "{told}");
}
