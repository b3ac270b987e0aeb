//! Every command of `docs/coverage.tsv` by which a requirement is seen at work: it runs in an empty folder and succeeds.

mod support;

use std::{
    collections::BTreeMap,
    process::Command,
    sync::atomic::{AtomicUsize, Ordering},
};

use support::Place;

const COVERAGE: &str = include_str!("../../../docs/coverage.tsv");

/// The commands, each once, with the requirements that name it.
fn commands() -> BTreeMap<&'static str, Vec<&'static str>> {
    let mut commands: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for line in COVERAGE.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        if let [id, _, _, _, attempt] = columns[..]
            && attempt.starts_with("cairn ")
        {
            commands.entry(attempt).or_default().push(id);
        }
    }
    commands
}

/// Runs a command line as a person's shell would, with the program in its path.
fn tried(line: &str) -> Option<String> {
    let place = Place::new();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_cairn"));
    let folder = program.parent().map(|p| p.display().to_string()).unwrap_or_default();
    let path = std::env::var("PATH").unwrap_or_default();
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(line).current_dir(place.path("")).env("PATH", format!("{folder}:{path}"));
    shell.stdin(std::process::Stdio::null());
    let ended = Place::ended(&mut shell);
    (ended.code != 0).then(|| format!("`{line}` ended with {}: {}", ended.code, ended.err.trim()))
}

#[test]
#[cfg(unix)]
fn every_command_that_shows_a_requirement_succeeds() {
    let commands = commands();
    assert!(commands.len() > 30, "only {} commands: were the columns read?", commands.len());
    let lines: Vec<&str> = commands.keys().copied().collect();
    let next = AtomicUsize::new(0);
    let work = || {
        let mut failed = Vec::new();
        while let Some(&line) = lines.get(next.fetch_add(1, Ordering::Relaxed)) {
            failed.extend(tried(line).map(|problem| format!("{:?}: {problem}", commands[line])));
        }
        failed
    };
    let failed: Vec<String> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_default()).collect()
    });
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
