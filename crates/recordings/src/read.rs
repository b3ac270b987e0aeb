//! From the bytes of a file to a recording: unpacks, finds out the format, reads.

use std::{borrow::Cow, fmt, io::Read, path::Path};

use flate2::read::MultiGzDecoder;

use crate::{
    ReadOptions, RecordingError,
    assemble::{RawRecording, assemble},
    cairn_mcap, carmen,
    complaints::{Action, Complaints, Place, Trouble},
    csv, mat, mcap_records, memory, mrpt,
    numbers::{Fields, lines, shown},
    recording::Recording,
    sonar_files,
    trajectories::true_poses,
};

/// What a file was read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// A log of the CARMEN toolkit.
    Carmen,
    /// Laser scans as text, as MRPT's tools write them.
    MrptLaser,
    /// A MAT file of level 5 with `saved_readings` and `saved_pose`.
    Mat,
    /// ARTEMIC's `saved_readings` and `saved_pose` as two texts.
    ArtemicText,
    /// Rows of a stamp and readings in millimetres, and a file of poses.
    SonarText,
    /// Cairn's CSV.
    Csv,
    /// Cairn's MCAP.
    CairnMcap,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Carmen => "CARMEN log",
            Self::MrptLaser => "MRPT laser text",
            Self::Mat => "MAT file",
            Self::ArtemicText => "ARTEMIC text",
            Self::SonarText => "sonar text",
            Self::Csv => "CSV file",
            Self::CairnMcap => "recording of cairn",
        })
    }
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
    let Some(format) = detect(name, &content)? else {
        let name = name.to_owned();
        return Err(RecordingError::UnknownFormat { name, beginning: beginning(&content) });
    };
    let needed = memory::needed_bytes(format, &content, poses.as_deref(), truth.as_deref());
    memory::afford(name, needed, options.memory_max_bytes)?;
    let options = ReadOptions { poses: poses.as_deref(), ..options.clone() };
    let mut raw = read_as(format, name, &content, &options, &mut complaints)?;
    if let Some(truth) = &truth {
        raw.truth = true_poses(truth, &mut complaints);
    }
    let contains = format!("{} scans of which none can be used", raw.scans.len());
    match assemble(raw, &mut complaints) {
        Some(recording) => Ok(Loaded { recording, format, complaints }),
        None => Err(no_scans(name, format, &contains, &complaints)),
    }
}

fn read_as(
    format: Format,
    name: &str,
    content: &[u8],
    options: &ReadOptions<'_>,
    complaints: &mut Complaints,
) -> Result<RawRecording, RecordingError> {
    match format {
        Format::Carmen => carmen::read(name, content, options, complaints),
        Format::MrptLaser => mrpt::read(name, content, options, complaints),
        Format::Mat => sonar_files::read_mat(name, content, options, complaints),
        Format::ArtemicText => sonar_files::read_artemic(name, content, options, complaints),
        Format::SonarText => sonar_files::read_sonar_text(name, content, options, complaints),
        Format::Csv => csv::read(name, content, options, complaints),
        Format::CairnMcap => cairn_mcap::read(name, content, options, complaints),
    }
}

/// The error for a file without a usable scan, with the first complaints.
pub(crate) fn no_scans(
    name: &str,
    format: Format,
    contains: &str,
    complaints: &Complaints,
) -> RecordingError {
    let contains = with_complaints(contains, complaints);
    RecordingError::NoScans { name: name.to_owned(), format, contains }
}

/// A text with the first complaints behind it.
pub(crate) fn with_complaints(contains: &str, complaints: &Complaints) -> String {
    let first = complaints.kept().iter().take(3);
    first.fold(contains.to_owned(), |text, complaint| format!("{text}; {complaint}"))
}

/// Whether the bytes begin like a gzip file.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The bytes of a file, unpacked if it is gzip.
fn plain<'a>(
    name: &str,
    bytes: &'a [u8],
    bytes_max: usize,
    complaints: &mut Complaints,
) -> Result<Cow<'a, [u8]>, RecordingError> {
    if is_gzip(bytes) {
        return Ok(Cow::Owned(unpack(name, bytes, bytes_max, complaints)?));
    }
    Ok(Cow::Borrowed(bytes))
}

/// Unpacks a gzip file as far as it goes.
pub(crate) fn unpack(
    name: &str,
    bytes: &[u8],
    bytes_max: usize,
    complaints: &mut Complaints,
) -> Result<Vec<u8>, RecordingError> {
    let mut out = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes);
    let mut buffer = vec![0; 1 << 16];
    loop {
        match decoder.read(&mut buffer) {
            Ok(0) => return Ok(out),
            Ok(n) => {
                if out.len() + n > bytes_max {
                    return Err(RecordingError::TooLarge { name: name.to_owned(), bytes_max });
                }
                out.extend_from_slice(&buffer[..n]);
            }
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) if out.is_empty() => {
                return Err(RecordingError::Gzip { name: name.to_owned(), problem: e.to_string() });
            }
            Err(e) => {
                let n = out.len();
                let text = || {
                    format!("the gzip file is cut or damaged ({e}); the {n} bytes before are used")
                };
                complaints.add(Place::Byte(n), Trouble::EndsEarly, Action::Skipped, text);
                return Ok(out);
            }
        }
    }
}

fn detect(name: &str, content: &[u8]) -> Result<Option<Format>, RecordingError> {
    if content.starts_with(mcap_records::MAGIC) {
        return Ok(Some(Format::CairnMcap));
    }
    if content.starts_with(b"\x89HDF") || content.starts_with(b"MATLAB 7.3") {
        let problem = "a MAT file of version 7.3, which is HDF5; save it with `-v7` and try again";
        return Err(RecordingError::Unsupported {
            name: name.to_owned(),
            problem: problem.to_owned(),
        });
    }
    if mat::is_mat(content) {
        return Ok(Some(Format::Mat));
    }
    let found = detect_text(content);
    let lower = name.to_ascii_lowercase();
    let stem = Path::new(lower.strip_suffix(".gz").unwrap_or(&lower));
    let is_log = stem.extension().is_some_and(|e| e == "clf" || e == "log");
    Ok(found.or(is_log.then_some(Format::Carmen)))
}

/// By the first line that tells.
fn detect_text(content: &[u8]) -> Option<Format> {
    for (_, line) in lines(content) {
        let Ok(text) = std::str::from_utf8(line) else { continue };
        let mut words = text.split_ascii_whitespace();
        let Some(first) = words.next() else { continue };
        if carmen::is_keyword(first) || text.starts_with("# CARMEN") {
            return Some(Format::Carmen);
        }
        if csv::is_beginning(text) {
            return Some(Format::Csv);
        }
        if first.starts_with('%') || mrpt::is_scan(text) {
            return Some(Format::MrptLaser);
        }
        if sonar_files::is_artemic_line(text) {
            return Some(Format::ArtemicText);
        }
        if sonar_files::is_sonar_line(text) {
            return Some(Format::SonarText);
        }
    }
    None
}

/// The first bytes as a person can read them.
fn beginning(content: &[u8]) -> String {
    let text = String::from_utf8_lossy(&content[..content.len().min(48)]);
    format!("{:?}", shown(&text))
}

/// The words at the beginning of lines, with how often they occur: what a file holds.
pub(crate) fn first_words(content: &[u8]) -> String {
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    let mut n_lines = 0_usize;
    for (_, line) in lines(content) {
        n_lines += 1;
        let text = String::from_utf8_lossy(line);
        let word = Fields::new(&text).word("").map(shown).unwrap_or_default();
        if counts.len() < 1000 || counts.contains_key(&word) {
            *counts.entry(word).or_insert(0) += 1;
        }
    }
    let mut by_count: Vec<(String, usize)> = counts.into_iter().collect();
    by_count.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let kinds: Vec<String> =
        by_count.iter().take(6).map(|(word, n)| format!("{n} × {word:?}")).collect();
    format!("{n_lines} lines, beginning with {}", kinds.join(", "))
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
