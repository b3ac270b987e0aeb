//! The same mission, seed and interventions give the same bits, whatever the number of threads.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use geometry::{Se2, Vec2};
use missions::{Intervention, Mission, Run};
use run_context::RunSeed;

/// Hashes after every hundredth of so many steps.
fn hashes(name: &str, seed: u64, steps: u64, overrides: &[&str]) -> Vec<String> {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let mission = Mission::load(name, &overrides).unwrap();
    let mut run = Run::new(mission, RunSeed(seed)).unwrap();
    let mut hashes = Vec::new();
    for step in 1..=steps {
        run.step();
        if step % 100 == 0 {
            hashes.push(run.state_hash().to_string());
        }
    }
    hashes
}

#[test]
fn the_same_run_twice_is_the_same_to_the_bit() {
    let first = hashes("doorbell", 3, 4000, &[]);
    assert_eq!(first, hashes("doorbell", 3, 4000, &[]));
    assert_ne!(first, hashes("doorbell", 4, 4000, &[]), "the seed changes nothing");
}

/// Two seeds whose robots stand still and differ in nothing but what their sonars return, over the
/// wire and without it; nothing that moves could tell them apart.
#[test]
fn what_was_sensed_is_part_of_the_state() {
    for link in ["memory", "direct"] {
        let text = format!(
            "[mission]\nname = \"still\"\nduration_max_s = 60.0\n\
             [[world.walls]]\nline_m = [[1.5, -3.0], [1.5, 3.0]]\n\
             [[robots]]\nmind.how.method = \"straight\"\n[robots.line]\nkind = \"{link}\"\n"
        );
        let after = |seed: u64, steps: u32| {
            let mission = Mission::parse("still.toml", &text, &[]).unwrap();
            let mut run = Run::new(mission, RunSeed(seed)).unwrap();
            (0..steps).for_each(|_| run.step());
            (run.view().robots[0].truth, run.state_hash())
        };
        let ((pose, hash), (other_pose, other_hash)) = (after(1, 300), after(2, 300));
        assert_eq!(pose, other_pose, "{link}: nobody moves");
        assert_ne!(hash, other_hash, "{link}: the readings differ");
        assert_eq!(hash, after(1, 300).1, "{link}: the same seed hears the same");
    }
}

#[test]
fn threads_change_nothing() {
    let few = ["robots.count=60", "robots.row_length=10"];
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| hashes("swarm", 1, 800, &few))
    };
    assert_eq!(with_threads(1), with_threads(4));
}

#[test]
fn reading_along_and_looking_change_nothing() {
    let mission = Mission::load("doorbell", &[]).unwrap();
    let mut plain = Run::new(mission.clone(), RunSeed(5)).unwrap();
    let mut watched = Run::new(mission, RunSeed(5)).unwrap();
    watched.set_trace(true);
    let mut n_packets = 0;
    for _ in 0..3000 {
        plain.step();
        watched.step();
        n_packets += watched.drain_trace().len();
        let _looked = watched.view();
    }
    assert_eq!(plain.state_hash(), watched.state_hash());
    assert!(n_packets > 300, "only {n_packets} packets were read along");
}

#[test]
fn an_intervention_changes_the_run_and_the_same_one_changes_it_alike() {
    let with = |intervention: Option<Intervention>| {
        let mission = Mission::load("one-obstacle", &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        (0..500).for_each(|_| run.step());
        if let Some(intervention) = intervention {
            run.apply(intervention).unwrap();
        }
        (0..500).for_each(|_| run.step());
        run.state_hash()
    };
    let aside = Intervention::SendGoal { robot: 0, goal_in_map: Se2::new(0.0, 2.0, 0.0) };
    assert_eq!(with(Some(aside.clone())), with(Some(aside.clone())));
    assert_ne!(with(Some(aside)), with(None));
    let placed = Intervention::PlaceBox { at: Vec2::new(2.0, 1.0), size_m: 0.3 };
    assert_ne!(with(Some(placed)), with(None));
}

#[test]
fn interventions_that_cannot_be_are_refused_with_a_reason() {
    let mission = Mission::load("doorbell", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    let mut refused = |i: Intervention| run.apply(i).unwrap_err().to_string();
    assert_eq!(
        refused(Intervention::PressButton { device: "gong".into() }),
        "there is no button `gong`; buttons: bell"
    );
    assert_eq!(
        refused(Intervention::Stop { robot: 3 }),
        "there is no robot 3; the mission has 1, counted from 0"
    );
    assert_eq!(
        refused(Intervention::RemoveThing { id: 0 }),
        "there is no thing 0 that may be taken away"
    );
    let on_the_robot = Intervention::PlaceBox { at: Vec2::new(-2.6, -3.1), size_m: 0.4 };
    assert!(refused(on_the_robot).contains("cannot stand"));
    let in_a_wall = Intervention::PlaceBox { at: Vec2::new(-6.0, 0.0), size_m: 0.4 };
    assert!(refused(in_a_wall).contains("a wall is there"));
    let huge = Intervention::PlaceBox { at: Vec2::new(0.0, 0.0), size_m: f64::NAN };
    assert_eq!(refused(huge), "the side of a box must be from 0.05 to 3 m");
    assert!(run.interventions().is_empty(), "a refused intervention was recorded");
}

#[test]
fn a_box_put_down_can_be_taken_away_again() {
    let mission = Mission::load("doorbell", &[]).unwrap();
    let mut run = Run::new(mission, RunSeed(1)).unwrap();
    run.apply(Intervention::PlaceBox { at: Vec2::new(-4.0, 0.0), size_m: 0.4 }).unwrap();
    let things = run.view().things;
    assert_eq!(things.len(), 1);
    assert!(things[0].removable);
    run.apply(Intervention::RemoveThing { id: things[0].id }).unwrap();
    assert!(run.view().things.is_empty());
    assert_eq!(run.interventions().len(), 2);
}
