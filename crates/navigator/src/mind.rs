//! The mind itself: the order in which its parts are asked, and the phase for people. What it knows, a part knows.

mod steps;

use std::time::Duration;

use geometry::{Base, Map, Odom, Transform2, Vec2};
use localisation::ParticleFilter;
use messages::{
    Command, FailureReason, LinkState, Observation, Observations, Order, Report, Scan, Sensed,
    Smell,
};
use obstacle_avoidance::State;
use path_following::{Path, WheelReference};
use path_planning::MapPlanner;
use run_context::Stamp;
use sensor_models::ScanBeam;

use crate::{
    around::{Surroundings, Sweep},
    config::{NavigatorConfig, Parts},
    follow::Follow,
    guard::{Guard, Scene},
    health::Health,
    how::Route,
    phase::Phase,
    says::Says,
    values::{PoseHealth, Situation, Way},
    view::NavigatorView,
    where_am_i::Locator,
    where_to::Task,
};

/// Standard deviations that hold a position in the plane with 95 %.
const ELLIPSE_N_SIGMA: f64 = 2.45;

/// One robot's mind; see the crate.
#[derive(Clone, Debug)]
pub struct Navigator {
    config: NavigatorConfig,
    locator: Locator,
    around: Surroundings,
    task: Task,
    route: Route,
    follow: Follow,
    guard: Guard,
    health: Health,
    phase: Phase,
    phase_since: Stamp,
    /// The phase in which it ceased to see.
    blind_in: Phase,
    next_control: Stamp,
    shown_state: u8,
}

impl Navigator {
    /// A navigator without a goal, on a robot whose dead reckoning begins at `map_from_odom`.
    pub fn new(config: NavigatorConfig, map_from_odom: Transform2<Map, Odom>) -> Self {
        let Parts { mut locator, around, task, route, follow, guard, health } = config.parts();
        locator.begin(map_from_odom);
        Self {
            config,
            locator,
            around,
            task,
            route,
            follow,
            guard,
            health,
            phase: Phase::Idle,
            phase_since: Stamp::ZERO,
            blind_in: Phase::Idle,
            next_control: Stamp::ZERO,
            shown_state: 0,
        }
    }

    /// Intermediate goals (m, map) that the direct method visits before every goal, in order.
    pub fn set_intermediate_goals(&mut self, via_in_map: Vec<Vec2>) {
        self.task.set_via(via_in_map);
    }

    /// The path (m, map) that the path method follows to its goal, from start to goal.
    pub fn set_path(&mut self, path_in_map: Path) {
        self.route.set_path(path_in_map, self.config.settings());
    }

    /// The map that the planning method finds its ways on.
    pub fn set_map(&mut self, map: MapPlanner) {
        self.route.set_map(map, self.config.settings());
    }

    /// The particles that say where the robot is, where that is the method.
    pub fn set_particles(&mut self, filter: ParticleFilter) {
        self.locator.set_particles(filter, &self.config.settings().lasers);
    }

    /// Replaces the place of the robot's dead reckoning in the map, as a localiser found it.
    pub fn set_map_from_odom(&mut self, map_from_odom: Transform2<Map, Odom>) {
        self.locator.relocate(map_from_odom);
        // What was remembered in the map is in the wrong place now.
        self.around.forget();
    }

    /// Takes in what was observed and appends what shall be done.
    ///
    /// `now` never decreases. Calls every 10 ms make it react fastest; control runs in its own
    /// period whatever the calls' rate. Reports and commands are in the order of their causes. No
    /// allocation once `commands` and the navigator have run a while.
    pub fn step(&mut self, now: Stamp, observations: &Observations, commands: &mut Vec<Command>) {
        let mut has_sensed = false;
        for observation in observations {
            has_sensed |= self.observe(now, observation, observations, commands);
        }
        if has_sensed {
            self.react(now, commands);
        }
        if now >= self.next_control {
            self.next_control = self.next_control.max(now) + self.period();
            self.control(now, commands);
        }
        self.ask(now, commands);
        self.show_state(commands);
    }

    /// What it is busy with.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    fn period(&self) -> Duration {
        self.config.period()
    }

    /// Whether it was about the robot and what is around it.
    fn observe(
        &mut self,
        now: Stamp,
        observation: &Observation,
        all: &Observations,
        commands: &mut Vec<Command>,
    ) -> bool {
        let about = observation.about;
        match &observation.value {
            Sensed::Odometry(odometry) => {
                if let Some((from, to)) = self.locator.take_odometry(now, about, odometry) {
                    self.route.roll(from, to);
                }
                self.health.take_link(LinkState::Up);
            }
            Sensed::Ring(ring) => {
                self.around.take_ring(about, self.locator.estimate().pose, ring);
            }
            Sensed::Contact(contacts) => self.around.take_contacts(about, *contacts),
            Sensed::Scan(scan) => {
                return self.take_scan(now, observation, scan, all.beams(scan));
            }
            Sensed::Battery(_) => return false,
            Sensed::Motors(motors) => {
                self.health.take_motors(*motors);
                return false;
            }
            Sensed::Smell(smell) => {
                self.take_smell(now, *smell, commands);
                return false;
            }
            Sensed::Tag(read) => {
                self.route.take_tag(self.locator.estimate().pose_now(now), read);
                if self.locator.take_tag(now, read) {
                    self.around.forget();
                }
                return false;
            }
            Sensed::Order(order) => {
                self.obey(now, *order, commands);
                return false;
            }
            Sensed::Link(state) => {
                self.health.take_link(*state);
                return false;
            }
        }
        true
    }

    /// Takes a scan; whether it is of one of the robot's lasers, and so young that it is known where the robot was.
    fn take_scan(
        &mut self,
        now: Stamp,
        observation: &Observation,
        scan: &Scan,
        beams: &[ScanBeam],
    ) -> bool {
        let time = |beam: Option<&ScanBeam>| {
            let after_s = beam.map_or(0.0, |beam| beam.after_s.max(0.0));
            observation.about + Duration::from_secs_f64(after_s)
        };
        let (Some(first), Some(last)) =
            (self.locator.pose_at(time(beams.first())), self.locator.pose_at(time(beams.last())))
        else {
            return false;
        };
        let (from, range_max_m) = (observation.from, scan.range_max_m);
        let sweep = Sweep { from, beams, range_max_m, first, last };
        let has_seen = self.around.take_scan(now, &sweep);
        if self.locator.take_scan(&sweep) {
            self.around.forget();
        }
        has_seen
    }

    fn take_smell(&mut self, now: Stamp, smell: Smell, commands: &mut Vec<Command>) {
        let intensities = (smell.left.max(0.0), smell.right.max(0.0));
        let aims = self.phase == Phase::AimAtTrail;
        let (is_own, is_progress) = self.route.take_answer(now, smell.query, intensities, aims);
        if is_progress {
            self.task.note_progress(now);
        }
        if is_own {
            self.follow_scent(now, intensities, commands);
        }
    }

    /// Between two control steps only the brake reacts; the phases find out why at the next.
    fn react(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        self.around.stand_at(situation.at.pose);
        let told = self.guard.told();
        let ahead = told.linear_mps() > 0.0 && self.is_blocked(&situation);
        if ahead || told != WheelReference::STOP && self.around.is_blind(now) {
            self.guard.stop(commands);
        }
        if self.phase == Phase::Approach
            && let Some(motion) = self.follow.brake_at_goal(&self.situation(now))
        {
            self.guard.pass(motion, &situation, &self.around, commands);
        }
    }

    fn obey(&mut self, now: Stamp, order: Order, commands: &mut Vec<Command>) {
        match order {
            Order::GoTo { goal_in_map } => self.go_to(now, goal_in_map, commands),
            Order::Stop => {
                self.forget_task(now);
                self.guard.stop(commands);
                self.enter(Phase::Idle, now);
            }
            Order::Restart => {
                self.forget_task(now);
                self.around.forget();
                self.guard.stop(commands);
                commands.push(Command::EnableMotors(true));
                commands.push(Command::Report(Report::StateEntered(0)));
                self.enter(Phase::Idle, now);
            }
            Order::ReportSonar => {
                commands.push(Command::Report(Report::Sonar(self.around.reported_ranges_m())));
            }
            Order::LinkTest => commands.push(Command::Report(Report::LinkEcho)),
        }
    }

    fn go_to(&mut self, now: Stamp, goal: Transform2<Map, Base>, commands: &mut Vec<Command>) {
        self.forget_task(now);
        self.guard.stop(commands);
        if !self.task.begin(now, goal) {
            self.fail(FailureReason::BadGoal, now, commands);
            return;
        }
        if self.health.motors_are_off() {
            commands.push(Command::EnableMotors(true));
        }
        self.next_control = now;
        let (leg, _) = self.route.begin(&self.situation(now));
        self.carry_out(leg, now, commands);
    }

    /// One control period.
    fn control(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if !self.is_busy() {
            return;
        }
        let at = self.locator.estimate();
        let silence = self.route.server_silence(now);
        if let Some(reason) =
            self.health.limit_reached(now, at.heard_at, self.task.clock(), silence)
        {
            self.fail(reason, now, commands);
            return;
        }
        if !at.is_heard {
            return;
        }
        self.task.watch(now, at.position());
        if self.is_held_blind(now, commands) {
            return;
        }
        match self.phase {
            Phase::AimAtTrail => self.aim(now, commands),
            Phase::FollowTrail => self.follow_way(now, commands),
            Phase::LostTrail => self.search(now, commands),
            Phase::Wait => self.wait(now, commands),
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.bypass(now, commands),
            Phase::Approach => self.approach(now, commands),
            Phase::AlignHeading => self.align(now, commands),
            Phase::Blind | Phase::Idle | Phase::Arrived | Phase::Failed(_) => {}
        }
    }

    /// A robot that sees nothing stands until it does; then it goes on with what it was at.
    fn is_held_blind(&mut self, now: Stamp, commands: &mut Vec<Command>) -> bool {
        let is_blind = self.around.is_blind(now);
        if is_blind {
            self.guard.stop(commands);
            if self.phase != Phase::Blind {
                self.blind_in = self.phase;
                self.enter(Phase::Blind, now);
            }
        } else if self.phase == Phase::Blind {
            if self.blind_in == Phase::FollowTrail {
                self.take_up(now);
            } else {
                self.enter(self.blind_in, now);
            }
        }
        is_blind
    }

    fn is_busy(&self) -> bool {
        !matches!(self.phase, Phase::Idle | Phase::Arrived | Phase::Failed(_))
    }

    /// Asks the server what is to be asked next.
    fn ask(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.is_busy() && self.locator.estimate().is_heard {
            let aims = self.phase == Phase::AimAtTrail;
            self.route.ask(&self.situation(now), aims, commands);
        }
    }

    fn enter(&mut self, phase: Phase, now: Stamp) {
        if phase == Phase::Approach && self.phase != Phase::Approach {
            self.follow.begin_homing(self.locator.estimate().position());
        }
        if phase != self.phase {
            self.follow.cancel_turn();
        }
        let asks = matches!(phase, Phase::AimAtTrail | Phase::FollowTrail | Phase::LostTrail);
        self.route.change_phase(asks);
        self.phase = phase;
        self.phase_since = now;
    }

    fn fail(&mut self, reason: FailureReason, now: Stamp, commands: &mut Vec<Command>) {
        self.end_task(now);
        self.guard.stop(commands);
        self.enter(Phase::Failed(reason), now);
        commands.push(Command::Report(Report::Failed(reason)));
    }

    /// The task has ended; its goal is still shown.
    fn end_task(&mut self, now: Stamp) {
        self.task.end();
        self.guard.forget_task(now);
        self.route.forget_task();
        self.follow.forget_task();
    }

    fn forget_task(&mut self, now: Stamp) {
        self.end_task(now);
        self.task.forget();
    }

    /// What all parts that steer know now.
    fn situation(&self, now: Stamp) -> Situation {
        Situation {
            now,
            at: self.locator.estimate(),
            goal: self.task.goal(),
            waits: self.phase == Phase::Wait,
            steering: self.follow.steering(),
            told: self.guard.told(),
        }
    }

    /// The way that the robot is about to take; while waiting, the one that will be resumed.
    fn way(&self, situation: &Situation) -> Way {
        let phase = if self.phase == Phase::Wait { self.guard.resume() } else { self.phase };
        let target = match phase {
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.guard.target(),
            Phase::Approach => situation.goal_point(),
            Phase::FollowTrail => return self.route.way(situation),
            _ => None,
        };
        match target {
            Some(target) => Way::to(situation.at.position(), target, !self.guard.is_detouring()),
            None => self.route.straight_way(situation),
        }
    }

    /// Whether something stands on that way.
    fn is_blocked(&self, situation: &Situation) -> bool {
        let way = self.way(situation);
        self.guard.is_blocked(scene(situation, &self.around, &way, &self.route))
    }

    /// How fast what is around lets the robot be on that way, m/s.
    fn way_speed_mps(&self, situation: &Situation) -> f64 {
        let way = self.way(situation);
        self.guard.way_speed_mps(scene(situation, &self.around, &way, &self.route))
    }

    /// On a trail the machine is idle; what the robot does has the same names.
    fn show_state(&mut self, commands: &mut Vec<Command>) {
        let state = match self.phase {
            Phase::AimAtTrail => State::Aim,
            Phase::FollowTrail | Phase::LostTrail | Phase::Approach
                if self.follow.steering().is_turning =>
            {
                State::Rotate
            }
            Phase::FollowTrail | Phase::LostTrail | Phase::Approach => State::Control,
            Phase::AlignHeading => State::Rotate,
            Phase::Wait | Phase::Blind => State::Supervise,
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => {
                // The machine reports for itself.
                self.shown_state = self.guard.state().byte();
                return;
            }
            Phase::Idle | Phase::Arrived | Phase::Failed(_) => State::Idle,
        };
        if state.byte() != self.shown_state {
            self.shown_state = state.byte();
            commands.push(Command::Report(Report::StateEntered(state.byte())));
        }
    }

    /// Everything worth showing.
    pub fn view(&self) -> NavigatorView<'_> {
        let at = self.locator.estimate();
        let ahead = self.route.ahead();
        let on_trail = matches!(self.phase, Phase::FollowTrail | Phase::LostTrail);
        let intensities = self.route.felt();
        let trail_error = intensities.map_or(0.0, |(left, right)| left - right);
        NavigatorView {
            phase: self.phase,
            avoider_state: self.guard.state().byte(),
            avoider_name: self.guard.state().name(),
            map_from_base: Transform2::new(at.pose),
            ellipse: at.covariance.ellipse(ELLIPSE_N_SIGMA),
            goal_in_map: self.task.goal().map(|goal| goal.map_from_base),
            target_in_map: self.target(),
            preview_in_map: &ahead[..ahead.len().min(self.route.n_shown())],
            scouting: self.route.scouting(),
            way_ahead_m: self.route.ahead_m(),
            intensities,
            bubble_limits_m: self.around.bubble_limits_m(at.speed_mps()),
            n_sonars: self.around.n_sonars(),
            follower_error: if on_trail { trail_error } else { self.follow.error_m() },
            rebound_rad: self.guard.rebound_rad(),
            n_echoes: self.around.echoes().len(),
            n_attempts: self.guard.n_attempts(),
        }
    }

    /// How far it relies on where it believes to be.
    pub fn pose_health(&self) -> PoseHealth {
        self.locator.estimate().health
    }

    /// What each of its parts says that it is about, and why; written out only when shown.
    pub fn says(&self) -> Says {
        Says {
            where_am_i: self.locator.says(),
            around: self.around.says(),
            where_to: self.task.says(),
            how: self.route.says(),
            follow: self.follow.says(),
            guard: self.guard.says(),
            health: self.health.says(self.phase),
        }
    }

    fn target(&self) -> Option<Vec2> {
        match self.phase {
            Phase::DriveToTarget | Phase::Avoid | Phase::Rejoin => self.guard.target(),
            Phase::Approach | Phase::AlignHeading => self.task.goal().map(|goal| goal.point()),
            _ => None,
        }
    }
}

/// What the guard looks at.
fn scene<'a>(
    situation: &'a Situation,
    around: &'a Surroundings,
    way: &'a Way,
    route: &'a Route,
) -> Scene<'a> {
    Scene { situation, around, way, points: route.ahead() }
}
