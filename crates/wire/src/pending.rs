//! Received bytes that a decoder has not taken apart yet, within bounds.

/// Bytes kept waiting at most. A caller who drains after each push never gets near it.
const PENDING_MAX: usize = 1 << 16;

/// Read bytes are dropped from the buffer's front once there are this many.
const COMPACT_AT: usize = 4096;

/// A queue of bytes that is read from the front in pieces.
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    bytes: Vec<u8>,
    start: usize,
}

impl Pending {
    pub(crate) fn new() -> Self {
        Self { bytes: Vec::with_capacity(2 * COMPACT_AT), start: 0 }
    }

    /// Appends bytes; of more than 65 536 the oldest are dropped. How many were.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> usize {
        if self.start >= COMPACT_AT {
            self.bytes.drain(..self.start);
            self.start = 0;
        }
        self.bytes.extend_from_slice(bytes);
        let excess = self.unread().len().saturating_sub(PENDING_MAX);
        self.skip(excess);
        excess
    }

    pub(crate) fn unread(&self) -> &[u8] {
        self.bytes.get(self.start..).unwrap_or_default()
    }

    pub(crate) fn skip(&mut self, n: usize) {
        self.start = self.start.saturating_add(n).min(self.bytes.len());
        if self.start == self.bytes.len() {
            self.clear();
        }
    }

    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.start = 0;
    }
}
