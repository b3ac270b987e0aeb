//! Following a known path: carrot, pure pursuit, Stanley, fuzzy on the path's error.
//!
//! All share one shape: [`PathFollower::step`] takes the path, the pose, a speed and the time since the
//! last step. They remember how far along the path the robot is, and look for it near there only, so
//! that a path may cross itself.
//!
//! Which one: pure pursuit is smooth and has one setting. The carrot swings more. Stanley returns to the
//! line fastest on gentle paths. Fuzzy needs no geometry beyond a signed distance.

use std::{
    f64::consts::{FRAC_PI_2, FRAC_PI_4},
    time::Duration,
};

use geometry::{Se2, Vec2, wrap_to_pi};

use crate::{
    Course, Leg, Path, SettingError, WheelReference,
    fuzzy::{FuzzyConfig, FuzzyController},
    law_table::law_table,
    path::heading_back_rad,
    wheels::check_range,
};

/// How far behind the last known place on the path the robot is looked for, metres: it may have been
/// pushed back or have driven around something.
const WINDOW_BEHIND_M: f64 = 0.5;
/// How far ahead of it, metres. Less than the distance along the path between two crossing branches.
const WINDOW_AHEAD_M: f64 = 1.5;

law_table! {
    /// A law that keeps a robot on a path it knows, by its name.
    ///
    /// This table is the list of path laws: missions, the guide and the tests of every law read it.
    pub enum PathController: fn() -> PathLaw {
        #[default]
        Fuzzy = "fuzzy", "fuzzy on the distance from the path (5.30) and its change (5.31)", PathLaw::fuzzy;
        Carrot = "carrot", "turns towards a point ahead on the path in proportion to the angle (5.5), (5.6); swings most", || PathLaw::CARROT;
        PurePursuit = "pure_pursuit", "drives the arc through a point ahead on the path (5.12); smooth", || PathLaw::PURE_PURSUIT;
        Stanley = "stanley", "steers along the path plus the arctangent of distance times gain over speed", || PathLaw::STANLEY;
    }
}

impl PathController {
    /// The law with its settings for 0.3 m/s.
    pub fn law(self) -> PathLaw {
        (self.maker())()
    }
}

/// How a path is followed, and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathLaw {
    /// Turn towards a point ahead on the path, in proportion to the angle: Δθ = `k_p` `φ_e` (5.5), (5.6).
    Carrot {
        /// Distance of the point from the robot, metres, 0.05 to 10; further at speeds at which it would swing.
        lookahead_m: f64,
        /// Turn rate per angle, 1/s, 0.05 to 20.
        gain_per_s: f64,
    },
    /// Drive the arc through a point ahead on the path: γ = 2 y / L² (5.12).
    PurePursuit {
        /// Distance of the point from the robot (L), metres, 0.05 to 10; further at speeds at which it would swing.
        lookahead_m: f64,
    },
    /// Steer along the path plus arctan(k e / v) back to it.
    Stanley {
        /// k: how fast the cross-track error shall fall, 1/s, 0.05 to 20.
        cross_track_gain_per_s: f64,
        /// Turn rate per angle, 1/s, 0.05 to 20.
        heading_gain_per_s: f64,
    },
    /// The fuzzy controller on the signed error (5.30) and its change (5.31).
    Fuzzy {
        /// Sets and rules at 0.3 m/s, see [`widths`]; `error_full` in metres, `change_full` in metres per 200 ms.
        fuzzy: FuzzyConfig,
    },
}

/// The speed that the laws' settings are for, metres per second.
const REFERENCE_SPEED_MPS: f64 = 0.3;

/// The point ahead is so many seconds of way away at least, and two control periods more: the turn rate
/// comes late by about half a period, a report's age and the wheels' ramp.
const LOOKAHEAD_S: f64 = 0.8;

/// How far beside an arc a point ahead on it may lead, metres.
const CHORD_OFF_M: f64 = 0.04;

/// A turn rate per angle, times this delay besides half a period (s), stays below [`GAIN_TIMES_DELAY_MAX`].
const DELAY_S: f64 = 0.15;

/// Above this a law that turns in proportion to an angle begins to swing.
const GAIN_TIMES_DELAY_MAX: f64 = 0.7;

impl PathLaw {
    /// Follow the carrot with settings for 0.3 m/s.
    pub const CARROT: Self = Self::Carrot { lookahead_m: 0.6, gain_per_s: 1.2 };
    /// Pure pursuit with settings for 0.3 m/s.
    pub const PURE_PURSUIT: Self = Self::PurePursuit { lookahead_m: 0.6 };
    /// Stanley with settings for 0.3 m/s.
    pub const STANLEY: Self =
        Self::Stanley { cross_track_gain_per_s: 0.8, heading_gain_per_s: 2.0 };

    /// Fuzzy with settings for 0.3 m/s.
    pub fn fuzzy() -> Self {
        Self::Fuzzy {
            fuzzy: FuzzyConfig { error_full: 0.25, change_full: 0.04, ..FuzzyConfig::default() },
        }
    }

    /// Whether it looks at errors only: then the curvature of a course is steered ahead of time for it.
    const fn looks_at_errors_only(&self) -> bool {
        match self {
            Self::Stanley { .. } | Self::Fuzzy { .. } => true,
            Self::Carrot { .. } | Self::PurePursuit { .. } => false,
        }
    }
}

/// A law and the robot it drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFollowerConfig {
    /// How the path is followed.
    pub law: PathLaw,
    /// Between the wheels (b), metres, 0.02 to 5.
    pub wheelbase_m: f64,
    /// No wheel is asked for more, metres per second, 0.01 to 10; arcs keep their shape.
    pub wheel_speed_max_mps: f64,
}

impl Default for PathFollowerConfig {
    /// Pure pursuit on the thesis's robot, b = 0.38 m.
    fn default() -> Self {
        Self { law: PathLaw::PURE_PURSUIT, wheelbase_m: 0.38, wheel_speed_max_mps: 0.75 }
    }
}

/// How a robot stands against the path it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Of the nearest point from the path's start, along it, metres.
    pub arc_length_m: f64,
    /// From there to the end along the path, metres.
    pub remaining_m: f64,
    /// From the path, metres, left positive.
    pub cross_track_m: f64,
    /// From the path's direction, radians, left positive.
    pub heading_error_rad: f64,
    /// The robot has passed the end.
    pub finished: bool,
}

/// What a law steers along.
struct Way<'a> {
    path: &'a Path,
    leg: Leg,
    /// No law looks further ahead, metres.
    lookahead_max_m: f64,
}

/// A controller that keeps a robot on a path it knows.
///
/// ```
/// use std::time::Duration;
/// use geometry::{Se2, Vec2};
/// use path_following::{Path, PathFollower, PathFollowerConfig};
///
/// let path = Path::polyline(&[Vec2::new(0.0, 0.0), Vec2::new(5.0, 0.0)]).unwrap();
/// let mut follower = PathFollower::new(PathFollowerConfig::default()).unwrap();
/// let right_of_it = Se2::new(1.0, -0.2, 0.0);
/// let wheels = follower.step(&path, right_of_it, 0.3, Duration::from_millis(200));
/// assert!(wheels.right_mps > wheels.left_mps, "turns left, back to the path");
/// ```
#[derive(Clone, Debug)]
pub struct PathFollower {
    config: PathFollowerConfig,
    /// Only for the fuzzy law.
    fuzzy: Option<FuzzyController>,
    progress: Option<Progress>,
}

impl PathFollower {
    /// Checks the settings.
    ///
    /// # Errors
    ///
    /// [`SettingError`] for a value outside its range.
    pub fn new(config: PathFollowerConfig) -> Result<Self, SettingError> {
        let lookahead = |value| check_range("lookahead_m", value, 0.05..=10.0, "from 0.05 to 10 m");
        let gain = |key, value| check_range(key, value, 0.05..=20.0, "from 0.05 to 20 1/s");
        check_range("wheelbase_m", config.wheelbase_m, 0.02..=5.0, "from 0.02 to 5 m")?;
        let speed_max = config.wheel_speed_max_mps;
        check_range("wheel_speed_max_mps", speed_max, 0.01..=10.0, "from 0.01 to 10 m/s")?;
        let mut fuzzy = None;
        match config.law {
            PathLaw::Carrot { lookahead_m, gain_per_s } => {
                lookahead(lookahead_m)?;
                gain("gain_per_s", gain_per_s)?;
            }
            PathLaw::PurePursuit { lookahead_m } => lookahead(lookahead_m)?,
            PathLaw::Stanley { cross_track_gain_per_s, heading_gain_per_s } => {
                gain("cross_track_gain_per_s", cross_track_gain_per_s)?;
                gain("heading_gain_per_s", heading_gain_per_s)?;
            }
            PathLaw::Fuzzy { fuzzy: config } => fuzzy = Some(FuzzyController::new(config)?),
        }
        Ok(Self { config, fuzzy, progress: None })
    }

    /// Wheel speeds for the pose the robot has now, `dt` after the last step.
    ///
    /// `speed_mps` is the speed wanted along the path, ≥ 0; a robot that looks away from where it should
    /// go turns on the spot first. Stops past the end of the path and for arguments that are not finite.
    /// O(pieces) at the first step after [`restart`](Self::restart), then O(pieces within two metres).
    /// Allocates nothing.
    pub fn step(
        &mut self,
        path: &Path,
        map_from_base: Se2,
        speed_mps: f64,
        dt: Duration,
    ) -> WheelReference {
        let Se2 { x_m, y_m, yaw_rad } = map_from_base;
        if !(x_m + y_m + yaw_rad + speed_mps).is_finite() {
            return WheelReference::STOP;
        }
        let way =
            Way { path, leg: Leg { from_m: 0.0, to_m: path.length_m() }, lookahead_max_m: 10.0 };
        let wheels = self.steer(&way, map_from_base, speed_mps, dt);
        wheels.limited(self.config.wheel_speed_max_mps)
    }

    /// As [`step`](Self::step) on one leg of a course: the robot is looked for on this leg only, no law looks
    /// around the corner at its end, and the curvature of the course is steered ahead of time by the laws
    /// that look at errors only. `finished` means that the end of the leg is passed.
    ///
    /// [`restart`](Self::restart) it at the beginning of every leg.
    pub fn step_on(
        &mut self,
        course: &Course,
        leg_index: usize,
        map_from_base: Se2,
        speed_mps: f64,
        dt: Duration,
    ) -> WheelReference {
        let Se2 { x_m, y_m, yaw_rad } = map_from_base;
        if !(x_m + y_m + yaw_rad + speed_mps).is_finite() {
            return WheelReference::STOP;
        }
        let leg = course.leg(leg_index);
        // A point ahead on an arc of curvature κ is steered for along a chord, L² κ / 8 beside the arc.
        let at_m = self.progress.map_or(leg.from_m, |p| p.arc_length_m);
        let sharpest_per_m = (0..4)
            .map(|k| course.curvature_at_per_m((at_m + 0.2 * f64::from(k)).min(leg.to_m)).abs())
            .fold(0.0, f64::max);
        let lookahead_max_m = (8.0 * CHORD_OFF_M / sharpest_per_m.max(1e-3)).sqrt().max(0.3);
        let way = Way { path: course.path(), leg, lookahead_max_m };
        let mut wheels = self.steer(&way, map_from_base, speed_mps, dt);
        if self.config.law.looks_at_errors_only()
            && let Some(now) = self.progress
            && !now.finished
            && now.heading_error_rad.abs() < FRAC_PI_4
        {
            // Where the robot will be when this shows, in the middle of the period.
            let soon_m = now.arc_length_m + speed_mps * (DELAY_S + 0.5 * dt.as_secs_f64());
            let curvature_per_m = course.curvature_at_per_m(soon_m.min(leg.to_m));
            let ahead =
                WheelReference::along_arc(speed_mps, curvature_per_m, self.config.wheelbase_m);
            wheels.left_mps += ahead.left_mps - speed_mps;
            wheels.right_mps += ahead.right_mps - speed_mps;
        }
        wheels.limited(self.config.wheel_speed_max_mps)
    }

    fn steer(
        &mut self,
        way: &Way<'_>,
        map_from_base: Se2,
        speed_mps: f64,
        dt: Duration,
    ) -> WheelReference {
        let Way { path, leg, lookahead_max_m } = *way;
        let before = self.progress;
        let now = self.locate(path, leg, map_from_base);
        self.progress = Some(now);
        if now.finished {
            return WheelReference::STOP;
        }
        let delay_s = DELAY_S + 0.5 * dt.as_secs_f64();
        let gain_max_per_s = GAIN_TIMES_DELAY_MAX / delay_s;
        let ahead = |lookahead_m: f64| {
            ahead_in_base(path, leg, map_from_base, &now, lookahead_m.min(lookahead_max_m))
        };
        match self.config.law {
            PathLaw::Carrot { lookahead_m, gain_per_s } => {
                let gain_per_s = gain_per_s.min(gain_max_per_s);
                // Damped to 0.7 of critical for L ≥ 2 v / k.
                let least_m = 2.0 * speed_mps.abs() / gain_per_s;
                let bearing_rad = bearing(ahead(lookahead_m.max(least_m)));
                self.turn_towards(bearing_rad, gain_per_s, speed_mps)
            }
            PathLaw::PurePursuit { lookahead_m } => {
                let least_m = speed_mps.abs() * (LOOKAHEAD_S + 2.0 * dt.as_secs_f64());
                self.pursue(ahead(lookahead_m.max(least_m)), speed_mps)
            }
            PathLaw::Stanley { cross_track_gain_per_s, heading_gain_per_s } => {
                let heading_gain_per_s = heading_gain_per_s.min(gain_max_per_s);
                let back_m = -cross_track_gain_per_s.min(gain_max_per_s) * now.cross_track_m;
                let yaw_rad = map_from_base.yaw_rad;
                let path_heading_rad = yaw_rad - now.heading_error_rad;
                let wanted_rad = heading_back_rad(path_heading_rad, back_m.atan2(speed_mps.abs()));
                self.turn_towards(wrap_to_pi(wanted_rad - yaw_rad), heading_gain_per_s, speed_mps)
            }
            PathLaw::Fuzzy { .. } => self.infer(before, &now, speed_mps, dt),
        }
    }

    /// Where the robot stood against the path at the last step; `None` before the first.
    pub fn progress(&self) -> Option<Progress> {
        self.progress
    }

    /// Forgets everything: the next step looks for the robot on the whole of the path it is given.
    pub fn restart(&mut self) {
        self.progress = None;
    }

    fn locate(&self, path: &Path, leg: Leg, map_from_base: Se2) -> Progress {
        let point = map_from_base.position();
        let (from_m, to_m) = self.progress.map_or((leg.from_m, leg.to_m), |before| {
            let at_m = before.arc_length_m;
            (leg.from_m.max(at_m - WINDOW_BEHIND_M), leg.to_m.min(at_m + WINDOW_AHEAD_M))
        });
        let seen = path.project_within(point, from_m, to_m);
        // Before and beyond a leg its ends go on straight, as the path's do.
        let is_outside = seen.arc_length_m <= leg.from_m || seen.arc_length_m >= leg.to_m;
        let direction = Se2::new(0.0, 0.0, seen.heading_rad).heading();
        let side_m = direction.perp(&(point - seen.point));
        Progress {
            arc_length_m: seen.arc_length_m,
            remaining_m: path.length_m() - seen.arc_length_m,
            cross_track_m: if is_outside { side_m } else { seen.cross_track_m },
            heading_error_rad: wrap_to_pi(map_from_base.yaw_rad - seen.heading_rad),
            finished: seen.arc_length_m >= leg.to_m,
        }
    }

    /// Turn rate in proportion to an angle; the speed fades as the angle nears a right one.
    fn turn_towards(&self, angle_rad: f64, gain_per_s: f64, speed_mps: f64) -> WheelReference {
        let forward_mps = speed_mps * angle_rad.cos().max(0.0);
        WheelReference::turning(forward_mps, gain_per_s * angle_rad, self.config.wheelbase_m)
    }

    /// The arc that starts along the heading and ends at the target: γ = 2 y / L². (5.12), (5.22), (5.23)
    fn pursue(&self, target_in_base: Vec2, speed_mps: f64) -> WheelReference {
        let wheelbase_m = self.config.wheelbase_m;
        let distance2_m2 = target_in_base.norm_squared();
        if target_in_base.x < 0.0 {
            // An arc to a target behind starts away from it; the nearer side is faster.
            let turn = if target_in_base.y < 0.0 { -1.0 } else { 1.0 };
            return WheelReference::turning(0.0, turn * 2.0 * speed_mps / wheelbase_m, wheelbase_m);
        }
        let curvature_per_m =
            if distance2_m2 > 0.0 { 2.0 * target_in_base.y / distance2_m2 } else { 0.0 };
        WheelReference::along_arc(speed_mps, curvature_per_m, wheelbase_m)
    }

    fn infer(
        &self,
        before: Option<Progress>,
        now: &Progress,
        speed_mps: f64,
        dt: Duration,
    ) -> WheelReference {
        let Some(fuzzy) = &self.fuzzy else { return WheelReference::STOP };
        if now.heading_error_rad.abs() > FRAC_PI_2 {
            // Its inputs do not know which way the robot looks: backwards on the line has no error.
            let angle_rad = -now.heading_error_rad;
            return self.turn_towards(angle_rad, speed_mps / FRAC_PI_4, speed_mps);
        }
        // e of (5.30) is negative on the left, as the rules want it.
        let error_m = -now.cross_track_m;
        let change_m = before.map_or(0.0, |before| error_m + before.cross_track_m);
        let periods = dt.as_secs_f64() / REFERENCE_PERIOD_S;
        let change_m = if periods > 0.0 { change_m / periods } else { 0.0 };
        let (wider, faster) = widths(speed_mps, REFERENCE_SPEED_MPS);
        fuzzy.step(error_m / wider, change_m / faster, speed_mps)
    }
}

/// How much wider the sets of the error and of its change (5.31) must be at a speed than at the one that they
/// are laid out for, m/s.
///
/// The error of a robot off its line by θ changes by V Δt sin θ a period. Below the speed of the layout the
/// set of the change shrinks with the speed, which keeps the damping; above it both sets grow with its
/// square, which keeps the times of the loop, as its delay does not shrink.
pub fn widths(speed_mps: f64, layout_mps: f64) -> (f64, f64) {
    let ratio = (speed_mps.abs() / layout_mps).max(0.1);
    if ratio < 1.0 { (1.0, ratio) } else { (ratio * ratio, ratio * ratio) }
}

/// The period that `change_full` refers to, seconds: the thesis's control period.
const REFERENCE_PERIOD_S: f64 = 0.2;

/// The point to steer for, in the robot's frame (m).
fn ahead_in_base(
    path: &Path,
    leg: Leg,
    map_from_base: Se2,
    now: &Progress,
    lookahead_m: f64,
) -> Vec2 {
    let from = map_from_base.position();
    let target_in_map = point_ahead(path, leg, from, now.arc_length_m, lookahead_m);
    // (5.23) with x forward and y left.
    map_from_base.inverse().transform_point(target_in_map)
}

fn bearing(in_base: Vec2) -> f64 {
    in_base.y.atan2(in_base.x)
}

/// The first point of the leg, from `from_along_m` on, that is `distance_m` away from `from`; the leg goes on
/// straight beyond its end. Where all of it is further away, its nearest point.
fn point_ahead(path: &Path, leg: Leg, from: Vec2, from_along_m: f64, distance_m: f64) -> Vec2 {
    let point = |along_m: f64| path.stretch_point_at(along_m, leg.from_m, leg.to_m);
    let is_far = |along_m: f64| (point(along_m) - from).norm() >= distance_m;
    if is_far(from_along_m) {
        return point(from_along_m);
    }
    // Strides short enough not to jump over a hairpin, and enough of them for a path that winds.
    let stride_m = 0.25 * distance_m;
    let mut near_m = from_along_m;
    for _ in 0..64 {
        let mut far_m = near_m + stride_m;
        if !is_far(far_m) {
            near_m = far_m;
            continue;
        }
        // Halving 20 times leaves less than a thousandth of a millimetre per metre.
        for _ in 0..20 {
            let middle_m = 0.5 * (near_m + far_m);
            if is_far(middle_m) { far_m = middle_m } else { near_m = middle_m }
        }
        return point(far_m);
    }
    point(near_m)
}

#[cfg(test)]
#[path = "path_laws_tests.rs"]
mod tests;
