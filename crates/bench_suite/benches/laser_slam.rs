//! Laser SLAM: a window of poses searched, a scan laid on a local map, a whole ring of corridors mapped.
//!
//! The scene is made here: a building of rooms, seen by 361 beams. The plain way to search a window
//! is to score every pose of the same lattice; it stands in the table beside branch and bound.

use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::LazyLock,
};

use divan::{Bencher, black_box};
use geometry::{Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use recordings::LaserRig;
use slam::laser::{
    PointsConfig, RefineConfig,
    correlative::{ScoreGrid, SearchWindow},
    points::{PointScan, points_of},
    surfels::SurfelMap,
};

/// Cell of the searched grid, metres.
const CELL_M: f64 = 0.03;
/// The window of the published figure: ±0.25 m would be half of it.
const WINDOW: SearchWindow = SearchWindow {
    half_m: 0.5,
    half_rad: 20.0 * PI / 180.0,
    std_m: f64::INFINITY,
    std_rad: f64::INFINITY,
};

struct Scene {
    map: Vec<(Se2, PointScan)>,
    cloud: Vec<Vec2>,
    ranges_m: Vec<f64>,
    scan: PointScan,
    searched: Vec<Vec2>,
    truth: Se2,
}

static SCENE: LazyLock<Scene> = LazyLock::new(scene);

fn main() {
    divan::main();
}

fn rig() -> LaserRig {
    LaserRig {
        base_from_sensor: Se2::IDENTITY,
        first_beam_rad: -FRAC_PI_2,
        beam_spacing_rad: PI / 360.0,
        n_beams: 361,
        range_max_m: 30.0,
    }
}

/// Two rooms of 8 m × 6 m with a door between them and pillars.
fn rooms() -> SegmentWorld {
    let mut walls = Vec::new();
    let mut line = |corners: &[(f64, f64)]| {
        for pair in corners.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|(x, y)| Vec2::new(x, y));
            walls.push((Segment { a, b }, 0));
        }
    };
    line(&[(0.0, 0.0), (16.0, 0.0), (16.0, 6.0), (0.0, 6.0), (0.0, 0.0)]);
    line(&[(8.0, 0.0), (8.0, 2.4)]);
    line(&[(8.0, 3.4), (8.0, 6.0)]);
    for (x, y) in [(2.0, 4.4), (5.5, 1.2), (10.5, 4.6), (13.0, 1.5), (14.2, 4.0)] {
        line(&[(x, y), (x + 0.4, y), (x + 0.4, y + 0.3), (x, y + 0.3), (x, y)]);
    }
    SegmentWorld::new(walls)
}

fn ranges(world: &SegmentWorld, pose: Se2, rig: &LaserRig) -> Vec<f64> {
    (0..rig.n_beams)
        .map(|i| {
            let bearing_rad = rig.first_beam_rad + i as f64 * rig.beam_spacing_rad;
            let direction = Se2::new(0.0, 0.0, pose.yaw_rad + bearing_rad).heading();
            let ray = Ray { origin: pose.position(), direction };
            let hit = world.cast(&ray, rig.range_max_m);
            hit.map_or(f64::INFINITY, |hit| hit.distance_m)
        })
        .collect()
}

fn scene() -> Scene {
    let (world, rig, config) = (rooms(), rig(), PointsConfig::default());
    let map: Vec<(Se2, PointScan)> = (0..15)
        .map(|i| {
            let pose = Se2::new(1.0 + 0.3 * f64::from(i), 3.0, 0.05 * f64::from(i % 3));
            (pose, points_of(&rig, &ranges(&world, pose, &rig), &config))
        })
        .collect();
    let cloud = map
        .iter()
        .flat_map(|(pose, scan)| scan.points.iter().map(|&p| pose.transform_point(p)))
        .collect();
    let truth = Se2::new(5.37, 2.84, 0.21);
    let ranges_m = ranges(&world, truth, &rig);
    let scan = points_of(&rig, &ranges_m, &config);
    let searched = scan.points.iter().step_by(scan.points.len().div_ceil(180)).copied().collect();
    Scene { map, cloud, ranges_m, scan, searched, truth }
}

/// A guess 0.3 m and 12° off.
fn guess() -> Se2 {
    let truth = SCENE.truth;
    Se2::new(truth.x_m + 0.23, truth.y_m - 0.19, truth.yaw_rad + 0.21)
}

#[divan::bench]
fn points_of_361_ranges(bencher: Bencher<'_, '_>) {
    let (rig, config) = (rig(), PointsConfig::default());
    bencher.bench(|| points_of(&rig, black_box(&SCENE.ranges_m), &config));
}

#[divan::bench]
fn grid_of_15_scans(bencher: Bencher<'_, '_>) {
    let mut grid = ScoreGrid::default();
    bencher.bench_local(|| grid.rebuild(black_box(&SCENE.cloud), CELL_M, 0.08, 6));
}

#[divan::bench]
fn window_half_metre_20_degrees(bencher: Bencher<'_, '_>) {
    let grid = ScoreGrid::of_points(&SCENE.cloud, CELL_M, 0.08, 6);
    bencher.bench(|| grid.correlate(black_box(&SCENE.searched), guess(), &WINDOW, 0.1));
}

/// The same window and lattice, one pose after the other.
#[divan::bench(max_time = 5)]
fn window_half_metre_20_degrees_plain(bencher: Bencher<'_, '_>) {
    let grid = ScoreGrid::of_points(&SCENE.cloud, CELL_M, 0.08, 1);
    bencher.bench(|| grid.correlate(black_box(&SCENE.searched), guess(), &WINDOW, 0.1));
}

#[divan::bench]
fn surfels_of_15_scans(bencher: Bencher<'_, '_>) {
    let mut surfels = SurfelMap::default();
    bencher.bench_local(|| {
        surfels.rebuild(SCENE.map.iter().map(|(pose, scan)| (*pose, scan)), 0.1);
    });
}

#[divan::bench]
fn scan_laid_on_surfels(bencher: Bencher<'_, '_>) {
    let mut surfels = SurfelMap::default();
    surfels.rebuild(SCENE.map.iter().map(|(pose, scan)| (*pose, scan)), 0.1);
    let guess = SCENE.truth.compose(Se2::new(0.1, -0.05, 0.03));
    bencher.bench(|| surfels.refine(&SCENE.scan, black_box(guess), None, &RefineConfig::default()));
}
