//! On few runs: what must hold whatever the figures are.

use std::collections::BTreeSet;

use figures::Report;
use missions::sense;

use super::{
    method::{Estimate, Method},
    results::{Case, Results},
    room::at_true_poses,
    sections::TIMES_HEADING,
    *,
};

fn options(n_runs: u32, n_threads: usize) -> Options {
    Options { n_runs, seed: RunSeed(5), n_threads, ..Options::default() }
}

fn in_pool<T: Send>(n_threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap().install(work)
}

fn scope(rooms: &'static [(&'static str, &'static str)], duration_max_s: f64) -> Scope {
    Scope { rooms, rings: &[FIVE], duration_max_s }
}

/// E1 with five sonars only, and not to the end.
fn small(n_runs: u32, n_threads: usize) -> Results {
    let measure =
        || measure(scope(&ROOMS[..1], 100.0), &options(n_runs, n_threads), &|_, _| ()).unwrap();
    in_pool(n_threads, measure)
}

fn without_times(mut report: Report) -> Report {
    report.sections.retain(|section| section.heading != TIMES_HEADING);
    report
}

/// What is in a report of the small run, times left out.
fn report(results: &Results) -> Report {
    without_times(Report {
        sections: vec![
            sections::targets(results),
            sections::maps(results),
            sections::limits(results),
            sections::drives(results).unwrap(),
            sections::search_spaces(results).unwrap(),
            findings::comparison(results),
        ],
        ..Report::default()
    })
}

#[test]
fn the_number_of_threads_changes_nothing_and_the_laws_hold() {
    let results = small(2, 2);
    let alone = small(2, 1);
    assert_eq!(report(&results), report(&alone));

    let (drifting, straight) = (Case::drifting("E1"), Case::straight("E1"));
    let odometry = |case| results.of(case, Method::Odometry);
    assert_eq!(odometry(drifting).len(), 2);
    for (with, without) in odometry(drifting).into_iter().zip(odometry(straight)) {
        assert!(with.rms_m > 2.0 * without.rms_m, "drift {} none {}", with.rms_m, without.rms_m);
    }
    for ratio in results.ratios(drifting, Method::Localised) {
        assert!(ratio < 1.0, "localisation helps against drift: {ratio}");
    }
    for case in [drifting, straight] {
        for judged in results.of(case, Method::TruePoses) {
            assert!(judged.rms_m < 1e-9, "true poses are true: {}", judged.rms_m);
            assert!(judged.exposed.precision_ratio > 0.5, "{:?}", judged.exposed);
        }
        for judged in results.of(case, Method::Localised) {
            let pythagoras = judged.along_m.hypot(judged.across_m);
            assert!((pythagoras - judged.rms_m).abs() < 1e-9, "{pythagoras} {}", judged.rms_m);
            let quarters = judged.quarters_m.map(|q| q * q).iter().sum::<f64>() / 4.0;
            assert!((quarters.sqrt() - judged.rms_m).abs() < 0.01 * judged.rms_m);
        }
    }
    // The second run drifts to the other side.
    let end = |j: usize| {
        let drift = results.tasks.iter().find(|task| task.drift_degpm > 0.0).unwrap();
        let recording = drive(drift, &results.rooms[0], j, &options(2, 1)).unwrap();
        let known = at_true_poses(&recording, results.rooms[0].world_from_map);
        let last = |r: &Recording| r.scans.last().unwrap().odom_from_base.unwrap();
        last(&known).inverse().compose(last(&recording)).yaw_rad
    };
    assert!(end(0) * end(1) < 0.0, "{} {}", end(0), end(1));
}

#[test]
fn what_is_heard_is_in_sight_and_what_is_in_sight_is_a_wall() {
    let room = Room::new(ROOMS[3], FIVE, f64::INFINITY, RunSeed(3)).unwrap();
    let set = |cells: &[grid_maps::Cell]| cells.iter().copied().collect::<BTreeSet<_>>();
    let (all, exposed) = (set(&room.truth.all), set(&room.truth.exposed));
    let heard = set(&room.truth.heard);
    assert!(exposed.is_subset(&all) && exposed.len() < all.len());
    // A point may be seen from between two stations only.
    assert!(heard.difference(&exposed).count() * 50 < heard.len());
    assert!(heard.len() * 4 > exposed.len(), "{} of {}", heard.len(), exposed.len());
    let n_parts: usize = room.truth.parts.iter().map(|(_, cells)| cells.len()).sum();
    assert_eq!(n_parts, all.len(), "every wall is in one arm");
    // Arms of 14.8 m and 2.7 m, a hall of 26.6 + 2.7 m: the hall's part is 29.3 m × 2.7 m, each arm below it
    // 12.1 m × 2.7 m. Things stand in it.
    let floor_m2 = room.truth.floor.len() as f64 * 0.14 * 0.14;
    let whole_m2 = 29.3 * 2.7 + 2.0 * 12.1 * 2.7;
    assert!((0.9 * whole_m2..1.05 * whole_m2).contains(&floor_m2), "{floor_m2} of {whole_m2}");
    assert!(room.truth.near_floor.len() < room.truth.floor.len());
    assert!((36.0..40.0).contains(&room.way_m), "12.45 m and 26 m: {}", room.way_m);
}

/// The document's map and ours lie on the same lattice: three cells aside, its precision falls from 0.67 to 0.48.
#[test]
fn maps_of_both_methods_lie_at_the_same_place() {
    let room = Room::new(ROOMS[0], FIVE, f64::INFINITY, RunSeed(3)).unwrap();
    let slip = ["robots.odometry.slip_std_ratio=0.0".to_owned()];
    let recording = sense(room.mission(0.0, &slip).unwrap(), RunSeed(9)).unwrap();
    let known = at_true_poses(&recording.recordings[0].1, room.world_from_map);
    let without_search = Method::Thesis(0, Maturity::Scans(1_000_000));
    let precision = |method: Method| {
        let estimate: Estimate = method.estimate(&known, &room).unwrap();
        let judged = estimate.judge(&known, &room, false).unwrap();
        (judged.exposed.precision_ratio, judged.exposed.recall_ratio)
    };
    let (ours, described) = (precision(Method::Odometry), precision(without_search));
    assert!(ours.0 > 0.5 && ours.1 > 0.4, "{ours:?}");
    assert!(described.0 > 0.6 && described.1 > 0.5, "{described:?}");
}

#[test]
fn the_experiment_is_found_by_its_name() {
    let found = crate::by_name("sonar-slam").unwrap();
    assert_eq!((found.name, found.n_runs), ("sonar-slam", 20));
    assert!(crate::by_name("sonar").is_none());
}

#[test]
fn every_table_is_complete() {
    let results = measure(scope(&ROOMS, 50.0), &options(1, 0), &|_, _| ()).unwrap();
    let sections = [
        sections::targets(&results),
        sections::maps(&results),
        sections::limits(&results),
        sections::drives(&results).unwrap(),
        sections::odometry_alone(&results),
        sections::search_spaces(&results).unwrap(),
        sections::open_area(&results),
        sections::prior_map(&results).unwrap(),
        sections::joined_areas(&results),
        sections::corridor(&results),
        findings::comparison(&results),
    ];
    let tables: Vec<_> = sections.iter().flat_map(|section| &section.tables).collect();
    for table in &tables {
        assert!(table.rows.iter().all(|row| row.len() == table.head.len()), "{}", table.caption);
        for row in &table.rows {
            assert!(!row.iter().any(String::is_empty), "{}: {row:?}", table.caption);
            // Nothing may be drawn far from the way; everything else was measured.
            let is_band = table.caption.starts_with("Precision of the walls drawn")
                || row[0].starts_with("V2");
            let is_with_drift_only = row[1].starts_with("document, ±3°, ");
            assert!(
                is_band || is_with_drift_only || !row.iter().any(|cell| cell.contains('–')),
                "{row:?}"
            );
        }
    }
    let n_rows: Vec<usize> = tables.iter().map(|table| table.rows.len()).collect();
    assert_eq!(n_rows, [8, 36, 4, 8, 4, 20, 9, 6, 8, 4, 4, 7]);
    let n_figures: usize = sections.iter().map(|section| section.figures.len()).sum();
    assert_eq!(n_figures, 12);
}
