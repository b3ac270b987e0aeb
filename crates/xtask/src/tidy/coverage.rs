//! `docs/coverage.tsv` says of every requirement how far it is met, which test proves it, and how to see it work.
//!
//! Columns: id, state (`done`, `partial`, `todo`), where, tests (separated by `;`), try. A test is named
//! `crate::module::test_fn`, or `web::name` for a browser test. What to try is a command line that begins with
//! `cairn` (a test of the program runs all of them), or `page: ` and where on which page it shows; a row that is
//! partial may say `none: ` and why nobody can see it yet.

use std::collections::{BTreeMap, BTreeSet};

use crate::repository::Repository;

const REQUIREMENTS: &str = "docs/requirements.tsv";
const COVERAGE: &str = "docs/coverage.tsv";
const WEB_TESTS: &str = "crates/studio/web/tests/";

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let mut found = Vec::new();
    let ids = |path| rows(repository.text(path)).map(|(_, row)| row[0]);
    let required: BTreeSet<&str> = ids(REQUIREMENTS).collect();
    if required.is_empty() {
        found.push(format!("{REQUIREMENTS} is absent or empty"));
    }
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for id in ids(COVERAGE) {
        *seen.entry(id).or_default() += 1;
    }
    let missing = required.iter().filter(|id| !seen.contains_key(*id));
    found.extend(missing.map(|id| format!("{COVERAGE} lacks {id}")));
    let repeated = seen.iter().filter(|&(_, &n)| n > 1);
    found.extend(repeated.map(|(id, _)| format!("{COVERAGE} has {id} more than once")));
    for (line, row) in rows(repository.text(COVERAGE)) {
        let problems = row_problems(repository, &required, &row);
        found.extend(problems.into_iter().map(|p| format!("{COVERAGE}:{line} {}: {p}", row[0])));
    }
    found
}

fn row_problems(repository: &Repository, required: &BTreeSet<&str>, row: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    if !required.contains(row[0]) {
        found.push(format!("is not in {REQUIREMENTS}"));
    }
    let [_, state, place, tests, attempt] = *row else {
        found.push(format!("has {} columns, not 5: id, state, where, tests, try", row.len()));
        return found;
    };
    if !["done", "partial", "todo"].contains(&state) {
        found.push(format!("`{state}` is no state; they are done, partial, todo"));
    }
    let tests: Vec<&str> = tests.split(';').map(str::trim).filter(|t| !t.is_empty()).collect();
    if state == "done" && tests.is_empty() {
        found.push("is done, but no test proves it".to_owned());
    }
    if state != "todo" && place.trim().is_empty() {
        found.push("does not say where".to_owned());
    }
    let visible = ["cairn ", "page: "].iter().any(|kind| attempt.starts_with(kind));
    if state != "todo" && !visible && !(state == "partial" && attempt.starts_with("none: ")) {
        found.push(
            "does not say how to try it: `cairn …`, `page: …`, or `none: …` if partial".to_owned(),
        );
    }
    let absent = tests.into_iter().filter(|test| !test_exists(repository, test));
    found.extend(absent.map(|test| format!("there is no test `{test}`")));
    found
}

/// Whether a test function of that name is in that crate, or a browser test in the web tests.
fn test_exists(repository: &Repository, test: &str) -> bool {
    let Some((member, path)) = test.split_once("::") else { return false };
    if member == "web" {
        let mut files = repository.files.iter().filter(|(file, _)| file.starts_with(WEB_TESTS));
        // Tests are declared with `test(` or with a wrapper such as `pageTest(`.
        let quoted = ['"', '\'', '`'].map(|quote| format!("est({quote}{path}{quote}"));
        return files.any(|(_, text)| quoted.iter().any(|call| text.contains(call)));
    }
    let name = path.rsplit("::").next().unwrap_or(path);
    let head = format!("fn {name}(");
    let folder = format!("crates/{member}/");
    repository
        .rust_files(&folder)
        .any(|(_, text)| text.match_indices(&head).any(|(at, _)| is_marked_as_test(&text[..at])))
}

/// Whether the lines before a function, back to the previous item, hold a test attribute.
fn is_marked_as_test(before: &str) -> bool {
    let attributes = before.lines().rev().skip_while(|line| line.trim().is_empty());
    let attributes = attributes.take_while(|line| {
        let line = line.trim();
        line.starts_with('#') || line.starts_with("//") || ["", "async", "pub"].contains(&line)
    });
    attributes.into_iter().any(|line| line.contains("test]") || line.contains("test("))
}

/// Line number and columns of every row below the head.
fn rows(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let numbered = (1..).zip(text.lines()).skip(1).filter(|(_, line)| !line.is_empty());
    numbered.map(|(number, line)| (number, line.split('\t').collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn every_kind_of_gap_is_reported() {
        let repository = Repository::of(&[
            (
                "docs/requirements.tsv",
                "id\tclass\trequirement\tsource\nA1\tC\tx\ty\nA2\tC\tx\ty\nA3\t\tx\ty\n",
            ),
            (
                "docs/coverage.tsv",
                "id\tstate\twhere\ttests\ttry\n\
                 A1\tdone\ta\ta::b::t; web::a page opens\tcairn x\n\
                 A2\tdone\ta\t\tnone: no\n\
                 A2\tfinished\ta\t\tpage: y\n\
                 A9\tpartial\t\ta::helper; b::t; web::no page; t\tnone: no\n\
                 A3\ttodo\t\t\n",
            ),
            ("crates/a/src/lib.rs", "//! A.\nfn helper() {}\n#[test]\n/// Says what.\nfn t() {}\n"),
            ("crates/studio/web/tests/a.test.mjs", "test('a page opens', () => {});"),
        ]);
        expect![[r#"
            docs/coverage.tsv has A2 more than once
            docs/coverage.tsv:3 A2: is done, but no test proves it
            docs/coverage.tsv:3 A2: does not say how to try it: `cairn …`, `page: …`, or `none: …` if partial
            docs/coverage.tsv:4 A2: `finished` is no state; they are done, partial, todo
            docs/coverage.tsv:5 A9: is not in docs/requirements.tsv
            docs/coverage.tsv:5 A9: does not say where
            docs/coverage.tsv:5 A9: there is no test `a::helper`
            docs/coverage.tsv:5 A9: there is no test `b::t`
            docs/coverage.tsv:5 A9: there is no test `web::no page`
            docs/coverage.tsv:5 A9: there is no test `t`
            docs/coverage.tsv:6 A3: has 4 columns, not 5: id, state, where, tests, try"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
