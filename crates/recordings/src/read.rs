//! From the bytes of a file to a recording: unpacks, finds out the format, reads.

use crate::{
    Format, ReadOptions, RecordingError,
    assemble::assemble,
    cairn_mcap, carmen,
    complaints::Complaints,
    contents::{beginning, no_scans},
    csv, mat, mcap_records, memory, mrpt,
    numbers::lines,
    raw::RawRecording,
    recording::Recording,
    sonar_files,
    trajectories::true_poses,
    unpack::plain,
};

/// How a format is recognised, read and paid for: a row for each, in the order in which they are looked for.
struct Reader {
    format: Format,
    /// Whether the first bytes tell.
    bytes_tell: fn(&[u8]) -> bool,
    /// Whether a line tells; the first line of which one does decides.
    line_tells: fn(&str) -> bool,
    read: Read,
    /// Bytes of memory that the scans take at most while they are read.
    cost_bytes: fn(&[u8]) -> usize,
    /// A small file, and its second one if there is one, for tests of every format.
    #[cfg(test)]
    sample: Sample,
}

#[cfg(test)]
type Sample = fn() -> (Vec<u8>, Option<Vec<u8>>);

type Read =
    fn(&str, &[u8], &ReadOptions<'_>, &mut Complaints) -> Result<RawRecording, RecordingError>;

const NEVER: fn(&[u8]) -> bool = |_| false;

const READERS: &[Reader] = &[
    Reader {
        format: Format::CairnMcap,
        bytes_tell: |bytes| bytes.starts_with(mcap_records::MAGIC),
        line_tells: |_| false,
        read: cairn_mcap::read,
        cost_bytes: |bytes| memory::messages_bytes(mcap_records::messages(bytes).map(|m| m.data)),
        #[cfg(test)]
        sample: cairn_mcap::tests::sample,
    },
    Reader {
        format: Format::Mat,
        bytes_tell: mat::is_mat,
        line_tells: |_| false,
        read: sonar_files::read_mat,
        // It tells only when it is unpacked, see `memory::scans_bytes`.
        cost_bytes: |_| 0,
        #[cfg(test)]
        sample: sonar_files::tests::mat_sample,
    },
    Reader {
        format: Format::Carmen,
        bytes_tell: NEVER,
        line_tells: carmen::is_beginning,
        read: carmen::read,
        cost_bytes: |bytes| memory::text_bytes(bytes, carmen::is_pose_line),
        #[cfg(test)]
        sample: carmen::tests::sample,
    },
    Reader {
        format: Format::Csv,
        bytes_tell: NEVER,
        line_tells: csv::is_beginning,
        read: csv::read,
        cost_bytes: of_rows,
        #[cfg(test)]
        sample: csv::tests::sample,
    },
    Reader {
        format: Format::MrptLaser,
        bytes_tell: NEVER,
        line_tells: mrpt::is_beginning,
        read: mrpt::read,
        cost_bytes: of_rows,
        #[cfg(test)]
        sample: mrpt::tests::sample,
    },
    Reader {
        format: Format::ArtemicText,
        bytes_tell: NEVER,
        line_tells: sonar_files::is_artemic_line,
        read: sonar_files::read_artemic,
        cost_bytes: of_rows,
        #[cfg(test)]
        sample: sonar_files::tests::artemic_sample,
    },
    Reader {
        format: Format::SonarText,
        bytes_tell: NEVER,
        line_tells: sonar_files::is_sonar_line,
        read: sonar_files::read_sonar_text,
        cost_bytes: of_rows,
        #[cfg(test)]
        sample: sonar_files::tests::sonar_sample,
    },
];

fn of_rows(content: &[u8]) -> usize {
    memory::text_bytes(content, |_| false)
}

/// A recording with what was wrong in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// What was sensed.
    pub recording: Recording,
    /// What the file was read as.
    pub format: Format,
    /// What was wrong, and what was done about it.
    pub complaints: Complaints,
}

/// Reads a recording from the bytes of its file, plain or as gzip; `name` is for messages, and its ending helps
/// where the content does not tell. Time and memory grow with the bytes; nothing is allocated because
/// the file claims a length.
///
/// ```
/// use recordings::{ReadOptions, read};
///
/// let log = "FLASER 3 1.5 2.5 81.91 0 0 0 0 0 0 10.25 host 10.25\n\
///            FLASER 3 1.5 2.5\n";
/// let loaded = read("corridor.clf", log.as_bytes(), &ReadOptions::default())?;
/// assert_eq!(loaded.recording.scans.len(), 1);
/// assert_eq!(loaded.recording.scans[0].ranges_m[2], f64::INFINITY);
/// assert!(loaded.complaints.kept()[0].to_string().starts_with("line 2: the line ends after 4 fields"));
/// # Ok::<(), recordings::RecordingError>(())
/// ```
///
/// # Errors
///
/// [`RecordingError`] when the format is unknown, an option is missing or out of range, or no scan is usable.
pub fn read(name: &str, bytes: &[u8], options: &ReadOptions<'_>) -> Result<Loaded, RecordingError> {
    options.check()?;
    if bytes.is_empty() {
        return Err(RecordingError::Empty { name: name.to_owned() });
    }
    let mut complaints = Complaints::keeping(options.complaints_max);
    let mut plain = |bytes| plain(name, bytes, options.bytes_max, &mut complaints);
    let content = plain(bytes)?;
    let poses = options.poses.map(&mut plain).transpose()?;
    let truth = options.truth.map(&mut plain).transpose()?;
    let Some(reader) = detect(name, &content)? else {
        let name = name.to_owned();
        return Err(RecordingError::UnknownFormat { name, beginning: beginning(&content) });
    };
    let format = reader.format;
    let needed = needed_bytes(reader, &content, poses.as_deref(), truth.as_deref());
    memory::afford(name, needed, options.memory_max_bytes)?;
    let options = ReadOptions { poses: poses.as_deref(), ..options.clone() };
    let mut raw = (reader.read)(name, &content, &options, &mut complaints)?;
    if let Some(truth) = &truth {
        raw.truth = true_poses(truth, &mut complaints);
    }
    let contains = format!("{} scans of which none can be used", raw.scans.len());
    match assemble(raw, &mut complaints) {
        Some(recording) => Ok(Loaded { recording, format, complaints }),
        None => Err(no_scans(name, format, &contains, &complaints)),
    }
}

/// Bytes that a recording takes at most while it is read, beside its files themselves; from their lines and fields,
/// without reading a number.
fn needed_bytes(
    reader: &Reader,
    content: &[u8],
    poses: Option<&[u8]>,
    truth: Option<&[u8]>,
) -> usize {
    (reader.cost_bytes)(content) + memory::second_bytes(poses) + memory::truth_bytes(truth)
}

fn detect(name: &str, content: &[u8]) -> Result<Option<&'static Reader>, RecordingError> {
    if let Some(reader) = READERS.iter().find(|reader| (reader.bytes_tell)(content)) {
        return Ok(Some(reader));
    }
    if content.starts_with(b"\x89HDF") || content.starts_with(b"MATLAB 7.3") {
        let problem = "a MAT file of version 7.3, which is HDF5; save it with `-v7` and try again";
        return Err(RecordingError::Unsupported {
            name: name.to_owned(),
            problem: problem.to_owned(),
        });
    }
    let texts = lines(content).filter_map(|(_, line)| std::str::from_utf8(line).ok());
    let mut told = texts.filter(|text| !text.trim_ascii().is_empty());
    let found = told.find_map(|text| READERS.iter().find(|reader| (reader.line_tells)(text)));
    // A log of CARMEN may begin with lines of any kind.
    let lower = name.to_ascii_lowercase();
    let stem = lower.strip_suffix(".gz").unwrap_or(&lower);
    let is_log = Format::Carmen.endings().iter().any(|ending| stem.ends_with(ending));
    Ok(found.or_else(|| READERS.iter().find(|r| is_log && r.format == Format::Carmen)))
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
