//! The filter against exact Bayes on a grid, and against a robot that drives in a flat.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{f64::consts::TAU, sync::Arc};

use geometry::{Ray, RayCaster as _, Se2, Segment, SegmentWorld, Twist, Vec2, wrap_to_pi};
use grid_maps::{Cell, CellBox, SolidCells, Window};
use localisation::{Estimate, FieldModel, FilterConfig, Health, LikelihoodField, ParticleFilter};
use rand_core::Rng as _;
use run_context::{RandomStream, RunSeed, StateHash};

const CELL_M: f64 = 0.05;

/// Walls of a flat of 8 × 6 m that looks the same from no two places.
fn flat() -> SegmentWorld {
    let lines: &[&[(f64, f64)]] = &[
        &[(0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0), (0.0, 0.0)],
        &[(3.0, 0.0), (3.0, 2.2)],
        &[(3.0, 3.2), (3.0, 6.0)],
        &[(3.0, 3.2), (5.5, 3.2)],
        &[(6.5, 3.2), (8.0, 3.2)],
        &[(0.8, 4.6), (1.5, 4.6), (1.5, 5.2), (0.8, 5.2), (0.8, 4.6)],
        &[(6.6, 0.9), (7.1, 0.9), (7.1, 1.9), (6.6, 1.9), (6.6, 0.9)],
    ];
    let segments = lines.iter().flat_map(|line| line.windows(2)).map(|ends| {
        let [a, b] = [ends[0], ends[1]].map(|(x, y)| Vec2::new(x, y));
        (Segment { a, b }, 0)
    });
    SegmentWorld::new(segments)
}

fn solid(world: &SegmentWorld) -> SolidCells {
    let area = CellBox { min: Cell::new(0, 0), width: 164, height: 124 };
    let mut cells = Window::filled(area, false).unwrap();
    for row in 0..124 {
        for column in 0..164 {
            let middle = map_from_cells()
                .transform_point(CELL_M * Vec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5));
            let near = world.nearest_distance(middle, 0.5 * CELL_M).is_some();
            *cells.get_mut(Cell::new(column, row)).unwrap() = near;
        }
    }
    SolidCells::new(&cells, |solid| solid, true)
}

fn map_from_cells() -> Se2 {
    Se2::new(-0.1, -0.1, 0.0)
}

fn field(world: &SegmentWorld) -> Arc<LikelihoodField> {
    Arc::new(
        LikelihoodField::new(&solid(world), CELL_M, map_from_cells(), FieldModel::default())
            .unwrap(),
    )
}

fn uniform(rng: &mut RandomStream) -> f64 {
    (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Sum of twelve even draws: nearly normal, and nothing of ours.
fn normal(rng: &mut RandomStream) -> f64 {
    (0..12).map(|_| uniform(rng)).sum::<f64>() - 6.0
}

/// Ends (m, base) of `n` beams all around; of those for which `is_short` says so somebody stands in the way.
fn scan(
    world: &SegmentWorld,
    pose: Se2,
    n: usize,
    rng: &mut RandomStream,
    is_short: impl Fn(usize) -> bool,
) -> Vec<Vec2> {
    let beam = |k: usize| {
        let bearing = TAU * k as f64 / n as f64;
        let direction = Se2::new(0.0, 0.0, pose.yaw_rad + bearing).heading();
        let hit = world.cast(&Ray { origin: pose.position(), direction }, 12.0);
        hit.map(|hit| {
            let range_m = if is_short(k) {
                0.4 * hit.distance_m
            } else {
                hit.distance_m + 0.01 * normal(rng)
            };
            range_m * Vec2::new(bearing.cos(), bearing.sin())
        })
    };
    (0..n).filter_map(beam).collect()
}

/// A robot that drives rounds in the flat; its wheels say something else.
struct Drive {
    truth: Se2,
    way_m: f64,
    rng: RandomStream,
}

/// A round through the doors, m.
const ROUND: [(f64, f64); 8] = [
    (1.5, 1.2),
    (1.5, 2.7),
    (4.5, 2.7),
    (6.0, 2.6),
    (6.0, 4.6),
    (6.0, 2.6),
    (4.5, 2.7),
    (1.5, 2.7),
];

impl Drive {
    fn new(seed: u64) -> Self {
        Self { truth: Se2::new(1.5, 1.2, 1.57), way_m: 0.0, rng: RunSeed(seed).stream("drive") }
    }

    /// A tenth of a metre on along the round; what the wheels say of it: slips and a drift of 1° a metre.
    fn step(&mut self) -> Se2 {
        self.way_m += 0.1;
        let lengths: Vec<f64> = (0..ROUND.len())
            .map(|k| {
                let ((x0, y0), (x1, y1)) = (ROUND[k], ROUND[(k + 1) % ROUND.len()]);
                (x1 - x0).hypot(y1 - y0)
            })
            .collect();
        let mut left = self.way_m % lengths.iter().sum::<f64>();
        let mut k = 0;
        while left > lengths[k] {
            left -= lengths[k];
            k += 1;
        }
        let ((x0, y0), (x1, y1)) = (ROUND[k], ROUND[(k + 1) % ROUND.len()]);
        let yaw = (y1 - y0).atan2(x1 - x0);
        let to = Se2::new(x0 + left * yaw.cos(), y0 + left * yaw.sin(), yaw);
        let Twist { dx_m, dy_m, dyaw_rad } = self.truth.inverse().compose(to).log();
        self.truth = to;
        let slip = 1.0 + 0.02 * normal(&mut self.rng);
        let turn = dyaw_rad * (1.0 + 0.02 * normal(&mut self.rng)) + 0.1 * 1.0_f64.to_radians();
        Se2::exp(Twist { dx_m: dx_m * slip, dy_m, dyaw_rad: turn })
    }

    fn drive(
        &mut self,
        filter: &mut ParticleFilter,
        world: &SegmentWorld,
        people: usize,
    ) -> (Estimate, f64, f64, usize) {
        let moved = self.step();
        filter.predict(moved);
        // Somebody walks around and hides some beams on one side.
        let first = (self.way_m * 7.0) as usize % 60;
        let hidden = |k: usize| (k + 60 - first) % 60 < people;
        let ends = scan(world, self.truth, 60, &mut self.rng, hidden);
        let n_left_out = filter.correct(&ends).n_left_out;
        let estimate = filter.estimate();
        let found = estimate.map_from_base.se2();
        let off_m = (found.position() - self.truth.position()).norm();
        (estimate, off_m, wrap_to_pi(found.yaw_rad - self.truth.yaw_rad).abs(), n_left_out)
    }
}

fn config() -> FilterConfig {
    FilterConfig {
        noise: robot_models::OdometryNoise { left_std_ratio: 0.03, right_std_ratio: 0.03 },
        ..FilterConfig::default()
    }
}

/// Every pose of a fine grid weighed by hand: distances to walls from the segments themselves, likelihoods in
/// floating point.
#[test]
fn weights_are_those_of_bayes_rule_on_a_grid() {
    let world = flat();
    let mut rng = RunSeed(5).stream("scan");
    // Six beams only: much stays possible.
    let truth = Se2::new(4.4, 1.3, 0.6);
    let ends = scan(&world, truth, 6, &mut rng, |_| false);
    let cells = solid(&world);
    let middles: Vec<Vec2> = (0..124)
        .flat_map(|row| (0..164).map(move |column| Cell::new(column, row)))
        .filter(|cell| cells.is_solid(*cell))
        .map(|c| {
            map_from_cells().transform_point(
                CELL_M * Vec2::new(f64::from(c.column) + 0.5, f64::from(c.row) + 0.5),
            )
        })
        .collect();
    let likelihood = |pose: Se2| -> f64 {
        ends.iter()
            .map(|end| {
                let at = pose.transform_point(*end);
                let snapped = map_from_cells().inverse().transform_point(at) / CELL_M;
                let centre = map_from_cells().transform_point(
                    CELL_M * Vec2::new(snapped.x.floor() + 0.5, snapped.y.floor() + 0.5),
                );
                if !(0.0..164.0).contains(&snapped.x) || !(0.0..124.0).contains(&snapped.y) {
                    return 0.1;
                }
                let near = middles
                    .iter()
                    .map(|m| (m - centre).norm_squared())
                    .fold(f64::INFINITY, f64::min);
                0.1 + 0.9 * (-0.5 * near / (0.08 * 0.08)).exp()
            })
            .product()
    };
    // The filter's own particles are the grid: what is compared is the weight of each region.
    let settings = FilterConfig { n_max: 4000, n_independent: 100.0, ..config() };
    let mut filter =
        ParticleFilter::anywhere(settings, field(&world), RunSeed(1).stream("filter")).unwrap();
    let poses: Vec<Se2> = filter.particles().map(|(pose, _)| pose).collect();
    let exact: Vec<f64> = poses.iter().map(|pose| likelihood(*pose)).collect();
    let sum: f64 = exact.iter().sum();
    // Weighed, not yet drawn anew: as many particles as before carry the weight.
    let before = filter.particles().count();
    let region =
        |pose: Se2| ((pose.x_m / 2.0) as usize).min(3) + 4 * ((pose.y_m / 2.0) as usize).min(2);
    let mut expected = [0.0; 12];
    poses.iter().zip(&exact).for_each(|(pose, weight)| expected[region(*pose)] += weight / sum);
    filter.correct(&ends);
    let mut found = [0.0; 12];
    filter.particles().for_each(|(pose, weight)| found[region(pose)] += weight);
    let off: f64 = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).sum();
    assert!(off < 0.12, "{off}: {expected:.3?} {found:.3?} ({before})");
    assert!(expected.iter().any(|w| *w > 0.2), "{expected:?}");
}

#[test]
fn a_robot_that_knows_where_it_began_is_followed_also_among_people() {
    let world = flat();
    let field = field(&world);
    for people in [0, 18] {
        for seed in 0..3 {
            let mut drive = Drive::new(seed);
            let rng = RunSeed(seed).stream("filter");
            let start = drive.truth;
            let mut filter =
                ParticleFilter::at(config(), Arc::clone(&field), rng, start, [0.05, 0.02]).unwrap();
            let (mut sum, mut n_sure, mut n_all_left_out) = (0.0, 0, 0);
            for k in 0..300 {
                let (estimate, off_m, off_rad, n_left_out) =
                    drive.drive(&mut filter, &world, people);
                n_all_left_out += n_left_out;
                assert!(
                    off_m < 0.3 && off_rad < 0.15,
                    "{people} {seed} {k}: {off_m} m {off_rad} rad"
                );
                sum += off_m * off_m;
                n_sure += u32::from(estimate.health == Health::Sure);
            }
            let rms_m = (sum / 300.0_f64).sqrt();
            assert!(rms_m < 0.06, "{people} {seed}: {rms_m} m");
            let least = if people > 0 { 150 } else { 250 };
            assert!(n_sure > least, "{people} {seed}: sure in {n_sure} of 300");
            assert!(filter.particles().count() < 3000);
            // Beams that end on people are left out as long as it is sure, and hardly any others.
            let per_scan = n_all_left_out as f64 / 300.0;
            let expected = if people > 0 { 5.0..19.0 } else { 0.0..1.0 };
            assert!(expected.contains(&per_scan), "{people} {seed}: {per_scan}");
        }
    }
}

#[test]
fn a_robot_that_knows_nothing_finds_itself_and_one_that_was_carried_away_too() {
    let world = flat();
    let field = field(&world);
    let (mut n_found, mut n_back, mut n_false) = (0, 0, 0);
    for seed in 0..10 {
        let mut drive = Drive::new(seed);
        let rng = RunSeed(seed).stream("filter");
        let mut filter = ParticleFilter::anywhere(config(), Arc::clone(&field), rng).unwrap();
        assert_ne!(filter.estimate().health, Health::Sure);
        let mut off = f64::INFINITY;
        let mut follow = |filter: &mut ParticleFilter, drive: &mut Drive, n: usize| {
            for _ in 0..n {
                let (estimate, off_m, ..) = drive.drive(filter, &world, 6);
                off = off_m;
                n_false += u32::from(estimate.health == Health::Sure && off_m > 0.5);
            }
            off
        };
        // 5 m of way.
        let off_m = follow(&mut filter, &mut drive, 50);
        println!("{seed}: {off_m:.2} m");
        n_found += u32::from(off_m < 0.3);
        // Carried half a round on.
        drive.way_m += 6.0;
        drive.step();
        n_back += u32::from(follow(&mut filter, &mut drive, 100) < 0.3);
    }
    println!(
        "found {n_found} of 10, back {n_back} of 10, falsely sure in {n_false} of 1500 corrections"
    );
    assert!(n_found >= 9 && n_back >= 9 && n_false <= 3, "{n_found} {n_back} {n_false}");
}

#[test]
fn equal_inputs_give_equal_bits_and_nothing_is_allocated() {
    let world = flat();
    let field = field(&world);
    let run = || {
        let mut drive = Drive::new(3);
        let rng = RunSeed(3).stream("filter");
        let mut filter =
            ParticleFilter::at(config(), Arc::clone(&field), rng, drive.truth, [0.05, 0.02])
                .unwrap();
        let mut n_allocated = 0;
        for k in 0..60 {
            let moved = drive.step();
            let ends = scan(&world, drive.truth, 60, &mut drive.rng, |_| false);
            let work = || {
                filter.predict(moved);
                filter.correct(&ends);
            };
            let count = allocation_counter::measure(work).count_total;
            n_allocated += if k > 0 { count } else { 0 };
        }
        let mut hash = StateHash::new();
        filter.absorb_state(&mut hash);
        (hash.value(), n_allocated)
    };
    let (first, second) = (run(), run());
    assert_eq!(first, second);
    assert_eq!(first.1, 0);
}

#[test]
fn settings_that_do_not_hold_together_are_named() {
    let wrong = FilterConfig { n_min: 5, ..FilterConfig::default() }.checked().unwrap_err();
    assert_eq!(wrong.to_string(), "localisation.n_min = 5: must be from 10 to 1 000 000");
    assert!(FilterConfig { n_max: 20, ..FilterConfig::default() }.checked().is_err());
    assert!(FilterConfig { kld_max_ratio: f64::NAN, ..FilterConfig::default() }.checked().is_err());
}
