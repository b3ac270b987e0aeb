//! The DLE framing of the radio links: `DLE STX DLE DLE payload DLE ETX`.
//!
//! A DLE (0x10) inside the payload is sent twice, so that `DLE ETX` can only be the end. The
//! [`Receiver`] is the byte-per-interrupt state machine of the thesis' pheromone server.
//!
//! Source: the thesis, Annex B1 (`int_svc`, `send_packet`).
//! Differences: the listing's sender forgets to double the DLEs although its receiver undoubles
//! them, so that a payload byte 0x10 breaks the frame; [`Framing::Stuffed`], the default, doubles
//! them and [`Framing::Listing`] does not. The listing enters state 5 when the byte that overflows
//! its buffer is a DLE; here an overflow always returns to state 0.

/// Data link escape: announces that the next byte is control, or a literal 0x10.
pub const DLE: u8 = 0x10;
/// Start of text.
pub const STX: u8 = 0x02;
/// End of text.
pub const ETX: u8 = 0x03;

/// Longest payload a [`Receiver::default`] accepts, bytes.
pub const PAYLOAD_MAX: usize = DEFAULT_BUFFER_SIZE - 2;

/// The receive buffer holds the payload, its closing DLE and ETX.
const DEFAULT_BUFFER_SIZE: usize = 256;

/// Whether the sender doubles the DLEs of a payload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Framing {
    /// Doubles them: any payload arrives.
    #[default]
    Stuffed,
    /// Does not, as the thesis' listing: a payload with a 0x10 is lost or mangled.
    Listing,
}

/// Order of the bytes of a 16-bit number. The thesis does not print it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// High byte first, the order of the arguments of the listing's `pack(high, low)`.
    #[default]
    BigEndian,
    /// Low byte first.
    LittleEndian,
}

impl ByteOrder {
    /// The two bytes of `value`, first sent first.
    pub fn bytes(self, value: i16) -> [u8; 2] {
        match self {
            Self::BigEndian => value.to_be_bytes(),
            Self::LittleEndian => value.to_le_bytes(),
        }
    }

    /// The number that two bytes, first sent first, stand for.
    pub fn number(self, bytes: [u8; 2]) -> i16 {
        match self {
            Self::BigEndian => i16::from_be_bytes(bytes),
            Self::LittleEndian => i16::from_le_bytes(bytes),
        }
    }
}

/// Appends the frame that carries `payload` to `out`.
pub fn write_frame(payload: &[u8], framing: Framing, out: &mut Vec<u8>) {
    out.extend_from_slice(&[DLE, STX, DLE, DLE]);
    for &byte in payload {
        out.push(byte);
        if byte == DLE && framing == Framing::Stuffed {
            out.push(DLE);
        }
    }
    out.extend_from_slice(&[DLE, ETX]);
}

/// Takes frames apart, byte by byte.
///
/// Cost: constant per byte; memory is the buffer given at the start.
#[derive(Clone, Debug)]
pub struct Receiver {
    state: State,
    buffer: Vec<u8>,
    buffer_size: usize,
    n_errors: u64,
    n_overflows: u64,
    n_dropped: u64,
    n_frames: u64,
}

/// What the next byte should be. The numbers are those of the listing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// 0: the DLE that opens a frame.
    Idle,
    /// 1: STX.
    Stx,
    /// 2: the first DLE after STX.
    FirstDle,
    /// 3: the second DLE after STX.
    SecondDle,
    /// 4: payload.
    Data,
    /// 5: what a DLE inside the payload means.
    Escape,
}

impl Receiver {
    /// A receiver with a buffer of so many bytes (the listing's `RBSIZE`); it takes payloads of up
    /// to two bytes less.
    pub fn with_buffer_size(buffer_size: usize) -> Self {
        Self {
            state: State::Idle,
            buffer: Vec::with_capacity(buffer_size),
            buffer_size,
            n_errors: 0,
            n_overflows: 0,
            n_dropped: 0,
            n_frames: 0,
        }
    }

    /// Takes one received byte; gives the payload of the frame that it completes.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        match (self.state, byte) {
            (State::Idle, DLE) => self.state = State::Stx,
            (State::Idle, _) => {}
            (State::Stx, STX) => self.state = State::FirstDle,
            (State::FirstDle, DLE) => self.state = State::SecondDle,
            (State::SecondDle, DLE) => {
                self.buffer.clear();
                self.state = State::Data;
            }
            (State::Stx | State::FirstDle | State::SecondDle, _) => {
                self.n_errors = self.n_errors.saturating_add(1);
                self.state = State::Idle;
            }
            (State::Data, _) => self.store(byte),
            (State::Escape, DLE) => self.state = State::Data,
            (State::Escape, ETX) => {
                self.state = State::Idle;
                self.n_frames = self.n_frames.saturating_add(1);
                // The last stored byte is the DLE before this ETX.
                return self.buffer.split_last().map(|(_dle, payload)| payload);
            }
            (State::Escape, _) => {
                self.n_dropped = self.n_dropped.saturating_add(1);
                self.state = State::Idle;
            }
        }
        None
    }

    /// The line reported an overrun, parity or framing error: the byte is lost and the frame with
    /// it.
    pub fn line_error(&mut self) {
        self.state = State::Idle;
        self.n_errors = self.n_errors.saturating_add(1);
    }

    /// Headers that went wrong and line errors so far: the listing's `error_count`.
    pub fn n_errors(&self) -> u64 {
        self.n_errors
    }

    /// Frames given up because they did not fit the buffer.
    pub fn n_overflows(&self) -> u64 {
        self.n_overflows
    }

    /// Frames given up because a DLE in them meant nothing.
    pub fn n_dropped(&self) -> u64 {
        self.n_dropped
    }

    /// Whole frames so far.
    pub fn n_frames(&self) -> u64 {
        self.n_frames
    }

    fn store(&mut self, byte: u8) {
        self.buffer.push(byte);
        if self.buffer.len() >= self.buffer_size {
            self.n_overflows = self.n_overflows.saturating_add(1);
            self.state = State::Idle;
        } else if byte == DLE {
            self.state = State::Escape;
        }
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::with_buffer_size(DEFAULT_BUFFER_SIZE)
    }
}

/// A payload of the wrong length or with the wrong first byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PayloadError {
    /// The payload has another length than its kind demands.
    #[error("{kind} of {len} bytes; it has {expected}")]
    Length {
        /// What was being read.
        kind: &'static str,
        /// Length found, bytes.
        len: usize,
        /// Length demanded, bytes.
        expected: usize,
    },
    /// The first byte names no kind that may come from that side.
    #[error("{kind} with operation code {opcode}; that side of the link never sends it")]
    Opcode {
        /// What was being read.
        kind: &'static str,
        /// The byte found.
        opcode: u8,
    },
    /// The payload was damaged on the way.
    #[error("{kind} with check byte {found:#04x} where its content demands {expected:#04x}")]
    Check {
        /// What was being read.
        kind: &'static str,
        /// The byte found.
        found: u8,
        /// What it should be.
        expected: u8,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    fn framed(payload: &[u8], framing: Framing) -> Vec<u8> {
        let mut out = Vec::new();
        write_frame(payload, framing, &mut out);
        out
    }

    fn receive(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Vec<u8>> {
        bytes.iter().filter_map(|&byte| receiver.push(byte).map(<[u8]>::to_vec)).collect()
    }

    fn receive_all(bytes: &[u8]) -> Vec<Vec<u8>> {
        receive(&mut Receiver::default(), bytes)
    }

    #[test]
    fn a_dle_in_the_payload_is_doubled_unless_as_in_the_listing() {
        let payload = [0x81, 1, 0x4A, 0x10, 0, 0];
        let stuffed = [0x10, 2, 0x10, 0x10, 0x81, 1, 0x4A, 0x10, 0x10, 0, 0, 0x10, 3];
        let listing = [0x10, 2, 0x10, 0x10, 0x81, 1, 0x4A, 0x10, 0, 0, 0x10, 3];
        assert_eq!(framed(&payload, Framing::Stuffed), stuffed);
        assert_eq!(framed(&payload, Framing::Listing), listing);
        assert_eq!(receive_all(&stuffed), [payload]);
        // The listing's frame is lost at the lone DLE.
        let mut receiver = Receiver::default();
        assert_eq!(receive(&mut receiver, &listing), Vec::<Vec<u8>>::new());
        assert_eq!(receiver.n_dropped(), 1);
    }

    #[test]
    fn the_listing_s_frame_arrives_when_it_has_no_dle() {
        assert_eq!(receive_all(&framed(&[0x81, 1, 74, 17], Framing::Listing)), [[0x81, 1, 74, 17]]);
    }

    /// Every state and byte of the table, as (bytes, whole frames, errors, dropped).
    #[test]
    fn the_machine_follows_the_table() {
        let cases: [(&[u8], usize, u64, u64); 11] = [
            (&[0x03, 0x55], 0, 0, 0),
            (&[0x10, 0x55], 0, 1, 0),
            (&[0x10, 0x10], 0, 1, 0),
            (&[0x10, 2, 0x55], 0, 1, 0),
            (&[0x10, 2, 0x10, 0x55], 0, 1, 0),
            (&[0x10, 2, 0x10, 0x10, 0x55, 0x10, 0x55], 0, 0, 1),
            (&[0x10, 2, 0x10, 0x10, 0x10, 3], 1, 0, 0),
            (&[0x10, 2, 0x10, 0x10, 0x55, 0x10, 3], 1, 0, 0),
            (&[0x10, 2, 0x10, 0x10, 0x10, 0x10, 0x10, 3], 1, 0, 0),
            (&[0x10, 2, 0x10, 0x10, 3, 2, 0x10, 3], 1, 0, 0),
            (&[0x10, 2, 0x10, 0x10, 7, 0x10, 2, 0x10, 0x10, 8, 0x10, 3], 0, 2, 1),
        ];
        for (bytes, frames, errors, dropped) in cases {
            let mut receiver = Receiver::default();
            let found = receive(&mut receiver, bytes).len();
            let counted = (found, receiver.n_errors(), receiver.n_dropped());
            assert_eq!(counted, (frames, errors, dropped), "{bytes:02x?}");
        }
    }

    #[test]
    fn a_frame_that_overflows_is_given_up_and_the_next_is_found() {
        let mut receiver = Receiver::with_buffer_size(10);
        let fits = framed(&[7; 8], Framing::Stuffed);
        assert_eq!(receive(&mut receiver, &fits), [[7; 8]]);
        let too_long = framed(&[7; 9], Framing::Stuffed);
        assert_eq!(receive(&mut receiver, &too_long).len(), 0);
        assert_eq!(receiver.n_overflows(), 1);
        // The byte that overflows is a DLE: still state 0, so the rest is no frame.
        assert_eq!(
            receive(&mut receiver, &framed(&[7, 7, 7, 7, 7, 7, 7, 7, 7, DLE], Framing::Stuffed))
                .len(),
            0
        );
        assert_eq!(receive(&mut receiver, &fits), [[7; 8]]);
        assert_eq!((receiver.n_overflows(), receiver.n_frames()), (2, 2));
    }

    #[test]
    fn a_line_error_drops_the_frame() {
        let mut receiver = Receiver::default();
        assert_eq!(receive(&mut receiver, &[0x10, 2, 0x10, 0x10, 5]).len(), 0);
        receiver.line_error();
        assert_eq!(receive(&mut receiver, &[6, 0x10, 3]).len(), 0);
        assert_eq!(receive(&mut receiver, &framed(&[9], Framing::Stuffed)), [[9]]);
        // One for the line, one for the header that began with the old frame's DLE.
        assert_eq!(receiver.n_errors(), 2);
    }

    #[test]
    fn byte_orders_are_each_other_s_mirror() {
        assert_eq!(ByteOrder::BigEndian.bytes(-200), [0xFF, 0x38]);
        assert_eq!(ByteOrder::LittleEndian.bytes(-200), [0x38, 0xFF]);
        assert_eq!(ByteOrder::LittleEndian.number([0x2C, 0x01]), 300);
        assert_eq!(ByteOrder::BigEndian.number([0x2C, 0x01]), 0x2C01);
    }

    fn dle_rich() -> impl Strategy<Value = u8> {
        prop_oneof![any::<u8>(), Just(DLE), Just(STX), Just(ETX)]
    }

    proptest! {
        #[test]
        fn every_payload_arrives(payload in vec(dle_rich(), 0..=PAYLOAD_MAX)) {
            prop_assert_eq!(receive_all(&framed(&payload, Framing::Stuffed)), vec![payload]);
        }

        /// Whatever state garbage leaves the machine in, one frame brings it back to step.
        #[test]
        fn after_garbage_at_most_one_frame_is_lost(
            garbage in vec(dle_rich(), 0..60),
            lost in vec(dle_rich(), 0..20),
            payload in vec(dle_rich(), 0..20),
        ) {
            let second = framed(&payload, Framing::Stuffed);
            let stream = [garbage, framed(&lost, Framing::Stuffed), second].concat();
            let found = receive_all(&stream);
            prop_assert_eq!(found.last(), Some(&payload));
        }
    }
}
