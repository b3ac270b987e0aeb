//! Values that are not allowed, said so that their author finds them.

use std::fmt;

use crate::setter;

/// A value outside what is allowed: where it stands, what it is, what it must be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// The file.
    pub origin: String,
    /// Line and column in it, from 1; `None` when the key is absent or was set elsewhere.
    pub position: Option<(usize, usize)>,
    /// The key with its tables, such as `robots[0].mind.follow.speed_mps`.
    pub key: String,
    /// What was found.
    pub found: String,
    /// What it must be, as prose.
    pub allowed: String,
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.origin)?;
        if let Some((line, column)) = self.position {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {} = {}: must be {}", self.key, self.found, self.allowed)
    }
}

impl std::error::Error for SettingError {}

/// A value that is not allowed, before it is known where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// The key with its tables.
    pub key: String,
    /// What was found.
    pub found: String,
    /// What it must be, as prose.
    pub allowed: String,
    /// Line and column (from 1) within the value, where that is a text of many lines.
    pub within: Option<(usize, usize)>,
}

impl Wrong {
    /// `key` must be `allowed`, but is `found`.
    pub fn new(key: impl Into<String>, found: impl fmt::Debug, allowed: impl Into<String>) -> Self {
        Self::prose(key, format!("{found:?}"), allowed)
    }

    /// The same with a found value that is prose already.
    pub fn prose(
        key: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self { key: key.into(), found: found.into(), allowed: allowed.into(), within: None }
    }

    /// The same, with line and column (from 1) within the value.
    #[must_use]
    pub fn within(self, line: usize, column: usize) -> Self {
        Self { within: Some((line, column)), ..self }
    }

    /// Puts it into a file of its own, called `origin`, that was read for the key.
    pub fn in_file(self, origin: &str) -> SettingError {
        let origin = origin.to_owned();
        let Self { key, found, allowed, within } = self;
        SettingError { origin, position: within, key, found, allowed }
    }

    /// Puts it at its place in `text`, a file called `origin`; or at the override that set it, if one did.
    pub fn located(self, origin: &str, text: &str, overrides: &[String]) -> SettingError {
        let (origin, position) = match setter(overrides, &self.key) {
            Some(given) => (format!("--set {given}"), None),
            None => (origin.to_owned(), position_of(text, &self.key)),
        };
        SettingError { origin, position, key: self.key, found: self.found, allowed: self.allowed }
    }
}

/// Line and column (from 1) of the value at a dotted `key` in `text`; of its nearest table when the
/// key itself is absent.
fn position_of(text: &str, key: &str) -> Option<(usize, usize)> {
    let table = toml::de::DeTable::parse(text).ok()?;
    let mut offset = None;
    let mut value: Option<&toml::Spanned<toml::de::DeValue<'_>>> = None;
    for part in key.split('.') {
        let (name, indices) = part.split_once('[').unwrap_or((part, ""));
        let next = match value {
            None => table.get_ref().get(name),
            Some(v) => v.get_ref().get(name),
        };
        let Some(mut next) = next else { break };
        offset = Some(next.span().start);
        for index in indices.split('[') {
            let Ok(index) = index.trim_end_matches(']').parse::<usize>() else { break };
            let Some(inner) = next.get_ref().get(index) else { break };
            next = inner;
            offset = Some(next.span().start);
        }
        value = Some(next);
    }
    let before = text.get(..offset?)?;
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    Some((line, column))
}

/// A number within a range, which must be finite; NaN is out of every range.
///
/// # Errors
///
/// [`Wrong`] with `prose` as what it must be.
pub fn range(
    key: impl Into<String>,
    value: f64,
    allowed: std::ops::RangeInclusive<f64>,
    prose: &str,
) -> Result<f64, Wrong> {
    if allowed.contains(&value) { Ok(value) } else { Err(Wrong::new(key, value, prose)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_point_at_the_value() {
        let text = "[mission]\nname = \"a\"\n\n[[robots]]\nname = \"x\"\n[robots.line]\nbaud = 7\n";
        assert_eq!(position_of(text, "mission.name"), Some((2, 8)));
        assert_eq!(position_of(text, "robots[0].line.baud"), Some((7, 8)));
        assert_eq!(position_of(text, "robots[0].absent"), Some((4, 1)));
        assert_eq!(position_of(text, "nothing.at.all"), None);
    }

    #[test]
    fn a_wrong_value_is_said_where_it_was_written() {
        let text = "[map]\nresolution_m = 7.0\n";
        let wrong = range("map.resolution_m", 7.0, 0.01..=1.0, "from 0.01 to 1 m").unwrap_err();
        let said = wrong.clone().located("a.toml", text, &[]).to_string();
        assert_eq!(said, "a.toml:2:16: map.resolution_m = 7.0: must be from 0.01 to 1 m");
        let set = ["map.resolution_m=7.0".to_owned()];
        let said = wrong.located("a.toml", text, &set).to_string();
        assert_eq!(
            said,
            "--set map.resolution_m=7.0: map.resolution_m = 7.0: must be from 0.01 to 1 m"
        );
        assert_eq!(range("k", 1.0, 0.01..=1.0, ""), Ok(1.0));
        assert!(range("k", f64::NAN, 0.01..=1.0, "").is_err());
    }
}
