//! `cairn map`: from a recording to a map, a corrected trajectory and a report.

mod args;
mod clock;
mod inputs;
mod print;
mod show;
mod study;

use std::{
    path::Path,
    process::ExitCode,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::bail;
use files::{Kind, Outputs, Refusal};
use indicatif::{ProgressBar, ProgressStyle};
use surveys::{
    CHECKPOINT, FolderInput, Outcome, SUMMARY, Survey, SurveyConfig, SurveyState, Written,
};

use crate::output::{self, Format, say_raw};
pub(crate) use args::Args;
use clock::clock;
use inputs::Inputs;

/// Scans between two looks at the clock.
const SCANS_PER_LOOK: usize = 8;

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if args.keys {
        say_raw!("{}", SurveyConfig::template());
        return Ok(ExitCode::SUCCESS);
    }
    if args.show {
        let inputs = args.log.as_deref().map(|log| Inputs::read(args, log)).transpose()?;
        let (config, asked) = inputs::config(args)?;
        if let Some(inputs) = &inputs {
            inputs::refuse_unread(&config, &asked, inputs)?;
        }
        return show::main(args, inputs, config);
    }
    let Some(log) = &args.log else { bail!("give the recording that is to be mapped") };
    let (config, asked) = inputs::config(args)?;
    let folder = args.output.clone().unwrap_or_else(|| inputs::default_folder(log));
    let outputs = outputs(args, &folder)?;
    let inputs = Inputs::read(args, log)?;
    inputs::refuse_unread(&config, &asked, &inputs)?;
    if let Some(plan) = &args.sweep {
        return study::main(args, (&inputs, &config), plan, &folder, &outputs);
    }
    let (resumed, config) = if args.resume {
        let (state, config) = surveys::read_checkpoint(&folder, &inputs.recording)?;
        (Some(state), config)
    } else {
        (None, config)
    };
    let begun = Instant::now();
    let place = (folder.as_path(), &outputs);
    let (outcome, written) = run(args, &inputs, &config, place, resumed.as_ref())?;
    surveys::remove_checkpoint(&folder);
    let run_s = begun.elapsed().as_secs_f64();
    match args.format {
        Format::Text => print::text(&inputs, &outcome, &written, &folder, run_s),
        Format::Json => print::json(&written, &folder, run_s),
    }
    Ok(ExitCode::SUCCESS)
}

/// What the command may write. Everything that stands in the way is said before the work.
fn outputs(args: &Args, folder: &Path) -> anyhow::Result<Outputs> {
    let given = [&args.log, &args.log2, &args.prior, &args.truth, &args.relations, &args.config];
    let given = given.into_iter().flatten().chain(&args.sweep).cloned();
    let outputs = Outputs::new(args.force).keeping(given.chain(inputs::prior_picture(args)?));
    let checked = match (&args.sweep, args.resume) {
        (Some(_), _) => study::check(args, folder, &outputs),
        // The checkpoint is what this run goes on from.
        (None, true) => outputs.check_folder(folder, &[(SUMMARY, Kind::JSON)]),
        (None, false) => surveys::check_results(folder, &outputs),
    };
    match checked {
        Ok(()) => Ok(outputs),
        Err(Refusal::Exists { path }) if path.starts_with(folder.join(CHECKPOINT)) => bail!(
            "{} holds the checkpoint of a run that was killed; finish it with --resume, begin anew with --force, or \
             choose another folder with -o",
            folder.display()
        ),
        Err(Refusal::Exists { path }) => bail!(
            "{} holds results already ({} is there); choose another folder with -o, or replace them with --force",
            folder.display(),
            path.file_name().unwrap_or_default().display()
        ),
        Err(other) => Err(other.into()),
    }
}

fn run(
    args: &Args,
    inputs: &Inputs,
    config: &SurveyConfig,
    (folder, outputs): (&Path, &Outputs),
    resumed: Option<&SurveyState>,
) -> anyhow::Result<(Outcome, Written)> {
    let prior = Inputs::prior(args, config)?;
    let mut survey =
        Survey::with_prior(Arc::clone(&inputs.recording), config.clone(), clock(), prior)?;
    let input = FolderInput {
        name: &inputs.name,
        source: &inputs.source,
        recording: &inputs.recording,
        config,
        known: &inputs.known,
        complaints: &inputs.complaints,
    };
    let bar = progress(inputs.recording.scans.len());
    let period = Duration::try_from_secs_f64(args.checkpoint_s).unwrap_or_default();
    let mut saved = Instant::now();
    while survey.progress().n_done < survey.progress().n_scans {
        let n_done = survey.progress().n_done;
        if let Some(state) = resumed.filter(|state| state.n_done == n_done) {
            state.check(&survey.outcome_so_far()?)?;
        }
        survey.step()?;
        if n_done % SCANS_PER_LOOK == 0 {
            bar.set_position(n_done as u64);
            if !period.is_zero() && saved.elapsed() >= period {
                surveys::write_checkpoint(folder, &input, &survey.outcome_so_far()?)?;
                saved = Instant::now();
            }
        }
    }
    bar.set_message("the last loops, and the files");
    bar.tick();
    survey.complete()?;
    let outcome = survey.outcome_so_far()?;
    let written = surveys::write_results(folder, &input, &outcome, outputs)?;
    bar.finish_and_clear();
    Ok((outcome, written))
}

/// A bar on standard error; invisible where that is no terminal.
fn progress(n_scans: usize) -> ProgressBar {
    let bar = output::bar(n_scans as u64);
    let style = "{wide_bar} {pos}/{len} scans, {per_sec}, {eta} left {msg}";
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    bar
}
