//! Whether something stands on the way ahead, and how fast what stands beside and behind it lets the robot be.

use std::time::Duration;

use geometry::Vec2;
use path_following::WheelReference;
use run_context::Stamp;

use super::scene::Scene;
use crate::{
    settings::Avoidance,
    values::{CAREFUL_MPS, Limits, Situation, earlier},
};

/// Speed where the way is narrow, metres per second, and as a part of the cruising speed.
const NARROW_MPS: f64 = 0.2;
const NARROW_RATIO: f64 = 0.6;

/// From so far ahead of the axle on the robot is slow in a narrow place, metres.
const NARROW_FROM_M: f64 = 0.9;

/// A robot is taken to come up to things with at least this speed, metres per second.
const COMES_UP_MPS: f64 = 0.24;

/// What must stay free beside the robot on its way, metres.
pub(crate) const WAY_MARGIN_M: f64 = 0.05;

/// Room to keep between the nose and a thing after stopping, metres: enough to turn in place,
/// since the rear corners reach 0.16 m further than the nose.
const STAND_OFF_M: f64 = 0.30;

/// Only what was heard so lately blocks the way of a moving robot: each sonar of eight fires every
/// 320 ms, and what is still there is heard again.
const RECENT: Duration = Duration::from_millis(1200);

/// A waiting robot believes longer: oblique smooth surfaces fall silent now and then.
const RECENT_WAITING: Duration = Duration::from_secs(4);

/// The rules; they remember nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hazards {
    method: Avoidance,
    limits: Limits,
}

impl Hazards {
    pub(crate) fn new(method: Avoidance, limits: Limits) -> Self {
        Self { method, limits }
    }

    /// Since when what was heard counts.
    pub(crate) fn recent(situation: &Situation) -> Stamp {
        earlier(situation.now, if situation.waits { RECENT_WAITING } else { RECENT })
    }

    /// Whether something stands on the way, near enough to stop for, of a robot that was told `told`.
    pub(crate) fn is_ahead(&self, scene: Scene<'_>, told: WheelReference) -> bool {
        match self.method {
            Avoidance::Off => false,
            Avoidance::Contact => scene.around.is_touched(),
            Avoidance::Rebound => scene.around.bubble_is_hurt(scene.situation.at.speed_mps()),
            Avoidance::Checked => self.way_is_blocked(scene, told),
        }
    }

    /// How far along its way (m, from the axle) the first thing stands, if any does.
    pub(crate) fn first_thing_m(scene: Scene<'_>) -> Option<f64> {
        let Scene { situation, around, way, .. } = scene;
        around.first_on_way_m(way, WAY_MARGIN_M, Self::recent(situation))
    }

    fn way_is_blocked(&self, scene: Scene<'_>, told: WheelReference) -> bool {
        let Scene { situation, around, way, .. } = scene;
        let limits = &self.limits;
        let end_m = way.end_m();
        let front_m = around.footprint().front_m();
        let least_mps = COMES_UP_MPS.min(0.8 * limits.speed_mps);
        let measured_mps = situation.at.speed_mps();
        let speed_mps = measured_mps.max(least_mps);
        let reach_m =
            STAND_OFF_M + 0.1 * speed_mps + 0.5 * speed_mps * speed_mps / limits.acceleration_mps2;
        let first_m = Self::first_thing_m(scene);
        let on_way = first_m.is_some_and(|m| m < front_m + reach_m && m < end_m + front_m + 0.04);
        on_way || around.something_is_at_the_nose(measured_mps.max(told.linear_mps()), end_m)
    }

    /// What narrow places and things on the way ahead allow, m/s.
    pub(crate) fn way_speed_mps(&self, scene: Scene<'_>) -> f64 {
        let Scene { situation, around, .. } = scene;
        let paced_mps = self.pace(scene) * self.limits.speed_mps;
        if self.method != Avoidance::Checked || paced_mps <= CAREFUL_MPS {
            return paced_mps;
        }
        let Some(first_m) = Self::first_thing_m(scene) else { return paced_mps };
        let left_m = first_m - around.footprint().front_m() - STAND_OFF_M;
        let stand_mps = situation.at.speed_to_stand_mps(left_m, situation.now, &self.limits);
        paced_mps.min(stand_mps.max(CAREFUL_MPS))
    }

    /// The speed along a line to a point (m, map) at which the robot shall stand, where the way allows `way_mps`, m/s.
    pub(crate) fn line_speed_mps(&self, situation: &Situation, to: Vec2, way_mps: f64) -> f64 {
        let left_m = (to - situation.at.position()).norm();
        let stand_mps = situation.at.speed_to_stand_mps(left_m, situation.now, &self.limits);
        way_mps.min(stand_mps).max(self.limits.least_mps())
    }

    /// A factor on the speed, at most 1: less where the way is narrow.
    fn pace(&self, scene: Scene<'_>) -> f64 {
        let Scene { situation, around, way, .. } = scene;
        if self.method != Avoidance::Checked {
            return 1.0;
        }
        let recent = Self::recent(situation);
        let Some(first_m) = around.first_on_way_m(way, 3.0 * WAY_MARGIN_M, recent) else {
            return 1.0;
        };
        let cruise_mps = self.limits.speed_mps;
        let slow_ratio = NARROW_RATIO.min(NARROW_MPS / cruise_mps);
        if self.limits.is_slow() {
            return if first_m < NARROW_FROM_M { slow_ratio } else { 1.0 };
        }
        // v² ≤ v_narrow² + 2 a d
        let left_m = first_m - NARROW_FROM_M;
        let more_mps = situation.at.speed_to_stand_mps(left_m, situation.now, &self.limits);
        ((slow_ratio * cruise_mps).hypot(more_mps) / cruise_mps).min(1.0)
    }
}
