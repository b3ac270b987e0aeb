//! The machine beyond the language: run and stop, steps, events, watchdog, allocations.

#![cfg(test)]

use decision::{DateTime, Machine, Mode, Program, Step, compile};
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
    assert_eq!((machine.outputs(), machine.n_watchdog_resets()), (8, 1));
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
