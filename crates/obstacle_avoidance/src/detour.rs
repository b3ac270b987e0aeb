//! A detour that has been checked against what was heard: one via-point beside an obstacle.
//!
//! The rebound (6.3) says which side is freer; it does not say how far to go, nor whether the
//! robot fits. This searches a small fan of via-points for two straight legs, pose to via and via to
//! one of some targets behind the obstacle, that stay clear of all remembered echoes, and takes the
//! one nearest to the rebound's heading among the short ones. An extension of ours.

use geometry::{Se2, Vec2, wrap_to_pi};

use crate::{EchoMemory, Footprint};

/// Settings of [`find_detour`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetourConfig {
    /// What must stay free beside the robot on a leg, metres.
    pub margin_m: f64,
    /// What must stay free while turning in place, metres.
    pub turn_margin_m: f64,
    /// How deep an echo is taken to be, metres.
    pub depth_m: f64,
    /// Shortest and longest distance to a via-point, metres.
    pub leg_m: (f64, f64),
    /// Greatest turn towards a via-point, radians.
    pub turn_max_rad: f64,
    /// Price of deviating from the preferred heading, metres per radian.
    pub deviation_price_m_per_rad: f64,
    /// A leg with this much room beside the robot costs nothing extra, metres.
    pub comfort_m: f64,
    /// Price of room that lacks to comfort, metres per metre.
    pub comfort_price_ratio: f64,
}

impl Default for DetourConfig {
    fn default() -> Self {
        Self {
            margin_m: 0.10,
            turn_margin_m: 0.04,
            depth_m: 0.4,
            leg_m: (0.25, 1.45),
            turn_max_rad: 105.0_f64.to_radians(),
            deviation_price_m_per_rad: 0.25,
            comfort_m: 0.3,
            comfort_price_ratio: 3.0,
        }
    }
}

/// A way around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detour {
    /// Where to drive first (m); `None` when the target can be driven to directly.
    pub via: Option<Vec2>,
    /// Which of the targets comes after it.
    pub target_index: usize,
    /// Length and prices together, metres.
    pub cost_m: f64,
}

/// Headings tried to either side.
const N_HEADINGS: i32 = 14;
/// Leg lengths tried per heading.
const N_LENGTHS: i32 = 7;

/// The cheapest checked way from `pose` to one of `targets` (m, same frame), or `None`.
///
/// `heading_preferred_rad` is the rebound's heading. Ties go to the first found, left before right.
/// O(via-points × targets × echoes) in the worst case; no allocation.
pub fn find_detour(
    echoes: &EchoMemory,
    footprint: &Footprint,
    pose: Se2,
    heading_preferred_rad: f64,
    targets: &[Vec2],
    config: &DetourConfig,
) -> Option<Detour> {
    let mut search = Search { echoes, footprint, config, targets, best: None };
    search.try_targets(pose, None, 0.0);
    let (shortest, longest) = config.leg_m;
    for step in 0..=N_HEADINGS {
        for side in [1.0, -1.0] {
            let turn_rad = side * config.turn_max_rad * f64::from(step) / f64::from(N_HEADINGS);
            if search.turn_is_free(pose, turn_rad) {
                let heading = Se2::new(pose.x_m, pose.y_m, pose.yaw_rad + turn_rad);
                let deviation = wrap_to_pi(heading.yaw_rad - heading_preferred_rad).abs();
                let price = config.deviation_price_m_per_rad * deviation;
                for k in 0..N_LENGTHS {
                    let leg_m =
                        shortest + (longest - shortest) * f64::from(k) / f64::from(N_LENGTHS - 1);
                    let via = pose.position() + heading.heading() * leg_m;
                    let Some(squeeze_m) = search.price_of_leg(pose.position(), via, 0.0) else {
                        break;
                    };
                    let at_via = Se2::new(via.x, via.y, heading.yaw_rad);
                    search.try_targets(at_via, Some(via), leg_m + price + squeeze_m);
                }
            }
        }
    }
    search.best
}

struct Search<'a> {
    echoes: &'a EchoMemory,
    footprint: &'a Footprint,
    config: &'a DetourConfig,
    targets: &'a [Vec2],
    best: Option<Detour>,
}

impl Search<'_> {
    fn try_targets(&mut self, from: Se2, via: Option<Vec2>, spent_m: f64) {
        for (target_index, target) in self.targets.iter().enumerate() {
            let leg = target - from.position();
            let cost_m = spent_m + leg.norm();
            if self.best.is_some_and(|b| b.cost_m <= cost_m) {
                continue;
            }
            let turn_rad = wrap_to_pi(leg.y.atan2(leg.x) - from.yaw_rad);
            let squeeze_m = self.price_of_leg(from.position(), *target, self.config.depth_m);
            let Some(squeeze_m) = squeeze_m else { continue };
            let cost_m = cost_m + squeeze_m;
            let better = self.best.is_none_or(|b| cost_m < b.cost_m);
            if better && self.turn_is_free(from, turn_rad) {
                self.best = Some(Detour { via, target_index, cost_m });
            }
        }
    }

    /// The price (m) of the room that a leg lacks to comfort, or `None` when it is not free.
    ///
    /// The nose reaches beyond the end of the leg, so the leg is checked that much further.
    fn price_of_leg(&self, from: Vec2, to: Vec2, depth_m: f64) -> Option<f64> {
        let along = to - from;
        let length_m = along.norm();
        if length_m < 1e-6 {
            return Some(0.0);
        }
        let nose = to + along * (self.footprint.front_m() / length_m);
        let needed_m = self.footprint.half_width_m() + self.config.margin_m;
        // Where the robot stands now it stands; only what lies ahead of the axle can be avoided.
        let start = from + along * (0.1 / length_m).min(1.0);
        let clearance_m = self.echoes.clearance_of_leg_m(start, nose, depth_m);
        let lacking_m = self.footprint.half_width_m() + self.config.comfort_m - clearance_m;
        (clearance_m >= needed_m).then(|| self.config.comfort_price_ratio * lacking_m.max(0.0))
    }

    fn turn_is_free(&self, pose: Se2, turn_rad: f64) -> bool {
        let clearance_m = self.echoes.clearance_of_turn_m(pose, turn_rad, self.footprint);
        clearance_m >= self.config.turn_margin_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EchoMemoryConfig, RangeSensor};
    use run_context::Stamp;

    /// A memory of these points, each heard from the origin.
    fn heard(points: &[(f64, f64)]) -> EchoMemory {
        let mut memory = EchoMemory::new(EchoMemoryConfig {
            range_max_m: 10.0,
            half_angle_rad: 1e-3,
            ..EchoMemoryConfig::default()
        });
        for &(x, y) in points {
            let sensor = RangeSensor { in_base: Vec2::zeros(), bearing_rad: y.atan2(x) };
            memory.observe(Stamp::ZERO, Se2::IDENTITY, &[sensor], &[x.hypot(y)], 1);
        }
        // A few may hide behind others.
        assert!(memory.len() + 4 >= points.len());
        memory
    }

    fn find(points: &[(f64, f64)], preferred_deg: f64) -> Option<Detour> {
        let targets = [Vec2::new(1.6, 0.0), Vec2::new(2.2, 0.0)];
        let preferred = preferred_deg.to_radians();
        find_detour(
            &heard(points),
            &Footprint::rectangle(0.21, 0.301, 0.2125).unwrap(),
            Se2::IDENTITY,
            preferred,
            &targets,
            &DetourConfig::default(),
        )
    }

    #[test]
    fn a_free_way_needs_no_via_point() {
        assert_eq!(find(&[], 0.0), Some(Detour { via: None, target_index: 0, cost_m: 1.6 }));
    }

    #[test]
    fn a_box_is_passed_on_the_preferred_side() {
        let a_box = [(0.8, 0.15), (0.8, 0.0), (0.8, -0.15)];
        let left = find(&a_box, 45.0).unwrap().via.unwrap();
        let right = find(&a_box, -45.0).unwrap().via.unwrap();
        assert!(left.y > 0.4, "{left}");
        assert!(right.y < -0.4, "{right}");
    }

    #[test]
    fn a_wall_on_one_side_sends_it_to_the_other() {
        let mut points = vec![(0.8, 0.15), (0.8, 0.0), (0.8, -0.15)];
        points.extend((0..12).map(|i| (f64::from(i) * 0.2 - 0.2, 0.5)));
        let via = find(&points, 45.0).unwrap().via.unwrap();
        assert!(via.y < -0.4, "{via}");
    }

    #[test]
    fn a_closed_corridor_has_no_detour() {
        let mut points: Vec<(f64, f64)> =
            (0..15).map(|i| (0.8, f64::from(i) * 0.1 - 0.7)).collect();
        points.extend((0..24).map(|i| (f64::from(i) * 0.1 - 0.5, 0.7)));
        points.extend((0..24).map(|i| (f64::from(i) * 0.1 - 0.5, -0.71)));
        assert_eq!(find(&points, 0.0), None);
    }
}
