//! How fast a commanded arc may be driven: a robot that hears nothing more must touch nothing that was heard.
//!
//! A robot holds its last wheel speeds until its watchdog stops it. So whatever it sweeps on its arc in
//! that time, and while it brakes, must be free of remembered echoes; where it is not, the same
//! arc is driven more slowly. An extension of ours: the thesis drives at a constant speed.

use geometry::Se2;
use obstacle_avoidance::{Arc, EchoMemory, Footprint, Hull};
use path_following::WheelReference;

/// What the robot keeps from what it heard where it has so much, metres: echoes are a few centimetres wrong.
const MARGIN_M: f64 = 0.05;

/// Between a command's way to the robot and the tick of its watchdog, seconds.
const LATE_S: f64 = 0.1;

/// Not slower than this, metres per second: who is so slow stops for what is ahead by the other rules.
const FLOOR_MPS: f64 = 0.06;

/// Speeds that are tried where the robot would touch something while it brakes after its arc.
const N_TRIES: u32 = 6;

/// Between two of them.
const TRY_RATIO: f64 = 0.8;

/// The rule and what it needs to know of a robot.
#[derive(Clone, Debug)]
pub(crate) struct DeafRule {
    hull: Hull,
    wheelbase_m: f64,
    acceleration_mps2: f64,
    /// How long a command may be in force after it was given.
    deaf_s: f64,
}

impl DeafRule {
    /// For a robot whose watchdog stops it after `watchdog_s` seconds, with `acceleration_mps2` (m/s²).
    pub(crate) fn new(
        footprint: &Footprint,
        wheelbase_m: f64,
        watchdog_s: f64,
        acceleration_mps2: f64,
    ) -> Self {
        let hull = Hull::new(footprint, MARGIN_M);
        Self { hull, wheelbase_m, acceleration_mps2, deaf_s: watchdog_s + LATE_S }
    }

    /// The same arc from `pose`, as fast as a robot may drive it that will hear nothing more.
    pub(crate) fn slowed(
        &self,
        wheels: WheelReference,
        pose: Se2,
        echoes: &EchoMemory,
    ) -> WheelReference {
        let asked_mps = wheels.linear_mps();
        let (size_mps, floor_mps) = (asked_mps.abs(), FLOOR_MPS.min(asked_mps.abs()));
        if size_mps < 1e-3 {
            return wheels;
        }
        let arc = Arc {
            curvature_per_m: wheels.angular_radps(self.wheelbase_m) / asked_mps,
            backwards: asked_mps < 0.0,
        };
        let way_m = self.way_m(size_mps);
        let free_m = echoes.free_way_m(pose, arc, way_m, &self.hull);
        let mut speed_mps = if free_m < way_m { self.speed_for_mps(free_m) } else { size_mps };
        let mut n_tries = 0;
        while speed_mps > floor_mps
            && n_tries < N_TRIES
            && self.tail_hits(speed_mps, pose, arc, echoes)
        {
            speed_mps *= TRY_RATIO;
            n_tries += 1;
        }
        let ratio = speed_mps.max(floor_mps) / size_mps;
        WheelReference { left_mps: ratio * wheels.left_mps, right_mps: ratio * wheels.right_mps }
    }

    /// The way of a deaf robot: v T + v² / 2a.
    fn way_m(&self, speed_mps: f64) -> f64 {
        speed_mps * self.deaf_s + 0.5 * speed_mps * speed_mps / self.acceleration_mps2
    }

    /// The speed with this way.
    fn speed_for_mps(&self, way_m: f64) -> f64 {
        let late_mps = self.acceleration_mps2 * self.deaf_s;
        (late_mps * late_mps + 2.0 * self.acceleration_mps2 * way_m).sqrt() - late_mps
    }

    /// Robots cease to turn before they stand: whether one that goes straight on at the end of its arc while it
    /// brakes touches something.
    fn tail_hits(&self, speed_mps: f64, pose: Se2, arc: Arc, echoes: &EchoMemory) -> bool {
        let braking_m = 0.5 * speed_mps * speed_mps / self.acceleration_mps2;
        let end = arc.pose_after(pose, speed_mps * self.deaf_s);
        let straight = Arc { curvature_per_m: 0.0, ..arc };
        echoes.free_way_m(end, straight, braking_m, &self.hull) < braking_m
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use obstacle_avoidance::{EchoMemoryConfig, RangeSensor};

    use run_context::Stamp;

    use super::*;

    fn guard(watchdog_s: f64) -> (DeafRule, Footprint) {
        let footprint = Footprint::rectangle(0.21, 0.301, 0.2125).unwrap();
        (DeafRule::new(&footprint, 0.38, watchdog_s, 0.3), footprint)
    }

    /// A memory of points (m, base frame of a robot at the origin).
    fn heard(points: &[(f64, f64)]) -> EchoMemory {
        let config = EchoMemoryConfig { half_angle_rad: 1e-3, ..EchoMemoryConfig::default() };
        let mut memory = EchoMemory::new(config);
        for &(x, y) in points {
            let sensor = RangeSensor { in_base: geometry::Vec2::zeros(), bearing_rad: y.atan2(x) };
            memory.observe(Stamp::ZERO, Se2::IDENTITY, &[sensor], &[x.hypot(y)], 1);
        }
        memory
    }

    fn arc(speed_mps: f64, curvature_per_m: f64) -> WheelReference {
        WheelReference::along_arc(speed_mps, curvature_per_m, 0.38)
    }

    /// The deaf robot written out anew, in steps of 1 ms: it holds its wheels, then brakes, on the arc or
    /// straight on. Least distance to a point.
    fn least_gap_m(
        footprint: &Footprint,
        wheels: WheelReference,
        deaf_s: f64,
        point: (f64, f64),
        straight: bool,
    ) -> f64 {
        let (mut pose, mut least_m) = (Se2::IDENTITY, f64::INFINITY);
        let mut speed_mps = wheels.linear_mps();
        let curvature_per_m = wheels.angular_radps(0.38) / speed_mps;
        for ms in 0..20_000 {
            let braking = f64::from(ms) * 1e-3 >= deaf_s;
            if braking {
                speed_mps -= 0.3e-3 * speed_mps.signum();
            }
            if braking && speed_mps * wheels.linear_mps() <= 0.0 {
                break;
            }
            let bend = if braking && straight { 0.0 } else { curvature_per_m };
            let dx_m = speed_mps * 1e-3;
            pose =
                pose.compose(Se2::exp(geometry::Twist { dx_m, dy_m: 0.0, dyaw_rad: bend * dx_m }));
            let point = pose.inverse().transform_point(geometry::Vec2::new(point.0, point.1));
            least_m = least_m.min(footprint.distance_m(point));
        }
        least_m
    }

    /// Wherever something was heard and whichever arc is asked for: deaf, it touches nothing, unless it
    /// creeps; and it is not slowed down where the whole way is free.
    #[test]
    fn a_deaf_robot_touches_nothing_that_was_heard() {
        let (mut n_slowed, mut n_whole, mut n_crept) = (0, 0, 0);
        for watchdog_s in [0.5, 2.0] {
            let (guard, footprint) = guard(watchdog_s);
            for speed_mps in [-0.1, 0.15, 0.3, 0.6] {
                for curvature_per_m in [-2.5, -0.7, 0.0, 0.4, 2.6] {
                    for k in 0..24 {
                        let angle_rad = f64::from(k) * FRAC_PI_2 / 6.0;
                        let far_m = 0.28 + 0.04 * f64::from(k % 13);
                        let point = (far_m * angle_rad.cos(), far_m * angle_rad.sin());
                        let gap_m = footprint.distance_m(geometry::Vec2::new(point.0, point.1));
                        if gap_m < 0.01 {
                            continue;
                        }
                        let asked = arc(speed_mps, curvature_per_m);
                        let slowed = guard.slowed(asked, Se2::IDENTITY, &heard(&[point]));
                        let ratio = slowed.linear_mps() / asked.linear_mps();
                        let bend = slowed.angular_radps(0.38) / slowed.linear_mps();
                        assert!((bend - curvature_per_m).abs() < 1e-9, "another arc");
                        assert!((0.0..=1.0).contains(&ratio), "{ratio}");
                        let gap_m = |wheels, straight| {
                            least_gap_m(&footprint, wheels, watchdog_s, point, straight)
                        };
                        let creeps = slowed.linear_mps().abs() <= FLOOR_MPS + 1e-9;
                        let case = format!("{watchdog_s} {speed_mps} {curvature_per_m} {point:?}");
                        for straight in [false, true] {
                            let touches = gap_m(slowed, straight) <= 0.0;
                            assert!(!touches || creeps, "{case}: {slowed:?}");
                        }
                        n_crept += u32::from(creeps && speed_mps > 0.1);
                        if ratio < 0.999 {
                            n_slowed += 1;
                            let near = gap_m(asked, false).min(gap_m(asked, true));
                            // What the margin, the command's way and the tries in steps cost.
                            let slack_m = MARGIN_M + LATE_S * speed_mps.abs() + 0.1;
                            assert!(near < slack_m, "{case}: slowed for {near} m");
                        } else {
                            n_whole += 1;
                        }
                    }
                }
            }
        }
        assert!(n_slowed > 100 && n_whole > 300 && n_crept > 20, "{n_slowed} {n_whole} {n_crept}");
    }

    /// A wall 0.5 m before the nose: v T + v² / 2a = 0.5 − 0.05, by hand 0.195 m/s.
    #[test]
    fn before_a_wall_the_speed_is_the_one_that_the_law_says() {
        let (guard, _) = guard(2.0);
        let memory = heard(&[(0.71, 0.0)]);
        let slowed = guard.slowed(arc(0.3, 0.0), Se2::IDENTITY, &memory);
        let speed_mps = slowed.linear_mps();
        let way_m = speed_mps * 2.1 + speed_mps * speed_mps / 0.6;
        assert!((way_m - 0.45).abs() < 1e-3, "{speed_mps} m/s, {way_m} m");
        // Backwards it is free; beyond the wall, too.
        for (wheels, pose) in [
            (arc(-0.1, 0.0), Se2::IDENTITY),
            (arc(0.3, 0.0), Se2::new(1.2, 0.0, 0.0)),
            (arc(0.3, 0.0), Se2::new(0.2, 0.0, std::f64::consts::PI)),
        ] {
            assert_eq!(guard.slowed(wheels, pose, &memory), wheels);
        }
        // Nothing heard, and wheels that stand.
        let silent = EchoMemory::new(EchoMemoryConfig::default());
        assert_eq!(guard.slowed(arc(0.3, 2.0), Se2::IDENTITY, &silent), arc(0.3, 2.0));
        let stop = WheelReference::STOP;
        assert_eq!(guard.slowed(stop, Se2::IDENTITY, &memory), stop);
    }

    /// Posts of a door of 0.95 m, 0.26 m beside the hull: straight through it is driven at full speed.
    #[test]
    fn a_door_is_driven_through_at_full_speed() {
        let (guard, _) = guard(2.0);
        let memory = heard(&[(0.5, 0.475), (0.5, -0.475), (0.62, 0.475), (0.62, -0.475)]);
        assert_eq!(guard.slowed(arc(0.3, 0.0), Se2::IDENTITY, &memory), arc(0.3, 0.0));
        assert_eq!(guard.slowed(arc(0.3, 0.3), Se2::IDENTITY, &memory), arc(0.3, 0.3));
        // In a curve it would touch a post.
        let curve = arc(0.3, 1.5);
        assert!(guard.slowed(curve, Se2::IDENTITY, &memory).linear_mps() < 0.25);
    }
}
