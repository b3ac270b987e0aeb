//! Runs the programs in `tests/programs/`: each says in comments what it expects.
//!
//! `;~ R2001 KITCHEN` at the end of a line expects that problem, at that piece of text, in that
//! line. Any other problem, and any that is missing, fails the file.
//!
//! Lines that begin with `;>` are a script, executed from top to bottom:
//!
//! - `mode listing` starts a machine that has the listing's faults; without it, a corrected one;
//! - `set I0=1 A3=200` sets the field;
//! - `run 15` lets fifteen times 10 ms pass, with a scan after each;
//! - `scan` scans once, without time passing;
//! - `expect Y1=1 M0=255 Y2:$03` compares: `=` a boolean's present value or a number's byte, `:`
//!   any byte; `OUT` is the outputs in the field;
//! - `expect moves 5000,3500,45` compares the goals sent since the last such line, in order.

#![cfg(test)]

use std::{fs, path::Path};

use decision::{Compilation, Machine, Mode, ResourceId, ValueKind, compile};

#[test]
fn every_program_does_what_its_comments_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs");
    let entries = fs::read_dir(folder).expect("the folder of programs");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    assert!(paths.len() >= 10, "only {} programs found", paths.len());
    for path in paths {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let source = fs::read_to_string(&path).expect("readable");
        let compilation = compile(&source);
        check_problems(&name, &source, &compilation);
        run_script(&name, &source, &compilation);
    }
}

fn check_problems(name: &str, source: &str, compilation: &Compilation) {
    let mut expected = Vec::new();
    for (index, line) in source.lines().enumerate() {
        for problem in line.split(";~").skip(1) {
            let (code, text) = problem.trim().split_once(' ').expect("code and text");
            expected.push(format!("{name}:{} {code} {text}", index + 1));
        }
    }
    let shown = |d: &decision::Diagnostic| {
        format!("{name}:{} {} {}", d.line, d.code, &source[d.span.start..d.span.end])
    };
    let mut found: Vec<String> = compilation.diagnostics.iter().map(shown).collect();
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
}

fn run_script(name: &str, source: &str, compilation: &Compilation) {
    let mut mode = Mode::Corrected;
    let mut machine = None;
    for (index, line) in source.lines().enumerate() {
        let Some(command) = line.trim_start().strip_prefix(";>") else { continue };
        let at = format!("{name}:{}", index + 1);
        let mut words = command.split_whitespace();
        let verb = words.next().expect("a command");
        if verb == "mode" {
            mode = Mode::Listing;
            machine = None;
            continue;
        }
        let program = || compilation.program.clone().expect("a script needs a correct program");
        let machine = machine.get_or_insert_with(|| Machine::new(program(), mode));
        match verb {
            "set" => words.for_each(|word| set_field(machine, word)),
            "scan" => assert!(machine.fault().is_none() && machine.scan().n_instructions > 0),
            "run" => {
                let n_ticks: u32 = words.next().and_then(|n| n.parse().ok()).expect("a number");
                for _ in 0..n_ticks {
                    machine.tick_10ms();
                    machine.scan();
                }
            }
            "expect" => words.for_each(|word| check_value(&at, machine, word)),
            _ => panic!("{at}: no such command: {verb}"),
        }
        if command.trim_start().starts_with("expect moves") {
            let expected = command.split_whitespace().skip(2).collect::<Vec<_>>();
            let mut found = Vec::new();
            machine.drain_moves(|m| {
                found.push(format!("{},{},{}", m.x_mm, m.y_mm, m.heading_deg));
            });
            assert_eq!(found, expected, "{at}");
        }
    }
}

fn number(text: &str) -> u16 {
    let hex = text.strip_prefix('$').map(|digits| u16::from_str_radix(digits, 16));
    hex.unwrap_or_else(|| text.parse()).expect("a number")
}

fn set_field(machine: &mut Machine, word: &str) {
    let (name, value) = word.split_once('=').expect("NAME=value");
    let n = name[1..].parse().expect("a number");
    match &name[..1] {
        "I" => machine.set_input(n, value == "1"),
        _ => machine.set_analog(n, u8::try_from(number(value)).expect("a byte")),
    }
}

fn check_value(at: &str, machine: &Machine, word: &str) {
    if let Some(value) = word.strip_prefix("OUT=") {
        return assert_eq!(machine.outputs(), number(value), "{at}: {word}");
    }
    let Some(end) = word.find(['=', ':']) else { return };
    let id = ResourceId::by_name(&word[..end]).expect("a resource");
    let byte = u16::from(machine.resource(id));
    let whole = word[end..].starts_with(':') || id.value_kind() == ValueKind::Number;
    let found = if whole { byte } else { byte & 1 };
    assert_eq!(found, number(&word[end + 1..]), "{at}: {word}, it is {byte:08b}");
}
