//! Against a loop over all parts with the same exact test: the raster must change nothing.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::{super::bvh::Bvh, super::parts::Block, build::CELLS_MAX, *};
use crate::{Ray, RayHit, Segment};

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn wall(a: Vec2, b: Vec2) -> (Segment, u32) {
    (Segment { a, b }, 0)
}

fn block(centre: Vec2, half_m: f64, index: u32) -> Block {
    let bounds = Aabb { min: centre, max: centre }.grown(half_m);
    Block { bounds, tag: index, index }
}

/// Numbers walls by their places, so that a tie that goes the wrong way shows.
fn parts(walls: &[(Segment, u32)], blocks: &[Block]) -> Parts {
    let walls: Vec<_> = walls.iter().map(|w| w.0).zip(0..).collect();
    Bvh::build(&walls, blocks).parts().clone()
}

fn by_raster(parts: &Parts, grid: &Grid, probe: &Probe, range_m: f64) -> Option<RayHit> {
    let mut nearest = Nearest::none_within(range_m);
    grid.cast(parts, probe, &mut nearest);
    parts.hit(probe, &nearest)
}

fn by_loop(parts: &Parts, probe: &Probe, range_m: f64) -> Option<RayHit> {
    let mut nearest = Nearest::none_within(range_m);
    let walls = (0..parts.walls.len()).map(Part::wall);
    for part in walls.chain((0..parts.blocks.len()).map(Part::block)) {
        parts.offer(part, probe, &mut nearest);
    }
    parts.hit(probe, &nearest)
}

fn check(parts: &Parts, grid: &Grid, origin: Vec2, direction: Vec2) {
    let probe = Probe::new(&Ray { origin, direction }).unwrap();
    let wanted = by_loop(parts, &probe, f64::INFINITY);
    assert_eq!(by_raster(parts, grid, &probe, f64::INFINITY), wanted, "{probe:?}");
    // The limit belongs to the range, to the last digit.
    if let Some(hit) = wanted {
        assert_eq!(by_raster(parts, grid, &probe, hit.distance_m), wanted, "{probe:?}");
        let short = by_raster(parts, grid, &probe, hit.distance_m.next_down());
        assert!(short.is_none(), "{probe:?}");
    }
}

/// Both signs of both axes, both diagonals, and directions a hair off them.
fn directions() -> Vec<Vec2> {
    let turns = (0..8).map(|i| f64::from(i) * TAU / 8.0);
    let off = [0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-4, -1e-4];
    let near = turns.flat_map(|turn| off.map(|off| v((turn + off).cos(), (turn + off).sin())));
    let axes = [v(1.0, 0.0), v(-1.0, 0.0), v(0.0, 1.0), v(0.0, -1.0), v(1.0, -0.0), v(-0.0, -1.0)];
    near.chain(axes).collect()
}

#[test]
fn rays_and_parts_on_the_borders_of_cells_are_told_nothing_else() {
    // Two far corners fix the raster; from then on the borders are known.
    let (low, high) = (v(-3.0, -2.0), v(5.0, 4.0));
    let mut walls = vec![wall(low, low), wall(high, high)];
    let raster = Grid::build(&parts(&walls, &[])).unwrap();
    let corner_of = |column: i32, row: i32| {
        raster.corner + raster.cell_m * v(f64::from(column), f64::from(row))
    };
    let mut blocks = Vec::new();
    for (i, (column, row)) in (0_u32..).zip([(20, 20), (31, 12), (40, 40), (9, 33), (50, 21)]) {
        let (here, cell) = (corner_of(column, row), raster.cell_m);
        walls.push(wall(here, corner_of(column + 3, row)));
        walls.push(wall(corner_of(column, row + 5), corner_of(column, row + 2)));
        walls.push(wall(corner_of(column + 6, row), corner_of(column + 8, row + 2)));
        walls.push(wall(corner_of(column + 6, row), corner_of(column + 4, row - 2)));
        // A block whose sides lie on borders, and one that is a point on a corner.
        blocks.push(block(corner_of(column + 10, row - 4), cell, 2 * i));
        blocks.push(block(corner_of(column - 4, row + 4), 0.0, 2 * i + 1));
    }
    let parts = parts(&walls, &blocks);
    let grid = Grid::build(&parts).unwrap();
    assert_eq!(
        (grid.corner, grid.columns, grid.rows),
        (raster.corner, raster.columns, raster.rows)
    );
    let nudges = [0.0, 1e-15, -1e-15, 1e-7, -1e-7, 0.5 * raster.cell_m];
    for (column, row) in (8..58).step_by(3).flat_map(|x| (4..48).step_by(4).map(move |y| (x, y))) {
        for nudge in nudges {
            for direction in directions() {
                check(&parts, &grid, corner_of(column, row) + v(nudge, -nudge), direction);
            }
        }
    }
    // Along and across the outermost borders, from outside and from the corners.
    for origin in [low, high, v(-3.0, 4.0), v(5.0, -2.0), v(-9.0, -2.0), v(5.0, 11.0)] {
        for direction in directions() {
            check(&parts, &grid, origin, direction);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn the_raster_changes_no_result(
        walls in proptest::collection::vec((-8.0..8.0, -8.0..8.0, -2.0..2.0, -2.0..2.0), 1..60),
        blocks in proptest::collection::vec((-60..60_i32, -60..60_i32), 0..200),
        rays in proptest::collection::vec((-12.0..12.0, -12.0..12.0, 0.0..TAU), 60),
    ) {
        let walls = walls.iter().map(|&(x, y, dx, dy)| wall(v(x, y), v(x + dx, y + dy)));
        let walls: Vec<_> = walls.collect();
        let blocks = blocks.iter().zip(0_u32..);
        let blocks = blocks.map(|(&(x, y), i)| block(v(x.into(), y.into()) * 0.15, 0.075, i));
        let blocks: Vec<_> = blocks.collect();
        let parts = parts(&walls, &blocks);
        let grid = Grid::build(&parts).unwrap();
        for (x, y, angle) in rays {
            check(&parts, &grid, v(x, y), v(angle.cos(), angle.sin()));
        }
    }

    /// Each named rectangle is empty, whatever the quadrant.
    #[test]
    fn named_rectangles_are_empty(
        lengths in proptest::collection::vec(prop_oneof![9 => Just(0_u32), 1 => Just(2_u32)], 15 * 11),
    ) {
        let cells = empty::rectangles(&lengths, 15);
        let is_free = |x: i32, y: i32| {
            let outside = !(0..15).contains(&x) || !(0..11).contains(&y);
            outside || lengths[(y * 15 + x) as usize] == 0
        };
        for (x, y) in (0..15).flat_map(|x| (0..11).map(move |y| (x, y))) {
            if !is_free(x, y) {
                continue;
            }
            for (quadrant, (right, up)) in [(1, 1), (-1, 1), (1, -1), (-1, -1)].into_iter().enumerate() {
                let [width, height] = cells[(y * 15 + x) as usize].shape(quadrant).map(|n| n as i32);
                for (i, j) in (0..width).flat_map(|i| (0..height).map(move |j| (i, j))) {
                    prop_assert!(is_free(x + i * right, y + j * up));
                }
                let beside = is_free(x + right, y) || is_free(x, y + up);
                prop_assert!(!beside || width * height > 1, "room left unused");
            }
        }
    }
}

#[test]
fn memory_is_bounded_however_large_the_world_and_long_the_walls() {
    let far = 1e6;
    let walk = |i: u32, step: f64| (f64::from(i) * step).fract() * far;
    let across: Vec<_> = (0..2000)
        .map(|i| {
            let ends = [0.618_034, 0.754_878, 0.569_84, 0.414_214].map(|step| walk(i, step));
            wall(v(ends[0], ends[1]), v(ends[2], ends[3]))
        })
        .collect();
    let line: Vec<_> =
        (0..2000).map(|i| wall(v(walk(i, 0.618), 0.0), v(walk(i, 0.618), 0.0))).collect();
    for walls in [across, line] {
        let parts = parts(&walls, &[]);
        let Some(grid) = Grid::build(&parts) else { continue };
        assert!(grid.cells.len() <= CELLS_MAX, "{} cells", grid.cells.len());
        assert!(grid.groups.len() <= 16 * walls.len(), "{} groups", grid.groups.len());
        for i in 0..200 {
            let angle = f64::from(i) * 0.31;
            check(&parts, &grid, v(walk(i, 0.3), walk(i, 0.7)), v(angle.cos(), angle.sin()));
        }
    }
}

#[test]
fn more_parts_than_cells_share_them() {
    // Blocks on a raster of 1 m, so many that the wanted number of cells exceeds the limit.
    let side = 1500_u32;
    let blocks = (0..side * side).map(|i| {
        let centre = v(f64::from(i % side), f64::from(i / side));
        block(centre, 0.1, i)
    });
    let blocks: Vec<_> = blocks.collect();
    let parts = Parts {
        walls: Vec::new(),
        bounds: blocks.iter().fold(Aabb::EMPTY, |grown, b| grown.union(b.bounds)),
        blocks,
    };
    let grid = Grid::build(&parts).unwrap();
    assert!(grid.cells.len() <= CELLS_MAX && grid.cells.len() > CELLS_MAX / 4);
    let probe = Probe::new(&Ray { origin: v(700.5, 800.0), direction: v(-1.0, 0.0) }).unwrap();
    let hit = by_raster(&parts, &grid, &probe, f64::INFINITY).unwrap();
    assert!((hit.distance_m - 0.4).abs() < 1e-9 && hit.tag == 800 * side + 700);
    let between = Probe::new(&Ray { origin: v(700.5, 800.5), direction: v(0.0, 1.0) }).unwrap();
    assert_eq!(by_raster(&parts, &grid, &between, f64::INFINITY), None);
}

#[test]
fn a_crowd_in_a_wide_world_has_no_raster() {
    let mut walls: Vec<_> =
        (0..3000).map(|i| wall(v(f64::from(i) * 0.1, 0.0), v(f64::from(i) * 0.1, 0.3))).collect();
    assert!(Grid::build(&parts(&walls, &[])).is_some());
    walls.push(wall(v(1e5, 1e5), v(1e5, 1e5)));
    assert!(Grid::build(&parts(&walls, &[])).is_none());
    assert!(Grid::build(&parts(&[], &[])).is_none());
    assert!(Grid::build(&parts(&[wall(v(0.0, 0.0), v(1e200, 1e200))], &[])).is_none());
    let unresolved = [wall(v(1e15, 0.0), v(1e15, 1.0))];
    assert!(Grid::build(&parts(&unresolved, &[])).is_none_or(|grid| grid.cell_m > 1.0));
}
