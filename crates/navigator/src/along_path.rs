//! Driving along a given path to its goal: leg by leg, corners on the spot, at the speed each place allows.

use geometry::{Vec2, wrap_to_pi};
use messages::{Command, FailureReason};
use path_following::{Course, CourseLimits, Path};
use run_context::Stamp;

use crate::{
    ahead::Hazard,
    arrive::TurnStatus,
    config::NavigatorSettings,
    navigator::{Navigator, SPEED_MIN_MPS},
    speed::braking_mps,
    trail::PREVIEW_STEP_M,
    view::Phase,
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
pub(crate) struct PathRoute {
    pub(crate) course: Course,
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

impl PathRoute {
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
}

impl Navigator {
    /// Sets out along the path: takes it up where the robot is, or drives to it first.
    pub(crate) fn begin_path(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let (Some(route), Some(goal)) = (&mut self.route, self.goal) else {
            self.fail(FailureReason::NoTrail, now, commands);
            return;
        };
        let path = route.course.path();
        let goal = goal.se2().position();
        let goal_along_m = path.reaches_m(goal, self.config.settings.approach_m, GOAL_SLACK_M);
        let position = self.pose.position();
        let along_m = path.first_near_m(position, 0.0, goal_along_m, TAKE_UP_SLACK_M);
        // Resampled like a scout's walk, so that everything after works on both.
        let n_steps = PathRoute::n_preview_steps(goal_along_m);
        self.preview.clear();
        self.preview_is_mixed.clear();
        for k in 0..=(n_steps as u32) {
            self.preview.push(path.point_at(goal_along_m * f64::from(k) / n_steps));
        }
        let join = path.point_at(along_m);
        route.goal_along_m = goal_along_m;
        route.preview_step_m = (goal_along_m / n_steps).max(1e-3);
        route.along_m = along_m;
        route.enter_leg(route.course.leg_at(along_m));
        self.scout.clear();
        self.path_follower.restart();
        self.show_preview(now);
        if (join - position).norm() > JOIN_FROM_M {
            self.bypass.resume = Phase::FollowTrail;
            self.machine.set_target(join, now);
            self.enter(Phase::Rejoin, now);
        } else {
            self.enter(Phase::FollowTrail, now);
        }
    }

    /// After an obstacle or a wait: takes the path up again, here or further on, never before.
    pub(crate) fn take_up_path(&mut self, now: Stamp) {
        let position = self.pose.position();
        if let Some(route) = &mut self.route {
            let path = route.course.path();
            let last_m = (route.along_m + TAKE_UP_WAY_M).min(route.goal_along_m);
            route.along_m = path.first_near_m(position, route.along_m, last_m, 0.1);
            route.enter_leg(route.course.leg_at(route.along_m));
        }
        self.path_follower.restart();
        self.show_preview(now);
    }

    /// One control period along the path.
    pub(crate) fn path_control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.locate_on_path(now);
        let Some(route) = &self.route else {
            self.fail(FailureReason::NoTrail, now, commands);
            return;
        };
        let (rest_m, corner_m, aligned) = (route.rest_m(), route.corner_ahead_m(), route.aligned);
        if corner_m.is_none() && self.rest_is_straight(rest_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        if corner_m.is_none() && rest_m <= 0.05 {
            // The path ends too far from the goal to go there blindly.
            self.fail(FailureReason::NoTrailToGoal, now, commands);
            return;
        }
        if !aligned || self.turn.is_some() {
            self.align_with_leg(now, commands);
            return;
        }
        if self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        let stop_m = self.stopping_way_m();
        if let Some(corner_m) = corner_m
            && corner_m - self.along_now_m(now) <= stop_m + CORNER_MARGIN_M
        {
            self.stop_wheels(commands);
            self.begin_next_leg(corner_m);
            return;
        }
        self.drive_leg(now, commands);
    }

    fn begin_next_leg(&mut self, corner_m: f64) {
        if let Some(route) = &mut self.route {
            route.along_m = corner_m;
            route.enter_leg(route.leg + 1);
        }
        self.path_follower.restart();
    }

    /// Turns on the spot to the direction of the leg where that is needed and safe.
    fn align_with_leg(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(route) = &self.route else { return };
        let heading_rad = route.leg_heading_rad();
        let off_rad = wrap_to_pi(heading_rad - self.pose.yaw_rad);
        let fresh = self.turn.is_none();
        let near = off_rad.abs() <= ALIGN_FROM_RAD && route.leg_is_entered_rolling();
        let no_room = fresh && !near && !self.turn_is_safe(off_rad);
        if fresh && (near || no_room) {
            self.set_aligned(no_room);
            return;
        }
        match self.turn_to(heading_rad, ALIGNED_RAD, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => self.set_aligned(false),
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    fn set_aligned(&mut self, no_room: bool) {
        if let Some(route) = &mut self.route {
            route.aligned = true;
            route.no_room = no_room;
        }
    }

    fn drive_leg(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let pose = self.pose_now(now);
        let settings = &self.config.settings;
        let delay_s = self.command_delay_s();
        let measured_mps = self.speed_mps().max(0.0);
        let narrow_mps = self.way_speed_mps(now);
        let at_m = self.along_now_m(now);
        let Some(route) = &mut self.route else { return };
        let way_m = measured_mps * (delay_s + settings.control_period_s);
        let end_m = route.course.leg(route.leg).to_m;
        let course_mps = route.course.speed_until_mps(at_m, (at_m + way_m).min(end_m));
        let goal_mps = braking_mps(
            route.goal_along_m - at_m - measured_mps * delay_s,
            settings.acceleration_mps2,
            settings.control_period_s,
        );
        let mut speed_mps = course_mps.min(goal_mps).min(narrow_mps);
        if route.no_room {
            speed_mps = speed_mps.min(NO_ROOM_MPS);
        }
        let speed_mps = speed_mps.max(SPEED_MIN_MPS.min(settings.speed_mps));
        let (leg, period) = (route.leg, self.config.period);
        let wheels = self.path_follower.step_on(&route.course, leg, pose, speed_mps, period);
        self.line_steering.error_m =
            self.path_follower.progress().map_or(0.0, |p| -p.cross_track_m);
        self.drive(wheels, now, commands);
    }

    /// Where the robot is on its leg, by its last report.
    fn locate_on_path(&mut self, now: Stamp) {
        let position = self.pose.position();
        let Some(route) = &mut self.route else { return };
        let leg = route.course.leg(route.leg);
        let (from_m, to_m) = (route.along_m - 0.5, route.along_m + 1.5);
        let (from_m, to_m) = (from_m.max(leg.from_m), to_m.min(leg.to_m).min(route.goal_along_m));
        let seen = route.course.path().project_within(position, from_m, to_m.max(from_m));
        route.along_m = seen.arc_length_m;
        let off_rad = wrap_to_pi(self.pose.yaw_rad - route.leg_heading_rad()).abs();
        if route.aligned && !route.no_room && off_rad > TURNED_AWAY_RAD {
            route.aligned = false;
        }
        self.show_preview(now);
    }

    /// The same at present: what it has driven since the report was true is added.
    fn along_now_m(&self, now: Stamp) -> f64 {
        let along_m = self.route.as_ref().map_or(0.0, |route| route.along_m);
        along_m + self.speed_mps().max(0.0) * self.report_age_s(now)
    }

    /// The preview begins where the robot is; a new point of it is progress.
    fn show_preview(&mut self, now: Stamp) {
        let Some(route) = &self.route else { return };
        let index = (route.along_m / route.preview_step_m) as usize;
        if index > self.preview_index {
            self.note_progress(now);
        }
        self.preview_index = index.min(self.preview.len().saturating_sub(1));
    }

    /// Whether the rest of the path is short, hardly leaves the straight line to the goal, and nothing was heard
    /// on that.
    fn rest_is_straight(&self, rest_m: f64) -> bool {
        let settings = &self.config.settings;
        let (Some(route), Some(goal)) = (&self.route, self.goal_point()) else { return false };
        let end = route.course.path().point_at(route.goal_along_m);
        let reach_m =
            if rest_m < 0.1 { settings.approach_from_trail_end_m } else { settings.approach_m };
        let way = goal - self.pose.position();
        if rest_m > settings.approach_m || !self.goal_is_straight_ahead(reach_m) {
            return false;
        }
        if rest_m < 0.1 || (goal - end).norm() > STRAIGHT_WITHIN_M {
            // Its end is beside the goal: first to its end.
            return rest_m < 0.1;
        }
        let length_m = way.norm().max(1e-6);
        let off_m = |point: Vec2| (way.perp(&(point - self.pose.position())) / length_m).abs();
        let along_m = |k: u32| route.along_m + rest_m * f64::from(k) / 8.0;
        (0..8).all(|k| off_m(route.course.path().point_at(along_m(k))) <= STRAIGHT_WITHIN_M)
    }
}

impl PathRoute {
    /// Whether this leg was entered without a corner: at the path's beginning or after an obstacle.
    fn leg_is_entered_rolling(&self) -> bool {
        self.along_m > self.course.leg(self.leg).from_m + 1e-9 || self.leg == 0
    }
}
