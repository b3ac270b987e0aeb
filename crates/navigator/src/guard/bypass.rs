//! Before and around an obstacle: wait, go around by the nine-state machine, look again, come back.

use std::time::Duration;

use geometry::{Vec2, wrap_to_pi};
use messages::{Command, FailureReason, Report, Ring};
use obstacle_avoidance::{
    Bubble, DetourConfig, Inputs, Machine, MachineConfig, MachineConfigError, Outcome, State,
    find_detour,
};
use path_following::WheelReference;
use run_context::Stamp;

use super::{
    behind::{N_TARGETS_MAX, targets_behind},
    helm::Helm,
    scene::Scene,
};
use crate::{
    around::RETREAT_M,
    phase::Phase,
    settings::{Avoidance, Method, NavigatorSettings},
    values::{Limits, Motion, SPEED_MIN_MPS},
};

/// How long a robot stands at least before it computes a rebound; a ring of eight has fired after
/// 320 ms.
const SETTLE_MIN: Duration = Duration::from_millis(500);
/// From a ping to the report that brings it, at most.
const REPORTED_AFTER: Duration = Duration::from_millis(100);
/// A path is rejoined as exactly as this, metres, so that the robot is on it from there on.
const PATH_NEAR_M: f64 = 0.1;

/// The way must stay clear so long before a waiting robot moves on.
const CLEAR_FOR: Duration = Duration::from_millis(600);

/// So near to where it waited a robot does not wait again, metres.
const WAITED_HERE_M: f64 = 0.5;

/// How long to look for a way around from one place before backing off.
const LOOK_FOR: Duration = Duration::from_millis(1600);

/// Speed of backing off, metres per second, and time for it.
const RETREAT_MPS: f64 = 0.10;
const RETREAT_LIMIT: Duration = Duration::from_secs(5);

/// A robot that feels and does not look backs off until so little is left of the straight way that it came, metres.
const BACK_OFF_LEFT_M: f64 = 0.02;

/// How far to turn for another look when there is no room behind, and how long that takes.
const LOOK_ASIDE_RAD: f64 = 0.8;
const LOOK_ASIDE_FOR: Duration = Duration::from_millis(3500);

/// Back-offs and looks per obstacle.
const N_RETREATS_MAX: u32 = 6;

/// Speed on a detour relative to cruising: it leads past things.
const DETOUR_PACE: f64 = 0.7;

/// ... of at most this, metres per second.
const DETOUR_OF_MPS: f64 = 0.3;

/// What the machine came to in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bypassing {
    /// It is at it.
    Going,
    /// It looks for a way around.
    NoWay,
    /// Drive along this line (m, map), at most so fast.
    Line {
        from: Vec2,
        to: Vec2,
        most_mps: f64,
    },
    /// Turn to this heading (rad, map) in an arc.
    Curve(f64),
    /// What it was sent to is reached.
    Reached,
    Failed(FailureReason),
}

/// What a waiting robot came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Waiting {
    Still,
    /// The way is clear: on with this phase.
    Clear(Phase),
    /// It is not: around it, in this phase.
    GoAround(Phase),
}

/// The machine, and what is remembered of the present obstacle.
#[derive(Clone, Debug)]
pub(crate) struct Bypass {
    machine: Machine,
    method: Avoidance,
    limits: Limits,
    detour: DetourConfig,
    wait: Duration,
    obstacle: Obstacle,
}

/// What is remembered of the present obstacle.
#[derive(Clone, Copy, Debug, Default)]
struct Obstacle {
    /// The phase to come back to.
    resume: Phase,
    /// Where the robot waited last; it does not wait again at the same place.
    waited_at: Option<Vec2>,
    clear_since: Option<Stamp>,
    /// Since when there has been no way around.
    no_way_since: Option<Stamp>,
    retreat: Option<(Vec2, Stamp)>,
    looks_until: Option<Stamp>,
    /// Where the last way around was planned.
    planned_at: Option<Vec2>,
    n_retreats: u32,
}

impl Bypass {
    pub(crate) fn new(s: &NavigatorSettings, bubble: Bubble) -> Result<Self, MachineConfigError> {
        Ok(Self {
            machine: Machine::new(machine_config(s), &s.sensors, bubble)?,
            method: s.avoidance,
            limits: s.limits(),
            detour: s.detour,
            // What touches does not go away by waiting.
            wait: match s.avoidance {
                Avoidance::Contact => Duration::ZERO,
                _ => Duration::from_secs_f64(s.wait_s),
            },
            obstacle: Obstacle::default(),
        })
    }

    pub(crate) fn forget_task(&mut self, now: Stamp) {
        self.machine.stop(now);
        self.obstacle = Obstacle::default();
    }

    /// The phase to come back to.
    pub(crate) fn resume(&self) -> Phase {
        self.obstacle.resume
    }

    pub(crate) fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Rebounds, back-offs and looks on the present obstacle.
    pub(crate) fn n_attempts(&self) -> u32 {
        self.machine.n_rebounds() + self.obstacle.n_retreats
    }

    /// Drives to a point (m, map) in a straight line.
    pub(crate) fn drive_to(&mut self, target: Vec2, now: Stamp) {
        self.machine.set_target(target, now);
    }

    /// The same, and follows the way from there on.
    pub(crate) fn join(&mut self, target: Vec2, now: Stamp) {
        self.obstacle.resume = Phase::FollowTrail;
        self.machine.set_target(target, now);
    }

    fn waited_near(&self, position: Vec2) -> bool {
        self.obstacle.waited_at.is_some_and(|place| (place - position).norm() < WAITED_HERE_M)
    }

    /// Something is in the way of that phase: wait a little, or go around at once. The phase for that.
    pub(crate) fn meet(&mut self, phase: Phase, scene: Scene<'_>) -> Phase {
        self.obstacle.resume = phase;
        self.obstacle.clear_since = None;
        if self.wait.is_zero() || self.waited_near(scene.situation.at.position()) {
            self.begin(scene)
        } else {
            Phase::Wait
        }
    }

    /// Stands since `since`, and knows whether the way is blocked still.
    pub(crate) fn wait(&mut self, since: Stamp, is_blocked: bool, scene: Scene<'_>) -> Waiting {
        let now = scene.situation.now;
        if !is_blocked {
            let since = *self.obstacle.clear_since.get_or_insert(now);
            let clear = now.since(since) >= CLEAR_FOR;
            return if clear { Waiting::Clear(self.obstacle.resume) } else { Waiting::Still };
        }
        self.obstacle.clear_since = None;
        if now.since(since) >= self.wait {
            self.obstacle.waited_at = Some(scene.situation.at.position());
            return Waiting::GoAround(self.begin(scene));
        }
        Waiting::Still
    }

    /// Hands over to the machine, in its state 5.
    fn begin(&mut self, scene: Scene<'_>) -> Phase {
        self.obstacle.no_way_since = None;
        self.obstacle.planned_at = None;
        self.obstacle.retreat = None;
        let position = scene.situation.at.position();
        if self.obstacle.resume == Phase::DriveToTarget {
            // The machine is at work already and finds the obstacle itself.
            self.obstacle.waited_at = Some(position);
            return Phase::DriveToTarget;
        }
        let mut targets = [Vec2::zeros(); N_TARGETS_MAX];
        let n_targets = self.targets(scene, &mut targets);
        let fallback = scene.situation.goal_point().unwrap_or(position);
        let target = targets[..n_targets].first().copied().unwrap_or(fallback);
        self.machine.set_target_behind_obstacle(target, scene.situation.now);
        Phase::Avoid
    }

    /// Backs off, or looks aside, if that is due; whether it is still at it.
    pub(crate) fn back_off(
        &mut self,
        scene: Scene<'_>,
        helm: &mut Helm,
        commands: &mut Vec<Command>,
    ) -> bool {
        let now = scene.situation.now;
        if let Some(until) = self.obstacle.looks_until {
            if now < until {
                return true;
            }
            self.obstacle.looks_until = None;
            self.machine.rebound_again(now);
        }
        let Some((from, since)) = self.obstacle.retreat else { return false };
        let done = scene.around.retreat_room_m(&scene.situation.at) < 0.05
            || (scene.situation.at.position() - from).norm() >= RETREAT_M
            || now.since(since) > RETREAT_LIMIT
            || scene.around.is_touched();
        if done {
            self.obstacle.retreat = None;
            helm.stop(commands);
            self.machine.rebound_again(now);
        } else {
            let wheels = WheelReference::straight(-RETREAT_MPS);
            helm.pass(Motion::Wheels(wheels), scene.situation, scene.around, commands);
        }
        true
    }

    /// Whether a robot on its straight way has just met something that it may wait for.
    pub(crate) fn may_wait(&self, phase: Phase, position: Vec2) -> bool {
        self.machine.state() == State::Supervise
            && phase == Phase::DriveToTarget
            && !self.waited_near(position)
            && !self.wait.is_zero()
    }

    /// One control period of the machine.
    pub(crate) fn step(
        &mut self,
        phase: Phase,
        is_blocked: bool,
        scene: Scene<'_>,
        helm: &mut Helm,
        commands: &mut Vec<Command>,
    ) -> Bypassing {
        let detour = match self.plan(scene) {
            Plan::NotNeeded => None,
            Plan::Via(via) => Some(via),
            Plan::NoWay { give_up_here } => {
                helm.stop(commands);
                if give_up_here
                    && let Bypassing::Failed(reason) = self.retreat(scene, helm, commands)
                {
                    return Bypassing::Failed(reason);
                }
                return Bypassing::NoWay;
            }
        };
        let output = self.step_machine(is_blocked, scene, detour);
        for state in output.entered() {
            commands.push(Command::Report(Report::StateEntered(*state)));
        }
        let done = self.carry_out(output.motion, phase, scene, helm, commands);
        match output.outcome {
            Outcome::Busy => done,
            Outcome::Reached => Bypassing::Reached,
            Outcome::TooManyRebounds => Bypassing::Failed(FailureReason::Blocked),
            Outcome::CannotTurn => Bypassing::Failed(FailureReason::Stuck),
        }
    }

    fn step_machine(
        &mut self,
        is_blocked: bool,
        scene: Scene<'_>,
        detour: Option<Vec2>,
    ) -> obstacle_avoidance::Output {
        let obstacle = match self.method {
            Avoidance::Off => Some(false),
            Avoidance::Rebound => None,
            Avoidance::Checked | Avoidance::Contact => Some(is_blocked),
        };
        self.machine.step(&Inputs {
            now: scene.situation.now,
            pose: scene.situation.at.pose,
            ranges_m: scene.around.ring().map_or(&[], Ring::ranges_m),
            speed_mps: scene.situation.at.speed_mps(),
            stalled: scene.around.is_touched(),
            saturated_turn: scene.situation.steering.is_saturated,
            obstacle,
            // A checked way is driven to its via-point; it leads past what cannot be heard from here.
            target_visible: (self.method == Avoidance::Checked).then_some(false),
            detour,
        })
    }

    fn carry_out(
        &mut self,
        motion: obstacle_avoidance::Motion,
        phase: Phase,
        scene: Scene<'_>,
        helm: &mut Helm,
        commands: &mut Vec<Command>,
    ) -> Bypassing {
        use obstacle_avoidance::Motion as Asked;
        let at = &scene.situation.at;
        match motion {
            Asked::None => {}
            Asked::Stop => helm.stop(commands),
            Asked::TurnTo(heading_rad) => {
                let turn_rad = wrap_to_pi(heading_rad - at.pose.yaw_rad);
                let is_checked = self.method == Avoidance::Checked;
                if is_checked && scene.around.tail_may_hit_a_wall(at, turn_rad) {
                    return Bypassing::Curve(heading_rad);
                }
                if is_checked && !scene.around.turn_is_safe(at, turn_rad) {
                    helm.stop(commands);
                    self.machine.rebound_again(scene.situation.now);
                    return self.retreat(scene, helm, commands);
                }
                helm.pass(Motion::Turn(heading_rad), scene.situation, scene.around, commands);
            }
            Asked::Follow => {
                let Some((from, to)) = self.machine.line() else { return Bypassing::Going };
                let aside = phase != Phase::DriveToTarget || self.machine.is_detouring();
                let cruise_mps = self.limits.speed_mps;
                let aside_mps = DETOUR_PACE * cruise_mps.min(DETOUR_OF_MPS);
                let most_mps = if aside { aside_mps } else { cruise_mps };
                return Bypassing::Line { from, to, most_mps };
            }
            // Nobody looks behind: over the ground that it came, and no further.
            Asked::BackOff
                if self.method == Avoidance::Contact && at.straight_m < BACK_OFF_LEFT_M =>
            {
                helm.stop(commands);
            }
            Asked::BackOff => {
                let wheels = WheelReference::straight(-SPEED_MIN_MPS);
                helm.pass(Motion::Wheels(wheels), scene.situation, scene.around, commands);
            }
        }
        Bypassing::Going
    }

    /// In state 5: looks for a checked way around.
    fn plan(&mut self, scene: Scene<'_>) -> Plan {
        let (now, position) = (scene.situation.now, scene.situation.at.position());
        let checked = self.method == Avoidance::Checked;
        if !checked || self.machine.state() != State::Obstacle || !self.machine.is_settled(now) {
            return Plan::NotNeeded;
        }
        // A way that was found here and could not be driven is none.
        let tried = self.obstacle.planned_at.is_some_and(|place| (place - position).norm() < 0.05);
        if !tried && let Some(via) = self.find_way_around(scene) {
            self.obstacle.no_way_since = None;
            self.obstacle.planned_at = Some(position);
            return Plan::Via(via);
        }
        let since = *self.obstacle.no_way_since.get_or_insert(now);
        Plan::NoWay { give_up_here: now.since(since) >= LOOK_FOR }
    }

    fn find_way_around(&mut self, scene: Scene<'_>) -> Option<Vec2> {
        let mut targets = [Vec2::zeros(); N_TARGETS_MAX];
        let n_targets = self.targets(scene, &mut targets);
        let ranges = scene.around.ring()?.ranges_m;
        let rebound_rad = obstacle_avoidance::rebound_angle_rad(scene.around.sensors(), &ranges)?;
        let pose = scene.situation.at.pose;
        let preferred_rad = pose.yaw_rad + rebound_rad;
        let scaled = |margin_ratio: f64, depth_ratio: f64| DetourConfig {
            margin_m: margin_ratio * self.detour.margin_m,
            depth_m: depth_ratio * self.detour.depth_m,
            ..self.detour
        };
        let search = |config: DetourConfig| {
            let (echoes, footprint) = (scene.around.echoes(), scene.around.footprint());
            find_detour(echoes, footprint, pose, preferred_rad, &targets[..n_targets], &config)
        };
        let found = search(scaled(1.5, 1.0))
            .or_else(|| search(scaled(1.0, 1.0)))
            .or_else(|| search(scaled(0.6, 0.5)))?;
        let target = targets[found.target_index];
        self.machine.retarget(target);
        Some(found.via.unwrap_or(target))
    }

    fn targets(&self, scene: Scene<'_>, targets: &mut [Vec2; N_TARGETS_MAX]) -> usize {
        targets_behind(self.obstacle.resume, self.machine.final_target(), scene, targets)
    }

    /// Begins to back off for another look, or to look aside where there is no room behind.
    fn retreat(
        &mut self,
        scene: Scene<'_>,
        helm: &mut Helm,
        commands: &mut Vec<Command>,
    ) -> Bypassing {
        self.obstacle.n_retreats += 1;
        self.obstacle.planned_at = None;
        self.obstacle.no_way_since = None;
        if self.obstacle.n_retreats > N_RETREATS_MAX {
            return Bypassing::Failed(FailureReason::Blocked);
        }
        if scene.around.retreat_room_m(&scene.situation.at) > 0.06 {
            self.obstacle.retreat = Some((scene.situation.at.position(), scene.situation.now));
        } else {
            self.look_aside(scene, helm, commands);
        }
        Bypassing::Going
    }

    /// No room behind: turns a little, now to one side, now to the other, for another look.
    fn look_aside(&mut self, scene: Scene<'_>, helm: &mut Helm, commands: &mut Vec<Command>) {
        let (now, at) = (scene.situation.now, &scene.situation.at);
        let first = if self.obstacle.n_retreats % 2 == 1 { 1.0 } else { -1.0 };
        let turn_rad = [first, -first]
            .map(|side| side * LOOK_ASIDE_RAD)
            .into_iter()
            .find(|turn_rad| scene.around.turn_is_safe(at, *turn_rad));
        self.machine.rebound_again(now);
        if let Some(turn_rad) = turn_rad {
            let heading_rad = wrap_to_pi(at.pose.yaw_rad + turn_rad);
            helm.pass(Motion::Turn(heading_rad), scene.situation, scene.around, commands);
            self.obstacle.looks_until = Some(now + LOOK_ASIDE_FOR);
        }
    }

    /// Whether it goes away from its way at present, and not back to it.
    pub(crate) fn is_away(&self) -> bool {
        self.machine.is_detouring() || self.machine.state() == State::Obstacle
    }

    /// The obstacle is passed.
    pub(crate) fn end(&mut self) {
        self.obstacle.n_retreats = 0;
        self.obstacle.waited_at = None;
    }
}

/// What [`Bypass::plan`] came to.
enum Plan {
    NotNeeded,
    Via(Vec2),
    NoWay { give_up_here: bool },
}

/// The settings of the machine that follow from the navigator's.
fn machine_config(s: &NavigatorSettings) -> MachineConfig {
    MachineConfig {
        variant: s.variant,
        period_s: s.control_period_s,
        near_m: if s.method == Method::Path { s.near_m.min(PATH_NEAR_M) } else { s.near_m },
        detour_m: s.detour_m,
        rebounds_max: s.attempts_max,
        // Every sensor has fired once after the robot stopped, and was reported.
        settle: SETTLE_MIN.max(s.sonar_round + REPORTED_AFTER),
        stand_before_turning: true,
        ..MachineConfig::default()
    }
}
