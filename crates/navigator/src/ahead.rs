//! What lies ahead: the way the robot is about to take, and whether something stands on it.

use std::time::Duration;

use geometry::Vec2;
use run_context::Stamp;

use crate::{config::Avoidance, navigator::Navigator, view::Phase};

/// Whether something is in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hazard {
    None,
    Ahead,
}

/// How much of the way ahead is looked at at 0.3 m/s, metres; at higher speeds as much more as braking takes.
const LOOK_M: f64 = 1.3;

/// The speed that [`LOOK_M`] is for, metres per second.
const LOOK_SPEED_MPS: f64 = 0.3;

/// Points of the way ahead: 3.6 m of preview.
const N_AHEAD_MAX: usize = 32;

/// Speed where the way is narrow, metres per second, and as a part of the cruising speed.
const NARROW_MPS: f64 = 0.2;
const NARROW_RATIO: f64 = 0.6;

/// A robot is taken to come up to things with at least this speed, metres per second.
const COMES_UP_MPS: f64 = 0.24;

/// What must stay free beside the robot on its way, metres.
const WAY_MARGIN_M: f64 = 0.05;

/// Room to keep between the nose and a thing after stopping, metres: enough to turn in place,
/// since the rear corners reach 0.16 m further than the nose.
pub(crate) const STAND_OFF_M: f64 = 0.30;

/// Only what was heard so lately blocks the way of a moving robot: each sonar of eight fires every
/// 320 ms, and what is still there is heard again.
const RECENT: Duration = Duration::from_millis(1200);

/// A waiting robot believes longer: oblique smooth surfaces fall silent now and then.
const RECENT_WAITING: Duration = Duration::from_secs(4);

/// A way to drive: its points (m, map), the first at the robot's axle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    points: [Vec2; N_AHEAD_MAX],
    n_points: usize,
    /// Whether the robot will stand at its end; else the trail goes on beyond.
    ends: bool,
}

impl Way {
    fn begin(at: Vec2) -> Self {
        let mut points = [Vec2::zeros(); N_AHEAD_MAX];
        points[0] = at;
        Self { points, n_points: 1, ends: false }
    }

    fn push(&mut self, point: Vec2) -> bool {
        let free = self.n_points < N_AHEAD_MAX;
        if free {
            self.points[self.n_points] = point;
            self.n_points += 1;
        }
        free
    }

    pub(crate) fn points(&self) -> &[Vec2] {
        &self.points[..self.n_points]
    }

    fn length_m(&self) -> f64 {
        self.points().windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}

impl Navigator {
    /// Whether something stands on the way, near enough to stop for.
    pub(crate) fn hazard(&self, now: Stamp) -> Hazard {
        let blocked = match self.config.settings.avoidance {
            Avoidance::Off => false,
            Avoidance::Rebound => self.bubble_is_hurt(),
            Avoidance::Checked => self.way_is_blocked(now),
        };
        if blocked { Hazard::Ahead } else { Hazard::None }
    }

    /// How far along its way (m, from the axle) the first thing stands, if any does.
    pub(crate) fn first_thing_m(&self, now: Stamp) -> Option<f64> {
        let width_m = self.config.footprint.half_width_m() + WAY_MARGIN_M;
        self.echoes.first_on_path_m(self.way().points(), width_m, self.recent(now))
    }

    /// A waiting robot has found its way clear: what it heard there before has gone.
    pub(crate) fn forget_what_left_the_way(&mut self, now: Stamp) {
        if self.config.settings.watchdog_s <= 0.0 {
            return;
        }
        let width_m = self.config.footprint.half_width_m() + WAY_MARGIN_M;
        let (way, recent) = (self.way(), self.recent(now));
        self.echoes.forget_on_path(way.points(), width_m, recent);
    }

    /// A factor on the speed, at most 1: less where the way is narrow.
    pub(crate) fn pace(&self, now: Stamp) -> f64 {
        if self.config.settings.avoidance != Avoidance::Checked {
            return 1.0;
        }
        let width_m = self.config.footprint.half_width_m() + 3.0 * WAY_MARGIN_M;
        let recent = self.recent(now);
        let first_m = self.echoes.first_on_path_m(self.way().points(), width_m, recent);
        let Some(first_m) = first_m else { return 1.0 };
        let cruise_mps = self.config.settings.speed_mps;
        let slow_ratio = NARROW_RATIO.min(NARROW_MPS / cruise_mps);
        if cruise_mps <= LOOK_SPEED_MPS {
            return if first_m < 0.9 { slow_ratio } else { 1.0 };
        }
        // v² ≤ v_narrow² + 2 a d
        let more_mps = self.speed_to_stand_mps(first_m - 0.9, now);
        ((slow_ratio * cruise_mps).hypot(more_mps) / cruise_mps).min(1.0)
    }

    /// How much of the way ahead is looked at, metres.
    fn look_m(&self) -> f64 {
        let settings = &self.config.settings;
        let (v, v0) = (settings.speed_mps.max(LOOK_SPEED_MPS), LOOK_SPEED_MPS);
        let braking_m = (v * v - v0 * v0) / (1.6 * settings.acceleration_mps2);
        LOOK_M + (braking_m + (v - v0) * (settings.control_period_s + 0.1)).min(2.2)
    }

    fn recent(&self, now: Stamp) -> Stamp {
        let waiting = self.phase == Phase::Wait;
        earlier(now, if waiting { RECENT_WAITING } else { RECENT })
    }

    fn bubble_is_hurt(&self) -> bool {
        let (speed_mps, period_s) = (self.speed_mps(), self.config.settings.control_period_s);
        self.config.bubble.check(self.base.ranges_m(), speed_mps, period_s).first.is_some()
    }

    fn way_is_blocked(&self, now: Stamp) -> bool {
        let settings = &self.config.settings;
        let way = self.way();
        let end_m = if way.ends { way.length_m() } else { f64::INFINITY };
        let front_m = self.config.footprint.front_m();
        let least_mps = COMES_UP_MPS.min(0.8 * settings.speed_mps);
        let speed_mps = self.speed_mps().max(least_mps);
        let reach_m = STAND_OFF_M
            + 0.1 * speed_mps
            + 0.5 * speed_mps * speed_mps / settings.acceleration_mps2;
        let width_m = self.config.footprint.half_width_m() + WAY_MARGIN_M;
        let first_m = self.echoes.first_on_path_m(way.points(), width_m, self.recent(now));
        let on_way = first_m.is_some_and(|m| m < front_m + reach_m && m < end_m + front_m + 0.04);
        on_way || self.something_is_at_the_nose(end_m)
    }

    /// The last line: sensors that look ahead read less than their floor, wherever we think we go.
    /// A slow robot needs less.
    pub(crate) fn something_is_at_the_nose(&self, end_m: f64) -> bool {
        let settings = &self.config.settings;
        let pace =
            (self.speed_mps().max(self.motion.linear_mps()) / settings.speed_mps).clamp(0.6, 1.0);
        let floors = settings.sensors.iter().zip(&settings.bubble_floors_m);
        floors.zip(self.base.ranges_m()).any(|((sensor, floor_m), range_m)| {
            let floor_m = (pace * floor_m).min(end_m + 0.05);
            sensor.bearing_rad.abs() < 1.1 && floor_m > 0.0 && *range_m <= floor_m
        })
    }

    /// The way that the robot is about to take.
    pub(crate) fn way(&self) -> Way {
        let mut way = Way::begin(self.pose.position());
        let target = match self.phase_on_the_way() {
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.machine.target(),
            Phase::Approach => self.goal_point(),
            Phase::FollowTrail => {
                self.extend_along_preview(&mut way);
                return way;
            }
            _ => None,
        };
        if let Some(target) = target {
            way.ends = !self.machine.is_detouring();
            way.push(target);
        } else {
            way.push(self.pose.position() + self.pose.heading() * self.look_m());
        }
        way
    }

    /// The phase whose way counts: while waiting, the one that will be resumed.
    fn phase_on_the_way(&self) -> Phase {
        if self.phase == Phase::Wait { self.bypass.resume } else { self.phase }
    }

    fn extend_along_preview(&self, way: &mut Way) {
        let look_m = self.look_m();
        let mut length_m = 0.0;
        let mut last = self.pose.position();
        let mut direction = self.pose.heading();
        // The nearest point may lie a little behind; the next one does not.
        for point in self.preview.iter().skip(self.preview_index + 2) {
            let step = point - last;
            if step.norm() < 1e-6 {
                continue;
            }
            if !way.push(*point) {
                return;
            }
            length_m += step.norm();
            direction = step / step.norm();
            last = *point;
            if length_m > look_m {
                return;
            }
        }
        way.push(last + direction * (look_m - length_m));
    }
}

/// The stamp so much earlier, or the beginning.
pub(crate) fn earlier(now: Stamp, by: Duration) -> Stamp {
    let by_nanos = u64::try_from(by.as_nanos()).unwrap_or(u64::MAX);
    Stamp::from_nanos(now.as_nanos().saturating_sub(by_nanos))
}
