//! `cairn reproduce`: the published experiments, repeated.

use std::{fs, path::PathBuf, process::ExitCode};

use anyhow::{Context, bail};
use clap::ValueEnum;
use experiments::{ALL, Options, Report};
use indicatif::{ProgressBar, ProgressStyle};
use run_context::RunSeed;

use crate::output::{self, say};
use crate::parse;

/// Repeats a published experiment and writes a report with figures
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn reproduce\n  cairn reproduce assistant-7.4\n  \
    cairn reproduce assistant-7.5 --runs 500 --output results")]
pub(crate) struct Args {
    /// Which experiment; left out, the list of them
    experiment: Option<String>,
    /// Runs per setting; the experiment's own number unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    runs: Option<u32>,
    /// Seed of the first run; the others follow
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::seed)]
    seed: u64,
    /// Threads; one per core unless given. The results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Where the report, its figures (SVG) and tables (CSV) go
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// The kind of report
    #[arg(long, value_enum, default_value_t)]
    report: Kind,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// One page with the figures inside
    #[default]
    Html,
    /// A text with the figures beside it
    Markdown,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let Some(name) = &args.experiment else {
        let row = |e: &experiments::Experiment| vec![e.name.to_owned(), e.title.to_owned()];
        output::table(&ALL.iter().map(row).collect::<Vec<_>>());
        return Ok(ExitCode::SUCCESS);
    };
    let Some(experiment) = experiments::by_name(name) else {
        bail!("there is no experiment `{name}`; there are {}", ALL.map(|e| e.name).join(", "));
    };
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(name));
    // Before the long work, not after it.
    fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let options = Options {
        n_runs: args.runs.unwrap_or(0),
        seed: RunSeed(args.seed),
        n_threads: args.threads,
    };
    let bar = ProgressBar::new(0);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} runs, {eta} left")
    {
        bar.set_style(style);
    }
    bar.set_prefix(name.clone());
    let report = experiment.run(&options, &|done, total| {
        bar.set_length(total as u64);
        // Threads report out of order; the bar only ever moves on.
        bar.set_position(bar.position().max(done as u64));
    })?;
    bar.finish_and_clear();
    let path = write(&report, args.report, &folder)?;
    print_tables(&report);
    say!("Report: {}", path.display());
    Ok(ExitCode::SUCCESS)
}

fn write(report: &Report, kind: Kind, folder: &std::path::Path) -> anyhow::Result<PathBuf> {
    let put = |name: String, text: String| {
        let path = folder.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        anyhow::Ok(path)
    };
    for figure in report.figures() {
        put(format!("{}.svg", figure.name), figure.svg.clone())?;
    }
    for (index, table) in report.tables().enumerate() {
        put(format!("table-{}.csv", index + 1), table.to_csv())?;
    }
    match kind {
        Kind::Html => put("report.html".to_owned(), report.to_html()),
        Kind::Markdown => put("report.md".to_owned(), report.to_markdown()),
    }
}

fn print_tables(report: &Report) {
    for table in report.tables() {
        say!("{}", table.caption);
        let rows = std::iter::once(&table.head).chain(&table.rows).cloned();
        output::table(&rows.collect::<Vec<_>>());
        say!();
    }
}
