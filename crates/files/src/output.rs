//! The rule itself, for one file.

use std::{
    ffi::OsString,
    fs::{self, File, Metadata, OpenOptions, TryLockError},
    io::{self, Read as _, Write as _},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};

use crate::{
    holder::holder,
    identity::{Identity, not_plain},
    kind::{HEAD_BYTES, Kind},
    refusal::Refusal,
};

/// Unfinished files of killed programs that may stand beside a name.
const LEFT_BEHIND_MAX: u32 = 1000;
/// How long it may take a program to lock the file that it has made.
const JUST_MADE: Duration = Duration::from_millis(50);
/// How often it tries.
const LOOKS_MAX: u32 = 10;

/// What a command may write: whether it may replace, and what it reads.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    replace: bool,
    inputs: Vec<(PathBuf, Identity)>,
}

/// A path that may be written, seen before it is.
#[derive(Debug)]
pub(crate) struct Target {
    /// As it was given.
    pub(crate) path: PathBuf,
    /// The folder that it is in.
    folder: PathBuf,
    name: OsString,
}

impl Outputs {
    /// Outputs of a command that reads nothing; `replace` is what `--force` asks for.
    pub fn new(replace: bool) -> Self {
        Self { replace, inputs: Vec::new() }
    }

    /// Adds what the command reads; paths at which nothing is do not matter.
    #[must_use]
    pub fn keeping<P: AsRef<Path>>(mut self, inputs: impl IntoIterator<Item = P>) -> Self {
        let of = |path: P| Some((path.as_ref().to_owned(), Identity::of(path.as_ref())?));
        self.inputs.extend(inputs.into_iter().filter_map(of));
        self
    }

    /// The same, but nothing may be replaced.
    #[must_use]
    pub fn never_replacing(mut self) -> Self {
        self.replace = false;
        self
    }

    /// Whether existing files may be replaced.
    pub fn replaces(&self) -> bool {
        self.replace
    }

    /// Whether `path` may be written; to be asked before the work begins.
    ///
    /// # Errors
    ///
    /// [`Refusal`]: what stands in the way and what to do.
    pub fn check(&self, path: &Path, kind: Kind) -> Result<(), Refusal> {
        let target = self.target(path, kind)?;
        // The folder may be read-only or full of names; a file of no length tells.
        let (probe, _file) = target.create_beside()?;
        fs::remove_file(&probe).map_err(|source| Refusal::Io { path: path.to_owned(), source })
    }

    /// As [`Outputs::check`], for several results that must not have one name.
    ///
    /// # Errors
    ///
    /// [`Refusal`] of the first.
    pub fn check_all(&self, wanted: &[(&Path, Kind)]) -> Result<(), Refusal> {
        let mut places: Vec<(PathBuf, OsString)> = Vec::new();
        for (path, kind) in wanted {
            let target = self.target(path, *kind)?;
            let folder = fs::canonicalize(&target.folder).unwrap_or(target.folder);
            let place = (folder, target.name);
            if places.contains(&place) {
                return Err(Refusal::Twice { path: (*path).to_owned() });
            }
            places.push(place);
        }
        wanted.iter().try_for_each(|(path, kind)| self.check(path, *kind))
    }

    /// Writes a file whole, or leaves everything as it was.
    ///
    /// # Errors
    ///
    /// [`Refusal`]; nothing half-written is left.
    pub fn write(&self, path: &Path, kind: Kind, bytes: &[u8]) -> Result<(), Refusal> {
        self.write_beside(path, kind, bytes)?.take_name(self)
    }

    /// Removes a result of an earlier run that no longer holds, if it is there and may be replaced.
    ///
    /// # Errors
    ///
    /// [`Refusal`], as if it were to be written.
    pub fn remove(&self, path: &Path, kind: Kind) -> Result<(), Refusal> {
        let target = self.target(path, kind)?;
        match fs::remove_file(&target.path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => {
                Err(Refusal::Io { path: target.path, source: e })
            }
            _ => Ok(()),
        }
    }

    /// Begins a file that is written little by little and is worth keeping when the program is killed: it is
    /// called `NAME.part` until [`Live::finish`], locked, and stays when it is not finished. What an earlier
    /// killed program left there is kept: the file is called `NAME.2.part` then, and so on.
    ///
    /// # Errors
    ///
    /// [`Refusal`], also when another program is writing the same name at this moment.
    pub fn begin(&self, path: &Path, kind: Kind) -> Result<Live, Refusal> {
        let target = self.target(path, kind)?;
        let mut left_behind = Vec::new();
        let mut number = 1;
        while number <= LEFT_BEHIND_MAX {
            let part = target.part(number);
            match OpenOptions::new().write(true).create_new(true).open(&part) {
                Ok(file) => {
                    if let Err(refusal) = lock_own(&file, path) {
                        let _left = fs::remove_file(&part);
                        return Err(refusal);
                    }
                    let outputs = self.clone();
                    return Ok(Live { outputs, target, kind, part, file, left_behind });
                }
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                    if is_left_behind(&part, path)? {
                        left_behind.push(part);
                        number += 1;
                    }
                }
                Err(source) => return Err(Refusal::Io { path: part, source }),
            }
        }
        Err(Refusal::Exists { path: target.part(LEFT_BEHIND_MAX) })
    }

    /// Writes bytes beside the name.
    pub(crate) fn write_beside(
        &self,
        path: &Path,
        kind: Kind,
        bytes: &[u8],
    ) -> Result<Written, Refusal> {
        let target = self.target(path, kind)?;
        let (beside, mut file) = target.create_beside()?;
        let written = Written { target, kind, beside: Some(beside) };
        let io = |source| Refusal::Io { path: path.to_owned(), source };
        file.write_all(bytes).and_then(|()| file.sync_all()).map_err(io)?;
        Ok(written)
    }

    /// Everything that can be known before: names, folders, inputs, what is there.
    fn target(&self, path: &Path, kind: Kind) -> Result<Target, Refusal> {
        let given = path.as_os_str().as_encoded_bytes();
        let is_slash = |byte: &u8| std::path::is_separator(char::from(*byte));
        let name = path.file_name().filter(|_| !given.last().is_some_and(is_slash));
        if let Some(what) = fs::metadata(path)
            .ok()
            .filter(Metadata::is_dir)
            .and_then(|_| fs::symlink_metadata(path).ok().as_ref().and_then(not_plain))
        {
            return Err(Refusal::NotPlain { path: path.to_owned(), what });
        }
        let Some(name) = name else {
            return Err(Refusal::NoName { path: path.to_owned(), example: kind.example() });
        };
        let folder = folder_of(path);
        present_folder(path, &folder)?;
        let target =
            Target { path: path.to_owned(), folder: folder.clone(), name: name.to_owned() };
        self.look(&target, kind)?;
        Ok(target)
    }

    /// What is at the name now.
    fn look(&self, target: &Target, kind: Kind) -> Result<(), Refusal> {
        let path = target.path.clone();
        if let Some(identity) = Identity::of(&path)
            && let Some((input, _)) = self.inputs.iter().find(|(_, input)| input.is(&identity))
        {
            return Err(Refusal::Input { path, input: input.clone() });
        }
        let metadata = match fs::symlink_metadata(&path) {
            Ok(metadata) => metadata,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(source) => return Err(Refusal::Io { path, source }),
        };
        if let Some(what) = not_plain(&metadata) {
            return Err(Refusal::NotPlain { path, what });
        }
        if !self.replace {
            return Err(Refusal::Exists { path });
        }
        let io = |source| Refusal::Io { path: path.clone(), source };
        let mut head = Vec::new();
        let file = File::open(&path).map_err(io)?;
        file.take(HEAD_BYTES as u64).read_to_end(&mut head).map_err(io)?;
        if kind.recognises(&head) {
            Ok(())
        } else {
            Err(Refusal::Foreign { path, kind: kind.name() })
        }
    }
}

/// Takes the lock of a file that is to be written, or says who has it; it is let go when the file is closed.
///
/// # Errors
///
/// [`Refusal::Held`] when another program has it.
pub fn lock(file: &File, path: &Path) -> Result<(), Refusal> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            Err(Refusal::Held { path: path.to_owned(), holder: holder(file) })
        }
        // Some network file systems have no locks; exclusive creation protects there.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(source)) => Err(Refusal::Io { path: path.to_owned(), source }),
    }
}

/// Whether a `.part` file is of a program that was killed; `false` when it is gone by now. It is opened for reading: a
/// left file is not touched.
///
/// # Errors
///
/// [`Refusal`] when another program writes it, or is just about to, or when it is no plain file.
fn is_left_behind(part: &Path, path: &Path) -> Result<bool, Refusal> {
    // A file is made first and locked then: one that is empty and free may be at that moment.
    for patience in [JUST_MADE, Duration::ZERO] {
        let metadata = fs::symlink_metadata(part);
        if let Some(what) = metadata.as_ref().ok().and_then(not_plain) {
            return Err(Refusal::NotPlain { path: part.to_owned(), what });
        }
        let left = match metadata.and_then(|_| File::open(part)) {
            Ok(left) => left,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(source) => return Err(Refusal::Io { path: part.to_owned(), source }),
        };
        lock(&left, path)?;
        if left.metadata().is_ok_and(|found| found.len() > 0) {
            break;
        }
        drop(left);
        wait(patience);
    }
    Ok(true)
}

/// Takes the lock of a file that was made just now; whoever else has it only looks whose it is, and lets go at once.
fn lock_own(file: &File, path: &Path) -> Result<(), Refusal> {
    for _ in 0..LOOKS_MAX {
        match lock(file, path) {
            Err(Refusal::Held { .. }) => wait(JUST_MADE / LOOKS_MAX),
            done => return done,
        }
    }
    lock(file, path)
}

#[expect(clippy::disallowed_methods, reason = "another program is waited for, for a moment")]
fn wait(patience: Duration) {
    std::thread::sleep(patience);
}

/// The folder of a path; `.` when it names none.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Refuses a folder that is missing or none.
pub(crate) fn present_folder(path: &Path, folder: &Path) -> Result<(), Refusal> {
    let (path, folder) = (path.to_owned(), folder.to_owned());
    match fs::metadata(&folder) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(Refusal::NotAFolder { path, folder }),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            Err(Refusal::NotAFolder { path, folder })
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(Refusal::NoFolder { path, folder }),
        Err(source) => Err(Refusal::Io { path, source }),
    }
}

impl Target {
    fn with_ending(&self, ending: &str) -> PathBuf {
        let mut name = self.name.clone();
        name.push(ending);
        self.folder.join(name)
    }

    fn part(&self, number: u32) -> PathBuf {
        if number == 1 {
            self.with_ending(".part")
        } else {
            self.with_ending(&format!(".{number}.part"))
        }
    }

    /// A new file beside the name, which no other program has.
    fn create_beside(&self) -> Result<(PathBuf, File), Refusal> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        loop {
            let count = COUNTER.fetch_add(1, Ordering::Relaxed);
            let beside = self.with_ending(&format!(".{}-{count}.part", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&beside) {
                Ok(file) => return Ok((beside, file)),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(source) => return Err(Refusal::Io { path: self.path.clone(), source }),
            }
        }
    }
}

/// A file that is whole but has not its name yet; it vanishes when dropped.
#[derive(Debug)]
pub(crate) struct Written {
    target: Target,
    kind: Kind,
    beside: Option<PathBuf>,
}

impl Written {
    /// Gives the file its name, after another look at what is there.
    pub(crate) fn take_name(mut self, outputs: &Outputs) -> Result<(), Refusal> {
        let Some(beside) = self.beside.clone() else { return Ok(()) };
        rename(outputs, &self.target, self.kind, &beside)?;
        self.beside = None;
        Ok(())
    }
}

impl Drop for Written {
    fn drop(&mut self) {
        if let Some(beside) = &self.beside {
            // What cannot be removed is left: its name says that it is not whole.
            let _left = fs::remove_file(beside);
        }
    }
}

/// From beside to the name: without replacing unless that was asked for.
fn rename(outputs: &Outputs, target: &Target, kind: Kind, beside: &Path) -> Result<(), Refusal> {
    let io = |source| Refusal::Io { path: target.path.clone(), source };
    outputs.look(target, kind)?;
    if outputs.replace {
        fs::rename(beside, &target.path).map_err(io)?;
    } else {
        // A second name for the file is never given to a name that exists, not even to one that came into being
        // since it was looked at; a rename would replace that.
        match fs::hard_link(beside, &target.path) {
            Ok(()) => fs::remove_file(beside).map_err(io)?,
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                return Err(Refusal::Exists { path: target.path.clone() });
            }
            // File systems without hard links.
            Err(_) => fs::rename(beside, &target.path).map_err(io)?,
        }
    }
    // The new name itself is on the disk too; where folders cannot be flushed, the system does it in time.
    if let Ok(folder) = File::open(&target.folder) {
        let _unsupported = folder.sync_all();
    }
    Ok(())
}

/// A file that grows under `NAME.part` and takes its name when it is finished; see [`Outputs::begin`].
#[derive(Debug)]
pub struct Live {
    outputs: Outputs,
    target: Target,
    kind: Kind,
    part: PathBuf,
    file: File,
    left_behind: Vec<PathBuf>,
}

impl Live {
    /// The file, to be written.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// The name that it will have.
    pub fn path(&self) -> &Path {
        &self.target.path
    }

    /// The name that it has meanwhile, and keeps when it is not finished.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Unfinished files of programs that were killed, which stand beside and were left as they are.
    pub fn left_behind(&self) -> &[PathBuf] {
        &self.left_behind
    }

    /// Flushes the file to the disk and gives it its name.
    ///
    /// # Errors
    ///
    /// [`Refusal`]; the file then stays under its `.part` name.
    pub fn finish(self) -> Result<PathBuf, Refusal> {
        let io = |source| Refusal::Io { path: self.part.clone(), source };
        self.file.sync_all().map_err(io)?;
        rename(&self.outputs, &self.target, self.kind, &self.part)?;
        Ok(self.target.path)
    }

    /// Removes the file: for work that failed before it began.
    pub fn discard(self) {
        let _left = fs::remove_file(&self.part);
    }
}

/// The path of the `n`th of several files: `out.mcap`, `out-2.mcap`, `out-3.mcap`.
pub fn numbered(path: &Path, n: u64) -> PathBuf {
    if n <= 1 {
        return path.to_owned();
    }
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{n}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
#[path = "output_tests.rs"]
mod tests;
