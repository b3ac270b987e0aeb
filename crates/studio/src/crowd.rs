//! From how many robots on they are a crowd.

use missions::Scene;

/// With more robots than this, only the first is told in full.
const N_ROBOTS_IN_FULL_MAX: usize = 12;

/// How many robots are told in full; the others are a crowd of poses.
pub(crate) fn n_robots_in_full(scene: &Scene) -> usize {
    let n_robots = scene.robots.len();
    if n_robots > N_ROBOTS_IN_FULL_MAX { 1 } else { n_robots }
}
