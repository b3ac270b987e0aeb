//! A grid without ends: memory exists only where something was written.
//!
//! Tiles of 64 × 64 cells are made on demand. A directory of 64 × 64 tiles makes a block, and the
//! few blocks of a map are kept sorted, so a single reading far outside costs 24 kB and not the
//! rectangle up to it.

use std::ops::Range;

use crate::{Cell, CellBox, MapError, Window};

/// Side of a tile, cells.
pub const TILE_SIDE_CELLS: usize = 64;

const TILE_BITS: u32 = TILE_SIDE_CELLS.trailing_zeros();
const TILE_MASK: i32 = TILE_SIDE_CELLS as i32 - 1;
const TILE_CELLS: usize = TILE_SIDE_CELLS * TILE_SIDE_CELLS;
/// In a block: no tile here.
const NO_TILE: u32 = u32::MAX;

/// A grid over all cells, of which all but the written ones have the `unknown` value.
#[derive(Clone, Debug)]
pub struct TileGrid<T> {
    unknown: T,
    /// In order of age.
    tiles: Vec<Box<[T]>>,
    /// In order of row, then column.
    blocks: Vec<Block>,
    /// Place of the block that was last written to.
    recent: usize,
}

/// A square of 64 × 64 tiles.
#[derive(Clone, Debug)]
struct Block {
    row: i32,
    column: i32,
    /// Indices of tiles, row by row, [`NO_TILE`] for none.
    tiles: Box<[u32]>,
}

/// A tile of a [`TileGrid`].
#[derive(Clone, Copy, Debug)]
pub struct Tile<'a, T> {
    /// Its lower left cell.
    pub min: Cell,
    /// [`TILE_SIDE_CELLS`]² values, row by row from the bottom.
    pub values: &'a [T],
}

/// Where a cell is kept: the tile, and the place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Slot {
    tile: u32,
    place: u32,
}

impl<T: Copy + PartialEq> TileGrid<T> {
    /// A grid in which nothing was written.
    pub const fn new(unknown: T) -> Self {
        Self { unknown, tiles: Vec::new(), blocks: Vec::new(), recent: 0 }
    }

    /// The value of cells that were never written.
    pub const fn unknown(&self) -> T {
        self.unknown
    }

    /// The value of a cell.
    pub fn get(&self, cell: Cell) -> T {
        match self.tile_index(tile_of(cell)) {
            Some(index) => self.tiles[index][place_of(cell)],
            None => self.unknown,
        }
    }

    /// Writes a cell.
    pub fn set(&mut self, cell: Cell, value: T) {
        *self.value_mut(cell) = value;
    }

    /// The value of a cell, to be changed; makes its tile.
    pub fn value_mut(&mut self, cell: Cell) -> &mut T {
        let slot = self.slot(cell);
        &mut self.tiles[slot.tile as usize][slot.place as usize]
    }

    /// Hands out the cells of `columns` in `row`, tile by tile from left to right, to be changed.
    pub fn change_span(&mut self, row: i32, columns: Range<i32>, mut change: impl FnMut(&mut [T])) {
        let mut column = columns.start;
        while column < columns.end {
            let cell = Cell { column, row };
            let slot = self.slot(cell);
            let left_in_tile = TILE_SIDE_CELLS as i32 - (column & TILE_MASK);
            let n = left_in_tile.min(columns.end - column);
            let start = slot.place as usize;
            change(&mut self.tiles[slot.tile as usize][start..start + n as usize]);
            column += n;
        }
    }

    /// The tiles that exist, in an order that depends only on where they are: by blocks of 64 × 64
    /// tiles, each row by row.
    pub fn tiles(&self) -> impl Iterator<Item = Tile<'_, T>> {
        self.blocks.iter().flat_map(|block| {
            let here = block.tiles.iter().enumerate().filter(|(_, index)| **index != NO_TILE);
            here.map(|(place, &index)| {
                let column = (block.column << TILE_BITS) + (place as i32 & TILE_MASK);
                let row = (block.row << TILE_BITS) + (place as i32 >> TILE_BITS);
                let min = Cell { column: column << TILE_BITS, row: row << TILE_BITS };
                Tile { min, values: &self.tiles[index as usize] }
            })
        })
    }

    /// Cells that are not unknown, with their values, in the order of [`tiles`](Self::tiles).
    pub fn known(&self) -> impl Iterator<Item = (Cell, T)> {
        self.tiles().flat_map(|tile| {
            tile.values.iter().enumerate().filter(|(_, value)| **value != self.unknown).map(
                move |(place, &value)| {
                    let (x, y) = (place % TILE_SIDE_CELLS, place / TILE_SIDE_CELLS);
                    (tile.min.offset(x as i32, y as i32), value)
                },
            )
        })
    }

    /// The smallest rectangle around all cells that are not unknown, or `None` if all are.
    ///
    /// Looks at every tile.
    pub fn bounds(&self) -> Option<CellBox> {
        let mut bounds: Option<CellBox> = None;
        for tile in self.tiles() {
            // A tile that lies inside already cannot add anything.
            if let Some(known) = bounds
                && known.contains(tile.min)
                && known.contains(tile.min.offset(TILE_MASK, TILE_MASK))
            {
                continue;
            }
            if let Some(here) = self.bounds_of_tile(&tile) {
                bounds = Some(bounds.map_or(here, |known| known.union(&here)));
            }
        }
        bounds
    }

    /// The cells of `area` as a dense window.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`] above [`WINDOW_CELLS_MAX`](crate::WINDOW_CELLS_MAX) cells.
    pub fn crop(&self, area: CellBox) -> Result<Window<T>, MapError> {
        let mut window = Window::filled(area, self.unknown)?;
        let corner = Cell {
            column: (area.column_end() - 1).max(i64::from(area.min.column)) as i32,
            row: (area.row_end() - 1).max(i64::from(area.min.row)) as i32,
        };
        let (first, last) = (tile_of(area.min), tile_of(corner));
        for tile_row in first.1..=last.1 {
            for tile_column in first.0..=last.0 {
                if let Some(index) = self.tile_index((tile_column, tile_row)) {
                    let (column, row) = (tile_column << TILE_BITS, tile_row << TILE_BITS);
                    copy_tile(&self.tiles[index], Cell { column, row }, &mut window);
                }
            }
        }
        Ok(window)
    }

    /// Writes the cells of `window`; unknown values are written where a tile exists, and make none.
    pub fn paste(&mut self, window: &Window<T>) {
        let area = window.area();
        for y in 0..area.height {
            let row = (i64::from(area.min.row) + y as i64) as i32;
            let values = window.row(row);
            let mut x = 0;
            while x < area.width {
                let cell = Cell { column: area.min.column + x as i32, row };
                let left_in_tile = TILE_SIDE_CELLS - (cell.column & TILE_MASK) as usize;
                let n = left_in_tile.min(area.width - x);
                let new = &values[x..x + n];
                let empty = new.iter().all(|value| *value == self.unknown);
                if !empty || self.tile_index(tile_of(cell)).is_some() {
                    let slot = self.slot(cell);
                    let start = slot.place as usize;
                    self.tiles[slot.tile as usize][start..start + n].copy_from_slice(new);
                }
                x += n;
            }
        }
    }

    /// Forgets every value but keeps the memory for the next use at the same place.
    pub fn clear(&mut self) {
        for tile in &mut self.tiles {
            tile.fill(self.unknown);
        }
    }

    /// How many tiles exist.
    pub fn n_tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Memory held for cells and directories, bytes.
    pub fn memory_bytes(&self) -> usize {
        let tile = TILE_CELLS * size_of::<T>() + size_of::<Box<[T]>>();
        let block = TILE_CELLS * size_of::<u32>() + size_of::<Block>();
        self.tiles.len() * tile + self.blocks.len() * block
    }

    /// Where `cell` is kept; makes its tile.
    pub(crate) fn slot(&mut self, cell: Cell) -> Slot {
        let key = tile_of(cell);
        let tile = match self.recent_tile(key) {
            Some(index) => index,
            None => self.find_or_make_tile(key),
        };
        Slot { tile, place: place_of(cell) as u32 }
    }

    pub(crate) fn at(&self, slot: Slot) -> T {
        self.tiles[slot.tile as usize][slot.place as usize]
    }

    pub(crate) fn at_mut(&mut self, slot: Slot) -> &mut T {
        &mut self.tiles[slot.tile as usize][slot.place as usize]
    }

    /// The tile with this column and row, if it exists and its block was the last written to.
    fn recent_tile(&self, (column, row): (i32, i32)) -> Option<u32> {
        let block = self.blocks.get(self.recent)?;
        let same = block.column == column >> TILE_BITS && block.row == row >> TILE_BITS;
        if !same {
            return None;
        }
        let index = block.tiles[place_of(Cell { column, row })];
        (index != NO_TILE).then_some(index)
    }

    #[cold]
    fn find_or_make_tile(&mut self, (column, row): (i32, i32)) -> u32 {
        let (block_column, block_row) = (column >> TILE_BITS, row >> TILE_BITS);
        self.recent = match self.find_block(block_column, block_row) {
            Ok(place) => place,
            Err(place) => {
                let tiles = vec![NO_TILE; TILE_CELLS].into_boxed_slice();
                self.blocks.insert(place, Block { row: block_row, column: block_column, tiles });
                place
            }
        };
        let entry = &mut self.blocks[self.recent].tiles[place_of(Cell { column, row })];
        if *entry == NO_TILE {
            *entry = self.tiles.len() as u32;
            self.tiles.push(vec![self.unknown; TILE_CELLS].into_boxed_slice());
        }
        *entry
    }

    fn find_block(&self, column: i32, row: i32) -> Result<usize, usize> {
        self.blocks.binary_search_by_key(&(row, column), |block| (block.row, block.column))
    }

    fn tile_index(&self, key: (i32, i32)) -> Option<usize> {
        if let Some(index) = self.recent_tile(key) {
            return Some(index as usize);
        }
        let (column, row) = key;
        let place = self.find_block(column >> TILE_BITS, row >> TILE_BITS).ok()?;
        let index = self.blocks[place].tiles[place_of(Cell { column, row })];
        (index != NO_TILE).then_some(index as usize)
    }

    fn bounds_of_tile(&self, tile: &Tile<'_, T>) -> Option<CellBox> {
        let (mut low, mut high) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for (y, row) in tile.values.chunks_exact(TILE_SIDE_CELLS).enumerate() {
            let known = |value: &T| *value != self.unknown;
            let Some(first) = row.iter().position(known) else { continue };
            let last = row.iter().rposition(known).unwrap_or(first);
            low = (low.0.min(first as i32), low.1.min(y as i32));
            high = (high.0.max(last as i32), high.1.max(y as i32));
        }
        (low.0 <= high.0).then(|| {
            CellBox::spanning(tile.min.offset(low.0, low.1), tile.min.offset(high.0, high.1))
        })
    }
}

/// Column and row of the tile that has `cell`.
const fn tile_of(cell: Cell) -> (i32, i32) {
    (cell.column >> TILE_BITS, cell.row >> TILE_BITS)
}

/// The place of a cell in its tile (and of a tile in its block, which is as wide).
const fn place_of(cell: Cell) -> usize {
    (((cell.row & TILE_MASK) << TILE_BITS) | (cell.column & TILE_MASK)) as usize
}

/// Copies what a tile and a window have in common.
fn copy_tile<T: Copy>(tile: &[T], min: Cell, window: &mut Window<T>) {
    let area = window.area();
    let common = area.intersection(&tile_box(min));
    for y in 0..common.height {
        let first = common.min.offset(0, y as i32);
        let from = place_of(first);
        let to = (first.column - area.min.column) as usize;
        window.row_mut(first.row)[to..to + common.width]
            .copy_from_slice(&tile[from..from + common.width]);
    }
}

const fn tile_box(min: Cell) -> CellBox {
    CellBox { min, width: TILE_SIDE_CELLS, height: TILE_SIDE_CELLS }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};
    use std::collections::BTreeMap;

    /// Columns and rows on both sides of zero, of tiles and of blocks.
    fn coordinate() -> impl Strategy<Value = i32> {
        prop_oneof![
            -130..130_i32,
            -4200..-4000_i32,
            4000..4200_i32,
            Just(1 << 30),
            Just(-(1 << 30))
        ]
    }

    proptest! {
        #[test]
        fn a_grid_is_a_map_from_cells_to_values(
            writes in vec((coordinate(), coordinate(), 1..9_u8), 0..60),
        ) {
            let mut grid = TileGrid::new(0_u8);
            let mut oracle = BTreeMap::new();
            for &(column, row, value) in &writes {
                grid.set(Cell { column, row }, value);
                oracle.insert(Cell { column, row }, value);
            }
            for &(column, row, _) in &writes {
                for near in [(0, 0), (1, 0), (0, -1), (64, 0), (-4096, 4096)] {
                    let cell = Cell { column, row }.offset(near.0, near.1);
                    prop_assert_eq!(grid.get(cell), oracle.get(&cell).copied().unwrap_or(0));
                }
            }
            let mut known: Vec<_> = grid.known().collect();
            known.sort();
            prop_assert_eq!(known, oracle.clone().into_iter().collect::<Vec<_>>());
            let around = oracle.keys().map(|&cell| CellBox::spanning(cell, cell));
            prop_assert_eq!(grid.bounds(), around.reduce(|a, b| a.union(&b)));
        }

        #[test]
        fn the_order_of_writing_does_not_show(
            mut writes in vec((coordinate(), coordinate()), 1..20),
        ) {
            let write = |cells: &[(i32, i32)]| {
                let mut grid = TileGrid::new(false);
                for &(column, row) in cells {
                    grid.set(Cell { column, row }, true);
                }
                grid.tiles().map(|t| (t.min, t.values.to_vec())).collect::<Vec<_>>()
            };
            let forwards = write(&writes);
            writes.reverse();
            prop_assert_eq!(forwards, write(&writes));
        }

        #[test]
        fn spans_change_their_cells_only(row in coordinate(), start in -200..200_i32, n in 0..300) {
            let mut grid = TileGrid::new(0_u8);
            grid.change_span(row, start..start + n, |cells| cells.iter_mut().for_each(|v| *v += 1));
            let written: Vec<_> = grid.known().collect();
            prop_assert_eq!(written.len(), n as usize);
            for (cell, value) in written {
                prop_assert!(value == 1 && cell.row == row);
                prop_assert!((start..start + n).contains(&cell.column));
            }
        }

        #[test]
        fn what_is_cropped_and_pasted_stays(
            cells in vec((-90..90_i32, -90..90_i32), 1..40),
            corner in (-100..100_i32, -100..100_i32),
            width in 0..150_usize,
            height in 0..150_usize,
        ) {
            let mut grid = TileGrid::new(0_u16);
            for (i, &(column, row)) in (1..).zip(&cells) {
                grid.set(Cell { column, row }, i);
            }
            let area = CellBox { min: Cell::new(corner.0, corner.1), width, height };
            let window = grid.crop(area).unwrap();
            for (cell, value) in window.iter() {
                prop_assert_eq!(value, grid.get(cell));
            }
            let mut copy = TileGrid::new(0_u16);
            copy.paste(&window);
            for (cell, value) in grid.known() {
                prop_assert_eq!(copy.get(cell), if area.contains(cell) { value } else { 0 });
            }
            // Pasting unknown over known forgets.
            grid.paste(&Window::filled(area, 0).unwrap());
            prop_assert!(grid.known().all(|(cell, _)| !area.contains(cell)));
        }
    }

    #[test]
    fn an_empty_grid_costs_nothing_and_a_far_cell_little() {
        let mut grid = TileGrid::new(0_i16);
        assert_eq!((grid.memory_bytes(), grid.bounds(), grid.n_tiles()), (0, None, 0));
        grid.set(Cell::new(0, 0), 1);
        grid.set(Cell::new(1 << 30, -(1 << 30)), 1);
        assert!(grid.memory_bytes() < 60_000, "{}", grid.memory_bytes());
        assert!(grid.crop(grid.bounds().unwrap()).is_err());
        grid.clear();
        assert_eq!((grid.bounds(), grid.n_tiles(), grid.get(Cell::new(0, 0))), (None, 2, 0));
        // Unknown values make no tile.
        grid.paste(&Window::filled(tile_box(Cell::new(640, 640)), 0).unwrap());
        assert_eq!(grid.n_tiles(), 2);
    }
}
