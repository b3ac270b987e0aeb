//! The last phases, straight to the goal and its heading, and turns in place.

use std::time::Duration;

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::WheelReference;
use robot_models::WheelSpeeds;
use run_context::Stamp;

use crate::{
    Avoidance,
    ahead::Hazard,
    messages::{Command, FailureReason, Report},
    navigator::{Navigator, SPEED_MIN_MPS},
    view::Phase,
};

/// A goal with this much freedom counts as reached when the robot has passed it, metres.
const PASSED_TOLERANCE_M: f64 = 0.20;

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

impl Navigator {
    /// Drives straight to the goal and stops there.
    pub(crate) fn approach_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal_point() else { return };
        let settings = &self.config.settings;
        let way = goal - self.pose.position();
        let distance_m = way.norm();
        let ahead_m = way.dot(&self.pose.heading());
        let passed =
            ahead_m <= 0.01 && distance_m <= PASSED_TOLERANCE_M.max(settings.goal_tolerance_m);
        if distance_m <= settings.goal_tolerance_m || passed && self.turn.is_none() {
            self.stop_wheels(commands);
            self.turn = None;
            self.enter(Phase::AlignHeading, now);
            return;
        }
        let bearing_rad = wrap_to_pi(way.y.atan2(way.x) - self.pose.yaw_rad);
        if self.turn.is_some() || bearing_rad.abs() > 0.4 {
            let heading_rad = way.y.atan2(way.x);
            match self.turn_to(heading_rad, 0.1, now, commands) {
                TurnStatus::Turning => {}
                TurnStatus::Done => {
                    self.line_from = self.pose.position();
                    self.n_approach_aims += 1;
                }
                TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
            }
            if self.n_approach_aims > 8 {
                self.fail(FailureReason::NoProgress, now, commands);
            }
            return;
        }
        if self.hazard(now) != Hazard::None {
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        let acceleration = settings.acceleration_mps2;
        // 0.8: half a period passes before a slower reference is acted upon.
        let braking_mps = 0.8 * (2.0 * acceleration * (distance_m - 0.02).max(0.0)).sqrt();
        let speed_mps =
            braking_mps.min(settings.speed_mps).max(SPEED_MIN_MPS.min(settings.speed_mps));
        let wheels = self.line_steering.step(self.pose, self.line_from, goal, speed_mps);
        self.drive(wheels, commands);
    }

    pub(crate) fn align_step(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let Some(goal) = self.goal else { return };
        let tolerance_rad = self.config.settings.heading_tolerance_rad;
        match self.turn_to(goal.se2().yaw_rad, tolerance_rad, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => {
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
        let wheels = self.status.map_or(WheelSpeeds::ZERO, |s| s.wheel_speeds);
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
        let Some(status) = self.status.filter(|_| self.driven_m < KNOWS_ITS_SIDES_AFTER_M) else {
            return false;
        };
        let footprint = &self.config.footprint;
        let reach_m = footprint.turning_radius_m() + TURN_MARGIN_M;
        let readings = self.config.settings.sensors.iter().zip(&status.sonar_ranges_m);
        readings.take(status.n_sonars).any(|(sensor, range_m)| {
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
        self.drive(WheelReference { left_mps, right_mps }, commands);
        true
    }
}
