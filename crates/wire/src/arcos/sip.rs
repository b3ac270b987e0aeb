//! What the robot sends: the standard server information packet, echoes and the rest.

use super::{
    BodyLength, ConfigPac, EncoderPac, GripperPac, IoPac, SimStatPac,
    fields::{Fields, push_string},
    report_error::ReportError,
    write_packet,
};

const STOPPED: u8 = 0x32;
const MOVING: u8 = 0x33;

/// Most readings that one packet has room for beside all other fields.
const N_READINGS_MAX: usize = 54;

/// Bytes of the fields that are always there, the sonar count included.
const FIXED_LEN: usize = 20;

/// Heading units in one turn.
const UNITS_PER_TURN: f64 = 4096.0;

/// One sonar reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SonarReading {
    /// The sensor's number, from 0.
    pub sensor: u8,
    /// Distance to the echo, mm.
    pub range_mm: u16,
}

/// The ports of the robot's input and output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IoFields {
    /// The analogue port whose value follows.
    pub analogue_port: u16,
    /// Value of that port, 0 to 255 for 0 to 5 V.
    pub analogue: u8,
    /// Digital inputs, one bit each.
    pub digital_in: u8,
    /// Digital outputs, one bit each.
    pub digital_out: u8,
}

/// Battery and rotation as newer firmware reports them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PowerFields {
    /// Battery voltage, tenths of a volt; unlike [`Sip::battery_decivolts`] it does not end at 25.5
    /// V.
    pub battery_decivolts: u16,
    /// 0 not charging, 1 bulk, 2 overcharge, 3 float.
    pub charge_state: u8,
    /// Rotational velocity, tenths of a degree per second, counter-clockwise positive.
    pub rotation_decidegps: i16,
}

/// The standard server information packet: what a robot tells its client every 100 ms.
///
/// The three optional parts follow each other: the first that is absent ends the packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sip {
    /// Whether the motors are moving (packet type 0x33) or stopped (0x32).
    pub moving: bool,
    /// x in the robot's own odometry, mm (distance factor 1.0); 15 bits, wraps at 32 768.
    pub x_mm: u16,
    /// y in the robot's own odometry, mm; 15 bits, wraps at 32 768.
    pub y_mm: u16,
    /// Heading, 1/4096 turn, counter-clockwise positive.
    pub heading_units: i16,
    /// Left wheel speed, mm/s.
    pub left_mmps: i16,
    /// Right wheel speed, mm/s.
    pub right_mmps: i16,
    /// Battery voltage, tenths of a volt.
    pub battery_decivolts: u8,
    /// Left wheel: bit 0 stalled; the others, bumpers of the rear, clockwise.
    pub stall_left: u8,
    /// Right wheel: bit 0 stalled; the others, bumpers of the front, clockwise: bit 1 is the
    /// leftmost.
    pub stall_right: u8,
    /// The heading the robot servos to, 1/4096 turn.
    pub control_units: i16,
    /// Bit 0 motors enabled, bits 1 to 4 sonar arrays on, 5 stop button and others.
    pub flags: u16,
    /// Compass heading, steps of 2°.
    pub compass: u8,
    /// Ports, if sent.
    pub io: Option<IoFields>,
    /// Battery and rotation, if sent.
    pub power: Option<PowerFields>,
    /// Fault flags, if sent.
    pub faults: Option<u16>,
    /// Sonar readings new since the last packet; see [`Sip::sonar`] and [`Sip::push_sonar`].
    pub readings: SonarReadings,
}

/// A robot's packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Report {
    /// Answer to the first step of connecting.
    Sync0,
    /// Answer to the second step of connecting.
    Sync1,
    /// Answer to the third step: who the robot is.
    Sync2 {
        /// The robot's own name.
        name: String,
        /// Its class, `Pioneer`.
        class: String,
        /// Its model; the client picks its parameters by it.
        subclass: String,
    },
    /// Standard information.
    Sip(Sip),
    /// The configuration that was asked for.
    Config(ConfigPac),
    /// The encoder counts that were asked for.
    Encoder(EncoderPac),
    /// The ports that were asked for.
    Io(IoPac),
    /// The gripper that was asked for.
    Gripper(GripperPac),
    /// What only a simulator knows.
    SimStat(SimStatPac),
    /// A packet this codec has no name for.
    Other {
        /// The type byte.
        kind: u8,
    },
}

impl Sip {
    /// A robot that stands at its origin, motors off, nothing heard, nothing optional.
    pub const AT_REST: Self = Self {
        moving: false,
        x_mm: 0,
        y_mm: 0,
        heading_units: 0,
        left_mmps: 0,
        right_mmps: 0,
        battery_decivolts: 120,
        stall_left: 0,
        stall_right: 0,
        control_units: 0,
        flags: 0,
        compass: 0,
        io: None,
        power: None,
        faults: None,
        readings: SonarReadings::NONE,
    };

    /// Sonar readings new since the last packet.
    pub fn sonar(&self) -> &[SonarReading] {
        self.readings.as_slice()
    }

    /// Adds a sonar reading; `false`, and nothing added, when the packet is full (54 readings).
    #[must_use]
    pub fn push_sonar(&mut self, reading: SonarReading) -> bool {
        let SonarReadings { items, len } = &mut self.readings;
        let Some(place) = items.get_mut(usize::from(*len)) else { return false };
        *place = reading;
        *len = len.saturating_add(1);
        true
    }

    /// Removes all sonar readings.
    pub fn clear_sonar(&mut self) {
        self.readings = SonarReadings::NONE;
    }

    /// Whether either wheel reports a stall.
    pub fn stalled(&self) -> bool {
        (self.stall_left | self.stall_right) & 1 != 0
    }

    /// Front and rear bumpers that are pressed: bit 0 is the first of each, counted clockwise.
    pub fn bumpers(&self) -> [u8; 2] {
        [self.stall_right >> 1, self.stall_left >> 1]
    }

    /// Heading, radians in [−π, π).
    pub fn heading_rad(&self) -> f64 {
        radians(self.heading_units)
    }

    /// The heading the robot servos to, radians in [−π, π).
    pub fn control_rad(&self) -> f64 {
        radians(self.control_units)
    }

    /// The protocol's units for a heading: −2048 to 2047 for [−π, π).
    pub fn heading_to_units(heading_rad: f64) -> i16 {
        let units = (heading_rad / std::f64::consts::TAU * UNITS_PER_TURN).round();
        // The remainder lies within ±2048, so the cast loses nothing.
        let wrapped = (units + UNITS_PER_TURN / 2.0).rem_euclid(UNITS_PER_TURN);
        (wrapped - UNITS_PER_TURN / 2.0) as i16
    }

    /// Appends the packet to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let mut body = Body::default();
        body.put([if self.moving { MOVING } else { STOPPED }]);
        body.put(self.x_mm.to_le_bytes());
        body.put(self.y_mm.to_le_bytes());
        body.put(self.heading_units.to_le_bytes());
        body.put(self.left_mmps.to_le_bytes());
        body.put(self.right_mmps.to_le_bytes());
        body.put([self.battery_decivolts, self.stall_left, self.stall_right]);
        body.put(self.control_units.to_le_bytes());
        body.put(self.flags.to_le_bytes());
        body.put([self.compass, self.readings.len]);
        for reading in self.sonar() {
            body.put([reading.sensor]);
            body.put(reading.range_mm.to_le_bytes());
        }
        self.encode_tail(&mut body);
        let written = write_packet(body.as_slice(), out);
        debug_assert!(written.is_ok(), "54 readings and all options fit a packet");
    }

    fn encode_tail(&self, body: &mut Body) {
        let Some(io) = self.io else { return };
        body.put(io.analogue_port.to_le_bytes());
        body.put([io.analogue, io.digital_in, io.digital_out]);
        let Some(power) = self.power else { return };
        body.put(power.battery_decivolts.to_le_bytes());
        body.put([power.charge_state]);
        body.put(power.rotation_decidegps.to_le_bytes());
        let Some(faults) = self.faults else { return };
        body.put(faults.to_le_bytes());
    }

    /// Reads the packet's body. What follows the known fields is ignored.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is neither 0x32 nor 0x33, or the fields that are always there
    /// are cut short.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let mut fields = Fields::new(body);
        let kind = fields.u8().ok_or(ReportError::Empty)?;
        if kind != STOPPED && kind != MOVING {
            return Err(ReportError::Kind { kind, expected: "0x32 or 0x33" });
        }
        let cut = |field| ReportError::CutShort { kind, len: body.len(), field };
        let mut sip = fixed_fields(kind == MOVING, &mut fields).ok_or(cut("fixed fields"))?;
        let n_readings = fields.u8().ok_or(cut("sonar count"))?;
        for _ in 0..n_readings {
            let sensor = fields.u8().ok_or(cut("sonar readings"))?;
            let range_mm = fields.u16().ok_or(cut("sonar readings"))?;
            if !sip.push_sonar(SonarReading { sensor, range_mm }) {
                return Err(cut("sonar readings"));
            }
        }
        sip.io = io_fields(&mut fields);
        sip.power = sip.io.and_then(|_| power_fields(&mut fields));
        sip.faults = sip.power.and_then(|_| fields.u16());
        Ok(sip)
    }
}

impl Default for Sip {
    fn default() -> Self {
        Self::AT_REST
    }
}

impl Report {
    /// Reads the body of a robot's packet.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the body is empty or its fields are cut short.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let &kind = body.first().ok_or(ReportError::Empty)?;
        Ok(match kind {
            0 => Self::Sync0,
            1 => Self::Sync1,
            2 => {
                let mut fields = Fields::new(body.get(1..).unwrap_or_default());
                let mut text = |field| {
                    let cut = ReportError::CutShort { kind, len: body.len(), field };
                    fields.string().ok_or(cut)
                };
                Self::Sync2 {
                    name: text("name")?,
                    class: text("class")?,
                    subclass: text("subclass")?,
                }
            }
            STOPPED | MOVING => Self::Sip(Sip::decode(body)?),
            ConfigPac::KIND => Self::Config(ConfigPac::decode(body)?),
            EncoderPac::KIND => Self::Encoder(EncoderPac::decode(body)?),
            IoPac::KIND => Self::Io(IoPac::decode(body)?),
            GripperPac::KIND => Self::Gripper(GripperPac::decode(body)?),
            SimStatPac::KIND => Self::SimStat(SimStatPac::decode(body)?),
            _ => Self::Other { kind },
        })
    }

    /// Appends the packet to `out`.
    ///
    /// # Errors
    ///
    /// [`BodyLength`] when the strings are too long for one packet; `out` is left as it was.
    pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), BodyLength> {
        match self {
            Self::Sync0 => write_packet(&[0], out),
            Self::Sync1 => write_packet(&[1], out),
            Self::Sync2 { name, class, subclass } => {
                let mut body = vec![2];
                for text in [name, class, subclass] {
                    push_string(text, &mut body);
                }
                write_packet(&body, out)
            }
            Self::Sip(sip) => {
                sip.encode(out);
                Ok(())
            }
            Self::Config(config) => config.encode(out),
            Self::Encoder(encoder) => {
                encoder.encode(out);
                Ok(())
            }
            Self::Io(io) => {
                io.encode(out);
                Ok(())
            }
            Self::Gripper(gripper) => {
                gripper.encode(out);
                Ok(())
            }
            Self::SimStat(stat) => {
                stat.encode(out);
                Ok(())
            }
            Self::Other { kind } => write_packet(&[*kind], out),
        }
    }
}

/// The sonar readings of one packet, at most 54, in a fixed place.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SonarReadings {
    items: [SonarReading; N_READINGS_MAX],
    len: u8,
}

impl SonarReadings {
    /// No readings.
    pub const NONE: Self =
        Self { items: [SonarReading { sensor: 0, range_mm: 0 }; N_READINGS_MAX], len: 0 };

    /// The readings in the packet's order.
    pub fn as_slice(&self) -> &[SonarReading] {
        self.items.get(..usize::from(self.len)).unwrap_or_default()
    }
}

impl std::fmt::Debug for SonarReadings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.as_slice().fmt(f)
    }
}

/// A body under construction, without allocation.
struct Body {
    bytes: [u8; super::BODY_LEN_MAX],
    len: usize,
}

impl Default for Body {
    fn default() -> Self {
        Self { bytes: [0; super::BODY_LEN_MAX], len: 0 }
    }
}

impl Body {
    fn put<const N: usize>(&mut self, field: [u8; N]) {
        let end = self.len.saturating_add(N);
        debug_assert!(end <= self.bytes.len(), "the fields fit a packet");
        if let Some(place) = self.bytes.get_mut(self.len..end) {
            place.copy_from_slice(&field);
            self.len = end;
        }
    }

    fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

fn fixed_fields(moving: bool, fields: &mut Fields<'_>) -> Option<Sip> {
    Some(Sip {
        moving,
        x_mm: fields.u16()?,
        y_mm: fields.u16()?,
        heading_units: fields.i16()?,
        left_mmps: fields.i16()?,
        right_mmps: fields.i16()?,
        battery_decivolts: fields.u8()?,
        stall_left: fields.u8()?,
        stall_right: fields.u8()?,
        control_units: fields.i16()?,
        flags: fields.u16()?,
        compass: fields.u8()?,
        ..Sip::AT_REST
    })
}

fn io_fields(fields: &mut Fields<'_>) -> Option<IoFields> {
    Some(IoFields {
        analogue_port: fields.u16()?,
        analogue: fields.u8()?,
        digital_in: fields.u8()?,
        digital_out: fields.u8()?,
    })
}

fn power_fields(fields: &mut Fields<'_>) -> Option<PowerFields> {
    Some(PowerFields {
        battery_decivolts: fields.u16()?,
        charge_state: fields.u8()?,
        rotation_decidegps: fields.i16()?,
    })
}

fn radians(units: i16) -> f64 {
    let half = UNITS_PER_TURN / 2.0;
    let wrapped = (f64::from(units) + half).rem_euclid(UNITS_PER_TURN) - half;
    wrapped * std::f64::consts::TAU / UNITS_PER_TURN
}

// Fixed part, readings, ports (5), power (5), faults (2).
const _: () = assert!(FIXED_LEN + 3 * N_READINGS_MAX + 12 <= super::BODY_LEN_MAX);
