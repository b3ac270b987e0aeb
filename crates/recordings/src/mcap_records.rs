//! The messages of an MCAP file, whole, cut off or damaged.
//!
//! Reads what the recorder writes: records in chunks without compression, or without chunks. Unlike a reader
//! for files in good order it goes on into the last, unfinished chunk, whose length is not yet written;
//! so nothing that reached the disk is lost. Lengths in the file are compared with the bytes that are left
//! before anything is done with them; nothing is copied.
//!
//! Source: MCAP format specification, <https://mcap.dev/spec> (records `Channel` 0x04, `Message` 0x05,
//! `Chunk` 0x06, `Data End` 0x0F).

use std::collections::BTreeMap;

use crate::complaints::{Action, Complaints, Place, Trouble};

/// What an MCAP file begins and ends with.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
pub(crate) const CHUNK: u8 = 0x06;
pub(crate) const DATA_END: u8 = 0x0F;
/// Opcode and length.
pub(crate) const RECORD_HEAD: usize = 9;
/// Channel, sequence, two times.
const MESSAGE_HEAD: usize = 22;

/// A message and where its record begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// Its content.
    pub data: &'a [u8],
    /// Where its record begins.
    pub byte: usize,
}

/// The messages, in the order of the file; afterwards what was wrong.
#[derive(Debug)]
pub struct Messages<'a> {
    bytes: &'a [u8],
    /// Where the next record begins.
    at: usize,
    /// Ends of the chunk that is being read, if one is.
    chunk_end: Option<usize>,
    topics: BTreeMap<u16, &'a str>,
    ended: bool,
    troubles: Vec<(usize, Trouble, String)>,
}

/// Messages of the bytes of a file that begins with [`MAGIC`].
pub fn messages(bytes: &[u8]) -> Messages<'_> {
    Messages {
        bytes,
        at: MAGIC.len().min(bytes.len()),
        chunk_end: None,
        topics: BTreeMap::new(),
        ended: false,
        troubles: Vec::new(),
    }
}

impl Messages<'_> {
    /// Says what was wrong with the file, once it has been read to its end.
    pub(crate) fn complain(self, complaints: &mut Complaints) {
        for (byte, trouble, found) in self.troubles {
            let action = if trouble == Trouble::Damaged { Action::Kept } else { Action::Skipped };
            complaints.add(Place::Byte(byte), trouble, action, || found);
        }
    }

    fn end_early(&mut self, found: String) {
        self.troubles.push((self.at, Trouble::EndsEarly, found));
        self.ended = true;
    }

    /// Steps into a chunk whose body begins at `start`; `length` is what the file says of it.
    fn enter_chunk(&mut self, start: usize, length: u64) {
        let left = &self.bytes[start..];
        let mut head = Fields { bytes: left, at: 0 };
        let parsed = (|| {
            head.skip(24)?;
            let crc = head.u32()?;
            let compression = head.string()?;
            let size = head.u64()?;
            Some((crc, compression, size, head.at))
        })();
        let whole = usize::try_from(length).ok().filter(|&n| n <= left.len());
        let Some((crc, compression, size, head_length)) = parsed else {
            self.end_early("the file ends in the head of a chunk".to_owned());
            return;
        };
        if !compression.is_empty() {
            let found = format!("a chunk compressed with {}", crate::numbers::shown(compression));
            self.troubles.push((start, Trouble::NotSupported, found));
            match whole {
                Some(length) => self.at = start + length,
                None => self.end_early("the file ends in a compressed chunk".to_owned()),
            }
            return;
        }
        let body = &left[head_length..];
        self.at = start + head_length;
        let Some(size) = usize::try_from(size).ok().filter(|&n| n <= body.len()) else {
            // Unfinished: read as far as there is something.
            self.chunk_end = Some(self.bytes.len());
            return;
        };
        let mut sum = flate2::Crc::new();
        sum.update(&body[..size]);
        if crc != 0 && sum.sum() != crc {
            let found = "the checksum of a chunk differs".to_owned();
            self.troubles.push((start, Trouble::Damaged, found));
        }
        self.chunk_end = Some(self.at + size);
    }
}

impl<'a> Iterator for Messages<'a> {
    type Item = Message<'a>;

    fn next(&mut self) -> Option<Message<'a>> {
        while !self.ended {
            if self.chunk_end.is_some_and(|end| self.at >= end) {
                self.chunk_end = None;
            }
            let byte = self.at;
            let mut head = Fields { bytes: self.bytes, at: byte };
            let (Some(opcode), Some(length)) = (head.u8(), head.u64()) else {
                self.end_early("the file ends without an end record".to_owned());
                break;
            };
            let start = byte + RECORD_HEAD;
            if opcode == CHUNK && self.chunk_end.is_none() {
                self.enter_chunk(start, length);
                continue;
            }
            let end = self.chunk_end.unwrap_or(self.bytes.len());
            let Some(next) = usize::try_from(length)
                .ok()
                .and_then(|n| start.checked_add(n))
                .filter(|&n| n <= end)
            else {
                self.end_early(format!(
                    "a record of {length} bytes, {} are left",
                    end.saturating_sub(start)
                ));
                break;
            };
            self.at = next;
            let body = &self.bytes[start..next];
            match opcode {
                CHANNEL => {
                    let mut fields = Fields { bytes: body, at: 0 };
                    if let (Some(id), Some(_schema), Some(topic)) =
                        (fields.u16(), fields.u16(), fields.string())
                    {
                        self.topics.entry(id).or_insert(topic);
                    }
                }
                MESSAGE if body.len() >= MESSAGE_HEAD => {
                    let id = u16::from_le_bytes([body[0], body[1]]);
                    if let Some(topic) = self.topics.get(&id) {
                        return Some(Message { topic, data: &body[MESSAGE_HEAD..], byte });
                    }
                    let found = format!("a message on channel {id}, which was not announced");
                    self.troubles.push((byte, Trouble::NotSupported, found));
                }
                DATA_END if self.chunk_end.is_none() => self.ended = true,
                _ => {}
            }
        }
        None
    }
}

/// Takes little-endian fields off bytes; `None` where they end.
pub(crate) struct Fields<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
}

impl<'a> Fields<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(n)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    pub(crate) fn skip(&mut self, n: usize) -> Option<()> {
        self.take(n).map(|_| ())
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.take(1)?.first().copied()
    }

    fn u16(&mut self) -> Option<u16> {
        self.take(2)?.first_chunk().map(|b| u16::from_le_bytes(*b))
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.take(4)?.first_chunk().map(|b| u32::from_le_bytes(*b))
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.take(8)?.first_chunk().map(|b| u64::from_le_bytes(*b))
    }

    pub(crate) fn string(&mut self) -> Option<&'a str> {
        let n = usize::try_from(self.u32()?).ok()?;
        std::str::from_utf8(self.take(n)?).ok()
    }
}
