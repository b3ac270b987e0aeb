//! The repository as text: what the checks look at, read once.

use std::{
    collections::BTreeMap,
    fmt, fs, io,
    path::{Path, PathBuf},
};

/// Folders that hold nothing of ours: built, fetched or kept by git.
const FOREIGN_FOLDERS: &[&str] = &[".git", "target", "node_modules", "dist"];

/// Endings of files that are read; all are text.
const TEXT_ENDINGS: &[&str] = &[
    "rs", "toml", "md", "tsv", "ts", "mjs", "js", "json", "html", "css", "rdpl", "map", "txt",
    "lock", "run",
];

/// Files and manifests by their path from the root, with `/` between folders.
#[derive(Debug, Default)]
pub(crate) struct Repository {
    pub(crate) root: PathBuf,
    pub(crate) files: BTreeMap<String, String>,
}

/// A file that cannot be read.
#[derive(Debug)]
pub(crate) struct ReadError {
    path: PathBuf,
    error: io::Error,
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} cannot be read: {}", self.path.display(), self.error)
    }
}

impl Repository {
    /// Reads every text file below `root`.
    pub(crate) fn read(root: &Path) -> Result<Self, ReadError> {
        let mut repository = Self { root: root.to_path_buf(), files: BTreeMap::new() };
        repository.read_folder(root)?;
        Ok(repository)
    }

    /// A repository that exists only in a test.
    #[cfg(test)]
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        let owned = |&(path, text): &(&str, &str)| (path.to_owned(), text.to_owned());
        Self { root: PathBuf::new(), files: files.iter().map(owned).collect() }
    }

    /// The text of a file, or nothing when it is absent.
    pub(crate) fn text(&self, path: &str) -> &str {
        self.files.get(path).map_or("", String::as_str)
    }

    /// The Rust files below a folder.
    pub(crate) fn rust_files<'a>(
        &'a self,
        below: &'a str,
    ) -> impl Iterator<Item = (&'a str, &'a str)> {
        let files = self.files.iter().map(|(path, text)| (path.as_str(), text.as_str()));
        files.filter(move |(path, _)| {
            path.starts_with(below) && Path::new(path).extension().is_some_and(|e| e == "rs")
        })
    }

    fn read_folder(&mut self, folder: &Path) -> Result<(), ReadError> {
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |error| ReadError { path, error }
        };
        for entry in fs::read_dir(folder).map_err(failed(folder))? {
            let path = entry.map_err(failed(folder))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !FOREIGN_FOLDERS.contains(&name.as_str()) {
                    self.read_folder(&path)?;
                }
                continue;
            }
            let ending = name.rsplit('.').next().unwrap_or_default();
            let is_text = TEXT_ENDINGS.contains(&ending) || path.ends_with(".ci/run");
            // Seeds of the fuzzers may carry any name and any bytes.
            if is_text && !path.components().any(|c| c.as_os_str() == "corpus") {
                // Cases of tests may be in another encoding on purpose.
                let bytes = fs::read(&path).map_err(failed(&path))?;
                let text = String::from_utf8_lossy(&bytes).into_owned();
                let relative = path.strip_prefix(&self.root).unwrap_or(&path);
                self.files.insert(relative.to_string_lossy().replace('\\', "/"), text);
            }
        }
        Ok(())
    }
}
