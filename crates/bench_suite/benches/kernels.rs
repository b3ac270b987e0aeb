//! Ray casts and distance queries in a scanned building, ours and parry2d's on the same rays.
//!
//! The building is the laboratory map of 470 walls and 63 311 points (20 mm) of the measured data;
//! without them a room of 64 pillars stands in, and the figures are not comparable. Origins are
//! spread over the free space that is connected to the robot's home, directions over the circle.
//!
//! First come the nanoseconds for one ray, as medians over passes that alternate between the two,
//! so that a busy machine troubles both alike; then the table of all kernels.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up has to stop")]

use std::{
    f64::consts::TAU,
    io::Read,
    sync::LazyLock,
    time::{Duration, Instant},
};

use divan::{Bencher, black_box, counter::ItemsCount};
use geometry::{Aabb, Ray, RayCaster, Segment, SegmentWorld, Vec2};
use parry2d::{
    math::{Pose2, Vec2 as ParryVec},
    query::{Ray as ParryRay, RayCast},
    shape::{Compound, Cuboid, Segment as ParrySegment, SharedShape},
};
use simulator::activmedia_map::{self, MapFile};

/// Rays per sample: more than any cache remembers.
const N_RAYS: usize = 20_000;
/// Cells of the flood fill that finds the free space, metres.
const CELL_M: f64 = 0.1;
/// Distance to walls that an origin keeps, metres: that of a small robot's sonar ring. It also
/// keeps the flood fill from leaking out through gaps of the scan.
const CLEARANCE_M: f64 = 0.25;
/// Ranges of a sonar and of a laser, metres.
const RANGES_M: [f64; 2] = [5.0, 30.0];

struct Scene {
    world: SegmentWorld,
    parry: Compound,
    rays: Vec<Ray>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let (map, home) = building();
    let world = map.to_segment_world();
    let rays = rays(&world, home);
    Scene { parry: parry(&map), rays, world }
});

fn main() {
    // Not when the table is only listed, or run once as a test.
    if std::env::args().any(|arg| arg == "--bench") {
        print_ns_per_ray();
    }
    divan::main();
}

#[expect(clippy::print_stdout, reason = "the figures are what the program is for")]
fn print_ns_per_ray() {
    /// Passes over all rays; the median is printed.
    const N_PASSES: usize = 15;
    let Scene { world, parry, rays } = &*SCENE;
    let theirs = parry_rays(rays);
    for range_m in RANGES_M {
        let passes = (0..N_PASSES).map(|_| {
            (
                timed(|| n_hits(world, rays, range_m)),
                timed(|| n_parry_hits(parry, &theirs, range_m)),
            )
        });
        let (mut ours, mut parrys): (Vec<_>, Vec<_>) = passes.unzip();
        ours.sort();
        parrys.sort();
        let ns = |sorted: &[Duration]| sorted[N_PASSES / 2].as_nanos() as f64 / rays.len() as f64;
        let (ours_ns, parry_ns) = (ns(&ours), ns(&parrys));
        println!("ray of {range_m} m: {ours_ns:.0} ns, parry2d {parry_ns:.0} ns");
    }
}

#[expect(clippy::disallowed_methods, reason = "a benchmark measures real time")]
fn timed(run: impl FnOnce() -> usize) -> Duration {
    let start = Instant::now();
    black_box(run());
    start.elapsed()
}

fn n_hits(world: &SegmentWorld, rays: &[Ray], range_m: f64) -> usize {
    rays.iter().filter(|ray| world.cast(black_box(ray), range_m).is_some()).count()
}

fn n_parry_hits(parry: &Compound, rays: &[ParryRay], range_m: f64) -> usize {
    let hit = |ray: &&ParryRay| parry.cast_local_ray(black_box(ray), range_m, true).is_some();
    rays.iter().filter(hit).count()
}

fn parry_rays(rays: &[Ray]) -> Vec<ParryRay> {
    let ours = |v: Vec2| ParryVec::new(v.x, v.y);
    rays.iter().map(|r| ParryRay::new(ours(r.origin), ours(r.direction))).collect()
}

/// One ray, from anywhere to anywhere.
#[divan::bench(args = RANGES_M)]
fn ray_cast(bencher: Bencher<'_, '_>, range_m: f64) {
    let Scene { world, rays, .. } = &*SCENE;
    bencher.counter(ItemsCount::new(rays.len())).bench(|| n_hits(world, rays, range_m));
}

/// The same rays through parry2d's hierarchy of the same segments and squares.
#[divan::bench(args = RANGES_M)]
fn ray_cast_parry2d(bencher: Bencher<'_, '_>, range_m: f64) {
    let Scene { parry, rays, .. } = &*SCENE;
    let rays = parry_rays(rays);
    bencher.counter(ItemsCount::new(rays.len())).bench(|| n_parry_hits(parry, &rays, range_m));
}

/// From a place to the nearest wall within 2 m.
#[divan::bench]
fn nearest_distance(bencher: Bencher<'_, '_>) {
    let Scene { world, rays, .. } = &*SCENE;
    bencher.counter(ItemsCount::new(rays.len())).bench(|| {
        let near = |ray: &&Ray| world.nearest_distance(black_box(ray.origin), 2.0).is_some();
        rays.iter().filter(near).count()
    });
}

/// Whether a robot's outline touches anything.
#[divan::bench]
fn touches_polygon(bencher: Bencher<'_, '_>) {
    let Scene { world, rays, .. } = &*SCENE;
    let outline = |ray: &Ray| {
        let side = Vec2::new(-ray.direction.y, ray.direction.x) * 0.21;
        let (front, back) = (ray.direction * 0.21, ray.direction * -0.30);
        [back - side, front - side, front + side, back + side].map(|corner| ray.origin + corner)
    };
    let outlines: Vec<_> = rays.iter().map(outline).collect();
    bencher.counter(ItemsCount::new(outlines.len())).bench(|| {
        outlines.iter().filter(|outline| world.touches_polygon(black_box(*outline))).count()
    });
}

/// From the parts to the index.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn build(bencher: Bencher<'_, '_>) {
    let (map, _) = building();
    bencher.bench(|| black_box(&map).to_segment_world());
}

/// The scanned building, or a stand-in; and a place in it that is free.
fn building() -> (MapFile, Vec2) {
    let Some(path) = testkit::data_folder("maps/columbia.map.gz") else { return pillars() };
    let mut text = String::new();
    let file = std::fs::File::open(path).expect("the file was just found");
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("a packed text");
    let map = activmedia_map::parse(&text).expect("a map");
    let home = map.home.expect("the map has a home").position();
    (map, home)
}

fn pillars() -> (MapFile, Vec2) {
    let corners =
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Vec2::new(x, y));
    let lines = (0..4).map(|i| Segment { a: corners[i], b: corners[(i + 1) % 4] }).collect();
    let pillar = |i: u32| Vec2::new(f64::from(i % 8), f64::from(i / 8)) * 2.0 - Vec2::new(7.0, 7.0);
    let map = MapFile { lines, points: (0..64).map(pillar).collect(), ..MapFile::default() };
    (map, Vec2::zeros())
}

fn parry(map: &MapFile) -> Compound {
    let ours = |v: Vec2| ParryVec::new(v.x, v.y);
    let walls = map
        .lines
        .iter()
        .map(|w| (Pose2::IDENTITY, SharedShape::new(ParrySegment::new(ours(w.a), ours(w.b)))));
    let half_m = 0.5 * map.to_segment_world().point_size_m();
    let square = SharedShape::new(Cuboid::new(ParryVec::new(half_m, half_m)));
    let points = map.points.iter().map(|p| (Pose2::translation(p.x, p.y), square.clone()));
    Compound::new(walls.chain(points).collect())
}

/// Rays from free space: a flood fill from `home`, then points and directions by irrational steps,
/// which spread evenly and are the same on every machine.
fn rays(world: &SegmentWorld, home: Vec2) -> Vec<Ray> {
    let free = free_cells(world, home);
    let part = |i: usize, step: f64| (i as f64 * step).fract();
    let ray = |i| {
        let cell = free[(part(i, 0.618_033_988_749_895) * free.len() as f64) as usize];
        let within =
            Vec2::new(part(i, 0.754_877_666_246_693) - 0.5, part(i, 0.569_840_290_998_053) - 0.5);
        let (s, c) = (TAU * part(i, 0.414_213_562_373_095)).sin_cos();
        Ray { origin: cell + CELL_M * within, direction: Vec2::new(c, s) }
    };
    (0..N_RAYS).map(ray).collect()
}

fn free_cells(world: &SegmentWorld, home: Vec2) -> Vec<Vec2> {
    let Aabb { min, max } = world.bounds();
    let cells = |from: f64, to: f64| ((to - from) / CELL_M).ceil().max(0.0) as usize;
    let (width, height) = (cells(min.x, max.x), cells(min.y, max.y));
    let centre =
        |column: usize, row: usize| min + CELL_M * Vec2::new(column as f64 + 0.5, row as f64 + 0.5);
    let mut seen = vec![false; width * height];
    let mut free = Vec::new();
    let mut waiting = vec![(cells(min.x, home.x) - 1, cells(min.y, home.y) - 1)];
    while let Some((column, row)) = waiting.pop() {
        if column >= width || row >= height || seen[row * width + column] {
            continue;
        }
        seen[row * width + column] = true;
        if world.nearest_distance(centre(column, row), CLEARANCE_M).is_some() {
            continue;
        }
        free.push(centre(column, row));
        waiting.extend([(column + 1, row), (column, row + 1)]);
        waiting.extend([(column.wrapping_sub(1), row), (column, row.wrapping_sub(1))]);
    }
    assert!(!free.is_empty(), "the home is not free");
    free
}
