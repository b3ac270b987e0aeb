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
/// line says what is skipped and the caller returns; everything else is still tested. `cargo test` counts the tests that
/// ask (`tests/measured_data.rs`).
///
/// # Panics
///
/// When they are absent and the variable `CAIRN_DATA_REQUIRED` is set to anything but nothing or 0, as it is in the
/// continuous integration: there a test that skips would be a check that is not made.
#[expect(clippy::print_stderr, reason = "a test that checks nothing must say so")]
pub fn data_folder(name: &str) -> Option<PathBuf> {
    let folder = data_folder_named();
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    assert!(
        !is_required(env::var("CAIRN_DATA_REQUIRED").ok().as_deref()),
        "no `{name}` in {}, and CAIRN_DATA_REQUIRED says that it must be there",
        folder.display()
    );
    eprintln!("skipped: no `{name}` in {} (set CAIRN_DATA to the data folder)", folder.display());
    None
}

/// The folder of the measured data, if the machine has it.
pub fn data_root() -> Option<PathBuf> {
    Some(data_folder_named()).filter(|folder| folder.is_dir())
}

fn data_folder_named() -> PathBuf {
    env::var_os("CAIRN_DATA").map_or_else(|| workspace_root().join("../shared/data"), PathBuf::from)
}

fn is_required(value: Option<&str>) -> bool {
    value.is_some_and(|value| !value.is_empty() && value != "0")
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
    fn data_that_are_not_there_are_none_where_nobody_requires_them() {
        if env::var_os("CAIRN_DATA_REQUIRED").is_none() {
            assert_eq!(data_folder("no such folder"), None);
        }
        assert!(is_required(Some("1")) && is_required(Some("true")));
        assert!(!is_required(None) && !is_required(Some("")) && !is_required(Some("0")));
    }

    #[test]
    fn a_corpus_comes_sorted_with_its_bytes() {
        let files = corpus(&workspace_root().join("crates/testkit/src"));
        assert!(files.iter().any(|(path, bytes)| path.ends_with("lib.rs") && !bytes.is_empty()));
        assert!(files.is_sorted());
    }
}
