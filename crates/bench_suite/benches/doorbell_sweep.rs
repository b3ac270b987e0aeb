//! The doorbell mission with a hundred seeds: box and person elsewhere each time.
//!
//! Prints how many arrived, how many touched anything, and what went wrong. Run with
//! `cargo bench -p cairn_bench_suite --bench doorbell_sweep`.
#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]

use missions::{Mission, Run, Summary};
use rayon::prelude::*;
use run_context::RunSeed;

fn main() {
    let quick = std::env::args().any(|a| a == "--test");
    let n_seeds: u64 = if quick { 1 } else { 100 };
    let Ok(mission) = Mission::load("doorbell", &[]) else { return };
    let run = |seed: u64| -> Option<Summary> {
        let mut run = Run::new(mission.clone(), RunSeed(seed)).ok()?;
        run.run_to_end();
        Some(run.summary())
    };
    let summaries: Vec<Summary> = (1..=n_seeds).into_par_iter().filter_map(run).collect();
    let mut n_passed = 0;
    let mut arrivals_s: Vec<f64> = Vec::new();
    for summary in &summaries {
        let Some(verdict) = &summary.verdict else { continue };
        n_passed += u32::from(verdict.passed);
        arrivals_s.extend(summary.figure("arrival_s"));
        for check in verdict.checks.iter().filter(|c| !c.passed) {
            println!("seed {}: {}: {}", summary.seed, check.name, check.text);
        }
    }
    let touched = summaries.iter().filter(|s| s.figure("contacts") > Some(0.0)).count();
    arrivals_s.sort_by(f64::total_cmp);
    let median_s = arrivals_s.get(arrivals_s.len() / 2).copied().unwrap_or(f64::NAN);
    println!(
        "{n_passed} of {n_seeds} passed, {} arrived, {touched} touched something, median arrival {median_s:.1} s",
        arrivals_s.len()
    );
}
