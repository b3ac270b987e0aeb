//! What a client may ask of the robot.

use super::{BODY_LEN_MAX, BodyLength, fields::Fields, write_packet};

const POSITIVE: u8 = 0x3B;
const NEGATIVE: u8 = 0x1B;
const STRING: u8 = 0x2B;

/// Longest string argument, bytes: a body less number, type and length.
const STRING_LEN_MAX: usize = BODY_LEN_MAX - 3;

/// A client's command. The protocol's units are in the variants' documents; headings and turn
/// rates are counter-clockwise positive.
///
/// SYNC0 and PULSE share number 0, SYNC1 and OPEN number 1, SYNC2 and CLOSE number 2. Here the
/// SYNCs have no argument while OPEN and CLOSE carry the argument 1, as the manufacturer's library
/// sends them; a bare 0 decodes as [`Command::Sync0`], so `Pulse` alone does not come back as
/// itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// First step of connecting; the same byte as [`Command::Pulse`].
    Sync0,
    /// Second step of connecting; the same byte as OPEN without an argument.
    Sync1,
    /// Third step of connecting; the same byte as CLOSE without an argument.
    Sync2,
    /// Nothing, so that the watchdog sees a packet.
    Pulse,
    /// Starts the server: information packets begin.
    Open,
    /// Ends the session.
    Close,
    /// The order in which sonars fire, sensor numbers plus one as bytes.
    Polling(Vec<u8>),
    /// Motors on (other than 0) or off (0).
    Enable(i16),
    /// Translational acceleration, mm/s²; deceleration when negative.
    SetA(i16),
    /// Greatest translational speed, mm/s.
    SetV(i16),
    /// Makes the present pose the origin of the robot's odometry.
    SetO,
    /// Moves so many millimetres straight; backwards when negative.
    Move(i16),
    /// Turns at so many degrees per second.
    Rotate(i16),
    /// Greatest rotational speed, deg/s.
    SetRv(i16),
    /// Translational speed, mm/s.
    Vel(i16),
    /// Turns to an absolute heading, degrees.
    Head(i16),
    /// Turns by so many degrees, relative to the present heading.
    DHead(i16),
    /// Plays tones: pairs of duration and pitch.
    Say(Vec<u8>),
    /// Asks for the configuration packet.
    Config,
    /// Encoder packets: 0 none, 1 one, 2 one with each information packet.
    Encoder(i16),
    /// Rotational speed, deg/s.
    RVel(i16),
    /// Turns by so many degrees, relative to the heading setpoint.
    DcHead(i16),
    /// Rotational acceleration, deg/s²; deceleration when negative.
    SetRa(i16),
    /// Sonar arrays on (1) or off (0). Bits 1 and up pick one array.
    Sonar(i16),
    /// Stops, decelerating as usual.
    Stop,
    /// Sets digital outputs: high byte the mask, low byte the values.
    DigOut(u16),
    /// Wheel speeds in steps of 20 mm/s.
    Vel2 {
        /// Left wheel, 20 mm/s.
        left: i8,
        /// Right wheel, 20 mm/s.
        right: i8,
    },
    /// What the gripper should do: 1 open, 2 close, 3 stop, 4 lift up, 5 down and others.
    Gripper(i16),
    /// Selects the analogue port reported in the information packets.
    AdSel(i16),
    /// The value that belongs to the last gripper command.
    GripperVal(i16),
    /// Gripper packets: 0 none, 1 one, 2 continuous.
    GripRequest(i16),
    /// Input and output packets: 0 none, 1 one, 2 continuous.
    IoRequest(i16),
    /// Treats bumper contact as a stall: 0 never, 1 front, 2 rear, 3 both.
    BumpStall(i16),
    /// Speed of the host port: 0 to 4 for 9600, 19 200, 38 400, 57 600, 115 200 baud.
    HostBaud(i16),
    /// Stops at once, without the deceleration limit.
    EStop,
    /// Battery packets: 0 none, 1 one, 2 continuous.
    BatteryInfo(i16),
    /// Plays a stored sound.
    Sound(i16),
    /// Sounds on (1) or off (0).
    SoundTog(i16),
    /// Simulated robots only: puts the true robot there; odometry does not notice.
    SimSetPose {
        /// x in the world, mm.
        x_mm: i32,
        /// y in the world, mm.
        y_mm: i32,
        /// Heading in the world, degrees.
        heading_deg: i32,
    },
    /// Simulated robots only: puts the true robot back where it began, and its odometry to zero.
    SimReset,
    /// Simulated robots only: packets with the true pose: 0 none, 1 one, 2 one before each
    /// information packet. Without an argument: one.
    SimStat(i16),
    /// Simulated robots only: a text for whoever watches the simulator.
    SimMessage(Vec<u8>),
    /// Simulated robots only: ends the simulator with this exit code.
    SimExit(i16),
    /// Pretends that the battery has this voltage, tenths of a volt.
    BatTest(i16),
    /// A command this codec has no name for; its argument is not read.
    Other {
        /// The command number.
        number: u8,
    },
}

/// Why a body is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// There is no command number.
    #[error("empty body; a command begins with its number")]
    Empty,
    /// The body ends before the argument does.
    #[error("command {number}: the body ends inside its argument, which is missing or cut short")]
    ArgumentMissing {
        /// The command number.
        number: u8,
    },
    /// The argument is not of the type that the command takes.
    #[error("command {number}: argument type {argument_type:#04x}; it takes {expected}")]
    ArgumentType {
        /// The command number.
        number: u8,
        /// The type byte found.
        argument_type: u8,
        /// What the command takes.
        expected: &'static str,
    },
    /// The argument does not fit 16 bits with a sign.
    #[error("command {number}: argument {value} is outside -32768 to 32767")]
    ArgumentRange {
        /// The command number.
        number: u8,
        /// The argument's value.
        value: i32,
    },
}

impl Command {
    /// The number that begins the command's body.
    pub fn number(&self) -> u8 {
        match self {
            Self::Sync0 | Self::Pulse => 0,
            Self::Sync1 | Self::Open => 1,
            Self::Sync2 | Self::Close => 2,
            Self::Polling(_) => 3,
            Self::Enable(_) => 4,
            Self::SetA(_) => 5,
            Self::SetV(_) => 6,
            Self::SetO => 7,
            Self::Move(_) => 8,
            Self::Rotate(_) => 9,
            Self::SetRv(_) => 10,
            Self::Vel(_) => 11,
            Self::Head(_) => 12,
            Self::DHead(_) => 13,
            Self::Say(_) => 15,
            Self::Config => 18,
            Self::Encoder(_) => 19,
            Self::RVel(_) => 21,
            Self::DcHead(_) => 22,
            Self::SetRa(_) => 23,
            Self::Sonar(_) => 28,
            Self::Stop => 29,
            Self::DigOut(_) => 30,
            Self::Vel2 { .. } => 32,
            Self::Gripper(_) => 33,
            Self::AdSel(_) => 35,
            Self::GripperVal(_) => 36,
            Self::GripRequest(_) => 37,
            Self::IoRequest(_) => 40,
            Self::BumpStall(_) => 44,
            Self::HostBaud(_) => 50,
            Self::EStop => 55,
            Self::BatteryInfo(_) => 62,
            Self::Sound(_) => 90,
            Self::SoundTog(_) => 92,
            Self::SimSetPose { .. } => 224,
            Self::SimReset => 225,
            Self::SimStat(_) => 237,
            Self::SimMessage(_) => 238,
            Self::SimExit(_) => 239,
            Self::BatTest(_) => 250,
            Self::Other { number } => *number,
        }
    }

    /// Appends the command's packet to `out`.
    ///
    /// # Errors
    ///
    /// [`BodyLength`] when a string argument is longer than 195 bytes; `out` is left as it was.
    pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), BodyLength> {
        let number = self.number();
        match self {
            Self::Open | Self::Close => write_int(number, 1, out),
            Self::Polling(text) | Self::Say(text) | Self::SimMessage(text) => {
                write_string(number, text, out)
            }
            Self::Enable(value)
            | Self::SetA(value)
            | Self::SetV(value)
            | Self::Move(value)
            | Self::Rotate(value)
            | Self::SetRv(value)
            | Self::Vel(value)
            | Self::Head(value)
            | Self::DHead(value)
            | Self::Encoder(value)
            | Self::RVel(value)
            | Self::DcHead(value)
            | Self::SetRa(value)
            | Self::Sonar(value)
            | Self::Gripper(value)
            | Self::AdSel(value)
            | Self::GripperVal(value)
            | Self::GripRequest(value)
            | Self::IoRequest(value)
            | Self::BumpStall(value)
            | Self::HostBaud(value)
            | Self::BatteryInfo(value)
            | Self::Sound(value)
            | Self::SoundTog(value)
            | Self::SimStat(value)
            | Self::SimExit(value)
            | Self::BatTest(value) => write_int(number, *value, out),
            Self::DigOut(bits) => write_int(number, bits.cast_signed(), out),
            Self::Vel2 { left, right } => {
                let bytes = [right.cast_unsigned(), left.cast_unsigned()];
                write_int(number, i16::from_le_bytes(bytes), out)
            }
            Self::SimSetPose { x_mm, y_mm, heading_deg } => {
                // The simulator ignores the type byte; the manufacturer's library sends 0.
                let [a, b, c] = [x_mm, y_mm, heading_deg].map(|value| value.to_le_bytes());
                let mut body = [0; 14];
                let fields = [number, 0].into_iter().chain(a).chain(b).chain(c);
                body.iter_mut().zip(fields).for_each(|(place, byte)| *place = byte);
                write_packet(&body, out)
            }
            Self::Sync0
            | Self::Sync1
            | Self::Sync2
            | Self::Pulse
            | Self::SetO
            | Self::Config
            | Self::Stop
            | Self::EStop
            | Self::SimReset
            | Self::Other { .. } => write_packet(&[number], out),
        }
    }

    /// Reads the command that a packet's body carries. Bytes after the argument are ignored, as the
    /// robot does.
    ///
    /// # Errors
    ///
    /// A [`CommandError`] when the body is empty or its argument is missing, of another type or out
    /// of range.
    pub fn decode(body: &[u8]) -> Result<Self, CommandError> {
        let (&number, rest) = body.split_first().ok_or(CommandError::Empty)?;
        let int = || integer(number, rest);
        Ok(match number {
            0 => Self::Sync0,
            1 if rest.is_empty() => Self::Sync1,
            1 => Self::Open,
            2 if rest.is_empty() => Self::Sync2,
            2 => Self::Close,
            3 => Self::Polling(string(number, rest)?),
            4 => Self::Enable(int()?),
            5 => Self::SetA(int()?),
            6 => Self::SetV(int()?),
            7 => Self::SetO,
            8 => Self::Move(int()?),
            9 => Self::Rotate(int()?),
            10 => Self::SetRv(int()?),
            11 => Self::Vel(int()?),
            12 => Self::Head(int()?),
            13 => Self::DHead(int()?),
            15 => Self::Say(string(number, rest)?),
            18 => Self::Config,
            19 => Self::Encoder(int()?),
            21 => Self::RVel(int()?),
            22 => Self::DcHead(int()?),
            23 => Self::SetRa(int()?),
            28 => Self::Sonar(int()?),
            29 => Self::Stop,
            30 => Self::DigOut(bits(number, rest)?),
            32 => {
                let [right, left] = bits(number, rest)?.to_le_bytes();
                Self::Vel2 { left: left.cast_signed(), right: right.cast_signed() }
            }
            33 => Self::Gripper(int()?),
            35 => Self::AdSel(int()?),
            36 => Self::GripperVal(int()?),
            37 => Self::GripRequest(int()?),
            40 => Self::IoRequest(int()?),
            44 => Self::BumpStall(int()?),
            50 => Self::HostBaud(int()?),
            55 => Self::EStop,
            62 => Self::BatteryInfo(int()?),
            90 => Self::Sound(int()?),
            92 => Self::SoundTog(int()?),
            224 => sim_pose(rest).ok_or(CommandError::ArgumentMissing { number })?,
            225 => Self::SimReset,
            237 if rest.is_empty() => Self::SimStat(1),
            237 => Self::SimStat(int()?),
            238 => Self::SimMessage(string(number, rest)?),
            239 => Self::SimExit(int()?),
            250 => Self::BatTest(int()?),
            _ => Self::Other { number },
        })
    }
}

fn write_int(number: u8, value: i16, out: &mut Vec<u8>) -> Result<(), BodyLength> {
    let argument_type = if value < 0 { NEGATIVE } else { POSITIVE };
    let [low, high] = value.unsigned_abs().to_le_bytes();
    write_packet(&[number, argument_type, low, high], out)
}

fn write_string(number: u8, text: &[u8], out: &mut Vec<u8>) -> Result<(), BodyLength> {
    let too_long = BodyLength { len: text.len().saturating_add(3) };
    let len = u8::try_from(text.len()).map_err(|_overflow| too_long)?;
    let mut body = [0; BODY_LEN_MAX];
    let place = body.get_mut(..usize::from(len).saturating_add(3)).ok_or(too_long)?;
    let fields = [number, STRING, len].into_iter().chain(text.iter().copied());
    place.iter_mut().zip(fields).for_each(|(place, byte)| *place = byte);
    write_packet(place, out)
}

/// Sign and magnitude of an integer argument.
fn signed(number: u8, rest: &[u8]) -> Result<i32, CommandError> {
    let mut fields = Fields::new(rest);
    let missing = CommandError::ArgumentMissing { number };
    let argument_type = fields.u8().ok_or(missing)?;
    let magnitude = i32::from(fields.u16().ok_or(missing)?);
    match argument_type {
        POSITIVE => Ok(magnitude),
        NEGATIVE => Ok(magnitude.wrapping_neg()),
        _ => Err(CommandError::ArgumentType {
            number,
            argument_type,
            expected: "an integer (0x3b positive, 0x1b negative)",
        }),
    }
}

fn integer(number: u8, rest: &[u8]) -> Result<i16, CommandError> {
    let value = signed(number, rest)?;
    i16::try_from(value).map_err(|_overflow| CommandError::ArgumentRange { number, value })
}

/// Sixteen bits that are no number. The manufacturer's library, and this codec, send them as a
/// signed number all the same, a magnitude when the top bit is set; other clients leave the bits
/// alone.
fn bits(number: u8, rest: &[u8]) -> Result<u16, CommandError> {
    let value = signed(number, rest)?;
    // Two's complement: the low 16 bits are what was meant, whatever the sign.
    Ok(value as u16)
}

fn string(number: u8, rest: &[u8]) -> Result<Vec<u8>, CommandError> {
    let mut fields = Fields::new(rest);
    let missing = CommandError::ArgumentMissing { number };
    let argument_type = fields.u8().ok_or(missing)?;
    if argument_type != STRING {
        let expected = "a string (0x2b)";
        return Err(CommandError::ArgumentType { number, argument_type, expected });
    }
    let len = fields.u8().ok_or(missing)?;
    fields.bytes(len.into()).map(<[u8]>::to_vec).ok_or(missing)
}

fn sim_pose(rest: &[u8]) -> Option<Command> {
    let mut fields = Fields::new(rest);
    fields.u8()?;
    let (x_mm, y_mm, heading_deg) = (fields.i32()?, fields.i32()?, fields.i32()?);
    Some(Command::SimSetPose { x_mm, y_mm, heading_deg })
}

const _: () = assert!(STRING_LEN_MAX == 195, "the error's document says 195");
