//! The packets about a robot's devices that it sends when asked: ports, gripper, and what only a
//! simulator knows.

use super::{ReportError, fields::Fields, write_packet};

/// Digital inputs of an [`IoPac`], bytes: the user port, front bumpers, rear bumpers, infrared.
const N_DIGITAL_IN: u8 = 4;
/// Digital outputs of an [`IoPac`], bytes.
const N_DIGITAL_OUT: u8 = 2;
/// Analogue inputs of an [`IoPac`].
const N_ANALOGUE: u8 = 9;

/// The robot's ports, asked for with IOREQUEST.
///
/// On the wire each group is preceded by how many there are; a client reads as many as it is told.
/// This one sends four bytes of inputs, two of outputs and nine analogue values; when reading, what
/// is missing stays zero and what is more is passed over.
///
/// Source: read off the client library AriaCoda (commit b0d02e0), which wants three counted groups,
/// infrared sensors in the fourth input byte, and no fixed sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IoPac {
    /// Inputs: user port, front bumpers, rear bumpers, infrared sensors (a set bit is quiet).
    pub digital_in: [u8; N_DIGITAL_IN as usize],
    /// Outputs.
    pub digital_out: [u8; N_DIGITAL_OUT as usize],
    /// Analogue inputs, 0 to 1023 for 0 to 5 V.
    pub analogue: [u16; N_ANALOGUE as usize],
}

/// What kind of gripper a robot has, and how it stands; asked for with GRIPREQUEST.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GripperPac {
    /// 0 none, 1 on the user port, 2 on the general port.
    pub kind: u8,
    /// Switches, one bit each.
    pub switches: u8,
    /// How hard it grasps, steps of 20 ms of pressing.
    pub grasp_time: u8,
}

/// What only a simulator knows, asked for with `SIM_STAT`.
///
/// Body: 0x62, two zero bytes, flags u32 (bit 0: there is a map), three intervals u16 ms, x, y, z
/// i32 mm, heading i32 deg, latitude, longitude, altitude i32 (zero here: flag bit 1 is clear),
/// quality of position i8 (−1: none), three errors i32 (zero here: flag bit 2 is clear). Then, ours,
/// because the format allows fields at the end: the world's bounds, four i32 mm.
///
/// Source: the manufacturer's wiki, "MobileSim true pose and other simulation-specific data"; the
/// README of its simulator for what follows the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SimStatPac {
    /// Whether there are walls.
    pub has_map: bool,
    /// Simulated time that one turn of the simulator's loop takes, ms.
    pub sim_interval_ms: u16,
    /// Real time that it should take, ms.
    pub real_interval_ms: u16,
    /// Real time that the last one took, ms.
    pub last_interval_ms: u16,
    /// Where the robot truly is, world frame, mm.
    pub x_mm: i32,
    /// Where the robot truly is, world frame, mm.
    pub y_mm: i32,
    /// Where it truly looks, world frame, whole degrees, −180 to 180.
    pub heading_deg: i32,
    /// Smallest x and y, largest x and y of the walls, mm; `None` when the packet ends before.
    pub bounds_mm: Option<[i32; 4]>,
}

impl IoPac {
    /// The packet's type byte.
    pub const KIND: u8 = 0xF0;

    /// Appends the packet to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let mut body = [0; 28];
        let analogue = self.analogue.iter().flat_map(|value| value.to_le_bytes());
        let bytes = [Self::KIND, N_DIGITAL_IN]
            .into_iter()
            .chain(self.digital_in)
            .chain([N_DIGITAL_OUT])
            .chain(self.digital_out)
            .chain([N_ANALOGUE])
            .chain(analogue);
        let len = fill(&mut body, bytes);
        let written = write_packet(body.get(..len).unwrap_or_default(), out);
        debug_assert!(written.is_ok(), "28 bytes fit a packet");
    }

    /// Reads the packet's body.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is not 0xF0 or a group is shorter than its count.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let (kind, mut fields) = open(body, Self::KIND, "0xf0")?;
        let cut = |field| ReportError::CutShort { kind, len: body.len(), field };
        let mut pac = Self::default();
        let mut group = |places: &mut [u8], field| {
            let n = fields.u8().ok_or(cut(field))?;
            let bytes = fields.bytes(n.into()).ok_or(cut(field))?;
            places.iter_mut().zip(bytes).for_each(|(place, &byte)| *place = byte);
            Ok::<(), ReportError>(())
        };
        group(&mut pac.digital_in, "digital inputs")?;
        group(&mut pac.digital_out, "digital outputs")?;
        let n = fields.u8().ok_or(cut("analogue inputs"))?;
        for index in 0..usize::from(n) {
            let value = fields.u16().ok_or(cut("analogue inputs"))?;
            if let Some(place) = pac.analogue.get_mut(index) {
                *place = value;
            }
        }
        Ok(pac)
    }
}

impl GripperPac {
    /// The packet's type byte.
    pub const KIND: u8 = 0xE0;

    /// Appends the packet to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let written = write_packet(&[Self::KIND, self.kind, self.switches, self.grasp_time], out);
        debug_assert!(written.is_ok(), "four bytes fit a packet");
    }

    /// Reads the packet's body.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is not 0xE0 or a field is missing.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let (kind, mut fields) = open(body, Self::KIND, "0xe0")?;
        let mut byte =
            |field| fields.u8().ok_or(ReportError::CutShort { kind, len: body.len(), field });
        Ok(Self {
            kind: byte("kind of gripper")?,
            switches: byte("switches")?,
            grasp_time: byte("grasp time")?,
        })
    }
}

impl SimStatPac {
    /// The packet's type byte.
    pub const KIND: u8 = 0x62;

    /// Appends the packet to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        let flags = u32::from(self.has_map).to_le_bytes();
        let intervals = [self.sim_interval_ms, self.real_interval_ms, self.last_interval_ms];
        let pose = [self.x_mm, self.y_mm, 0, self.heading_deg];
        let nowhere_on_earth = [0_i32; 3];
        let no_errors = [0_i32; 3];
        let bounds = self.bounds_mm.unwrap_or_default();
        let n_bounds = if self.bounds_mm.is_some() { bounds.len() } else { 0 };
        let mut body = [0; 70];
        let bytes = [Self::KIND, 0, 0]
            .into_iter()
            .chain(flags)
            .chain(intervals.into_iter().flat_map(u16::to_le_bytes))
            .chain(pose.into_iter().chain(nowhere_on_earth).flat_map(i32::to_le_bytes))
            .chain([NO_POSITION])
            .chain(no_errors.into_iter().flat_map(i32::to_le_bytes))
            .chain(bounds.into_iter().take(n_bounds).flat_map(i32::to_le_bytes));
        let len = fill(&mut body, bytes);
        let written = write_packet(body.get(..len).unwrap_or_default(), out);
        debug_assert!(written.is_ok(), "70 bytes fit a packet");
    }

    /// Reads the packet's body; a packet that ends after the heading is whole.
    ///
    /// # Errors
    ///
    /// [`ReportError`] when the type is not 0x62 or a field up to the heading is missing.
    pub fn decode(body: &[u8]) -> Result<Self, ReportError> {
        let (kind, mut fields) = open(body, Self::KIND, "0x62")?;
        let cut = ReportError::CutShort { kind, len: body.len(), field: "true pose" };
        let mut pac = fixed(&mut fields).ok_or(cut)?;
        pac.bounds_mm = bounds(&mut fields);
        Ok(pac)
    }
}

/// "There is no position on Earth", as a byte.
const NO_POSITION: u8 = (-1_i8).cast_unsigned();

fn fixed(fields: &mut Fields<'_>) -> Option<SimStatPac> {
    fields.u16()?;
    let flags = fields.i32()?;
    let (sim_interval_ms, real_interval_ms, last_interval_ms) =
        (fields.u16()?, fields.u16()?, fields.u16()?);
    let (x_mm, y_mm, _z_mm, heading_deg) =
        (fields.i32()?, fields.i32()?, fields.i32()?, fields.i32()?);
    let has_map = flags & 1 != 0;
    let bounds_mm = None;
    Some(SimStatPac {
        has_map,
        sim_interval_ms,
        real_interval_ms,
        last_interval_ms,
        x_mm,
        y_mm,
        heading_deg,
        bounds_mm,
    })
}

/// Past position on Earth, its quality and the errors.
fn bounds(fields: &mut Fields<'_>) -> Option<[i32; 4]> {
    fields.bytes(4 * 3 + 1 + 4 * 3)?;
    Some([fields.i32()?, fields.i32()?, fields.i32()?, fields.i32()?])
}

fn open<'a>(
    body: &'a [u8],
    wanted: u8,
    expected: &'static str,
) -> Result<(u8, Fields<'a>), ReportError> {
    let mut fields = Fields::new(body);
    let kind = fields.u8().ok_or(ReportError::Empty)?;
    if kind == wanted { Ok((kind, fields)) } else { Err(ReportError::Kind { kind, expected }) }
}

/// Writes `bytes` to the front of `place`; how many there were.
fn fill(place: &mut [u8], bytes: impl Iterator<Item = u8>) -> usize {
    let mut len: usize = 0;
    for (place, byte) in place.iter_mut().zip(bytes) {
        *place = byte;
        len = len.saturating_add(1);
    }
    len
}
