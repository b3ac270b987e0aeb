//! What a requirement of success is: how it is told to people, when it has come true, and whether it can.

use std::fmt;

use run_context::Stamp;

use super::{cast::Cast, facts::Facts};
use crate::verdict::Check;

/// A key of `[success]`, for people.
#[derive(Clone, Copy, Debug)]
pub(crate) struct About {
    /// The key.
    pub(crate) key: &'static str,
    /// What it asks for, a sentence without a full stop.
    pub(crate) text: &'static str,
    /// Its lines in the template; a table of its own begins with `[[success.`.
    pub(crate) template: &'static str,
}

/// How far a requirement has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    Open,
    Done(Stamp),
    Missed,
}

/// Its state, and what was noted when it came true.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    pub(crate) state: State,
    /// Distance (m) and turn (rad) from a goal when it was reached: the robot may have gone on since.
    pub(crate) reached: Option<(f64, f64)>,
}

impl Progress {
    pub(crate) fn is_done(self) -> bool {
        matches!(self.state, State::Done(_))
    }
}

/// A requirement that was checked against the mission.
pub(crate) trait Requirement: fmt::Debug + Send + Sync {
    /// Of something that must happen: whether it has, and its deadline. Nothing of what must hold at the end.
    fn happened(&self, _progress: Progress, _facts: &dyn Facts) -> Option<(bool, Stamp)> {
        None
    }

    /// What is noted when it happens.
    fn note(&self, _facts: &dyn Facts) -> Option<(f64, f64)> {
        None
    }

    /// Whether it holds, with what was found and what is allowed. What is not known does not hold.
    fn check(&self, progress: Progress, facts: &dyn Facts) -> Check;

    /// Why it can hardly be meant or met, a sentence each.
    fn warnings(&self, cast: &Cast<'_>) -> Vec<String>;

    /// How near to its goal a robot must come, m; for the map.
    fn arrival_within_m(&self, _robot: usize) -> Option<f64> {
        None
    }
}

/// A check with its short name.
pub(super) fn check(name: &str, passed: bool, text: impl Into<String>) -> Check {
    Check { name: name.to_owned(), passed, text: text.into() }
}
