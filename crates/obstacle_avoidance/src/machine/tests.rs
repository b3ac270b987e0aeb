//! The machine, state by state, against the ways through it that the thesis draws.

use super::*;
use crate::nominal_bearing_rad;

fn machine(config: MachineConfig) -> Machine {
    let sensor = |i| RangeSensor { in_base: Vec2::zeros(), bearing_rad: nominal_bearing_rad(i, 8) };
    let sensors: Vec<RangeSensor> = (0..8).map(sensor).collect();
    // Annex C looks at sensors 1 to 6 only.
    let gains = [0.0, 6.0, 8.0, 10.0, 10.0, 8.0, 6.0, 0.0];
    let bubble = Bubble::new(&gains, &[0.0; 8], 5.0).unwrap();
    Machine::new(config, &sensors, bubble).unwrap()
}

const FREE: [f64; 8] = [5.0; 8];
const WALL_AHEAD: [f64; 8] = [5.0, 5.0, 5.0, 0.5, 0.5, 5.0, 5.0, 5.0];

fn inputs(ms: u64, pose: Se2, ranges_m: &[f64]) -> Inputs<'_> {
    Inputs {
        now: Stamp::from_millis(ms),
        pose,
        ranges_m,
        speed_mps: 0.3,
        stalled: false,
        saturated_turn: false,
        obstacle: None,
        target_visible: None,
        detour: None,
    }
}

fn run(machine: &mut Machine, steps: &[(Se2, [f64; 8])]) -> Vec<u8> {
    let mut entered = Vec::new();
    for (k, (pose, ranges)) in steps.iter().enumerate() {
        entered.extend(machine.step(&inputs(200 * k as u64, *pose, ranges)).entered());
    }
    entered
}

const fn at(x_m: f64, y_m: f64, yaw_rad: f64) -> Se2 {
    Se2 { x_m, y_m, yaw_rad }
}

/// A wall behind a robot with sixteen sonars turned its rebound from −18° to −42°.
#[test]
fn what_is_behind_does_not_change_the_rebound() {
    let front_deg = [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0_f64];
    let rear_deg = [-90.0, -130.0, -150.0, -170.0, 170.0, 150.0, 130.0, 90.0_f64];
    let place = |x: f64| {
        move |deg: &f64| RangeSensor { in_base: Vec2::new(x, 0.0), bearing_rad: deg.to_radians() }
    };
    let sensors: Vec<RangeSensor> =
        front_deg.iter().map(place(0.1)).chain(rear_deg.iter().map(place(-0.2))).collect();
    let turn_deg = |rear_m: f64| {
        let mut ranges = [5.0; 16];
        ranges[..8].copy_from_slice(&[1.0, 1.2, 1.5, 2.0, 0.4, 3.0, 4.0, 5.0]);
        ranges[8..].fill(rear_m);
        let gains: Vec<f64> = (0..16).map(|i| if i < 8 { 10.0 } else { 0.0 }).collect();
        let bubble = Bubble::new(&gains, &[0.0; 16], 5.0).unwrap();
        let mut machine = Machine::new(MachineConfig::default(), &sensors, bubble).unwrap();
        machine.set_target(Vec2::new(9.0, 0.0), Stamp::ZERO);
        let turns =
            (0..8).find_map(|k| match machine.step(&inputs(200 * k, at(0.0, 0.0, 0.0), &ranges)) {
                Output { motion: Motion::TurnTo(heading_rad), .. }
                    if machine.rebound_rad().is_some() =>
                {
                    Some(heading_rad.to_degrees())
                }
                _ => None,
            });
        turns.unwrap()
    };
    // (6.3) by hand, over the eight of the front; swung out, because something is ahead.
    let sum = 90.0 * (1.0 - 5.0) + 50.0 * (1.2 - 4.0) + 30.0 * (1.5 - 3.0) + 10.0 * (2.0 - 0.4);
    let expected_deg: f64 = sum / 18.1 - 50.0;
    for rear_m in [0.2, 1.0, 5.0] {
        let turn = turn_deg(rear_m);
        assert!((turn - expected_deg).abs() < 1e-9, "{rear_m} m behind: {turn}");
    }
}

#[test]
fn an_idle_machine_says_nothing() {
    let mut machine = machine(MachineConfig::default());
    let output = machine.step(&inputs(0, Se2::IDENTITY, &WALL_AHEAD));
    assert_eq!(
        (output.motion, output.entered(), output.outcome),
        (Motion::None, &[][..], Outcome::Busy)
    );
}

#[test]
fn a_free_way_runs_through_1_2_3_4_to_0() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(0.0, 2.0), Stamp::ZERO);
    let first = machine.step(&inputs(0, Se2::IDENTITY, &FREE));
    assert_eq!(first.motion, Motion::TurnTo(std::f64::consts::FRAC_PI_2));
    assert_eq!(machine.step(&inputs(200, at(0.0, 0.0, 1.0), &FREE)).motion, Motion::None);
    let turned = machine.step(&inputs(400, at(0.0, 0.0, 1.55), &FREE));
    assert_eq!((turned.motion, turned.entered()), (Motion::Follow, &[3, 4][..]));
    let driving = machine.step(&inputs(600, at(0.0, 1.0, 1.57), &FREE));
    assert_eq!((driving.motion, driving.entered()), (Motion::Follow, &[3, 4][..]));
    let done = machine.step(&inputs(800, at(0.0, 1.76, 1.57), &FREE));
    assert_eq!(
        (done.motion, done.entered(), done.outcome),
        (Motion::Stop, &[0][..], Outcome::Reached)
    );
    assert_eq!(machine.target(), None);
}

#[test]
fn an_obstacle_runs_through_5_6_7_8_and_back_to_1() {
    let config = MachineConfig { variant: Variant::Detour, ..MachineConfig::default() };
    let mut machine = machine(config);
    machine.set_target(Vec2::new(4.0, 0.0), Stamp::ZERO);
    let away = 45.0_f64.to_radians();
    let start = [(at(0.0, 0.0, 0.0), FREE), (at(0.0, 0.0, 0.0), FREE)];
    assert_eq!(run(&mut machine, &start), [1, 2, 3, 4]);
    assert_eq!(run(&mut machine, &[(at(1.0, 0.0, 0.0), WALL_AHEAD)]), [5]);
    let rebound = machine.step(&inputs(600, at(1.0, 0.0, 0.0), &WALL_AHEAD));
    assert_eq!(rebound.entered(), [6]);
    assert!(matches!(rebound.motion, Motion::TurnTo(h) if (h - away).abs() < 1e-9), "{rebound:?}");
    let via = machine.target().unwrap();
    let expected = Vec2::new(1.0 + 1.2 * away.cos(), 1.2 * away.sin());
    assert!((via - expected).norm() < 1e-9, "{via}");
    assert_eq!(run(&mut machine, &[(at(1.0, 0.0, away), FREE)]), [7, 8]);
    assert_eq!(run(&mut machine, &[(at(1.4, 0.4, away), FREE)]), [7, 8]);
    assert_eq!(run(&mut machine, &[(at(1.8, 0.8, away), FREE)]), [1]);
    assert_eq!(machine.target(), Some(Vec2::new(4.0, 0.0)));
}

#[test]
fn the_visibility_variant_aims_again_when_the_goal_is_seen() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target_behind_obstacle(Vec2::new(4.0, 0.0), Stamp::ZERO);
    let away = 45.0_f64.to_radians();
    assert_eq!(run(&mut machine, &[(at(1.0, 0.0, 0.0), WALL_AHEAD)]), [5, 6]);
    // The box is still to the right, towards the goal.
    let beside = [5.0, 5.0, 5.0, 5.0, 5.0, 0.9, 0.9, 0.9];
    assert_eq!(run(&mut machine, &[(at(1.0, 0.0, away), beside)]), [7, 8]);
    assert_eq!(run(&mut machine, &[(at(1.5, 0.5, away), beside)]), [7, 8]);
    assert_eq!(run(&mut machine, &[(at(1.6, 0.6, away), FREE)]), [1]);
    // Seen, but hardly moved: not yet.
    machine.set_target_behind_obstacle(Vec2::new(4.0, 0.0), Stamp::ZERO);
    assert_eq!(run(&mut machine, &[(at(1.0, 0.0, 0.0), WALL_AHEAD)]), [5, 6]);
    assert_eq!(
        run(&mut machine, &[(at(1.1, 0.1, away), FREE), (at(1.2, 0.2, away), FREE)]),
        [7, 8, 7, 8]
    );
    // Never seen, but far enough away.
    assert_eq!(run(&mut machine, &[(at(1.1 + 1.8, 0.1 + 1.8, away), beside)]), [1]);
}

#[test]
fn a_saturated_turn_stops_and_aims_anew() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(4.0, 0.0), Stamp::ZERO);
    run(&mut machine, &[(Se2::IDENTITY, FREE), (Se2::IDENTITY, FREE)]);
    let saturated = Inputs { saturated_turn: true, ..inputs(400, at(0.5, 0.5, 0.0), &FREE) };
    let output = machine.step(&saturated);
    assert_eq!((output.motion, output.entered()), (Motion::Stop, &[3, 1][..]));
}

#[test]
fn the_listings_heading_check_misses_the_wrap_and_the_right_one_does_not() {
    for (check, entered) in
        [(HeadingCheck::Wrapped, vec![5, 6, 7, 8]), (HeadingCheck::Listing, vec![5, 6])]
    {
        let mut machine =
            machine(MachineConfig { heading_check: check, ..MachineConfig::default() });
        machine.set_target_behind_obstacle(Vec2::new(4.0, 0.0), Stamp::ZERO);
        // Rebound to 1° from −44°; the robot ends its turn at −1°, i.e. 359°.
        let (before, after) = (-44.0_f64.to_radians(), -1.0_f64.to_radians());
        let seen =
            run(&mut machine, &[(at(0.0, 0.0, before), WALL_AHEAD), (at(0.0, 0.0, after), FREE)]);
        assert_eq!(seen, entered, "{check:?}");
    }
}

#[test]
fn a_stall_backs_off_and_rebounds() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(4.0, 0.0), Stamp::ZERO);
    run(&mut machine, &[(Se2::IDENTITY, FREE), (Se2::IDENTITY, FREE)]);
    let stalled = Inputs { stalled: true, ..inputs(400, Se2::IDENTITY, &FREE) };
    let output = machine.step(&stalled);
    assert_eq!((output.motion, output.entered()), (Motion::BackOff, &[5][..]));
    assert_eq!(machine.step(&inputs(1500, Se2::IDENTITY, &FREE)).motion, Motion::BackOff);
    assert_eq!(machine.step(&inputs(1700, Se2::IDENTITY, &FREE)).entered(), [6]);
}

#[test]
fn it_gives_up_visibly_when_nothing_helps() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(4.0, 0.0), Stamp::ZERO);
    let mut outcome = Outcome::Busy;
    let mut heading = 0.0;
    let mut n_steps = 0;
    while outcome == Outcome::Busy && n_steps < 1000 {
        let output = machine.step(&inputs(200 * n_steps, at(0.0, 0.0, heading), &WALL_AHEAD));
        if let Motion::TurnTo(wanted) = output.motion {
            heading = wanted;
        }
        outcome = output.outcome;
        n_steps += 1;
    }
    assert_eq!(outcome, Outcome::TooManyRebounds);
    assert!(n_steps < 50, "{n_steps}");
    assert_eq!(machine.state(), State::Idle);
}

#[test]
fn a_robot_that_does_not_turn_is_noticed() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(-4.0, 0.0), Stamp::ZERO);
    let outcomes: Vec<Outcome> =
        (0..200).map(|k| machine.step(&inputs(200 * k, Se2::IDENTITY, &FREE)).outcome).collect();
    assert_eq!(outcomes.iter().filter(|o| **o == Outcome::CannotTurn).count(), 1);
    assert!(!outcomes.contains(&Outcome::Reached));
}

#[test]
fn heartbeats_come_after_two_seconds_and_then_every_second() {
    let mut machine = machine(MachineConfig::default());
    machine.set_target(Vec2::new(9.0, 0.0), Stamp::ZERO);
    let beats: Vec<u64> = (0..30_u64)
        .map(|k| 200 * k)
        .filter(|ms| machine.step(&inputs(*ms, Se2::IDENTITY, &FREE)).heartbeat)
        .collect();
    assert_eq!(beats, [2000, 3000, 4000, 5000]);
}

#[test]
fn settings_outside_their_range_are_named() {
    let sensors = [RangeSensor { in_base: Vec2::zeros(), bearing_rad: 0.0 }];
    let bubble = Bubble::new(&[1.0], &[0.0], 5.0).unwrap();
    let bad = MachineConfig { near_m: f64::NAN, ..MachineConfig::default() };
    assert_eq!(Machine::new(bad, &sensors, bubble.clone()).unwrap_err().key, "near_m");
    let bad = MachineConfig { angular_limit_rad: -1.0, ..MachineConfig::default() };
    assert_eq!(Machine::new(bad, &sensors, bubble.clone()).unwrap_err().key, "angular_limit_rad");
    assert_eq!(Machine::new(MachineConfig::default(), &[], bubble).unwrap_err().key, "n_sensors");
}
