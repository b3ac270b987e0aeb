//! How far one scan saw in each direction, to tell what it looked through.
//!
//! A match may lay walls on walls and still be wrong, as when a corridor is shifted along itself. Then
//! the scan looks through walls of the other map: it saw farther where they should have stopped it.

use geometry::{Se2, Vec2, wrap_to_pi};
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
            let bearing_rad = wrap_to_pi(p.y.atan2(p.x) - self.first_beam_rad);
            let beam = bearing_rad.rem_euclid(std::f64::consts::TAU) / self.beam_spacing_rad;
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
