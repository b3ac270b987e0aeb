//! What passes between the parts of a mind: plain values that can be copied, and nothing that a part keeps for itself.

use std::time::Duration;

use geometry::{Base, Map, Odom, Se2, Transform2, Twist, Vec2};
use path_following::WheelReference;
use robot_models::{BodyVelocity, PoseCovariance, WheelSpeeds};
use run_context::Stamp;

/// Slowest speed at which a robot is sent anywhere, metres per second.
pub(crate) const SPEED_MIN_MPS: f64 = 0.08;

/// Speed at which a trail's corner is driven and an obstacle is come up to, metres per second: the
/// thesis's 300 mm/s, at which its laws were tuned.
pub(crate) const CAREFUL_MPS: f64 = 0.3;

/// Part of the wheels' acceleration that braking counts on; the rest is for late reports.
const BRAKING_SHARE: f64 = 0.8;

/// A report older than this says nothing about the present.
const REPORT_AGE_MAX_S: f64 = 0.5;

/// How much of the way ahead is looked at at 0.3 m/s, metres; at higher speeds as much more as braking takes.
const LOOK_M: f64 = 1.3;

/// The speed that [`LOOK_M`] is for, metres per second.
const LOOK_SPEED_MPS: f64 = 0.3;

/// Points of the way ahead: 3.6 m of preview.
const N_AHEAD_MAX: usize = 32;

/// How well a robot knows where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PoseHealth {
    /// As well as its devices let it.
    #[default]
    Sure,
    /// Worse than it should for going on as usual.
    Unsure,
    /// It does not know.
    Lost,
}

/// Whether a robot stands, by what its wheels report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rest {
    /// A wheel turns.
    Moves,
    /// Both wheels are slower than 0.03 m/s.
    #[default]
    Stands,
    /// It has been reported standing for 200 ms at least.
    Settled,
}

/// Where a robot is, as the part *where am I* has it from the latest report of its wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The reported pose (m, rad, map).
    pub pose: Se2,
    /// Covariance of that pose.
    pub covariance: PoseCovariance,
    /// Where its dead reckoning begins.
    pub map_from_odom: Transform2<Map, Odom>,
    /// When the pose was true.
    pub about: Stamp,
    /// When the wheels were last heard of.
    pub heard_at: Stamp,
    /// The wheels were heard of at all.
    pub is_heard: bool,
    /// Measured velocity of the body.
    pub velocity: BodyVelocity,
    /// The robot itself says that it moves.
    pub is_moving: bool,
    /// Whether its wheels turn.
    pub rest: Rest,
    /// How far it came straight forward to where it is, metres: so far it may back off blindly.
    pub straight_m: f64,
    /// The way driven since the mind began, metres.
    pub driven_m: f64,
    /// How far the pose can be relied on.
    pub health: PoseHealth,
}

impl PoseEstimate {
    /// Whether both wheels are slow enough to turn in place.
    pub(crate) fn stands(&self) -> bool {
        self.rest != Rest::Moves
    }

    /// Whether it has come to rest.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.rest == Rest::Settled
    }

    pub(crate) fn position(&self) -> Vec2 {
        self.pose.position()
    }

    /// Measured speed over ground, metres per second.
    pub(crate) fn speed_mps(&self) -> f64 {
        self.velocity.linear_mps
    }

    /// How old the last report is, seconds.
    pub(crate) fn age_s(&self, now: Stamp) -> f64 {
        now.since(self.about).as_secs_f64().min(REPORT_AGE_MAX_S)
    }

    /// How long a command takes to the wheels, as long as the last report took, seconds.
    pub(crate) fn delay_s(&self) -> f64 {
        self.heard_at.since(self.about).as_secs_f64().min(REPORT_AGE_MAX_S)
    }

    /// Where the robot is by now: the reported pose and what its wheels have done since.
    pub(crate) fn pose_now(&self, now: Stamp) -> Se2 {
        self.pose_after_s(self.age_s(now))
    }

    /// Where it will be when a command that is given now gets to its wheels.
    pub(crate) fn pose_at_command(&self, now: Stamp) -> Se2 {
        self.pose_after_s(self.age_s(now) + self.delay_s())
    }

    fn pose_after_s(&self, age_s: f64) -> Se2 {
        self.pose.compose(Se2::exp(Twist {
            dx_m: self.velocity.linear_mps * age_s,
            dy_m: 0.0,
            dyaw_rad: self.velocity.angular_radps * age_s,
        }))
    }

    /// How far the robot still goes when it is told to stop now, metres: v T + v² / 2a with its measured speed.
    pub(crate) fn stopping_way_m(&self, limits: &Limits) -> f64 {
        let speed_mps = self.speed_mps().abs();
        let braking_m = 0.5 * speed_mps * speed_mps / limits.acceleration_mps2;
        speed_mps * self.delay_s() + braking_m
    }

    /// How far it goes until a command that is given now gets to its wheels, metres.
    pub(crate) fn way_until_command_m(&self, now: Stamp) -> f64 {
        self.speed_mps().max(0.0) * (self.age_s(now) + self.delay_s())
    }

    /// The fastest speed to a point `left_m` away (by the last report) at which the robot shall stand, m/s.
    pub(crate) fn speed_to_stand_mps(&self, left_m: f64, now: Stamp, limits: &Limits) -> f64 {
        let left_m = left_m - self.way_until_command_m(now);
        braking_mps(left_m, limits.acceleration_mps2, limits.period_s)
    }
}

/// How fast a robot drives, brakes and decides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Cruising speed, metres per second.
    pub(crate) speed_mps: f64,
    pub(crate) acceleration_mps2: f64,
    /// Time between control steps, seconds.
    pub(crate) period_s: f64,
}

impl Limits {
    /// The slowest speed at which it is sent anywhere, metres per second.
    pub(crate) fn least_mps(&self) -> f64 {
        SPEED_MIN_MPS.min(self.speed_mps)
    }

    /// How much of the way ahead is looked at, metres.
    pub(crate) fn look_m(&self) -> f64 {
        let (v, v0) = (self.speed_mps.max(LOOK_SPEED_MPS), LOOK_SPEED_MPS);
        let braking_m = (v * v - v0 * v0) / (1.6 * self.acceleration_mps2);
        LOOK_M + (braking_m + (v - v0) * (self.period_s + 0.1)).min(2.2)
    }

    /// Whether it cruises no faster than what [`LOOK_M`] is for.
    pub(crate) fn is_slow(&self) -> bool {
        self.speed_mps <= LOOK_SPEED_MPS
    }
}

/// Where to stand in the end, and how exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Goal {
    /// The pose.
    pub map_from_base: Transform2<Map, Base>,
    /// How near to it the robot must stand, metres.
    pub within_m: f64,
    /// How well it must look its way, radians.
    pub within_rad: f64,
}

impl Goal {
    pub(crate) fn point(&self) -> Vec2 {
        self.map_from_base.se2().position()
    }
}

/// How it stands with steering.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steering {
    /// A turn in place is under way.
    pub(crate) is_turning: bool,
    /// A line was left so far that it must be aimed at anew.
    pub(crate) is_saturated: bool,
}

/// What all parts that steer know at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
    pub(crate) now: Stamp,
    pub(crate) at: PoseEstimate,
    pub(crate) goal: Option<Goal>,
    /// It stands and waits for its way to clear.
    pub(crate) waits: bool,
    pub(crate) steering: Steering,
    /// What the wheels were told last.
    pub(crate) told: WheelReference,
}

impl Situation {
    pub(crate) fn goal_point(&self) -> Option<Vec2> {
        self.goal.map(|goal| goal.point())
    }
}

/// What the wheels shall do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// What they were told before.
    Keep,
    Stop,
    /// Turn in place to this heading (rad, map).
    Turn(f64),
    Wheels(WheelReference),
}

/// A way to drive: its points (m, map), the first at the robot's axle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    points: [Vec2; N_AHEAD_MAX],
    n_points: usize,
    ends: bool,
}

impl Way {
    pub(crate) fn begin(at: Vec2) -> Self {
        let mut points = [Vec2::zeros(); N_AHEAD_MAX];
        points[0] = at;
        Self { points, n_points: 1, ends: false }
    }

    /// Straight to a point; `ends` when the robot will stand there, else the way goes on beyond.
    pub(crate) fn to(from: Vec2, target: Vec2, ends: bool) -> Self {
        let mut way = Self::begin(from);
        way.ends = ends;
        way.push(target);
        way
    }

    /// Straight on for so many metres.
    pub(crate) fn on(pose: Se2, length_m: f64) -> Self {
        Self::to(pose.position(), pose.position() + pose.heading() * length_m, false)
    }

    /// Adds a point; `false` when there is no room.
    pub(crate) fn push(&mut self, point: Vec2) -> bool {
        let free = self.n_points < N_AHEAD_MAX;
        if free {
            self.points[self.n_points] = point;
            self.n_points += 1;
        }
        free
    }

    pub(crate) fn points(&self) -> &[Vec2] {
        &self.points[..self.n_points]
    }

    /// How far the robot goes before it stands, metres; infinite when the way goes on.
    pub(crate) fn end_m(&self) -> f64 {
        if !self.ends {
            return f64::INFINITY;
        }
        self.points().windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }
}

/// The fastest speed that still stops within `left_m` when the next decision comes after `delay_s`:
/// v T + v² / 2a = d. Zero when nothing is left.
pub(crate) fn braking_mps(left_m: f64, acceleration_mps2: f64, delay_s: f64) -> f64 {
    let a = BRAKING_SHARE * acceleration_mps2;
    let late_mps = a * delay_s;
    (late_mps * late_mps + 2.0 * a * left_m.max(0.0)).sqrt() - late_mps
}

/// The same speeds as the robots' crate names them.
pub(crate) fn to_wheels(wheels: WheelReference) -> WheelSpeeds {
    WheelSpeeds { left_mps: wheels.left_mps, right_mps: wheels.right_mps }
}

/// The stamp so much earlier, or the beginning.
pub(crate) fn earlier(now: Stamp, by: Duration) -> Stamp {
    let by_nanos = u64::try_from(by.as_nanos()).unwrap_or(u64::MAX);
    Stamp::from_nanos(now.as_nanos().saturating_sub(by_nanos))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Braking written out anew: drives at the speed for the delay, then brakes with all there is.
    #[test]
    fn what_is_allowed_stops_in_time_and_not_much_earlier() {
        for a in [0.1, 0.3, 2.0] {
            for delay_s in [0.0, 0.2, 1.0] {
                for left_m in [0.0, 0.01, 0.3, 3.0] {
                    let v = braking_mps(left_m, a, delay_s);
                    let way_m = v * delay_s + v * v / (2.0 * a);
                    assert!(way_m <= left_m + 1e-9, "{a} {delay_s} {left_m}: {way_m}");
                    assert!(way_m >= 0.8 * left_m - 1e-9, "{a} {delay_s} {left_m}: {way_m}");
                }
            }
        }
        assert!(braking_mps(-1.0, 0.3, 0.2).abs() < 1e-12);
    }
}
