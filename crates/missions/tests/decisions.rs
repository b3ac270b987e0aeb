//! What a decision program and the rest of a mission promise each other: completion belongs to the
//! last MOVE, outputs are safe without a program, clock and watchdog work.

#![cfg(test)]

use geometry::Se2;
use missions::{Intervention, Mission, Run};

const ERRANDS: &str = include_str!("../../../missions/errands.toml");
const PROGRAM: &str = include_str!("../../../missions/errands.rdpl");

fn run(mission: Mission) -> Run {
    let seed = mission.seed();
    Run::new(mission, seed).unwrap()
}

fn errands(overrides: &[&str]) -> Run {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    run(Mission::load("errands", &overrides).unwrap())
}

/// The errands with another program, and more events.
fn errands_with(program: &str, events: &str, overrides: &[&str]) -> Run {
    let text = ERRANDS
        .replace("program_file = \"errands.rdpl\"", &format!("program = '''\n{program}'''"))
        .replace("[success]", &format!("{events}\n[success]"));
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    run(Mission::parse("errands", &text, &overrides).unwrap())
}

fn byte(run: &Run, name: &str) -> u8 {
    run.decision_resources().find(|(known, _)| *known == name).unwrap().1
}

/// Present values of BUSY, DONE and FAILED.
fn points(run: &Run) -> [u8; 3] {
    ["I6", "I4", "I5"].map(|name| byte(run, name) & 1)
}

/// The values that STATUS took, with the times at which it did, until the verdict and the ten seconds after it in which
/// the last report may still be on a slow line.
fn statuses(run: &mut Run) -> Vec<(u8, f64)> {
    let mut seen: Vec<(u8, f64)> = Vec::new();
    let mut n_after = 0;
    while run.finished().is_none() || (n_after < 1000 && seen.last().is_some_and(|l| l.0 < 4)) {
        n_after += usize::from(run.finished().is_some());
        run.step();
        let status = byte(run, "STATUS");
        if seen.last().is_none_or(|&(last, _)| last != status) {
            seen.push((status, run.now().as_secs_f64()));
        }
        assert!(points(run).iter().sum::<u8>() <= 1, "busy, done and failed exclude each other");
    }
    seen
}

fn said(run: &mut Run, text: &str) -> usize {
    run.drain_log().iter().filter(|item| item.text.contains(text)).count()
}

/// Every state lasts as long as its errand: none is skipped.
fn assert_no_goal_skipped(seen: &[(u8, f64)], at_least_s: f64, what: &str) {
    assert_eq!(seen.iter().map(|(s, _)| *s).collect::<Vec<_>>(), [0, 1, 2, 3, 4], "{what}");
    for pair in seen[1..].windows(2) {
        let lasted_s = pair[1].1 - pair[0].1;
        assert!(lasted_s > at_least_s, "{what}: state {} lasted {lasted_s} s", pair[0].0);
    }
}

#[test]
fn three_errands_are_done_one_after_another_and_one_fails() {
    let mut errands = errands(&[]);
    let seen = statuses(&mut errands);
    assert_no_goal_skipped(&seen, 10.0, "errands");
    assert!(errands.finished().unwrap().passed, "{:?}", errands.finished());
    assert_eq!(byte(&errands, "M0"), 2, "STC kept the state in which an errand failed");
    let log: Vec<String> = errands.drain_log().into_iter().map(|item| item.text).collect();
    let heard: Vec<&str> = log
        .iter()
        .filter_map(|text| text.strip_prefix("the decision program hears that "))
        .collect();
    let [first, second, third] = heard[..] else { panic!("{heard:?}") };
    assert_eq!(first, "MOVE 1 is done: the robot stands there");
    assert!(second.starts_with("MOVE 2 is failed: "), "{second}");
    assert_eq!(third, "MOVE 3 is done: the robot stands there");
}

#[test]
fn a_pulse_serves_in_any_order_of_functions_and_a_level_where_move_stands_first() {
    // The same program with its MOVEs at the end.
    let moves: Vec<&str> = PROGRAM.lines().filter(|line| line.contains("MOVE  S")).collect();
    let others: Vec<&str> = PROGRAM.lines().filter(|line| !line.contains("MOVE  S")).collect();
    assert_eq!(moves.len(), 3);
    let moves_last = format!("{}\n{}\n", others.join("\n"), moves.join("\n"));
    for program in [PROGRAM, &moves_last] {
        let mut pulse = errands_with(program, "", &["decision.completion=pulse"]);
        let seen = statuses(&mut pulse);
        assert_no_goal_skipped(&seen, 10.0, "pulse");
        assert!(pulse.finished().unwrap().passed);
    }
    // What the guide warns of: a level that is read above the MOVE is still that of the MOVE before.
    let mut level = errands_with(&moves_last, "", &[]);
    let seen = statuses(&mut level);
    assert!(seen.windows(2).any(|pair| pair[1].1 - pair[0].1 < 0.1), "{seen:?}");
}

#[test]
fn answers_over_a_slow_and_lossy_link_are_late_and_never_wrong() {
    for seed in 0..6_u32 {
        let slow = "decision.line.latency_ms=400";
        let lossy = format!("decision.line.loss_prob={}", 0.004 * f64::from(seed));
        let mission = Mission::load("errands", &[slow.to_owned(), lossy]).unwrap();
        let mut slow = Run::new(mission, run_context::RunSeed(seed.into())).unwrap();
        let seen = statuses(&mut slow);
        // A stale answer would end a state at once; on the worst of these lines a robot may count as
        // silent before its errand is over, five questions later.
        assert_no_goal_skipped(&seen, 4.0, &format!("seed {seed}"));
    }
}

#[test]
fn a_robot_that_cannot_be_reached_has_failed_after_the_time_that_the_mission_gives() {
    let mut cut = errands(&["decision.line.loss_prob=1.0", "decision.answer_within_s=2.0"]);
    let mut seen = Vec::new();
    while cut.now().as_secs_f64() < 12.0 {
        cut.step();
        seen.push((cut.now().as_secs_f64(), byte(&cut, "STATUS"), points(&cut)));
    }
    let status_at = |t: f64| seen.iter().rfind(|(now, ..)| *now <= t).unwrap().1;
    // The call comes at 2 s; each MOVE takes 2 s and five times 10 ms to fail.
    assert_eq!([1.9, 2.1, 4.0, 4.2, 6.0, 6.4, 8.0, 8.5].map(status_at), [0, 1, 1, 2, 2, 3, 3, 4]);
    assert_eq!(seen.last().unwrap().2, [0, 0, 1]);
    assert_eq!(said(&mut cut, "is failed: the robot does not answer the ground"), 3);
    assert!(cut.summary().figure("path_length_m").unwrap() < 0.01);
}

#[test]
fn a_move_to_where_the_robot_stands_is_busy_and_then_done() {
    let program =
        "MOVE I0,-2500,0,0,RISE\nOR O0,I4,I5,I6,0L\nCOUNTER M0,UP,I6,RISE\nCOUNTER M1,UP,I4,RISE\n";
    let again = "[[events]]\nat_s = 8.0\ndo = \"press\"\ndevice = \"call\"\n";
    let mut here = errands_with(program, again, &[]);
    while here.now().as_secs_f64() < 14.0 {
        here.step();
    }
    // Twice busy and twice done: the second MOVE to the same place is another MOVE.
    assert_eq!(["M0", "M1"].map(|name| byte(&here, name)), [2, 2]);
    assert_eq!(points(&here), [0, 1, 0]);
}

#[test]
fn a_move_that_another_replaces_is_neither_done_nor_failed() {
    // The second press, on its way to the kitchen, sends it to the dock.
    let program = "COUNTER M0,UP,I0,RISE\nSTIC M1,2,1L,3\nACOMP Y0,M0,M1\n\
                   MOVE I0,2500,1500,0,RISE\nMOVE Y0,-2500,0,0,RISE\n\
                   COUNTER M2,UP,I4,RISE\nCOUNTER M3,UP,I5,RISE\nOR O0,I6,0L,0L,0L\n";
    let again = "[[events]]\nat_s = 8.0\ndo = \"press\"\ndevice = \"call\"\n";
    let mut replaced = errands_with(program, again, &[]);
    while replaced.now().as_secs_f64() < 30.0 {
        replaced.step();
    }
    assert_eq!(["M2", "M3"].map(|name| byte(&replaced, name)), [1, 0]);
    let log: Vec<String> = replaced.drain_log().into_iter().map(|item| item.text).collect();
    let told = |text: &str| log.iter().any(|line| line.contains(text));
    assert!(told("MOVE 2 is replaced by MOVE 3 in the same scan, and not sent"), "{log:#?}");
    assert!(told("MOVE 3 replaces MOVE 1, which was under way"), "{log:#?}");
    assert!(told("hears that MOVE 3 is done"), "{log:#?}");
}

/// The errands until the robot is on its way to the kitchen.
fn under_way() -> Run {
    let mut run = errands_with("MOVE I0,2500,1500,0,RISE\nOR O0,I4,I5,I6,0L\n", "", &[]);
    while run.now().as_secs_f64() < 6.0 {
        run.step();
    }
    assert_eq!(points(&run), [1, 0, 0]);
    run
}

fn go_on(run: &mut Run, seconds: f64) {
    let until = run.now().as_secs_f64() + seconds;
    while run.now().as_secs_f64() < until {
        run.step();
    }
}

#[test]
fn a_person_who_takes_the_robot_makes_the_move_fail() {
    let elsewhere = || Intervention::SendGoal { robot: 0, goal_in_map: Se2::new(0.0, 2.0, 0.0) };
    for (intervention, why) in [
        (elsewhere(), "somebody sent the robot elsewhere"),
        (Intervention::Stop { robot: 0 }, "somebody stopped the robot"),
        (
            Intervention::Drive { robot: 0, speed_mps: 0.1, turn_rate_radps: 0.0 },
            "somebody drives the robot by hand",
        ),
    ] {
        let mut run = under_way();
        run.apply(intervention).unwrap();
        run.step();
        assert_eq!(points(&run), [0, 0, 1], "{why}");
        assert_eq!(said(&mut run, &format!("MOVE 1 is failed: {why}")), 1);
        // The arrival at the person's goal is not the program's.
        go_on(&mut run, 25.0);
        assert_eq!(points(&run), [0, 0, 1], "{why}");
    }
    // A robot that stood at its goal and is sent away is no longer done, and has not failed.
    let mut run = under_way();
    go_on(&mut run, 25.0);
    assert_eq!(points(&run), [0, 1, 0]);
    run.apply(Intervention::Stop { robot: 0 }).unwrap();
    go_on(&mut run, 1.0);
    assert_eq!(points(&run), [0, 1, 0], "told to stop where it stands");
    run.apply(Intervention::Drive { robot: 0, speed_mps: 0.1, turn_rate_radps: 0.0 }).unwrap();
    run.step();
    assert_eq!(points(&run), [0, 0, 0], "driven away by hand");
    run.apply(elsewhere()).unwrap();
    run.step();
    assert_eq!(points(&run), [0, 0, 0]);
    go_on(&mut run, 25.0);
    assert_eq!(points(&run), [0, 0, 0]);
}

#[test]
fn a_program_that_stops_takes_outputs_and_robot_with_it() {
    let stop = "[[events]]\nat_s = 6.0\ndo = \"stop_program\"\n\
                [[events]]\nat_s = 16.0\ndo = \"run_program\"\n";
    for stops_robot in [true, false] {
        let setting = format!("decision.failsafe_stops_robot={stops_robot}");
        let mut run = errands_with(PROGRAM, stop, &[&setting]);
        go_on(&mut run, 5.9);
        // "under way" and "trouble", in the order of the devices.
        assert_eq!(run.view().devices_on[1..], [true, false]);
        go_on(&mut run, 0.2);
        let decision = run.view().decision.unwrap();
        assert!(!decision.run && !decision.drives_outputs && decision.outputs == 0b10);
        assert_eq!(run.view().devices_on[1..], [false, true], "off, and on by its fail-safe value");
        go_on(&mut run, 2.0);
        let wheels = run.view().robots[0].wheels_mps;
        let stands = wheels.iter().all(|v| v.abs() < 1e-3);
        assert_eq!(stands, stops_robot, "{wheels:?}");
        go_on(&mut run, 9.0);
        // It runs again: a MOVE that was ended for it has failed, and it goes on to the store room.
        assert_eq!(byte(&run, "STATUS"), if stops_robot { 2 } else { 1 });
        assert!(run.view().decision.unwrap().drives_outputs);
        assert_eq!(said(&mut run, "they go to their fail-safe values"), 1);
    }
}

#[test]
fn the_night_watch_logs_events_and_is_restarted_by_its_watchdog() {
    let mut watch = run(Mission::load("night-watch", &[]).unwrap());
    let mut lamps = Vec::new();
    while watch.finished().is_none() {
        watch.step();
        let on = watch.view().devices_on[1..].to_vec();
        if lamps.last().is_none_or(|(_, last)| *last != on) {
            lamps.push((watch.steps(), on));
        }
    }
    let (off, on) = (false, true);
    // Hall lamp, warning lamp, alarm; steps of 10 ms, the event of a step shows at its end.
    let expected = [
        (1, vec![off, off, off]),
        // The door opens at 1 s: a warning, and no light, for it is before ten.
        (101, vec![off, on, off]),
        // At 6 s it is after ten.
        (601, vec![on, on, off]),
        // The program is stopped at 7 s and runs again at 10 s; the 3 s of light are over then.
        (701, vec![off, off, on]),
        (1001, vec![off, on, off]),
        // Its loop stands still from 13 s on; a second later the watchdog starts it anew, and it has
        // counted nobody.
        (1400, vec![off, off, off]),
    ];
    assert_eq!(lamps, expected);
    let summary = watch.summary();
    assert!(watch.finished().unwrap().passed, "{:?}", watch.finished());
    assert_eq!(summary.figure("decision_watchdog_resets"), Some(1.0));
    assert_eq!(summary.figure("decision_events"), Some(3.0));
    // 21:59:55 and 20 s.
    assert_eq!(summary.figure("decision_clock_s"), Some(22.0 * 3600.0 + 15.0));
    let log: Vec<String> = watch.drain_log().into_iter().map(|item| item.text).collect();
    let told = |text: &str| log.iter().filter(|line| line.contains(text)).count();
    assert_eq!(told("event 1: I0 at 2026-03-01 21:59:56"), 1, "{log:#?}");
    assert_eq!(told("event 1: I0 at 2026-03-01 22:00:01"), 1, "{log:#?}");
    assert_eq!(told("R8004"), 1, "{log:#?}");
}

#[test]
fn an_error_of_the_program_is_told_and_makes_the_outputs_safe() {
    // 501 functions: one more than a scan of 200 ms has time for.
    let program = "OR O0,1L,0L,0L,0L\n".repeat(501);
    let mut overrun = errands_with(&program, "", &[]);
    go_on(&mut overrun, 1.0);
    let decision = overrun.view().decision.unwrap();
    assert_eq!((decision.fault, decision.outputs), (Some("R8006"), 0b10));
    assert_eq!(overrun.summary().figure("decision_faults"), Some(1.0));
    assert_eq!(said(&mut overrun, "R8006: A scan took longer"), 1);
}

#[test]
fn a_run_that_is_closed_leaves_nothing_on() {
    let mut run = under_way();
    assert_eq!(run.view().devices_on[1..], [true, false]);
    let hash = run.state_hash();
    run.close();
    assert_eq!(run.view().devices_on[1..], [false, true]);
    assert_ne!(run.state_hash(), hash);
}

#[test]
fn wrong_settings_of_the_decision_node_are_refused() {
    for (setting, words) in [
        ("decision.busy_input=4", "another input than busy_input"),
        ("decision.failed_input=6", "another input than busy_input"),
        ("decision.busy_input=0", "`call` has this one"),
        ("decision.completion=edge", "`level`, `pulse`"),
        ("decision.clock=25:00", "a time such as 07:30"),
        ("decision.clock=2026-02-30 07:30", "a time such as 07:30"),
        ("decision.watchdog_s=-1", "from 0 to 3600 s"),
        ("decision.answer_within_s=0", "from 0.1 to 600 s"),
    ] {
        let error = Mission::load("errands", &[setting.to_owned()]).unwrap_err().to_string();
        assert!(error.contains(words), "{setting}: {error}");
    }
    let done = ERRANDS.replace("arrived_input", "done_input");
    assert!(Mission::parse("done", &done, &[]).is_ok(), "another name for the same");
    for (device, words) in [
        ("kind = \"button\"\nfailsafe = \"on\"", "a button is an input"),
        ("kind = \"lamp\"\nfailsafe = \"dim\"", "`off`, `on`, `hold`"),
    ] {
        let kind = device.lines().next().unwrap();
        let text = ERRANDS.replacen(kind, device, 1).replacen(
            "failsafe = \"on\"\n\n[[robots]]",
            "\n[[robots]]",
            1,
        );
        let error = Mission::parse("devices", &text, &[]).unwrap_err().to_string();
        assert!(error.contains(words), "{device}: {error}");
    }
}

/// Log lines of the errands, up to 20 s, that say what the ground asked and what it heard.
fn asked(events: &str, link: &str) -> Vec<String> {
    let mut run = errands_with(PROGRAM, events, &[link]);
    while run.now().as_secs_f64() < 20.0 {
        run.step();
    }
    let words = ["answers the link test", "sonars:", "begins anew", "does not answer for"];
    let log = run.drain_log().into_iter().map(|item| item.text);
    log.filter(|text| words.iter().any(|word| text.contains(word))).collect()
}

/// Over bytes and without, whole and cut either way: an answer comes once, or its absence is said.
#[test]
fn what_the_ground_asks_is_answered_or_the_silence_is_told() {
    let cut = |direction: &str| {
        format!(
            "[[events]]\nat_s = 0.1\ndo = \"cut_line\"\nrobot = \"assistant\"\nline = \"ground\"\n\
             direction = \"{direction}\"\n"
        )
    };
    for link in ["decision.line.kind=memory", "decision.line.kind=direct"] {
        let answers = asked("", link);
        let [test, sonar, anew] = &answers[..] else { panic!("{link}: {answers:?}") };
        assert!(test.starts_with("assistant answers the link test after 0.0"), "{link}: {test}");
        // The wall behind the store room's door is 3.7 m ahead of the first sonars to the right.
        assert!(sonar.starts_with("assistant reports its front sonars: 2."), "{link}: {sonar}");
        assert!(anew.starts_with("assistant begins anew, as it says after 0.0"), "{link}: {anew}");
        for direction in ["both", "to_ground", "from_ground"] {
            let answers = asked(&cut(direction), link);
            assert_eq!(answers.len(), 3, "{link} {direction}: {answers:?}");
            for of in ["the link is tested", "a sonar report", "a restart"] {
                let is_told =
                    |text: &String| text.contains("does not answer for") && text.contains(of);
                assert!(answers.iter().any(is_told), "{link} {direction}: {answers:?}");
            }
        }
    }
}
