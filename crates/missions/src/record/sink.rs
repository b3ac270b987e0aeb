//! Where the bytes of a recording are until they are written: whole pieces, each with its checksum, reach the file
//! in one go, so that a program that is killed leaves a file that ends between two of them.

use std::{
    fs::File,
    io::{self, Seek, SeekFrom, Write},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use recordings::mcap_file::{Crc, check_record};

/// The writing end, for the format's writer.
#[derive(Clone, Debug)]
pub(super) struct Sink(Arc<Mutex<Pending>>);

#[derive(Debug)]
struct Pending {
    bytes: Vec<u8>,
    /// Bytes of `bytes` that `crc` is of already.
    n_summed: usize,
    /// Of everything that was ever written here.
    crc: Crc,
    n_total: u64,
}

impl Sink {
    pub(super) fn new() -> Self {
        let bytes = Vec::new();
        Self(Arc::new(Mutex::new(Pending { bytes, n_summed: 0, crc: Crc::new(), n_total: 0 })))
    }

    fn pending(&self) -> MutexGuard<'_, Pending> {
        // Bytes are only ever appended: a panic elsewhere leaves them as good as they were.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.pending().bytes.is_empty()
    }

    /// The content of a check record of everything until now.
    pub(super) fn check(&self) -> [u8; 16] {
        let mut pending = self.pending();
        let Pending { bytes, n_summed, crc, n_total } = &mut *pending;
        crc.update(&bytes[*n_summed..]);
        *n_summed = bytes.len();
        check_record(*n_total, crc.sum())
    }

    /// Writes out what waits. When the file system refuses, the file is cut back to what it was, so that it ends
    /// with a whole piece.
    pub(super) fn write_out(&self, file: &mut File) -> io::Result<()> {
        let mut pending = self.pending();
        let Pending { bytes, n_summed, crc, n_total } = &mut *pending;
        if bytes.is_empty() {
            return Ok(());
        }
        let before = *n_total - bytes.len() as u64;
        if let Err(error) = file.write_all(bytes) {
            let _as_it_is = file.set_len(before);
            return Err(error);
        }
        crc.update(&bytes[*n_summed..]);
        *n_summed = 0;
        bytes.clear();
        Ok(())
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut pending = self.pending();
        pending.bytes.extend_from_slice(bytes);
        pending.n_total += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Sink {
    /// The format's writer asks for its place and goes nowhere.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.pending().n_total),
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
