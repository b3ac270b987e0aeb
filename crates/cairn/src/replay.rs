//! `cairn replay`: a recording, run again and compared step by step.

use std::{path::PathBuf, process::ExitCode};

use missions::{Divergence, Replay, ReplayReport};
use serde_json::json;
use studio::{Options, Show};

use crate::output::{self, Format, say};
use crate::parse;

/// Runs a recording again: in the studio, or headless with every step compared
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn replay out.mcap\n  cairn replay out.mcap --headless\n\n\
    Headless, exit code 0 means that every step had the recorded state, 1 that one differed."
)]
pub(crate) struct Args {
    /// The recording
    recording: PathBuf,
    /// Compare every step with the recording, without the studio
    #[arg(long)]
    headless: bool,
    /// Changes one key of the recorded mission, to see what another setting would have done
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE", requires = "headless")]
    overrides: Vec<String>,
    /// How a headless replay prints its end
    #[arg(long, value_enum, default_value_t, requires = "headless")]
    format: Format,
    /// Port of the studio on this computer; the first free one from 7878 unless given, 0 for any
    #[arg(long, conflicts_with = "headless")]
    port: Option<u16>,
    /// Seconds simulated per second in the studio, 0.1 to 20
    #[arg(
        long,
        value_name = "RATIO",
        default_value_t = 1.0,
        value_parser = parse::speed,
        allow_negative_numbers = true,
        conflicts_with = "headless"
    )]
    speed: f64,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if args.headless {
        let replay = Replay::open_with(&args.recording, &args.overrides)?;
        return Ok(headless(replay, args.format));
    }
    let options = Options { port: args.port, speed_ratio: args.speed };
    let name = args.recording.display().to_string();
    studio::serve(Show::Replay(args.recording.clone()), options, |address| {
        say!("Replay of {name}");
        say!("The studio is at http://{address} — open it in a browser; Ctrl-C ends it.");
    })?;
    Ok(ExitCode::SUCCESS)
}

fn headless(mut replay: Replay, format: Format) -> ExitCode {
    let bar = crate::run::progress(replay.run().mission());
    while replay.step() {
        bar.set_position(replay.run().steps());
    }
    bar.finish_and_clear();
    let report = replay.report();
    let summary = replay.run().summary();
    match format {
        Format::Text => {
            print_report(&report);
            output::summary(&summary, Format::Text);
        }
        Format::Json => {
            let mut object = output::summary_json(&summary);
            object["steps_compared"] = json!(report.steps);
            object["first_difference"] = json!(report.divergence.map(|d| d.step));
            object["truncation"] = json!(report.truncation);
            say!("{object}");
        }
    }
    if report.is_identical() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn print_report(report: &ReplayReport) {
    if let Some(truncation) = &report.truncation {
        say!("The recording is not whole: {truncation}");
    }
    match report.divergence {
        None => say!("{} steps, each with the recorded state.\n", report.steps),
        Some(Divergence { step, recorded, replayed }) => say!(
            "Step {step} is the first that differs: recorded {recorded:016x}, now {replayed:016x}.\n"
        ),
    }
}
