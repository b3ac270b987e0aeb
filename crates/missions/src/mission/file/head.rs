//! `[mission]`: what it is called and how long it may take.

use serde::{Deserialize, Serialize};

/// `[mission]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeadFile {
    /// Short name: small letters, digits, `-`.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// What happens and what to look at.
    pub about: String,
    /// The run ends at this time at the latest, seconds.
    pub duration_max_s: f64,
    /// Seed used unless another is asked for.
    pub seed: u64,
}

impl Default for HeadFile {
    fn default() -> Self {
        Self {
            name: "untitled".into(),
            title: String::new(),
            about: String::new(),
            duration_max_s: 120.0,
            seed: 1,
        }
    }
}
