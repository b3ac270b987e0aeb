//! A public number says its unit in its name: `speed_max_mps`, not `max_speed`.
//!
//! Looks at public fields and at parameters of public functions whose type is `f64` or `f32`, also
//! inside `Option` or a range. Arrays and vectors say unit and order in their documents, and names
//! that begin with `n_` count. It reads text, not syntax: enough for sources that rustfmt has laid
//! out.

use crate::repository::Repository;

/// What may end a name: units first, then kinds of number that have none.
const ENDINGS: &[&str] = &[
    "m",
    "mm",
    "cm",
    "m2",
    "s",
    "ms",
    "ns",
    "rad",
    "deg",
    "mps",
    "mmps",
    "mps2",
    "mmps2",
    "radps",
    "degps",
    "radps2",
    "hz",
    "px",
    "cells",
    "v",
    "per_s",
    "per_m",
    "radpm",
    "bits",
    "degpm",
    "kg",
    "w",
    "mah",
    "per_turn",
    "per_tick",
    "ratio",
    "prob",
    "logodds",
    "percent",
    "intensity",
];

/// Crates whose public parts serve this repository only.
const EXEMPT_CRATES: &[&str] = &["bench_suite", "testkit", "xtask"];

/// Crate (`*` for any), name and reason of numbers that need no unit.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("*", "value", "in an error: what a key says that is named beside it, with its unit"),
    ("*", "left", "intensity of pheromones, 0 to 255: the unit is the field's own"),
    ("*", "right", "intensity of pheromones, 0 to 255: the unit is the field's own"),
    (
        "navigator",
        "follower_error",
        "the unit depends on the law that follows; so says its document",
    ),
    ("least_squares", "chi2_before", "a sum of squares in units of standard deviations"),
    ("least_squares", "chi2_at_start", "a sum of squares in units of standard deviations"),
    ("least_squares", "chi2_after", "a sum of squares in units of standard deviations"),
    ("least_squares", "cost_at_start", "a sum of squares in units of standard deviations"),
    ("least_squares", "cost_after", "a sum of squares in units of standard deviations"),
    ("path_following", "error", "input of a fuzzy controller: the caller chooses the unit"),
    ("path_following", "change", "input of a fuzzy controller: the caller chooses the unit"),
    ("path_following", "input", "input of a fuzzy controller: the caller chooses the unit"),
    ("path_following", "full", "scale of an input, in the input's unit"),
    ("path_following", "error_full", "scale of an input, in the input's unit"),
    ("path_following", "change_full", "scale of an input, in the input's unit"),
    ("robot_models", "min", "in an error: the limit of a key that is named beside it"),
    ("robot_models", "max", "in an error: the limit of a key that is named beside it"),
];

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in repository.rust_files("crates/") {
        let parts: Vec<&str> = path.split('/').collect();
        let ["crates", member, "src", ..] = parts[..] else { continue };
        if EXEMPT_CRATES.contains(&member) || path.ends_with("tests.rs") {
            continue;
        }
        for (line, name) in public_numbers(text) {
            let allowed = ALLOWED.iter().any(|(c, n, _)| (*c == member || *c == "*") && *n == name);
            if !has_unit(&name) && !allowed {
                found.push(format!("{path}:{line} `{name}` does not end in its unit"));
            }
        }
    }
    found
}

fn has_unit(name: &str) -> bool {
    name.starts_with("n_")
        || ENDINGS.iter().any(|ending| {
            let before = name.strip_suffix(ending);
            before.is_some_and(|before| before.is_empty() || before.ends_with('_'))
        })
}

/// Line and name of every public floating-point field and parameter before the tests.
fn public_numbers(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut signature: Option<(usize, String)> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line == "#[cfg(test)]" {
            break;
        }
        if line.starts_with("//") {
            continue;
        }
        let opens =
            ["pub fn ", "pub const fn ", "pub async fn "].iter().any(|o| line.starts_with(o));
        if opens {
            signature = Some((number, String::new()));
        } else if signature.is_none()
            && let Some((name, kind)) = field(line)
            && is_float(kind)
        {
            found.push((number, name.to_owned()));
        }
        if let Some((_, text)) = &mut signature {
            text.push_str(line);
            text.push(' ');
        }
        if line.ends_with(['{', ';', '}'])
            && let Some((number, text)) = signature.take()
        {
            found.extend(parameters(&text).into_iter().map(|name| (number, name)));
        }
    }
    found
}

/// Name and type of a line like `pub name: kind,`.
fn field(line: &str) -> Option<(&str, &str)> {
    let (name, kind) = line.strip_prefix("pub ")?.split_once(": ")?;
    let is_name = name.chars().all(|c| c.is_alphanumeric() || c == '_');
    is_name.then_some((name, kind.trim_end_matches(',')))
}

/// Names of the floating-point parameters of a signature.
fn parameters(signature: &str) -> Vec<String> {
    let Some((_, inside)) = signature.split_once('(') else { return Vec::new() };
    let mut depth = 1;
    let mut end = inside.len();
    for (i, c) in inside.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            end = i;
            break;
        }
    }
    let parameters = inside[..end].split(", ").filter_map(|p| p.trim().split_once(": "));
    let floats = parameters.filter(|(_, kind)| is_float(kind.trim_end_matches([',', ' '])));
    floats.map(|(name, _)| name.trim_start_matches("mut ").to_owned()).collect()
}

fn is_float(kind: &str) -> bool {
    let bare = kind.trim_start_matches("Option<").trim_end_matches('>');
    let bare = bare.trim_start_matches("RangeInclusive<").trim_start_matches("Range<");
    matches!(bare.trim_start_matches('&'), "f64" | "f32")
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn fields_and_parameters_without_a_unit_are_reported() {
        let source = "\
//! A module.
pub struct Robot {
    /// pub doc: f64,
    pub speed: f64,
    pub speed_max_mps: f64,
    pub max_mps_speed: Option<f64>,
    pub place: [f64; 3],
    pub n_sigma: f64,
    pub range: Range<f64>,
    pub(crate) hidden: f64,
    pub name: String,
    inner: f64,
}
pub fn turn(robot: &Robot, angle: f64, by_rad: f64) -> f64 {
    let pub_x: f64 = 0.0;
}
pub fn long(
    range_m: f64,
    mut limit: Option<f64>,
    check: impl Fn(f64) -> f64,
) {
}
fn private(x: f64) {}
#[cfg(test)]
mod tests { pub fn x(y: f64) {} }
";
        let repository = Repository::of(&[
            ("crates/a/src/lib.rs", source),
            ("crates/robot_models/src/lib.rs", "pub fn between(min: f64) {}"),
            ("crates/b/src/lib.rs", "pub fn between(min: f64) {}"),
            ("crates/testkit/src/lib.rs", "pub fn between(min: f64) {}"),
        ]);
        expect![[r#"
            crates/a/src/lib.rs:4 `speed` does not end in its unit
            crates/a/src/lib.rs:6 `max_mps_speed` does not end in its unit
            crates/a/src/lib.rs:9 `range` does not end in its unit
            crates/a/src/lib.rs:14 `angle` does not end in its unit
            crates/a/src/lib.rs:17 `limit` does not end in its unit
            crates/b/src/lib.rs:1 `min` does not end in its unit"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
