//! Finished settings on the disk, one line each, so that a sweep outlives its process.
//!
//! The first line tells whose journal it is; every other is one row. A line is flushed to the disk before the row
//! counts as finished. The last line of a killed process may be torn: it is cut off and its setting run again.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use files::{Kind, Outputs};
use serde::{Deserialize, Serialize};

use super::table::Row;

/// A journal that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file system refuses.
    #[error("{}: {source}", path.display())]
    Io {
        /// The journal.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It may not be written.
    #[error(transparent)]
    Refused(#[from] files::Refusal),
    /// It was written for another recording, configuration or plan.
    #[error(
        "{}: belongs to another sweep (another recording, configuration or plan); choose another folder, \
         or remove it to begin again", path.display()
    )]
    Another {
        /// The journal.
        path: PathBuf,
    },
    /// A line before the last is not a row.
    #[error("{}:{line}: is not a finished setting; remove the line, or the file to begin again", path.display())]
    Damaged {
        /// The journal.
        path: PathBuf,
        /// Line in it, from 1.
        line: usize,
    },
}

#[derive(Deserialize, Serialize)]
struct Head {
    cairn_sweep: u32,
    fingerprint: String,
}

const FORMAT: u32 = 1;

/// An open journal.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens or makes a journal; gives back what it holds, by the name of the setting.
    pub(super) fn open(
        path: &Path,
        fingerprint: &str,
    ) -> Result<(Self, BTreeMap<String, Row>), JournalError> {
        let io = |source| JournalError::Io { path: path.to_owned(), source };
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(io(error)),
        };
        // A link, a folder or a file of another sort is not written on.
        Outputs::new(true).check(path, Kind::JSON)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let head = Head { cairn_sweep: FORMAT, fingerprint: fingerprint.to_owned() };
        let begins = serde_json::to_string(&head).map_err(|e| io(e.into()))?;
        if whole == 0 && !begins.starts_with(&text) {
            return Err(JournalError::Damaged { path: path.to_owned(), line: 1 });
        }
        let mut rows = BTreeMap::new();
        for (index, line) in text[..whole].lines().enumerate() {
            let damaged = JournalError::Damaged { path: path.to_owned(), line: index + 1 };
            if index == 0 {
                let head: Head = serde_json::from_str(line).map_err(|_unreadable| damaged)?;
                if head.fingerprint != fingerprint || head.cairn_sweep != FORMAT {
                    return Err(JournalError::Another { path: path.to_owned() });
                }
            } else {
                let row: Row = serde_json::from_str(line).map_err(|_unreadable| damaged)?;
                rows.insert(row.setting.clone(), row);
            }
        }
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(io)?;
        files::lock(&file, path)?;
        file.set_len(whole as u64).map_err(io)?;
        let mut journal = Self { path: path.to_owned(), file };
        if whole == 0 {
            journal.line(&head)?;
        }
        Ok((journal, rows))
    }

    /// Adds a row; it is on the disk when this returns.
    pub(super) fn add(&mut self, row: &Row) -> Result<(), JournalError> {
        self.line(row)
    }

    fn line(&mut self, content: &impl Serialize) -> Result<(), JournalError> {
        let io = |source| JournalError::Io { path: self.path.clone(), source };
        let mut text = serde_json::to_string(content).map_err(|e| io(e.into()))?;
        text.push('\n');
        self.file.write_all(text.as_bytes()).map_err(io)?;
        self.file.sync_data().map_err(io)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(setting: &str, value: f64) -> Row {
        Row {
            setting: setting.to_owned(),
            figures: vec![("e".to_owned(), value)],
            failure: None,
            time_s: 0.5,
        }
    }

    #[test]
    fn a_torn_line_is_cut_off_and_the_rest_is_kept() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("sweep.jsonl");
        let (mut journal, rows) = Journal::open(&path, "f").unwrap();
        assert!(rows.is_empty());
        journal.add(&row("a=1", 0.1)).unwrap();
        journal.add(&row("a=2", 1.0 / 3.0)).unwrap();
        drop(journal);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() - 9]).unwrap();
        let (mut journal, rows) = Journal::open(&path, "f").unwrap();
        assert_eq!(rows.keys().collect::<Vec<_>>(), ["a=1"]);
        journal.add(&row("a=2", 1.0 / 3.0)).unwrap();
        drop(journal);
        assert_eq!(fs::read_to_string(&path).unwrap(), text, "as if it had not been torn");
        let (_, rows) = Journal::open(&path, "f").unwrap();
        assert_eq!(rows["a=2"], row("a=2", 1.0 / 3.0), "figures keep their bits");
    }

    #[test]
    fn another_sweeps_journal_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("sweep.jsonl");
        drop(Journal::open(&path, "f").unwrap());
        let error = Journal::open(&path, "g").unwrap_err().to_string();
        assert!(error.contains("another sweep"), "{error}");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{text}nonsense\n")).unwrap();
        let error = Journal::open(&path, "f").unwrap_err().to_string();
        assert!(error.contains("sweep.jsonl:2:"), "{error}");
        assert!(Journal::open(&place.path().join("no/such"), "f").is_err());
    }

    #[test]
    fn what_is_no_journal_is_left_as_it_is() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("sweep.jsonl");
        for foreign in ["notes without an end of line", "{\"mine\": 1}", "a\nb\nc"] {
            fs::write(&path, foreign).unwrap();
            assert!(Journal::open(&path, "f").is_err(), "{foreign}");
            assert_eq!(fs::read_to_string(&path).unwrap(), foreign);
        }
        fs::write(&path, "{\"cairn_sw").unwrap();
        let (held, _) = Journal::open(&path, "f").unwrap();
        let error = Journal::open(&path, "f").unwrap_err().to_string();
        assert!(error.contains("is being written by"), "{error}");
        drop(held);
    }
}
