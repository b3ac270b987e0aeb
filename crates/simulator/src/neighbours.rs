//! Which robots are near: a uniform grid kept as one sorted list.
//!
//! No hash map, so the order of what it finds is the order of cells, then of robots. Cells are
//! at least as large as two robots and what they may move in a step, so neighbours lie in the
//! 3 × 3 cells around a robot.

use geometry::{Aabb, Ray, Vec2};

/// What a body may move between two rebuilds beyond its wheels' speed (bumps, slip), metres.
const SPARE_M: f64 = 0.1;

#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    cell_size_m: f64,
    /// Greatest distance from a body's cell to any of its points, metres.
    reach_m: f64,
    /// (row, column, body), sorted.
    entries: Vec<(i32, i32, u32)>,
}

impl Neighbours {
    pub(crate) fn new() -> Self {
        Self { cell_size_m: 1.0, reach_m: 0.5, entries: Vec::new() }
    }

    /// Makes room for bodies of that radius that move up to `move_max_m` per step.
    pub(crate) fn admit(&mut self, radius_m: f64, move_max_m: f64) {
        self.reach_m = self.reach_m.max(radius_m + move_max_m + SPARE_M);
        self.cell_size_m = self.cell_size_m.max(2.0 * self.reach_m);
    }

    /// Sorts the bodies anew. O(n log n), near O(n) when few changed cells; allocates only when
    /// there are more bodies than ever before.
    pub(crate) fn rebuild(&mut self, positions: impl ExactSizeIterator<Item = Vec2>) {
        if self.entries.len() == positions.len() {
            // The order of the last step is almost right, and sorting that is cheap.
            let (size_m, entries) = (self.cell_size_m, &mut self.entries);
            // Entries are permuted bodies, so look positions up by a second pass in body order.
            entries.sort_unstable_by_key(|entry| entry.2);
            for (entry, position) in entries.iter_mut().zip(positions) {
                (entry.0, entry.1) = cell(position, size_m);
            }
        } else {
            self.entries.clear();
            let size_m = self.cell_size_m;
            self.entries.extend((0..).zip(positions).map(|(body, position)| {
                let (row, column) = cell(position, size_m);
                (row, column, body)
            }));
        }
        self.entries.sort_unstable();
    }

    /// The bodies whose position lies within two reaches of `point`, and some more.
    pub(crate) fn near(&self, point: Vec2) -> impl Iterator<Item = usize> + '_ {
        let (row, column) = cell(point, self.cell_size_m);
        (row.saturating_sub(1)..=row.saturating_add(1))
            .flat_map(move |r| self.row_part(r, column.saturating_sub(1), column.saturating_add(1)))
    }

    /// The bodies with a point within `distance_m` of `point`, and some more.
    pub(crate) fn near_within(
        &self,
        point: Vec2,
        distance_m: f64,
    ) -> impl Iterator<Item = usize> + '_ {
        self.in_box(Aabb { min: point, max: point }.grown(distance_m))
    }

    /// The bodies with a point in `bounds`, and some more.
    pub(crate) fn in_box(&self, bounds: Aabb) -> impl Iterator<Item = usize> + '_ {
        let Aabb { min, max } = bounds.grown(self.reach_m);
        let rows = index(min.y, self.cell_size_m)..=index(max.y, self.cell_size_m);
        let (left, right) = (index(min.x, self.cell_size_m), index(max.x, self.cell_size_m));
        rows.flat_map(move |row| self.row_part(row, left, right))
    }

    /// The bodies that a ray of `range_m` may meet, and some more.
    pub(crate) fn along<'a>(&'a self, ray: &Ray, range_m: f64) -> impl Iterator<Item = usize> + 'a {
        let (start, end) = (ray.origin, ray.origin + range_m * ray.direction);
        let (low, high) = (start.y.min(end.y) - self.reach_m, start.y.max(end.y) + self.reach_m);
        let (first, last) = (index(low, self.cell_size_m), index(high, self.cell_size_m));
        let ray = *ray;
        (first..=last).flat_map(move |row| {
            let (left, right) = self.columns_of_row(&ray, range_m, row);
            self.row_part(row, left, right)
        })
    }

    /// First and last column of `row` that the ray, widened by the reach, passes.
    fn columns_of_row(&self, ray: &Ray, range_m: f64, row: i32) -> (i32, i32) {
        let bottom_m = f64::from(row) * self.cell_size_m - self.reach_m;
        let top_m = bottom_m + self.cell_size_m + 2.0 * self.reach_m;
        // Part of the ray between the two heights; the whole ray when it is level.
        let at = |height_m: f64| (height_m - ray.origin.y) / ray.direction.y;
        let (enter, leave) = if ray.direction.y.abs() < 1e-9 {
            (0.0, range_m)
        } else {
            let (a, b) = (at(bottom_m), at(top_m));
            (a.min(b).clamp(0.0, range_m), a.max(b).clamp(0.0, range_m))
        };
        let (a, b) =
            (ray.origin.x + enter * ray.direction.x, ray.origin.x + leave * ray.direction.x);
        (
            index(a.min(b) - self.reach_m, self.cell_size_m),
            index(a.max(b) + self.reach_m, self.cell_size_m),
        )
    }

    fn row_part(&self, row: i32, left: i32, right: i32) -> impl Iterator<Item = usize> + '_ {
        let start = self.entries.partition_point(|&(r, c, _)| (r, c) < (row, left));
        self.entries[start..]
            .iter()
            .take_while(move |&&(r, c, _)| (r, c) <= (row, right))
            .map(|&(_, _, body)| body as usize)
    }
}

fn cell(position: Vec2, size_m: f64) -> (i32, i32) {
    (index(position.y, size_m), index(position.x, size_m))
}

/// Saturates far away, which only makes distant bodies look like neighbours.
fn index(coordinate_m: f64, size_m: f64) -> i32 {
    (coordinate_m / size_m).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(positions: &[Vec2]) -> Neighbours {
        let mut neighbours = Neighbours::new();
        neighbours.admit(0.37, 0.022);
        neighbours.rebuild(positions.iter().copied());
        neighbours
    }

    fn positions() -> impl Strategy<Value = Vec<Vec2>> {
        let place = (-8.0..8.0, -8.0..8.0).prop_map(|(x, y)| Vec2::new(x, y));
        proptest::collection::vec(place, 1..60)
    }

    fn check_no_repeats(mut found: Vec<usize>) -> Result<Vec<usize>, TestCaseError> {
        found.sort_unstable();
        prop_assert!(found.windows(2).all(|w| w[0] != w[1]), "found twice: {:?}", found);
        Ok(found)
    }

    proptest! {
        #[test]
        fn nobody_near_is_missed(positions in positions()) {
            let neighbours = grid(&positions);
            for here in &positions {
                let found = check_no_repeats(neighbours.near(*here).collect())?;
                for (i, there) in positions.iter().enumerate() {
                    prop_assert!((there - here).norm() > 0.8 || found.contains(&i));
                }
            }
        }

        /// Cells grow with the robots.
        #[test]
        fn large_robots_are_not_missed_either(positions in positions(), radius in 0.1..2.5) {
            let mut neighbours = Neighbours::new();
            neighbours.admit(radius, 0.022);
            neighbours.rebuild(positions.iter().copied());
            for here in &positions {
                let found = check_no_repeats(neighbours.near(*here).collect())?;
                for (i, there) in positions.iter().enumerate() {
                    prop_assert!((there - here).norm() > 2.0 * radius || found.contains(&i));
                }
            }
        }

        #[test]
        fn nobody_within_a_distance_is_missed(positions in positions(), d in 0.0..3.0) {
            let neighbours = grid(&positions);
            let found = check_no_repeats(neighbours.near_within(Vec2::zeros(), d).collect())?;
            for (i, there) in positions.iter().enumerate() {
                prop_assert!(there.norm() > d + 0.4 || found.contains(&i));
            }
        }

        #[test]
        fn nobody_on_a_ray_is_missed(positions in positions(), angle in -3.2..3.2, range in 0.1..6.0) {
            let neighbours = grid(&positions);
            for angle in [angle, 0.0, std::f64::consts::FRAC_PI_2, -std::f64::consts::PI] {
                let direction = geometry::Se2::new(0.0, 0.0, angle).heading();
                let ray = Ray { origin: Vec2::new(0.3, -0.2), direction };
                let found = check_no_repeats(neighbours.along(&ray, range).collect())?;
                for (i, there) in positions.iter().enumerate() {
                    let along = (there - ray.origin).dot(&direction).clamp(0.0, range);
                    let off = (there - ray.origin - along * direction).norm();
                    prop_assert!(off > 0.4 || found.contains(&i), "{there} {angle} {range}");
                }
            }
        }

        #[test]
        fn a_rebuild_is_as_good_as_a_new_grid(first in positions(), shift in -2.0..2.0) {
            let second: Vec<Vec2> = first.iter().rev().map(|p| p.add_scalar(shift)).collect();
            let mut rebuilt = grid(&first);
            rebuilt.rebuild(second.iter().copied());
            prop_assert_eq!(rebuilt.entries, grid(&second).entries);
        }
    }
}
