//! What a localiser says.

use geometry::{Base, Map, Transform2};
use robot_models::PoseCovariance;

/// How far an estimate can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// The pose is known, and what is seen fits it.
    Sure,
    /// It may be elsewhere: the particles are spread, or little fits.
    Unsure,
    /// What is seen does not fit where it should be; it may be anywhere.
    Lost,
}

impl Health {
    /// The word for it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Sure => "sure",
            Self::Unsure => "unsure",
            Self::Lost => "lost",
        }
    }
}

/// Where a robot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean of the heaviest group of particles.
    pub map_from_base: Transform2<Map, Base>,
    /// Around that pose: of its group where that has nine tenths of the weight, else of all particles.
    pub covariance: PoseCovariance,
    /// Part of the beams that end where the map has something, at that pose; 1 before the first correction.
    pub agreement_ratio: f64,
    /// Part of the weight that is in the heaviest group.
    pub share_ratio: f64,
    /// In a word.
    pub health: Health,
}

/// Standard deviations up to which a pose is known: of the position (m) and of the heading (rad).
const SURE_POSITION_STD_M: f64 = 0.15;
const SURE_HEADING_STD_RAD: f64 = 0.12;

/// Part of the beams that must fit a pose that is known, and below which it is lost.
const SURE_AGREEMENT: f64 = 0.5;
const LOST_AGREEMENT: f64 = 0.3;

/// Part of the weight that the heaviest group has where the pose is known.
const SURE_SHARE: f64 = 0.9;

impl Estimate {
    /// The word that follows from the figures.
    pub(crate) fn with_health(self) -> Self {
        let variance = |i: usize| self.covariance.0[(i, i)];
        let position_std_m = (variance(0) + variance(1)).sqrt();
        let heading_std_rad = variance(2).sqrt();
        let known = position_std_m <= SURE_POSITION_STD_M
            && heading_std_rad <= SURE_HEADING_STD_RAD
            && self.share_ratio >= SURE_SHARE;
        let health = if self.agreement_ratio < LOST_AGREEMENT {
            Health::Lost
        } else if known && self.agreement_ratio >= SURE_AGREEMENT {
            Health::Sure
        } else {
            Health::Unsure
        };
        Self { health, ..self }
    }
}
