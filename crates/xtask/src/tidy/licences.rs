//! Dependencies carry licences that allow what we do, and need no C++ to build.

use std::{env, path::Path, process::Command};

use serde_json::Value;

use crate::repository::Repository;

/// Licences (SPDX) that a dependency may have: permissive, or with a duty that stays in its files.
const ALLOWED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Crates that would need a foreign compiler, a library of the system or a download.
const BANNED: &[&str] = &["bindgen", "cmake", "openssl-sys", "libudev-sys", "curl-sys"];

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    match metadata(&repository.root) {
        Ok(metadata) => check(&metadata),
        Err(error) => vec![error],
    }
}

fn metadata(root: &Path) -> Result<Value, String> {
    // Only what this platform uses: others' crates need not have been fetched.
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let platform = format!("{}-unknown-linux-gnu", env::consts::ARCH);
    let output = Command::new(cargo)
        .current_dir(root)
        .args(["metadata", "--format-version", "1", "--locked", "--filter-platform", &platform])
        .output()
        .map_err(|error| format!("cargo metadata: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo metadata: {error}"))
}

fn check(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let mut found = Vec::new();
    for package in packages {
        let name = package["name"].as_str().unwrap_or_default();
        let licence = package["license"].as_str().unwrap_or_default();
        if !is_allowed(licence) {
            found.push(format!("{name} has the licence `{licence}`, which is not on the list"));
        }
        if BANNED.contains(&name) {
            found.push(format!("{name} must not be needed: it wants more than a Rust compiler"));
        }
    }
    found
}

/// Evaluates an SPDX expression: `OR` needs one side, `AND` both, and `/` is an old `OR`.
fn is_allowed(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ");
    let any = split_outside_brackets(&expression, " OR ");
    if any.len() > 1 {
        return any.into_iter().any(is_allowed);
    }
    let all = split_outside_brackets(&expression, " AND ");
    if all.len() > 1 {
        return all.into_iter().all(is_allowed);
    }
    let one = expression.trim();
    match one.strip_prefix('(').and_then(|inner| inner.strip_suffix(')')) {
        Some(inner) => is_allowed(inner),
        None => ALLOWED.contains(&one),
    }
}

fn split_outside_brackets<'a>(expression: &'a str, separator: &str) -> Vec<&'a str> {
    let mut parts = Vec::new();
    let (mut start, mut depth) = (0, 0);
    for (i, c) in expression.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ if depth == 0 && i >= start && expression[i..].starts_with(separator) => {
                parts.push(&expression[start..i]);
                start = i + separator.len();
            }
            _ => {}
        }
    }
    parts.push(&expression[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn expressions_are_read_as_written() {
        for good in [
            "MIT",
            "MIT OR Apache-2.0",
            "GPL-3.0 OR MIT",
            "MIT/Apache-2.0",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "(GPL-3.0 AND MIT) OR Zlib",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert!(is_allowed(good), "{good}");
        }
        for bad in ["", "GPL-3.0", "MIT AND GPL-3.0", "(MIT AND GPL-3.0)", "GPL-3.0 OR (LGPL-3.0)"]
        {
            assert!(!is_allowed(bad), "{bad}");
        }
    }

    #[test]
    fn strange_licences_and_banned_crates_are_named() {
        let metadata = serde_json::json!({"packages": [
            {"name": "good", "license": "MIT"},
            {"name": "closed", "license": null},
            {"name": "cmake", "license": "MIT OR Apache-2.0"},
        ]});
        expect![[r#"
            closed has the licence ``, which is not on the list
            cmake must not be needed: it wants more than a Rust compiler"#]]
        .assert_eq(&check(&metadata).join("\n"));
    }
}
