//! One instruction at a time: everything the target keeps in RAM, and what each opcode does to it.
//!
//! Source: the thesis, Annex A2. The comments number the points where [`Mode::Corrected`] departs
//! from the listing; the guide (`docs/guide/rdpl.md`) explains each to users.

use run_context::{Stamp, StateHash};

use crate::{
    Code, EdgeCode, Family, Mnemonic, Mode, OPCODE_END_OF_CYCLE, OPCODE_READ_INPUTS, ResourceId,
    clock::DateTime,
    estimate::N_FUNCTIONS_MAX,
    moves::LastMove,
    ring::Ring,
    state::{Event, Failsafe, Fault, MoveCommand, Step},
    timers::{Start, Timers},
};

/// Goals that wait to be taken; far more than one scan's worth is never useful.
const N_MOVES: usize = 32;
/// Entries of the event log.
const N_EVENTS: usize = 64;
/// Bytes of program memory that the listing's interpreter runs through before it wraps.
pub(crate) const LISTING_PROGRAM_BYTES: usize = 4096;

/// What goes on after an instruction.
#[derive(Clone, Copy)]
enum Next {
    /// At the instruction so many bytes on.
    Skip(usize),
    /// At the beginning: the scan is over.
    Begin,
    /// At the same instruction, for ever.
    Stay,
    /// Nowhere.
    Fault(Code),
}

/// The RAM of the target.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    pub(crate) mode: Mode,
    /// Every address an image can name, also those that no resource has.
    bytes: [u8; 256],
    pub(crate) inputs: u16,
    pub(crate) analogs: [u8; 8],
    pub(crate) outputs: u16,
    /// What the outputs do while the program does not drive them.
    failsafe: Failsafe,
    /// Whether the program drives the outputs: it has written them and goes on running.
    pub(crate) drives_outputs: bool,
    pub(crate) last_move: LastMove,
    /// Functions executed in this scan.
    n_functions: usize,
    pub(crate) timers: Timers,
    pub(crate) moves: Ring<MoveCommand, N_MOVES>,
    pub(crate) events: Ring<Event, N_EVENTS>,
    pub(crate) fault: Option<Fault>,
    /// Offset of the next instruction.
    pub(crate) next: usize,
    pub(crate) clock: DateTime,
    pub(crate) now: Stamp,
    /// A tick that the main loop has not seen yet; listing mode only.
    pub(crate) tick_flag: bool,
}

impl Memory {
    pub(crate) fn new(mode: Mode) -> Self {
        let mut memory = Self {
            mode,
            bytes: [0; 256],
            inputs: 0,
            analogs: [0; 8],
            outputs: 0,
            failsafe: Failsafe::default(),
            drives_outputs: false,
            last_move: LastMove::default(),
            n_functions: 0,
            timers: Timers::new(mode),
            moves: Ring::new(),
            events: Ring::new(),
            fault: None,
            next: 0,
            clock: DateTime::SWITCHED_ON,
            now: Stamp::ZERO,
            tick_flag: false,
        };
        // Correction 6: what has always been 1 has a history of ones. The table's plain 1 reads
        // as a rising edge, and 1L would rise for ever.
        let one = match mode {
            Mode::Corrected => 0xFF,
            Mode::Listing => 0x01,
        };
        let negated = (0..16).filter_map(|n| ResourceId::of(Family::NegatedInput, n));
        let state = ResourceId::of(Family::State, 0);
        for id in negated.chain(state).chain([ResourceId::ONE]) {
            memory.write(id.address(), one);
        }
        memory.write(ResourceId::QRUN.address(), 1);
        memory.read_clock();
        memory
    }

    /// A reset by the watchdog or by hand: initial values, but the field stays as it is, and so
    /// do the time, the log of events and how the machine is wired.
    pub(crate) fn restart(&mut self) {
        let fresh = Self::new(self.mode);
        let old = std::mem::replace(self, fresh);
        (self.inputs, self.analogs, self.outputs) = (old.inputs, old.analogs, old.outputs);
        (self.clock, self.now, self.events) = (old.clock, old.now, old.events);
        self.last_move = old.last_move.restarted();
        self.set_failsafe(old.failsafe);
        self.read_clock();
    }

    /// What the outputs do while no program drives them, from now on.
    pub(crate) fn set_failsafe(&mut self, failsafe: Failsafe) {
        self.failsafe = failsafe;
        if !self.drives_outputs {
            self.release_outputs();
        }
    }

    /// The program does not drive the outputs any more: they go to their fail-safe values.
    fn release_outputs(&mut self) {
        let Failsafe { on, hold } = self.failsafe;
        self.outputs = (on & !hold) | (self.outputs & hold);
        self.drives_outputs = false;
    }

    pub(crate) fn read(&self, address: u8) -> u8 {
        self.bytes.get(usize::from(address)).copied().unwrap_or(0)
    }

    pub(crate) fn write(&mut self, address: u8, value: u8) {
        if let Some(byte) = self.bytes.get_mut(usize::from(address)) {
            *byte = value;
        }
        // Correction 11: the listing's outputs stay as they are when the program is stopped.
        if address == ResourceId::QRUN.address() && value == 0 && self.mode == Mode::Corrected {
            self.release_outputs();
        }
    }

    /// The new value becomes bit 0, and every older one moves up.
    fn shift(&mut self, address: u8, bit: bool) {
        let history = self.read(address);
        self.write(address, (history << 1) | u8::from(bit));
    }

    fn bit(&self, address: u8) -> bool {
        self.read(address) & 1 != 0
    }

    fn edge_is(&self, address: u8, edge: u8) -> bool {
        EdgeCode::of(self.read(address)) == EdgeCode::of(edge)
    }

    /// Executes the instruction at the beginning of `code`, the rest of the image.
    pub(crate) fn execute(&mut self, code: &[u8]) -> Step {
        let Some((&opcode, rest)) = code.split_first() else {
            return self.advance(Next::Fault(Code::TruncatedImage));
        };
        let next = match opcode {
            OPCODE_READ_INPUTS => self.read_inputs(),
            OPCODE_END_OF_CYCLE => self.end_of_cycle(),
            // A scan that takes longer than it may is an error of its own, as in any programmable
            // controller; the listing's interpreter does not look.
            _ if self.mode == Mode::Corrected && self.n_functions >= N_FUNCTIONS_MAX => {
                Next::Fault(Code::ScanOverrun)
            }
            _ => {
                self.n_functions = self.n_functions.saturating_add(1);
                match Mnemonic::by_opcode(opcode) {
                    Some(mnemonic) => self.function(mnemonic, rest),
                    None => self.unknown(opcode),
                }
            }
        };
        self.advance(next)
    }

    /// Executes a function, whose operands are the first of `rest`.
    fn function(&mut self, mnemonic: Mnemonic, rest: &[u8]) -> Next {
        let size = mnemonic.size_bytes();
        let Some((operands, tail)) = rest.split_at_checked(size.saturating_sub(1)) else {
            return Next::Fault(Code::TruncatedImage);
        };
        match mnemonic {
            Mnemonic::And => self.logic(operands, |[a, b, c, d]| a & b & c & d),
            Mnemonic::Nand => self.logic(operands, |[a, b, c, d]| !(a & b & c & d)),
            Mnemonic::Or => self.logic(operands, |[a, b, c, d]| a | b | c | d),
            Mnemonic::Nor => self.logic(operands, |[a, b, c, d]| !(a | b | c | d)),
            Mnemonic::Xor => self.logic(operands, |[a, b, c, d]| a ^ b ^ c ^ d),
            Mnemonic::Ff => self.flip_flop(fixed(operands)),
            Mnemonic::Timer => self.timer(fixed(operands)),
            Mnemonic::Counter => self.counter(fixed(operands)),
            Mnemonic::Dcomp => {
                let [dest, a, b, mask] = fixed(operands);
                self.shift(dest, self.read(a) & mask == self.read(b) & mask);
            }
            Mnemonic::Acomp => {
                let [dest, a, b] = fixed(operands);
                self.shift(dest, self.read(a) >= self.read(b));
            }
            Mnemonic::Move => {
                self.move_to(fixed(operands));
                if self.mode == Mode::Listing {
                    // Correction 3: the listing takes 0x0E for reserved and starts over, so that nothing
                    // after a MOVE is ever executed, and the outputs are never written.
                    return Next::Begin;
                }
            }
            Mnemonic::Stc => {
                let [dest, source, condition, edge] = fixed(operands);
                // Correction 4: the listing takes the edge from one byte too far, which is the
                // opcode of the next instruction.
                let edge = match self.mode {
                    Mode::Corrected => edge,
                    Mode::Listing => tail.first().copied().unwrap_or(0),
                };
                if self.edge_is(condition, edge) {
                    self.write(dest, self.read(source));
                }
            }
            Mnemonic::Stic => {
                let [dest, constant, condition, edge] = fixed(operands);
                if self.edge_is(condition, edge) {
                    self.write(dest, constant);
                }
            }
            Mnemonic::Oper => self.add(fixed(operands)),
            Mnemonic::Mul => self.multiply(fixed(operands)),
            Mnemonic::Event => self.event(fixed(operands)),
        }
        Next::Skip(size)
    }

    /// What the listing calls `next()`.
    fn advance(&mut self, next: Next) -> Step {
        // Correction 2: S follows STATUS once per scan, so that an edge of S lasts a scan. The
        // listing shifts it after every instruction.
        let decodes = match self.mode {
            Mode::Corrected => matches!(next, Next::Begin),
            Mode::Listing => !matches!(next, Next::Stay),
        };
        if decodes {
            self.decode_status();
        }
        match next {
            Next::Skip(size) => {
                self.next = self.next.saturating_add(size);
                if self.mode == Mode::Listing && self.next >= LISTING_PROGRAM_BYTES {
                    self.next = 0;
                    return Step::EndOfScan;
                }
                Step::Executed
            }
            Next::Begin => {
                self.next = 0;
                self.n_functions = 0;
                Step::EndOfScan
            }
            Next::Stay => Step::Hung,
            Next::Fault(code) => {
                self.fault = Some(Fault { code, address: self.next });
                if self.mode == Mode::Corrected {
                    self.release_outputs();
                }
                Step::Faulted
            }
        }
    }

    fn decode_status(&mut self) {
        let status = self.read(ResourceId::STATUS.address()) & 0x0F;
        for number in 0..16 {
            if let Some(id) = ResourceId::of(Family::State, number) {
                self.shift(id.address(), number == status);
            }
        }
    }

    fn read_inputs(&mut self) -> Next {
        let inputs = self.last_move.on(self.inputs);
        self.last_move.read();
        for number in 0..16_u8 {
            let value = inputs.checked_shr(number.into()).unwrap_or(0) & 1 != 0;
            for (id, bit) in input_pair(number).into_iter().zip([value, !value]) {
                if let Some(id) = id {
                    self.shift(id.address(), bit);
                }
            }
        }
        self.read_clock();
        let analogs = self.analogs;
        for (number, value) in (0_u8..).zip(analogs) {
            if let Some(id) = ResourceId::of(Family::Analog, number) {
                self.write(id.address(), value);
            }
        }
        Next::Skip(1)
    }

    /// Puts the clock into the resources that show it.
    fn read_clock(&mut self) {
        let DateTime { month, day, hour, minute, second, .. } = self.clock;
        let shown = [
            (Family::Hour, hour),
            (Family::Minute, minute),
            (Family::Second, second),
            (Family::Day, day),
            (Family::Month, month),
            (Family::Weekday, self.clock.weekday()),
        ];
        for (family, value) in shown {
            if let Some(id) = ResourceId::of(family, 0) {
                self.write(id.address(), value);
            }
        }
    }

    /// The points of `MOVE` change in the middle of a scan, as if this scan had read them so: bit
    /// 0 of their histories is replaced, and nothing shifts.
    fn amend_move_points(&mut self) {
        let inputs = self.last_move.on(self.inputs);
        for number in self.last_move.inputs().into_iter().flatten() {
            let value = inputs.checked_shr(number.into()).unwrap_or(0) & 1 != 0;
            for (id, bit) in input_pair(number).into_iter().zip([value, !value]) {
                if let Some(id) = id {
                    let history = self.read(id.address());
                    self.write(id.address(), (history & !1) | u8::from(bit));
                }
            }
        }
    }

    fn end_of_cycle(&mut self) -> Next {
        let mut outputs = 0;
        for number in (0..16).rev() {
            let bit =
                ResourceId::of(Family::Output, number).is_some_and(|id| self.bit(id.address()));
            outputs = (outputs << 1) | u16::from(bit);
        }
        self.outputs = outputs;
        self.drives_outputs = true;
        Next::Begin
    }

    fn logic(&mut self, operands: &[u8], function: impl Fn([bool; 4]) -> bool) {
        let [dest, inputs @ ..] = fixed::<5>(operands);
        let bit = function(inputs.map(|address| self.bit(address)));
        self.shift(dest, bit);
    }

    fn flip_flop(&mut self, [dest, set, reset, priority]: [u8; 4]) {
        let bit = match [set, reset].map(|address| self.bit(address)) {
            [true, false] => true,
            [false, true] => false,
            [true, true] => priority & 1 != 0,
            // Correction 1: a flip-flop that holds has been updated all the same. The listing
            // does not shift, so that the rising edge of a short pulse never ends.
            [false, false] if self.mode == Mode::Listing => return,
            [false, false] => self.bit(dest),
        };
        self.shift(dest, bit);
    }

    fn timer(&mut self, [timer, kind, input, edge, k]: [u8; 5]) {
        let number = timer & 0x1F;
        let start = Start {
            number,
            is_oscillator: kind & 1 != 0,
            input: EdgeCode::of(self.read(input)),
            edge: EdgeCode::of(edge),
            k,
        };
        let output = self.timers.execute(start);
        if let Some(id) = ResourceId::of(Family::TimerOutput, number) {
            self.shift(id.address(), output);
        }
    }

    fn counter(&mut self, [dest, direction, clock, edge]: [u8; 4]) {
        let code = EdgeCode::of(edge);
        if matches!(code, EdgeCode::Rising | EdgeCode::Falling) && self.edge_is(clock, edge) {
            let count = self.read(dest);
            let up = self.bit(direction);
            self.write(dest, if up { count.saturating_add(1) } else { count.saturating_sub(1) });
        }
    }

    fn move_to(&mut self, [trigger, x1, x0, y1, y0, h1, h0, edge]: [u8; 8]) {
        if self.edge_is(trigger, edge) {
            let [x_mm, y_mm, heading_deg] = [[x1, x0], [y1, y0], [h1, h0]].map(i16::from_be_bytes);
            let number = self.last_move.begin();
            self.moves.push(MoveCommand { x_mm, y_mm, heading_deg, number });
            self.amend_move_points();
        }
    }

    fn add(&mut self, [high, low, a, b, select]: [u8; 5]) {
        let [a, b] = [a, b].map(|address| self.read(address));
        let select = match self.mode {
            Mode::Corrected => select,
            // Correction 12: the listing fetches SELOP like the other operands, through the table
            // of resources. Its 0 is I0 and its 1 is I1.
            Mode::Listing => self.read(select),
        };
        if select & 1 == 0 {
            return self.write_pair(high, low, u16::from(a).saturating_add(u16::from(b)));
        }
        // Correction 5, second part: the listing clears the sign it has just set.
        let negative = a < b && self.mode == Mode::Corrected;
        self.write(high, if negative { 0x80 } else { 0x00 });
        self.write(low, a.abs_diff(b));
    }

    fn multiply(&mut self, [high, low, a, b]: [u8; 4]) {
        let [a, b] = [a, b].map(|address| u16::from(self.read(address)));
        self.write_pair(high, low, a.saturating_mul(b));
    }

    fn write_pair(&mut self, high: u8, low: u8, value: u16) {
        let [high_byte, low_byte] = value.to_be_bytes();
        let high_byte = match self.mode {
            Mode::Corrected => high_byte,
            // Correction 5, first part: `temp & 0xff00 >> 8` is `temp & (0xff00 >> 8)` in C.
            Mode::Listing => low_byte,
        };
        self.write(high, high_byte);
        self.write(low, low_byte);
    }

    fn event(&mut self, [kind, input, edge]: [u8; 3]) {
        if let Some(resource) = ResourceId::from_address(input)
            && self.edge_is(input, edge)
        {
            let history = self.read(input);
            let (at, clock) = (self.now, self.clock);
            self.events.push(Event { at, clock, kind: kind & 0x0F, resource, history });
        }
    }

    fn unknown(&self, opcode: u8) -> Next {
        match (self.mode, opcode) {
            // Correction 7: the listing hangs on the reserved opcodes and starts over on all
            // others that it does not know.
            (Mode::Corrected, _) => Next::Fault(Code::UnknownOpcode),
            (Mode::Listing, 0x01..=0x03) => Next::Stay,
            (Mode::Listing, _) => Next::Begin,
        }
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_bytes(&self.bytes);
        hash.absorb_bytes(&self.analogs);
        let fault = self.fault.map_or(u64::MAX, |fault| fault.address as u64);
        let words = [self.inputs.into(), self.outputs.into(), self.next as u64, fault];
        for word in words {
            hash.absorb_u64(word);
        }
        hash.absorb_u64(self.now.as_nanos());
        hash.absorb_u64(self.tick_flag.into());
        hash.absorb_u64(self.drives_outputs.into());
        self.last_move.absorb_state(hash);
        self.timers.absorb_state(hash);
        for goal in self.moves.iter() {
            for number in [goal.x_mm, goal.y_mm, goal.heading_deg] {
                hash.absorb_bytes(&number.to_be_bytes());
            }
        }
        for event in self.events.iter() {
            hash.absorb_u64(event.at.as_nanos());
            hash.absorb_bytes(&[event.kind, event.resource.address(), event.history]);
        }
    }
}

/// Operands as many as a function has. Their number is that of the table; the zeros of others are never seen.
fn fixed<const N: usize>(operands: &[u8]) -> [u8; N] {
    debug_assert_eq!(operands.len(), N, "the table and the machine differ in a function's size");
    operands.try_into().unwrap_or([0; N])
}

/// An input and its complement.
fn input_pair(number: u8) -> [Option<ResourceId>; 2] {
    [Family::Input, Family::NegatedInput].map(|family| ResourceId::of(family, number))
}
