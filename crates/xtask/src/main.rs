//! Chores of the repository: `cargo xtask ci` and `cargo xtask tidy`.
//!
//! What a reviewer would say twice is a check in [`mod@tidy`]; `cargo test -p xtask` runs them too.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

use std::{
    env,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

mod repository;
mod tidy;

use repository::Repository;

const USAGE: &str = "\
usage: cargo xtask <chore>
  ci     everything the continuous integration does, in its order
  tidy   only the checks of layers, documents, units, licences and coverage
example: cargo xtask tidy";

fn main() -> ExitCode {
    let chores: Vec<String> = env::args().skip(1).collect();
    let chores: Vec<&str> = chores.iter().map(String::as_str).collect();
    match chores[..] {
        ["ci"] => ci(),
        ["tidy"] => tidy(),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn ci() -> ExitCode {
    match Command::new(root().join(".ci/run")).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!(".ci/run cannot be started: {error}");
            ExitCode::from(2)
        }
    }
}

fn tidy() -> ExitCode {
    let repository = match Repository::read(&root()) {
        Ok(repository) => repository,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let mut n_findings = 0;
    for check in tidy::CHECKS {
        let findings = (check.run)(&repository);
        println!("{:<40} {}", check.name, summary(findings.len()));
        for finding in &findings {
            println!("  {finding}");
        }
        n_findings += findings.len();
    }
    if n_findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn summary(n_findings: usize) -> String {
    if n_findings == 0 { "in order".to_owned() } else { format!("{n_findings} to mend") }
}

/// The root of the repository, two folders above this crate.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}
