//! Shortest ways over cells.

mod any_angle;
mod floor;
mod jump;
mod open;
mod steps;

use std::f64::consts::SQRT_2;

use grid_maps::Cell;

pub use floor::FreeFloor;
use open::{Nodes, Open};

/// How a way over cells is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridMethod {
    /// A* over the eight neighbours.
    AStar,
    /// Jump points with bits in blocks: the same lengths, sooner.
    #[default]
    JumpPoints,
    /// Lazy Theta*: any direction, near the shortest.
    AnyAngle,
}

settings::choices!(GridMethod {
    AStar = "astar": "A* over the eight neighbours of each cell",
    JumpPoints = "jps": "jump points with bits in blocks: ways as short as those of A*, found sooner",
    AnyAngle = "any-angle": "lazy Theta*: straight lines in any direction, nearly the shortest",
});

/// What a search may do at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Cells expanded.
    pub n_expanded_max: u64,
}

impl Budget {
    /// As many as there are.
    pub const UNLIMITED: Self = Self { n_expanded_max: u64::MAX };
}

/// What a search cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Cells expanded, a cell that was expanded again counted again.
    pub n_expanded: u64,
}

/// A way over cells.
#[derive(Clone, Debug, PartialEq)]
pub struct GridPath {
    /// Where it turns, start and goal included, in order: between two of them it is straight.
    pub turns: Vec<Cell>,
    /// Its length, sides of cells; exact to rounding: the lengths of its pieces summed.
    pub length_cells: f64,
}

/// How a search ended.
#[derive(Clone, Debug, PartialEq)]
pub enum GridOutcome {
    /// Here is a way.
    Found(GridPath),
    /// The start is blocked, or outside.
    StartBlocked,
    /// The goal is blocked, or outside; the free cell nearest to it that can be reached.
    GoalBlocked {
        /// By the straight distance; the start itself if nothing is nearer.
        nearest: Cell,
    },
    /// The goal is free, but no way leads there; the cell nearest to it that can be reached.
    Unreachable {
        /// By the straight distance; the start itself if nothing is nearer.
        nearest: Cell,
    },
    /// The budget was used up.
    BudgetSpent,
}

/// Looks for ways on one floor; keeps its memory between searches.
///
/// Memory: 16 bytes for each cell. A search touches only what it looks at and, once warm, allocates the
/// way that it returns and nothing else.
#[derive(Clone, Debug)]
pub struct GridSearch {
    floor: FreeFloor,
    nodes: Nodes,
    open: Open,
    effort: Effort,
}

/// Length of the shortest ways with eight directions between two cells, without obstacles.
#[inline]
fn octile(a: Cell, b: Cell) -> f64 {
    let (columns, rows) = (a.column.abs_diff(b.column), a.row.abs_diff(b.row));
    let (less, more) = if columns < rows { (columns, rows) } else { (rows, columns) };
    f64::from(more - less) + SQRT_2 * f64::from(less)
}

impl GridSearch {
    /// On a floor.
    pub fn new(floor: FreeFloor) -> Self {
        let nodes = Nodes::new(floor.n_nodes());
        Self { floor, nodes, open: Open::default(), effort: Effort::default() }
    }

    /// Goes on with another floor, and the same memory.
    pub fn set_floor(&mut self, floor: FreeFloor) {
        if floor.n_nodes() != self.floor.n_nodes() {
            self.nodes = Nodes::new(floor.n_nodes());
        }
        self.floor = floor;
    }

    /// The floor.
    pub fn floor(&self) -> &FreeFloor {
        &self.floor
    }

    /// What the last search cost.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Looks for a way from `start` to `goal`.
    ///
    /// With [`GridMethod::AStar`] and [`GridMethod::JumpPoints`] it is a shortest one of those with eight
    /// directions; when there are several, which one depends on the method. Equal calls give equal ways.
    pub fn find(
        &mut self,
        start: Cell,
        goal: Cell,
        method: GridMethod,
        budget: Budget,
    ) -> GridOutcome {
        self.effort = Effort::default();
        let Some(from) = self.floor.node(start).filter(|_| self.floor.is_free(start)) else {
            return GridOutcome::StartBlocked;
        };
        let Some(to) = self.floor.node(goal).filter(|_| self.floor.is_free(goal)) else {
            return GridOutcome::GoalBlocked { nearest: self.nearest_reachable(from, goal) };
        };
        self.nodes.begin();
        let found = match method {
            GridMethod::AStar => self.step_search(from, to, budget),
            GridMethod::JumpPoints => self.jump_search(from, to, budget),
            GridMethod::AnyAngle => self.any_angle_search(from, to, budget),
        };
        match found {
            Ended::Found => {
                GridOutcome::Found(self.way_back(from, to, method != GridMethod::AnyAngle))
            }
            Ended::Exhausted => {
                GridOutcome::Unreachable { nearest: self.nearest_reachable(from, goal) }
            }
            Ended::BudgetSpent => GridOutcome::BudgetSpent,
        }
    }

    /// Whether the budget allows one more; it is counted.
    #[inline]
    fn may_expand(&mut self, budget: Budget) -> bool {
        self.effort.n_expanded += 1;
        self.effort.n_expanded <= budget.n_expanded_max
    }

    /// The way by the parents of its cells. With eight directions a piece is drawn with its diagonal part first.
    fn way_back(&self, from: u32, to: u32, in_eight_directions: bool) -> GridPath {
        let mut cells = vec![self.floor.cell(to)];
        let mut at = to;
        while at != from {
            let Some(node) = self.nodes.get(at) else { break };
            let (end, begin) = (self.floor.cell(at), self.floor.cell(node.parent));
            if in_eight_directions {
                let (columns, rows) = (end.column - begin.column, end.row - begin.row);
                let diagonal = columns.abs().min(rows.abs());
                let corner = Cell {
                    column: begin.column + diagonal * columns.signum(),
                    row: begin.row + diagonal * rows.signum(),
                };
                if corner != begin && corner != end {
                    cells.push(corner);
                }
            }
            at = node.parent;
            cells.push(begin);
        }
        cells.reverse();
        GridPath::through(&cells)
    }

    /// The cell nearest to `goal` that can be reached from a free cell. O(cells).
    fn nearest_reachable(&mut self, from: u32, goal: Cell) -> Cell {
        let offsets = self.floor.offsets();
        self.nodes.begin();
        self.nodes.improve(from, from, 0.0);
        let mut waiting = vec![from];
        let far = |cell: Cell| {
            let (dx, dy) = (i64::from(cell.column - goal.column), i64::from(cell.row - goal.row));
            (dx * dx + dy * dy, cell.row, cell.column)
        };
        let mut nearest = self.floor.cell(from);
        while let Some(node) = waiting.pop() {
            let cell = self.floor.cell(node);
            if far(cell) < far(nearest) {
                nearest = cell;
            }
            // Whoever can step diagonally can step straight: four directions reach everything.
            let open = self.floor.open_steps(node);
            for d in [0, 2, 4, 6] {
                let next = node.wrapping_add(offsets[d]);
                if open >> d & 1 == 1 && self.nodes.improve(next, node, 0.0) {
                    waiting.push(next);
                }
            }
        }
        nearest
    }
}

/// How a search within ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    Found,
    Exhausted,
    BudgetSpent,
}

impl GridPath {
    /// The cells that it passes, in order: at each step along a piece the nearest one.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let first = self.turns.first().copied();
        let along = |pair: &[Cell]| {
            let (from, to) = (pair[0], pair[1]);
            let (columns, rows) = (to.column - from.column, to.row - from.row);
            let n_steps = columns.abs().max(rows.abs());
            let part = move |length: i32, step: i32| {
                (f64::from(length * step) / f64::from(n_steps)).round() as i32
            };
            (1..=n_steps).map(move |step| Cell {
                column: from.column + part(columns, step),
                row: from.row + part(rows, step),
            })
        };
        first.into_iter().chain(self.turns.windows(2).flat_map(along))
    }

    /// How many they are.
    pub fn n_cells(&self) -> usize {
        self.cells().count()
    }

    /// Through these cells in order, straight from each to the next.
    fn through(cells: &[Cell]) -> Self {
        let mut turns: Vec<Cell> = Vec::with_capacity(cells.len());
        for &cell in cells {
            // Straight on: the one between is no turn.
            if let [.., before, last] = turns[..]
                && is_straight(before, last, cell)
                && let Some(end) = turns.last_mut()
            {
                *end = cell;
            } else {
                turns.push(cell);
            }
        }
        let length = |pair: &[Cell]| {
            let [a, b] = [pair[0], pair[1]];
            f64::from(a.column - b.column).hypot(f64::from(a.row - b.row))
        };
        let length_cells = turns.windows(2).map(length).sum();
        Self { turns, length_cells }
    }
}

/// Whether the way from a over b to c goes straight on at b.
fn is_straight(a: Cell, b: Cell, c: Cell) -> bool {
    let way =
        |from: Cell, to: Cell| (i64::from(to.column - from.column), i64::from(to.row - from.row));
    let ((x1, y1), (x2, y2)) = (way(a, b), way(b, c));
    x1 * y2 == x2 * y1 && x1 * x2 + y1 * y2 > 0
}
