//! The outline of the robot: what must not touch anything.

use geometry::{Se2, Vec2};

/// Corners that an outline may have.
const N_CORNERS_MAX: usize = 12;

/// A convex outline in the base frame, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    corners: [Vec2; N_CORNERS_MAX],
    n_corners: usize,
}

impl Footprint {
    /// An outline from its corners (m, base frame), convex, counter-clockwise, 3 to 12 of them;
    /// `None` otherwise.
    pub fn new(corners: &[Vec2]) -> Option<Self> {
        if !(3..=N_CORNERS_MAX).contains(&corners.len()) {
            return None;
        }
        let n_corners = corners.len();
        let convex = (0..n_corners).all(|i| {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % n_corners]);
            // Written so that corners that are no numbers fail.
            (b - a).perp(&(c - b)) >= 0.0
        });
        let mut own = [Vec2::zeros(); N_CORNERS_MAX];
        own[..n_corners].copy_from_slice(corners);
        let outline = Self { corners: own, n_corners };
        let around_axle = outline.depth_m(Vec2::zeros()) > 0.0;
        (convex && around_axle).then_some(outline)
    }

    /// A rectangle from `-rear_m` to `front_m` and `half_width_m` to either side (m, all above 0).
    pub fn rectangle(front_m: f64, rear_m: f64, half_width_m: f64) -> Option<Self> {
        let (f, r, w) = (front_m, -rear_m, half_width_m);
        Self::new(&[Vec2::new(f, -w), Vec2::new(f, w), Vec2::new(r, w), Vec2::new(r, -w)])
    }

    /// The corners (m, base frame).
    pub fn corners(&self) -> &[Vec2] {
        &self.corners[..self.n_corners]
    }

    pub(crate) fn corners_mut(&mut self) -> &mut [Vec2] {
        &mut self.corners[..self.n_corners]
    }

    /// From the axle to the front, metres.
    pub fn front_m(&self) -> f64 {
        self.corners().iter().map(|c| c.x).fold(0.0, f64::max)
    }

    /// From the middle to the side that reaches further, metres.
    pub fn half_width_m(&self) -> f64 {
        self.corners().iter().map(|c| c.y.abs()).fold(0.0, f64::max)
    }

    /// The radius (m) that the outline sweeps when the robot turns in place all the way round.
    pub fn turning_radius_m(&self) -> f64 {
        self.corners().iter().map(Vec2::norm).fold(0.0, f64::max)
    }

    /// Distance (m) from the outline to a point (m, base frame); 0 inside. O(corners).
    pub fn distance_m(&self, in_base: Vec2) -> f64 {
        if self.depth_m(in_base) >= 0.0 {
            return 0.0;
        }
        let to_edge = |(a, b)| distance_to_segment_m(in_base, a, b);
        self.edges().map(to_edge).fold(f64::INFINITY, f64::min)
    }

    /// How deep (m) a point (m, base frame) lies inside the outline; negative outside.
    pub fn depth_m(&self, in_base: Vec2) -> f64 {
        let depth = |(a, b): (Vec2, Vec2)| (b - a).normalize().perp(&(in_base - a));
        self.edges().map(depth).fold(f64::INFINITY, f64::min)
    }

    /// Least distance (m) to a point (m, in the pose's outer frame) while turning in place by
    /// `turn_rad` (signed, not wrapped), starting at `pose`.
    ///
    /// Exact at steps of at most 5°; between them the outline moves under 33 mm.
    pub fn distance_while_turning_m(&self, pose: Se2, turn_rad: f64, point: Vec2) -> f64 {
        let n_steps = (turn_rad.abs() / 5.0_f64.to_radians()).ceil().max(1.0);
        let from_start = Se2::new(0.0, 0.0, -pose.yaw_rad).rotate(point - pose.position());
        let mut least_m = f64::INFINITY;
        for step in 0..=(n_steps as u32) {
            let (s, c) = (-turn_rad * f64::from(step) / n_steps).sin_cos();
            let p =
                Vec2::new(c * from_start.x - s * from_start.y, s * from_start.x + c * from_start.y);
            least_m = least_m.min(self.distance_m(p));
        }
        least_m
    }

    pub(crate) fn edges(&self) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
        let corners = self.corners();
        (0..corners.len()).map(move |i| (corners[i], corners[(i + 1) % corners.len()]))
    }
}

/// Distance (m) from a point to a segment, which may be a point itself.
pub(crate) fn distance_to_segment_m(point: Vec2, from: Vec2, to: Vec2) -> f64 {
    let along = to - from;
    let length2 = along.norm_squared();
    let share =
        if length2 > 0.0 { ((point - from).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (point - from - along * share).norm()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    fn pioneer() -> Footprint {
        Footprint::rectangle(0.21, 0.301, 0.2125).unwrap()
    }

    #[test]
    fn distances_to_a_rectangle_are_those_of_school() {
        let outline = pioneer();
        assert_eq!(outline.distance_m(Vec2::new(0.0, 0.0)), 0.0);
        assert!((outline.distance_m(Vec2::new(0.31, 0.0)) - 0.1).abs() < 1e-12);
        assert!((outline.distance_m(Vec2::new(-0.401, 0.1)) - 0.1).abs() < 1e-12);
        assert!((outline.distance_m(Vec2::new(0.0, -0.3125)) - 0.1).abs() < 1e-12);
        assert!((outline.distance_m(Vec2::new(0.24, 0.2525)) - 0.05).abs() < 1e-12);
        assert!((outline.depth_m(Vec2::new(0.2, 0.0)) - 0.01).abs() < 1e-12);
        assert!((outline.depth_m(Vec2::new(0.0, 0.3125)) + 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_rear_corner_reaches_a_wall_that_the_side_does_not() {
        // A point beside the robot, 0.3 m from its axle: free when standing, hit when turning.
        let (outline, beside) = (pioneer(), Vec2::new(-0.05, 0.30));
        assert!(outline.distance_m(beside) > 0.08);
        let turn = -50.0_f64.to_radians();
        assert!(outline.distance_while_turning_m(Se2::IDENTITY, turn, beside) < 0.001);
        // The other way round the corner moves away from it.
        assert!(outline.distance_while_turning_m(Se2::IDENTITY, 0.3, beside) > 0.04);
        assert!((outline.turning_radius_m() - 0.3684).abs() < 1e-4);
    }

    #[test]
    fn a_full_turn_sees_a_point_as_the_turning_circle_does() {
        let outline = pioneer();
        for k in 0..12 {
            let angle = f64::from(k) * 0.5;
            let point = Vec2::new(0.5 * angle.cos() + 1.0, 0.5 * angle.sin() - 2.0);
            let pose = Se2::new(1.0, -2.0, 0.7);
            let least = outline.distance_while_turning_m(pose, std::f64::consts::TAU, point);
            assert!((least - (0.5 - outline.turning_radius_m())).abs() < 2e-3, "{least}");
        }
    }

    #[test]
    fn what_is_no_outline_is_refused() {
        let points = |list: &[(f64, f64)]| -> Vec<Vec2> {
            list.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
        };
        assert!(Footprint::new(&points(&[(1.0, 0.0), (0.0, 1.0)])).is_none());
        let clockwise = points(&[(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]);
        assert!(Footprint::new(&clockwise).is_none());
        let dented = points(&[(1.0, -1.0), (0.2, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]);
        assert!(Footprint::new(&dented).is_none());
        assert!(Footprint::rectangle(-0.1, 0.3, 0.2).is_none());
        assert!(Footprint::rectangle(f64::NAN, 0.3, 0.2).is_none());
    }
}
