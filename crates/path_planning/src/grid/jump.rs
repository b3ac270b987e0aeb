//! Jump points, with the bits of 64 cells looked at together.
//!
//! Of the many equally short ways over a free floor one is enough: diagonal steps first, then straight ones, and another
//! turn only behind a corner. So a search need keep only cells behind corners, and everything between them is a scan along
//! bits.
//!
//! Source: Harabor, Grastien (2014), "Improving jump point search", ICAPS: scans of blocks of bits and the pruning of
//! cells between. Differences: no corner is cut, so a straight way turns beside the cell *behind* a blocked one, and
//! diagonal steps have no forced neighbours (Sturtevant, Rabin (2016), "Canonical orderings on grids", IJCAI).

use std::{cmp::Ordering, f64::consts::SQRT_2};

use grid_maps::Cell;

use super::{
    Budget, Ended, GridSearch,
    floor::{BitRows, STEPS, WORD},
    octile,
    open::SAME_WAY,
};

/// A way along bits, and where it may end before a corner: the goal, if it is in this row.
#[derive(Clone, Copy)]
struct Scan {
    from: u32,
    /// A number that no bit has where the goal is not.
    goal: u32,
}

/// No bit.
const NOWHERE: u32 = u32::MAX;

impl BitRows {
    /// Cells of a word behind a corner for who comes from lower bits: the one before it is blocked beside, itself is not.
    #[inline]
    fn corners_up(&self, word: usize) -> u64 {
        let beside = |word: usize| {
            let (here, before) = (self.words[word], self.words[word - 1]);
            (here << 1 | before >> 63) & !here
        };
        beside(word - self.n_words as usize) | beside(word + self.n_words as usize)
    }

    /// The same for who comes from higher bits.
    #[inline]
    fn corners_down(&self, word: usize) -> u64 {
        let beside = |word: usize| {
            let (here, after) = (self.words[word], self.words[word + 1]);
            (here >> 1 | after << 63) & !here
        };
        beside(word - self.n_words as usize) | beside(word + self.n_words as usize)
    }

    /// Towards higher bits: the first cell behind a corner, or the goal; `None` where the way ends before.
    #[inline]
    fn jump_up(&self, Scan { from, goal }: Scan) -> Option<u32> {
        let mut word = (from / WORD) as usize;
        // Bits above the one it comes from.
        let mut mask = u64::MAX.checked_shl(from % WORD + 1).unwrap_or(0);
        loop {
            let blocked = self.words[word];
            let found = (self.corners_up(word) | blocked) & mask;
            if found != 0 {
                let bit = found.trailing_zeros();
                let at = word as u32 * WORD + bit;
                if goal > from && goal <= at {
                    // The goal is free: it is not the blocked cell that ends the way.
                    return Some(goal);
                }
                return (blocked >> bit & 1 == 0).then_some(at);
            }
            word += 1;
            mask = u64::MAX;
        }
    }

    /// The same towards lower bits.
    #[inline]
    fn jump_down(&self, Scan { from, goal }: Scan) -> Option<u32> {
        let mut word = (from / WORD) as usize;
        let mut mask = !(u64::MAX << (from % WORD));
        loop {
            let blocked = self.words[word];
            let found = (self.corners_down(word) | blocked) & mask;
            if found != 0 {
                let bit = found.ilog2();
                let at = word as u32 * WORD + bit;
                if goal < from && goal >= at {
                    return Some(goal);
                }
                return (blocked >> bit & 1 == 0).then_some(at);
            }
            word -= 1;
            mask = u64::MAX;
        }
    }

    /// Which bits beside a bit, in the rows below and above, are free although those before them are blocked.
    #[inline]
    fn forced(&self, bit: u32, towards_higher: bool) -> [bool; 2] {
        let stride = self.n_words * WORD;
        let before = if towards_higher { bit - 1 } else { bit + 1 };
        [bit - stride, bit + stride].map(|beside| {
            let before = if beside < bit { before - stride } else { before + stride };
            self.is_blocked(before) && !self.is_blocked(beside)
        })
    }
}

/// The goal of a search, as a bit of both kinds of rows.
#[derive(Clone, Copy)]
struct Goal {
    node: u32,
    turned: u32,
    cell: Cell,
}

impl GridSearch {
    pub(super) fn jump_search(&mut self, from: u32, to: u32, budget: Budget) -> Ended {
        let cell = self.floor.cell(to);
        let turned = self.floor.turned(to);
        let goal = Goal { node: to, turned, cell };
        let estimate = octile(self.floor.cell(from), cell);
        self.open.begin(estimate);
        self.nodes.improve(from, from, 0.0);
        self.open.push(from, estimate);
        while let Some(node) = self.open.pop_within(self.way_to(to)) {
            let Some((way, parent)) = self.nodes.close(node) else { continue };
            if !self.may_expand(budget) {
                return Ended::BudgetSpent;
            }
            let directions = if node == from { 255 } else { self.directions(parent, node) };
            self.expand(node, way, directions, goal);
        }
        if self.way_to(to).is_finite() { Ended::Found } else { Ended::Exhausted }
    }

    fn way_to(&self, node: u32) -> f64 {
        self.nodes.get(node).map_or(f64::INFINITY, |known| known.way + SAME_WAY)
    }

    /// The directions in which a shortest way may go on from a jump point: straight on, and around the corners beside
    /// it. The last piece of the way to it is straight.
    fn directions(&self, parent: u32, node: u32) -> u8 {
        let (a, b) = (self.floor.cell(parent), self.floor.cell(node));
        let (columns, rows) = (b.column - a.column, b.row - a.row);
        // Diagonal first: what is left of the longer side is straight.
        let when = |is_so: bool, directions: u8| if is_so { directions } else { 0 };
        match columns.abs().cmp(&rows.abs()) {
            Ordering::Greater => {
                let right = columns > 0;
                let [below, above] = self.floor.rows.forced(node, right);
                if right {
                    1 | when(below, 0b1100_0000) | when(above, 0b0000_0110)
                } else {
                    16 | when(below, 0b0110_0000) | when(above, 0b0000_1100)
                }
            }
            Ordering::Less => {
                let up = rows > 0;
                let [left, right] = self.floor.columns.forced(self.floor.turned(node), up);
                if up {
                    4 | when(left, 0b0001_1000) | when(right, 0b0000_0011)
                } else {
                    64 | when(left, 0b0011_0000) | when(right, 0b1000_0001)
                }
            }
            // Only the goal is come to diagonally, and nothing lies behind it.
            Ordering::Equal => 0,
        }
    }

    fn expand(&mut self, node: u32, way: f64, directions: u8, goal: Goal) {
        let turned = self.floor.turned(node);
        for d in 0..8 {
            if directions >> d & 1 == 0 {
                continue;
            }
            if d % 2 == 0 {
                if let Some(next) = self.jump(node, turned, d, goal) {
                    self.reach(next, node, way, goal);
                }
            } else {
                self.slide(node, way, d, goal);
            }
        }
    }

    /// Along one of the four straight directions.
    #[inline]
    fn jump(&self, node: u32, turned: u32, d: usize, goal: Goal) -> Option<u32> {
        let floor = &self.floor;
        let in_row = |bit: u32, goal: u32, stride: u32| {
            if bit / stride == goal / stride { goal } else { NOWHERE }
        };
        let along_row = || Scan { from: node, goal: in_row(node, goal.node, floor.stride()) };
        let column_stride = floor.columns.n_words * WORD;
        let along_column =
            || Scan { from: turned, goal: in_row(turned, goal.turned, column_stride) };
        match d {
            0 => floor.rows.jump_up(along_row()),
            2 => floor.columns.jump_up(along_column()).map(|bit| floor.turned_back(bit)),
            4 => floor.rows.jump_down(along_row()),
            _ => floor.columns.jump_down(along_column()).map(|bit| floor.turned_back(bit)),
        }
    }

    /// Along a diagonal, looking aside at each step.
    fn slide(&mut self, from: u32, from_way: f64, d: usize, goal: Goal) {
        let offset = self.floor.offsets()[d];
        let (dx, dy) = STEPS[d];
        let turned_offset = (dx * (self.floor.columns.n_words * WORD) as i32 + dy) as u32;
        let (aside_x, aside_y) = (if dx > 0 { 0 } else { 4 }, if dy > 0 { 2 } else { 6 });
        let (mut node, mut turned, mut way) = (from, self.floor.turned(from), from_way);
        while self.floor.open_steps(node) >> d & 1 == 1 {
            node = node.wrapping_add(offset);
            turned = turned.wrapping_add(turned_offset);
            way += SQRT_2;
            if node == goal.node {
                if self.nodes.improve(node, from, way) {
                    self.open.push(node, way);
                }
                return;
            }
            for aside in [aside_x, aside_y] {
                if let Some(next) = self.jump(node, turned, aside, goal) {
                    let cell = self.floor.cell(node);
                    let next_way = way + octile(cell, self.floor.cell(next));
                    self.offer(next, from, next_way, goal);
                }
            }
        }
    }

    fn reach(&mut self, next: u32, node: u32, way: f64, goal: Goal) {
        let length = octile(self.floor.cell(node), self.floor.cell(next));
        self.offer(next, node, way + length, goal);
    }

    fn offer(&mut self, next: u32, parent: u32, way: f64, goal: Goal) {
        if self.nodes.improve(next, parent, way) {
            let cell = self.floor.cell(next);
            let left = octile(cell, goal.cell);
            self.open.push(next, way + left);
        }
    }
}
