//! The machine beyond the language: run and stop, steps, events, watchdog, allocations.

#![cfg(test)]

use decision::{
    DateTime, Failsafe, Machine, Mode, MovePoints, MoveReport, MoveSignal, MoveState, Program,
    Step, compile,
};
use std::time::Duration;

use run_context::Stamp;

fn program(source: &str) -> Program {
    compile(source).program.expect("correct")
}

fn machine(source: &str) -> Machine {
    Machine::new(program(source), Mode::Corrected)
}

#[test]
fn a_stopped_machine_goes_on_where_it_stood() {
    let mut machine = machine("AND Y0,I0,1L,1L,1L\nAND Y1,I0,1L,1L,1L");
    machine.set_input(0, true);
    assert_eq!((machine.step_instruction(), machine.next_function()), (Step::Executed, Some(0)));
    assert_eq!((machine.step_instruction(), machine.next_function()), (Step::Executed, Some(1)));
    machine.stop();
    assert_eq!(machine.step_instruction(), Step::Stopped);
    assert_eq!(machine.scan().n_instructions, 0);
    let bytes = |machine: &Machine| ["Y0", "Y1"].map(|name| machine.resource_by_name(name));
    assert_eq!(bytes(&machine), [Some(1), Some(0)]);
    machine.run();
    assert_eq!(machine.scan().n_instructions, 2);
    assert_eq!((bytes(&machine), machine.next_function()), ([Some(1), Some(1)], None));
    assert_eq!(machine.n_scans(), 1);
}

#[test]
fn timers_tell_what_they_are_doing() {
    let mut machine = machine("TIMER 9,MONO,I0,RISE,3");
    machine.set_input(0, true);
    machine.scan();
    (0..12).for_each(|_| machine.tick_10ms());
    let timer = machine.timers().nth(9).expect("timer 9");
    assert_eq!(
        (timer.index, timer.remaining.as_millis(), timer.quantum.as_millis()),
        (9, 180, 100)
    );
    assert!(timer.running && timer.output);
    assert_eq!(machine.timers().filter(|timer| timer.running || timer.output).count(), 1);
    assert_eq!(machine.timers().count(), 32);
}

#[test]
fn events_carry_the_time_and_the_cause() {
    let mut machine = machine("EVENT 5,I0,RISE\nEVENT 6,I0,FALL");
    let midday = DateTime { hour: 12, ..DateTime::SWITCHED_ON };
    assert!(machine.set_clock(midday));
    for tick in 0..8 {
        machine.set_input(0, tick % 4 < 2);
        machine.scan();
        machine.tick_10ms();
    }
    let log: Vec<_> =
        machine.events().map(|e| (e.kind, e.at, e.resource.to_string(), e.history)).collect();
    let input = || "I0".to_owned();
    let at = Stamp::from_millis;
    let expected = [
        (5, at(0), input(), 0b1),
        (6, at(20), input(), 0b110),
        (5, at(40), input(), 0b1_1001),
        (6, at(60), input(), 0b110_0110),
    ];
    assert_eq!(log, expected);
    assert_eq!(machine.events().last().expect("four").clock.to_string(), "2000-01-01 12:00:00.06");
    (0..400).for_each(|n| {
        machine.set_input(0, n % 2 == 0);
        machine.scan();
    });
    assert_eq!((machine.events().count(), machine.n_events_lost()), (64, 404 - 64));
}

#[test]
fn goals_that_nobody_takes_are_lost_and_counted() {
    let mut machine = machine("MOVE I0,1,2,3,RISE");
    (0..70).for_each(|n| {
        machine.set_input(0, n % 2 == 0);
        machine.scan();
    });
    let mut n_taken = 0;
    machine.drain_moves(|_| n_taken += 1);
    assert_eq!((n_taken, machine.n_moves_lost()), (32, 3));
}

#[test]
fn the_watchdog_restarts_a_machine_that_nobody_runs() {
    let mut machine = machine("FF O3,I0,0L,0");
    machine.set_input(0, true);
    machine.scan();
    assert_eq!(machine.outputs(), 8);
    (0..199).for_each(|_| machine.tick_10ms());
    assert_eq!((machine.outputs(), machine.n_watchdog_resets()), (8, 0));
    machine.tick_10ms();
    assert_eq!((machine.outputs(), machine.n_watchdog_resets()), (0, 1));
    assert_eq!(machine.now(), Stamp::from_millis(2000), "time goes on");
    machine.scan();
    assert_eq!(machine.outputs(), 8, "the field is read again");
    // A stopped program is not a standing loop.
    machine.stop();
    (0..500).for_each(|_| {
        machine.tick_10ms();
        machine.scan();
    });
    assert_eq!((machine.outputs(), machine.n_watchdog_resets()), (0, 1));
    // Another time, and none at all.
    machine.set_watchdog(Duration::from_millis(50));
    (0..12).for_each(|_| machine.tick_10ms());
    assert_eq!(machine.n_watchdog_resets(), 3);
    machine.set_watchdog(Duration::ZERO);
    (0..100_000).for_each(|_| machine.tick_10ms());
    assert_eq!(machine.n_watchdog_resets(), 3);
}

/// Outputs 0 to 3 of a program that sets all four: off, on, held, held and on.
const FAILSAFE: Failsafe = Failsafe { on: 0b1010, hold: 0b1100 };
const ALL_ON: &str = "AND O0,1L,1L,1L,1L\nAND O1,1L,1L,1L,1L\nAND O2,1L,1L,1L,1L\n\
                      AND O3,1L,1L,1L,1L\n";

#[test]
fn outputs_have_their_fail_safe_values_whenever_the_program_does_not_drive_them() {
    let mut machine = machine(&format!("{ALL_ON}STIC QRUN,0,I0,RISE\nSTIC O2,0,I1,3"));
    let seen = |machine: &Machine| (machine.outputs(), machine.drives_outputs());
    machine.set_failsafe(FAILSAFE);
    assert_eq!(seen(&machine), (0b0010, false), "before the first scan nothing is to be held");
    machine.scan();
    assert_eq!(seen(&machine), (0b1111, true));
    // By the operator: at once, and until a whole scan is over after the restart.
    machine.stop();
    assert_eq!(seen(&machine), (0b1110, false));
    machine.run();
    assert_eq!(seen(&machine), (0b1110, false));
    machine.scan();
    assert_eq!(seen(&machine), (0b1111, true));
    // By the program, in the middle of a scan whose outputs are not written any more.
    machine.set_input(0, true);
    assert_eq!(machine.scan().end, Step::Stopped);
    assert_eq!(seen(&machine), (0b1110, false));
    // By a reset, and by the watchdog.
    machine.reset();
    machine.set_input(0, false);
    assert_eq!(seen(&machine), (0b1110, false));
    machine.scan();
    assert_eq!(seen(&machine), (0b1111, true));
    (0..200).for_each(|_| machine.tick_10ms());
    assert_eq!((seen(&machine), machine.n_watchdog_resets()), ((0b1110, false), 1));
    // Held is what the field had, not what a memory says.
    machine.set_input(1, true);
    machine.scan();
    machine.scan();
    machine.stop();
    assert_eq!(seen(&machine), (0b1010, false));
}

#[test]
fn an_error_and_an_overrun_release_the_outputs() {
    let set_o0 = [0x00, 0x07, 0x20, 0xD1, 0xD1, 0xD1, 0xD1];
    // STIC QRUN,1,I0,RISE or, when the byte is damaged, an unknown opcode.
    for (opcode, code) in [(0xFE, "R8001"), (0x11, "R8006")] {
        let functions = [opcode, 0xD3, 1, 0, 1].repeat(if opcode == 0x11 { 500 } else { 1 });
        let mut image = [&set_o0[..], &functions].concat();
        image.push(0x0F);
        let mut machine = Machine::from_image(&image, Mode::Corrected);
        machine.set_failsafe(Failsafe { on: 0b10, hold: 0 });
        let report = machine.scan();
        let fault = machine.fault().expect("a fault");
        assert_eq!((report.end, fault.code.id()), (Step::Faulted, code));
        assert_eq!((machine.outputs(), machine.drives_outputs()), (0b10, false), "{code}");
        if code == "R8006" {
            // Reading the inputs, 500 functions in 200 ms, and not the 501st.
            assert_eq!((report.n_instructions, fault.address), (501, 7 + 499 * 5 + 1 - 1));
        }
    }
    let five_hundred = compile(&"AND O0,1L,1L,1L,1L\n".repeat(500)).program.expect("no errors");
    let mut machine = Machine::new(five_hundred, Mode::Corrected);
    assert_eq!((machine.scan().end, machine.outputs()), (Step::EndOfScan, 1));
}

/// Inputs 0, 1, 2 (trigger, second trigger, a switch) are the field's; 3 to 5 are points.
const POINTS: MovePoints =
    MovePoints { busy: Some(3), done: Some(4), failed: Some(5), signal: MoveSignal::Level };

fn points(machine: &Machine) -> [u8; 3] {
    ["I3", "I4", "I5"].map(|name| machine.resource_by_name(name).expect("an input") & 3)
}

#[test]
fn a_move_takes_the_answer_to_the_one_before_away_in_its_own_scan() {
    // O0 and O1 look at DONE, before and after the MOVE.
    let source = "AND O0,I4,1L,1L,1L\nMOVE I0,1,2,3,RISE\nAND O1,I4,1L,1L,1L\nAND O2,I3,NI4,NI5,1L";
    let mut machine = machine(source);
    machine.set_move_points(POINTS);
    // The field cannot claim that a MOVE is done.
    machine.set_input(4, true);
    machine.scan();
    assert_eq!((points(&machine), machine.move_state()), ([0; 3], MoveState::Idle));
    machine.set_input(0, true);
    machine.scan();
    assert_eq!((points(&machine), machine.outputs()), ([0b01, 0, 0], 0b100));
    assert!(!machine.report_move(0, MoveReport::Done) && !machine.report_move(2, MoveReport::Done));
    assert!(machine.report_move(1, MoveReport::Done));
    machine.set_input(0, false);
    machine.scan();
    assert_eq!((points(&machine), machine.outputs()), ([0b10, 0b01, 0], 0b011));
    machine.scan();
    assert_eq!(points(&machine), [0, 0b11, 0], "a level stays");
    // The second MOVE: what stands above it has seen DONE, what stands below it has not.
    machine.set_input(0, true);
    machine.scan();
    assert_eq!((points(&machine), machine.outputs()), ([0b01, 0b10, 0], 0b101));
    // A late answer to the first is nobody's.
    assert!(!machine.report_move(1, MoveReport::Failed));
    machine.scan();
    assert_eq!(points(&machine), [0b11, 0, 0]);
    assert!(machine.report_move(2, MoveReport::Failed));
    assert!(!machine.report_move(2, MoveReport::Done), "an answer is final");
    machine.scan();
    assert_eq!((points(&machine), machine.move_state()), ([0b10, 0, 0b01], MoveState::Failed));
}

#[test]
fn somebody_else_who_sends_the_robot_away_ends_done() {
    let mut machine = machine("MOVE I0,1,2,3,RISE");
    machine.set_move_points(POINTS);
    machine.set_input(0, true);
    machine.scan();
    assert!(!machine.report_move(1, MoveReport::Left), "it has not arrived yet");
    assert!(machine.report_move(1, MoveReport::Done));
    machine.scan();
    assert!(machine.report_move(1, MoveReport::Left));
    machine.scan();
    assert_eq!((points(&machine), machine.move_state()), ([0, 0b10, 0], MoveState::Idle));
}

#[test]
fn a_pulse_lasts_one_scan_and_waits_for_it() {
    let mut machine = machine("MOVE I0,1,2,3,RISE\nCOUNTER M0,UP,I4,RISE\nCOUNTER M1,UP,I5,RISE");
    machine.set_move_points(MovePoints { signal: MoveSignal::Pulse, ..POINTS });
    for (report, expected) in [(MoveReport::Done, [0, 0b01, 0]), (MoveReport::Failed, [0, 0, 0b01])]
    {
        machine.set_input(0, true);
        machine.scan();
        let number = machine.n_moves();
        machine.scan();
        // A stopped program misses nothing.
        machine.stop();
        assert!(machine.report_move(number, report));
        machine.scan();
        machine.run();
        machine.set_input(0, false);
        machine.scan();
        assert_eq!(points(&machine), [expected[0] | 0b10, expected[1], expected[2]]);
        machine.scan();
        assert_eq!(points(&machine), [0, expected[1] << 1, expected[2] << 1]);
        machine.scan();
        assert_eq!(points(&machine), [0; 3]);
    }
    assert_eq!(["M0", "M1"].map(|name| machine.resource_by_name(name)), [Some(1), Some(1)]);
}

#[test]
fn two_moves_in_one_scan_leave_the_last_and_a_reset_leaves_none() {
    let mut machine = machine("MOVE I0,1,0,0,RISE\nMOVE I0,2,0,0,RISE");
    machine.set_move_points(POINTS);
    machine.set_input(0, true);
    machine.scan();
    let mut sent = Vec::new();
    machine.drain_moves(|goal| sent.push((goal.number, goal.x_mm)));
    assert_eq!(sent, [(1, 1), (2, 2)]);
    assert!(!machine.report_move(1, MoveReport::Done));
    machine.reset();
    assert_eq!((machine.move_state(), machine.n_moves()), (MoveState::Idle, 2));
    assert!(!machine.report_move(2, MoveReport::Done), "the program does not know of it any more");
    machine.set_input(0, false);
    machine.scan();
    machine.set_input(0, true);
    machine.scan();
    assert_eq!(machine.n_moves(), 4, "numbers are not given twice");
}

#[test]
fn a_program_reads_the_clock() {
    // From seven o'clock on workdays: Saturday and Sunday are 6 and 7.
    let source = "STIC M0,7,1L,3\nSTIC M1,6,1L,3\nACOMP Y0,HOUR,M0\nACOMP Y1,WEEKDAY,M1\n\
                  NOR Y2,Y1,0L,0L,0L\nAND O0,Y0,Y2,1L,1L";
    let mut machine = machine(source);
    let mut at = |text: &str| {
        assert!(machine.set_clock(DateTime::parse(text).expect("a clock")));
        machine.scan();
        let before = machine.outputs();
        machine.tick_10ms();
        machine.scan();
        let bytes = ["HOUR", "MINUTE", "SECOND", "DAY", "MONTH", "WEEKDAY"];
        (before, machine.outputs(), bytes.map(|name| machine.resource_by_name(name).unwrap_or(99)))
    };
    // Friday, 4 December 2009, and the Saturday after it.
    assert_eq!(at("2009-12-04 06:59:59.99"), (0, 1, [7, 0, 0, 4, 12, 5]));
    assert_eq!(at("2009-12-04 23:59:59.99"), (1, 0, [0, 0, 0, 5, 12, 6]));
    assert_eq!(at("2009-12-05 09:30:15.00"), (0, 0, [9, 30, 15, 5, 12, 6]));
    let wrong = compile("STIC HOUR,3,1L,3").diagnostics.first().map(|d| d.code.id());
    assert_eq!(wrong, Some("R2003"));
}

#[test]
fn a_fault_stays_until_the_reset() {
    let mut machine = Machine::from_image(&[0x00, 0x04, 0x20], Mode::Corrected);
    assert_eq!(machine.scan().end, Step::Faulted);
    let fault = machine.fault().expect("a fault");
    assert_eq!((fault.code.id(), fault.address), ("R8002", 1));
    assert_eq!((machine.scan().n_instructions, machine.scan().end), (0, Step::Faulted));
    machine.reset();
    assert_eq!(machine.fault(), None);
}

#[test]
fn neither_ticks_nor_scans_allocate() {
    let line = "TIMER 3,OSC,NI0,3,1\nMOVE YTMR3,1,2,3,RISE\nEVENT 1,YTMR3,FALL\nMUL M0,M1,A0,A1\n";
    for mode in [Mode::Corrected, Mode::Listing] {
        let mut machine = Machine::new(program(&line.repeat(125)), mode);
        let mut n_moves = 0;
        let allocations = allocation_counter::measure(|| {
            for tick in 0..300_u16 {
                machine.set_inputs(tick);
                machine.tick_10ms();
                machine.scan();
                machine.drain_moves(|_| n_moves += 1);
                assert!(machine.timers().count() == 32 && machine.events().count() <= 64);
            }
        });
        assert_eq!(allocations.count_total, 0);
        assert!(n_moves > 0);
    }
}

/// On the bench as in a mission: of two MOVE in one scan one is sent, a program that is stopped fails its MOVE, and the
/// outputs shown are those in the field.
#[test]
fn the_bench_shows_the_field_and_fails_the_move_of_a_stopped_program() {
    use decision::{Failsafe, MovePoints, Rehearsal, ResourceId, Script, rehearse};
    let source = "MOVE I0,1000,0,0,RISE\nMOVE I0,2000,0,0,RISE\nOR O2,I6,0L,0L,0L\n";
    let program = decision::compile(source).program.expect("correct");
    let mut machine = decision::Machine::new(program, decision::Mode::Corrected);
    machine.set_failsafe(Failsafe { on: 1, ..Failsafe::default() });
    let (busy, done, failed) = (Some(6), Some(4), Some(5));
    machine.set_move_points(MovePoints { busy, done, failed, ..MovePoints::default() });
    machine.run();
    let script = Script::parse("1 I0=1; 2 stop; 4 run; 6 done; 20 I0=0").expect("a script");
    let seconds = std::time::Duration::from_secs;
    assert_eq!(script.left_after(seconds(10)), [20.0]);
    assert!(script.left_after(seconds(21)).is_empty());
    let watched: Vec<ResourceId> = ["I5", "I6", "O0", "O2"]
        .iter()
        .map(|name| ResourceId::by_name(name).expect("a resource"))
        .collect();
    let plan = Rehearsal { duration: seconds(10), watched, move_takes: None };
    let mut rows = Vec::new();
    let n_sent = rehearse(&mut machine, &script, &plan, |row| rows.push(row.clone()));
    assert_eq!(n_sent, 1);
    let row = |t_s: f64| rows.iter().find(|row| row.t_s.to_bits() == t_s.to_bits()).expect("a row");
    assert!(row(1.0).news[0].contains("MOVE 1 is replaced by MOVE 2"), "{:?}", row(1.0));
    assert!(row(1.0).news[1].starts_with("MOVE 2 to (2000, 0)"), "{:?}", row(1.0));
    assert_eq!(row(1.0).values, [0, 1, 0, 1]);
    assert_eq!(row(2.0).values[2..], [1, 0], "the outputs in the field");
    assert!(row(2.0).news.iter().any(|n| n.starts_with("MOVE 2 is failed")), "{:?}", row(2.0));
    assert_eq!(row(4.0).values, [1, 0, 0, 0]);
    assert_eq!(row(6.0).news, ["no MOVE is under way that could be done"]);
}
