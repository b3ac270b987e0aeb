//! Where the way goes on behind an obstacle.

use geometry::Vec2;

use super::{hazards::Hazards, scene::Scene};
use crate::{how::PREVIEW_STEP_M, phase::Phase};

/// Distances behind an obstacle at which the trail is taken up again, metres, first to last.
const REJOIN_FROM_M: f64 = 0.8;
const REJOIN_TO_M: f64 = 3.2;

/// Targets offered to the search for a detour.
pub(crate) const N_TARGETS_MAX: usize = 12;

/// Where the way may be taken up again behind what is ahead (m, map).
pub(crate) fn targets_behind(
    resume: Phase,
    target: Option<Vec2>,
    scene: Scene<'_>,
    targets: &mut [Vec2; N_TARGETS_MAX],
) -> usize {
    let mut n_targets = 0;
    let mut offer = |point: Vec2| {
        if let Some(slot) = targets.get_mut(n_targets) {
            *slot = point;
            n_targets += 1;
        }
    };
    let goal = scene.situation.goal_point();
    if resume == Phase::FollowTrail {
        let hit_m = Hazards::first_thing_m(scene);
        let hit_m = hit_m.unwrap_or(0.7).min(1.3);
        let first = ((hit_m + REJOIN_FROM_M) / PREVIEW_STEP_M) as usize;
        let last = ((hit_m + REJOIN_TO_M) / PREVIEW_STEP_M) as usize;
        for k in (first..=last).step_by(3) {
            if let Some(point) = scene.points.get(k) {
                offer(*point);
            }
        }
        let on_preview =
            goal.is_some_and(|g| scene.points.last().is_some_and(|p| (p - g).norm() < 1.0));
        if let Some(goal) = goal.filter(|_| on_preview) {
            offer(goal);
        }
    } else if resume == Phase::Approach {
        goal.into_iter().for_each(&mut offer);
    } else if let Some(target) = target {
        // The direct method: somewhere on the line to the target, or the target itself.
        let position = scene.situation.at.position();
        let way = target - position;
        let length_m = way.norm();
        for k in 0..8 {
            let ahead_m = 1.2 + 0.3 * f64::from(k);
            if ahead_m < length_m {
                offer(position + way * (ahead_m / length_m));
            }
        }
        offer(target);
    }
    n_targets
}
