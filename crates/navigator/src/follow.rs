//! *Follow*: the laws that turn a way into a [`Motion`]: of trails, lines, paths, of turns and of homing to a goal.
//!
//! It knows what was asked for and where the robot is; what else is around it only asks before it turns.

mod homing;
mod laws;
mod turns;

use std::time::Duration;

use geometry::Vec2;
use path_following::{
    PathFollower, PathFollowerConfig, SettingError, TrailFollower, TrailFollowerConfig, TrailLaw,
    TrailTuning, WheelReference,
};
use run_context::Stamp;

use crate::{
    around::Surroundings,
    how::CourseLeg,
    says::Sentence,
    settings::NavigatorSettings,
    values::{CAREFUL_MPS, Limits, Motion, Situation, Steering},
};
use homing::{Homing, creep_mps};
use laws::{LineSteering, Sight, TrailSteering};
use turns::Turns;

pub(crate) use homing::Homed;
pub(crate) use turns::{Curving, TurnStatus};

/// Part of the cruising speed at which the robot turns in an arc.
const CURVE_RATIO: f64 = 0.5;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Follow {
    trail: TrailSteering,
    line: LineSteering,
    path: PathFollower,
    turns: Turns,
    homing: Homing,
    /// Metres to the right of the line or path that was steered along last.
    error_m: f64,
    /// The law that steered last.
    law: &'static str,
    limits: Limits,
    period: Duration,
    fit_to_speed: bool,
}

impl Follow {
    pub(crate) fn new(s: &NavigatorSettings) -> Result<Self, SettingError> {
        Ok(Self {
            trail: trail_steering(s)?,
            line: LineSteering::new()?,
            path: PathFollower::new(PathFollowerConfig {
                law: s.path_controller.law(),
                wheelbase_m: s.drive.wheelbase_m,
                wheel_speed_max_mps: s.wheel_speed_max_mps(),
            })?,
            turns: Turns::default(),
            homing: Homing::default(),
            error_m: 0.0,
            law: "steers by nothing yet",
            limits: s.limits(),
            period: Duration::from_secs_f64(s.control_period_s),
            fit_to_speed: s.fit_to_speed,
        })
    }

    pub(crate) fn says(&self) -> Sentence {
        let law = match (self.turns.is_curving(), self.turns.is_turning()) {
            (true, _) => "turns in an arc, since there is no room on the spot",
            (_, true) => "turns on the spot",
            _ => self.law,
        };
        Sentence::Follows { law, off_m: self.error_m }
    }

    pub(crate) fn forget_task(&mut self) {
        self.turns = Turns::default();
        self.homing.forget();
        self.restart();
    }

    /// The laws of trails and paths begin anew: what they last saw has nothing to do with what comes.
    pub(crate) fn restart(&mut self) {
        self.trail.forget();
        self.path.restart();
    }

    /// How it stands.
    pub(crate) fn steering(&self) -> Steering {
        Steering { is_turning: self.turns.is_turning(), is_saturated: self.line.is_saturated() }
    }

    pub(crate) fn cancel_turn(&mut self) {
        self.turns.cancel_turn();
    }

    /// One step of a turn in place to a heading (rad, map).
    pub(crate) fn turn_to(
        &mut self,
        heading_rad: f64,
        within_rad: f64,
        situation: &Situation,
        around: &Surroundings,
    ) -> (TurnStatus, Motion) {
        self.turns.turn_to(heading_rad, within_rad, situation, around)
    }

    /// Begins to turn in an arc to a heading (rad, map).
    pub(crate) fn begin_curve(&mut self, heading_rad: f64, now: Stamp) {
        self.turns.begin_curve(heading_rad, now);
    }

    /// One step of a turn in an arc.
    pub(crate) fn curve(&mut self, situation: &Situation, around: &Surroundings) -> Curving {
        let speed_mps = CURVE_RATIO * self.limits.speed_mps;
        self.turns.curve(situation, around, speed_mps)
    }

    /// The goal is headed for from where the robot is.
    pub(crate) fn begin_homing(&mut self, from: Vec2) {
        self.homing.begin(from);
    }

    /// One step straight to the goal.
    pub(crate) fn approach(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
    ) -> (Homed, Motion) {
        self.homing.step(situation, around, &mut self.turns, &self.limits)
    }

    /// The wheels for the way to the goal, where the way allows `way_mps`.
    pub(crate) fn home(&mut self, situation: &Situation, way_mps: f64) -> Motion {
        let Some(goal) = situation.goal else { return Motion::Keep };
        let at = &situation.at;
        let left_m = (goal.point() - at.position()).norm();
        let speed_mps = at
            .speed_to_stand_mps(left_m, situation.now, &self.limits)
            .min(way_mps)
            .max(creep_mps(&goal, &self.limits))
            .min(self.limits.speed_mps);
        let from = self.homing.line_from();
        Motion::Wheels(self.along_line(situation, from, goal.point(), speed_mps))
    }

    /// Between two control steps: stands if it is time to stop at the goal.
    pub(crate) fn brake_at_goal(&mut self, situation: &Situation) -> Option<Motion> {
        let drives = situation.told.linear_mps() > 0.0;
        let brakes = drives && self.homing.brakes(situation, &self.turns, &self.limits);
        brakes.then(|| self.settle(situation.now))
    }

    /// Stands, to measure where.
    pub(crate) fn settle(&mut self, now: Stamp) -> Motion {
        self.homing.settle(now, &mut self.turns)
    }

    /// One step of the turn to the goal's heading.
    pub(crate) fn align(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
    ) -> (Homed, Motion) {
        Homing::align(situation, around, &mut self.turns)
    }

    /// Wheels along a straight line (m, map).
    pub(crate) fn along_line(
        &mut self,
        situation: &Situation,
        from: Vec2,
        to: Vec2,
        speed_mps: f64,
    ) -> WheelReference {
        let sight = Sight { pose: situation.at.pose, about: situation.at.about };
        let wheels = self.line.step(sight, from, to, speed_mps);
        self.error_m = self.line.error_m();
        self.law = "steers along a straight line";
        wheels
    }

    pub(crate) fn forget_saturation(&mut self) {
        self.line.forget_saturation();
    }

    /// Wheels by what the antennas smell, left and right.
    pub(crate) fn along_trail(
        &mut self,
        situation: &Situation,
        (left, right): (f64, f64),
        speed_mps: f64,
    ) -> WheelReference {
        // The measured speed as a part of the one that the laws of trails were tuned at, or of a lower cruising
        // speed; 1 for a law as printed.
        self.law = "steers by what the antennas smell";
        let tuned_mps = self.limits.speed_mps.min(CAREFUL_MPS);
        let pace = if self.fit_to_speed { situation.at.speed_mps() / tuned_mps } else { 1.0 };
        self.trail.step(left, right, speed_mps, pace)
    }

    /// Wheels along a piece of a given path.
    pub(crate) fn along_course(
        &mut self,
        situation: &Situation,
        leg: &CourseLeg<'_>,
    ) -> WheelReference {
        let pose = situation.at.pose_now(situation.now);
        let wheels = self.path.step_on(leg.course, leg.leg, pose, leg.speed_mps, self.period);
        self.law = "steers along the path";
        self.error_m = self.path.progress().map_or(0.0, |p| -p.cross_track_m);
        wheels
    }

    pub(crate) fn error_m(&self) -> f64 {
        self.error_m
    }
}

fn trail_steering(s: &NavigatorSettings) -> Result<TrailSteering, SettingError> {
    let law =
        s.trail_controller.law(TrailTuning { fuzzy: s.trail_fuzzy, listing: s.trail_listing });
    let most_mps = s.wheel_speed_max_mps();
    // Where the rules say how fast H is, H itself is allowed.
    let wheel_speed_max_mps = match law {
        TrailLaw::Fuzzy { fuzzy } => most_mps.max(fuzzy.fast_ratio * s.speed_mps),
        _ => most_mps,
    };
    let config = TrailFollowerConfig {
        law,
        wheelbase_m: s.drive.wheelbase_m,
        wheel_speed_max_mps,
        ..TrailFollowerConfig::default()
    };
    Ok(TrailSteering::new(TrailFollower::new(config)?, s.control_period_s))
}
