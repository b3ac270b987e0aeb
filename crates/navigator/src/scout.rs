//! The scout: a virtual twin that walks the trail ahead of the robot.
//!
//! The pheromone server answers for any pose, also for poses at which nobody is. The twin uses the
//! robot's own control law and ideal wheels, so what it walks is what the robot will drive: a
//! preview of the trail. Walks from several starts tell which way a trail leads to the goal.
//! An extension of ours; a trail by itself has no direction.

use geometry::{Se2, Vec2, wrap_to_pi};
use path_following::SettingError;
use robot_models::DriveGeometry;

use crate::steer::{TrailSteering, advance};

/// Time that the twin walks between two questions, seconds: 120 mm at 300 mm/s, where the law
/// still holds a trail within a few millimetres.
const WALK_S: f64 = 0.4;

/// Speed of the twin, metres per second.
const WALK_MPS: f64 = 0.3;

/// So many answers in a row without pheromone end a walk; fewer are a gap in the trail.
const N_LOST_MAX: u32 = 5;

/// Points that a preview can hold: 72 m.
const N_POINTS_MAX: usize = 600;

/// How a walk stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Walk {
    /// Still walking.
    Going,
    /// Came to the goal.
    AtGoal,
    /// The trail ended.
    TrailEnded,
    /// The trail goes on, but the limit is reached.
    LimitReached,
}

/// One walk: a twin and the points it passed.
#[derive(Clone, Debug)]
pub(crate) struct Scout {
    pose: Se2,
    steering: TrailSteering,
    points: Vec<Vec2>,
    status: Walk,
    n_lost: u32,
    n_points_max: usize,
    nearest_m: f64,
    /// Whether the twin ever smelled anything on this walk.
    smelled: bool,
}

impl Scout {
    pub(crate) fn new() -> Result<Self, SettingError> {
        Ok(Self {
            pose: Se2::IDENTITY,
            steering: TrailSteering::new()?,
            points: Vec::new(),
            status: Walk::TrailEnded,
            n_lost: 0,
            n_points_max: 0,
            nearest_m: f64::INFINITY,
            smelled: false,
        })
    }

    /// The same with room for the longest walk, which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.points.reserve_exact(N_POINTS_MAX);
        self
    }

    /// Begins anew at `start`, to walk at most `length_max_m`.
    pub(crate) fn start(&mut self, start: Se2, length_max_m: f64) {
        self.pose = start;
        self.steering.forget();
        self.points.clear();
        self.points.push(start.position());
        self.status = Walk::Going;
        self.n_lost = 0;
        let n_points = (length_max_m / (WALK_S * WALK_MPS)) as usize;
        self.n_points_max = n_points.clamp(2, N_POINTS_MAX);
        self.nearest_m = f64::INFINITY;
        self.smelled = false;
    }

    /// Forgets the walk.
    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.status = Walk::TrailEnded;
    }

    pub(crate) fn status(&self) -> Walk {
        self.status
    }

    /// Where the next question is about.
    pub(crate) fn pose(&self) -> Se2 {
        self.pose
    }

    pub(crate) fn points(&self) -> &[Vec2] {
        &self.points
    }

    pub(crate) fn smelled(&self) -> bool {
        self.smelled
    }

    /// Least distance to the goal on the walk, metres.
    pub(crate) fn nearest_m(&self) -> f64 {
        self.nearest_m
    }

    /// Length of the walk so far, metres.
    pub(crate) fn length_m(&self) -> f64 {
        self.points.len().saturating_sub(1) as f64 * WALK_S * WALK_MPS
    }

    /// Takes the answer for [`pose`](Self::pose) and walks on.
    pub(crate) fn smell(&mut self, (left, right): (f64, f64), goal: Vec2, drive: &DriveGeometry) {
        if self.status != Walk::Going {
            return;
        }
        let lost = left <= 0.0 && right <= 0.0;
        self.n_lost = if lost { self.n_lost + 1 } else { 0 };
        if self.n_lost >= N_LOST_MAX {
            // The points walked blindly are no trail.
            let n_kept = self.points.len().saturating_sub(N_LOST_MAX as usize - 1).max(1);
            self.points.truncate(n_kept);
            self.status = Walk::TrailEnded;
            return;
        }
        let wheels = if lost {
            self.steering.forget();
            path_following::WheelReference::straight(WALK_MPS)
        } else {
            self.smelled = true;
            self.steering.step(left, right, WALK_MPS, 1.0)
        };
        self.pose = advance(self.pose, wheels, drive, WALK_S);
        self.points.push(self.pose.position());
        self.judge(goal);
    }

    fn judge(&mut self, goal: Vec2) {
        let distance_m = (goal - self.pose.position()).norm();
        // At the goal when it begins to fall behind.
        let passed = self.nearest_m < 0.5 && distance_m > self.nearest_m + 0.02;
        self.nearest_m = self.nearest_m.min(distance_m);
        if self.smelled && (passed || distance_m < 0.15) {
            self.status = Walk::AtGoal;
        } else if self.points.len() >= self.n_points_max {
            self.status = Walk::LimitReached;
        }
    }
}

/// The starts from which walks are tried, in order: at the robot, then around it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Starts {
    next: u32,
}

/// Directions of the first walks relative to the direction of the goal, degrees.
const HEADINGS_DEG: [f64; 4] = [0.0, 90.0, -90.0, 180.0];

/// Radii of the rings of further starts, metres.
const RINGS_M: [f64; 2] = [0.7, 1.4];

/// Starts per ring.
const N_RING: u32 = 8;

impl Starts {
    /// The next start, or `None` after the last. Poses in the frame of `robot` and `goal`.
    pub(crate) fn next(&mut self, robot: Se2, goal: Vec2) -> Option<Se2> {
        let way = goal - robot.position();
        let goal_rad = if way.norm() > 0.1 { way.y.atan2(way.x) } else { robot.yaw_rad };
        let index = self.next;
        self.next += 1;
        if let Some(heading_deg) = HEADINGS_DEG.get(index as usize) {
            let yaw_rad = goal_rad + heading_deg.to_radians();
            return Some(Se2::new(robot.x_m, robot.y_m, yaw_rad));
        }
        let index = index - HEADINGS_DEG.len() as u32;
        // Both ways along whatever lies there: first towards the goal, then away from it.
        let (ring, rest) = (index / (2 * N_RING), index % (2 * N_RING));
        let radius_m = *RINGS_M.get(ring as usize)?;
        let angle_rad = goal_rad + f64::from(rest % N_RING) * std::f64::consts::FRAC_PI_4;
        let around = Se2::new(0.0, 0.0, angle_rad).heading() * radius_m;
        let yaw_rad = if rest < N_RING { goal_rad } else { goal_rad + std::f64::consts::PI };
        Some(Se2::new(robot.x_m + around.x, robot.y_m + around.y, wrap_to_pi(yaw_rad)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: DriveGeometry = DriveGeometry {
        wheelbase_m: 0.38,
        wheel_diameter_m: 0.195,
        encoder_ticks_per_turn: 500.0,
        gear_ratio: 38.3,
    };

    /// A trail along the x axis up to `end_m`, as two antennas 380 mm apart smell it ahead.
    fn smell(pose: Se2, end_m: f64) -> (f64, f64) {
        let antenna = |side: f64| {
            let at = pose.transform_point(Vec2::new(0.0, side));
            let sources = (0..200).map(|k| Vec2::new(f64::from(k) * 0.2, 0.0));
            let ahead = sources
                .filter(|s| s.x <= end_m && (s - pose.position()).dot(&pose.heading()) >= 0.0);
            ahead.map(|s| (100.0 * (1.0 - (s - at).norm() / 0.6)).max(0.0)).sum::<f64>()
        };
        (antenna(0.19), antenna(-0.19))
    }

    fn walk(start: Se2, goal: Vec2, end_m: f64, max_m: f64) -> Scout {
        let mut scout = Scout::new().unwrap();
        scout.start(start, max_m);
        for _ in 0..10_000 {
            if scout.status() != Walk::Going {
                break;
            }
            scout.smell(smell(scout.pose(), end_m), goal, &DRIVE);
        }
        scout
    }

    #[test]
    fn the_twin_walks_to_the_goal_and_stays_on_the_trail() {
        let scout = walk(Se2::new(0.0, 0.1, 0.7), Vec2::new(5.0, 0.0), 10.0, 30.0);
        assert_eq!(scout.status(), Walk::AtGoal);
        assert!(scout.nearest_m() < 0.2);
        assert!(scout.points().iter().skip(18).all(|p| p.y.abs() < 0.05), "{:?}", scout.points());
    }

    #[test]
    fn every_walk_ends_and_says_how() {
        let far = Vec2::new(50.0, 0.0);
        let ended = walk(Se2::IDENTITY, far, 3.0, 30.0);
        assert_eq!(ended.status(), Walk::TrailEnded);
        assert!((ended.points().last().unwrap().x - 3.0).abs() < 0.5);
        assert_eq!(walk(Se2::IDENTITY, far, 30.0, 6.0).status(), Walk::LimitReached);
        let nothing = walk(Se2::new(0.0, 5.0, 0.0), far, 3.0, 30.0);
        assert!(nothing.status() == Walk::TrailEnded && !nothing.smelled());
        assert_eq!(nothing.points().len(), 1);
    }

    #[test]
    fn starts_are_bounded_and_begin_towards_the_goal() {
        let mut starts = Starts::default();
        let robot = Se2::new(1.0, 1.0, 2.0);
        let first = starts.next(robot, Vec2::new(1.0, 5.0)).unwrap();
        assert!((first.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let n_more = std::iter::from_fn(|| starts.next(robot, Vec2::new(1.0, 5.0))).count();
        assert_eq!(n_more, 3 + 2 * 16);
    }
}
