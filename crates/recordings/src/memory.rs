//! How much memory a recording takes, said before it is read: for programs that read what strangers bring.

use std::mem::size_of;

use crate::{
    RecordingError,
    numbers::lines,
    raw::{RawPose, RawScan},
    recording::{Recording, Scan, StampedPose},
};

/// Bytes that an allocation takes beside what is asked for.
const OVERHEAD_BYTES: usize = 16;
/// Bytes of a scan without its readings while it is read: as it stands in the file, in its place in the recording
/// with its three poses, and in the list in which the same scan is looked for.
const SCAN_BYTES: usize = size_of::<RawScan>()
    + size_of::<Scan>()
    + 3 * size_of::<StampedPose>()
    + 128
    + 4 * OVERHEAD_BYTES;
/// Bytes of an odometry line while it is read.
const POSE_BYTES: usize = 2 * size_of::<RawPose>() + 2 * size_of::<StampedPose>();
/// Bytes of a reading.
const READING_BYTES: usize = size_of::<f64>();

/// Bytes that messages take of which each may hold a scan.
pub(crate) fn messages_bytes<'m>(messages: impl Iterator<Item = &'m [u8]>) -> usize {
    messages.map(|data| SCAN_BYTES + data.len()).sum()
}

/// Bytes that a second file of poses takes: it is read as a table, line by line.
pub(crate) fn second_bytes(poses: Option<&[u8]>) -> usize {
    poses.map_or(0, |bytes| lines(bytes).count() * SCAN_BYTES)
}

/// Bytes that true poses take: they are numbers.
pub(crate) fn truth_bytes(truth: Option<&[u8]>) -> usize {
    truth.map_or(0, |bytes| lines(bytes).count() * POSE_BYTES)
}

/// Bytes that scans take while they are read.
pub(crate) const fn scans_bytes(n_scans: usize, n_readings: usize) -> usize {
    n_scans.saturating_mul(SCAN_BYTES.saturating_add(n_readings.saturating_mul(READING_BYTES)))
}

/// Bytes that the lines of a text take, each a scan or a pose, by their fields.
pub(crate) fn text_bytes(content: &[u8], is_pose: impl Fn(&[u8]) -> bool) -> usize {
    let is_gap = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
    let of_line = |line: &[u8]| {
        if is_pose(line) {
            return POSE_BYTES;
        }
        SCAN_BYTES + READING_BYTES * (1 + line.iter().filter(|b| is_gap(b)).count())
    };
    lines(content).map(|(_, line)| of_line(line)).sum()
}

/// Whether so many bytes may be taken.
///
/// # Errors
///
/// [`RecordingError::TooMuchMemory`] when not.
pub(crate) fn afford(name: &str, needed: usize, most: usize) -> Result<(), RecordingError> {
    if needed <= most {
        return Ok(());
    }
    Err(RecordingError::TooMuchMemory { name: name.to_owned(), needed, most })
}

impl Recording {
    /// Bytes that it takes in memory.
    ///
    /// ```
    /// use recordings::{ReadOptions, read};
    ///
    /// let log = "FLASER 3 1.5 2.5 81.91 0 0 0 0 0 0 10.25 host 10.25\n";
    /// let recording = read("corridor.clf", log.as_bytes(), &ReadOptions::default())?.recording;
    /// assert!((100..400).contains(&recording.memory_bytes()));
    /// # Ok::<(), recordings::RecordingError>(())
    /// ```
    pub fn memory_bytes(&self) -> usize {
        let of_scan = |scan: &Scan| {
            size_of::<Scan>()
                + READING_BYTES * (scan.ranges_m.len() + scan.stamps.len())
                + 2 * OVERHEAD_BYTES
        };
        let poses = self.odometry.len() + self.reference.len() + self.truth.len();
        let extra = |row: &Vec<f64>| size_of::<Vec<f64>>() + READING_BYTES * row.len();
        self.scans.iter().map(of_scan).sum::<usize>()
            + poses * size_of::<StampedPose>()
            + self.extra_columns_m.iter().map(extra).sum::<usize>()
    }
}
