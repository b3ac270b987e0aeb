//! How fast: what still stops in time, what the way ahead allows, and where the robot is by now.

use robot_models::WheelSpeeds;
use std::time::Duration;

use geometry::{Se2, Twist, Vec2, wrap_to_pi};
use run_context::Stamp;

use crate::{
    ahead::STAND_OFF_M,
    config::{Avoidance, Method},
    navigator::{Navigator, SPEED_MIN_MPS},
    trail::PREVIEW_STEP_M,
};

/// Part of the wheels' acceleration that braking counts on; the rest is for late reports.
const BRAKING_SHARE: f64 = 0.8;

/// A report older than this says nothing about the present.
const REPORT_AGE_MAX_S: f64 = 0.5;

/// Wheels slower than this stand, metres per second: a Pioneer reports whole millimetres per second.
const STILL_MPS: f64 = 0.01;

/// So long both wheels must have been reported standing before the robot counts as at rest.
const STILL_FOR: Duration = Duration::from_millis(200);

/// Speed at which a trail's corner is driven and an obstacle is come up to, metres per second: the
/// thesis's 300 mm/s, at which its laws were tuned.
const CAREFUL_MPS: f64 = 0.3;

/// Speed in a bend of a preview that is driven line by line, metres per second. At 0.3 m/s the robot swings so far out of a
/// junction's right angle that of 400 errands through doors 13 touched a post, at this one 3.
const LINE_BEND_MPS: f64 = 0.18;

/// A robot that looks further beside its preview than this is careful, radians.
const BESIDE_RAD: f64 = 0.25;

/// Turning of the preview within its next [`BEND_POINTS`] from which it is a corner, radians: 20° in
/// 0.6 m, a radius of 1.7 m. The one place where bends are slowed for.
const BEND_RAD: f64 = 0.35;

/// Points of the preview that a bend is looked for in: 0.6 m.
const BEND_POINTS: usize = 5;

/// The fastest speed that still stops within `left_m` when the next decision comes after `delay_s`:
/// v T + v² / 2a = d. Zero when nothing is left.
pub(crate) fn braking_mps(left_m: f64, acceleration_mps2: f64, delay_s: f64) -> f64 {
    let a = BRAKING_SHARE * acceleration_mps2;
    let late_mps = a * delay_s;
    (late_mps * late_mps + 2.0 * a * left_m.max(0.0)).sqrt() - late_mps
}

/// Since when the wheels have been reported standing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stillness {
    since: Option<Stamp>,
    latest: Stamp,
}

impl Stillness {
    /// Takes a report that is about `about`.
    pub(crate) fn note(&mut self, about: Stamp, wheels: WheelSpeeds) {
        let stands = wheels.left_mps.abs() < STILL_MPS && wheels.right_mps.abs() < STILL_MPS;
        self.since = if stands { self.since.or(Some(about)) } else { None };
        self.latest = about;
    }

    /// Whether all reports of the last 200 ms, and at least two, say that it stands.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.since.is_some_and(|since| self.latest.since(since) >= STILL_FOR)
    }
}

impl Navigator {
    /// How old the last report is, seconds.
    pub(crate) fn report_age_s(&self, now: Stamp) -> f64 {
        now.since(self.base.about).as_secs_f64().min(REPORT_AGE_MAX_S)
    }

    /// How long a command takes to the wheels, as long as the last report took, seconds.
    pub(crate) fn command_delay_s(&self) -> f64 {
        self.base_at.since(self.base.about).as_secs_f64().min(REPORT_AGE_MAX_S)
    }

    /// Where the robot is by now: the reported pose and what its wheels have done since.
    pub(crate) fn pose_now(&self, now: Stamp) -> Se2 {
        self.pose_after_s(self.report_age_s(now))
    }

    /// Where it will be when a command that is given now gets to its wheels.
    pub(crate) fn pose_at_command(&self, now: Stamp) -> Se2 {
        self.pose_after_s(self.report_age_s(now) + self.command_delay_s())
    }

    /// The reported pose and what the wheels do in the time after it.
    fn pose_after_s(&self, age_s: f64) -> Se2 {
        let velocity = self.config.settings.drive.body_velocity(self.base.wheel_speeds());
        self.pose.compose(Se2::exp(Twist {
            dx_m: velocity.linear_mps * age_s,
            dy_m: 0.0,
            dyaw_rad: velocity.angular_radps * age_s,
        }))
    }

    /// How far the robot still goes when it is told to stop now, metres: v T + v² / 2a with its measured speed.
    pub(crate) fn stopping_way_m(&self) -> f64 {
        let speed_mps = self.speed_mps().abs();
        let braking_m = 0.5 * speed_mps * speed_mps / self.config.settings.acceleration_mps2;
        speed_mps * self.command_delay_s() + braking_m
    }

    /// The fastest speed to a point `left_m` away (by the last report) at which the robot shall stand, m/s.
    pub(crate) fn speed_to_stand_mps(&self, left_m: f64, now: Stamp) -> f64 {
        let settings = &self.config.settings;
        let gone_m = self.speed_mps().max(0.0) * (self.report_age_s(now) + self.command_delay_s());
        braking_mps(left_m - gone_m, settings.acceleration_mps2, settings.control_period_s)
    }

    /// What narrow places and things on the way ahead allow, m/s.
    pub(crate) fn way_speed_mps(&self, now: Stamp) -> f64 {
        let settings = &self.config.settings;
        let paced_mps = self.pace(now) * settings.speed_mps;
        if settings.avoidance != Avoidance::Checked || paced_mps <= CAREFUL_MPS {
            return paced_mps;
        }
        let Some(first_m) = self.first_thing_m(now) else { return paced_mps };
        let left_m = first_m - self.config.footprint.front_m() - STAND_OFF_M;
        paced_mps.min(self.speed_to_stand_mps(left_m, now).max(CAREFUL_MPS))
    }

    /// The speed on a trail: the way ahead, its bends, and the goal at its end.
    /// The law for straight lines takes a bend of the preview in pieces, and swings out of it: see [`LINE_BEND_MPS`].
    pub(crate) fn trail_speed_mps(&self, now: Stamp, by_lines: bool) -> f64 {
        let settings = &self.config.settings;
        let mut speed_mps = self.way_speed_mps(now);
        if !settings.fit_to_speed {
            return speed_mps;
        }
        if let Some(bend_m) = self.first_bend_m() {
            let gone_m =
                self.speed_mps().max(0.0) * (self.report_age_s(now) + self.command_delay_s());
            let a = settings.acceleration_mps2;
            let more_mps = braking_mps(bend_m - gone_m, a, settings.control_period_s);
            let bend_mps = if by_lines { LINE_BEND_MPS } else { CAREFUL_MPS };
            // v² ≤ v_bend² + 2 a d
            speed_mps = speed_mps.min(bend_mps.hypot(more_mps));
        }
        let looks_beside = self
            .preview_heading_rad()
            .is_some_and(|ahead_rad| wrap_to_pi(ahead_rad - self.pose.yaw_rad).abs() > BESIDE_RAD);
        if looks_beside {
            speed_mps = speed_mps.min(CAREFUL_MPS);
        }
        if let Some(rest_m) = self.rest_to_goal_m() {
            speed_mps = speed_mps.min(self.speed_to_stand_mps(rest_m, now));
        }
        speed_mps.max(SPEED_MIN_MPS.min(settings.speed_mps))
    }

    /// The measured speed as a part of the one that the laws of trails were tuned at, or of a lower cruising speed;
    /// 1 for a law as printed.
    pub(crate) fn trail_pace(&self) -> f64 {
        if !self.config.settings.fit_to_speed {
            return 1.0;
        }
        self.speed_mps() / self.config.settings.speed_mps.min(CAREFUL_MPS)
    }

    /// Way to the first bend of the preview, metres.
    fn first_bend_m(&self) -> Option<f64> {
        let ahead = self.preview.get(self.preview_index..)?;
        let direction = |way: Vec2| way.y.atan2(way.x);
        let bends = |points: &[Vec2]| {
            let (into, out) =
                (points[2] - points[0], points[BEND_POINTS] - points[BEND_POINTS - 2]);
            wrap_to_pi(direction(out) - direction(into)).abs() > BEND_RAD
        };
        ahead.windows(BEND_POINTS + 1).position(bends).map(|k| PREVIEW_STEP_M * k as f64)
    }

    /// Way over the preview to the goal where the preview leads to it; straight where there is none.
    fn rest_to_goal_m(&self) -> Option<f64> {
        let goal = self.goal_point()?;
        let settings = &self.config.settings;
        let Some(last) = self.preview.last() else {
            return Some((goal - self.pose.position()).norm());
        };
        let beyond_m = (goal - last).norm();
        let on_trail = settings.method == Method::Trail;
        (on_trail && beyond_m <= settings.approach_from_trail_end_m)
            .then(|| self.preview_ahead_m() + beyond_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Braking written out anew: drives at the speed for the delay, then brakes with all there is.
    #[test]
    fn what_is_allowed_stops_in_time_and_not_much_earlier() {
        for a in [0.1, 0.3, 2.0] {
            for delay_s in [0.0, 0.2, 1.0] {
                for left_m in [0.0, 0.01, 0.3, 3.0] {
                    let v = braking_mps(left_m, a, delay_s);
                    let way_m = v * delay_s + v * v / (2.0 * a);
                    assert!(way_m <= left_m + 1e-9, "{a} {delay_s} {left_m}: {way_m}");
                    assert!(way_m >= 0.8 * left_m - 1e-9, "{a} {delay_s} {left_m}: {way_m}");
                }
            }
        }
        assert!(braking_mps(-1.0, 0.3, 0.2).abs() < 1e-12);
    }
}
