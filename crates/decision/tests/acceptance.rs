//! The acceptance tests AT1 to AT9 of the thesis's decision language, with exact numbers.

#![cfg(test)]

use std::fmt::Write as _;

use decision::{Code, Machine, Mode, MoveCommand, Program, compile, decode};

const DOORBELL: &str = "\
OR   Y1,I1,I2,I3,0L
FF   Y2,I0,Y1,0
TIMER 16,MONO,I0,RISE,15
TIMER 0,MONO,YTMR16,FALL,10
AND  Y3,YTMR0,Y2,1L,1L
MOVE Y3,5000,3500,45,RISE
";

fn program(source: &str) -> Program {
    let compilation = compile(source);
    assert_eq!(compilation.n_errors, 0, "{:?}", compilation.diagnostics);
    compilation.program.expect("no errors")
}

fn machine(source: &str) -> Machine {
    Machine::new(program(source), Mode::Corrected)
}

/// Runs for `n_ticks` of 10 ms with a scan after each; `field` sets the inputs at its ticks.
/// Gives the tick of every goal.
fn run(machine: &mut Machine, n_ticks: u32, field: &[(u32, u8, bool)]) -> Vec<(u32, MoveCommand)> {
    let mut goals = Vec::new();
    for tick in 1..=n_ticks {
        for &(_, input, value) in field.iter().filter(|&&(at, ..)| at == tick) {
            machine.set_input(input, value);
        }
        machine.tick_10ms();
        machine.scan();
        machine.drain_moves(|goal| goals.push((tick, goal)));
    }
    goals
}

/// Ticks at which the doorbell program sends the robot.
fn doorbell(field: &[(u32, u8, bool)]) -> Vec<u32> {
    let goals = run(&mut machine(DOORBELL), 4000, field);
    for (_, goal) in &goals {
        assert_eq!(*goal, MoveCommand { x_mm: 5000, y_mm: 3500, heading_deg: 45, number: 1 });
    }
    goals.into_iter().map(|(tick, _)| tick).collect()
}

#[test]
fn at1_an_unanswered_bell_sends_the_robot_after_15_s() {
    assert_eq!(doorbell(&[(1, 0, true), (51, 0, false)]), [1501]);
    // Even when the bell is never released.
    assert_eq!(doorbell(&[(1, 0, true)]), [1501]);
    // And a second bell starts the fifteen seconds again.
    let twice = [(1, 0, true), (51, 0, false), (1001, 0, true), (1051, 0, false)];
    assert_eq!(doorbell(&twice), [2501]);
    assert_eq!(doorbell(&[]), [0; 0]);
}

#[test]
fn at1_motion_within_the_window_keeps_the_robot_home() {
    for room in 1..=3 {
        // Together with the bell (reset wins, and lasts longer), in the middle, in the last scan.
        for start in [1, 700, 1500] {
            let motion = [(start, room, true), (start + 100, room, false)];
            let field = [&[(1, 0, true), (51, 0, false)], &motion[..]].concat();
            assert_eq!(doorbell(&field), [0; 0], "room {room} at {start}");
        }
        let after = [(1, 0, true), (51, 0, false), (1520, room, true)];
        assert_eq!(doorbell(&after), [1501], "too late to matter");
    }
    // The flip-flop is set by the level of the bell: still pressed after the motion, it wins.
    assert_eq!(doorbell(&[(1, 0, true), (100, 1, true), (200, 1, false)]), [1501]);
}

/// Ticks for which `YTMRn` is 1 after its input rises once.
fn pulse_ticks(timer: u8, k: u8) -> u32 {
    let mut machine = machine(&format!("TIMER {timer},MONO,I0,RISE,{k}"));
    machine.scan();
    machine.set_input(0, true);
    let name = format!("YTMR{timer}");
    let mut n_ticks = 0;
    machine.scan();
    while machine.resource_by_name(&name).expect("a timer") & 1 != 0 {
        machine.tick_10ms();
        machine.scan();
        n_ticks += 1;
    }
    n_ticks
}

#[test]
fn at2_every_group_of_timers_spans_its_printed_range() {
    // Milliseconds for K = 1 and K = 255.
    let table = [(0, 10, 2550), (8, 100, 25_500), (16, 1000, 255_000), (24, 60_000, 15_300_000)];
    for (first, shortest_ms, longest_ms) in table {
        for timer in [first, first + 7] {
            assert_eq!(pulse_ticks(timer, 1) * 10, shortest_ms, "timer {timer}");
            assert_eq!(pulse_ticks(timer, 255) * 10, longest_ms, "timer {timer}");
        }
    }
}

#[test]
fn at2_an_oscillator_has_a_period_of_two_k_quanta() {
    for (timer, k, period_ticks) in [(0, 1, 2), (0, 7, 14), (9, 3, 60), (16, 2, 400)] {
        let mut machine = machine(&format!("TIMER {timer},OSC,I0,3,{k}"));
        machine.set_input(0, true);
        // Two scans make the input a steady 1.
        machine.scan();
        let name = format!("YTMR{timer}");
        for tick in 0..4 * period_ticks {
            machine.scan();
            let expected = u8::from(tick % period_ticks < period_ticks / 2);
            let output = machine.resource_by_name(&name).expect("a timer") & 1;
            assert_eq!(output, expected, "timer {timer}, K {k}, tick {tick}");
            machine.tick_10ms();
        }
    }
}

#[test]
fn at2_triggers_follow_the_table_of_edges() {
    // One scan per column. I0 over time: steady 0, rising, steady 1, falling, steady 0.
    let field = [false, false, true, true, false, false];
    // K is one quantum of 10 ms, which passes between scans.
    for (edge, expected) in [(0, "11000 1"), (1, "00100 0"), (2, "00001 0"), (3, "00010 0")]
        .map(|(e, s)| (e, s.replace(' ', "")))
    {
        let mut machine = machine(&format!("TIMER 0,MONO,I0,{edge},1"));
        let mut outputs = String::new();
        for value in field {
            machine.set_input(0, value);
            machine.scan();
            write!(outputs, "{}", machine.resource_by_name("YTMR0").expect("a timer") & 1)
                .expect("a string");
            machine.tick_10ms();
        }
        assert_eq!(outputs, expected, "edge {edge}");
    }
}

#[test]
fn at2_a_second_trigger_starts_the_pulse_again() {
    let mut machine = machine("TIMER 0,MONO,I0,RISE,10");
    let field = [(1, 0, true), (3, 0, false), (6, 0, true)];
    let mut high = Vec::new();
    for tick in 1..=30 {
        run_one(&mut machine, tick, &field);
        if machine.resource_by_name("YTMR0").expect("a timer") & 1 != 0 {
            high.push(tick);
        }
    }
    assert_eq!(high, (1..16).collect::<Vec<_>>());
}

fn run_one(machine: &mut Machine, tick: u32, field: &[(u32, u8, bool)]) {
    for &(_, input, value) in field.iter().filter(|&&(at, ..)| at == tick) {
        machine.set_input(input, value);
    }
    machine.tick_10ms();
    machine.scan();
}

/// The counter after `n` edges of each kind.
fn count(direction: &str, edge: &str, n: u32) -> u8 {
    let mut machine = machine(&format!("COUNTER M0,{direction},I0,{edge}"));
    machine.set_input(1, true);
    for _ in 0..n {
        machine.set_input(0, true);
        machine.scan();
        machine.set_input(0, false);
        machine.scan();
    }
    machine.resource_by_name("M0").expect("a memory")
}

#[test]
fn at3_a_counter_stops_at_its_ends() {
    for edge in ["RISE", "FALL"] {
        assert_eq!([1, 254, 255, 256, 300].map(|n| count("UP", edge, n)), [1, 254, 255, 255, 255]);
        assert_eq!(count("DOWN", edge, 3), 0);
        assert_eq!(count("I1", edge, 7), 7, "a variable direction");
        assert_eq!(count("NI1", edge, 7), 0, "a variable direction");
    }
}

#[test]
fn at4_the_two_flip_flops_differ() {
    let mut machine = machine("FF Y12,I0,I1,0\nFF Y13,I1,I0,1");
    let mut after = |i0, i1| {
        machine.set_input(0, i0);
        machine.set_input(1, i1);
        machine.scan();
        ["Y12", "Y13"].map(|name| machine.resource_by_name(name).expect("a memory") & 1)
    };
    assert_eq!(after(true, true), [0, 1]);
    assert_eq!(after(true, false), [1, 0]);
    assert_eq!(after(false, true), [0, 1]);
    assert_eq!(after(false, false), [0, 1]);
}

#[test]
fn at5_the_order_of_operands_does_not_matter() {
    let source = "FF Y12,I1,NI1,0\nAND Y1,I0,Y12,1L,1L\nAND Y2,Y12,1L,I0,1L";
    let mut machine = machine(source);
    for (i0, i1) in [(false, false), (true, false), (false, true), (true, true)] {
        machine.set_input(0, i0);
        machine.set_input(1, i1);
        machine.scan();
        let bits = ["Y1", "Y2"].map(|name| machine.resource_by_name(name).expect("a memory") & 1);
        assert_eq!(bits, [u8::from(i0 && i1); 2]);
    }
}

#[test]
fn at6_the_low_nibble_of_status_is_decoded() {
    for status in [0_u8, 7, 15, 0x17, 0xF0, 0xFF] {
        let mut machine = machine(&format!("STIC STATUS,{status},1L,3"));
        machine.scan();
        let set: Vec<u8> = (0..16)
            .filter(|n| machine.resource_by_name(&format!("S{n}")).expect("a state") & 1 != 0)
            .collect();
        assert_eq!(set, [status & 0x0F]);
    }
    // Before anything has been decoded, the state is 0.
    let fresh = Machine::new(Program::default(), Mode::Corrected);
    let set = |n: &u8| fresh.resource_by_name(&format!("S{n}")).expect("a state") & 1 != 0;
    assert_eq!((0..16).filter(set).collect::<Vec<u8>>(), [0]);
}

#[test]
fn at7_comparisons() {
    let mut machine = machine("DCOMP Y0,A0,A1,$F0\nACOMP Y1,A0,A1\nDCOMP Y2,A0,A1,0");
    // OP1, OP2, equal under $F0, at least; under an empty mask all are equal.
    let table = [
        (0x51, 0x5F, 1, 0),
        (0x51, 0x61, 0, 0),
        (0x61, 0x51, 0, 1),
        (0x55, 0x55, 1, 1),
        (0, 0, 1, 1),
        (255, 0, 0, 1),
        (0, 255, 0, 0),
        (127, 128, 0, 0),
    ];
    for (a, b, equal, at_least) in table {
        machine.set_analog(0, a);
        machine.set_analog(1, b);
        machine.scan();
        let bits =
            ["Y0", "Y1", "Y2"].map(|name| machine.resource_by_name(name).expect("a memory") & 1);
        assert_eq!(bits, [equal, at_least, 1], "{a} and {b}");
    }
}

/// A program of so many functions, each writing a resource of its own as long as there are any.
fn long_program(n_functions: usize) -> String {
    (0..n_functions).fold(String::new(), |text, _| text + "STIC M0,1,I0,RISE\n")
}

#[test]
fn at8_capacity() {
    let codes = |source: &str| -> Vec<_> {
        compile(source).diagnostics.iter().map(|d| (d.code, d.line)).collect()
    };
    let full = compile(&long_program(500)).program.expect("correct").estimate();
    assert!((full.scan_ms - 200.0).abs() < 1e-9, "{}", full.scan_ms);
    assert_eq!((full.n_functions, full.bytes, full.warnings.len()), (500, 2502, 0));
    assert_eq!(codes(&long_program(500)), []);
    assert_eq!(codes(&long_program(501)), [(Code::ScanTooLong, 501)]);

    // 454 MOVE of nine bytes and two bytes around them are 4088; eight more fit exactly.
    let moves = "MOVE I0,1,2,3,RISE\n".repeat(454);
    let image_bytes = |source: &str| program(source).image().len();
    let exact = format!("{moves}EVENT 1,I0,RISE\nEVENT 1,I0,RISE\n");
    assert_eq!((image_bytes(&exact), codes(&exact)), (4096, vec![]));
    let over = format!("{moves}EVENT 1,I0,RISE\nMUL M0,M1,A0,A1\n");
    assert_eq!((image_bytes(&over), codes(&over)), (4097, vec![(Code::ImageTooLarge, 456)]));
}

#[test]
fn at9_the_doorbell_is_forty_bytes() {
    let expected = [
        0x00, // read inputs
        0x06, 0x41, 0x01, 0x02, 0x03, 0xD1, // OR Y1,I1,I2,I3,0L
        0x09, 0x42, 0x00, 0x41, 0x00, // FF Y2,I0,Y1,0
        0x0A, 0x10, 0x00, 0x00, 0x01, 0x0F, // TIMER 16,MONO,I0,RISE,15
        0x0A, 0x00, 0x00, 0xB0, 0x02, 0x0A, // TIMER 0,MONO,YTMR16,FALL,10
        0x04, 0x43, 0xA0, 0x42, 0xD2, 0xD2, // AND Y3,YTMR0,Y2,1L,1L
        0x0E, 0x43, 0x13, 0x88, 0x0D, 0xAC, 0x00, 0x2D, 0x01, // MOVE Y3,5000,3500,45,RISE
        0x0F, // end of cycle
    ];
    let program = program(DOORBELL);
    assert_eq!(program.image(), expected);
    assert_eq!(program.image().len(), 40);
    let estimate = program.estimate();
    assert!((estimate.scan_ms - 2.4).abs() < 1e-9);
    assert_eq!(decode(&expected).expect("an image").image(), expected);

    let fixed = program.fixed_size_image(4096).expect("it fits");
    assert_eq!((fixed.len(), &fixed[..40]), (4096, &expected[..]));
    assert_eq!(decode(&fixed), decode(&expected));
    assert_eq!(program.fixed_size_image(39), None);
}

/// What concerns the program as a whole is told first, however many other problems there are.
#[test]
fn what_is_wrong_with_the_whole_is_not_hidden_behind_hundreds_of_lines() {
    let compilation = decision::compile(&"AND O0,I0,1L,1L,1L\n".repeat(800));
    let found: Vec<Code> = compilation.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(found[..2], [Code::ScanTooLong, Code::ImageTooLarge]);
    assert_eq!(found.iter().filter(|&&code| code == Code::LostWrite).count(), 200);
    assert_eq!(found.last(), Some(&Code::TooManyProblems));
}

#[test]
fn a_program_that_does_nothing_is_named_as_such() {
    for text in ["", "\n", "; the lamp\n", "\u{FEFF}"] {
        let compilation = decision::compile(text);
        let found: Vec<Code> = compilation.diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(found, [Code::NoFunctions], "{text:?}");
        assert!(compilation.program.is_some());
    }
    // A mistake that leaves nothing is told as that mistake.
    let wrong = decision::compile("ADN O0,I0\n");
    assert!(wrong.diagnostics.iter().all(|d| d.code != Code::NoFunctions) && wrong.n_errors > 0);
}
