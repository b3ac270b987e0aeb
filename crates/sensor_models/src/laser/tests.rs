//! The laser against laws: walls, cosines, materials, sweeps.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use geometry::{Segment, SegmentWorld};
use proptest::prelude::*;
use run_context::{RunSeed, Stamp};

use super::*;
use crate::material::{material_by_name, materials};

fn tag(name: &str) -> u32 {
    material_by_name(name).unwrap().0
}

fn wall(ends: [f64; 4], material: &str) -> (Segment, u32) {
    let [ax, ay, bx, by] = ends;
    (Segment { a: Vec2::new(ax, ay), b: Vec2::new(bx, by) }, tag(material))
}

/// A wall across the x axis.
fn across(x_m: f64, material: &str) -> (Segment, u32) {
    wall([x_m, -50.0, x_m, 50.0], material)
}

fn world(walls: &[(Segment, u32)]) -> SegmentWorld {
    SegmentWorld::new(walls.iter().copied())
}

fn exact() -> LaserModel {
    LaserModel::half_circle().without_errors()
}

/// One beam from the origin along the x axis.
fn ahead(model: &LaserModel, walls: &[(Segment, u32)]) -> LaserEcho {
    let ray = Ray { origin: Vec2::zeros(), direction: Vec2::new(1.0, 0.0) };
    let luck = Luck::draw(&mut RunSeed(1).stream("laser"));
    model.measure(&ray, &world(walls), materials(), luck.of(0))
}

#[test]
fn a_scan_of_a_wall_is_one_over_cosine() {
    let scene = world(&[across(2.0, "plaster")]);
    let mut ranges_m = vec![9.0];
    let mut rng = RunSeed(1).stream("laser");
    exact().scan(Se2::IDENTITY, &scene, materials(), &mut rng, &mut ranges_m);
    assert_eq!(ranges_m.len(), 181);
    for (degree, range_m) in (-90..=90).zip(&ranges_m) {
        let expected = (2.0 / f64::from(degree).to_radians().cos()).min(8.0);
        assert!((range_m - expected).abs() < 1e-9, "{degree}: {range_m}");
    }
}

/// 2000 beams of 1 cm and 1 % at 2 m: 3 cm. The mean of the squares is σ² within 5·√(2/n) = 16 %, and
/// the mean is 0 within 5·σ/√n.
#[test]
fn its_errors_have_the_stated_deviation() {
    let scene = world(&[across(2.0, "plaster")]);
    let laser = LaserModel {
        first_beam_rad: 0.0,
        beam_spacing_rad: 0.0,
        n_beams: 2000,
        range_std_ratio: 0.01,
        ..LaserModel::half_circle()
    };
    let mut ranges_m = Vec::new();
    let mut rng = RunSeed(1).stream("laser");
    laser.scan(Se2::IDENTITY, &scene, materials(), &mut rng, &mut ranges_m);
    let errors_m = || ranges_m.iter().map(|r| r - 2.0);
    let variance_m2 = errors_m().map(|e| e * e).sum::<f64>() / 2000.0;
    assert!((variance_m2 / 9e-4 - 1.0).abs() < 0.16, "{variance_m2}");
    assert!((errors_m().sum::<f64>() / 2000.0).abs() < 5.0 * 0.03 / 2000_f64.sqrt());
    // No two beams have the same luck.
    let mut sorted = ranges_m.clone();
    sorted.sort_by(f64::total_cmp);
    assert!(sorted.windows(2).filter(|w| w[0].to_bits() == w[1].to_bits()).count() < 20);
}

/// A dropout of 30 % of 2000 beams: within five standard deviations (20.5) of 600.
#[test]
fn beams_drop_out_as_often_as_stated() {
    let scene = world(&[across(2.0, "plaster")]);
    let laser = LaserModel { beam_spacing_rad: 0.0, first_beam_rad: 0.0, n_beams: 2000, ..exact() };
    let laser = LaserModel { dropout_prob: 0.3, ..laser };
    let mut ranges_m = Vec::new();
    let mut rng = RunSeed(5).stream("laser");
    laser.scan(Se2::IDENTITY, &scene, materials(), &mut rng, &mut ranges_m);
    let n_lost = ranges_m.iter().filter(|&&range_m| range_m > 7.9).count();
    assert!(n_lost.abs_diff(600) < 103, "{n_lost}");
}

/// A surface of remission ρ is seen up to reach·√ρ head-on, and less by the root of the cosine askew.
#[test]
fn dark_and_oblique_surfaces_are_seen_less_far() {
    let laser = LaserModel { reach_m: 10.0, range_max_m: 50.0, ..exact() };
    let head_on_m = 10.0 * 0.3_f64.sqrt();
    for (x_m, seen) in [(head_on_m - 0.01, true), (head_on_m + 0.01, false)] {
        assert_eq!(ahead(&laser, &[across(x_m, "person")]).is_something(), seen, "{x_m}");
    }
    // 60° askew: the wall's normal is 60° from the beam.
    let oblique_m = 10.0 * (0.3_f64 * 0.5).sqrt();
    for (x_m, seen) in [(oblique_m - 0.01, true), (oblique_m + 0.01, false)] {
        let (dx, dy) = (60.0_f64.to_radians().sin(), 60.0_f64.to_radians().cos());
        let askew = wall([x_m - dx, -dy, x_m + dx, dy], "person");
        assert_eq!(ahead(&laser, &[askew]).is_something(), seen, "{x_m}");
    }
    // Strength is remission times cosine.
    let echo = ahead(&laser, &[across(1.0, "person")]);
    assert!((echo.strength_ratio - 0.3).abs() < 1e-12, "{echo:?}");
}

#[test]
fn glass_askew_shows_what_stands_behind_it_and_head_on_itself() {
    let laser = LaserModel { reach_m: 30.0, range_max_m: 50.0, ..exact() };
    let pane = wall([1.0 - 1.0, -1.0, 1.0 + 1.0, 1.0], "glass");
    let behind = ahead(&laser, &[pane, across(3.0, "plaster")]);
    assert!((behind.range_m - 3.0).abs() < 1e-5, "{behind:?}");
    // Twice through the glass.
    assert!((behind.strength_ratio - 0.8 * 0.85 * 0.85).abs() < 1e-12, "{behind:?}");
    let head_on = ahead(&laser, &[across(1.0, "glass"), across(3.0, "plaster")]);
    assert!((head_on.range_m - 1.0).abs() < 1e-12, "{head_on:?}");
    // Too far for the 8 % that it throws back: it is not there.
    let far = ahead(&laser, &[across(9.0, "glass"), across(10.0, "plaster")]);
    assert!((far.range_m - 10.0).abs() < 1e-5, "{far:?}");
    assert_eq!(ahead(&laser, &[pane]), LaserEcho::NOTHING);
}

#[test]
fn a_mirror_shows_what_stands_before_it_too_far() {
    let laser = LaserModel { reach_m: 20.0, range_max_m: 50.0, ..exact() };
    // At 45°: the beam goes on along +y from (2, 0) to a wall at y = 3.
    let mirror = wall([1.0, -1.0, 3.0, 1.0], "mirror");
    let side = wall([-50.0, 3.0, 50.0, 3.0], "plaster");
    let seen = ahead(&laser, &[mirror, side]);
    assert!((seen.range_m - 5.0).abs() < 1e-5, "{seen:?}");
    assert_eq!(ahead(&laser, &[mirror]), LaserEcho::NOTHING);
    // A hair off head-on, it is not seen and shows what is behind the laser.
    let (dx, dy) = (0.05_f64.sin(), 0.05_f64.cos());
    let almost = wall([2.0 - dx, -dy, 2.0 + dx, dy], "mirror");
    let back = ahead(&laser, &[almost, across(-1.0, "plaster")]);
    assert!((back.range_m - (2.0 + 3.0 / 0.1_f64.cos())).abs() < 1e-4, "{back:?}");
    let head_on = ahead(&laser, &[across(2.0, "mirror"), across(-1.0, "plaster")]);
    assert!((head_on.range_m - 2.0).abs() < 1e-12, "{head_on:?}");
}

#[test]
fn two_mirrors_end_after_a_few_surfaces() {
    let (dx, dy) = (0.05_f64.sin(), 0.05_f64.cos());
    let almost = |x: f64| wall([x - 9.0 * dx, -9.0 * dy, x + 9.0 * dx, 9.0 * dy], "mirror");
    let laser = LaserModel { reach_m: 1e4, range_max_m: 1e3, ..exact() };
    let laser = LaserModel { range_min_m: 0.0, ..laser };
    // Either one of the mirrors answers by its dust or nothing does; it ends.
    let echo = ahead(&laser, &[almost(2.0), almost(-2.0)]);
    assert!(echo.range_m > 1.0, "{echo:?}");
}

#[test]
fn what_is_too_near_or_too_far_returns_nothing() {
    let laser = LaserModel { range_min_m: 0.15, range_max_m: 6.0, ..exact() };
    for (x_m, seen) in [(0.149, false), (0.151, true), (5.999, true), (6.001, false)] {
        assert_eq!(ahead(&laser, &[across(x_m, "plaster")]).is_something(), seen, "{x_m}");
    }
}

#[test]
fn ranges_are_whole_steps() {
    let laser = LaserModel { range_step_m: 0.01, ..exact() };
    let echo = ahead(&laser, &[across(1.234, "plaster")]);
    assert!((echo.range_m - 1.23).abs() < 1e-12, "{echo:?}");
}

#[test]
fn settings_outside_their_ranges_are_named() {
    for kind in LaserKind::ALL {
        assert_eq!(kind.model().checked(), Ok(kind.model()));
        assert_eq!(LaserKind::by_name(kind.name()), Some(kind));
    }
    let bad = |model: LaserModel| model.checked().unwrap_err().key;
    let good = LaserModel::ld06();
    assert_eq!(bad(LaserModel { n_beams: 0, ..good }), "n_beams");
    assert_eq!(bad(LaserModel { n_beams: 452, ..good }), "beam_spacing_rad * (n_beams - 1)");
    assert_eq!(bad(LaserModel { turn: Duration::ZERO, ..good }), "turn");
    assert_eq!(bad(LaserModel { n_turns: 9, ..good }), "n_turns");
    assert_eq!(bad(LaserModel { range_min_m: 13.0, ..good }), "range_max_m");
    assert_eq!(bad(LaserModel { reach_m: f64::NAN, ..good }), "reach_m");
    assert_eq!(bad(LaserModel { dropout_prob: -0.1, ..good }), "dropout_prob");
    let error = LaserModel { range_std_m: 2.0, ..good }.checked().unwrap_err();
    assert_eq!(error.to_string(), "range_std_m = 2: must be from 0 to 1 m");
}

/// All beams that a sweep fires in `until_ms`, asked every `step_ms`, of a sensor that moves as `pose` says.
fn swept(
    model: LaserModel,
    scene: &SegmentWorld,
    [step_ms, until_ms]: [u64; 2],
    pose: impl Fn(f64) -> Se2,
) -> Vec<Beam> {
    let mut sweep = Sweep::new(model, RunSeed(1).stream("laser"));
    let mut beams = Vec::new();
    sweep.start(Stamp::ZERO);
    for ms in (0..=until_ms).step_by(step_ms as usize) {
        let now = Stamp::from_millis(ms);
        sweep.fire(now, pose(now.as_secs_f64()), scene, materials(), |beam| beams.push(beam));
    }
    beams
}

/// A robot that drives and turns evenly: each beam measures from where it was when it was fired.
#[test]
fn a_turning_robot_bends_its_scan() {
    let scene = world(&[across(3.0, "plaster")]);
    let pose = |t: f64| Se2::new(0.4 * t, 0.0, -1.5 * t + 0.4);
    let beams = swept(LaserModel::ld06().without_errors(), &scene, [10, 300], pose);
    assert_eq!(beams.len(), 3 * 450 + 1);
    let mut n_checked = 0;
    for (i, beam) in beams.iter().enumerate() {
        // 4500 beams a second, clockwise by 0.8°.
        let t = i as f64 / 4500.0;
        assert!((beam.at.as_secs_f64() - t).abs() < 1e-6);
        assert_eq!(beam.index, i % 450);
        assert_eq!((beam.is_first, beam.is_last), (i % 450 == 0, i % 450 == 449));
        let towards = pose(t).yaw_rad - (i % 450) as f64 * 0.8_f64.to_radians();
        let expected = (3.0 - 0.4 * t) / towards.cos();
        if expected > 0.0 && expected < 11.9 {
            n_checked += 1;
            assert!((beam.echo.range_m - expected).abs() < 1e-6, "{i}: {beam:?} {expected}");
        } else if !(0.0..12.1).contains(&expected) {
            assert_eq!(beam.echo, LaserEcho::NOTHING);
        }
    }
    assert!(n_checked > 500);
}

#[test]
fn how_often_it_is_asked_makes_no_difference() {
    let scene = world(&[across(3.0, "plaster"), wall([-9.0, 2.0, 9.0, 2.0], "wood")]);
    let pose = |t: f64| Se2::new(0.4 * t, 0.1 * t, 1.2 * t);
    let coarse = swept(LaserModel::rplidar_a1(), &scene, [10, 400], pose);
    let fine = swept(LaserModel::rplidar_a1(), &scene, [2, 400], pose);
    assert_eq!(coarse.len(), fine.len());
    for (a, b) in coarse.iter().zip(&fine) {
        assert_eq!((a.index, a.at), (b.index, b.at));
        let same = (a.echo.range_m - b.echo.range_m).abs() < 3e-4 || a.echo == b.echo;
        assert!(same, "{a:?} {b:?}");
    }
}

/// Half-degree scans of a mirror that turns by whole degrees: two turns, 361 beams, even ones first.
#[test]
fn interlaced_beams_wait_for_their_turn() {
    let half_degrees = LaserModel {
        beam_spacing_rad: 0.5_f64.to_radians(),
        n_beams: 361,
        n_turns: 2,
        ..LaserModel::half_circle()
    };
    let beams = swept(half_degrees, &world(&[]), [1, 40], |_| Se2::IDENTITY);
    let scan: Vec<usize> = beams.iter().take(361).map(|beam| beam.index).collect();
    let expected: Vec<usize> = (0..=360).step_by(2).chain((1..360).step_by(2)).collect();
    assert_eq!(scan, expected);
    // The second turn begins 13.3 ms after the first; the second scan after two.
    assert_eq!(beams[181].at.as_nanos() / 1000, 13_351);
    assert_eq!(beams[361].at.as_nanos() / 1000, 26_666);
}

#[test]
fn a_stopped_head_fires_nothing_and_a_long_pause_begins_anew() {
    let scene = world(&[across(3.0, "plaster")]);
    let mut sweep = Sweep::new(LaserModel::ld06(), RunSeed(1).stream("laser"));
    let count = |sweep: &mut Sweep, ms: u64| {
        let mut n = 0;
        sweep.fire(Stamp::from_millis(ms), Se2::IDENTITY, &scene, materials(), |_| n += 1);
        n
    };
    assert_eq!(count(&mut sweep, 50), 0);
    sweep.start(Stamp::from_millis(50));
    assert_eq!(count(&mut sweep, 60), 46);
    assert_eq!(count(&mut sweep, 60), 0);
    sweep.stop();
    assert_eq!(count(&mut sweep, 100), 0);
    sweep.start(Stamp::from_millis(100));
    assert_eq!(count(&mut sweep, 110), 46);
    // A minute later: one beam, not 270 000.
    assert_eq!(count(&mut sweep, 60_110), 1);
}

#[test]
fn a_robot_that_is_lifted_measures_from_where_it_is_put() {
    let scene = world(&[across(3.0, "plaster")]);
    let pose = |t: f64| Se2::new(if t < 0.005 { -7.0 } else { 1.0 }, 0.0, FRAC_PI_4);
    let beams = swept(LaserModel::ld06().without_errors(), &scene, [10, 10], pose);
    // The beam at 0 saw from afar; the next ones, 0.8° apart, from 2 m.
    let expected = 2.0 / (FRAC_PI_4 - 0.8_f64.to_radians()).cos();
    assert!((beams[1].echo.range_m - expected).abs() < 1e-9, "{:?}", beams[1]);
    assert!((beams[0].echo.range_m - 10.0 * SQRT_2).abs() > 1.0);
}

proptest! {
    /// One number a scan, whatever is met: what comes after never depends on the scene.
    #[test]
    fn the_scene_does_not_shift_later_scans(x_m in 0.3_f64..7.0) {
        let twice = |first: &SegmentWorld, second: &SegmentWorld| {
            let mut rng = RunSeed(3).stream("laser");
            let mut ranges_m = Vec::new();
            for scene in [first, second] {
                let laser = LaserModel::rplidar_a1();
                laser.scan(Se2::IDENTITY, scene, materials(), &mut rng, &mut ranges_m);
            }
            ranges_m
        };
        let wall = world(&[across(2.0, "plaster")]);
        let same = twice(&world(&[]), &wall);
        prop_assert_eq!(same, twice(&world(&[across(x_m, "glass"), across(-x_m, "wood")]), &wall));
    }
}
