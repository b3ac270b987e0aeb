//! Occupancy grids: scans and cones in, rays and distances out; ours and the plain way.
//!
//! The plain way is what one writes first: a flat `Vec<f32>`, a line by Bresenham for each beam,
//! every cell of it changed. Scenes are made here, so the figures need no data: rooms of 6 m × 5 m
//! on both sides of corridors, with doors and furniture, from a fixed seed.
//!
//! First come the figures that documents quote, as medians over passes that alternate between ours
//! and the plain way, so that a busy machine troubles both alike; then the table of all kernels.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up has to stop")]

use std::{
    f64::consts::{PI, TAU},
    sync::LazyLock,
    time::{Duration, Instant},
};

use divan::{Bencher, black_box, counter::ItemsCount};
use geometry::{Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use grid_maps::{
    BeamFan, Cell, CellBox, ConeInserter, ConeShape, DistanceField, EvidenceModel, Lattice,
    LogOddsMap, RayMap, RayWalk, ScanInserter, ScanRules, State, Thresholds, Window,
    squared_distances,
};

const LASER_RESOLUTION_M: f64 = 0.05;
const SONAR_RESOLUTION_M: f64 = 0.035;
const N_BEAMS: usize = 361;
const LASER_RANGE_M: f64 = 30.0;
/// Poses of scans and rings: more than one, so that no cache knows the next.
const N_POSES: usize = 64;
/// Side of the map for ray casts, cells.
const RAY_MAP_CELLS: usize = 4000;
const N_RAYS: usize = 20_000;
/// Angles of the sonars of a ring, degrees.
const RING_DEG: [f64; 8] = [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0];

/// Poses in the building with what a laser and a ring measure there.
struct Scene {
    fan: BeamFan,
    poses: Vec<Se2>,
    scans: Vec<Vec<f64>>,
    rings: Vec<[f64; 8]>,
}

/// A map for rays, and rays from its free cells.
struct RayScene {
    map: RayMap,
    occupied: Window<bool>,
    lattice: Lattice,
    rays: Vec<(Vec2, Vec2)>,
}

static SCENE: LazyLock<Scene> = LazyLock::new(scene);
static ROOMS: LazyLock<RayScene> = LazyLock::new(|| ray_scene(rooms_200_m(), 1));
static HALL: LazyLock<RayScene> = LazyLock::new(|| ray_scene(hall_200_m(), 1));
static SCANS: LazyLock<RayScene> = LazyLock::new(|| ray_scene(rooms_200_m(), N_BEAMS));

fn main() {
    // Not when the table is only listed, or run once as a test.
    if std::env::args().any(|arg| arg == "--bench") {
        print_figures();
    }
    divan::main();
}

#[expect(clippy::print_stdout, reason = "the figures are what the program is for")]
fn print_figures() {
    let ranges = SCENE.scans.iter().flatten().filter(|range_m| range_m.is_finite());
    let mean_m = ranges.clone().sum::<f64>() / ranges.count() as f64;
    println!("scans of {N_BEAMS} beams, mean range {mean_m:.1} m");
    let (mut map, mut inserter) = laser_map();
    let mut plain = Plain::new(LASER_RESOLUTION_M);
    let mut n_cells = 0;
    let mut insert_ours = || n_cells = insert_scans(&mut map, &mut inserter);
    let mut insert_plainly = || plain.insert_scans();
    let [ours, theirs] = alternating([&mut insert_ours, &mut insert_plainly]);
    let per_scan_us = |time: Duration| time.as_secs_f64() * 1e6 / N_POSES as f64;
    let rate = |n: usize, time: Duration| n as f64 / time.as_secs_f64() / 1e6;
    let (us, plain_us) = (per_scan_us(ours), per_scan_us(theirs));
    println!("scan into map: {us:.1} µs, plain {plain_us:.1} µs");
    let (cells, plain_cells) = (rate(n_cells, ours), rate(plain.n_cells, theirs));
    println!("cell updates: {cells:.0} M/s, plain {plain_cells:.0} M/s");
    let (mut map, cones) = sonar_map();
    let mut n_cells = 0;
    let [ours] = alternating([&mut || n_cells = insert_rings(&mut map, &cones)]);
    let (us, cells) = (per_scan_us(ours), rate(n_cells, ours));
    println!("ring of 8 sonars, 15° cones: {us:.1} µs, {cells:.0} M cells/s");
    for (name, scene) in
        [("anywhere, rooms", &*ROOMS), ("anywhere, hall", &*HALL), ("of scans, rooms", &*SCANS)]
    {
        let mut n_hits = [0; 2];
        let [first, second] = &mut n_hits;
        // Not in turn: the plain way fills all caches with cells, and leaves nothing of ours.
        let [ours] = alternating([&mut || *first = cast(scene)]);
        let [theirs] = alternating([&mut || *second = walk(scene)]);
        assert_eq!(n_hits[0], n_hits[1], "both ways hit the same");
        let (ours, theirs) = (rate(N_RAYS, ours), rate(N_RAYS, theirs));
        println!("rays {name}, 4000 × 4000: {ours:.1} M/s, cell by cell {theirs:.1} M/s");
    }
}

/// Median times, in turn.
fn alternating<const N: usize>(mut runs: [&mut dyn FnMut(); N]) -> [Duration; N] {
    const N_PASSES: usize = 31;
    let mut times = [(); N].map(|()| Vec::new());
    for _ in 0..N_PASSES {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            times.push(timed(run));
        }
    }
    times.map(|mut times| {
        times.sort();
        times[N_PASSES / 2]
    })
}

#[expect(clippy::disallowed_methods, reason = "a benchmark measures real time")]
fn timed(run: &mut dyn FnMut()) -> Duration {
    let start = Instant::now();
    run();
    start.elapsed()
}

/// 361 beams over half a turn, cells of 5 cm.
#[divan::bench]
fn scan(bencher: Bencher<'_, '_>) {
    let (mut map, mut inserter) = laser_map();
    bencher.counter(ItemsCount::new(N_POSES)).bench_local(|| insert_scans(&mut map, &mut inserter));
}

/// The same into an empty map, tiles and all.
#[divan::bench]
fn scan_into_new_map(bencher: Bencher<'_, '_>) {
    let (empty, mut inserter) = laser_map();
    bencher
        .counter(ItemsCount::new(N_POSES))
        .with_inputs(|| empty.clone())
        .bench_local_refs(|map| insert_scans(map, &mut inserter));
}

/// The same beams one by one, as the definition has it.
#[divan::bench]
fn scan_by_rays(bencher: Bencher<'_, '_>) {
    let (mut map, _) = laser_map();
    bencher.counter(ItemsCount::new(N_POSES)).bench_local(|| {
        for_each_beam(|from, to| map.insert_ray(from, to, true));
    });
}

/// The plain way.
#[divan::bench]
fn scan_plain(bencher: Bencher<'_, '_>) {
    let mut plain = Plain::new(LASER_RESOLUTION_M);
    bencher.counter(ItemsCount::new(N_POSES)).bench_local(|| plain.insert_scans());
}

/// 8 sonars with cones of 15° to both sides, cells of 35 mm.
#[divan::bench]
fn sonar_ring(bencher: Bencher<'_, '_>) {
    let (mut map, cones) = sonar_map();
    bencher.counter(ItemsCount::new(N_POSES)).bench_local(|| insert_rings(&mut map, &cones));
}

/// From free places in a building of rooms, anywhere.
#[divan::bench]
fn ray_in_rooms(bencher: Bencher<'_, '_>) {
    LazyLock::force(&ROOMS);
    bencher.counter(ItemsCount::new(N_RAYS)).bench(|| cast(&ROOMS));
}

/// The same in a hall of 200 m with a pillar here and there.
#[divan::bench]
fn ray_in_hall(bencher: Bencher<'_, '_>) {
    LazyLock::force(&HALL);
    bencher.counter(ItemsCount::new(N_RAYS)).bench(|| cast(&HALL));
}

/// In rooms again, but 361 rays from each place, as a scan has them.
#[divan::bench]
fn ray_of_scan(bencher: Bencher<'_, '_>) {
    LazyLock::force(&SCANS);
    bencher.counter(ItemsCount::new(N_RAYS)).bench(|| cast(&SCANS));
}

#[divan::bench]
fn ray_in_rooms_cell_by_cell(bencher: Bencher<'_, '_>) {
    LazyLock::force(&ROOMS);
    bencher.counter(ItemsCount::new(N_RAYS)).bench(|| walk(&ROOMS));
}

/// From cells to the index.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn ray_map_4000(bencher: Bencher<'_, '_>) {
    let RayScene { occupied, lattice, .. } = &*ROOMS;
    bencher.bench(|| RayMap::new(*lattice, black_box(occupied), |occupied| occupied));
}

/// Exact distances of a million cells.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn distances_1000(bencher: Bencher<'_, '_>) {
    let area = CellBox { min: Cell::new(0, 0), width: 1000, height: 1000 };
    let rooms = &ROOMS.occupied;
    let values = (0..1000).flat_map(|row| rooms.row(row)[..1000].to_vec()).collect();
    let cells = Window::from_values(area, values).expect("a million values");
    bencher
        .counter(ItemsCount::new(area.n_cells()))
        .bench(|| squared_distances(black_box(&cells), |occupied| occupied));
}

/// Distance and slope at 361 points.
#[divan::bench]
fn distance_samples(bencher: Bencher<'_, '_>) {
    let (mut map, mut inserter) = laser_map();
    insert_scans(&mut map, &mut inserter);
    let area = map.bounds().expect("a map with scans");
    let field = DistanceField::of_map(&map, area, &Thresholds::default(), 1.0);
    let field = field.expect("a small map");
    let mut points = Vec::new();
    for_each_beam(|_, to| points.push(to));
    bencher.counter(ItemsCount::new(points.len())).bench(|| {
        let distances = points.iter().filter_map(|point| field.sample(black_box(*point)));
        distances.map(|sample| sample.distance_m + sample.gradient.x).sum::<f64>()
    });
}

/// A submap of 20 m as a dense window.
#[divan::bench]
fn crop_400(bencher: Bencher<'_, '_>) {
    let (mut map, mut inserter) = laser_map();
    insert_scans(&mut map, &mut inserter);
    let corner = map.lattice().cell_of(Vec2::new(90.0, 90.0));
    let area = CellBox { min: corner, width: 400, height: 400 };
    bencher.counter(ItemsCount::new(area.n_cells())).bench(|| map.grid().crop(black_box(area)));
}

fn laser_map() -> (LogOddsMap, ScanInserter) {
    let rules = ScanRules::new(LASER_RANGE_M, LASER_RESOLUTION_M);
    (empty_map(LASER_RESOLUTION_M), ScanInserter::new(rules))
}

fn sonar_map() -> (LogOddsMap, ConeInserter) {
    let shape =
        ConeShape { half_angle_rad: 15_f64.to_radians(), range_max_m: 4.0, tolerance_m: 0.05 };
    // Weaker with distance and towards the edge.
    let weight = |r_m: f64, alpha_rad: f64| (1.0 - r_m / 5.0) * (1.0 - alpha_rad);
    let cones = ConeInserter::new(
        shape,
        SONAR_RESOLUTION_M,
        |r_m, alpha_rad| -0.4 * weight(r_m, alpha_rad),
        |r_m, alpha_rad| 0.9 * weight(r_m, alpha_rad),
    );
    (empty_map(SONAR_RESOLUTION_M), cones.expect("a valid shape"))
}

fn empty_map(resolution_m: f64) -> LogOddsMap {
    let lattice = Lattice::new(Vec2::zeros(), resolution_m).expect("a valid lattice");
    LogOddsMap::new(lattice, EvidenceModel::default()).expect("a valid model")
}

/// Puts all scans in; how many cells changed.
fn insert_scans(map: &mut LogOddsMap, inserter: &mut ScanInserter) -> usize {
    let Scene { fan, poses, scans, .. } = &*SCENE;
    let mut n_cells = 0;
    for (pose, ranges) in poses.iter().zip(scans) {
        let report = inserter.insert(map, fan, *black_box(pose), black_box(ranges));
        n_cells += report.n_free_cells + report.n_hits;
    }
    n_cells
}

fn insert_rings(map: &mut LogOddsMap, cones: &ConeInserter) -> usize {
    let Scene { poses, rings, .. } = &*SCENE;
    let mut n_cells = 0;
    for (pose, ranges) in poses.iter().zip(rings) {
        for (degrees, range_m) in RING_DEG.iter().zip(ranges) {
            let sonar = pose.compose(Se2::new(0.0, 0.0, degrees.to_radians()));
            n_cells += cones.insert_echo(map, black_box(sonar), *range_m, 1.0);
        }
    }
    n_cells
}

fn for_each_beam(mut beam: impl FnMut(Vec2, Vec2)) {
    let Scene { fan, poses, scans, .. } = &*SCENE;
    for (pose, ranges) in poses.iter().zip(scans) {
        for (direction, range_m) in fan.directions().iter().zip(ranges) {
            if *range_m < LASER_RANGE_M {
                beam(pose.position(), pose.transform_point(direction * *range_m));
            }
        }
    }
}

/// What one writes first.
struct Plain {
    resolution_m: f64,
    width: usize,
    cells: Vec<f32>,
    n_cells: usize,
}

impl Plain {
    fn new(resolution_m: f64) -> Self {
        let width = (200.0 / resolution_m) as usize;
        Self { resolution_m, width, cells: vec![0.0; width * width], n_cells: 0 }
    }

    fn insert_scans(&mut self) {
        self.n_cells = 0;
        for_each_beam(|from, to| {
            let cell = |point: Vec2| [point.x, point.y].map(|x| (x / self.resolution_m) as i32);
            self.line(cell(from), cell(to));
        });
    }

    /// Bresenham's line.
    fn line(&mut self, from: [i32; 2], to: [i32; 2]) {
        let (dx, dy) = ((to[0] - from[0]).abs(), -(to[1] - from[1]).abs());
        let (step_x, step_y) = ((to[0] - from[0]).signum(), (to[1] - from[1]).signum());
        let (mut x, mut y, mut error) = (from[0], from[1], dx + dy);
        while [x, y] != to {
            self.add(x, y, -0.4);
            let twice = 2 * error;
            if twice >= dy {
                error += dy;
                x += step_x;
            }
            if twice <= dx {
                error += dx;
                y += step_y;
            }
        }
        self.add(x, y, 0.85);
    }

    fn add(&mut self, x: i32, y: i32, logodds: f32) {
        let cell = &mut self.cells[y as usize * self.width + x as usize];
        *cell = (*cell + logodds).clamp(-4.0, 4.0);
        self.n_cells += 1;
    }
}

fn cast(scene: &RayScene) -> usize {
    let rays = scene.rays.iter();
    let hit = |&&(from, direction): &&(Vec2, Vec2)| {
        scene.map.cast_ray(black_box(from), direction, LASER_RANGE_M).is_some()
    };
    rays.filter(hit).count()
}

/// The same question, one cell after the other.
fn walk(scene: &RayScene) -> usize {
    let RayScene { occupied, lattice, rays, .. } = scene;
    let hit = |&&(from, direction): &&(Vec2, Vec2)| {
        let to = from + direction * LASER_RANGE_M;
        let mut cells = RayWalk::new(lattice, black_box(from), to);
        cells.any(|cell| occupied.get(cell) == Some(true))
    };
    rays.iter().filter(hit).count()
}

/// Numbers without a pattern, the same in each run.
struct Dice(u64);

impl Dice {
    /// From 0 to below 1. Source: Steele, Lea and Flood (2014), `SplitMix64`.
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Rooms of 6 m × 5 m on both sides of corridors of 2.4 m, doors of 1 m, a table in each room.
fn rooms_200_m() -> Vec<Segment> {
    let mut dice = Dice(1);
    let mut walls = Vec::new();
    let wall = |walls: &mut Vec<Segment>, a: [f64; 2], b: [f64; 2]| {
        walls.push(Segment { a: Vec2::from(a), b: Vec2::from(b) });
    };
    let n_strips = (198.0 / 12.4) as i32;
    for strip in 0..n_strips {
        let y = 1.0 + 12.4 * f64::from(strip);
        wall(&mut walls, [1.0, y], [199.0, y]);
        for (side, far) in [(5.0, y), (7.4, y + 12.4)] {
            for room in 0..33 {
                let x = 1.0 + 6.0 * f64::from(room);
                let door = x + 0.5 + 4.0 * dice.roll();
                wall(&mut walls, [x, y + side], [door, y + side]);
                wall(&mut walls, [door + 1.0, y + side], [x + 6.0, y + side]);
                wall(&mut walls, [x, y + side], [x, far]);
                let table = [x + 1.0 + 3.0 * dice.roll(), (y + side + far) / 2.0 - 0.4];
                let corners = [[0.0, 0.0], [1.6, 0.0], [1.6, 0.8], [0.0, 0.8]]
                    .map(|c| [table[0] + c[0], table[1] + c[1]]);
                for i in 0..4 {
                    wall(&mut walls, corners[i], corners[(i + 1) % 4]);
                }
            }
        }
    }
    wall(&mut walls, [1.0, 1.0], [1.0, 199.0]);
    wall(&mut walls, [199.0, 1.0], [199.0, 199.0]);
    walls
}

/// A hall with 400 pillars.
fn hall_200_m() -> Vec<Segment> {
    let mut dice = Dice(2);
    let corners = [[1.0, 1.0], [199.0, 1.0], [199.0, 199.0], [1.0, 199.0]].map(Vec2::from);
    let mut walls: Vec<Segment> =
        (0..4).map(|i| Segment { a: corners[i], b: corners[(i + 1) % 4] }).collect();
    for _ in 0..400 {
        let at = Vec2::new(2.0 + 196.0 * dice.roll(), 2.0 + 196.0 * dice.roll());
        let half = Vec2::new(0.3, 0.3);
        walls.push(Segment { a: at - half, b: at + half });
        let half = Vec2::new(0.3, -0.3);
        walls.push(Segment { a: at - half, b: at + half });
    }
    walls
}

/// Poses in rooms and corridors of the building, with ranges and 1 cm of jitter for the laser, and
/// ranges from 1 m to 3 m for the sonars.
fn scene() -> Scene {
    // Twice as large as the rooms for rays: a mean range of 5 m.
    let walls = rooms_200_m().into_iter().map(|wall| Segment { a: wall.a * 2.0, b: wall.b * 2.0 });
    let world = SegmentWorld::new(walls.map(|wall| (wall, 0)));
    let mut dice = Dice(3);
    let fan = BeamFan::uniform(-PI / 2.0, PI / (N_BEAMS - 1) as f64, N_BEAMS);
    let fan = fan.expect("half a turn");
    let range_m = |pose: Se2, direction: Vec2| {
        let ray = Ray { origin: pose.position(), direction: pose.rotate(direction) };
        world.cast(&ray, LASER_RANGE_M).map_or(f64::INFINITY, |hit| hit.distance_m)
    };
    let mut scene = Scene { fan, poses: Vec::new(), scans: Vec::new(), rings: Vec::new() };
    while scene.poses.len() < N_POSES {
        // All within 20 m of each other: where a robot is, it stays for a while.
        let at = Vec2::new(90.0 + 20.0 * dice.roll(), 90.0 + 20.0 * dice.roll());
        let pose = Se2::new(at.x, at.y, TAU * dice.roll() - PI);
        if world.nearest_distance(at, 0.3).is_some() {
            continue;
        }
        let mut jitter = || 0.02 * (dice.roll() - 0.5);
        let ranges = scene.fan.directions().iter();
        let ranges = ranges.map(|beam| range_m(pose, *beam) + jitter()).collect();
        let ring = RING_DEG.map(|_| 1.0 + 2.0 * dice.roll());
        scene.poses.push(pose);
        scene.scans.push(ranges);
        scene.rings.push(ring);
    }
    scene
}

/// As many rays from one place as `n_together`, all round; each place is anywhere.
fn ray_scene(walls: Vec<Segment>, n_together: usize) -> RayScene {
    let lattice = Lattice::new(Vec2::zeros(), LASER_RESOLUTION_M).expect("a valid lattice");
    let area = CellBox { min: Cell::new(0, 0), width: RAY_MAP_CELLS, height: RAY_MAP_CELLS };
    let mut states = Window::filled(area, State::Free).expect("16 million cells");
    for wall in walls {
        for cell in RayWalk::new(&lattice, wall.a, wall.b) {
            if let Some(state) = states.get_mut(cell) {
                *state = State::Occupied;
            }
        }
    }
    let mut dice = Dice(4);
    let mut rays = Vec::new();
    while rays.len() < N_RAYS {
        let from = Vec2::new(2.0 + 196.0 * dice.roll(), 2.0 + 196.0 * dice.roll());
        let first_rad = TAU * dice.roll();
        if states.get(lattice.cell_of(from)) == Some(State::Free) {
            rays.extend((0..n_together).map(|i| {
                let (s, c) = (first_rad + TAU * i as f64 / n_together as f64).sin_cos();
                (from, Vec2::new(c, s))
            }));
        }
    }
    rays.truncate(N_RAYS);
    let map = RayMap::of_states(lattice, &states);
    let occupied = states.map(|state| state == State::Occupied);
    RayScene { map, occupied, lattice, rays }
}
