//! RPLIDAR A1 (and A2 in standard mode): requests, response descriptors, sample nodes.
//!
//! The host asks with `A5 command`, or `A5 command length payload xor` when the command's bit 7 is set. The device
//! answers with a descriptor, `A5 5A`, u32 (length of one packet, and whether more follow), type; then
//! with packets of that length. Angles grow clockwise seen from above. 115200 baud, 8N1.
//!
//! A standard node is 5 bytes:
//!
//! | bits | content |
//! | --- | --- |
//! | 0 | S: first sample of a turn |
//! | 1 | not S |
//! | 2 … 7 | quality |
//! | 8 | check, always 1 |
//! | 9 … 23 | angle, 1/64° |
//! | 24 … 39 | distance, 1/4 mm; 0: nothing came back |
//!
//! Source: the maker's public SDK (`Slamtec/rplidar_sdk`) and protocol manuals of the A1 and A2.
//! Differences: express scans (`82`) and configuration queries (`84`) are read as requests and have no answer
//! here, as on early firmware.

use crate::search::Search;

mod reader;
mod request;

pub(crate) use reader::reader;
pub use request::{Request, RequestDecoder};

/// The line's speed, bits per second.
pub const BAUD: u32 = 115_200;

/// Sixty-fourths of a degree in a turn.
pub const TURN_Q6: u16 = 360 * 64;
/// Length of a standard node, bytes.
pub const NODE_LEN: usize = 5;

const START: u8 = 0xA5;
const ANSWER: u8 = 0x5A;
const DESCRIPTOR_LEN: usize = 7;
/// Bit 30 of a descriptor's length: packets follow until the next request.
const ENDLESS: u32 = 1 << 30;

/// What kind of packets a descriptor announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerKind {
    /// One [`Info`].
    Info,
    /// One [`Health`].
    Health,
    /// One [`SampleTimes`].
    SampleTimes,
    /// [`Node`]s without end.
    Nodes,
    /// The adapter's flags: u32, bit 0 says that it can drive the motor by PWM.
    AdapterFlags,
}

/// Who the device is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Info {
    /// Major model in the high four bits, sub-model in the low ones: 0x18 is an A1M8.
    pub model: u8,
    /// Firmware, minor part: hundredths.
    pub firmware_minor: u8,
    /// Firmware, major part.
    pub firmware_major: u8,
    /// Hardware.
    pub hardware: u8,
    /// Serial number.
    pub serial: [u8; 16],
}

/// How the device feels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// 0 good, 1 warning, 2 error: protection stop.
    pub status: u8,
    /// The device's error code.
    pub error: u16,
}

/// How long a sample takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleTimes {
    /// In standard mode, µs.
    pub standard_us: u16,
    /// In express mode, µs.
    pub express_us: u16,
}

/// One sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Node {
    /// Whether it is the first of a turn.
    pub is_first: bool,
    /// Strength of what came back, 0 to 63.
    pub quality: u8,
    /// Angle from the zero axis, clockwise, 1/64°, below 23 040.
    pub angle_q6: u16,
    /// Range, 1/4 mm; 0: nothing came back.
    pub distance_q2: u16,
}

/// Something whole that the device said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A request was understood; this is what comes.
    Announced(AnswerKind),
    /// Who the device is.
    Info(Info),
    /// How it feels.
    Health(Health),
    /// How long a sample takes.
    SampleTimes(SampleTimes),
    /// The adapter's flags.
    AdapterFlags(u32),
    /// A sample.
    Node(Node),
}

impl AnswerKind {
    const ALL: [Self; 5] =
        [Self::Info, Self::Health, Self::SampleTimes, Self::Nodes, Self::AdapterFlags];

    /// Length of a packet, bytes, and the type's number.
    fn facts(self) -> (u32, u8) {
        match self {
            Self::Info => (20, 0x04),
            Self::Health => (3, 0x06),
            Self::SampleTimes => (4, 0x15),
            Self::Nodes => (5, 0x81),
            Self::AdapterFlags => (4, 0xFF),
        }
    }

    /// The descriptor that announces it.
    pub fn descriptor(self) -> [u8; DESCRIPTOR_LEN] {
        let (len, number) = self.facts();
        let mode = if self == Self::Nodes { ENDLESS } else { 0 };
        let [l0, l1, l2, l3] = (len | mode).to_le_bytes();
        [START, ANSWER, l0, l1, l2, l3, number]
    }
}

impl Info {
    /// The packet, without its descriptor.
    pub fn encode(&self) -> [u8; 20] {
        let mut bytes = [0; 20];
        let head = [self.model, self.firmware_minor, self.firmware_major, self.hardware];
        for (place, byte) in bytes.iter_mut().zip(head.into_iter().chain(self.serial)) {
            *place = byte;
        }
        bytes
    }
}

impl Health {
    /// The packet, without its descriptor.
    pub fn encode(&self) -> [u8; 3] {
        let [low, high] = self.error.to_le_bytes();
        [self.status, low, high]
    }
}

impl SampleTimes {
    /// The packet, without its descriptor.
    pub fn encode(&self) -> [u8; 4] {
        let ([s0, s1], [e0, e1]) = (self.standard_us.to_le_bytes(), self.express_us.to_le_bytes());
        [s0, s1, e0, e1]
    }
}

impl Node {
    /// The bytes on the line; angle and quality keep the bits that they have room for.
    pub fn encode(&self) -> [u8; NODE_LEN] {
        let sync = if self.is_first { 0b01 } else { 0b10 };
        let [a0, a1] = ((self.angle_q6 << 1) | 1).to_le_bytes();
        let [d0, d1] = self.distance_q2.to_le_bytes();
        [(self.quality << 2) | sync, a0, a1, d0, d1]
    }

    /// Reads a node; `None` where its check bits say that this is none.
    pub fn decode(bytes: [u8; NODE_LEN]) -> Option<Self> {
        let [head, a0, a1, d0, d1] = bytes;
        let angle = u16::from_le_bytes([a0, a1]);
        let angle_q6 = angle >> 1;
        let is_node = matches!(head & 0b11, 0b01 | 0b10) && angle & 1 == 1 && angle_q6 < TURN_Q6;
        is_node.then(|| Self {
            is_first: head & 1 == 1,
            quality: head >> 2,
            angle_q6,
            distance_q2: u16::from_le_bytes([d0, d1]),
        })
    }
}

/// Finds answers in received bytes that may be cut anywhere and may carry noise.
///
/// A descriptor is looked for in front of each packet, so samples that were still under way when a
/// scan was ended cost nothing but bytes. Samples have no checksum: a byte where a node's check bits
/// are wrong is skipped and counted, as the maker's SDK does.
///
/// Cost: at most 7 steps per received byte; at most 20 bytes stay behind between calls.
#[derive(Clone, Debug)]
pub struct Decoder {
    search: Search,
    awaited: Option<AnswerKind>,
    n_answers: u64,
    n_nodes: u64,
}

impl Decoder {
    /// A decoder that has heard nothing.
    pub fn new() -> Self {
        Self { search: Search::new(), awaited: None, n_answers: 0, n_nodes: 0 }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped and
    /// counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// A request was sent that ends whatever the device was sending: only a descriptor counts now.
    pub fn expect_descriptor(&mut self) {
        self.awaited = None;
    }

    /// Whether samples come.
    pub fn is_scanning(&self) -> bool {
        self.awaited == Some(AnswerKind::Nodes)
    }

    /// The next whole answer, or `None` until more bytes come.
    pub fn next_answer(&mut self) -> Option<Answer> {
        loop {
            if let Some(kind) = self.announced() {
                self.search.take(DESCRIPTOR_LEN);
                self.awaited = Some(kind);
                return Some(Answer::Announced(kind));
            }
            let unread = self.search.unread();
            match self.awaited {
                None => {
                    let first = *unread.first()?;
                    // A descriptor may still be growing.
                    let may_grow = unread.len() < DESCRIPTOR_LEN
                        && first == START
                        && unread.get(1).is_none_or(|&second| second == ANSWER);
                    if may_grow {
                        return None;
                    }
                    self.search.skip(1);
                }
                Some(AnswerKind::Nodes) => {
                    let bytes = *unread.first_chunk::<NODE_LEN>()?;
                    if let Some(node) = Node::decode(bytes) {
                        self.search.take(NODE_LEN);
                        self.n_nodes = self.n_nodes.saturating_add(1);
                        return Some(Answer::Node(node));
                    }
                    let may_grow =
                        unread.len() < DESCRIPTOR_LEN && bytes.starts_with(&[START, ANSWER]);
                    if may_grow {
                        return None;
                    }
                    self.search.skip(1);
                }
                Some(kind) => {
                    let (answer, len) = single(kind, unread)?;
                    self.search.take(len);
                    self.awaited = None;
                    self.n_answers = self.n_answers.saturating_add(1);
                    return Some(answer);
                }
            }
        }
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.search.skip_all();
        self.awaited = None;
    }

    /// Single answers so far.
    pub fn n_answers(&self) -> u64 {
        self.n_answers
    }

    /// Samples so far.
    pub fn n_nodes(&self) -> u64 {
        self.n_nodes
    }

    /// Bytes thrown away as noise, or as samples that came after their scan was ended, so far.
    pub fn n_bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// The kind that the descriptor at the front announces. A single answer's content is never looked
    /// into.
    fn announced(&self) -> Option<AnswerKind> {
        if !matches!(self.awaited, None | Some(AnswerKind::Nodes)) {
            return None;
        }
        let bytes = self.search.unread().first_chunk::<DESCRIPTOR_LEN>()?;
        AnswerKind::ALL.into_iter().find(|kind| kind.descriptor() == *bytes)
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

/// A single answer and its length, once it is whole.
fn single(kind: AnswerKind, bytes: &[u8]) -> Option<(Answer, usize)> {
    let answer = match kind {
        AnswerKind::Info => {
            let &[model, firmware_minor, firmware_major, hardware] = bytes.first_chunk::<4>()?;
            let serial = *bytes.get(4..)?.first_chunk::<16>()?;
            Answer::Info(Info { model, firmware_minor, firmware_major, hardware, serial })
        }
        AnswerKind::Health => {
            let &[status, low, high] = bytes.first_chunk::<3>()?;
            Answer::Health(Health { status, error: u16::from_le_bytes([low, high]) })
        }
        AnswerKind::SampleTimes => {
            let &[s0, s1, e0, e1] = bytes.first_chunk::<4>()?;
            let [standard_us, express_us] = [[s0, s1], [e0, e1]].map(u16::from_le_bytes);
            Answer::SampleTimes(SampleTimes { standard_us, express_us })
        }
        AnswerKind::AdapterFlags => {
            Answer::AdapterFlags(u32::from_le_bytes(*bytes.first_chunk::<4>()?))
        }
        AnswerKind::Nodes => return None,
    };
    let (len, _) = kind.facts();
    Some((answer, len as usize))
}

#[cfg(test)]
mod tests;
