//! Which file a path means, however it is spelt.

use std::{
    fs::{self, Metadata},
    path::{Path, PathBuf},
};

/// A file, as the file system knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    canonical: PathBuf,
    /// Device and number on Unix: equal for every name of one file.
    node: Option<(u64, u64)>,
}

impl Identity {
    /// Of what the path leads to; `None` when nothing is there.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let canonical = fs::canonicalize(path).ok()?;
        let node = fs::metadata(&canonical).ok().and_then(|m| node(&m));
        Some(Self { canonical, node })
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        self.canonical == other.canonical || (self.node.is_some() && self.node == other.node)
    }
}

#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "other systems have none")]
pub(crate) fn node(metadata: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    Some((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
pub(crate) fn node(_metadata: &Metadata) -> Option<(u64, u64)> {
    None
}

/// How many names the file has.
#[cfg(unix)]
pub(crate) fn n_names(metadata: &Metadata) -> u64 {
    use std::os::unix::fs::MetadataExt as _;
    metadata.nlink()
}

#[cfg(not(unix))]
pub(crate) fn n_names(_metadata: &Metadata) -> u64 {
    1
}

/// What a thing that is no plain file is, for people; `None` for a plain file with one name.
pub(crate) fn not_plain(metadata: &Metadata) -> Option<String> {
    let kind = metadata.file_type();
    if kind.is_symlink() {
        return Some("a symbolic link".to_owned());
    }
    if kind.is_dir() {
        return Some("a folder".to_owned());
    }
    if kind.is_file() {
        let n = n_names(metadata);
        return (n > 1).then(|| format!("one of {n} names of one file (hard links)"));
    }
    Some(special(kind).to_owned())
}

#[cfg(unix)]
fn special(kind: fs::FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;
    if kind.is_fifo() {
        "a pipe (FIFO)"
    } else if kind.is_socket() {
        "a socket"
    } else if kind.is_char_device() || kind.is_block_device() {
        "a device"
    } else {
        "no plain file"
    }
}

#[cfg(not(unix))]
fn special(_kind: fs::FileType) -> &'static str {
    "no plain file"
}
