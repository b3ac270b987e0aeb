//! Every code of the decision language has a page in `docs/problems`, and every page its code.

use std::collections::BTreeSet;

use crate::repository::Repository;

const REGISTRY: &str = "crates/decision/src/codes.rs";
const PAGES: &str = "docs/problems/";

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let codes = codes(repository.text(REGISTRY));
    let mut found = Vec::new();
    if codes.is_empty() {
        found.push(format!("{REGISTRY} holds no code"));
    }
    let mut pages = BTreeSet::new();
    for (path, text) in &repository.files {
        let Some(page) = path.strip_prefix(PAGES).and_then(|p| p.strip_suffix(".md")) else {
            continue;
        };
        // An index may stand beside the pages.
        if page == "README" {
            continue;
        }
        pages.insert(page);
        if !codes.contains(page) {
            found.push(format!("{path} explains a code that {REGISTRY} does not have"));
        }
        if !text.lines().next().is_some_and(|head| head.contains(page)) {
            found.push(format!("{path} does not name its code in the first line"));
        }
    }
    let lacking = codes.iter().filter(|code| !pages.contains(*code));
    found.extend(lacking.map(|code| format!("{code} has no page {PAGES}{code}.md")));
    found
}

/// Every word that is an R and four digits, in code, not in comments.
fn codes(source: &str) -> BTreeSet<&str> {
    let lines = source.lines().filter(|line| !line.trim_start().starts_with("//"));
    let words = lines.flat_map(|line| line.split(|c: char| !c.is_ascii_alphanumeric()));
    let is_code = |word: &&str| {
        let digits = word.strip_prefix('R');
        digits.is_some_and(|d| d.len() == 4 && d.bytes().all(|b| b.is_ascii_digit()))
    };
    words.filter(is_code).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn missing_and_stray_pages_are_reported() {
        let repository = Repository::of(&[
            (REGISTRY, "// R7777 was withdrawn.\nA R1001 \"a\"; B R1002 \"b\"; R12 R10003"),
            ("docs/problems/R1001.md", "# R1001: a\n"),
            ("docs/problems/R2001.md", "# Something\n"),
            ("docs/problems/README.md", "# All\n"),
        ]);
        expect![[r#"
            docs/problems/R2001.md explains a code that crates/decision/src/codes.rs does not have
            docs/problems/R2001.md does not name its code in the first line
            R1002 has no page docs/problems/R1002.md"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
