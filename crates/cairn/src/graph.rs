//! `cairn graph`: a pose graph alone, optimised.

use std::{fmt::Write as _, io::Read as _, path::PathBuf, process::ExitCode, time::Instant};

use anyhow::{Context, bail};
use clap::ValueEnum;
use files::{Kind, Outputs};
use flate2::read::MultiGzDecoder;
use least_squares::{Config, Outcome, Report, Start, Workspace, g2o, optimise};
use serde_json::json;

use crate::given;
use crate::output::{self, Format, complain, say};

/// Bytes that a compressed graph may unpack to.
const BYTES_MAX: u64 = files::Limit::LOG.bytes_max();

/// Optimises a pose graph (g2o text, plain or gzip) and prints what it was and what it is
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn graph intel.g2o\n  cairn graph city10000.g2o.gz -o optimised.g2o\n  \
    cairn graph manhattan.g2o --start odometry --format json\n\n\
    chi2 is the sum of e'We over all edges. Lines with other tags than VERTEX_SE2, EDGE_SE2 and FIX are\n\
    counted and left out. Exit code 0: at a minimum; 1: the poses are the best so far, but no minimum was\n\
    reached; 2: the file cannot be used, or nothing can be computed."
)]
pub(crate) struct Args {
    /// The graph, or `-` for standard input
    file: PathBuf,
    /// Where the optimised graph goes; it is written whole or not at all
    #[arg(short, long, value_name = "OUT.g2o")]
    output: Option<PathBuf>,
    /// Replaces a graph that is there already
    #[arg(long, requires = "output")]
    force: bool,
    /// Where to begin: the poses of the file, those along the edges, those of two linear problems, or the
    /// best of the three
    #[arg(long, value_enum, default_value_t)]
    start: Begin,
    /// Steps at most
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    iterations: u32,
    /// How the result is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Begin {
    #[default]
    Auto,
    File,
    Odometry,
    Chordal,
}

impl Begin {
    fn start(self) -> Start {
        match self {
            Self::Auto => Start::Auto,
            Self::File => Start::Given,
            Self::Odometry => Start::Odometry,
            Self::Chordal => Start::Chordal,
        }
    }
}

/// What was found and what it took.
struct Found {
    n_vertices: usize,
    n_edges: usize,
    report: Report,
    damage: g2o::Damage,
    /// What is wrong with the compressed file, if it is.
    cut: Option<String>,
    read_s: f64,
    optimise_s: f64,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let name = args.file.display();
    let outputs = Outputs::new(args.force).keeping([&args.file]);
    if let Some(path) = &args.output {
        outputs.check(path, Kind::GRAPH)?;
    }
    let begun = Instant::now();
    let bytes = if given::is_stdin(&args.file) {
        given::stdin(BYTES_MAX)?
    } else {
        crate::input::read(&args.file, "the graph")?
    };
    let (text, cut) = unpacked(bytes).with_context(|| format!("cannot read the graph {name}"))?;
    let (mut graph, ids, damage) =
        g2o::read(&text).map_err(|e| crate::input::another(&args.file, &text, "pose graph", e))?;
    drop(text);
    let read_s = begun.elapsed().as_secs_f64();
    let config = Config {
        iterations_max: args.iterations as usize,
        start: args.start.start(),
        ..Config::default()
    };
    let begun = Instant::now();
    let report = optimise(&mut graph, &config, &mut Workspace::new());
    let optimise_s = begun.elapsed().as_secs_f64();
    match report.outcome {
        Outcome::NotFinite => bail!(
            "{name}: the errors of the graph are not finite numbers at the start; try another --start"
        ),
        Outcome::TooLarge => bail!("{name}: the graph is too large for this machine's memory"),
        _ => {}
    }
    if let Some(path) = &args.output {
        outputs.write(path, Kind::GRAPH, g2o::write(&graph, &ids).as_bytes())?;
    }
    let (n_vertices, n_edges) = (graph.poses().len(), graph.edges().len());
    let found = Found { n_vertices, n_edges, report, damage, cut, read_s, optimise_s };
    match args.format {
        Format::Text => print_text(args, &found),
        Format::Json => say!("{}", as_json(args, &found)),
    }
    let reached = matches!(found.report.outcome, Outcome::Converged | Outcome::NothingToMove);
    Ok(if reached { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The bytes as they are, or unpacked as far as that goes, with what is wrong then.
fn unpacked(bytes: Vec<u8>) -> anyhow::Result<(Vec<u8>, Option<String>)> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok((bytes, None));
    }
    let mut text = Vec::new();
    let end = MultiGzDecoder::new(bytes.as_slice()).take(BYTES_MAX).read_to_end(&mut text);
    if text.len() as u64 == BYTES_MAX {
        bail!("it unpacks to more than {BYTES_MAX} bytes");
    }
    match end {
        Ok(_) => Ok((text, None)),
        Err(error) if text.is_empty() => {
            bail!("nothing of this gzip file can be unpacked: {error}")
        }
        Err(error) => {
            let n_lines = text.split(|&byte| byte == b'\n').count() - 1;
            let cut = format!("the gzip file is damaged or cut after line {n_lines} ({error})");
            Ok((text, Some(cut)))
        }
    }
}

fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Converged => "converged",
        Outcome::IterationLimit => "iteration_limit",
        Outcome::Stalled => "stalled",
        Outcome::NothingToMove => "nothing_to_move",
        _ => "failed",
    }
}

fn start_word(start: Start) -> &'static str {
    match start {
        Start::Odometry => "odometry",
        Start::Chordal => "chordal",
        _ => "file",
    }
}

fn print_text(args: &Args, found: &Found) {
    let Found { report, .. } = found;
    let complaints = complaints(found);
    if !complaints.is_empty() {
        complain!("{}", complaints.join("\n"));
    }
    let (n_vertices, n_edges) = (found.n_vertices, found.n_edges);
    say!("{}: {n_vertices} vertices, {n_edges} edges\n", args.file.display());
    let ended = match report.outcome {
        Outcome::Converged => "at a minimum",
        Outcome::IterationLimit => "the limit of iterations came first",
        Outcome::Stalled => "no step leads further down",
        _ => "nothing may move",
    };
    let start = match report.start {
        Start::Odometry => "poses along the edges",
        Start::Chordal => "poses of two linear problems",
        _ => "the poses of the file",
    };
    let row =
        |name: &str, value: String, about: &str| vec![format!("  {name}"), value, about.to_owned()];
    let (read_ms, optimise_ms) = (1e3 * found.read_s, 1e3 * found.optimise_s);
    output::table(&[
        row("chi2 before", figure(report.chi2_before), "at the poses of the file"),
        row("chi2 at the start", figure(report.chi2_at_start), start),
        row("chi2 after", figure(report.chi2_after), ended),
        row("iterations", report.iterations.to_string(), ""),
        row(
            "time",
            format!("{:.1} ms", read_ms + optimise_ms),
            &format!("reading {read_ms:.1} ms, optimising {optimise_ms:.1} ms"),
        ),
    ]);
    if let Some(path) = &args.output {
        say!("\nOptimised graph: {}", path.display());
    }
}

/// Seven digits that count.
fn figure(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e9).contains(&value.abs()) {
        format!("{value:.6e}")
    } else {
        let before = value.abs().max(1.0).log10().floor() as usize;
        format!("{value:.digits$}", digits = 6_usize.saturating_sub(before).max(1))
    }
}

/// What was wrong with the file, a line each.
fn complaints(found: &Found) -> Vec<String> {
    let mut lines: Vec<String> = found.cut.iter().cloned().collect();
    let mut text = String::new();
    let _infallible = write!(text, "{}", found.damage);
    lines.extend(text.lines().map(str::to_owned));
    lines
}

fn as_json(args: &Args, found: &Found) -> serde_json::Value {
    let Found { report, .. } = found;
    json!({
        "file": args.file.display().to_string(),
        "vertices": found.n_vertices,
        "edges": found.n_edges,
        "chi2_before": report.chi2_before,
        "chi2_at_start": report.chi2_at_start,
        "chi2_after": report.chi2_after,
        "iterations": report.iterations,
        "outcome": outcome_word(report.outcome),
        "start": start_word(report.start),
        "anchors": report.n_anchors,
        "time_s": found.read_s + found.optimise_s,
        "read_s": found.read_s,
        "optimise_s": found.optimise_s,
        "skipped_lines": found.damage.n_skipped,
        "complaints": complaints(found),
        "output": args.output.as_ref().map(|path| path.display().to_string()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_the_digits_that_count() {
        assert_eq!(figure(45.004_212_3), "45.00421");
        assert_eq!(figure(0.0), "0.000000");
        assert_eq!(figure(511.986_7), "511.9867");
        assert_eq!(figure(1.25e12), "1.250000e12");
        assert_eq!(figure(2.5e-7), "2.500000e-7");
        assert_eq!(figure(123_456_789.0), "123456789.0");
    }
}
