//! Which cells have their centre inside a polygon: rows and spans, without allocation once warm.
//!
//! Every edge is cut with the centre lines of the rows it passes; the cuts of a row, sorted and
//! taken in pairs, are its spans (even-odd rule). A centre exactly on an edge belongs to the
//! polygon on its left or below it, so polygons that share an edge share no cell.

/// Polygons in, spans out; keeps its memory.
///
/// Coordinates are in cells, at least 0 and at most [`SIDE_MAX_CELLS`].
#[derive(Clone, Debug)]
pub(crate) struct SpanFill {
    edges: Vec<Edge>,
    first: Option<[f64; 2]>,
    last: [f64; 2],
    /// Per row, where its cuts begin; one more at the end.
    starts: Vec<u32>,
    cuts: Vec<i32>,
}

/// An edge that crosses at least one centre line, from its lower end.
#[derive(Clone, Copy, Debug)]
struct Edge {
    row_start: u32,
    row_end: u32,
    x: f64,
    y: f64,
    dx_per_dy: f64,
}

/// Polygons are no larger than this; it bounds the memory.
pub(crate) const SIDE_MAX_CELLS: f64 = 16_400.0;

impl SpanFill {
    /// A filler without memory yet.
    pub(crate) const fn new() -> Self {
        Self {
            edges: Vec::new(),
            first: None,
            last: [0.0; 2],
            starts: Vec::new(),
            cuts: Vec::new(),
        }
    }

    /// Forgets the last polygon.
    pub(crate) fn begin(&mut self) {
        self.edges.clear();
        self.first = None;
    }

    /// Goes on to the next corner.
    pub(crate) fn corner(&mut self, at: [f64; 2]) {
        if self.first.is_some() {
            self.edge(self.last, at);
        } else {
            self.first = Some(at);
        }
        self.last = at;
    }

    /// Closes the polygon and hands out its spans: row, first column, one past the last column;
    /// from bottom to top, each row from left to right.
    pub(crate) fn for_each_span(&mut self, mut span: impl FnMut(i32, i32, i32)) {
        if let Some(first) = self.first {
            self.edge(self.last, first);
        }
        self.cut();
        let mut start = 0;
        for (row, &end) in self.starts.iter().enumerate() {
            let cuts = &mut self.cuts[start..end as usize];
            start = end as usize;
            match cuts {
                [] => {}
                [a, b] => {
                    let (low, high) = ((*a).min(*b), (*a).max(*b));
                    if low < high {
                        span(row as i32, low, high);
                    }
                }
                _ => {
                    sort(cuts);
                    for pair in cuts.chunks_exact(2).filter(|pair| pair[0] < pair[1]) {
                        span(row as i32, pair[0], pair[1]);
                    }
                }
            }
        }
    }

    fn edge(&mut self, a: [f64; 2], b: [f64; 2]) {
        // From the lower end always, so that an edge and its reverse are cut at the same columns.
        let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let (row_start, row_end) = (nearest(low[1]), nearest(high[1]));
        if row_start < row_end {
            let dx_per_dy = (high[0] - low[0]) / (high[1] - low[1]);
            let [x, y] = low;
            self.edges.push(Edge { row_start, row_end, x, y, dx_per_dy });
        }
    }

    /// Cuts all edges, sorted by row: count, add up, then put in place.
    ///
    /// Afterwards `starts[row]` is where the cuts of the *next* row begin.
    fn cut(&mut self) {
        let n_rows = self.edges.iter().map(|edge| edge.row_end).max().unwrap_or(0) as usize;
        self.starts.clear();
        self.starts.resize(n_rows + 1, 0);
        // First only the changes of the number of cuts: an edge adds one from its first row on and
        // takes it away after its last.
        for edge in &self.edges {
            let (from, to) = (edge.row_start as usize, edge.row_end as usize);
            self.starts[from] = self.starts[from].wrapping_add(1);
            self.starts[to] = self.starts[to].wrapping_sub(1);
        }
        let (mut n_here, mut n_before) = (0_u32, 0_u32);
        for start in &mut self.starts {
            n_here = n_here.wrapping_add(*start);
            *start = n_before;
            n_before += n_here;
        }
        self.cuts.clear();
        self.cuts.resize(n_before as usize, 0);
        for edge in &self.edges {
            let rows = &mut self.starts[edge.row_start as usize..edge.row_end as usize];
            let mut centre = f64::from(edge.row_start) + 0.5;
            for next in rows {
                let x = edge.x + (centre - edge.y) * edge.dx_per_dy;
                self.cuts[*next as usize] = nearest(x) as i32;
                *next += 1;
                centre += 1.0;
            }
        }
    }
}

/// The first cell whose centre lies beyond `x`: `x` rounded, halves up.
fn nearest(x: f64) -> u32 {
    // Not `round`: that is a call on old processors, this is one conversion.
    (x + 0.5) as i32 as u32
}

/// Sorts a handful of numbers.
fn sort(cuts: &mut [i32]) {
    if cuts.len() > 24 {
        cuts.sort_unstable();
        return;
    }
    for i in 1..cuts.len() {
        let value = cuts[i];
        let mut j = i;
        while j > 0 && cuts[j - 1] > value {
            cuts[j] = cuts[j - 1];
            j -= 1;
        }
        cuts[j] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    fn cells_of(fill: &mut SpanFill, polygon: &[[f64; 2]]) -> Vec<(i32, i32)> {
        fill.begin();
        for &corner in polygon {
            fill.corner(corner);
        }
        let mut cells = Vec::new();
        fill.for_each_span(|row, start, end| cells.extend((start..end).map(|c| (row, c))));
        cells
    }

    /// Oracle: how often the edges turn around a centre, by the signs of areas. `None` near an
    /// edge, where rounding decides.
    fn turns_around(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> Option<i32> {
        let mut turns = 0;
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let area = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let beside = y > a[1].min(b[1]) - 1e-9 && y < a[1].max(b[1]) + 1e-9;
            if beside && area.abs() <= 1e-9 * (length + 1.0) {
                return None;
            }
            if a[1] <= y && y < b[1] && area > 0.0 {
                turns += 1;
            } else if b[1] <= y && y < a[1] && area < 0.0 {
                turns -= 1;
            }
        }
        Some(turns)
    }

    #[test]
    fn a_square_covers_its_centres_once_and_shares_none_with_its_neighbour() {
        let mut fill = SpanFill::new();
        let left = cells_of(&mut fill, &[[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]]);
        let right = cells_of(&mut fill, &[[2.5, 0.5], [4.5, 0.5], [4.5, 2.5], [2.5, 2.5]]);
        // Centres on the lower or left edge (0.5) are outside, on the upper or right edge inside.
        assert_eq!(left, [(1, 1), (1, 2), (2, 1), (2, 2)]);
        assert_eq!(right, [(1, 3), (1, 4), (2, 3), (2, 4)]);
        assert!(cells_of(&mut fill, &[]).is_empty());
        assert!(cells_of(&mut fill, &[[1.0, 1.0], [9.0, 9.0]]).is_empty());
    }

    #[test]
    fn many_cuts_in_a_row_are_sorted() {
        // A comb of 20 teeth, drawn from right to left.
        let mut comb = vec![[0.0, 0.0], [80.0, 0.0]];
        for tooth in (0..20).rev() {
            let x = f64::from(4 * tooth);
            comb.extend([[x + 3.0, 5.0], [x + 2.0, 5.0], [x + 2.0, 1.0], [x + 1.0, 1.0]]);
        }
        let mut fill = SpanFill::new();
        let cells = cells_of(&mut fill, &comb);
        // More than the short sort takes.
        assert!(fill.cuts.len() >= 5 * 26, "{} cuts", fill.cuts.len());
        for row in 0..5 {
            for column in 0..80 {
                let inside = cells.contains(&(row, column));
                let turns = turns_around(&comb, [f64::from(column) + 0.5, f64::from(row) + 0.5]);
                assert!(turns.is_none_or(|turns| (turns != 0) == inside), "{row}, {column}");
            }
        }
    }

    proptest! {
        #[test]
        fn spans_cover_the_centres_inside(
            polygon in vec((0.0..30.0_f64, 0.0..30.0_f64).prop_map(|(x, y)| [x, y]), 3..12),
        ) {
            let mut fill = SpanFill::new();
            let cells = cells_of(&mut fill, &polygon);
            let mut unique = cells.clone();
            unique.dedup();
            prop_assert_eq!(unique.len(), cells.len());
            for row in 0..30 {
                for column in 0..30 {
                    let centre = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                    if let Some(turns) = turns_around(&polygon, centre) {
                        let inside = turns.rem_euclid(2) == 1;
                        prop_assert_eq!(cells.contains(&(row, column)), inside);
                    }
                }
            }
        }
    }
}
