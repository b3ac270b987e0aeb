//! The longest control cycle: from the question about the robot's own pose to the answer that the wheel reference
//! follows from, as it took in virtual time. What the node computes takes none here.

use messages::{Command, Sensed, Smell};
use run_context::Stamp;

/// Begin and end markers of a robot's control cycles.
#[derive(Debug, Default)]
pub(super) struct Dialogue {
    asked_at: Option<(u8, Stamp)>,
    longest_ms: Option<f64>,
}

impl Dialogue {
    /// The navigator was told something.
    pub(super) fn hear(&mut self, now: Stamp, value: &Sensed) {
        let Sensed::Smell(Smell { query, .. }) = value else { return };
        if let Some((asked, at)) = self.asked_at
            && asked == *query
        {
            let cycle_ms = now.since(at).as_secs_f64() * 1e3;
            self.longest_ms = Some(self.longest_ms.map_or(cycle_ms, |max| max.max(cycle_ms)));
            self.asked_at = None;
        }
    }

    /// The navigator wants something.
    pub(super) fn say(&mut self, now: Stamp, command: &Command) {
        if let Command::QueryPheromones { query, .. } = command {
            self.asked_at = Some((*query, now));
        }
    }

    /// The longest cycle so far, ms; `None` before the first.
    pub(super) fn longest_ms(&self) -> Option<f64> {
        self.longest_ms
    }
}
