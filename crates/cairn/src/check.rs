//! `cairn check`: whether a mission can be run, and what it holds, without running it.

use std::process::ExitCode;

use missions::Mission;
use run_context::RunSeed;
use serde_json::json;

use crate::given;
use crate::output::{self, Format, say};
use crate::parse;

/// Checks a mission without running it: every key, file and place, and what is odd about it
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn check my-flat.toml\n  cairn check doorbell --format json\n  \
    cairn missions doorbell | cairn check -\n\n\
    Exit code 0: it can be run (there may be warnings); 2: it cannot, and the message says where and why."
)]
pub(crate) struct Args {
    /// A mission file, the name of a shipped mission, or `-` for standard input
    mission: String,
    /// Changes one key of the mission; may be given several times
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    overrides: Vec<String>,
    /// Seed that places the random boxes; the mission's own unless given
    #[arg(long, value_name = "N", value_parser = parse::seed)]
    seed: Option<u64>,
    /// How the result is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let mission = given::mission_without_warnings(&args.mission, &args.overrides)?;
    let seed = args.seed.map_or_else(|| mission.seed(), RunSeed);
    // Everything must find its place, as in a run; robots elsewhere are not called.
    missions::can_start(&mission, seed)?;
    let warnings = mission.warnings();
    match args.format {
        Format::Text => print(&mission, seed, &warnings),
        Format::Json => {
            let robots: Vec<_> = mission.robots().collect();
            say!(
                "{}",
                json!({
                    "mission": mission.name(),
                    "title": mission.title(),
                    "seed": seed.0,
                    "duration_max_s": mission.duration_max().as_secs_f64(),
                    "robots": robots.iter().map(|(name, model)| json!({"name": name, "model": model})).collect::<Vec<_>>(),
                    "devices": mission.file().devices.len(),
                    "events": mission.file().events.len(),
                    "requirements": mission.n_requirements(),
                    "needs_a_real_robot": mission.has_real_robot(),
                    "warnings": warnings,
                })
            );
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn print(mission: &Mission, seed: RunSeed, warnings: &[String]) {
    say!("{}: {}\n", mission.name(), mission.title());
    let file = mission.file();
    let row = |name: &str, value: String| vec![format!("  {name}"), value];
    let mut models: Vec<(&str, usize)> = Vec::new();
    for (_, model) in mission.robots() {
        match models.iter_mut().find(|(known, _)| *known == model) {
            Some((_, n)) => *n += 1,
            None => models.push((model, 1)),
        }
    }
    let robots: Vec<String> = models.iter().map(|(model, n)| format!("{n} {model}")).collect();
    output::table(&[
        row("robots", if robots.is_empty() { "none".to_owned() } else { robots.join(", ") }),
        row("devices", file.devices.len().to_string()),
        row("decision", if file.decision.is_some() { "a program" } else { "none" }.to_owned()),
        row("pheromones", if file.pheromones.is_some() { "a server" } else { "none" }.to_owned()),
        row("events", file.events.len().to_string()),
        row("requirements", mission.n_requirements().to_string()),
        row("at most", format!("{} s", output::number(mission.duration_max().as_secs_f64()))),
        row("seed", seed.0.to_string()),
    ]);
    say!();
    for warning in warnings {
        say!("warning: {warning}");
    }
    let real = if mission.has_real_robot() {
        "; a robot of it is elsewhere and was not called"
    } else {
        ""
    };
    match warnings.len() {
        0 => say!("It can be run{real}."),
        n => say!("It can be run{real}; {n} warning{}.", if n == 1 { "" } else { "s" }),
    }
}
