//! Whether a robot has truly driven the path it was sent along: what the judge knows of it.
//!
//! Standing at the goal is not enough where a path leads past its goal or ends where it begins. Marks along
//! the path must be passed in their order, and no mark counts before most of the way to it has been
//! driven. Obstacles may be driven around: marks may be left out if a later one soon follows.

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::Path;

/// A mark counts as passed within this distance, metres: wider than a box that is driven around.
const PASSED_WITHIN_M: f64 = 1.0;
/// Distance between marks on straight pieces, metres.
const MARK_EVERY_M: f64 = 2.0;
/// A corner of so much is a mark, radians.
const CORNER_RAD: f64 = 0.5;
/// So far ahead a mark may be passed before those in between, metres.
const AHEAD_MAX_M: f64 = 5.0;
/// Part of the way to a mark that must have been driven; the rest is corners that were cut.
const DRIVEN_RATIO: f64 = 0.75;
/// A goal that the path passes so much nearer elsewhere is not meant there; a start neither. Metres.
const SLACK_M: f64 = 0.3;

/// Follows one robot along its path, from the truth.
#[derive(Clone, Debug)]
pub(super) struct Sides {
    path: Path,
    /// Where all marks lie along the path, metres.
    marks_m: Vec<f64>,
    /// A path whose end is this near to the goal leads to it with its end, metres.
    end_reach_m: f64,
    from_m: f64,
    goal_m: f64,
    passed_m: f64,
    driven_m: f64,
}

impl Sides {
    pub(super) fn new(path: &Path, end_reach_m: f64) -> Self {
        let goal_m = path.length_m();
        let marks_m = marks(path);
        let path = path.clone();
        Self { path, marks_m, end_reach_m, from_m: 0.0, goal_m, passed_m: 0.0, driven_m: 0.0 }
    }

    /// A goal was given to the robot at `at`.
    pub(super) fn begin(&mut self, at: Vec2, goal: Vec2) {
        self.goal_m = self.path.reaches_m(goal, self.end_reach_m, SLACK_M);
        self.from_m = self.path.first_near_m(at, 0.0, self.goal_m, SLACK_M);
        self.passed_m = self.from_m;
        self.driven_m = 0.0;
    }

    /// The robot is at `at` now, `driven_m` further than before.
    pub(super) fn step(&mut self, at: Vec2, driven_m: f64) {
        self.driven_m += driven_m;
        let first = self.marks_m.partition_point(|&mark_m| mark_m <= self.passed_m);
        let end_m = (self.passed_m + AHEAD_MAX_M).min(self.goal_m);
        for &mark_m in self.marks_m[first..].iter().take_while(|&&mark_m| mark_m <= end_m) {
            let is_driven = self.driven_m >= DRIVEN_RATIO * (mark_m - self.from_m);
            if is_driven && (self.path.point_at(mark_m) - at).norm() <= PASSED_WITHIN_M {
                self.passed_m = mark_m;
            }
        }
    }

    /// Whether the path to the goal was driven: every mark passed, and most of the way.
    pub(super) fn is_driven(&self) -> bool {
        let last = self.marks_m.partition_point(|&mark_m| mark_m <= self.goal_m);
        let last_m = last.checked_sub(1).map_or(0.0, |last| self.marks_m[last]);
        let is_passed = self.passed_m >= last_m.min(self.goal_m) || last_m <= self.from_m;
        is_passed && self.driven_m >= DRIVEN_RATIO * self.way_m() - SLACK_M
    }

    /// Length of the path from where it was taken up to the goal, metres.
    pub(super) fn way_m(&self) -> f64 {
        self.goal_m - self.from_m
    }

    /// How far the robot has come along it, metres.
    pub(super) fn passed_m(&self) -> f64 {
        self.passed_m - self.from_m
    }
}

/// Corners, and points on what lies between them.
fn marks(path: &Path) -> Vec<f64> {
    let mut marks_m = Vec::new();
    let (mut along_m, mut last_m) = (0.0, 0.0);
    let mut heading_rad = path.start().yaw_rad;
    for piece in path.pieces() {
        let begin: Se2 = piece.pose_at(0.0);
        let is_corner = wrap_to_pi(begin.yaw_rad - heading_rad).abs() >= CORNER_RAD;
        if along_m > 0.0 && (is_corner || along_m - last_m >= MARK_EVERY_M) {
            marks_m.push(along_m);
            last_m = along_m;
        }
        let length_m = piece.length_m();
        let n_between = (length_m / MARK_EVERY_M).ceil().min(10_000.0) as u32;
        for k in 1..n_between {
            last_m = along_m + length_m * f64::from(k) / f64::from(n_between);
            marks_m.push(last_m);
        }
        heading_rad = piece.pose_at(length_m).yaw_rad;
        along_m += length_m;
    }
    marks_m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(points: &[(f64, f64)]) -> Sides {
        let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        Sides::new(&Path::polyline(&points).unwrap(), 0.7)
    }

    /// Drives straight from point to point in steps of 1 cm.
    fn drive(sides: &mut Sides, points: &[(f64, f64)]) {
        for pair in points.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|(x, y)| Vec2::new(x, y));
            let n = ((b - a).norm() / 0.01).ceil() as u32;
            for k in 1..=n {
                let at = a + (b - a) * (f64::from(k) / f64::from(n));
                sides.step(at, (b - a).norm() / f64::from(n));
            }
        }
    }

    const SQUARE: [(f64, f64); 5] = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0), (0.0, 0.0)];

    #[test]
    fn a_square_is_driven_when_all_its_sides_are() {
        let mut square = sides(&SQUARE);
        square.begin(Vec2::new(0.1, -0.1), Vec2::zeros());
        assert!(!square.is_driven());
        for last in 2..5 {
            let mut part = square.clone();
            drive(&mut part, &SQUARE[..last]);
            assert!(!part.is_driven(), "after {} sides", last - 1);
        }
        drive(&mut square, &SQUARE);
        assert!(square.is_driven());
        // The same way backwards is another one.
        let mut backwards = sides(&SQUARE);
        backwards.begin(Vec2::zeros(), Vec2::zeros());
        let turned: Vec<(f64, f64)> = SQUARE.into_iter().rev().collect();
        drive(&mut backwards, &turned);
        assert!(!backwards.is_driven());
    }

    #[test]
    fn small_loops_and_ways_back_count_too() {
        let small = SQUARE.map(|(x, y)| (0.1 * x, 0.1 * y));
        for path in [&small[..], &[(0.0, 0.0), (2.0, 0.0), (0.0, 0.0)]] {
            let mut sides = sides(path);
            sides.begin(Vec2::zeros(), Vec2::zeros());
            assert!(!sides.is_driven(), "{path:?}");
            drive(&mut sides, path);
            assert!(sides.is_driven(), "{path:?}");
        }
    }

    #[test]
    fn a_box_in_a_corner_may_be_driven_around() {
        let mut square = sides(&SQUARE);
        square.begin(Vec2::zeros(), Vec2::zeros());
        let around =
            [(0.0, 0.0), (1.4, 0.0), (2.2, 1.0), (3.0, 1.6), (3.0, 3.0), (0.0, 3.0), (0.0, 0.0)];
        drive(&mut square, &around);
        assert!(square.is_driven(), "{square:?}");
    }

    #[test]
    fn a_goal_in_the_middle_of_a_path_needs_the_path_up_to_there() {
        let mut line = sides(&[(0.0, 0.0), (6.0, 0.0)]);
        line.begin(Vec2::zeros(), Vec2::new(3.0, 0.0));
        assert!((line.way_m() - 3.0).abs() < 0.01);
        assert!(!line.is_driven());
        drive(&mut line, &[(0.0, 0.0), (3.0, 0.0)]);
        assert!(line.is_driven());
    }
}
