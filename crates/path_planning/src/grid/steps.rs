//! A* over the eight neighbours.
//!
//! Source: Hart, Nilsson, Raphael (1968), "A formal basis for the heuristic determination of minimum cost paths",
//! IEEE Trans. Systems Science and Cybernetics 4(2). Differences: the queue is sorted in buckets of a quarter of a
//! step, so a cell may be expanded again; what is found is as short.

use super::{Budget, Ended, GridSearch, octile};

/// Length of a step in each direction, cells.
const LENGTHS: [f64; 8] = [1.0, SQRT_2, 1.0, SQRT_2, 1.0, SQRT_2, 1.0, SQRT_2];

use std::f64::consts::SQRT_2;

impl GridSearch {
    pub(super) fn step_search(&mut self, from: u32, to: u32, budget: Budget) -> Ended {
        let goal = self.floor.cell(to);
        let offsets = self.floor.offsets();
        let estimate = octile(self.floor.cell(from), goal);
        self.open.begin(estimate);
        self.nodes.improve(from, from, 0.0);
        self.open.push(from, estimate);
        let mut best = if from == to { 0.0 } else { f64::INFINITY };
        while let Some(node) = self.open.pop_within(best) {
            let Some((way, _)) = self.nodes.close(node) else { continue };
            if !self.may_expand(budget) {
                return Ended::BudgetSpent;
            }
            let mut open = self.floor.open_steps(node);
            while open != 0 {
                let d = open.trailing_zeros() as usize & 7;
                open &= open - 1;
                let next = node.wrapping_add(offsets[d]);
                let next_way = way + LENGTHS[d];
                if self.nodes.improve(next, node, next_way) {
                    let estimate = next_way + octile(self.floor.cell(next), goal);
                    self.open.push(next, estimate);
                    if next == to {
                        best = next_way;
                    }
                }
            }
        }
        if best.is_finite() { Ended::Found } else { Ended::Exhausted }
    }
}
