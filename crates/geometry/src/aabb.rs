//! Boxes whose sides are parallel to the axes.

use crate::Vec2;

/// A closed box with sides parallel to the axes.
///
/// It is empty when a coordinate of `min` exceeds that of `max`; see [`Aabb::EMPTY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates (m).
    pub min: Vec2,
    /// The corner with the largest coordinates (m).
    pub max: Vec2,
}

impl Aabb {
    /// The box that contains nothing; growing it by a box gives that box.
    pub const EMPTY: Self = Self {
        min: Vec2::new(f64::INFINITY, f64::INFINITY),
        max: Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The smallest box around `points` (m); [`Aabb::EMPTY`] when there are none. Points with a
    /// coordinate that is not a number do not count in that coordinate.
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Self {
        points.into_iter().fold(Self::EMPTY, |grown, p| grown.union(Self { min: p, max: p }))
    }

    /// The smallest box that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The box with every side moved outwards by `margin_m` (inwards when negative).
    #[must_use]
    pub fn grown(self, margin_m: f64) -> Self {
        Self { min: self.min.add_scalar(-margin_m), max: self.max.add_scalar(margin_m) }
    }

    /// Whether no point lies in the box.
    pub fn is_empty(self) -> bool {
        self.min.x > self.max.x || self.min.y > self.max.y
    }

    /// Whether `point` (m) lies in the box or on its border.
    pub fn contains(self, point: Vec2) -> bool {
        let within = |low: f64, x: f64, high: f64| low <= x && x <= high;
        within(self.min.x, point.x, self.max.x) && within(self.min.y, point.y, self.max.y)
    }

    /// Whether the two boxes share a point; touching counts.
    pub fn overlaps(self, other: Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
    }

    /// Width and height (m); not finite for an empty box.
    pub fn size(self) -> Vec2 {
        self.max - self.min
    }

    /// The point midway between the corners (m).
    pub fn centre(self) -> Vec2 {
        0.5 * (self.min + self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Aabb {
        Aabb { min: Vec2::new(0.0, 0.0), max: Vec2::new(1.0, 2.0) }
    }

    #[test]
    fn nothing_has_an_empty_box_that_growing_ignores() {
        assert_eq!(Aabb::around([]), Aabb::EMPTY);
        assert!(Aabb::EMPTY.is_empty() && !unit().is_empty());
        assert_eq!(Aabb::EMPTY.union(unit()), unit());
        assert!(!Aabb::EMPTY.overlaps(unit()) && !Aabb::EMPTY.contains(Vec2::zeros()));
    }

    #[test]
    fn the_border_belongs_to_the_box() {
        assert!(unit().contains(Vec2::new(1.0, 2.0)) && unit().contains(Vec2::new(0.0, 0.0)));
        assert!(!unit().contains(Vec2::new(1.0, 2.000_001)));
        assert!(!unit().contains(Vec2::new(-1e-9, 1.0)));
        let beside = Aabb { min: Vec2::new(1.0, 2.0), max: Vec2::new(3.0, 3.0) };
        assert!(unit().overlaps(beside) && beside.overlaps(unit()));
        assert!(!unit().overlaps(Aabb { min: Vec2::new(1.1, 0.0), ..beside }));
    }

    #[test]
    fn a_point_that_is_not_a_number_is_in_no_box() {
        assert!(!unit().contains(Vec2::new(f64::NAN, 0.5)));
        let around = Aabb::around([Vec2::new(f64::NAN, 1.0), Vec2::new(2.0, 3.0)]);
        assert_eq!(around.max, Vec2::new(2.0, 3.0));
    }

    #[test]
    fn size_centre_and_margin_follow_the_corners() {
        assert_eq!(unit().size(), Vec2::new(1.0, 2.0));
        assert_eq!(unit().centre(), Vec2::new(0.5, 1.0));
        assert_eq!(unit().grown(0.5).min, Vec2::new(-0.5, -0.5));
        assert!(unit().grown(-0.6).is_empty());
    }
}
