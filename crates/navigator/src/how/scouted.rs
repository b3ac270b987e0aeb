//! The way over a pheromone trail: find it and its direction by asking, follow it, lose it and find it again.

use std::time::Duration;

use geometry::{Vec2, wrap_to_pi};
use messages::{Command, FailureReason};
use path_following::WheelReference;
use run_context::Stamp;

use super::{
    inquiry::{Asker, Inquiry},
    leg::{Leg, Scent},
    preview::{PREVIEW_STEP_M, Preview},
    scout::{Scout, Scouting, Search},
};
use crate::{around::Surroundings, settings::NavigatorSettings, values::Situation};

/// Both wheels when the trail is lost, metres per second: VL = VR = 4 in units of 20 mm/s
/// (the thesis, Annex B2; its other value, 60 mm/s, contradicts this one).
const LOST_MPS: f64 = 0.08;

/// Time for driving on without a trail.
const LOST_LIMIT: Duration = Duration::from_secs(30);

/// Times that a trail may be looked for in one task.
const N_AIMS_MAX: u32 = 6;

/// A moving robot without an answer about its own pose for this long stands.
const ANSWER_MISSING: Duration = Duration::from_millis(900);

/// What an answer may take at most once its period has begun.
const ANSWER_ROUND_TRIP: Duration = Duration::from_millis(700);

/// Deviation from the preview's direction from which the robot turns in place, radians.
const TURN_FROM_RAD: f64 = 1.0;

/// How far along the preview the robot may have come while it was busy with an obstacle, points.
pub(crate) const RESUME_POINTS: usize = 50;

/// How much longer than straight the rest of a way may be when the goal is headed for, metres.
const WINDING_M: f64 = 0.8;

/// Along the preview the robot steers for a point so many points ahead: it cuts corners by about
/// half of that.
const LINE_POINTS: isize = 3;

/// The longest gap in a trail that is driven across along the preview, metres.
const GAP_MAX_M: f64 = 0.9;

/// How far along the preview the robot may come in one control period, points.
const FOLLOW_POINTS: usize = 9;

/// A preview that begins so far from the robot is driven to first, metres, for its fourth point.
const JOIN_FROM_M: f64 = 0.3;
const JOIN_AT: usize = 3;

/// How well it looks along the trail when it sets out, and when it has turned to it on the way, radians.
const SET_OUT_RAD: f64 = 0.15;
const TURNED_RAD: f64 = 0.2;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct ScoutedTrail {
    scout: Scout,
    inquiry: Inquiry,
    /// An answer about the robot's own pose is wanted.
    own_wanted: bool,
    /// When the last one came.
    last_own_at: Stamp,
    n_aims: u32,
    lost_from: Option<Vec2>,
    /// Where the antennas ceased to smell anything, on the preview.
    gap_from: Option<Vec2>,
    turn_first: bool,
    keeps_preview: bool,
    period: Duration,
    approach_m: f64,
    approach_from_end_m: f64,
    scout_max_m: f64,
    lost_drive_m: f64,
}

impl ScoutedTrail {
    pub(crate) fn new(s: &NavigatorSettings) -> Self {
        Self {
            scout: Scout::new(),
            inquiry: Inquiry::default(),
            own_wanted: false,
            last_own_at: Stamp::ZERO,
            n_aims: 0,
            lost_from: None,
            gap_from: None,
            turn_first: s.turn_first,
            keeps_preview: s.preview_m > 0.0,
            period: Duration::from_secs_f64(s.control_period_s),
            approach_m: s.approach_m,
            approach_from_end_m: s.approach_from_trail_end_m,
            scout_max_m: s.scout_max_m,
            lost_drive_m: s.lost_drive_m,
        }
    }

    /// The same with room for the largest network, which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.scout = self.scout.with_room();
        self
    }

    pub(crate) fn figures(&self) -> Scouting {
        self.scout.figures()
    }

    pub(crate) fn forget_task(&mut self) {
        self.inquiry.cancel();
        self.own_wanted = false;
        self.lost_from = None;
        self.gap_from = None;
        self.n_aims = 0;
    }

    /// The phase changes; elsewhere than on the trail an answer that was lost must not count as silence.
    pub(crate) fn change_phase(&mut self, goes_on_asking: bool) {
        if !goes_on_asking {
            self.inquiry.cancel();
        }
        self.own_wanted = false;
    }

    /// Since when questions have gone unanswered.
    pub(crate) fn silence(&self, now: Stamp) -> Duration {
        self.inquiry.silence(now)
    }

    /// Begins to look for a trail to the goal, standing.
    pub(crate) fn look(&mut self, situation: &Situation, preview: &mut Preview) {
        self.n_aims += 1;
        preview.clear();
        self.lost_from = None;
        self.gap_from = None;
        self.inquiry.cancel();
        if let Some(goal) = situation.goal_point() {
            self.scout.begin(situation.at.pose, goal, self.scout_max_m);
        }
    }

    /// Standing, while the scout asks; then turning towards what it found.
    pub(crate) fn aim(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        preview: &mut Preview,
    ) -> Leg {
        if self.n_aims > N_AIMS_MAX {
            Leg::Failed(FailureReason::TrailLost)
        } else if around.goal_is_straight_ahead(situation, self.approach_m) {
            Leg::ToGoal
        } else if !preview.is_empty() {
            self.set_out(situation, preview)
        } else if self.scout.status() != Search::Going {
            self.take_route(situation, around, preview)
        } else {
            Leg::Rest
        }
    }

    /// The scout is back: with a way, with the beginning of one, or without.
    fn take_route(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        preview: &mut Preview,
    ) -> Leg {
        let reach_m = self.approach_from_end_m;
        let end = self.scout.route_end();
        let is_leg = self.scout.status() == Search::LimitReached;
        if let Some((end, from_goal_m)) = end.filter(|(_, m)| is_leg || *m <= reach_m) {
            let goal = situation.goal_point().filter(|_| from_goal_m < 0.5);
            preview.write(|points, is_mixed| {
                self.scout.route(end, goal, PREVIEW_STEP_M, points, is_mixed);
            });
            Leg::Rest
        } else if around.goal_is_straight_ahead(situation, reach_m) {
            Leg::ToGoal
        } else if self.scout.has_found_trails() {
            Leg::Failed(FailureReason::NoTrailToGoal)
        } else {
            Leg::Failed(FailureReason::NoTrail)
        }
    }

    /// Turns towards the preview and sets out; first drives to it if it begins elsewhere. With `turn_first = false` it
    /// drives off at once, whichever way it looks.
    fn set_out(&self, situation: &Situation, preview: &Preview) -> Leg {
        let Some(first) = preview.points().first().copied() else { return Leg::Rest };
        if !self.turn_first {
            // Its law, or the preview that it steers along, brings it there in an arc.
            return Leg::TakeUp;
        }
        let position = situation.at.position();
        if (first - position).norm() > JOIN_FROM_M {
            return Leg::Join(preview.points().get(JOIN_AT).copied().unwrap_or(first));
        }
        let heading_rad = preview.heading_rad(position).unwrap_or(situation.at.pose.yaw_rad);
        Leg::TurnOut { heading_rad, within_rad: SET_OUT_RAD }
    }

    /// The way is followed from here on; whether the robot has come further along it.
    pub(crate) fn take_up(&mut self, situation: &Situation, preview: &mut Preview) -> bool {
        self.last_own_at = situation.now;
        self.lost_from = None;
        let is_further = preview.advance(situation.at.position(), RESUME_POINTS);
        if !self.keeps_preview {
            preview.clear();
        }
        is_further
    }

    /// Where the robot has come along its way; whether that is further.
    pub(crate) fn advance(situation: &Situation, preview: &mut Preview) -> bool {
        preview.advance(situation.at.position(), FOLLOW_POINTS)
    }

    /// One control period on the trail.
    pub(crate) fn follow(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        preview: &Preview,
        is_blocked: bool,
    ) -> Leg {
        let ahead_m = preview.ahead_m();
        let at_end = !preview.is_empty() && ahead_m < 0.4;
        let reach_m = if at_end { self.approach_from_end_m } else { self.approach_m };
        // A way may pass near its goal, behind a wall or on a loop, long before it leads there.
        let is_short = preview.is_empty() || ahead_m < reach_m + WINDING_M;
        if is_short && around.goal_is_straight_ahead(situation, reach_m) {
            return Leg::ToGoal;
        }
        if at_end && ahead_m < PREVIEW_STEP_M {
            return self.leave(situation);
        }
        if situation.steering.is_turning || self.must_turn(situation, around, preview) {
            let position = situation.at.position();
            let heading_rad = preview.heading_rad(position).unwrap_or(situation.at.pose.yaw_rad);
            return Leg::Turn { heading_rad, within_rad: TURNED_RAD };
        }
        if is_blocked {
            return Leg::Blocked;
        }
        self.go_on(situation.now)
    }

    /// Wants another answer; stands when the server has been silent for too long.
    fn go_on(&mut self, now: Stamp) -> Leg {
        // A question is asked once a period, so an answer is up to a period and a round trip old.
        let missing = ANSWER_MISSING.max(self.period + ANSWER_ROUND_TRIP);
        self.own_wanted = true;
        Leg::ByAntennas { stand: now.since(self.last_own_at) > missing }
    }

    /// The way that the scout found is driven: on to the goal, or another search from here.
    fn leave(&self, situation: &Situation) -> Leg {
        let Some(goal) = situation.goal_point() else { return Leg::Rest };
        let reach_m = self.approach_from_end_m + PREVIEW_STEP_M;
        let is_near = (goal - situation.at.position()).norm() <= reach_m;
        if is_near { Leg::ToGoal } else { Leg::LookAgain }
    }

    /// Far off the trail's direction the robot turns in place, if there is room; the law of the
    /// trail turns it, too, but in an arc.
    fn must_turn(&self, situation: &Situation, around: &Surroundings, preview: &Preview) -> bool {
        preview.heading_rad(situation.at.position()).is_some_and(|heading_rad| {
            let turn_rad = wrap_to_pi(heading_rad - situation.at.pose.yaw_rad);
            self.turn_first
                && turn_rad.abs() > TURN_FROM_RAD
                && around.turn_is_safe(&situation.at, turn_rad)
        })
    }

    /// One control period without a trail: straight on and slowly, for a bounded way.
    pub(crate) fn search(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        is_blocked: bool,
        since: Stamp,
    ) -> Leg {
        if around.goal_is_straight_ahead(situation, self.approach_from_end_m) {
            return Leg::ToGoal;
        }
        let position = situation.at.position();
        let driven_m = (position - self.lost_from.unwrap_or(position)).norm();
        let long = situation.now.since(since) > LOST_LIMIT;
        if driven_m >= self.lost_drive_m || long || is_blocked {
            return Leg::LookAgain;
        }
        self.go_on(situation.now)
    }

    /// Takes an answer: P_L, P_R, if it is about the robot's own pose. The scout's own count only while the robot
    /// `aims`; then they are progress, since a search has a limit of its own.
    pub(crate) fn answer(
        &mut self,
        now: Stamp,
        query: u8,
        intensities: (f64, f64),
        aims: bool,
    ) -> Answer {
        match self.inquiry.answer(query) {
            Some(Asker::Own) => {
                self.last_own_at = now;
                Answer::Own
            }
            Some(Asker::Scout) if aims => {
                self.scout.answer(intensities);
                Answer::Scout
            }
            _ => Answer::Nobodys,
        }
    }

    /// What the robot's own answer means for its way; `follows` unless the trail is lost already.
    pub(crate) fn scent(
        &mut self,
        situation: &Situation,
        (left, right): (f64, f64),
        preview: &Preview,
        follows: bool,
    ) -> Scent {
        let is_lost = left <= 0.0 && right <= 0.0;
        // A branch that is not taken smells, too.
        let is_led = if is_lost {
            self.crosses_gap(situation, preview) && follows
        } else {
            preview.is_mixed_here()
        };
        if !is_lost {
            self.gap_from = None;
        }
        if is_led {
            let line = preview.point(-1).zip(preview.point(LINE_POINTS));
            if let Some((from, to)) = line {
                return Scent::Line { from, to };
            }
        }
        if is_lost {
            if follows {
                self.lost_from = Some(situation.at.position());
            }
            return Scent::Nothing(WheelReference::straight(LOST_MPS));
        }
        Scent::Trail
    }

    /// Nothing is smelled: whether that is a gap in the trail, short enough to be driven across along the preview.
    fn crosses_gap(&mut self, situation: &Situation, preview: &Preview) -> bool {
        let position = situation.at.position();
        let gap_m = (position - *self.gap_from.get_or_insert(position)).norm();
        preview.ahead_m() > 0.0 && gap_m < GAP_MAX_M
    }

    /// Asks the server what is to be asked next, when the link is free.
    pub(crate) fn ask(&mut self, situation: &Situation, aims: bool, commands: &mut Vec<Command>) {
        let now = situation.now;
        if !self.inquiry.is_free(now) {
            return;
        }
        if self.own_wanted {
            self.own_wanted = false;
            self.inquiry.ask(now, Asker::Own, situation.at.pose, commands);
        } else if aims && let Some(pose) = self.scout.question() {
            self.inquiry.ask(now, Asker::Scout, pose, commands);
        }
    }
}

/// Whom an answer was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Own,
    Scout,
    Nobodys,
}
