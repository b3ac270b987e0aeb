//! How runs end: standing, and repeatably.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use missions::{Direction, Intervention, InterventionError, Line, Mission, Recorder, Replay, Run};
use run_context::RunSeed;

fn start(name: &str, overrides: &[&str]) -> Run {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    Run::new(Mission::load(name, &overrides).unwrap(), RunSeed(1)).unwrap()
}

fn fastest_wheel_mps(run: &Run) -> f64 {
    let wheels = run.view().robots.into_iter().flat_map(|robot| robot.wheels_mps);
    wheels.fold(0.0, |fastest, wheel| fastest.max(wheel.abs()))
}

#[test]
fn when_the_time_is_over_in_mid_drive_the_run_steps_on_until_the_wheels_stand() {
    for link in ["memory", "direct"] {
        let kind = format!("robots.line.kind={link}");
        let mut run = start("one-obstacle", &["mission.duration_max_s=6", &kind]);
        while run.finished().is_none() {
            run.step();
        }
        assert!(fastest_wheel_mps(&run) > 0.2, "{link}");
        let verdict = run.finished().cloned().unwrap();
        assert!(!verdict.passed, "{link}");
        assert_eq!(run.run_to_end(), &verdict, "{link}");
        assert!(fastest_wheel_mps(&run) < 1e-9, "{link}");
        // From 0.3 m/s at 0.3 m/s²: a second, and what a packet takes.
        assert!((690..740).contains(&run.steps()), "{link}: {}", run.steps());
        assert_eq!(run.summary().figure("rolling_robots"), Some(0.0));
        assert_eq!(run.interventions().len(), 1);
    }
}

#[test]
fn a_run_that_stands_at_its_verdict_takes_no_further_step() {
    let mut run = start("one-obstacle", &[]);
    run.run_to_end();
    let steps = run.steps();
    assert!(!run.step_to_end() && !run.step_to_rest());
    assert_eq!((run.steps(), run.interventions().len()), (steps, 0));
}

#[test]
fn after_it_was_told_to_stand_a_run_takes_no_more_orders() {
    let mut run = start("one-obstacle", &[]);
    for _ in 0..500 {
        run.step();
    }
    while run.step_to_rest() {}
    assert!(run.finished().is_none());
    let stop = Intervention::Stop { robot: 0 };
    assert_eq!(run.apply(stop).unwrap_err(), InterventionError::Halted);
    for _ in 0..500 {
        run.step();
    }
    assert!(fastest_wheel_mps(&run) < 1e-9);
}

/// The order is on the line, or not yet sent, when the halt comes; later it arrives, or is repeated.
#[test]
fn an_order_under_way_at_the_halt_does_not_set_the_robot_off_again() {
    for (latency_ms, steps_between) in [(400, 0), (400, 1), (400, 30), (400, 60), (5, 1)] {
        let settings =
            ["decision.line.kind=memory", &format!("decision.line.latency_ms={latency_ms}")];
        let mut run = start("doorbell", &settings);
        let pass = |run: &mut Run, n_steps: u64| (0..n_steps).for_each(|_| run.step());
        pass(&mut run, 100);
        let goal_in_map = geometry::Se2::new(1.0, 0.5, 0.0);
        run.apply(Intervention::SendGoal { robot: 0, goal_in_map }).unwrap();
        pass(&mut run, steps_between);
        run.apply(Intervention::Halt).unwrap();
        // Braking from whatever speed it had.
        pass(&mut run, 200);
        for _ in 0..1000 {
            run.step();
            let wheel_mps = fastest_wheel_mps(&run);
            assert!(wheel_mps < 1e-9, "{latency_ms} ms, {steps_between} steps: {wheel_mps} m/s");
        }
    }
}

#[test]
fn a_robot_that_is_led_by_hand_is_let_go() {
    let mut run = start("artemic-e3", &[]);
    for _ in 0..3000 {
        run.step();
    }
    assert!(fastest_wheel_mps(&run) > 0.05);
    while run.step_to_rest() {}
    assert!(fastest_wheel_mps(&run) < 1e-9 && run.steps() < 3300);
}

#[test]
fn a_halt_that_cannot_come_through_is_left_to_the_watchdog() {
    let mut run = start("one-obstacle", &[]);
    for _ in 0..600 {
        run.step();
    }
    let cut = Intervention::CutLink { robot: 0, line: Line::Robot, direction: Direction::Both };
    run.apply(cut).unwrap();
    while run.step_to_rest() {}
    assert!(fastest_wheel_mps(&run) < 1e-9);
    assert!((850..1000).contains(&run.steps()), "{}", run.steps());
}

#[test]
fn cuts_and_the_last_order_are_recorded_and_replay() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut run = start("trail-corner", &["mission.duration_max_s=13"]);
    let mut recorder = Recorder::create(&path, &run, &files::Outputs::new(false)).unwrap();
    let (line, direction) = (Line::Pheromones, Direction::Back);
    let events = [
        (500, Intervention::CutLink { robot: 0, line, direction }),
        (540, Intervention::RestoreLink { robot: 0, line, direction }),
        (900, Intervention::CutLink { robot: 0, line: Line::Ground, direction: Direction::Away }),
    ];
    loop {
        let now = run.steps();
        for (_, event) in events.iter().filter(|(step, _)| *step == now) {
            run.apply(event.clone()).unwrap();
        }
        if !run.step_to_end() {
            break;
        }
        let said = run.drain_log();
        recorder.record(&run, &said).unwrap();
    }
    recorder.finish(&run).unwrap();
    assert_eq!(run.interventions().len(), 4);
    let mut replay = Replay::open(&path).unwrap();
    let report = replay.run_to_end();
    assert_eq!((report.divergence, report.steps), (None, run.steps()));
    assert_eq!(replay.run().interventions(), run.interventions());
}

#[test]
fn lines_that_do_not_exist_are_refused_with_a_reason() {
    let mut run = start("one-obstacle", &[]);
    let (line, direction) = (Line::Pheromones, Direction::Both);
    let no_server = run.apply(Intervention::CutLink { robot: 0, line, direction }).unwrap_err();
    assert!(no_server.to_string().contains("[pheromones]"), "{no_server}");
    let nobody = Intervention::RestoreLink { robot: 3, line: Line::Ground, direction };
    assert!(matches!(run.apply(nobody), Err(InterventionError::NoSuchRobot { .. })));
}

#[test]
fn a_robot_on_a_direct_line_has_a_watchdog_too() {
    for (direction, way_max_m) in
        [(Direction::Away, 0.78), (Direction::Back, 0.48), (Direction::Both, 0.78)]
    {
        let mut run = start("one-obstacle", &["robots.line.kind=direct"]);
        for _ in 0..600 {
            run.step();
        }
        run.apply(Intervention::CutLink { robot: 0, line: Line::Robot, direction }).unwrap();
        for _ in 0..500 {
            run.step();
        }
        let way_m = run.summary().figure("way_since_cut_m").unwrap();
        assert!((0.1..=way_max_m).contains(&way_m), "{direction:?}: {way_m} m");
        assert!(fastest_wheel_mps(&run) < 1e-9);
        assert_eq!(run.view().robots[0].phase, "failed");
        run.apply(Intervention::RestoreLink { robot: 0, line: Line::Robot, direction }).unwrap();
        for _ in 0..500 {
            run.step();
        }
        assert!(fastest_wheel_mps(&run) < 1e-9);
        let goal_in_map = geometry::Se2::new(0.0, -1.0, 0.0);
        run.apply(Intervention::SendGoal { robot: 0, goal_in_map }).unwrap();
        for _ in 0..400 {
            run.step();
        }
        assert!(run.view().robots[0].phase != "failed");
    }
}
