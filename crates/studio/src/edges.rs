//! Changes of the decision program's booleans between two states.
//!
//! The program scans every 10 ms; at ten times real time a page sees one scan in thirty. Pulses would
//! be seen by luck only, so the levels are looked at after every step and the changes told with the state.

use std::collections::VecDeque;

use missions::Run;

use crate::protocol::Edge;

/// Changes kept; older ones are dropped first.
const N_EDGES_MAX: usize = 400;
/// Publications in which a change is repeated, for pages that miss one.
const N_TELLINGS: u64 = 4;

/// Remembers the levels and collects the changes.
#[derive(Debug, Default)]
pub(crate) struct Edges {
    /// In the order of [`Run::decision_resources`]; `None` for numbers and constants.
    levels: Vec<Option<bool>>,
    /// With the publication that was the first to tell it.
    changes: VecDeque<(u64, Edge)>,
    n_published: u64,
}

impl Edges {
    /// Begins with the present levels.
    pub(crate) fn of(run: &Run) -> Self {
        let level = |(name, byte): (&str, u8)| is_boolean(name).then_some(byte & 1 == 1);
        Self { levels: run.decision_resources().map(level).collect(), ..Self::default() }
    }

    /// Notes what changed in the last step. Allocates only when something did.
    pub(crate) fn look(&mut self, run: &Run) {
        for ((name, byte), level) in run.decision_resources().zip(&mut self.levels) {
            let high = byte & 1 == 1;
            if level.is_none_or(|before| before == high) {
                continue;
            }
            *level = Some(high);
            if self.changes.len() >= N_EDGES_MAX {
                self.changes.pop_front();
            }
            let edge = (run.now().as_secs_f64(), name.to_owned(), high);
            self.changes.push_back((self.n_published, edge));
        }
    }

    /// The changes that a page may not have seen, oldest first.
    pub(crate) fn publish(&mut self) -> Vec<Edge> {
        while self.changes.front().is_some_and(|(since, _)| self.n_published >= since + N_TELLINGS)
        {
            self.changes.pop_front();
        }
        self.n_published += 1;
        self.changes.iter().map(|(_, edge)| edge.clone()).collect()
    }
}

/// Whether a resource's byte is the history of a boolean. Constants are, but never change.
fn is_boolean(name: &str) -> bool {
    let families = ["I", "NI", "O", "Y", "YTMR", "S"];
    families.iter().any(|family| {
        let number = name.strip_prefix(family).unwrap_or_default();
        !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use missions::Mission;

    use super::*;

    fn rig() -> Run {
        let mission = Mission::load("decision-rig", &[]).unwrap();
        let seed = mission.seed();
        Run::new(mission, seed).unwrap()
    }

    #[test]
    fn booleans_are_told_from_numbers_and_constants() {
        for name in ["I0", "NI12", "O3", "Y2", "YTMR16", "S1"] {
            assert!(is_boolean(name), "{name}");
        }
        for name in ["M3", "A0", "0L", "1L", "STATUS", "QRUN", "Y", ""] {
            assert!(!is_boolean(name), "{name}");
        }
    }

    /// The bell of the rig is pressed at 2.0 s and released half a second later; both are told with
    /// their times however rarely somebody publishes.
    #[test]
    fn a_pulse_between_two_states_is_told_with_its_times() {
        let mut run = rig();
        let mut edges = Edges::of(&run);
        for _ in 0..400 {
            run.step();
            edges.look(&run);
        }
        let bell: Vec<Edge> =
            edges.publish().into_iter().filter(|(_, name, _)| name == "I0").collect();
        let (up, down) = (&bell[0], &bell[1]);
        assert_eq!(bell.len(), 2, "{bell:?}");
        assert!(up.2 && (up.0 - 2.0).abs() < 0.02, "{up:?}");
        assert!(!down.2 && (down.0 - 2.5).abs() < 0.02, "{down:?}");
    }

    #[test]
    fn a_change_is_repeated_for_a_while_and_then_forgotten() {
        let mut run = rig();
        let mut edges = Edges::of(&run);
        for _ in 0..300 {
            run.step();
            edges.look(&run);
        }
        let told: Vec<bool> = (0..6).map(|_| !edges.publish().is_empty()).collect();
        assert_eq!(told, [true, true, true, true, false, false]);
    }
}
