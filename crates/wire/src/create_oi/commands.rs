//! Commands: what a client may say, and the robot's reading of it.

use crate::search::{Found, Search};

/// Speeds of the line in bits per second, by the code of [`Command::Baud`].
pub const BAUDS: [u32; 12] =
    [300, 600, 1200, 2400, 4800, 9600, 14_400, 19_200, 28_800, 38_400, 57_600, 115_200];

/// The radius of [`Command::Drive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radius {
    /// Straight on: 8000 or 7FFF hex.
    Straight,
    /// On the spot, clockwise: −1.
    Clockwise,
    /// On the spot, counter-clockwise: 1.
    CounterClockwise,
    /// An arc, mm from its centre to the robot's, positive to the left; the robot takes up to ±2000.
    Arc(i16),
}

/// What a client can say.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(
    missing_docs,
    reason = "the names are those of the specification; fields are named by unit"
)]
pub enum Command {
    /// 7: boots anew; the interface is off then.
    Reset,
    /// 128: begins the interface, in passive mode.
    Start,
    /// 129: another speed of the line, by its code in [`BAUDS`].
    Baud(u8),
    /// 131, or 130 (CONTROL) of older robots: safe mode.
    Safe,
    /// 132: full mode, in which nothing stops it.
    Full,
    /// 133: switches the robot off.
    Power,
    /// 134: cleans a spot.
    Spot,
    /// 135: cleans.
    Clean,
    /// 136: cleans until the battery is empty.
    Max,
    /// 137: a speed and a radius.
    Drive { speed_mmps: i16, radius: Radius },
    /// 138: brushes and vacuum.
    Motors(u8),
    /// 139: light emitting diodes; colour and brightness of the big one.
    Leds { bits: u8, colour: u8, intensity: u8 },
    /// 140: stores a song of pairs (note, duration in 1/64 s).
    Song { number: u8, notes: Vec<[u8; 2]> },
    /// 141: plays one.
    Play(u8),
    /// 142: a packet, or a group, once.
    Sensors(u8),
    /// 143: seeks the home base.
    Dock,
    /// 144: duty of main brush, side brush, vacuum.
    PwmMotors([u8; 3]),
    /// 145: a speed for each wheel.
    DriveDirect { right_mmps: i16, left_mmps: i16 },
    /// 146: duty of each wheel, ±255.
    DrivePwm { right: i16, left: i16 },
    /// 148: these packets every 15 ms.
    Stream(Vec<u8>),
    /// 149: these packets once.
    QueryList(Vec<u8>),
    /// 150: holds the stream, or lets it go on.
    Pause { streams: bool },
    /// 162: lights of the schedule.
    SchedulingLeds([u8; 2]),
    /// 163: segments of the display.
    DigitLedsRaw([u8; 4]),
    /// 164: characters of the display.
    DigitLedsAscii([u8; 4]),
    /// 165: presses buttons for a sixth of a second.
    Buttons(u8),
    /// 167: a schedule of cleaning.
    Schedule([u8; 15]),
    /// 168: day, hour, minute.
    SetDayTime([u8; 3]),
    /// 173: ends the interface.
    Stop,
}

impl Radius {
    /// From its two bytes.
    pub fn of_wire(radius_mm: i16) -> Self {
        match radius_mm {
            i16::MIN | i16::MAX => Self::Straight,
            -1 => Self::Clockwise,
            1 => Self::CounterClockwise,
            arc => Self::Arc(arc),
        }
    }

    /// As two bytes.
    pub fn to_wire(self) -> i16 {
        match self {
            Self::Straight => i16::MIN,
            Self::Clockwise => -1,
            Self::CounterClockwise => 1,
            Self::Arc(radius_mm) => radius_mm,
        }
    }
}

impl Command {
    /// Its number.
    pub fn opcode(&self) -> u8 {
        match self {
            Self::Reset => 7,
            Self::Start => 128,
            Self::Baud(_) => 129,
            Self::Safe => 131,
            Self::Full => 132,
            Self::Power => 133,
            Self::Spot => 134,
            Self::Clean => 135,
            Self::Max => 136,
            Self::Drive { .. } => 137,
            Self::Motors(_) => 138,
            Self::Leds { .. } => 139,
            Self::Song { .. } => 140,
            Self::Play(_) => 141,
            Self::Sensors(_) => 142,
            Self::Dock => 143,
            Self::PwmMotors(_) => 144,
            Self::DriveDirect { .. } => 145,
            Self::DrivePwm { .. } => 146,
            Self::Stream(_) => 148,
            Self::QueryList(_) => 149,
            Self::Pause { .. } => 150,
            Self::SchedulingLeds(_) => 162,
            Self::DigitLedsRaw(_) => 163,
            Self::DigitLedsAscii(_) => 164,
            Self::Buttons(_) => 165,
            Self::Schedule(_) => 167,
            Self::SetDayTime(_) => 168,
            Self::Stop => 173,
        }
    }

    /// Appends its bytes. Lists and songs of more than 255 entries are cut there.
    pub fn encode(&self, out: &mut Vec<u8>) {
        out.push(self.opcode());
        let mut two = |first: i16, second: i16| {
            out.extend_from_slice(&first.to_be_bytes());
            out.extend_from_slice(&second.to_be_bytes());
        };
        match self {
            Self::Drive { speed_mmps, radius } => two(*speed_mmps, radius.to_wire()),
            Self::DriveDirect { right_mmps, left_mmps } => two(*right_mmps, *left_mmps),
            Self::DrivePwm { right, left } => two(*right, *left),
            Self::Baud(byte)
            | Self::Motors(byte)
            | Self::Play(byte)
            | Self::Sensors(byte)
            | Self::Buttons(byte) => out.push(*byte),
            Self::Pause { streams } => out.push(u8::from(*streams)),
            Self::Leds { bits, colour, intensity } => {
                out.extend_from_slice(&[*bits, *colour, *intensity]);
            }
            Self::Song { number, notes } => {
                let notes = notes.get(..255).unwrap_or(notes);
                out.extend_from_slice(&[*number, notes.len() as u8]);
                out.extend(notes.iter().flatten());
            }
            Self::Stream(ids) | Self::QueryList(ids) => {
                let ids = ids.get(..255).unwrap_or(ids);
                out.push(ids.len() as u8);
                out.extend_from_slice(ids);
            }
            Self::PwmMotors(bytes) | Self::SetDayTime(bytes) => out.extend_from_slice(bytes),
            Self::SchedulingLeds(bytes) => out.extend_from_slice(bytes),
            Self::DigitLedsRaw(bytes) | Self::DigitLedsAscii(bytes) => out.extend_from_slice(bytes),
            Self::Schedule(bytes) => out.extend_from_slice(bytes),
            Self::Reset
            | Self::Start
            | Self::Safe
            | Self::Full
            | Self::Power
            | Self::Spot
            | Self::Clean
            | Self::Max
            | Self::Dock
            | Self::Stop => {}
        }
    }

    /// The command that `bytes` begins with, and the bytes after it.
    fn read(bytes: &[u8]) -> Read<'_> {
        let Some((&opcode, data)) = bytes.split_first() else { return Read::Unfinished };
        let n_data = match opcode {
            7 | 128 | 130..=136 | 143 | 173 => 0,
            129 | 138 | 141 | 142 | 150 | 165 => 1,
            162 => 2,
            139 | 144 | 168 => 3,
            137 | 145 | 146 | 163 | 164 => 4,
            167 => 15,
            140 => match data.get(1) {
                Some(&n_notes) => usize::from(n_notes).saturating_mul(2).saturating_add(2),
                None => return Read::Unfinished,
            },
            148 | 149 => match data.first() {
                Some(&n_ids) => usize::from(n_ids).saturating_add(1),
                None => return Read::Unfinished,
            },
            _ => return Read::Unknown(opcode),
        };
        let Some((data, rest)) = data.split_at_checked(n_data) else { return Read::Unfinished };
        match Self::of_parts(opcode, data) {
            Some(command) => Read::Command(command, rest),
            None => Read::Unknown(opcode),
        }
    }

    fn of_parts(opcode: u8, data: &[u8]) -> Option<Self> {
        let word = |at: usize| Some(i16::from_be_bytes(*data.get(at..)?.first_chunk()?));
        let byte = || data.first().copied();
        Some(match opcode {
            7 => Self::Reset,
            128 => Self::Start,
            129 => Self::Baud(byte()?),
            130 | 131 => Self::Safe,
            132 => Self::Full,
            133 => Self::Power,
            134 => Self::Spot,
            135 => Self::Clean,
            136 => Self::Max,
            137 => Self::Drive { speed_mmps: word(0)?, radius: Radius::of_wire(word(2)?) },
            138 => Self::Motors(byte()?),
            139 => {
                let &[bits, colour, intensity] = data.first_chunk()?;
                Self::Leds { bits, colour, intensity }
            }
            140 => {
                let (notes, _) = data.get(2..)?.as_chunks::<2>();
                Self::Song { number: byte()?, notes: notes.to_vec() }
            }
            141 => Self::Play(byte()?),
            142 => Self::Sensors(byte()?),
            143 => Self::Dock,
            144 => Self::PwmMotors(*data.first_chunk()?),
            145 => Self::DriveDirect { right_mmps: word(0)?, left_mmps: word(2)? },
            146 => Self::DrivePwm { right: word(0)?, left: word(2)? },
            148 => Self::Stream(data.get(1..)?.to_vec()),
            149 => Self::QueryList(data.get(1..)?.to_vec()),
            150 => Self::Pause { streams: byte()? != 0 },
            162 => Self::SchedulingLeds(*data.first_chunk()?),
            163 => Self::DigitLedsRaw(*data.first_chunk()?),
            164 => Self::DigitLedsAscii(*data.first_chunk()?),
            165 => Self::Buttons(byte()?),
            167 => Self::Schedule(*data.first_chunk()?),
            168 => Self::SetDayTime(*data.first_chunk()?),
            173 => Self::Stop,
            _ => return None,
        })
    }
}

enum Read<'b> {
    Command(Command, &'b [u8]),
    Unfinished,
    Unknown(u8),
}

/// The robot's reading of received bytes.
///
/// A byte where an opcode should be and that is none is dropped, counted and remembered; a command that has begun
/// waits for its data however long that takes, because nothing on the wire tells it from other bytes.
#[derive(Clone, Debug)]
pub struct CommandDecoder {
    search: Search,
    dropped: Vec<u8>,
}

/// Dropped bytes that are remembered until they are asked for.
const N_DROPPED_MAX: usize = 256;

/// Bytes kept waiting at most: far more than the longest command, a song of 255 notes.
const PENDING_MAX: usize = 1 << 14;

impl Default for CommandDecoder {
    fn default() -> Self {
        Self::new()
    }
}

impl CommandDecoder {
    /// A decoder that has room for a usual burst of bytes already.
    pub fn new() -> Self {
        Self { search: Search::keeping(PENDING_MAX), dropped: Vec::new() }
    }

    /// Appends received bytes. Of more than 16 384 bytes not yet asked for, the oldest are dropped and counted.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole command, or `None` until more bytes come.
    pub fn next_command(&mut self) -> Option<Command> {
        let dropped = &mut self.dropped;
        let examine = |bytes: &[u8]| match Command::read(bytes) {
            Read::Command(command, rest) => {
                Found::Whole(command, bytes.len().saturating_sub(rest.len()))
            }
            Read::Unfinished => Found::Unfinished,
            Read::Unknown(byte) => {
                if dropped.len() < N_DROPPED_MAX {
                    dropped.push(byte);
                }
                Found::Noise
            }
        };
        // Any byte may be an opcode; which are not says the table of commands.
        self.search.next(|_| true, examine)
    }

    /// The bytes dropped since the last call, the first 256 of them.
    pub fn take_dropped(&mut self) -> impl Iterator<Item = u8> + '_ {
        self.dropped.drain(..)
    }

    /// Bytes that were no opcode where one should be, so far.
    pub fn bytes_dropped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Whether a command has begun and not ended.
    pub fn has_unfinished(&self) -> bool {
        self.search.has_unfinished()
    }

    /// Forgets a command that has begun.
    pub fn clear(&mut self) {
        self.search.clear();
    }
}
