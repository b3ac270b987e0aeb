//! Ray casts through a grid by the million: free squares are skipped, the answer stays exact.

use geometry::Vec2;

use crate::{CELL_LIMIT, Cell, CellBox, Lattice, State, Window, lattice::floor};

const BLOCK_BITS: i32 = 3;
const BLOCK_SIDE: i32 = 1 << BLOCK_BITS;
const BLOCK_MASK: i32 = BLOCK_SIDE - 1;

/// The obstacles of a window, arranged for rays.
///
/// The distance that a cast finds is, to the last bit, that of walking cell by cell (see
/// [`RayWalk`](crate::RayWalk)) to the border of the first obstacle. Outside the window nothing
/// stands in the way.
///
/// Blocks of 8 × 8 cells are kept as 64 bits; and for each block, and each of the eight directions
/// between the axes and the diagonals, how far an empty wedge reaches from there. So a ray crosses
/// free space in leaps as large as the space ahead of it allows. Memory: 16 bytes for 64 cells.
#[derive(Clone, Debug)]
pub struct RayMap {
    lattice: Lattice,
    area: CellBox,
    n_tile_columns: usize,
    /// One bit for each cell of a block, row by row. Blocks are in tiles of 8 × 8, so that a
    /// cache line has what lies together.
    blocks: Vec<u64>,
    /// For each [`Octant`] and block: 0 if the block has an obstacle, else one more than how many
    /// columns (rows, if steep) of blocks are empty wherever a ray that is in the block may go.
    wedges: [Vec<u8>; 8],
}

/// One coordinate of a ray: where it starts and how it moves; cells.
#[derive(Clone, Copy)]
struct Line {
    from: f64,
    speed: f64,
    /// `from`, or infinitely far behind for a line that does not move: then all borders are
    /// infinitely far ahead, in the same arithmetic.
    border_from: f64,
    /// Distance from one border to the next; its sign is the direction.
    per_border: f64,
    forwards: bool,
    moves: bool,
}

/// Which way a ray goes: along both axes, and along which of them more.
#[derive(Clone, Copy, Debug)]
struct Octant {
    right: bool,
    up: bool,
    steep: bool,
}

/// Where a ray is: the cell, and how far along it entered.
#[derive(Clone, Copy)]
struct Place {
    column: i32,
    row: i32,
    distance: f64,
}

impl RayMap {
    /// Arranges the cells of a window for which `blocks` holds. O(cells).
    pub fn new<T: Copy>(lattice: Lattice, cells: &Window<T>, blocks: impl Fn(T) -> bool) -> Self {
        let area = cells.area();
        let n_blocks = |side: usize| side.div_ceil(BLOCK_SIDE as usize);
        let (n_block_columns, n_block_rows) = (n_blocks(area.width), n_blocks(area.height));
        let mut bits = vec![0_u64; n_block_columns * n_block_rows];
        for (y, row) in cells.values().chunks_exact(area.width.max(1)).enumerate() {
            for (x, _) in row.iter().enumerate().filter(|(_, value)| blocks(**value)) {
                bits[(y >> BLOCK_BITS) * n_block_columns + (x >> BLOCK_BITS)] |=
                    1 << (((y as i32 & BLOCK_MASK) << BLOCK_BITS) | (x as i32 & BLOCK_MASK));
            }
        }
        let wedges = Octant::ALL
            .map(|octant| tiled(&octant.wedges(&bits, n_block_columns), n_block_columns, 0));
        let blocks = tiled(&bits, n_block_columns, 0);
        let n_tile_columns = n_block_columns.div_ceil(BLOCK_SIDE as usize);
        Self { lattice, area, n_tile_columns, blocks, wedges }
    }

    /// Arranges the occupied cells: unknown ones let rays pass.
    pub fn of_states(lattice: Lattice, states: &Window<State>) -> Self {
        Self::new(lattice, states, |state| state == State::Occupied)
    }

    /// Memory held, bytes.
    pub fn memory_bytes(&self) -> usize {
        self.blocks.len() * (size_of::<u64>() + self.wedges.len())
    }

    /// Distance from `from` (m) along the unit vector `direction` to the border of the first
    /// obstacle, metres; 0 when it starts in one, `None` when there is none up to `range_max_m`.
    ///
    /// A ray exactly through a corner passes the cell beside it along x, so diagonal walls are
    /// tight. What is not a number hits nothing.
    pub fn cast_ray(&self, from: Vec2, direction: Vec2, range_max_m: f64) -> Option<f64> {
        let start = self.lattice.cell_at(from)?;
        if !(direction.x.is_finite() && direction.y.is_finite()) || self.blocks.is_empty() {
            return None;
        }
        let range_max = range_max_m / self.lattice.resolution_m;
        let corner = Vec2::new(f64::from(self.area.min.column), f64::from(self.area.min.row));
        let at = self.lattice.in_cells(from) - corner;
        let x = Line::new(at.x, direction.x);
        let y = Line::new(at.y, direction.y);
        let Cell { column, row } = self.area.min;
        let first = Place {
            column: start.column.saturating_sub(column),
            row: start.row.saturating_sub(row),
            distance: 0.0,
        };
        let place = if self.has(first) { first } else { self.enter(first, x, y)? };
        let steep = direction.y.abs() > direction.x.abs();
        let octant = Octant { right: x.forwards, up: y.forwards, steep };
        let distance = match octant.index() {
            0 => self.follow::<false, false, false>(place, x, y, range_max),
            1 => self.follow::<true, false, false>(place, x, y, range_max),
            2 => self.follow::<false, true, false>(place, x, y, range_max),
            3 => self.follow::<true, true, false>(place, x, y, range_max),
            4 => self.follow::<false, false, true>(place, x, y, range_max),
            5 => self.follow::<true, false, true>(place, x, y, range_max),
            6 => self.follow::<false, true, true>(place, x, y, range_max),
            _ => self.follow::<true, true, true>(place, x, y, range_max),
        }?;
        Some(distance * self.lattice.resolution_m)
    }

    /// From inside to the first obstacle; cells.
    fn follow<const RIGHT: bool, const UP: bool, const STEEP: bool>(
        &self,
        mut place: Place,
        x: Line,
        y: Line,
        range_max: f64,
    ) -> Option<f64> {
        // Now the compiler knows the directions, and drops the questions after them.
        let (x, y) = (Line { forwards: RIGHT, ..x }, Line { forwards: UP, ..y });
        let octant = Octant { right: RIGHT, up: UP, steep: STEEP };
        let wedges = &self.wedges[octant.index()];
        // On a diagonal, rounding may lead out of the wedge: there, block by block.
        let [less, more] = if STEEP { [x.speed, y.speed] } else { [y.speed, x.speed] };
        let wedge_max = if less.abs() < more.abs() * (1.0 - 1e-6) { u8::MAX } else { 1 };
        // What is not a number ends this too.
        while place.distance <= range_max && self.has(place) {
            let (column, row) = (place.column >> BLOCK_BITS, place.row >> BLOCK_BITS);
            let block = tiled_index(column as usize, row as usize, self.n_tile_columns);
            let wedge = wedges[block].min(wedge_max);
            if wedge > 1 {
                place = place.leap::<STEEP>(x, y, i32::from(wedge) - 1);
                continue;
            }
            let bits = if wedge == 0 { self.blocks[block] & octant.ahead(place) } else { 0 };
            if bits == 0 {
                // A block in which nothing lies ahead is as good as empty.
                place = place.hop(x, y);
                continue;
            }
            let (column, row) = (place.column & !BLOCK_MASK, place.row & !BLOCK_MASK);
            loop {
                let (dx, dy) = (place.column - column, place.row - row);
                if ((dx | dy) & !BLOCK_MASK) != 0 {
                    break;
                }
                if bits >> ((dy << BLOCK_BITS) | dx) & 1 == 1 {
                    return (place.distance <= range_max).then_some(place.distance);
                }
                place = place.step(x, y);
            }
        }
        None
    }

    fn has(&self, place: Place) -> bool {
        // Below zero wraps to a huge number.
        (place.column as u32 as usize) < self.area.width
            && (place.row as u32 as usize) < self.area.height
    }

    /// Where a ray that starts outside comes into the window.
    fn enter(&self, first: Place, x: Line, y: Line) -> Option<Place> {
        let border = |at: i32, side: usize, line: Line| {
            let side = i32::try_from(side).unwrap_or(i32::MAX);
            match at {
                _ if at < 0 => (line.moves && line.forwards).then_some(Some(0)),
                _ if at >= side => (line.moves && !line.forwards).then_some(Some(side)),
                _ => Some(None),
            }
        };
        let column = border(first.column, self.area.width, x)?;
        let row = border(first.row, self.area.height, y)?;
        let distance = |border: Option<i32>, line: Line| {
            border.map_or(f64::NEG_INFINITY, |border| line.distance_to(border))
        };
        let place = match (distance(column, x) > distance(row, y), column, row) {
            (true, Some(column), _) | (_, Some(column), None) => first.across_column(x, y, column),
            (_, _, Some(row)) => first.across_row(x, y, row),
            (_, None, None) => first,
        };
        Some(place)
    }
}

impl Line {
    fn new(from: f64, speed: f64) -> Self {
        let moves = speed != 0.0;
        let (border_from, per_border) =
            if moves { (from, 1.0 / speed) } else { (f64::NEG_INFINITY, f64::INFINITY) };
        Self { from, speed, border_from, per_border, forwards: speed >= 0.0, moves }
    }

    /// Where the ray meets a border.
    fn distance_to(self, border: i32) -> f64 {
        (f64::from(border) - self.border_from) * self.per_border
    }

    /// The cell it is in at `distance` by rounding alone, and whether that is to be trusted.
    ///
    /// A large number without digits behind the point rounds what is added to it, and has the whole
    /// number in its lowest bits: cheaper than a conversion with its checks.
    fn near(self, distance: f64) -> (i32, bool) {
        const SHIFT: f64 = 6_755_399_441_055_744.0;
        let at = self.from + distance * self.speed;
        // The nearest whole number half a cell below is the lower border, unless a border is close.
        let shifted = at - 0.5 + SHIFT;
        let part = at - (shifted - SHIFT);
        (shifted.to_bits() as i32, part > UNSURE && part < 1.0 - UNSURE)
    }

    /// The border through which it leaves the cells from `low` to before `high`.
    fn exit(self, low: i32, high: i32) -> i32 {
        if self.forwards { high } else { low }
    }

    /// The cell behind a border.
    fn behind(self, border: i32) -> i32 {
        if self.forwards { border } else { border - 1 }
    }

    /// The cell it is in at `distance`, `old` being one it was in before. Borders that are reached
    /// exactly at `distance` count if `at_border` says so.
    fn cell_at(self, old: i32, distance: f64, at_border: bool) -> i32 {
        if !self.moves {
            return old;
        }
        let at = self.from + distance * self.speed;
        let guess = floor(at);
        // Far outside any map the exact cell does not matter.
        if at.is_nan() || at.abs() >= f64::from(CELL_LIMIT) {
            return guess;
        }
        // Rounding may have moved it across a border. The borders themselves decide, by the same
        // numbers as step by step.
        let passed = |border: i32| {
            let there = self.distance_to(border);
            if at_border { there <= distance } else { there < distance }
        };
        if self.forwards {
            let mut cell = guess.max(old);
            while cell > old && !passed(cell) {
                cell -= 1;
            }
            while passed(cell + 1) {
                cell += 1;
            }
            cell
        } else {
            let mut cell = guess.min(old);
            while cell < old && !passed(cell + 1) {
                cell += 1;
            }
            while passed(cell) {
                cell -= 1;
            }
            cell
        }
    }
}

/// Rounding moves a place by a thousandth of this at most; cells.
const UNSURE: f64 = 1e-4;

impl Place {
    /// Out of the empty wedge ahead, through its far side.
    #[expect(clippy::inline_always, reason = "only inside `follow` are the directions constants")]
    #[inline(always)]
    fn leap<const STEEP: bool>(self, x: Line, y: Line, wedge: i32) -> Self {
        let (along, aside) = if STEEP { (y, x) } else { (x, y) };
        let block = if STEEP { self.row } else { self.column } >> BLOCK_BITS;
        let border = along.exit((block + 1 - wedge) << BLOCK_BITS, (block + wedge) << BLOCK_BITS);
        let distance = along.distance_to(border);
        let (guess, sure) = aside.near(distance);
        match (sure, STEEP) {
            (true, true) => Self { column: guess, row: y.behind(border), distance },
            (true, false) => Self { column: x.behind(border), row: guess, distance },
            (false, true) => self.across_row(x, y, border),
            (false, false) => self.across_column(x, y, border),
        }
    }

    /// Out of the block.
    #[expect(clippy::inline_always, reason = "only inside `follow` are the directions constants")]
    #[inline(always)]
    fn hop(self, x: Line, y: Line) -> Self {
        let low = |at: i32| at & !BLOCK_MASK;
        let column = x.exit(low(self.column), low(self.column) + BLOCK_SIDE);
        let row = y.exit(low(self.row), low(self.row) + BLOCK_SIDE);
        let (to_column, to_row) = (x.distance_to(column), y.distance_to(row));
        // Which border comes first is anybody's guess, so both ways are worked out and one is
        // taken: a wrong guess of the processor costs more.
        let x_first = to_column <= to_row;
        let distance = if x_first { to_column } else { to_row };
        let ((guess_x, sure_x), (guess_y, sure_y)) = (x.near(distance), y.near(distance));
        if if x_first { sure_y } else { sure_x } {
            let column = if x_first { x.behind(column) } else { guess_x };
            let row = if x_first { guess_y } else { y.behind(row) };
            Self { column, row, distance }
        } else if x_first {
            self.across_column(x, y, column)
        } else {
            self.across_row(x, y, row)
        }
    }

    /// To the next cell.
    #[expect(clippy::inline_always, reason = "only inside `follow` are the directions constants")]
    #[inline(always)]
    fn step(self, x: Line, y: Line) -> Self {
        let column = x.exit(self.column, self.column + 1);
        let row = y.exit(self.row, self.row + 1);
        let (to_column, to_row) = (x.distance_to(column), y.distance_to(row));
        let x_first = to_column <= to_row;
        let distance = if x_first { to_column } else { to_row };
        let column = if x_first { x.behind(column) } else { self.column };
        let row = if x_first { self.row } else { y.behind(row) };
        Self { column, row, distance }
    }

    /// Behind a border between columns, with no trust in rounding. Where both axes meet a border at once, x goes first.
    #[cold]
    fn across_column(self, x: Line, y: Line, border: i32) -> Self {
        let distance = x.distance_to(border);
        let row = y.cell_at(self.row, distance, false);
        Self { column: x.behind(border), row, distance }
    }

    /// Behind a border between rows.
    #[cold]
    fn across_row(self, x: Line, y: Line, border: i32) -> Self {
        let distance = y.distance_to(border);
        let column = x.cell_at(self.column, distance, true);
        Self { column, row: y.behind(border), distance }
    }
}

impl Octant {
    /// In order of their index.
    const ALL: [Self; 8] = [
        Self { right: false, up: false, steep: false },
        Self { right: true, up: false, steep: false },
        Self { right: false, up: true, steep: false },
        Self { right: true, up: true, steep: false },
        Self { right: false, up: false, steep: true },
        Self { right: true, up: false, steep: true },
        Self { right: false, up: true, steep: true },
        Self { right: true, up: true, steep: true },
    ];

    const fn index(self) -> usize {
        self.right as usize | ((self.up as usize) << 1) | ((self.steep as usize) << 2)
    }

    /// The cells of a place's block that lie to this side of the place, itself included.
    const fn ahead(self, place: Place) -> u64 {
        let (column, row) = (place.column & BLOCK_MASK, place.row & BLOCK_MASK);
        let columns: u64 = if self.right { 0xff & (0xff << column) } else { 0xff >> (7 - column) };
        let rows = if self.up {
            u64::MAX << (row << BLOCK_BITS)
        } else {
            u64::MAX >> ((7 - row) << BLOCK_BITS)
        };
        (columns * 0x0101_0101_0101_0101) & rows
    }

    /// For each block one more than the length of the wedge that is empty ahead of it, 0 if it has
    /// an obstacle itself; beyond the map everything is empty. O(blocks).
    ///
    /// A ray that is somewhere in a block and goes along x at least as far as along y is, k columns
    /// on, at most k + 1 rows aside. So a wedge of one column is the block and the one aside, and
    /// a longer one is that and what both blocks ahead of them have in common.
    fn wedges(self, blocks: &[u64], width: usize) -> Vec<u8> {
        let height = blocks.len().checked_div(width).unwrap_or(0);
        let (n_along, n_aside) = if self.steep { (height, width) } else { (width, height) };
        let (forwards, to_side) =
            if self.steep { (self.up, self.right) } else { (self.right, self.up) };
        let place = |along: usize, aside: usize| {
            let along = if forwards { along } else { n_along - 1 - along };
            let aside = if to_side { aside } else { n_aside - 1 - aside };
            if self.steep { along * width + aside } else { aside * width + along }
        };
        let mut wedges = vec![0_u8; blocks.len()];
        for along in (0..n_along).rev() {
            for aside in 0..n_aside {
                let has_side = aside + 1 < n_aside;
                let is_empty = blocks[place(along, aside)] == 0;
                let has_wedge = !has_side || blocks[place(along, aside + 1)] == 0;
                let next = |aside: usize, exists: bool| {
                    if exists { wedges[place(along + 1, aside)] } else { u8::MAX }
                };
                let has_next = along + 1 < n_along;
                let least = next(aside, has_next).min(next(aside + 1, has_next && has_side));
                // In an obstacle's block there is no wedge, as in a block beside one.
                let longer = least.max(1).saturating_add(1);
                wedges[place(along, aside)] = match (is_empty, has_wedge) {
                    (false, _) => 0,
                    (true, false) => 1,
                    (true, true) => longer,
                };
            }
        }
        wedges
    }
}

/// Where a block is kept.
fn tiled_index(column: usize, row: usize, n_tile_columns: usize) -> usize {
    let tile = (row >> BLOCK_BITS) * n_tile_columns + (column >> BLOCK_BITS);
    (tile << (2 * BLOCK_BITS)) | ((row & 7) << BLOCK_BITS) | (column & 7)
}

/// Values row by row, brought into tiles; the last ones are filled up.
fn tiled<T: Copy>(rows: &[T], width: usize, beyond: T) -> Vec<T> {
    let height = rows.len().checked_div(width).unwrap_or(0);
    let (n_columns, n_rows) = (width.div_ceil(8), height.div_ceil(8));
    let mut tiles = vec![beyond; n_columns * n_rows * 64];
    for (row, values) in rows.chunks_exact(width.max(1)).enumerate() {
        for (column, value) in values.iter().enumerate() {
            tiles[tiled_index(column, row, n_columns)] = *value;
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    /// Oracle: all borders up to the range, sorted by distance, x before y, one after the other.
    fn by_definition(
        lattice: &Lattice,
        cells: &Window<bool>,
        from: Vec2,
        direction: Vec2,
        range_max_m: f64,
    ) -> Option<f64> {
        let mut cell = lattice.cell_of(from);
        let corner = cells.area().min;
        let at =
            lattice.in_cells(from) - Vec2::new(f64::from(corner.column), f64::from(corner.row));
        let start = [cell.column - corner.column, cell.row - corner.row];
        let mut borders = Vec::new();
        for axis in 0..2 {
            let (from, speed) = (at[axis], direction[axis]);
            for i in 0..400 {
                if speed > 0.0 {
                    borders.push((
                        (f64::from(start[axis] + 1 + i) - from) * (1.0 / speed),
                        axis,
                        1,
                    ));
                } else if speed < 0.0 {
                    borders.push(((f64::from(start[axis] - i) - from) * (1.0 / speed), axis, -1));
                }
            }
        }
        borders.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut distance = 0.0;
        for (next, axis, step) in borders {
            if distance > range_max_m / lattice.resolution_m {
                return None;
            }
            if cells.get(cell) == Some(true) {
                return Some(distance * lattice.resolution_m);
            }
            distance = next;
            cell = if axis == 0 { cell.offset(step, 0) } else { cell.offset(0, step) };
        }
        None
    }

    fn direction() -> impl Strategy<Value = Vec2> {
        let any = (-3.2..3.2_f64).prop_map(|a| Vec2::new(a.cos(), a.sin()));
        let half = 0.5_f64.sqrt();
        prop_oneof![
            4 => any,
            // Nearly along an axis or a diagonal: borders come close together.
            1 => (-1e-9..1e-9_f64).prop_map(|a| Vec2::new(-a.cos(), a.sin())),
            1 => (-1e-5..1e-5_f64).prop_map(move |a| Vec2::new(half + a, -half)),
            // From border to border, so that both axes meet theirs at once; any length will do.
            2 => (-3..4_i32, 1..4_i32).prop_map(|(x, y)| Vec2::new(f64::from(x), f64::from(y))),
            2 => (1..4_i32, -3..4_i32).prop_map(|(x, y)| Vec2::new(f64::from(-x), f64::from(-y))),
            1 => (0..4).prop_map(|i| [Vec2::x(), Vec2::y(), -Vec2::x(), -Vec2::y()][i as usize]),
            1 => (0..4).prop_map(move |i| {
                Vec2::new(if i & 1 == 0 { half } else { -half }, if i & 2 == 0 { half } else { -half })
            })
        ]
    }

    proptest! {
        #[test]
        fn leaps_find_what_steps_find_to_the_last_bit(
            obstacles in vec((0..60_usize, 0..50_usize), 0..25),
            from in prop_oneof![
                (-0.9..7.5_f64, -0.9..6.5_f64),
                // Exactly on borders and corners, inside and outside.
                (-8..68_i32, -8..58_i32).prop_map(|(c, r)| (f64::from(c) * 0.125, f64::from(r) * 0.125)),
            ],
            direction in direction(),
            range_max_m in prop_oneof![Just(20.0), Just(f64::INFINITY), 0.0..6.0_f64],
        ) {
            let area = CellBox { min: Cell::new(-3, 2), width: 60, height: 50 };
            let mut cells = Window::filled(area, false).unwrap();
            for (x, y) in obstacles {
                cells.values_mut()[y * 60 + x] = true;
            }
            let lattice = Lattice::new(Vec2::new(0.375, -0.25), 0.125).unwrap();
            let map = RayMap::new(lattice, &cells, |obstacle| obstacle);
            let from = Vec2::new(from.0, from.1);
            let expected = by_definition(&lattice, &cells, from, direction, range_max_m);
            prop_assert_eq!(map.cast_ray(from, direction, range_max_m), expected);
        }

        #[test]
        fn wedges_are_as_long_as_they_can_be(
            blocks in vec(prop_oneof![9 => Just(0_u64), 1 => Just(4)], 70), width in 1..11_usize,
        ) {
            let n = 70 / width * width;
            let height = n / width;
            let is_empty = |x: i32, y: i32| {
                let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
                !inside || blocks[y as usize * width + x as usize] == 0
            };
            for octant in Octant::ALL {
                let wedges = octant.wedges(&blocks[..n], width);
                for (i, wedge) in wedges.into_iter().enumerate() {
                    let (x, y) = ((i % width) as i32, (i / width) as i32);
                    let column_is_empty = |k: i32| {
                        (0..=k + 1).all(|aside| {
                            let (dx, dy) = if octant.steep { (aside, k) } else { (k, aside) };
                            let dx = if octant.right { dx } else { -dx };
                            let dy = if octant.up { dy } else { -dy };
                            is_empty(x + dx, y + dy)
                        })
                    };
                    // Beyond 80 blocks there is nothing any more.
                    let length = (0..80).find(|k| !column_is_empty(*k)).unwrap_or(254);
                    let expected = if is_empty(x, y) { length + 1 } else { 0 };
                    if wedge < 80 || length < 80 {
                        prop_assert_eq!(i32::from(wedge), expected, "{:?} {}", octant, i);
                    }
                }
            }
        }

        #[test]
        fn what_lies_ahead_is_a_corner_of_the_block(column in 0..8_i32, row in 0..8_i32) {
            let place = Place { column: column - 16, row: row + 8, distance: 0.0 };
            for octant in Octant::ALL {
                let ahead = octant.ahead(place);
                for k in 0..64 {
                    let (x, y) = (k % 8, k / 8);
                    let right = if octant.right { x >= column } else { x <= column };
                    let up = if octant.up { y >= row } else { y <= row };
                    prop_assert_eq!(ahead >> k & 1 == 1, right && up);
                }
            }
        }
    }

    /// A leap that ends in a corner goes along x first, like a step: past the cell above the corner's
    /// left, into the one below its right.
    #[test]
    fn a_leap_into_a_corner_goes_along_x_first() {
        let area = CellBox { min: Cell::new(0, 0), width: 32, height: 64 };
        let lattice = Lattice::new(Vec2::zeros(), 1.0).unwrap();
        let cast = |column, row| {
            let mut cells = Window::filled(area, false).unwrap();
            *cells.get_mut(Cell::new(column, row)).unwrap() = true;
            let map = RayMap::new(lattice, &cells, |obstacle| obstacle);
            map.cast_ray(Vec2::zeros(), Vec2::new(1.0, 2.0), 99.0)
        };
        assert_eq!((cast(7, 16), cast(8, 15), cast(8, 16)), (None, Some(8.0), Some(8.0)));
    }

    #[test]
    fn broken_rays_hit_nothing() {
        let area = CellBox { min: Cell::new(0, 0), width: 9, height: 9 };
        let full = Window::filled(area, State::Occupied).unwrap();
        let lattice = Lattice::new(Vec2::zeros(), 1.0).unwrap();
        let map = RayMap::of_states(lattice, &full);
        let (inside, outside) = (Vec2::new(4.5, 4.5), Vec2::new(-3.0, 4.5));
        assert_eq!(map.cast_ray(inside, Vec2::x(), 0.0), Some(0.0));
        assert_eq!(map.cast_ray(outside, Vec2::x(), 3.0), Some(3.0));
        assert_eq!(map.cast_ray(outside, Vec2::x(), 2.999), None);
        assert_eq!(map.cast_ray(outside, Vec2::y(), 9.0), None);
        assert_eq!(map.cast_ray(outside, Vec2::zeros(), 9.0), None);
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(map.cast_ray(Vec2::new(bad, 0.0), Vec2::x(), 9.0), None);
            assert_eq!(map.cast_ray(outside, Vec2::new(bad, 0.0), 9.0), None);
        }
        assert_eq!(map.cast_ray(outside, Vec2::x(), f64::NAN), None);
        let states = Window::filled(area, State::Unknown).unwrap();
        assert_eq!(RayMap::of_states(lattice, &states).cast_ray(outside, Vec2::x(), 99.0), None);
        let nothing = Window::filled(CellBox { width: 0, ..area }, State::Occupied).unwrap();
        assert_eq!(RayMap::of_states(lattice, &nothing).cast_ray(inside, Vec2::x(), 99.0), None);
        assert_eq!(map.memory_bytes(), 64 * 16);
    }
}
