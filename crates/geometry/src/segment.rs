//! Straight pieces of line.

use crate::Vec2;

/// The straight piece of line between two points; both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// One end (m).
    pub a: Vec2,
    /// The other end (m).
    pub b: Vec2,
}

impl Segment {
    /// From `a` to `b`, metres.
    pub fn length(self) -> f64 {
        (self.b - self.a).norm()
    }

    /// The point at `ratio` of the way from `a` (0) to `b` (1) (m); outside [0, 1] on the line
    /// beyond the ends.
    pub fn point_at(self, ratio: f64) -> Vec2 {
        self.a + (self.b - self.a) * ratio
    }

    /// How far along the segment its point nearest to `point` (m) lies: 0 at `a`, 1 at `b`. A
    /// segment without length answers 0.
    pub fn closest_ratio(self, point: Vec2) -> f64 {
        let along = self.b - self.a;
        let length_squared = along.norm_squared();
        if length_squared > 0.0 {
            ((point - self.a).dot(&along) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// The point of the segment nearest to `point` (both m).
    pub fn closest_point(self, point: Vec2) -> Vec2 {
        // Each end from its own coordinates, so that the far end is met exactly too.
        let ratio = self.closest_ratio(point);
        if ratio < 0.5 { self.point_at(ratio) } else { self.b + (self.a - self.b) * (1.0 - ratio) }
    }

    /// From `point` (m) to the nearest point of the segment, metres.
    pub fn distance(self, point: Vec2) -> f64 {
        (point - self.closest_point(point)).norm()
    }

    /// Whether the two segments share a point; touching counts.
    ///
    /// Decided by the signs of cross products: exact for coordinates whose products are, otherwise
    /// to rounding.
    pub fn intersects(self, other: Self) -> bool {
        let side = |s: Self, p: Vec2| (s.b - s.a).perp(&(p - s.a));
        let (c, d) = (side(self, other.a), side(self, other.b));
        let (e, f) = (side(other, self.a), side(other, self.b));
        let apart = |u: f64, v: f64| (u > 0.0 && v > 0.0) || (u < 0.0 && v < 0.0);
        if apart(c, d) || apart(e, f) {
            return false;
        }
        // What is left and not in line crosses; in line, the boxes around them decide.
        let overlap = |p: f64, q: f64, r: f64, s: f64| p.min(q) <= r.max(s) && r.min(s) <= p.max(q);
        overlap(self.a.x, self.b.x, other.a.x, other.b.x)
            && overlap(self.a.y, self.b.y, other.a.y, other.b.y)
    }

    /// From the nearest point of one segment to the nearest of the other, metres; 0 when they
    /// intersect.
    pub fn distance_to_segment(self, other: Self) -> f64 {
        if self.intersects(other) {
            return 0.0;
        }
        // Two segments that do not cross are nearest at an end of one of them.
        let from_ends = self.distance(other.a).min(self.distance(other.b));
        from_ends.min(other.distance(self.a)).min(other.distance(self.b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn segment(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
        Segment { a: Vec2::new(ax, ay), b: Vec2::new(bx, by) }
    }

    #[test]
    fn the_nearest_point_is_a_foot_or_an_end() {
        let s = segment(0.0, 0.0, 4.0, 0.0);
        assert_eq!(s.closest_point(Vec2::new(1.0, 3.0)), Vec2::new(1.0, 0.0));
        assert_eq!(s.closest_point(Vec2::new(-1.0, -3.0)), s.a);
        assert_eq!(s.closest_point(Vec2::new(9.0, 1.0)), s.b);
        assert!((s.distance(Vec2::new(7.0, 4.0)) - 5.0).abs() < 1e-15);
        assert!((s.length() - 4.0).abs() < 1e-15);
    }

    #[test]
    fn a_segment_without_length_is_a_point() {
        let s = segment(1.0, 1.0, 1.0, 1.0);
        assert_eq!(s.closest_point(Vec2::new(4.0, 5.0)), s.a);
        assert!((s.distance(Vec2::new(4.0, 5.0)) - 5.0).abs() < 1e-15);
    }

    #[test]
    fn crossing_touching_in_line_and_apart_are_told_apart() {
        let s = segment(0.0, 0.0, 4.0, 0.0);
        assert!(s.intersects(segment(2.0, -1.0, 2.0, 1.0)), "crossing");
        assert!(s.intersects(segment(4.0, 0.0, 5.0, 3.0)), "end on end");
        assert!(s.intersects(segment(2.0, 0.0, 2.0, 1.0)), "end on the middle");
        assert!(s.intersects(segment(3.0, 0.0, 9.0, 0.0)), "in line, overlapping");
        assert!(!s.intersects(segment(4.5, 0.0, 9.0, 0.0)), "in line, apart");
        assert!(!s.intersects(segment(0.0, 1.0, 4.0, 1.0)), "parallel");
        assert!(!s.intersects(segment(5.0, -1.0, 5.0, 1.0)), "beyond the end");
        assert!((s.distance_to_segment(segment(0.0, 1.5, 4.0, 2.0)) - 1.5).abs() < 1e-15);
        assert!((s.distance_to_segment(segment(7.0, -4.0, 9.0, -9.0)) - 5.0).abs() < 1e-15);
    }

    proptest! {
        /// Oracle: the best of many points, tried one by one.
        #[test]
        fn no_point_of_the_segment_is_nearer(
            (ax, ay, bx, by) in (-5.0..5.0, -5.0..5.0, -5.0..5.0, -5.0..5.0),
            (x, y) in (-9.0..9.0, -9.0..9.0),
        ) {
            let tried = (0..=1000).map(|i| {
                let t = f64::from(i) / 1000.0;
                f64::hypot(ax + t * (bx - ax) - x, ay + t * (by - ay) - y)
            });
            let best = tried.fold(f64::INFINITY, f64::min);
            let found = segment(ax, ay, bx, by).distance(Vec2::new(x, y));
            prop_assert!(found <= best + 1e-12);
            prop_assert!(found >= best - 0.02, "nearer than any point there is");
        }

        /// Oracle: the point where the two lines meet, by Cramer's rule on both parameters.
        #[test]
        fn intersection_agrees_with_solving_for_it(
            (ax, ay, bx, by) in (-5.0..5.0, -5.0..5.0, -5.0..5.0, -5.0..5.0),
            (cx, cy, dx, dy) in (-5.0..5.0, -5.0..5.0, -5.0..5.0, -5.0..5.0),
        ) {
            let (ux, uy, vx, vy) = (bx - ax, by - ay, dx - cx, dy - cy);
            let det: f64 = vx * uy - ux * vy;
            prop_assume!(det.abs() > 1e-6);
            let t = (vx * (cy - ay) - vy * (cx - ax)) / det;
            let s = (ux * (cy - ay) - uy * (cx - ax)) / det;
            let margin = [t, 1.0 - t, s, 1.0 - s].into_iter().fold(f64::INFINITY, f64::min);
            prop_assume!(margin.abs() > 1e-9);
            let (one, two) = (segment(ax, ay, bx, by), segment(cx, cy, dx, dy));
            prop_assert_eq!(one.intersects(two), margin > 0.0);
            prop_assert_eq!(two.intersects(one), margin > 0.0);
        }
    }
}
