//! The nine-state machine that drives to a target and rebounds from what is in the way.
//!
//! States and their bytes are those of Annex C of the thesis. One call of [`Machine::step`] is one
//! control period. The machine knows no follower: in states 3 and 7 it says [`Motion::Follow`], and
//! its owner follows the straight line [`Machine::line`].

mod config;

use std::time::Duration;

use geometry::{Se2, Vec2, wrap_to_pi};
use run_context::Stamp;

use crate::{Bubble, RangeSensor, rebound_turn_rad};

pub use config::{HeadingCheck, MachineConfig, MachineConfigError, Variant};

/// Sensors that look at most so far aside look ahead, radians (22°).
const AHEAD_RAD: f64 = 0.384;
/// How far the innermost sensors to either side may differ, radians (1°).
const INNERMOST_SPREAD_RAD: f64 = 0.0175;

/// Number of states.
pub const N_STATES: usize = 9;

/// States of the machine; the discriminant is the telemetry byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// Waits for a target.
    #[default]
    Idle = 0,
    /// Computes the heading to the target.
    Aim = 1,
    /// Turns to it.
    Rotate = 2,
    /// One control step towards the target.
    Control = 3,
    /// Looks for obstacles and for the end.
    Supervise = 4,
    /// Stands before an obstacle and computes the rebound.
    Obstacle = 5,
    /// Turns away.
    RotateAway = 6,
    /// One control step away from the obstacle.
    DetourControl = 7,
    /// Looks for obstacles, and whether the target may be aimed at again.
    DetourSupervise = 8,
}

impl State {
    /// The telemetry byte.
    pub fn byte(self) -> u8 {
        self as u8
    }

    /// A word or two for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Aim => "aim at target",
            Self::Rotate => "rotating",
            Self::Control => "control step",
            Self::Supervise => "supervise",
            Self::Obstacle => "obstacle",
            Self::RotateAway => "rotating away",
            Self::DetourControl => "detour step",
            Self::DetourSupervise => "supervise detour",
        }
    }
}

/// What a step needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs<'a> {
    /// Now.
    pub now: Stamp,
    /// Where the robot is, in the frame of the targets; it must not jump while a target is driven to.
    pub pose: Se2,
    /// Latest ranges, one per sensor, metres.
    pub ranges_m: &'a [f64],
    /// Speed over ground, metres per second.
    pub speed_mps: f64,
    /// A wheel stalls or a bumper is pressed.
    pub stalled: bool,
    /// The follower's last step had one wheel at its highest and the other at its lowest speed.
    pub saturated_turn: bool,
    /// Whether something is in the way, if the owner knows better than the bubble.
    pub obstacle: Option<bool>,
    /// Whether the way to the target is free, if the owner knows better than the latest ranges.
    pub target_visible: Option<bool>,
    /// Where to go around what is in the way, if the owner has looked; read in state 5.
    pub detour: Option<Vec2>,
}

/// What the wheels shall do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Motion {
    /// As before.
    #[default]
    None,
    /// Stand.
    Stop,
    /// Turn in place to this heading (rad, frame of the targets).
    TurnTo(f64),
    /// Follow the line to the target.
    Follow,
    /// Drive back slowly.
    BackOff,
}

/// How things stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// On the way, or idle.
    #[default]
    Busy,
    /// The target was reached in this step.
    Reached,
    /// Given up in this step: too many rebounds without progress.
    TooManyRebounds,
    /// Given up in this step: the robot does not turn.
    CannotTurn,
}

/// The answer of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// What to do.
    pub motion: Motion,
    /// How things stand.
    pub outcome: Outcome,
    /// A heartbeat is due.
    pub heartbeat: bool,
    entered: [u8; 6],
    n_entered: usize,
}

impl Output {
    /// Telemetry bytes of the states entered in this step, in order.
    pub fn entered(&self) -> &[u8] {
        &self.entered[..self.n_entered]
    }

    fn tell(&mut self, state: State) {
        if let Some(slot) = self.entered.get_mut(self.n_entered) {
            *slot = state.byte();
            self.n_entered += 1;
        }
    }
}

/// The machine; see the module.
#[derive(Clone, Debug)]
pub struct Machine {
    config: MachineConfig,
    sensors: Vec<RangeSensor>,
    bubble: Bubble,
    state: State,
    /// The state was entered between two steps and is told in the next.
    unannounced: bool,
    /// The target proper; a detour has its own in `detour`.
    target: Option<Vec2>,
    detour: Option<Vec2>,
    line_from: Vec2,
    heading_wanted_rad: f64,
    rebound_rad: Option<f64>,
    since: Stamp,
    n_turn_orders: u32,
    back_off_until: Option<Stamp>,
    n_rebounds: u32,
    nearest_m: f64,
    heartbeat_due: Option<Stamp>,
}

impl Machine {
    /// An idle machine for these sensors; `bubble` speaks of the same sensors in the same order.
    ///
    /// # Errors
    ///
    /// [`MachineConfigError`] names the first setting outside its range.
    pub fn new(
        config: MachineConfig,
        sensors: &[RangeSensor],
        bubble: Bubble,
    ) -> Result<Self, MachineConfigError> {
        config::check(&config, sensors.len(), &bubble)?;
        Ok(Self {
            config,
            sensors: sensors.to_vec(),
            bubble,
            state: State::Idle,
            unannounced: false,
            target: None,
            detour: None,
            line_from: Vec2::zeros(),
            heading_wanted_rad: 0.0,
            rebound_rad: None,
            since: Stamp::ZERO,
            n_turn_orders: 0,
            back_off_until: None,
            n_rebounds: 0,
            nearest_m: f64::INFINITY,
            heartbeat_due: None,
        })
    }

    /// The state.
    pub fn state(&self) -> State {
        self.state
    }

    /// The bubble in use.
    pub fn bubble(&self) -> &Bubble {
        &self.bubble
    }

    /// Where it drives to at present (m): the temporary target during a detour.
    pub fn target(&self) -> Option<Vec2> {
        self.detour.or(self.target)
    }

    /// The line to follow (m): from where the target was aimed at to the target.
    pub fn line(&self) -> Option<(Vec2, Vec2)> {
        self.target().map(|target| (self.line_from, target))
    }

    /// Whether it goes around something.
    pub fn is_detouring(&self) -> bool {
        self.detour.is_some()
    }

    /// The last rebound relative to the heading at that time, radians, left positive.
    pub fn rebound_rad(&self) -> Option<f64> {
        self.rebound_rad
    }

    /// Rebounds and stalls since there was progress.
    pub fn n_rebounds(&self) -> u32 {
        self.n_rebounds
    }

    /// Takes a new target (m) and aims at it in the next step.
    pub fn set_target(&mut self, target: Vec2, now: Stamp) {
        self.reset(now);
        self.target = Some(target);
        self.state = State::Aim;
        self.unannounced = true;
    }

    /// Takes a new target (m) that lies behind an obstacle: starts in state 5 instead of aiming.
    pub fn set_target_behind_obstacle(&mut self, target: Vec2, now: Stamp) {
        self.set_target(target, now);
        self.state = State::Obstacle;
    }

    /// Replaces the target (m) on the way to it, without forgetting the rebounds so far.
    pub fn retarget(&mut self, target: Vec2) {
        if self.target.is_some() {
            self.target = Some(target);
            self.nearest_m = f64::INFINITY;
        }
    }

    /// Back to state 5, counted as a rebound: what was planned cannot be done.
    pub fn rebound_again(&mut self, now: Stamp) {
        if self.target.is_some() {
            self.n_rebounds += 1;
            self.unannounced |= self.state != State::Obstacle;
            self.state = State::Obstacle;
            self.since = now;
        }
    }

    /// The target proper (m), also during a detour.
    pub fn final_target(&self) -> Option<Vec2> {
        self.target
    }

    /// Whether state 5 has lasted long enough to compute the rebound in the next step.
    pub fn is_settled(&self, now: Stamp) -> bool {
        self.state == State::Obstacle
            && self.back_off_until.is_none_or(|until| now >= until)
            && now.since(self.since) >= self.config.settle
    }

    /// Forgets the target; the next step says nothing but that.
    pub fn stop(&mut self, now: Stamp) {
        self.reset(now);
    }

    /// One control period.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> Output {
        let mut output = Output { heartbeat: self.heartbeat(inputs.now), ..Output::default() };
        let Some(target) = self.target else {
            return output;
        };
        if std::mem::take(&mut self.unannounced) {
            output.tell(self.state);
        }
        self.note_progress(inputs.pose, target);
        if self.check_stall(inputs, &mut output) {
            return output;
        }
        match self.state {
            State::Idle => {}
            State::Aim => self.aim(inputs, &mut output),
            State::Rotate => {
                if self.turn_is_done(inputs, false, &mut output) {
                    self.enter(State::Control, inputs.now, &mut output);
                    self.control(inputs, &mut output);
                }
            }
            State::Control | State::DetourControl => self.control(inputs, &mut output),
            State::Supervise | State::DetourSupervise => self.supervise(inputs, &mut output),
            State::Obstacle => self.rebound(inputs, &mut output),
            State::RotateAway => {
                if self.turn_is_done(inputs, true, &mut output) {
                    self.leave_turn_away(inputs, &mut output);
                }
            }
        }
        if self.n_rebounds > self.config.rebounds_max {
            self.give_up(Outcome::TooManyRebounds, inputs.now, &mut output);
        }
        output
    }

    fn aim(&mut self, inputs: &Inputs<'_>, output: &mut Output) {
        self.detour = None;
        if self.still_rolls(inputs) {
            output.motion = Motion::Stop;
            return;
        }
        let position = inputs.pose.position();
        let way = self.target.unwrap_or(position) - position;
        self.line_from = position;
        if way.norm() < self.config.near_m {
            self.reach(inputs.now, output);
            return;
        }
        self.heading_wanted_rad = way.y.atan2(way.x);
        self.n_turn_orders = 1;
        output.motion = Motion::TurnTo(self.heading_wanted_rad);
        self.enter(State::Rotate, inputs.now, output);
    }

    fn control(&mut self, inputs: &Inputs<'_>, output: &mut Output) {
        if inputs.saturated_turn {
            // Too far off the line to steer back: stand, and aim anew.
            output.motion = Motion::Stop;
            self.detour = None;
            self.enter(State::Aim, inputs.now, output);
            return;
        }
        output.motion = Motion::Follow;
        let next = if self.detour.is_some() { State::DetourSupervise } else { State::Supervise };
        self.enter(next, inputs.now, output);
    }

    fn supervise(&mut self, inputs: &Inputs<'_>, output: &mut Output) {
        if self.sees_obstacle(inputs) {
            output.motion = Motion::Stop;
            self.n_rebounds += 1;
            self.enter(State::Obstacle, inputs.now, output);
            return;
        }
        let position = inputs.pose.position();
        let near = self.target().is_some_and(|t| (t - position).norm() < self.config.near_m);
        match (self.detour.is_some(), near) {
            (false, true) => self.reach(inputs.now, output),
            (true, true) => self.end_detour(inputs.now, output),
            (true, false) if self.may_aim_again(inputs) => self.end_detour(inputs.now, output),
            (detouring, false) => {
                let next = if detouring { State::DetourControl } else { State::Control };
                self.enter(next, inputs.now, output);
                self.control(inputs, output);
            }
        }
    }

    fn rebound(&mut self, inputs: &Inputs<'_>, output: &mut Output) {
        output.motion = Motion::Stop;
        if let Some(until) = self.back_off_until {
            if inputs.now < until {
                output.motion = Motion::BackOff;
                return;
            }
            self.back_off_until = None;
            self.since = inputs.now;
        }
        if inputs.now.since(self.since) < self.config.settle || self.still_rolls(inputs) {
            return;
        }
        let blocked = self.front_is_blocked(inputs);
        let turn_rad =
            rebound_turn_rad(&self.sensors, inputs.ranges_m, blocked, &self.config.swing);
        self.rebound_rad = Some(turn_rad);
        let position = inputs.pose.position();
        let heading_rad = wrap_to_pi(inputs.pose.yaw_rad + turn_rad);
        if self.detour.is_none() || !self.config.keep_first_detour {
            let reach_m = match self.config.variant {
                Variant::Detour => self.config.detour_m,
                Variant::Visibility => self.config.detour_max_m,
            };
            let ahead = Se2::new(0.0, 0.0, heading_rad).heading();
            self.detour = Some(inputs.detour.unwrap_or(position + ahead * reach_m));
        }
        self.line_from = position;
        self.heading_wanted_rad = inputs.detour.map_or(heading_rad, |via| {
            let way = via - position;
            way.y.atan2(way.x)
        });
        self.n_turn_orders = 1;
        output.motion = Motion::TurnTo(self.heading_wanted_rad);
        self.enter(State::RotateAway, inputs.now, output);
    }

    fn leave_turn_away(&mut self, inputs: &Inputs<'_>, output: &mut Output) {
        let blocked = inputs.obstacle.unwrap_or_else(|| self.front_is_blocked(inputs));
        if blocked {
            self.n_rebounds += 1;
            output.motion = Motion::Stop;
            self.enter(State::Obstacle, inputs.now, output);
        } else {
            self.enter(State::DetourControl, inputs.now, output);
            self.line_from = inputs.pose.position();
            self.control(&Inputs { saturated_turn: false, ..*inputs }, output);
        }
    }

    /// Whether the turn ordered in states 1 and 5 is done; orders it again when it takes too long.
    fn turn_is_done(&mut self, inputs: &Inputs<'_>, away: bool, output: &mut Output) -> bool {
        let (now_rad, wanted_rad) = (inputs.pose.yaw_rad, self.heading_wanted_rad);
        let error_rad = match self.config.heading_check {
            HeadingCheck::Listing if away => full_turn(now_rad) - full_turn(wanted_rad),
            _ => wrap_to_pi(now_rad - wanted_rad),
        };
        if error_rad.abs() <= self.config.angular_limit_rad {
            return true;
        }
        if inputs.now.since(self.since) > self.config.turn_limit {
            self.n_turn_orders += 1;
            self.since = inputs.now;
            output.motion = Motion::TurnTo(wanted_rad);
            if self.n_turn_orders > 3 {
                self.give_up(Outcome::CannotTurn, inputs.now, output);
            }
        }
        false
    }

    /// The body that the thesis's `check_stall` leaves open: stop, back off a little, rebound.
    fn check_stall(&mut self, inputs: &Inputs<'_>, output: &mut Output) -> bool {
        let busy = self.state != State::Idle && self.back_off_until.is_none();
        if !(busy && inputs.stalled) {
            return false;
        }
        output.motion = Motion::BackOff;
        self.back_off_until = Some(inputs.now + self.config.back_off);
        self.n_rebounds += 1;
        self.enter(State::Obstacle, inputs.now, output);
        if self.n_rebounds > self.config.rebounds_max {
            self.give_up(Outcome::TooManyRebounds, inputs.now, output);
        }
        true
    }

    fn still_rolls(&self, inputs: &Inputs<'_>) -> bool {
        self.config.stand_before_turning
            && inputs.speed_mps.abs() > 0.03
            && inputs.now.since(self.since) < Duration::from_secs(3)
    }

    fn sees_obstacle(&self, inputs: &Inputs<'_>) -> bool {
        inputs.obstacle.unwrap_or_else(|| {
            let (speed_mps, period_s) = (inputs.speed_mps, self.config.period_s);
            self.bubble.check(inputs.ranges_m, speed_mps, period_s).first.is_some()
        })
    }

    /// The sensors nearest to straight ahead, measured against the boundary of a moving robot: all
    /// within 22°, or the innermost of a ring that has none there.
    fn front_is_blocked(&self, inputs: &Inputs<'_>) -> bool {
        let aside = self.sensors.iter().map(|sensor| sensor.bearing_rad.abs());
        let innermost_rad = aside.fold(f64::INFINITY, f64::min);
        let limit_rad = AHEAD_RAD.max(innermost_rad + INNERMOST_SPREAD_RAD);
        let ahead = |s: &RangeSensor| s.bearing_rad.abs() <= limit_rad;
        let speed_mps = inputs.speed_mps.abs().max(0.3);
        self.sensors.iter().zip(inputs.ranges_m).enumerate().any(|(index, (sensor, &range_m))| {
            ahead(sensor) && self.bubble.is_inside(index, range_m, speed_mps, self.config.period_s)
        })
    }

    fn may_aim_again(&self, inputs: &Inputs<'_>) -> bool {
        if self.config.variant == Variant::Detour || inputs.detour.is_some() {
            return false;
        }
        let driven_m = (inputs.pose.position() - self.line_from).norm();
        let visible = inputs.target_visible.unwrap_or_else(|| self.target_is_visible(inputs));
        driven_m >= self.config.detour_max_m || driven_m >= self.config.detour_min_m && visible
    }

    /// Fig. 6.9: nothing in the visibility zone in the goal's direction. Directions that no sensor
    /// looks into are not visible.
    fn target_is_visible(&self, inputs: &Inputs<'_>) -> bool {
        let Some(target) = self.target else { return false };
        let way = target - inputs.pose.position();
        let bearing_rad = wrap_to_pi(way.y.atan2(way.x) - inputs.pose.yaw_rad);
        let needed_m = way.norm().min(self.config.visibility_m);
        let mut zone = self.sensors.iter().zip(inputs.ranges_m).filter(|(sensor, _)| {
            wrap_to_pi(sensor.bearing_rad - bearing_rad).abs() <= self.config.visibility_half_rad
        });
        let first = zone.next();
        first.is_some_and(|(_, r)| *r >= needed_m) && zone.all(|(_, r)| *r >= needed_m)
    }

    fn end_detour(&mut self, now: Stamp, output: &mut Output) {
        output.motion = Motion::Stop;
        self.detour = None;
        self.enter(State::Aim, now, output);
    }

    fn reach(&mut self, now: Stamp, output: &mut Output) {
        output.motion = Motion::Stop;
        output.outcome = Outcome::Reached;
        self.target = None;
        self.detour = None;
        self.enter(State::Idle, now, output);
    }

    fn give_up(&mut self, outcome: Outcome, now: Stamp, output: &mut Output) {
        self.reach(now, output);
        output.outcome = outcome;
    }

    fn note_progress(&mut self, pose: Se2, target: Vec2) {
        let distance_m = (target - pose.position()).norm();
        if distance_m < self.nearest_m - self.config.progress_m {
            // The first distance is where progress is counted from.
            if self.nearest_m.is_finite() {
                self.n_rebounds = 0;
            }
            self.nearest_m = distance_m;
        }
    }

    fn heartbeat(&mut self, now: Stamp) -> bool {
        let due = *self.heartbeat_due.get_or_insert(now + self.config.first_heartbeat);
        if now < due {
            return false;
        }
        self.heartbeat_due = Some(now + Duration::from_secs(1));
        true
    }

    fn enter(&mut self, state: State, now: Stamp, output: &mut Output) {
        self.state = state;
        self.since = now;
        output.tell(state);
    }

    fn reset(&mut self, now: Stamp) {
        self.state = State::Idle;
        self.unannounced = false;
        self.target = None;
        self.detour = None;
        self.since = now;
        self.n_rebounds = 0;
        self.nearest_m = f64::INFINITY;
        self.back_off_until = None;
        self.rebound_rad = None;
    }
}

fn full_turn(angle_rad: f64) -> f64 {
    angle_rad.rem_euclid(std::f64::consts::TAU)
}

#[cfg(test)]
mod tests;
