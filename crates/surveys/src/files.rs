//! Results on a disk: whole or not at all.

use std::{
    fs::{self, File},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// A file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {source}", path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// Files that appear together in a folder.
///
/// Each is written beside its name (`NAME.part`), flushed to the disk, and takes its name only when
/// [`Batch::commit`] is called after all of them. A batch that is dropped before removes what it wrote.
#[derive(Debug)]
pub struct Batch {
    folder: PathBuf,
    /// The folders that were made for it, outermost first.
    made: Vec<PathBuf>,
    names: Vec<String>,
}

impl Batch {
    /// Begins a batch; makes the folder if there is none.
    ///
    /// # Errors
    ///
    /// [`WriteError`] when the folder cannot be made.
    pub fn new(folder: &Path) -> Result<Self, WriteError> {
        let absent = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let mut made: Vec<PathBuf> =
            folder.ancestors().take_while(absent).map(Path::to_owned).collect();
        made.reverse();
        fs::create_dir_all(folder)
            .map_err(|source| WriteError { path: folder.to_owned(), source })?;
        Ok(Self { folder: folder.to_owned(), made, names: Vec::new() })
    }

    /// Writes one file beside its name.
    ///
    /// # Errors
    ///
    /// [`WriteError`]; what was written so far vanishes with the batch.
    pub fn put(&mut self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        let part = self.part(name);
        self.names.push(name.to_owned());
        let write = || {
            let mut file = File::create(&part)?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        write().map_err(|source| WriteError { path: part.clone(), source })
    }

    /// Gives every file its name, replacing files of that name.
    ///
    /// # Errors
    ///
    /// [`WriteError`] when one cannot be renamed; those before it are in place, each whole.
    pub fn commit(mut self) -> Result<(), WriteError> {
        self.made.clear();
        let names = std::mem::take(&mut self.names);
        for (done, name) in names.iter().enumerate() {
            let path = self.folder.join(name);
            if let Err(source) = fs::rename(self.part(name), &path) {
                self.names = names[done..].to_vec();
                return Err(WriteError { path, source });
            }
        }
        Ok(())
    }

    fn part(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.part"))
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        // What cannot be removed is left: its name says that it is not whole.
        for name in &self.names {
            let _left = fs::remove_file(self.part(name));
        }
        // Only folders that are empty go; another program may have used them meanwhile.
        for folder in self.made.iter().rev() {
            let _used = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<_> = entries.map(|n| n.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_appear_together_and_replace_older_ones() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("a"), "old").unwrap();
        let mut batch = Batch::new(place.path()).unwrap();
        batch.put("a", b"new").unwrap();
        batch.put("b", b"other").unwrap();
        assert_eq!(fs::read(place.path().join("a")).unwrap(), b"old", "not before the commit");
        batch.commit().unwrap();
        assert_eq!(fs::read(place.path().join("a")).unwrap(), b"new");
        assert_eq!(names(place.path()), ["a", "b"]);
    }

    #[test]
    fn a_batch_that_fails_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/er");
        let mut batch = Batch::new(&folder).unwrap();
        batch.put("a", b"new").unwrap();
        let error = batch.put("no/such/b", b"other").unwrap_err().to_string();
        assert!(error.contains("no/such/b") && error.contains("cannot be written"), "{error}");
        drop(batch);
        assert_eq!(names(place.path()), [""; 0], "folders that it made are gone");
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        let error = Batch::new(&file.join("folder")).unwrap_err().to_string();
        assert!(error.contains("folder"), "{error}");
        assert_eq!(names(place.path()), ["file"]);
    }
}
