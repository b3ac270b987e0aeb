//! How long the stages of a run take, by a clock that the caller lends.

use std::{collections::BTreeMap, fmt, time::Duration};

/// A clock: time since any fixed moment. This crate reads none of its own.
#[derive(Default)]
pub struct Clock(Option<Box<dyn Fn() -> Duration + Send + Sync>>);

impl Clock {
    /// A clock that `read` reads.
    pub fn new(read: impl Fn() -> Duration + Send + Sync + 'static) -> Self {
        Self(Some(Box::new(read)))
    }

    /// A clock that stands still: every stage takes no time.
    pub fn stopped() -> Self {
        Self(None)
    }

    /// The time now.
    pub fn now(&self) -> Duration {
        self.0.as_ref().map_or(Duration::ZERO, |read| read())
    }
}

impl fmt::Debug for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Clock").field(&self.0.is_some()).finish()
    }
}

/// Time spent by stage.
#[derive(Debug, Default)]
pub struct Stages {
    clock: Clock,
    spent: BTreeMap<&'static str, Spent>,
}

/// What a stage took in all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Times that it was entered.
    pub n_times: usize,
    /// In all.
    pub total: Duration,
    /// The longest single time.
    pub longest: Duration,
}

impl Stages {
    /// Begins with nothing spent.
    pub fn new(clock: Clock) -> Self {
        Self { clock, spent: BTreeMap::new() }
    }

    /// The clock's time.
    pub fn now(&self) -> Duration {
        self.clock.now()
    }

    /// Does `work` and writes down under `stage` how long it took.
    pub fn measure<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let begun = self.clock.now();
        let result = work();
        self.add(stage, self.clock.now().saturating_sub(begun));
        result
    }

    /// Writes down that `stage` took `time`.
    pub fn add(&mut self, stage: &'static str, time: Duration) {
        let spent = self.spent.entry(stage).or_default();
        spent.n_times += 1;
        spent.total += time;
        spent.longest = spent.longest.max(time);
    }

    /// Every stage by name.
    pub fn all(&self) -> &BTreeMap<&'static str, Spent> {
        &self.spent
    }

    /// The sum over all stages.
    pub fn total(&self) -> Duration {
        self.spent.values().map(|spent| spent.total).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn stages_add_up() {
        // Each look at the clock moves it on: 1, 2, 3 … ms.
        let looks = AtomicU64::new(0);
        let tick = move || Duration::from_millis(looks.fetch_add(1, Ordering::Relaxed));
        let mut stages = Stages::new(Clock::new(tick));
        assert_eq!(stages.measure("match", || 7), 7);
        stages.add("match", Duration::from_millis(5));
        stages.add("map", Duration::from_millis(2));
        let matched = stages.all()["match"];
        assert_eq!((matched.n_times, matched.total.as_millis()), (2, 6));
        assert_eq!(matched.longest.as_millis(), 5);
        assert_eq!(stages.total().as_millis(), 8);
    }

    #[test]
    fn a_clock_that_stands_still_measures_nothing() {
        let mut stages = Stages::new(Clock::stopped());
        stages.measure("match", || ());
        assert_eq!(stages.total(), Duration::ZERO);
    }
}
