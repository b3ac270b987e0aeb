//! `cairn replay`: a recording, run again and compared step by step.

use std::{path::PathBuf, process::ExitCode};

use missions::{Divergence, Replay, ReplayReport};
use serde_json::json;
use studio::{Options, Show};

use crate::interrupt::Interrupt;
use crate::output::{self, Format, say};
use crate::parse;

/// Runs a recording again: in the studio, or headless with every step compared
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn replay out.mcap\n  cairn replay out.mcap --headless\n  \
    cairn replay out.mcap --headless --set robots.mind.follow.speed_mps=0.2\n\n\
    Headless, exit code 0 means that every step had the recorded state and the file is whole or ends where its\n\
    program was killed; 1 that a step differed, or that the file is damaged; 2 that nothing can be replayed.\n\
    With --set the run goes on to a verdict of its own, without the order to stand that ended the recorded one: exit code 0 when it is passed, 1 when it is failed."
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
        let bytes = crate::input::read(&args.recording, "the recording")?;
        let replay = Replay::from_bytes(&args.recording, &bytes, &args.overrides)?;
        drop(bytes);
        return Ok(headless(replay, args.format, !args.overrides.is_empty()));
    }
    let options = Options { port: args.port, speed_ratio: args.speed };
    let name = args.recording.display().to_string();
    let interrupt = Interrupt::listen()?;
    let on_ready = |address| {
        say!("Replay of {name}");
        say!("The studio is at http://{address} — open it in a browser; Ctrl-C ends it.");
    };
    let show = Show::Replay(args.recording.clone());
    studio::serve_until(show, options, on_ready, interrupt.wait())?;
    Ok(ExitCode::SUCCESS)
}

fn headless(mut replay: Replay, format: Format, is_changed: bool) -> ExitCode {
    let bar = crate::run::progress(replay.run().mission());
    while replay.step() {
        bar.set_position(replay.run().steps());
    }
    bar.finish_and_clear();
    let report = replay.report();
    let summary = replay.run().summary();
    match format {
        Format::Text => {
            for note in replay.notes() {
                say!("{note}");
            }
            say!("{}\n", if is_changed { changed(&report) } else { compared(&report) });
            output::summary(&summary, Format::Text);
        }
        Format::Json => {
            let mut object = output::summary_json(&summary);
            object["steps_compared"] = json!(report.steps);
            object["steps_recorded"] = json!(report.steps_recorded);
            object["first_difference"] = json!(report.divergence.map(|d| d.step));
            object["identical"] = json!(report.is_identical());
            object["damage"] = json!(report.damage);
            object["other_build"] = json!(report.other_build);
            object["truncation"] = json!(report.truncation);
            object["interventions_repeated"] = json!(report.interventions_repeated);
            object["interventions_refused"] = json!(report.interventions_refused);
            object["interventions_left"] = json!(report.interventions_left);
            object["interventions_not_repeated"] = json!(report.interventions_not_repeated);
            say!("{object}");
        }
    }
    let good = if is_changed {
        summary.verdict.is_some_and(|verdict| verdict.passed)
    } else {
        report.is_identical()
    };
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// How the steps of a replay compare with those of the recording.
fn compared(report: &ReplayReport) -> String {
    let of = match report.steps_recorded {
        Some(recorded) if recorded != report.steps => format!(" of {recorded} that were recorded"),
        _ => String::new(),
    };
    let steps = format!("{} steps{of} were compared", report.steps);
    match (report.divergence, &report.other_build) {
        (None, _) if report.is_identical() && report.steps == 0 => {
            "It ends before its first step: there is nothing to compare.".to_owned()
        }
        (None, _) if report.is_identical() => {
            format!("{} steps, each with the recorded state.", report.steps)
        }
        (None, _) if report.steps == 0 => {
            let n = report.steps_recorded.map_or_else(|| "?".to_owned(), |n| n.to_string());
            format!("None of the {n} steps that were recorded can be compared.")
        }
        (None, _) => format!("{steps}; those are as recorded, but the file is not."),
        (Some(Divergence { step, recorded, replayed }), other) => {
            let why = match other {
                _ if !report.damage.is_empty() => "The file is damaged, see above.",
                Some(_) => {
                    "Another build wrote the recording: that is to be expected, and says nothing against it."
                }
                None => {
                    "The same build on the same machine repeats every step: is it another machine?"
                }
            };
            format!(
                "Step {step} is the first that differs: recorded {recorded:016x}, now {replayed:016x}; {steps}. {why}"
            )
        }
    }
}

/// What would have happened under other settings.
fn changed(report: &ReplayReport) -> String {
    let first = match report.divergence {
        Some(Divergence { step, .. }) => {
            let t_s = step as f64 * 0.01;
            format!("With these settings the run is another one from step {step} ({t_s:.2} s) on.")
        }
        None => "These settings changed nothing in the steps that were recorded.".to_owned(),
    };
    let (repeated, left) = (report.interventions_repeated, report.interventions_left);
    let left_out = report.interventions_not_repeated;
    let n = repeated + left + left_out + report.interventions_refused.len() as u64;
    let of = (n > 0).then(|| format!("Of {n} recorded interventions {repeated} were repeated."));
    let refused = report.interventions_refused.iter().map(|refused| format!("Refused: {refused}"));
    let left = (left > 0).then(|| format!("The run ended before {left} of them."));
    let halt = (left_out > 0)
        .then(|| "Not repeated: the order to stand with which the recorded run ended.".to_owned());
    let lines = std::iter::once(first).chain(of).chain(refused).chain(halt).chain(left);
    lines.collect::<Vec<String>>().join("\n")
}
