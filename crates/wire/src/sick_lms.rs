//! SICK LMS200 and LMS291: the telegrams of the laser that Pioneers carry.
//!
//! A telegram is `02 address length length payload crc crc`, 8N1, with the length of the payload and the
//! CRC low byte first. Before its answer the device sends one bare byte: `06` accepted, `15` bad
//! checksum. An answer has bit 7 set in address and command, and ends with a status byte that the length counts. The
//! line begins at 9600 baud and may be changed to 19200, 38400 or, over RS-422, 500 000.
//!
//! [`Decoder`] finds telegrams, [`Request`] and [`Reply`] are what they say, [`RangeField`] is what a
//! reading's bits mean.
//!
//! Source: the public drivers `ros-drivers/sicktoolbox`, `playerproject/player` and
//! `reedhedges/AriaCoda`, and what they quote of SICK's Telegram Listing 8007954.

mod decoder;
mod reader;
mod reading;
mod reply;
mod request;
#[cfg(test)]
mod tests;

pub use decoder::{Decoder, Item, Side};
pub(crate) use reader::reader;
pub use reading::{RangeField, Reading, ScanReply, Unit};
pub use reply::{Reply, StatusReply};
pub use request::{Config, Request};

/// The line's speed after power-on, bits per second, unless another was made permanent.
pub const BAUD_START: u32 = 9600;

/// Longest payload of a telegram, bytes: 401 readings and what stands around them.
pub const PAYLOAD_MAX: usize = 812;

/// The bare byte before an answer: accepted.
pub const ACK: u8 = 0x06;
/// The bare byte for a telegram with a wrong checksum.
pub const NAK: u8 = 0x15;

/// Status byte of a healthy device.
pub const STATUS_OK: u8 = 0x10;
/// The password of installation mode.
pub const PASSWORD: [u8; 8] = *b"SICK_LMS";

const STX: u8 = 0x02;
/// Set in address and command of an answer.
const FROM_DEVICE: u8 = 0x80;
/// Bytes around a payload.
const FRAME_LEN: usize = 6;

/// Speeds of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Baud {
    /// 9600 bits per second.
    B9600,
    /// 19 200 bits per second.
    B19200,
    /// 38 400 bits per second.
    B38400,
    /// 500 000 bits per second; needs RS-422.
    B500000,
}

impl Baud {
    /// All there are, slowest first.
    pub const ALL: [Self; 4] = [Self::B9600, Self::B19200, Self::B38400, Self::B500000];

    /// Bits per second.
    pub fn bits_per_s(self) -> u32 {
        match self {
            Self::B9600 => 9600,
            Self::B19200 => 19_200,
            Self::B38400 => 38_400,
            Self::B500000 => 500_000,
        }
    }

    /// The speed of that many bits per second.
    pub fn of(bits_per_s: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|baud| baud.bits_per_s() == bits_per_s)
    }

    /// The mode of command `20` that sets it.
    fn mode(self) -> u8 {
        match self {
            Self::B9600 => 0x42,
            Self::B19200 => 0x41,
            Self::B38400 => 0x40,
            Self::B500000 => 0x48,
        }
    }

    /// How a status answer says it.
    fn word(self) -> u16 {
        match self {
            Self::B9600 => 0x8067,
            Self::B19200 => 0x8033,
            Self::B38400 => 0x8019,
            Self::B500000 => 0x8001,
        }
    }

    fn of_word(word: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|baud| baud.word() == word)
    }
}

/// Angle and resolution of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// 100 or 180 degrees, symmetric about straight ahead.
    pub angle_deg: u16,
    /// 100, 50 or 25 hundredths of a degree; 25 at 100° only.
    pub resolution_cdeg: u16,
}

impl Variant {
    /// All there are.
    pub const ALL: [Self; 5] = [
        Self { angle_deg: 180, resolution_cdeg: 100 },
        Self { angle_deg: 180, resolution_cdeg: 50 },
        Self { angle_deg: 100, resolution_cdeg: 100 },
        Self { angle_deg: 100, resolution_cdeg: 50 },
        Self { angle_deg: 100, resolution_cdeg: 25 },
    ];

    /// Whether the device knows it.
    pub fn is_known(self) -> bool {
        Self::ALL.contains(&self)
    }

    /// Readings of a scan.
    pub fn n_readings(self) -> usize {
        let hundredths = usize::from(self.angle_deg).saturating_mul(100);
        let steps = hundredths.checked_div(usize::from(self.resolution_cdeg));
        steps.unwrap_or(0).saturating_add(1)
    }

    /// Turns of the mirror, which looks every whole degree, for one scan.
    pub fn n_turns(self) -> usize {
        let turns = 100_u16.checked_div(self.resolution_cdeg).unwrap_or(1);
        usize::from(turns.max(1))
    }
}

/// Appends a telegram. Of a longer payload only [`PAYLOAD_MAX`] bytes are sent.
pub fn write_telegram(address: u8, payload: &[u8], out: &mut Vec<u8>) {
    let payload = payload.get(..PAYLOAD_MAX).unwrap_or(payload);
    let start = out.len();
    let [low, high] = u16::try_from(payload.len()).unwrap_or(u16::MAX).to_le_bytes();
    out.extend_from_slice(&[STX, address, low, high]);
    out.extend_from_slice(payload);
    let crc = checksum(out.get(start..).unwrap_or_default());
    out.extend_from_slice(&crc.to_le_bytes());
}

/// SICK's checksum of a telegram from its STX to the end of its payload. It is not CRC-16/IBM: the state is
/// shifted once per byte, and each byte goes in together with the one before it.
pub fn checksum(bytes: &[u8]) -> u16 {
    let (crc, _) = bytes.iter().fold((0_u16, 0_u8), |(crc, before), &byte| {
        let carry = if crc & 0x8000 == 0 { 0 } else { 0x8005 };
        ((crc << 1) ^ carry ^ u16::from_be_bytes([before, byte]), byte)
    });
    crc
}

/// The two bytes at `at`, low first.
fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let pair = bytes.get(at..)?.first_chunk::<2>()?;
    Some(u16::from_le_bytes(*pair))
}
