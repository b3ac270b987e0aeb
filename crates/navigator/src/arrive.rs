//! The last phases, straight to the goal and its heading, and turns in place.

use messages::{Command, FailureReason, Report};
use std::time::Duration;

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    Avoidance,
    ahead::Hazard,
    navigator::{Navigator, SPEED_MIN_MPS},
    view::Phase,
};

/// So near to its goal a robot that has driven past it stops and looks where it stands, metres.
const PASSED_WITHIN_M: f64 = 0.5;

/// Times that a robot which stands beside its goal tries to stand better.
const N_CORRECTIONS_MAX: u32 = 6;

/// A goal so near behind the robot is backed up to, metres.
const BACK_UP_MAX_M: f64 = 0.4;

/// ... if it lies so straight behind it, radians.
const BACK_UP_BEARING_RAD: f64 = 0.4;

/// Bearing of the goal from which the robot turns on the spot, radians.
const TURN_TO_GOAL_FROM_RAD: f64 = 0.4;

/// Slowest speed to the goal, metres per second: two of the steps in which wheels are told their speed.
const CREEP_MPS: f64 = 0.04;

/// Time to come to rest, and to back up.
const SETTLE_LIMIT: Duration = Duration::from_secs(6);

/// Times that a turn is ordered before it is given up.
const N_TURN_ORDERS_MAX: u32 = 3;

/// Time after which a turn is ordered again.
const TURN_LIMIT: Duration = Duration::from_secs(6);

/// Time for a turn with all its orders, also when it must wait for room.
const TURN_LIMIT_TOTAL: Duration = Duration::from_secs(20);

/// What a turn in place must leave free, metres: echoes are a few centimetres wrong.
const TURN_MARGIN_M: f64 = 0.02;

/// Way after which the side sensors have heard all that is beside the robot, metres.
const KNOWS_ITS_SIDES_AFTER_M: f64 = 0.4;

/// Time for a turn in an arc: half a turn takes 3.5 s.
const CURVE_LIMIT: Duration = Duration::from_secs(5);

/// A turn in place that was ordered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    heading_rad: f64,
    begun: Stamp,
    ordered: Stamp,
    n_orders: u32,
}

/// How a turn stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TurnStatus {
    Turning,
    Done,
    GaveUp,
}

/// The way to the goal's exact place.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Homing {
    stage: Stage,
    since: Stamp,
    /// Times that it stood beside the goal and tried again.
    n_corrections: u32,
}

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

impl Homing {
    /// The stage to begin with; corrections are counted on.
    pub(crate) fn restart(&mut self) {
        self.stage = Stage::Drive;
    }
}

impl Navigator {
    /// Drives straight to the goal, stands, measures where it stands, and tries again if that is not there.
    pub(crate) fn approach_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        match self.homing.stage {
            Stage::Drive | Stage::Aim => self.home_step(now, commands),
            Stage::BackUp => self.back_up_step(now, commands),
            Stage::Settle => self.settle_step(now, commands),
        }
    }

    fn home_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        if self.turn.is_none() && self.homing.stage == Stage::Drive && self.is_time_to_stop(now) {
            self.settle(now, commands);
            return;
        }
        let pose = self.pose_now(now);
        let way = goal - pose.position();
        let bearing_rad = wrap_to_pi(way.y.atan2(way.x) - pose.yaw_rad);
        let aims = self.homing.stage == Stage::Aim || bearing_rad.abs() > TURN_TO_GOAL_FROM_RAD;
        if self.turn.is_some() || aims {
            self.turn_to_goal(now, commands);
            return;
        }
        if self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        let settings = &self.config.settings;
        let left_m = (goal - self.pose.position()).norm();
        let creep_mps = self.creep_mps();
        let speed_mps =
            self.speed_to_stand_mps(left_m, now).min(self.way_speed_mps(now)).max(creep_mps);
        let speed_mps = speed_mps.min(settings.speed_mps);
        let wheels = self.line_steering.step(self.sight(), self.line_from, goal, speed_mps);
        self.drive(wheels, now, commands);
    }

    fn turn_to_goal(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        let way = goal - self.pose.position();
        match self.turn_to(way.y.atan2(way.x), 0.1, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => {
                self.homing.stage = Stage::Drive;
                self.line_from = self.pose.position();
                self.n_approach_aims += 1;
            }
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
        if self.n_approach_aims > 8 {
            self.fail(FailureReason::MissedGoal, now, commands);
        }
    }

    /// Slowest speed to the goal: a period of it is half of what the robot may miss it by.
    fn creep_mps(&self) -> f64 {
        let settings = &self.config.settings;
        let fine_mps = 0.5 * settings.goal_tolerance_m / settings.control_period_s;
        fine_mps.clamp(CREEP_MPS, SPEED_MIN_MPS).min(settings.speed_mps)
    }

    /// Whether a robot that is told to stop now stands at the goal, or has passed it.
    fn is_time_to_stop(&self, now: Stamp) -> bool {
        let Some(goal) = self.goal_point() else { return false };
        let pose = self.pose_now(now);
        let way = goal - pose.position();
        let ahead_m = way.dot(&pose.heading());
        let margin_m = (0.25 * self.config.settings.goal_tolerance_m).min(0.02);
        let moves = self.base.is_moving() || self.motion.linear_mps() > 0.0;
        let there = way.norm() <= margin_m;
        let passes = moves && way.norm() < PASSED_WITHIN_M;
        there || passes && ahead_m <= self.stopping_way_m() + 0.5 * margin_m
    }

    /// Between two control steps: a report says that it is time to stop at the goal.
    pub(crate) fn brake_at_goal(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let homes = self.phase == Phase::Approach && self.homing.stage == Stage::Drive;
        if homes
            && self.turn.is_none()
            && self.motion.linear_mps() > 0.0
            && self.is_time_to_stop(now)
        {
            self.settle(now, commands);
        }
    }

    fn settle(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.stop_wheels(commands);
        self.turn = None;
        self.homing.stage = Stage::Settle;
        self.homing.since = now;
    }

    /// Measures where it stands once it does.
    fn settle_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        if !self.stillness.is_at_rest() {
            self.stop_wheels(commands);
            if now.since(self.homing.since) > SETTLE_LIMIT {
                self.fail(FailureReason::TimedOut, now, commands);
            }
            return;
        }
        let way = goal - self.pose.position();
        if way.norm() <= self.config.settings.goal_tolerance_m {
            self.enter(Phase::AlignHeading, now);
            return;
        }
        self.homing.n_corrections += 1;
        self.homing.since = now;
        if self.homing.n_corrections > N_CORRECTIONS_MAX {
            self.fail(FailureReason::MissedGoal, now, commands);
            return;
        }
        let behind = -way;
        let bearing_rad = wrap_to_pi(behind.y.atan2(behind.x) - self.pose.yaw_rad);
        let back_up = way.norm() <= BACK_UP_MAX_M
            && bearing_rad.abs() <= BACK_UP_BEARING_RAD
            && self.retreat_room_m() > 0.04;
        self.homing.stage = if back_up { Stage::BackUp } else { Stage::Aim };
    }

    fn back_up_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        let pose = self.pose_now(now);
        let behind_m = (pose.position() - goal).dot(&pose.heading());
        let stalled = self.base.is_touched();
        let done = behind_m <= self.stopping_way_m()
            || self.retreat_room_m() < 0.03
            || stalled
            || now.since(self.homing.since) > SETTLE_LIMIT;
        if done {
            self.settle(now, commands);
        } else {
            self.drive(WheelReference::straight(-self.creep_mps()), now, commands);
        }
    }

    /// Turns to the goal's heading; arrived is who then stands, at the place and looking the way asked for.
    pub(crate) fn align_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal else { return };
        let tolerance_rad = self.config.settings.heading_tolerance_rad;
        match self.turn_to(goal.se2().yaw_rad, tolerance_rad, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done if !self.stillness.is_at_rest() => {}
            TurnStatus::Done => {
                let off_m = (goal.se2().position() - self.pose.position()).norm();
                if off_m > self.config.settings.goal_tolerance_m {
                    // Turning has moved it away.
                    self.enter(Phase::Approach, now);
                    self.settle(now, commands);
                    return;
                }
                self.forget_task(now);
                self.goal = Some(goal);
                self.enter(Phase::Arrived, now);
                commands.push(Command::Report(Report::Arrived));
            }
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    /// Orders a turn in place, waits for its end, orders it again when it takes too long.
    pub(crate) fn turn_to(
        &mut self,
        heading_rad: f64,
        tolerance_rad: f64,
        now: Stamp,
        commands: &mut Vec<Command>,
    ) -> TurnStatus {
        let error_rad = wrap_to_pi(heading_rad - self.pose.yaw_rad);
        let wheels = self.base.wheel_speeds();
        let still = wheels.left_mps.abs() < 0.03 && wheels.right_mps.abs() < 0.03;
        if error_rad.abs() <= tolerance_rad && still {
            self.turn = None;
            return TurnStatus::Done;
        }
        let turn = match self.turn {
            Some(turn) if now.since(turn.ordered) < TURN_LIMIT => {
                let changed = wrap_to_pi(heading_rad - turn.heading_rad).abs() > 0.1;
                // An order that was lost on the way shows as standing still off the heading.
                let ignored = still && now.since(turn.ordered) > Duration::from_millis(1200);
                if !changed && !ignored {
                    return TurnStatus::Turning;
                }
                let n_orders = turn.n_orders + u32::from(ignored);
                Turn { heading_rad, ordered: now, n_orders, ..turn }
            }
            Some(turn) => Turn { heading_rad, ordered: now, n_orders: turn.n_orders + 1, ..turn },
            None if !still => {
                self.stop_wheels(commands);
                return TurnStatus::Turning;
            }
            None => Turn { heading_rad, begun: now, ordered: now, n_orders: 1 },
        };
        let too_long = now.since(turn.begun) > TURN_LIMIT_TOTAL;
        if turn.n_orders > N_TURN_ORDERS_MAX || too_long {
            self.turn = None;
            self.stop_wheels(commands);
            return TurnStatus::GaveUp;
        }
        if !self.turn_is_safe(error_rad) {
            // What was heard may be forgotten or seen through before the time is over.
            self.turn = Some(Turn { ordered: now, n_orders: 1, ..turn });
            self.stop_wheels(commands);
            return TurnStatus::Turning;
        }
        self.turn = Some(turn);
        self.order_turn(heading_rad, commands);
        TurnStatus::Turning
    }

    pub(crate) fn order_turn(&mut self, heading_rad: f64, commands: &mut Vec<Command>) {
        self.motion = WheelReference::STOP;
        let offset_rad = self.map_from_odom.se2().yaw_rad;
        let heading_in_odom_rad = wrap_to_pi(heading_rad - offset_rad);
        commands.push(Command::TurnTo { heading_in_odom_rad });
    }

    /// Whether turning in place touches nothing that was heard lately.
    pub(crate) fn turn_is_safe(&self, turn_rad: f64) -> bool {
        if self.config.settings.avoidance == Avoidance::Off {
            return true;
        }
        let clearance_m =
            self.echoes.clearance_of_turn_m(self.pose, turn_rad, &self.config.footprint);
        clearance_m > TURN_MARGIN_M && !self.tail_may_hit_a_wall(turn_rad)
    }

    /// Where the robot was switched on it has heard nothing beside its tail yet: what a side sensor
    /// hears then is taken to go on backwards, like a wall.
    pub(crate) fn tail_may_hit_a_wall(&self, turn_rad: f64) -> bool {
        if self.config.settings.avoidance == Avoidance::Off {
            return false;
        }
        if self.driven_m >= KNOWS_ITS_SIDES_AFTER_M {
            return false;
        }
        let footprint = &self.config.footprint;
        let reach_m = footprint.turning_radius_m() + TURN_MARGIN_M;
        let mut readings = self.config.settings.sensors.iter().zip(self.base.ranges_m());
        readings.any(|(sensor, range_m)| {
            let sine = sensor.bearing_rad.sin();
            let aside_m = sensor.in_base.y + range_m * sine;
            // Turning to the right swings the tail to the left.
            let swings_there = aside_m * turn_rad < 0.0;
            sine.abs() > 0.94 && swings_there && aside_m.abs() < reach_m && {
                let wall = (0..8).map(|k| Vec2::new(-0.05 * f64::from(k), aside_m));
                let mut gaps =
                    wall.map(|p| footprint.distance_while_turning_m(Se2::IDENTITY, turn_rad, p));
                gaps.any(|gap_m| gap_m < TURN_MARGIN_M)
            }
        })
    }

    /// Turns in an arc where a turn in place has no room: its tail swings out less.
    ///
    /// Whether it still turns; ends at the heading, before a thing, or after [`CURVE_LIMIT`].
    pub(crate) fn curve_step(&mut self, now: Stamp, commands: &mut Vec<Command>) -> bool {
        let Some((heading_rad, since)) = self.curve else { return false };
        let error_rad = wrap_to_pi(heading_rad - self.pose.yaw_rad);
        let done = error_rad.abs() < 0.06
            || now.since(since) > CURVE_LIMIT
            || self.something_is_at_the_nose(f64::INFINITY);
        if done {
            self.curve = None;
            self.stop_wheels(commands);
            return false;
        }
        let speed_mps = 0.5 * self.config.settings.speed_mps;
        let (inner, outer) = (0.4 * speed_mps, 1.6 * speed_mps);
        let (left_mps, right_mps) = if error_rad > 0.0 { (inner, outer) } else { (outer, inner) };
        self.drive(WheelReference { left_mps, right_mps }, now, commands);
        true
    }
}
