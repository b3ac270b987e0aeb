//! Measures the empty space around each cell.

use super::{Cell, EXTENTS};

/// The greatest extent.
const LONGEST: u8 = EXTENTS[EXTENTS.len() - 1];

/// For each extent that there may be, the place in [`EXTENTS`] of the greatest that is at most it.
static FLOORS: [u8; LONGEST as usize + 1] = floors();

const fn floors() -> [u8; LONGEST as usize + 1] {
    let mut floors = [0; LONGEST as usize + 1];
    let (mut extent, mut place) = (1, 0);
    while extent < floors.len() {
        if place + 1 < EXTENTS.len() && EXTENTS[place + 1] as usize <= extent {
            place += 1;
        }
        floors[extent] = place as u8;
        extent += 1;
    }
    floors
}

/// For each empty cell, in each quadrant the code of the largest empty rectangle with sides in
/// [`EXTENTS`]; other cells are left for their lists. `lengths` are those of the lists.
pub(super) fn rectangles(lengths: &[u32], columns: usize) -> Vec<Cell> {
    let n_rows = lengths.len() / columns;
    let mut cells = vec![Cell(0); lengths.len()];
    for to_left in [false, true] {
        let runs = runs(lengths, columns, to_left);
        for down in [false, true] {
            let quadrant = u32::from(to_left) | u32::from(down) << 1;
            for (place, cell) in cells.iter_mut().enumerate().filter(|&(i, _)| lengths[i] == 0) {
                let row = place / columns;
                let code = if down {
                    largest_rectangle(row + 1, |i| runs[place - i * columns])
                } else {
                    largest_rectangle(n_rows - row, |i| runs[place + i * columns])
                };
                cell.0 |= u32::from(code) << (8 * quadrant);
            }
        }
    }
    cells
}

/// Empty cells from each cell on, itself included; beyond the raster all are empty.
fn runs(lengths: &[u32], columns: usize, to_left: bool) -> Vec<u8> {
    let mut runs = vec![0; lengths.len()];
    for (runs, lengths) in runs.chunks_mut(columns).zip(lengths.chunks(columns)) {
        let mut run = LONGEST;
        for i in 0..columns {
            let i = if to_left { i } else { columns - 1 - i };
            run = if lengths[i] > 0 { 0 } else { LONGEST.min(run + 1) };
            runs[i] = run;
        }
    }
    runs
}

/// The code of the largest rectangle over `n_rows` rows with empty runs of the given lengths;
/// beyond them all is empty. The first run is not 0.
fn largest_rectangle(n_rows: usize, run: impl Fn(usize) -> u8) -> u8 {
    let (mut best, mut best_code) = (0, 0);
    let mut width = LONGEST;
    let mut height = 0;
    for (code_y, &extent) in (0_u8..).zip(&EXTENTS) {
        while height < usize::from(extent) {
            if height < n_rows {
                width = width.min(run(height));
            }
            height += 1;
        }
        if usize::from(width) * usize::from(LONGEST) <= best {
            break;
        }
        let code_x = FLOORS[usize::from(width)];
        let area = usize::from(EXTENTS[usize::from(code_x)]) * height;
        if area > best {
            (best, best_code) = (area, code_y << 4 | code_x);
        }
    }
    best_code
}
