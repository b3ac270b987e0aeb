//! Which sonar fires when: one of each array per period, round and round.

use std::time::Duration;

use run_context::Stamp;

/// The firing order of a robot's sonar arrays.
///
/// All arrays fire at the same instants, one sensor each; instants are the multiples of the
/// period since the run began, so that nothing accumulates rounding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FiringSchedule {
    arrays: Vec<Vec<usize>>,
    period: Duration,
}

/// One ping that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Firing {
    /// When.
    pub at: Stamp,
    /// Index of the sensor in the robot's list.
    pub sensor_index: usize,
}

impl FiringSchedule {
    /// Every array's order, and the time between two pings of an array.
    ///
    /// With a zero period nothing ever fires; empty orders are dropped.
    pub fn new(arrays: Vec<Vec<usize>>, period: Duration) -> Self {
        let arrays = arrays.into_iter().filter(|order| !order.is_empty()).collect();
        Self { arrays, period }
    }

    /// The Pioneer's: arrays of eight in the order of their numbers, 40 ms apart, so that a ring of
    /// eight comes round in 320 ms.
    pub fn pioneer(n_sensors: usize) -> Self {
        let sensors: Vec<usize> = (0..n_sensors).collect();
        let arrays = sensors.chunks(8).map(<[usize]>::to_vec).collect();
        Self::new(arrays, Duration::from_millis(40))
    }

    /// The time between two pings of an array.
    pub fn period(&self) -> Duration {
        self.period
    }

    /// The pings with `after < at ≤ until`, in order of time, then of array. Does not allocate.
    pub fn due(&self, after: Stamp, until: Stamp) -> impl Iterator<Item = Firing> + '_ {
        let period = u64::try_from(self.period.as_nanos()).unwrap_or(u64::MAX);
        let round = |stamp: Stamp| stamp.as_nanos().checked_div(period).unwrap_or(0);
        let rounds = if period == 0 { 0..0 } else { round(after)..round(until) };
        rounds.map(|before| before + 1).flat_map(move |number| {
            let at = Stamp::from_nanos(number.saturating_mul(period));
            self.arrays.iter().map(move |order| {
                // Instant 1 fires the first of each order; the remainder fits in usize.
                let place = ((number - 1) % order.len() as u64) as usize;
                Firing { at, sensor_index: order[place] }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fired(schedule: &FiringSchedule, after_ms: u64, until_ms: u64) -> Vec<(u64, usize)> {
        schedule
            .due(Stamp::from_millis(after_ms), Stamp::from_millis(until_ms))
            .map(|firing| (firing.at.as_nanos() / 1_000_000, firing.sensor_index))
            .collect()
    }

    #[test]
    fn each_array_fires_one_sensor_every_forty_milliseconds() {
        let schedule = FiringSchedule::pioneer(16);
        assert_eq!(fired(&schedule, 0, 80), [(40, 0), (40, 8), (80, 1), (80, 9)]);
        assert_eq!(fired(&schedule, 320, 360), [(360, 0), (360, 8)]);
    }

    #[test]
    fn the_instant_itself_belongs_to_the_interval_that_ends_there() {
        let schedule = FiringSchedule::pioneer(8);
        assert_eq!(fired(&schedule, 30, 40), [(40, 0)]);
        assert_eq!(fired(&schedule, 40, 50), []);
    }

    #[test]
    fn ticks_of_any_length_fire_the_same_pings() {
        let schedule = FiringSchedule::pioneer(8);
        let mut pieces = Vec::new();
        for start in (0..1000).step_by(10) {
            pieces.extend(fired(&schedule, start, start + 10));
        }
        assert_eq!(pieces, fired(&schedule, 0, 1000));
        assert_eq!(pieces.len(), 25);
    }

    #[test]
    fn an_order_of_ones_own_is_kept_and_empty_ones_are_silent() {
        let odd_first = vec![vec![0, 2, 1, 3], vec![]];
        let schedule = FiringSchedule::new(odd_first, Duration::from_millis(10));
        let sensors: Vec<usize> = fired(&schedule, 0, 50).iter().map(|f| f.1).collect();
        assert_eq!(sensors, [0, 2, 1, 3, 0]);
        assert_eq!(fired(&FiringSchedule::new(vec![vec![0]], Duration::ZERO), 0, 50), []);
    }
}
