//! The packet protocol between a Pioneer robot and its client (ARCOS, formerly P2OS).
//!
//! A packet is `FA FB count body… sum_high sum_low`: `count` is the length of body and checksum
//! together. A client's body is a command number with at most one argument ([`Command`]); a robot's
//! body is an echo, a server information packet ([`Sip`]) or one of the packets asked for
//! ([`ConfigPac`], [`EncoderPac`], [`IoPac`], [`GripperPac`], [`SimStatPac`]); [`Report`] tells them
//! apart. Numbers are little endian, only
//! the checksum is not.
//!
//! The codec knows no connection state: whether a bare `1` is SYNC1 or OPEN is for the robot to
//! say, because on the wire they are the same bytes.
//!
//! Source: the manufacturer's public manuals of the Pioneer 2 and 3 (packet layout, tables of
//! client commands and of the standard information packet) and the thesis, Annex C, whose receive
//! buffer has the same offsets.

mod command;
mod config_pac;
mod decoder;
mod describe;
mod device_pacs;
#[cfg(test)]
mod device_pacs_tests;
mod fields;
mod reader;
mod report_error;
mod sip;
#[cfg(test)]
mod tests;

pub use command::{Command, CommandError};
pub use config_pac::{ConfigPac, EncoderPac};
pub use decoder::{Decoder, Packet};
pub use describe::describe;
pub use device_pacs::{GripperPac, IoPac, SimStatPac};
pub(crate) use reader::reader;
pub use report_error::ReportError;
pub use sip::{IoFields, PowerFields, Report, Sip, SonarReading, SonarReadings};

/// The two bytes that open every packet.
pub const HEADER: [u8; 2] = [0xFA, 0xFB];

/// Longest body a packet may carry, bytes: the count covers the checksum and may not exceed 200.
pub const BODY_LEN_MAX: usize = 198;

/// What `count` may be at most.
pub(crate) const COUNT_MAX: u8 = 200;

/// A body that no packet can carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("packet body of {len} bytes; a packet carries 1 to {BODY_LEN_MAX}")]
pub struct BodyLength {
    /// Its length, bytes.
    pub len: usize,
}

/// Appends one packet that carries `body` to `out`.
///
/// # Errors
///
/// [`BodyLength`] when the body is empty or longer than [`BODY_LEN_MAX`]; `out` is left as it was.
pub fn write_packet(body: &[u8], out: &mut Vec<u8>) -> Result<(), BodyLength> {
    let too_long = BodyLength { len: body.len() };
    if body.is_empty() || body.len() > BODY_LEN_MAX {
        return Err(too_long);
    }
    let count = u8::try_from(body.len().saturating_add(2)).map_err(|_overflow| too_long)?;
    out.extend_from_slice(&HEADER);
    out.push(count);
    out.extend_from_slice(body);
    out.extend_from_slice(&checksum(body).to_be_bytes());
    Ok(())
}

/// The checksum of a body: its 16-bit big-endian pairs added modulo 2¹⁶; an odd last byte is then
/// exclusive-ored into the low byte.
pub fn checksum(body: &[u8]) -> u16 {
    let (pairs, odd) = body.as_chunks::<2>();
    let sum = pairs.iter().fold(0_u16, |sum, &pair| sum.wrapping_add(u16::from_be_bytes(pair)));
    odd.first().map_or(sum, |&last| sum ^ u16::from(last))
}
