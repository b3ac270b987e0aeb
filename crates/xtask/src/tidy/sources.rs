//! Every file says what it is for, fits in a head, and holds no test that does not run.

use crate::repository::Repository;

/// Lines of a file at most, tests included.
const LINES_MAX: usize = 1000;

/// Files that may be longer, each with the reason.
const LONG_FILES: &[(&str, &str)] = &[];

/// What a source does not contain, and what to do about it.
const BANNED: &[(&str, &str)] = &[
    ("#[ignore", "a test that does not run protects nothing"),
    ("#[should_panic", "a panic is no interface: test the error"),
    ("FIXME", "mend it, or write what it does not do into the document"),
    ("TODO", "write what it does not do into the document"),
];

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in repository.rust_files("") {
        if !text.starts_with("//!") {
            found.push(format!("{path} does not begin with `//!` and what the file is for"));
        }
        let n_lines = text.lines().count();
        let listed = LONG_FILES.iter().any(|(long, _)| *long == path);
        if n_lines > LINES_MAX && !listed {
            found.push(format!("{path} has {n_lines} lines; at most {LINES_MAX}: split it"));
        }
        if path.starts_with("crates/xtask/") {
            // This file has to name them.
            continue;
        }
        for (number, line) in (1..).zip(text.lines()) {
            let banned = BANNED.iter().filter(|(word, _)| line.contains(word));
            found.extend(banned.map(|(word, why)| format!("{path}:{number} has `{word}`: {why}")));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn headless_long_and_silenced_files_are_reported() {
        let long = "//! Long.\n".repeat(LINES_MAX + 1);
        let fits = "//! Fits.\n".repeat(LINES_MAX);
        let repository = Repository::of(&[
            ("crates/a/src/lib.rs", "use b;\n//! Too late.\n"),
            ("crates/a/src/long.rs", &long),
            ("crates/a/src/fits.rs", &fits),
            ("crates/a/tests/t.rs", "//! Tests.\n#[test]\n#[ignore]\nfn t() {}\n"),
            ("crates/a/notes.md", "TODO: none"),
        ]);
        expect![[r#"
            crates/a/src/lib.rs does not begin with `//!` and what the file is for
            crates/a/src/long.rs has 1001 lines; at most 1000: split it
            crates/a/tests/t.rs:3 has `#[ignore`: a test that does not run protects nothing"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
