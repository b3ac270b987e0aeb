//! Turns: on the spot, by an order that the robot carries out itself, and in an arc where there is no room for that.

use std::time::Duration;

use geometry::wrap_to_pi;
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    around::Surroundings,
    values::{Motion, Situation},
};

/// Times that a turn is ordered before it is given up.
const N_TURN_ORDERS_MAX: u32 = 3;

/// Time after which a turn is ordered again.
const TURN_LIMIT: Duration = Duration::from_secs(6);

/// Time for a turn with all its orders, also when it must wait for room.
const TURN_LIMIT_TOTAL: Duration = Duration::from_secs(20);

/// A robot that stands so long after an order has not heard it.
const IGNORED_AFTER: Duration = Duration::from_millis(1200);

/// Time for a turn in an arc: half a turn takes 3.5 s.
const CURVE_LIMIT: Duration = Duration::from_secs(5);

/// How well the robot looks where it was to turn to in an arc, radians.
const CURVED_RAD: f64 = 0.06;

/// A turn in place that was ordered.
#[derive(Clone, Copy, Debug)]
struct Turn {
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

/// How a turn in an arc stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Curving {
    /// There is none.
    No,
    Turning(Motion),
    /// It has just ended: stand.
    Ended,
}

/// Turns that are under way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Turns {
    turn: Option<Turn>,
    /// A turn in an arc: its heading (rad, map) and since when.
    curve: Option<(f64, Stamp)>,
}

impl Turns {
    pub(crate) fn is_turning(&self) -> bool {
        self.turn.is_some()
    }

    pub(crate) fn is_curving(&self) -> bool {
        self.curve.is_some()
    }

    pub(crate) fn cancel_turn(&mut self) {
        self.turn = None;
    }

    /// Orders a turn in place, waits for its end, orders it again when it takes too long.
    pub(crate) fn turn_to(
        &mut self,
        heading_rad: f64,
        within_rad: f64,
        situation: &Situation,
        around: &Surroundings,
    ) -> (TurnStatus, Motion) {
        let (now, at) = (situation.now, &situation.at);
        let error_rad = wrap_to_pi(heading_rad - at.pose.yaw_rad);
        if error_rad.abs() <= within_rad && at.stands() {
            self.turn = None;
            return (TurnStatus::Done, Motion::Keep);
        }
        let turn = match self.turn {
            Some(turn) if now.since(turn.ordered) < TURN_LIMIT => {
                let changed = wrap_to_pi(heading_rad - turn.heading_rad).abs() > 0.1;
                // An order that was lost on the way shows as standing still off the heading.
                let ignored = at.stands() && now.since(turn.ordered) > IGNORED_AFTER;
                if !changed && !ignored {
                    return (TurnStatus::Turning, Motion::Keep);
                }
                let n_orders = turn.n_orders + u32::from(ignored);
                Turn { heading_rad, ordered: now, n_orders, ..turn }
            }
            Some(turn) => Turn { heading_rad, ordered: now, n_orders: turn.n_orders + 1, ..turn },
            None if !at.stands() => return (TurnStatus::Turning, Motion::Stop),
            None => Turn { heading_rad, begun: now, ordered: now, n_orders: 1 },
        };
        let too_long = now.since(turn.begun) > TURN_LIMIT_TOTAL;
        if turn.n_orders > N_TURN_ORDERS_MAX || too_long {
            self.turn = None;
            return (TurnStatus::GaveUp, Motion::Stop);
        }
        if !around.turn_is_safe(at, error_rad) {
            // What was heard may be forgotten or seen through before the time is over.
            self.turn = Some(Turn { ordered: now, n_orders: 1, ..turn });
            return (TurnStatus::Turning, Motion::Stop);
        }
        self.turn = Some(turn);
        (TurnStatus::Turning, Motion::Turn(heading_rad))
    }

    /// Begins to turn in an arc to a heading (rad, map).
    pub(crate) fn begin_curve(&mut self, heading_rad: f64, now: Stamp) {
        self.curve = Some((heading_rad, now));
    }

    /// Turns in an arc where a turn in place has no room: its tail swings out less.
    ///
    /// Ends at the heading, before a thing, or after [`CURVE_LIMIT`]. The robot shall drive at about `speed_mps`.
    pub(crate) fn curve(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        speed_mps: f64,
    ) -> Curving {
        let Some((heading_rad, since)) = self.curve else { return Curving::No };
        let at = &situation.at;
        let error_rad = wrap_to_pi(heading_rad - at.pose.yaw_rad);
        let nose_mps = at.speed_mps().max(situation.told.linear_mps());
        let done = error_rad.abs() < CURVED_RAD
            || situation.now.since(since) > CURVE_LIMIT
            || around.something_is_at_the_nose(nose_mps, f64::INFINITY);
        if done {
            self.curve = None;
            return Curving::Ended;
        }
        let (inner, outer) = (0.4 * speed_mps, 1.6 * speed_mps);
        let (left_mps, right_mps) = if error_rad > 0.0 { (inner, outer) } else { (outer, inner) };
        Curving::Turning(Motion::Wheels(WheelReference { left_mps, right_mps }))
    }
}
