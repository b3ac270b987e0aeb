//! Goals on trails as a person sends them: with junctions, beside the trails, and where no trail leads.
//!
//! `GOALS=1 cargo test -p cairn_missions --test trails -- --nocapture` prints what happens to each
//! goal of a grid over the flat of `doorbell`; `SEEDS=100` drives the errands of `trail-junctions`
//! with so many seeds.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use geometry::Se2;
use missions::{Intervention, Mission, Run};
use run_context::RunSeed;

/// The flat of `doorbell` without its bell: nobody but the test sends the robot anywhere.
fn quiet_flat() -> Mission {
    let text = include_str!("../../../missions/doorbell.toml");
    let (head, rest) = text.split_once("[[devices]]").unwrap();
    let (_, rest) = rest.split_once("[[robots]]").unwrap();
    let (robot, _) = rest.split_once("[decision]").unwrap();
    let folder = std::env::temp_dir().join(format!("cairn-trails-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("quiet-flat.toml");
    let people = head.find("# Sits in the kitchen").unwrap();
    let text = format!(
        "{}[[robots]]{robot}[success]\nno_contact = true\n",
        &head[..people].replace("duration_max_s = 180.0", "duration_max_s = 900.0")
    );
    std::fs::write(&file, text).unwrap();
    Mission::load(file.to_str().unwrap(), &[]).unwrap()
}

struct Ending {
    /// The last sentence about the task.
    said: String,
    arrived: bool,
    after_s: f64,
    /// When the log first said something about the goal, seconds after it was sent.
    answered_s: f64,
    contacts: f64,
    error_m: f64,
}

fn send(mission: &Mission, x_m: f64, y_m: f64) -> Ending {
    let mut run = Run::new(mission.clone(), RunSeed(1)).unwrap();
    for _ in 0..50 {
        run.step();
    }
    run.drain_log();
    let goal_in_map = Se2::new(x_m, y_m, 0.0);
    run.apply(Intervention::SendGoal { robot: 0, goal_in_map }).unwrap();
    let mut answered_s = f64::INFINITY;
    for step in 0..60_000_u32 {
        run.step();
        let after_s = 0.01 * f64::from(step);
        let news = run.drain_log();
        // Where the goal is beside the robot, it goes there at once.
        let words = ["looking for a trail to", "approaching the goal"];
        if news.iter().any(|item| words.iter().any(|word| item.text.contains(word))) {
            answered_s = answered_s.min(after_s);
        }
        let ended = news
            .iter()
            .any(|item| item.text.contains("gives up") || item.text.contains("stands at its goal"));
        if ended || step == 59_999 {
            let view = run.view();
            let robot = &view.robots[0];
            return Ending {
                said: robot.task.clone(),
                arrived: robot.phase == "arrived",
                after_s,
                answered_s,
                contacts: run.summary().figure("contacts").unwrap(),
                error_m: (robot.truth.x_m - x_m).hypot(robot.truth.y_m - y_m),
            };
        }
    }
    unreachable!("the loop ends above")
}

#[test]
fn every_goal_in_the_flat_is_reached_or_refused_in_words() {
    let mission = quiet_flat();
    let all = std::env::var("GOALS").is_ok();
    let (mut n_arrived, mut n_refused, mut n) = (0, 0, 0);
    let spacing_m = if all { 1.0 } else { 2.5 };
    for row in 0..20 {
        for column in 0..20 {
            let (x, y) = (-5.5 + spacing_m * f64::from(column), -4.0 + spacing_m * f64::from(row));
            if x > 5.6 || y > 4.1 {
                continue;
            }
            let ending = send(&mission, x, y);
            n += 1;
            n_arrived += u32::from(ending.arrived);
            n_refused += u32::from(ending.said.contains("no trail leads to the goal; the nearest"));
            if all {
                let Ending { said, after_s, contacts, .. } = &ending;
                println!("| {x:.1}, {y:.1} | {said} | {after_s:.0} s | {contacts:.0} |");
            }
            let Ending { answered_s, contacts, error_m, arrived, said, .. } = ending;
            assert!(answered_s < 1.0, "({x}, {y}): a word after {answered_s} s");
            assert!(contacts < 0.5, "({x}, {y}): {contacts} contacts, {said}");
            assert!(arrived || said.contains("gave up"), "({x}, {y}): {said}");
            assert!(!arrived || error_m < 0.3, "({x}, {y}): {error_m} m beside it");
        }
    }
    println!("{n} goals: {n_arrived} reached, {n_refused} refused because no trail leads there");
    assert!(n_arrived >= 2 && n_refused >= 2);
}

#[test]
fn the_errands_over_junctions_are_all_done() {
    let n_seeds = std::env::var("SEEDS").map_or(3, |n| n.parse().unwrap());
    let (mut n_passed, mut n_touched, mut off_m) = (0, 0, 0.0_f64);
    for seed in 1..=n_seeds {
        let mission = Mission::load("trail-junctions", &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(seed)).unwrap();
        let verdict = run.run_to_end().clone();
        let summary = run.summary();
        n_passed += u64::from(verdict.passed);
        n_touched += u64::from(summary.figure("contacts") != Some(0.0));
        if !verdict.passed {
            println!("seed {seed}: {verdict:#?}");
            continue;
        }
        // By the lines of the mission file the shortest ways are 9.9, 11.3, 7.2 and 4.2 m; corners
        // are cut.
        let path_length_m = summary.figure("path_length_m").unwrap();
        assert!((27.0..34.0).contains(&path_length_m), "seed {seed}: {path_length_m} m");
        let cross_track_m = summary.figure("cross_track_rms_m").unwrap();
        assert!(cross_track_m < 0.3, "seed {seed}: {cross_track_m} m off the nearest trail");
        off_m = cross_track_m.max(off_m);
    }
    println!(
        "errands: {n_passed} of {n_seeds} seeds done, {n_touched} touched something; {off_m:.3} m off the trails, rms, at most"
    );
    // 98 of the first 100: a door post that no sonar has heard is driven into now and then.
    assert!(n_passed * 100 >= n_seeds * 98 && n_touched * 100 <= n_seeds * 2);
}

/// Without the scouted way the antennas decide at junctions: they smell both branches at once.
#[test]
fn antennas_alone_do_not_do_the_errands() {
    let keys = ["robots.mind.how.preview_m=0".to_owned(), "mission.duration_max_s=150".to_owned()];
    let mission = Mission::load("trail-junctions", &keys).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    assert!(!run.run_to_end().passed);
}
