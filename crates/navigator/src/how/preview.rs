//! The way ahead, point by point: as the scout found it, as it was given, or as it is supposed to go on.

use geometry::{Se2, Vec2, wrap_to_pi};

use crate::values::Way;

/// Between two points of the preview, metres.
pub(crate) const PREVIEW_STEP_M: f64 = 0.12;

/// Points for which there is always room.
const N_POINTS: usize = 1024;

/// Turning of the preview within its next [`BEND_POINTS`] from which it is a corner, radians: 20° in
/// 0.6 m, a radius of 1.7 m. The one place where bends are slowed for.
const BEND_RAD: f64 = 0.35;

/// Points of the preview that a bend is looked for in: 0.6 m.
const BEND_POINTS: usize = 5;

/// How far ahead on the preview the robot looks for its direction, points.
const DIRECTION_POINTS: usize = 4;

/// Points, whether the antennas smell more than one trail there, and where the robot is among them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Preview {
    points: Vec<Vec2>,
    /// May be shorter.
    is_mixed: Vec<bool>,
    index: usize,
}

impl Preview {
    /// The same with room for [`N_POINTS`], which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.points = Vec::with_capacity(N_POINTS);
        self.is_mixed = Vec::with_capacity(N_POINTS);
        self
    }

    pub(crate) fn reserve(&mut self, n_points: usize) {
        self.points.reserve(n_points);
    }

    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.is_mixed.clear();
        self.index = 0;
    }

    /// Replaces the points; where the robot is among them stays.
    pub(crate) fn lay(&mut self, points: impl Iterator<Item = Vec2>) {
        self.points.clear();
        self.is_mixed.clear();
        self.points.extend(points);
    }

    /// Has them written by another, and begins at the first.
    pub(crate) fn write(&mut self, write: impl FnOnce(&mut Vec<Vec2>, &mut Vec<bool>)) {
        write(&mut self.points, &mut self.is_mixed);
        self.index = 0;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub(crate) fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// The points from the robot's on.
    pub(crate) fn ahead(&self) -> &[Vec2] {
        self.points.get(self.index..).unwrap_or(&[])
    }

    /// Length ahead of the robot, metres.
    pub(crate) fn ahead_m(&self) -> f64 {
        PREVIEW_STEP_M * self.ahead().len().saturating_sub(1) as f64
    }

    /// The point `n_points` after the robot's, or before it; the last, or the first, where there is none.
    pub(crate) fn point(&self, n_points: isize) -> Option<Vec2> {
        let last = self.points.len().checked_sub(1)?;
        self.points.get(self.index.saturating_add_signed(n_points).min(last)).copied()
    }

    /// Whether the antennas smell more than one trail where the robot is.
    pub(crate) fn is_mixed_here(&self) -> bool {
        self.is_mixed.get(self.index).is_some_and(|mixed| *mixed)
    }

    /// Goes to the point nearest to the robot, looking at `n_ahead` points: a
    /// way may pass the same place twice. Whether that is further on.
    pub(crate) fn advance(&mut self, position: Vec2, n_ahead: usize) -> bool {
        let candidates = self.points.iter().enumerate().skip(self.index).take(n_ahead);
        let nearest = candidates.min_by(|(_, a), (_, b)| {
            (*a - position).norm_squared().total_cmp(&(*b - position).norm_squared())
        });
        let further = nearest.map(|(index, _)| index).filter(|index| *index > self.index);
        self.index = further.unwrap_or(self.index);
        further.is_some()
    }

    /// Goes to that point; whether it is further on.
    pub(crate) fn go_to(&mut self, index: usize) -> bool {
        let is_further = index > self.index;
        self.index = index.min(self.points.len().saturating_sub(1));
        is_further
    }

    /// Direction from the robot to the way a little ahead (rad, map); `None` without one.
    pub(crate) fn heading_rad(&self, position: Vec2) -> Option<f64> {
        let way = self.point(DIRECTION_POINTS as isize)? - position;
        (way.norm() > 0.15).then(|| way.y.atan2(way.x))
    }

    /// Way to the first bend, metres.
    pub(crate) fn first_bend_m(&self) -> Option<f64> {
        let ahead = self.points.get(self.index..)?;
        let direction = |way: Vec2| way.y.atan2(way.x);
        let bends = |points: &[Vec2]| {
            let (into, out) =
                (points[2] - points[0], points[BEND_POINTS] - points[BEND_POINTS - 2]);
            wrap_to_pi(direction(out) - direction(into)).abs() > BEND_RAD
        };
        ahead.windows(BEND_POINTS + 1).position(bends).map(|k| PREVIEW_STEP_M * k as f64)
    }

    /// The way that a robot at `pose` is about to take, as far as is looked at; straight on beyond the last point.
    pub(crate) fn way(&self, pose: Se2, look_m: f64) -> Way {
        let mut way = Way::begin(pose.position());
        let mut length_m = 0.0;
        let mut last = pose.position();
        let mut direction = pose.heading();
        // The nearest point may lie a little behind; the next one does not.
        for point in self.points.iter().skip(self.index + 2) {
            let step = point - last;
            if step.norm() < 1e-6 {
                continue;
            }
            if !way.push(*point) {
                return way;
            }
            length_m += step.norm();
            direction = step / step.norm();
            last = *point;
            if length_m > look_m {
                return way;
            }
        }
        way.push(last + direction * (look_m - length_m));
        way
    }
}
