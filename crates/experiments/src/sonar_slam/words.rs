//! Numbers as the report writes them.

/// Metres with three digits; a dash for what was not measured.
pub(super) fn metres(value: f64) -> String {
    number(value, 3)
}

/// A ratio in per cent.
pub(super) fn percent(ratio: f64) -> String {
    number(100.0 * ratio, 1)
}

/// So many digits; a dash for what was not measured.
pub(super) fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".to_owned() }
}
