//! Sensor packets: which there are, how long, signed or not, and the groups.

/// Names of the packets that are used by name.
pub mod ids {
    /// Bumps (bit 0 right, 1 left) and wheel drops (bit 2 right, 3 left).
    pub const BUMPS_AND_DROPS: u8 = 7;
    /// A wall on the right.
    pub const WALL: u8 = 8;
    /// No floor at the left; front left, front right and right follow.
    pub const CLIFF_LEFT: u8 = 9;
    /// The beam of a virtual wall.
    pub const VIRTUAL_WALL: u8 = 13;
    /// Overcurrents: bit 3 right wheel, 4 left wheel.
    pub const OVERCURRENTS: u8 = 14;
    /// Infrared byte heard all around.
    pub const IR_OMNI: u8 = 17;
    /// Buttons that are pressed.
    pub const BUTTONS: u8 = 18;
    /// Way since it was read last, mm.
    pub const DISTANCE: u8 = 19;
    /// Angle since it was read last, degrees, counter-clockwise.
    pub const ANGLE: u8 = 20;
    /// How it is charging: 0 not, 2 full, 3 trickle, 4 waiting.
    pub const CHARGING_STATE: u8 = 21;
    /// Voltage, mV.
    pub const VOLTAGE: u8 = 22;
    /// Current into the battery, mA.
    pub const CURRENT: u8 = 23;
    /// Temperature of the battery, °C.
    pub const TEMPERATURE: u8 = 24;
    /// Charge, mAh.
    pub const CHARGE: u8 = 25;
    /// Capacity, mAh.
    pub const CAPACITY: u8 = 26;
    /// Strength of the wall sensor's echo, 0 to 1023.
    pub const WALL_SIGNAL: u8 = 27;
    /// Strength of the floor's echo at the left, 0 to 4095; front left, front right and right follow.
    pub const CLIFF_LEFT_SIGNAL: u8 = 28;
    /// Where power comes from: bit 0 charger, bit 1 home base.
    pub const CHARGING_SOURCES: u8 = 34;
    /// Mode: 0 off, 1 passive, 2 safe, 3 full.
    pub const MODE: u8 = 35;
    /// Number of the song chosen.
    pub const SONG_NUMBER: u8 = 36;
    /// Whether it plays.
    pub const SONG_PLAYING: u8 = 37;
    /// How many packets are streamed.
    pub const STREAM_PACKETS: u8 = 38;
    /// Speed that DRIVE asked for last, mm/s.
    pub const REQUESTED_VELOCITY: u8 = 39;
    /// Radius that DRIVE asked for last, mm.
    pub const REQUESTED_RADIUS: u8 = 40;
    /// Speed that the right wheel was asked for, mm/s.
    pub const REQUESTED_RIGHT: u8 = 41;
    /// Speed that the left wheel was asked for, mm/s.
    pub const REQUESTED_LEFT: u8 = 42;
    /// Counts of the left wheel, modulo 65 536.
    pub const ENCODER_LEFT: u8 = 43;
    /// Counts of the right wheel, modulo 65 536.
    pub const ENCODER_RIGHT: u8 = 44;
    /// Light bumper: bits 0 to 5 from left to right.
    pub const LIGHT_BUMPER: u8 = 45;
    /// Strength of the leftmost light bumper's echo, 0 to 4095; five others follow, to the right.
    pub const LIGHT_LEFT_SIGNAL: u8 = 46;
    /// Infrared byte heard on the left.
    pub const IR_LEFT: u8 = 52;
    /// Infrared byte heard on the right.
    pub const IR_RIGHT: u8 = 53;
    /// Current of the left wheel's motor, mA; right wheel and two brushes follow.
    pub const MOTOR_LEFT_CURRENT: u8 = 54;
    /// Current of the right wheel's motor, mA.
    pub const MOTOR_RIGHT_CURRENT: u8 = 55;
    /// Whether the caster turns: it makes way forwards.
    pub const STASIS: u8 = 58;
}

/// The first packet that is no group.
const FIRST: u8 = 7;
/// The last one.
const LAST: u8 = 58;
/// How many there are.
const N_PACKETS: usize = (LAST - FIRST + 1) as usize;

/// How a packet is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// What it is, for people.
    pub name: &'static str,
    /// Its length, 1 or 2 bytes.
    pub n_bytes: u8,
    /// Whether it can be negative.
    pub signed: bool,
}

const fn u8_(name: &'static str) -> Format {
    Format { name, n_bytes: 1, signed: false }
}
const fn i8_(name: &'static str) -> Format {
    Format { name, n_bytes: 1, signed: true }
}
const fn u16_(name: &'static str) -> Format {
    Format { name, n_bytes: 2, signed: false }
}
const fn i16_(name: &'static str) -> Format {
    Format { name, n_bytes: 2, signed: true }
}

/// All packets, from [`FIRST`] on.
const FORMATS: [Format; N_PACKETS] = [
    u8_("bumps and drops"),
    u8_("wall"),
    u8_("cliff left"),
    u8_("cliff front left"),
    u8_("cliff front right"),
    u8_("cliff right"),
    u8_("virtual wall"),
    u8_("overcurrents"),
    u8_("dirt"),
    u8_("unused 16"),
    u8_("infrared"),
    u8_("buttons"),
    i16_("distance"),
    i16_("angle"),
    u8_("charging state"),
    u16_("voltage"),
    i16_("current"),
    i8_("temperature"),
    u16_("charge"),
    u16_("capacity"),
    u16_("wall signal"),
    u16_("cliff left signal"),
    u16_("cliff front left signal"),
    u16_("cliff front right signal"),
    u16_("cliff right signal"),
    u8_("unused 32"),
    u16_("unused 33"),
    u8_("charging sources"),
    u8_("mode"),
    u8_("song"),
    u8_("song playing"),
    u8_("stream packets"),
    i16_("requested velocity"),
    i16_("requested radius"),
    i16_("requested right"),
    i16_("requested left"),
    u16_("encoder left"),
    u16_("encoder right"),
    u8_("light bumper"),
    u16_("light left"),
    u16_("light front left"),
    u16_("light centre left"),
    u16_("light centre right"),
    u16_("light front right"),
    u16_("light right"),
    u8_("infrared left"),
    u8_("infrared right"),
    i16_("motor left current"),
    i16_("motor right current"),
    i16_("main brush current"),
    i16_("side brush current"),
    u8_("stasis"),
];

/// How the packet of that number is written; `None` for groups and numbers that there are not.
pub fn format(id: u8) -> Option<Format> {
    FORMATS.get(usize::from(id.checked_sub(FIRST)?)).copied()
}

/// The packets that a number stands for: itself, or those of a group; `None` for a number that there is not.
pub fn members(id: u8) -> Option<std::ops::RangeInclusive<u8>> {
    Some(match id {
        0 => 7..=26,
        1 => 7..=16,
        2 => 17..=20,
        3 => 21..=26,
        4 => 27..=34,
        5 => 35..=42,
        6 => 7..=42,
        FIRST..=LAST => id..=id,
        100 => 7..=58,
        101 => 43..=58,
        106 => 46..=51,
        107 => 54..=58,
        _ => return None,
    })
}

/// Bytes of data that a number stands for, without its id.
pub fn data_len(id: u8) -> Option<usize> {
    members(id).map(|ids| ids.filter_map(format).map(|format| usize::from(format.n_bytes)).sum())
}

/// Values of packets, by number; those that were never set are unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Readings {
    values: [i32; N_PACKETS],
    known: u64,
}

impl Default for Readings {
    fn default() -> Self {
        Self { values: [0; N_PACKETS], known: 0 }
    }
}

impl Readings {
    /// The value of a packet; `None` when it is unknown.
    pub fn get(&self, id: u8) -> Option<i32> {
        let index = id.checked_sub(FIRST)?;
        let value = self.values.get(usize::from(index))?;
        (self.known >> index & 1 != 0).then_some(*value)
    }

    /// Sets a packet; a value that does not fit is the nearest that does, and a number that there is not is passed over.
    pub fn set(&mut self, id: u8, value: i32) {
        let Some(format) = format(id) else { return };
        let index = id.saturating_sub(FIRST);
        let (least, most) = match (format.n_bytes, format.signed) {
            (1, false) => (0, 0xFF),
            (1, true) => (-0x80, 0x7F),
            (_, false) => (0, 0xFFFF),
            (_, true) => (-0x8000, 0x7FFF),
        };
        if let Some(place) = self.values.get_mut(usize::from(index)) {
            *place = value.clamp(least, most);
            self.known |= 1 << index;
        }
    }

    /// Appends the data of a packet or of a group, without its id; unknown ones are 0. Says whether there is such a
    /// number.
    pub fn write(&self, id: u8, out: &mut Vec<u8>) -> bool {
        let Some(ids) = members(id) else { return false };
        for id in ids {
            let Some(format) = format(id) else { continue };
            // Two's complement: the low bytes are the same for every width.
            let [.., high, low] = self.get(id).unwrap_or(0).to_be_bytes();
            if format.n_bytes == 2 {
                out.push(high);
            }
            out.push(low);
        }
        true
    }

    /// Reads the data of a packet or of a group from the front of `bytes`; what is left of them, or `None` when there is no
    /// such number or they are too few, with nothing changed.
    pub fn read<'b>(&mut self, id: u8, bytes: &'b [u8]) -> Option<&'b [u8]> {
        let (mut data, rest) = bytes.split_at_checked(data_len(id)?)?;
        for id in members(id)? {
            let format = format(id)?;
            let (own, after) = data.split_at_checked(usize::from(format.n_bytes))?;
            data = after;
            self.set(id, number(own, format.signed));
        }
        Some(rest)
    }
}

/// The number of one or two bytes.
fn number(bytes: &[u8], signed: bool) -> i32 {
    match (bytes, signed) {
        (&[low], false) => low.into(),
        (&[low], true) => low.cast_signed().into(),
        (&[high, low, ..], false) => u16::from_be_bytes([high, low]).into(),
        (&[high, low, ..], true) => i16::from_be_bytes([high, low]).into(),
        ([], _) => 0,
    }
}
