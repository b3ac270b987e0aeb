//! `cairn map --sweep`: many settings on one recording.

use std::{path::Path, process::ExitCode, sync::Arc};

use files::{Batch, Kind, Outputs, Refusal};
use indicatif::{ProgressBar, ProgressStyle};

use serde_json::json;
use surveys::{
    Setting, Survey, SurveyConfig, SweepOptions, SweepOutcome, SweepPlan, sweep, sweep_report, tune,
};

use super::{args::Args, clock::clock, inputs::Inputs};
use crate::output::{self, Format, number, say};

/// Rows of the table that are printed.
const ROWS_SHOWN: usize = 12;
/// The best settings, to be given to `--config`.
const BEST: &str = "best.toml";

/// The names of what a sweep or a search for the best settings writes.
fn stem(args: &Args) -> &'static str {
    if args.tune { "tune" } else { "sweep" }
}

/// Whether the results of the sweep may be written; its journal may be there, to go on from.
pub(super) fn check(args: &Args, folder: &Path, outputs: &Outputs) -> Result<(), Refusal> {
    let stem = stem(args);
    let (table, page) = (format!("{stem}.csv"), format!("{stem}.html"));
    let names = [(&*table, Kind::CSV), (&page, Kind::HTML), (BEST, Kind::SETTINGS)];
    outputs.check_folder(folder, &names)
}

pub(super) fn main(
    args: &Args,
    (inputs, config): (&Inputs, &SurveyConfig),
    plan_path: &Path,
    folder: &Path,
    outputs: &Outputs,
) -> anyhow::Result<ExitCode> {
    let text = files::read_text(plan_path, "the plan")?;
    let plan = SweepPlan::parse(&plan_path.display().to_string(), &text)?;
    plan.check(config)?;
    files::make_folder(folder)?;
    let name = stem(args);
    let journal = folder.join(format!("{name}.jsonl"));
    if args.force {
        outputs.remove(&journal, Kind::JSON)?;
    }
    let options = SweepOptions {
        journal,
        fingerprint: surveys::sweep_fingerprint(&inputs.recording, config, &plan, &inputs.known),
        n_threads: args.threads,
    };
    let bar = progress(args.tune);
    let evaluate = |setting: &Setting| one(args, inputs, config, setting);
    let tell = |done: usize, total: usize| {
        bar.set_length(total as u64);
        // Threads report out of order; the bar only ever moves on.
        bar.set_position(bar.position().max(done as u64));
    };
    let clock = clock();
    let found = if args.tune {
        let start = |key: &str| config.get_value(key);
        tune(&plan, &start, &options, (&clock, &evaluate, &tell))?
    } else {
        sweep(&plan, &options, &clock, &evaluate, &tell)?
    };
    bar.finish_and_clear();
    let best = config.with(&found.table.rows[found.best].0.overrides())?;
    let page = sweep_report(&inputs.name, &inputs.source, &plan, &found)?;
    let mut batch = Batch::new(folder, outputs)?;
    batch.put(&format!("{name}.csv"), Kind::CSV, found.table.to_csv().as_bytes())?;
    batch.put(&format!("{name}.html"), Kind::HTML, page.to_html().as_bytes())?;
    batch.put(BEST, Kind::SETTINGS, best.to_toml().as_bytes())?;
    batch.commit()?;
    match args.format {
        Format::Text => print_text(inputs, &plan, &found, folder, name),
        Format::Json => print_json(&plan, &found, folder, name),
    }
    Ok(if found.settled { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The figures of a survey under one setting.
fn one(
    args: &Args,
    inputs: &Inputs,
    config: &SurveyConfig,
    setting: &Setting,
) -> Result<Vec<(String, f64)>, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let config = config.with(&setting.overrides()).map_err(|e| said(&e))?;
    let prior = Inputs::prior(args, &config).map_err(|e| said(&e))?;
    let recording = Arc::clone(&inputs.recording);
    let survey = Survey::with_prior(recording, config.clone(), surveys::Clock::stopped(), prior);
    let outcome = survey.and_then(Survey::finish).map_err(|e| said(&e))?;
    let judgement = outcome.judge(&inputs.recording, &inputs.known);
    let figures = outcome.figures(&judgement, config.map()).map_err(|e| said(&e))?;
    Ok(figures.into_iter().map(|figure| (figure.name, figure.value)).collect())
}

fn progress(tunes: bool) -> ProgressBar {
    let bar = crate::output::bar(0);
    let style = if tunes {
        "{wide_bar} {pos} settings, at most {len}; at most {eta} left"
    } else {
        "{wide_bar} {pos}/{len} settings, {eta} left"
    };
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    bar
}

fn print_text(inputs: &Inputs, plan: &SweepPlan, found: &SweepOutcome, folder: &Path, name: &str) {
    let figure = plan.goal().figure();
    let n = found.table.rows.len();
    let failed = found.table.rows.iter().filter(|(_, row)| row.failure.is_some()).count();
    say!(
        "{}: {n} settings, {failed} failed, {} taken from the journal\n",
        inputs.name,
        found.n_resumed
    );
    let order = found.table.order(plan.goal());
    let value = |i: usize| found.table.figure(i, figure).unwrap_or(f64::NAN);
    let mut head: Vec<String> = found.table.keys.iter().map(|key| format!("  {key}")).collect();
    head.extend([figure.to_owned(), "time (s)".to_owned()]);
    let row = |i: &usize| {
        let (setting, row) = &found.table.rows[*i];
        let cells = setting.0.iter().map(|(_, value)| {
            format!("  {}", value.as_str().map_or_else(|| value.to_string(), str::to_owned))
        });
        let mut cells: Vec<String> = cells.collect();
        cells.push(row.failure.clone().unwrap_or_else(|| number(value(*i))));
        cells.push(format!("{:.2}", row.time_s));
        cells
    };
    let rows = std::iter::once(head).chain(order.iter().take(ROWS_SHOWN).map(row));
    output::table(&rows.collect::<Vec<_>>());
    if n > ROWS_SHOWN {
        say!("  … and {} more", n - ROWS_SHOWN);
    }
    if !found.settled {
        say!("\nThe limit of rounds came first; another change may still be better.");
    }
    say!("\nTable: {}", folder.join(format!("{name}.csv")).display());
    say!("Report: {}", folder.join(format!("{name}.html")).display());
    say!("Best settings: {} (give it to --config)", folder.join(BEST).display());
}

fn print_json(plan: &SweepPlan, found: &SweepOutcome, folder: &Path, name: &str) {
    let (setting, row) = &found.table.rows[found.best];
    let values: serde_json::Map<String, serde_json::Value> =
        setting.0.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
    let figures: serde_json::Map<String, serde_json::Value> =
        row.figures.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
    say!(
        "{}",
        json!({
            "settings": found.table.rows.len(),
            "failed": found.table.rows.iter().filter(|(_, row)| row.failure.is_some()).count(),
            "resumed": found.n_resumed,
            "settled": found.settled,
            "goal": plan.goal().figure(),
            "best": {"setting": values, "figures": figures},
            "table": folder.join(format!("{name}.csv")).display().to_string(),
        })
    );
}
