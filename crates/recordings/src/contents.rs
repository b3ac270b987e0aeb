//! What a file holds, in words, for messages on files that cannot be read.

use crate::{
    Format, RecordingError,
    complaints::Complaints,
    numbers::{Fields, lines, shown},
};

/// The error for a file without a usable scan, with the first complaints.
pub(crate) fn no_scans(
    name: &str,
    format: Format,
    contains: &str,
    complaints: &Complaints,
) -> RecordingError {
    let contains = with_complaints(contains, complaints);
    RecordingError::NoScans { name: name.to_owned(), format, contains }
}

/// A text with the first complaints behind it.
pub(crate) fn with_complaints(contains: &str, complaints: &Complaints) -> String {
    let first = complaints.kept().iter().take(3);
    first.fold(contains.to_owned(), |text, complaint| format!("{text}; {complaint}"))
}

/// The first bytes as a person can read them.
pub(crate) fn beginning(content: &[u8]) -> String {
    let text = String::from_utf8_lossy(&content[..content.len().min(48)]);
    format!("{:?}", shown(&text))
}

/// The words at the beginning of lines, with how often they occur: what a file holds.
pub(crate) fn first_words(content: &[u8]) -> String {
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    let mut n_lines = 0_usize;
    for (_, line) in lines(content) {
        n_lines += 1;
        let text = String::from_utf8_lossy(line);
        let word = Fields::new(&text).word("").map(shown).unwrap_or_default();
        if counts.len() < 1000 || counts.contains_key(&word) {
            *counts.entry(word).or_insert(0) += 1;
        }
    }
    let mut by_count: Vec<(String, usize)> = counts.into_iter().collect();
    by_count.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let kinds: Vec<String> =
        by_count.iter().take(6).map(|(word, n)| format!("{n} × {word:?}")).collect();
    format!("{n_lines} lines, beginning with {}", kinds.join(", "))
}
