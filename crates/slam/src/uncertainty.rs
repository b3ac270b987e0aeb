//! How uncertain one keyframe is, seen from another: covariances carried along the graph.
//!
//! The covariance along one path of the graph is an upper bound of that in the whole graph, since more
//! edges can only add information. The path is the one with the least covariance.
//!
//! Source: M. Bosse et al. (2004), "Simultaneous localization and map building in large-scale cyclic
//! environments using the Atlas framework", IJRR 23(12), the Dijkstra projection. Covariances are of
//! right perturbations, T = T̄ exp(ξ): T₁T₂ has Ad(T₂⁻¹) Σ₁ Ad(T₂⁻¹)ᵀ + Σ₂, and T⁻¹ has
//! Ad(T) Σ Ad(T)ᵀ (Solà, Deray, Atchuthan 2018, arXiv:1812.01537, section III).

use std::{cmp::Reverse, collections::BinaryHeap};

use geometry::Se2;
use nalgebra::{Matrix3, Rotation2};

/// A radian counts like so many metres when paths are compared.
const LEVER_M: f64 = 5.0;

/// Neighbours in the graph with the covariance of the pose between.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links {
    of: Vec<Vec<Link>>,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    to: usize,
    /// Of the pose of `to` in this one's frame.
    covariance: Matrix3<f64>,
}

impl Links {
    /// A keyframe without neighbours.
    pub(crate) fn add_vertex(&mut self) {
        self.of.push(Vec::new());
    }

    /// Ties two keyframes; `covariance` is that of `from_from_to`.
    pub(crate) fn add(
        &mut self,
        from: usize,
        to: usize,
        from_from_to: Se2,
        covariance: Matrix3<f64>,
    ) {
        self.of[from].push(Link { to, covariance });
        let a = adjoint(from_from_to);
        self.of[to].push(Link { to: from, covariance: a * covariance * a.transpose() });
    }

    /// For each keyframe, the covariance of its pose seen from `start`, along the least uncertain path.
    ///
    /// Keyframes that no path reaches have `None`. Cost: n log n in the number of keyframes.
    pub(crate) fn seen_from(&self, start: usize, poses: &[Se2]) -> Vec<Option<Matrix3<f64>>> {
        let mut settled: Vec<Option<Matrix3<f64>>> = vec![None; self.of.len()];
        let mut open = BinaryHeap::new();
        let mut best = vec![f64::INFINITY; self.of.len()];
        let mut waiting = vec![Matrix3::zeros(); self.of.len()];
        best[start] = 0.0;
        open.push(Reverse((Cost(0.0), start)));
        while let Some(Reverse((Cost(cost), at))) = open.pop() {
            if settled[at].is_some() || cost > best[at] {
                continue;
            }
            settled[at] = Some(waiting[at]);
            for link in &self.of[at] {
                if settled[link.to].is_some() {
                    continue;
                }
                let to_from_at = poses[link.to].inverse().compose(poses[at]);
                let a = adjoint(to_from_at);
                let covariance = a * waiting[at] * a.transpose() + link.covariance;
                let cost = covariance[(0, 0)]
                    + covariance[(1, 1)]
                    + LEVER_M * LEVER_M * covariance[(2, 2)];
                if cost < best[link.to] {
                    best[link.to] = cost;
                    waiting[link.to] = covariance;
                    open.push(Reverse((Cost(cost), link.to)));
                }
            }
        }
        settled
    }
}

/// Turns a perturbation on the right of a pose into the one on its left that does the same.
pub(crate) fn adjoint(pose: Se2) -> Matrix3<f64> {
    let (s, c) = pose.yaw_rad.sin_cos();
    Matrix3::new(c, -s, pose.y_m, s, c, -pose.x_m, 0.0, 0.0, 1.0)
}

/// The information of a pose in the map's axes, turned into that of a perturbation on its right.
pub(crate) fn in_own_axes(information: &Matrix3<f64>, pose: Se2) -> Matrix3<f64> {
    let mut turn = Matrix3::identity();
    turn.fixed_view_mut::<2, 2>(0, 0).copy_from(Rotation2::new(pose.yaw_rad).matrix());
    turn.transpose() * information * turn
}

/// A finite cost, for the heap.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Twist;
    use nalgebra::Vector3;

    fn exp(v: Vector3<f64>) -> Se2 {
        Se2::exp(Twist { dx_m: v.x, dy_m: v.y, dyaw_rad: v.z })
    }

    #[test]
    fn the_adjoint_moves_a_perturbation_to_the_other_side() {
        for pose in [Se2::new(2.0, -1.0, 0.7), Se2::new(-3.0, 0.5, -2.0), Se2::IDENTITY] {
            for axis in 0..3 {
                let mut small = Vector3::zeros();
                small[axis] = 1e-6;
                let right = pose.compose(exp(small));
                let left = exp(adjoint(pose) * small).compose(pose);
                assert!((right.position() - left.position()).norm() < 1e-10);
                assert!((right.yaw_rad - left.yaw_rad).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn a_chain_of_turns_spreads_sideways_with_its_length() {
        // 10 steps of 1 m ahead, only the yaw uncertain: the end's variance across is Σ (kσ)² for
        // the k metres that each turn moves, by hand; along it is nothing.
        let std = 0.01;
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, std * std));
        let (mut links, mut poses) = (Links::default(), Vec::new());
        for i in 0..=10 {
            links.add_vertex();
            poses.push(Se2::new(f64::from(i), 0.0, 0.0));
            if i > 0 {
                let i = i as usize;
                links.add(i - 1, i, Se2::new(1.0, 0.0, 0.0), covariance);
            }
        }
        let seen = links.seen_from(0, &poses)[10].unwrap();
        let expected: f64 = (0..10).map(|k| (f64::from(k) * std).powi(2)).sum();
        assert!((seen[(1, 1)] - expected).abs() < 1e-12, "{seen}");
        assert!(seen[(0, 0)].abs() < 1e-15);
        assert!((seen[(2, 2)] - 10.0 * std * std).abs() < 1e-12);
        // Seen from the other end: the same in yaw, and every step's own end counts, 1 to 10 m.
        let back = links.seen_from(10, &poses)[0].unwrap();
        let expected: f64 = (1..=10).map(|k| (f64::from(k) * std).powi(2)).sum();
        assert!((back[(1, 1)] - expected).abs() < 1e-12, "{back}");
    }

    #[test]
    fn the_surer_way_is_taken_and_islands_have_none() {
        let sure = Matrix3::identity() * 1e-4;
        let vague = Matrix3::identity() * 1e-1;
        let poses = [Se2::IDENTITY; 4];
        let mut links = Links::default();
        for _ in 0..4 {
            links.add_vertex();
        }
        links.add(0, 2, Se2::IDENTITY, vague);
        links.add(0, 1, Se2::IDENTITY, sure);
        links.add(1, 2, Se2::IDENTITY, sure);
        let seen = links.seen_from(0, &poses);
        assert!((seen[2].unwrap()[(0, 0)] - 2e-4).abs() < 1e-15);
        assert_eq!(seen[3], None);
        assert_eq!(seen[0], Some(Matrix3::zeros()));
    }

    #[test]
    fn information_turns_with_the_pose() {
        let information = Matrix3::from_diagonal(&Vector3::new(4.0, 1.0, 9.0));
        let own = in_own_axes(&information, Se2::new(5.0, 6.0, std::f64::consts::FRAC_PI_2));
        // Turned left by 90°, the map's x is to the right: what was known along x is known along -y.
        assert!((own - Matrix3::from_diagonal(&Vector3::new(1.0, 4.0, 9.0))).norm() < 1e-12);
    }
}
