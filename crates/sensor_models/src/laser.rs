//! A scanning range finder: thin beams, no cone, hardly any error.
//!
//! The simplest member of the plug-in family beside the sonar: anything that turns a pose and a
//! scene into ranges. Glass and other materials are not told apart.

use geometry::{Ray, RayCaster, Se2};
use rand_distr::{Distribution, StandardNormal};
use run_context::RandomStream;

/// A fan of equally spaced beams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserModel {
    /// Direction of the first beam from the sensor's x axis, radians.
    pub first_beam_rad: f64,
    /// Angle from one beam to the next, counter-clockwise positive, radians.
    pub beam_spacing_rad: f64,
    /// Number of beams.
    pub n_beams: usize,
    /// Greatest range, metres; also the reading when nothing came back.
    pub range_max_m: f64,
    /// Standard deviation of a range, metres.
    pub range_std_m: f64,
}

impl LaserModel {
    /// Half a circle in front at one beam per degree, 8 m, 1 cm: the class of a small safety
    /// scanner.
    pub fn half_circle() -> Self {
        Self {
            first_beam_rad: -std::f64::consts::FRAC_PI_2,
            beam_spacing_rad: 1.0_f64.to_radians(),
            n_beams: 181,
            range_max_m: 8.0,
            range_std_m: 0.01,
        }
    }

    /// Scans from `world_from_sensor` into `scene` and replaces the content of `ranges_m` by one
    /// range (m) per beam, first beam first. Allocates only while `ranges_m` grows.
    pub fn scan(
        &self,
        world_from_sensor: Se2,
        scene: &impl RayCaster,
        rng: &mut RandomStream,
        ranges_m: &mut Vec<f64>,
    ) {
        ranges_m.clear();
        for i in 0..self.n_beams {
            let angle_rad = self.first_beam_rad + i as f64 * self.beam_spacing_rad;
            let direction = Se2::new(0.0, 0.0, world_from_sensor.yaw_rad + angle_rad).heading();
            let ray = Ray { origin: world_from_sensor.position(), direction };
            let gauss: f64 = StandardNormal.sample(rng);
            let range_m = match scene.cast(&ray, self.range_max_m) {
                Some(hit) => {
                    (hit.distance_m + self.range_std_m * gauss).clamp(0.0, self.range_max_m)
                }
                None => self.range_max_m,
            };
            ranges_m.push(range_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Segment, SegmentWorld, Vec2};
    use run_context::RunSeed;

    #[test]
    fn a_scan_of_a_wall_is_one_over_cosine() {
        let wall = Segment { a: Vec2::new(2.0, -50.0), b: Vec2::new(2.0, 50.0) };
        let scene = SegmentWorld::new([(wall, 0)]);
        let laser = LaserModel { range_std_m: 0.0, ..LaserModel::half_circle() };
        let mut ranges_m = vec![9.0];
        laser.scan(Se2::IDENTITY, &scene, &mut RunSeed(1).stream("laser"), &mut ranges_m);
        assert_eq!(ranges_m.len(), 181);
        for (degree, range_m) in (-90..=90).zip(&ranges_m) {
            let expected = (2.0 / f64::from(degree).to_radians().cos()).min(8.0);
            assert!((range_m - expected).abs() < 1e-9, "{degree}: {range_m}");
        }
    }

    /// 181 beams of 1 cm: the mean of the squares is σ² within 5·√(2/n) = 53 %.
    #[test]
    fn its_noise_has_the_stated_deviation() {
        let wall = Segment { a: Vec2::new(2.0, -50.0), b: Vec2::new(2.0, 50.0) };
        let scene = SegmentWorld::new([(wall, 0)]);
        let laser =
            LaserModel { first_beam_rad: 0.0, beam_spacing_rad: 0.0, ..LaserModel::half_circle() };
        let mut ranges_m = Vec::new();
        laser.scan(Se2::IDENTITY, &scene, &mut RunSeed(1).stream("laser"), &mut ranges_m);
        let squares = ranges_m.iter().map(|r| (r - 2.0).powi(2)).sum::<f64>() / 181.0;
        assert!((squares / 1e-4 - 1.0).abs() < 0.53, "{squares}");
    }
}
