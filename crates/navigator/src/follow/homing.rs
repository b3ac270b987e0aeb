//! The last part of every way, straight to the goal and its heading: drive, stand, measure, correct, turn.

use std::time::Duration;

use geometry::{Vec2, wrap_to_pi};
use messages::FailureReason;
use path_following::WheelReference;
use run_context::Stamp;

use super::turns::{TurnStatus, Turns};
use crate::{
    around::Surroundings,
    values::{Goal, Limits, Motion, SPEED_MIN_MPS, Situation},
};

/// So near to its goal a robot that has driven past it stops and looks where it stands, metres.
const PASSED_WITHIN_M: f64 = 0.5;

/// Times that a robot which stands beside its goal tries to stand better.
const N_CORRECTIONS_MAX: u32 = 6;

/// Times that it turns to its goal in one task.
const N_AIMS_MAX: u32 = 8;

/// A goal so near behind the robot is backed up to, metres.
const BACK_UP_MAX_M: f64 = 0.4;

/// ... if it lies so straight behind it, radians.
const BACK_UP_BEARING_RAD: f64 = 0.4;

/// Bearing of the goal from which the robot turns on the spot, radians, and how well it looks there then.
const TURN_TO_GOAL_FROM_RAD: f64 = 0.4;
const TURNED_TO_GOAL_RAD: f64 = 0.1;

/// Slowest speed to the goal, metres per second: two of the steps in which wheels are told their speed.
const CREEP_MPS: f64 = 0.04;

/// Time to come to rest, and to back up.
const SETTLE_LIMIT: Duration = Duration::from_secs(6);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// Forward, steering for the goal.
    #[default]
    Drive,
    /// Turns to the goal on the spot, then drives.
    Aim,
    /// Straight back to a goal that was passed.
    BackUp,
    /// Told to stop; where it stands is measured when it does.
    Settle,
}

/// How it stands with the goal after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Homed {
    Going,
    /// The way to it may be driven now, if nothing is on it.
    MayDrive,
    /// The robot stands at it.
    Stands,
    /// It looks the right way, too.
    Arrived,
    /// Turning has moved it away.
    Moved,
    Failed(FailureReason),
}

/// The way to the goal's exact place.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Homing {
    stage: Stage,
    since: Stamp,
    /// Times that it stood beside the goal and tried again.
    n_corrections: u32,
    n_aims: u32,
    /// Where the straight line to the goal begins (m, map).
    line_from: Vec2,
}

impl Homing {
    /// The goal is headed for from there; corrections are counted on.
    pub(crate) fn begin(&mut self, from: Vec2) {
        self.line_from = from;
        self.stage = Stage::Drive;
    }

    /// Forgets the task.
    pub(crate) fn forget(&mut self) {
        *self = Self { line_from: self.line_from, ..Self::default() };
    }

    pub(crate) fn line_from(&self) -> Vec2 {
        self.line_from
    }

    /// Drives straight to the goal, stands, measures where it stands, and tries again if that is not there.
    pub(crate) fn step(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        turns: &mut Turns,
        limits: &Limits,
    ) -> (Homed, Motion) {
        let Some(goal) = situation.goal else { return (Homed::Going, Motion::Keep) };
        match self.stage {
            Stage::Drive | Stage::Aim => self.drive(&goal, situation, around, turns, limits),
            Stage::BackUp => self.back_up(&goal, situation, around, turns, limits),
            Stage::Settle => self.measure(&goal, situation, around),
        }
    }

    fn drive(
        &mut self,
        goal: &Goal,
        situation: &Situation,
        around: &Surroundings,
        turns: &mut Turns,
        limits: &Limits,
    ) -> (Homed, Motion) {
        if self.brakes(situation, turns, limits) {
            return (Homed::Going, self.settle(situation.now, turns));
        }
        let pose = situation.at.pose_now(situation.now);
        let way = goal.point() - pose.position();
        let bearing_rad = wrap_to_pi(way.y.atan2(way.x) - pose.yaw_rad);
        let aims = self.stage == Stage::Aim || bearing_rad.abs() > TURN_TO_GOAL_FROM_RAD;
        if turns.is_turning() || aims {
            return self.turn_to_goal(goal, situation, around, turns);
        }
        (Homed::MayDrive, Motion::Keep)
    }

    fn turn_to_goal(
        &mut self,
        goal: &Goal,
        situation: &Situation,
        around: &Surroundings,
        turns: &mut Turns,
    ) -> (Homed, Motion) {
        let way = goal.point() - situation.at.position();
        let heading_rad = way.y.atan2(way.x);
        let (status, motion) = turns.turn_to(heading_rad, TURNED_TO_GOAL_RAD, situation, around);
        match status {
            TurnStatus::Turning => {}
            TurnStatus::Done => {
                self.begin(situation.at.position());
                self.n_aims += 1;
            }
            TurnStatus::GaveUp => return (Homed::Failed(FailureReason::Stuck), motion),
        }
        let missed = self.n_aims > N_AIMS_MAX;
        (if missed { Homed::Failed(FailureReason::MissedGoal) } else { Homed::Going }, motion)
    }

    /// Whether the robot drives to the goal and must be told to stop now to stand there.
    pub(crate) fn brakes(&self, situation: &Situation, turns: &Turns, limits: &Limits) -> bool {
        !turns.is_turning()
            && self.stage == Stage::Drive
            && situation.goal.is_some_and(|goal| is_time_to_stop(&goal, situation, limits))
    }

    /// Stands, to measure where.
    pub(crate) fn settle(&mut self, now: Stamp, turns: &mut Turns) -> Motion {
        turns.cancel_turn();
        self.stage = Stage::Settle;
        self.since = now;
        Motion::Stop
    }

    /// Measures where it stands once it does.
    fn measure(
        &mut self,
        goal: &Goal,
        situation: &Situation,
        around: &Surroundings,
    ) -> (Homed, Motion) {
        let (now, at) = (situation.now, &situation.at);
        if !at.is_at_rest() {
            let too_long = now.since(self.since) > SETTLE_LIMIT;
            let homed =
                if too_long { Homed::Failed(FailureReason::TimedOut) } else { Homed::Going };
            return (homed, Motion::Stop);
        }
        let way = goal.point() - at.position();
        if way.norm() <= goal.within_m {
            return (Homed::Stands, Motion::Keep);
        }
        self.n_corrections += 1;
        self.since = now;
        if self.n_corrections > N_CORRECTIONS_MAX {
            return (Homed::Failed(FailureReason::MissedGoal), Motion::Keep);
        }
        let behind = -way;
        let bearing_rad = wrap_to_pi(behind.y.atan2(behind.x) - at.pose.yaw_rad);
        let back_up = way.norm() <= BACK_UP_MAX_M
            && bearing_rad.abs() <= BACK_UP_BEARING_RAD
            && around.retreat_room_m(at) > 0.04;
        self.stage = if back_up { Stage::BackUp } else { Stage::Aim };
        (Homed::Going, Motion::Keep)
    }

    fn back_up(
        &mut self,
        goal: &Goal,
        situation: &Situation,
        around: &Surroundings,
        turns: &mut Turns,
        limits: &Limits,
    ) -> (Homed, Motion) {
        let (now, at) = (situation.now, &situation.at);
        let pose = at.pose_now(now);
        let behind_m = (pose.position() - goal.point()).dot(&pose.heading());
        let done = behind_m <= at.stopping_way_m(limits)
            || around.retreat_room_m(at) < 0.03
            || around.is_touched()
            || now.since(self.since) > SETTLE_LIMIT;
        let motion = if done {
            self.settle(now, turns)
        } else {
            Motion::Wheels(WheelReference::straight(-creep_mps(goal, limits)))
        };
        (Homed::Going, motion)
    }

    /// Turns to the goal's heading; arrived is who then stands, at the place and looking the way asked for.
    pub(crate) fn align(
        situation: &Situation,
        around: &Surroundings,
        turns: &mut Turns,
    ) -> (Homed, Motion) {
        let Some(goal) = situation.goal else { return (Homed::Going, Motion::Keep) };
        let pose = goal.map_from_base.se2();
        let (status, motion) = turns.turn_to(pose.yaw_rad, goal.within_rad, situation, around);
        let homed = match status {
            TurnStatus::Turning => Homed::Going,
            TurnStatus::Done if !situation.at.is_at_rest() => Homed::Going,
            TurnStatus::Done => {
                let off_m = (pose.position() - situation.at.position()).norm();
                if off_m > goal.within_m { Homed::Moved } else { Homed::Arrived }
            }
            TurnStatus::GaveUp => Homed::Failed(FailureReason::Stuck),
        };
        (homed, motion)
    }
}

/// Slowest speed to the goal: a period of it is half of what the robot may miss it by.
pub(crate) fn creep_mps(goal: &Goal, limits: &Limits) -> f64 {
    let fine_mps = 0.5 * goal.within_m / limits.period_s;
    fine_mps.clamp(CREEP_MPS, SPEED_MIN_MPS).min(limits.speed_mps)
}

/// Whether a robot that is told to stop now stands at the goal, or has passed it.
fn is_time_to_stop(goal: &Goal, situation: &Situation, limits: &Limits) -> bool {
    let at = &situation.at;
    let pose = at.pose_now(situation.now);
    let way = goal.point() - pose.position();
    let ahead_m = way.dot(&pose.heading());
    let margin_m = (0.25 * goal.within_m).min(0.02);
    let moves = at.is_moving || situation.told.linear_mps() > 0.0;
    let there = way.norm() <= margin_m;
    let passes = moves && way.norm() < PASSED_WITHIN_M;
    there || passes && ahead_m <= at.stopping_way_m(limits) + 0.5 * margin_m
}
