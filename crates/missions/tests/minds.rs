//! What the tables of `[robots.mind]` make a robot do: places on its way, and when it gives up.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use geometry::Vec2;
use missions::{Mission, Run};
use run_context::RunSeed;

const HEAD: &str = "[mission]\nname = \"t\"\nduration_max_s = 90.0\n\
    [[robots]]\nline.kind = \"direct\"\n[robots.mind]\nhow.method = \"straight\"\n";
const GOAL: &str = "[[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"robot\"\npose = [5.0, 0.0, 0.0]\n\
     [[success.arrived]]\nrobot = \"robot\"\npose = [5.0, 0.0, 0.0]\n";

/// Where the robot was, every step, and whether the mission passed.
fn driven(text: &str, overrides: &[&str]) -> (Vec<Vec2>, bool) {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let mission = Mission::parse("t.toml", text, &overrides).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    let mut way = Vec::new();
    while run.finished().is_none() {
        run.step();
        let truth = run.poses().next().unwrap().truth;
        way.push(Vec2::new(truth.x_m, truth.y_m));
    }
    (way, run.finished().unwrap().passed)
}

/// The step at which a place is passed nearest, and how near that is, m.
fn nearest(way: &[Vec2], place: Vec2) -> (usize, f64) {
    let apart_m = way.iter().map(|at| (at - place).norm()).enumerate();
    apart_m.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

#[test]
fn places_on_the_way_are_visited_in_their_order_before_the_goal() {
    let places = [Vec2::new(1.0, 1.5), Vec2::new(3.0, -1.0)];
    let text = [HEAD, "where_to.via_m = [[1.0, 1.5], [3.0, -1.0]]\n", GOAL].concat();
    let (way, passed) = driven(&text, &[]);
    assert!(passed);
    let [first, second] = places.map(|place| nearest(&way, place));
    // NEAR of the thesis's machine is 0.25 m.
    assert!(first.1 < 0.3 && second.1 < 0.3, "{first:?} {second:?}");
    assert!(first.0 < second.0 && second.0 < way.len() - 500, "{first:?} {second:?}");
    let (direct, passed) = driven(&[HEAD, GOAL].concat(), &[]);
    assert!(passed);
    assert!(places.iter().all(|&place| nearest(&direct, place).1 > 0.9));
}

#[test]
fn places_on_the_way_are_refused_where_nobody_would_visit_them() {
    let said = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        Mission::load("path-slalom", &overrides).unwrap_err().to_string()
    };
    let set = "robots.mind.where_to.via_m=[[1, 1], [2, 2]]";
    let told = said(&[set]);
    let expected = "robots[0].mind.where_to.via_m = 2 places, and how.method = \"path\": must be absent: only \
                    how.method = \"straight\" visits places on its way";
    assert!(told.ends_with(expected), "{told}");
    let straight = "robots.mind.how.method=straight";
    let told = said(&[straight, "robots.mind.where_to.via_m=[[1, 1], [2, nan]]"]);
    assert!(told.contains("robots[0].mind.where_to.via_m[1] = [2.0, NaN]"), "{told}");
}

/// When a robot of a shipped mission gives up, s, and what it says.
fn gives_up(name: &str, overrides: &[&str]) -> (f64, String) {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let mut run = Run::new(Mission::load(name, &overrides).unwrap(), RunSeed(1)).unwrap();
    while run.finished().is_none() {
        run.step();
        for item in run.drain_log() {
            if let Some((_, why)) = item.text.split_once("gives up: ") {
                return (0.01 * run.steps() as f64, why.to_owned());
            }
        }
    }
    panic!("{name} does not give up");
}

/// Each limit alone decides when; the cut of `server-lost` is at 12 s, that of `link-cut` at 8 s, both goals come at 2 s.
#[test]
fn a_robot_gives_up_when_its_limits_say() {
    let limit = |name: &str, key: &str, value_s: f64| {
        gives_up(name, &[&format!("robots.mind.health.{key}={value_s}")])
    };
    for limit_s in [2.0, 8.0] {
        let (at_s, why) = limit("server-lost", "server_limit_s", limit_s);
        assert!((at_s - 12.0 - limit_s).abs() < 0.6, "{limit_s}: {at_s}");
        assert_eq!(why, "the pheromone server does not answer");
    }
    // Without the setting it is the driver who says so, after 1 s.
    let (usual_s, why) = gives_up("link-cut", &[]);
    let (at_s, _) = limit("link-cut", "link_limit_s", 0.4);
    assert_eq!(why, "the vehicle does not answer");
    assert!(at_s < usual_s - 0.2 && at_s > 8.3, "{at_s} {usual_s}");
    let (at_s, why) = limit("one-obstacle", "task_limit_s", 5.0);
    assert!((at_s - 7.0).abs() < 0.5 && why == "a phase took too long", "{at_s}: {why}");
    let (at_s, why) = limit("one-obstacle", "progress_limit_s", 2.0);
    assert!(at_s > 10.0 && why == "no progress", "{at_s}: {why}");
}

#[test]
fn limits_outside_their_ranges_are_refused_by_name() {
    for (key, value, allowed) in [
        ("task_limit_s", "0.5", "from 1 to 36000 s"),
        ("progress_limit_s", "nan", "from 1 to 3600 s"),
        ("link_limit_s", "0", "from 0.2 to 60 s"),
        ("server_limit_s", "61", "from 0.5 to 60 s"),
    ] {
        let set = format!("robots.mind.health.{key}={value}");
        let said = Mission::load("doorbell", &[set]).unwrap_err().to_string();
        assert!(said.contains(&format!("robots[0].mind.health.{key} = ")), "{said}");
        assert!(said.contains(allowed), "{said}");
    }
    let said = Mission::load("doorbell", &["robots.mind.guard.attempts_max=0".to_owned()]);
    assert!(said.unwrap_err().to_string().ends_with("attempts_max = 0: must be from 1 to 100"));
}
