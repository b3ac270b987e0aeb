//! Frames of a stream: written by the robot, found by its client in bytes that may be cut anywhere and carry noise.

use super::{Readings, data_len};
use crate::search::{Found, Search};

/// First byte of a frame.
pub const STREAM_HEADER: u8 = 19;

/// Longest frame: as much as 15 ms carry at 115 200 baud. Of more the robot sends no whole frames.
pub const FRAME_LEN_MAX: usize = 172;

/// Header, count and sum.
const OVERHEAD: usize = 3;

/// Bytes kept waiting at most. A caller who drains after each push never gets near it.
const PENDING_MAX: usize = 1 << 14;

/// Appends the frame with these packets. One that would be too long is cut, as the robot cuts it: it has no right
/// sum. Numbers that there are not are left out.
pub fn write_frame(ids: &[u8], readings: &Readings, out: &mut Vec<u8>) {
    let begin = out.len();
    out.extend_from_slice(&[STREAM_HEADER, 0]);
    for &id in ids {
        if data_len(id).is_some() {
            out.push(id);
            readings.write(id, out);
        }
    }
    let n_bytes = out.len().saturating_sub(begin).saturating_sub(2);
    if let Some(count) = out.get_mut(begin.saturating_add(1)) {
        // Beyond 255 the frame is cut below anyway.
        *count = n_bytes as u8;
    }
    let sum = out.get(begin..).unwrap_or_default().iter().fold(0_u8, |sum, b| sum.wrapping_add(*b));
    out.push(sum.wrapping_neg());
    out.truncate(begin.saturating_add(FRAME_LEN_MAX));
}

/// One frame, whose sum was right and whose packets are all known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What it says.
    pub readings: Readings,
    /// Its length with header and sum, bytes.
    pub n_bytes: usize,
}

/// Finds frames in received bytes.
///
/// Feed it with [`push`](Self::push), then take frames until [`next_frame`](Self::next_frame) gives `None`. How the
/// bytes were cut makes no difference. After a wrong sum only the header is given up, so a good frame that a damaged
/// one seemed to swallow is still found.
///
/// Cost: at most 172 steps per received byte; at most 171 bytes stay behind between calls.
#[derive(Clone, Debug)]
pub struct StreamDecoder {
    search: Search,
    noise: Noise,
}

/// What looked like a frame and was none.
#[derive(Clone, Copy, Debug, Default)]
struct Noise {
    bad_sums: u64,
    n_unreadable: u64,
}

impl Default for StreamDecoder {
    fn default() -> Self {
        Self::new()
    }
}

impl StreamDecoder {
    /// A decoder that has room for a usual burst of bytes already.
    pub fn new() -> Self {
        Self { search: Search::keeping(PENDING_MAX), noise: Noise::default() }
    }

    /// Appends received bytes. Of more than 16 384 bytes not yet asked for, the oldest are dropped
    /// and counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole frame, or `None` until more bytes come.
    pub fn next_frame(&mut self) -> Option<Frame> {
        let noise = &mut self.noise;
        self.search.next(|byte| byte == STREAM_HEADER, |bytes| examine(bytes, noise))
    }

    /// Gives up the frame that began but did not end; call it when the line has been silent for longer than a frame
    /// takes.
    pub fn give_up_unfinished(&mut self) {
        self.search.give_up_unfinished();
    }

    /// Whether a frame has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        self.search.has_unfinished()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.search.clear();
    }

    /// Bytes thrown away as noise so far, answers without a frame among them.
    pub fn bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Frames whose sum was wrong so far, including noise that looked like a header.
    pub fn bad_sums(&self) -> u64 {
        self.noise.bad_sums
    }

    /// Frames with a right sum so far whose packets are not known.
    pub fn n_unreadable(&self) -> u64 {
        self.noise.n_unreadable
    }

    #[cfg(test)]
    pub(crate) fn n_unread(&self) -> usize {
        self.search.unread().len()
    }
}

/// What `bytes`, which begins with the header, begins with.
fn examine(bytes: &[u8], noise: &mut Noise) -> Found<Frame> {
    let Some(&count) = bytes.get(1) else { return Found::Unfinished };
    let n_bytes = usize::from(count).saturating_add(OVERHEAD);
    // An id and a byte of data at least.
    if count < 2 || n_bytes > FRAME_LEN_MAX {
        return Found::Noise;
    }
    let Some(frame) = bytes.get(..n_bytes) else { return Found::Unfinished };
    if frame.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) != 0 {
        noise.bad_sums = noise.bad_sums.saturating_add(1);
        return Found::Noise;
    }
    let mut readings = Readings::default();
    let mut rest = frame.get(2..n_bytes.saturating_sub(1)).unwrap_or_default();
    while let Some((&id, data)) = rest.split_first() {
        let Some(behind) = readings.read(id, data) else {
            noise.n_unreadable = noise.n_unreadable.saturating_add(1);
            return Found::Noise;
        };
        rest = behind;
    }
    Found::Whole(Frame { readings, n_bytes }, n_bytes)
}
