//! Ticks in real time: how many are due.

use std::time::{Duration, Instant};

/// As much of the time in which the computer did something else is made up at once; a computer that
/// slept for an hour does not race through that hour.
pub(crate) const MADE_UP_MAX: Duration = Duration::from_secs(1);

/// Says how many ticks are due.
pub(crate) struct Pace {
    period: Duration,
    /// When the next tick is due.
    next: Instant,
    last_turn: Instant,
}

/// One turn of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    /// Ticks to be made now, at least one.
    pub(crate) n_ticks: u32,
    /// Time that is not made up.
    pub(crate) lost: Duration,
    /// Time since the turn before.
    pub(crate) since_last: Duration,
}

impl Pace {
    /// A first tick is due `now`, and one every `period` (not zero) from there on.
    pub(crate) fn new(period: Duration, now: Instant) -> Self {
        Self { period: period.max(Duration::from_millis(1)), next: now, last_turn: now }
    }

    /// The ticks that are due by `now`; the caller makes them.
    pub(crate) fn turn(&mut self, now: Instant) -> Turn {
        let since_last = now.saturating_duration_since(self.last_turn);
        self.last_turn = now;
        let late = now.saturating_duration_since(self.next);
        let lost = late.saturating_sub(MADE_UP_MAX);
        self.next += lost;
        let n_late = late.min(MADE_UP_MAX).as_nanos() / self.period.as_nanos();
        let n_ticks = u32::try_from(n_late).unwrap_or(u32::MAX).saturating_add(1);
        self.next += self.period * n_ticks;
        Turn { n_ticks, lost, since_last }
    }

    /// How long nothing is due.
    pub(crate) fn rest(&self, now: Instant) -> Option<Duration> {
        self.next.checked_duration_since(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(10);

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    /// Ticks made by somebody who runs while `runs` says so and sleeps no longer than it must.
    fn ticks(until_ms: u64, runs: impl Fn(u64) -> bool) -> (u32, Duration) {
        let began = Instant::now();
        let mut pace = Pace::new(PERIOD, began);
        let (mut n_ticks, mut lost) = (0, Duration::ZERO);
        for at_ms in 0..until_ms {
            let now = began + ms(at_ms);
            if runs(at_ms) && pace.rest(now).is_none_or(|rest| rest.is_zero()) {
                let turn = pace.turn(now);
                n_ticks += turn.n_ticks;
                lost += turn.lost;
            }
        }
        (n_ticks, lost)
    }

    #[test]
    fn a_process_that_is_held_makes_up_for_it() {
        assert_eq!(ticks(36_000, |_| true), (3600, Duration::ZERO));
        // Held for 60 ms in every 200.
        assert_eq!(ticks(36_000, |at| at % 200 >= 60), (3600, Duration::ZERO));
        // Or for 990 ms in every second.
        assert_eq!(ticks(36_000, |at| at % 1000 >= 990), (3600, Duration::ZERO));
    }

    #[test]
    fn what_cannot_be_made_up_is_lost_and_said() {
        // 5 s of sleep: four are lost.
        let (n_ticks, lost) = ticks(10_000, |at| !(2000..7000).contains(&at));
        assert_eq!(lost, ms(4000));
        assert_eq!(n_ticks, 600);
    }

    #[test]
    fn ticks_stay_on_their_beat() {
        let began = Instant::now();
        let mut pace = Pace::new(PERIOD, began);
        assert_eq!(pace.turn(began), Turn { n_ticks: 1, lost: ms(0), since_last: ms(0) });
        assert_eq!(pace.rest(began + ms(1)), Some(ms(9)));
        // Three late, and the next is due where it would have been anyway.
        assert_eq!(pace.turn(began + ms(34)), Turn { n_ticks: 3, lost: ms(0), since_last: ms(34) });
        assert_eq!(pace.rest(began + ms(34)), Some(ms(6)));
    }
}
