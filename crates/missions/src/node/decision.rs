//! The decision node: reads its inputs, scans its program every 10 ms, drives its outputs.
//!
//! In the thesis's rigs this is a microcontroller on the ground (Fig. 7.4) that polls a data
//! acquisition block. Its measured 0.4 ms per function gives the length of a scan; a scan longer than the
//! 200 ms that the thesis allows a node is an error of the machine (R8006). When the program does not
//! run, for whatever reason, the outputs have their fail-safe values, and a robot that is on its way for
//! a MOVE is told to stop.

use decision::{
    FUNCTION_MS, Family, Machine, Mode, MoveCommand, MoveReport, MoveState, Operand, Program,
    ResourceId,
};
use geometry::Se2;
use run_context::StateHash;

use super::devices::Devices;
use crate::{
    mission::plan::{DecisionPlan, ProgramAction},
    view::LogLevel,
};

/// The decision node of a mission.
#[derive(Debug)]
pub(crate) struct DecisionNode {
    machine: Machine,
    robot: Option<usize>,
    /// Whether a robot on its way stops when the program does.
    stops_robot: bool,
    n_scans: u64,
    /// MOVE that were sent: those that another in the same scan replaced were not.
    n_moves_sent: u64,
    cycle_max_ms: f64,
    /// Steps for which its loop still stands, as a mission may want it.
    stalled_steps: u64,
    /// What was last told.
    told: Told,
    /// The resources that the program names and the outputs of its timers, each once.
    named: Vec<(String, ResourceId)>,
}

/// What the log has been told of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Told {
    drives_outputs: bool,
    is_faulted: bool,
    n_watchdog_resets: u64,
    n_events: u64,
}

/// What a step of the decision node asks for.
#[derive(Debug)]
pub(crate) enum Request {
    /// Send the robot to a goal, for a MOVE of that number.
    Move(u64, Se2),
    /// Stop the robot.
    StopRobot,
    /// Write into the log.
    Tell(LogLevel, String),
}

impl DecisionNode {
    pub(crate) fn new(plan: &DecisionPlan) -> Self {
        let mode = if plan.listing_mode { Mode::Listing } else { Mode::Corrected };
        let mut machine = Machine::new(plan.program.clone(), mode);
        machine.set_failsafe(plan.failsafe);
        machine.set_move_points(plan.points);
        machine.set_watchdog(plan.watchdog);
        // The mission was checked to have a clock that the calendar has.
        machine.set_clock(plan.clock);
        machine.run();
        Self {
            machine,
            robot: plan.robot,
            stops_robot: plan.stops_robot,
            n_scans: 0,
            n_moves_sent: 0,
            cycle_max_ms: 0.0,
            stalled_steps: 0,
            told: Told::default(),
            named: named(&plan.program),
        }
    }

    /// The resources that the program names, with their bytes, always in the same order.
    pub(crate) fn resources(&self) -> impl Iterator<Item = (&str, u8)> {
        self.named.iter().map(|(name, id)| (name.as_str(), self.machine.resource(*id)))
    }

    /// The robot that MOVE commands.
    pub(crate) fn robot(&self) -> Option<usize> {
        self.robot
    }

    /// What the operator of the node does to it.
    pub(crate) fn act(&mut self, action: ProgramAction) {
        match action {
            ProgramAction::Stop => self.machine.stop(),
            ProgramAction::Run => self.machine.run(),
            ProgramAction::Stall { n_steps } => self.stalled_steps = n_steps,
        }
    }

    /// 10 ms of the node: inputs, timers, one scan. `told` is what the robot's end of the link said of
    /// the last MOVE; `ask` takes what follows.
    pub(crate) fn step(
        &mut self,
        devices: &Devices,
        told: Option<(u64, MoveReport, &'static str)>,
        mut ask: impl FnMut(Request),
    ) {
        for (number, value) in devices.inputs() {
            self.machine.set_input(number, value);
        }
        self.hear(told, &mut ask);
        self.machine.tick_10ms();
        if self.machine.n_watchdog_resets() > self.told.n_watchdog_resets {
            // The watchdog has started the loop again: what the old program did ends before the new one acts.
            self.stalled_steps = 0;
            self.tell(&mut ask);
        }
        if self.stalled_steps > 0 {
            self.stalled_steps -= 1;
        } else {
            self.scan(&mut ask);
        }
        self.tell(&mut ask);
    }

    /// A report on a MOVE reaches the inputs that show it.
    fn hear(
        &mut self,
        told: Option<(u64, MoveReport, &'static str)>,
        ask: &mut impl FnMut(Request),
    ) {
        let Some((number, report, why)) = told else { return };
        // Nothing is skipped when arrival and the next order came in one step.
        let is_first = self.machine.move_state() == MoveState::Busy;
        let report = if is_first && report == MoveReport::Left { MoveReport::Done } else { report };
        if self.machine.report_move(number, report) {
            let (level, what) = match report {
                MoveReport::Done => (LogLevel::Info, "done"),
                MoveReport::Failed => (LogLevel::Warn, "failed"),
                MoveReport::Left => (LogLevel::Info, "no longer done"),
            };
            let text = format!("the decision program hears that MOVE {number} is {what}: {why}");
            ask(Request::Tell(level, text));
        }
    }

    fn scan(&mut self, ask: &mut impl FnMut(Request)) {
        let was_busy = self.machine.move_state() == MoveState::Busy;
        let before = self.machine.n_moves();
        let report = self.machine.scan();
        self.n_scans += 1;
        self.cycle_max_ms = self.cycle_max_ms.max(report.n_functions as f64 * FUNCTION_MS);
        let last = self.machine.n_moves();
        self.machine.drain_moves(|goal| {
            let number = goal.number;
            if number < last {
                let text = format!(
                    "MOVE {number} is replaced by MOVE {last} in the same scan, and not sent"
                );
                return ask(Request::Tell(LogLevel::Warn, text));
            }
            if was_busy {
                let text = format!("MOVE {number} replaces MOVE {before}, which was under way");
                ask(Request::Tell(LogLevel::Info, text));
            }
            self.n_moves_sent += 1;
            ask(Request::Move(number, pose(goal)));
        });
    }

    /// What has changed and people should know; a robot on its way stops with the program.
    fn tell(&mut self, ask: &mut impl FnMut(Request)) {
        let machine = &self.machine;
        let now = Told {
            drives_outputs: machine.drives_outputs(),
            is_faulted: machine.fault().is_some(),
            n_watchdog_resets: machine.n_watchdog_resets(),
            n_events: machine.n_events(),
        };
        let before = std::mem::replace(&mut self.told, now);
        if now == before {
            return;
        }
        let n_new = usize::try_from(now.n_events - before.n_events).unwrap_or(usize::MAX);
        let n_kept = machine.events().count();
        for event in machine.events().skip(n_kept.saturating_sub(n_new)) {
            let (kind, resource, clock) = (event.kind, event.resource, event.clock);
            let text = format!("event {kind}: {resource} at {clock} of the decision node's clock");
            ask(Request::Tell(LogLevel::Info, text));
        }
        if now.n_watchdog_resets > before.n_watchdog_resets {
            let text = "the watchdog restarts the decision program: its loop stood still (R8004)";
            ask(Request::Tell(LogLevel::Bad, text.to_owned()));
        }
        if let Some(fault) = machine.fault().filter(|_| !before.is_faulted) {
            let (code, address) = (fault.code, fault.address);
            let title = code.title().trim_end_matches('.');
            let text = format!("the decision program stops at byte {address} with {code}: {title}");
            ask(Request::Tell(LogLevel::Bad, text));
        }
        let was_reset = now.n_watchdog_resets > before.n_watchdog_resets;
        if before.drives_outputs && (!now.drives_outputs || was_reset) {
            let text = "no decision program drives the outputs: they go to their fail-safe values";
            ask(Request::Tell(LogLevel::Warn, text.to_owned()));
            if self.stops_robot {
                ask(Request::StopRobot);
            }
        }
        if now.drives_outputs && !before.drives_outputs && self.n_scans > 1 {
            let text = "the decision program drives the outputs again".to_owned();
            ask(Request::Tell(LogLevel::Info, text));
        }
    }

    /// The run is over: the program stops, and the outputs go to their fail-safe values.
    pub(crate) fn close(&mut self) {
        self.machine.stop();
    }

    pub(crate) fn machine(&self) -> &Machine {
        &self.machine
    }

    pub(crate) fn n_scans(&self) -> u64 {
        self.n_scans
    }

    /// MOVE commands that were sent so far.
    pub(crate) fn n_moves_sent(&self) -> u64 {
        self.n_moves_sent
    }

    /// The longest scan so far on the thesis's microcontroller, ms.
    pub(crate) fn cycle_max_ms(&self) -> f64 {
        self.cycle_max_ms
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        self.machine.absorb_state(hash);
        hash.absorb_u64(self.stalled_steps);
    }
}

fn named(program: &Program) -> Vec<(String, ResourceId)> {
    let mut named: Vec<(String, ResourceId)> = Vec::new();
    for function in program.functions() {
        let timer = function.timer().and_then(|n| ResourceId::of(Family::TimerOutput, n));
        for id in function.operands.iter().filter_map(Operand::resource).chain(timer) {
            if !named.iter().any(|(_, known)| *known == id) {
                named.push((id.to_string(), id));
            }
        }
    }
    named
}

fn pose(goal: MoveCommand) -> Se2 {
    let metres = |mm: i16| f64::from(mm) * 1e-3;
    Se2::new(metres(goal.x_mm), metres(goal.y_mm), f64::from(goal.heading_deg).to_radians())
}
