//! The decision node: reads its inputs, scans its program every 10 ms, drives its outputs.
//!
//! In the thesis's rigs this is a microcontroller on the ground (Fig. 7.4) that polls a data
//! acquisition block. Its time per function (`decision::FUNCTION_MS`) gives the length of a scan; a scan longer than the 200 ms
//! that the thesis allows a node counts as an overrun.

use decision::{Machine, Mode, MoveCommand, Operand, Program, ResourceId};
use geometry::Se2;
use run_context::StateHash;

use super::devices::Devices;
use crate::mission::plan::DecisionPlan;

/// Instructions of a scan that are no functions: it reads the inputs first and writes the outputs last.
const N_IMAGE_INSTRUCTIONS: usize = 2;

/// The decision node of a mission.
#[derive(Debug)]
pub(super) struct DecisionNode {
    machine: Machine,
    robot: Option<usize>,
    arrived_input: Option<u8>,
    failed_input: Option<u8>,
    n_scans: u64,
    n_moves: u64,
    cycle_max_ms: f64,
    /// The resources that the program names and the outputs of its timers, each once.
    named: Vec<(String, ResourceId)>,
}

impl DecisionNode {
    pub(super) fn new(plan: &DecisionPlan) -> Self {
        let mode = if plan.listing_mode { Mode::Listing } else { Mode::Corrected };
        let mut machine = Machine::new(plan.program.clone(), mode);
        machine.run();
        let named = named(&plan.program);
        Self {
            machine,
            robot: plan.robot,
            arrived_input: plan.arrived_input,
            failed_input: plan.failed_input,
            n_scans: 0,
            n_moves: 0,
            cycle_max_ms: 0.0,
            named,
        }
    }

    /// The resources that the program names, with their bytes, always in the same order.
    pub(super) fn resources(&self) -> impl Iterator<Item = (&str, u8)> {
        self.named.iter().map(|(name, id)| (name.as_str(), self.machine.resource(*id)))
    }

    /// The robot that MOVE commands.
    pub(super) fn robot(&self) -> Option<usize> {
        self.robot
    }

    /// 10 ms of the node: inputs, timers, one scan. `send` takes the goals of MOVE.
    pub(super) fn step(
        &mut self,
        devices: &Devices,
        (arrived, failed): (bool, bool),
        mut send: impl FnMut(Se2),
    ) {
        for (number, value) in devices.inputs() {
            self.machine.set_input(number, value);
        }
        if let Some(number) = self.arrived_input {
            self.machine.set_input(number, arrived);
        }
        if let Some(number) = self.failed_input {
            self.machine.set_input(number, failed);
        }
        self.machine.tick_10ms();
        let report = self.machine.scan();
        self.n_scans += 1;
        let n_functions = report.n_instructions.saturating_sub(N_IMAGE_INSTRUCTIONS);
        self.cycle_max_ms = self.cycle_max_ms.max(n_functions as f64 * decision::FUNCTION_MS);
        let n_moves = &mut self.n_moves;
        self.machine.drain_moves(|goal| {
            *n_moves += 1;
            send(pose(goal));
        });
    }

    pub(super) fn machine(&self) -> &Machine {
        &self.machine
    }

    pub(super) fn n_scans(&self) -> u64 {
        self.n_scans
    }

    /// MOVE commands so far.
    pub(super) fn n_moves(&self) -> u64 {
        self.n_moves
    }

    /// The longest scan so far on the thesis's microcontroller, ms.
    pub(super) fn cycle_max_ms(&self) -> f64 {
        self.cycle_max_ms
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        self.machine.absorb_state(hash);
        hash.absorb_u64(self.n_moves);
    }
}

fn named(program: &Program) -> Vec<(String, ResourceId)> {
    let mut named: Vec<(String, ResourceId)> = Vec::new();
    for function in program.functions() {
        let timer = function.operands.first().and_then(Operand::immediate);
        let timer = timer.filter(|_| function.mnemonic.name() == "TIMER");
        let timer = timer.and_then(|n| ResourceId::by_name(&format!("YTMR{n}")).ok());
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
