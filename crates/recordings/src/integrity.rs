//! Whether every byte of an MCAP file is as it was written.
//!
//! A file that was finished is covered from its first byte to its last: the data section by the checksum in its
//! `Data End` record, the summary and the footer by the footer's, and those two records, of which only the
//! checksums themselves are covered by nothing, by having one possible form. A file that was not finished has no
//! such records; cairn writes a *check record* after every chunk, which holds the checksum of everything before it, so
//! that what a killed program left is covered up to its last check record. Other tools pass over it: its opcode is one of
//! those that the format keeps for applications.
//!
//! | check record | bytes |
//! | --- | --- |
//! | opcode 0xC5, length 16 | 1 + 8 |
//! | bytes before this record | 8, little endian |
//! | CRC-32 of them | 4, little endian |
//! | `crc1` | 4 |
//!
//! A CRC-32 finds every change within 32 neighbouring bits.
//!
//! Source: MCAP format specification, <https://mcap.dev/spec> (records `Header` 0x01, `Footer` 0x02, `Chunk` 0x06,
//! `Data End` 0x0F; opcodes from 0x80 are free for applications).

use std::ops::Range;

use crate::mcap_records::{CHUNK, DATA_END, Fields, MAGIC, RECORD_HEAD};

/// Opcode of a check record.
pub const CHECK_OPCODE: u8 = 0xC5;
const CHECK_MARK: &[u8; 4] = b"crc1";
/// How the name of the library in the header ends when a file has check records.
pub const LIBRARY_MARK: &str = " with check records";
/// The header, which names the library, is within these first bytes.
const FRONT_BYTES: usize = 512;
const CHECK_BYTES: u64 = 16;
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
/// Two places and a checksum.
const FOOTER_BYTES: usize = 20;
const DATA_END_BYTES: usize = 4;
/// Places of damage that are named.
const DAMAGE_MAX: usize = 8;

/// The content of a check record after `n_bytes` of a file whose CRC-32 is `crc`.
pub fn check_record(n_bytes: u64, crc: u32) -> [u8; CHECK_BYTES as usize] {
    let mut content = [0; CHECK_BYTES as usize];
    content[..8].copy_from_slice(&n_bytes.to_le_bytes());
    content[8..12].copy_from_slice(&crc.to_le_bytes());
    content[12..].copy_from_slice(CHECK_MARK);
    content
}

/// A part of a file that is not as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it is, as closely as that can be told.
    pub bytes: Range<usize>,
    /// What shows it.
    pub found: String,
}

impl std::fmt::Display for Damage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (bytes {} to {})", self.found, self.bytes.start, self.bytes.end)
    }
}

/// How much of a file can be relied on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Integrity {
    /// Whether the file has its end: it was finished, and its last bytes are there.
    pub finished: bool,
    /// Bytes from the beginning that are covered by checksums which hold.
    pub n_verified: usize,
    /// Whether it has check records.
    pub has_checks: bool,
    /// What is not as it was written. Empty for a file that was cut off between two check records.
    pub damage: Vec<Damage>,
}

impl Integrity {
    /// Looks at every byte. Cost: linear in the size.
    pub fn of(bytes: &[u8]) -> Self {
        let mut found =
            Self { finished: false, n_verified: 0, has_checks: false, damage: Vec::new() };
        if !bytes.starts_with(MAGIC) {
            found.say(0..MAGIC.len().min(bytes.len()), "the file does not begin as an MCAP file");
            return found;
        }
        let tail = Tail::of(bytes);
        found.finished = tail.is_some();
        let end = tail.as_ref().map_or(bytes.len(), |tail| tail.data_end);
        let walked = found.walk(&bytes[..end]);
        // A damaged length derails the walk before it comes by a check record; the mark of their writer is there still.
        let front = &bytes[..end.min(FRONT_BYTES)];
        found.has_checks |= front.windows(LIBRARY_MARK.len()).any(|w| w == LIBRARY_MARK.as_bytes());
        if !walked.has_header {
            found.say(0..bytes.len(), "the file has no header");
        }
        match tail {
            Some(tail) => found.judge_tail(bytes, &tail),
            None if found.has_checks
                && found.n_verified < bytes.len()
                && found.damage.is_empty() =>
            {
                let rest = found.n_verified..bytes.len();
                found.say(rest, "the end of the file is damaged or was not written whole: no checksum holds there");
            }
            None if !found.has_checks && walked.ends => {
                found.say(end..end, "the file has the form of a finished one, but not its end");
            }
            None => {}
        }
        found
    }

    fn say(&mut self, bytes: Range<usize>, found: &str) {
        if self.damage.len() < DAMAGE_MAX {
            self.damage.push(Damage { bytes, found: found.to_owned() });
        }
    }

    /// The records of the data section.
    fn walk(&mut self, bytes: &[u8]) -> Walked {
        let mut walked = Walked { has_header: false, ends: false };
        let mut crc = flate2::Crc::new();
        let (mut at, mut summed) = (MAGIC.len(), 0);
        let mut holds = true;
        loop {
            let mut head = Fields { bytes, at };
            let (Some(opcode), Some(length)) = (head.u8(), head.u64()) else { return walked };
            let start = at + RECORD_HEAD;
            let next = usize::try_from(length).ok().and_then(|n| start.checked_add(n));
            let Some(next) = next.filter(|&next| next <= bytes.len()) else { return walked };
            let body = &bytes[start..next];
            match opcode {
                CHECK_OPCODE if length == CHECK_BYTES && body.ends_with(CHECK_MARK) => {
                    crc.update(&bytes[summed..at]);
                    summed = at;
                    self.has_checks = true;
                    if body == check_record(at as u64, crc.sum()) {
                        if holds {
                            self.n_verified = next;
                        }
                    } else if holds {
                        // Everything after it is covered together with what is wrong here.
                        holds = false;
                        self.say(
                            self.n_verified..next,
                            "the checksum of everything so far differs",
                        );
                    }
                }
                HEADER if at == MAGIC.len() => {
                    walked.has_header = true;
                    let mut fields = Fields { bytes: body, at: 0 };
                    let library = fields.string().and_then(|_profile| fields.string());
                    self.has_checks |=
                        library.is_some_and(|library| library.ends_with(LIBRARY_MARK));
                }
                CHUNK => self.look_at_chunk(body, start),
                DATA_END => walked.ends = true,
                _ => {}
            }
            at = next;
        }
    }

    fn look_at_chunk(&mut self, body: &[u8], start: usize) {
        let mut head = Fields { bytes: body, at: 0 };
        let parsed = (|| {
            head.skip(24)?;
            let crc = head.u32()?;
            let compression = head.string()?;
            let size = usize::try_from(head.u64()?).ok()?;
            Some((crc, compression.is_empty(), size, head.at))
        })();
        let Some((crc, is_plain, size, head_bytes)) = parsed else {
            self.say(start..start + body.len(), "the head of a chunk makes no sense");
            return;
        };
        let records = &body[head_bytes..];
        if crc == 0 || !is_plain {
            return;
        }
        let mut sum = flate2::Crc::new();
        sum.update(records);
        if size != records.len() || sum.sum() != crc {
            self.say(start..start + body.len(), "the checksum of a chunk differs");
        }
    }

    fn judge_tail(&mut self, bytes: &[u8], tail: &Tail) {
        let sum = |range: Range<usize>| {
            let mut crc = flate2::Crc::new();
            crc.update(&bytes[range]);
            crc.sum()
        };
        // Foreign writers may leave a checksum out, which zero says; cairn never does.
        let differs = |stated: u32, found: u32| stated != found && (stated != 0 || self.has_checks);
        let data_differs = differs(tail.data_crc, sum(0..tail.data_end));
        let summary_differs = differs(tail.summary_crc, sum(tail.summary..tail.footer_crc_at));
        let has_sums = tail.data_crc != 0 && tail.summary_crc != 0;
        if data_differs {
            if self.damage.is_empty() {
                // The checksum itself may be what changed.
                let end = tail.data_end + RECORD_HEAD + DATA_END_BYTES;
                self.say(self.n_verified..end, "the checksum of the data differs");
            }
        } else if has_sums {
            self.n_verified = tail.data_end;
        }
        if summary_differs {
            self.say(tail.summary..bytes.len(), "the checksum of the summary differs");
        } else if !data_differs && has_sums {
            self.n_verified = bytes.len();
        }
    }
}

/// What stands among the records.
struct Walked {
    has_header: bool,
    /// Whether there is a `Data End`, as in a file that was finished.
    ends: bool,
}

/// The end of a finished file.
struct Tail {
    /// Where the `Data End` record begins.
    data_end: usize,
    data_crc: u32,
    /// Where the summary begins, or the footer when there is none.
    summary: usize,
    footer_crc_at: usize,
    summary_crc: u32,
}

impl Tail {
    /// `None` when the file does not end with a footer and the end mark, or there is no `Data End` where it must be.
    fn of(bytes: &[u8]) -> Option<Self> {
        let before_mark = bytes.strip_suffix(MAGIC)?;
        let footer = before_mark.len().checked_sub(RECORD_HEAD + FOOTER_BYTES)?;
        let mut fields = Fields { bytes: before_mark, at: footer };
        (fields.u8()? == FOOTER && fields.u64()? == FOOTER_BYTES as u64).then_some(())?;
        let summary_start = usize::try_from(fields.u64()?).ok()?;
        fields.skip(8)?;
        let footer_crc_at = fields.at;
        let summary_crc = fields.u32()?;
        let summary = if summary_start == 0 { footer } else { summary_start };
        (summary <= footer).then_some(())?;
        let data_end = summary.checked_sub(RECORD_HEAD + DATA_END_BYTES)?;
        let mut fields = Fields { bytes: before_mark, at: data_end };
        (fields.u8()? == DATA_END && fields.u64()? == DATA_END_BYTES as u64).then_some(())?;
        let data_crc = fields.u32()?;
        Some(Self { data_end, data_crc, summary, footer_crc_at, summary_crc })
    }
}

#[cfg(test)]
#[path = "integrity_tests.rs"]
mod tests;
