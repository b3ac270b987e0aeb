//! Finding telegrams, and the bare bytes before them, in a byte stream that may be cut anywhere and may carry
//! noise.

use super::{ACK, FRAME_LEN, FROM_DEVICE, NAK, PAYLOAD_MAX, STX, checksum, u16_at};
use crate::search::{Found, Search};

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
    search: Search,
    payload: Vec<u8>,
    n_telegrams: u64,
    n_bad_checksums: u64,
    n_unfinished: u64,
}

/// What was found; a telegram's payload is kept beside it.
enum Kind {
    Bare(u8),
    Telegram { address: u8 },
}

impl Decoder {
    /// A decoder that has heard nothing.
    pub fn new(side: Side) -> Self {
        Self {
            side,
            search: Search::new(),
            payload: Vec::with_capacity(PAYLOAD_MAX),
            n_telegrams: 0,
            n_bad_checksums: 0,
            n_unfinished: 0,
        }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped and
    /// counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole telegram or bare byte, or `None` until more bytes come.
    pub fn next_item(&mut self) -> Option<Item<'_>> {
        let Self { side, search, payload, n_bad_checksums, .. } = self;
        let side = *side;
        let begins = |byte| byte == STX || is_bare(side, byte);
        match search.next(begins, |bytes| examine(bytes, side, payload, n_bad_checksums))? {
            Kind::Bare(byte) => Some(if byte == ACK { Item::Ack } else { Item::Nak }),
            Kind::Telegram { address } => {
                self.n_telegrams = self.n_telegrams.saturating_add(1);
                Some(Item::Telegram { address, payload: &self.payload })
            }
        }
    }

    /// Gives up the telegram that began and did not end; says whether there was one. Call it when the
    /// line has been silent: a damaged length would otherwise hide what follows.
    pub fn give_up_unfinished(&mut self) -> bool {
        let is_one = self.search.give_up_unfinished();
        self.n_unfinished = self.n_unfinished.saturating_add(u64::from(is_one));
        is_one
    }

    /// Whether a telegram has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        self.search.has_unfinished()
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.search.skip_all();
    }

    /// Telegrams so far.
    pub fn n_telegrams(&self) -> u64 {
        self.n_telegrams
    }

    /// Bytes thrown away as noise so far.
    pub fn n_bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Telegrams whose checksum was wrong so far, including noise that looked like a beginning.
    pub fn n_bad_checksums(&self) -> u64 {
        self.n_bad_checksums
    }

    /// Telegrams that were given up half way so far.
    pub fn n_unfinished(&self) -> u64 {
        self.n_unfinished
    }

    #[cfg(test)]
    pub(crate) fn n_unread(&self) -> usize {
        self.search.unread().len()
    }
}

/// Whether the byte stands for itself.
fn is_bare(side: Side, byte: u8) -> bool {
    side == Side::FromDevice && matches!(byte, ACK | NAK)
}

/// What the bytes begin with; a telegram's payload is copied.
fn examine(
    bytes: &[u8],
    side: Side,
    payload: &mut Vec<u8>,
    n_bad_checksums: &mut u64,
) -> Found<Kind> {
    let Some(&first) = bytes.first() else { return Found::Unfinished };
    if is_bare(side, first) {
        return Found::Whole(Kind::Bare(first), 1);
    }
    let Some(&address) = bytes.get(1) else { return Found::Unfinished };
    let from_device = address & FROM_DEVICE != 0;
    if from_device != (side == Side::FromDevice) {
        return Found::Noise;
    }
    let Some(len) = u16_at(bytes, 2) else { return Found::Unfinished };
    let len = usize::from(len);
    if !(1..=PAYLOAD_MAX).contains(&len) {
        return Found::Noise;
    }
    let n_bytes = len.saturating_add(FRAME_LEN);
    let whole = bytes.get(..n_bytes).and_then(<[u8]>::split_last_chunk::<2>);
    let Some((body, crc)) = whole else { return Found::Unfinished };
    if checksum(body) != u16::from_le_bytes(*crc) {
        *n_bad_checksums = n_bad_checksums.saturating_add(1);
        return Found::Noise;
    }
    payload.clear();
    payload.extend_from_slice(body.get(4..).unwrap_or_default());
    Found::Whole(Kind::Telegram { address }, n_bytes)
}
