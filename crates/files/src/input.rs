//! Inputs, read within limits.

use std::{
    fs::File,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

/// Bytes read between two words on the progress.
const PIECE_BYTES: usize = 1 << 22;

/// How large an input may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    bytes_max: u64,
}

impl Limit {
    /// Mission files, settings, plans, decision programs and the maps that missions name: 32 MiB of text.
    pub const TEXT: Self = Self { bytes_max: 32 << 20 };
    /// Pictures of maps: 512 MiB.
    pub const PICTURE: Self = Self { bytes_max: 512 << 20 };
    /// Logs, recordings and pose graphs: 2 GiB, which is also what they may unpack to.
    pub const LOG: Self = Self { bytes_max: 2 << 30 };

    /// A limit of so many bytes.
    pub const fn bytes(bytes_max: u64) -> Self {
        Self { bytes_max }
    }

    /// The number of bytes.
    pub const fn bytes_max(self) -> u64 {
        self.bytes_max
    }
}

/// An input that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// The file system refuses.
    #[error("cannot read {what} {}: {source}", path.display())]
    Io {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is a folder.
    #[error("cannot read {what} {}: it is a folder; give the file in it", path.display())]
    Folder {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
    },
    /// It is too large.
    #[error(
        "cannot read {what} {}: it has {}, at most {} are allowed", path.display(),
        size.map_or_else(|| "more bytes than may be read".to_owned(), shown), shown(*bytes_max)
    )]
    TooLarge {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
        /// Bytes that it has, when that is known.
        size: Option<u64>,
        /// Bytes that it may have.
        bytes_max: u64,
    },
    /// It is no text.
    #[error("cannot read {what} {}: it is no text: byte {byte} is no UTF-8", path.display())]
    NotText {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
        /// The first byte that is none.
        byte: usize,
    },
}

/// A number of bytes for people.
fn shown(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// Reads a file of at most `limit` bytes; `what` is what it should be, with its article (`the recording`). A size
/// that is known beforehand is refused before anything is read; of a pipe or device no more than the limit is
/// taken. `tell` hears the bytes read and, if it is known, how many there are, every 4 MiB.
///
/// # Errors
///
/// [`InputError`].
pub fn read(
    path: &Path,
    what: &str,
    limit: Limit,
    tell: &mut dyn FnMut(u64, Option<u64>),
) -> Result<Vec<u8>, InputError> {
    let (what, path) = (what.to_owned(), path.to_owned());
    let io = |source| InputError::Io { what: what.clone(), path: path.clone(), source };
    let mut file = File::open(&path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(InputError::Folder { what, path });
    }
    let size = metadata.is_file().then_some(metadata.len());
    let too_large = |size| InputError::TooLarge {
        what: what.clone(),
        path: path.clone(),
        size,
        bytes_max: limit.bytes_max,
    };
    if size.is_some_and(|size| size > limit.bytes_max) {
        return Err(too_large(size));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(size.unwrap_or(0)).unwrap_or(0));
    loop {
        // One byte more than allowed tells that there is more.
        let rest = (limit.bytes_max + 1).saturating_sub(bytes.len() as u64);
        let piece = rest.min(PIECE_BYTES as u64);
        let n = (&mut file).take(piece).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 > limit.bytes_max {
            return Err(too_large(None));
        }
        if n == 0 {
            return Ok(bytes);
        }
        tell(bytes.len() as u64, size);
    }
}

/// As [`read`], for text of at most [`Limit::TEXT`].
///
/// # Errors
///
/// [`InputError`], also when it is no UTF-8.
pub fn read_text(path: &Path, what: &str) -> Result<String, InputError> {
    let bytes = read(path, what, Limit::TEXT, &mut |_, _| ())?;
    String::from_utf8(bytes).map_err(|e| InputError::NotText {
        what: what.to_owned(),
        path: path.to_owned(),
        byte: e.utf8_error().valid_up_to(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_have_a_limit() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a");
        std::fs::write(&path, vec![b'a'; 100]).unwrap();
        let limited = |n| read(&path, "the log", Limit::bytes(n), &mut |_, _| ());
        assert_eq!(limited(100).unwrap().len(), 100);
        let said = limited(99).unwrap_err().to_string();
        assert!(
            said.contains("the log") && said.contains("100 bytes") && said.contains("99 bytes"),
            "{said}"
        );
        let said = read(place.path(), "the log", Limit::TEXT, &mut |_, _| ()).unwrap_err();
        assert!(said.to_string().contains("folder"), "{said}");
        std::fs::write(&path, b"ab\xff").unwrap();
        let said = read_text(&path, "the mission").unwrap_err().to_string();
        assert!(said.contains("byte 2"), "{said}");
    }

    /// A device has no size that could be refused beforehand.
    #[cfg(target_os = "linux")]
    #[test]
    fn an_endless_input_is_left_at_the_limit() {
        let mut most = 0;
        let tell = &mut |read, size| {
            assert_eq!(size, None);
            most = read;
        };
        let said =
            read(Path::new("/dev/zero"), "the log", Limit::bytes(10 << 20), tell).unwrap_err();
        assert!(said.to_string().contains("more bytes than may be read"), "{said}");
        assert!(most > 0 && most <= 10 << 20, "{most}");
    }
}
