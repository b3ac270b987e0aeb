//! The front: for each bearing of a cone the nearest surface that was offered.

use super::piece::{Piece, Surface};

/// Pieces that a view holds: more than furniture shows in the cone of a sonar.
const PIECES_MAX: usize = 48;

/// Disjoint pieces, from right to left.
#[derive(Clone, Debug)]
pub(super) struct Front {
    pieces: [Piece; PIECES_MAX],
    n: usize,
    /// What takes the place of the pieces that a new one overlaps.
    built: [Piece; PIECES_MAX],
    n_built: usize,
    overflows: bool,
}

/// Whose piece is nearer; an old one by its place.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    New,
    Old(usize),
}

impl Front {
    pub(super) fn new() -> Self {
        let nothing = Piece::new([0.0; 2], Surface::Line { inverse: [0.0; 2] }, 0);
        Self {
            pieces: [nothing; PIECES_MAX],
            n: 0,
            built: [nothing; PIECES_MAX],
            n_built: 0,
            overflows: false,
        }
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces[..self.n]
    }

    /// Whether there was no room for what should be here.
    pub(super) fn overflows(&self) -> bool {
        self.overflows
    }

    /// The greatest depth (m) of the front, if it closes the whole way between two slopes.
    pub(super) fn depth_where_closed(&self, edges: [f64; 2]) -> Option<f64> {
        let pieces = self.pieces();
        let (first, last) = (pieces.first()?, pieces.last()?);
        if first.slopes[0] > edges[0] || last.slopes[1] < edges[1] {
            return None;
        }
        let (mut reached, mut least) = (edges[0], f64::INFINITY);
        for piece in pieces {
            let [from, to] = piece.slopes;
            if from > reached {
                return None;
            }
            reached = to;
            least = least.min(piece.inverse_depth_min());
        }
        Some(1.0 / least)
    }

    /// Puts a piece in where it is nearer than what is there; says whether it shows anywhere.
    pub(super) fn insert(&mut self, new: Piece) -> bool {
        if self.overflows {
            return false;
        }
        let [from, to] = new.slopes;
        let first = self.pieces().iter().take_while(|old| old.slopes[1] <= from).count();
        let overlapped = self.pieces()[first..].iter().take_while(|old| old.slopes[0] < to).count();
        let mut shows = overlapped == 0;
        self.n_built = 0;
        let mut last = None;
        let mut at = from;
        for place in first..first + overlapped {
            let old = self.pieces[place];
            let [old_from, old_to] = old.slopes;
            if old_from > at {
                self.build(Owner::New, &new, [at, old_from], &mut last);
                shows = true;
                at = old_from;
            } else if old_from < at {
                self.build(Owner::Old(place), &old, [old_from, at], &mut last);
            }
            let end = old_to.min(to);
            let cuts = new.crossings(&old, [at, end]);
            let stops = [cuts[0], cuts[1], end];
            for stop in stops.into_iter().filter(|stop| !stop.is_nan()) {
                let middle = 0.5 * (at + stop);
                if new.inverse_depth(middle) > old.inverse_depth(middle) {
                    self.build(Owner::New, &new, [at, stop], &mut last);
                    shows = true;
                } else {
                    self.build(Owner::Old(place), &old, [at, stop], &mut last);
                }
                at = stop;
            }
            if old_to > end {
                self.build(Owner::Old(place), &old, [end, old_to], &mut last);
            }
        }
        if at < to {
            self.build(Owner::New, &new, [at, to], &mut last);
            shows = true;
        }
        if shows {
            self.splice(first, overlapped);
        }
        shows
    }

    /// Adds a part of `source` to what is being built, or lengthens the last one.
    fn build(
        &mut self,
        owner: Owner,
        source: &Piece,
        [from, to]: [f64; 2],
        last: &mut Option<Owner>,
    ) {
        if to <= from {
            return;
        }
        if *last == Some(owner) {
            let begins = self.built[self.n_built - 1].slopes[0];
            self.built[self.n_built - 1] = source.part([begins, to]);
            return;
        }
        if self.n_built == PIECES_MAX {
            self.overflows = true;
            return;
        }
        self.built[self.n_built] = source.part([from, to]);
        self.n_built += 1;
        *last = Some(owner);
    }

    /// Replaces `n_old` pieces from `first` on by what was built.
    fn splice(&mut self, first: usize, n_old: usize) {
        let n_after = self.n - n_old + self.n_built;
        if self.overflows || n_after > PIECES_MAX {
            self.overflows = true;
            return;
        }
        self.pieces.copy_within(first + n_old..self.n, first + self.n_built);
        self.pieces[first..first + self.n_built].copy_from_slice(&self.built[..self.n_built]);
        self.n = n_after;
    }
}
