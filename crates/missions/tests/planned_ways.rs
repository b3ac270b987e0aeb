//! Robots that plan their ways on the map of their world.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use missions::{Mission, Run};
use run_context::RunSeed;

/// Two rooms of 3 × 4 m with a door of 1 m at the far end of the wall between them, and a table.
const MISSION: &str = r#"
[mission]
name = "rooms"
duration_max_s = 150.0
[[world.walls]]
line_m = [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [0.0, 4.0]]
closed = true
[[world.walls]]
line_m = [[3.0, 0.0], [3.0, 3.0]]
[[world.things]]
name = "table"
at_m = [4.6, 2.4]
size_m = [0.8, 0.6]
[[robots]]
name = "r"
model = "pioneer3dx"
start = [1.0, 1.0, 0.0]
[robots.mind]
how.method = "map"
[[events]]
at_s = 1.0
do = "goal"
robot = "r"
pose = [5.0, 1.0, 180.0]
[success]
no_contact = true
"#;

const ARRIVED: &str = "[[success.arrived]]\nrobot = \"r\"\npose = [5.0, 1.0, 180.0]\n";

fn gave_up(reason: &str) -> String {
    format!("[[success.gave_up]]\nrobot = \"r\"\nreason = \"{reason}\"\n")
}

fn run(text: &str, seed: u64) -> (bool, String, f64) {
    let mission = Mission::parse("rooms.toml", text, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(seed)).unwrap();
    let verdict = run.run_to_end().clone();
    (verdict.passed, verdict.text, run.summary().figure("path_length_m").unwrap_or(0.0))
}

/// Straight it would be 4 m, through the wall: by the door, and around the table, it is more than 6.
#[test]
fn the_way_leads_through_the_door_whatever_the_seed() {
    for seed in 1..5 {
        let (passed, text, way_m) = run(&format!("{MISSION}{ARRIVED}"), seed);
        assert!(passed, "seed {seed}: {text}");
        assert!((6.0..11.0).contains(&way_m), "seed {seed}: {way_m} m");
    }
}

#[test]
fn why_there_is_no_way_is_the_reason_for_giving_up() {
    let to = |pose: &str, reason: &str| {
        let text = MISSION.replace("pose = [5.0, 1.0, 180.0]", pose) + &gave_up(reason);
        run(&text, 1)
    };
    // In the table, in a wall, outside.
    for pose in ["pose = [4.6, 2.4, 0.0]", "pose = [3.0, 1.0, 0.0]", "pose = [9.0, 1.0, 0.0]"] {
        let (passed, text, way_m) = to(pose, "goal_blocked");
        assert!(passed && way_m < 0.01, "{pose}: {text}");
    }
    let closed = MISSION.replace("[3.0, 3.0]]", "[3.0, 4.0]]") + &gave_up("no_way");
    let (passed, text, _) = run(&closed, 1);
    assert!(passed, "{text}");
}

/// A box that no map knows closes the door: the robot waits, looks for other ways, touches nothing, and gives up.
#[test]
fn a_way_that_is_closed_by_something_unknown_is_given_up_in_words() {
    let boxed = "[[events]]\nat_s = 2.0\ndo = \"place_box\"\nat_m = [3.0, 3.5]\nsize_m = 0.9\n";
    let text = format!("{}{boxed}{}", MISSION.replace("150.0", "400.0"), gave_up(""));
    let (passed, text, _) = run(&text, 1);
    assert!(passed, "{text}");
}

/// A box that no map knows closes the near one of two doors: the way through the far one is planned, around what was heard.
#[test]
fn another_way_is_planned_around_what_no_map_knows() {
    let rooms = MISSION
        .replace("[6.0, 4.0], [0.0, 4.0]", "[6.0, 6.0], [0.0, 6.0]")
        .replace("line_m = [[3.0, 0.0], [3.0, 3.0]]", "line_m = [[3.0, 0.0], [3.0, 1.0]]")
        .replace("[[world.things]]\nname = \"table\"\nat_m = [4.6, 2.4]\nsize_m = [0.8, 0.6]\n", "[[world.walls]]\nline_m = [[3.0, 2.0], [3.0, 4.4]]\n[[world.walls]]\nline_m = [[3.0, 5.6], [3.0, 6.0]]\n")
        .replace("start = [1.0, 1.0, 0.0]", "start = [1.0, 1.5, 0.0]")
        .replace("duration_max_s = 150.0", "duration_max_s = 300.0");
    let boxed = "[[events]]\nat_s = 2.0\ndo = \"place_box\"\nat_m = [3.1, 1.5]\nsize_m = 0.9\n";
    let (free, text, near_m) = run(&format!("{rooms}{ARRIVED}"), 1);
    assert!(free && near_m < 5.0, "{text} {near_m}");
    for seed in 1..4 {
        let (passed, text, way_m) = run(&format!("{rooms}{boxed}{ARRIVED}"), seed);
        println!("{seed} {passed} {text} {way_m}");
        assert!(passed && way_m > 8.0, "seed {seed}: {text} {way_m}");
    }
}
