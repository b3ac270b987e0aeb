//! Drawing trails: from a polyline to cells.

use geometry::Vec2;

use crate::Field;

impl Field {
    /// Draws a trail one cell wide along a polyline (m, map frame): every cell the line passes gets
    /// `value`. Returns how many cells were written; what lies outside the field is skipped.
    ///
    /// Neighbouring cells share a side or a corner, never both ways around, so that the trail stays thin
    /// on diagonals. A single point writes one cell. O(length / cell size).
    pub fn draw_trail(&mut self, polyline: &[Vec2], value: u8) -> usize {
        self.draw_wide_trail(polyline, value, 1)
    }

    /// As [`draw_trail`](Self::draw_trail), with a square brush of `width_cells` cells; an even brush
    /// reaches one cell further right and down. Cells already at `value` are not counted.
    pub fn draw_wide_trail(&mut self, polyline: &[Vec2], value: u8, width_cells: usize) -> usize {
        let revision_before = self.revision();
        match polyline {
            [] => {}
            [point] => self.draw_line(*point, *point, value, width_cells),
            _ => {
                for ends in polyline.windows(2) {
                    self.draw_line(ends[0], ends[1], value, width_cells);
                }
            }
        }
        (self.revision() - revision_before) as usize
    }

    /// Bresenham's line between the cells of the two ends: one cell per step of the longer direction.
    fn draw_line(&mut self, from: Vec2, to: Vec2, value: u8, width_cells: usize) {
        let (Some(from), Some(to)) = (self.cell_coordinates(from), self.cell_coordinates(to))
        else {
            return;
        };
        let delta = (to.0 - from.0, to.1 - from.1);
        let n_steps = delta.0.abs().max(delta.1.abs());
        // Only the steps inside the field are walked, so that a far end costs nothing.
        let (first, last) = self.steps_inside(from, delta, n_steps, width_cells as i64);
        for step in first..=last {
            let along = |from: i64, delta: i64| {
                if n_steps == 0 { from } else { from + rounded_ratio(delta * step, n_steps) }
            };
            self.stamp(along(from.0, delta.0), along(from.1, delta.1), value, width_cells as i64);
        }
    }

    /// The range of steps that can touch the field with a brush of this width; empty as (1, 0).
    fn steps_inside(
        &self,
        from: (i64, i64),
        delta: (i64, i64),
        n_steps: i64,
        brush: i64,
    ) -> (i64, i64) {
        let (mut first, mut last) = (0, n_steps);
        for (from, delta, n) in
            [(from.0, delta.0, self.width() as i64), (from.1, delta.1, self.height() as i64)]
        {
            let (low, high) = (-brush - 1, n + brush);
            if delta == 0 {
                if !(low..=high).contains(&from) {
                    return (1, 0);
                }
                continue;
            }
            let step_at = |bound: i64| (bound - from) * n_steps / delta;
            let (a, b) = (step_at(low), step_at(high));
            first = first.max(a.min(b) - 1);
            last = last.min(a.max(b) + 1);
        }
        (first, last)
    }

    fn stamp(&mut self, col: i64, row: i64, value: u8, width_cells: i64) {
        let before = (width_cells - 1) / 2;
        for row in row - before..row - before + width_cells {
            for col in col - before..col - before + width_cells {
                if let (Ok(col), Ok(row)) = (usize::try_from(col), usize::try_from(row)) {
                    // Beyond the border there is nothing to write.
                    self.set(col, row, value).ok();
                }
            }
        }
    }

    /// Column and row of a point, outside the field as well; `None` when it is not finite or absurdly far.
    fn cell_coordinates(&self, point: Vec2) -> Option<(i64, i64)> {
        let cell = point / self.cell_size_m();
        let far = 1e9;
        (cell.x.abs() < far && cell.y.abs() < far).then(|| {
            let col = (cell.x + 0.5).floor() as i64 + (self.width() / 2) as i64;
            let row = (self.height() / 2) as i64 - (cell.y + 0.5).floor() as i64;
            (col, row)
        })
    }
}

/// a/b rounded to the nearest whole number, halves away from zero; b > 0.
fn rounded_ratio(a: i64, b: i64) -> i64 {
    (2 * a.abs() + b) / (2 * b) * a.signum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::{Expect, expect};

    fn check(width_cells: usize, polyline: &[(f64, f64)], expected: &Expect) {
        let mut field = Field::new(9, 7, 1.0).unwrap();
        let polyline: Vec<Vec2> = polyline.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        let n_written = field.draw_wide_trail(&polyline, 1, width_cells);
        expected.assert_eq(&format!("{}{n_written} written\n", field.to_text()));
    }

    #[test]
    fn a_corner_is_drawn_cell_by_cell() {
        check(
            1,
            &[(-3.0, -2.0), (2.0, -2.0), (2.0, 3.0)],
            &expect![[r#"
            0 0 0 0 0 0 1 0 0
            0 0 0 0 0 0 1 0 0
            0 0 0 0 0 0 1 0 0
            0 0 0 0 0 0 1 0 0
            0 0 0 0 0 0 1 0 0
            0 1 1 1 1 1 1 0 0
            0 0 0 0 0 0 0 0 0
            11 written
        "#]],
        );
    }

    #[test]
    fn a_slanted_line_is_one_cell_thin() {
        check(
            1,
            &[(-4.0, -1.0), (4.0, 2.0)],
            &expect![[r#"
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 1 1
            0 0 0 0 1 1 1 0 0
            0 0 1 1 0 0 0 0 0
            1 1 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            9 written
        "#]],
        );
    }

    #[test]
    fn a_wide_brush_covers_both_sides() {
        check(
            3,
            &[(-2.0, 0.0), (2.0, 0.0)],
            &expect![[r#"
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 1 1 1 1 1 1 1 0
            0 1 1 1 1 1 1 1 0
            0 1 1 1 1 1 1 1 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            21 written
        "#]],
        );
    }

    #[test]
    fn what_is_outside_is_skipped_however_far() {
        check(
            1,
            &[(-1e6, 1.0), (1e6, 1.0)],
            &expect![[r#"
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            1 1 1 1 1 1 1 1 1
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            9 written
        "#]],
        );
        check(
            1,
            &[(-6.0, 9.0), (6.0, 9.0), (f64::NAN, 0.0)],
            &expect![[r#"
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 0 0 0 0 0 0 0 0
            0 written
        "#]],
        );
    }

    #[test]
    fn a_line_is_the_same_from_both_ends() {
        for end in [(4.0, 1.0), (4.0, 3.0), (-3.0, 2.0), (1.0, -3.0)] {
            let mut there = Field::new(11, 9, 1.0).unwrap();
            let end = Vec2::new(end.0, end.1);
            there.draw_trail(&[Vec2::zeros(), end], 1);
            assert!(there.n_sources() > 3);
            assert_eq!(there.value(5, 4), 1);
            let (col, row) = there.cell_at(end).unwrap();
            assert_eq!(there.value(col, row), 1);
        }
    }
}
