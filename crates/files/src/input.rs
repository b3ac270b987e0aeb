//! Inputs, read within limits.

use std::{
    fs::File,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

use crate::Sort;

/// Bytes read between two words on the progress.
const PIECE_BYTES: usize = 1 << 22;

/// Bytes of a file that are looked at to know its sort.
const HEAD_BYTES: u64 = 4096;

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
    #[error(
        "cannot read {what} {}: it is no text in UTF-8: byte {byte} is none (line {line}); \
         if an editor wrote it, save it as UTF-8", path.display()
    )]
    NotText {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
        /// The first byte that is none.
        byte: usize,
        /// Its line, from 1.
        line: usize,
    },
    /// It is something else.
    #[error("cannot read {what} {}: it is {sort}", path.display())]
    Another {
        /// What it should be.
        what: String,
        /// The path.
        path: PathBuf,
        /// What it is.
        sort: Sort,
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
/// [`InputError`], also when it is no UTF-8; of a file that is of another sort, what it is.
pub fn read_text(path: &Path, what: &str) -> Result<String, InputError> {
    match read(path, what, Limit::TEXT, &mut |_, _| ()) {
        Ok(bytes) => text_of(path, what, bytes),
        // Too large for a text: what is it?
        Err(InputError::TooLarge { size: Some(size), what, path, bytes_max }) => {
            let mut head = Vec::new();
            let file = File::open(&path);
            let _unreadable = file.and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
            Err(match Sort::of(&path, &head) {
                Some(sort) => InputError::Another { what, path, sort },
                None => InputError::TooLarge { size: Some(size), what, path, bytes_max },
            })
        }
        Err(error) => Err(error),
    }
}

/// The text that bytes are, read already; `path` is what errors call them.
///
/// # Errors
///
/// [`InputError::Another`] and [`InputError::NotText`] when they are no UTF-8, also when every byte happens to be
/// (UTF-16 of plain letters).
pub fn text_of(path: &Path, what: &str, bytes: Vec<u8>) -> Result<String, InputError> {
    let (what, path) = (what.to_owned(), path.to_owned());
    let is_binary = bytes.iter().take(HEAD_BYTES as usize).any(|&byte| byte == 0);
    let error = match String::from_utf8(bytes) {
        Ok(text) if !is_binary => return Ok(text),
        Ok(text) => {
            return match Sort::of(&path, text.as_bytes()) {
                Some(sort @ (Sort::UTF16 | Sort::UTF32)) => {
                    Err(InputError::Another { what, path, sort })
                }
                _ => Ok(text),
            };
        }
        Err(error) => error,
    };
    let byte = error.utf8_error().valid_up_to();
    let bytes = error.into_bytes();
    match Sort::of(&path, &bytes) {
        // A text that says what it is has a letter in another encoding.
        Some(sort) if sort != Sort::MISSION && sort != Sort::SETTINGS => {
            Err(InputError::Another { what, path, sort })
        }
        _ => {
            let line = 1 + bytes.iter().take(byte).filter(|&&byte| byte == b'\n').count();
            Err(InputError::NotText { what, path, byte, line })
        }
    }
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
        assert!(said.contains("byte 2") && said.contains("line 1"), "{said}");
    }

    #[test]
    fn another_sort_of_file_is_named() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("mine.toml");
        let said = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_text(&path, "the mission").map_err(|error| error.to_string())
        };
        for (bytes, word) in [
            (&b"\xff\xfe[\0m\0"[..], "UTF-16"),
            (b"[\0m\0i\0s\0", "UTF-16"),
            (b"\x89MCAP0\r\n\xff", "cairn replay"),
            (b"\x1f\x8b\x08\x00\xff", "gunzip"),
            (b"\x89PNG\r\n", "picture"),
            (b"; b\xfcro\nAND O0,I0\n", "cairn rdpl"),
            (b"[mission]\nname = \"B\xfcro\"\n", "(line 2)"),
        ] {
            let said = said(bytes).unwrap_err();
            assert!(said.contains(word) && said.contains("mine.toml"), "{said}");
        }
        assert_eq!(said(b"a = 1\n").as_deref(), Ok("a = 1\n"));
        // Larger than any text may be.
        let large = std::fs::File::create(&path).unwrap();
        std::io::Write::write_all(&mut &large, b"\x89MCAP0\r\n").unwrap();
        large.set_len(Limit::TEXT.bytes_max() + 1).unwrap();
        let said = read_text(&path, "the mission").unwrap_err().to_string();
        assert!(said.contains("cairn replay"), "{said}");
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
