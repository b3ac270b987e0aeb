//! What subcommands print: tables for people, one JSON object for machines.

use std::io::{IsTerminal as _, Write as _};

use clap::ValueEnum;
use indicatif::ProgressBar;
use missions::{LogItem, Run, Summary, Verdict};
use serde_json::{Map, Value, json};

/// Prints a line on standard output; see [`write_out`].
macro_rules! say {
    () => { $crate::output::write_out(format_args!("\n")) };
    ($($parts:tt)*) => {
        $crate::output::write_out(format_args!("{}\n", format_args!($($parts)*)))
    };
}

/// Prints on standard output as it is; see [`write_out`].
macro_rules! say_raw {
    ($($parts:tt)*) => { $crate::output::write_out(format_args!($($parts)*)) };
}

/// Prints a line on standard error; see [`write_err`].
macro_rules! complain {
    ($($parts:tt)*) => {
        $crate::output::write_err(format_args!("{}\n", format_args!($($parts)*)))
    };
}

pub(crate) use {complain, say, say_raw};

/// Writes to standard error. When nobody can hear it any more (a closed pipe, a full disk) the work goes on: the exit
/// code still says how it ended.
pub(crate) fn write_err(text: std::fmt::Arguments<'_>) {
    let mut err = std::io::stderr().lock();
    let _nobody_hears = err.write_fmt(text);
}

/// Writes to standard output. A reader that has seen enough (`cairn missions | head -1`) ends the
/// program quietly, as people expect of a pipe; a full disk ends it with a message and code 2.
#[expect(clippy::exit, reason = "what cannot be written must not end in success")]
pub(crate) fn write_out(text: std::fmt::Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    match out.write_fmt(text).and_then(|()| out.flush()) {
        Ok(()) => {}
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(error) => {
            complain!("cairn: the output cannot be written: {error}");
            std::process::exit(2)
        }
    }
}

/// Tells what goes on while a server runs. It goes on when nobody listens any more.
pub(crate) fn note(text: std::fmt::Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    let _nobody_listens = writeln!(out, "{text}").and_then(|()| out.flush());
}

/// Robots whose minds are printed at most.
const N_MINDS_MAX: usize = 5;
/// Parts of a mind.
const N_PARTS: usize = 7;

/// Tells what each part of the first robots' minds says that it is about, on standard error as events are.
pub(crate) fn minds(run: &Run) {
    for (robot, part, sentence) in run.minds().take(N_MINDS_MAX * N_PARTS) {
        complain!("{robot}, {part}: {sentence}");
    }
}

/// The same of all robots, by robot and part.
pub(crate) fn minds_json(run: &Run) -> Value {
    let mut minds = Map::new();
    for (robot, part, sentence) in run.minds() {
        let mind = minds.entry(robot).or_insert_with(|| json!({}));
        mind[part] = sentence.into();
    }
    minds.into()
}

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A table for people.
    #[default]
    Text,
    /// One JSON object on standard output, nothing else.
    Json,
}

/// Prints a table whose columns are as wide as their widest cell; the last column is left ragged.
pub(crate) fn table(rows: &[Vec<String>]) {
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
    };
    let widths: Vec<usize> = (0..n_columns).map(|column| width(column).unwrap_or(0)).collect();
    for row in rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            line.push_str(cell);
            line.extend(std::iter::repeat_n(' ', width + 2 - cell.chars().count()));
        }
        say!("{}", line.trim_end());
    }
}

/// A number with as many decimals as a reader of figures wants.
pub(crate) fn number(value: f64) -> String {
    if value.fract().abs() < 1e-9 && value.abs() < 1e12 {
        format!("{value:.0}")
    } else if value.abs() < 0.1 {
        format!("{value:.4}")
    } else {
        format!("{value:.3}")
    }
}

/// A bar of progress on standard error; invisible where that is no terminal, or one that cannot move its cursor.
pub(crate) fn bar(length: u64) -> ProgressBar {
    if is_dumb() { ProgressBar::hidden() } else { ProgressBar::new(length) }
}

/// Whether standard error takes colours: a terminal that has some, and nobody asked for none (`NO_COLOR`, `TERM=dumb`).
pub(crate) fn colour_on_stderr() -> bool {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    std::io::stderr().is_terminal() && !refused && !is_dumb()
}

/// The same of standard output.
pub(crate) fn colour_on_stdout() -> bool {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    std::io::stdout().is_terminal() && !refused && !is_dumb()
}

fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|value| value == "dumb")
}

/// Prints one event of a run on standard error, as it happens.
pub(crate) fn event(item: &LogItem) {
    complain!("{:9.2} s  {:4}  {}", seconds(item), item.level.name(), item.text);
}

/// The same for machines.
pub(crate) fn event_json(item: &LogItem) -> Value {
    json!({"t_s": seconds(item), "level": item.level.name(), "text": item.text})
}

fn seconds(item: &LogItem) -> f64 {
    item.step as f64 * 0.01
}

/// Prints how a run ended: the verdict with its checks, then the figures.
pub(crate) fn summary(summary: &Summary, format: Format) {
    match format {
        Format::Text => summary_text(summary),
        Format::Json => say!("{}", summary_json(summary)),
    }
}

fn summary_text(summary: &Summary) {
    let Summary { mission, seed, verdict, .. } = summary;
    match verdict {
        Some(Verdict { passed, text, checks }) => {
            let word = if *passed { "passed" } else { "FAILED" };
            say!("{mission} (seed {seed}): {word}: {text}\n");
            let row = |check: &missions::Check| {
                let mark = if check.passed { "ok" } else { "FAILED" };
                vec![format!("  {mark}"), check.name.clone(), check.text.clone()]
            };
            table(&checks.iter().map(row).collect::<Vec<_>>());
        }
        None => say!("{mission} (seed {seed}): stopped before its verdict"),
    }
    say!();
    let row = |figure: &missions::Figure| {
        let value = figure.value.map_or_else(|| "–".to_owned(), number);
        vec![format!("  {}", figure.name), value, figure.about.to_owned()]
    };
    let mut rows: Vec<_> = summary.figures.iter().map(row).collect();
    rows.push(vec![
        "  state_hash".to_owned(),
        summary.state_hash.clone(),
        format!("after {} steps of 10 ms", summary.steps),
    ]);
    table(&rows);
}

/// The summary as one object; figures that do not apply are null.
pub(crate) fn summary_json(summary: &Summary) -> Value {
    let figures: Map<String, Value> =
        summary.figures.iter().map(|f| (f.name.to_owned(), json!(f.value))).collect();
    let check = |c: &missions::Check| json!({"name": c.name, "passed": c.passed, "text": c.text});
    json!({
        "mission": summary.mission,
        "seed": summary.seed,
        "steps": summary.steps,
        "verdict": summary.verdict.as_ref().map(|v| if v.passed { "pass" } else { "fail" }),
        "text": summary.verdict.as_ref().map(|v| v.text.clone()),
        "checks": summary.verdict.as_ref().map(|v| v.checks.iter().map(check).collect::<Vec<_>>()),
        "figures": figures,
        "state_hash": summary.state_hash,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_long_as_they_need_be() {
        assert_eq!(number(3.0), "3");
        assert_eq!(number(-1.5), "-1.500");
        assert_eq!(number(0.012_34), "0.0123");
        assert_eq!(number(0.1), "0.100");
    }
}
