//! What an LMS answers.

use super::{Baud, Config, FROM_DEVICE, ScanReply, Unit, Variant, u16_at, write_telegram};

/// Fields of a status answer, bytes.
const STATUS_LEN: usize = 152;

/// The fields of a status answer that drivers look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusReply {
    /// Firmware, such as `V02.10 `.
    pub firmware: [u8; 7],
    /// The operating mode, as set by command `20`.
    pub mode: u8,
    /// Whether the device is defective.
    pub is_defective: bool,
    /// What the top bits of readings mean.
    pub measuring_mode: u8,
    /// Angle and resolution.
    pub variant: Variant,
    /// Speed of the line; `None` for a word that is not known.
    pub baud: Option<Baud>,
    /// Address of the device.
    pub address: u8,
    /// What readings count in.
    pub unit: Option<Unit>,
}

/// An answer; its payload's last byte is the status byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply<'a> {
    /// `90`: the device has been switched on; type and firmware as text.
    PowerOn(&'a [u8]),
    /// `91`: it will restart.
    WillReset,
    /// `92`: the request does not suit its state, or means nothing to it.
    Refused,
    /// `A0`: 0 the mode was changed, 1 refused or wrong password, 2 fault.
    Mode(u8),
    /// `B0`: a scan.
    Scan(ScanReply<'a>),
    /// `B1`: status.
    Status(StatusReply),
    /// `B2`: errors, two bytes each.
    Errors(&'a [u8]),
    /// `BA`: type and firmware as text.
    Type(&'a [u8]),
    /// `BB`: whether the variant was taken over, and which holds.
    Variant(bool, Variant),
    /// `F4`: the configuration.
    Config(Config),
    /// `F7`: whether the configuration was written, and which holds.
    ConfigWritten(bool, Config),
    /// Anything else, by its command.
    Other(u8),
}

impl<'a> Reply<'a> {
    /// Reads a device's payload: what it says, and its status byte. `None` for less than two
    /// bytes; what does not have its command's length is [`Reply::Other`].
    pub fn decode(payload: &'a [u8]) -> Option<(Self, u8)> {
        let (&status, rest) = payload.split_last()?;
        let (&command, fields) = rest.split_first()?;
        let variant = |at: usize| {
            let angle_deg = u16_at(fields, at)?;
            let resolution_cdeg = u16_at(fields, at.saturating_add(2))?;
            Some(Variant { angle_deg, resolution_cdeg })
        };
        let reply = match command {
            0x90 => Some(Self::PowerOn(fields)),
            0x91 => Some(Self::WillReset),
            0x92 => Some(Self::Refused),
            0xA0 => fields.first().map(|&result| Self::Mode(result)),
            0xB0 => ScanReply::decode(fields).map(Self::Scan),
            0xB1 => StatusReply::decode(rest).map(Self::Status),
            0xB2 => Some(Self::Errors(fields)),
            0xBA => Some(Self::Type(fields)),
            0xBB => fields.first().zip(variant(1)).map(|(&ok, v)| Self::Variant(ok == 1, v)),
            0xF4 => Config::from_bytes(fields).map(Self::Config),
            0xF7 => fields.split_first().and_then(|(&ok, config)| {
                Some(Self::ConfigWritten(ok == 1, Config::from_bytes(config)?))
            }),
            _ => None,
        };
        Some((reply.unwrap_or(Self::Other(command)), status))
    }

    /// Appends the telegram of a device of that address. Scans are written by [`ScanReply::write`].
    pub fn encode(&self, address: u8, status: u8, out: &mut Vec<u8>) {
        let mut payload = [0; STATUS_LEN + 2];
        let n = self.fields(&mut payload);
        if let Some(place) = payload.get_mut(n) {
            *place = status;
        }
        let whole = payload.get(..n.saturating_add(1)).unwrap_or_default();
        write_telegram(address | FROM_DEVICE, whole, out);
    }

    /// Writes command and fields; how many bytes they are. Texts are cut to what a status has room for.
    fn fields(&self, place: &mut [u8; STATUS_LEN + 2]) -> usize {
        let mut fill = |parts: [&[u8]; 3]| {
            let room = place.iter_mut().take(STATUS_LEN + 1);
            room.zip(parts.into_iter().flatten()).map(|(place, byte)| *place = *byte).count()
        };
        match self {
            Self::PowerOn(text) => fill([&[0x90], text, &[]]),
            Self::WillReset => fill([&[0x91], &[], &[]]),
            Self::Refused => fill([&[0x92], &[], &[]]),
            Self::Mode(result) => fill([&[0xA0, *result], &[], &[]]),
            Self::Scan(_) => fill([&[0xB0, 0, 0], &[], &[]]),
            Self::Status(status) => {
                status.write(place);
                STATUS_LEN.saturating_add(1)
            }
            Self::Errors(errors) => fill([&[0xB2], errors, &[]]),
            Self::Type(text) => fill([&[0xBA], text, &[]]),
            Self::Variant(ok, Variant { angle_deg, resolution_cdeg }) => fill([
                &[0xBB, (*ok).into()],
                &angle_deg.to_le_bytes(),
                &resolution_cdeg.to_le_bytes(),
            ]),
            Self::Config(config) => fill([&[0xF4], config.bytes(), &[]]),
            Self::ConfigWritten(ok, config) => fill([&[0xF7, (*ok).into()], config.bytes(), &[]]),
            Self::Other(command) => fill([&[*command], &[], &[]]),
        }
    }
}

impl StatusReply {
    /// Reads command and fields: offsets count from the command.
    fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != STATUS_LEN.saturating_add(1) {
            return None;
        }
        let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
        Some(Self {
            firmware: *bytes.get(1..)?.first_chunk()?,
            mode: byte(8),
            is_defective: byte(9) != 0,
            measuring_mode: byte(102),
            variant: Variant {
                angle_deg: u16_at(bytes, 107)?,
                resolution_cdeg: u16_at(bytes, 109)?,
            },
            baud: Baud::of_word(u16_at(bytes, 116)?),
            address: byte(120),
            unit: Unit::of_code(byte(122)),
        })
    }

    fn write(&self, place: &mut [u8; STATUS_LEN + 2]) {
        let mut put = |at: usize, bytes: &[u8]| {
            place.iter_mut().skip(at).zip(bytes).for_each(|(place, byte)| *place = *byte);
        };
        put(0, &[0xB1]);
        put(1, &self.firmware);
        put(8, &[self.mode, self.is_defective.into()]);
        // Variant 0: an LMS200. The motor turns 75 times a second.
        put(67, &75_u16.to_le_bytes());
        put(102, &[self.measuring_mode]);
        put(107, &self.variant.angle_deg.to_le_bytes());
        put(109, &self.variant.resolution_cdeg.to_le_bytes());
        put(116, &self.baud.map_or(0, Baud::word).to_le_bytes());
        put(120, &[self.address]);
        put(122, &[self.unit.map_or(0, Unit::code)]);
        put(124, &self.firmware);
    }
}
