//! Files that are packed with gzip.

use std::{borrow::Cow, io::Read};

use flate2::read::MultiGzDecoder;

use crate::{
    RecordingError,
    complaints::{Action, Complaints, Place, Trouble},
};

/// Whether the bytes begin like a gzip file.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The bytes of a file, unpacked if it is gzip.
pub(crate) fn plain<'a>(
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
