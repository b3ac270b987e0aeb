//! Why a file is not written.

use std::{io, path::PathBuf};

/// A file that is not written; nothing was changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The path names no file.
    #[error("{}: cannot be written: it names no file; give a name such as {example}", path.display())]
    NoName {
        /// The path.
        path: PathBuf,
        /// A name that would do.
        example: &'static str,
    },
    /// The folder for it is not there.
    #[error(
        "{}: cannot be written: there is no folder {}; make it first", path.display(), folder.display()
    )]
    NoFolder {
        /// The path.
        path: PathBuf,
        /// The folder that is missing.
        folder: PathBuf,
    },
    /// What should be a folder is something else.
    #[error("{}: cannot be written: {} is no folder", path.display(), folder.display())]
    NotAFolder {
        /// The path.
        path: PathBuf,
        /// What is no folder.
        folder: PathBuf,
    },
    /// The command reads the file.
    #[error(
        "{}: is read by this command and would be overwritten{}; choose another name for what is written",
        path.display(), if input == path { String::new() } else { format!(" (it is {})", input.display()) }
    )]
    Input {
        /// The path.
        path: PathBuf,
        /// How the input is spelt.
        input: PathBuf,
    },
    /// Two results would have one name.
    #[error("{}: two results would have this name; choose another for one of them", path.display())]
    Twice {
        /// The path.
        path: PathBuf,
    },
    /// It is a folder, a link, a pipe or a device.
    #[error("{}: is {what}, which is never replaced; choose another name", path.display())]
    NotPlain {
        /// The path.
        path: PathBuf,
        /// What it is.
        what: String,
    },
    /// It exists, and replacing was not asked for.
    #[error("{}: exists already; choose another name, or replace it with --force", path.display())]
    Exists {
        /// The path.
        path: PathBuf,
    },
    /// It exists and is something else than what would be written.
    #[error(
        "{}: exists and is not {kind}, so it is not replaced, not even with --force; choose another name",
        path.display()
    )]
    Foreign {
        /// The path.
        path: PathBuf,
        /// What would be written.
        kind: &'static str,
    },
    /// Another program is writing it.
    #[error("{}: is being written by {holder}; choose another name, or wait until it has ended", path.display())]
    Held {
        /// The path.
        path: PathBuf,
        /// Who writes it.
        holder: String,
    },
    /// The file system refuses.
    #[error("{}: cannot be written: {source}", path.display())]
    Io {
        /// The path.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}
