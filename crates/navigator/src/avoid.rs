//! The phases before and around an obstacle: wait, go around, come back.

use messages::{Command, FailureReason, Report, Ring};
use std::time::Duration;

use geometry::Vec2;
use obstacle_avoidance::{Inputs, Motion, Outcome, State, find_detour};
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    ahead::Hazard,
    config::{Avoidance, Method},
    navigator::{Navigator, SPEED_MIN_MPS},
    trail::PREVIEW_STEP_M,
    view::Phase,
};

/// What is remembered of the present obstacle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bypass {
    /// The phase to come back to.
    pub(crate) resume: Phase,
    /// Where the robot waited last; it does not wait again at the same place.
    waited_at: Option<Vec2>,
    clear_since: Option<Stamp>,
    /// Since when there has been no way around.
    no_way_since: Option<Stamp>,
    retreat: Option<(Vec2, Stamp)>,
    looks_until: Option<Stamp>,
    /// Where the last way around was planned.
    planned_at: Option<Vec2>,
    pub(crate) n_retreats: u32,
}

/// The way must stay clear so long before a waiting robot moves on.
const CLEAR_FOR: Duration = Duration::from_millis(600);

/// How long to look for a way around from one place before backing off.
const LOOK_FOR: Duration = Duration::from_millis(1600);

/// How far to back off for another look, metres: over ground the robot has just come from.
const RETREAT_M: f64 = 0.25;

/// Speed of backing off, metres per second.
const RETREAT_MPS: f64 = 0.10;

/// How far to turn for another look when there is no room behind, and how long that takes.
const LOOK_ASIDE_RAD: f64 = 0.8;
const LOOK_ASIDE_FOR: Duration = Duration::from_millis(3500);

/// Back-offs and looks per obstacle.
const N_RETREATS_MAX: u32 = 6;

/// Distances behind an obstacle at which the trail is taken up again, metres, first to last.
const REJOIN_FROM_M: f64 = 0.8;
const REJOIN_TO_M: f64 = 3.2;

/// Targets offered to the search for a detour.
const N_TARGETS_MAX: usize = 12;

/// Speed on a detour relative to cruising: it leads past things.
const DETOUR_PACE: f64 = 0.7;

/// ... of at most this, metres per second.
const DETOUR_OF_MPS: f64 = 0.3;

impl Navigator {
    /// Something is in the way: wait a little, or go around at once.
    pub(crate) fn begin_wait(&mut self, now: Stamp) {
        let position = self.pose.position();
        let waited_here =
            self.bypass.waited_at.is_some_and(|place| (place - position).norm() < 0.5);
        self.bypass.resume = self.phase;
        self.bypass.clear_since = None;
        if self.config.wait.is_zero() || waited_here {
            self.begin_bypass(now);
        } else {
            self.enter(Phase::Wait, now);
        }
    }

    pub(crate) fn wait_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.stop_wheels(commands);
        if self.hazard(now) == Hazard::None {
            let since = *self.bypass.clear_since.get_or_insert(now);
            if now.since(since) >= CLEAR_FOR {
                self.forget_what_left_the_way(now);
                let resume = self.bypass.resume;
                if resume == Phase::FollowTrail {
                    self.begin_following(now);
                } else {
                    self.enter(resume, now);
                }
            }
            return;
        }
        self.bypass.clear_since = None;
        if now.since(self.phase_since) >= self.config.wait {
            self.bypass.waited_at = Some(self.pose.position());
            self.begin_bypass(now);
        }
    }

    /// Hands over to the machine, in its state 5.
    fn begin_bypass(&mut self, now: Stamp) {
        self.bypass.no_way_since = None;
        self.bypass.planned_at = None;
        self.bypass.retreat = None;
        if self.bypass.resume == Phase::DriveToTarget {
            // The machine is at work already and finds the obstacle itself.
            self.bypass.waited_at = Some(self.pose.position());
            self.enter(Phase::DriveToTarget, now);
            return;
        }
        let mut targets = [Vec2::zeros(); N_TARGETS_MAX];
        let n_targets = self.targets_behind(now, &mut targets);
        let fallback = self.goal_point().unwrap_or(self.pose.position());
        let target = targets[..n_targets].first().copied().unwrap_or(fallback);
        self.machine.set_target_behind_obstacle(target, now);
        self.enter(Phase::Avoid, now);
    }

    /// One control period of the machine.
    pub(crate) fn machine_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.retreat_step(now, commands) || self.curve_step(now, commands) {
            return;
        }
        let hazard = self.hazard(now) != Hazard::None;
        let state = self.machine.state();
        let position = self.pose.position();
        let fresh_hit = state == State::Supervise
            && self.phase == Phase::DriveToTarget
            && self.bypass.waited_at.is_none_or(|place| (place - position).norm() >= 0.5);
        if fresh_hit && hazard && !self.config.wait.is_zero() {
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        let detour = match self.plan_detour(now, state, commands) {
            Plan::NotNeeded => None,
            Plan::Via(via) => Some(via),
            Plan::NoWay => return,
        };
        let output = self.step_machine(now, hazard, detour);
        for state in output.entered() {
            commands.push(Command::Report(Report::StateEntered(*state)));
        }
        self.carry_out(output.motion, now, commands);
        match output.outcome {
            Outcome::Busy => self.name_phase(),
            Outcome::Reached => self.bypass_done(now),
            Outcome::TooManyRebounds => self.fail(FailureReason::Blocked, now, commands),
            Outcome::CannotTurn => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    fn step_machine(
        &mut self,
        now: Stamp,
        hazard: bool,
        detour: Option<Vec2>,
    ) -> obstacle_avoidance::Output {
        let checked = self.config.settings.avoidance == Avoidance::Checked;
        let obstacle = match self.config.settings.avoidance {
            Avoidance::Off => Some(false),
            Avoidance::Rebound => None,
            Avoidance::Checked => Some(hazard),
        };
        let ring = self.base.ring;
        let inputs = Inputs {
            now,
            pose: self.pose,
            ranges_m: ring.as_ref().map_or(&[], Ring::ranges_m),
            speed_mps: self.speed_mps(),
            stalled: self.base.is_touched(),
            saturated_turn: self.line_steering.saturated,
            obstacle,
            // A checked way is driven to its via-point; it leads past what cannot be heard from here.
            target_visible: checked.then_some(false),
            detour,
        };
        self.line_steering.saturated = false;
        self.machine.step(&inputs)
    }

    fn carry_out(&mut self, motion: Motion, now: Stamp, commands: &mut Vec<Command>) {
        let settings = &self.config.settings;
        match motion {
            Motion::None => {}
            Motion::Stop => self.stop_wheels(commands),
            Motion::TurnTo(heading_rad) => {
                let turn_rad = geometry::wrap_to_pi(heading_rad - self.pose.yaw_rad);
                if settings.avoidance == Avoidance::Checked && self.tail_may_hit_a_wall(turn_rad) {
                    self.curve = Some((heading_rad, now));
                } else if settings.avoidance == Avoidance::Checked && !self.turn_is_safe(turn_rad) {
                    self.stop_wheels(commands);
                    self.machine.rebound_again(now);
                    self.begin_retreat(now, commands);
                } else {
                    self.order_turn(heading_rad, commands);
                }
            }
            Motion::Follow => {
                let Some((from, to)) = self.machine.line() else { return };
                let left_m = (to - self.pose.position()).norm();
                let aside = self.phase != Phase::DriveToTarget || self.machine.is_detouring();
                let aside_mps = DETOUR_PACE * settings.speed_mps.min(DETOUR_OF_MPS);
                let most_mps = if aside { aside_mps } else { settings.speed_mps };
                let speed_mps = most_mps
                    .min(self.way_speed_mps(now))
                    .min(self.speed_to_stand_mps(left_m, now))
                    .max(SPEED_MIN_MPS.min(settings.speed_mps));
                let wheels = self.line_steering.step(self.sight(), from, to, speed_mps);
                self.drive(wheels, now, commands);
            }
            Motion::BackOff => self.drive(WheelReference::straight(-SPEED_MIN_MPS), now, commands),
        }
    }

    /// In state 5: looks for a checked way around; backs off or gives up when there is none.
    fn plan_detour(&mut self, now: Stamp, state: State, commands: &mut Vec<Command>) -> Plan {
        let checked = self.config.settings.avoidance == Avoidance::Checked;
        if !checked || state != State::Obstacle || !self.machine.is_settled(now) {
            return Plan::NotNeeded;
        }
        // A way that was found here and could not be driven is none.
        let position = self.pose.position();
        let tried = self.bypass.planned_at.is_some_and(|place| (place - position).norm() < 0.05);
        if !tried && let Some(via) = self.find_way_around(now) {
            self.bypass.no_way_since = None;
            self.bypass.planned_at = Some(position);
            return Plan::Via(via);
        }
        self.stop_wheels(commands);
        let since = *self.bypass.no_way_since.get_or_insert(now);
        if now.since(since) >= LOOK_FOR {
            self.begin_retreat(now, commands);
        }
        Plan::NoWay
    }

    fn find_way_around(&mut self, now: Stamp) -> Option<Vec2> {
        let mut targets = [Vec2::zeros(); N_TARGETS_MAX];
        let n_targets = self.targets_behind(now, &mut targets);
        let settings = &self.config.settings;
        let ranges = self.base.ring?.ranges_m;
        let rebound_rad = obstacle_avoidance::rebound_angle_rad(&settings.sensors, &ranges)?;
        let preferred_rad = self.pose.yaw_rad + rebound_rad;
        let scaled = |margin_ratio: f64, depth_ratio: f64| obstacle_avoidance::DetourConfig {
            margin_m: margin_ratio * settings.detour.margin_m,
            depth_m: depth_ratio * settings.detour.depth_m,
            ..settings.detour
        };
        let search = |config: obstacle_avoidance::DetourConfig| {
            let (echoes, footprint) = (&self.echoes, &self.config.footprint);
            find_detour(echoes, footprint, self.pose, preferred_rad, &targets[..n_targets], &config)
        };
        let found = search(scaled(1.5, 1.0))
            .or_else(|| search(scaled(1.0, 1.0)))
            .or_else(|| search(scaled(0.6, 0.5)))?;
        let target = targets[found.target_index];
        self.machine.retarget(target);
        Some(found.via.unwrap_or(target))
    }

    /// Where the way may be taken up again behind what is ahead (m, map).
    fn targets_behind(&self, now: Stamp, targets: &mut [Vec2; N_TARGETS_MAX]) -> usize {
        let mut n_targets = 0;
        let mut offer = |point: Vec2| {
            if let Some(slot) = targets.get_mut(n_targets) {
                *slot = point;
                n_targets += 1;
            }
        };
        let goal = self.goal_point();
        if self.bypass.resume == Phase::FollowTrail {
            let hit_m = self.first_thing_m(now).unwrap_or(0.7).min(1.3);
            let first = ((hit_m + REJOIN_FROM_M) / PREVIEW_STEP_M) as usize;
            let last = ((hit_m + REJOIN_TO_M) / PREVIEW_STEP_M) as usize;
            for ahead in (first..=last).step_by(3) {
                if let Some(point) = self.preview.get(self.preview_index + ahead) {
                    offer(*point);
                }
            }
            let on_preview =
                goal.is_some_and(|g| self.preview.last().is_some_and(|p| (p - g).norm() < 1.0));
            if let Some(goal) = goal.filter(|_| on_preview) {
                offer(goal);
            }
        } else if self.bypass.resume == Phase::Approach {
            goal.into_iter().for_each(&mut offer);
        } else if let Some(target) = self.machine.final_target() {
            // The direct method: somewhere on the line to the target, or the target itself.
            let way = target - self.pose.position();
            let length_m = way.norm();
            for k in 0..8 {
                let ahead_m = 1.2 + 0.3 * f64::from(k);
                if ahead_m < length_m {
                    offer(self.pose.position() + way * (ahead_m / length_m));
                }
            }
            offer(target);
        }
        n_targets
    }

    fn begin_retreat(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.bypass.n_retreats += 1;
        self.bypass.planned_at = None;
        self.bypass.no_way_since = None;
        if self.bypass.n_retreats > N_RETREATS_MAX {
            self.fail(FailureReason::Blocked, now, commands);
            return;
        }
        if self.retreat_room_m() > 0.06 {
            self.bypass.retreat = Some((self.pose.position(), now));
        } else {
            self.look_aside(now, commands);
        }
    }

    /// How far the robot may back off: over the straight way it has just come, or where the side
    /// sonars have heard enough to know.
    pub(crate) fn retreat_room_m(&self) -> f64 {
        let known_m = self.straight_m.min(RETREAT_M);
        let behind = |m: f64| {
            let heading = self.pose.heading();
            geometry::Se2::new(
                self.pose.x_m - heading.x * m,
                self.pose.y_m - heading.y * m,
                self.pose.yaw_rad,
            )
        };
        let steps = (1..=5).map(|k| 0.05 * f64::from(k)).take_while(|m| {
            *m <= known_m + 0.02
                && self.echoes.clearance_m(behind(*m), &self.config.footprint) > 0.03
        });
        steps.fold(0.0, f64::max)
    }

    /// No room behind: turns a little, now to one side, now to the other, for another look.
    fn look_aside(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let first = if self.bypass.n_retreats % 2 == 1 { 1.0 } else { -1.0 };
        let turn_rad = [first, -first]
            .map(|side| side * LOOK_ASIDE_RAD)
            .into_iter()
            .find(|turn_rad| self.turn_is_safe(*turn_rad));
        self.machine.rebound_again(now);
        if let Some(turn_rad) = turn_rad {
            self.order_turn(geometry::wrap_to_pi(self.pose.yaw_rad + turn_rad), commands);
            self.bypass.looks_until = Some(now + LOOK_ASIDE_FOR);
        }
    }

    /// Backs off if that is due; whether it is still at it.
    fn retreat_step(&mut self, now: Stamp, commands: &mut Vec<Command>) -> bool {
        if let Some(until) = self.bypass.looks_until {
            if now < until {
                return true;
            }
            self.bypass.looks_until = None;
            self.machine.rebound_again(now);
        }
        let Some((from, since)) = self.bypass.retreat else { return false };
        let done = self.retreat_room_m() < 0.05
            || (self.pose.position() - from).norm() >= RETREAT_M
            || now.since(since) > Duration::from_secs(5)
            || self.base.is_touched();
        if done {
            self.bypass.retreat = None;
            self.stop_wheels(commands);
            self.machine.rebound_again(now);
        } else {
            self.drive(WheelReference::straight(-RETREAT_MPS), now, commands);
        }
        true
    }

    fn name_phase(&mut self) {
        if self.phase == Phase::Avoid || self.phase == Phase::Rejoin {
            let away = self.machine.is_detouring() || self.machine.state() == State::Obstacle;
            self.phase = if away { Phase::Avoid } else { Phase::Rejoin };
        }
    }

    fn bypass_done(&mut self, now: Stamp) {
        self.bypass.n_retreats = 0;
        self.bypass.waited_at = None;
        if self.phase == Phase::DriveToTarget {
            self.target_reached(now);
            return;
        }
        let settings = &self.config.settings;
        match (self.bypass.resume, settings.method) {
            (Phase::FollowTrail, _) => self.begin_following(now),
            (Phase::LostTrail, Method::Trail) => self.aim_at_trail(now),
            _ => self.enter(Phase::Approach, now),
        }
        self.note_progress(now);
    }
}

/// What [`Navigator::plan_detour`] came to.
enum Plan {
    NotNeeded,
    Via(Vec2),
    NoWay,
}
