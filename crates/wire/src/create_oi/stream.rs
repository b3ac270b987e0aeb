//! Frames of a stream: written by the robot, found by its client in bytes that may be cut anywhere and carry noise.

use super::{Readings, data_len};

/// First byte of a frame.
pub const STREAM_HEADER: u8 = 19;

/// Longest frame: as much as 15 ms carry at 115 200 baud. Of more the robot sends no whole frames.
pub const FRAME_LEN_MAX: usize = 172;

/// Header, count and sum.
const OVERHEAD: usize = 3;

/// Bytes kept waiting at most. A caller who drains after each push never gets near it.
const PENDING_MAX: usize = 1 << 14;

/// Read bytes are dropped from the buffer's front once there are this many.
const COMPACT_AT: usize = 2048;

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
#[derive(Clone, Debug, Default)]
pub struct StreamDecoder {
    pending: Vec<u8>,
    start: usize,
    bytes_skipped: u64,
    bad_sums: u64,
    n_unreadable: u64,
}

impl StreamDecoder {
    /// A decoder that has room for a usual burst of bytes already.
    pub fn new() -> Self {
        Self { pending: Vec::with_capacity(2 * COMPACT_AT), ..Self::default() }
    }

    /// Appends received bytes. Of more than 16 384 bytes not yet asked for, the oldest are dropped
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

    /// The next whole frame, or `None` until more bytes come.
    pub fn next_frame(&mut self) -> Option<Frame> {
        loop {
            let start = self.unread().iter().position(|&byte| byte == STREAM_HEADER);
            self.skip(start.unwrap_or(self.unread().len()));
            match examine(self.unread()) {
                Ok(None) => {
                    if self.unread().is_empty() {
                        self.pending.clear();
                        self.start = 0;
                    }
                    return None;
                }
                Ok(Some(frame)) => {
                    self.start = self.start.saturating_add(frame.n_bytes);
                    return Some(frame);
                }
                Err(noise) => {
                    match noise {
                        Noise::Count => {}
                        Noise::Sum => self.bad_sums = self.bad_sums.saturating_add(1),
                        Noise::Packets => self.n_unreadable = self.n_unreadable.saturating_add(1),
                    }
                    self.skip(1);
                }
            }
        }
    }

    /// Gives up the frame that began but did not end; call it when the line has been silent for longer than a frame
    /// takes.
    pub fn give_up_unfinished(&mut self) {
        if !self.unread().is_empty() {
            self.skip(1);
        }
    }

    /// Whether a frame has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        !self.unread().is_empty()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.pending.clear();
        self.start = 0;
    }

    /// Bytes thrown away as noise so far, answers without a frame among them.
    pub fn bytes_skipped(&self) -> u64 {
        self.bytes_skipped
    }

    /// Frames whose sum was wrong so far, including noise that looked like a header.
    pub fn bad_sums(&self) -> u64 {
        self.bad_sums
    }

    /// Frames with a right sum so far whose packets are not known.
    pub fn n_unreadable(&self) -> u64 {
        self.n_unreadable
    }

    fn unread(&self) -> &[u8] {
        self.pending.get(self.start..).unwrap_or_default()
    }

    fn skip(&mut self, n: usize) {
        self.bytes_skipped = self.bytes_skipped.saturating_add(n as u64);
        self.start = self.start.saturating_add(n).min(self.pending.len());
    }
}

enum Noise {
    Count,
    Sum,
    Packets,
}

/// The frame that `bytes`, which is empty or begins with the header, begins with; `None` until there are more of them.
fn examine(bytes: &[u8]) -> Result<Option<Frame>, Noise> {
    let Some(&count) = bytes.get(1) else { return Ok(None) };
    let n_bytes = usize::from(count).saturating_add(OVERHEAD);
    // An id and a byte of data at least.
    if count < 2 || n_bytes > FRAME_LEN_MAX {
        return Err(Noise::Count);
    }
    let Some(frame) = bytes.get(..n_bytes) else { return Ok(None) };
    if frame.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) != 0 {
        return Err(Noise::Sum);
    }
    let mut readings = Readings::default();
    let mut rest = frame.get(2..n_bytes.saturating_sub(1)).unwrap_or_default();
    while let Some((&id, data)) = rest.split_first() {
        rest = readings.read(id, data).ok_or(Noise::Packets)?;
    }
    Ok(Some(Frame { readings, n_bytes }))
}
