//! The phases on a trail: find it and its direction, follow it, lose it and find it again.

use std::time::Duration;

use geometry::{Vec2, wrap_to_pi};
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    ahead::Hazard,
    arrive::TurnStatus,
    config::Method,
    inquiry::Asker,
    messages::{Command, FailureReason},
    navigator::Navigator,
    scout::{Starts, Walk},
    view::Phase,
};

/// Both wheels when the trail is lost, metres per second: VL = VR = 4 in units of 20 mm/s
/// (the thesis, Annex B2; its other value, 60 mm/s, contradicts this one).
const LOST_MPS: f64 = 0.08;

/// Times that a trail may be looked for in one task.
const N_AIMS_MAX: u32 = 6;

/// A moving robot without an answer about its own pose for this long stands.
const ANSWER_MISSING: Duration = Duration::from_millis(900);

/// What an answer may take at most once its period has begun.
const ANSWER_ROUND_TRIP: Duration = Duration::from_millis(700);

/// Deviation from the preview's direction from which the robot turns in place, radians.
const TURN_FROM_RAD: f64 = 1.0;

/// How far ahead on the preview the robot looks for its direction, points of 120 mm.
const DIRECTION_POINTS: usize = 4;

impl Navigator {
    /// Begins to look for the trail, standing.
    pub(crate) fn aim_at_trail(&mut self, now: Stamp) {
        self.n_aims += 1;
        self.starts = Starts::default();
        self.scout.clear();
        self.scout_best.clear();
        self.preview.clear();
        self.preview_index = 0;
        self.lost_from = None;
        self.inquiry.cancel();
        self.enter(Phase::AimAtTrail, now);
        self.next_start();
    }

    /// Standing, while the scout walks; then turning towards what it found.
    pub(crate) fn aim_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.n_aims > N_AIMS_MAX {
            self.fail(FailureReason::TrailLost, now, commands);
        } else if self.goal_is_straight_ahead(self.config.settings.approach_m) {
            self.enter(Phase::Approach, now);
        } else if !self.preview.is_empty() {
            self.set_out(now, commands);
        } else if self.scout.status() != Walk::Going {
            // All starts are used up and none was good.
            let settings = &self.config.settings;
            let near_end = self.goal_is_straight_ahead(settings.approach_from_trail_end_m);
            if near_end {
                self.enter(Phase::Approach, now);
                return;
            }
            let found = self.scout_best.smelled();
            let reason = if found { FailureReason::NoTrailToGoal } else { FailureReason::NoTrail };
            self.fail(reason, now, commands);
        }
    }

    /// Asks the server what is to be asked next, when the link is free.
    pub(crate) fn pump_questions(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let busy = !matches!(self.phase, Phase::Idle | Phase::Arrived | Phase::Failed(_));
        let on_trail = self.config.settings.method == Method::Trail;
        if !busy || !on_trail || self.status.is_none() || !self.inquiry.is_free(now) {
            return;
        }
        if self.own_wanted {
            self.own_wanted = false;
            let pose = self.pose;
            self.inquiry.ask(now, Asker::Own, pose, commands);
        } else if self.scout.status() == Walk::Going
            && (self.phase == Phase::AimAtTrail && self.preview.is_empty()
                || self.preview_ahead_m() < self.config.settings.preview_m)
        {
            let pose = self.scout.pose();
            self.inquiry.ask(now, Asker::Scout, pose, commands);
        }
    }

    /// The scout got its answer.
    pub(crate) fn scout_step(&mut self, intensities: (f64, f64)) {
        let Some(goal) = self.goal_point() else { return };
        let n_before = self.scout.points().len();
        self.scout.smell(intensities, goal, &self.config.settings.drive);
        if self.phase == Phase::AimAtTrail && self.preview.is_empty() {
            self.judge_walk(goal);
        } else if self.scout.points().len() > n_before {
            self.preview.extend(self.scout.points().last());
        }
    }

    /// Whether the present walk is good enough to set out, or the next start is due.
    fn judge_walk(&mut self, goal: Vec2) {
        let settings = &self.config.settings;
        let from_m = (goal - self.pose.position()).norm();
        let gained_m = from_m - self.scout.nearest_m();
        match self.scout.status() {
            Walk::AtGoal => self.accept_walk(),
            Walk::Going => {
                let long = self.scout.length_m() >= settings.scout_commit_m;
                let now_at_m = (goal - self.scout.pose().position()).norm();
                if long && from_m - now_at_m > 0.6 * settings.scout_commit_m {
                    self.accept_walk();
                }
            }
            Walk::TrailEnded | Walk::LimitReached => {
                let better = self.scout_best.points().is_empty()
                    || self.scout.smelled() && self.scout.nearest_m() < self.scout_best.nearest_m();
                let near_end = self.scout.nearest_m() < settings.approach_from_trail_end_m;
                if self.scout.smelled() && gained_m > 0.3 && near_end {
                    self.accept_walk();
                } else {
                    if better {
                        std::mem::swap(&mut self.scout, &mut self.scout_best);
                    }
                    self.next_start();
                }
            }
        }
    }

    fn accept_walk(&mut self) {
        self.preview.clear();
        self.preview.extend_from_slice(self.scout.points());
        self.preview_index = 0;
    }

    fn next_start(&mut self) {
        self.scout.clear();
        if let Some(start) = self.goal_point().and_then(|goal| self.starts.next(self.pose, goal)) {
            self.scout.start(start, self.config.settings.scout_max_m);
        }
    }

    /// Turns towards the preview and sets out; first drives to it if it begins elsewhere.
    fn set_out(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(first) = self.preview.first().copied() else { return };
        if (first - self.pose.position()).norm() > 0.3 {
            let target = self.preview.get(3).copied().unwrap_or(first);
            self.bypass.resume = Phase::FollowTrail;
            self.machine.set_target(target, now);
            self.enter(Phase::Rejoin, now);
            return;
        }
        if !self.config.settings.turn_first {
            self.begin_following(now);
            return;
        }
        let heading_rad = self.preview_heading_rad().unwrap_or(self.pose.yaw_rad);
        if self.curve_step(now, commands) {
            return;
        }
        if self.turn.is_none()
            && self.tail_may_hit_a_wall(wrap_to_pi(heading_rad - self.pose.yaw_rad))
        {
            self.curve = Some((heading_rad, now));
            return;
        }
        match self.turn_to(heading_rad, 0.15, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => self.begin_following(now),
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    pub(crate) fn begin_following(&mut self, now: Stamp) {
        self.trail_steering.forget();
        self.last_own_at = now;
        self.lost_from = None;
        if self.config.settings.method == Method::Path {
            self.take_up_path(now);
        } else {
            self.advance_on_preview(now, true);
        }
        self.enter(Phase::FollowTrail, now);
    }

    /// One control period on the trail, or along a given path.
    pub(crate) fn follow_control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.config.settings.method == Method::Path {
            self.path_control(now, commands);
            return;
        }
        self.advance_on_preview(now, false);
        let settings = &self.config.settings;
        let at_end = self.preview_ahead_m() < 0.4 && self.scout.status() != Walk::Going;
        let reach_m = if at_end { settings.approach_from_trail_end_m } else { settings.approach_m };
        if self.goal_is_straight_ahead(reach_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        if self.turn.is_some() || self.must_turn_to_preview() {
            self.turn_to_preview(now, commands);
            return;
        }
        if self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        self.stand_without_answers(now, commands);
        self.own_wanted = true;
    }

    /// Stands when the server has been silent for too long.
    fn stand_without_answers(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        // A question is asked once a period, so an answer is up to a period and a round trip old.
        let missing = ANSWER_MISSING.max(self.config.period + ANSWER_ROUND_TRIP);
        if now.since(self.last_own_at) > missing {
            self.stop_wheels(commands);
        }
    }

    /// The server's answer about the robot's own pose: one step of the trail law.
    pub(crate) fn follow_trail_step(
        &mut self,
        now: Stamp,
        (left, right): (f64, f64),
        commands: &mut Vec<Command>,
    ) {
        self.intensities = Some((left, right));
        self.last_own_at = now;
        let following = matches!(self.phase, Phase::FollowTrail | Phase::LostTrail);
        if !following || self.turn.is_some() || self.hazard(now) != Hazard::None {
            return;
        }
        if left <= 0.0 && right <= 0.0 {
            if self.phase == Phase::FollowTrail {
                self.lost_from = Some(self.pose.position());
                self.enter(Phase::LostTrail, now);
                self.trail_steering.forget();
            }
            self.drive(WheelReference::straight(LOST_MPS), commands);
            return;
        }
        if self.phase == Phase::LostTrail {
            self.begin_following(now);
        }
        let speed_mps = self.trail_speed_mps(now);
        let wheels = self.trail_steering.step(left, right, speed_mps, self.trail_pace());
        self.drive(wheels, commands);
    }

    /// One control period without a trail: straight on and slowly, for a bounded way.
    pub(crate) fn lost_control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let settings = &self.config.settings;
        if self.goal_is_straight_ahead(settings.approach_from_trail_end_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        let from = self.lost_from.unwrap_or(self.pose.position());
        let driven_m = (self.pose.position() - from).norm();
        let long = now.since(self.phase_since) > Duration::from_secs(30);
        if driven_m >= settings.lost_drive_m || long || self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
            self.aim_at_trail(now);
            return;
        }
        self.stand_without_answers(now, commands);
        self.own_wanted = true;
    }

    fn turn_to_preview(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let heading_rad = self.preview_heading_rad().unwrap_or(self.pose.yaw_rad);
        match self.turn_to(heading_rad, 0.2, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => self.begin_following(now),
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    /// Far off the trail's direction the robot turns in place, if there is room; the law of the
    /// trail turns it, too, but in an arc.
    fn must_turn_to_preview(&self) -> bool {
        self.preview_heading_rad().is_some_and(|heading_rad| {
            let turn_rad = wrap_to_pi(heading_rad - self.pose.yaw_rad);
            self.config.settings.turn_first
                && turn_rad.abs() > TURN_FROM_RAD
                && self.turn_is_safe(turn_rad)
        })
    }

    /// Direction from the robot to the preview a little ahead; `None` without a preview.
    pub(crate) fn preview_heading_rad(&self) -> Option<f64> {
        let last = self.preview.len().checked_sub(1)?;
        let index = (self.preview_index + DIRECTION_POINTS).min(last);
        let way = self.preview.get(index)? - self.pose.position();
        (way.norm() > 0.15).then(|| way.y.atan2(way.x))
    }

    /// Moves the preview's index to the point nearest to the robot, searching ahead only; all of
    /// the preview when `anywhere`, else a metre.
    pub(crate) fn advance_on_preview(&mut self, now: Stamp, anywhere: bool) {
        let position = self.pose.position();
        let n_ahead = if anywhere { usize::MAX } else { 9 };
        let candidates = self.preview.iter().enumerate().skip(self.preview_index).take(n_ahead);
        let nearest = candidates.min_by(|(_, a), (_, b)| {
            (*a - position).norm_squared().total_cmp(&(*b - position).norm_squared())
        });
        let nearest = nearest.map(|(index, _)| index);
        if let Some(index) = nearest.filter(|index| *index > self.preview_index) {
            self.preview_index = index;
            self.note_progress(now);
        }
    }

    /// Length of the preview ahead of the robot, metres.
    pub(crate) fn preview_ahead_m(&self) -> f64 {
        let ahead = self.preview.get(self.preview_index..).unwrap_or(&[]);
        0.12 * ahead.len().saturating_sub(1) as f64
    }

    /// Whether the goal is within reach and nothing was heard on the straight way to it.
    pub(crate) fn goal_is_straight_ahead(&self, within_m: f64) -> bool {
        let Some(goal) = self.goal_point() else { return false };
        let way = goal - self.pose.position();
        if way.norm() > within_m {
            return false;
        }
        let half_width_m = self.config.footprint.half_width_m();
        way.norm() < 0.1
            || self.echoes.clearance_of_leg_m(self.pose.position(), goal, 0.0) > half_width_m
    }
}
