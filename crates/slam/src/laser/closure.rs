//! Edges between keyframes: loops that were closed, why others were not, and how much an edge says.

use geometry::Se2;
use nalgebra::Matrix3;

use crate::uncertainty::in_own_axes;

use super::{config::LaserConfig, local_map::isotropic, surfels::Refined};

/// A loop edge: two keyframes far apart on the way that saw the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// The earlier keyframe.
    pub from: usize,
    /// The later keyframe.
    pub to: usize,
    /// Pose of the later one in the frame of the earlier one.
    pub to_in_from: Se2,
    /// Share of the scan's points that the older map explained.
    pub inlier_ratio: f64,
    /// How far the estimate was off, metres.
    pub shift_m: f64,
    /// The same, radians.
    pub shift_rad: f64,
}

/// Why a loop candidate was not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejection {
    /// No pose of the window explains enough.
    Score,
    /// Too few points found a surface.
    Inliers,
    /// The scan looks through what the other map says is there.
    Through,
    /// The way back ends elsewhere.
    BothWays,
    /// No second one agreed in time.
    Alone,
}

/// The information of an edge that a match makes, in the axes of the pose itself.
///
/// Points of one scan share errors (of the beam pattern, of the surface), so that they count less than
/// their number; and no match is surer than the floor.
pub(crate) fn edge_information(
    placed: &Refined,
    std_m: f64,
    std_rad: f64,
    config: &LaserConfig,
) -> Matrix3<f64> {
    let tracking = &config.tracking;
    let information = placed.information / tracking.inflation_ratio + isotropic(std_m, std_rad);
    let floor = Matrix3::from_diagonal(&nalgebra::Vector3::new(
        tracking.floor_std_m.powi(2),
        tracking.floor_std_m.powi(2),
        tracking.floor_std_rad.powi(2),
    ));
    let own = in_own_axes(&information, placed.pose);
    let covariance = own.try_inverse().unwrap_or_else(Matrix3::identity) + floor;
    covariance.try_inverse().unwrap_or_else(Matrix3::identity)
}
