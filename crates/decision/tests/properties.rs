//! Promises that hold for every program: nothing panics, work is bounded, images round-trip, and
//! the machine agrees with an interpreter that was written apart from it.

#![cfg(test)]

use std::collections::{BTreeMap, BTreeSet};

use decision::{
    Compilation, Family, Machine, Mnemonic, Mode, ResourceId, Role, Step, compile, decode,
};
use proptest::{collection::vec, prelude::*, sample::select};

/// Pieces that programs are made of, right and wrong.
fn fragment() -> impl Strategy<Value = String> {
    const PIECES: &[&str] = &[
        "AND", "OR", "FF", "TIMER", "MOVE", "COUNTER", "STC", "STIC", "EVENT", "OPER", "MUL",
        "EQU", "I0", "I99", "Y1", "YTMR3", "0L", "1L", "RISE", "UP", "OSC", "$1F", "%101", "$",
        "%", "-1", "99999", "'a'", "'", "\"", ";", ",", " ", "\t", "\n", "\r\n", "\r", "\0", "é",
        "\u{1A}", "\u{FEFF}", "NAME", "NAME:", "A-B", "2L",
    ];
    prop_oneof![4 => select(PIECES).prop_map(str::to_owned), 1 => any::<char>().prop_map(String::from)]
}

fn messy_source() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<String>(),
        vec(fragment(), 0..60).prop_map(|pieces| pieces.join(" ")),
        vec(fragment(), 0..60).prop_map(|pieces| pieces.concat()),
        vec(any::<u8>(), 0..200).prop_map(|bytes| String::from_utf8_lossy(&bytes).into_owned()),
    ]
}

/// A resource that may stand in that role.
fn resource(role: Role) -> BoxedStrategy<String> {
    let fits = move |id: &ResourceId| match role {
        // QRUN would stop the machine: the oracle knows no stopping.
        _ if id.family() == Family::Run => false,
        role if role.is_destination() => id.is_writable() && id.address() % 8 < 3,
        _ => id.address() % 8 < 3 || id.family() == Family::Zero || id.family() == Family::One,
    };
    let names: Vec<String> = ResourceId::all().filter(fits).map(|id| id.to_string()).collect();
    select(names).boxed()
}

fn operand(role: Role) -> BoxedStrategy<String> {
    let Some((min, max)) = role.range() else { return resource(role) };
    // Short timers, so that they end within a run.
    let max = if role == Role::Quanta { 5 } else { max };
    (min..=max).prop_map(|value| value.to_string()).boxed()
}

fn function() -> impl Strategy<Value = String> {
    select(Mnemonic::ALL).prop_flat_map(|mnemonic| {
        let operands: Vec<_> = mnemonic.parameters().iter().map(|p| operand(p.role)).collect();
        operands.prop_map(move |operands| format!("{mnemonic} {}", operands.join(",")))
    })
}

/// A program without errors. Lines that happen to be wrong (an oscillator on an edge) are left
/// out, as the compiler leaves them out.
fn program_source() -> impl Strategy<Value = String> {
    vec(function(), 0..25).prop_map(|lines| {
        let wrong: BTreeSet<usize> = {
            let compilation = compile(&lines.join("\n"));
            let errors = compilation.diagnostics.iter();
            errors.filter(|d| d.severity == decision::Severity::Error).map(|d| d.line).collect()
        };
        let kept = (1..).zip(&lines).filter(|(number, _)| !wrong.contains(number));
        kept.map(|(_, line)| line.as_str()).collect::<Vec<_>>().join("\n")
    })
}

fn check_places(source: &str, compilation: &Compilation) {
    for d in &compilation.diagnostics {
        assert!(source.get(d.span.start..d.span.end).is_some(), "{d} has no place");
        assert!(d.line >= 1 && d.column >= 1 && !d.message.is_empty() && !d.message.ends_with('.'));
    }
    for operand in
        compilation.program.iter().flat_map(decision::Program::functions).flat_map(|f| &f.operands)
    {
        assert_eq!(&source[operand.span.start..operand.span.end], operand.text);
        let text = source.strip_prefix('\u{FEFF}').unwrap_or(source);
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let line = text.split('\n').nth(operand.line - 1).expect("the line exists");
        let shown: String = line.chars().skip(operand.column - 1).take(operand.length).collect();
        assert_eq!(shown, operand.text);
    }
}

// The oracle. It reads the text again, keeps each history as a list of booleans, newest first,
// and each number as a number; it knows neither addresses nor bytes of code.

#[derive(Default)]
struct Oracle {
    bytes: BTreeMap<String, Vec<bool>>,
    timer_ms: BTreeMap<String, u32>,
    phase: BTreeMap<String, bool>,
    moves: Vec<(i32, i32, i32)>,
    n_events: usize,
    elapsed_ms: u32,
}

impl Oracle {
    fn new() -> Self {
        let mut oracle = Self::default();
        for name in
            ["S0".to_owned(), "1L".to_owned()].into_iter().chain((0..16).map(|n| format!("NI{n}")))
        {
            oracle.bytes.insert(name, vec![true; 8]);
        }
        // Saturday, 1 January 2000, midnight; no run here lasts an hour.
        for (name, number) in [("DAY", 1), ("MONTH", 1), ("WEEKDAY", 6)] {
            oracle.store(name, number);
        }
        oracle
    }

    fn history(&self, name: &str) -> Vec<bool> {
        self.bytes.get(name).cloned().unwrap_or_else(|| vec![false; 8])
    }

    fn now(&self, name: &str) -> bool {
        self.history(name)[0]
    }

    fn number(&self, name: &str) -> u32 {
        self.history(name).iter().rev().fold(0, |sum, &bit| sum * 2 + u32::from(bit))
    }

    fn push(&mut self, name: &str, value: bool) {
        let mut history = self.history(name);
        history.insert(0, value);
        history.pop();
        self.bytes.insert(name.to_owned(), history);
    }

    fn store(&mut self, name: &str, number: u32) {
        let bits = (0..8).map(|n| number & (1 << n) != 0).collect();
        self.bytes.insert(name.to_owned(), bits);
    }

    fn edge(&self, name: &str, edge: &str) -> bool {
        let history = self.history(name);
        (history[1], history[0])
            == match edge {
                "0" => (false, false),
                "1" => (false, true),
                "2" => (true, false),
                _ => (true, true),
            }
    }

    fn line(&mut self, line: &str) {
        let (function, operands) = line.split_once(' ').expect("a function");
        let op: Vec<&str> = operands.split(',').collect();
        let trues = |oracle: &Self| op[1..].iter().filter(|name| oracle.now(name)).count();
        match function {
            "AND" => self.push(op[0], trues(self) == 4),
            "NAND" => self.push(op[0], trues(self) != 4),
            "OR" => self.push(op[0], trues(self) > 0),
            "NOR" => self.push(op[0], trues(self) == 0),
            "XOR" => self.push(op[0], [1, 3].contains(&trues(self))),
            "FF" => {
                let value = match (self.now(op[1]), self.now(op[2])) {
                    (false, false) => self.now(op[0]),
                    (true, true) => op[3] == "1",
                    (set, _) => set,
                };
                self.push(op[0], value);
            }
            "TIMER" => self.timer(&op),
            "COUNTER" if ["1", "2"].contains(&op[3]) && self.edge(op[2], op[3]) => {
                let step = if self.now(op[1]) { 1 } else { -1 };
                let count = i64::from(self.number(op[0])) + step;
                self.store(op[0], u32::try_from(count.clamp(0, 255)).expect("in range"));
            }
            "DCOMP" => {
                let mask: u32 = op[3].parse().expect("a number");
                let differing = self.number(op[1]) ^ self.number(op[2]);
                self.push(op[0], differing & mask == 0);
            }
            "ACOMP" => self.push(op[0], self.number(op[1]) >= self.number(op[2])),
            "MOVE" if self.edge(op[0], op[4]) => {
                let goal: Vec<i32> =
                    op[1..4].iter().map(|n| n.parse().expect("a number")).collect();
                self.moves.push((goal[0], goal[1], goal[2]));
            }
            "STC" if self.edge(op[2], op[3]) => self.store(op[0], self.number(op[1])),
            "STIC" if self.edge(op[2], op[3]) => {
                self.store(op[0], op[1].parse().expect("a number"));
            }
            "OPER" => {
                let (a, b) = (self.number(op[2]), self.number(op[3]));
                let (high, low) = match op[4] {
                    "0" => ((a + b) / 256, (a + b) % 256),
                    _ if a < b => (128, b - a),
                    _ => (0, a - b),
                };
                self.store(op[0], high);
                self.store(op[1], low);
            }
            "MUL" => {
                let product = self.number(op[2]) * self.number(op[3]);
                self.store(op[0], product / 256);
                self.store(op[1], product % 256);
            }
            "EVENT" if self.edge(op[1], op[2]) => self.n_events += 1,
            _ => {}
        }
    }

    fn timer(&mut self, op: &[&str]) {
        let quantum_ms = match op[0].parse::<u32>().expect("a number") {
            0..8 => 10,
            8..16 => 100,
            16..24 => 1000,
            _ => 60_000,
        };
        let full = quantum_ms * op[4].parse::<u32>().expect("a number");
        let name = format!("YTMR{}", op[0]);
        let holds = self.edge(op[2], op[3]);
        let left = self.timer_ms.entry(name.clone()).or_default();
        let output = if op[1] == "0" {
            if holds {
                *left = full;
            }
            *left > 0
        } else {
            let phase = self.phase.entry(name.clone()).or_default();
            if holds && *left == 0 {
                *left = full;
                *phase = !*phase;
            }
            holds && *phase
        };
        self.push(&name, output);
    }

    fn scan(&mut self, source: &str, inputs: u16, analogs: [u8; 8]) {
        for n in 0..16 {
            let value = inputs >> n & 1 == 1;
            self.push(&format!("I{n}"), value);
            self.push(&format!("NI{n}"), !value);
        }
        for (n, value) in analogs.into_iter().enumerate() {
            self.store(&format!("A{n}"), value.into());
        }
        self.store("SECOND", self.elapsed_ms / 1000 % 60);
        self.store("MINUTE", self.elapsed_ms / 60_000);
        source.lines().for_each(|line| self.line(line));
        let status = self.number("STATUS") % 16;
        (0..16).for_each(|n| self.push(&format!("S{n}"), n == status));
    }

    fn pass_10_ms(&mut self) {
        self.elapsed_ms += 10;
        self.timer_ms.values_mut().for_each(|left| *left = left.saturating_sub(10));
    }
}

proptest! {
    #[test]
    fn nothing_panics_and_everything_has_a_place(source in messy_source()) {
        let compilation = compile(&source);
        check_places(&source, &compilation);
        let lines = compilation.listing().lines().count();
        prop_assert!(lines > compilation.n_lines);
        prop_assert_eq!(compilation.program.is_none(), compilation.n_errors > 0);
        prop_assert!(compilation.diagnostics.len() <= 201);
    }

    #[test]
    fn no_image_hurts_the_machine(
        image in prop_oneof![
            vec(any::<u8>(), 0..300),
            vec(0_u8..0x18, 0..300),
            program_source().prop_flat_map(|source| {
                let image = compile(&source).program.expect("correct").image().to_vec();
                let n = image.len();
                (Just(image), 0..n, any::<u8>()).prop_map(|(mut image, at, byte)| {
                    image[at] = byte;
                    image
                })
            }),
        ],
        inputs in any::<u16>(),
    ) {
        if let Ok(program) = decode(&image) {
            prop_assert_eq!(decode(program.image()), Ok(program.clone()));
            prop_assert!(image.starts_with(program.image()));
        }
        for mode in [Mode::Corrected, Mode::Listing] {
            let mut machine = Machine::from_image(&image, mode);
            machine.set_inputs(inputs);
            for _ in 0..4 {
                let report = machine.scan();
                prop_assert!(report.n_instructions <= 4096 && report.end != Step::Executed);
                prop_assert_eq!(report.end == Step::Faulted, machine.fault().is_some());
                machine.tick_10ms();
            }
        }
    }

    #[test]
    fn images_round_trip(source in program_source()) {
        let program = compile(&source).program.expect("correct");
        let decoded = decode(program.image()).expect("an image");
        let meaning = |p: &decision::Program| -> Vec<_> {
            let kinds = |f: &decision::Function| f.operands.iter().map(|o| o.kind).collect::<Vec<_>>();
            p.functions().iter().map(|f| (f.mnemonic, f.address, kinds(f))).collect()
        };
        prop_assert_eq!(meaning(&decoded), meaning(&program));
        // What the decoder wrote is a program, and the same one; its places are right.
        let again = compile(decoded.source());
        check_places(decoded.source(), &again);
        prop_assert_eq!(again.program, Some(decoded));
    }

    #[test]
    fn the_machine_agrees_with_the_oracle(
        source in program_source(),
        field in vec((any::<u16>(), any::<[u8; 8]>(), 0_u8..4), 1..40),
    ) {
        let program = compile(&source).program.expect("correct");
        let mut machine = Machine::new(program, Mode::Corrected);
        let mut oracle = Oracle::new();
        for (inputs, analogs, n_ticks) in field {
            machine.set_inputs(inputs);
            for (n, value) in (0_u8..).zip(analogs) {
                machine.set_analog(n, value);
            }
            machine.scan();
            oracle.scan(&source, inputs, analogs);
            for id in ResourceId::all().filter(|id| id.family() != Family::Run) {
                let name = id.to_string();
                prop_assert_eq!(u32::from(machine.resource(id)), oracle.number(&name), "{}", name);
            }
            let mut moves = Vec::new();
            machine.drain_moves(|m| moves.push((m.x_mm.into(), m.y_mm.into(), m.heading_deg.into())));
            prop_assert_eq!(moves, std::mem::take(&mut oracle.moves));
            for n in 0..16 {
                prop_assert_eq!(machine.outputs() >> n & 1 == 1, oracle.now(&format!("O{n}")));
            }
            for _ in 0..n_ticks {
                machine.tick_10ms();
                oracle.pass_10_ms();
            }
        }
        let n_events = machine.events().count() as u64 + machine.n_events_lost();
        prop_assert_eq!(n_events, oracle.n_events as u64);
    }

    #[test]
    fn steps_and_scans_are_the_same(source in program_source(), field in vec(any::<u16>(), 1..20)) {
        for mode in [Mode::Corrected, Mode::Listing] {
            let program = compile(&source).program.expect("correct");
            let mut scanned = Machine::new(program.clone(), mode);
            let mut stepped = Machine::new(program, mode);
            for &inputs in &field {
                for machine in [&mut scanned, &mut stepped] {
                    machine.set_inputs(inputs);
                    machine.tick_10ms();
                }
                let report = scanned.scan();
                while stepped.step_instruction() == Step::Executed {}
                prop_assert!(report.end == Step::EndOfScan);
                let hashes = [&scanned, &stepped].map(|machine| {
                    let mut hash = run_context::StateHash::new();
                    machine.absorb_state(&mut hash);
                    hash
                });
                prop_assert_eq!(hashes[0], hashes[1]);
            }
        }
    }
}

#[test]
fn garbage_is_compiled_in_bounded_work() {
    let source = "QQQQ ZZZZ,RRRR\n".repeat(50_000);
    let compilation = compile(&source);
    assert_eq!((compilation.diagnostics.len(), compilation.n_errors), (201, 50_000));
    let last = compilation.diagnostics.last().expect("a last one").to_string();
    assert!(last.contains("49800 further problems"), "{last}");
}
