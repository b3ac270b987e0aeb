//! What an outline sweeps on an arc: how far the robot gets until it touches something that was heard.
//!
//! A robot that holds two wheel speeds turns about one fixed point. Seen from the robot, everything else
//! turns about that point the other way, so each echo runs along a circle, and where the circle meets an
//! edge of the outline the robot touches it. Exact, without steps.

use geometry::{Se2, Vec2};

use crate::{EchoMemory, Footprint};

/// Arcs that are flatter than this count as so flat, 1/m: over a metre they leave the straight line by 0.05 mm.
const CURVATURE_MIN_PER_M: f64 = 1e-4;

/// A motion with constant wheel speeds, as far as its shape goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Curvature, 1/m, positive to the left of a robot that looks along its heading.
    pub curvature_per_m: f64,
    /// Whether it is driven backwards.
    pub backwards: bool,
}

impl Arc {
    /// Where a robot that begins at `from` is after so many metres of way.
    pub fn pose_after(&self, from: Se2, way_m: f64) -> Se2 {
        let dx_m = if self.backwards { -way_m } else { way_m };
        let dyaw_rad = self.curvature_per_m * dx_m;
        from.compose(Se2::exp(geometry::Twist { dx_m, dy_m: 0.0, dyaw_rad }))
    }

    /// The arc with a curvature that has a centre.
    fn bent(self) -> Self {
        let size_per_m = self.curvature_per_m.abs().max(CURVATURE_MIN_PER_M);
        Self { curvature_per_m: size_per_m.copysign(self.curvature_per_m), ..self }
    }
}

/// An outline with a margin around it that a robot keeps where it has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hull {
    /// From the widest, which has the whole margin, to the bare outline.
    shells: [Footprint; N_SHELLS],
}

/// An echo inside a shell is judged by the next one: who stands nearer to a post than the margin may
/// still drive past it.
const N_SHELLS: usize = 3;

impl Hull {
    /// A hull that keeps `margin_m` (≥ 0) from what was heard.
    pub fn new(footprint: &Footprint, margin_m: f64) -> Self {
        let shell = |k: usize| footprint.grown(margin_m * k as f64 / (N_SHELLS - 1) as f64);
        Self { shells: std::array::from_fn(|k| shell(N_SHELLS - 1 - k)) }
    }

    /// The way (m) on an arc from a robot's pose until it meets a point (m, base frame), within `way_max_m`;
    /// `None` when it does not. O(corners).
    ///
    /// A point inside the bare outline is met at once where the outline moves towards it, and not at all
    /// where it moves away.
    pub fn way_to_m(&self, in_base: Vec2, arc: Arc, way_max_m: f64) -> Option<f64> {
        let shell = self.shells.iter().find(|shell| shell.depth_m(in_base) < 0.0);
        match shell {
            Some(shell) => shell.way_to_m(in_base, arc).filter(|way_m| *way_m <= way_max_m),
            None => self.shells[N_SHELLS - 1].presses_on(in_base, arc).then_some(0.0),
        }
    }

    /// No point farther than this from the axle is met within `way_m`.
    fn reach_m(&self, way_m: f64) -> f64 {
        self.shells[0].turning_radius_m() + way_m
    }
}

impl EchoMemory {
    /// The way (m) that is free of all remembered echoes when an outline drives along an arc from `pose`, at
    /// most `way_max_m`. O(echoes × corners), no allocation.
    pub fn free_way_m(&self, pose: Se2, arc: Arc, way_max_m: f64, hull: &Hull) -> f64 {
        let reach_m = hull.reach_m(way_max_m);
        let to_base = pose.inverse();
        let mut free_m = way_max_m;
        for at in self.points() {
            if (at - pose.position()).norm_squared() < reach_m * reach_m
                && let Some(way_m) = hull.way_to_m(to_base.transform_point(at), arc, free_m)
            {
                free_m = way_m;
            }
        }
        free_m
    }
}

impl Footprint {
    /// The way (m) on an arc until this outline meets a point outside of it (m, base frame).
    fn way_to_m(&self, in_base: Vec2, arc: Arc) -> Option<f64> {
        let arc = arc.bent();
        let centre = Vec2::new(0.0, 1.0 / arc.curvature_per_m);
        let from = in_base - centre;
        // Seen from the robot the point turns the other way.
        let turns_left = (arc.curvature_per_m > 0.0) == arc.backwards;
        let side = if turns_left { 1.0 } else { -1.0 };
        let mut least_rad = f64::INFINITY;
        for (a, b) in self.edges() {
            let (a, along) = (a - centre, b - a);
            // |a + t along|² = |from|²
            let half = a.dot(&along) / along.norm_squared();
            let square =
                half * half - (a.norm_squared() - from.norm_squared()) / along.norm_squared();
            if square < 0.0 {
                continue;
            }
            for t in [-half - square.sqrt(), -half + square.sqrt()] {
                if (0.0..=1.0).contains(&t) {
                    let met = a + along * t;
                    let turn_rad = side * from.perp(&met).atan2(from.dot(&met));
                    let turn_rad =
                        if turn_rad < 0.0 { turn_rad + std::f64::consts::TAU } else { turn_rad };
                    least_rad = least_rad.min(turn_rad);
                }
            }
        }
        least_rad.is_finite().then(|| least_rad / arc.curvature_per_m.abs())
    }

    /// Whether the edge that is nearest to a point inside (m, base frame) moves towards it on an arc.
    fn presses_on(&self, in_base: Vec2, arc: Arc) -> bool {
        let sense = if arc.backwards { -1.0 } else { 1.0 };
        // Velocity of the robot's point there, for a unit of speed.
        let turn = arc.curvature_per_m;
        let velocity = Vec2::new(1.0 - turn * in_base.y, turn * in_base.x) * sense;
        let outward = |(a, b): (Vec2, Vec2)| {
            let along = (b - a).normalize();
            (along.perp(&(in_base - a)), Vec2::new(along.y, -along.x))
        };
        let nearest = self.edges().map(outward).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.is_some_and(|(_, normal)| normal.dot(&velocity) > 0.0)
    }

    /// The outline with all its edges moved outwards by `margin_m` (≥ 0).
    #[must_use]
    pub fn grown(&self, margin_m: f64) -> Self {
        let corners = self.corners();
        let n = corners.len();
        let normal = |a: Vec2, b: Vec2| {
            let along = (b - a).normalize();
            Vec2::new(along.y, -along.x)
        };
        let mut grown = *self;
        for (i, corner) in grown.corners_mut().iter_mut().enumerate() {
            let before = normal(corners[(i + n - 1) % n], corners[i]);
            let after = normal(corners[i], corners[(i + 1) % n]);
            // Where the two moved edges meet; corners are convex, so the divisor is above 0.
            *corner += (before + after) * (margin_m / (1.0 + before.dot(&after)).max(0.1));
        }
        grown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EchoMemoryConfig, RangeSensor};
    use run_context::{RunSeed, Stamp};

    fn pioneer() -> Footprint {
        Footprint::rectangle(0.21, 0.301, 0.2125).unwrap()
    }

    fn ahead(curvature_per_m: f64) -> Arc {
        Arc { curvature_per_m, backwards: false }
    }

    /// Drives the outline in steps of 0.1 mm until the point is inside.
    fn way_by_steps_m(outline: &Footprint, point: Vec2, arc: Arc, way_max_m: f64) -> Option<f64> {
        (0..=(way_max_m / 1e-4) as u32).map(|k| 1e-4 * f64::from(k)).find(|way_m| {
            let pose = arc.pose_after(Se2::IDENTITY, *way_m);
            outline.depth_m(pose.inverse().transform_point(point)) >= 0.0
        })
    }

    #[test]
    fn the_way_is_the_one_that_small_steps_find() {
        use proptest::prelude::Rng;
        let mut rng = RunSeed(7).stream("sweep");
        let mut uniform =
            |from: f64, to: f64| from + (to - from) * (rng.next_u64() as f64 / u64::MAX as f64);
        let octagon: Vec<Vec2> = (0..8)
            .map(|k| {
                let angle_rad = std::f64::consts::FRAC_PI_4 * f64::from(k) + 0.2;
                Vec2::new(0.3 * angle_rad.cos(), 0.25 * angle_rad.sin())
            })
            .collect();
        let outlines = [pioneer(), Footprint::new(&octagon).unwrap()];
        let (mut n_met, mut n_free) = (0, 0);
        for k in 0..600 {
            let outline = outlines[k % 2];
            let point = Vec2::new(uniform(-0.9, 1.2), uniform(-0.9, 0.9));
            let curvature_per_m = if k % 5 == 0 { 0.0 } else { uniform(-4.0, 4.0) };
            let arc = Arc { curvature_per_m, backwards: k % 3 == 0 };
            if outline.depth_m(point) >= 0.0 {
                continue;
            }
            let found = Hull::new(&outline, 0.0).way_to_m(point, arc, 0.8);
            let stepped = way_by_steps_m(&outline, point, arc, 0.8);
            match (found, stepped) {
                (Some(found), Some(stepped)) => {
                    assert!((found - stepped).abs() < 2e-4, "{point} {arc:?}: {found} {stepped}");
                    n_met += 1;
                }
                (None, None) => n_free += 1,
                // A corner that grazes the point between two steps, or the end of the way.
                (Some(found), None) => {
                    let pose = arc.pose_after(Se2::IDENTITY, found);
                    let depth_m = outline.depth_m(pose.inverse().transform_point(point));
                    assert!(depth_m > -1e-4, "{point} {arc:?}: {found}, {depth_m} deep");
                }
                (None, Some(stepped)) => panic!("{point} {arc:?}: not met, but after {stepped} m"),
            }
        }
        assert!(n_met > 40 && n_free > 100, "{n_met} {n_free}");
    }

    #[test]
    fn straight_on_a_thing_ahead_is_met_by_the_nose_and_one_beside_is_not() {
        let hull = Hull::new(&pioneer(), 0.04);
        let way_to = |x, y| hull.way_to_m(Vec2::new(x, y), ahead(0.0), 1.0);
        assert!((way_to(0.75, 0.0).unwrap() - 0.5).abs() < 1e-4, "0.75 − 0.21 − 0.04");
        assert_eq!(way_to(0.75, 0.2526), None);
        assert!(way_to(0.75, 0.252).is_some());
        assert_eq!(way_to(-0.75, 0.0), None, "behind");
        let back = Arc { curvature_per_m: 0.0, backwards: true };
        let behind_m = hull.way_to_m(Vec2::new(-0.75, 0.0), back, 1.0).unwrap();
        assert!((behind_m - (0.75 - 0.301 - 0.04)).abs() < 1e-4);
        assert_eq!(hull.way_to_m(Vec2::new(1.3, 0.0), ahead(0.0), 1.0), None, "too far");
    }

    /// Beside the robot and nearer than the margin: straight past it is allowed, turning into it is not.
    #[test]
    fn a_post_within_the_margin_may_be_passed() {
        let hull = Hull::new(&pioneer(), 0.04);
        let post = Vec2::new(0.0, 0.2125 + 0.01);
        assert_eq!(hull.way_to_m(post, ahead(0.0), 1.0), None);
        // To the right the tail swings out to the left, where the post is.
        let into_m = hull.way_to_m(post, ahead(-2.0), 1.0).unwrap();
        assert!((0.0..0.1).contains(&into_m), "{into_m}");
    }

    #[test]
    fn what_is_inside_stops_only_who_moves_towards_it() {
        let hull = Hull::new(&pioneer(), 0.04);
        let at_nose = Vec2::new(0.205, 0.0);
        let back = Arc { curvature_per_m: 0.0, backwards: true };
        assert_eq!(hull.way_to_m(at_nose, ahead(0.0), 1.0), Some(0.0));
        assert_eq!(hull.way_to_m(at_nose, back, 1.0), None);
        let at_front_corner = Vec2::new(0.18, 0.21);
        assert_eq!(hull.way_to_m(at_front_corner, ahead(2.0), 1.0), Some(0.0));
        assert_eq!(hull.way_to_m(at_front_corner, ahead(-2.0), 1.0), None);
    }

    #[test]
    fn an_outline_grows_by_its_margin_on_every_side() {
        let grown = pioneer().grown(0.05);
        let expected = Footprint::rectangle(0.26, 0.351, 0.2625).unwrap();
        let gaps = grown.corners().iter().zip(expected.corners()).map(|(a, b)| (a - b).norm());
        assert!(gaps.fold(0.0, f64::max) < 1e-12);
        let bevelled =
            [(0.2, -0.1), (0.2, 0.1), (0.1, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.1, -0.2)]
                .map(|(x, y)| Vec2::new(x, y));
        let bevelled = Footprint::new(&bevelled).unwrap();
        let grown = bevelled.grown(0.05);
        for (before, after) in bevelled.edges().zip(grown.edges()) {
            let middle = (after.0 + after.1) / 2.0;
            let along = (before.1 - before.0).normalize();
            assert!((along.perp(&(middle - before.0)) + 0.05).abs() < 1e-12);
        }
    }

    #[test]
    fn the_nearest_of_many_echoes_ends_the_free_way() {
        let mut memory = EchoMemory::new(EchoMemoryConfig::default());
        let sensor = RangeSensor { in_base: Vec2::zeros(), bearing_rad: 0.0 };
        for (k, range_m) in [1.5, 1.2, 0.9].into_iter().enumerate() {
            memory.observe(Stamp::from_millis(k as u64), Se2::IDENTITY, &[sensor], &[range_m], 1);
        }
        let hull = Hull::new(&pioneer(), 0.0);
        let free_m = |pose| memory.free_way_m(pose, ahead(0.0), 0.75, &hull);
        assert!((free_m(Se2::IDENTITY) - 0.69).abs() < 1e-6);
        assert!(
            (free_m(Se2::new(-0.2, 0.0, 0.0)) - 0.75).abs() < 1e-12,
            "beyond the way asked for"
        );
        assert!((free_m(Se2::new(0.9, -0.6, 1.57)) - 0.39).abs() < 1e-3);
        let memory = EchoMemory::new(EchoMemoryConfig::default());
        assert!((memory.free_way_m(Se2::IDENTITY, ahead(1.0), 0.75, &hull) - 0.75).abs() < 1e-12);
    }
}
