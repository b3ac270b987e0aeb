//! Mission files: what is accepted, what is refused and how it is said, and the template.

use expect_test::{Expect, expect, expect_file};
use missions::{Mission, WordList, file::MissionFile};

/// A mission with one robot, one bell and one trail, to which a test adds or changes lines.
const SMALL: &str = r#"[mission]
name = "small"

[world]
[[world.walls]]
line_m = [[2.0, -2.0], [2.0, 2.0]]

[[devices]]
name = "bell"
input = 0

[[robots]]
[robots.mind]
how.method = "straight"
"#;

fn check(text: &str, overrides: &[&str], expected: &Expect) {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let said = match Mission::parse("small.toml", text, &overrides) {
        Ok(mission) => format!("accepted: {}", mission.name()),
        Err(error) => error.to_string(),
    };
    expected.assert_eq(&said);
}

fn check_added(lines: &str, expected: &Expect) {
    check(&format!("{SMALL}{lines}"), &[], expected);
}

#[test]
fn a_goal_that_the_link_cannot_carry_is_refused() {
    let goal =
        "[[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"robot\"\npose = [33.0, 0.0, 0.0]\n";
    check_added(
        goal,
        &expect![
            "small.toml:19:8: events[0].pose = a goal farther away: must be within 32 m of the origin, because the link carries millimetres in 16 bits"
        ],
    );
    let nearer = goal.replace("33.0", "-31.9");
    check_added(&nearer, &expect!["accepted: small"]);
    check(&format!("{SMALL}{goal}"), &["robots.line.kind=direct"], &expect!["accepted: small"]);
}

#[test]
fn random_boxes_have_names_of_their_own() {
    let boxes = "[[world.random_boxes]]\narea_m = [-1.0, -1.0, 1.0, 1.0]\n";
    check_added(
        &format!("{boxes}{boxes}"),
        &expect![[
            r#"small.toml:17:1: world.random_boxes[1].name = "box": must be a name of its own; world.random_boxes[0] has this one"#
        ]],
    );
}

#[test]
fn only_robots_may_be_elsewhere() {
    check(
        &format!("{SMALL}[pheromones]\ntrails_m = [[[0.0, 0.0], [1.0, 0.0]]]\n"),
        &["pheromones.line.kind=tcp"],
        &expect![[
            r#"--set pheromones.line.kind=tcp: pheromones.line.kind = "tcp": must be one of `memory`, `direct`"#
        ]],
    );
    check(
        SMALL,
        &["robots.line.kind=tcp", "robots.line.address=127.0.0.1:8101"],
        &expect!["accepted: small"],
    );
}

#[test]
fn the_small_mission_is_accepted() {
    check(SMALL, &[], &expect!["accepted: small"]);
}

#[test]
fn a_misspelt_key_is_shown_with_what_is_allowed() {
    check(
        "[mission]\nnmae = \"x\"\n",
        &[],
        &expect![[r#"
            small.toml: TOML parse error at line 2, column 1
              |
            2 | nmae = "x"
              | ^^^^
            unknown field `nmae`: did you mean `name`?"#]],
    );
}

#[test]
fn a_wrong_type_is_shown_in_its_place() {
    check(
        "[mission]\nseed = \"one\"\n",
        &[],
        &expect![[r#"
            small.toml: TOML parse error at line 2, column 8
              |
            2 | seed = "one"
              |        ^^^^^
            invalid type: string "one", expected u64"#]],
    );
}

#[test]
fn a_number_outside_its_range_is_located() {
    check(
        "[mission]\nname = \"x\"\nduration_max_s = 0.0\n",
        &[],
        &expect!["small.toml:3:18: mission.duration_max_s = 0.0: must be from 0.1 to 86400 s"],
    );
    check(
        &format!("{SMALL}follow.speed_mps = nan\n"),
        &[],
        &expect![
            "small.toml:15:20: robots[0].mind.follow.speed_mps = NaN: must be from 0.05 to 1 m/s"
        ],
    );
    check(
        &format!("{SMALL}control_period_ms = 205\n"),
        &[],
        &expect![
            "small.toml:15:21: robots[0].mind.control_period_ms = 205: must be a multiple of 10 from 50 to 2000 ms"
        ],
    );
}

#[test]
fn a_method_that_does_not_exist_is_answered_with_those_that_do() {
    check_added(
        "guard.method = \"bug2\"\n",
        &expect![[
            r#"small.toml:15:16: robots[0].mind.guard.method = "bug2": must be one of `checked`, `rebound`, `contact`, `off`"#
        ]],
    );
    check(
        SMALL,
        &["robots.mind.how.method=teleport"],
        &expect![[
            r#"--set robots.mind.how.method=teleport: robots[0].mind.how.method = "teleport": must be one of `trail`, `straight`, `path`, `tags`, `map`"#
        ]],
    );
    check(
        SMALL,
        &["robots.model=roomba"],
        &expect![[
            r#"--set robots.model=roomba: robots[0].model = "roomba": must be one of `pioneer3dx`, `peoplebot`, `artemic5`, `artemic8`, `create2`"#
        ]],
    );
    check(
        SMALL,
        &["world.walls.material=jelly"],
        &expect![[
            r#"--set world.walls.material=jelly: world.walls[0].material = "jelly": must be one of `plaster`, `wood`, `glass`, `fabric`, `metal`, `cardboard`, `person`, `mirror`"#
        ]],
    );
}

#[test]
fn a_trail_route_needs_a_trail() {
    check(
        SMALL,
        &["robots.mind.how.method=trail"],
        &expect![[
            r#"--set robots.mind.how.method=trail: robots[0].mind.how.method = "trail": must be `straight`, because the mission has no [pheromones]"#
        ]],
    );
}

#[test]
fn names_are_unique() {
    check_added(
        "[[robots]]\n",
        &expect![[
            r#"small.toml:15:1: robots[1].name = "robot": must be a name of its own; robots[0] has this one"#
        ]],
    );
    check_added(
        "[[devices]]\nname = \"bell\"\n",
        &expect![[
            r#"small.toml:16:8: devices[1].name = "bell": must be a name of its own; devices[0] has this one"#
        ]],
    );
    check_added(
        "[[devices]]\n",
        &expect![[r#"small.toml:15:1: devices[1].name = "": must be a name"#]],
    );
}

#[test]
fn inputs_and_outputs_exist_once() {
    check_added(
        "[[devices]]\nname = \"second\"\ninput = 0\n",
        &expect![
            "small.toml:17:9: devices[1].input = 0: must be a number of its own; `bell` has this one"
        ],
    );
    check_added(
        "[[devices]]\nname = \"second\"\ninput = 16\n",
        &expect!["small.toml:17:9: devices[1].input = 16: must be from 0 to 15"],
    );
    check_added(
        "[[devices]]\nname = \"lamp\"\nkind = \"lamp\"\n",
        &expect!["small.toml:15:1: devices[1].output = absent: must be a number from 0 to 15"],
    );
    check_added(
        "[[devices]]\nname = \"lamp\"\nkind = \"lamp\"\ninput = 3\n",
        &expect!["small.toml:18:9: devices[1].input = 3: must be absent: a lamp is an output"],
    );
}

#[test]
fn nobody_starts_inside_a_wall_or_a_thing() {
    check(
        SMALL,
        &["robots.start=[1.9, 0.0, 0.0]"],
        &expect![
            "--set robots.start=[1.9, 0.0, 0.0]: robots[0].start = [1.9, 0.0, 0.0]: must be a place where `robot` touches no wall"
        ],
    );
    check_added(
        "[[world.things]]\nname = \"table\"\nat_m = [0.2, 0.1]\n",
        &expect![
            "small.toml:12:1: robots[0].start = [0.0, 0.0, 0.0]: must be a place where `robot` does not touch `table`"
        ],
    );
}

#[test]
fn files_that_are_not_there_are_named() {
    check_added(
        "[decision]\nprogram_file = \"lost.rdpl\"\n",
        &expect![[
            r#"small.toml:16:16: decision.program_file = "lost.rdpl": must be a file that can be read (lost.rdpl: cannot be read: not among the shipped files)"#
        ]],
    );
    let absent = Mission::load("no/such/mission.toml", &[]).unwrap_err().to_string();
    expect!["no mission is called `no/such/mission.toml` and no such file exists; shipped missions: doorbell, doorbell-answered, trail-45deg, trail-corner, trail-junctions, tag-trail, path-slalom, one-obstacle, intermediate-goals, decision-rig, errands, night-watch, swarm, link-cut, server-lost, ward-call, ward-rounds, go-anywhere, workshop, laser-ward, create-errand, create-scan, artemic-e1, artemic-e2, artemic-e3, artemic-e4"].assert_eq(&absent);
}

#[test]
fn a_program_with_an_error_is_refused_with_its_line() {
    check_added(
        "[decision]\nprogram = \"\\nAND O0,I77\"\n",
        &expect![
            "small.toml:16:11: decision.program = a program with 1 error (line 2, column 1: AND needs 5 operands and has 2: OP2 is missing): must be a program that compiles"
        ],
    );
    check_added(
        "[decision]\n",
        &expect![
            "small.toml:15:1: decision.program = absent: must be the program, or instead program_file with the name of its file"
        ],
    );
    check_added(
        "[decision]\nprogram = \"AND O0,I0,1L,1L,1L\"\narrived_input = 0\n",
        &expect![
            "small.toml:17:17: decision.arrived_input = 0: must be an input of its own; `bell` has this one"
        ],
    );
}

#[test]
fn events_and_requirements_speak_of_what_exists() {
    check_added(
        "[[events]]\ndo = \"press\"\ndevice = \"gong\"\n",
        &expect![[
            r#"small.toml:17:10: events[0].device = "gong": must be one of the mission's names: bell"#
        ]],
    );
    check_added(
        "[[events]]\ndo = \"goal\"\nrobot = \"robot\"\n",
        &expect![
            "small.toml:15:1: events[0].pose = absent: must be x, y (m), yaw (degrees), either here or in pose_from_start"
        ],
    );
    check_added(
        "[[success.arrived]]\nrobot = \"ghost\"\npose = [0, 0, 0]\n",
        &expect![[
            r#"small.toml:16:9: success.arrived[0].robot = "ghost": must be one of the mission's names: robot"#
        ]],
    );
}

#[test]
fn overrides_that_cannot_be_applied_are_explained() {
    check(
        SMALL,
        &["robots.start"],
        &expect!["--set robots.start: must look like table.key=value, with an equals sign"],
    );
    check(
        SMALL,
        &["robots.wings=2"],
        &expect![[r#"
            --set robots.wings=2: unknown field `wings`, expected one of `name`, `model`, `start`, `count`, `spacing_m`, `row_length`, `odometry`, `sonar`, `line`, `mind`, `tag_readers`, `lasers`, `teleoperator`
            in `robots`"#]],
    );
}

#[test]
fn the_resolved_text_makes_the_same_mission() {
    for name in Mission::shipped() {
        let mission = Mission::load(name, &[]).unwrap();
        let again = Mission::parse("resolved", &mission.to_toml(), &[]).unwrap();
        assert_eq!(again.file(), mission.file(), "{name}");
        assert_eq!(again.to_toml(), mission.to_toml(), "{name}");
    }
}

#[test]
fn an_override_reaches_the_resolved_text() {
    let mission = Mission::load("doorbell", &["robots.mind.follow.speed_mps=0.25".to_owned()]);
    assert!((mission.unwrap().file().robots[0].mind.follow.speed_mps - 0.25).abs() < 1e-12);
}

/// Keys of a table and all tables in it, with the tables' names; indices left out.
fn keys(value: &toml::Value, prefix: &str, found: &mut std::collections::BTreeSet<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, inner) in table {
                let path = format!("{prefix}.{key}");
                found.insert(path.clone());
                keys(inner, &path, found);
            }
        }
        toml::Value::Array(array) => array.iter().for_each(|v| keys(v, prefix, found)),
        _ => {}
    }
}

#[test]
fn the_template_is_a_mission_and_names_every_key() {
    let template = Mission::template();
    let written: MissionFile = toml::from_str(template).unwrap();
    Mission::parse("template", template, &[]).unwrap();

    let mut in_template = std::collections::BTreeSet::new();
    keys(&toml::from_str(template).unwrap(), "", &mut in_template);
    let mut in_code = std::collections::BTreeSet::new();
    keys(&toml::Value::try_from(&written).unwrap(), "", &mut in_code);
    let missing: Vec<&String> =
        in_code.difference(&in_template).filter(|k| !k.contains(".line.")).collect();
    assert!(missing.is_empty(), "the template does not show {missing:?}");
}

#[test]
fn the_template_shows_the_defaults() {
    let template = Mission::template();
    // Without the lines marked as examples, every table falls back to its defaults.
    let plain: String =
        template.lines().filter(|l| !l.contains("# e.g.")).fold(String::new(), |t, l| t + l + "\n");
    let file: MissionFile = toml::from_str(&plain).unwrap();
    let default = MissionFile::default();
    assert_eq!(file.mission, default.mission);
    assert_eq!(file.robots[0], missions::file::RobotFile::default());
    assert_eq!(file.pheromones, Some(missions::file::PheromonesFile::default()));
    assert_eq!(file.decision, Some(missions::file::DecisionFile::default()));
    let bare_world =
        missions::file::WorldFile { bounds_m: file.world.bounds_m, ..default.world.clone() };
    assert_eq!(bare_world, default.world);
    assert_eq!(file.world.random_boxes[0], missions::file::RandomBoxesFile::default());
    assert_eq!(file.success.stayed[0], missions::file::StayedFile::default());
    assert_eq!(file.success.arrived[0], missions::file::ArrivedFile::default());
}

/// Every key that is no table, with the tables on the way to it; of several tables the first.
fn leaves(value: &toml::Value, way: &[String], found: &mut Vec<(Vec<String>, toml::Value)>) {
    match value {
        toml::Value::Table(table) => {
            for (key, inner) in table {
                leaves(inner, &[way, std::slice::from_ref(key)].concat(), found);
            }
        }
        toml::Value::Array(array) if array.first().is_some_and(toml::Value::is_table) => {
            leaves(&array[0], &[way, &["[]".to_owned()]].concat(), found);
        }
        leaf => found.push((way.to_vec(), leaf.clone())),
    }
}

/// A file with these tables and, in the last of them, `last` alone.
fn nested(way: &[String], last: Option<(&str, &toml::Value)>) -> toml::Value {
    match way {
        [] => {
            let pairs = last.into_iter().map(|(key, value)| (key.to_owned(), value.clone()));
            toml::Value::Table(pairs.collect())
        }
        [first, rest @ ..] if first == "[]" => toml::Value::Array(vec![nested(rest, last)]),
        [first, rest @ ..] => {
            toml::Value::Table([(first.clone(), nested(rest, last))].into_iter().collect())
        }
    }
}

/// `[pheromones.line] baud = 9600` used to change the latency from 5 to 2 ms.
#[test]
fn a_key_that_is_set_to_its_default_changes_nothing() {
    let template: MissionFile = toml::from_str(Mission::template()).unwrap();
    let mut keys = Vec::new();
    leaves(&toml::Value::try_from(&template).unwrap(), &[], &mut keys);
    let mut n_links = 0;
    for (way, _) in &keys {
        let (key, tables) = way.split_last().unwrap();
        let bare: MissionFile = nested(tables, None).try_into().unwrap();
        let written = toml::Value::try_from(&bare).unwrap();
        let step = |at: Option<toml::Value>, name: &String| match (at?, name.as_str()) {
            (toml::Value::Array(array), "[]") => array.first().cloned(),
            (table, name) => table.get(name).cloned(),
        };
        // What has no default is not written.
        let Some(default) = way.iter().fold(Some(written), step) else { continue };
        let set = nested(tables, Some((key, &default)));
        let set: MissionFile = set.try_into().unwrap();
        assert_eq!(set, bare, "{} = {default}", way.join("."));
        n_links += usize::from(tables.last().is_some_and(|table| table == "line"));
    }
    assert_eq!((n_links, keys.len() > 100), (4 * 6, true));
}

/// The three kinds of lines, each with what a cable or a radio modem takes.
#[test]
fn a_baud_rate_alone_keeps_the_latency() {
    let overrides =
        ["pheromones.line.baud=9600", "decision.line.baud=9600", "robots.line.baud=9600"];
    let overrides = overrides.map(str::to_owned);
    let set = Mission::load("doorbell", &overrides).unwrap();
    assert_eq!(set.file(), Mission::load("doorbell", &[]).unwrap().file());
    let latency_ms =
        |mission: &Mission| mission.file().pheromones.as_ref().unwrap().line.latency_ms;
    assert!((latency_ms(&set) - 5.0).abs() < 1e-12);
    let slower = Mission::load("doorbell", &["pheromones.line.baud=4800".to_owned()]).unwrap();
    assert!((latency_ms(&slower) - 5.0).abs() < 1e-12);
}

/// The text with what stands between two marks replaced.
#[expect(clippy::unwrap_used, reason = "a failing helper fails its test")]
fn with(text: &str, mark: &str, table: &str) -> String {
    let (begin, end) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->\n"));
    let (before, rest) = text.split_once(&begin).unwrap();
    let (_, after) = rest.split_once(&end).unwrap();
    format!("{before}{begin}{table}{end}{after}")
}

#[test]
fn the_guide_shows_the_template_the_words_and_the_requirements() {
    // UPDATE_EXPECT=1 brings it up to date: one test, as all of it is one file. It ends with the template in a block.
    let guide = include_str!("../../../docs/guide/missions.md");
    let (before, _) = guide.rsplit_once("```toml\n").unwrap();
    let guide = format!("{before}```toml\n{}```\n", Mission::template());
    let mut words_table = "| key | word | what it is |\n| --- | --- | --- |\n".to_owned();
    for WordList { key, words } in Mission::word_lists() {
        // The laws have a chapter of their own.
        let is_law = key.ends_with(".trail_law") || key.ends_with(".path_law");
        for (word, about) in words.iter().filter(|(_, about)| !is_law && !about.is_empty()) {
            words_table.extend(["| `", key, "` | `", word, "` | ", about, " |\n"]);
        }
    }
    let mut requirements = "| `[success]` | what it asks for |\n| --- | --- |\n".to_owned();
    for (key, text) in Mission::requirement_texts() {
        requirements.extend(["| `", key, "` | ", text, " |\n"]);
    }
    let guide = with(&guide, "words", &words_table);
    let guide = with(&guide, "requirements", &requirements);
    expect_file!["../../../docs/guide/missions.md"].assert_eq(&guide);
}

/// What the template writes as comments is what the checks take: each word at its key is accepted there, and another one
/// is answered with the whole list.
#[test]
fn every_word_of_every_list_is_accepted_at_its_key() {
    let text = Mission::template();
    let file: MissionFile = toml::from_str(text).unwrap();
    let cut = file.events.iter().position(|event| event.action == "cut_line").unwrap();
    let said = |sets: &[String]| match Mission::parse("t.toml", text, sets) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    for WordList { key, words } in Mission::word_lists() {
        // Of the events one has a line; a direction belongs to one of three lines.
        let key = match key {
            "events.line" | "events.direction" => key.replace("events", &format!("events[{cut}]")),
            _ => key.to_owned(),
        };
        let lines: &[&str] = if key.ends_with(".direction") {
            &["robot", "pheromones", "ground"]
        } else {
            &["robot"]
        };
        for (word, _) in &words {
            let with = |value: &str, line: &str| {
                let usual = format!("events[{cut}].direction=both");
                said(&[usual, format!("events[{cut}].line={line}"), format!("{key}={value}")])
            };
            let told = |line: &&&str| with("nonsense", line).contains(&format!("`{word}`"));
            let line = lines.iter().find(told).unwrap_or_else(|| panic!("{key}: {word}"));
            // It may be refused for another reason: what it needs is not in the template.
            let said = with(word, line);
            assert!(!said.contains("must be one of"), "{key}={word}: {said}");
        }
    }
}

#[test]
fn a_robot_that_is_driven_by_hand_is_here_and_one() {
    let by_hand = "[robots.teleoperator]\npath_m = [[0.0, 0.0], [1.0, 0.0]]\n";
    check_added(by_hand, &expect!["accepted: small"]);
    check(
        &format!("{SMALL}{by_hand}"),
        &["robots.count=2"],
        &expect![
            "--set robots.count=2: robots[0].count = 2: must be 1, because one person drives one robot"
        ],
    );
    let elsewhere = ["robots.line.kind=tcp", "robots.line.address=127.0.0.1:9"];
    check(
        &format!("{SMALL}{by_hand}"),
        &elsewhere,
        &expect![[
            r#"--set robots.line.kind=tcp: robots[0].line.kind = "tcp": must be `memory` or `direct`: nobody here sees a robot that is elsewhere"#
        ]],
    );
    check_added(
        &by_hand.replace("[1.0, 0.0]", "[0.0, 0.0]"),
        &expect![
            "small.toml:16:10: robots[0].teleoperator.path_m = a path needs two different points; 2 given, all the same: must be at least two different corners"
        ],
    );
    check_added(
        &format!("{by_hand}laps = 2\n"),
        &expect![
            "small.toml:17:8: robots[0].teleoperator.laps = 2: must be 1, or a path that ends where it begins"
        ],
    );
    let round = by_hand.replace("[1.0, 0.0]", "[1.0, 0.0], [1.0, 1.0], [0.0, 0.0]");
    check_added(&format!("{round}laps = 2\n"), &expect!["accepted: small"]);
    check_added(
        &format!("{round}laps = 0\n"),
        &expect!["small.toml:17:8: robots[0].teleoperator.laps = 0: must be from 1 to 100"],
    );
    check_added(
        &format!("{round}laps = 101\n"),
        &expect!["small.toml:17:8: robots[0].teleoperator.laps = 101: must be from 1 to 100"],
    );
    check_added(
        &format!("{by_hand}speed_mps = 0.0\n"),
        &expect![
            "small.toml:17:13: robots[0].teleoperator.speed_mps = 0.0: must be from 0.02 to 1 m/s"
        ],
    );
    check_added(
        &format!("{by_hand}corner_radius_m = nan\n"),
        &expect![
            "small.toml:17:19: robots[0].teleoperator.corner_radius_m = NaN: must be from 0.05 to 5 m"
        ],
    );
}

#[test]
fn a_line_too_slow_for_the_robot_is_refused() {
    let create = ["robots.model=create2", "robots.mind.guard.method=off"];
    check(
        SMALL,
        &create,
        &expect![
            "small.toml:12:1: robots[0].line.baud = 9600: must be at least 38400 baud, so that the reports of iRobot Create 2 fit"
        ],
    );
    let fast = "robots.line.baud=115200";
    check(SMALL, &[create[0], create[1], fast], &expect!["accepted: small"]);
}

#[test]
fn artemic_has_no_line_to_be_simulated() {
    check(
        SMALL,
        &["robots.model=artemic5"],
        &expect![[
            r#"small.toml:12:1: robots[0].line.kind = "memory": must be `direct`: the line of ARTEMIC (5 sonars) is not simulated"#
        ]],
    );
    check(
        SMALL,
        &["robots.model=artemic8", "robots.line.kind=direct"],
        &expect!["accepted: small"],
    );
    check(
        SMALL,
        &["robots.odometry.drift_degpm=6"],
        &expect![
            "--set robots.odometry.drift_degpm=6: robots[0].odometry.drift_degpm = 6.0: must be from -5 to 5 degrees per metre"
        ],
    );
    check(
        SMALL,
        &["robots.sonar.range_step_m=-0.1"],
        &expect![
            "--set robots.sonar.range_step_m=-0.1: robots[0].sonar.range_step_m = -0.1: must be from 0 to 0.1 m"
        ],
    );
    check(
        SMALL,
        &["robots.sonar.range_min_m=0.4"],
        &expect![
            "--set robots.sonar.range_min_m=0.4: robots[0].sonar.range_min_m = 0.4: must be from 0 to 0.3 m"
        ],
    );
}

/// A program that an old editor saved is read as `cairn rdpl` reads it, and it is said.
#[test]
fn a_program_of_another_encoding_is_read_and_the_guess_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let source = "AND O0,I0,1L,1L,1L ; Tür\nOR O1,I0,0L,0L,0L\n";
    let latin: Vec<u8> = source.chars().map(|c| c as u8).collect();
    let utf_16: Vec<u8> =
        [0xFEFF].into_iter().chain(source.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let cases = [
        (source.as_bytes().to_vec(), None),
        (latin, Some("line 1: this is not UTF-8 and was read as Latin-1 (1 such lines)")),
        (utf_16, Some("line 1: this is not UTF-8 and was read as UTF-16 (2 such lines)")),
    ];
    let mission = "[mission]\nname = \"own\"\n[decision]\nprogram_file = \"own.rdpl\"\n\
                   [success]\nmoves_sent = 0\n";
    for (bytes, told) in cases {
        std::fs::write(folder.path().join("own.rdpl"), bytes).unwrap();
        let read = Mission::parse_in(folder.path(), "own.toml", mission, &[]).unwrap();
        let text = read.program_source().unwrap().trim_start_matches('\u{FEFF}');
        assert_eq!(text, source);
        let guesses: Vec<String> =
            read.warnings().into_iter().filter(|w| w.contains("own.rdpl")).collect();
        match told {
            None => assert!(guesses.is_empty(), "{guesses:?}"),
            Some(told) => assert!(guesses[0].contains(told), "{guesses:?}"),
        }
    }
}
