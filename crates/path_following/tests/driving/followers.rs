//! Every follower against the promises that all share, with an ideal robot on the x axis.

use std::time::Duration;

use geometry::{Se2, Vec2};
use path_following::{
    EquivalentPoint, Past, PastConfig, Path, PathController, PathFollower, PathFollowerConfig,
    PathLaw, TrailController, TrailFollower, TrailFollowerConfig, TrailLaw, TrailSense,
    TrailTuning,
    fuzzy::{FuzzyConfig, Sets},
    fuzzy_listing::{ListingConfig, ListingFuzzy},
};
use pheromones::{Field, SenseConfig};

use crate::promises::{Follower, Promises, check_follower, drive};

const DT: Duration = Duration::from_millis(200);

fn path_follower(law: PathLaw) -> PathFollower {
    PathFollower::new(PathFollowerConfig { law, ..PathFollowerConfig::default() }).unwrap()
}

fn on_path(law: PathLaw) -> impl Fn() -> Follower {
    move || {
        let path = Path::polyline(&[Vec2::new(-1.0, 0.0), Vec2::new(60.0, 0.0)]).unwrap();
        let mut follower = path_follower(law);
        Box::new(move |pose| follower.step(&path, pose, 0.3, DT))
    }
}

fn on_trail(law: TrailLaw, tells_equivalent: bool) -> impl Fn() -> Follower {
    move || {
        let mut field = Field::new(161, 41, 0.2).unwrap();
        field.draw_trail(&[Vec2::new(-16.0, 0.0), Vec2::new(16.0, 0.0)], 1);
        let config = TrailFollowerConfig { law, ..TrailFollowerConfig::default() };
        let mut follower = TrailFollower::new(config).unwrap();
        Box::new(move |pose| follower.step(sensed(&field, pose, tells_equivalent), 0.3, DT))
    }
}

fn sensed(field: &Field, pose: Se2, tells_equivalent: bool) -> TrailSense {
    let config = SenseConfig::default();
    let smell = field.sense(pose, &config);
    let equivalent = field
        .equivalent_source(pose, &config)
        .filter(|_| tells_equivalent)
        .map(|s| EquivalentPoint { bearing_rad: s.bearing_rad, distance_m: s.distance_m });
    TrailSense { left: smell.left, right: smell.right, equivalent }
}

fn exact(residual_m: f64) -> Promises {
    Promises { wheel_speed_max_mps: 0.75, residual_m, mirrors: true }
}

#[test]
fn every_path_law_keeps_its_promises() {
    for law in PathController::ALL {
        check_follower(law.key(), on_path(law.law()), &exact(0.01));
    }
    let PathLaw::Fuzzy { fuzzy } = PathLaw::fuzzy() else { unreachable!() };
    let five = PathLaw::Fuzzy { fuzzy: FuzzyConfig { sets: Sets::Five, ..fuzzy } };
    check_follower("fuzzy on the path, five sets", on_path(five), &exact(0.01));
}

/// With what the server tells and without; what is left of the distance may differ from law to law, below.
#[test]
fn every_trail_law_keeps_its_promises() {
    for law in TrailController::ALL {
        for tells_equivalent in [false, true] {
            let follower = on_trail(law.law(TrailTuning::default()), tells_equivalent);
            check_follower(law.key(), follower, &exact(0.1));
        }
    }
}

#[test]
fn fuzzy_on_a_trail_keeps_its_promises() {
    check_follower("fuzzy on a trail", on_trail(TrailLaw::fuzzy(), false), &exact(0.03));
    let fuzzy = FuzzyConfig { sets: Sets::Five, ..FuzzyConfig::default() };
    let five = TrailLaw::Fuzzy { fuzzy };
    check_follower("fuzzy on a trail, five sets", on_trail(five, false), &exact(0.03));
}

/// Whole units of 20 mm/s mirror as well, as division of positive numbers rounds both wheels alike.
#[test]
fn the_listing_keeps_its_promises() {
    check_follower("listing", on_trail(TrailLaw::listing(), false), &exact(0.05));
}

#[test]
fn the_fuzzy_angle_keeps_its_promises() {
    check_follower("fuzzy angle", on_trail(TrailLaw::fuzzy_angle(), true), &exact(0.05));
    check_follower("fuzzy angle, guessed", on_trail(TrailLaw::fuzzy_angle(), false), &exact(0.05));
}

#[test]
fn pursuing_the_equivalent_source_keeps_its_promises() {
    check_follower("trail pursuit", on_trail(TrailLaw::pure_pursuit(), true), &exact(0.05));
    check_follower(
        "trail pursuit, guessed",
        on_trail(TrailLaw::pure_pursuit(), false),
        &exact(0.05),
    );
}

/// Polyline, arcs and a crossing: a figure of eight, once around, never further off than stated.
#[test]
fn paths_that_cross_themselves_are_driven_to_their_end() {
    let eight = [(-2.0, -1.5), (2.0, 1.5), (3.5, 0.0), (2.0, -1.5), (-2.0, 1.5), (-3.5, 0.0)];
    let corners: Vec<Vec2> = eight.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    let path = Path::rounded(&corners, 0.8).unwrap();
    for law in PathController::ALL.iter().map(|law| law.law()) {
        let is_close = matches!(law, PathLaw::PurePursuit { .. } | PathLaw::Stanley { .. });
        let off_max_m = if is_close { 0.15 } else { 0.25 };
        let mut follower = path_follower(law);
        let mut pose = path.start();
        let (mut worst_m, mut n_steps, mut travelled_m) = (0.0_f64, 0, 0.0);
        loop {
            let wheels = follower.step(&path, pose, 0.3, DT);
            let progress = follower.progress().unwrap();
            worst_m = worst_m.max(progress.cross_track_m.abs());
            if progress.finished {
                break;
            }
            travelled_m += wheels.linear_mps() * 0.2;
            n_steps += 1;
            assert!(n_steps < 600, "{law:?} never arrives: {pose:?}");
            pose = drive(pose, wheels, 0.2);
        }
        assert!(worst_m < off_max_m, "{law:?} was {worst_m} m off");
        assert!(travelled_m > 0.9 * path.length_m(), "{law:?} took a short cut: {travelled_m} m");
    }
}

/// Led by hand along a curve, then alone along what was recorded, and home again.
#[test]
fn the_past_is_followed_there_and_back() {
    let led =
        Path::rounded(&[Vec2::zeros(), Vec2::new(3.0, 0.0), Vec2::new(3.0, 3.0)], 1.0).unwrap();
    let mut past = Past::new(PastConfig::default()).unwrap();
    for i in 0..=500 {
        past.record(led.pose_at(led.length_m() * f64::from(i) / 500.0), 0.25);
    }
    for (path, home) in
        [(past.path().unwrap(), led.end()), (past.path_back().unwrap(), led.start())]
    {
        let mut follower = path_follower(PathLaw::PURE_PURSUIT);
        let mut pose = path.start();
        for _ in 0..200 {
            let speed_mps = past.speed_at_mps(follower.progress().map_or(0.0, |p| p.arc_length_m));
            pose = drive(pose, follower.step(&path, pose, speed_mps, DT), 0.2);
            assert!(led.project(pose.position()).cross_track_m.abs() < 0.1, "{pose:?}");
        }
        assert!((pose.position() - home.position()).norm() < 0.15, "{pose:?}");
    }
}

/// The promise for the control loop, once the path and the field are there.
#[test]
fn steps_allocate_nothing() {
    let path = Path::polyline(&[Vec2::new(-1.0, 0.0), Vec2::new(60.0, 0.0)]).unwrap();
    let field = Field::new(41, 41, 0.2).unwrap();
    let mut path_followers: Vec<PathFollower> =
        PathController::ALL.iter().map(|law| path_follower(law.law())).collect();
    let trail_follower = |law: &TrailController| {
        let law = law.law(TrailTuning::default());
        TrailFollower::new(TrailFollowerConfig { law, ..TrailFollowerConfig::default() }).unwrap()
    };
    let mut trail_followers: Vec<TrailFollower> =
        TrailController::ALL.iter().map(trail_follower).collect();
    let mut listing = ListingFuzzy::new(ListingConfig::default()).unwrap();
    let mut past = Past::new(PastConfig::default()).unwrap();
    let allocations = allocation_counter::measure(|| {
        for i in 0..50 {
            let pose = Se2::new(f64::from(i) * 0.06, 0.1, 0.2);
            for follower in &mut path_followers {
                follower.step(&path, pose, 0.3, DT);
            }
            for follower in &mut trail_followers {
                follower.step(sensed(&field, pose, true), 0.3, DT);
                let smell = TrailSense { left: f64::from(i), right: 9.0, equivalent: None };
                follower.step(smell, 0.3, DT);
            }
            listing.step(40, 30);
            past.record(pose, 0.3);
        }
    });
    assert_eq!(allocations.count_total, 0);
}
