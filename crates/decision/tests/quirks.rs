//! Every point where the printed listing errs: what it does, and what the corrected machine does.
//! The numbers are those of the list in `docs/guide/rdpl.md`.

#![cfg(test)]

use decision::{Code, DateTime, Failsafe, Machine, Mode, Step, compile, compile_as};

const MODES: [Mode; 2] = [Mode::Listing, Mode::Corrected];

/// The same program in both machines, listing first.
fn machines(source: &str) -> [Machine; 2] {
    let program = compile(source).program.expect("correct");
    MODES.map(|mode| Machine::new(program.clone(), mode))
}

fn byte(machine: &Machine, name: &str) -> u8 {
    machine.resource_by_name(name).expect("a resource")
}

fn scan_with_input(machine: &mut Machine, value: bool) {
    machine.set_input(0, value);
    machine.scan();
}

#[test]
fn quirk_1_a_flip_flop_that_holds_does_not_shift() {
    let rising_scans = machines("FF Y0,I0,I1,0\nCOUNTER M0,UP,Y0,RISE").map(|mut machine| {
        scan_with_input(&mut machine, true);
        for _ in 0..4 {
            scan_with_input(&mut machine, false);
        }
        (byte(&machine, "Y0"), byte(&machine, "M0"))
    });
    assert_eq!(rising_scans, [(0b0000_0001, 5), (0b0001_1111, 1)]);
}

#[test]
fn quirk_2_states_shift_after_every_instruction() {
    // Two functions after the write see S1: the listing shows the edge only to the first.
    let source = "STIC STATUS,1,I0,RISE\nCOUNTER M0,UP,S1,RISE\nCOUNTER M1,UP,S1,RISE";
    let counts = machines(source).map(|mut machine| {
        scan_with_input(&mut machine, true);
        let same_scan = [byte(&machine, "M0"), byte(&machine, "M1")];
        machine.scan();
        (same_scan, [byte(&machine, "M0"), byte(&machine, "M1")])
    });
    assert_eq!(counts, [([1, 0], [1, 0]), ([0, 0], [1, 1])]);
}

#[test]
fn quirk_3_nothing_after_a_move_is_executed() {
    let after = machines("MOVE I0,1,2,3,RISE\nAND O0,I0,1L,1L,1L").map(|mut machine| {
        machine.set_input(0, true);
        let report = machine.scan();
        let mut n_moves = 0;
        machine.drain_moves(|_| n_moves += 1);
        (report.n_instructions, n_moves, byte(&machine, "O0"), machine.outputs())
    });
    // In the listing, 1L is a plain 1, so O0 would follow if it were executed.
    assert_eq!(after, [(2, 1, 0, 0), (4, 1, 1, 1)]);
}

#[test]
fn quirk_4_stc_takes_its_edge_from_the_next_opcode() {
    // Opcode of AND: 0x04, whose low bits are 00. Opcode of COMP: 0x0D, 01. STC asks for 11.
    let copied = |next: &str, field: [bool; 2]| {
        machines(&format!("STC M0,A0,I0,3\n{next}")).map(|mut machine| {
            machine.set_analog(0, 9);
            scan_with_input(&mut machine, field[0]);
            machine.set_resource(decision::ResourceId::by_name("M0").expect("M0"), 0);
            scan_with_input(&mut machine, field[1]);
            byte(&machine, "M0")
        })
    };
    let (and, acomp) = ("AND Y0,I1,I1,I1,I1", "ACOMP Y0,A0,A1");
    assert_eq!(copied(and, [true, true]), [0, 9], "steady 1");
    assert_eq!(copied(and, [false, false]), [9, 0], "steady 0");
    assert_eq!(copied(acomp, [false, true]), [9, 0], "rising");
    assert_eq!(copied(acomp, [true, false]), [0, 0], "falling");
    // Last in the program, it takes the edge from the end of cycle, 0x0F: a steady 1.
    assert_eq!(copied("", [true, true]), [9, 9]);
}

#[test]
fn quirk_5_sums_lose_the_high_byte_and_differences_the_sign() {
    let source = "OPER M0,M1,A0,A1,0\nOPER M2,M3,A0,A1,1\nMUL M4,M5,A0,A1";
    let results = machines(source).map(|mut machine| {
        machine.set_analog(0, 200);
        machine.set_analog(1, 203);
        // The listing's SELOP 1 is the resource at address 1 (quirk 12).
        machine.set_input(1, true);
        machine.scan();
        ["M0", "M1", "M2", "M3", "M4", "M5"].map(|name| byte(&machine, name))
    });
    // 200 + 203 = 0x0193, 200 − 203 = −3, 200 · 203 = 0x9E98.
    assert_eq!(results, [[0x93, 0x93, 0, 3, 0x98, 0x98], [0x01, 0x93, 0x80, 3, 0x9E, 0x98]]);
}

#[test]
fn quirk_6_the_constant_one_looks_like_a_rising_edge() {
    let source = "STIC M0,1,1L,3\nCOUNTER M1,UP,1L,RISE\nTIMER 0,OSC,1L,3,1";
    let results = machines(source).map(|mut machine| {
        (0..3).for_each(|_| {
            machine.scan();
        });
        (byte(&machine, "M0"), byte(&machine, "M1"), byte(&machine, "YTMR0") & 1)
    });
    assert_eq!(results, [(0, 3, 0), (1, 0, 1)]);
}

#[test]
fn quirk_7_unknown_opcodes_hang_or_start_over() {
    let steps = |opcode: u8| {
        MODES.map(|mode| {
            let mut machine = Machine::from_image(&[0x00, opcode, 0x0F], mode);
            let report = machine.scan();
            (report.n_instructions, report.end, machine.fault().map(|fault| fault.code))
        })
    };
    let faulted = (1, Step::Faulted, Some(Code::UnknownOpcode));
    for opcode in [0x01, 0x02, 0x03] {
        assert_eq!(steps(opcode), [(1, Step::Hung, None), faulted]);
    }
    for opcode in [0x14, 0x15, 0xFE, 0xFF] {
        assert_eq!(steps(opcode), [(2, Step::EndOfScan, None), faulted]);
    }
}

#[test]
fn quirk_8_an_edge_of_an_input_lasts_one_scan() {
    let counts = machines("COUNTER M0,UP,I0,RISE").map(|mut machine| {
        scan_with_input(&mut machine, true);
        (0..5).for_each(|_| scan_with_input(&mut machine, true));
        // A pulse between two scans is not seen.
        machine.set_input(0, false);
        scan_with_input(&mut machine, true);
        byte(&machine, "M0")
    });
    assert_eq!(counts, [1, 1]);
}

#[test]
fn quirk_9_ticks_between_two_passes_are_lost() {
    let left = machines("TIMER 0,MONO,I0,RISE,10").map(|mut machine| {
        scan_with_input(&mut machine, true);
        (0..3).for_each(|_| machine.tick_10ms());
        machine.scan();
        machine.timers().next().expect("timer 0").remaining.as_millis()
    });
    assert_eq!(left, [90, 70]);
}

#[test]
fn quirk_10_the_last_line_counts_without_a_newline() {
    assert_eq!(compile("AND O0,I0,I1,I2,I3").program.expect("correct").functions().len(), 1);
}

#[test]
fn quirk_11_a_stopped_program_freezes_the_outputs() {
    let outputs = machines("AND O0,I0,1L,1L,1L\nSTIC QRUN,0,I1,RISE").map(|mut machine| {
        machine.set_failsafe(Failsafe { on: 0b100, hold: 0 });
        scan_with_input(&mut machine, true);
        let running = machine.outputs();
        machine.set_input(1, true);
        machine.scan();
        (running, machine.outputs(), machine.is_running())
    });
    assert_eq!(outputs, [(0b001, 0b001, false), (0b001, 0b100, false)]);
}

#[test]
fn quirk_12_the_selector_of_oper_is_fetched_through_the_table() {
    // Selector 0 is I0 for the listing, selector 1 is I1; a set bit subtracts.
    let results = |i0, i1| {
        machines("OPER M0,M1,A0,A1,0\nOPER M2,M3,A0,A1,1").map(|mut machine| {
            machine.set_analog(0, 5);
            machine.set_analog(1, 3);
            machine.set_input(1, i1);
            scan_with_input(&mut machine, i0);
            [byte(&machine, "M1"), byte(&machine, "M3")]
        })
    };
    assert_eq!(results(false, false), [[8, 8], [8, 2]]);
    assert_eq!(results(true, false), [[2, 8], [8, 2]]);
    assert_eq!(results(false, true), [[8, 2], [8, 2]]);
}

#[test]
fn quirk_13_case_is_folded_up_to_the_first_quote() {
    let source = "stic m0,'a',1l,3";
    let [listing, corrected] = MODES.map(|mode| compile_as(source, mode));
    assert_eq!(corrected.n_errors, 0);
    let found: Vec<_> = listing.diagnostics.iter().map(ToString::to_string).collect();
    let expected = "1:13 R2001 error: nothing is called `1l` in listing mode (after a quote the \
                    listing folds no case: write `1L`)";
    assert_eq!(found, [expected]);
    // In capitals, and with small letters before the quote or in the comment, both read it.
    for mode in MODES {
        assert_eq!(compile_as("stic m0,'a',1L,3 ; small", mode).n_errors, 0);
    }
}

#[test]
fn the_first_quantum_of_the_listing_may_be_short() {
    let source = "TIMER 16,MONO,I0,RISE,2";
    for (late_by, expected) in [(0, [200, 200]), (70, [130, 200]), (99, [101, 200])] {
        let pulses = machines(source).map(|mut machine| {
            (0..late_by).for_each(|_| {
                machine.tick_10ms();
                machine.scan();
            });
            scan_with_input(&mut machine, true);
            let mut n_ticks = 0;
            while byte(&machine, "YTMR16") & 1 != 0 {
                machine.tick_10ms();
                machine.scan();
                n_ticks += 1;
            }
            n_ticks
        });
        assert_eq!(pulses, expected, "{late_by} ticks after a full second");
    }
}

#[test]
fn the_clock_of_the_listing_has_a_30_day_august() {
    let last_moment = DateTime {
        year: 2009,
        month: 8,
        day: 30,
        hour: 23,
        minute: 59,
        second: 59,
        centisecond: 99,
    };
    let dates = machines("").map(|mut machine| {
        assert!(machine.set_clock(last_moment));
        machine.tick_10ms();
        machine.scan();
        machine.clock().to_string()
    });
    assert_eq!(dates, ["2009-09-01 00:00:00.00", "2009-08-31 00:00:00.00"]);
    let [_, mut corrected] = machines("");
    assert!(!corrected.set_clock(DateTime { month: 13, ..last_moment }));
}
