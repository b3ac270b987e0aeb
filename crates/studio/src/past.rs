//! What a live run showed before: whole states, so that a page can look back while the run goes on.
//!
//! A state is kept every 0.1 s of the run's time (of a crowd, which takes forty times the room, every half second), as
//! the text that pages are sent. When all of them together are larger than [`BYTES_MAX`], every second one of the older
//! half goes, again and again: the newest minutes stay fine, the beginning gets coarser, and the first state stays.

use std::collections::VecDeque;

use serde::Serialize;

/// Bytes that the states of a run may take.
pub(crate) const BYTES_MAX: usize = 16 * 1024 * 1024;
/// Steps between two states that are kept.
const N_STEPS: u64 = 10;
/// The same when there is a crowd.
const N_STEPS_OF_CROWD: u64 = 50;

/// States of a run by their times.
#[derive(Debug)]
pub(crate) struct Past {
    n_steps: u64,
    bytes_max: usize,
    n_bytes: usize,
    /// Rising in time.
    states: VecDeque<(f64, Box<str>)>,
}

/// How much is kept, for people.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Kept {
    pub n_states: usize,
    pub n_bytes: usize,
    pub bytes_max: usize,
    /// Between two states at first, s.
    pub period_s: f64,
    /// The longest time between two of them by now, s.
    pub gap_max_s: f64,
}

impl Past {
    /// Of a run that begins.
    pub(crate) fn new(is_crowd: bool) -> Self {
        Self::with_room(is_crowd, BYTES_MAX)
    }

    fn with_room(is_crowd: bool, bytes_max: usize) -> Self {
        let n_steps = if is_crowd { N_STEPS_OF_CROWD } else { N_STEPS };
        Self { n_steps, bytes_max, n_bytes: 0, states: VecDeque::new() }
    }

    /// Whether the state after so many steps is kept.
    pub(crate) fn wants(&self, steps: u64) -> bool {
        steps.is_multiple_of(self.n_steps)
    }

    /// Keeps a state.
    pub(crate) fn keep(&mut self, t_s: f64, text: String) {
        self.n_bytes += text.len();
        self.states.push_back((t_s, text.into_boxed_str()));
        while self.n_bytes > self.bytes_max && self.states.len() > 3 {
            self.thin();
        }
    }

    /// Drops every second state of the older half.
    fn thin(&mut self) {
        let half = self.states.len().div_ceil(2);
        let mut index = 0;
        let n_bytes = &mut self.n_bytes;
        self.states.retain(|(_, text)| {
            let stays = index >= half || index % 2 == 0;
            index += 1;
            if !stays {
                *n_bytes -= text.len();
            }
            stays
        });
    }

    /// The newest state that is not after a time; before the first one, that.
    pub(crate) fn at(&self, t_s: f64) -> Option<&str> {
        let after = self.states.partition_point(|(at_s, _)| *at_s <= t_s + 1e-6);
        self.states.get(after.saturating_sub(1)).map(|(_, text)| &**text)
    }

    /// How much is kept.
    pub(crate) fn kept(&self) -> Kept {
        let times = self.states.iter().map(|state| state.0);
        let gaps = times.clone().skip(1).zip(times).map(|(after_s, before_s)| after_s - before_s);
        Kept {
            n_states: self.states.len(),
            n_bytes: self.n_bytes,
            bytes_max: self.bytes_max,
            period_s: self.n_steps as f64 / 100.0,
            gap_max_s: (gaps.fold(0.0, f64::max) * 1e3).round() / 1e3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hours of a run in the room of a hundred states.
    #[test]
    fn the_newest_are_fine_the_oldest_coarse_and_memory_is_bounded() {
        let mut past = Past::with_room(false, 100 * 1000);
        let n_states = 100_000_u32;
        for i in 0..n_states {
            past.keep(f64::from(i) / 10.0, format!("{i:>1000}"));
            assert!(past.n_bytes <= 100 * 1000);
            let newest: Vec<_> = past.states.iter().rev().take(20).map(|state| state.0).collect();
            let is_fine = |w: &[f64]| (w[0] - w[1] - 0.1).abs() < 1e-6;
            assert!(newest.windows(2).all(is_fine), "after {i}: {newest:?}");
        }
        let kept = past.kept();
        assert!(kept.n_bytes <= 100 * 1000 && kept.n_states >= 50, "{kept:?}");
        assert_eq!(past.states.iter().map(|s| s.1.len()).sum::<usize>(), kept.n_bytes);
        assert_eq!(past.at(0.0).map(str::trim), Some("0"), "the first one stays");
        assert!(kept.gap_max_s > 100.0, "{kept:?}");
    }

    #[test]
    fn a_time_gives_the_state_that_was_shown_then() {
        let mut past = Past::new(false);
        assert!(past.at(1.0).is_none());
        for i in 0..10_u32 {
            past.keep(f64::from(i) / 10.0, i.to_string());
        }
        for (t_s, wanted) in [(-1.0, "0"), (0.0, "0"), (0.19, "1"), (0.2, "2"), (99.0, "9")] {
            assert_eq!(past.at(t_s), Some(wanted), "{t_s}");
        }
        assert!(past.wants(0) && past.wants(10) && !past.wants(15));
        assert!(!Past::new(true).wants(10) && Past::new(true).wants(50));
        assert!((past.kept().gap_max_s - 0.1).abs() < 1e-9);
    }
}
