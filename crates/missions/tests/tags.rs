//! Trails of tags in the floor, through the whole closed loop.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use missions::{Mission, Run, Summary};
use run_context::RunSeed;

fn run(name: &str, seed: u64, overrides: &[&str]) -> Summary {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let mut run = Run::new(Mission::load(name, &overrides).unwrap(), RunSeed(seed)).unwrap();
    run.run_to_end();
    run.summary()
}

fn passes(summary: &Summary) -> bool {
    summary.verdict.as_ref().unwrap().passed
}

fn figure(summary: &Summary, name: &str) -> f64 {
    summary.figure(name).unwrap()
}

/// Out around two corners and back, with unequal wheels and every tenth tag dead.
#[test]
fn the_way_out_and_back_is_found_with_many_seeds() {
    for seed in 1..=8 {
        let summary = run("tag-trail", seed, &[]);
        assert!(passes(&summary), "{seed}: {}", summary.verdict.unwrap().text);
    }
}

/// AT22: with the tags' coordinates the error stays bounded, without them it grows with the way.
#[test]
fn what_tags_store_of_their_place_bounds_the_error() {
    let error_m = |corrects: bool| {
        let method = if corrects { "tag_fixes" } else { "dead_reckoning" };
        let set = format!("robots.mind.where_am_i.method={method}");
        let overrides = vec![set, "tags.missing_ratio=0".to_owned()];
        let mission = Mission::load("tag-trail", &overrides).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        let mut errors_m = [0.0_f64; 2];
        for step in 0..8000 {
            run.step();
            let view = run.view();
            let (is, believed) = (view.robots[0].truth, view.robots[0].estimate);
            let error_m = (is.x_m - believed.x_m).hypot(is.y_m - believed.y_m);
            let half = usize::from(step >= 4000);
            errors_m[half] = errors_m[half].max(error_m);
        }
        errors_m
    };
    let (with, without) = (error_m(true), error_m(false));
    assert!(with[0] < 0.06 && with[1] < 0.06, "{with:?}");
    assert!(without[1] > 2.0 * without[0] && without[1] > 0.2, "{without:?}");
}

/// AT22: look-ahead points in the tags make the robot swing less than two readers' gradient does.
#[test]
fn look_ahead_points_swing_less_than_the_gradient() {
    for seed in 1..=3 {
        let gradient = run("tag-trail", seed, &[]);
        let ahead = run("tag-trail", seed, &["robots.mind.follow.tags.law=look_ahead"]);
        assert!(passes(&ahead), "{seed}: {}", ahead.verdict.unwrap().text);
        let name = "turn_rate_rms_radps";
        let (one, other) = (figure(&ahead, name), figure(&gradient, name));
        assert!(one < 0.8 * other, "{seed} {name}: {one} {other}");
    }
}

/// A straight trail, one robot, and what its passes leave in the tags.
const STRAIGHT: &str = "[mission]\nname = \"straight\"\nduration_max_s = 60.0\n\
    [world]\nbounds_m = [-1.0, -1.0, 6.0, 1.0]\n\
    [[robots]]\nname = \"robot\"\n[robots.mind]\nhow.method = \"tags\"\nfollow.speed_mps = 0.2\n\
    [tags]\ntrails_m = [[[0.0, 0.0], [5.0, 0.0]]]\n\
    [[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"robot\"\npose = [4.8, 0.0, 0.0]\n\
    [success]\nno_contact = true\n[[success.arrived]]\nrobot = \"robot\"\npose = [4.8, 0.0, 0.0]\n";

#[test]
fn passing_robots_amplify_the_trail_once_and_only_the_trail() {
    let strengths = |amplify: u8| {
        let overrides = [format!("robots.tag_readers.amplify={amplify}")];
        let mission = Mission::parse("straight.toml", STRAIGHT, &overrides).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        run.run_to_end();
        assert!(passes(&run.summary()), "{}", run.summary().verdict.unwrap().text);
        let tags = run.scene().tags.unwrap().strengths;
        tags.into_iter().map(|(_, strength)| strength).collect::<Vec<u8>>()
    };
    let (plain, more) = (strengths(0), strengths(20));
    assert_eq!(plain.len(), more.len());
    let mut grown: Vec<u8> = plain.iter().zip(&more).map(|(a, b)| b - a).collect();
    grown.retain(|grown| *grown > 0);
    grown.dedup();
    assert!(grown.contains(&20), "{grown:?}");
    // A robot that stands where it turns may pass the same tag twice; white tags stay white.
    assert!(grown.iter().all(|grown| [20, 40, 55, 60].contains(grown)), "{grown:?}");
    assert!(plain.iter().zip(&more).all(|(before, after)| (*before == 0) == (*after == 0)));
}

/// A box on the trail: the robot stands, waits, goes around it and finds the trail again.
#[test]
fn a_box_on_the_trail_is_passed_and_the_trail_taken_up_again() {
    let text = format!(
        "{STRAIGHT}[[world.things]]\nname = \"box\"\nkind = \"box\"\nmaterial = \"cardboard\"\nat_m = [2.5, 0.05]\n"
    );
    let text =
        text.replace("-1.0, -1.0, 6.0, 1.0", "-1.0, -2.5, 6.0, 2.5").replace("= 60.0", "= 150.0");
    for seed in 1..=4 {
        let mission = Mission::parse("box.toml", &text, &[]).unwrap();
        let mut run = Run::new(mission, RunSeed(seed)).unwrap();
        run.run_to_end();
        assert!(passes(&run.summary()), "{seed}: {}", run.summary().verdict.unwrap().text);
    }
}

/// Nothing to follow is said at once, and the robot does not move far.
#[test]
fn without_a_trail_the_robot_says_so() {
    for (set, reason) in [
        ("tags.missing_ratio=1", "no trail"),
        ("robots.start=[-0.5, 0.7, 0.0]", "no trail"),
        ("robots.tag_readers.miss_prob=1", "no trail"),
    ] {
        let mission = Mission::parse("straight.toml", STRAIGHT, &[set.to_owned()]).unwrap();
        let mut run = Run::new(mission, RunSeed(1)).unwrap();
        run.run_to_end();
        let (summary, view) = (run.summary(), run.view());
        assert!(!passes(&summary), "{set}");
        assert!(
            view.robots[0].failure.as_ref().unwrap().contains(reason),
            "{set}: {:?}",
            view.robots[0].failure
        );
        assert!(figure(&summary, "path_length_m") < 1.0, "{set}");
    }
}

/// Robots on one floor that all write into its tags: the same bits for any number of threads.
#[test]
fn threads_change_nothing_for_robots_that_write_into_tags() {
    let text = STRAIGHT
        .replace(
            "name = \"robot\"\n[robots.n",
            "name = \"robot\"\ncount = 10\nspacing_m = [0.0, 1.0]\nrow_length = 1\n[robots.n",
        )
        .replace("bounds_m = [-1.0, -1.0, 6.0, 1.0]", "bounds_m = [-1.0, -1.0, 6.0, 10.0]")
        .replace("trails_m = [", "trails_m = [[[0.0, 3.0], [5.0, 3.0]], [[0.0, 4.0], [5.0, 4.0]], ")
        .replace("pose = [4.8, 0.0, 0.0]", "pose_from_start = [4.8, 0.0, 0.0]");
    let overrides = ["robots.tag_readers.amplify=5".to_owned()];
    let mission = Mission::parse("many.toml", &text, &overrides).unwrap();
    let hashes = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| {
            let mut run = Run::new(mission.clone(), RunSeed(1)).unwrap();
            let hash = |run: &mut Run| {
                (0..200).for_each(|_| run.step());
                run.state_hash().to_string()
            };
            (0..10).map(|_| hash(&mut run)).collect::<Vec<_>>()
        })
    };
    assert_eq!(hashes(1), hashes(4));
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    for (set, says) in [
        ("tags.width_cells=0", "tags.width_cells = 0"),
        ("tags.peak=0", "tags.peak = 0"),
        ("tags.pitch_m=0.001", "from 0.02 to 2 m"),
        ("tags.missing_ratio=1.5", "from 0 to 1"),
        ("tags.area_m=[0.0, 0.0, 1.0]", "x0 < x1"),
        ("tags.area_m=[0.0, -1.0, 4.0, 1.0]", "tags.trails_m[0][1]"),
        ("tags.trails_m=[[[0.0, 0.0]]]", "two or more corners"),
        ("tags.trails_m=[[[0.0, 0.0], [0.0, 0.0]]]", "two or more corners"),
        ("robots.tag_readers.at_m=[[0.2, 0.0]]", "two places, left and right"),
        ("robots.tag_readers.at_m=[[0.2, -0.1], [0.2, 0.1]]", "the left reader first"),
        ("robots.tag_readers.at_m=[[0.2, 3.0], [0.2, 0.1]]", "within 1 m"),
        ("robots.tag_readers.range_m=0", "from 0.005 to 1 m"),
        ("robots.tag_readers.read_ms=0", "from 1 to 5000 ms"),
        ("robots.mind.follow.tags.hold_m=0", "from 0.05 to 2 m"),
        ("robots.mind.follow.tags.error_full=0", "from 1 to 100000"),
        ("robots.mind.follow.tags.law=\"lookahead\"", "look_ahead"),
        ("robots.line={kind=\"tcp\", address=\"localhost:8101\"}", "the tags are simulated"),
    ] {
        let refused = Mission::parse("straight.toml", STRAIGHT, &[set.to_owned()]);
        let message = refused.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(says), "{set}: {message}");
    }
    let bare = STRAIGHT.replace("[tags]\ntrails_m = [[[0.0, 0.0], [5.0, 0.0]]]\n", "");
    let refused = Mission::parse("bare.toml", &bare, &[]).unwrap_err().to_string();
    assert!(refused.contains("the mission has no [tags]"), "{refused}");
    let unread = STRAIGHT.replace("how.method = \"tags\"", "how.method = \"straight\"");
    let warnings = Mission::parse("unread.toml", &unread, &[]).unwrap().warnings();
    assert!(warnings.iter().any(|w| w.contains("no robot has readers")), "{warnings:?}");
    let nothing = bare.replace("how.method = \"tags\"", "how.method = \"straight\"");
    let nothing = nothing
        .replace("[success]", "[success] # x")
        .replace("[[events]]", "[robots.tag_readers]\n[[events]]");
    let warnings = Mission::parse("nothing.toml", &nothing, &[]).unwrap().warnings();
    assert!(warnings.iter().any(|w| w.contains("no tags to read")), "{warnings:?}");
}
