//! The doorbell program over twenty seconds: prints what changes, when.
//!
//! Run with `cargo run -p cairn_decision --example doorbell`.
#![expect(clippy::print_stdout, reason = "an example prints what it found")]

use decision::{Machine, Mode, compile};

const PROGRAM: &str = "\
BELL  EQU   I0
      OR    Y1,I1,I2,I3,0L
      FF    Y2,BELL,Y1,0
      TIMER 16,MONO,BELL,RISE,15
      TIMER 0,MONO,YTMR16,FALL,10
      AND   Y3,YTMR0,Y2,1L,1L
      MOVE  Y3,5000,3500,45,RISE
";

fn main() {
    let compilation = compile(PROGRAM);
    let Some(program) = compilation.program else {
        compilation.diagnostics.iter().for_each(|diagnostic| println!("{diagnostic}"));
        return;
    };
    println!("{}", program.listing());
    let mut machine = Machine::new(program, Mode::Corrected);
    let mut before = [0; 5];
    for tick in 0..2000 {
        machine.set_input(0, (200..250).contains(&tick));
        machine.scan();
        let names = ["I0", "Y2", "YTMR16", "YTMR0", "Y3"];
        let now = names.map(|name| machine.resource_by_name(name).unwrap_or(0) & 1);
        for (name, (old, new)) in names.iter().zip(before.iter().zip(now)) {
            if *old != new {
                println!("{}  {name} is {new}", machine.now());
            }
        }
        let at = machine.now();
        machine.drain_moves(|goal| println!("{at}  {goal:?}"));
        before = now;
        machine.tick_10ms();
    }
}
