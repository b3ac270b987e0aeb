//! What the step does with readings and odometry; how well it localises is tested in rooms.

use std::time::Duration;

use geometry::Twist;

use super::*;
use crate::{maturity::Maturity, registration::Outcome};

const SILENT: f64 = 9.0;

fn ring() -> RingRig {
    let at = |deg: f64| Se2::new(0.1, 0.0, deg.to_radians());
    RingRig {
        base_from_sensors: vec![at(90.0), at(0.0), at(-90.0)],
        half_angle_rad: 0.26,
        range_min_m: 0.15,
        range_max_m: 5.0,
    }
}

fn scan(ms: u64, x_m: f64, ranges_m: [f64; 3]) -> Scan {
    Scan {
        stamp: Stamp::from_millis(ms),
        odom_from_base: Some(Se2::new(x_m, 0.0, 0.0)),
        ranges_m: ranges_m.to_vec(),
        stamps: Vec::new(),
    }
}

fn localiser(maturity: Maturity) -> Localiser {
    Localiser::new(&ring(), LocaliserConfig { maturity, ..Default::default() }).unwrap()
}

/// Drives `n` rows of 5 cm along walls at both sides; registrations by row.
fn along_walls(localiser: &mut Localiser, n: u64) -> Vec<(u64, Registration)> {
    let rows = (0..n).map(|i| (i, scan(i * 250, 0.05 * i as f64, [1.0, SILENT, 1.2])));
    rows.filter_map(|(i, scan)| localiser.step(&scan).map(|r| (i, r))).collect()
}

#[test]
fn a_short_term_map_is_registered_when_it_is_mature_in_any_unit() {
    let first = |maturity| along_walls(&mut localiser(maturity), 60)[0].0;
    // Two echoes a row, 5 cm and a quarter of a second apart, and at least 12 echoes.
    assert_eq!(first(Maturity::Readings(30)), 14);
    assert_eq!(first(Maturity::Scans(20)), 19);
    assert_eq!(first(Maturity::Seconds(3.0)), 12);
    assert_eq!(first(Maturity::Distance(0.99)), 20);
    assert_eq!(first(Maturity::Scans(2)), 5, "a map that has seen nothing is not mature");
}

#[test]
fn in_open_space_a_short_term_map_lives_on_but_not_for_ever() {
    let mut open = localiser(Maturity::Scans(5));
    let silent = |i: u64| scan(i * 250, 0.05 * i as f64, [SILENT; 3]);
    let first = (0..100).find(|&i| open.step(&silent(i)).is_some());
    assert_eq!(first, Some(40), "the first row that is 2 m on");
    assert!(open.walls().is_empty());
}

#[test]
fn rows_at_standstill_are_not_used() {
    let mut still = localiser(Maturity::Scans(3));
    assert!((0..50).all(|i| still.step(&scan(i * 250, 0.0, [1.0, SILENT, 1.2])).is_none()));
    assert_eq!(still.counts().n_at_standstill, 3 * 49);
    // Creeping on by 4 mm a row, every third row is used.
    let mut creeping = localiser(Maturity::Scans(1000));
    for i in 0..30 {
        creeping.step(&scan(i * 50, 0.004 * i as f64, [1.0, SILENT, 1.2]));
    }
    assert_eq!(creeping.counts().n_at_standstill, 3 * 20);
}

/// Readings of one row are taken one after another: each belongs where the robot was then.
#[test]
fn readings_are_placed_at_their_own_stamps() {
    let config =
        LocaliserConfig { maturity: Maturity::Scans(1000), life_max_m: 50.0, ..Default::default() };
    let mut fast = Localiser::new(&ring(), config).unwrap();
    for i in 0..5_u64 {
        let mut row = scan(i * 1000, i as f64 * 0.5, [1.0, SILENT, 1.2]);
        let stamp = |ms: u64| Stamp::from_millis((i * 1000).saturating_sub(500) + ms);
        row.stamps = vec![stamp(0), stamp(250), stamp(750)];
        fast.step(&row);
    }
    let chain = fast.chain.as_ref().unwrap();
    let at = |reading: &StmReading| chain.pose(reading.at).x_m;
    let of = |sensor: usize| -> Vec<f64> {
        fast.readings.iter().filter(|r| r.sensor == sensor).map(at).collect()
    };
    let close = |found: &[f64], expected: &[f64]| {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near && found.len() == expected.len(), "{found:?}, not {expected:?}");
    };
    close(&of(0), &[0.0, 0.25, 0.75, 1.25, 1.75]);
    // A quarter of a second after the row: it waits until odometry says where that was.
    close(&of(2), &[0.125 * 3.0, 0.625, 1.125, 1.625][..]);
    assert_eq!(fast.pending.len(), 1);
}

#[test]
fn a_ghost_behind_a_known_wall_is_dropped() {
    let mut corridor = localiser(Maturity::Distance(1.0));
    along_walls(&mut corridor, 60);
    // Back in front of what is known: the left sonar misses the wall and hears something at 3 m.
    let row = |i: u64| scan(20_000 + i * 250, 1.0 + 0.05 * i as f64, [3.0, SILENT, 1.2]);
    for i in 0..20 {
        corridor.step(&row(i));
    }
    corridor.finish();
    assert!(corridor.counts().n_ghosts >= 19, "{:?}", corridor.counts());
    let lattice = *corridor.map().lattice();
    let prob = |x: f64, y: f64| corridor.map().prob(lattice.cell_of(Vec2::new(x, y)));
    assert!(prob(1.5, 1.0).unwrap() > 0.9, "the wall is still there");
    assert_eq!(prob(1.5, 2.0), None, "and behind it nothing is known");
    assert!(prob(1.5, 0.5).unwrap() < 0.25, "before it is free: {:?}", prob(1.5, 0.5));
}

#[test]
fn silence_clears_no_more_than_it_may() {
    let mut open = localiser(Maturity::Distance(1.0));
    for i in 0..60 {
        open.step(&scan(i * 250, 0.05 * i as f64, [SILENT; 3]));
    }
    open.finish();
    let lattice = *open.map().lattice();
    let prob = |y: f64| open.map().prob(lattice.cell_of(Vec2::new(1.0, y)));
    assert!(prob(0.4).unwrap() < 0.4);
    assert_eq!(prob(0.8), None);
}

#[test]
fn bad_rows_and_jumps_are_counted_and_survived() {
    let mut l = localiser(Maturity::Distance(1.0));
    let mut without = scan(0, 0.0, [1.0; 3]);
    without.odom_from_base = None;
    assert!(l.step(&without).is_none());
    assert_eq!((l.counts().n_rows_without_odometry, l.map_from_base()), (1, None));
    l.step(&scan(250, 0.0, [1.0, SILENT, 1.2]));
    l.step(&scan(500, 0.05, [f64::INFINITY, f64::NAN, -1.0]));
    let before = l.map_from_base().unwrap();
    l.step(&scan(750, 99.0, [1.0, SILENT, 1.2]));
    l.step(&scan(700, 99.0, [1.0, SILENT, 1.2]));
    assert_eq!((l.counts().n_jumps, l.map_from_base().unwrap()), (1, before));
    let mut long = scan(1000, 99.05, [1.0; 3]);
    long.ranges_m = vec![1.0; 50];
    l.step(&long);
    let x = l.map_from_base().unwrap().x_m;
    assert!((x - 0.1).abs() < 1e-9, "after the jump it goes on from where it was: {x}");
    l.finish();
}

#[test]
fn it_begins_where_it_is_told_and_corrects_odometry_from_there() {
    let mut l = localiser(Maturity::Distance(1.0));
    let begin = Se2::new(3.0, -2.0, 1.0);
    l.begin_at(begin, 0.01, 0.01);
    l.step(&scan(0, 7.0, [SILENT; 3]));
    assert_eq!(l.map_from_base(), Some(begin));
    l.step(&scan(250, 7.5, [SILENT; 3]));
    let expected = begin.compose(Se2::new(0.5, 0.0, 0.0));
    let found = l.map_from_odom().se2().compose(Se2::new(7.5, 0.0, 0.0));
    let off = expected.inverse().compose(found);
    assert!(off.position().norm() < 1e-9 && off.yaw_rad.abs() < 1e-9, "{off:?}");
}

/// The second look knows from the first metre what odometry misses.
#[test]
fn a_second_look_remembers_the_drift_and_nothing_else() {
    let mut first = localiser(Maturity::Distance(1.0));
    for i in 0..160_u64 {
        let mut row = scan(i * 250, 0.0, [1.0, SILENT, 1.2]);
        // The way is straight between straight walls; odometry says that it bends.
        let bent = Twist { dx_m: 0.05 * i as f64, dy_m: 0.0, dyaw_rad: 0.0005 * i as f64 };
        row.odom_from_base = Some(Se2::exp(bent));
        first.step(&row);
    }
    first.finish();
    let second = first.again().unwrap();
    let missed = second.filter.missed_yaw().0;
    assert!((missed + 0.01).abs() < 0.002, "{missed}");
    assert!(second.walls().is_empty() && second.map().bounds().is_none());
}

/// With the walls of an earlier run a wrong start is found and mended.
#[test]
fn a_prior_map_corrects_the_start() {
    let mut first = localiser(Maturity::Distance(1.0));
    along_walls(&mut first, 60);
    first.finish();
    for off_m in [0.08, -0.08] {
        let mut second = localiser(Maturity::Distance(1.0));
        second.set_prior(first.map().clone(), first.walls().to_vec());
        second.begin_at(Se2::new(0.0, off_m, 0.0), 0.1, 0.02);
        let found = along_walls(&mut second, 60);
        assert!(found.iter().all(|(_, r)| r.outcome.is_applied()));
        let pose = second.map_from_base().unwrap();
        assert!(pose.y_m.abs() < 0.01, "{pose:?}");
        assert!((pose.x_m - 2.95).abs() < 0.05, "along the corridor nothing is known: {pose:?}");
    }
}

#[test]
fn switched_off_it_follows_odometry() {
    let mut l = Localiser::new(&ring(), LocaliserConfig::odometry_only()).unwrap();
    let found = along_walls(&mut l, 60);
    assert!(found.iter().all(|(_, r)| r.outcome == Outcome::SwitchedOff));
    assert!((l.map_from_base().unwrap().x_m - 2.95).abs() < 1e-12);
    assert!(l.map().bounds().is_some());
}

#[test]
fn more_odometry_than_rows_gives_the_same_way() {
    let mut l = localiser(Maturity::Distance(10.0));
    l.step(&scan(0, 0.0, [SILENT; 3]));
    l.add_odometry(Stamp::ZERO + Duration::from_millis(100), Se2::new(0.0, 0.0, 0.5));
    l.add_odometry(Stamp::ZERO + Duration::from_millis(150), Se2::new(0.1, 0.05, 0.5));
    let mut last = scan(250, 0.2, [SILENT; 3]);
    last.odom_from_base = Some(Se2::new(0.2, 0.1, 0.5));
    l.step(&last);
    let off = l.map_from_base().unwrap().inverse().compose(Se2::new(0.2, 0.1, 0.5));
    assert!(off.position().norm() < 1e-12 && off.yaw_rad.abs() < 1e-12);
}

/// After warm-up, a row between registrations costs no allocation.
#[test]
fn a_row_does_not_allocate() {
    let mut l = localiser(Maturity::Distance(1.0));
    along_walls(&mut l, 100);
    let rows: Vec<Scan> =
        (100..115).map(|i| scan(i * 250, 0.05 * i as f64, [1.0, SILENT, 1.2])).collect();
    let mut n_registered = 0;
    for row in rows {
        let mut registered = false;
        let used = allocation_counter::measure(|| registered = l.step(&row).is_some());
        n_registered += usize::from(registered);
        assert!(registered || used.count_total == 0, "{used:?}");
    }
    assert!(n_registered <= 1);
}
