//! Recordings: what was recorded comes out the same when it is run again.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead as _, BufReader, Write as _},
    path::Path,
};

use geometry::{Se2, Vec2};
use missions::{Intervention, Mission, Recorder, Replay, Run, Seek};
use rand_core::Rng as _;
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

/// A recording of the last build before the words changed.
#[test]
fn a_recording_with_older_words_is_read_with_those_of_today_and_says_so() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases/older-words.mcap");
    let path = std::path::Path::new(file);
    let mut replay = Replay::open(path).unwrap();
    let report = replay.run_to_end();
    assert_eq!((report.steps, report.steps_recorded), (10, Some(10)));
    let build = report.other_build.unwrap();
    assert!(build.contains("keys or words had other names"), "{build}");
    assert!(replay.notes().iter().any(|note| note.contains("read as those of today")));
    // The mission is the one that it was.
    let mission = replay.run().mission();
    let written = [
        "line.kind=direct",
        "mind.how.method=straight",
        "mind.where_am_i.method=tag_fixes",
        "mind.follow.tags.law=gradient",
    ];
    let sets: Vec<String> = written.iter().map(|set| format!("robots.{set}")).collect();
    let same = Mission::parse("same", &mission.to_toml(), &sets).unwrap();
    assert_eq!(same.file(), mission.file());
    // What is set now is answered as ever.
    let set = ["robots.navigator.route=direct".to_owned()];
    let told = Replay::open_with(path, &set).map(|_| ()).unwrap_err().to_string();
    assert!(
        told.contains(
            "--set robots.navigator.route=direct: robots.navigator.route: this key is now"
        ),
        "{told}"
    );
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
    let elsewhere = ["robots.line.kind=tcp", "robots.line.address=127.0.0.1:9"];
    let error = Replay::open_with(&path, &elsewhere.map(ToOwned::to_owned)).unwrap_err();
    assert!(error.to_string().contains("robots.line.kind=memory"), "{error}");
}

#[test]
fn a_replay_with_another_parameter_names_the_first_difference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 700);
    let slower = ["robots.mind.follow.speed_mps=0.2".to_owned()];
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
    let said = report.truncation.clone().unwrap();
    assert!(said.contains(&format!("after {} steps", report.steps)), "{said}");
    // A cut in the middle of a piece is no clean end: what is left out is named.
    assert!(report.damage[0].contains("was not written whole") && !report.is_identical());
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
    assert!(report.truncation.is_some() && report.is_identical(), "{report:?}");
    assert_eq!(report.steps, 500);
}

#[test]
fn a_file_that_is_no_recording_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("notes.mcap");
    fs::write(&text, "these are notes").unwrap();
    let said = Replay::open(&text).unwrap_err().to_string();
    assert!(said.contains("is no recording of a mission"), "{said}");
    let absent = Replay::open(&folder.path().join("absent.mcap")).unwrap_err().to_string();
    assert!(absent.contains("cannot read the recording"), "{absent}");
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
    // Whose states they are is not known: that is said, and no other reason is made up for differences.
    assert!(report.other_build.unwrap().contains("an earlier build (layout 1)"));
    let said = Replay::open(&write(4)).unwrap_err().to_string();
    assert!(said.contains("its layout is 4, this version reads 1 to 3"), "{said}");
}

/// The bytes of a recording: finished, or as a killed program leaves it.
fn bytes_of_a_run(steps: u64, finished: bool) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    if finished {
        record(&path, steps);
        return fs::read(path).unwrap();
    }
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    for _ in 0..steps {
        run.step();
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
    }
    drop(recorder);
    fs::read(folder.path().join("run.mcap.part")).unwrap()
}

/// A thousand single bytes, each changed to something else: none passes for the recording.
#[test]
fn a_thousand_damaged_bytes_are_a_thousand_times_named() {
    let name = Path::new("damaged.mcap");
    let mut random = RunSeed(1).stream("test/damage");
    let (mut n_refused, mut n_named) = (0, 0);
    for finished in [true, false] {
        let whole = bytes_of_a_run(150, finished);
        let found = Replay::from_bytes(name, &whole, &[]).unwrap().run_to_end();
        assert!(found.is_identical() && found.steps == 150, "{found:?}");
        let mut bytes = whole.clone();
        for _ in 0..500 {
            let at = (random.next_u64() % whole.len() as u64) as usize;
            let flip = 1 + (random.next_u64() % 255) as u8;
            bytes[at] ^= flip;
            match Replay::from_bytes(name, &bytes, &[]) {
                Err(error) => {
                    let said = error.to_string();
                    assert!(said.contains("damaged") || said.contains("MCAP"), "byte {at}: {said}");
                    n_refused += 1;
                }
                Ok(replay) => {
                    let report = replay.report();
                    assert!(!report.damage.is_empty(), "byte {at} ^ {flip:#04x}: silent");
                    assert!(!report.is_identical() && !replay.notes().is_empty());
                    n_named += 1;
                }
            }
            bytes[at] ^= flip;
        }
    }
    println!("1000 damages: {n_named} named and replayed, {n_refused} named and refused, 0 silent");
}

/// Killed between any two steps, the file is whole up to at most half a second before.
#[test]
fn wherever_a_run_is_killed_its_last_second_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let (path, part) = (folder.path().join("run.mcap"), folder.path().join("run.mcap.part"));
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    let mut sizes = vec![fs::metadata(&part).unwrap().len()];
    for _ in 0..1000 {
        run.step();
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
        sizes.push(fs::metadata(&part).unwrap().len());
    }
    let whole = fs::read(&part).unwrap();
    let mut most_lost = 0;
    for (step, size) in sizes.iter().enumerate() {
        let mut replay = Replay::from_bytes(&part, &whole[..*size as usize], &[]).unwrap();
        let lost = step as u64 - replay.n_steps();
        most_lost = lost.max(most_lost);
        if step.is_multiple_of(100) {
            let report = replay.run_to_end();
            assert!(
                report.is_identical() && report.truncation.is_some(),
                "step {step}: {report:?}"
            );
        } else {
            assert!(replay.report().damage.is_empty(), "step {step}");
        }
    }
    println!("killed after each of 1000 steps: at most {most_lost} steps lost, 0 unreadable");
    assert!(most_lost < 100, "{most_lost} steps of 10 ms");
}

/// What the next test starts in a process of its own: it records and says each step, until it is killed.
#[test]
fn a_child_that_records() {
    let Some(path) = std::env::var_os("CAIRN_TEST_RECORD_TO") else { return };
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(2)).unwrap();
    let mut recorder =
        Recorder::create(Path::new(&path), &run, &files::Outputs::new(false)).unwrap();
    let mut out = std::io::stdout().lock();
    for step in 1..=100_000_u64 {
        run.step();
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
        // One write for each step: what was said was done.
        out.write_all(format!("step {step}\n").as_bytes()).unwrap();
        out.flush().unwrap();
    }
}

/// True kills, at moments that nobody chose. `CAIRN_KILLS=1000` for as many.
#[test]
fn a_killed_process_leaves_all_but_its_last_second() {
    let n_kills: u64 = std::env::var("CAIRN_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let folder = tempfile::tempdir().unwrap();
    let (mut most_lost, mut n_torn, mut n_steps) = (0, 0, 0);
    for kill in 0..n_kills {
        let path = folder.path().join(format!("{kill}.mcap"));
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "a_child_that_records", "--nocapture"])
            .env("CAIRN_TEST_RECORD_TO", &path)
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let wanted = format!("step {}", 1 + (kill * 7919) % 977);
        lines.find(|line| *line == wanted).expect("it records");
        child.kill().unwrap();
        child.wait().unwrap();
        let said = lines.filter_map(|line| line.strip_prefix("step ")?.parse().ok()).last();
        let last: u64 = said.unwrap_or_else(|| wanted[5..].parse().unwrap());
        let part = folder.path().join(format!("{kill}.mcap.part"));
        let mut replay = Replay::open(&part).expect("0 unreadable");
        most_lost = most_lost.max(last.saturating_sub(replay.n_steps()));
        n_steps += last;
        n_torn += u64::from(!replay.report().damage.is_empty());
        if kill.is_multiple_of(10) {
            assert_eq!(replay.run_to_end().divergence, None);
        }
        fs::remove_file(part).unwrap();
    }
    println!(
        "{n_kills} kills at step {} on average: at most {most_lost} steps of 10 ms lost, {n_torn} ended within a \
         piece, 0 unreadable",
        n_steps / n_kills
    );
    assert!(most_lost <= 100);
}

#[test]
fn a_replay_goes_to_any_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 700);
    // The states, got the straight way.
    let mut straight = Replay::open(&path).unwrap();
    let mut hashes = vec![straight.run().state_hash().value()];
    while straight.step() {
        hashes.push(straight.run().state_hash().value());
    }
    let mut replay = Replay::open(&path).unwrap();
    assert_eq!(replay.n_steps(), 700);
    for target in [650, 120, 121, 0, 700, 699, 305, 9999, 1] {
        let expected = target.min(700);
        loop {
            let before = replay.run().steps();
            let found = replay.seek(target, 64).unwrap();
            let (at, back) = (replay.run().steps(), before > expected);
            assert!(at <= expected && (back || at - before <= 64), "{before} to {at}");
            match found {
                Seek::There => break,
                Seek::OnTheWay { steps_left } => assert_eq!(steps_left, expected - at),
            }
        }
        assert_eq!(replay.run().steps(), expected);
        assert_eq!(replay.run().state_hash().value(), hashes[expected as usize], "step {expected}");
    }
    let report = replay.run_to_end();
    assert!(report.is_identical() && report.interventions_repeated == 2, "{report:?}");
}

#[test]
fn a_changed_replay_runs_on_to_its_own_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    record(&path, 700);
    assert!(Replay::open(&path).unwrap().run().finished().is_none());
    let slower = ["robots.mind.follow.speed_mps=0.2".to_owned()];
    let mut replay = Replay::open_with(&path, &slower).unwrap();
    let report = replay.run_to_end();
    let verdict = replay.run().finished().expect("a verdict of its own");
    assert!(replay.run().steps() > 700, "{verdict:?}");
    assert_eq!((report.steps, report.interventions_repeated), (700, 2));
    assert_eq!((&report.interventions_refused[..], report.interventions_left), (&[][..], 0));
    // The robot stands where the box was put down: the box is refused, which is named with its time.
    let there = ["robots.start=[2.0, 0.9, 0.0]".to_owned()];
    let mut replay = Replay::open_with(&path, &there).unwrap();
    let report = replay.run_to_end();
    assert!(replay.run().finished().is_some());
    let refused = &report.interventions_refused[..];
    assert!(refused.len() == 1 && refused[0].starts_with("at 3.00 s: a box"), "{report:?}");
}

/// A run that was stopped in mid-drive is recorded with the order to stand: under other settings nobody gave it.
#[test]
fn a_changed_replay_of_a_run_that_was_stopped_comes_to_its_own_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut run = Run::new(Mission::load("one-obstacle", &[]).unwrap(), RunSeed(2)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    while run.steps() < 500 || run.step_to_rest() {
        if run.steps() < 500 {
            run.step();
        }
        let log = run.drain_log();
        recorder.record(&run, &log).unwrap();
    }
    recorder.finish(&run).unwrap();
    assert!(run.finished().is_none() && run.interventions().len() == 1);
    let slower = ["robots.mind.follow.speed_mps=0.2".to_owned()];
    let mut replay = Replay::open_with(&path, &slower).unwrap();
    let n_steps_max = replay.run().mission().duration_max().as_millis() as u64 / 10 + 1;
    while replay.step() {
        assert!(replay.run().steps() <= n_steps_max, "it does not end");
    }
    assert!(replay.run().finished().is_some());
    let report = replay.report();
    assert_eq!((report.interventions_repeated, report.interventions_not_repeated), (0, 1));
    // Unchanged, it is repeated like everything else.
    let report = Replay::open(&path).unwrap().run_to_end();
    assert!(report.is_identical() && report.interventions_repeated == 1, "{report:?}");
}

/// Other programs that read MCAP: the format's own library finds every message, and the summary.
#[test]
fn the_formats_own_library_reads_a_recording() {
    let bytes = bytes_of_a_run(150, true);
    let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    let hashes = messages.iter().filter(|m| m.channel.topic == "/cairn/hash").count();
    assert_eq!(hashes, 150);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let stats = summary.stats.unwrap();
    assert_eq!(stats.message_count, messages.len() as u64);
    assert_eq!(summary.chunk_indexes.len() as u32, stats.chunk_count);
    assert!(stats.chunk_count >= 4, "{}", stats.chunk_count);
}
