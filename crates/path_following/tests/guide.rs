//! The guide's tables of laws are those of the crate; `UPDATE_EXPECT=1` brings them up to date.

#![cfg(test)]

use expect_test::expect_file;
use path_following::{PathController, TrailController};

fn table(key: &str, rows: impl Iterator<Item = (&'static str, &'static str)>) -> String {
    let rows = rows.map(|(word, about)| format!("| `{word}` | {about} |\n"));
    format!("| `{key}` | how |\n| --- | --- |\n") + &rows.collect::<String>()
}

/// The text with what stands between two marks replaced.
fn with(text: &str, mark: &str, table: &str) -> String {
    let (begin, end) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->\n"));
    let (before, rest) = text.split_once(&begin).expect("a mark where the table begins");
    let (_, after) = rest.split_once(&end).expect("a mark where the table ends");
    format!("{before}{begin}{table}{end}{after}")
}

#[test]
fn the_guide_has_every_law() {
    let guide = include_str!("../../../docs/guide/missions.md");
    let paths = PathController::ALL.iter().map(|law| (law.key(), law.about()));
    let trails = TrailController::ALL.iter().map(|law| (law.key(), law.about()));
    let wanted = with(guide, "path laws", &table("mind.follow.path_law", paths));
    let wanted = with(&wanted, "trail laws", &table("mind.follow.trail_law", trails));
    expect_file!["../../../docs/guide/missions.md"].assert_eq(&wanted);
}

#[test]
fn words_of_laws_are_told_apart() {
    let distinct = |mut words: Vec<&str>| {
        let n = words.len();
        words.sort_unstable();
        words.dedup();
        words.len() == n && words.iter().all(|word| !word.is_empty())
    };
    assert!(distinct(PathController::ALL.iter().map(|law| law.key()).collect()));
    assert!(distinct(TrailController::ALL.iter().map(|law| law.key()).collect()));
    assert_eq!(PathController::ALL[0], PathController::default());
    assert_eq!(TrailController::ALL[0], TrailController::default());
}
