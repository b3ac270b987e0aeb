//! One rule for outputs, command by command: what exists, what is read, links, pipes and folders stay as they are,
//! and that is said before any work.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod support;

use std::{collections::BTreeMap, fs, path::Path};

use support::{Place, short_drive};

const PROGRAM: &str = "AND Y0,I0,I1,1L,1L\nOR O0,Y0,I2,0L,0L\n";
const GRAPH: &str = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";

/// Everything below a folder: files with their content, other things with what they are.
fn everything(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        let kind = entry.file_type().unwrap();
        if kind.is_dir() {
            for (inner, content) in everything(&entry.path()) {
                found.insert(format!("{name}/{inner}"), content);
            }
            found.insert(format!("{name}/"), Vec::new());
        } else if kind.is_file() {
            found.insert(name, fs::read(entry.path()).unwrap());
        } else {
            found.insert(name, format!("{kind:?}").into_bytes());
        }
    }
    found
}

/// A folder with everything that the commands below read, and things that must stay.
fn place() -> Place {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    place.write("other.toml", &short_drive(0.2));
    place.write("lamp.src", PROGRAM);
    place.write("g.rdpl", PROGRAM);
    place.write("graph.g2o", GRAPH);
    place.write(
        "plan.toml",
        "minimise = \"truth.rms_m\"\n[[keys]]\nkey = \"map.resolution_m\"\nvalues = [0.1]\n",
    );
    let room = surveys::testing::room(12);
    place.write("room.csv", &recordings::csv::write(&room));
    place.write("notes.txt", "notes\n");
    fs::create_dir(place.path("folder")).unwrap();
    fs::create_dir(place.path("held")).unwrap();
    for name in ["map.pgm", "summary.json", "sweep.csv", "report.html", "figure.svg"] {
        place.write(&format!("held/{name}"), "mine and not the program's\n");
    }
    fs::create_dir(place.path("odd")).unwrap();
    fs::create_dir(place.path("odd/checkpoint")).unwrap();
    place.write("odd/checkpoint/diary.txt", "mine\n");
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("drive.toml", place.path("link.mcap")).unwrap();
        symlink("nowhere", place.path("dangling.svg")).unwrap();
        fs::hard_link(place.path("graph.g2o"), place.path("twin.g2o")).unwrap();
        place.write("one.txt", "one\n");
        fs::hard_link(place.path("one.txt"), place.path("twin.mcap")).unwrap();
        let pipe = std::process::Command::new("mkfifo").arg(place.path("pipe.mcap")).status();
        assert!(pipe.unwrap().success());
    }
    place
}

/// A command and a word of its refusal; each is refused with `--force` too unless the word is `exists already`.
const REFUSED: &[(&str, &str)] = &[
    ("run drive.toml --headless --record drive.toml", "is read by this command"),
    ("run drive.toml --headless --record ./folder/../drive.toml", "is read by this command"),
    ("run drive.toml --headless --record other.toml", "exists already"),
    ("run drive.toml --headless --record folder", "a folder"),
    ("run drive.toml --headless --record folder/", "a folder"),
    ("run drive.toml --headless --record new/out.mcap", "there is no folder new"),
    ("run drive.toml --headless --record notes.txt/out.mcap", "notes.txt is no folder"),
    ("run drive.toml --record other.toml --port 0", "exists already"),
    ("rdpl lamp.src --gates lamp.src", "is read by this command"),
    ("rdpl g.rdpl --check --gates g.rdpl", "is read by this command"),
    ("rdpl lamp.src --gates lamp.bin", "two results"),
    ("rdpl lamp.src --gates folder/../lamp.lst", "two results"),
    ("rdpl lamp.src --gates notes.txt", "exists already"),
    ("rdpl lamp.src -o new", "there is no folder new"),
    ("rdpl lamp.src -o notes.txt", "notes.txt is no folder"),
    ("graph graph.g2o -o graph.g2o", "is read by this command"),
    ("graph graph.g2o -o notes.txt", "exists already"),
    ("graph graph.g2o -o folder", "a folder"),
    ("graph graph.g2o -o new/out.g2o", "there is no folder new"),
    ("map room.csv -o held", "holds results already"),
    ("map room.csv -o new/deeper", "there is no folder new"),
    ("map room.csv -o notes.txt", "is no folder"),
    ("map room.csv -o odd", "part of a checkpoint"),
    ("map room.csv --sweep plan.toml -o held", "holds results already"),
    ("map room.csv --sweep plan.toml -o new/deeper", "there is no folder new"),
    ("reproduce assistant-7.4 --runs 1 -o held", "exists already"),
    ("reproduce assistant-7.4 --runs 1 -o new/deeper", "there is no folder new"),
    ("reproduce assistant-7.4 --runs 1 -o notes.txt", "is no folder"),
];

#[cfg(unix)]
const REFUSED_UNIX: &[(&str, &str)] = &[
    ("run drive.toml --headless --record link.mcap", "is read by this command"),
    ("run other.toml --headless --record link.mcap", "a symbolic link"),
    ("run drive.toml --headless --record twin.mcap", "hard links"),
    ("run drive.toml --headless --record pipe.mcap", "a pipe"),
    ("run drive.toml --headless --record /dev/null", "a device"),
    ("rdpl lamp.src --check --gates dangling.svg", "a symbolic link"),
    ("graph graph.g2o -o twin.g2o", "is read by this command"),
    ("graph graph.g2o -o /dev/null", "a device"),
];
#[cfg(not(unix))]
const REFUSED_UNIX: &[(&str, &str)] = &[];

#[test]
fn nothing_is_written_that_should_not_be() {
    let place = place();
    let before = everything(&place.path(""));
    for (command, word) in REFUSED.iter().chain(REFUSED_UNIX) {
        place.cairn(command).refused(2, &[word]);
        assert_eq!(everything(&place.path("")), before, "{command}");
        // With --force what exists would be replaced, but none of these files is of the sort that is written.

        let word = if ["exists already", "holds results already"].contains(word) {
            "not even with --force"
        } else {
            word
        };
        place.cairn(&format!("{command} --force")).refused(2, &[word]);
        assert_eq!(everything(&place.path("")), before, "{command} --force");
    }
}

/// What is written can be replaced with `--force`, and only then.
#[test]
fn force_replaces_what_cairn_wrote() {
    let place = place();
    for (command, file) in [
        ("run drive.toml --headless --record out.mcap", "out.mcap"),
        ("rdpl lamp.src --gates lamp.svg", "lamp.bin"),
        ("graph graph.g2o -o out.g2o", "out.g2o"),
        ("map room.csv -o mapped", "mapped/summary.json"),
        ("map room.csv --sweep plan.toml -o swept", "swept/sweep.csv"),
        ("reproduce assistant-7.4 --runs 1 -o report", "report/report.html"),
    ] {
        place.cairn(command).fine();
        let before = everything(&place.path(""));
        assert!(before.contains_key(file), "{command}");
        assert!(before.keys().all(|name| !name.contains(".part")), "{before:?}");
        place.cairn(command).refused(2, &["--force"]);
        assert_eq!(everything(&place.path("")), before, "{command}");
        place.cairn(&format!("{command} --force")).fine();
        let names = |all: &BTreeMap<String, Vec<u8>>| all.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&everything(&place.path(""))), names(&before), "{command}");
    }
}

/// On a full disk nothing half-written takes a name, and the program says so.
#[cfg(unix)]
#[test]
fn a_full_disk_is_said() {
    let place = place();
    let before = everything(&place.path(""));
    for command in [
        "graph graph.g2o -o out.g2o",
        "rdpl lamp.src",
        "map room.csv -o mapped",
        "reproduce assistant-7.4 --runs 1 -o report",
    ] {
        let binary = env!("CARGO_BIN_EXE_cairn");
        let script = format!("trap '' XFSZ; ulimit -f 0; exec {binary} {command}");
        let mut shell = std::process::Command::new("sh");
        let ended = Place::ended(shell.args(["-c", &script]).current_dir(place.path("")));
        ended.refused(2, &["cannot be written"]);
        assert_eq!(everything(&place.path("")), before, "{command}");
    }
}

/// A disk that fills up while a run is recorded: the run ends at once, and what was recorded can be replayed.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_ends_a_recorded_run() {
    let place = place();
    let binary = env!("CARGO_BIN_EXE_cairn");
    let limited = |blocks: u32, name: &str| {
        let run = format!("{binary} run drive.toml --headless --record {name}");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {run}");
        let mut shell = std::process::Command::new("sh");
        Place::ended(shell.args(["-c", &script]).current_dir(place.path("")))
    };
    limited(64, "out.mcap")
        .refused(2, &["the recording stops after", "out.mcap.part", "cannot be written"]);
    assert!(!place.path("out.mcap").exists());
    let replay = place.cairn("replay out.mcap.part --headless").fine().out;
    assert!(
        replay.contains("was not finished") && replay.contains("each with the recorded state"),
        "{replay}"
    );
    // Not even the head finds room: that is known before the run, and nothing is left.
    limited(0, "none.mcap").refused(2, &["none.mcap", "cannot be written"]);
    assert!(!place.path("none.mcap.part").exists());
}

/// What a mission from standard input names is an input as well.
#[test]
fn a_mission_from_standard_input_keeps_its_files() {
    let place = Place::new();
    fs::copy(support::shipped("doorbell.rdpl"), place.path("doorbell.rdpl")).unwrap();
    let mission = fs::read_to_string(support::shipped("doorbell.toml")).unwrap();
    let program = place.read("doorbell.rdpl");
    for force in ["", " --force"] {
        let command = format!("run - --headless --record doorbell.rdpl{force}");
        place.piped(&command, &mission).refused(2, &["is read by this command"]);
    }
    assert_eq!(place.read("doorbell.rdpl"), program);
}

/// Two runs cannot record under one name, and what a killed one left is kept.
#[cfg(unix)]
#[test]
fn a_recording_has_one_writer() {
    let place = place();
    place.write("out.mcap.part", "left by a crash");
    let mut first = place.command();
    first.args(["run", "drive.toml", "--record", "out.mcap", "--port", "0"]);
    let mut first = first.stdout(std::process::Stdio::null()).spawn().unwrap();
    while !place.path("out.mcap.2.part").exists() {
        assert!(first.try_wait().unwrap().is_none(), "it ended");
        std::thread::yield_now();
    }
    let second = place.cairn("run drive.toml --headless --record out.mcap");
    let holder =
        if cfg!(target_os = "linux") { format!("process {}", first.id()) } else { String::new() };
    second.refused(2, &["out.mcap", "is being written by", &holder]);
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(!place.path("out.mcap").exists());
    let third = place.cairn("run drive.toml --headless --record out.mcap").fine();
    assert!(
        third.err.contains("out.mcap.2.part") && third.err.contains("is kept"),
        "{}",
        third.err
    );
    assert_eq!(place.read("out.mcap.part"), "left by a crash");
    assert!(place.path("out.mcap.2.part").exists() && place.path("out.mcap").exists());
}
