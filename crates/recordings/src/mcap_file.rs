//! MCAP files, byte by byte: their messages, whole, cut off or damaged, and whether every byte is as it was written.

pub use crate::{
    integrity::{CHECK_OPCODE, Damage, Integrity, LIBRARY_MARK, check_record},
    mcap_records::{MAGIC, Message, Messages, messages},
};
/// The checksum of MCAP files: CRC-32 as in gzip.
pub use flate2::Crc;
