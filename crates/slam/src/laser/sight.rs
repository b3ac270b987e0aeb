//! How far one scan saw in each direction, to tell what it looked through.
//!
//! A match may lay walls on walls and still be wrong, as when a corridor is shifted along itself. Then
//! the scan looks through walls of the other map: it saw farther where they should have stopped it.

use geometry::{Se2, Vec2};
use recordings::LaserRig;

use super::config::LaserConfig;

/// Points nearer to the measured range than this agree with it, metres.
const AGREES_M: f64 = 0.3;

/// The ranges of one scan, kept small.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    base_from_sensor: Se2,
    first_beam_rad: f64,
    beam_spacing_rad: f64,
    /// Metres; zero where nothing came back, since then nothing is known.
    ranges_m: Vec<f32>,
}

impl Sight {
    pub(crate) fn of(rig: &LaserRig, ranges_m: &[f64]) -> Self {
        let kept = |&range_m: &f64| if range_m < rig.range_max_m { range_m as f32 } else { 0.0 };
        Self {
            base_from_sensor: rig.base_from_sensor,
            first_beam_rad: rig.first_beam_rad,
            beam_spacing_rad: rig.beam_spacing_rad,
            ranges_m: ranges_m.iter().map(kept).collect(),
        }
    }

    /// Share of the `points` in view that this scan looked through; points behind its own are not in view.
    ///
    /// `base_from_points` is the pose of the points' frame in this scan's. A point counts as looked
    /// through when the beams on both sides of it went farther.
    pub(crate) fn through(
        &self,
        points: &[Vec2],
        base_from_points: Se2,
        config: &LaserConfig,
    ) -> f64 {
        let sensor_from_points = self.base_from_sensor.inverse().compose(base_from_points);
        let agrees_m = AGREES_M.max(config.refine.reach_end_m);
        let (mut n_through, mut n_seen) = (0.0, 0.0);
        for &point in points {
            let p = sensor_from_points.transform_point(point);
            let range_m = p.norm();
            // Lasers that turn clockwise have a negative spacing.
            let turn_rad = (p.y.atan2(p.x) - self.first_beam_rad) * self.beam_spacing_rad.signum();
            let beam = turn_rad.rem_euclid(std::f64::consts::TAU) / self.beam_spacing_rad.abs();
            let (low, high) = (beam.floor() as usize, beam.ceil() as usize);
            let (Some(&a), Some(&b)) = (self.ranges_m.get(low), self.ranges_m.get(high)) else {
                continue;
            };
            let nearer_m = f64::from(a.min(b));
            if nearer_m > range_m + agrees_m {
                n_through += 1.0;
            } else if (nearer_m - range_m).abs() <= agrees_m {
                n_seen += 1.0;
            }
        }
        n_through / f64::max(n_through + n_seen, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A half circle of beams that all saw 2 m, counter-clockwise or clockwise.
    fn sight(clockwise: bool) -> Sight {
        let sign = if clockwise { -1.0 } else { 1.0 };
        let rig = LaserRig {
            base_from_sensor: Se2::new(0.1, 0.0, 0.0),
            first_beam_rad: -sign * FRAC_PI_2,
            beam_spacing_rad: sign * 1.0_f64.to_radians(),
            n_beams: 181,
            range_max_m: 30.0,
        };
        Sight::of(&rig, &[2.0; 181])
    }

    #[test]
    fn points_before_the_range_are_looked_through_and_those_at_it_are_seen() {
        let config = LaserConfig::default();
        for clockwise in [false, true] {
            let through =
                |points: &[Vec2]| sight(clockwise).through(points, Se2::IDENTITY, &config);
            let at = |range_m: f64, deg: f64| {
                let (s, c) = deg.to_radians().sin_cos();
                Vec2::new(0.1 + range_m * c, range_m * s)
            };
            assert!((through(&[at(1.0, 30.0), at(1.0, -60.0)]) - 1.0).abs() < 1e-12);
            assert!(through(&[at(2.0, 30.0), at(1.9, -60.0)]).abs() < 1e-12);
            assert!((through(&[at(1.0, 10.0), at(2.1, 50.0)]) - 0.5).abs() < 1e-12);
            // Behind the range, and behind the robot: not in view.
            assert!(through(&[at(5.0, 30.0), at(1.0, 180.0)]).abs() < 1e-12);
        }
    }

    #[test]
    fn one_side_tells_them_apart() {
        let config = LaserConfig::default();
        for clockwise in [false, true] {
            let mut sight = sight(clockwise);
            // To the left of the robot it saw farther.
            for (i, range_m) in sight.ranges_m.iter_mut().enumerate() {
                let left = if clockwise { i < 90 } else { i > 90 };
                *range_m = if left { 4.0 } else { 2.0 };
            }
            let left = sight.through(&[Vec2::new(0.1, 2.0)], Se2::IDENTITY, &config);
            let right = sight.through(&[Vec2::new(0.1, -2.0)], Se2::IDENTITY, &config);
            assert!(
                (left - 1.0).abs() < 1e-12 && right.abs() < 1e-12,
                "{clockwise}: {left} {right}"
            );
        }
    }
}
