//! How much faster than real time the closed loop runs: one robot with every byte, and a swarm.
//!
//! Prints the median of several runs. Run with `cargo bench -p cairn_bench_suite --bench closed_loop`.
#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]
#![expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::time::Instant;

use missions::{Mission, Run};
use run_context::RunSeed;

fn main() {
    // Test runners pass arguments that mean nothing here; they only want to know that it starts.
    let quick = std::env::args().any(|a| a == "--test");
    let repeats = if quick { 1 } else { 7 };
    measure("one robot, every byte (doorbell)", "doorbell", &[], repeats, 8000);
    let few: &[String] = if quick { &["robots.count=50".to_owned()] } else { &[] };
    measure("swarm, direct links", "swarm", few, repeats.min(3), if quick { 50 } else { 500 });
}

/// Runs the first `steps` steps of a mission `repeats` times.
fn measure(title: &str, mission: &str, overrides: &[String], repeats: usize, steps: u64) {
    let Ok(mission) = Mission::load(mission, overrides) else { return };
    let mut ratios: Vec<f64> = Vec::new();
    for seed in 1..=repeats as u64 {
        let Ok(mut run) = Run::new(mission.clone(), RunSeed(seed)) else { return };
        let begin = Instant::now();
        (0..steps).for_each(|_| run.step());
        ratios.push(run.now().as_secs_f64() / begin.elapsed().as_secs_f64());
    }
    ratios.sort_by(f64::total_cmp);
    let n_robots = mission.n_robots();
    println!(
        "{title}: {n_robots} robots, {:.0} × real time (median of {repeats}, {:.0} to {:.0})",
        ratios[ratios.len() / 2],
        ratios[0],
        ratios[ratios.len() - 1],
    );
}
