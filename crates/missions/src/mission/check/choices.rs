//! Words that choose one of a few methods.

use super::super::error::Wrong;

/// The index of `found` in `allowed`; the error lists what is allowed.
pub(in super::super) fn choose(key: &str, found: &str, allowed: &[&str]) -> Result<usize, Wrong> {
    allowed.iter().position(|&a| a == found).ok_or_else(|| {
        let quoted: Vec<String> = allowed.iter().map(|a| format!("`{a}`")).collect();
        Wrong::new(key, found, format!("one of {}", quoted.join(", ")))
    })
}
