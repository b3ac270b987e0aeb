//! Lazy Theta*: ways of straight lines in any direction.
//!
//! Source: Nash, Koenig, Tovey (2010), "Lazy Theta*: any-angle path planning and path length analysis in 3D", AAAI.
//! Differences: lines run between the middles of cells, and one that passes through a corner needs both
//! cells beside it free.

use super::{Budget, Ended, GridSearch};

impl GridSearch {
    pub(super) fn any_angle_search(&mut self, from: u32, to: u32, budget: Budget) -> Ended {
        let offsets = self.floor.offsets();
        let estimate = self.straight(from, to);
        self.open.begin(estimate);
        self.nodes.improve(from, from, 0.0);
        self.open.push(from, estimate);
        let mut best = f64::INFINITY;
        while let Some(node) = self.open.pop_within(best) {
            let Some((_, parent)) = self.nodes.close(node) else { continue };
            if !self.may_expand(budget) {
                return Ended::BudgetSpent;
            }
            self.settle(node, parent, &offsets);
            let Some(&known) = self.nodes.get(node) else { continue };
            if node == to {
                best = best.min(known.way);
                continue;
            }
            let mut open = self.floor.open_steps(node);
            while open != 0 {
                let d = open.trailing_zeros() as usize & 7;
                open &= open - 1;
                let next = node.wrapping_add(offsets[d]);
                // As if its parent saw it.
                let way = self.nodes.get(known.parent).map_or(0.0, |parent| parent.way)
                    + self.straight(known.parent, next);
                if self.nodes.improve(next, known.parent, way) {
                    self.open.push(next, way + self.straight(next, to));
                }
            }
        }
        if best.is_finite() { Ended::Found } else { Ended::Exhausted }
    }

    /// Whether its parent truly sees a cell is looked at only when it is expanded: if not, the best of the neighbours that
    /// were expanded becomes its parent.
    fn settle(&mut self, node: u32, parent: u32, offsets: &[u32; 8]) {
        let cell = self.floor.cell(node);
        if parent == node || self.floor.sees(self.floor.cell(parent), cell) {
            return;
        }
        let mut best: Option<(f64, u32)> = None;
        let open = self.floor.open_steps(node);
        for (d, offset) in offsets.iter().enumerate() {
            let beside = node.wrapping_add(*offset);
            if open >> d & 1 == 1
                && let Some(known) = self.nodes.get(beside).filter(|known| known.is_closed())
            {
                let way = known.way + self.straight(beside, node);
                if best.is_none_or(|(least, _)| way < least) {
                    best = Some((way, beside));
                }
            }
        }
        if let Some((way, beside)) = best {
            self.nodes.amend(node, beside, way);
        }
    }

    fn straight(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (self.floor.cell(a), self.floor.cell(b));
        f64::from(a.column - b.column).hypot(f64::from(a.row - b.row))
    }
}
