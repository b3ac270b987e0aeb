//! `cairn drive` from end to end: scripts in simulation and over the bytes of a real robot's protocol.

#![cfg_attr(
    unix,
    expect(
        clippy::disallowed_methods,
        reason = "a drive is interrupted in the middle of its time"
    )
)]

mod support;

use std::{io::Write as _, process::Stdio};

use support::Place;

/// Forwards for 2 s at 0.3 m/s with 0.3 m/s²: v t, and what is braked behind it is what was missing before. Then about
/// 0.8 rad/s · 1 s, and the hold of half a second is cut short by the next piece.
#[test]
fn a_script_drives_as_far_as_it_says() {
    let place = Place::new();
    let pieces = "drive one-obstacle --piece 2,0.3,0 --piece 3,0,0 --format json";
    let end = place.cairn(pieces).fine().json();
    let way_m = end["path_length_m"].as_f64().unwrap();
    assert!((way_m - 0.6).abs() < 0.06, "{way_m} m");
    let pieces = "drive one-obstacle --piece 1,0,-0.8 --piece 3,0,0 --format json";
    let turned_rad = place.cairn(pieces).fine().json()["pose"][2].as_f64().unwrap();
    assert!((turned_rad + 0.8).abs() < 0.15, "{turned_rad} rad");
}

#[test]
fn standard_input_and_files_are_scripts_and_a_recording_repeats_them() {
    let place = Place::new();
    place.write("arc.txt", "# an arc\n1.5 0.2 0.4\n\n0.5 -0.1 0 # and back\n");
    let by_file =
        place.cairn("drive one-obstacle --script arc.txt --record arc.mcap --format json");
    let by_file = by_file.fine().json();
    let mut command = place.command();
    command.args(["drive", "one-obstacle", "--script", "-", "--format", "json"]);
    let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    process.stdin.take().unwrap().write_all(place.read("arc.txt").as_bytes()).unwrap();
    let output = process.wait_with_output().unwrap();
    let by_pipe: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(by_file, by_pipe);
    let replay = place.cairn("replay arc.mcap --headless --format json").fine().json();
    assert_eq!(
        (&replay["state_hash"], &replay["first_difference"]),
        (&by_file["state_hash"], &serde_json::Value::Null)
    );
}

/// Real time passes here: a robot at the end of a line has its own.
#[test]
fn a_pioneer_on_a_line_is_driven_and_stands_at_the_end() {
    let place = Place::new();
    let robot = place.serve("robot pioneer3dx --world one-obstacle --listen 127.0.0.1:0");
    let drive = format!("drive --connect {} --piece 1,0.3,0 --format json", robot.address);
    let end = place.cairn(&drive).fine().json();
    let way_m = end["path_length_m"].as_f64().unwrap();
    assert!(way_m > 0.1 && end["contacts"].is_null(), "{end}");
}

/// Sends a signal to a process by the system's own program for that.
#[cfg(unix)]
#[expect(clippy::unwrap_used, reason = "a failing helper fails its test")]
fn signal(process: &std::process::Child, name: &str) {
    let mut kill = std::process::Command::new("kill");
    assert!(kill.args([name, &process.id().to_string()]).status().unwrap().success());
}

/// Whether a closed terminal is told to the programs that are begun here: under `nohup` none is.
#[cfg(unix)]
fn hears_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_none_or(|mask| mask & 1 == 0)
}

/// The script's first piece would last for minutes: the robot stands when the program is asked to end.
#[cfg(unix)]
#[test]
fn a_drive_that_is_interrupted_leaves_its_robot_standing() {
    let place = Place::new();
    let robot = place.serve("robot pioneer3dx --world one-obstacle --listen 127.0.0.1:0");
    let names = if hears_hangups() { &["-INT", "-TERM", "-HUP"][..] } else { &["-INT", "-TERM"] };
    for &name in names {
        let mut command = place.command();
        command.args(["drive", "--connect", &robot.address, "--piece", "300,0,0.5"]);
        command.args(["--format", "json"]).stdout(Stdio::piped());
        let process = command.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(2500));
        signal(&process, name);
        let output = process.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{name}");
        let end: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let time_s = end["time_s"].as_f64().unwrap();
        assert!((0.6..60.0).contains(&time_s), "{name}: it was let go and stands: {end}");
    }
}

/// The script does not end: its writer holds the line open and says nothing more.
#[cfg(unix)]
#[test]
fn a_recording_of_an_interrupted_drive_is_whole() {
    let place = Place::new();
    let mut command = place.command();
    command.args(["drive", "one-obstacle", "--script", "-", "--record", "cut.mcap"]);
    let mut process = command.stdin(Stdio::piped()).spawn().unwrap();
    let mut script = process.stdin.take().unwrap();
    script.write_all(b"2 0.3 0\n").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2500));
    signal(&process, "-TERM");
    assert_eq!(process.wait().unwrap().code(), Some(130));
    drop(script);
    place.cairn("replay cut.mcap --headless --format json").fine();
    assert!(!place.path("cut.mcap.part").exists());
}

/// Its robot is gone, and would be waited for: 4 s at the first signal, and no longer at the second.
#[cfg(unix)]
#[test]
fn a_studio_that_is_interrupted_twice_waits_for_no_robot() {
    let pause = |millis| std::thread::sleep(std::time::Duration::from_millis(millis));
    let place = Place::new();
    let robot = place.serve("robot pioneer3dx --world one-obstacle --listen 127.0.0.1:0");
    let mut command = place.command();
    command.args(["run", "one-obstacle", "--port", "0", "--set", "robots.line.kind=tcp"]);
    command.args(["--set", &format!("robots.line.address={}", robot.address)]);
    let mut process = command.stdout(Stdio::null()).spawn().unwrap();
    pause(2500);
    drop(robot);
    pause(300);
    signal(&process, "-INT");
    pause(300);
    assert!(process.try_wait().unwrap().is_none(), "it waits for the robot");
    let second = std::time::Instant::now();
    signal(&process, "-INT");
    assert_eq!(process.wait().unwrap().code(), Some(130));
    assert!(second.elapsed().as_secs_f64() < 2.0);
}

#[test]
fn a_script_that_fails_half_way_leaves_a_whole_recording_and_a_long_one_is_not_cut() {
    let place = Place::new();
    let drive = "drive one-obstacle --script - --record half.mcap";
    place.piped(drive, "1 0.2 0\n1 fast 0\n").refused(2, &["standard input:2", "fast"]);
    place.cairn("replay half.mcap --headless").fine();
    let long = "# nothing, as long as it takes\n".repeat((1 << 20) / 31 + 2);
    place.piped("drive one-obstacle --script -", &long).refused(2, &["at most 1048576 bytes"]);
}

#[test]
fn what_cannot_be_driven_is_refused_with_2() {
    let place = Place::new();
    place.write("wrong.txt", "1 0.2 0\n1 fast 0\n");
    place
        .cairn("drive doorbell --script wrong.txt")
        .refused(2, &["wrong.txt:2", "fast", "2 0.3 0"]);
    place.cairn("drive doorbell --script nowhere.txt").refused(2, &["nowhere.txt"]);
    place.cairn("drive doorbell").refused(2, &["no terminal", "--script"]);
    place.cairn("drive doorbell --robot nobody --piece 1,0,0").refused(2, &["nobody", "assistant"]);
    place.cairn("drive doorbell --piece 1,2").refused(2, &["--piece:1", "three numbers"]);
    place
        .cairn("drive --connect 127.0.0.1:1 --piece 1,0,0")
        .refused(2, &["127.0.0.1:1", "switched on"]);
    place.cairn("drive decision-rig --piece 1,0,0").refused(2, &["no robot to drive"]);
}
