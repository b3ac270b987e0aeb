//! Orders to one robot, and what the ground knows of them: goals, stops, questions, MOVE of the decision program.

use std::time::Duration;

use decision::MoveReport;
use messages::{Command, Observations, Order, Sensed};
use navigator::Phase;
use run_context::{Stamp, StateHash};

use crate::{
    asked::Asked,
    node::{
        desk::{Desk, GroundOrder, Telemetry},
        inquiry::Inquiry,
    },
    view::LogLevel,
};

/// A question that nobody has answered for so long is given up, whatever line it went over.
const ANSWER_WITHIN: Duration = Duration::from_secs(10);

/// Who gives an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OrderBy {
    /// The decision program, with a MOVE of that number.
    Program(u64),
    /// Somebody at the ground station, or the mission's plan.
    Person,
    /// Somebody who drives it by hand from now on.
    Hand,
    /// The decision node, because its program has stopped.
    Failsafe,
}

/// A MOVE of the decision program, as long as nobody has given it another.
#[derive(Clone, Copy, Debug)]
struct ProgramMove {
    number: u64,
    /// What became of it when somebody else gave an order; before that the telemetry says it.
    end: Option<(MoveReport, &'static str)>,
}

/// Whether somebody ended its task for good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Halt {
    #[default]
    No,
    Due,
    Done,
}

/// The orders to one robot.
#[derive(Debug, Default)]
pub(super) struct Orders {
    pub(super) desk: Desk,
    /// An order was given and has not reached the navigator yet.
    is_under_way: bool,
    inquiry: Inquiry,
    /// The last MOVE of the decision program that it was given.
    program_move: Option<ProgramMove>,
    /// Takes no more orders.
    halts: Halt,
}

impl Orders {
    /// Puts an order on the desk; it leaves at the next step. From now on nothing is believed of the goal before.
    /// A robot that was halted takes none: `false`.
    pub(super) fn give(&mut self, order: GroundOrder, by: OrderBy) -> bool {
        if self.halts != Halt::No {
            return false;
        }
        self.end_program_move(order, by);
        self.desk.order = Some(order);
        self.is_under_way = true;
        self.desk.telemetry = match order {
            GroundOrder::GoTo(_) => Telemetry::UnderWay,
            GroundOrder::Stop | GroundOrder::Restart => Telemetry::NoGoal,
        };
        true
    }

    /// Asks it something; a restart is an order besides, which whoever calls has given.
    pub(super) fn ask(&mut self, asked: Asked, now: Stamp) {
        if self.halts != Halt::No {
            return;
        }
        if asked != Asked::Restart {
            self.desk.question = Some(asked);
        }
        self.inquiry.begin(asked, now);
    }

    /// Ends its task for good. The ground is told to send a stop, so that it repeats no goal; one that is still on its
    /// way to the robot is not obeyed.
    pub(super) fn halt(&mut self) {
        self.halts = Halt::Due;
        self.desk.order = Some(GroundOrder::Stop);
        self.is_under_way = false;
    }

    /// What of the orders that arrive is for the navigator: of a robot that was halted none, and a stop of its own.
    pub(super) fn filter(&mut self, now: Stamp, phase: Phase, observations: &mut Observations) {
        if self.halts != Halt::No {
            observations.retain(|seen| !matches!(seen.value, Sensed::Order(_)));
        }
        if self.halts == Halt::Due && is_busy(phase) {
            observations.push(now, Sensed::Order(Order::Stop));
        }
    }

    /// What of the navigator's commands is for a robot that was halted: nothing that moves it.
    pub(super) fn hold_back(&mut self, commands: &mut Vec<Command>) {
        if self.halts != Halt::No {
            commands.retain(|c| !matches!(c, Command::Drive(_) | Command::TurnTo { .. }));
        }
        if self.halts == Halt::Due {
            self.halts = Halt::Done;
            commands.push(Command::Stop);
        }
    }

    /// The navigator was told something.
    pub(super) fn hear(&mut self, value: &Sensed) {
        if matches!(value, Sensed::Order(_)) {
            self.is_under_way = false;
        }
    }

    /// Hands over what the ground learnt in this step of what it had asked.
    pub(super) fn take_answers(&mut self, now: Stamp, mut tell: impl FnMut(LogLevel, String)) {
        let late = self.inquiry.give_up(now, ANSWER_WITHIN);
        for event in &self.desk.events {
            if let Some((level, text)) = self.inquiry.hear(*event, now) {
                tell(level, text);
            }
        }
        if let Some((level, text)) = late {
            tell(level, text);
        }
    }

    /// A new order ends the MOVE before: one that was under way will not be done any more, and from
    /// one that was done the robot is sent away.
    fn end_program_move(&mut self, order: GroundOrder, by: OrderBy) {
        if let OrderBy::Program(number) = by {
            self.program_move = Some(ProgramMove { number, end: None });
            return;
        }
        let telemetry = self.desk.telemetry;
        let Some(program_move) = &mut self.program_move else { return };
        if program_move.end.is_some_and(|(report, _)| report != MoveReport::Done) {
            return;
        }
        let is_done = program_move.end.is_some() || telemetry == Telemetry::Arrived;
        program_move.end = Some(match (telemetry, order) {
            (Telemetry::Failed(reason), _) => (MoveReport::Failed, reason),
            (_, GroundOrder::GoTo(_)) if is_done => {
                (MoveReport::Left, "the robot is sent elsewhere")
            }
            (_, GroundOrder::GoTo(_)) => (MoveReport::Failed, "somebody sent the robot elsewhere"),
            _ if is_done && by == OrderBy::Hand => {
                (MoveReport::Left, "the robot is driven away by hand")
            }
            _ if is_done => (MoveReport::Done, "the robot stands there"),
            _ if by == OrderBy::Failsafe => (MoveReport::Failed, "the program has stopped"),
            _ if by == OrderBy::Hand => (MoveReport::Failed, "somebody drives the robot by hand"),
            (_, GroundOrder::Restart) => (MoveReport::Failed, "somebody restarted the robot"),
            _ => (MoveReport::Failed, "somebody stopped the robot"),
        });
    }

    /// Whether it is on its way for a MOVE of the decision program.
    pub(super) fn is_on_program_move(&self) -> bool {
        self.program_move.is_some_and(|m| m.end.is_none())
            && self.desk.telemetry == Telemetry::UnderWay
    }

    /// What the ground knows of the last MOVE that it was given: its number, what became of it and
    /// why; `None` while it is under way.
    pub(super) fn program_move(&self) -> Option<(u64, MoveReport, &'static str)> {
        let ProgramMove { number, end } = self.program_move?;
        let (report, why) = match (end, self.desk.telemetry) {
            (Some(end), _) => end,
            (None, Telemetry::Arrived) => (MoveReport::Done, "the robot stands there"),
            (None, Telemetry::Failed(reason)) => (MoveReport::Failed, reason),
            (None, _) => return None,
        };
        Some((number, report, why))
    }

    /// Whether an order was given that has not reached the navigator yet.
    pub(super) fn is_under_way(&self) -> bool {
        self.is_under_way
    }

    /// Why the robot will not come to its goal, as far as the ground knows.
    pub(super) fn failure(&self) -> Option<&'static str> {
        match self.desk.telemetry {
            Telemetry::Failed(reason) => Some(reason),
            _ => None,
        }
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        self.inquiry.absorb_state(hash);
    }
}

/// Whether a navigator may move its robot.
fn is_busy(phase: Phase) -> bool {
    !matches!(phase, Phase::Idle | Phase::Arrived | Phase::Failed(_))
}
