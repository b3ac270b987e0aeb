//! The phases on a trail: find it and its direction, follow it, lose it and find it again.

use messages::{Command, FailureReason};
use std::time::Duration;

use geometry::wrap_to_pi;
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    ahead::Hazard, arrive::TurnStatus, config::Method, inquiry::Asker, navigator::Navigator,
    scout::Search, view::Phase,
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

/// Between two points of the preview, metres.
pub(crate) const PREVIEW_STEP_M: f64 = 0.12;

/// How far along the preview the robot may have come while it was busy with an obstacle, points.
const RESUME_POINTS: usize = 50;

/// How much longer than straight the rest of a way may be when the goal is headed for, metres.
const WINDING_M: f64 = 0.8;

/// Along the preview the robot steers for a point so many points ahead: it cuts corners by about
/// half of that.
const LINE_POINTS: usize = 3;

/// The longest gap in a trail that is driven across along the preview, metres.
const GAP_MAX_M: f64 = 0.9;

/// How far along the preview the robot may come in one control period, points.
const FOLLOW_POINTS: usize = 9;

/// How far ahead on the preview the robot looks for its direction, points.
const DIRECTION_POINTS: usize = 4;

impl Navigator {
    /// Begins to look for a trail to the goal, standing.
    pub(crate) fn aim_at_trail(&mut self, now: Stamp) {
        self.n_aims += 1;
        self.forget_preview();
        self.lost_from = None;
        self.gap_from = None;
        self.inquiry.cancel();
        self.enter(Phase::AimAtTrail, now);
        if let Some(goal) = self.goal_point() {
            self.scout.begin(self.pose, goal, self.config.settings.scout_max_m);
        }
    }

    /// Standing, while the scout asks; then turning towards what it found.
    pub(crate) fn aim_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.n_aims > N_AIMS_MAX {
            self.fail(FailureReason::TrailLost, now, commands);
        } else if self.goal_is_straight_ahead(self.config.settings.approach_m) {
            self.enter(Phase::Approach, now);
        } else if !self.preview.is_empty() {
            self.set_out(now, commands);
        } else if self.scout.status() != Search::Going {
            self.take_route(now, commands);
        }
    }

    /// The scout is back: with a way, with the beginning of one, or without.
    fn take_route(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let settings = &self.config.settings;
        let reach_m = settings.approach_from_trail_end_m;
        let end = self.scout.route_end();
        let is_leg = self.scout.status() == Search::LimitReached;
        if let Some((end, from_goal_m)) = end.filter(|(_, m)| is_leg || *m <= reach_m) {
            let goal = self.goal_point().filter(|_| from_goal_m < 0.5);
            let (points, is_mixed) = (&mut self.preview, &mut self.preview_is_mixed);
            self.scout.route(end, goal, PREVIEW_STEP_M, points, is_mixed);
            self.preview_index = 0;
        } else if self.goal_is_straight_ahead(reach_m) {
            self.enter(Phase::Approach, now);
        } else {
            let found = self.scout.has_found_trails();
            let reason = if found { FailureReason::NoTrailToGoal } else { FailureReason::NoTrail };
            self.fail(reason, now, commands);
        }
    }

    /// Asks the server what is to be asked next, when the link is free.
    pub(crate) fn pump_questions(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let busy = !matches!(self.phase, Phase::Idle | Phase::Arrived | Phase::Failed(_));
        let on_trail = self.config.settings.method == Method::Trail;
        if !busy || !on_trail || !self.is_heard || !self.inquiry.is_free(now) {
            return;
        }
        if self.own_wanted {
            self.own_wanted = false;
            let pose = self.pose;
            self.inquiry.ask(now, Asker::Own, pose, commands);
        } else if self.phase == Phase::AimAtTrail
            && let Some(pose) = self.scout.question()
        {
            self.inquiry.ask(now, Asker::Scout, pose, commands);
        }
    }

    /// The scout got its answer.
    pub(crate) fn scout_step(&mut self, now: Stamp, intensities: (f64, f64)) {
        if self.phase == Phase::AimAtTrail {
            self.scout.answer(intensities);
            // A search has a limit of its own.
            self.note_progress(now);
        }
    }

    pub(crate) fn forget_preview(&mut self) {
        self.preview.clear();
        self.preview_is_mixed.clear();
        self.preview_index = 0;
    }

    /// Turns towards the preview and sets out; first drives to it if it begins elsewhere. With `turn_first = false` it
    /// drives off at once, whichever way it looks.
    fn set_out(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(first) = self.preview.first().copied() else { return };
        if !self.config.settings.turn_first {
            // Its law, or the preview that it steers along, brings it there in an arc.
            self.begin_following(now);
            return;
        }
        if (first - self.pose.position()).norm() > 0.3 {
            let target = self.preview.get(3).copied().unwrap_or(first);
            self.bypass.resume = Phase::FollowTrail;
            self.machine.set_target(target, now);
            self.enter(Phase::Rejoin, now);
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
            self.advance_on_preview(now, RESUME_POINTS);
        }
        if self.config.settings.method == Method::Trail && self.config.settings.preview_m <= 0.0 {
            self.forget_preview();
        }
        self.enter(Phase::FollowTrail, now);
    }

    /// One control period on the trail, or along a given path.
    pub(crate) fn follow_control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.config.settings.method == Method::Path {
            self.path_control(now, commands);
            return;
        }
        self.advance_on_preview(now, FOLLOW_POINTS);
        let settings = &self.config.settings;
        let ahead_m = self.preview_ahead_m();
        let at_end = !self.preview.is_empty() && ahead_m < 0.4;
        let reach_m = if at_end { settings.approach_from_trail_end_m } else { settings.approach_m };
        // A way may pass near its goal, behind a wall or on a loop, long before it leads there.
        let is_short = self.preview.is_empty() || ahead_m < reach_m + WINDING_M;
        if is_short && self.goal_is_straight_ahead(reach_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        if settings.method == Method::Trail && at_end && ahead_m < PREVIEW_STEP_M {
            self.leave_preview(now, commands);
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
        let is_lost = left <= 0.0 && right <= 0.0;
        if self.is_led_by_preview(is_lost) {
            self.follow_preview_step(now, commands);
            return;
        }
        if is_lost {
            if self.phase == Phase::FollowTrail {
                self.lost_from = Some(self.pose.position());
                self.enter(Phase::LostTrail, now);
                self.trail_steering.forget();
            }
            self.drive(WheelReference::straight(LOST_MPS), now, commands);
            return;
        }
        if self.phase == Phase::LostTrail {
            self.begin_following(now);
        }
        let speed_mps = self.trail_speed_mps(now, false);
        let wheels = self.trail_steering.step(left, right, speed_mps, self.trail_pace());
        self.drive(wheels, now, commands);
    }

    /// Whether to drive along the preview and not after the antennas: they smell a branch that is not
    /// taken, or nothing, because the trail has a gap.
    fn is_led_by_preview(&mut self, is_lost: bool) -> bool {
        if !is_lost {
            self.gap_from = None;
            return self.preview_is_mixed.get(self.preview_index).is_some_and(|mixed| *mixed);
        }
        let position = self.pose.position();
        let gap_m = (position - *self.gap_from.get_or_insert(position)).norm();
        self.phase == Phase::FollowTrail && self.preview_ahead_m() > 0.0 && gap_m < GAP_MAX_M
    }

    /// One step along the preview, by the law for straight lines.
    fn follow_preview_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(last) = self.preview.len().checked_sub(1) else { return };
        let from = self.preview[self.preview_index.saturating_sub(1).min(last)];
        self.trail_steering.forget();
        let speed_mps = self.trail_speed_mps(now, true);
        let to = self.preview[(self.preview_index + LINE_POINTS).min(last)];
        let wheels = self.line_steering.step(self.sight(), from, to, speed_mps);
        self.drive(wheels, now, commands);
    }

    /// The way that the scout found is driven: on to the goal, or another search from here.
    fn leave_preview(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        let reach_m = self.config.settings.approach_from_trail_end_m + PREVIEW_STEP_M;
        if (goal - self.pose.position()).norm() <= reach_m {
            self.enter(Phase::Approach, now);
        } else {
            self.stop_wheels(commands);
            self.aim_at_trail(now);
        }
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

    /// Moves the preview's index to the point nearest to the robot, looking at `n_ahead` points: a
    /// way may pass the same place twice.
    pub(crate) fn advance_on_preview(&mut self, now: Stamp, n_ahead: usize) {
        let position = self.pose.position();
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
        PREVIEW_STEP_M * ahead.len().saturating_sub(1) as f64
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
