//! Laying a short-term map on the long-term one: many poses, one score, and how distinct the best is.

use geometry::{Se2, Vec2};
use grid_maps::{CellBox, Lattice, LogOddsMap, MapError, STEPS_PER_LOGODDS, Window};
use nalgebra::{Matrix3, Vector3};
use sensor_models::bayes::prob_from_logodds;

use crate::{
    classic::Score,
    config::{Distinctness, SearchLevel},
};

/// Log-odds beyond this count as this: one certain cell must not decide alone.
const EVIDENCE_MAX_LOGODDS: f32 = 3.0;

/// Variance of what was not measured: m² and rad².
const UNMEASURED_VAR: f64 = 100.0;

/// One pose that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Shift of the short-term map along x and y, metres.
    pub shift: Vec2,
    /// Turn of the short-term map about its pivot, radians.
    pub turn_rad: f64,
    /// Less is better; `None` without enough overlap.
    pub score_ratio: Option<f64>,
    /// Cells known in both maps, as far as [`Evidence`] keeps them.
    pub n_common: usize,
}

/// What a search found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SearchResult {
    /// All candidates, level by level, heading by heading, shift by shift.
    pub candidates: Vec<Candidate>,
    /// Cells of the short-term map that were laid down.
    pub n_cells: usize,
    /// Index of the best; the first of equals, and the middle pose of a level comes first.
    pub best: Option<usize>,
    /// The minimum between the candidates around the best: shift (m, m) and turn (rad).
    pub refined: Option<Vector3<f64>>,
    /// How steeply the scores rise around the minimum: second derivatives by shift (m) and turn (rad),
    /// 0 in a direction in which they do not rise. `None` at the border of what was tried.
    pub curvature: Option<Vector3<f64>>,
}

/// A short-term map as points with evidence, about a pivot.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    points: Vec<(Vec2, f32)>,
    radius_m: f64,
}

impl Evidence {
    /// The known cells of `map` with at least 0.1 of evidence, about `pivot` (m). Of those that are
    /// probably free, which are many and say little each, one in four, along diagonals.
    pub fn of(map: &LogOddsMap, pivot: Vec2) -> Self {
        let lattice = map.lattice();
        let mut evidence = Self::default();
        for (cell, step) in map.grid().known() {
            let logodds = f64::from(step) / STEPS_PER_LOGODDS;
            let is_kept = (2 * cell.row + cell.column).rem_euclid(4) == 0;
            if logodds >= 0.1 || (logodds <= -0.1 && is_kept) {
                let point = lattice.centre_of(cell) - pivot;
                evidence.radius_m = evidence.radius_m.max(point.norm());
                evidence.points.push((point, logodds as f32));
            }
        }
        evidence
    }

    /// How many cells it keeps.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// Tries the poses of `levels` for `evidence` about `pivot` on `map`.
///
/// O(headings × points × shifts).
///
/// # Errors
///
/// [`MapError::TooLarge`] when the evidence spreads over more cells than a window may have.
pub fn search(
    map: &LogOddsMap,
    evidence: &Evidence,
    pivot: Vec2,
    levels: &[SearchLevel],
    score: Score,
) -> Result<SearchResult, MapError> {
    let mut result = SearchResult { n_cells: evidence.len(), ..SearchResult::default() };
    if evidence.is_empty() || levels.is_empty() {
        return Ok(result);
    }
    let resolution_m = map.lattice().resolution_m;
    let reach: f64 = levels.iter().map(|l| l.n_shifts as f64 * l.shift_step_cells + 1.0).sum();
    let margin_m = evidence.radius_m + (reach + 2.0) * resolution_m;
    let low = map.lattice().cell_of(pivot - Vec2::repeat(margin_m));
    let high = map.lattice().cell_of(pivot + Vec2::repeat(margin_m));
    let side = |low: i32, high: i32| (high - low + 1).max(1) as usize;
    let (width, height) = (side(low.column, high.column), side(low.row, high.row));
    let mut window = map.logodds_window(CellBox { min: low, width, height })?;
    if matches!(score, Score::Evidence { .. }) {
        for logodds in window.values_mut() {
            *logodds = bounded(*logodds);
        }
    }
    let lattice = *map.lattice();
    let mut table = Table { window, lattice, cells: Vec::with_capacity(evidence.len()) };

    let mut centre = (Vec2::zeros(), 0.0);
    for level in levels {
        let begin = result.candidates.len();
        let task = Task { map, evidence, pivot, score };
        table.try_level(&task, level, centre, &mut result.candidates);
        let found = &result.candidates[begin..];
        result.best = best_of(found).map(|i| begin + i);
        let Some(best) = result.best else { break };
        let Candidate { shift, turn_rad, .. } = result.candidates[best];
        (result.refined, result.curvature) = (None, None);
        let bowl = Bowl::around(found, best - begin, level, resolution_m);
        let finer = bowl.as_ref().and_then(|_| {
            let steps = Vector3::new(resolution_m, resolution_m, level.heading_step_rad);
            table.bowl_between(evidence, pivot, (shift, turn_rad), steps, score)
        });
        if let Some(bowl) = finer.or(bowl) {
            result.refined = Some(bowl.minimum + Vector3::new(shift.x, shift.y, turn_rad));
            result.curvature = Some(bowl.curvature);
        }
        centre = (shift, turn_rad);
    }
    Ok(result)
}

impl SearchResult {
    /// The measured correction with its covariance, if there is a minimum inside what was tried. Where
    /// the scores do not rise the variance is that of anything.
    pub fn measured(&self, distinct: &Distinctness) -> Option<(Vector3<f64>, Matrix3<f64>)> {
        let best = self.candidates[self.best?];
        let score = best.score_ratio?;
        let curvature = self.curvature?;
        let overlap_ratio = best.n_common as f64 / self.n_cells as f64;
        if score > distinct.score_max_ratio
            || overlap_ratio < distinct.overlap_min_ratio
            || curvature.amax() <= 0.0
        {
            return None;
        }
        // A rise of `rise_min_ratio` a unit away has that unit as deviation; where the scores do not
        // rise, as along a corridor, nothing is measured.
        let var = curvature.map(|second| {
            let var = 2.0 * distinct.rise_min_ratio / second.max(1e-12);
            var.min(UNMEASURED_VAR)
        });
        let floor = Vector3::new(
            distinct.shift_std_m.powi(2),
            distinct.shift_std_m.powi(2),
            distinct.heading_std_rad.powi(2),
        );
        let covariance = Matrix3::from_diagonal(&(var + floor));
        Some((self.refined?, covariance))
    }
}

fn best_of(candidates: &[Candidate]) -> Option<usize> {
    let scored = (0..).zip(candidates).filter_map(|(i, c)| c.score_ratio.map(|s| (i, s)));
    scored.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(i, _)| i)
}

/// What is laid on what.
struct Task<'a> {
    map: &'a LogOddsMap,
    evidence: &'a Evidence,
    pivot: Vec2,
    score: Score,
}

struct Table {
    window: Window<f32>,
    lattice: Lattice,
    /// Place in the window's values for each point of the evidence, and its evidence.
    cells: Vec<(i32, f32)>,
}

impl Table {
    fn try_level(
        &mut self,
        task: &Task<'_>,
        level: &SearchLevel,
        centre: (Vec2, f64),
        candidates: &mut Vec<Candidate>,
    ) {
        let Task { map, evidence, pivot, score } = *task;
        let resolution_m = map.lattice().resolution_m;
        let width = self.window.area().width as i32;
        let min = self.window.area().min;
        for turn in outwards(level.n_headings) {
            let turn_rad = centre.1 + f64::from(turn) * level.heading_step_rad;
            let at = Se2::new(pivot.x + centre.0.x, pivot.y + centre.0.y, turn_rad);
            self.cells.clear();
            for &(point, logodds) in &evidence.points {
                let cell = map.lattice().cell_of(at.transform_point(point));
                let place = (cell.row - min.row) * width + cell.column - min.column;
                let is_evidence = matches!(score, Score::Evidence { .. });
                self.cells.push((place, if is_evidence { bounded(logodds) } else { logodds }));
            }
            for dy in outwards(level.n_shifts) {
                for dx in outwards(level.n_shifts) {
                    let cells = |n: i32| (f64::from(n) * level.shift_step_cells).round() as i32;
                    let offset = cells(dy) * width + cells(dx);
                    let (score_ratio, n_common) = self.score(score, offset);
                    let shift = Vec2::new(f64::from(cells(dx)), f64::from(cells(dy)));
                    let shift = centre.0 + shift * resolution_m;
                    candidates.push(Candidate { shift, turn_rad, score_ratio, n_common });
                }
            }
        }
    }

    fn score(&self, score: Score, offset: i32) -> (Option<f64>, usize) {
        match score {
            Score::Evidence { n_cells_min } => self.correlation(offset, n_cells_min),
            Score::CommonCells { n_cells_min } => {
                let (sum, _, n) = self.differences(offset);
                let enough = n >= n_cells_min.max(1);
                (enough.then(|| sum / n as f64), n)
            }
            Score::WholeWindow => {
                let (_, sum, n) = self.differences(offset);
                (Some(if n == 0 { 0.0 } else { sum }), n)
            }
        }
    }

    /// One minus the correlation of evidence, bounded on both sides already, over the cells known in
    /// both.
    fn correlation(&self, offset: i32, n_cells_min: usize) -> (Option<f64>, usize) {
        let values = self.window.values();
        let (mut product, mut ours, mut theirs, mut n) = (0.0_f32, 0.0_f32, 0.0_f32, 0_u32);
        for &(place, a) in &self.cells {
            let b = values.get((place + offset) as usize).copied().unwrap_or(f32::NAN);
            if b.is_nan() {
                continue;
            }
            product += a * b;
            ours += a * a;
            theirs += b * b;
            n += 1;
        }
        let norm = (ours * theirs).sqrt();
        let enough = n as usize >= n_cells_min.max(1) && norm > 0.0;
        (enough.then(|| 1.0 - f64::from(product / norm)), n as usize)
    }

    /// The bowl of evidence around a pose, by values between the cells: candidates fall on whole
    /// cells, so that their scores know nothing finer. `None` for the source's scores.
    fn bowl_between(
        &self,
        evidence: &Evidence,
        pivot: Vec2,
        (shift, turn_rad): (Vec2, f64),
        steps: Vector3<f64>,
        score: Score,
    ) -> Option<Bowl> {
        let Score::Evidence { n_cells_min } = score else { return None };
        let at = |by: Vector3<f64>| {
            let place = pivot + shift + by.xy();
            let at = Se2::new(place.x, place.y, turn_rad + by.z);
            self.correlation_between(evidence, at, n_cells_min)
        };
        Bowl::of(at(Vector3::zeros())?, steps, |axis, sign| {
            let mut by = Vector3::zeros();
            by[axis] = sign * steps[axis];
            at(by)
        })
    }

    /// As [`Self::correlation`], with the map interpolated between the centres of four cells; points
    /// of which one is unknown do not count.
    fn correlation_between(&self, evidence: &Evidence, at: Se2, n_min: usize) -> Option<f64> {
        let (values, area) = (self.window.values(), self.window.area());
        let (sin, cos) = at.yaw_rad.sin_cos();
        let origin = at.position() - self.lattice.origin;
        let (mut product, mut ours, mut theirs, mut n) = (0.0_f32, 0.0_f32, 0.0_f32, 0_usize);
        for &(p, logodds) in &evidence.points {
            let x = (origin.x + cos * p.x - sin * p.y) / self.lattice.resolution_m - 0.5;
            let y = (origin.y + sin * p.x + cos * p.y) / self.lattice.resolution_m - 0.5;
            let (column, row) = (x.floor(), y.floor());
            let (u, v) = ((x - column) as f32, (y - row) as f32);
            let (dc, dr) = (column as i32 - area.min.column, row as i32 - area.min.row);
            if dc < 0 || dr < 0 || dc as usize + 1 >= area.width || dr as usize + 1 >= area.height {
                continue;
            }
            let i = dr as usize * area.width + dc as usize;
            let below = values[i] * (1.0 - u) + values[i + 1] * u;
            let above = values[i + area.width] * (1.0 - u) + values[i + area.width + 1] * u;
            let b = below * (1.0 - v) + above * v;
            if b.is_nan() {
                continue;
            }
            let a = bounded(logodds);
            product += a * b;
            ours += a * a;
            theirs += b * b;
            n += 1;
        }
        let norm = (ours * theirs).sqrt();
        (n >= n_min.max(1) && norm > 0.0).then(|| 1.0 - f64::from(product / norm))
    }

    /// Sum of differences of probabilities over the cells known in both; over all; how many both.
    fn differences(&self, offset: i32) -> (f64, f64, usize) {
        let values = self.window.values();
        let (mut common, mut all, mut n) = (0.0, 0.0, 0);
        for &(place, a) in &self.cells {
            let b = values.get((place + offset) as usize).copied().unwrap_or(f32::NAN);
            let ours = prob_from_logodds(f64::from(a));
            if b.is_nan() {
                all += (ours - 0.5).abs();
            } else {
                let difference = (ours - prob_from_logodds(f64::from(b))).abs();
                common += difference;
                all += difference;
                n += 1;
            }
        }
        (common, all, n)
    }
}

/// NaN, unknown, stays NaN.
fn bounded(logodds: f32) -> f32 {
    logodds.clamp(-EVIDENCE_MAX_LOGODDS, EVIDENCE_MAX_LOGODDS)
}

/// 0, 1, −1, 2, −2 …: the middle first, so that it wins among equals.
fn outwards(n: usize) -> impl Iterator<Item = i32> {
    let n = n as i32;
    std::iter::once(0).chain((1..=n).flat_map(|i| [i, -i]))
}

/// The scores around the best candidate as a bowl: where its bottom is, and how steep it is.
struct Bowl {
    minimum: Vector3<f64>,
    /// Second derivatives by shift (m) and turn (rad).
    curvature: Vector3<f64>,
}

impl Bowl {
    /// From the six neighbours at one step; `None` at the border of a level, where the minimum may be
    /// anywhere beyond.
    fn around(
        found: &[Candidate],
        best: usize,
        level: &SearchLevel,
        resolution_m: f64,
    ) -> Option<Self> {
        let shift_m = (level.shift_step_cells.round()).max(1.0) * resolution_m;
        let steps = Vector3::new(shift_m, shift_m, level.heading_step_rad);
        let at = |axis: usize, sign: f64| -> Option<f64> {
            let c = found[best];
            let mut place = Vector3::new(c.shift.x, c.shift.y, c.turn_rad);
            place[axis] += sign * steps[axis];
            let near = |o: &&Candidate| {
                let other = Vector3::new(o.shift.x, o.shift.y, o.turn_rad);
                (other - place).component_div(&steps).amax() < 0.1
            };
            found.iter().find(near)?.score_ratio
        };
        Self::of(found[best].score_ratio?, steps, at)
    }

    /// From the score in the middle and those one step to both sides along each axis.
    fn of(
        middle: f64,
        steps: Vector3<f64>,
        at: impl Fn(usize, f64) -> Option<f64>,
    ) -> Option<Self> {
        let (mut minimum, mut curvature) = (Vector3::zeros(), Vector3::zeros());
        for axis in 0..3 {
            let (below, above) = (at(axis, -1.0)?, at(axis, 1.0)?);
            let second = below + above - 2.0 * middle;
            if second <= 1e-9 {
                continue;
            }
            let offset = (0.5 * (below - above) / second).clamp(-1.0, 1.0);
            minimum[axis] = offset * steps[axis];
            curvature[axis] = second / steps[axis].powi(2);
        }
        Some(Self { minimum, curvature })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid_maps::{Cell, EvidenceModel};

    /// A corner of two walls with free space inside, moved by a pose.
    fn corner(at: Se2) -> LogOddsMap {
        let lattice = Lattice { origin: Vec2::zeros(), resolution_m: 0.035 };
        let mut map = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        let area = -60..60;
        for row in area.clone() {
            for column in area.clone() {
                let cell = Cell { column, row };
                let p = at.inverse().transform_point(lattice.centre_of(cell));
                let inside = p.x.min(p.y);
                if p.x.max(p.y) < 1.4 && inside > -0.05 {
                    let wall = 1.5 - 3.0 * (inside - 0.02).abs() / 0.06;
                    map.set(cell, Some(wall.max(-0.8)));
                }
            }
        }
        map
    }

    const EVIDENCE: Score = Score::Evidence { n_cells_min: 100 };

    fn found(map: &LogOddsMap, short: &LogOddsMap, score: Score) -> SearchResult {
        let pivot = Vec2::new(0.3, 0.3);
        let levels = [SearchLevel::source(3)];
        search(map, &Evidence::of(short, pivot), pivot, &levels, score).unwrap()
    }

    #[test]
    fn a_shifted_and_turned_map_is_found_by_both_scores_that_can() {
        let map = corner(Se2::IDENTITY);
        let off = Se2::new(0.035, -0.035, 2.0_f64.to_radians());
        // Turned about the pivot, then shifted: what the search has to undo.
        let pivot = Se2::new(0.3, 0.3, 0.0);
        let about = |m: Se2| {
            let turned = Se2::new(0.0, 0.0, m.yaw_rad);
            let shift = Se2::new(m.x_m, m.y_m, 0.0);
            shift.compose(pivot).compose(turned).compose(pivot.inverse())
        };
        let short = corner(about(off));
        for score in [EVIDENCE, Score::CommonCells { n_cells_min: 100 }] {
            let result = found(&map, &short, score);
            assert_eq!(result.candidates.len(), 63);
            let best = result.candidates[result.best.unwrap()];
            assert!((best.shift - Vec2::new(-0.035, 0.035)).norm() < 1e-9, "{score:?} {best:?}");
            assert!((best.turn_rad + 2.0_f64.to_radians()).abs() < 1e-9, "{score:?} {best:?}");
        }
    }

    /// Between cells: the minimum of the bowl is nearer to the truth than the best candidate, on the
    /// right side of it and not beyond.
    #[test]
    fn the_minimum_is_refined_below_a_cell() {
        let map = corner(Se2::IDENTITY);
        let short = corner(Se2::new(0.012, 0.010, 0.0));
        let result = found(&map, &short, EVIDENCE);
        let refined = result.refined.unwrap();
        assert!((-0.012..-0.001).contains(&refined[0]), "{refined}");
        assert!((-0.010..-0.001).contains(&refined[1]), "{refined}");
        assert!(result.measured(&Distinctness::default()).is_some());
        let strict = Distinctness { score_max_ratio: 0.0, ..Distinctness::default() };
        assert!(result.measured(&strict).is_none(), "too bad a fit is no measurement");
        let wide = Distinctness { overlap_min_ratio: 1.01, ..Distinctness::default() };
        assert!(result.measured(&wide).is_none(), "too little overlap is no measurement");
    }

    /// One straight wall: the scores do not rise along it.
    #[test]
    fn along_a_wall_only_the_way_across_is_measured() {
        let lattice = Lattice { origin: Vec2::zeros(), resolution_m: 0.035 };
        let mut map = LogOddsMap::new(lattice, EvidenceModel::default()).unwrap();
        for column in -80..80 {
            for row in -20..4 {
                let logodds = if row < 0 { -0.8 } else { 1.5 };
                map.set(Cell { column, row }, Some(logodds));
            }
        }
        let mut short = map.clone();
        short.clear();
        for column in -20..20 {
            for row in -10..2 {
                let cell = Cell { column, row };
                short.set(cell, map.logodds(cell));
            }
        }
        let pivot = Vec2::zeros();
        let levels = [SearchLevel::source(3)];
        let evidence = Evidence::of(&short, pivot);
        let result = search(&map, &evidence, pivot, &levels, EVIDENCE).unwrap();
        let best = result.candidates[result.best.unwrap()];
        assert!(best.shift.norm() < 1e-12, "the middle is first among equals: {best:?}");
        let (_, covariance) = result.measured(&Distinctness::default()).unwrap();
        assert!(covariance[(0, 0)] > 10.0, "along the wall anything is possible: {covariance}");
        assert!(covariance[(1, 1)] < 0.01, "across it is certain: {covariance}");
    }

    /// The best at the border of what was tried: the minimum may be anywhere beyond.
    #[test]
    fn a_minimum_at_the_border_is_no_measurement() {
        let map = corner(Se2::IDENTITY);
        let result = found(&map, &corner(Se2::new(0.2, 0.0, 0.0)), EVIDENCE);
        let best = result.candidates[result.best.unwrap()];
        assert!((best.shift.x + 0.035).abs() < 1e-9, "{best:?}");
        assert!(result.measured(&Distinctness::default()).is_none());
    }

    #[test]
    fn without_overlap_there_is_no_best_pose() {
        let map = corner(Se2::IDENTITY);
        let far = corner(Se2::new(0.0, 0.0, 0.0));
        let nowhere = Vec2::new(50.0, 50.0);
        let evidence = Evidence::of(&far, Vec2::zeros());
        let levels = [SearchLevel::source(1)];
        let result = search(&map, &evidence, nowhere, &levels, EVIDENCE).unwrap();
        assert_eq!((result.candidates.len(), result.best), (27, None));
        // The programmed score likes it: nothing in common is a perfect fit.
        let result = search(&map, &evidence, nowhere, &levels, Score::WholeWindow).unwrap();
        assert_eq!(result.candidates[result.best.unwrap()].score_ratio, Some(0.0));
        let empty = Evidence::default();
        assert!(search(&map, &empty, nowhere, &levels, EVIDENCE).unwrap().candidates.is_empty());
    }

    #[test]
    fn a_finer_level_searches_around_the_best_of_the_coarser() {
        let map = corner(Se2::IDENTITY);
        let short = corner(Se2::new(0.14, 0.0, 0.0));
        let coarse = SearchLevel { n_shifts: 2, shift_step_cells: 2.0, ..SearchLevel::source(0) };
        let fine = SearchLevel::source(1);
        let pivot = Vec2::new(0.3, 0.3);
        let evidence = Evidence::of(&short, pivot);
        let result = search(&map, &evidence, pivot, &[coarse, fine], EVIDENCE).unwrap();
        assert_eq!(result.candidates.len(), 25 + 27);
        let best = result.candidates[result.best.unwrap()];
        assert!(result.best.unwrap() >= 25 && (best.shift.x + 0.14).abs() < 1e-9, "{best:?}");
    }
}
