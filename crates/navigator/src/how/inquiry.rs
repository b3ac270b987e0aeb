//! Questions to the pheromone server: one at a time, each answered, repeated or given up.

use std::time::Duration;

use geometry::{Se2, Transform2};
use run_context::Stamp;

use messages::Command;

/// Who asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asker {
    /// The robot, about its own pose.
    Own,
    /// The scout, about a pose that nobody is at.
    Scout,
}

/// The question that is out, and what was learnt about the server.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inquiry {
    next_id: u8,
    out: Option<(u8, Asker, Stamp)>,
    silent_since: Option<Stamp>,
}

/// A question without an answer after this time is asked again; the wire alone takes 27 ms.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

impl Inquiry {
    /// Whether the link is free for a question.
    pub(crate) fn is_free(&self, now: Stamp) -> bool {
        self.out.is_none_or(|(_, _, asked)| now.since(asked) >= ANSWER_LIMIT)
    }

    pub(crate) fn ask(&mut self, now: Stamp, asker: Asker, pose: Se2, commands: &mut Vec<Command>) {
        let query = self.next_id;
        self.next_id = query.wrapping_add(1);
        self.out = Some((query, asker, now));
        self.silent_since.get_or_insert(now);
        commands.push(Command::QueryPheromones { query, map_from_base: Transform2::new(pose) });
    }

    /// Whose question this answers; `None` for late and foreign answers.
    pub(crate) fn answer(&mut self, query: u8) -> Option<Asker> {
        let (_, asker, _) = self.out.filter(|(id, _, _)| *id == query)?;
        self.out = None;
        self.silent_since = None;
        Some(asker)
    }

    /// Since when questions have gone unanswered.
    pub(crate) fn silence(&self, now: Stamp) -> Duration {
        self.silent_since.map_or(Duration::ZERO, |since| now.since(since))
    }

    /// Forgets the question that is out; its answer will not be taken for another's.
    pub(crate) fn cancel(&mut self) {
        self.out = None;
        self.silent_since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_and_foreign_answers_count_for_nothing() {
        let (mut inquiry, mut commands) = (Inquiry::default(), Vec::new());
        let at = Stamp::from_millis;
        inquiry.ask(at(0), Asker::Own, Se2::IDENTITY, &mut commands);
        assert!(!inquiry.is_free(at(299)));
        assert!(inquiry.is_free(at(300)));
        assert_eq!(inquiry.silence(at(300)), Duration::from_millis(300));
        inquiry.ask(at(300), Asker::Scout, Se2::IDENTITY, &mut commands);
        assert_eq!(inquiry.answer(0), None);
        assert_eq!(inquiry.answer(1), Some(Asker::Scout));
        assert_eq!(inquiry.answer(1), None);
        assert_eq!(inquiry.silence(at(900)), Duration::ZERO);
        inquiry.ask(at(900), Asker::Own, Se2::IDENTITY, &mut commands);
        inquiry.cancel();
        assert_eq!(inquiry.answer(2), None);
        assert_eq!(commands.len(), 3);
    }
}
