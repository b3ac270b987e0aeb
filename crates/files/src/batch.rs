//! Results that appear together in a folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    identity::not_plain,
    kind::Kind,
    output::{Outputs, Written, folder_of, present_folder},
    refusal::Refusal,
};

/// Files that appear together in a folder of results.
///
/// Each is written beside its name, flushed to the disk, and takes its name only when [`Batch::commit`] is called
/// after all of them. A batch that is dropped before removes what it wrote, and the folder if it made it.
#[derive(Debug)]
pub struct Batch {
    outputs: Outputs,
    folder: PathBuf,
    files: Vec<Written>,
    /// Whether the folder was made for it.
    made: bool,
}

impl Outputs {
    /// Whether results may go into `folder`, which is made when it is not there (those above it are not), and
    /// whether each of `names` may be written in it; to be asked before the work begins.
    ///
    /// # Errors
    ///
    /// [`Refusal`]: what stands in the way and what to do.
    pub fn check_folder(&self, folder: &Path, names: &[(&str, Kind)]) -> Result<(), Refusal> {
        if make_folder(folder)? {
            // It was only to be seen whether it can be made.
            let _used = fs::remove_dir(folder);
            return Ok(());
        }
        for (name, kind) in names {
            self.check(&folder.join(name), *kind)?;
        }
        Ok(())
    }
}

/// Makes a folder unless it is there, but none above it; `true` when it was made.
///
/// # Errors
///
/// [`Refusal`] when there is no folder above it, or something else has its name.
pub fn make_folder(folder: &Path) -> Result<bool, Refusal> {
    let io = |source| Refusal::Io { path: folder.to_owned(), source };
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => Ok(false),
        Ok(_) => Err(Refusal::NotAFolder { path: folder.to_owned(), folder: folder.to_owned() }),
        Err(_) => {
            present_folder(folder, &folder_of(folder))?;
            if let Some(what) = fs::symlink_metadata(folder).ok().as_ref().and_then(not_plain) {
                return Err(Refusal::NotPlain { path: folder.to_owned(), what });
            }
            fs::create_dir(folder).map_err(io)?;
            Ok(true)
        }
    }
}

impl Batch {
    /// Begins a batch; makes the folder if there is none, but no folder above it.
    ///
    /// # Errors
    ///
    /// [`Refusal`] when the folder cannot be made.
    pub fn new(folder: &Path, outputs: &Outputs) -> Result<Self, Refusal> {
        let made = make_folder(folder)?;
        Ok(Self { outputs: outputs.clone(), folder: folder.to_owned(), files: Vec::new(), made })
    }

    /// Writes one file beside its name.
    ///
    /// # Errors
    ///
    /// [`Refusal`]; what was written so far vanishes with the batch.
    pub fn put(&mut self, name: &str, kind: Kind, bytes: &[u8]) -> Result<(), Refusal> {
        let path = self.folder.join(name);
        self.files.push(self.outputs.write_beside(&path, kind, bytes)?);
        Ok(())
    }

    /// Gives every file its name, in the order in which they were put.
    ///
    /// # Errors
    ///
    /// [`Refusal`] when one cannot take its name; those before it are in place, each whole, the others vanish.
    pub fn commit(mut self) -> Result<(), Refusal> {
        for file in std::mem::take(&mut self.files) {
            file.take_name(&self.outputs)?;
            self.made = false;
        }
        self.made = false;
        Ok(())
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        self.files.clear();
        if self.made {
            // Only when it is empty: another program may have used it meanwhile.
            let _used = fs::remove_dir(&self.folder);
        }
    }
}
