//! Where the wheels said that the robot was, for a while.

use geometry::{Se2, Twist};
use run_context::Stamp;

/// Reports that are remembered: three seconds at ten a second.
const N_PLACES: usize = 32;

/// The last reports of the wheels: poses in their own dead reckoning, and when they were true.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Track {
    places: [(Stamp, Se2); N_PLACES],
    n_places: usize,
    next: usize,
}

impl Default for Track {
    fn default() -> Self {
        Self { places: [(Stamp::ZERO, Se2::IDENTITY); N_PLACES], n_places: 0, next: 0 }
    }
}

impl Track {
    /// Adds a report; one that is not later than the last replaces all, since time went back.
    pub(crate) fn note(&mut self, about: Stamp, odom_from_base: Se2) {
        if self.n_places > 0 && about <= self.place(0).0 {
            self.n_places = 0;
        }
        self.places[self.next] = (about, odom_from_base);
        self.next = (self.next + 1) % N_PLACES;
        self.n_places = (self.n_places + 1).min(N_PLACES);
    }

    /// The place so many reports ago.
    fn place(&self, k: usize) -> (Stamp, Se2) {
        self.places[(self.next + 2 * N_PLACES - 1 - k) % N_PLACES]
    }

    /// The pose (dead reckoning) at that time, between two reports on an arc; `None` before the first that is
    /// remembered, and after the last.
    pub(crate) fn at(&self, time: Stamp) -> Option<Se2> {
        let k = (0..self.n_places).find(|k| self.place(*k).0 <= time)?;
        let (before, from) = self.place(k);
        if time == before {
            return Some(from);
        }
        let (after, to) = self.place(k.checked_sub(1)?);
        let ratio = time.since(before).as_secs_f64() / after.since(before).as_secs_f64();
        let way = from.inverse().compose(to).log();
        Some(from.compose(Se2::exp(Twist {
            dx_m: ratio * way.dx_m,
            dy_m: ratio * way.dy_m,
            dyaw_rad: ratio * way.dyaw_rad,
        })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot on a circle: between two reports it is on the circle, too.
    #[test]
    fn between_two_reports_the_robot_is_on_its_arc() {
        let at = |ms: u64| {
            Se2::exp(Twist { dx_m: 5e-4 * ms as f64, dy_m: 0.0, dyaw_rad: 1e-3 * ms as f64 })
        };
        let mut track = Track::default();
        assert_eq!(track.at(Stamp::ZERO), None);
        for k in 0..50 {
            track.note(Stamp::from_millis(100 * k), at(100 * k));
        }
        for ms in [1800, 1850, 4444, 4900] {
            let (found, truth) = (track.at(Stamp::from_millis(ms)).unwrap(), at(ms));
            assert!((found.position() - truth.position()).norm() < 1e-9, "{ms}");
            assert!((found.yaw_rad - truth.yaw_rad).abs() < 1e-9, "{ms}");
        }
        // Before what is remembered, and after the last report.
        assert_eq!(track.at(Stamp::from_millis(1799)), None);
        assert_eq!(track.at(Stamp::from_millis(4901)), None);
        // Time went back: the wheels' client began anew.
        track.note(Stamp::from_millis(100), Se2::IDENTITY);
        assert_eq!(track.at(Stamp::from_millis(4444)), None);
    }
}
