//! The machine that scans a program, as the microcontroller of the decision node does.
//!
//! A scan reads the inputs, evaluates every function in order, and writes the outputs. The caller
//! owns time: [`Machine::tick_10ms`] lets 10 ms pass, [`Machine::scan`] does one scan, and how
//! many of the one go with how many of the other is the caller's choice. The machine executes the
//! image, not the source, so that what it does is what the target does, byte by byte.
//!
//! Source: the thesis, §4.2.2 and Annex A2. Where text and listing disagree, [`Mode`] chooses.

use std::{ops::Add as _, sync::Arc, time::Duration};

use run_context::{Stamp, StateHash};

use crate::{
    DateTime, Family, OPCODE_END_OF_CYCLE, OPCODE_READ_INPUTS, Program, ResourceId, decode,
    execute::{LISTING_PROGRAM_BYTES, Memory},
    mode::Mode,
    moves::{MovePoints, MoveReport, MoveState},
    state::{Event, Failsafe, Fault, MoveCommand, Step},
    timers::{TICK, quantum_ticks},
};

/// What one timer is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimerView {
    /// 0 to 31.
    pub index: u8,
    /// Until its count-down ends. In listing mode, up to one quantum too much.
    pub remaining: Duration,
    /// What it counts in: 10 ms, 100 ms, 1 s or 1 min.
    pub quantum: Duration,
    /// Whether it is counting.
    pub running: bool,
    /// Its output, as the program sees it.
    pub output: bool,
}

/// What one scan did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanReport {
    /// Instructions executed, reading inputs and writing outputs included.
    pub n_instructions: usize,
    /// Functions among them. [`FUNCTION_MS`](crate::FUNCTION_MS) is about these.
    pub n_functions: usize,
    /// How it ended; never [`Step::Executed`].
    pub end: Step,
}

/// Time without a pass of the main loop after which the watchdog resets the machine, unless
/// another is set: 2 s, about the longest time the watchdog of such a controller knows. The thesis
/// gives none.
pub const WATCHDOG: Duration = Duration::from_secs(2);
/// Executes a program, scan by scan. Ticks, scans and steps allocate nothing.
///
/// ```
/// use decision::{Machine, Mode, compile};
///
/// let program = compile("AND O0,I0,NI1,1L,1L").program.expect("correct");
/// let mut machine = Machine::new(program, Mode::Corrected);
/// machine.set_input(0, true);
/// machine.scan();
/// assert_eq!(machine.outputs(), 0b1);
/// ```
#[derive(Clone, Debug)]
pub struct Machine {
    program: Program,
    image: Arc<[u8]>,
    memory: Memory,
    idle_ticks: u32,
    /// Ticks after which the watchdog bites; 0: it is switched off.
    watchdog_ticks: u32,
    n_watchdog_resets: u64,
    n_scans: u64,
}

impl Machine {
    /// A machine about to do its first scan.
    pub fn new(program: Program, mode: Mode) -> Self {
        let image = Arc::clone(&program.image);
        Self::with(program, image, mode)
    }

    /// A machine with these bytes in its program memory, whatever they are. If they are no
    /// program, [`Machine::program`] is empty, and running them shows what the target would do.
    pub fn from_image(image: &[u8], mode: Mode) -> Self {
        Self::with(decode(image).unwrap_or_default(), image.into(), mode)
    }

    fn with(program: Program, image: Arc<[u8]>, mode: Mode) -> Self {
        let image = match mode {
            Mode::Corrected => image,
            // The listing runs through its whole program memory, which is 0 where unwritten.
            // Nine more bytes, so that the last instruction can be read without an end.
            Mode::Listing => {
                let bytes = image.iter().copied().take(LISTING_PROGRAM_BYTES);
                bytes.chain(std::iter::repeat(0)).take(LISTING_PROGRAM_BYTES + 9).collect()
            }
        };
        let memory = Memory::new(mode);
        let (n_watchdog_resets, n_scans) = (0, 0);
        let watchdog_ticks = ticks(WATCHDOG);
        Self { program, image, memory, idle_ticks: 0, watchdog_ticks, n_watchdog_resets, n_scans }
    }

    /// Time without a step after which the watchdog resets it, in whole ticks; zero switches it
    /// off.
    pub fn set_watchdog(&mut self, after: Duration) {
        self.watchdog_ticks = ticks(after);
    }

    /// What the outputs do while no program drives them.
    pub fn set_failsafe(&mut self, failsafe: Failsafe) {
        self.memory.set_failsafe(failsafe);
    }

    /// The inputs that say what became of the last `MOVE`. They override the field's.
    pub fn set_move_points(&mut self, points: MovePoints) {
        self.memory.last_move.points = points;
    }

    /// Reports on a `MOVE` by its number. False, and nothing changes, when it is not the last one,
    /// or not waiting for such a report: an answer that comes too late is about something else.
    pub fn report_move(&mut self, number: u64, report: MoveReport) -> bool {
        self.memory.last_move.report(number, report)
    }

    /// What became of the last `MOVE`.
    pub fn move_state(&self) -> MoveState {
        self.memory.last_move.state
    }

    /// The number of the last `MOVE`; 0 before the first.
    pub fn n_moves(&self) -> u64 {
        self.memory.last_move.number
    }

    /// The program it executes.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Which of the two behaviours it has.
    pub fn mode(&self) -> Mode {
        self.memory.mode
    }

    /// Sets digital input `n` (0 to 15) in the field; the next scan reads it. Others are ignored.
    pub fn set_input(&mut self, n: u8, value: bool) {
        let bit = 1_u16.checked_shl(n.into()).unwrap_or(0);
        self.memory.inputs &= !bit;
        if value {
            self.memory.inputs |= bit;
        }
    }

    /// Sets all digital inputs in the field; bit n is input n.
    pub fn set_inputs(&mut self, inputs: u16) {
        self.memory.inputs = inputs;
    }

    /// The digital inputs in the field; bit n is input n.
    pub fn inputs(&self) -> u16 {
        self.memory.inputs
    }

    /// Sets analog input `n` (0 to 7) in the field; the next scan reads it. Others are ignored.
    pub fn set_analog(&mut self, n: u8, value: u8) {
        if let Some(analog) = self.memory.analogs.get_mut(usize::from(n)) {
            *analog = value;
        }
    }

    /// Lets 10 ms pass for timers, clock and watchdog.
    ///
    /// In listing mode this only raises a flag, which the next step or scan sees; a second tick
    /// before that is lost, as on the target (point 9 of the guide's list).
    pub fn tick_10ms(&mut self) {
        self.memory.now = self.memory.now.add(TICK);
        match self.memory.mode {
            Mode::Corrected => self.pass_tick(),
            Mode::Listing => self.memory.tick_flag = true,
        }
        self.idle_ticks = self.idle_ticks.saturating_add(1);
        if self.watchdog_ticks > 0 && self.idle_ticks >= self.watchdog_ticks {
            self.idle_ticks = 0;
            self.n_watchdog_resets = self.n_watchdog_resets.saturating_add(1);
            self.memory.restart();
        }
    }

    fn pass_tick(&mut self) {
        self.memory.timers.tick();
        self.memory.clock.tick(self.memory.mode);
    }

    /// Executes to the end of the scan; a whole scan, unless one was begun by steps. At most as
    /// many instructions as the program memory has bytes.
    pub fn scan(&mut self) -> ScanReport {
        let mut n_instructions: usize = 0;
        let mut n_functions: usize = 0;
        loop {
            let opcode = self.image.get(self.memory.next).copied();
            let is_function = !matches!(opcode, Some(OPCODE_READ_INPUTS | OPCODE_END_OF_CYCLE));
            let end = self.step_instruction();
            if matches!(end, Step::Executed | Step::EndOfScan) {
                n_instructions = n_instructions.saturating_add(1);
                n_functions = n_functions.saturating_add(usize::from(is_function));
            }
            if end != Step::Executed {
                return ScanReport { n_instructions, n_functions, end };
            }
        }
    }

    /// One pass of the target's main loop: executes one instruction, if `QRUN` lets it.
    pub fn step_instruction(&mut self) -> Step {
        self.idle_ticks = 0;
        if std::mem::take(&mut self.memory.tick_flag) {
            self.pass_tick();
        }
        if self.memory.fault.is_some() {
            return Step::Faulted;
        }
        if !self.is_running() {
            return Step::Stopped;
        }
        let code = self.image.get(self.memory.next..).unwrap_or_default();
        let step = self.memory.execute(code);
        if step == Step::EndOfScan {
            self.n_scans = self.n_scans.saturating_add(1);
        }
        step
    }

    /// Index in [`Program::functions`] of what the next step executes; `None` at the reading of
    /// inputs and the writing of outputs.
    pub fn next_function(&self) -> Option<usize> {
        let next = self.memory.next;
        self.program.functions.binary_search_by_key(&next, |function| function.address).ok()
    }

    /// Scans that came to their end.
    pub fn n_scans(&self) -> u64 {
        self.n_scans
    }

    /// Sets `QRUN`: goes on where it was stopped.
    pub fn run(&mut self) {
        self.memory.write(ResourceId::QRUN.address(), 1);
    }

    /// Clears `QRUN`: no instruction is executed any more, and the outputs go to their fail-safe
    /// values (in listing mode they stay as they are). Timers go on.
    pub fn stop(&mut self) {
        self.memory.write(ResourceId::QRUN.address(), 0);
    }

    /// Whether `QRUN` is set.
    pub fn is_running(&self) -> bool {
        self.memory.read(ResourceId::QRUN.address()) != 0
    }

    /// Starts over: initial values, no goals, outputs at their fail-safe values, first instruction.
    /// Inputs in the field, clock, time and the log of events stay.
    pub fn reset(&mut self) {
        self.idle_ticks = 0;
        self.memory.restart();
    }

    /// The outputs in the field; bit n is output n. They are what the last whole scan wrote, or
    /// their fail-safe values ([`Machine::drives_outputs`]).
    pub fn outputs(&self) -> u16 {
        self.memory.outputs
    }

    /// Whether the program drives the outputs; otherwise they have their fail-safe values.
    pub fn drives_outputs(&self) -> bool {
        self.memory.drives_outputs
    }

    /// Takes the goals sent since the last call, in order. At most 32 wait; the oldest go first.
    pub fn drain_moves(&mut self, take: impl FnMut(MoveCommand)) {
        std::iter::from_fn(|| self.memory.moves.pop()).for_each(take);
    }

    /// Goals lost because nobody took them in time.
    pub fn n_moves_lost(&self) -> u64 {
        self.memory.moves.n_lost()
    }

    /// The byte of a resource: a number, or a history with the present value in bit 0.
    pub fn resource(&self, id: ResourceId) -> u8 {
        self.memory.read(id.address())
    }

    /// The byte of a resource, by name; `None` when nothing is called so.
    pub fn resource_by_name(&self, name: &str) -> Option<u8> {
        ResourceId::by_name(name).ok().map(|id| self.resource(id))
    }

    /// Puts a byte into a resource, for debugging. What the next scan writes, it overwrites.
    pub fn set_resource(&mut self, id: ResourceId, value: u8) {
        self.memory.write(id.address(), value);
    }

    /// The 32 timers, in order.
    pub fn timers(&self) -> impl Iterator<Item = TimerView> + '_ {
        (0..32).map(|index| {
            let remaining = self.memory.timers.remaining(index);
            let output = ResourceId::of(Family::TimerOutput, index);
            TimerView {
                index,
                remaining,
                quantum: TICK.saturating_mul(quantum_ticks(index)),
                running: !remaining.is_zero(),
                output: output.is_some_and(|id| self.resource(id) & 1 != 0),
            }
        })
    }

    /// The event log, oldest first: the last 64 events.
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        self.memory.events.iter()
    }

    /// Events that the log has forgotten.
    pub fn n_events_lost(&self) -> u64 {
        self.memory.events.n_lost()
    }

    /// The fault it stands on, if it does.
    pub fn fault(&self) -> Option<Fault> {
        self.memory.fault
    }

    /// How often the watchdog has reset it ([`Code::WatchdogReset`](crate::Code::WatchdogReset)): whenever its time passed in
    /// ticks without a step.
    pub fn n_watchdog_resets(&self) -> u64 {
        self.n_watchdog_resets
    }

    /// Time since it was switched on.
    pub fn now(&self) -> Stamp {
        self.memory.now
    }

    /// What its clock shows.
    pub fn clock(&self) -> DateTime {
        self.memory.clock
    }

    /// Sets its clock; false, and nothing changes, if there is no such date or time.
    pub fn set_clock(&mut self, clock: DateTime) -> bool {
        let is_valid = clock.is_valid(self.memory.mode);
        if is_valid {
            self.memory.clock = clock;
        }
        is_valid
    }

    /// Events logged so far, the forgotten ones included.
    pub fn n_events(&self) -> u64 {
        self.memory.events.n_pushed()
    }

    /// Absorbs everything that decides what it does next.
    pub fn absorb_state(&self, hash: &mut StateHash) {
        self.memory.absorb_state(hash);
        hash.absorb_u64(self.idle_ticks.into());
    }
}

/// Whole ticks in a time.
fn ticks(time: Duration) -> u32 {
    u32::try_from(time.as_millis() / 10).unwrap_or(u32::MAX)
}
