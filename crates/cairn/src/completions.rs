//! `cairn completions`: what the Tab key offers in a shell.

use std::process::ExitCode;

use clap_complete::Shell;

use crate::output::say_raw;

/// Prints a script that makes a shell complete subcommands, options and their values
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn completions bash > ~/.local/share/bash-completion/completions/cairn\n  \
    cairn completions zsh > ~/.zfunc/_cairn\n  cairn completions fish > ~/.config/fish/completions/cairn.fish"
)]
pub(crate) struct Args {
    /// Which shell
    #[arg(value_enum)]
    shell: Shell,
}

/// `command` is the whole command line.
pub(crate) fn main(args: &Args, mut command: clap::Command) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "cairn", &mut script);
    say_raw!("{}", String::from_utf8_lossy(&script));
    ExitCode::SUCCESS
}
