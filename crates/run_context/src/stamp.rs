//! Time as an argument: integer nanoseconds since the run began.

use std::{
    fmt,
    ops::{Add, AddAssign},
    time::Duration,
};

/// An instant of a run: whole nanoseconds since it began. Never the wall clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stamp(u64);

impl Stamp {
    /// The beginning of the run.
    pub const ZERO: Self = Self(0);

    /// The instant so many nanoseconds after the beginning.
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// The instant so many milliseconds after the beginning.
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis * 1_000_000)
    }

    /// Nanoseconds since the beginning.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the beginning, for people and formulas; exact to 1 ns up to 104 days.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Time from `earlier` to `self`; zero when `earlier` is later.
    pub const fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Duration> for Stamp {
    type Output = Self;

    /// Saturates after 584 years.
    fn add(self, rhs: Duration) -> Self {
        Self(self.0.saturating_add(u64::try_from(rhs.as_nanos()).unwrap_or(u64::MAX)))
    }
}

impl AddAssign<Duration> for Stamp {
    fn add_assign(&mut self, rhs: Duration) {
        *self = *self + rhs;
    }
}

impl fmt::Display for Stamp {
    /// Seconds with three decimals, such as `12.340 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:03} s", self.0 / 1_000_000_000, self.0 / 1_000_000 % 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_plus_a_duration_lies_that_much_later() {
        let later = Stamp::from_millis(1500) + Duration::from_micros(250);
        assert_eq!(later.as_nanos(), 1_500_250_000);
        assert_eq!(later.since(Stamp::from_millis(1500)), Duration::from_micros(250));
        assert_eq!(Stamp::ZERO.since(later), Duration::ZERO);
        assert_eq!(
            Stamp::from_nanos(u64::MAX) + Duration::from_secs(1),
            Stamp::from_nanos(u64::MAX)
        );
    }

    #[test]
    fn it_is_written_in_seconds() {
        assert_eq!(Stamp::from_millis(12_340).to_string(), "12.340 s");
    }
}
