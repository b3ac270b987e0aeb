//! Finding packets in a byte stream that may be cut anywhere and may carry noise.

use super::{COUNT_MAX, HEADER, checksum};

/// Shortest count: one body byte and the checksum.
const COUNT_MIN: u8 = 3;

/// Bytes kept waiting at most. A caller who drains after each push never gets near it.
const PENDING_MAX: usize = 1 << 16;

/// Read bytes are dropped from the buffer's front once there are this many.
const COMPACT_AT: usize = 4096;

/// The body of one packet, checksum verified.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Packet {
    bytes: [u8; COUNT_MAX as usize],
    len: u8,
}

impl Packet {
    /// The body: a command number or report type, then its fields.
    pub fn body(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }
}

impl std::fmt::Debug for Packet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Packet({:02x?})", self.body())
    }
}

/// Finds packets in received bytes.
///
/// Feed it with [`push`](Self::push), then take packets until [`next_packet`](Self::next_packet)
/// gives `None`. How the bytes were cut makes no difference. After a bad checksum only the header's
/// first byte is given up, so a good packet that a damaged one seemed to swallow is still found.
///
/// Cost: at most 200 steps per received byte; at most 202 bytes stay behind between calls.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    pending: Vec<u8>,
    start: usize,
    bytes_skipped: u64,
    bad_checksums: u64,
    impossible_counts: u64,
}

impl Decoder {
    /// A decoder that has room for a usual burst of bytes already.
    pub fn new() -> Self {
        Self { pending: Vec::with_capacity(2 * COMPACT_AT), ..Self::default() }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped
    /// and counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.start >= COMPACT_AT {
            self.pending.drain(..self.start);
            self.start = 0;
        }
        let excess = bytes.len().saturating_sub(PENDING_MAX);
        self.bytes_skipped = self.bytes_skipped.saturating_add(excess as u64);
        self.pending.extend_from_slice(bytes.get(excess..).unwrap_or_default());
        self.skip(self.unread().len().saturating_sub(PENDING_MAX));
    }

    /// The next whole packet, or `None` until more bytes come.
    pub fn next_packet(&mut self) -> Option<Packet> {
        loop {
            let start = self.unread().iter().position(|&byte| byte == HEADER[0]);
            self.skip(start.unwrap_or(self.unread().len()));
            match examine(self.unread()) {
                Found::Nothing => {
                    if self.unread().is_empty() {
                        self.pending.clear();
                        self.start = 0;
                    }
                    return None;
                }
                Found::Packet(packet) => {
                    self.start =
                        self.start.saturating_add(usize::from(packet.len)).saturating_add(5);
                    return Some(packet);
                }
                Found::Noise(noise) => {
                    match noise {
                        Noise::StrayHeader => {}
                        Noise::Count => {
                            self.impossible_counts = self.impossible_counts.saturating_add(1);
                        }
                        Noise::Checksum => {
                            self.bad_checksums = self.bad_checksums.saturating_add(1);
                        }
                    }
                    self.skip(1);
                }
            }
        }
    }

    /// Gives up the packet that began but did not end, so that whatever good packets hide behind
    /// its header can be found by [`next_packet`](Self::next_packet).
    ///
    /// Call it when the line has been silent for longer than a packet takes: a damaged count
    /// would otherwise make the decoder wait for bytes that never come.
    pub fn give_up_unfinished(&mut self) {
        if !self.unread().is_empty() {
            self.skip(1);
        }
    }

    /// Whether a packet has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        !self.unread().is_empty()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.pending.clear();
        self.start = 0;
    }

    /// Bytes thrown away as noise so far; a measure of link quality.
    pub fn bytes_skipped(&self) -> u64 {
        self.bytes_skipped
    }

    /// Packets whose checksum was wrong so far, including noise that looked like a header.
    pub fn bad_checksums(&self) -> u64 {
        self.bad_checksums
    }

    /// Headers whose count was impossible (under 3 or over 200) so far.
    pub fn impossible_counts(&self) -> u64 {
        self.impossible_counts
    }

    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.pending.capacity()
    }

    fn unread(&self) -> &[u8] {
        self.pending.get(self.start..).unwrap_or_default()
    }

    fn skip(&mut self, n: usize) {
        self.bytes_skipped = self.bytes_skipped.saturating_add(n as u64);
        self.start = self.start.saturating_add(n).min(self.pending.len());
    }
}

enum Found {
    Packet(Packet),
    Nothing,
    Noise(Noise),
}

enum Noise {
    StrayHeader,
    Count,
    Checksum,
}

/// What `bytes`, which is empty or begins with the first header byte, begins with.
fn examine(bytes: &[u8]) -> Found {
    match bytes.get(1) {
        None => return Found::Nothing,
        Some(&second) if second != HEADER[1] => return Found::Noise(Noise::StrayHeader),
        Some(_) => {}
    }
    let Some(&count) = bytes.get(2) else { return Found::Nothing };
    if !(COUNT_MIN..=COUNT_MAX).contains(&count) {
        return Found::Noise(Noise::Count);
    }
    let rest = bytes.get(3..).unwrap_or_default();
    let Some((body, sum)) = rest.get(..usize::from(count)).and_then(<[u8]>::split_last_chunk::<2>)
    else {
        return Found::Nothing;
    };
    if checksum(body) != u16::from_be_bytes(*sum) {
        return Found::Noise(Noise::Checksum);
    }
    let mut packet = Packet { bytes: [0; COUNT_MAX as usize], len: count.saturating_sub(2) };
    if let Some(place) = packet.bytes.get_mut(..body.len()) {
        place.copy_from_slice(body);
    }
    Found::Packet(packet)
}
