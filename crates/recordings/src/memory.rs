//! How much memory a recording takes, said before it is read: for programs that read what strangers bring.

use std::mem::size_of;

use crate::{
    Format, RecordingError,
    assemble::{RawPose, RawScan},
    carmen, mcap_records,
    numbers::lines,
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

/// Bytes that a recording takes at most while it is read, beside its files themselves; from their lines and fields,
/// without reading a number. MAT files tell only when they are unpacked: see [`scans_bytes`].
pub(crate) fn needed_bytes(
    format: Format,
    content: &[u8],
    poses: Option<&[u8]>,
    truth: Option<&[u8]>,
) -> usize {
    let scans = match format {
        Format::Mat => 0,
        Format::CairnMcap => {
            mcap_records::messages(content).map(|m| SCAN_BYTES + m.data.len()).sum()
        }
        Format::Carmen => text_bytes(content, carmen::is_pose_line),
        Format::MrptLaser | Format::ArtemicText | Format::SonarText | Format::Csv => {
            text_bytes(content, |_| false)
        }
    };
    // A second file of poses is read as a table, line by line; true poses are numbers.
    let of_lines = |bytes: Option<&[u8]>, each| bytes.map_or(0, |b| lines(b).count() * each);
    scans + of_lines(poses, SCAN_BYTES) + of_lines(truth, POSE_BYTES)
}

/// Bytes that scans take while they are read.
pub(crate) const fn scans_bytes(n_scans: usize, n_readings: usize) -> usize {
    n_scans.saturating_mul(SCAN_BYTES.saturating_add(n_readings.saturating_mul(READING_BYTES)))
}

fn text_bytes(content: &[u8], is_pose: impl Fn(&[u8]) -> bool) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, read};

    /// What was read takes no more than was said before, whatever the format; and a limit just below is kept.
    #[test]
    fn what_is_read_was_foretold() {
        let flaser = "FLASER 5 1.5 2.5 3.5 81.91 2.0 0 0 0 0 0 0 1.25 host 1.25\n".repeat(40);
        let odom = "ODOM 0 0 0 0 0 0 1.25 host 1.25\n".repeat(40);
        let rig = "# rig: {\"kind\":\"ring\",\"base_from_sensors\":[[0.1,0.0,0.0]],\"half_angle_rad\":0.26,\
                   \"range_min_m\":0.1,\"range_max_m\":5.0}\nstamp_s,range_0_m\n";
        let rows = |n: usize| (0..n).map(|i| format!("{i}.5,1.35\n")).collect::<Vec<_>>().concat();
        let files = [
            ("a.log", format!("{flaser}{odom}").into_bytes()),
            ("b.csv", format!("{rig}{}", rows(40)).into_bytes()),
        ];
        for (name, bytes) in files {
            let loaded = read(name, &bytes, &ReadOptions::default()).unwrap();
            let foretold = needed_bytes(loaded.format, &bytes, None, None);
            assert!(loaded.recording.memory_bytes() <= foretold, "{name}");
            let options = |memory_max_bytes| ReadOptions { memory_max_bytes, ..Default::default() };
            assert!(read(name, &bytes, &options(foretold)).is_ok(), "{name}");
            let refused = read(name, &bytes, &options(foretold - 1)).unwrap_err();
            assert!(
                matches!(refused, RecordingError::TooMuchMemory { needed, .. } if needed == foretold),
                "{name}: {refused}"
            );
        }
    }

    /// Odometry lines are cheaper than scans, and a file of many numbers dearer than one of few.
    #[test]
    fn what_costs_more_is_said_to_cost_more() {
        let of = |text: &str| needed_bytes(Format::Carmen, text.as_bytes(), None, None);
        assert!(of("ODOM 0 0 0 0 0 0 1 h 1\n") < of("FLASER 1 1.5 0 0 0 0 0 0 1 h 1\n"));
        let more = of("FLASER 2 1.5 1.5 0 0 0 0 0 0 1 h 1\n");
        assert_eq!(more, of("FLASER 1 1.5 0 0 0 0 0 0 1 h 1\n") + READING_BYTES);
    }
}
