//! Trails: one pheromone query by map and number of sources, one fuzzy step.
//!
//! A query must not notice how large the map is or how many sources it has: `cargo bench -p
//! cairn_bench_suite --bench trails`.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up has nothing to measure")]

use std::{f64::consts::TAU, hint::black_box, time::Duration};

use divan::Bencher;
use geometry::{Se2, Vec2};
use path_following::{
    Path, PathFollower, PathFollowerConfig, PathLaw, TrailFollower, TrailFollowerConfig, TrailLaw,
    TrailSense,
    fuzzy::{FuzzyConfig, FuzzyController},
    fuzzy_listing::{ListingConfig, ListingFuzzy},
};
use pheromones::{Field, Perception, SenseConfig};

fn main() {
    divan::main();
}

/// A thousand by a thousand cells, every `one_in`th a source, in no pattern.
fn scattered(one_in: usize) -> Field {
    let mut field = Field::new(1000, 1000, 0.2).expect("a valid size");
    let n_cells = 1_000_000;
    for i in 0..n_cells / one_in {
        // 757 is prime to the number of cells: every place is met once.
        let cell_index = i * one_in * 757 % n_cells;
        field.set(cell_index % 1000, cell_index / 1000, 1).expect("a cell of the field");
    }
    field
}

/// Poses all over the map.
fn poses() -> Vec<Se2> {
    (0..1000)
        .map(|i| {
            let part = |prime: i32| f64::from(i * prime % 1000) / 1000.0 - 0.5;
            Se2::new(190.0 * part(37), 190.0 * part(313), TAU * part(71))
        })
        .collect()
}

fn query(bencher: Bencher<'_, '_>, field: &Field, config: &SenseConfig) {
    let poses = poses();
    let mut turn = 0;
    bencher.bench_local(|| {
        turn = (turn + 1) % poses.len();
        field.sense(black_box(poses[turn]), black_box(config))
    });
}

/// Both antennas; the number is how many sources the map of a million cells has.
#[divan::bench(args = [10_000, 1_000_000])]
fn scalar_sum_by_sources(bencher: Bencher<'_, '_>, n_sources: usize) {
    query(bencher, &scattered(1_000_000 / n_sources), &SenseConfig::default());
}

#[divan::bench(args = [10_000, 1_000_000])]
fn vector_sum_by_sources(bencher: Bencher<'_, '_>, n_sources: usize) {
    let perception = Perception::VectorAtan2;
    let config = SenseConfig { perception, ..SenseConfig::default() };
    query(bencher, &scattered(1_000_000 / n_sources), &config);
}

#[divan::bench(args = [10_000, 1_000_000])]
fn strict_listing_by_sources(bencher: Bencher<'_, '_>, n_sources: usize) {
    let config =
        SenseConfig { perception: Perception::Listing, strict: true, ..SenseConfig::default() };
    query(bencher, &scattered(1_000_000 / n_sources), &config);
}

/// The same query, the map being a square of so many cells a side, full of sources.
#[divan::bench(args = [21, 200, 2000])]
fn scalar_sum_by_map_side(bencher: Bencher<'_, '_>, side: usize) {
    let mut field = Field::new(side, side, 0.2).expect("a valid size");
    for cell_index in 0..side * side {
        field.set(cell_index % side, cell_index / side, 1).expect("a cell of the field");
    }
    let config = SenseConfig::default();
    bencher.bench_local(|| field.sense(black_box(Se2::new(0.03, 0.05, 0.7)), black_box(&config)));
}

#[divan::bench]
fn fuzzy_step(bencher: Bencher<'_, '_>) {
    let controller = FuzzyController::new(FuzzyConfig::default()).expect("valid settings");
    let mut error = 0.0;
    bencher.bench_local(|| {
        error = if error > 60.0 { -60.0 } else { error + 0.37 };
        controller.step(black_box(error), black_box(-0.3 * error), black_box(0.3))
    });
}

#[divan::bench]
fn fuzzy_listing_step(bencher: Bencher<'_, '_>) {
    let mut controller = ListingFuzzy::new(ListingConfig::default()).expect("valid settings");
    let mut left = 0_u8;
    bencher.bench_local(|| {
        left = left.wrapping_add(7);
        controller.step(black_box(left), black_box(120))
    });
}

#[divan::bench]
fn fuzzy_trail_follower_step(bencher: Bencher<'_, '_>) {
    let config = TrailFollowerConfig { law: TrailLaw::fuzzy(), ..TrailFollowerConfig::default() };
    let mut follower = TrailFollower::new(config).expect("valid settings");
    let mut left = 0.0;
    bencher.bench_local(|| {
        left = if left > 200.0 { 1.0 } else { left + 0.37 };
        let sensed = TrailSense { left, right: 120.0, equivalent: None };
        follower.step(black_box(sensed), 0.3, Duration::from_millis(200))
    });
}

/// On a path of a hundred pieces.
#[divan::bench]
fn pure_pursuit_step(bencher: Bencher<'_, '_>) {
    let zigzag: Vec<Vec2> = (0..=100).map(|i| Vec2::new(f64::from(i), f64::from(i % 2))).collect();
    let path = Path::polyline(&zigzag).expect("a hundred different points");
    let config = PathFollowerConfig { law: PathLaw::PURE_PURSUIT, ..PathFollowerConfig::default() };
    let mut follower = PathFollower::new(config).expect("valid settings");
    let mut along_m = 0.0;
    bencher.bench_local(|| {
        along_m = if along_m > 130.0 { 0.0 } else { along_m + 0.06 };
        follower.step(&path, black_box(path.pose_at(along_m)), 0.3, Duration::from_millis(200))
    });
}
