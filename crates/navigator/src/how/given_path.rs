//! The way along a given path to its goal: leg by leg, corners on the spot, at the speed each place allows.

use geometry::{Vec2, wrap_to_pi};
use messages::FailureReason;
use path_following::{Course, CourseLimits, Path};

use super::{
    leg::{CourseLeg, Leg},
    preview::{PREVIEW_STEP_M, Preview},
};
use crate::{
    around::Surroundings,
    settings::NavigatorSettings,
    values::{Limits, PoseEstimate, Situation, braking_mps},
};

/// A robot further from its path than this drives to it in a straight line first, metres.
const JOIN_FROM_M: f64 = 0.25;

/// A path is taken up at the first place that is hardly further away than the nearest, metres: a loop at
/// its beginning.
const TAKE_UP_SLACK_M: f64 = 0.3;

/// After an obstacle the path is taken up within so much of its way, metres: as far as targets are offered.
const TAKE_UP_WAY_M: f64 = 5.0;

/// A goal that the path passes so much nearer elsewhere is not meant there, metres.
const GOAL_SLACK_M: f64 = 0.3;

/// Direction off the leg at which the robot turns on the spot before it drives, radians.
const ALIGN_FROM_RAD: f64 = 0.35;

/// How well it looks along the leg after turning, radians.
const ALIGNED_RAD: f64 = 0.06;

/// So far off the leg's direction while driving it stands and turns, radians.
const TURNED_AWAY_RAD: f64 = 1.2;

/// A corner counts as reached so much before the robot would stand in it, metres.
const CORNER_MARGIN_M: f64 = 0.02;

/// The rest of the path is left for a straight line to the goal where it leaves that by no more, metres.
const STRAIGHT_WITHIN_M: f64 = 0.04;

/// Speed where a turn on the spot has no room, metres per second.
const NO_ROOM_MPS: f64 = 0.1;

/// Age of a report, way of a command and ramp of the wheels, seconds: with a report every 100 ms over 9600 baud.
const LINK_LAG_S: f64 = 0.15;

/// A path under way.
#[derive(Clone, Debug)]
pub(crate) struct GivenPath {
    course: Course,
    limits: Limits,
    approach_m: f64,
    approach_from_end_m: f64,
    /// Where the path reaches the goal, metres along it.
    goal_along_m: f64,
    /// Where the robot is, metres along it.
    along_m: f64,
    leg: usize,
    /// It looks along the leg, or has no room to turn on the spot.
    aligned: bool,
    no_room: bool,
    /// Way between two points of the preview, metres.
    preview_step_m: f64,
}

impl GivenPath {
    pub(crate) fn new(path: Path, settings: &NavigatorSettings) -> Self {
        let limits = CourseLimits {
            cruise_mps: settings.speed_mps,
            wheel_speed_max_mps: settings.wheel_speed_max_mps(),
            acceleration_mps2: settings.acceleration_mps2,
            wheelbase_m: settings.drive.wheelbase_m,
            lag_s: settings.control_period_s + LINK_LAG_S,
        };
        Self {
            course: Course::new(path, &limits),
            limits: settings.limits(),
            approach_m: settings.approach_m,
            approach_from_end_m: settings.approach_from_trail_end_m,
            goal_along_m: 0.0,
            along_m: 0.0,
            leg: 0,
            aligned: false,
            no_room: false,
            preview_step_m: PREVIEW_STEP_M,
        }
    }

    /// Points that its preview can have.
    pub(crate) fn n_preview_points(&self) -> usize {
        Self::n_preview_steps(self.course.path().length_m()) as usize + 1
    }

    fn n_preview_steps(length_m: f64) -> f64 {
        (length_m / PREVIEW_STEP_M).ceil().clamp(1.0, 4000.0)
    }

    /// What is left of the path to its goal, metres.
    fn rest_m(&self) -> f64 {
        self.goal_along_m - self.along_m
    }

    /// Where the leg ends for this task: at its corner, or where the path reaches the goal.
    fn corner_ahead_m(&self) -> Option<f64> {
        let end_m = self.course.leg(self.leg).to_m;
        (self.leg + 1 < self.course.n_legs() && end_m < self.goal_along_m).then_some(end_m)
    }

    /// Direction of the leg just ahead of the robot, radians. At a corner the place itself belongs to two legs, and
    /// rounding would choose between them.
    fn leg_heading_rad(&self) -> f64 {
        let leg = self.course.leg(self.leg);
        let at_m = (self.along_m + 0.05).min(leg.to_m - 1e-6).max(leg.from_m);
        self.course.path().pose_at(at_m).yaw_rad
    }

    fn enter_leg(&mut self, leg: usize) {
        self.leg = leg;
        self.aligned = false;
        self.no_room = false;
    }

    /// Whether this leg was entered without a corner: at the path's beginning or after an obstacle.
    fn leg_is_entered_rolling(&self) -> bool {
        self.along_m > self.course.leg(self.leg).from_m + 1e-9 || self.leg == 0
    }

    /// Sets out along the path: takes it up where the robot is, or drives to it first. And whether the robot has come
    /// further than at the beginning.
    pub(crate) fn begin(&mut self, situation: &Situation, preview: &mut Preview) -> (Leg, bool) {
        let Some(goal) = situation.goal_point() else {
            return (Leg::Failed(FailureReason::NoTrail), false);
        };
        let path = self.course.path();
        let goal_along_m = path.reaches_m(goal, self.approach_m, GOAL_SLACK_M);
        let position = situation.at.position();
        let along_m = path.first_near_m(position, 0.0, goal_along_m, TAKE_UP_SLACK_M);
        // Resampled like a scout's walk, so that everything after works on both.
        let n_steps = Self::n_preview_steps(goal_along_m);
        let at = |k: u32| path.point_at(goal_along_m * f64::from(k) / n_steps);
        preview.lay((0..=(n_steps as u32)).map(at));
        let join = path.point_at(along_m);
        self.goal_along_m = goal_along_m;
        self.preview_step_m = (goal_along_m / n_steps).max(1e-3);
        self.along_m = along_m;
        self.enter_leg(self.course.leg_at(along_m));
        let is_further = self.show(preview);
        let far = (join - position).norm() > JOIN_FROM_M;
        (if far { Leg::Join(join) } else { Leg::Follow }, is_further)
    }

    /// After an obstacle or a wait: takes the path up again, here or further on, never before. Whether further on.
    pub(crate) fn take_up(&mut self, position: Vec2, preview: &mut Preview) -> bool {
        let last_m = (self.along_m + TAKE_UP_WAY_M).min(self.goal_along_m);
        self.along_m = self.course.path().first_near_m(position, self.along_m, last_m, 0.1);
        self.enter_leg(self.course.leg_at(self.along_m));
        self.show(preview)
    }

    /// One control period along the path, once it knows where the robot is.
    pub(crate) fn follow(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        is_blocked: bool,
    ) -> Leg {
        let is_turning = situation.steering.is_turning;
        let (rest_m, corner_m) = (self.rest_m(), self.corner_ahead_m());
        if corner_m.is_none() && self.rest_is_straight(situation, around, rest_m) {
            return Leg::ToGoal;
        }
        if corner_m.is_none() && rest_m <= 0.05 {
            // The path ends too far from the goal to go there blindly.
            return Leg::Failed(FailureReason::NoTrailToGoal);
        }
        if !self.aligned || is_turning {
            return self.align(&situation.at, around, is_turning);
        }
        if is_blocked {
            return Leg::Blocked;
        }
        let stop_m = situation.at.stopping_way_m(&self.limits);
        if let Some(corner_m) = corner_m
            && corner_m - self.along_now_m(situation) <= stop_m + CORNER_MARGIN_M
        {
            self.along_m = corner_m;
            self.enter_leg(self.leg + 1);
            return Leg::Corner;
        }
        Leg::ByCourse
    }

    /// Turns on the spot to the direction of the leg where that is needed and safe.
    fn align(&mut self, at: &PoseEstimate, around: &Surroundings, is_turning: bool) -> Leg {
        let heading_rad = self.leg_heading_rad();
        let off_rad = wrap_to_pi(heading_rad - at.pose.yaw_rad);
        let near = off_rad.abs() <= ALIGN_FROM_RAD && self.leg_is_entered_rolling();
        let no_room = !is_turning && !near && !around.turn_is_safe(at, off_rad);
        if !is_turning && (near || no_room) {
            self.set_aligned(no_room);
            return Leg::Rest;
        }
        Leg::Turn { heading_rad, within_rad: ALIGNED_RAD }
    }

    /// The robot looks along the leg, or has no room to turn there.
    pub(crate) fn set_aligned(&mut self, no_room: bool) {
        self.aligned = true;
        self.no_room = no_room;
    }

    /// The leg, and how fast it may be driven where the robot is, at most as fast as the way allows.
    pub(crate) fn course(&self, situation: &Situation, way_mps: f64) -> CourseLeg<'_> {
        let limits = &self.limits;
        let delay_s = situation.at.delay_s();
        let measured_mps = situation.at.speed_mps().max(0.0);
        let at_m = self.along_now_m(situation);
        let ahead_m = measured_mps * (delay_s + limits.period_s);
        let end_m = self.course.leg(self.leg).to_m;
        let course_mps = self.course.speed_until_mps(at_m, (at_m + ahead_m).min(end_m));
        let goal_mps = braking_mps(
            self.goal_along_m - at_m - measured_mps * delay_s,
            limits.acceleration_mps2,
            limits.period_s,
        );
        let mut speed_mps = course_mps.min(goal_mps).min(way_mps);
        if self.no_room {
            speed_mps = speed_mps.min(NO_ROOM_MPS);
        }
        let speed_mps = speed_mps.max(limits.least_mps());
        CourseLeg { course: &self.course, leg: self.leg, speed_mps }
    }

    /// Where the robot is on its leg, by its last report; whether that is further on.
    pub(crate) fn advance(&mut self, at: &PoseEstimate, preview: &mut Preview) -> bool {
        let leg = self.course.leg(self.leg);
        let (from_m, to_m) = (self.along_m - 0.5, self.along_m + 1.5);
        let (from_m, to_m) = (from_m.max(leg.from_m), to_m.min(leg.to_m).min(self.goal_along_m));
        let seen = self.course.path().project_within(at.position(), from_m, to_m.max(from_m));
        self.along_m = seen.arc_length_m;
        let off_rad = wrap_to_pi(at.pose.yaw_rad - self.leg_heading_rad()).abs();
        if self.aligned && !self.no_room && off_rad > TURNED_AWAY_RAD {
            self.aligned = false;
        }
        self.show(preview)
    }

    /// The same at present: what it has driven since the report was true is added.
    fn along_now_m(&self, situation: &Situation) -> f64 {
        self.along_m + situation.at.speed_mps().max(0.0) * situation.at.age_s(situation.now)
    }

    /// The preview begins where the robot is; whether that is further than before.
    fn show(&self, preview: &mut Preview) -> bool {
        preview.go_to((self.along_m / self.preview_step_m) as usize)
    }

    /// Whether the rest of the path is short, hardly leaves the straight line to the goal, and nothing was heard
    /// on that.
    fn rest_is_straight(&self, situation: &Situation, around: &Surroundings, rest_m: f64) -> bool {
        let Some(goal) = situation.goal_point() else { return false };
        let position = situation.at.position();
        let end = self.course.path().point_at(self.goal_along_m);
        let reach_m = if rest_m < 0.1 { self.approach_from_end_m } else { self.approach_m };
        let way = goal - position;
        if rest_m > self.approach_m || !around.goal_is_straight_ahead(situation, reach_m) {
            return false;
        }
        if rest_m < 0.1 || (goal - end).norm() > STRAIGHT_WITHIN_M {
            // Its end is beside the goal: first to its end.
            return rest_m < 0.1;
        }
        let length_m = way.norm().max(1e-6);
        let off_m = |point: Vec2| (way.perp(&(point - position)) / length_m).abs();
        let along_m = |k: u32| self.along_m + rest_m * f64::from(k) / 8.0;
        (0..8).all(|k| off_m(self.course.path().point_at(along_m(k))) <= STRAIGHT_WITHIN_M)
    }
}
