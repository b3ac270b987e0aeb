//! What one registration did, for whoever wants to see.

use geometry::{Map, Odom, Se2, Transform2};
use nalgebra::Matrix3;
use recordings::StampedPose;
use run_context::Stamp;

use crate::{maturity::Collected, search::Candidate};

/// A short-term map that was laid on the long-term one and became part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Registration {
    /// Of the last row in the short-term map.
    pub stamp: Stamp,
    /// What it had collected.
    pub collected: Collected,
    /// Every pose that was tried, with its score.
    pub candidates: Vec<Candidate>,
    /// Index of the best candidate.
    pub chosen: Option<usize>,
    /// Echoes that were attributed to known walls.
    pub n_wall_echoes: usize,
    /// Root of the mean square of their residuals, metres.
    pub wall_rms_m: f64,
    /// What came of it.
    pub outcome: Outcome,
    /// From the uncorrected to the corrected pose of the robot at the end, in the frame of the map:
    /// x m, y m, yaw rad.
    pub correction: Se2,
    /// The robot's pose at the end about which the short-term map was drawn: corrected by walls, not by grids.
    pub drawn_end: Se2,
    /// Of the robot's pose (x, y, yaw in the frame of the map) after the correction; m² and rad².
    pub covariance: Matrix3<f64>,
    /// Yaw that odometry is now believed to miss per metre, radians.
    pub missed_yaw_radpm: f64,
    /// Corrects odometry from here on, until the next registration.
    pub map_from_odom: Transform2<Map, Odom>,
    /// Poses of the rows of the short-term map, corrected in hindsight.
    pub poses: Vec<StampedPose>,
}

/// Whether a correction was applied, and on what grounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The grids had a distinct minimum, and walls were recognised.
    ByGridsAndWalls,
    /// The grids alone.
    ByGrids,
    /// Walls alone: the grids' minimum was not distinct, or was not looked for.
    ByWalls,
    /// Nothing was recognised: new ground, or too little overlap.
    NothingRecognised,
    /// The minimum of the grids was not distinct, and no wall was recognised.
    NotDistinct,
    /// Corrections are switched off.
    SwitchedOff,
}

impl Outcome {
    /// Whether the pose was changed.
    pub fn is_applied(self) -> bool {
        matches!(self, Self::ByGridsAndWalls | Self::ByGrids | Self::ByWalls)
    }
}
