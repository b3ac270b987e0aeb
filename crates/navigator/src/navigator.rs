//! The navigator itself: what it remembers, how it takes in observations, and its phases' order.

use geometry::{Base, Map, Odom, Se2, Transform2, Vec2, wrap_to_pi};
use messages::{
    BaseState, Command, FailureReason, LinkState, N_RING_MAX, Observation, Observations,
    OdometryReading, Order, Report, Ring, Sensed, Smell,
};
use obstacle_avoidance::{EchoMemory, Machine, State};
use path_following::{Path, PathFollower, WheelReference};
use robot_models::PoseCovariance;
use run_context::Stamp;

use crate::{
    ahead::Hazard,
    along_path::PathRoute,
    arrive::{Homing, Turn},
    avoid::Bypass,
    config::{Avoidance, Method, NavigatorConfig},
    guard::Guard,
    inquiry::{Asker, Inquiry},
    scout::Scout,
    speed::Stillness,
    steer::{LineSteering, Sight, TrailSteering, to_wheels},
    tag_fix::TagFix,
    tags::TagTrail,
    trail::PREVIEW_STEP_M,
    view::{NavigatorView, Phase},
};

/// Standard deviations that hold a position in the plane with 95 %.
const ELLIPSE_N_SIGMA: f64 = 2.45;

/// Slowest speed at which a robot is sent anywhere, metres per second.
pub(crate) const SPEED_MIN_MPS: f64 = 0.08;

/// One robot's mind; see the crate.
#[derive(Clone, Debug)]
pub struct Navigator {
    pub(crate) config: NavigatorConfig,
    pub(crate) map_from_odom: Transform2<Map, Odom>,
    /// The latest of what the robot's devices said.
    pub(crate) base: BaseState,
    /// When its wheels were last heard of.
    pub(crate) base_at: Stamp,
    pub(crate) stillness: Stillness,
    link_up: bool,
    /// Its wheels were heard of.
    pub(crate) is_heard: bool,
    pub(crate) pose: Se2,
    pub(crate) covariance: PoseCovariance,
    pub(crate) echoes: EchoMemory,
    pub(crate) machine: Machine,
    pub(crate) bypass: Bypass,
    guard: Guard,
    pub(crate) inquiry: Inquiry,
    pub(crate) scout: Scout,
    pub(crate) trail_steering: TrailSteering,
    pub(crate) line_steering: LineSteering,
    pub(crate) tags: TagTrail,
    pub(crate) tag_fix: TagFix,
    pub(crate) phase: Phase,
    pub(crate) phase_since: Stamp,
    pub(crate) goal: Option<Transform2<Map, Base>>,
    /// Intermediate goals of the direct method and how many are behind.
    via: Vec<Vec2>,
    n_via_done: usize,
    /// The given path of the path method.
    pub(crate) route: Option<PathRoute>,
    pub(crate) path_follower: PathFollower,
    /// The path ahead: where the trail runs, or the given path.
    pub(crate) preview: Vec<Vec2>,
    /// Whether the antennas smell more than one trail there, point by point; may be shorter.
    pub(crate) preview_is_mixed: Vec<bool>,
    pub(crate) preview_index: usize,
    pub(crate) turn: Option<Turn>,
    pub(crate) homing: Homing,
    pub(crate) next_control: Stamp,
    task_since: Stamp,
    progress_at: Stamp,
    nearest_m: f64,
    pub(crate) own_wanted: bool,
    pub(crate) intensities: Option<(f64, f64)>,
    pub(crate) last_own_at: Stamp,
    pub(crate) lost_from: Option<Vec2>,
    /// Where the antennas ceased to smell anything, on the preview.
    pub(crate) gap_from: Option<Vec2>,
    pub(crate) n_aims: u32,
    pub(crate) motion: WheelReference,
    pub(crate) line_from: Vec2,
    pub(crate) n_approach_aims: u32,
    shown_state: u8,
    /// How far the robot came straight forward to where it is: so far it may back off blindly.
    pub(crate) straight_m: f64,
    straight_yaw_rad: f64,
    straight_from: Vec2,
    /// The way driven since the navigator began, metres.
    pub(crate) driven_m: f64,
    /// A turn in an arc that is under way: its heading (rad, map) and since when.
    pub(crate) curve: Option<(f64, Stamp)>,
}

impl Navigator {
    /// A navigator without a goal, on a robot whose dead reckoning begins at `map_from_odom`.
    pub fn new(config: NavigatorConfig, map_from_odom: Transform2<Map, Odom>) -> Self {
        let settings = &config.settings;
        let parts = config.parts.clone();
        Self {
            map_from_odom,
            base: BaseState::default(),
            base_at: Stamp::ZERO,
            stillness: Stillness::default(),
            link_up: true,
            is_heard: false,
            pose: map_from_odom.se2(),
            covariance: PoseCovariance::zero(),
            echoes: EchoMemory::new(settings.echoes),
            machine: parts.machine,
            bypass: Bypass::default(),
            guard: parts.guard,
            inquiry: Inquiry::default(),
            scout: Scout::new().with_room(),
            trail_steering: parts.trail_steering,
            line_steering: parts.line_steering,
            tags: parts.tags,
            tag_fix: TagFix::new(),
            phase: Phase::Idle,
            phase_since: Stamp::ZERO,
            goal: None,
            via: Vec::new(),
            n_via_done: 0,
            route: None,
            path_follower: parts.path_follower,
            preview: Vec::with_capacity(1024),
            preview_is_mixed: Vec::with_capacity(1024),
            preview_index: 0,
            turn: None,
            homing: Homing::default(),
            next_control: Stamp::ZERO,
            task_since: Stamp::ZERO,
            progress_at: Stamp::ZERO,
            nearest_m: f64::INFINITY,
            own_wanted: false,
            intensities: None,
            last_own_at: Stamp::ZERO,
            lost_from: None,
            gap_from: None,
            n_aims: 0,
            motion: WheelReference::STOP,
            line_from: Vec2::zeros(),
            n_approach_aims: 0,
            shown_state: 0,
            straight_m: 0.0,
            straight_yaw_rad: map_from_odom.se2().yaw_rad,
            straight_from: map_from_odom.se2().position(),
            driven_m: 0.0,
            curve: None,
            config,
        }
    }

    /// Intermediate goals (m, map) that the direct method visits before every goal, in order.
    pub fn set_intermediate_goals(&mut self, via_in_map: Vec<Vec2>) {
        self.via = via_in_map;
    }

    /// The path (m, map) that the path method follows to its goal, from start to goal.
    pub fn set_path(&mut self, path_in_map: Path) {
        let route = PathRoute::new(path_in_map, &self.config.settings);
        self.preview.reserve(route.n_preview_points());
        self.route = Some(route);
    }

    /// Takes in what was observed and appends what shall be done.
    ///
    /// `now` never decreases. Calls every 10 ms make it react fastest; control runs in its own
    /// period whatever the calls' rate. Reports and commands are in the order of their causes. No
    /// allocation once `commands` and the navigator have run a while.
    pub fn step(&mut self, now: Stamp, observations: &Observations, commands: &mut Vec<Command>) {
        let mut has_sensed = false;
        for observation in observations {
            has_sensed |= self.observe(now, observation, commands);
        }
        if has_sensed {
            self.react(now, commands);
        }
        if now >= self.next_control {
            self.next_control = self.next_control.max(now) + self.config.period;
            self.control(now, commands);
        }
        self.pump_questions(now, commands);
        self.show_state(commands);
    }

    /// What it is busy with.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Everything worth showing.
    pub fn view(&self) -> NavigatorView<'_> {
        let mut bubble_limits_m = [0.0; N_RING_MAX];
        let settings = &self.config.settings;
        let speed_mps = self.speed_mps().abs().max(0.5 * settings.speed_mps);
        self.config.bubble.limits(speed_mps, settings.control_period_s, &mut bubble_limits_m);
        let preview_from = self.preview_index.min(self.preview.len());
        let n_shown = (settings.preview_m / PREVIEW_STEP_M) as usize + 1;
        let preview_to = (preview_from + n_shown).min(self.preview.len());
        let on_trail = matches!(self.phase, Phase::FollowTrail | Phase::LostTrail);
        let trail_error = self.intensities.map_or(0.0, |(left, right)| left - right);
        NavigatorView {
            phase: self.phase,
            avoider_state: self.machine.state().byte(),
            avoider_name: self.machine.state().name(),
            map_from_base: Transform2::new(self.pose),
            ellipse: self.covariance.ellipse(ELLIPSE_N_SIGMA),
            goal_in_map: self.goal,
            target_in_map: self.target(),
            preview_in_map: &self.preview[preview_from..preview_to],
            scouting: self.scout.figures(),
            way_ahead_m: self.preview_ahead_m(),
            intensities: self.intensities,
            bubble_limits_m,
            n_sonars: self.base.ring.map_or(0, |ring| ring.n_sensors),
            follower_error: if on_trail { trail_error } else { self.line_steering.error_m },
            rebound_rad: self.machine.rebound_rad(),
            n_echoes: self.echoes.len(),
            n_attempts: self.machine.n_rebounds() + self.bypass.n_retreats,
        }
    }

    /// Replaces the place of the robot's dead reckoning in the map, as a localiser found it.
    pub fn set_map_from_odom(&mut self, map_from_odom: Transform2<Map, Odom>) {
        self.map_from_odom = map_from_odom;
        if let Some(odometry) = self.base.odometry {
            self.pose = (map_from_odom * odometry.odom_from_base).se2();
        }
        // What was remembered in the map is in the wrong place now.
        self.echoes.clear();
        self.tag_fix.clear();
    }

    /// Whether it was about the robot and what is around it.
    fn observe(
        &mut self,
        now: Stamp,
        observation: &Observation,
        commands: &mut Vec<Command>,
    ) -> bool {
        let about = observation.about;
        self.base.take(observation);
        match &observation.value {
            Sensed::Odometry(odometry) => self.observe_odometry(now, about, odometry),
            Sensed::Ring(ring) => self.observe_ring(about, ring),
            Sensed::Contact(_) | Sensed::Scan(_) => {}
            Sensed::Motors(_) | Sensed::Battery(_) => return false,
            Sensed::Smell(Smell { query, left, right }) => {
                let intensities = (left.max(0.0), right.max(0.0));
                match self.inquiry.answer(*query) {
                    Some(Asker::Own) => self.follow_trail_step(now, intensities, commands),
                    Some(Asker::Scout) => self.scout_step(now, intensities),
                    None => {}
                }
                return false;
            }
            Sensed::Tag(read) => {
                self.take_tag(now, read);
                return false;
            }
            Sensed::Order(order) => {
                self.obey(now, *order, commands);
                return false;
            }
            Sensed::Link(state) => {
                self.link_up = *state == LinkState::Up;
                return false;
            }
        }
        true
    }

    fn observe_odometry(&mut self, now: Stamp, about: Stamp, odometry: &OdometryReading) {
        let pose = (self.map_from_odom * odometry.odom_from_base).se2();
        let settings = &self.config.settings;
        if self.is_heard {
            self.tags.roll(self.pose, pose);
            let moved = self.pose.inverse().compose(pose).log();
            self.driven_m += moved.dx_m.abs();
            let half_turn_m = 0.5 * moved.dyaw_rad * settings.drive.wheelbase_m;
            self.covariance = self.covariance.propagated(
                self.pose.yaw_rad,
                moved.dx_m - half_turn_m,
                moved.dx_m + half_turn_m,
                &settings.drive,
                &settings.odometry_noise,
            );
        }
        self.pose = pose;
        self.is_heard = true;
        self.base_at = now;
        self.stillness.note(about, odometry.wheel_speeds);
        self.link_up = true;
        self.note_straight_way(pose);
    }

    fn observe_ring(&mut self, about: Stamp, ring: &Ring) {
        let sensors = &self.config.settings.sensors;
        let fresh = u32::from(ring.fresh);
        self.echoes.observe(about, self.pose, sensors, ring.ranges_m(), fresh);
    }

    /// Between two control steps only the brake reacts; the phases find out why at the next.
    fn react(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.echoes.forget_inside(self.pose, &self.config.footprint, 0.02);
        if self.motion.linear_mps() > 0.0 && self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
        }
        self.brake_at_goal(now, commands);
    }

    /// `pose` is new, `self.pose` as well; the way since the last status is in the wheels' speeds.
    fn note_straight_way(&mut self, pose: Se2) {
        if wrap_to_pi(pose.yaw_rad - self.straight_yaw_rad).abs() > 0.12 {
            self.straight_yaw_rad = pose.yaw_rad;
            self.straight_from = pose.position();
        }
        let way = pose.position() - self.straight_from;
        self.straight_m = way.dot(&pose.heading()).max(0.0);
    }

    fn obey(&mut self, now: Stamp, order: Order, commands: &mut Vec<Command>) {
        match order {
            Order::GoTo { goal_in_map } => self.go_to(now, goal_in_map, commands),
            Order::Stop => {
                self.forget_task(now);
                self.stop_wheels(commands);
                self.enter(Phase::Idle, now);
            }
            Order::Restart => {
                self.forget_task(now);
                self.echoes.clear();
                self.stop_wheels(commands);
                commands.push(Command::EnableMotors(true));
                commands.push(Command::Report(Report::StateEntered(0)));
                self.enter(Phase::Idle, now);
            }
            Order::ReportSonar => {
                let mut ranges_m = [self.config.settings.range_max_m; 8];
                let known = self.base.ranges_m();
                let known = &known[..known.len().min(8)];
                ranges_m[..known.len()].copy_from_slice(known);
                commands.push(Command::Report(Report::Sonar(ranges_m)));
            }
            Order::LinkTest => commands.push(Command::Report(Report::LinkEcho)),
        }
    }

    fn go_to(&mut self, now: Stamp, goal: Transform2<Map, Base>, commands: &mut Vec<Command>) {
        self.forget_task(now);
        self.stop_wheels(commands);
        let pose = goal.se2();
        if !(pose.x_m.is_finite() && pose.y_m.is_finite() && pose.yaw_rad.is_finite()) {
            self.fail(FailureReason::BadGoal, now, commands);
            return;
        }
        if self.base.motors.is_some_and(|motors| !motors.enabled) {
            commands.push(Command::EnableMotors(true));
        }
        self.goal = Some(goal);
        self.task_since = now;
        self.note_progress(now);
        self.next_control = now;
        match self.config.settings.method {
            Method::Trail => self.aim_at_trail(now),
            Method::Direct => {
                let target = self.via.first().copied().unwrap_or(pose.position());
                self.drive_to(target, now);
            }
            Method::Path => self.begin_path(now, commands),
            Method::Tags => self.begin_tags(now, commands),
        }
    }

    /// One control period.
    fn control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if matches!(self.phase, Phase::Idle | Phase::Arrived | Phase::Failed(_)) {
            return;
        }
        if let Some(reason) = self.limit_reached(now) {
            self.fail(reason, now, commands);
            return;
        }
        if !self.is_heard {
            return;
        }
        self.watch_progress(now);
        if self.tags_control(now, commands) {
            return;
        }
        match self.phase {
            Phase::AimAtTrail => self.aim_step(now, commands),
            Phase::FollowTrail => self.follow_control(now, commands),
            Phase::LostTrail => self.lost_control(now, commands),
            Phase::Wait => self.wait_step(now, commands),
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.machine_step(now, commands),
            Phase::Approach => self.approach_step(now, commands),
            Phase::AlignHeading => self.align_step(now, commands),
            Phase::Idle | Phase::Arrived | Phase::Failed(_) => {}
        }
    }

    fn limit_reached(&self, now: Stamp) -> Option<FailureReason> {
        let settings = &self.config.settings;
        let over = |since: Stamp, limit_s: f64| now.since(since).as_secs_f64() > limit_s;
        let silent_s = self.inquiry.silence(now).as_secs_f64();
        if over(self.base_at.max(self.task_since), settings.link_limit_s) || !self.link_up {
            Some(FailureReason::LinkLost)
        } else if over(self.task_since, settings.task_limit_s) {
            Some(FailureReason::TimedOut)
        } else if over(self.progress_at, settings.progress_limit_s) {
            Some(FailureReason::NoProgress)
        } else if silent_s > settings.server_limit_s {
            Some(FailureReason::ServerSilent)
        } else {
            None
        }
    }

    fn watch_progress(&mut self, now: Stamp) {
        let Some(goal) = self.goal else { return };
        let distance_m = (goal.se2().position() - self.pose.position()).norm();
        if distance_m < self.nearest_m - 0.25 {
            self.nearest_m = distance_m;
            self.note_progress(now);
        }
    }

    pub(crate) fn note_progress(&mut self, now: Stamp) {
        self.progress_at = now;
    }

    /// Turns the wheels so, or more slowly on the same arc where what was heard is too near for that.
    pub(crate) fn drive(
        &mut self,
        wheels: WheelReference,
        now: Stamp,
        commands: &mut Vec<Command>,
    ) {
        let settings = &self.config.settings;
        let wheels = if settings.avoidance == Avoidance::Checked && settings.watchdog_s > 0.0 {
            self.guard.slowed(wheels, self.pose_at_command(now), &self.echoes)
        } else {
            wheels
        };
        self.motion = wheels;
        commands.push(Command::Drive(to_wheels(wheels)));
    }

    pub(crate) fn stop_wheels(&mut self, commands: &mut Vec<Command>) {
        self.motion = WheelReference::STOP;
        commands.push(Command::Stop);
    }

    pub(crate) fn enter(&mut self, phase: Phase, now: Stamp) {
        if phase == Phase::Approach && self.phase != Phase::Approach {
            self.line_from = self.pose.position();
            self.homing.restart();
        }
        if phase != self.phase {
            self.turn = None;
        }
        // Only these phases go on asking; elsewhere an answer that was lost must not count as silence.
        if !matches!(phase, Phase::AimAtTrail | Phase::FollowTrail | Phase::LostTrail) {
            self.inquiry.cancel();
        }
        self.phase = phase;
        self.phase_since = now;
        self.own_wanted = false;
    }

    pub(crate) fn fail(&mut self, reason: FailureReason, now: Stamp, commands: &mut Vec<Command>) {
        let goal = self.goal;
        self.forget_task(now);
        self.goal = goal;
        self.stop_wheels(commands);
        self.enter(Phase::Failed(reason), now);
        commands.push(Command::Report(Report::Failed(reason)));
    }

    pub(crate) fn forget_task(&mut self, now: Stamp) {
        self.goal = None;
        self.machine.stop(now);
        self.bypass = Bypass::default();
        self.inquiry.cancel();
        self.forget_preview();
        self.turn = None;
        self.curve = None;
        self.own_wanted = false;
        self.lost_from = None;
        self.gap_from = None;
        self.n_aims = 0;
        self.n_via_done = 0;
        self.n_approach_aims = 0;
        self.homing = Homing::default();
        self.nearest_m = f64::INFINITY;
        self.trail_steering.forget();
    }

    /// The direct method: the machine reached what it was sent to.
    pub(crate) fn target_reached(&mut self, now: Stamp) {
        self.n_via_done += 1;
        let next = self.via.get(self.n_via_done).copied();
        match (next, self.goal_point()) {
            (Some(via), _) => self.drive_to(via, now),
            (None, Some(goal)) if self.n_via_done == self.via.len() => self.drive_to(goal, now),
            _ => self.enter(Phase::Approach, now),
        }
        self.note_progress(now);
        self.nearest_m = f64::INFINITY;
    }

    fn drive_to(&mut self, target: Vec2, now: Stamp) {
        self.machine.set_target(target, now);
        self.enter(Phase::DriveToTarget, now);
    }

    pub(crate) fn goal_point(&self) -> Option<Vec2> {
        self.goal.map(|goal| goal.se2().position())
    }

    /// What is known of where the robot is.
    pub(crate) fn sight(&self) -> Sight {
        Sight { pose: self.pose, about: self.base.about }
    }

    /// Measured speed over ground, metres per second.
    pub(crate) fn speed_mps(&self) -> f64 {
        let wheels = self.base.wheel_speeds();
        0.5 * (wheels.left_mps + wheels.right_mps)
    }

    fn target(&self) -> Option<Vec2> {
        match self.phase {
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.machine.target(),
            Phase::Approach | Phase::AlignHeading => self.goal_point(),
            _ => None,
        }
    }

    /// On a trail the machine is idle; what the robot does has the same names.
    fn show_state(&mut self, commands: &mut Vec<Command>) {
        let state = match self.phase {
            Phase::AimAtTrail => State::Aim,
            Phase::FollowTrail | Phase::LostTrail | Phase::Approach if self.turn.is_some() => {
                State::Rotate
            }
            Phase::FollowTrail | Phase::LostTrail | Phase::Approach => State::Control,
            Phase::AlignHeading => State::Rotate,
            Phase::Wait => State::Supervise,
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => {
                // The machine reports for itself.
                self.shown_state = self.machine.state().byte();
                return;
            }
            Phase::Idle | Phase::Arrived | Phase::Failed(_) => State::Idle,
        };
        if state.byte() != self.shown_state {
            self.shown_state = state.byte();
            commands.push(Command::Report(Report::StateEntered(state.byte())));
        }
    }
}
