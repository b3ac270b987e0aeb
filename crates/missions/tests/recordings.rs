//! Recordings: what was recorded comes out the same when it is run again.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{collections::BTreeMap, fs, path::Path};

use geometry::{Se2, Vec2};
use missions::{Intervention, Mission, Recorder, Replay, Run};
use run_context::RunSeed;

/// Records so many steps, with two interventions on the way; gives the last hash.
fn record(path: &Path, steps: u64) -> u64 {
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(path, &run, &files::Outputs::new(false)).unwrap();
    for step in 0..steps {
        if step == 300 {
            let at = Vec2::new(2.0, 0.9);
            run.apply(Intervention::PlaceBox { at, size_m: 0.3 }).unwrap();
        }
        if step == 600 {
            let goal_in_map = Se2::new(1.0, -1.5, 0.5);
            run.apply(Intervention::SendGoal { robot: 0, goal_in_map }).unwrap();
        }
        run.step();
        let log = run.drain_log();
        recorder.record(&run, &log).unwrap();
    }
    let hash = run.state_hash().value();
    assert_eq!(recorder.finish(&run).unwrap(), path);
    hash
}

#[test]
fn a_replay_has_the_same_hash_at_every_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let last = record(&path, 1000);
    assert!(!folder.path().join("run.mcap.part").exists());

    let mut replay = Replay::open(&path).unwrap();
    let report = replay.run_to_end();
    assert_eq!(report.divergence, None);
    assert_eq!((report.steps, report.steps_recorded), (1000, Some(1000)));
    assert_eq!(report.truncation, None);
    assert_eq!(replay.run().state_hash().value(), last);
    assert_eq!(replay.run().interventions().len(), 2, "the interventions were not repeated");
}

#[test]
fn a_replay_never_moves_a_robot_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 10);
    let elsewhere = ["robots.link.kind=tcp", "robots.link.address=127.0.0.1:9"];
    let error = Replay::open_with(&path, &elsewhere.map(ToOwned::to_owned)).unwrap_err();
    assert!(error.to_string().contains("robots.link.kind=memory"), "{error}");
}

#[test]
fn a_replay_with_another_parameter_names_the_first_difference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 700);
    let slower = ["robots.navigator.speed_mps=0.2".to_owned()];
    let report = Replay::open_with(&path, &slower).unwrap().run_to_end();
    let divergence = report.divergence.unwrap();
    // The goal is given at 2 s; before that the speed means nothing.
    assert!((200..400).contains(&divergence.step), "{divergence:?}");
    assert!(!report.is_identical());
}

#[test]
fn a_recording_that_breaks_off_is_replayed_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 3000);
    let whole = fs::read(&path).unwrap();
    let cut = folder.path().join("cut.mcap");
    fs::write(&cut, &whole[..whole.len() / 2]).unwrap();

    let report = Replay::open(&cut).unwrap().run_to_end();
    assert_eq!(report.divergence, None);
    assert_eq!(report.steps_recorded, None);
    assert!(report.steps > 0 && report.steps < 3000, "{} steps", report.steps);
    let said = report.truncation.unwrap();
    assert!(said.contains(&format!("after {} steps", report.steps)), "{said}");
}

#[test]
fn a_run_that_dies_leaves_a_part_that_replays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    for _ in 0..500 {
        run.step();
        recorder.record(&run, &[]).unwrap();
    }
    // Dropping the recorder without `finish` is what a crash with unwinding does.
    drop(recorder);
    assert!(!path.exists(), "a name stands for a whole recording");
    let report = Replay::open(&folder.path().join("run.mcap.part")).unwrap().run_to_end();
    assert!(report.truncation.is_some());
    assert_eq!(report.divergence, None);
}

#[test]
fn a_file_that_is_no_recording_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("notes.mcap");
    fs::write(&text, "these are notes").unwrap();
    let said = Replay::open(&text).unwrap_err().to_string();
    assert!(said.contains("is no recording of a mission"), "{said}");
    let absent = Replay::open(&folder.path().join("absent.mcap")).unwrap_err().to_string();
    assert!(absent.contains("cannot be read"), "{absent}");
}

#[test]
fn recordings_of_the_first_layout_still_replay_and_those_to_come_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |format: u32| {
        let path = folder.path().join(format!("format-{format}.mcap"));
        let mission = Mission::load("one-obstacle", &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(2)).unwrap();
        let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
        let mut write = |topic: &str, data: &[u8]| {
            let channel = writer.add_channel(0, topic, "", &BTreeMap::new()).unwrap();
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: 0,
                log_time: 0,
                publish_time: 0,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        };
        // Text without the keys that came later; what is absent has the value that it had then.
        let later = ["range_min_m", "range_step_m", "drift_degpm"];
        let resolved = run.mission().to_toml();
        let is_old = |line: &&str| !later.iter().any(|key| line.starts_with(key));
        let mission = resolved.lines().filter(is_old).collect::<Vec<_>>().join("\n");
        assert!(mission.len() < resolved.len());
        let head =
            serde_json::json!({"format": format, "cairn": "0.1.0", "seed": 2, "mission": mission});
        write("/cairn/head", head.to_string().as_bytes());
        for _ in 0..400 {
            run.step();
            let hash = run.state_hash().value();
            write("/cairn/hash", &[run.steps().to_le_bytes(), hash.to_le_bytes()].concat());
        }
        writer.finish().unwrap();
        path
    };
    let report = Replay::open(&write(1)).unwrap().run_to_end();
    assert_eq!((report.steps, report.divergence), (400, None));
    let said = Replay::open(&write(3)).unwrap_err().to_string();
    assert!(said.contains("its layout is 3, this version reads 1 to 2"), "{said}");
}
