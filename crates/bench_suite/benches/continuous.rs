//! Continuous localisation with sonars: a ring into the map, a short-term map onto the long-term one, a
//! whole run.
//!
//! The limits are 20 µs for a ring of eight cones at 35 mm and 1 ms for a registration with 63
//! candidates: `cargo bench -p cairn_bench_suite --bench continuous`.

#![expect(clippy::expect_used, reason = "a benchmark that cannot be set up has nothing to measure")]

use std::hint::black_box;

use continuous_localisation::{
    LocaliserConfig, Score, SearchLevel,
    classic::{ClassicConfig, ClassicLog, LISTING_RING},
    insertion::{PlacedReading, RingInserter},
    run,
    search::{Evidence, search},
};
use divan::Bencher;
use geometry::{Ray, RayCaster, Se2, Segment, SegmentWorld, Vec2};
use grid_maps::{EvidenceModel, Lattice, LogOddsMap};
use recordings::{Recording, Rig, RingRig, Scan};
use run_context::Stamp;
use sensor_models::ConeModel;

fn main() {
    divan::main();
}

fn ring() -> Vec<Se2> {
    let mount = |s: &continuous_localisation::classic::ClassicSonar| {
        Se2::new(s.x_mm * 1e-3, s.y_mm * 1e-3, s.azimuth_deg.to_radians())
    };
    LISTING_RING.iter().map(mount).collect()
}

/// A room of 5 × 4 m with a cupboard.
fn room() -> SegmentWorld {
    let corners = [(0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0), (0.0, 0.0)];
    let cupboard = [(2.0, 4.0), (2.0, 3.4), (3.2, 3.4), (3.2, 4.0)];
    let lines = corners.windows(2).chain(cupboard.windows(2));
    let point = |(x, y): (f64, f64)| Vec2::new(x, y);
    SegmentWorld::new(lines.map(|p| (Segment { a: point(p[0]), b: point(p[1]) }, 0)))
}

/// Way along the walls and round: pose at so many metres.
fn pose_at(way_m: f64) -> Se2 {
    let (half, radius) = (1.2, 1.0);
    let turn_m = std::f64::consts::PI * radius;
    let lap = way_m % (4.0 * half + 2.0 * turn_m);
    let back = Se2::new(2.5, 2.0, std::f64::consts::PI);
    let side = |m: f64| {
        if m < 2.0 * half {
            return Se2::new(m - half, -radius, 0.0);
        }
        let angle = (m - 2.0 * half) / radius;
        Se2::new(half + radius * angle.sin(), -radius * angle.cos(), angle)
    };
    let half_lap = 2.0 * half + turn_m;
    if lap < half_lap {
        Se2::new(2.5, 2.0, 0.0).compose(side(lap))
    } else {
        back.compose(side(lap - half_lap))
    }
}

fn ranges_m(pose: Se2, world: &SegmentWorld) -> Vec<f64> {
    let nearest = |sensor: &Se2| {
        let at = pose.compose(*sensor);
        let rays = (-7..=7).map(|i| {
            let direction = Se2::new(0.0, 0.0, at.yaw_rad + 0.035 * f64::from(i)).heading();
            let hit = world.cast(&Ray { origin: at.position(), direction }, 5.0);
            hit.map_or(5.0, |hit| hit.distance_m)
        });
        rays.fold(5.0, f64::min)
    };
    ring().iter().map(nearest).collect()
}

fn recording(n_rows: u64) -> Recording {
    let world = room();
    let scan = |i: u64| {
        let pose = pose_at(0.05 * i as f64);
        Scan {
            stamp: Stamp::from_millis(250 * i),
            odom_from_base: Some(pose),
            ranges_m: ranges_m(pose, &world),
            stamps: Vec::new(),
        }
    };
    Recording {
        rig: Rig::Ring(RingRig {
            base_from_sensors: ring(),
            half_angle_rad: 15.0_f64.to_radians(),
            range_min_m: 0.15,
            range_max_m: 5.0,
        }),
        scans: (0..n_rows).map(scan).collect(),
        odometry: Vec::new(),
        reference: Vec::new(),
        truth: Vec::new(),
        extra_columns_m: Vec::new(),
        epoch_ns: 0,
    }
}

fn empty_map() -> LogOddsMap {
    let lattice = Lattice { origin: Vec2::zeros(), resolution_m: 0.035 };
    LogOddsMap::new(lattice, EvidenceModel::default()).expect("a valid map")
}

fn placed(way_m: f64, world: &SegmentWorld) -> Vec<PlacedReading> {
    let pose = pose_at(way_m);
    let of = |(sensor, range_m): (Se2, f64)| PlacedReading {
        map_from_sensor: pose.compose(sensor),
        range_m,
        is_echo: true,
        focus: None,
    };
    ring().into_iter().zip(ranges_m(pose, world)).map(of).collect()
}

/// Eight readings of a ring in a room, cones of 15° to each side, cells of 35 mm.
#[divan::bench]
fn ring_of_eight_into_the_map(bencher: Bencher<'_, '_>) {
    let world = room();
    let rows: Vec<Vec<PlacedReading>> =
        (0..200).map(|i| placed(0.05 * f64::from(i), &world)).collect();
    let inserter = RingInserter::new(ConeModel::default(), 0.035).expect("a valid cone");
    let mut map = empty_map();
    let mut turn = 0;
    bencher.bench_local(|| {
        turn = (turn + 1) % rows.len();
        for reading in &rows[turn] {
            inserter.insert(&mut map, black_box(reading));
        }
    });
}

/// A short-term map of a metre (20 rows of eight) laid on the map of a whole lap at 63 poses.
#[divan::bench]
fn registration_of_63_candidates(bencher: Bencher<'_, '_>) {
    let world = room();
    let inserter = RingInserter::new(ConeModel::default(), 0.035).expect("a valid cone");
    let (mut long, mut short) = (empty_map(), empty_map());
    for i in 0..200 {
        for reading in placed(0.05 * f64::from(i), &world) {
            inserter.insert(&mut long, &reading);
            if i >= 180 {
                inserter.insert(&mut short, &reading);
            }
        }
    }
    let pivot = pose_at(10.0).position();
    let levels = [SearchLevel::source(3)];
    let score = Score::Evidence { n_cells_min: 60 };
    bencher.bench_local(|| {
        let evidence = Evidence::of(black_box(&short), pivot);
        search(&long, &evidence, pivot, &levels, score).expect("a small map").best
    });
}

/// A lap and a half, 240 rows, everything included.
#[divan::bench(sample_count = 20)]
fn run_of_240_rows(bencher: Bencher<'_, '_>) {
    let recording = recording(240);
    bencher.bench_local(|| run(black_box(&recording), LocaliserConfig::default()).expect("a ring"));
}

/// The same rows through the source's program, without and with its search.
#[divan::bench(sample_count = 5, args = ["listing", "thesis"])]
fn source_run_of_240_rows(bencher: Bencher<'_, '_>, what: &str) {
    let (log, ring) = ClassicLog::from_recording(&recording(240)).expect("a ring with odometry");
    let config = match what {
        "listing" => ClassicConfig { ring, ..ClassicConfig::listing(35.0, 600) },
        _ => ClassicConfig { ring, ..ClassicConfig::thesis() },
    };
    bencher.bench_local(|| {
        continuous_localisation::classic::run(black_box(&log), &config).expect("a small map")
    });
}
