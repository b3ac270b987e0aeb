//! What the bits of a scan mean.

use super::{STATUS_OK, u16_at};

/// What a reading counts in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
}

impl Unit {
    /// Metres in one.
    pub fn metres(self) -> f64 {
        match self {
            Self::Cm => 0.01,
            Self::Mm => 0.001,
        }
    }

    /// The number for it in a configuration.
    pub(super) fn code(self) -> u8 {
        match self {
            Self::Cm => 0,
            Self::Mm => 1,
        }
    }

    pub(super) fn of_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Cm),
            1 => Some(Self::Mm),
            _ => None,
        }
    }
}

/// How many of a reading's 16 bits are its range; the others tell of fields and reflectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RangeField {
    mask: u16,
}

/// What a reading says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// A range, in the scan's unit.
    Range(u16),
    /// Something beyond the scale.
    Beyond,
    /// Nothing came back.
    NoReturn,
    /// Something came back, but too weakly.
    WeakSignal,
    /// The receiver was blinded, or the value could not be read.
    Invalid,
}

impl RangeField {
    /// 13 bits, as delivered.
    pub const BITS_13: Self = Self { mask: 0x1FFF };

    /// The ranges of a measuring mode of the configuration: 13 bits in modes 0 to 2, 14 in 3 and 4, 15 in 5
    /// and 6. `None` for modes without ranges.
    pub fn of_mode(measuring_mode: u8) -> Option<Self> {
        match measuring_mode {
            0..=2 => Some(Self::BITS_13),
            3 | 4 => Some(Self { mask: 0x3FFF }),
            5 | 6 => Some(Self { mask: 0x7FFF }),
            _ => None,
        }
    }

    /// Greatest range, in the scan's unit: the nine greatest numbers have meanings of their own. Published for
    /// 13 bits; that the wider fields do the same is our reading.
    pub fn range_max(self) -> u16 {
        self.mask.saturating_sub(9)
    }

    /// The bits that say this. A range beyond the scale is [`Reading::Beyond`].
    pub fn encode(self, reading: Reading) -> u16 {
        match reading {
            Reading::Range(range) if range <= self.range_max() => range,
            Reading::Range(_) | Reading::Beyond => self.mask.saturating_sub(8),
            Reading::WeakSignal => self.mask.saturating_sub(4),
            Reading::Invalid => self.mask.saturating_sub(1),
            Reading::NoReturn => self.mask,
        }
    }

    /// What bits say.
    pub fn decode(self, bits: u16) -> Reading {
        let value = bits & self.mask;
        match self.mask.saturating_sub(value) {
            0 => Reading::NoReturn,
            4 => Reading::WeakSignal,
            8 => Reading::Beyond,
            // 1FFE dazzled, 1FFD overflow, 1FFA read error, and the numbers between without a meaning.
            1..=7 => Reading::Invalid,
            _ => Reading::Range(value),
        }
    }
}

/// The readings of one scan, as they lie in a `B0` answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanReply<'a> {
    /// What the readings count in.
    pub unit: Unit,
    /// Which quarter of an interlaced scan this is, if it is a partial one.
    pub part: Option<u8>,
    values: &'a [[u8; 2]],
}

impl<'a> ScanReply<'a> {
    /// Reads the fields of a `B0` answer without command and status.
    pub(super) fn decode(fields: &'a [u8]) -> Option<Self> {
        let count = u16_at(fields, 0)?;
        let (values, rest) = fields.get(2..)?.as_chunks::<2>();
        if values.len() != usize::from(count & 0x3FF) || !rest.is_empty() {
            return None;
        }
        let is_partial = count & 0x2000 != 0;
        let [_, high] = count.to_le_bytes();
        Some(Self {
            unit: Unit::of_code(high >> 6)?,
            part: is_partial.then_some((high >> 3) & 3),
            values,
        })
    }

    /// The readings' bits, rightmost first.
    pub fn bits(&self) -> impl ExactSizeIterator<Item = u16> + 'a {
        self.values.iter().map(|pair| u16::from_le_bytes(*pair))
    }

    /// How many readings there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Appends the payload of a `B0` answer of a healthy device; at most 1023 readings.
    pub fn write(unit: Unit, bits: impl ExactSizeIterator<Item = u16>, payload: &mut Vec<u8>) {
        let count = u16::try_from(bits.len()).unwrap_or(u16::MAX).min(0x3FF);
        let head = count | (u16::from(unit.code()) << 14);
        payload.push(0xB0);
        payload.extend_from_slice(&head.to_le_bytes());
        for reading in bits.take(count.into()) {
            payload.extend_from_slice(&reading.to_le_bytes());
        }
        payload.push(STATUS_OK);
    }
}
