//! The Open Interface (OI) of the iRobot Create 2 and the Roombas of its family.
//!
//! Commands are an opcode and its data, without header, length or checksum, and none is acknowledged; numbers of two
//! bytes have their high byte first. Sensors come as *packets*: asked for once ([`Command::Sensors`],
//! [`Command::QueryList`]) they are bare data, streamed ([`Command::Stream`]) they come every 15 ms in frames
//!
//! ```text
//! 13 n { id data }… sum        n counts ids and data; all bytes together are 0 modulo 256
//! ```
//!
//! [`CommandDecoder`] is the robot's side, [`StreamDecoder`] the client's; both start again after noise and count what
//! they drop.
//!
//! Source: iRobot Create 2 Open Interface Specification (2016); sizes of the groups as printed there. Differences: the
//! prose of its stream example says 549 where its bytes 02 19 hex are 537.

mod commands;
mod packets;
mod reader;
mod stream;
#[cfg(test)]
mod tests;

pub use commands::{BAUDS, Command, CommandDecoder, Radius};
pub use packets::{Format, Readings, data_len, format, ids, members};
pub(crate) use reader::reader;
pub use stream::{FRAME_LEN_MAX, Frame, STREAM_HEADER, StreamDecoder, write_frame};
