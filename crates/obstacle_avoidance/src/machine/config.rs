//! Settings of the machine.

use std::time::Duration;

use crate::{Bubble, ForcedSwing};

/// When the machine aims at its target again after a rebound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// After a temporary target at a fixed distance (Annex C).
    Detour,
    /// As soon as nothing is in the way towards the target (Fig. 6.9).
    #[default]
    Visibility,
}

settings::choices!(Variant {
    Visibility = "visibility": "as soon as nothing is in the way towards it",
    Detour = "detour": "after a place at a fixed distance aside",
});

/// How state 6 compares headings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeadingCheck {
    /// By the shorter way round.
    #[default]
    Wrapped,
    /// By the absolute difference of two headings in 0–360°, as printed: 359° and 1° differ by 358°.
    Listing,
}

/// Settings of a [`Machine`](crate::Machine).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineConfig {
    /// When to aim at the target again.
    pub variant: Variant,
    /// Time between two steps, seconds: the Δt of (6.3.1).
    pub period_s: f64,
    /// Distance at which a target counts as reached, metres (the thesis's NEAR).
    pub near_m: f64,
    /// Distance of the temporary target, metres (its DETOUR).
    pub detour_m: f64,
    /// Heading error at which a turn counts as done, radians (its `ANGULAR_LIMIT`).
    pub angular_limit_rad: f64,
    /// How state 6 compares headings.
    pub heading_check: HeadingCheck,
    /// Least swing when the front is blocked.
    pub swing: ForcedSwing,
    /// A temporary target stays where the first rebound put it, as printed; else each rebound
    /// places a new one, since the old one often lies behind the new obstacle.
    pub keep_first_detour: bool,
    /// How far to look for the target in the visibility variant, metres.
    pub visibility_m: f64,
    /// Half the opening of the zone that must be free towards the target, radians.
    pub visibility_half_rad: f64,
    /// The visibility variant drives away at least so far, metres, before it aims again, lest it
    /// turns to and fro on the spot; and at most [`detour_max_m`](Self::detour_max_m).
    pub detour_min_m: f64,
    /// See [`detour_min_m`](Self::detour_min_m); metres.
    pub detour_max_m: f64,
    /// How long to stand in state 5 before the rebound is computed, so that every sensor has
    /// fired since the robot stopped. Zero in the thesis.
    pub settle: Duration,
    /// Stand before every turn: a robot that is told to turn while it rolls drifts on. The thesis
    /// does not say; at most 3 s.
    pub stand_before_turning: bool,
    /// How long to back off after a stall.
    pub back_off: Duration,
    /// A turn that takes longer is asked for again; the third time the machine gives up.
    pub turn_limit: Duration,
    /// Rebounds and stalls in a row, without coming [`progress_m`](Self::progress_m) nearer to the
    /// target than ever before, after which the machine gives up.
    pub rebounds_max: u32,
    /// What counts as coming nearer, metres.
    pub progress_m: f64,
    /// First heartbeat after this time, then one per second.
    pub first_heartbeat: Duration,
}

impl Default for MachineConfig {
    /// The thesis's values where it has any, else those of its reconstruction.
    fn default() -> Self {
        Self {
            variant: Variant::default(),
            period_s: 0.2,
            near_m: 0.25,
            detour_m: 1.2,
            angular_limit_rad: 5.0_f64.to_radians(),
            heading_check: HeadingCheck::default(),
            swing: ForcedSwing::default(),
            keep_first_detour: false,
            visibility_m: 1.5,
            visibility_half_rad: 30.0_f64.to_radians(),
            detour_min_m: 0.4,
            detour_max_m: 2.5,
            settle: Duration::ZERO,
            stand_before_turning: false,
            back_off: Duration::from_millis(1200),
            turn_limit: Duration::from_secs(6),
            rebounds_max: 12,
            progress_m: 0.3,
            first_heartbeat: Duration::from_secs(2),
        }
    }
}

/// A setting of a [`Machine`](crate::Machine) outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("avoider.{key} = {value}: must be {requirement}")]
pub struct MachineConfigError {
    /// The setting.
    pub key: &'static str,
    /// What was given.
    pub value: f64,
    /// What is allowed.
    pub requirement: &'static str,
}

pub(super) fn check(
    config: &MachineConfig,
    n_sensors: usize,
    bubble: &Bubble,
) -> Result<(), MachineConfigError> {
    let error = |key, value, requirement| Err(MachineConfigError { key, value, requirement });
    if bubble.len() != n_sensors {
        return error("n_sensors", n_sensors as f64, "the number of sensors the bubble speaks of");
    }
    let lengths = [
        ("period_s", config.period_s, 0.01),
        ("near_m", config.near_m, 0.01),
        ("detour_m", config.detour_m, 0.05),
        ("detour_min_m", config.detour_min_m, 0.0),
        ("detour_max_m", config.detour_max_m, 0.05),
        ("visibility_m", config.visibility_m, 0.05),
        ("progress_m", config.progress_m, 0.01),
    ];
    for (key, value, least) in lengths {
        if !(least..=100.0).contains(&value) {
            return error(key, value, "from a few centimetres (or milliseconds) to 100");
        }
    }
    let angles = [
        ("angular_limit_rad", config.angular_limit_rad),
        ("visibility_half_rad", config.visibility_half_rad),
    ];
    for (key, value) in angles {
        if !(0.001..=std::f64::consts::PI).contains(&value) {
            return error(key, value, "from 0.001 to π");
        }
    }
    Ok(())
}
