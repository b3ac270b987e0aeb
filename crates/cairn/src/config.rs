//! `cairn config`: every key of a mission file, with its default and what it means.

use std::process::ExitCode;

use missions::Mission;

use crate::output::say_raw;

/// Prints a mission file with every key, its default and a sentence on it
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  cairn config > reference.toml")]
pub(crate) struct Args {}

#[expect(clippy::unnecessary_wraps, reason = "every subcommand has this shape")]
pub(crate) fn main(_args: &Args) -> anyhow::Result<ExitCode> {
    say_raw!("{}", Mission::template());
    Ok(ExitCode::SUCCESS)
}
