//! Whether a run was a success, requirement by requirement.

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Whether every check passed.
    pub passed: bool,
    /// One sentence.
    pub text: String,
    /// The checks, in the order of `[success]`.
    pub checks: Vec<Check>,
}

/// One requirement and how it came out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// Short name, such as `arrived`.
    pub name: String,
    /// Whether it holds.
    pub passed: bool,
    /// What was found and what is allowed.
    pub text: String,
}

impl Verdict {
    /// The verdict that follows from the checks; without any, a run that ends has passed.
    pub(crate) fn from_checks(checks: Vec<Check>) -> Self {
        let failed: Vec<String> = checks
            .iter()
            .filter(|c| !c.passed)
            .map(|c| format!("{}: {}", c.name, c.text))
            .collect();
        let text = if checks.is_empty() {
            "the mission asks for nothing".to_owned()
        } else if failed.is_empty() {
            "every requirement holds".to_owned()
        } else {
            failed.join("; ")
        };
        Self { passed: failed.is_empty(), text, checks }
    }
}
