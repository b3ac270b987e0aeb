//! The map about one keyframe: what its neighbours along the way saw, to be matched against.

use geometry::{Se2, Vec2};
use nalgebra::Matrix3;

use super::{
    config::{LaserConfig, RefineConfig, TrackingConfig},
    correlative::{ScoreGrid, SearchWindow},
    keyframe::Keyframe,
    points::PointScan,
    surfels::{PosePrior, Refined, SurfelMap},
};

/// Likelihood levels of every grid; the coarsest bounds 32 × 32 shifts.
const N_LEVELS: usize = 6;
/// Farther from a guess nothing is looked for, metres.
const WINDOW_MAX_M: f64 = 6.0;
/// Keyframes farther from the anchor see nothing of what a scan there sees, metres.
const FAR_M: f64 = 50.0;
/// Points of a scan that take part in a correlative match: enough to tell, and quick.
const CORRELATED_POINTS_MAX: usize = 180;

/// What some keyframes saw, in the frame of one of them, the anchor.
#[derive(Clone, Debug, Default)]
pub struct LocalMap {
    anchor: usize,
    surfels: SurfelMap,
    grid: ScoreGrid,
    cloud: Vec<Vec2>,
    grid_is_current: bool,
}

impl LocalMap {
    /// Takes what `members` (keyframe indices) saw, in the frame of keyframe `anchor`.
    pub fn rebuild(
        &mut self,
        keyframes: &[Keyframe],
        poses: &[Se2],
        anchor: usize,
        members: impl Iterator<Item = usize> + Clone,
        config: &TrackingConfig,
    ) {
        let anchor_from_map = poses[anchor].inverse();
        // After a jump of the odometry neighbours along the way may be far apart.
        let near = |&i: &usize| anchor_from_map.compose(poses[i]).position().norm() <= FAR_M;
        let placed =
            members.filter(near).map(|i| (anchor_from_map.compose(poses[i]), &keyframes[i].points));
        self.surfels.rebuild(placed.clone(), config.surfel_cell_m);
        self.cloud.clear();
        for (pose, scan) in placed {
            self.cloud.extend(scan.points.iter().map(|&p| pose.transform_point(p)));
        }
        self.anchor = anchor;
        self.grid_is_current = false;
    }

    /// The keyframe in whose frame the map is.
    pub fn anchor(&self) -> usize {
        self.anchor
    }

    /// Every point that was taken, metres, in the anchor's frame.
    pub fn cloud(&self) -> &[Vec2] {
        &self.cloud
    }

    /// Whether nothing was seen.
    pub fn is_empty(&self) -> bool {
        self.surfels.is_empty()
    }

    /// Lays `scan` on the map from `guess`.
    pub fn refine(
        &self,
        scan: &PointScan,
        guess: Se2,
        prior: Option<&PosePrior>,
        config: &RefineConfig,
    ) -> Refined {
        self.surfels.refine(scan, guess, prior, config)
    }

    /// The likelihood grid, made when first asked for.
    pub fn grid(&mut self, config: &TrackingConfig) -> &ScoreGrid {
        if !self.grid_is_current {
            self.grid.rebuild(&self.cloud, config.grid_resolution_m, config.grid_std_m, N_LEVELS);
            self.grid_is_current = true;
        }
        &self.grid
    }

    /// Places `scan` with a guess of the given certainty: by gradient where that must do, by a search of
    /// the window where the guess is too unsure, and by both where the first is not convincing.
    pub fn place(
        &mut self,
        scan: &PointScan,
        guess: Se2,
        std_m: f64,
        std_rad: f64,
        config: &LaserConfig,
    ) -> Refined {
        let (std_m, std_rad) = (std_m.max(1e-6), std_rad.max(1e-6));
        let prior = PosePrior { pose: guess, information: isotropic(std_m, std_rad) };
        let direct = self.refine(scan, guess, Some(&prior), &config.refine);
        // A gradient finds its way over about the reach of its first step, at 10 m as well.
        let within_reach = std_m < 0.12 && std_rad * 10.0 < 0.25;
        if within_reach && direct.inlier_ratio >= config.tracking.keyframe_inlier_ratio {
            return direct;
        }
        let thinned = thinned(&scan.points, CORRELATED_POINTS_MAX);
        let window = SearchWindow {
            half_m: (3.0 * std_m).min(WINDOW_MAX_M),
            half_rad: (3.0 * std_rad).min(std::f64::consts::PI),
            std_m,
            std_rad,
        };
        let grid = self.grid(&config.tracking);
        let Some(found) = grid.correlate(&thinned, guess, &window, 0.1) else { return direct };
        let searched = self.refine(scan, found.pose, Some(&prior), &config.refine);
        if searched.inlier_ratio >= direct.inlier_ratio - 0.01 { searched } else { direct }
    }
}

/// Every n-th point, so that at most `n_max` are left.
pub(crate) fn thinned(points: &[Vec2], n_max: usize) -> Vec<Vec2> {
    let step = points.len().div_ceil(n_max).max(1);
    points.iter().step_by(step).copied().collect()
}

/// The information of a pose known to the given standard deviations.
pub(crate) fn isotropic(std_m: f64, std_rad: f64) -> Matrix3<f64> {
    // A guess without any error would leave nothing to find.
    let (std_m, std_rad) = (std_m.max(1e-6), std_rad.max(1e-6));
    let position = std_m.powi(-2);
    Matrix3::from_diagonal(&nalgebra::Vector3::new(position, position, std_rad.powi(-2)))
}
