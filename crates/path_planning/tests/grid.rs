//! Ways over cells against a search that shares nothing with ours, and against the lengths of public benchmarks.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{collections::BinaryHeap, f64::consts::SQRT_2, io::Read as _};

use grid_maps::{Cell, CellBox, State, Window, files::moving_ai};
use path_planning::{Budget, FreeFloor, GridMethod, GridOutcome, GridPath, GridSearch, scenario};
use proptest::prelude::*;
use settings::Choice as _;

fn window(width: usize, blocked: &[bool]) -> Window<bool> {
    let area = CellBox { min: Cell::new(0, 0), width, height: blocked.len() / width };
    Window::from_values(area, blocked.to_vec()).unwrap()
}

/// Dijkstra over all cells, with a heap of whole numbers: lengths are counts of straight and diagonal steps, and the
/// shortest by length. `None` where no way leads.
fn lengths(cells: &Window<bool>, from: Cell) -> Vec<Option<f64>> {
    let area = cells.area();
    let (width, height) = (area.width as i32, area.height as i32);
    let free = |x: i32, y: i32| cells.get(Cell::new(x, y)) == Some(false);
    let mut best = vec![None; area.n_cells()];
    let mut heap = BinaryHeap::new();
    let key = |straight: u32, diagonal: u32| {
        let length = f64::from(straight) + SQRT_2 * f64::from(diagonal);
        std::cmp::Reverse(((length * 1e9) as u64, straight, diagonal))
    };
    if free(from.column, from.row) {
        heap.push((key(0, 0), from.column, from.row));
    }
    while let Some((std::cmp::Reverse((_, straight, diagonal)), x, y)) = heap.pop() {
        let at = (y * width + x) as usize;
        if best[at].is_some() {
            continue;
        }
        best[at] = Some(f64::from(straight) + SQRT_2 * f64::from(diagonal));
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let (i, j) = (x + dx, y + dy);
            let open = free(i, j) && free(x, j) && free(i, y);
            if (dx, dy) == (0, 0) || !open || !(0..width).contains(&i) || !(0..height).contains(&j)
            {
                continue;
            }
            let is_diagonal = u32::from(dx != 0 && dy != 0);
            heap.push((key(straight + 1 - is_diagonal, diagonal + is_diagonal), i, j));
        }
    }
    best
}

/// Walks along a way: every piece is straight over free cells, its steps are open, and its length is as told.
fn check_way(cells: &Window<bool>, path: &GridPath, from: Cell, to: Cell) {
    let free = |x: i32, y: i32| cells.get(Cell::new(x, y)) == Some(false);
    assert_eq!((path.turns[0], *path.turns.last().unwrap()), (from, to));
    let mut length = 0.0;
    for pair in path.turns.windows(2) {
        let (dx, dy) = (pair[1].column - pair[0].column, pair[1].row - pair[0].row);
        assert!(dx == 0 || dy == 0 || dx.abs() == dy.abs(), "{pair:?} is no straight piece");
        let (sx, sy) = (dx.signum(), dy.signum());
        let (mut x, mut y) = (pair[0].column, pair[0].row);
        for _ in 0..dx.abs().max(dy.abs()) {
            assert!(
                free(x + sx, y) && free(x, y + sy) && free(x + sx, y + sy),
                "{pair:?} at {x} {y}"
            );
            (x, y) = (x + sx, y + sy);
            length += if sx != 0 && sy != 0 { SQRT_2 } else { 1.0 };
        }
    }
    assert!((length - path.length_cells).abs() < 1e-6, "{length} {}", path.length_cells);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Rows shorter and longer than a word; every density of obstacles; each method again and again on one memory.
    #[test]
    fn ways_are_as_short_as_those_of_another_search(
        (width, height) in prop_oneof![(1_usize..20, 1_usize..20), (60_usize..70, 3_usize..9), (3_usize..9, 125_usize..135)],
        density in 0.0..0.5_f64,
        noise in proptest::collection::vec(0.0..1.0_f64, 20 * 135),
        ends in proptest::collection::vec((0..1000_usize, 0..1000_usize), 6),
    ) {
        let blocked: Vec<bool> = noise[..width * height].iter().map(|n| *n < density).collect();
        let cells = window(width, &blocked);
        let mut search = GridSearch::new(FreeFloor::new(&cells, |b| b).unwrap());
        let cell = |k: usize| Cell::new((k % width) as i32, (k / width % height) as i32);
        for (a, b) in ends {
            let (from, to) = (cell(a * 7), cell(b * 13));
            let truth = lengths(&cells, from);
            let expected = truth[to.row as usize * width + to.column as usize];
            for &method in GridMethod::ALL {
                let found = search.find(from, to, method, Budget::UNLIMITED);
                match (found, expected) {
                    (GridOutcome::Found(path), Some(length)) if method != GridMethod::AnyAngle => {
                        prop_assert!((path.length_cells - length).abs() < 1e-6, "{:?} {} {}", method, path.length_cells, length);
                        check_way(&cells, &path, from, to);
                    }
                    (GridOutcome::Found(path), Some(length)) => {
                        let far = f64::from(to.column - from.column).hypot(f64::from(to.row - from.row));
                        prop_assert!(path.length_cells <= length + 1e-6 && path.length_cells >= far - 1e-9);
                        for pair in path.turns.windows(2) {
                            prop_assert!(search.floor().sees(pair[0], pair[1]), "{:?}", pair);
                        }
                    }
                    (GridOutcome::StartBlocked, None) => prop_assert!(cells.get(from) == Some(true)),
                    (GridOutcome::GoalBlocked { nearest } | GridOutcome::Unreachable { nearest }, None) => {
                        let far = |c: Cell| i64::from(c.column - to.column).pow(2) + i64::from(c.row - to.row).pow(2);
                        let reachable = |i: &usize| truth[*i].is_some();
                        let least = (0..truth.len()).filter(reachable).map(|i| far(cell(i))).min().unwrap();
                        prop_assert_eq!(far(nearest), least);
                        prop_assert!(truth[nearest.row as usize * width + nearest.column as usize].is_some());
                    }
                    (found, expected) => prop_assert!(false, "{:?} {:?} {:?}", method, found, expected),
                }
            }
        }
    }

    /// Oracle: a disc laid on every cell, square by square.
    #[test]
    fn a_disc_stands_where_it_reaches_into_nothing_solid(
        noise in proptest::collection::vec(prop::bool::weighted(0.1), 17 * 11),
        radius in 0.0..4.0_f64,
        beyond: bool,
    ) {
        let cells = window(17, &noise);
        let solid = grid_maps::SolidCells::new(&cells, |b| b, beyond);
        let floor = FreeFloor::of_solid_for_disc(&solid, radius).unwrap();
        for y in 0..11 {
            for x in 0..17 {
                let here = Cell::new(x, y);
                let blocked = cells.get(here) == Some(true);
                // Middle to middle, less half a cell: the rule that is documented.
                let near = (0..11).flat_map(|j| (0..17).map(move |i| (i, j))).any(|(i, j)| {
                    let far = f64::from(i - x).hypot(f64::from(j - y)) - 0.5;
                    cells.get(Cell::new(i, j)) == Some(true) && far < radius - 1e-12
                });
                prop_assert_eq!(floor.is_free(here), !(blocked || near && radius > 0.0), "{} {}", x, y);
            }
        }
    }
}

#[test]
fn a_budget_ends_a_search_and_the_next_one_is_whole() {
    let cells = window(64, &vec![false; 64 * 64]);
    let mut search = GridSearch::new(FreeFloor::new(&cells, |b| b).unwrap());
    let (from, to) = (Cell::new(0, 0), Cell::new(63, 20));
    for &method in GridMethod::ALL {
        let little = Budget { n_expanded_max: 0 };
        assert_eq!(search.find(from, to, method, little), GridOutcome::BudgetSpent);
        let GridOutcome::Found(path) = search.find(from, to, method, Budget::UNLIMITED) else {
            panic!()
        };
        assert!(path.length_cells > 60.0 && search.effort().n_expanded > 0);
    }
    let outside = search.find(Cell::new(-1, 0), to, GridMethod::AStar, Budget::UNLIMITED);
    assert_eq!(outside, GridOutcome::StartBlocked);
    let outside = search.find(from, Cell::new(64, 20), GridMethod::AStar, Budget::UNLIMITED);
    assert_eq!(outside, GridOutcome::GoalBlocked { nearest: Cell::new(63, 20) });
}

fn unpacked(path: &std::path::Path) -> String {
    let mut text = String::new();
    let file = std::fs::File::open(path).unwrap();
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap();
    text
}

/// Every query of every map, in release; in a debug build each 25th.
#[test]
fn lengths_of_public_benchmarks_are_met() {
    let Some(folder) = testkit::data_folder("movingai") else { return };
    let mut n_checked = 0;
    let mut names: Vec<_> =
        std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    for path in names.iter().filter(|p| p.to_string_lossy().ends_with(".scen.gz")) {
        let map = path.to_string_lossy().replace(".scen.gz", ".gz");
        let states = moving_ai::read(&unpacked(std::path::Path::new(&map))).unwrap();
        let floor = FreeFloor::new(&states, |state| state != State::Free).unwrap();
        let height = floor.height();
        let mut search = GridSearch::new(floor);
        let queries = scenario::parse(&unpacked(path)).unwrap();
        let every = if cfg!(debug_assertions) { 25 } else { 1 };
        for query in queries.iter().step_by(every) {
            let cell = |[x, y]: [usize; 2]| Cell::new(x as i32, (height - 1 - y) as i32);
            for method in [GridMethod::AStar, GridMethod::JumpPoints] {
                let found =
                    search.find(cell(query.start), cell(query.goal), method, Budget::UNLIMITED);
                let GridOutcome::Found(path) = found else {
                    panic!("{map}:{} {found:?}", query.line)
                };
                let off = (path.length_cells - query.optimal_cells).abs();
                assert!(
                    off < query.tolerance_cells,
                    "{map}:{} {method:?} {}",
                    query.line,
                    path.length_cells
                );
                n_checked += 1;
            }
        }
    }
    assert!(n_checked > 600, "{n_checked}");
}
