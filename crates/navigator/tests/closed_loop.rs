//! The navigator against a world: situations drawn by seed, judged by what happened.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, Figures, Person, boxed, trail, wall};
use geometry::{Se2, Segment, Vec2};
use messages::{FailureReason, Order, Report, Sensed};
use navigator::{Avoidance, Method, NavigatorSettings, PathController, Phase, TrailController};
use obstacle_avoidance::Variant;
use path_following::Path;
use pheromones::Field;
use robot_models::WheelSpeeds;
use run_context::{RunSeed, Stamp, StateHash};

/// A uniform number from a seed and a label; the situations' own dice.
fn dice(seed: u64, label: &str, from: f64, to: f64) -> f64 {
    use rand_core::Rng;
    let ratio = RunSeed(seed).stream(label).next_u64() as f64 / u64::MAX as f64;
    from + ratio * (to - from)
}

fn same(settings: NavigatorSettings) -> NavigatorSettings {
    settings
}

fn corridor(half_width: f64) -> Vec<(Segment, u32)> {
    vec![
        wall(-2.0, half_width, 12.0, half_width),
        wall(-2.0, -half_width, 12.0, -half_width),
        wall(-2.0, -half_width, -2.0, half_width),
        wall(12.0, -half_width, 12.0, half_width),
    ]
}

#[test]
fn a_free_straight_trail_is_driven_to_its_goal() {
    let field = trail(&[(0.0, 0.0), (8.0, 0.0)]);
    let mut bed = Bed::new(same, corridor(0.75), field, Se2::new(0.0, 0.0, 0.0), 1);
    bed.trace = std::env::var("TRACE").is_ok();
    let figures = bed.run_to(Se2::new(8.0, 0.0, 1.0), 120.0);
    assert_eq!(figures.phase, Phase::Arrived, "{figures:?}");
    assert_eq!(figures.n_touched, 0);
    assert!(figures.goal_error_m < 0.15 && figures.heading_error_rad.abs() < 0.09);
}

/// A straight corridor, 1.8 to 2.4 m wide, with a box near the trail that leaves
/// 0.75 m on one side, 0.16 m on either side of the robot (or `GAP`). Of 1000 seeds 996 arrive.
fn box_in_corridor(seed: u64) -> Bed {
    let d = |label, from, to| dice(seed, label, from, to);
    let half_width = d("half_width", 0.9, 1.2);
    let size = Vec2::new(d("depth", 0.3, 0.5), d("width", 0.3, 0.5));
    let yaw = d("yaw", -0.8, 0.8);
    let reach = 0.5 * (size.x * yaw.sin().abs() + size.y * yaw.cos().abs());
    // Free on the wider side: half_width + |offset| - reach.
    let gap_m = std::env::var("GAP").map_or(0.75, |gap| gap.parse().unwrap());
    let least_offset = (gap_m + reach - half_width).max(0.0);
    let offset = d("offset", least_offset, 0.5_f64.max(least_offset + 0.05));
    let side = if d("side", -1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
    let mut walls = corridor(half_width);
    walls.extend(boxed(Vec2::new(d("at", 3.0, 6.0), side * offset), size, yaw));
    let start = Se2::new(0.0, d("y", -0.1, 0.1), d("heading", -0.3, 0.3));
    Bed::new(same, walls, trail(&[(0.0, 0.0), (10.0, 0.0)]), start, seed)
}

/// Two rooms and a 0.95 m door between them; the trail turns to the door and beyond it again.
fn through_a_door(seed: u64) -> Bed {
    let d = |label, from, to| dice(seed, label, from, to);
    let centre = d("door", -0.05, 0.05);
    let (low, high) = (centre - 0.475, centre + 0.475);
    let thick = d("thick", 0.08, 0.2);
    let mut walls = Vec::new();
    for x in [3.0, 3.0 + thick] {
        walls.push(wall(x, -4.0, x, low));
        walls.push(wall(x, high, x, 4.0));
    }
    walls.push(wall(3.0, low, 3.0 + thick, low));
    walls.push(wall(3.0, high, 3.0 + thick, high));
    walls.extend([wall(-2.0, -4.0, 7.0, -4.0), wall(-2.0, 4.0, 7.0, 4.0)]);
    walls.extend([wall(-2.0, -4.0, -2.0, 4.0), wall(7.0, -4.0, 7.0, 4.0)]);
    let first = d("first", 1.0, 1.8);
    let second = d("second", 4.4, 5.4);
    let (a, b) = (
        if d("a", -1.0, 1.0) < 0.0 { -2.6 } else { 2.6 },
        if d("b", -1.0, 1.0) < 0.0 { -2.6 } else { 2.6 },
    );
    let field = trail(&[(first, a), (first, 0.0), (second, 0.0), (second, b)]);
    let heading = if a < 0.0 { 1.57 } else { -1.57 };
    let start = Se2::new(first, a, heading + d("heading", -0.3, 0.3));
    let mut bed = Bed::new(same, walls, field, start, seed);
    bed.goal = Se2::new(second, b, d("goal_heading", -3.0, 3.0));
    bed
}

/// The thesis's 7.4: 45 degrees off at the start, in the open.
fn off_by_45_degrees(seed: u64) -> Bed {
    let side = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
    let start =
        Se2::new(0.0, dice(seed, "y", -0.15, 0.15), side * dice(seed, "heading", 0.6, 0.95));
    Bed::new(same, corridor(2.0), trail(&[(0.0, 0.0), (10.0, 0.0)]), start, seed)
}

/// With `turn_first = false` the law does all turning, wherever in the trail's first cell the robot begins. The
/// scout's way used to begin too far away for that in half of them.
#[test]
fn a_robot_that_shall_not_turn_first_drives_off_at_once() {
    for k in 0..11 {
        for heading_rad in [-0.785, 0.785] {
            let start = Se2::new(0.02 * f64::from(k), 0.0, heading_rad);
            let settings = |s| NavigatorSettings { turn_first: false, preview_m: 0.0, ..s };
            let field = trail(&[(0.0, 0.0), (6.0, 0.0)]);
            let mut bed = Bed::new(settings, corridor(2.0), field, start, 1);
            let figures = bed.run_to(Se2::new(6.0, 0.0, 0.0), 120.0);
            let gone = |pose: &&Se2| (pose.position() - start.position()).norm() > 0.03;
            let first = figures.track.iter().find(gone).unwrap();
            let turned_rad = (first.yaw_rad - heading_rad).abs();
            assert!(turned_rad < 0.3, "{start:?}: turned by {turned_rad} first");
            assert_eq!(figures.phase, Phase::Arrived, "{start:?}");
        }
    }
}

/// `fit_to_speed`: the bend of a trail and the goal at its end are slowed for; without it the speed is constant.
#[test]
fn a_bend_and_the_goal_are_slowed_for_if_the_speed_shall_fit() {
    let speeds = |fit_to_speed: bool, controller: TrailController| {
        let settings = |s| NavigatorSettings {
            fit_to_speed,
            trail_controller: controller,
            speed_mps: 0.6,
            avoidance: Avoidance::Off,
            ..s
        };
        let field = trail(&[(0.0, 0.0), (6.0, 0.0), (6.0, 5.0)]);
        let mut bed = Bed::new(settings, Vec::new(), field, Se2::new(0.0, 0.0, 0.0), 1);
        let figures = bed.run_to(Se2::new(6.0, 5.0, 1.57), 90.0);
        // Poses are 200 ms apart.
        let mps = |pair: &[Se2]| (pair[1].position() - pair[0].position()).norm() / 0.2;
        let fastest = |near: fn(&Se2) -> bool| {
            let pairs = figures.track.windows(2).filter(|pair| near(&pair[0]));
            pairs.map(mps).fold(0.0, f64::max)
        };
        let straight = fastest(|p| (3.0..4.5).contains(&p.x_m));
        (straight, fastest(|p| (5.3..5.7).contains(&p.x_m) && p.y_m < 0.6), figures)
    };
    for &controller in TrailController::ALL.iter().filter(|law| law.fits_to_speed()) {
        let (straight_mps, bend_mps, figures) = speeds(true, controller);
        assert!(straight_mps > 0.5 && bend_mps < 0.4, "{straight_mps} {bend_mps}");
        assert_eq!(figures.phase, Phase::Arrived, "{controller:?}");
        assert!(figures.goal_error_m < 0.1, "{}", figures.goal_error_m);
    }
    let (straight_mps, bend_mps, _) = speeds(false, TrailController::Fuzzy);
    assert!(straight_mps > 0.5 && bend_mps > 0.5, "{straight_mps} {bend_mps}");
}

/// A person crosses the corridor in front of the robot.
fn person_crossing(seed: u64) -> Bed {
    let d = |label, from, to| dice(seed, label, from, to);
    let mut bed = Bed::new(
        same,
        corridor(1.5),
        trail(&[(0.0, 0.0), (10.0, 0.0)]),
        Se2::new(0.0, 0.0, 0.0),
        seed,
    );
    let x = d("x", 2.0, 6.0);
    let side = if d("side", -1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
    let slant = d("slant", -0.4, 0.4);
    let speed_mps = d("speed", 0.3, 0.9);
    // About when the robot comes by.
    let starts = Stamp::from_millis(
        (1000.0 * (3.5 + x / 0.3 - 1.2 / speed_mps + d("when", -2.5, 2.5)).max(0.0)) as u64,
    );
    let (from, to) = (Vec2::new(x - slant, side * 1.2), Vec2::new(x + slant, -side * 1.2));
    bed.person = Some(Person { from, to, speed_mps, starts, yields: true });
    bed
}

struct Tally {
    n: u32,
    n_arrived: u32,
    n_touched: u32,
    time_s: f64,
    clearance_min_m: f64,
}

fn sweep(name: &str, n: u64, situation: fn(u64) -> Bed) -> Tally {
    let mut tally = Tally { n: 0, n_arrived: 0, n_touched: 0, time_s: 0.0, clearance_min_m: 5.0 };
    for seed in 0..n {
        let mut bed = situation(seed);
        let goal = bed.goal;
        let figures = bed.run_to(goal, 300.0);
        let arrived = figures.phase == Phase::Arrived && figures.goal_error_m < 0.25;
        tally.n += 1;
        tally.n_arrived += u32::from(arrived);
        tally.n_touched += u32::from(figures.n_touched > 0);
        tally.clearance_min_m = tally.clearance_min_m.min(figures.clearance_min_m);
        if arrived {
            tally.time_s += figures.time_s;
        }
        if !arrived || figures.n_touched > 0 {
            let Figures { phase, n_touched, time_s, .. } = figures;
            println!(
                "{name} seed {seed}: {phase:?} touched {n_touched} after {time_s:.0} s at {:?}",
                bed.world_from_base
            );
        }
    }
    println!(
        "{name}: arrived {}/{}, touched {}, mean {:.1} s, least clearance {:.3} m",
        tally.n_arrived,
        tally.n,
        tally.n_touched,
        tally.time_s / f64::from(tally.n_arrived.max(1)),
        tally.clearance_min_m
    );
    tally
}

fn check(name: &str, n: u64, situation: fn(u64) -> Bed) {
    if let Ok(seed) = std::env::var("SEED") {
        let mut bed = situation(seed.parse().unwrap());
        bed.trace = true;
        let goal = bed.goal;
        bed.run_to(goal, 300.0);
        return;
    }
    let n = std::env::var("N").map_or(n, |n| n.parse().unwrap());
    let tally = sweep(name, n, situation);
    assert!(
        tally.n_arrived * 100 >= tally.n * 99,
        "{name}: {}/{} arrived",
        tally.n_arrived,
        tally.n
    );
    assert_eq!(tally.n_touched, 0, "{name}");
}

#[test]
fn a_box_on_the_trail_is_passed() {
    check("box", 120, box_in_corridor);
}

#[test]
fn a_door_on_the_trail_is_passed() {
    check("door", 100, through_a_door);
}

#[test]
fn the_trail_is_taken_up_at_45_degrees() {
    check("45 degrees", 50, off_by_45_degrees);
}

#[test]
fn a_person_who_crosses_is_not_touched() {
    check("person", 100, person_crossing);
}

/// 5 by 5 m with a table-sized block in the middle; the direct method goes straight across.
fn single_obstacle(seed: u64, avoidance: Avoidance, variant: Variant) -> Bed {
    let d = |label, from, to| dice(seed, label, from, to);
    let mut walls = vec![
        wall(-2.0, -4.0, 10.0, -4.0),
        wall(10.0, -4.0, 10.0, 4.0),
        wall(10.0, 4.0, -2.0, 4.0),
        wall(-2.0, 4.0, -2.0, -4.0),
    ];
    walls.extend(boxed(
        Vec2::new(3.5, d("y", -0.3, 0.3)),
        Vec2::new(0.5, 0.6),
        d("yaw", -0.3, 0.3),
    ));
    let settings = move |s: NavigatorSettings| NavigatorSettings {
        method: Method::Direct,
        avoidance,
        variant,
        ..s
    };
    let field = Field::new(3, 3, 0.2).unwrap();
    let mut bed =
        Bed::new(settings, walls, field, Se2::new(0.0, 0.0, d("heading", -1.0, 1.0)), seed);
    bed.goal = Se2::new(7.0, 0.0, 0.0);
    bed
}

fn single_obstacle_checked(seed: u64) -> Bed {
    single_obstacle(seed, Avoidance::Checked, Variant::Visibility)
}

fn single_obstacle_visibility(seed: u64) -> Bed {
    single_obstacle(seed, Avoidance::Rebound, Variant::Visibility)
}

fn single_obstacle_detour(seed: u64) -> Bed {
    single_obstacle(seed, Avoidance::Rebound, Variant::Detour)
}

#[test]
fn the_direct_method_goes_around_a_single_obstacle() {
    check("direct, checked", 60, single_obstacle_checked);
}

#[test]
fn the_thesis_rebound_gets_around_a_single_obstacle_mostly() {
    // No check of the detour, no memory: the near-sighted original. It must end visibly always,
    // arrive nearly always, and touch rarely.
    for (name, situation) in [
        ("rebound, visibility", single_obstacle_visibility as fn(u64) -> Bed),
        ("rebound, detour", single_obstacle_detour),
    ] {
        let tally = sweep(name, 60, situation);
        assert!(tally.n_arrived >= 54, "{name}: {}", tally.n_arrived);
        assert!(tally.n_touched <= 6, "{name}: {}", tally.n_touched);
    }
}

#[test]
fn a_robot_beside_a_wall_does_not_swing_its_tail_into_it() {
    // The side is 0.06 m from the wall; the rear corners reach 0.05 m into it during a turn.
    for side in [1.0, -1.0] {
        let mut walls = corridor(3.0);
        walls.push(wall(-1.5, side * 0.275, 3.0, side * 0.275));
        let settings = |s: NavigatorSettings| NavigatorSettings { method: Method::Direct, ..s };
        let field = Field::new(3, 3, 0.2).unwrap();
        let mut bed = Bed::new(settings, walls, field, Se2::IDENTITY, 4);
        let figures = bed.run_to(Se2::new(0.5, -side * 2.0, 0.0), 200.0);
        assert_eq!(figures.n_touched, 0, "wall on side {side}: {:?}", figures.phase);
        assert!(matches!(figures.phase, Phase::Arrived | Phase::Failed(_)));
    }
}

#[test]
fn the_thesis_rebound_on_a_trail_always_ends() {
    let situation = |seed| {
        let mut bed = box_in_corridor(seed);
        bed.change_settings(|s| NavigatorSettings {
            avoidance: Avoidance::Rebound,
            wait_s: 0.0,
            ..s
        });
        bed
    };
    let mut n_arrived = 0;
    for seed in 0..40 {
        let mut bed = situation(seed);
        let goal = bed.goal;
        let figures = bed.run_to(goal, 600.0);
        assert!(matches!(figures.phase, Phase::Arrived | Phase::Failed(_)), "seed {seed}");
        n_arrived += u32::from(figures.phase == Phase::Arrived && figures.n_touched == 0);
    }
    println!("rebound on a trail in a corridor: {n_arrived}/40 arrived without touching");
    assert!(n_arrived >= 10, "{n_arrived}");
}

/// A U of walls between start and goal, open towards the start (the thesis, Fig. 6.12).
fn labyrinth() -> Bed {
    let walls = vec![
        wall(-2.0, -5.0, 10.0, -5.0),
        wall(10.0, -5.0, 10.0, 5.0),
        wall(10.0, 5.0, -2.0, 5.0),
        wall(-2.0, 5.0, -2.0, -5.0),
        wall(4.0, -2.5, 4.0, 2.5),
        wall(1.0, 2.5, 4.0, 2.5),
        wall(1.0, -2.5, 4.0, -2.5),
    ];
    let settings = |s: NavigatorSettings| NavigatorSettings {
        method: Method::Direct,
        avoidance: Avoidance::Rebound,
        ..s
    };
    let mut bed =
        Bed::new(settings, walls, Field::new(3, 3, 0.2).unwrap(), Se2::new(0.0, 0.0, 0.0), 5);
    bed.goal = Se2::new(7.0, 0.0, 0.0);
    bed
}

#[test]
fn a_labyrinth_needs_intermediate_goals() {
    let mut direct = labyrinth();
    let figures = direct.run_to(direct.goal, 600.0);
    assert!(matches!(figures.phase, Phase::Failed(_)), "{:?} {}", figures.phase, figures.time_s);
    assert_eq!(figures.n_touched, 0);

    let mut guided = labyrinth();
    let via = vec![Vec2::new(0.0, 3.7), Vec2::new(5.5, 3.7)];
    guided.navigator.set_intermediate_goals(via);
    let figures = guided.run_to(guided.goal, 600.0);
    assert_eq!(figures.phase, Phase::Arrived, "{}", figures.time_s);
    assert_eq!(figures.n_touched, 0);
    println!("labyrinth with two goals: {:.0} s", figures.time_s);
}

#[test]
fn a_given_path_is_followed_by_every_law() {
    for &law in PathController::ALL {
        let settings = |s: NavigatorSettings| NavigatorSettings {
            method: Method::Path,
            path_controller: law,
            ..s
        };
        let room = corridor(4.0);
        let field = Field::new(3, 3, 0.2).unwrap();
        let mut bed = Bed::new(settings, room, field, Se2::new(0.0, 0.0, 0.0), 3);
        let corners =
            [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (6.0, 2.0)].map(|(x, y)| Vec2::new(x, y));
        bed.navigator.set_path(Path::polyline(&corners).unwrap());
        let figures = bed.run_to(Se2::new(6.0, 2.0, 0.0), 120.0);
        assert_eq!(figures.phase, Phase::Arrived, "{law:?}");
        assert!(figures.goal_error_m < 0.15, "{law:?}: {}", figures.goal_error_m);
        let length_m = 8.0;
        assert!((figures.way_m - length_m).abs() < 1.0, "{law:?} drove {}", figures.way_m);
    }
}

#[test]
fn a_trail_is_followed_by_every_law() {
    for &law in TrailController::ALL {
        let settings = |s: NavigatorSettings| NavigatorSettings { trail_controller: law, ..s };
        let field = trail(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.6)]);
        let start = Se2::new(0.0, 0.05, 0.3);
        let mut bed = Bed::new(settings, corridor(4.0), field, start, 3);
        let figures = bed.run_to(Se2::new(4.0, 2.6, 1.5), 120.0);
        assert_eq!(figures.phase, Phase::Arrived, "{law:?}");
    }
}

#[test]
fn every_dead_end_is_reported() {
    let failure = |bed: &mut Bed, goal: Se2| {
        let figures = bed.run_to(goal, 400.0);
        assert_eq!(figures.n_touched, 0);
        let Phase::Failed(reason) = figures.phase else { panic!("{:?}", figures.phase) };
        assert!(figures.reports.contains(&Report::Failed(reason)));
        assert!(bed.wheels.left_mps.abs() < 0.31, "it was told to stand");
        reason
    };
    let origin = Se2::new(0.0, 0.0, 0.0);
    let far = Se2::new(8.0, 0.0, 0.0);
    let straight = || trail(&[(0.0, 0.0), (10.0, 0.0)]);

    let nothing = Field::new(101, 101, 0.2).unwrap();
    let mut bed = Bed::new(same, corridor(2.0), nothing, origin, 1);
    assert_eq!(failure(&mut bed, far), FailureReason::NoTrail);

    let elsewhere = trail(&[(-1.0, 0.0), (3.0, 0.0)]);
    let mut bed = Bed::new(same, corridor(2.0), elsewhere, origin, 1);
    assert_eq!(failure(&mut bed, far), FailureReason::NoTrailToGoal);

    let mut walls = corridor(0.8);
    walls.push(wall(5.0, -0.8, 5.0, 0.8));
    let mut bed = Bed::new(same, walls, straight(), origin, 1);
    assert_eq!(failure(&mut bed, far), FailureReason::Blocked);

    let mut bed = Bed::new(same, corridor(2.0), straight(), origin, 1);
    bed.server_answers = false;
    assert_eq!(failure(&mut bed, far), FailureReason::ServerSilent);

    let mut bed = Bed::new(same, corridor(2.0), straight(), origin, 1);
    assert_eq!(
        failure(&mut bed, Se2 { x_m: f64::NAN, y_m: 0.0, yaw_rad: 0.0 }),
        FailureReason::BadGoal
    );
}

#[test]
fn a_broken_link_stops_the_task() {
    let mut bed =
        Bed::new(same, corridor(2.0), trail(&[(0.0, 0.0), (10.0, 0.0)]), Se2::IDENTITY, 1);
    bed.cut_link_at = Some(Stamp::from_millis(12_000));
    let figures = bed.run_to(Se2::new(8.0, 0.0, 0.0), 60.0);
    assert_eq!(figures.phase, Phase::Failed(FailureReason::LinkLost));
    assert!(figures.time_s < 15.0, "{}", figures.time_s);
}

#[test]
fn a_server_that_pauses_only_delays() {
    let mut bed =
        Bed::new(same, corridor(2.0), trail(&[(0.0, 0.0), (10.0, 0.0)]), Se2::IDENTITY, 1);
    bed.server_pause = Some((Stamp::from_millis(10_000), Stamp::from_millis(13_000)));
    let figures = bed.run_to(Se2::new(8.0, 0.0, 0.0), 120.0);
    assert_eq!(figures.phase, Phase::Arrived);
    assert_eq!(figures.n_touched, 0);
}

#[test]
fn stop_stops_and_orders_are_answered() {
    let mut bed =
        Bed::new(same, corridor(2.0), trail(&[(0.0, 0.0), (10.0, 0.0)]), Se2::IDENTITY, 1);
    bed.run_to(Se2::new(8.0, 0.0, 0.0), 12.0);
    assert_eq!(bed.navigator.phase(), Phase::FollowTrail);
    bed.tell(Sensed::Order(Order::Stop));
    bed.tell(Sensed::Order(Order::LinkTest));
    bed.tell(Sensed::Order(Order::ReportSonar));
    for _ in 0..300 {
        bed.tick();
    }
    assert_eq!(bed.navigator.phase(), Phase::Idle);
    assert_eq!(bed.wheels, WheelSpeeds::ZERO);
    let reports = &bed.figures.reports;
    assert!(reports.contains(&Report::LinkEcho));
    let sonar = reports.iter().find_map(|r| if let Report::Sonar(s) = r { Some(*s) } else { None });
    assert!((sonar.unwrap()[0] - 1.86).abs() < 0.1, "{sonar:?}");
    bed.tell(Sensed::Order(Order::Restart));
    bed.tick();
    assert_eq!(bed.figures.reports.last(), Some(&Report::StateEntered(0)));
}

#[test]
fn equal_runs_are_equal_to_the_bit() {
    let run = || {
        let mut bed = box_in_corridor(3);
        let goal = bed.goal;
        let figures = bed.run_to(goal, 120.0);
        let mut hash = StateHash::new();
        for pose in &figures.track {
            for value in [pose.x_m, pose.y_m, pose.yaw_rad] {
                hash.absorb(value);
            }
        }
        (figures.track.len(), hash.value())
    };
    assert_eq!(run(), run());
}

#[test]
fn every_state_of_the_machine_is_told() {
    let mut walls = corridor(1.2);
    walls.extend(boxed(Vec2::new(4.0, 0.1), Vec2::new(0.4, 0.4), 0.2));
    let mut bed = Bed::new(same, walls, trail(&[(0.0, 0.0), (10.0, 0.0)]), Se2::IDENTITY, 1);
    let figures = bed.run_to(Se2::new(8.0, 0.0, 0.0), 120.0);
    let told: Vec<u8> =
        (0..9).filter(|state| figures.reports.contains(&Report::StateEntered(*state))).collect();
    assert_eq!(told, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
}
