//! What a navigator shows of itself: for screens and recordings, never read back.

use geometry::{Base, Map, Transform2, Vec2};
use messages::N_RING_MAX;
use robot_models::UncertaintyEllipse;

use crate::{how::Scouting, phase::Phase};

/// A navigator at one instant.
#[derive(Clone, Copy, Debug)]
pub struct NavigatorView<'a> {
    /// What it is busy with.
    pub phase: Phase,
    /// State of the avoider's machine, 0–8.
    pub avoider_state: u8,
    /// The same in words.
    pub avoider_name: &'static str,
    /// Estimated pose.
    pub map_from_base: Transform2<Map, Base>,
    /// Where the robot lies with about 95 % probability if the odometry's error model holds (2.45 σ).
    pub ellipse: UncertaintyEllipse,
    /// The goal, if any.
    pub goal_in_map: Option<Transform2<Map, Base>>,
    /// The point that is driven to at present, if any (m, map).
    pub target_in_map: Option<Vec2>,
    /// The path ahead, up to `preview_m`: the way that the scout found or the given path (m, map).
    pub preview_in_map: &'a [Vec2],
    /// Length of the whole path ahead, metres.
    pub way_ahead_m: f64,
    /// What the scout has asked and found for the present goal, or for the last one.
    pub scouting: Scouting,
    /// The last intensities at the robot's own pose: left, right.
    pub intensities: Option<(f64, f64)>,
    /// The bubble's boundary of each sensor, metres; zero where there is no sensor.
    pub bubble_limits_m: [f64; N_RING_MAX],
    /// Number of sensors of which `bubble_limits_m` speaks.
    pub n_sonars: usize,
    /// The follower's error: P_L − P_R on a trail, metres to the left on a path.
    pub follower_error: f64,
    /// The last rebound angle relative to the robot's heading at that time, radians.
    pub rebound_rad: Option<f64>,
    /// Echoes remembered for guarding (m, map).
    pub n_echoes: usize,
    /// Attempts used on the present obstacle.
    pub n_attempts: u32,
}
