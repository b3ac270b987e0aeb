//! A map of short pieces of surface, and the pose at which a scan lies on them.
//!
//! Points of many scans are merged where they agree in place and direction; a scan is laid on the
//! result by minimising the distances of its points to the lines of their nearest pieces.
//!
//! Source: A. Censi (2008), "An ICP variant using a point-to-line metric", ICRA, for the metric; robust
//! weights after P. Huber. Differences: lines are those of merged surfels and not of one scan's
//! neighbouring points, and Gauss–Newton steps replace the closed form, so that a prior can take part.

use geometry::{Se2, Vec2, wrap_to_pi};
use nalgebra::{Matrix3, Vector3};

use super::{config::RefineConfig, points::PointScan};

/// Normals whose cosine is greater belong to one surface: 45°.
const NORMALS_AGREE: f64 = 0.7;
/// Weight of a point without a normal, per coordinate, beside that of a point on a surface.
const LONE_POINT_WEIGHT: f64 = 0.1;

/// Standard deviation of a fitted normal, radians (3°): a dozen points over 30 cm, each off by 1 cm or so.
const NORMAL_STD_RAD: f64 = 0.05;

/// A piece of surface: place, unit normal, and how many points it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Surfel {
    point: Vec2,
    normal: Vec2,
    n_points: f64,
}

/// Surfels on a lattice, for nearest-neighbour questions.
#[derive(Clone, Debug, Default)]
pub struct SurfelMap {
    origin: Vec2,
    cell_m: f64,
    width: i32,
    height: i32,
    /// Surfels of cell c are `surfels[starts[c]..starts[c + 1]]`.
    starts: Vec<u32>,
    surfels: Vec<Surfel>,
    scratch: Vec<(u32, Surfel)>,
}

/// A scan laid on a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined {
    /// Pose of the scan's frame in the map's.
    pub pose: Se2,
    /// Information (inverse covariance) of x, y, yaw in the map's frame, of the points alone.
    pub information: Matrix3<f64>,
    /// Share of the scan's points that found a surface near and parallel.
    pub inlier_ratio: f64,
    /// Root mean square distance of those to their surfaces, metres.
    pub rms_m: f64,
    /// Whether the steps became negligible within the limit of iterations.
    pub converged: bool,
}

/// A guess with its information (x, y, yaw in the map's frame), which pulls while a scan is laid on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosePrior {
    /// The guess.
    pub pose: Se2,
    /// Inverse of its covariance.
    pub information: Matrix3<f64>,
}

impl SurfelMap {
    /// Takes the oriented points of several scans, each at its pose in the map's frame.
    ///
    /// Points of a cell of `cell_m` are merged when their normals agree within 45°.
    pub fn rebuild<'a>(
        &mut self,
        scans: impl Iterator<Item = (Se2, &'a PointScan)> + Clone,
        cell_m: f64,
    ) {
        let mut min = Vec2::repeat(f64::INFINITY);
        let mut max = Vec2::repeat(f64::NEG_INFINITY);
        for (pose, scan) in scans.clone() {
            for &p in &scan.points {
                let p = pose.transform_point(p);
                (min, max) = (min.inf(&p), max.sup(&p));
            }
        }
        self.surfels.clear();
        self.scratch.clear();
        self.cell_m = cell_m;
        if min.x > max.x {
            (self.width, self.height, self.origin) = (0, 0, Vec2::zeros());
            return;
        }
        self.origin = min;
        let size = (max - min) / cell_m;
        (self.width, self.height) = (size.x as i32 + 1, size.y as i32 + 1);
        for (pose, scan) in scans {
            for (&p, &n) in scan.points.iter().zip(&scan.normals) {
                let point = pose.transform_point(p);
                let (x, y) = self.cell_of(point);
                let surfel = Surfel { point, normal: pose.rotate(n), n_points: 1.0 };
                self.scratch.push(((y * self.width + x) as u32, surfel));
            }
        }
        self.merge();
    }

    /// Number of surfels.
    pub fn len(&self) -> usize {
        self.surfels.len()
    }

    /// Whether there is nothing to lie on.
    pub fn is_empty(&self) -> bool {
        self.surfels.is_empty()
    }

    /// The pose at which `scan` lies on the map, from `guess`, which `prior` may pull back.
    ///
    /// Cost: iterations times points times the surfels within reach, a few each.
    pub fn refine(
        &self,
        scan: &PointScan,
        guess: Se2,
        prior: Option<&PosePrior>,
        config: &RefineConfig,
    ) -> Refined {
        let mut pose = guess;
        let mut converged = false;
        let mut reach_m = config.reach_start_m;
        for _ in 0..config.iterations_max {
            let sums = self.sums(scan, pose, reach_m, config);
            let (mut h, mut g) = (sums.hessian, sums.gradient);
            if let Some(prior) = prior {
                let e = Vector3::new(
                    pose.x_m - prior.pose.x_m,
                    pose.y_m - prior.pose.y_m,
                    wrap_to_pi(pose.yaw_rad - prior.pose.yaw_rad),
                );
                h += prior.information;
                g += prior.information * e;
            }
            // A floor keeps the step defined where neither points nor prior say anything.
            h += Matrix3::identity() * 1e-6;
            let Some(step) = h.cholesky().map(|factor| factor.solve(&-g)) else { break };
            pose = Se2::new(pose.x_m + step.x, pose.y_m + step.y, pose.yaw_rad + step.z);
            let small = step.xy().norm() < config.step_min_m && step.z.abs() < config.step_min_rad;
            if small && reach_m <= config.reach_end_m {
                converged = true;
                break;
            }
            reach_m = (reach_m * config.reach_shrink_ratio).max(config.reach_end_m);
        }
        let sums = self.sums(scan, pose, config.reach_end_m, config);
        Refined {
            pose,
            information: sums.believed(),
            inlier_ratio: sums.n_inliers / scan.points.len().max(1) as f64,
            rms_m: (sums.squares_m2 / sums.n_oriented.max(1.0)).sqrt(),
            converged,
        }
    }

    /// Sorts the scratch by cell and merges what agrees.
    fn merge(&mut self) {
        // Stable, so that the order of scans decides among equals.
        self.scratch.sort_by_key(|&(cell, _)| cell);
        let n_cells = self.width as usize * self.height as usize;
        self.starts.clear();
        self.starts.resize(n_cells + 1, 0);
        let mut i = 0;
        while i < self.scratch.len() {
            let cell = self.scratch[i].0;
            let first = self.surfels.len();
            while i < self.scratch.len() && self.scratch[i].0 == cell {
                let new = self.scratch[i].1;
                match self.surfels[first..].iter_mut().find(|old| old.is_like(&new)) {
                    Some(old) => {
                        old.point += new.point;
                        old.normal += new.normal;
                        old.n_points += 1.0;
                    }
                    None => self.surfels.push(new),
                }
                i += 1;
            }
            for surfel in &mut self.surfels[first..] {
                surfel.point /= surfel.n_points;
                surfel.normal /= surfel.normal.norm().max(f64::MIN_POSITIVE);
            }
            self.starts[cell as usize + 1] = (self.surfels.len() - first) as u32;
        }
        for c in 0..n_cells {
            self.starts[c + 1] += self.starts[c];
        }
    }

    fn cell_of(&self, point: Vec2) -> (i32, i32) {
        let cell = (point - self.origin) / self.cell_m;
        (cell.x.floor() as i32, cell.y.floor() as i32)
    }

    /// The nearest surfel to `point` within `reach_m` whose normal agrees with `normal`; any, if that is zero.
    fn nearest(&self, point: Vec2, normal: Vec2, reach_m: f64) -> Option<&Surfel> {
        if self.surfels.is_empty() {
            return None;
        }
        let (cx, cy) = self.cell_of(point);
        let reach = (reach_m / self.cell_m).ceil() as i32;
        let cos_min = if normal == Vec2::zeros() { -1.0 } else { NORMALS_AGREE };
        let (x0, x1) =
            (cx.saturating_sub(reach).max(0), cx.saturating_add(reach).min(self.width - 1));
        let (y0, y1) =
            (cy.saturating_sub(reach).max(0), cy.saturating_add(reach).min(self.height - 1));
        let mut best = None;
        let mut best_m2 = reach_m * reach_m;
        for y in y0..=y1 {
            if x0 > x1 {
                break;
            }
            let row = y * self.width;
            let from = self.starts[(row + x0) as usize] as usize;
            let to = self.starts[(row + x1) as usize + 1] as usize;
            for surfel in &self.surfels[from..to] {
                let d2 = (surfel.point - point).norm_squared();
                if d2 < best_m2 && surfel.normal.dot(&normal) > cos_min {
                    best_m2 = d2;
                    best = Some(surfel);
                }
            }
        }
        best
    }

    /// The normal equations of the points at `pose`.
    fn sums(&self, scan: &PointScan, pose: Se2, reach_m: f64, config: &RefineConfig) -> Sums {
        let mut sums = Sums::default();
        let (s, c) = pose.yaw_rad.sin_cos();
        for (p, n) in scan.points.iter().zip(&scan.normals) {
            let turned = Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y);
            let normal = Vec2::new(c * n.x - s * n.y, s * n.x + c * n.y);
            let point = turned + pose.position();
            let Some(surfel) = self.nearest(point, normal, reach_m) else { continue };
            let off = point - surfel.point;
            sums.n_inliers += 1.0;
            if *n == Vec2::zeros() {
                // Of a point alone both coordinates count, but it may be another part of the thing.
                let weight = weight_of(off.norm(), config) * LONE_POINT_WEIGHT;
                sums.add(Vec2::new(1.0, 0.0), turned, off.x, weight);
                sums.add(Vec2::new(0.0, 1.0), turned, off.y, weight);
            } else {
                let e = surfel.normal.dot(&off);
                let weight = weight_of(e.abs(), config);
                sums.add(surfel.normal, turned, e, weight);
                sums.doubt(surfel.normal, turned, weight);
                sums.squares_m2 += e * e;
                sums.n_oriented += 1.0;
            }
        }
        sums
    }
}

/// JᵀWJ, JᵀWe and what the errors say of the fit.
#[derive(Default)]
struct Sums {
    hessian: Matrix3<f64>,
    /// What the errors of the normals alone put into the Hessian.
    of_normals: Matrix3<f64>,
    gradient: Vector3<f64>,
    n_inliers: f64,
    n_oriented: f64,
    squares_m2: f64,
}

impl Sums {
    /// e = n · (R p + t - q);  ∂e/∂(x, y, θ) = (nx, ny, n · (R p)⊥), with `turned` = R p.
    fn add(&mut self, n: Vec2, turned: Vec2, e: f64, weight: f64) {
        let j = Vector3::new(n.x, n.y, n.y * turned.x - n.x * turned.y);
        self.hessian += j * j.transpose() * weight;
        self.gradient += j * (e * weight);
    }

    /// A normal that is wrong by ε adds ε² along the surface, where the point says nothing.
    fn doubt(&mut self, n: Vec2, turned: Vec2, weight: f64) {
        let along = Vec2::new(-n.y, n.x);
        let j = Vector3::new(along.x, along.y, along.y * turned.x - along.x * turned.y);
        self.of_normals += j * j.transpose() * (weight * NORMAL_STD_RAD.powi(2));
    }

    /// The Hessian less what the errors of the normals make of nothing; never less than nothing.
    ///
    /// In a corridor the difference decides: some hundred points whose normals are off by 3° would
    /// otherwise fix the position along it to centimetres.
    fn believed(&self) -> Matrix3<f64> {
        let mut eigen = (self.hessian - self.of_normals).symmetric_eigen();
        eigen.eigenvalues.apply(|value| *value = value.max(0.0));
        eigen.recompose()
    }
}

impl Surfel {
    /// Whether both lie on one surface (normals within 45°), or neither has a direction.
    fn is_like(&self, new: &Self) -> bool {
        if new.normal == Vec2::zeros() {
            self.normal == Vec2::zeros()
        } else {
            self.normal.dot(&new.normal) > NORMALS_AGREE * self.normal.norm()
        }
    }
}

/// Huber's weight of an error (m), over the variance: full within k, then falling as k / |e|.
fn weight_of(e_m: f64, config: &RefineConfig) -> f64 {
    config.robust_m / e_m.max(config.robust_m) / config.point_std_m.powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 6 × 4 m seen from (1.0, 0.7): points every 5 cm on its walls, with normals inwards.
    fn room() -> PointScan {
        let mut scan = PointScan::default();
        let mut add = |x: f64, y: f64, nx: f64, ny: f64| {
            scan.points.push(Vec2::new(x, y));
            scan.normals.push(Vec2::new(nx, ny));
        };
        for i in 0..120 {
            let x = f64::from(i) * 0.05 - 2.0;
            add(x, -1.5, 0.0, 1.0);
            add(x, 2.5, 0.0, -1.0);
        }
        for i in 0..80 {
            let y = f64::from(i) * 0.05 - 1.5;
            add(-2.0, y, 1.0, 0.0);
            add(4.0, y, -1.0, 0.0);
        }
        scan
    }

    fn map_of(scan: &PointScan) -> SurfelMap {
        let mut map = SurfelMap::default();
        map.rebuild([(Se2::IDENTITY, scan)].into_iter(), 0.1);
        map
    }

    #[test]
    fn a_displaced_room_is_brought_back() {
        let scan = room();
        let map = map_of(&scan);
        assert!(map.len() < scan.points.len() && map.len() > 150);
        for (x, y, yaw) in [(0.2, -0.1, 0.05), (-0.25, 0.15, -0.06), (0.0, 0.0, 0.0)] {
            let refined = map.refine(&scan, Se2::new(x, y, yaw), None, &RefineConfig::default());
            assert!(refined.converged);
            let pose = refined.pose;
            assert!(pose.position().norm() < 2e-3 && pose.yaw_rad.abs() < 1e-3, "{pose:?}");
            assert!(refined.inlier_ratio > 0.99 && refined.rms_m < 2e-3);
            assert!(refined.information.symmetric_eigenvalues().min() > 0.0);
        }
    }

    #[test]
    fn the_information_is_the_curvature_of_the_error() {
        let scan = room();
        let map = map_of(&scan);
        let config = RefineConfig::default();
        let at = map.refine(&scan, Se2::IDENTITY, None, &config);
        // Half the sum of squares over the variance at small displacements, by the walls' equations.
        let cost = |pose: Se2| -> f64 {
            let e2 = scan
                .points
                .iter()
                .zip(&scan.normals)
                .map(|(p, n)| n.dot(&(pose.transform_point(*p) - p)).powi(2));
            0.5 * e2.sum::<f64>() / config.point_std_m.powi(2)
        };
        let step = 1e-4;
        for (axis, pose) in
            [Se2::new(step, 0.0, 0.0), Se2::new(0.0, step, 0.0), Se2::new(0.0, 0.0, step)]
                .into_iter()
                .enumerate()
        {
            let curvature = 2.0 * cost(pose) / (step * step);
            let information = at.information[(axis, axis)];
            assert!(
                (information / curvature - 1.0).abs() < 0.05,
                "{axis}: {information} {curvature}"
            );
        }
    }

    #[test]
    fn a_corridor_leaves_its_direction_to_the_prior() {
        let mut scan = room();
        let keep: Vec<bool> = scan.normals.iter().map(|n| n.x == 0.0).collect();
        let mut i = 0;
        scan.points.retain(|_| {
            i += 1;
            keep[i - 1]
        });
        scan.normals.retain(|n| n.x == 0.0);
        let map = map_of(&scan);
        let guess = Se2::new(0.3, 0.1, 0.02);
        let information = nalgebra::Matrix3::from_diagonal(&Vector3::new(100.0, 100.0, 100.0));
        let prior = PosePrior { pose: guess, information };
        let refined = map.refine(&scan, guess, Some(&prior), &RefineConfig::default());
        assert!((refined.pose.x_m - 0.3).abs() < 0.01, "{:?}", refined.pose);
        assert!(refined.pose.y_m.abs() < 0.01 && refined.pose.yaw_rad.abs() < 0.005);
        assert!(refined.information[(0, 0)] < 1e-3 * refined.information[(1, 1)]);
    }

    #[test]
    fn surfaces_seen_from_behind_do_not_attract() {
        let mut behind = room();
        for normal in &mut behind.normals {
            *normal = -*normal;
        }
        let refined = map_of(&room()).refine(
            &behind,
            Se2::new(0.1, 0.0, 0.0),
            None,
            &RefineConfig::default(),
        );
        assert!(refined.inlier_ratio.abs() < f64::EPSILON);
    }

    #[test]
    fn lone_points_place_a_scan_too() {
        let points: Vec<Vec2> = [(2.0, 1.0), (3.0, -1.0), (1.0, 2.0), (4.0, 0.5), (2.5, -2.0)]
            .map(|(x, y)| Vec2::new(x, y))
            .to_vec();
        let scan = PointScan { normals: vec![Vec2::zeros(); points.len()], points };
        let refined =
            map_of(&scan).refine(&scan, Se2::new(0.1, -0.05, 0.02), None, &RefineConfig::default());
        assert!(refined.pose.position().norm() < 1e-3, "{:?}", refined.pose);
    }

    #[test]
    fn an_empty_map_leaves_the_guess() {
        let guess = Se2::new(0.1, 0.2, 0.3);
        let refined =
            map_of(&PointScan::default()).refine(&room(), guess, None, &RefineConfig::default());
        assert_eq!((refined.pose, refined.inlier_ratio), (guess, 0.0));
        let none =
            map_of(&room()).refine(&PointScan::default(), guess, None, &RefineConfig::default());
        assert_eq!((none.pose, none.inlier_ratio), (guess, 0.0));
    }
}
