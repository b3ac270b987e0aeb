//! From ranges to points with normals: what a laser scan says about surfaces.

use geometry::{Se2, Vec2};
use recordings::LaserRig;

use super::config::PointsConfig;

/// A scan as oriented points in the robot's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointScan {
    /// Points on surfaces, thinned to an even spacing, metres, in `Base`.
    pub points: Vec<Vec2>,
    /// Unit normal of the surface at each point, towards the sensor; zero where none can be told.
    pub normals: Vec<Vec2>,
}

impl PointScan {
    /// Whether nothing was seen.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// The surface points of one scan.
///
/// Beams without a return, nearer than `range_min_m` or farther than `range_max_m` are left out. Each
/// point's normal is that of the line fitted to its neighbours on the same surface; neighbouring beams
/// are on one surface when their end points are close for the angle between them. Points are moved onto
/// their fitted line, which averages the range noise, and thinned to `spacing_m` along the surface.
///
/// Cost: linear in the number of beams times the beams within the fitted neighbourhood.
pub fn points_of(rig: &LaserRig, ranges_m: &[f64], config: &PointsConfig) -> PointScan {
    let beams = ends(rig, ranges_m, config);
    let mut scan = PointScan::default();
    let mut last_kept: Option<Vec2> = None;
    for (i, &(end, _)) in beams.iter().enumerate() {
        if last_kept.is_some_and(|kept| (end - kept).norm() < config.spacing_m) {
            continue;
        }
        last_kept = Some(end);
        let (point, normal) = fitted(&beams, i, rig, config).unwrap_or((end, Vec2::zeros()));
        scan.points.push(point);
        scan.normals.push(normal);
    }
    scan
}

/// Standard deviation of one range (m), from how much neighbouring ranges depart from straight progress.
///
/// The median of |r₋₁ - 2 r₀ + r₊₁| over the scan, which surfaces bend hardly and edges are too few to
/// move, scaled as for a normal distribution (its variance is 6 σ²). `None` with fewer than 20 triples.
pub fn range_std_m(rig: &LaserRig, ranges_m: &[f64], config: &PointsConfig) -> Option<f64> {
    let far_m = config.range_max_m.min(rig.range_max_m);
    let counts = |range_m: f64| range_m >= config.range_min_m && range_m < far_m;
    let triples = ranges_m.windows(3).filter(|r| r.iter().all(|&range_m| counts(range_m)));
    let mut bends: Vec<f64> = triples.map(|r| (r[0] - 2.0 * r[1] + r[2]).abs()).collect();
    if bends.len() < 20 {
        return None;
    }
    let middle = bends.len() / 2;
    let (_, &mut median, _) = bends.select_nth_unstable_by(middle, f64::total_cmp);
    Some(MEDIAN_TO_STD_RATIO * median / 6.0_f64.sqrt())
}

/// Standard deviation of a normal distribution over the median of its absolute values.
const MEDIAN_TO_STD_RATIO: f64 = 1.4826;

/// End points (m, in `Base`) with their ranges (m), of the beams that count.
fn ends(rig: &LaserRig, ranges_m: &[f64], config: &PointsConfig) -> Vec<(Vec2, f64)> {
    let far_m = config.range_max_m.min(rig.range_max_m);
    let counts = |range_m: f64| range_m >= config.range_min_m && range_m < far_m;
    let beams = ranges_m.iter().enumerate().filter(|&(_, &range_m)| counts(range_m));
    beams
        .map(|(i, &range_m)| {
            let bearing_rad = rig.first_beam_rad + i as f64 * rig.beam_spacing_rad;
            let heading = Se2::new(0.0, 0.0, bearing_rad).heading();
            (rig.base_from_sensor.transform_point(heading * range_m), range_m)
        })
        .collect()
}

/// The point of beam `i` moved onto the line through its neighbours, with the line's normal.
fn fitted(
    beams: &[(Vec2, f64)],
    i: usize,
    rig: &LaserRig,
    config: &PointsConfig,
) -> Option<(Vec2, Vec2)> {
    let (end, range_m) = beams[i];
    // Far away the beams are far apart; a line needs some of them on each side all the same.
    let spread_m = range_m * rig.beam_spacing_rad.abs();
    let reach_m = config.normal_reach_m.max(3.2 * spread_m);
    let gap_m = config.gap_m.max(4.0 * spread_m);
    let mut n = 0.0;
    let mut sum = Vec2::zeros();
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let mut add = |p: Vec2| {
        // About the point itself, so that squares keep their digits.
        let d = p - end;
        n += 1.0;
        sum += d;
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    };
    add(end);
    let mut previous = end;
    for &(p, _) in &beams[i + 1..] {
        if (p - previous).norm() > gap_m || (p - end).norm() > reach_m {
            break;
        }
        add(p);
        previous = p;
    }
    previous = end;
    for &(p, _) in beams[..i].iter().rev() {
        if (p - previous).norm() > gap_m || (p - end).norm() > reach_m {
            break;
        }
        add(p);
        previous = p;
    }
    if n < config.n_normal_points_min as f64 {
        return None;
    }
    let mean = sum / n;
    let (cxx, cxy, cyy) =
        (xx / n - mean.x * mean.x, xy / n - mean.x * mean.y, yy / n - mean.y * mean.y);
    // Eigenvalues of the 2 × 2 scatter; the small one is the variance across the line.
    let half_trace = 0.5 * (cxx + cyy);
    let root = (0.25 * (cxx - cyy).powi(2) + cxy * cxy).sqrt();
    let (across, along) = ((half_trace - root).max(0.0), half_trace + root);
    if across > config.normal_rms_max_m.powi(2) || across > 0.1 * along {
        return None;
    }
    let yaw_rad = 0.5 * (2.0 * cxy).atan2(cxx - cyy);
    let (s, c) = yaw_rad.sin_cos();
    let mut normal = Vec2::new(-s, c);
    if normal.dot(&(rig.base_from_sensor.position() - end)) < 0.0 {
        normal = -normal;
    }
    Some((end + normal * normal.dot(&mean), normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn rig() -> LaserRig {
        LaserRig {
            base_from_sensor: Se2::IDENTITY,
            first_beam_rad: -FRAC_PI_2,
            beam_spacing_rad: PI / 360.0,
            n_beams: 361,
            range_max_m: 80.0,
        }
    }

    /// Ranges to the infinite line n · p = d, infinite where a beam does not meet it.
    fn wall(rig: &LaserRig, n: Vec2, d: f64) -> Vec<f64> {
        (0..rig.n_beams)
            .map(|i| {
                let bearing = rig.first_beam_rad + i as f64 * rig.beam_spacing_rad;
                let along = n.dot(&Vec2::new(bearing.cos(), bearing.sin()));
                if along > 1e-6 { d / along } else { f64::INFINITY }
            })
            .collect()
    }

    #[test]
    fn a_wall_gives_evenly_spaced_points_with_its_normal() {
        for n in [Vec2::new(1.0, 0.0), Vec2::new(0.6, 0.8), Vec2::new(0.6, -0.8)] {
            let config = PointsConfig { range_max_m: 4.0, ..PointsConfig::default() };
            let scan = points_of(&rig(), &wall(&rig(), n, 2.0), &config);
            assert!(scan.points.len() > 40, "{} points", scan.points.len());
            let n_points = scan.points.len();
            for (i, (p, normal)) in scan.points.iter().zip(&scan.normals).enumerate() {
                assert!((n.dot(p) - 2.0).abs() < 1e-9);
                if i == 0 || i == n_points - 1 {
                    continue; // At its ends the wall may have too few neighbours on one side.
                }
                assert!((normal + n).norm() < 1e-6, "towards the sensor: {normal} for {n}");
            }
            for pair in scan.points.windows(2) {
                assert!((pair[1] - pair[0]).norm() >= config.spacing_m - 1e-9);
            }
        }
    }

    #[test]
    fn the_mounting_moves_the_points() {
        let mut rig = rig();
        let ranges = wall(&rig, Vec2::new(1.0, 0.0), 2.0);
        rig.base_from_sensor = Se2::new(0.2, -0.1, FRAC_PI_2);
        let scan = points_of(&rig, &ranges, &PointsConfig::default());
        // Ahead of the sensor is to the left of the robot.
        assert!(scan.points.iter().all(|p| (p.y - 1.9).abs() < 1e-9));
    }

    #[test]
    fn what_does_not_count_is_left_out() {
        let config = PointsConfig::default();
        let mut ranges = vec![f64::INFINITY; 361];
        (ranges[10], ranges[20], ranges[30]) = (0.05, 70.0, 3.0);
        let scan = points_of(&rig(), &ranges, &config);
        assert_eq!(scan.points.len(), 1);
        assert_eq!(scan.normals[0], Vec2::zeros(), "one point alone has no direction");
        assert!(points_of(&rig(), &[], &config).is_empty());
    }

    #[test]
    fn a_step_between_surfaces_bends_no_normal() {
        // Half of the beams meet a wall at 2 m, the other half one at 4 m.
        let (near, far) =
            (wall(&rig(), Vec2::new(1.0, 0.0), 2.0), wall(&rig(), Vec2::new(1.0, 0.0), 4.0));
        let ranges: Vec<f64> = (0..361).map(|i| if i < 180 { near[i] } else { far[i] }).collect();
        let config = PointsConfig { range_max_m: 8.0, ..PointsConfig::default() };
        let scan = points_of(&rig(), &ranges, &config);
        let oriented = scan.normals.iter().filter(|n| **n != Vec2::zeros());
        let mut n_oriented = 0;
        for normal in oriented {
            n_oriented += 1;
            assert!((normal - Vec2::new(-1.0, 0.0)).norm() < 1e-6, "{normal}");
        }
        assert!(n_oriented > 60);
    }

    #[test]
    fn noise_is_measured() {
        use rand_distr::{Distribution, Normal};
        let config = PointsConfig::default();
        let mut rng = run_context::RunSeed(3).stream("noise");
        for std in [0.01, 0.1, 0.3] {
            let noise = Normal::new(0.0, std).unwrap();
            let ranges: Vec<f64> = wall(&rig(), Vec2::new(1.0, 0.0), 5.0)
                .iter()
                .map(|r| r + noise.sample(&mut rng))
                .collect();
            let found = range_std_m(&rig(), &ranges, &config).unwrap();
            // A median of some 300 normal triples is good to about a tenth.
            assert!((found / std - 1.0).abs() < 0.35, "{found} for {std}");
        }
        assert_eq!(range_std_m(&rig(), &[1.0; 21], &config), None);
        assert_eq!(range_std_m(&rig(), &[1.0; 22], &config), Some(0.0));
    }
}
