//! Looking for frames in received bytes that may be cut anywhere and may carry noise.
//!
//! Every decoder here works alike: find a byte that can begin a frame, wait until the frame is whole, check it; where
//! it is none give up one byte and look again, so that a good frame which a damaged one seemed to swallow is still
//! found. This is written once; a decoder says how a frame begins and what a whole one is.

/// Bytes kept waiting at most, unless a decoder asks for fewer. A caller who drains after each push never gets near it.
const PENDING_MAX: usize = 1 << 16;

/// Read bytes are dropped from the buffer's front once they are this part of the most that may wait.
const COMPACT_PART: usize = 16;

/// What bytes begin with.
pub(crate) enum Found<T> {
    /// A frame, and its length in bytes.
    Whole(T, usize),
    /// Something that may become one.
    Unfinished,
    /// No frame.
    Noise,
}

/// Received bytes that no frame was made of yet, and how many never will be.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    bytes: Vec<u8>,
    start: usize,
    pending_max: usize,
    n_skipped: u64,
}

impl Search {
    /// At most 65 536 bytes wait.
    pub(crate) fn new() -> Self {
        Self::keeping(PENDING_MAX)
    }

    /// At most so many bytes wait. There is room for a usual burst already.
    pub(crate) fn keeping(pending_max: usize) -> Self {
        let bytes = Vec::with_capacity(pending_max / (COMPACT_PART / 2));
        Self { bytes, start: 0, pending_max, n_skipped: 0 }
    }

    /// Appends received bytes; of more than may wait the oldest are dropped and count as skipped.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        if self.start >= self.pending_max / COMPACT_PART {
            self.bytes.drain(..self.start);
            self.start = 0;
        }
        let n_waiting = self.unread().len();
        if n_waiting.saturating_add(bytes.len()) <= self.pending_max {
            self.bytes.extend_from_slice(bytes);
        } else {
            self.push_newest(bytes);
        }
    }

    /// Appends what may wait of too many bytes.
    #[cold]
    fn push_newest(&mut self, bytes: &[u8]) {
        let excess = bytes.len().saturating_sub(self.pending_max);
        self.n_skipped = self.n_skipped.saturating_add(excess as u64);
        self.bytes.extend_from_slice(bytes.get(excess..).unwrap_or_default());
        self.skip(self.unread().len().saturating_sub(self.pending_max));
    }

    /// The next frame, or `None` until more bytes come.
    ///
    /// `begins` says whether a byte can begin one, and `examine` what the bytes from such a one on begin with.
    #[inline]
    pub(crate) fn next<T>(
        &mut self,
        begins: impl Fn(u8) -> bool,
        mut examine: impl FnMut(&[u8]) -> Found<T>,
    ) -> Option<T> {
        loop {
            let unread = self.unread();
            if unread.is_empty() {
                return None;
            }
            let n_noise = unread.iter().position(|&byte| begins(byte)).unwrap_or(unread.len());
            if n_noise > 0 {
                self.skip(n_noise);
                continue;
            }
            match examine(unread) {
                Found::Whole(frame, len) => {
                    self.take(len);
                    return Some(frame);
                }
                Found::Unfinished => return None,
                Found::Noise => self.skip(1),
            }
        }
    }

    /// Gives up the frame that began and did not end, so that good ones behind its beginning can be found; says whether
    /// there was one. For a line that has been silent for longer than a frame takes: a damaged length would otherwise
    /// make the search wait for bytes that never come.
    pub(crate) fn give_up_unfinished(&mut self) -> bool {
        let is_one = self.has_unfinished();
        self.skip(usize::from(is_one));
        is_one
    }

    /// Whether a frame has begun and not ended.
    pub(crate) fn has_unfinished(&self) -> bool {
        !self.unread().is_empty()
    }

    /// The bytes that wait.
    #[inline]
    pub(crate) fn unread(&self) -> &[u8] {
        self.bytes.get(self.start..).unwrap_or_default()
    }

    /// The first `n` bytes were understood.
    #[inline]
    pub(crate) fn take(&mut self, n: usize) {
        self.start = self.start.saturating_add(n).min(self.bytes.len());
        if self.start == self.bytes.len() {
            self.clear();
        }
    }

    /// The first `n` bytes are noise.
    #[inline]
    pub(crate) fn skip(&mut self, n: usize) {
        self.n_skipped = self.n_skipped.saturating_add(n as u64);
        self.take(n);
    }

    /// Forgets the bytes that wait, uncounted.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.start = 0;
    }

    /// Forgets the bytes that wait; they count as skipped.
    pub(crate) fn skip_all(&mut self) {
        self.skip(self.unread().len());
    }

    /// Bytes thrown away as noise so far.
    pub(crate) fn n_skipped(&self) -> u64 {
        self.n_skipped
    }

    #[cfg(test)]
    pub(crate) fn capacity(&self) -> usize {
        self.bytes.capacity()
    }
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
