//! The program `cairn`: one file per subcommand, and nothing else that could be called mathematics.
#![expect(
    clippy::disallowed_methods,
    reason = "the command line waits and looks at the clock; the libraries do not"
)]

mod check;
mod completions;
mod config;
mod drive;
mod explain;
mod given;
mod graph;
mod input;
mod interrupt;
mod map;
mod missions;
mod output;
mod parse;
mod pheromone_server;
mod plan;
mod rdpl;
mod replay;
mod reproduce;
mod robot;
mod run;
mod serve;
mod world_map;

use std::process::ExitCode;

use output::{complain, say_raw};

use clap::{
    CommandFactory as _, Parser, Subcommand,
    error::{ContextKind, ContextValue, ErrorKind},
};

/// A navigation system for small mobile robots: simulates them down to the bytes they speak, steers
/// them, and shows it all in a browser.
///
/// Without a subcommand, cairn runs the mission `doorbell` in real time and serves the studio on this
/// computer; open the address that it prints.
#[derive(Debug, Parser)]
#[command(
    name = "cairn",
    version,
    subcommand_required = false,
    after_help = "Examples:\n  cairn\n  cairn run doorbell --headless --seed 7\n  cairn missions"
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Args),
    Check(check::Args),
    Drive(Box<drive::Args>),
    Replay(replay::Args),
    Missions(missions::Args),
    Robot(robot::Args),
    PheromoneServer(pheromone_server::Args),
    Rdpl(rdpl::Args),
    Explain(explain::Args),
    Reproduce(reproduce::Args),
    Config(config::Args),
    Map(Box<map::Args>),
    Graph(graph::Args),
    Plan(plan::Args),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refused(&error),
    };
    let outcome = match cli.command {
        None => run::studio_with_doorbell(),
        Some(Command::Run(args)) => run::main(&args),
        Some(Command::Check(args)) => check::main(&args),
        Some(Command::Drive(args)) => drive::main(&args),
        Some(Command::Replay(args)) => replay::main(&args),
        Some(Command::Missions(args)) => missions::main(&args),
        Some(Command::Robot(args)) => robot::main(&args),
        Some(Command::PheromoneServer(args)) => pheromone_server::main(&args),
        Some(Command::Rdpl(args)) => rdpl::main(&args),
        Some(Command::Explain(args)) => explain::main(&args),
        Some(Command::Reproduce(args)) => reproduce::main(&args),
        Some(Command::Config(args)) => config::main(&args),
        Some(Command::Map(args)) => map::main(&args),
        Some(Command::Graph(args)) => graph::main(&args),
        Some(Command::Plan(args)) => plan::main(&args),
        Some(Command::Completions(args)) => Ok(completions::main(&args, Cli::command())),
    };
    match outcome {
        Ok(code) => code,
        Err(error) => {
            complain!("cairn: {}", said_once(&error));
            ExitCode::from(2)
        }
    }
}

/// Says what is wrong with a command line; who names a mission or a file where a subcommand belongs is told which one takes
/// it.
fn refused(error: &clap::Error) -> ExitCode {
    let word = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(word)) if error.kind() == ErrorKind::InvalidSubcommand => word,
        _ => {
            if error.use_stderr() {
                let _nobody_reads = error.print();
                return ExitCode::from(2);
            }
            // Help and version come this way too.
            let text = error.render();
            let is_coloured = output::colour_on_stdout();
            if is_coloured {
                say_raw!("{}", text.ansi());
            } else {
                say_raw!("{text}");
            }
            return ExitCode::SUCCESS;
        }
    };
    let meant =
        meant_by(word).map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"));
    complain!("cairn: there is no subcommand `{word}`{meant}\n\n`cairn --help` lists them.");
    ExitCode::from(2)
}

/// The command that takes `word`, or the subcommand that it is like.
fn meant_by(word: &str) -> Option<String> {
    let ending = std::path::Path::new(word).extension().and_then(|ending| ending.to_str());
    let takes = match ending {
        Some("toml") => "run",
        Some("mcap" | "part") => "replay",
        Some("rdpl" | "src") => "rdpl",
        Some("g2o") => "graph",
        Some("gz") => "map",
        Some(ending) if is_log(ending) => "map",
        _ => "",
    };
    if !takes.is_empty() {
        return Some(format!("cairn {takes} {word}"));
    }
    let command = Cli::command();
    let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
    // Two letters are too few for likeness: they are meant for what begins and ends with them.
    let ends = |name: &&&str| {
        word.len() == 2
            && name.starts_with(&word[..1])
            && name.ends_with(&word[1..])
            && word.is_ascii()
    };
    let short = names.iter().find(ends).copied();
    let subcommand = || {
        short.or_else(|| settings::did_you_mean(word, names)).map(|name| format!("cairn {name}"))
    };
    let shipped = ::missions::Mission::shipped();
    if shipped.contains(&word) {
        return Some(format!("cairn run {word}"));
    }
    subcommand()
        .or_else(|| settings::did_you_mean(word, shipped).map(|name| format!("cairn run {name}")))
}

/// Whether files of that ending are robots' logs; missions and programs come first.
fn is_log(ending: &str) -> bool {
    let mut endings = recordings::Format::ALL.iter().flat_map(|format| format.endings());
    endings.any(|known| known.strip_prefix('.') == Some(ending))
}

/// An error and its causes on one line, without those that the text before already quotes.
fn said_once(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text.push_str(": ");
            text.push_str(&cause);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_said_once() {
        let whole = anyhow::anyhow!("disk full").context("x.toml: cannot be read: disk full");
        assert_eq!(said_once(&whole), "x.toml: cannot be read: disk full");
        let part = anyhow::anyhow!("disk full").context("cannot write x.lst");
        assert_eq!(said_once(&part), "cannot write x.lst: disk full");
    }

    /// The help of every subcommand says what it does and ends with an example.
    #[test]
    fn every_help_has_an_example() {
        Cli::command().debug_assert();
        for command in Cli::command().get_subcommands() {
            let name = command.get_name();
            let after = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(after.contains(&format!("cairn {name}")), "{name} has no example");
            assert!(command.get_about().is_some(), "{name} does not say what it does");
            for argument in command.get_arguments() {
                assert!(
                    argument.get_help().is_some(),
                    "{name}: {} is unexplained",
                    argument.get_id()
                );
            }
        }
    }
}
