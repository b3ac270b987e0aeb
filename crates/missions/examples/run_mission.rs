//! Runs a mission without a screen: `cargo run --example run_mission -- doorbell 7`.
//!
//! Prints the log, the verdict and the figures.
#![expect(clippy::print_stdout, reason = "an example prints what it found")]

use missions::{Mission, Run};
use run_context::RunSeed;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "doorbell".to_owned());
    let seed = arguments.next().map(|s| s.parse()).transpose()?;
    let overrides: Vec<String> = arguments.collect();
    let mission = Mission::load(&name, &overrides)?;
    let seed = seed.map_or(mission.seed(), RunSeed);
    let mut run = Run::new(mission, seed)?;
    run.run_to_end();
    for item in run.drain_log() {
        println!("{:8.2} s  {:4}  {}", item.step as f64 * 0.01, item.level.name(), item.text);
    }
    let summary = run.summary();
    for check in summary.verdict.iter().flat_map(|v| &v.checks) {
        println!("{} {}: {}", if check.passed { "pass" } else { "FAIL" }, check.name, check.text);
    }
    for figure in &summary.figures {
        if let Some(value) = figure.value {
            println!("{:24} {value:10.3}  {}", figure.name, figure.about);
        }
    }
    println!("state hash {}", summary.state_hash);
    Ok(())
}
