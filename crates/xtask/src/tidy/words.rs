//! The repository speaks of the product: not of how, where or by what it was written.

use crate::repository::Repository;

/// Words that belong to a workplace, compared without regard to case. They are written in two
/// halves so that this file passes its own check.
const WORDS: &[(&str, &str)] = &[
    ("/wo", "rk/"),
    ("/ro", "ot/"),
    ("helper a", "gent"),
    ("suba", "gent"),
    ("sub-a", "gent"),
    ("language mo", "del"),
    ("chat", "gpt"),
    ("clau", "de"),
    ("anth", "ropic"),
    ("open", "ai"),
    ("contracts", ".md"),
    ("index.cra", "tes.io"),
    ("static.cra", "tes.io"),
    ("files.python", "hosted"),
    ("proxy.gol", "ang"),
];

/// A mirror of a package registry in a lock file would fail everywhere else.
const LOCK_FILE: &str = "package-lock.json";
const PUBLIC_REGISTRY: &str = "https://registry.npmjs.org/";

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let words: Vec<String> = WORDS.iter().map(|(a, b)| format!("{a}{b}")).collect();
    let mut found = Vec::new();
    for (path, text) in &repository.files {
        for (number, line) in (1..).zip(text.lines()) {
            let lower = line.to_lowercase();
            let named = words.iter().filter(|word| lower.contains(*word));
            found.extend(named.map(|word| format!("{path}:{number} has `{word}`")));
            if path.ends_with(LOCK_FILE)
                && line.contains("\"resolved\"")
                && !line.contains(PUBLIC_REGISTRY)
            {
                found.push(format!("{path}:{number} is fetched from a private place"));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn workplaces_and_mirrors_are_reported() {
        let path = format!("see {}{}notes", WORDS[0].0, WORDS[0].1);
        let repository = Repository::of(&[
            ("README.md", "It works.\nHomework/exercise"),
            ("docs/a.md", &path),
            (
                "web/package-lock.json",
                "\"resolved\": \"https://registry.npmjs.org/a.tgz\",\n\
                 \"resolved\": \"http://mirror/a.tgz\",",
            ),
        ]);
        expect![[r#"
            docs/a.md:1 has `WORD`
            web/package-lock.json:2 is fetched from a private place"#]]
        .assert_eq(&findings(&repository).join("\n").replace(&path[4..10], "WORD"));
    }
}
