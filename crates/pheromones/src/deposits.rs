//! Deposits that evaporate: the part of the field that time changes.

use std::time::Duration;

use crate::{Field, FieldError, VALUE_MAX, deposit::Deposit, field::is_source};

impl Field {
    /// Adds evaporating pheromone to a cell, as a passing robot does; the cell's sum stays ≤ 127.
    ///
    /// What was still there of earlier deposits is kept and starts to age anew. Returns the new value.
    /// A reserved cell (≥ 128) takes nothing and returns its value.
    ///
    /// # Errors
    ///
    /// [`FieldError::Outside`]; nothing is changed.
    pub fn deposit(&mut self, col: usize, row: usize, amount: u8) -> Result<u8, FieldError> {
        let cell_index = self.cell_index(col, row)?;
        let value = self.value(col, row);
        if value > VALUE_MAX || amount == 0 {
            return Ok(value);
        }
        let new_value = value.saturating_add(amount).min(VALUE_MAX);
        let base = self.deposits.get(&cell_index).map_or(value, |deposit| deposit.base);
        if new_value > base {
            let deposit = Deposit { base, peak: new_value - base, age_ns: 0 };
            self.deposits.insert(cell_index, deposit);
        }
        self.put(cell_index, new_value);
        Ok(new_value)
    }

    /// Lets all deposits age by `elapsed`; after `lifetime` (τ) without refreshment one is gone.
    ///
    /// Exact: any way of cutting a stretch of time into calls with one lifetime gives the same field.
    /// Values are rounded up to whole numbers, so a deposit smells of at least 1 until its end. Lasting
    /// sources stay. O(deposits). Returns how many cells changed.
    ///
    /// Source: the thesis, (5.34), p(t) = p₀ (1 − t/τ). Differences: each deposit has its own age, which
    /// (5.36) leaves open; whole numbers.
    pub fn evaporate(&mut self, elapsed: Duration, lifetime: Duration) -> usize {
        let elapsed_ns = u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX);
        let lifetime_ns = u64::try_from(lifetime.as_nanos()).unwrap_or(u64::MAX);
        let mut deposits = std::mem::take(&mut self.deposits);
        let mut n_changed = 0;
        deposits.retain(|&cell_index, deposit| {
            deposit.age_ns = deposit.age_ns.saturating_add(elapsed_ns);
            let level = deposit.level(lifetime_ns);
            let value = deposit.base + level; // base + peak ≤ 127
            n_changed += usize::from(self.values()[cell_index] != value);
            self.put(cell_index, value);
            level > 0
        });
        self.deposits = deposits;
        n_changed
    }

    /// Turns every lasting source into a deposit of age zero, so that a drawn trail evaporates too.
    pub fn make_volatile(&mut self) {
        for cell_index in 0..self.values().len() {
            let value = self.values()[cell_index];
            if is_source(value) {
                let deposit = Deposit { base: 0, peak: value, age_ns: 0 };
                self.deposits
                    .entry(cell_index)
                    .and_modify(|d| {
                        // The evaporating part keeps its age only if there was nothing underneath.
                        if d.base > 0 {
                            *d = deposit;
                        }
                    })
                    .or_insert(deposit);
            }
        }
    }

    /// Cells with something in them that evaporates.
    pub fn n_deposits(&self) -> usize {
        self.deposits.len()
    }
}
