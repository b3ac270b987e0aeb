//! Figures of one robot, brought up to date every step from the truth.

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::Path;
use simulator::{Body, BodyId, World};

use super::sides::Sides;

/// Seconds per step.
const DT_S: f64 = 0.01;
/// Gravity, m/s².
const GRAVITY_MPS2: f64 = 9.81;
/// Rolling resistance of hard wheels on a floor: force over weight. A usual textbook value; it only
/// scales the energy figure.
const ROLLING_RATIO: f64 = 0.02;
/// Turn rates below this are no turning, rad/s; keeps encoder ripple out of the oscillation figure.
const TURN_DEADBAND_RADPS: f64 = 0.05;
/// The trail's projection is looked for this far around the last one, m.
const PROJECTION_WINDOW_M: f64 = 1.5;

/// The world measures no clearance beyond this, m: nothing is there.
const CLEARANCE_SEEN_MAX_M: f64 = 5.0;

/// How exact the least clearance is, m.
const CLEARANCE_EXACT_M: f64 = 0.005;

/// Running figures of one robot.
#[derive(Clone, Debug)]
pub(super) struct RobotMetrics {
    body: Option<BodyId>,
    trails: Vec<Path>,
    /// The path that it must drive before it counts as arrived.
    sides: Option<Sides>,
    start: Se2,
    last: Se2,
    along_trail_m: f64,
    pub(super) path_length_m: f64,
    pub(super) strayed_max_m: f64,
    /// Greatest way of any point of the robot, summed over the steps, m.
    moved_m: f64,
    clearance: Clearance,
    pub(super) contacts: u64,
    contacts_seen: u64,
    pub(super) cross_track_m: Option<f64>,
    cross_track_square_sum: f64,
    cross_track_max_m: f64,
    n_following: u64,
    turn_sign: f64,
    pub(super) n_turn_reversals: u64,
    turn_rate_square_sum: f64,
    n_steps_moving: u64,
    wheel_speeds: [f64; 2],
    /// Work of the wheels per mass, J/kg.
    pub(super) energy_jpkg: f64,
    goal_step: Option<u64>,
    pub(super) arrival_step: Option<u64>,
    /// The way driven when one of its lines was last cut, and when it was given its next order, m.
    cut_at_m: Option<f64>,
    sent_on_at_m: Option<f64>,
}

/// The distance to the nearest surface, measured only when it matters: between two measurements it can
/// have shrunk by no more than everything has moved.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_field_names, reason = "the common ending is the unit")]
struct Clearance {
    /// What was measured last, m.
    last_m: f64,
    /// What everything had moved by then, m.
    at_way_m: f64,
    /// The least so far, m.
    least_m: f64,
}

impl Default for Clearance {
    fn default() -> Self {
        Self { last_m: f64::NEG_INFINITY, at_way_m: 0.0, least_m: f64::INFINITY }
    }
}

impl RobotMetrics {
    /// A robot at `start`; `body` is `None` for one elsewhere, of which only its reports are known.
    pub(super) fn new(
        body: Option<BodyId>,
        start: Se2,
        trails: Vec<Path>,
        sides: Option<Sides>,
    ) -> Self {
        Self {
            body,
            trails,
            sides,
            start,
            last: start,
            along_trail_m: f64::NAN,
            path_length_m: 0.0,
            strayed_max_m: 0.0,
            moved_m: 0.0,
            clearance: Clearance::default(),
            contacts: 0,
            contacts_seen: 0,
            cross_track_m: None,
            cross_track_square_sum: 0.0,
            cross_track_max_m: 0.0,
            n_following: 0,
            turn_sign: 0.0,
            n_turn_reversals: 0,
            turn_rate_square_sum: 0.0,
            n_steps_moving: 0,
            wheel_speeds: [0.0; 2],
            energy_jpkg: 0.0,
            goal_step: None,
            arrival_step: None,
            cut_at_m: None,
            sent_on_at_m: None,
        }
    }

    /// Measures the clearance if it could be less than the least so far, which needs what everything
    /// else has moved: the sum of the greatest ways of anything else in every step, m.
    pub(super) fn measure_clearance(&mut self, world: &World, others_moved_m: f64) {
        let Some(id) = self.body else { return };
        let moved_m = self.moved_m + others_moved_m;
        let bound_m = self.clearance.last_m - (moved_m - self.clearance.at_way_m);
        if bound_m < self.clearance.least_m - CLEARANCE_EXACT_M {
            let last_m = world.clearance_m(id);
            let least_m = self.clearance.least_m.min(last_m);
            self.clearance = Clearance { last_m, at_way_m: moved_m, least_m };
        }
    }

    /// Something was put down: the last clearance says nothing any more.
    pub(super) fn forget_clearance(&mut self) {
        self.clearance.last_m = f64::NEG_INFINITY;
    }

    /// Least clearance so far, m; infinite before it was measured, and 5 where nothing was nearer.
    pub(super) fn clearance_min_m(&self) -> f64 {
        self.clearance.least_m
    }

    /// The same as a figure; `None` where nothing was within the 5 m that are looked at.
    pub(super) fn clearance_seen_m(&self) -> Option<f64> {
        Some(self.clearance.least_m).filter(|&least_m| least_m < CLEARANCE_SEEN_MAX_M)
    }

    /// Takes the truth after a step; `following`: the robot is on a trail on purpose. Returns the way
    /// of the point of the robot that moved farthest, at most, m.
    pub(super) fn update(&mut self, body: &Body, following: bool) -> f64 {
        let pose = body.world_from_base.se2();
        let turned_rad = wrap_to_pi(pose.yaw_rad - self.last.yaw_rad).abs();
        let way_m = (pose.position() - self.last.position()).norm()
            + turned_rad * body.model.bounding_radius_m();
        self.moved_m += way_m;
        self.moving_on(pose.position());
        self.contacts = body.contacts;
        self.turning(wrap_to_pi(pose.yaw_rad - self.last.yaw_rad) / DT_S);
        self.working([body.wheel_speeds.left_mps, body.wheel_speeds.right_mps]);
        self.tracking(pose.position(), following);
        self.last = pose;
        way_m
    }

    /// The same for a robot elsewhere, from what it believes; contacts and clearance stay unknown.
    pub(super) fn update_reported(&mut self, pose: Se2, following: bool) {
        self.moving_on(pose.position());
        self.tracking(pose.position(), following);
        self.last = pose;
    }

    /// Whether it was given a goal.
    pub(super) fn has_goal(&self) -> bool {
        self.goal_step.is_some()
    }

    /// Whether what the robot touches is known: it is simulated here.
    pub(super) fn is_simulated(&self) -> bool {
        self.body.is_some()
    }

    fn moving_on(&mut self, to: Vec2) {
        let step_m = (to - self.last.position()).norm();
        self.path_length_m += step_m;
        self.strayed_max_m = self.strayed_max_m.max((to - self.start.position()).norm());
        if let Some(sides) = &mut self.sides {
            sides.step(to, step_m);
        }
    }

    fn turning(&mut self, rate_radps: f64) {
        if self.wheel_speeds.iter().any(|v| v.abs() > 0.01) {
            self.n_steps_moving += 1;
            self.turn_rate_square_sum += rate_radps * rate_radps;
        }
        if rate_radps.abs() > TURN_DEADBAND_RADPS {
            let sign = rate_radps.signum();
            if self.turn_sign * sign < 0.0 {
                self.n_turn_reversals += 1;
            }
            self.turn_sign = sign;
        }
    }

    fn working(&mut self, wheel_speeds: [f64; 2]) {
        for (before, &after) in self.wheel_speeds.iter().zip(&wheel_speeds) {
            // Each wheel carries half the mass; braking gives nothing back.
            let kinetic = 0.5 * (after * after - before * before);
            let rolling = ROLLING_RATIO * GRAVITY_MPS2 * after.abs() * DT_S;
            self.energy_jpkg += 0.5 * (kinetic.max(0.0) + rolling);
        }
        self.wheel_speeds = wheel_speeds;
    }

    fn tracking(&mut self, at: Vec2, following: bool) {
        let s = self.along_trail_m;
        let projection = match &self.trails[..] {
            // Near the last projection, so that a trail that comes near itself is not mixed up.
            [trail] if s.is_finite() => {
                trail.project_within(at, s - PROJECTION_WINDOW_M, s + PROJECTION_WINDOW_M)
            }
            // Of a network the nearest trail counts, whichever the robot means to follow.
            trails => {
                let all = trails.iter().map(|trail| trail.project(at));
                let nearest =
                    all.min_by(|a, b| a.cross_track_m.abs().total_cmp(&b.cross_track_m.abs()));
                let Some(nearest) = nearest else { return };
                nearest
            }
        };
        self.along_trail_m = projection.arc_length_m;
        let e = projection.cross_track_m;
        self.cross_track_m = Some(e);
        if following {
            self.n_following += 1;
            self.cross_track_square_sum += e * e;
            self.cross_track_max_m = self.cross_track_max_m.max(e.abs());
        }
    }

    /// The true pose after the last step; of a robot elsewhere, the reported one.
    pub(super) fn pose(&self) -> Se2 {
        self.last
    }

    /// A goal was given, or the robot is driven by hand: time and way count from here.
    pub(super) fn goal_given(&mut self, step: u64, goal: Option<Se2>) {
        self.goal_step = Some(step);
        self.arrival_step = None;
        self.sent_on_at_m.get_or_insert(self.path_length_m);
        if let (Some(sides), Some(goal)) = (&mut self.sides, goal) {
            sides.begin(self.last.position(), goal.position());
        }
    }

    /// One of its lines was cut.
    pub(super) fn line_cut(&mut self) {
        self.cut_at_m = Some(self.path_length_m);
        self.sent_on_at_m = None;
    }

    /// The way driven since one of its lines was last cut, until its next order, m; `None` if none was.
    pub(super) fn way_since_cut_m(&self) -> Option<f64> {
        let until_m = self.sent_on_at_m.unwrap_or(self.path_length_m);
        self.cut_at_m.map(|cut_at_m| until_m - cut_at_m)
    }

    /// The path that it must drive to its goal, if it was given one.
    pub(super) fn sides(&self) -> Option<&Sides> {
        self.sides.as_ref()
    }

    /// Whether the robot stands at its goal.
    pub(super) fn arrival(&mut self, arrived: bool, step: u64) {
        if arrived && self.goal_step.is_some() && self.arrival_step.is_none() {
            self.arrival_step = Some(step);
        }
    }

    /// Whether a contact came since the last call.
    pub(super) fn take_new_contact(&mut self) -> bool {
        let is_new = self.contacts > self.contacts_seen;
        self.contacts_seen = self.contacts;
        is_new
    }

    /// From the last goal to the arrival, or until now, s.
    pub(super) fn under_way_s(&self, step: u64) -> f64 {
        let end = self.arrival_step.unwrap_or(step);
        self.goal_step.map_or(0.0, |begin| end.saturating_sub(begin) as f64 * DT_S)
    }

    /// From the last goal to the arrival, s; `None` without an arrival.
    pub(super) fn drive_time_s(&self) -> Option<f64> {
        self.arrival_step.map(|step| self.under_way_s(step))
    }

    /// Root mean square distance from the trail while following it, m.
    pub(super) fn cross_track_rms_m(&self) -> Option<f64> {
        (self.n_following > 0)
            .then(|| (self.cross_track_square_sum / self.n_following as f64).sqrt())
    }

    /// Greatest distance from the trail while following it, m.
    pub(super) fn cross_track_max_m(&self) -> Option<f64> {
        (self.n_following > 0).then_some(self.cross_track_max_m)
    }

    /// Root mean square turn rate while moving, rad/s.
    pub(super) fn turn_rate_rms_radps(&self) -> Option<f64> {
        let n = self.n_steps_moving;
        (n > 0).then(|| (self.turn_rate_square_sum / n as f64).sqrt())
    }
}
