//! What became of the last `MOVE`, and the inputs that tell the program.
//!
//! `MOVE` only asks: another node drives, and reports. Its reports reach the program as digital
//! inputs ([`MovePoints`]), and they are always about the *last* `MOVE`: the instruction itself
//! takes the answer to the one before off those inputs, so that the functions below it, in the
//! same scan, already see a robot that is busy. Each `MOVE` has a number; a report with another
//! number is not believed.
//!
//! Source: none. The thesis prints `MOVE` without an answer and names the lack (§4.3: "no handling
//! of errors"); its figures let a limit switch say that an action is complete.

use run_context::StateHash;

/// How `done` and `failed` appear on their inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MoveSignal {
    /// 1 from the report until the next `MOVE`, or until somebody else sends the robot away.
    #[default]
    Level,
    /// 1 in one scan.
    Pulse,
}

settings::choices!(MoveSignal {
    Level = "level": "1 until the next MOVE",
    Pulse = "pulse": "1 in one scan",
});

/// The digital inputs (0 to 15) that say what the robot is doing about the last `MOVE`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MovePoints {
    /// 1 from the `MOVE` until the report about it.
    pub busy: Option<u8>,
    /// 1 when the robot stands at its goal.
    pub done: Option<u8>,
    /// 1 when the robot has given up, or nobody will drive this `MOVE` to its end any more.
    pub failed: Option<u8>,
    /// Level or pulse; `busy` is always a level.
    pub signal: MoveSignal,
}

/// A report about a `MOVE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveReport {
    /// The robot stands at the goal.
    Done,
    /// The robot has given up, was stopped, or cannot be reached.
    Failed,
    /// The robot stood at the goal, and somebody else has sent it away.
    Left,
}

/// What became of the last `MOVE`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MoveState {
    /// There was none yet, or the robot was sent elsewhere since it was done.
    #[default]
    Idle,
    /// Nobody has reported on it yet.
    Busy,
    /// The robot stands at its goal.
    Done,
    /// It will not be done.
    Failed,
}

impl MoveState {
    /// `idle`, `busy`, `done` or `failed`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Busy => "busy",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// The last `MOVE` and its answer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LastMove {
    pub(crate) points: MovePoints,
    /// Number of the last `MOVE`, from 1; 0 before the first.
    pub(crate) number: u64,
    pub(crate) state: MoveState,
    /// An answer that no scan has read yet; only with [`MoveSignal::Pulse`].
    is_news: bool,
}

impl LastMove {
    /// A `MOVE` is executed: gives its number.
    pub(crate) fn begin(&mut self) -> u64 {
        self.number = self.number.saturating_add(1);
        (self.state, self.is_news) = (MoveState::Busy, false);
        self.number
    }

    /// A report; false when it is about another `MOVE`, or nothing that this one is waiting for.
    pub(crate) fn report(&mut self, number: u64, report: MoveReport) -> bool {
        let next = match (self.state, report) {
            (MoveState::Busy, MoveReport::Done) => MoveState::Done,
            (MoveState::Busy, MoveReport::Failed) => MoveState::Failed,
            (MoveState::Done, MoveReport::Left) => MoveState::Idle,
            _ => return false,
        };
        if number != self.number {
            return false;
        }
        (self.state, self.is_news) = (next, true);
        true
    }

    /// The inputs of the field with the points in their places; bit n is input n. A pulse is over
    /// when it was `read` by a scan.
    pub(crate) fn on(&self, field: u16) -> u16 {
        let answered = match self.points.signal {
            MoveSignal::Level => true,
            MoveSignal::Pulse => self.is_news,
        };
        let points = [
            (self.points.busy, self.state == MoveState::Busy),
            (self.points.done, self.state == MoveState::Done && answered),
            (self.points.failed, self.state == MoveState::Failed && answered),
        ];
        points.into_iter().fold(field, |field, (input, value)| {
            let bit = input.and_then(|n| 1_u16.checked_shl(n.into())).unwrap_or(0);
            if value { field | bit } else { field & !bit }
        })
    }

    /// A scan has read the inputs.
    pub(crate) fn read(&mut self) {
        self.is_news = false;
    }

    /// The machine starts over: it has sent nothing, but numbers are not given twice.
    pub(crate) fn restarted(self) -> Self {
        Self { points: self.points, number: self.number, ..Self::default() }
    }

    /// The inputs that are points.
    pub(crate) fn inputs(&self) -> [Option<u8>; 3] {
        [self.points.busy, self.points.done, self.points.failed]
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.number);
        hash.absorb_u64(self.state as u64);
        hash.absorb_u64(self.is_news.into());
    }
}
