//! How far a trajectory is from what is known: true poses, a reference, or measured relations.
//!
//! Source: R. Kümmerle et al. (2009), "On measuring the accuracy of SLAM algorithms", Autonomous
//! Robots 27, eq. (3) and (4): errors of relative poses, which no choice of frame can hide. For
//! trajectories the rigid motion that fits best is taken off first (S. Umeyama (1991), IEEE PAMI 13,
//! without the scale).

use geometry::{Se2, Vec2, wrap_to_pi};
use recordings::StampedPose;
use run_context::Stamp;

/// A measured pose of the robot at one time, seen from the robot at another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// The earlier or first moment.
    pub first: Stamp,
    /// The other moment.
    pub second: Stamp,
    /// Pose at `second` in the robot's frame at `first`.
    pub second_in_first: Se2,
}

/// Mean, spread and greatest of some errors.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Errors {
    /// How many were averaged.
    pub n: usize,
    /// Distance: mean, metres.
    pub mean_m: f64,
    /// Distance: standard deviation, metres.
    pub std_m: f64,
    /// Distance: root of the mean square, metres.
    pub rms_m: f64,
    /// Distance: greatest, metres.
    pub max_m: f64,
    /// Turn: mean of the absolute values, radians.
    pub mean_rad: f64,
    /// Turn: standard deviation, radians.
    pub std_rad: f64,
    /// Turn: greatest, radians.
    pub max_rad: f64,
}

/// Errors of relations, taken apart by how far in time the two moments are.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct RelationErrors {
    /// All relations with both moments in the trajectory.
    pub all: Errors,
    /// Moments at most `consecutive_s` apart.
    pub consecutive: Errors,
    /// The others: places that were visited again.
    pub revisiting: Errors,
    /// Relations with a moment outside the trajectory.
    pub n_outside: usize,
}

/// The pose at `stamp`, on the straight line between the neighbours in `trajectory` (in order of time).
///
/// `None` outside the trajectory, or where the neighbours are more than `gap_max_s` apart.
pub fn pose_at(trajectory: &[StampedPose], stamp: Stamp, gap_max_s: f64) -> Option<Se2> {
    let after = trajectory.partition_point(|p| p.stamp < stamp);
    let b = trajectory.get(after)?;
    if b.stamp == stamp {
        return Some(b.pose);
    }
    let a = trajectory.get(after.checked_sub(1)?)?;
    let gap_s = b.stamp.since(a.stamp).as_secs_f64();
    if gap_s > gap_max_s {
        return None;
    }
    let part = stamp.since(a.stamp).as_secs_f64() / gap_s;
    let step = a.pose.inverse().compose(b.pose).log();
    let part_way = geometry::Twist {
        dx_m: step.dx_m * part,
        dy_m: step.dy_m * part,
        dyaw_rad: step.dyaw_rad * part,
    };
    Some(a.pose.compose(Se2::exp(part_way)))
}

/// The rigid motion that brings `estimate` onto `truth` with the least squared distance of positions.
///
/// Pairs by index; the shorter one ends it. Fewer than two places: only the first pose is matched.
pub fn align(estimate: &[Se2], truth: &[Se2]) -> Se2 {
    let n = estimate.len().min(truth.len());
    if n == 0 {
        return Se2::IDENTITY;
    }
    let mean = |poses: &[Se2]| poses[..n].iter().map(|p| p.position()).sum::<Vec2>() / n as f64;
    let (mean_e, mean_t) = (mean(estimate), mean(truth));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (e, t) in estimate[..n].iter().zip(truth) {
        let (e, t) = (e.position() - mean_e, t.position() - mean_t);
        dot += e.dot(&t);
        cross += e.x * t.y - e.y * t.x;
    }
    if dot.hypot(cross) < 1e-9 {
        return truth[0].compose(estimate[0].inverse());
    }
    let turn = Se2::new(0.0, 0.0, cross.atan2(dot));
    let shift = mean_t - turn.rotate(mean_e);
    Se2::new(shift.x, shift.y, turn.yaw_rad)
}

/// Errors of `estimate` against `truth`, pair by pair, after [`align`].
pub fn absolute_errors(estimate: &[Se2], truth: &[Se2]) -> Errors {
    let truth_from_estimate = align(estimate, truth);
    let pairs = estimate.iter().zip(truth).map(|(e, t)| {
        let e = truth_from_estimate.compose(*e);
        ((e.position() - t.position()).norm(), wrap_to_pi(e.yaw_rad - t.yaw_rad).abs())
    });
    Errors::of(&pairs.collect::<Vec<_>>())
}

/// Errors of `trajectory` (in order of time) against measured relations.
///
/// Moments more than `gap_max_s` from the next pose on either side count as outside.
pub fn relation_errors(
    trajectory: &[StampedPose],
    relations: &[Relation],
    consecutive_s: f64,
    gap_max_s: f64,
) -> RelationErrors {
    let (mut near, mut far) = (Vec::new(), Vec::new());
    let mut n_outside = 0;
    for relation in relations {
        let first = pose_at(trajectory, relation.first, gap_max_s);
        let second = pose_at(trajectory, relation.second, gap_max_s);
        let (Some(first), Some(second)) = (first, second) else {
            n_outside += 1;
            continue;
        };
        let found = first.inverse().compose(second);
        let error = relation.second_in_first.inverse().compose(found);
        let apart_s = relation.second.as_secs_f64() - relation.first.as_secs_f64();
        let pair = (error.position().norm(), error.yaw_rad.abs());
        if apart_s.abs() <= consecutive_s { near.push(pair) } else { far.push(pair) }
    }
    let all: Vec<_> = near.iter().chain(&far).copied().collect();
    RelationErrors {
        all: Errors::of(&all),
        consecutive: Errors::of(&near),
        revisiting: Errors::of(&far),
        n_outside,
    }
}

impl Errors {
    /// Of pairs (distance in metres, absolute turn in radians).
    pub fn of(pairs: &[(f64, f64)]) -> Self {
        if pairs.is_empty() {
            return Self::default();
        }
        let n = pairs.len() as f64;
        let mean_m = pairs.iter().map(|p| p.0).sum::<f64>() / n;
        let mean_rad = pairs.iter().map(|p| p.1).sum::<f64>() / n;
        let std = |of: &dyn Fn(&(f64, f64)) -> f64| {
            (pairs.iter().map(|p| of(p).powi(2)).sum::<f64>() / n).sqrt()
        };
        Self {
            n: pairs.len(),
            mean_m,
            std_m: std(&|p| p.0 - mean_m),
            rms_m: std(&|p| p.0),
            max_m: pairs.iter().map(|p| p.0).fold(0.0, f64::max),
            mean_rad,
            std_rad: std(&|p| p.1 - mean_rad),
            max_rad: pairs.iter().map(|p| p.1).fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamped(nanos: u64, x: f64, y: f64, yaw: f64) -> StampedPose {
        StampedPose { stamp: Stamp::from_nanos(nanos), pose: Se2::new(x, y, yaw) }
    }

    #[test]
    fn a_moved_copy_has_no_error() {
        let truth: Vec<Se2> =
            (0..20).map(|i| Se2::new(f64::from(i), f64::from(i * i) * 0.1, 0.1)).collect();
        for motion in [Se2::new(3.0, -2.0, 2.5), Se2::new(-1.0, 7.0, -0.3)] {
            let moved: Vec<Se2> = truth.iter().map(|p| motion.compose(*p)).collect();
            let errors = absolute_errors(&moved, &truth);
            assert!(errors.max_m < 1e-9 && errors.max_rad < 1e-9, "{errors:?}");
        }
    }

    #[test]
    fn a_known_offset_is_found() {
        // Two of four points moved apart along y by ±0.1: the best fit leaves the mean at 0.1 of each.
        let truth = [0.0, 1.0, 2.0, 3.0].map(|x| Se2::new(x, 0.0, 0.0));
        let mut found = truth;
        found[0].y_m = 0.1;
        found[1].y_m = -0.1;
        found[2].y_m = -0.1;
        found[3].y_m = 0.1;
        let errors = absolute_errors(&found, &truth);
        assert!((errors.mean_m - 0.1).abs() < 1e-12, "{errors:?}");
        assert!(errors.std_m < 1e-12);
    }

    #[test]
    fn poses_between_stamps_lie_on_the_arc() {
        let quarter = std::f64::consts::FRAC_PI_2;
        // A quarter circle of radius 1 to the left.
        let path = [stamped(0, 0.0, 0.0, 0.0), stamped(1_000, 1.0, 1.0, quarter)];
        let half = pose_at(&path, Stamp::from_nanos(500), 1.0).unwrap();
        assert!((half.x_m - (quarter / 2.0).sin()).abs() < 1e-12);
        assert!((half.y_m - (1.0 - (quarter / 2.0).cos())).abs() < 1e-12);
        assert_eq!(pose_at(&path, Stamp::from_nanos(1_001), 1.0), None);
        assert_eq!(pose_at(&path, Stamp::from_nanos(500), 1e-7), None);
    }

    #[test]
    fn relations_are_told_apart_by_time() {
        let path = [
            stamped(0, 0.0, 0.0, 0.0),
            stamped(1_000_000_000, 1.0, 0.0, 0.0),
            stamped(100_000_000_000, 0.0, 0.3, 0.0),
        ];
        let near = Relation {
            first: Stamp::ZERO,
            second: Stamp::from_millis(1000),
            second_in_first: Se2::new(0.9, 0.0, 0.0),
        };
        let far = Relation {
            first: Stamp::ZERO,
            second: Stamp::from_millis(100_000),
            second_in_first: Se2::new(0.0, 0.0, 0.2),
        };
        let outside = Relation { second: Stamp::from_millis(200_000), ..near };
        let errors = relation_errors(&path, &[near, far, outside], 5.0, 1000.0);
        assert_eq!((errors.all.n, errors.n_outside), (2, 1));
        assert!((errors.consecutive.mean_m - 0.1).abs() < 1e-12);
        assert!((errors.revisiting.mean_m - 0.3).abs() < 1e-12);
        assert!((errors.revisiting.mean_rad - 0.2).abs() < 1e-12);
    }
}
