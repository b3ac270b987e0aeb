//! The 32 timers: four groups of eight, counting in 10 ms, 100 ms, 1 s and 1 min.
//!
//! Source: the thesis, §4.2.3.4 with Tables 4.3 and 4.5, and Annex A2, `ftimer` and `timer`.
//! Differences: in [`Mode::Corrected`] every timer counts 10 ms ticks by itself, so that K quanta
//! are K quanta. In [`Mode::Listing`] the quanta come from dividers that run freely, so that the
//! first one is cut short by up to a quantum, as on the target. Table 4.3 prints 255 s where the
//! second group reaches 25.5 s, and Table 4.5 prints "rising" for EDGE 2, which is falling.

use std::time::Duration;

use run_context::StateHash;

use crate::{EdgeCode, Mode};

/// What timers, clock and watchdog count.
pub(crate) const TICK: Duration = Duration::from_millis(10);

/// Ticks in one quantum of each group.
const QUANTUM_TICKS: [u32; 4] = [1, 10, 100, 6000];

/// How a timer is told to work by its instruction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// 0 to 31.
    pub(crate) number: u8,
    pub(crate) is_oscillator: bool,
    /// What its input just did.
    pub(crate) input: EdgeCode,
    /// What its input must do.
    pub(crate) edge: EdgeCode,
    /// Quanta.
    pub(crate) k: u8,
}

#[derive(Clone, Debug)]
pub(crate) struct Timers {
    mode: Mode,
    /// What is left: ticks in corrected mode, quanta in listing mode.
    left: [u32; 32],
    /// Bit n is the phase of oscillator n.
    phases: u32,
    /// Ticks modulo one minute, for the dividers of the listing.
    divider: u32,
}

impl Timers {
    pub(crate) fn new(mode: Mode) -> Self {
        Self { mode, left: [0; 32], phases: 0, divider: 0 }
    }

    /// Executes one `TIMER` instruction and gives the timer's output.
    pub(crate) fn execute(&mut self, start: Start) -> bool {
        let quantum = match self.mode {
            Mode::Corrected => quantum_ticks(start.number),
            Mode::Listing => 1,
        };
        let full = u32::from(start.k).saturating_mul(quantum);
        let Some(left) = self.left.get_mut(usize::from(start.number)) else {
            return false;
        };
        let triggered = start.input == start.edge;
        if !start.is_oscillator {
            if triggered {
                *left = full;
            }
            return triggered || *left != 0;
        }
        // An oscillator runs on levels; an edge never starts it.
        if !triggered || matches!(start.edge, EdgeCode::Rising | EdgeCode::Falling) {
            return false;
        }
        let bit = 1_u32.checked_shl(start.number.into()).unwrap_or(0);
        if *left == 0 {
            *left = full;
            self.phases ^= bit;
        }
        self.phases & bit != 0
    }

    /// 10 ms pass.
    pub(crate) fn tick(&mut self) {
        if self.mode == Mode::Corrected {
            count_down(&mut self.left);
            return;
        }
        self.divider = self.divider.saturating_add(1);
        for (group, quantum) in self.left.chunks_exact_mut(8).zip(QUANTUM_TICKS) {
            if self.divider.is_multiple_of(quantum) {
                count_down(group);
            }
        }
        if self.divider >= QUANTUM_TICKS[3] {
            self.divider = 0;
        }
    }

    /// Time left of timer `number`. In listing mode, up to one quantum more than really is left.
    pub(crate) fn remaining(&self, number: u8) -> Duration {
        let left = self.left.get(usize::from(number)).copied().unwrap_or(0);
        let unit = match self.mode {
            Mode::Corrected => 1,
            Mode::Listing => quantum_ticks(number),
        };
        let ticks = u64::from(left).saturating_mul(unit.into());
        Duration::from_millis(ticks.saturating_mul(10))
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        self.left.iter().for_each(|&left| hash.absorb_u64(left.into()));
        hash.absorb_u64(self.phases.into());
        hash.absorb_u64(self.divider.into());
    }
}

fn count_down(timers: &mut [u32]) {
    for left in timers {
        *left = left.saturating_sub(1);
    }
}

/// Ticks in one quantum of timer `number`.
pub(crate) fn quantum_ticks(number: u8) -> u32 {
    QUANTUM_TICKS.get(usize::from(number / 8)).copied().unwrap_or(1)
}
