//! `cairn map` from end to end, on small recordings made by arithmetic.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod support;

use std::{
    fs,
    io::Write as _,
    path::Path,
    process::{Command, Stdio},
};

use grid_maps::{
    State, Thresholds,
    files::{MapYaml, map_server, read_pgm},
};
use serde_json::Value;
use support::Place;
use surveys::testing::{room, sonar_room, to_carmen};

/// A folder with a laser's log, a ring's log and the true poses of both.
fn place(n_scans: usize) -> Place {
    let place = Place::new();
    let laser = room(n_scans);
    place.write("room.clf", &to_carmen(&laser));
    place.write("truth.tum", &truth(&laser));
    let ring = sonar_room(n_scans);
    place.write("ring.csv", &recordings::csv::write(&ring));
    place
}

/// True poses in the time of the CARMEN log.
fn truth(recording: &recordings::Recording) -> String {
    recordings::trajectories::write_tum(&recording.truth, 1_000_000_000_000_000)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn figure(summary: &Value, name: &str) -> f64 {
    summary["figures"][name].as_f64().unwrap_or_else(|| panic!("no {name} in {summary}"))
}

/// A figure that counts.
fn whole(summary: &Value, name: &str) -> usize {
    figure(summary, name).round() as usize
}

#[test]
fn a_laser_log_becomes_a_map_that_can_be_read_again() {
    let place = place(160);
    let run = place.cairn("map room.clf --truth truth.tum").fine();
    for word in ["160 scans of 181 beams", "loops closed", "true poses", "room-map/report.html"] {
        assert!(run.out.contains(word), "`{word}` is missing in: {}", run.out);
    }
    assert_eq!(
        run.err, "",
        "no progress bar where there is no terminal, nothing to complain about"
    );
    let folder = place.path("room-map");
    let all = [
        "graph.g2o",
        "map.pgm",
        "map.png",
        "map.yaml",
        "report.html",
        "settings.toml",
        "summary.json",
        "trajectory.tum",
    ];
    assert_eq!(names(&folder), all);

    let summary: Value = serde_json::from_str(&place.read("room-map/summary.json")).unwrap();
    assert_eq!(summary["partial"], false);
    let (error_m, drift_m) =
        (figure(&summary, "truth.rms_m"), figure(&summary, "truth.odometry.rms_m"));
    assert!(error_m < 0.05 && drift_m > 0.3, "{error_m} m with, {drift_m} m without the mapper");
    assert!(figure(&summary, "truth.mean_deg") < 0.5);

    // One line for each scan, each with its own stamp in the log's time.
    let trajectory = place.read("room-map/trajectory.tum");
    let times: Vec<f64> =
        trajectory.lines().map(|l| l.split(' ').next().unwrap().parse().unwrap()).collect();
    assert_eq!(times.len(), 160);
    assert!(times.iter().enumerate().all(|(i, t)| (t - 1e6 - 0.2 * i as f64).abs() < 1e-6));

    // The map server's reading of the two files has the very cells that were counted.
    let yaml = MapYaml::parse(&place.read("room-map/map.yaml")).unwrap();
    let image = read_pgm(&fs::read(folder.join("map.pgm")).unwrap()).unwrap();
    let served = map_server::read(&image, &yaml).unwrap();
    let states = served.states(&Thresholds::default());
    let count = |state| states.values().iter().filter(|&&s| s == state).count();
    assert_eq!(count(State::Occupied), whole(&summary, "map.occupied_cells"));
    assert_eq!(count(State::Free), whole(&summary, "map.free_cells"));
    // The room has 8 m × 6 m; where its walls are is seen to within a cell or two.
    let (width_m, height_m) =
        (image.width() as f64 * yaml.resolution_m, image.height() as f64 * yaml.resolution_m);
    assert!(width_m.min(height_m) > 5.9 && width_m.max(height_m) < 10.5, "{width_m} × {height_m}");

    let report = place.read("room-map/report.html");
    for word in [
        "<svg",
        "data:image/png;base64,",
        "Loop closures",
        "Errors",
        "Corrections",
        "Time",
        "Parameters",
        "nothing to complain about",
    ] {
        assert!(report.contains(word), "`{word}` is missing in the report");
    }
    assert!(
        !report.contains("http://")
            || report.matches("http://").count() == report.matches("http://www.w3.org").count(),
        "the page needs nothing from elsewhere"
    );
    assert!(place.read("room-map/graph.g2o").starts_with("VERTEX_SE2 0 0 0 0"));
}

#[test]
fn settings_of_a_run_repeat_it() {
    let place = place(60);
    place.cairn("map room.clf -o a --set map.resolution_m=0.1 --set laser.loops.radius_m=2").fine();
    place.cairn("map room.clf -o b --config a/settings.toml").fine();
    for file in ["map.pgm", "map.yaml", "trajectory.tum", "graph.g2o", "settings.toml"] {
        assert_eq!(
            fs::read(place.path(&format!("a/{file}"))).unwrap(),
            fs::read(place.path(&format!("b/{file}"))).unwrap(),
            "{file}"
        );
    }
    assert!(place.read("a/map.yaml").contains("resolution: 0.1"));
    let keys = place.cairn("map --keys").fine().out;
    assert!(keys.contains("[laser.loops]") && keys.contains("radius_m = 4.0"), "{keys}");
    place.write("keys.toml", &keys);
    place.cairn("map room.clf -o c --config keys.toml").fine();
}

#[test]
fn a_ring_of_sonars_is_mapped_in_every_form() {
    let place = place(400);
    let run = |rest: &str| place.cairn(&format!("map ring.csv --format json {rest}")).fine().json();
    let ours = run("-o ours");
    assert!(figure(&ours, "map.occupied_cells") > 100.0 && figure(&ours, "registrations") > 5.0);
    let plain = run("-o plain --method odometry");
    assert_eq!(whole(&plain, "corrections"), 0);
    let (with, without) = (figure(&ours, "truth.rms_m"), figure(&plain, "truth.rms_m"));
    assert!(with < 0.5 * without, "{with} m with, {without} m without corrections");
    let graph = run("-o graph --mode graph");
    assert!(figure(&graph, "truth.rms_m") < 0.5 * without);
    assert!(place.path("graph/graph.g2o").exists());
    for mode in ["thesis", "listing"] {
        let found = run(&format!("-o {mode} --mode {mode}"));
        assert!(figure(&found, "registrations") > 5.0, "{mode}");
        assert_eq!(found["parameters"]["survey.mode"], mode);
    }
    // A map that is known already: the way of the second run is laid on the map of the first.
    let known = run("-o known --prior ours/map.yaml");
    assert!(figure(&known, "truth.rms_m") < without);
    place.cairn("map room.clf --prior ours/map.yaml -o no").refused(2, &["sonar method only"]);
    place.cairn("map ring.csv --method laser -o no").refused(2, &["sonars", "laser"]);
    assert!(!place.path("no").exists());
}

#[test]
fn bad_lines_are_named_counted_and_survived() {
    let place = place(60);
    let log = place.read("room.clf");
    let mut lines: Vec<String> = log.lines().map(str::to_owned).collect();
    lines[10] = lines[10].replacen("FLASER 181 ", "FLASER 181 nonsense ", 1);
    lines[20] = lines[20].chars().take(300).collect();
    lines.insert(31, lines[30].clone());
    lines.swap(40, 41);
    place.write("bad.clf", &(lines.join("\n") + "\n"));
    let run = place.cairn("map bad.clf -o bad").fine();
    for line in ["line 11", "line 21"] {
        assert!(run.err.contains(line), "{line} is missing in: {}", run.err);
    }
    let summary: Value = serde_json::from_str(&place.read("bad/summary.json")).unwrap();
    assert_eq!(summary["scans"], 58);
    assert!(summary["complaints"]["bad.clf"]["total"].as_u64().unwrap() >= 3);
    assert!(place.read("bad/report.html").contains("skipped"));

    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(log.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    fs::write(place.path("cut.clf.gz"), &packed[..packed.len() / 2]).unwrap();
    let run = place.cairn("map cut.clf.gz -o cut").fine();
    assert!(run.err.contains("gzip"), "{}", run.err);
}

#[test]
fn what_cannot_be_mapped_is_refused_and_leaves_nothing() {
    let place = place(20);
    place.write("empty.clf", "");
    place.write("none.clf", "# a log without scans\nODOM 0 0 0 0 0 0 1.0 host 1.0\n");
    place.write("strange.bin", "This is no log.\n");
    let map = |rest: &str| place.cairn(&format!("map {rest}"));
    map("absent.clf").refused(2, &["absent.clf", "No such file"]);
    map("empty.clf").refused(2, &["empty.clf", "empty"]);
    map("none.clf").refused(2, &["none.clf", "no usable scan"]);
    map("strange.bin").refused(2, &["strange.bin", "CARMEN"]);
    map("").refused(2, &["LOG"]);
    map("room.clf --set map.resolution_m=0").refused(2, &["map.resolution_m", "from 0.005 to 1"]);
    map("room.clf --set map.resolutoin_m=1").refused(2, &["did you mean map.resolution_m"]);
    place.write("s.toml", "[map]\nresolution_m = 5\n");
    map("room.clf --config s.toml").refused(2, &["s.toml:2:16", "from 0.005 to 1"]);
    map("room.clf --ring circle").refused(2, &["listing8"]);
    map("room.clf --ring five").refused(2, &["CARMEN log", "leave --ring artemic5 out"]);
    map("room.clf truth.tum").refused(2, &["no second file"]);
    let help = map("--help").fine().out;
    assert!(recordings::Format::ALL.iter().all(|format| help.contains(format.name())), "{help}");
    map("room.clf --truth room.clf").refused(2, &["room.clf", "line"]);
    map("room.clf --prior absent.yaml").refused(2, &["absent.yaml"]);
    map("room.clf -o empty.clf/folder").refused(2, &["empty.clf/folder"]);
    map("room.clf --resume").refused(2, &["no checkpoint"]);
    assert_eq!(
        names(&place.path("")),
        ["empty.clf", "none.clf", "ring.csv", "room.clf", "s.toml", "strange.bin", "truth.tum"]
    );
}

#[test]
fn results_are_replaced_only_by_force() {
    let place = place(20);
    place.cairn("map room.clf").fine();
    let before = fs::read(place.path("room-map/map.pgm")).unwrap();
    let again = "map room.clf --set map.resolution_m=0.1";
    place.cairn(again).refused(2, &["room-map", "--force", "-o"]);
    assert_eq!(fs::read(place.path("room-map/map.pgm")).unwrap(), before);
    place.cairn(&format!("{again} --force")).fine();
    assert_ne!(fs::read(place.path("room-map/map.pgm")).unwrap(), before);
}

/// A map of pixels of a tenth of a millimetre (a public case) would take minutes: it is refused before the log is read.
#[test]
fn known_maps_have_sensible_pixels_and_places() {
    let place = place(3);
    let yaml = |resolution: &str, origin: &str| {
        let text = format!(
            "image: y.pgm\nresolution: {resolution}\norigin: {origin}\nnegate: 0\noccupied_thresh: 0.65\n\
             free_thresh: 0.2\n"
        );
        place.write("y.yaml", &text);
        place.cairn("map absent.csv --prior y.yaml --method sonar")
    };
    yaml("1e-4", "[0,0,0]").refused(2, &["y.yaml", "line 2", "more than 0.0001 and at most 10"]);
    yaml("11", "[0,0,0]").refused(2, &["at most 10"]);
    yaml("-0.05", "[0,0,0]").refused(2, &["-0.05", "at most 10"]);
    yaml("0.0002", "[0,0,0]").refused(2, &["0.0002", "from 0.005 to 1 m"]);
    yaml("0.05", "[.inf,0,0]").refused(2, &["line 3", ".inf"]);
    yaml("0.05", "[0,1e9,0]").refused(2, &["line 3", "1e9"]);
    if let Some(case) = testkit::data_folder("../cases/prior/y_1e-4.yaml") {
        let ended = place.cairn(&format!("map ring.csv --prior {}", case.display()));
        ended.refused(2, &["y_1e-4.yaml", "1e-4", "more than 0.0001 and at most 10"]);
    }
}

/// A file may not grow beyond 2 kB, as on a full disk: the write fails in the middle of a file.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing() {
    let place = place(20);
    let binary = env!("CARGO_BIN_EXE_cairn");
    let script = format!("trap '' XFSZ; ulimit -f 4; exec {binary} map room.clf -o out");
    let mut shell = Command::new("sh");
    let ended = Place::ended(shell.args(["-c", &script]).current_dir(place.path("")));
    ended.refused(2, &["out/", "cannot be written"]);
    assert!(!place.path("out").exists(), "{:?}", names(&place.path("out")));
}

#[test]
fn a_killed_run_leaves_a_usable_checkpoint_and_is_finished() {
    let place = place(500);
    place.cairn("map room.clf -o whole --checkpoint-s 0").fine();
    let mut command = place.command();
    command.args(["map", "room.clf", "-o", "killed", "--checkpoint-s", "0.001"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // The summary takes its name last: where it is, the checkpoint is whole.
    while !place.path("killed/checkpoint/summary.json").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before its first checkpoint");
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!place.path("killed/summary.json").exists(), "results of a run that was not finished");

    let summary: Value =
        serde_json::from_str(&place.read("killed/checkpoint/summary.json")).unwrap();
    let n_done = summary["scans_done"].as_u64().unwrap();
    assert!(summary["partial"] == true && (1..500).contains(&n_done), "{summary}");
    let yaml = MapYaml::parse(&place.read("killed/checkpoint/map.yaml")).unwrap();
    let image = read_pgm(&fs::read(place.path("killed/checkpoint/map.pgm")).unwrap()).unwrap();
    assert!(map_server::read(&image, &yaml).is_ok());
    let n_lines = place.read("killed/checkpoint/trajectory.tum").lines().count() as u64;
    // A kill between two files of a checkpoint may leave some of the next one.
    assert!(n_lines >= n_done, "{n_lines} poses of {n_done} scans");

    place.cairn("map ring.csv -o killed --resume").refused(2, &["another recording"]);
    // A checkpoint that the run does not come by is no checkpoint of this run.
    let state = place.read("killed/checkpoint/state.json");
    let mut strange: Value = serde_json::from_str(&state).unwrap();
    strange["poses"] = "0123456789abcdef".into();
    place.write("killed/checkpoint/state.json", &strange.to_string());
    place.cairn("map room.clf -o killed --resume").refused(2, &["at scan", "without --resume"]);
    place.write("killed/checkpoint/state.json", &state);
    place.cairn("map room.clf -o killed --resume").fine();
    for file in ["map.pgm", "trajectory.tum", "graph.g2o"] {
        let read = |folder: &str| fs::read(place.path(&format!("{folder}/{file}"))).unwrap();
        assert_eq!(read("killed"), read("whole"), "{file}");
    }
    assert!(!place.path("killed/checkpoint").exists(), "a finished run needs no checkpoint");
}

const PLAN: &str = "minimise = \"truth.rms_m\"\n\
    [[keys]]\nkey = \"sonar.correct\"\nvalues = [true, false]\n\
    [[keys]]\nkey = \"sonar.maturity_distance_m\"\nvalues = [0.3, 0.6, 1.2]\n";

/// The table without its last column, which is time.
fn timeless(csv: &str) -> Vec<&str> {
    csv.lines().map(|line| line.rsplit_once(',').unwrap().0).collect()
}

#[test]
fn a_sweep_that_was_killed_ends_like_one_that_was_not() {
    let place = place(120);
    place.write("plan.toml", PLAN);
    let out = place.cairn("map ring.csv --sweep plan.toml -o one --threads 1").fine().out;
    assert!(out.contains("6 settings, 0 failed") && out.contains("best.toml"), "{out}");
    let journal = fs::read(place.path("one/sweep.jsonl")).unwrap();
    fs::create_dir(place.path("two")).unwrap();
    fs::write(place.path("two/sweep.jsonl"), &journal[..journal.len() * 3 / 5]).unwrap();
    let object = place.cairn("map ring.csv --sweep plan.toml -o two --format json").fine().json();
    assert!((1..6).contains(&object["resumed"].as_u64().unwrap()), "{object}");
    assert_eq!(object["best"]["setting"]["sonar.correct"], true);
    let (one, two) = (place.read("one/sweep.csv"), place.read("two/sweep.csv"));
    assert_eq!(timeless(&one), timeless(&two));
    assert_eq!(place.read("one/best.toml"), place.read("two/best.toml"));
    assert!(place.read("one/sweep.html").contains("truth.rms_m against sonar.maturity_distance_m"));
    // The best settings are settings.
    place.cairn("map ring.csv --config one/best.toml -o best").fine();
}

#[test]
fn tuning_finds_what_the_sweep_found() {
    let place = place(120);
    place.write("plan.toml", PLAN);
    place.cairn("map ring.csv --sweep plan.toml -o swept").fine();
    let tuned =
        place.cairn("map ring.csv --sweep plan.toml --tune -o tuned --format json").fine().json();
    assert_eq!(tuned["settled"], true);
    assert_eq!(tuned["best"]["setting"]["sonar.correct"], true);
    assert!(place.path("tuned/tune.csv").exists());
    place.write("log.toml", &PLAN.replace("truth.rms_m", "truth.rsm_m"));
    place.cairn("map ring.csv --sweep log.toml -o no").refused(2, &["truth.rsm_m", "truth.rms_m"]);
    place.write("bad.toml", &PLAN.replace("1.2", "-1.2"));
    place.cairn("map ring.csv --sweep bad.toml -o no").refused(2, &["maturity_distance_m = -1.2"]);
}

/// The author's saved workspace of this recording: 240 short-term maps, 3124 occupied cells.
#[test]
fn the_printed_program_has_its_golden_result() {
    let Some(log) = testkit::data_folder("artemic/robot_state_U.mat") else { return };
    let place = Place::new();
    let mut command = place.command();
    command.args(["map", "--mode", "listing", "--format", "json", "-o", "out"]).arg(log);
    let summary = Place::ended(&mut command).fine().json();
    assert_eq!(whole(&summary, "registrations"), 240);
    assert_eq!(whole(&summary, "map.occupied_cells"), 3124);
    assert_eq!(whole(&summary, "map.free_cells"), 18_006);
    let yaml = place.read("out/map.yaml");
    assert!(yaml.contains("resolution: 0.05"), "{yaml}");
}
