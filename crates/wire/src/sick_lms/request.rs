//! What a host asks of an LMS.

use super::{Baud, PASSWORD, Unit, Variant, u16_at, write_telegram};

/// Fields of a configuration of newer firmware, bytes; older has two less.
const CONFIG_MAX: usize = 34;
const CONFIG_MIN: usize = 32;
const MEASURING_MODE_AT: usize = 5;
const UNIT_AT: usize = 6;

/// The configuration that command `77` writes and `74` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    bytes: [u8; CONFIG_MAX],
    len: u8,
}

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// `10`: restarts the device.
    Reset,
    /// `20 00`: installation mode, in which configurations may be written.
    Installation([u8; 8]),
    /// `20 24`: scans without end.
    Continuous,
    /// `20 25`: scans on request only.
    OnRequest,
    /// `20 40` … `20 48`: another speed of the line, from after the answer.
    Baud(Baud),
    /// `20` with a mode that is not spoken here: subrange, partial scans, reflectivity.
    OtherMode(u8),
    /// `30 01`: one scan.
    OneScan,
    /// `31`: status.
    Status,
    /// `32`: errors.
    Errors,
    /// `3A`: type and firmware as text.
    Type,
    /// `3B`: angle and resolution.
    Variant(Variant),
    /// `74`: configuration.
    ReadConfig,
    /// `77`: writes the configuration, to a memory that wears out.
    WriteConfig(Config),
    /// Anything else, by its command.
    Other(u8),
}

impl Config {
    /// As delivered: 13-bit ranges with fields, in centimetres, sensitivity standard.
    pub fn delivered() -> Self {
        Self { bytes: [0; CONFIG_MAX], len: CONFIG_MIN as u8 }
    }

    /// Reads 32 to 34 bytes.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        if !(CONFIG_MIN..=CONFIG_MAX).contains(&bytes.len()) {
            return None;
        }
        let mut config = Self { bytes: [0; CONFIG_MAX], len: bytes.len() as u8 };
        for (place, byte) in config.bytes.iter_mut().zip(bytes) {
            *place = *byte;
        }
        Some(config)
    }

    /// The fields as sent.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// What the top bits of a reading mean; see [`RangeField::of_mode`](super::RangeField::of_mode).
    pub fn measuring_mode(&self) -> u8 {
        self.bytes.get(MEASURING_MODE_AT).copied().unwrap_or(0)
    }

    /// What readings count in; `None` for a unit that is not spoken here.
    pub fn unit(&self) -> Option<Unit> {
        self.bytes.get(UNIT_AT).copied().and_then(Unit::of_code)
    }

    /// The same with another unit and measuring mode.
    #[must_use]
    pub fn with(mut self, unit: Unit, measuring_mode: u8) -> Self {
        if let Some(place) = self.bytes.get_mut(MEASURING_MODE_AT) {
            *place = measuring_mode;
        }
        if let Some(place) = self.bytes.get_mut(UNIT_AT) {
            *place = unit.code();
        }
        self
    }
}

impl Request {
    /// Installation mode with the password that devices are delivered with.
    pub const INSTALLATION: Self = Self::Installation(PASSWORD);

    /// Appends the telegram for the device of that address; 0 is any.
    pub fn encode(&self, address: u8, out: &mut Vec<u8>) {
        let mode = |mode: u8, out: &mut Vec<u8>| write_telegram(address, &[0x20, mode], out);
        let bare = |command: u8, out: &mut Vec<u8>| write_telegram(address, &[command], out);
        match *self {
            Self::Reset => bare(0x10, out),
            Self::Installation([a, b, c, d, e, f, g, h]) => {
                write_telegram(address, &[0x20, 0, a, b, c, d, e, f, g, h], out);
            }
            Self::Continuous => mode(0x24, out),
            Self::OnRequest => mode(0x25, out),
            Self::Baud(baud) => mode(baud.mode(), out),
            Self::OtherMode(number) => mode(number, out),
            Self::OneScan => write_telegram(address, &[0x30, 0x01], out),
            Self::Status => bare(0x31, out),
            Self::Errors => bare(0x32, out),
            Self::Type => bare(0x3A, out),
            Self::Variant(Variant { angle_deg, resolution_cdeg }) => {
                let ([a0, a1], [r0, r1]) = (angle_deg.to_le_bytes(), resolution_cdeg.to_le_bytes());
                write_telegram(address, &[0x3B, a0, a1, r0, r1], out);
            }
            Self::ReadConfig => bare(0x74, out),
            Self::WriteConfig(config) => {
                let mut payload = [0x77; CONFIG_MAX + 1];
                let n = config.bytes().len();
                for (place, byte) in payload.iter_mut().skip(1).zip(config.bytes()) {
                    *place = *byte;
                }
                let whole = payload.get(..n.saturating_add(1)).unwrap_or_default();
                write_telegram(address, whole, out);
            }
            Self::Other(command) => bare(command, out),
        }
    }

    /// Reads a host's payload. What is too short or has an unknown command is [`Request::Other`].
    pub fn decode(payload: &[u8]) -> Self {
        match *payload {
            [0x10] => Self::Reset,
            [0x20, 0, ref password @ ..] => {
                password.try_into().map_or(Self::OtherMode(0), Self::Installation)
            }
            [0x20, 0x24] => Self::Continuous,
            [0x20, 0x25] => Self::OnRequest,
            [0x20, mode, ..] => Baud::ALL
                .into_iter()
                .find(|baud| baud.mode() == mode)
                .map_or(Self::OtherMode(mode), Self::Baud),
            [0x30, 0x01] => Self::OneScan,
            [0x31] => Self::Status,
            [0x32] => Self::Errors,
            [0x3A] => Self::Type,
            [0x3B, ref fields @ ..] => match (u16_at(fields, 0), u16_at(fields, 2)) {
                (Some(angle_deg), Some(resolution_cdeg)) => {
                    Self::Variant(Variant { angle_deg, resolution_cdeg })
                }
                _ => Self::Other(0x3B),
            },
            [0x74] => Self::ReadConfig,
            [0x77, ref fields @ ..] => {
                Config::from_bytes(fields).map_or(Self::Other(0x77), Self::WriteConfig)
            }
            [command, ..] => Self::Other(command),
            [] => Self::Other(0),
        }
    }
}
