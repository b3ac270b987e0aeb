//! Finding packets in a byte stream that may be cut anywhere and may carry noise.

use super::{COUNT_MAX, HEADER, checksum};
use crate::search::{Found, Search};

/// Shortest count: one body byte and the checksum.
const COUNT_MIN: u8 = 3;

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
#[derive(Clone, Debug)]
pub struct Decoder {
    search: Search,
    noise: Noise,
}

/// What looked like a packet and was none.
#[derive(Clone, Copy, Debug, Default)]
struct Noise {
    bad_checksums: u64,
    impossible_counts: u64,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that has room for a usual burst of bytes already.
    pub fn new() -> Self {
        Self { search: Search::new(), noise: Noise::default() }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped
    /// and counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole packet, or `None` until more bytes come.
    pub fn next_packet(&mut self) -> Option<Packet> {
        let noise = &mut self.noise;
        self.search.next(|byte| byte == HEADER[0], |bytes| examine(bytes, noise))
    }

    /// Gives up the packet that began but did not end, so that whatever good packets hide behind
    /// its header can be found by [`next_packet`](Self::next_packet).
    ///
    /// Call it when the line has been silent for longer than a packet takes: a damaged count
    /// would otherwise make the decoder wait for bytes that never come.
    pub fn give_up_unfinished(&mut self) {
        self.search.give_up_unfinished();
    }

    /// Whether a packet has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        self.search.has_unfinished()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.search.clear();
    }

    /// Bytes thrown away as noise so far; a measure of link quality.
    pub fn bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Packets whose checksum was wrong so far, including noise that looked like a header.
    pub fn bad_checksums(&self) -> u64 {
        self.noise.bad_checksums
    }

    /// Headers whose count was impossible (under 3 or over 200) so far.
    pub fn impossible_counts(&self) -> u64 {
        self.noise.impossible_counts
    }

    #[cfg(test)]
    pub(super) fn capacity(&self) -> usize {
        self.search.capacity()
    }

    #[cfg(test)]
    pub(crate) fn n_unread(&self) -> usize {
        self.search.unread().len()
    }
}

/// What `bytes`, which begins with the first header byte, begins with.
fn examine(bytes: &[u8], noise: &mut Noise) -> Found<Packet> {
    match bytes.get(1) {
        None => return Found::Unfinished,
        Some(&second) if second != HEADER[1] => return Found::Noise,
        Some(_) => {}
    }
    let Some(&count) = bytes.get(2) else { return Found::Unfinished };
    if !(COUNT_MIN..=COUNT_MAX).contains(&count) {
        noise.impossible_counts = noise.impossible_counts.saturating_add(1);
        return Found::Noise;
    }
    let rest = bytes.get(3..).unwrap_or_default();
    let Some((body, sum)) = rest.get(..usize::from(count)).and_then(<[u8]>::split_last_chunk::<2>)
    else {
        return Found::Unfinished;
    };
    if checksum(body) != u16::from_be_bytes(*sum) {
        noise.bad_checksums = noise.bad_checksums.saturating_add(1);
        return Found::Noise;
    }
    let mut packet = Packet { bytes: [0; COUNT_MAX as usize], len: count.saturating_sub(2) };
    if let Some(place) = packet.bytes.get_mut(..body.len()) {
        place.copy_from_slice(body);
    }
    // Header and count stand before what is counted.
    Found::Whole(packet, usize::from(count).saturating_add(3))
}
