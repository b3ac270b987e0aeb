//! Where a set of points fits best on a map, over a whole window of poses: correlative matching.
//!
//! The map is a grid of likelihoods; a pose's score is their mean under the points. A pyramid of
//! maxima bounds the score of many poses at once, so that branch and bound finds the best pose of the
//! window without looking at all. Use it when the guess may be wrong by more than what a gradient can
//! mend; follow it by [`refine`](super::surfels::SurfelMap::refine), which is finer than a cell.
//!
//! Source: E. Olson (2009), "Real-time correlative scan matching", ICRA (likelihood tables, covariance
//! of the score surface); W. Hess et al. (2016), "Real-time loop closure in 2D LIDAR SLAM", ICRA,
//! Algorithms 2 and 3 (branch and bound, precomputed maxima). Differences: a quadratic penalty for the
//! distance from the guess takes part in the bound.

use geometry::{Se2, Vec2, wrap_to_pi};
use nalgebra::{Matrix3, Vector3};

/// The greatest number of levels; a coarsest cell then bounds 2⁷ × 2⁷ shifts.
const LEVELS_MAX: usize = 8;

/// Likelihood of a surface per cell, 0 to 255, with maxima over squares of 2ʰ × 2ʰ cells.
#[derive(Clone, Debug, Default)]
pub struct ScoreGrid {
    origin: Vec2,
    resolution_m: f64,
    width: i32,
    height: i32,
    /// Level h, cell (x, y): the greatest likelihood in [x, x + 2ʰ) × [y, y + 2ʰ).
    levels: Vec<Vec<u8>>,
}

/// Which poses to try: a box about the guess, and how much distance from the guess costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchWindow {
    /// Greatest shift along x and along y, metres.
    pub half_m: f64,
    /// Greatest turn, radians.
    pub half_rad: f64,
    /// Standard deviation of the guess's position, metres; infinite for "anywhere in the window".
    pub std_m: f64,
    /// Standard deviation of the guess's yaw, radians.
    pub std_rad: f64,
}

/// The best pose of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// The pose of the points' frame in the map's, on the search lattice.
    pub pose: Se2,
    /// Mean likelihood under the points, 0 to 1.
    pub score_ratio: f64,
    /// Poses whose score was computed, bounds included.
    pub n_scored: usize,
}

/// Cells or turns to each side at most, however wide the window.
const HALF_MAX: i32 = 1 << 14;
/// What a unit of squared normalised distance from the guess takes off the score.
const PENALTY_RATIO: f64 = 0.01;

impl ScoreGrid {
    /// A grid over `points` (m) with a Gaussian of `std_m` about each, and `n_levels` levels.
    ///
    /// Cost: points times the Gaussian's cells, plus four passes over the grid for each level.
    pub fn of_points(points: &[Vec2], resolution_m: f64, std_m: f64, n_levels: usize) -> Self {
        let mut grid = Self::default();
        grid.rebuild(points, resolution_m, std_m, n_levels);
        grid
    }

    /// As [`of_points`](Self::of_points), in the memory that the grid already has.
    pub fn rebuild(&mut self, points: &[Vec2], resolution_m: f64, std_m: f64, n_levels: usize) {
        let n_levels = n_levels.clamp(1, LEVELS_MAX);
        let reach = (3.0 * std_m / resolution_m).ceil() as i32;
        let (min, max) = box_of(points);
        let margin_m = f64::from(reach + 1) * resolution_m;
        self.resolution_m = resolution_m;
        self.origin = min - Vec2::new(margin_m, margin_m);
        let cells = (max - self.origin) / resolution_m;
        self.width = cells.x.ceil() as i32 + reach + 2;
        self.height = cells.y.ceil() as i32 + reach + 2;
        if points.is_empty() {
            (self.width, self.height, self.origin) = (1, 1, Vec2::zeros());
        }
        self.levels.resize_with(n_levels, Vec::new);
        let n_cells = self.width as usize * self.height as usize;
        let finest = &mut self.levels[0];
        finest.clear();
        finest.resize(n_cells, 0);
        let side = 2 * reach + 1;
        let kernel: Vec<u8> = (0..side * side)
            .map(|i| {
                let (x, y) = (f64::from(i % side - reach), f64::from(i / side - reach));
                let d2 = (x * x + y * y) * (resolution_m / std_m).powi(2);
                (255.0 * (-0.5 * d2).exp()).round() as u8
            })
            .collect();
        for point in points {
            let cell = (point - self.origin) / resolution_m;
            let (cx, cy) = (cell.x.floor() as i32 - reach, cell.y.floor() as i32 - reach);
            for (row, values) in kernel.chunks_exact(side as usize).enumerate() {
                let start = ((cy + row as i32) * self.width + cx) as usize;
                for (cell, &value) in finest[start..start + side as usize].iter_mut().zip(values) {
                    *cell = (*cell).max(value);
                }
            }
        }
        for level in 1..n_levels {
            let (finer, coarser) = self.levels.split_at_mut(level);
            pool(&finer[level - 1], &mut coarser[0], self.width as usize, 1 << (level - 1));
        }
    }

    /// Mean likelihood (0 to 1) under `points` of the frame at `pose`; points off the grid count 0.
    pub fn score_ratio(&self, points: &[Vec2], pose: Se2) -> f64 {
        let cells: Vec<(i32, i32)> =
            points.iter().map(|&p| self.cell_of(pose.transform_point(p))).collect();
        f64::from(self.sum(0, &cells, 0, 0)) / (255.0 * points.len().max(1) as f64)
    }

    /// The best pose for `points` in the window about `guess`, if its score, less what its distance from the
    /// guess costs, exceeds `score_min_ratio`.
    ///
    /// The lattice of poses has the grid's resolution, and turns small enough that the farthest
    /// point moves by one cell. Of equal ones the first found; the same inputs give
    /// the same one. Cost: in the
    /// worst case all poses of the window times the points; usually a few thousand bounds.
    pub fn correlate(
        &self,
        points: &[Vec2],
        guess: Se2,
        window: &SearchWindow,
        score_min_ratio: f64,
    ) -> Option<Correlation> {
        if points.is_empty() || self.levels.is_empty() {
            return None;
        }
        let mut search = Search::new(self, points, guess, window, score_min_ratio);
        search.run();
        let best = search.best?;
        let yaw_rad = guess.yaw_rad + search.turns[best.turn].yaw_rad;
        let pose = Se2::new(
            guess.x_m + f64::from(best.x) * self.resolution_m,
            guess.y_m + f64::from(best.y) * self.resolution_m,
            yaw_rad,
        );
        let sum = self.sum(0, &search.turns[best.turn].cells, best.x, best.y);
        let score_ratio = f64::from(sum) / (255.0 * points.len() as f64);
        Some(Correlation { pose, score_ratio, n_scored: search.n_scored })
    }

    /// Covariance (x, y, yaw; m², rad²) of the pose about `best`, from the shape of the score about it.
    ///
    /// Source: Olson (2009), section III-D: scores are turned into probabilities and their second
    /// moments taken. Differences: probabilities are exp((s - s_best) / `temperature_ratio`), over
    /// ±`reach` cells and as many turns.
    pub fn covariance(
        &self,
        points: &[Vec2],
        best: Se2,
        reach: i32,
        temperature_ratio: f64,
    ) -> Matrix3<f64> {
        let step_rad = self.turn_step_rad(points);
        let top = self.score_ratio(points, best);
        let (mut k, mut u, mut s) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        let mut cells = Vec::with_capacity(points.len());
        for turn in -reach..=reach {
            let yaw_rad = f64::from(turn) * step_rad;
            let turned = Se2::new(best.x_m, best.y_m, best.yaw_rad + yaw_rad);
            cells.clear();
            cells.extend(points.iter().map(|&p| self.cell_of(turned.transform_point(p))));
            for y in -reach..=reach {
                for x in -reach..=reach {
                    let score =
                        f64::from(self.sum(0, &cells, x, y)) / (255.0 * points.len() as f64);
                    let p = ((score - top) / temperature_ratio).exp();
                    let d = Vector3::new(
                        f64::from(x) * self.resolution_m,
                        f64::from(y) * self.resolution_m,
                        yaw_rad,
                    );
                    k += d * d.transpose() * p;
                    u += d * p;
                    s += p;
                }
            }
        }
        k / s - u * u.transpose() / (s * s)
    }

    fn cell_of(&self, point: Vec2) -> (i32, i32) {
        let cell = (point - self.origin) / self.resolution_m;
        (cell.x.floor() as i32, cell.y.floor() as i32)
    }

    /// Sum of level `level` under cells shifted by (dx, dy).
    fn sum(&self, level: usize, cells: &[(i32, i32)], dx: i32, dy: i32) -> u32 {
        let grid = &self.levels[level];
        let (width, height) = (self.width as u32, self.height as u32);
        // A square of maxima that begins left of or below the grid may still reach into it; it is
        // bounded by the square that begins at the border, which contains its part of the grid.
        let side = (1 << level) - 1;
        let mut sum = 0;
        for &(x, y) in cells {
            let (mut x, mut y) = (x.saturating_add(dx), y.saturating_add(dy));
            if level > 0 {
                x = if x < 0 && x.saturating_add(side) >= 0 { 0 } else { x };
                y = if y < 0 && y.saturating_add(side) >= 0 { 0 } else { y };
            }
            // A negative number wraps to a huge one, so one comparison per axis does for two.
            if (x as u32) < width && (y as u32) < height {
                sum += u32::from(grid[(y as u32 * width + x as u32) as usize]);
            }
        }
        sum
    }

    /// The turn that moves the farthest of most points by one cell, radians.
    fn turn_step_rad(&self, points: &[Vec2]) -> f64 {
        let mut ranges: Vec<f64> = points.iter().map(Vec2::norm).collect();
        if ranges.is_empty() {
            return self.resolution_m;
        }
        let nth = (ranges.len() * 9 / 10).min(ranges.len() - 1);
        let (_, far_m, _) = ranges.select_nth_unstable_by(nth, f64::total_cmp);
        self.resolution_m / far_m.max(1.0)
    }
}

/// One turn of the points: their cells at no shift.
#[derive(Debug)]
struct Turn {
    yaw_rad: f64,
    cells: Vec<(i32, i32)>,
    penalty: f64,
}

/// A square of shifts, [x, x + 2ʰ) × [y, y + 2ʰ), at one turn.
#[derive(Clone, Copy, Debug)]
struct Node {
    turn: usize,
    x: i32,
    y: i32,
    bound: f64,
}

struct Search<'a> {
    grid: &'a ScoreGrid,
    turns: Vec<Turn>,
    /// Greatest shift, cells.
    half: i32,
    /// Penalty per squared cell.
    penalty_per_cell2: f64,
    score_scale: f64,
    best: Option<Node>,
    /// Nothing at or below it is wanted.
    best_bound: f64,
    n_scored: usize,
}

impl<'a> Search<'a> {
    /// Turns the points by every angle of the window once, which all shifts then share.
    fn new(
        grid: &'a ScoreGrid,
        points: &[Vec2],
        guess: Se2,
        window: &SearchWindow,
        score_min_ratio: f64,
    ) -> Self {
        let step_rad = grid.turn_step_rad(points);
        let half_rad = window.half_rad.min(std::f64::consts::PI);
        let n_turns = ((half_rad / step_rad).ceil() as i32).clamp(0, HALF_MAX);
        let turns = (-n_turns..=n_turns)
            .map(|i| {
                let yaw_rad = f64::from(i) * step_rad;
                let turned = Se2::new(guess.x_m, guess.y_m, guess.yaw_rad + yaw_rad);
                let (s, c) = turned.yaw_rad.sin_cos();
                let scale = 1.0 / grid.resolution_m;
                let offset = (turned.position() - grid.origin) * scale;
                let (s, c) = (s * scale, c * scale);
                let cell = |p: &Vec2| {
                    let x = c * p.x - s * p.y + offset.x;
                    let y = s * p.x + c * p.y + offset.y;
                    (x.floor() as i32, y.floor() as i32)
                };
                Turn {
                    yaw_rad,
                    cells: points.iter().map(cell).collect(),
                    penalty: PENALTY_RATIO * (yaw_rad / window.std_rad).powi(2),
                }
            })
            .collect();
        let half = ((window.half_m / grid.resolution_m).ceil() as i32).clamp(0, HALF_MAX);
        Self {
            grid,
            turns,
            half,
            penalty_per_cell2: PENALTY_RATIO * (grid.resolution_m / window.std_m).powi(2),
            score_scale: 1.0 / (255.0 * points.len() as f64),
            best: None,
            best_bound: score_min_ratio,
            n_scored: 0,
        }
    }

    fn run(&mut self) {
        let span = 2 * self.half + 1;
        // The coarsest level that still splits the window in about three along each axis.
        let mut level = 0;
        while level + 1 < self.grid.levels.len() && (3 << level) < span {
            level += 1;
        }
        let mut roots = Vec::new();
        for turn in 0..self.turns.len() {
            let mut y = -self.half;
            while y <= self.half {
                let mut x = -self.half;
                while x <= self.half {
                    let bound = self.bound(turn, x, y, level);
                    roots.push(Node { turn, x, y, bound });
                    x += 1 << level;
                }
                y += 1 << level;
            }
        }
        sort_by_bound(&mut roots);
        for node in roots {
            if node.bound <= self.best_bound {
                break;
            }
            self.descend(node, level);
        }
    }

    /// Depth first, the most promising quarter first.
    fn descend(&mut self, node: Node, level: usize) {
        if level == 0 {
            self.best_bound = node.bound;
            self.best = Some(node);
            return;
        }
        let half = 1 << (level - 1);
        let corners = [(0, 0), (half, 0), (0, half), (half, half)];
        let mut quarters = [node; 4];
        let mut n = 0;
        for (dx, dy) in corners {
            let (x, y) = (node.x + dx, node.y + dy);
            if x > self.half || y > self.half {
                continue;
            }
            let bound = self.bound(node.turn, x, y, level - 1);
            quarters[n] = Node { turn: node.turn, x, y, bound };
            n += 1;
        }
        sort_by_bound(&mut quarters[..n]);
        for quarter in &quarters[..n] {
            if quarter.bound <= self.best_bound {
                break;
            }
            self.descend(*quarter, level - 1);
        }
    }

    /// An upper bound of score less penalty in the square; exact at level 0.
    fn bound(&mut self, turn: usize, x: i32, y: i32, level: usize) -> f64 {
        self.n_scored += 1;
        let sum = self.grid.sum(level, &self.turns[turn].cells, x, y);
        let side = (1 << level) - 1;
        let nearest = |low: i32| f64::from(0.clamp(low, low + side));
        let d2 = nearest(x).powi(2) + nearest(y).powi(2);
        f64::from(sum) * self.score_scale - self.turns[turn].penalty - d2 * self.penalty_per_cell2
    }
}

/// The best first; equal ones keep the order of turns, rows and columns.
fn sort_by_bound(nodes: &mut [Node]) {
    nodes.sort_by(|a, b| b.bound.total_cmp(&a.bound));
}

/// Maxima over squares twice as wide: `out[x, y] = max(in[x, y], in[x + s, y], in[x, y + s], in[x + s, y + s])`.
fn pool(finer: &[u8], coarser: &mut Vec<u8>, width: usize, shift: usize) {
    coarser.clear();
    coarser.extend_from_slice(finer);
    for row in coarser.chunks_exact_mut(width) {
        // In place from the left: what is read has not been written yet.
        for x in 0..width.saturating_sub(shift) {
            row[x] = row[x].max(row[x + shift]);
        }
    }
    let down = shift * width;
    for start in (0..coarser.len().saturating_sub(down)).step_by(width) {
        let (upper, lower) = coarser.split_at_mut(start + down);
        for (a, b) in upper[start..start + width].iter_mut().zip(&lower[..width]) {
            *a = (*a).max(*b);
        }
    }
}

fn box_of(points: &[Vec2]) -> (Vec2, Vec2) {
    let zero = (Vec2::zeros(), Vec2::zeros());
    let Some(&first) = points.first() else { return zero };
    points.iter().fold((first, first), |(min, max), p| (min.inf(p), max.sup(p)))
}

/// The difference of two poses of one frame: metres between the places, radians between the yaws.
pub fn pose_distance(a: Se2, b: Se2) -> (f64, f64) {
    ((a.position() - b.position()).norm(), wrap_to_pi(a.yaw_rad - b.yaw_rad).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection::vec, prelude::*};

    /// Oracle: the likelihood at a place by its definition, without grid, levels or bounds.
    fn likelihood(map: &[Vec2], origin: Vec2, resolution_m: f64, std_m: f64, p: Vec2) -> u32 {
        let cell = |p: Vec2| ((p - origin) / resolution_m).map(f64::floor);
        let reach = (3.0 * std_m / resolution_m).ceil();
        map.iter()
            .map(|m| cell(*m) - cell(p))
            .filter(|d| d.x.abs() <= reach && d.y.abs() <= reach)
            .map(|d| {
                let d2 = d.norm_squared() * (resolution_m / std_m).powi(2);
                (255.0 * (-0.5 * d2).exp()).round() as u32
            })
            .max()
            .unwrap_or(0)
    }

    fn points(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec2>> {
        vec((-3.0..3.0, -3.0..3.0), n)
            .prop_map(|all| all.into_iter().map(|(x, y)| Vec2::new(x, y)).collect())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_grid_holds_the_definition(map in points(1..30), scan in points(1..20), yaw in -3.0..3.0) {
            let grid = ScoreGrid::of_points(&map, 0.1, 0.15, 3);
            let pose = Se2::new(0.3, -0.2, yaw);
            let sum: u32 = scan
                .iter()
                .map(|&p| likelihood(&map, grid.origin, 0.1, 0.15, pose.transform_point(p)))
                .sum();
            let expected = f64::from(sum) / (255.0 * scan.len() as f64);
            prop_assert!((grid.score_ratio(&scan, pose) - expected).abs() < 1e-12);
        }

        #[test]
        fn branch_and_bound_finds_what_trying_all_finds(
            map in points(5..30),
            scan in points(5..15),
            half_m in 0.0..0.9,
            levels in 1..7_usize,
            std_m in prop_oneof![Just(f64::INFINITY), 0.2..2.0],
        ) {
            let grid = ScoreGrid::of_points(&map, 0.1, 0.15, levels);
            let guess = Se2::new(0.1, -0.3, 0.4);
            let window = SearchWindow { half_m, half_rad: 0.15, std_m, std_rad: 0.1 };
            let step_rad = grid.turn_step_rad(&scan);
            let (turns, cells) =
                ((0.15 / step_rad).ceil() as i32, (half_m / 0.1_f64).ceil() as i32);
            let mut best = f64::NEG_INFINITY;
            for t in -turns..=turns {
                for y in -cells..=cells {
                    for x in -cells..=cells {
                        let shift = Vec2::new(f64::from(x), f64::from(y)) * 0.1;
                        let turned = Se2::new(guess.x_m, guess.y_m, guess.yaw_rad + f64::from(t) * step_rad);
                        // Shifts are whole cells, so the shifted point is asked for at the cell's centre.
                        let sum: u32 = scan.iter().map(|&p| {
                            let cell = ((turned.transform_point(p) - grid.origin) / 0.1).map(f64::floor);
                            let centre = grid.origin + cell.add_scalar(0.5) * 0.1;
                            likelihood(&map, grid.origin, 0.1, 0.15, centre + shift)
                        }).sum();
                        let penalty = 0.01 * ((shift.norm() / std_m).powi(2) + (f64::from(t) * step_rad / 0.1).powi(2));
                        best = best.max(f64::from(sum) / (255.0 * scan.len() as f64) - penalty);
                    }
                }
            }
            match grid.correlate(&scan, guess, &window, 0.2) {
                Some(found) => {
                    let (shift, turn) = pose_distance(found.pose, guess);
                    let penalty = 0.01 * ((shift / std_m).powi(2) + (turn / 0.1).powi(2));
                    prop_assert!((found.score_ratio - penalty - best).abs() < 1e-9);
                }
                None => prop_assert!(best <= 0.2 + 1e-12),
            }
        }
    }

    #[test]
    fn a_corridor_is_uncertain_along_itself() {
        let wall = |y: f64| (0..200).map(move |i| Vec2::new(f64::from(i) * 0.05 - 5.0, y));
        let map: Vec<Vec2> = wall(1.0).chain(wall(-1.0)).collect();
        let scan: Vec<Vec2> = map.iter().filter(|p| p.x.abs() < 2.0).copied().collect();
        let grid = ScoreGrid::of_points(&map, 0.05, 0.08, 1);
        let covariance = grid.covariance(&scan, Se2::IDENTITY, 4, 0.05);
        assert!(covariance[(0, 0)] > 20.0 * covariance[(1, 1)], "{covariance}");
        assert!(covariance.symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn nothing_to_match_is_no_match() {
        let window = SearchWindow { half_m: 1.0, half_rad: 0.3, std_m: 0.3, std_rad: 0.1 };
        let empty = ScoreGrid::of_points(&[], 0.05, 0.08, 4);
        assert_eq!(empty.correlate(&[Vec2::new(1.0, 0.0)], Se2::IDENTITY, &window, 0.1), None);
        let grid = ScoreGrid::of_points(&[Vec2::new(1.0, 0.0)], 0.05, 0.08, 4);
        assert_eq!(grid.correlate(&[], Se2::IDENTITY, &window, 0.1), None);
    }
}
