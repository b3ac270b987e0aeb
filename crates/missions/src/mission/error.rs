//! What can be wrong with a mission, said so that its author can act on it.

use std::{fmt, path::PathBuf};

/// A mission that cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MissionError {
    /// Neither a shipped mission nor a file.
    #[error("no mission is called `{name}` and no such file exists; shipped missions: {shipped}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names that exist.
        shipped: String,
    },
    /// A file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not TOML, or a key is unknown or of the wrong type; the parser's own message
    /// shows line, column and what was expected.
    #[error("{origin}: {message}")]
    Syntax {
        /// The file.
        origin: String,
        /// The parser's message.
        message: String,
    },
    /// A `--set` that cannot be applied.
    #[error("--set {given}: {problem}")]
    Override {
        /// What was given.
        given: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A value that is not allowed.
    #[error("{0}")]
    Setting(Box<SettingError>),
}

/// A value outside what is allowed: where it stands, what it is, what it must be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// The file.
    pub origin: String,
    /// Line and column in it, from 1; `None` when the key is absent or was set elsewhere.
    pub position: Option<(usize, usize)>,
    /// The key with its tables, such as `robots[0].navigator.speed_mps`.
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
pub(crate) struct Wrong {
    pub(crate) key: String,
    pub(crate) found: String,
    pub(crate) allowed: String,
}

impl Wrong {
    /// `key` must be `allowed`, but is `found`.
    pub(crate) fn new(
        key: impl Into<String>,
        found: impl fmt::Debug,
        allowed: impl Into<String>,
    ) -> Self {
        Self { key: key.into(), found: format!("{found:?}"), allowed: allowed.into() }
    }

    /// The same with a found value that is prose already.
    pub(crate) fn prose(
        key: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self { key: key.into(), found: found.into(), allowed: allowed.into() }
    }

    /// Puts it at its place in `text`.
    pub(crate) fn located(self, origin: &str, text: &str) -> MissionError {
        let position = position_of(text, &self.key);
        MissionError::Setting(Box::new(SettingError {
            origin: origin.to_owned(),
            position,
            key: self.key,
            found: self.found,
            allowed: self.allowed,
        }))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_point_at_the_value() {
        let text = "[mission]\nname = \"a\"\n\n[[robots]]\nname = \"x\"\n[robots.link]\nbaud = 7\n";
        assert_eq!(position_of(text, "mission.name"), Some((2, 8)));
        assert_eq!(position_of(text, "robots[0].link.baud"), Some((7, 8)));
        assert_eq!(position_of(text, "robots[0].absent"), Some((4, 1)));
        assert_eq!(position_of(text, "nothing.at.all"), None);
    }
}
