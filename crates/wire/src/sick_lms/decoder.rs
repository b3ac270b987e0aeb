//! Finding telegrams, and the bare bytes before them, in a byte stream that may be cut anywhere and may carry
//! noise.

use super::{ACK, FRAME_LEN, FROM_DEVICE, NAK, PAYLOAD_MAX, STX, checksum, u16_at};
use crate::pending::Pending;

/// Whose bytes are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The host's: no bare bytes, addresses below 0x80.
    FromHost,
    /// The device's.
    FromDevice,
}

/// Something whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item<'a> {
    /// A telegram with a right checksum.
    Telegram {
        /// Address byte as sent.
        address: u8,
        /// Command, fields and, from a device, the status byte.
        payload: &'a [u8],
    },
    /// The device accepts what it was sent.
    Ack,
    /// The device was sent a telegram with a wrong checksum.
    Nak,
}

/// Finds telegrams in received bytes.
///
/// After a wrong checksum only the STX is given up, so a good telegram that a damaged one seemed to
/// swallow is still found; bytes in the midst of such a telegram may look like a bare `06` or `15`.
///
/// Cost: a telegram's length per STX among the received bytes; at most 818 bytes stay behind between
/// calls.
#[derive(Clone, Debug)]
pub struct Decoder {
    side: Side,
    pending: Pending,
    payload: Vec<u8>,
    n_telegrams: u64,
    n_bytes_skipped: u64,
    n_bad_checksums: u64,
    n_unfinished: u64,
}

enum Found {
    Nothing,
    Noise,
    BadChecksum,
    Bare(u8),
    Telegram { address: u8 },
}

impl Decoder {
    /// A decoder that has heard nothing.
    pub fn new(side: Side) -> Self {
        Self {
            side,
            pending: Pending::new(),
            payload: Vec::with_capacity(PAYLOAD_MAX),
            n_telegrams: 0,
            n_bytes_skipped: 0,
            n_bad_checksums: 0,
            n_unfinished: 0,
        }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped and
    /// counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        let n_dropped = self.pending.push(bytes);
        self.n_bytes_skipped = self.n_bytes_skipped.saturating_add(n_dropped as u64);
    }

    /// The next whole telegram or bare byte, or `None` until more bytes come.
    pub fn next_item(&mut self) -> Option<Item<'_>> {
        loop {
            match self.examine() {
                Found::Nothing => return None,
                Found::Noise => self.skip(1),
                Found::BadChecksum => {
                    self.n_bad_checksums = self.n_bad_checksums.saturating_add(1);
                    self.skip(1);
                }
                Found::Bare(byte) => {
                    self.pending.skip(1);
                    return Some(if byte == ACK { Item::Ack } else { Item::Nak });
                }
                Found::Telegram { address } => {
                    self.n_telegrams = self.n_telegrams.saturating_add(1);
                    self.pending.skip(self.payload.len().saturating_add(FRAME_LEN));
                    return Some(Item::Telegram { address, payload: &self.payload });
                }
            }
        }
    }

    /// Gives up the telegram that began and did not end; says whether there was one. Call it when the
    /// line has been silent: a damaged length would otherwise hide what follows.
    pub fn give_up_unfinished(&mut self) -> bool {
        let is_one = self.has_unfinished();
        if is_one {
            self.n_unfinished = self.n_unfinished.saturating_add(1);
            self.skip(1);
        }
        is_one
    }

    /// Whether a telegram has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        !self.pending.unread().is_empty()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.skip(self.pending.unread().len());
    }

    /// Telegrams so far.
    pub fn n_telegrams(&self) -> u64 {
        self.n_telegrams
    }

    /// Bytes thrown away as noise so far.
    pub fn n_bytes_skipped(&self) -> u64 {
        self.n_bytes_skipped
    }

    /// Telegrams whose checksum was wrong so far, including noise that looked like a beginning.
    pub fn n_bad_checksums(&self) -> u64 {
        self.n_bad_checksums
    }

    /// Telegrams that were given up half way so far.
    pub fn n_unfinished(&self) -> u64 {
        self.n_unfinished
    }

    /// What the bytes begin with; a telegram's payload is copied.
    fn examine(&mut self) -> Found {
        let bytes = self.pending.unread();
        let Some(&first) = bytes.first() else { return Found::Nothing };
        if self.side == Side::FromDevice && matches!(first, ACK | NAK) {
            return Found::Bare(first);
        }
        if first != STX {
            return Found::Noise;
        }
        let Some(&address) = bytes.get(1) else { return Found::Nothing };
        let from_device = address & FROM_DEVICE != 0;
        if from_device != (self.side == Side::FromDevice) {
            return Found::Noise;
        }
        let Some(len) = u16_at(bytes, 2) else { return Found::Nothing };
        let len = usize::from(len);
        if !(1..=PAYLOAD_MAX).contains(&len) {
            return Found::Noise;
        }
        let Some(whole) = bytes.get(..len.saturating_add(FRAME_LEN)) else {
            return Found::Nothing;
        };
        let Some((body, crc)) = whole.split_last_chunk::<2>() else { return Found::Nothing };
        if checksum(body) != u16::from_le_bytes(*crc) {
            return Found::BadChecksum;
        }
        self.payload.clear();
        self.payload.extend_from_slice(body.get(4..).unwrap_or_default());
        Found::Telegram { address }
    }

    fn skip(&mut self, n: usize) {
        self.n_bytes_skipped = self.n_bytes_skipped.saturating_add(n as u64);
        self.pending.skip(n);
    }
}
