//! Simple polygons: outlines of robots, furniture, rooms and zones.

use crate::{Aabb, Se2, Segment, Vec2};

/// Why a list of corners is no [`Polygon`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// Fewer than three corners.
    #[error("a polygon needs at least 3 corners, found {n_corners}")]
    TooFewCorners {
        /// How many there were.
        n_corners: usize,
    },
    /// A coordinate that is not a finite number.
    #[error("corner {corner_index} of the polygon is ({x_m}, {y_m}): both must be finite metres")]
    NotFinite {
        /// Which corner, counted from 0.
        corner_index: usize,
        /// Its x, metres.
        x_m: f64,
        /// Its y, metres.
        y_m: f64,
    },
    /// Two neighbouring corners that are the same point.
    #[error(
        "corners {corner_index} and the next of the polygon are both ({x_m}, {y_m}): remove one"
    )]
    RepeatedCorner {
        /// The first of the two, counted from 0.
        corner_index: usize,
        /// Their x, metres.
        x_m: f64,
        /// Their y, metres.
        y_m: f64,
    },
    /// Two edges that cross or touch, or lie on each other.
    #[error(
        "edges {edge_index} and {other_index} of the polygon meet (edge i begins at corner i): \
         list the corners in order around the outline"
    )]
    SelfIntersecting {
        /// The first of the two, counted from 0.
        edge_index: usize,
        /// The second of the two.
        other_index: usize,
    },
}

/// An outline without holes whose edges do not meet except at common corners.
///
/// The corners are kept counter-clockwise, so the inside is to the left of every edge. The border
/// belongs to the polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<Vec2>,
}

impl Polygon {
    /// Checks `corners` (m), given in order around the outline either way; turns a clockwise list
    /// round. O(n²) for n corners.
    ///
    /// # Errors
    ///
    /// [`PolygonError`] names the first corner or pair of edges that is wrong.
    pub fn new(mut corners: Vec<Vec2>) -> Result<Self, PolygonError> {
        check_corners(&corners)?;
        check_edges(&corners)?;
        if signed_area_m2(&corners) < 0.0 {
            corners.reverse();
        }
        Ok(Self { corners })
    }

    /// The rectangle with its sides along the axes between two opposite corners (m).
    ///
    /// # Errors
    ///
    /// [`PolygonError`] when it has no width or height, or a coordinate is not finite.
    pub fn rectangle(corner: Vec2, opposite: Vec2) -> Result<Self, PolygonError> {
        let across = Vec2::new(opposite.x, corner.y);
        Self::new(vec![corner, across, opposite, Vec2::new(corner.x, opposite.y)])
    }

    /// The corners (m), counter-clockwise, the first not repeated.
    pub fn corners(&self) -> &[Vec2] {
        &self.corners
    }

    /// The edges, counter-clockwise; edge i begins at corner i.
    pub fn edges(&self) -> impl Iterator<Item = Segment> + '_ {
        edges(&self.corners)
    }

    /// Whether `point` (m) lies inside or on the border. O(n) for n corners.
    ///
    /// Source: Hormann, Agathos (2001), "The point in polygon problem for arbitrary polygons",
    /// Computational Geometry 20(3), doi:10.1016/S0925-7721(01)00012-8, the crossing rule.
    /// Differences: points on the border are found first and count as inside.
    pub fn contains(&self, point: Vec2) -> bool {
        let mut inside = false;
        for Segment { a, b } in self.edges() {
            let side = (b - a).perp(&(point - a));
            let between_ends = (point - a).dot(&(point - b)) <= 0.0;
            if side.abs() <= 0.0 && between_ends {
                return true;
            }
            // The half-open rule counts a corner at the point's height once, not twice.
            let crosses_height = (a.y > point.y) != (b.y > point.y);
            if crosses_height && (side > 0.0) == (b.y > a.y) {
                inside = !inside;
            }
        }
        inside
    }

    /// From `point` (m) to the polygon, metres; 0 inside.
    pub fn distance(&self, point: Vec2) -> f64 {
        if self.contains(point) {
            return 0.0;
        }
        self.edges().map(|e| e.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// Whether no corner bends inwards.
    pub fn is_convex(&self) -> bool {
        let n = self.corners.len();
        (0..n).all(|i| {
            let [a, b, c] = [i, i + 1, i + 2].map(|k| self.corners[k % n]);
            (b - a).perp(&(c - b)) >= 0.0
        })
    }

    /// Area, square metres; positive.
    pub fn area_m2(&self) -> f64 {
        signed_area_m2(&self.corners)
    }

    /// The centre of mass of the area (m). It may lie outside a polygon that is not convex.
    pub fn centroid(&self) -> Vec2 {
        // About the first corner, so that a small polygon far from the origin keeps its digits.
        let first = self.corners[0];
        let mut weighted = Vec2::zeros();
        for Segment { a, b } in self.edges() {
            let (a, b) = (a - first, b - first);
            weighted += a.perp(&b) * (a + b);
        }
        first + weighted / (6.0 * self.area_m2())
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.corners.iter().copied())
    }

    /// The polygon moved by `outer_from_inner`.
    #[must_use]
    pub fn transformed(&self, outer_from_inner: Se2) -> Self {
        Self {
            corners: self.corners.iter().map(|&c| outer_from_inner.transform_point(c)).collect(),
        }
    }
}

fn edges(corners: &[Vec2]) -> impl Iterator<Item = Segment> + '_ {
    let ends = corners.iter().cycle().skip(1);
    corners.iter().zip(ends).map(|(&a, &b)| Segment { a, b })
}

/// The shoelace formula, about the first corner; positive for counter-clockwise corners.
fn signed_area_m2(corners: &[Vec2]) -> f64 {
    let first = corners[0];
    0.5 * edges(corners).map(|e| (e.a - first).perp(&(e.b - first))).sum::<f64>()
}

fn check_corners(corners: &[Vec2]) -> Result<(), PolygonError> {
    let n_corners = corners.len();
    if n_corners < 3 {
        return Err(PolygonError::TooFewCorners { n_corners });
    }
    for (corner_index, c) in corners.iter().enumerate() {
        let (x_m, y_m) = (c.x, c.y);
        if !(x_m.is_finite() && y_m.is_finite()) {
            return Err(PolygonError::NotFinite { corner_index, x_m, y_m });
        }
        if *c == corners[(corner_index + 1) % n_corners] {
            return Err(PolygonError::RepeatedCorner { corner_index, x_m, y_m });
        }
    }
    Ok(())
}

fn check_edges(corners: &[Vec2]) -> Result<(), PolygonError> {
    let n = corners.len();
    let all: Vec<Segment> = edges(corners).collect();
    for (edge_index, edge) in all.iter().enumerate() {
        let found =
            Err(PolygonError::SelfIntersecting { edge_index, other_index: (edge_index + 1) % n });
        // Neighbours share a corner; they must not run back over each other.
        let next = all[(edge_index + 1) % n];
        let (along, onward) = (edge.b - edge.a, next.b - next.a);
        if along.perp(&onward).abs() <= 0.0 && along.dot(&onward) < 0.0 {
            return found;
        }
        for (other_index, other) in all.iter().enumerate().skip(edge_index + 2) {
            let neighbours = edge_index == 0 && other_index == n - 1;
            if !neighbours && edge.intersects(*other) {
                return Err(PolygonError::SelfIntersecting { edge_index, other_index });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    fn polygon(corners: &[(f64, f64)]) -> Result<Polygon, PolygonError> {
        Polygon::new(corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect())
    }

    /// An L of area 3 with its inner corner at (1, 1).
    fn l_shape() -> Polygon {
        polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]).unwrap()
    }

    /// Corners at growing angles and any radii: star-shaped, so always simple.
    fn star() -> impl Strategy<Value = Polygon> {
        proptest::collection::vec(0.2..3.0_f64, 3..12).prop_map(|radii| {
            let step = TAU / radii.len() as f64;
            let corner = |(i, r): (usize, &f64)| {
                let (s, c) = (i as f64 * step + 0.1).sin_cos();
                Vec2::new(r * c, r * s)
            };
            Polygon::new(radii.iter().enumerate().map(corner).collect()).unwrap()
        })
    }

    #[test]
    fn corners_that_make_no_outline_are_refused_with_their_place() {
        let check = |corners: &[(f64, f64)], message: &str| {
            assert_eq!(polygon(corners).unwrap_err().to_string(), message);
        };
        check(&[(0.0, 0.0), (1.0, 0.0)], "a polygon needs at least 3 corners, found 2");
        check(
            &[(0.0, 0.0), (1.0, f64::NAN), (1.0, 1.0)],
            "corner 1 of the polygon is (1, NaN): both must be finite metres",
        );
        check(
            &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)],
            "corners 3 and the next of the polygon are both (0, 0): remove one",
        );
        check(
            &[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)],
            "edges 0 and 2 of the polygon meet (edge i begins at corner i): \
             list the corners in order around the outline",
        );
        assert!(matches!(
            polygon(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]),
            Err(PolygonError::SelfIntersecting { .. })
        ));
    }

    #[test]
    fn a_clockwise_list_is_turned_round() {
        let turned = polygon(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]).unwrap();
        assert!((turned.area_m2() - 1.0).abs() < 1e-15);
        assert!(turned.is_convex());
    }

    #[test]
    fn an_l_has_its_area_its_centroid_and_a_corner_that_bends_inwards() {
        let l = l_shape();
        assert!((l.area_m2() - 3.0).abs() < 1e-15);
        // Three unit squares centred at (0.5, 0.5), (1.5, 0.5), (0.5, 1.5).
        assert!((l.centroid() - Vec2::new(2.5 / 3.0, 2.5 / 3.0)).norm() < 1e-15);
        assert!(!l.is_convex());
        assert_eq!(l.bounds().max, Vec2::new(2.0, 2.0));
    }

    #[test]
    fn the_border_is_inside_and_the_notch_is_not() {
        let l = l_shape();
        for (x, y) in [(0.5, 0.5), (0.0, 0.0), (2.0, 0.5), (1.0, 1.0), (1.0, 1.5), (1.0, 0.0)] {
            assert!(l.contains(Vec2::new(x, y)), "({x}, {y})");
        }
        for (x, y) in
            [(1.5, 1.5), (-0.1, 0.0), (3.0, 1.0), (-1.0, 2.0), (3.0, 2.0), (0.5, f64::NAN)]
        {
            assert!(!l.contains(Vec2::new(x, y)), "({x}, {y})");
        }
        assert!((l.distance(Vec2::new(1.5, 1.2)) - 0.2).abs() < 1e-15);
        assert!(l.distance(Vec2::new(0.5, 0.5)).abs() < 1e-15);
    }

    proptest! {
        /// Oracle: the angles under which a point sees the edges add up to a turn, or to nothing.
        #[test]
        fn inside_agrees_with_the_winding_angle(p in star(), x in -3.0..3.0, y in -3.0..3.0) {
            let seen = |c: &Vec2| f64::atan2(c.y - y, c.x - x);
            let n = p.corners().len();
            let total: f64 = (0..n).map(|i| {
                let d = seen(&p.corners()[(i + 1) % n]) - seen(&p.corners()[i]);
                d - TAU * (d / TAU).round()
            }).sum();
            prop_assert_eq!(p.contains(Vec2::new(x, y)), total > PI);
        }

        #[test]
        fn moving_keeps_area_and_takes_the_centroid_along(
            p in star(), x in -9.0..9.0, y in -9.0..9.0, yaw in -3.0..3.0,
        ) {
            let motion = Se2::new(x, y, yaw);
            let moved = p.transformed(motion);
            prop_assert!((moved.area_m2() - p.area_m2()).abs() < 1e-11);
            prop_assert!((moved.centroid() - motion.transform_point(p.centroid())).norm() < 1e-9);
        }

        /// Oracle: triangles from a fan about the centre of the star, each by its own formula.
        #[test]
        fn area_and_centroid_agree_with_a_fan_of_triangles(p in star()) {
            let (mut area, mut moment) = (0.0, Vec2::zeros());
            for e in p.edges() {
                let t = 0.5 * (e.a.x * e.b.y - e.b.x * e.a.y);
                area += t;
                moment += t * (e.a + e.b) / 3.0;
            }
            prop_assert!((p.area_m2() - area).abs() < 1e-12);
            prop_assert!((p.centroid() - moment / area).norm() < 1e-9);
        }
    }
}
