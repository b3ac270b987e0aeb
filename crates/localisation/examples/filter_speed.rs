//! How many beams of how many particles a second: `cargo run --release -p cairn_localisation --example filter_speed`.
#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "an example that prints, times and fails loudly"
)]

use std::{sync::Arc, time::Instant};

use geometry::{Se2, Vec2};
use grid_maps::{Cell, CellBox, SolidCells, Window};
use localisation::{FieldModel, FilterConfig, LikelihoodField, ParticleFilter};
use run_context::RunSeed;

const SIDE: i32 = 1000;

fn main() {
    // Rooms of 5 m: 50 m a side at 5 cm.
    let area = CellBox { min: Cell::new(0, 0), width: SIDE as usize, height: SIDE as usize };
    let mut cells = Window::filled(area, false).unwrap();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let wall = (column % 100 < 2 && row % 100 > 30) || (row % 100 < 2 && column % 100 > 30);
            *cells.get_mut(Cell::new(column, row)).unwrap() = wall;
        }
    }
    let solid = SolidCells::new(&cells, |solid| solid, true);
    let field = LikelihoodField::new(&solid, 0.05, Se2::IDENTITY, FieldModel::default()).unwrap();
    let field = Arc::new(field);
    let ends: Vec<Vec2> = (0..60)
        .map(|k| {
            let bearing = f64::from(k) * std::f64::consts::TAU / 60.0;
            Vec2::new(bearing.cos(), bearing.sin()) * (2.0 + f64::from(k % 7) * 0.3)
        })
        .collect();
    for n in [1000, 10_000, 100_000] {
        let config = FilterConfig { n_min: n, n_max: n, ..FilterConfig::default() };
        let rng = RunSeed(1).stream("filter");
        let start = Se2::new(12.5, 12.5, 0.3);
        let mut filter =
            ParticleFilter::at(config, Arc::clone(&field), rng, start, [0.3, 0.2]).unwrap();
        let n_rounds = 3_000_000 / (60 * n) + 3;
        let mut times_s = Vec::new();
        for _ in 0..n_rounds {
            filter.predict(Se2::new(0.01, 0.0, 0.001));
            let begun = Instant::now();
            filter.correct(&ends);
            times_s.push(begun.elapsed().as_secs_f64());
        }
        times_s.sort_by(f64::total_cmp);
        let median_s = times_s[times_s.len() / 2];
        let per_s = (60 * n) as f64 / median_s;
        println!(
            "{n:>7} particles x 60 beams: {:.2} ms a correction, {:.0} M particle-beams/s",
            1e3 * median_s,
            per_s / 1e6
        );
    }
}
