//! What a reader is told beside the file.

use std::f64::consts::TAU;

use geometry::Se2;

use crate::{Ring, complaints::KEPT_DEFAULT, error::RecordingError};

/// What a reader is told beside the file. The default is right for most files.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions<'a> {
    /// Which robot of a recording of several (cairn's MCAP); `None`: the only one.
    pub robot: Option<&'a str>,
    /// The second file of formats that have two: poses beside ARTEMIC's readings or a sonar text.
    pub poses: Option<&'a [u8]>,
    /// A file of true poses, lines of `t x y yaw` or of TUM's fields; they take the place of those of the recording.
    pub truth: Option<&'a [u8]>,
    /// Angle from a laser's first beam to its last one, radians, in (0, 2π], where the format does not say it; at
    /// 2π the last beam is one spacing short of the first. `None`: that of the format.
    pub field_of_view_rad: Option<f64>,
    /// Where the laser sits on the robot, for formats that do not say it. `None`: at its centre, but 0.20 m ahead
    /// for MRPT's simulated scans.
    pub base_from_sensor: Option<Se2>,
    /// Readings from here on mean that nothing came back, metres, above 0. `None`: that of the format or rig.
    pub range_max_m: Option<f64>,
    /// Time between rows, seconds, above 0, for formats without stamps. `None`: 0.25 s for MAT files, 0.05 s
    /// for ARTEMIC's texts.
    pub period_s: Option<f64>,
    /// Which ring of sonars took the readings.
    pub ring: Ring,
    /// Bytes that a compressed file may unpack to.
    pub bytes_max: usize,
    /// Bytes of memory that reading may take, beside the file's own bytes and those that it unpacks to.
    pub memory_max_bytes: usize,
    /// Complaints that are kept in full.
    pub complaints_max: usize,
}

/// Bytes that a compressed file may unpack to, if nothing else is asked for: a day of a laser.
const BYTES_MAX: usize = 1 << 29;

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        Self {
            robot: None,
            poses: None,
            truth: None,
            field_of_view_rad: None,
            base_from_sensor: None,
            range_max_m: None,
            period_s: None,
            ring: Ring::File,
            bytes_max: BYTES_MAX,
            memory_max_bytes: usize::MAX,
            complaints_max: KEPT_DEFAULT,
        }
    }
}

impl ReadOptions<'_> {
    pub(crate) fn check(&self) -> Result<(), RecordingError> {
        let check = |option, value: Option<f64>, max: f64, requirement| match value {
            Some(value) if !(value > 0.0 && value <= max) => {
                Err(RecordingError::Option { option, value, requirement })
            }
            _ => Ok(()),
        };
        check("field_of_view_rad", self.field_of_view_rad, TAU, "above 0, at most 2π")?;
        check("range_max_m", self.range_max_m, 1e6, "above 0, at most 1000000 m")?;
        check("period_s", self.period_s, 86_400.0, "above 0, at most a day")
    }
}
