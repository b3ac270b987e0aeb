//! A run in figures.

use crate::verdict::Verdict;

/// What a run came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Name of the mission.
    pub mission: String,
    /// Seed of the run.
    pub seed: u64,
    /// Steps of 10 ms taken.
    pub steps: u64,
    /// The verdict, if the run has ended.
    pub verdict: Option<Verdict>,
    /// The figures, in a fixed order, units last in the names.
    pub figures: Vec<Figure>,
    /// Hash of the whole state after the last step, hexadecimal.
    pub state_hash: String,
}

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name with its unit last, such as `path_length_m`.
    pub name: &'static str,
    /// The value; `None` when it does not apply to this run.
    pub value: Option<f64>,
    /// What it is, in a few words.
    pub about: &'static str,
}

impl Summary {
    /// The value of a figure by its name.
    pub fn figure(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|f| f.name == name).and_then(|f| f.value)
    }
}
