//! Explicit paths: polylines and arcs, with the error of a robot against them.

use std::f64::consts::FRAC_PI_2;

use geometry::{Arc, Se2, Segment, Vec2, wrap_to_pi};

/// Pieces must meet within this distance, metres: far above rounding, far below what a robot notices.
const GAP_MAX_M: f64 = 1e-6;

/// Points nearer than this (m) are one point.
const POINTS_MERGE_M: f64 = 1e-9;

/// One piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// From `a` to `b`.
    Line(Segment),
    /// A piece of a circle.
    Arc(Arc),
}

/// A path to follow, from its start to its end, in one frame. Never empty, never of length zero.
///
/// ```
/// use geometry::Vec2;
/// use path_following::Path;
///
/// let path = Path::polyline(&[Vec2::new(0.0, 0.0), Vec2::new(4.0, 0.0), Vec2::new(4.0, 3.0)]).unwrap();
/// let seen = path.project(Vec2::new(1.0, 0.2));
/// assert_eq!((path.length_m(), seen.arc_length_m, seen.cross_track_m), (7.0, 1.0, 0.2));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    pieces: Vec<Piece>,
    /// Where each piece begins, and the whole ends: one more than there are pieces, metres along.
    bounds_m: Vec<f64>,
}

/// Where a point stands against a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Of the nearest point of the path from its start, along it, metres.
    pub arc_length_m: f64,
    /// From the path, metres, left positive: minus the error e of (5.30). Before the start and beyond the
    /// end it is the distance from the tangent there.
    pub cross_track_m: f64,
    /// Direction of the path there, radians.
    pub heading_rad: f64,
    /// The nearest point (m).
    pub point: Vec2,
}

/// What cannot be a path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// Fewer than two different points.
    #[error("a path needs two different points; {n_points} given, all the same")]
    TooShort {
        /// Points given.
        n_points: usize,
    },
    /// A coordinate or size that is not finite, or a radius that is not positive.
    #[error("piece or point {index} of the path is not finite or has no positive size")]
    NotFinite {
        /// From 0.
        index: usize,
    },
    /// Pieces that do not meet.
    #[error(
        "piece {index} of the path begins {gap_m} m from the end of the one before it; they must meet"
    )]
    Gap {
        /// The second of the two, from 0.
        index: usize,
        /// Between them, metres.
        gap_m: f64,
    },
}

impl Path {
    /// Straight lines from point to point (m). Repeated points are one point.
    ///
    /// # Errors
    ///
    /// [`PathError::TooShort`] and [`PathError::NotFinite`].
    pub fn polyline(points: &[Vec2]) -> Result<Self, PathError> {
        if let Some(index) = points.iter().position(|p| !(p.x.is_finite() && p.y.is_finite())) {
            return Err(PathError::NotFinite { index });
        }
        let mut lines = Vec::with_capacity(points.len());
        let mut points_left = points.iter();
        let mut a = *points_left.next().ok_or(PathError::TooShort { n_points: 0 })?;
        for &b in points_left {
            if (b - a).norm() > POINTS_MERGE_M {
                lines.push(Piece::Line(Segment { a, b }));
                a = b;
            }
        }
        if lines.is_empty() {
            return Err(PathError::TooShort { n_points: points.len() });
        }
        Ok(Self::from_checked(lines))
    }

    /// Lines and arcs, each beginning where the one before it ends. Directions may jump.
    ///
    /// # Errors
    ///
    /// [`PathError`]; the first offending piece is named.
    pub fn new(pieces: Vec<Piece>) -> Result<Self, PathError> {
        if pieces.is_empty() {
            return Err(PathError::TooShort { n_points: 0 });
        }
        for (index, piece) in pieces.iter().enumerate() {
            if !piece.is_sound() {
                return Err(PathError::NotFinite { index });
            }
            if let Some(before) = index.checked_sub(1) {
                let end = pieces[before].pose_at(pieces[before].length_m()).position();
                let gap_m = (piece.pose_at(0.0).position() - end).norm();
                if gap_m > GAP_MAX_M {
                    return Err(PathError::Gap { index, gap_m });
                }
            }
        }
        Ok(Self::from_checked(pieces))
    }

    /// A polyline whose corners are rounded by arcs of `radius_m`, or of what fits.
    ///
    /// # Errors
    ///
    /// As [`polyline`](Self::polyline); [`PathError::NotFinite`] also for a radius that is not positive.
    pub fn rounded(points: &[Vec2], radius_m: f64) -> Result<Self, PathError> {
        let sharp = Self::polyline(points)?;
        if !(radius_m.is_finite() && radius_m > 0.0) {
            return Err(PathError::NotFinite { index: 0 });
        }
        let mut corners: Vec<Vec2> =
            sharp.pieces.iter().map(|p| p.pose_at(0.0).position()).collect();
        corners.push(sharp.end().position());
        let mut pieces = Vec::with_capacity(2 * corners.len());
        let mut from = corners[0];
        for corner in corners.windows(3) {
            let (into, out) = (corner[1] - corner[0], corner[2] - corner[1]);
            let turn_rad = wrap_to_pi(out.y.atan2(out.x) - into.y.atan2(into.x));
            // Tangent length t = r tan(|turn| / 2); at most half of either side, so that arcs never meet.
            let half_tan = (0.5 * turn_rad.abs()).tan();
            let room_m = 0.5 * into.norm().min(out.norm());
            let tangent_m = (radius_m * half_tan).min(room_m);
            if turn_rad.abs() < 1e-9 || !half_tan.is_finite() || half_tan > 1e6 {
                push_line(&mut pieces, from, corner[1]);
                from = corner[1];
                continue;
            }
            let entry = corner[1] - tangent_m * into.normalize();
            push_line(&mut pieces, from, entry);
            let start = Se2::new(entry.x, entry.y, into.y.atan2(into.x));
            let arc = Arc::from_pose(start, tangent_m / half_tan, turn_rad);
            pieces.push(Piece::Arc(arc));
            from = arc.point_at(arc.length());
        }
        push_line(&mut pieces, from, corners[corners.len() - 1]);
        Ok(Self::from_checked(pieces))
    }

    /// Its pieces in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Length along the path, metres; positive.
    pub fn length_m(&self) -> f64 {
        self.bounds_m[self.pieces.len()]
    }

    /// The point at a distance along the path (m); beyond the ends the end points.
    pub fn point_at(&self, arc_length_m: f64) -> Vec2 {
        self.pose_at(arc_length_m).position()
    }

    /// Point and direction at a distance along the path; beyond the ends those of the ends. O(log pieces).
    pub fn pose_at(&self, arc_length_m: f64) -> Se2 {
        let along_m = arc_length_m.clamp(0.0, self.length_m());
        let index = self.piece_at(along_m);
        self.pieces[index].pose_at(along_m - self.bounds_m[index])
    }

    /// As [`point_at`](Self::point_at), but the path goes on straight beyond its ends.
    pub fn extended_point_at(&self, arc_length_m: f64) -> Vec2 {
        let along_m = arc_length_m.clamp(0.0, self.length_m());
        let pose = self.pose_at(along_m);
        pose.position() + (arc_length_m - along_m) * pose.heading()
    }

    /// As [`pose_at`](Self::pose_at), but before and beyond a stretch the path goes on straight as it
    /// begins and ends there: what a law sees that must not look around the corner.
    pub(crate) fn stretch_point_at(&self, along_m: f64, from_m: f64, to_m: f64) -> Vec2 {
        let inside_m = along_m.clamp(from_m, to_m);
        let index = self.piece_at(inside_m);
        // At a corner the piece that leads to it, not the one after.
        let at_the_joint = inside_m >= to_m && to_m - self.bounds_m[index] <= POINTS_MERGE_M;
        let index = if at_the_joint { index.saturating_sub(1) } else { index };
        let pose = self.pieces[index].pose_at(inside_m - self.bounds_m[index]);
        pose.position() + (along_m - inside_m) * pose.heading()
    }

    /// First point and direction.
    pub fn start(&self) -> Se2 {
        self.pose_at(0.0)
    }

    /// Last point and direction.
    pub fn end(&self) -> Se2 {
        self.pose_at(self.length_m())
    }

    /// Direction of the last piece at its end, radians.
    pub fn end_heading(&self) -> f64 {
        self.end().yaw_rad
    }

    /// The nearest point of the whole path; of equally near ones the first travelled. O(pieces).
    pub fn project(&self, point: Vec2) -> Projection {
        self.project_within(point, 0.0, self.length_m())
    }

    /// Where a robot at a point takes the path up, metres along it: the first place within the stretch from
    /// `from_m` to `to_m` that is no more than `slack_m` further away than the nearest one, and nearest
    /// around there. A loop is begun at its beginning, although its end is as near. O(pieces + stretch / 5 cm).
    pub fn first_near_m(&self, point: Vec2, from_m: f64, to_m: f64, slack_m: f64) -> f64 {
        let nearest = self.project_within(point, from_m, to_m);
        let near_m = (nearest.point - point).norm() + slack_m;
        let end_m = nearest.arc_length_m;
        let step_m = Self::search_step_m(end_m - from_m.max(0.0));
        let mut along_m = from_m.clamp(0.0, self.length_m());
        while along_m < end_m {
            if (self.point_at(along_m) - point).norm() <= near_m {
                return self.downhill_m(point, along_m, end_m, step_m);
            }
            along_m += step_m;
        }
        end_m
    }

    /// Where the path reaches a goal, metres along it: its end if that is within `end_reach_m` of the goal;
    /// else the last place that is hardly further from the goal (`slack_m`) than the nearest one. A loop
    /// reaches a goal where it begins only after all its sides. O(pieces + length / 5 cm).
    pub fn reaches_m(&self, goal: Vec2, end_reach_m: f64, slack_m: f64) -> f64 {
        let (length_m, step_m) = (self.length_m(), Self::search_step_m(self.length_m()));
        let distance_m = |along_m: f64| (self.point_at(along_m) - goal).norm();
        let near_m = if distance_m(length_m) <= end_reach_m {
            f64::INFINITY
        } else {
            let nearest = self.project(goal);
            (nearest.point - goal).norm() + slack_m
        };
        let mut along_m = length_m;
        while along_m > 0.0 && distance_m(along_m) > near_m {
            along_m = (along_m - step_m).max(0.0);
        }
        // Back as long as that leads nearer.
        while along_m > 0.0 {
            let before_m = (along_m - step_m).max(0.0);
            if distance_m(before_m) >= distance_m(along_m) {
                break;
            }
            along_m = before_m;
        }
        let around = self.project_within(goal, along_m - step_m, along_m + step_m);
        around.arc_length_m
    }

    /// From a place on as long as that leads nearer to a point, then the nearest place around.
    fn downhill_m(&self, point: Vec2, from_m: f64, end_m: f64, step_m: f64) -> f64 {
        let distance_m = |along_m: f64| (self.point_at(along_m) - point).norm();
        let mut along_m = from_m;
        while along_m < end_m && distance_m((along_m + step_m).min(end_m)) < distance_m(along_m) {
            along_m = (along_m + step_m).min(end_m);
        }
        self.project_within(point, (along_m - step_m).max(from_m), along_m + step_m).arc_length_m
    }

    /// Steps of a search along so much way: 5 cm, and longer ones where that would be more than 20 000.
    fn search_step_m(way_m: f64) -> f64 {
        (way_m / 20_000.0).max(0.05)
    }

    /// The nearest point of the stretch from `from_m` to `to_m` along the path, so that a robot on a path
    /// that crosses itself stays on its branch. The stretch is cut to the path. A stretch that begins or ends at a
    /// joint has the direction of the piece inside it there. O(log pieces + pieces in it).
    ///
    /// Source: the thesis, (5.27)–(5.31), for one segment or arc.
    pub fn project_within(&self, point: Vec2, from_m: f64, to_m: f64) -> Projection {
        let from_m = from_m.clamp(0.0, self.length_m());
        let to_m = to_m.clamp(from_m, self.length_m());
        let (mut first, mut last) = (self.piece_at(from_m), self.piece_at(to_m));
        // A piece that the stretch only touches, at a joint, does not lend it its direction.
        if first < last && to_m - self.bounds_m[last] <= POINTS_MERGE_M {
            last -= 1;
        }
        let ends_m = self.bounds_m[first] + self.pieces[first].length_m();
        if first < last && ends_m - from_m <= POINTS_MERGE_M {
            first += 1;
        }
        let mut best: Option<(f64, f64, usize)> = None;
        for index in first..=last {
            let start_m = self.bounds_m[index];
            let piece = &self.pieces[index];
            let low_m = (from_m - start_m).clamp(0.0, piece.length_m());
            let high_m = (to_m - start_m).clamp(low_m, piece.length_m());
            let along_m = piece.closest_along_within(point, low_m, high_m);
            let distance_m = (piece.pose_at(along_m).position() - point).norm();
            if best.map_or(!distance_m.is_nan(), |(least_m, ..)| distance_m < least_m) {
                best = Some((distance_m, along_m, index));
            }
        }
        // A point that is no number is near nothing; it gets the beginning of the stretch.
        let (distance_m, along_m, index) =
            best.unwrap_or((f64::NAN, from_m - self.bounds_m[first], first));
        self.describe(point, distance_m, along_m, index)
    }

    fn describe(&self, point: Vec2, distance_m: f64, along_m: f64, index: usize) -> Projection {
        let pose = self.pieces[index].pose_at(along_m);
        let arc_length_m = self.bounds_m[index] + along_m;
        let side_m = pose.heading().perp(&(point - pose.position()));
        let at_an_end = arc_length_m <= 0.0 || arc_length_m >= self.length_m();
        // On the outside of a corner the nearest point is the corner itself, not straight abeam.
        let cross_track_m = if at_an_end { side_m } else { distance_m.copysign(side_m) };
        Projection {
            arc_length_m,
            cross_track_m,
            heading_rad: pose.yaw_rad,
            point: pose.position(),
        }
    }

    fn from_checked(pieces: Vec<Piece>) -> Self {
        let mut bounds_m = Vec::with_capacity(pieces.len() + 1);
        let mut along_m = 0.0;
        for piece in &pieces {
            bounds_m.push(along_m);
            along_m += piece.length_m();
        }
        bounds_m.push(along_m);
        Self { pieces, bounds_m }
    }

    /// The piece at a distance along the path that is inside it; at a joint the later one.
    fn piece_at(&self, along_m: f64) -> usize {
        let n_begun = self.bounds_m.partition_point(|&bound_m| bound_m <= along_m);
        n_begun.clamp(1, self.pieces.len()) - 1
    }
}

impl Piece {
    /// Length along it, metres.
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Line(line) => (line.b - line.a).norm(),
            Self::Arc(arc) => arc.length(),
        }
    }

    /// Point and direction at a distance from its start along it, metres.
    pub fn pose_at(&self, along_m: f64) -> Se2 {
        match self {
            Self::Line(line) => {
                let direction = (line.b - line.a).normalize();
                let point = line.a + along_m * direction;
                Se2::new(point.x, point.y, direction.y.atan2(direction.x))
            }
            Self::Arc(arc) => arc.pose_at(along_m),
        }
    }

    /// How far along it the nearest point of its stretch from `low_m` to `high_m` lies, metres.
    fn closest_along_within(&self, point: Vec2, low_m: f64, high_m: f64) -> f64 {
        match self {
            Self::Line(line) => {
                let along_m = (point - line.a).dot(&(line.b - line.a).normalize());
                along_m.clamp(low_m, high_m)
            }
            Self::Arc(arc) => {
                let turn_rad = |along_m: f64| along_m / arc.radius_m * arc.sweep_rad.signum();
                let stretch = Arc {
                    start_rad: arc.start_rad + turn_rad(low_m),
                    sweep_rad: turn_rad(high_m - low_m),
                    ..*arc
                };
                low_m + stretch.closest_along(point)
            }
        }
    }

    fn is_sound(&self) -> bool {
        let (numbers, size_m) = match self {
            Self::Line(Segment { a, b }) => ([a.x, a.y, b.x, b.y], (b - a).norm()),
            Self::Arc(arc) => {
                let numbers = [arc.centre.x, arc.centre.y, arc.start_rad, arc.sweep_rad];
                (numbers, arc.radius_m.min(arc.length()))
            }
        };
        numbers.iter().all(|n| n.is_finite()) && size_m.is_finite() && size_m > POINTS_MERGE_M
    }
}

/// The signed error of a point against the line through `line.a` and `line.b`, metres: **negative on the left** of the
/// direction from `a` to `b`, the opposite of [`Projection::cross_track_m`]. Not a number for a line without length.
///
/// Source: the thesis, (5.27)–(5.30): A = y₂ − y₁, B = x₁ − x₂, C = x₂ y₁ − x₁ y₂,
/// e = (A x + B y + C) / √(A² + B²).
pub fn signed_line_error_m(line: Segment, point: Vec2) -> f64 {
    let (p, q) = (line.a, line.b);
    let (a, b, c) = (q.y - p.y, p.x - q.x, q.x * p.y - p.x * q.y);
    (a * point.x + b * point.y + c) / a.hypot(b)
}

/// The direction that leads back to a path: towards it by the angle given, on either side (radians).
pub(crate) fn heading_back_rad(path_heading_rad: f64, correction_rad: f64) -> f64 {
    wrap_to_pi(path_heading_rad + correction_rad.clamp(-FRAC_PI_2, FRAC_PI_2))
}

fn push_line(pieces: &mut Vec<Piece>, a: Vec2, b: Vec2) {
    if (b - a).norm() > POINTS_MERGE_M {
        pieces.push(Piece::Line(Segment { a, b }));
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
#[path = "path_tests.rs"]
mod tests;
