//! When a short-term map has seen enough to be compared with the long-term one.

/// How much a short-term map collects before it is registered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Maturity {
    /// So many valid readings: in open space the map lives until it has seen something.
    Readings(usize),
    /// So many rows of readings.
    Scans(usize),
    /// So much time, seconds.
    Seconds(f64),
    /// So much way by odometry, metres.
    Distance(f64),
}

/// What a short-term map has collected so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Collected {
    /// Valid readings.
    pub n_readings: usize,
    /// Rows of readings.
    pub n_scans: usize,
    /// From the first row to the last, seconds.
    pub duration_s: f64,
    /// Way by odometry from the first row to the last, metres.
    pub distance_m: f64,
}

impl Maturity {
    /// Whether this is enough.
    pub fn is_reached(self, collected: &Collected) -> bool {
        match self {
            Self::Readings(n) => collected.n_readings >= n,
            Self::Scans(n) => collected.n_scans >= n,
            Self::Seconds(s) => collected.duration_s >= s,
            Self::Distance(m) => collected.distance_m >= m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_unit_is_compared_with_its_own_count() {
        let c = Collected { n_readings: 45, n_scans: 6, duration_s: 1.5, distance_m: 0.4 };
        for (reached, not) in [
            (Maturity::Readings(45), Maturity::Readings(46)),
            (Maturity::Scans(6), Maturity::Scans(7)),
            (Maturity::Seconds(1.5), Maturity::Seconds(1.6)),
            (Maturity::Distance(0.4), Maturity::Distance(0.41)),
        ] {
            assert!(reached.is_reached(&c) && !not.is_reached(&c), "{reached:?}");
        }
    }
}
