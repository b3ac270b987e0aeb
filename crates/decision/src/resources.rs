//! The variables a program works on: 218 named bytes, at fixed one-byte addresses.
//!
//! A boolean resource is a byte of history: bit 0 is its value now, bit 1 its value one update
//! ago, and so on for eight updates. The two lowest bits together tell levels from edges, which
//! is all that [`EdgeCode`] says.
//!
//! Source: the thesis, Tables 4.1 and 4.2, §4.2.3.1. Differences: the thesis prints no addresses;
//! the layout here is ours and is pinned by tests, because images depend on it. Its machine has a
//! clock (Annex A2, `rtc()`) that no resource shows; `HOUR` to `WEEKDAY` are ours.

use std::fmt;

/// Address of one resource: 0 to 217.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ResourceId(u8);

/// A family of resources that share a name and differ in a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// `I0`–`I15`, digital inputs, as read at the start of the scan.
    Input,
    /// `NI0`–`NI15`, complements of the inputs.
    NegatedInput,
    /// `O0`–`O15`, digital outputs, written to the field at the end of the scan.
    Output,
    /// `A0`–`A7`, analog inputs, 0 to 255.
    Analog,
    /// `M0`–`M7`, memory meant for 8-bit numbers.
    Memory,
    /// `Y0`–`Y95`, memory meant for booleans, but good for numbers too.
    General,
    /// `YTMR0`–`YTMR31`, outputs of the timers.
    TimerOutput,
    /// `S0`–`S15`, the low four bits of `STATUS`, decoded: one is 1, the others are 0.
    State,
    /// `STATUS`, the state of a state machine.
    Status,
    /// `0L`, always 0.
    Zero,
    /// `1L`, always 1.
    One,
    /// `QRUN`, non-zero while the program may run.
    Run,
    /// `HOUR` of the machine's clock, 0 to 23, as read at the start of the scan.
    Hour,
    /// `MINUTE`, 0 to 59.
    Minute,
    /// `SECOND`, 0 to 59.
    Second,
    /// `DAY` of the month, 1 to 31.
    Day,
    /// `MONTH`, 1 to 12.
    Month,
    /// `WEEKDAY`, 1 (Monday) to 7 (Sunday).
    Weekday,
}

/// What the bytes of a family stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A history of one bit.
    Boolean,
    /// A number from 0 to 255.
    Number,
    /// Whichever the program makes of it.
    Either,
}

/// The two lowest bits of a history byte: what the variable just did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeCode {
    /// 00: it is 0 and was 0.
    Low,
    /// 01: it is 1 and was 0.
    Rising,
    /// 10: it is 0 and was 1.
    Falling,
    /// 11: it is 1 and was 1.
    High,
}

impl Family {
    /// Whether the machine's clock writes it.
    pub fn is_clock(self) -> bool {
        use Family::{Day, Hour, Minute, Month, Second, Weekday};
        matches!(self, Hour | Minute | Second | Day | Month | Weekday)
    }
}

impl EdgeCode {
    /// Reads the code from a history byte.
    pub fn of(history: u8) -> Self {
        match history & 3 {
            0 => Self::Low,
            1 => Self::Rising,
            2 => Self::Falling,
            _ => Self::High,
        }
    }
}

struct Row {
    family: Family,
    name: &'static str,
    first: u8,
    len: u8,
}

const fn row(family: Family, name: &'static str, first: u8, len: u8) -> Row {
    Row { family, name, first, len }
}

/// The address map. Images in the field depend on it: never renumber.
const ROWS: [Row; 18] = [
    row(Family::Input, "I", 0x00, 16),
    row(Family::NegatedInput, "NI", 0x10, 16),
    row(Family::Output, "O", 0x20, 16),
    row(Family::Analog, "A", 0x30, 8),
    row(Family::Memory, "M", 0x38, 8),
    row(Family::General, "Y", 0x40, 96),
    row(Family::TimerOutput, "YTMR", 0xA0, 32),
    row(Family::State, "S", 0xC0, 16),
    row(Family::Status, "STATUS", 0xD0, 1),
    row(Family::Zero, "0L", 0xD1, 1),
    row(Family::One, "1L", 0xD2, 1),
    row(Family::Run, "QRUN", 0xD3, 1),
    row(Family::Hour, "HOUR", 0xD4, 1),
    row(Family::Minute, "MINUTE", 0xD5, 1),
    row(Family::Second, "SECOND", 0xD6, 1),
    row(Family::Day, "DAY", 0xD7, 1),
    row(Family::Month, "MONTH", 0xD8, 1),
    row(Family::Weekday, "WEEKDAY", 0xD9, 1),
];

/// How many resources there are.
pub const N_RESOURCES: u8 = 0xDA;

impl ResourceId {
    /// `STATUS`.
    pub const STATUS: Self = Self(0xD0);
    /// `0L`.
    pub const ZERO: Self = Self(0xD1);
    /// `1L`.
    pub const ONE: Self = Self(0xD2);
    /// `QRUN`.
    pub const QRUN: Self = Self(0xD3);

    /// The resource at an address of an image, if there is one.
    pub fn from_address(address: u8) -> Option<Self> {
        (address < N_RESOURCES).then_some(Self(address))
    }

    /// Its address in images.
    pub fn address(self) -> u8 {
        self.0
    }

    /// Every resource, by address.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..N_RESOURCES).map(Self)
    }

    /// Member `number` of a family; `None` beyond its end.
    pub fn of(family: Family, number: u8) -> Option<Self> {
        let row = ROWS.iter().find(|row| row.family == family)?;
        (number < row.len).then(|| Self(row.first.saturating_add(number)))
    }

    /// Looks a resource up by its name as a program writes it, in either case: `YTMR16`, `0L`.
    ///
    /// # Errors
    ///
    /// [`NameError::NumberTooLarge`] when the family exists but not that member, with the
    /// greatest number it has; [`NameError::Unknown`] for everything else.
    pub fn by_name(name: &str) -> Result<Self, NameError> {
        let upper = name.to_ascii_uppercase();
        if let Some(row) = ROWS.iter().find(|row| row.len == 1 && row.name == upper) {
            return Ok(Self(row.first));
        }
        let digits = upper.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let family = upper.strip_suffix(digits).unwrap_or("");
        let row = ROWS.iter().find(|row| row.len > 1 && row.name == family);
        let (Some(row), false) = (row, digits.is_empty()) else {
            return Err(NameError::Unknown);
        };
        if !digits.bytes().all(|b| b.is_ascii_digit())
            || (digits.len() > 1 && digits.starts_with('0'))
        {
            return Err(NameError::Unknown);
        }
        let number = digits.parse::<u8>().ok().filter(|&number| number < row.len);
        let too_large =
            NameError::NumberTooLarge { family: row.name, number_max: row.len.saturating_sub(1) };
        number.map(|number| Self(row.first.saturating_add(number))).ok_or(too_large)
    }

    /// The family it belongs to.
    pub fn family(self) -> Family {
        self.row().family
    }

    /// Its number within the family.
    pub fn number(self) -> u8 {
        self.0.saturating_sub(self.row().first)
    }

    /// What its byte stands for.
    pub fn value_kind(self) -> ValueKind {
        match self.family() {
            Family::Analog | Family::Memory | Family::Status | Family::Run => ValueKind::Number,
            family if family.is_clock() => ValueKind::Number,
            Family::General => ValueKind::Either,
            _ => ValueKind::Boolean,
        }
    }

    /// Whether a program may name it as a destination. Timer outputs belong to `TIMER`.
    pub fn is_writable(self) -> bool {
        use Family::{General, Memory, Output, Run, Status};
        matches!(self.family(), Output | Memory | General | Status | Run)
    }

    fn row(self) -> &'static Row {
        let [first, rest @ ..] = &ROWS;
        rest.iter().rev().find(|row| row.first <= self.0).unwrap_or(first)
    }
}

impl fmt::Display for ResourceId {
    /// The name as a program writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let row = self.row();
        if row.len == 1 {
            f.write_str(row.name)
        } else {
            write!(f, "{}{}", row.name, self.number())
        }
    }
}

/// Why a name is not a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NameError {
    /// Nothing is called so.
    #[error("there is no such resource")]
    Unknown,
    /// The family exists, the number does not.
    #[error("the last one is {family}{number_max}")]
    NumberTooLarge {
        /// Name of the family.
        family: &'static str,
        /// Greatest number in it.
        number_max: u8,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_back_to_its_address() {
        assert_eq!(ResourceId::all().count(), 218);
        for id in ResourceId::all() {
            assert_eq!(ResourceId::by_name(&id.to_string()), Ok(id));
            assert_eq!(ResourceId::by_name(&id.to_string().to_lowercase()), Ok(id));
            assert_eq!(ResourceId::of(id.family(), id.number()), Some(id));
        }
        assert_eq!(ResourceId::from_address(218), None);
    }

    #[test]
    fn the_published_map_holds() {
        let address = |name| ResourceId::by_name(name).map(ResourceId::address);
        let map = [
            ("I0", 0x00),
            ("I15", 0x0F),
            ("NI0", 0x10),
            ("O0", 0x20),
            ("A0", 0x30),
            ("M0", 0x38),
            ("Y0", 0x40),
            ("Y95", 0x9F),
            ("YTMR0", 0xA0),
            ("YTMR31", 0xBF),
            ("S0", 0xC0),
            ("STATUS", 0xD0),
            ("0L", 0xD1),
            ("1L", 0xD2),
            ("QRUN", 0xD3),
            ("HOUR", 0xD4),
            ("WEEKDAY", 0xD9),
        ];
        for (name, expected) in map {
            assert_eq!(address(name), Ok(expected), "{name}");
        }
    }

    #[test]
    fn wrong_names_say_why() {
        let too_large = |family, number_max| Err(NameError::NumberTooLarge { family, number_max });
        assert_eq!(ResourceId::by_name("I16"), too_large("I", 15));
        assert_eq!(ResourceId::by_name("A8"), too_large("A", 7));
        assert_eq!(ResourceId::by_name("Y99999999999"), too_large("Y", 95));
        for name in ["", "I", "Q1", "I-1", "I01", "STATUS0", "2L", "I1X", "7"] {
            assert_eq!(ResourceId::by_name(name), Err(NameError::Unknown), "{name}");
        }
    }

    #[test]
    fn edges_are_the_two_lowest_bits() {
        use EdgeCode::{Falling, High, Low, Rising};
        let codes = [0b1111_1100, 0b1010_1101, 0b0000_0010, 0b0000_0111].map(EdgeCode::of);
        assert_eq!(codes, [Low, Rising, Falling, High]);
    }
}
