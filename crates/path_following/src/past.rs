//! Follow the past: record a path that the robot is led along, then drive it again.

use geometry::{Se2, Vec2};

use crate::{Path, PathError, SettingError, wheels::check_range};

/// How densely a drive is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PastConfig {
    /// A point is kept when it is this far from the last one, metres, 0.001 to 10.
    pub spacing_m: f64,
    /// Points at most; memory for all is taken at the start.
    pub n_points_max: usize,
}

impl Default for PastConfig {
    /// Every 5 cm, up to 500 m.
    fn default() -> Self {
        Self { spacing_m: 0.05, n_points_max: 10_000 }
    }
}

/// What became of a recorded pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// It is the newest point of the path.
    Kept,
    /// Too near to the last point: nothing to remember.
    TooNear,
    /// Not finite.
    Refused,
    /// The memory is full; the recording ends at its last point.
    Full,
}

/// A recorded drive.
///
/// Turning on the spot leaves no trace. Source of the idea: the thesis, §5.2.1 ("follow the past").
#[derive(Clone, Debug)]
pub struct Past {
    config: PastConfig,
    points: Vec<Vec2>,
    /// The speed with which each point was passed, metres per second.
    speeds_mps: Vec<f64>,
    /// Distance of each point from the first one along the drive, metres.
    along_m: Vec<f64>,
}

impl Past {
    /// Takes the memory.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: PastConfig) -> Result<Self, SettingError> {
        check_range("spacing_m", config.spacing_m, 0.001..=10.0, "from 0.001 to 10 m")?;
        let n_points = config.n_points_max as f64;
        check_range("n_points_max", n_points, 2.0..=1e7, "from 2 to 10000000")?;
        let empty = || Vec::with_capacity(config.n_points_max);
        let (speeds_mps, along_m) = (empty(), empty());
        Ok(Self { config, points: Vec::with_capacity(config.n_points_max), speeds_mps, along_m })
    }

    /// Takes note of where the robot is and how fast it goes (m/s). O(1), allocates nothing.
    pub fn record(&mut self, map_from_base: Se2, speed_mps: f64) -> Recorded {
        let point = map_from_base.position();
        if !(point.x + point.y + speed_mps).is_finite() {
            return Recorded::Refused;
        }
        let step_m = self.points.last().map(|last| (point - last).norm());
        if step_m.is_some_and(|step_m| step_m < self.config.spacing_m) {
            return Recorded::TooNear;
        }
        if self.points.len() == self.config.n_points_max {
            return Recorded::Full;
        }
        let along_m = self.along_m.last().map_or(0.0, |last_m| last_m + step_m.unwrap_or(0.0));
        self.points.push(point);
        self.speeds_mps.push(speed_mps);
        self.along_m.push(along_m);
        Recorded::Kept
    }

    /// The points kept (m).
    pub fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// The drive as a path for any [`PathFollower`](crate::PathFollower). O(points).
    ///
    /// # Errors
    ///
    /// [`PathError::TooShort`] for fewer than two points.
    pub fn path(&self) -> Result<Path, PathError> {
        Path::polyline(&self.points)
    }

    /// The drive backwards, home again. O(points).
    ///
    /// # Errors
    ///
    /// As [`path`](Self::path).
    pub fn path_back(&self) -> Result<Path, PathError> {
        let backwards: Vec<Vec2> = self.points.iter().rev().copied().collect();
        Path::polyline(&backwards)
    }

    /// The speed recorded at a distance along the path, metres per second, linear between points; 0 for
    /// an empty recording. O(log points).
    pub fn speed_at_mps(&self, arc_length_m: f64) -> f64 {
        let after = self.along_m.partition_point(|&along_m| along_m <= arc_length_m);
        match (after.checked_sub(1), self.speeds_mps.get(after)) {
            (None, first) => first.copied().unwrap_or(0.0),
            (Some(last), None) => self.speeds_mps[last],
            (Some(before), Some(&to)) => {
                let (from_m, to_m) = (self.along_m[before], self.along_m[after]);
                let part = (arc_length_m - from_m) / (to_m - from_m);
                self.speeds_mps[before] + part * (to - self.speeds_mps[before])
            }
        }
    }

    /// Forgets the drive and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.speeds_mps.clear();
        self.along_m.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{
        Recorded::{Full, Kept, TooNear},
        *,
    };

    fn past(n_points_max: usize) -> Past {
        Past::new(PastConfig { spacing_m: 0.1, n_points_max }).unwrap()
    }

    fn at(x_m: f64, y_m: f64) -> Se2 {
        Se2::new(x_m, y_m, 0.3)
    }

    #[test]
    fn keeps_points_a_spacing_apart_until_full() {
        let mut past = past(3);
        let poses = [(0.0, 0.0), (0.09, 0.0), (0.11, 0.0), (0.11, 0.09), (0.11, 0.2), (1.0, 0.0)];
        let outcomes = poses.map(|(x, y)| past.record(at(x, y), 0.3));
        assert_eq!(outcomes, [Kept, TooNear, Kept, TooNear, Kept, Full]);
        assert_eq!(past.record(at(f64::NAN, 0.0), 0.3), Recorded::Refused);
        assert!((past.path().unwrap().length_m() - 0.31).abs() < 1e-12);
        past.clear();
        assert_eq!(past.path().unwrap_err(), PathError::TooShort { n_points: 0 });
    }

    #[test]
    fn the_way_back_is_the_way_turned_around() {
        let mut past = past(10);
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)] {
            past.record(at(x, y), 0.3);
        }
        let back = past.path_back().unwrap();
        assert_eq!(back.start().position(), Vec2::new(1.0, 2.0));
        assert_eq!(back.point_at(2.5), Vec2::new(0.5, 0.0));
    }

    #[test]
    fn speeds_are_those_of_the_drive() {
        let mut past = past(10);
        assert!(past.speed_at_mps(1.0).abs() < 1e-12);
        for (x, speed) in [(0.0, 0.1), (1.0, 0.3), (2.0, 0.2)] {
            past.record(at(x, 0.0), speed);
        }
        let speeds = [-1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 9.0].map(|s| past.speed_at_mps(s));
        let expected = [0.1, 0.1, 0.2, 0.3, 0.25, 0.2, 0.2];
        for (speed, expected) in speeds.iter().zip(expected) {
            assert!((speed - expected).abs() < 1e-12, "{speeds:?}");
        }
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let refused = Past::new(PastConfig { spacing_m: 0.1, n_points_max: 1 }).unwrap_err();
        assert_eq!(refused.to_string(), "n_points_max = 1: must be from 2 to 10000000");
        assert!(Past::new(PastConfig { spacing_m: f64::NAN, n_points_max: 5 }).is_err());
    }
}
