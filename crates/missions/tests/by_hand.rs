//! A person with keys drives: what the robot does, when it stops, and that a replay repeats it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use missions::{Intervention, Mission, Recorder, Replay, Run};
use run_context::RunSeed;

/// Drives forwards at `speed_mps` for two seconds, renewed ten times a second, and lets go; then three seconds more.
/// The way driven until the hand was last felt, and after it, m.
fn ways_m(mission: &str, speed_mps: f64) -> [f64; 2] {
    let mission = Mission::load(mission, &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    // The line to the robot has to be there first, and the mission's own first goal is over.
    (0..230).for_each(|_| run.step());
    let way_m = |run: &Run| run.view().figures.path_length_m.unwrap();
    let begin_m = way_m(&run);
    for step in 0..200 {
        if step % 10 == 0 {
            run.apply(Intervention::Drive { robot: 0, speed_mps, turn_rate_radps: 0.0 }).unwrap();
        }
        run.step();
        let phase = run.view().robots[0].phase;
        assert_eq!(phase, "driven by hand", "step {step}");
    }
    let held_m = way_m(&run) - begin_m;
    (0..300).for_each(|_| run.step());
    let view = run.view();
    let robot = &view.robots[0];
    assert!(robot.wheels_mps.iter().all(|wheel_mps| wheel_mps.abs() < 1e-3), "it stands");
    assert_ne!(robot.phase, "driven by hand");
    [held_m, way_m(&run) - begin_m - held_m]
}

/// v t − v²/2a until then, with a = 0.3 m/s²; afterwards no more than the hold, the lines' delays and the braking.
#[test]
fn a_robot_goes_as_far_as_it_is_driven_and_stops_when_the_hand_is_gone() {
    for mission in ["one-obstacle", "doorbell"] {
        let [held_m, after_m] = ways_m(mission, 0.3);
        assert!((0.3..0.6).contains(&held_m), "{mission}: {held_m} m");
        let most_m = 0.3 * (0.4 + 0.25) + 0.3 * 0.3 / (2.0 * 0.3) + 0.02;
        assert!((0.1..most_m).contains(&after_m), "{mission}: {after_m} m of at most {most_m} m");
    }
}

#[test]
fn a_goal_takes_the_robot_from_the_hand_and_the_hand_from_a_goal() {
    let mission = Mission::load("one-obstacle", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    let drive = Intervention::Drive { robot: 0, speed_mps: 0.2, turn_rate_radps: 0.4 };
    (0..500).for_each(|_| run.step());
    assert!(run.view().robots[0].goal.is_some(), "it is under way to its goal");
    run.apply(drive.clone()).unwrap();
    (0..30).for_each(|_| run.step());
    assert_eq!(run.view().robots[0].goal, None, "its mind has forgotten its task");
    let goal_in_map = geometry::Se2::new(1.0, 0.5, 0.0);
    run.apply(Intervention::SendGoal { robot: 0, goal_in_map }).unwrap();
    (0..30).for_each(|_| run.step());
    assert_ne!(run.view().robots[0].phase, "driven by hand");
    assert!(run.view().robots[0].goal.is_some());
    run.apply(Intervention::Drive { robot: 0, speed_mps: f64::NAN, turn_rate_radps: 0.0 })
        .unwrap_err();
    run.apply(Intervention::Drive { robot: 9, speed_mps: 0.1, turn_rate_radps: 0.0 }).unwrap_err();
}

#[test]
fn what_was_driven_by_hand_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("by-hand.mcap");
    let mission = Mission::load("doorbell", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(3)).unwrap();
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    for step in 0..800_i32 {
        if step % 7 == 0 && (100..500).contains(&step) {
            let (speed_mps, turn_rate_radps) =
                (0.1 + f64::from(step) / 3e3, f64::from(step) / -700.0);
            run.apply(Intervention::Drive { robot: 0, speed_mps, turn_rate_radps }).unwrap();
        }
        run.step();
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
    }
    recorder.finish(&run).unwrap();
    let mut replay = Replay::open(&path).unwrap();
    while replay.step() {}
    let report = replay.report();
    assert!(report.is_identical() && report.interventions_refused.is_empty(), "{report:?}");
    assert_eq!(report.steps, 800);
    assert_eq!(replay.run().state_hash(), run.state_hash());
}
