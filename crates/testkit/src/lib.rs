//! What tests of several crates share: where the repository and the measured data are.
//!
//! Used by tests only, never by a product crate. It knows no robot and no format, so that any
//! crate, whatever its level, may use it.
//!
//! ```
//! let Some(maps) = testkit::data_folder("maps") else { return };
//! assert!(maps.is_dir());
//! ```

use std::{
    env,
    path::{Path, PathBuf},
};

/// The root folder of the repository.
///
/// # Panics
///
/// When this crate is not two folders below it.
pub fn workspace_root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    match here.ancestors().nth(2) {
        Some(root) => root,
        None => panic!("testkit lies two folders below the root of the repository"),
    }
}

/// The folder (or file) `name` of the measured data, if the machine has it.
///
/// The data are not part of the repository: they are looked for in the folder that the variable
/// `CAIRN_DATA` names, or else in `../shared/data` beside the repository. When they are absent, one
/// line says what is skipped and the caller returns; everything else is still tested.
#[expect(clippy::print_stderr, reason = "a test that checks nothing must say so")]
pub fn data_folder(name: &str) -> Option<PathBuf> {
    let folder = env::var_os("CAIRN_DATA")
        .map_or_else(|| workspace_root().join("../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no `{name}` in {} (set CAIRN_DATA to the data folder)", folder.display());
    None
}

/// Every file of a folder, sorted by name, with its bytes; for tests that replay a corpus.
///
/// # Panics
///
/// When the folder is absent, empty or not readable: a corpus that is not replayed protects
/// nothing.
pub fn corpus(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => panic!("corpus {}: {error}", folder.display()),
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "corpus {} is empty", folder.display());
    let read = |path: PathBuf| match std::fs::read(&path) {
        Ok(bytes) => (path, bytes),
        Err(error) => panic!("corpus file {}: {error}", path.display()),
    };
    paths.into_iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_where_the_workspace_manifest_is() {
        let manifest = std::fs::read_to_string(workspace_root().join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[workspace]"));
    }

    #[test]
    fn data_that_are_not_there_are_none() {
        assert_eq!(data_folder("no such folder"), None);
    }

    #[test]
    fn a_corpus_comes_sorted_with_its_bytes() {
        let files = corpus(&workspace_root().join("crates/testkit/src"));
        assert!(files.iter().any(|(path, bytes)| path.ends_with("lib.rs") && !bytes.is_empty()));
        assert!(files.is_sorted());
    }
}
