//! `cairn reproduce`: the published experiments, repeated.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::bail;
use clap::ValueEnum;
use experiments::{ALL, Options, Report, Sweep};
use files::{Batch, Kind, Outputs};
use indicatif::ProgressStyle;
use run_context::RunSeed;

use crate::output::{self, say};
use crate::parse;

/// Repeats a published experiment and writes a report with figures
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn reproduce\n  cairn reproduce assistant-7.4\n  \
    cairn reproduce assistant-7.5 --runs 500 --output results\n  \
    cairn reproduce assistant-7.4 --speeds 0.2,0.3,0.4 --sets 3,5 --runs 5 --output sweep")]
pub(crate) struct Args {
    /// Which experiment; left out, the list of them
    experiment: Option<String>,
    /// Runs per setting; the experiment's own number unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    runs: Option<u32>,
    /// Seed of the first run; the others follow
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::seed)]
    seed: u64,
    /// Speeds to sweep instead of the published ones, m/s (7.4, 7.5)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    speeds: Vec<f64>,
    /// Control periods to sweep, ms (7.4)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    periods: Vec<u32>,
    /// Perception radii to sweep, m (7.4)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    sigmas: Vec<f64>,
    /// Numbers of fuzzy sets to sweep, 3 or 5 (7.4)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    sets: Vec<u32>,
    /// Accelerations of the wheels to sweep, m/s² (7.4)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    accelerations: Vec<f64>,
    /// Threads; one per core unless given. The results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Where the report, its figures (SVG) and tables (CSV) go: a folder, made if there is none; named for the
    /// experiment unless given
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replaces a report that is in the folder already
    #[arg(long)]
    force: bool,
    /// The kind of report
    #[arg(long, value_enum, default_value_t)]
    report: ReportKind,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ReportKind {
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
    let outputs = Outputs::new(args.force);
    outputs.check_folder(&folder, &[("report.html", Kind::HTML), ("report.md", Kind::MARKDOWN)])?;
    refuse_results(&folder, &outputs)?;
    let options = Options {
        n_runs: args.runs.unwrap_or(0),
        seed: RunSeed(args.seed),
        n_threads: args.threads,
        sweep: Sweep {
            speeds_mps: args.speeds.clone(),
            periods_ms: args.periods.clone(),
            sigmas_m: args.sigmas.clone(),
            n_sets: args.sets.clone(),
            accelerations_mps2: args.accelerations.clone(),
        },
    };
    let bar = output::bar(0);
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
    let path = write(&report, args.report, &folder, &outputs)?;
    print_tables(&report);
    say!("Report: {}", path.display());
    Ok(ExitCode::SUCCESS)
}

/// Figures and tables of an earlier report are seen before the work; which ones there will be, only after it.
fn refuse_results(folder: &Path, outputs: &Outputs) -> anyhow::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let path = entry.path();
        let is_table = entry.file_name().to_string_lossy().starts_with("table-");
        let kind = match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Kind::SVG,
            Some("csv") if is_table => Kind::CSV,
            _ => continue,
        };
        outputs.check(&path, kind)?;
    }
    Ok(())
}

fn write(
    report: &Report,
    kind: ReportKind,
    folder: &Path,
    outputs: &Outputs,
) -> anyhow::Result<PathBuf> {
    let mut batch = Batch::new(folder, outputs)?;
    for figure in report.figures() {
        batch.put(&format!("{}.svg", figure.name), Kind::SVG, figure.svg.as_bytes())?;
    }
    for (index, table) in report.tables().enumerate() {
        batch.put(&format!("table-{}.csv", index + 1), Kind::CSV, table.to_csv().as_bytes())?;
    }
    let name = match kind {
        ReportKind::Html => {
            batch.put("report.html", Kind::HTML, report.to_html().as_bytes())?;
            "report.html"
        }
        ReportKind::Markdown => {
            batch.put("report.md", Kind::MARKDOWN, report.to_markdown().as_bytes())?;
            "report.md"
        }
    };
    batch.commit()?;
    Ok(folder.join(name))
}

fn print_tables(report: &Report) {
    for table in report.tables() {
        say!("{}", table.caption);
        let rows = std::iter::once(&table.head).chain(&table.rows).cloned();
        output::table(&rows.collect::<Vec<_>>());
        say!();
    }
}
