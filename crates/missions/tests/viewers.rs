//! What other programs see in a recording: messages with public schemas, read by a reader that is not ours.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{collections::BTreeMap, fs, path::Path};

use mcap::MessageStream;
use missions::{Mission, Recorder, Replay, Run};
use run_context::RunSeed;
use serde_json::Value;

fn record(path: &Path, name: &str, overrides: &[&str], steps: u64) {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let mut run = Run::new(Mission::load(name, &overrides).unwrap(), RunSeed(1)).unwrap();
    let mut recorder = Recorder::create(path, &run, &files::Outputs::new(false)).unwrap();
    for _ in 0..steps {
        run.step();
        let log = run.drain_log();
        recorder.record(&run, &log).unwrap();
    }
    recorder.finish(&run).unwrap();
}

/// Of each topic its schema's name, and its messages with their times (s).
type Topics = BTreeMap<String, (Option<String>, Vec<(f64, Value)>)>;

fn read(path: &Path) -> (Topics, usize, usize) {
    let bytes = fs::read(path).unwrap();
    let mut topics = Topics::new();
    let (mut own_bytes, mut other_bytes) = (0, 0);
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().map(|schema| {
            assert_eq!(schema.encoding, "jsonschema");
            let text: Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!(text["title"], schema.name);
            schema.name.clone()
        });
        let is_own = message.channel.topic.starts_with("/cairn/");
        assert_eq!(is_own, schema.is_none(), "{}", message.channel.topic);
        *(if is_own { &mut own_bytes } else { &mut other_bytes }) += message.data.len() + 31;
        let entry = topics.entry(message.channel.topic.clone()).or_default();
        entry.0 = schema;
        // Hashes and scans are no text.
        let value = serde_json::from_slice(&message.data).unwrap_or(Value::Null);
        assert!(is_own || value.is_object());
        entry.1.push((message.log_time as f64 * 1e-9, value));
    }
    (topics, own_bytes, other_bytes)
}

#[test]
fn another_reader_finds_poses_transforms_scene_path_and_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ward.mcap");
    record(&path, "ward-call", &[], 2000);
    let (topics, own_bytes, other_bytes) = read(&path);
    let schema = |topic: &str| topics[topic].0.clone().unwrap();
    assert_eq!(schema("/tf"), "foxglove.FrameTransforms");
    assert_eq!(schema("/carrier/pose"), "foxglove.PoseInFrame");
    assert_eq!(schema("/carrier/truth"), "foxglove.PoseInFrame");
    assert_eq!(schema("/carrier/path"), "foxglove.PosesInFrame");
    assert_eq!(schema("/carrier/sonar"), "foxglove.SceneUpdate");
    assert_eq!(schema("/scene"), "foxglove.SceneUpdate");
    assert_eq!(schema("/log"), "foxglove.Log");
    println!("{own_bytes} bytes of our own topics, {other_bytes} of those for viewers");
    assert!(other_bytes < own_bytes, "viewers would double the file");

    // The poses are those of the states, to a tenth of a millimetre.
    let states = &topics["/cairn/state"].1;
    let poses = &topics["/carrier/truth"].1;
    assert_eq!((states.len(), poses.len()), (200, 100));
    for (time_s, message) in poses {
        let (_, state) = states.iter().find(|(t, _)| (t - time_s).abs() < 1e-6).unwrap();
        let truth = &state["robots"][0]["truth"];
        let at = &message["pose"]["position"];
        for (i, axis) in ["x", "y"].into_iter().enumerate() {
            let off = truth[i].as_f64().unwrap() - at[axis].as_f64().unwrap();
            assert!(off.abs() < 6e-5, "{off} m at {time_s} s");
        }
        let turn = &message["pose"]["orientation"];
        let yaw = 2.0 * turn["z"].as_f64().unwrap().atan2(turn["w"].as_f64().unwrap());
        let off = (truth[2].as_f64().unwrap() - yaw).sin();
        assert!(off.abs() < 1e-5, "{off} rad at {time_s} s");
        let stamp = message["timestamp"]["sec"].as_f64().unwrap()
            + 1e-9 * message["timestamp"]["nsec"].as_f64().unwrap();
        assert!((stamp - time_s).abs() < 1e-6);
    }
    // Everything in words is there twice.
    assert_eq!(topics["/log"].1.len(), topics["/cairn/log"].1.len());
}

#[test]
fn the_scene_holds_the_walls_of_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ward.mcap");
    record(&path, "ward-call", &[], 100);
    let (topics, ..) = read(&path);
    let run = Run::new(Mission::load("ward-call", &[]).unwrap(), RunSeed(1)).unwrap();
    let (_, first) = &topics["/scene"].1[0];
    let entities = first["entities"].as_array().unwrap();
    let walls = entities.iter().find(|entity| entity["id"] == "walls").unwrap();
    let points = walls["lines"][0]["points"].as_array().unwrap();
    assert_eq!(
        (&walls["lines"][0]["type"], points.len()),
        (&2.into(), 2 * run.scene().walls.len())
    );
    assert!(points.len() > 200, "{}", points.len());
    assert!(entities.iter().any(|entity| entity["id"] == "carrier"));
    // The nurse walks.
    let nurse =
        |v: &(f64, Value)| v.1["entities"].as_array().unwrap().iter().any(|e| e["id"] == "nurse");
    assert!(topics["/scene"].1[1..].iter().all(nurse));
}

#[test]
fn a_box_that_comes_and_goes_does_so_in_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut run = Run::new(Mission::load("one-obstacle", &[]).unwrap(), RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    for step in 0..200 {
        if step == 50 {
            let at = geometry::Vec2::new(2.0, 0.9);
            run.apply(missions::Intervention::PlaceBox { at, size_m: 0.3 }).unwrap();
        }
        if step == 150 {
            let id = run.view().things.last().unwrap().id;
            run.apply(missions::Intervention::RemoveThing { id }).unwrap();
        }
        run.step();
        recorder.record(&run, &[]).unwrap();
    }
    recorder.finish(&run).unwrap();
    let (topics, ..) = read(&path);
    let scenes = &topics["/scene"].1;
    assert_eq!(scenes.len(), 3, "at the beginning, the box, and its end");
    assert_eq!(scenes[1].1["entities"][0]["lines"][0]["points"].as_array().unwrap().len(), 4);
    assert_eq!(scenes[2].1["deletions"][0]["id"], scenes[1].1["entities"][0]["id"]);
    let report = Replay::open(&path).unwrap().run_to_end();
    assert!(report.is_identical(), "{report:?}");
}

#[test]
fn a_swarm_has_one_topic_of_transforms() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("swarm.mcap");
    record(&path, "swarm", &["robots.count=40"], 200);
    let (topics, own_bytes, other_bytes) = read(&path);
    assert_eq!(topics["/tf"].1.len(), 2);
    assert_eq!(topics["/tf"].1[0].1["transforms"].as_array().unwrap().len(), 80);
    assert!(!topics.keys().any(|topic| topic.ends_with("/pose")));
    assert!(other_bytes < own_bytes);
}
