//! A trail that lies in the floor itself: what each tag stores of it.
//!
//! Across the trail the intensity falls linearly from the middle to nothing, as the thesis's grey levels do, so that
//! two readers side by side find a gradient; along the trail it is the same everywhere.
//!
//! Source: the thesis, 5.3.2, variant A, and Fig. 5.16 (three or four adjacent cells wide, white is none, black the
//! most). Differences: it prints no profile; this one is the diffusion (5.33) of a source line.

use geometry::{Segment, Vec2};

use crate::model::diffused;

/// A trail to be written into tags.
///
/// ```
/// use geometry::Vec2;
/// use pheromones::TagTrail;
///
/// let line = vec![Vec2::new(0.0, 0.0), Vec2::new(8.0, 0.0)];
/// // Three tags wide with tags every 0.1 m: 0.2 m from the middle there is nothing left.
/// let trail = TagTrail::new(vec![line], 3, 0.1, 200);
/// let strengths = [-0.2, -0.1, 0.0, 0.1, 0.2].map(|y| trail.strength_at(Vec2::new(4.0, y)));
/// assert_eq!(strengths, [0, 100, 200, 100, 0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TagTrail {
    lines: Vec<Vec<Vec2>>,
    reach_m: f64,
    peak: u8,
}

impl TagTrail {
    /// A trail along polylines (m, map), so many tags wide where tags are `pitch_m` apart, with `peak` in the
    /// middle. A line along a row of tags wants an odd width, one between two rows an even one.
    pub fn new(lines: Vec<Vec<Vec2>>, width_cells: usize, pitch_m: f64, peak: u8) -> Self {
        // The first row beyond the width is the first without pheromone.
        Self { lines, reach_m: 0.5 * (width_cells as f64 + 1.0) * pitch_m, peak }
    }

    /// Distance from the middle at which nothing is left, metres.
    pub fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// What a tag at a point (m, map) stores, 0 off the trail; where trails meet, the strongest counts.
    /// O(corners).
    pub fn strength_at(&self, point: Vec2) -> u8 {
        let pieces = self.lines.iter().flat_map(|line| line.windows(2));
        let away_m = pieces
            .map(|ends| {
                let piece = Segment { a: ends[0], b: ends[1] };
                (piece.closest_point(point) - point).norm()
            })
            .fold(f64::INFINITY, f64::min);
        // At most the peak, which is a byte.
        diffused(f64::from(self.peak), away_m, self.reach_m).round() as u8
    }
}

/// What a tag stores after a robot that passes has amplified it: more, up to 255, where there is a trail, and
/// still nothing where there is none.
///
/// Source: the thesis, 5.3.2: robots may amplify the trail that they pass.
pub fn amplified(strength: u8, amount: u8) -> u8 {
    if strength == 0 { 0 } else { strength.saturating_add(amount) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(width_cells: usize, peak: u8) -> TagTrail {
        let line = vec![Vec2::new(0.0, 0.0), Vec2::new(2.0, 0.0), Vec2::new(2.0, 2.0)];
        TagTrail::new(vec![line], width_cells, 0.1, peak)
    }

    /// Counted by hand for even and odd widths: the rows that hold something are as many as asked for.
    #[test]
    fn a_trail_is_as_many_tags_wide_as_asked_for() {
        for width_cells in 1..=9 {
            let trail = corner(width_cells, 200);
            let between_rows = if width_cells % 2 == 0 { 0.05 } else { 0.0 };
            let row_m = |row: i32| 0.1 * f64::from(row) + between_rows;
            let n = (-9..9).filter(|row| trail.strength_at(Vec2::new(1.0, row_m(*row))) > 0);
            assert_eq!(n.count(), width_cells);
        }
    }

    /// The law (5.33) at points whose distance is known from elementary geometry.
    #[test]
    fn strength_falls_linearly_with_the_distance() {
        let trail = corner(4, 250);
        assert!((trail.reach_m() - 0.25).abs() < 1e-12);
        for (x, y, away_m) in [
            (1.0, 0.0, 0.0),
            (1.0, 0.13, 0.13),
            (1.0, -0.13, 0.13),
            (2.12, 1.0, 0.12),
            // Beyond the corner, on the diagonal of 3-4-5.
            (2.06, -0.08, 0.1),
            (-0.2, 0.0, 0.2),
            (1.0, 0.3, 0.3),
        ] {
            let expected = (250.0 * (1.0 - away_m / 0.25_f64)).max(0.0).round();
            let found = f64::from(trail.strength_at(Vec2::new(x, y)));
            assert!((found - expected).abs() <= 1.0, "({x}, {y}): {found} {expected}");
        }
        assert_eq!(TagTrail::new(Vec::new(), 3, 0.1, 200).strength_at(Vec2::zeros()), 0);
    }

    #[test]
    fn passing_robots_amplify_the_trail_and_nothing_else() {
        assert_eq!([0, 1, 250, 255].map(|strength| amplified(strength, 10)), [0, 11, 255, 255]);
        assert_eq!(amplified(7, 0), 7);
    }
}
