//! The way over a trail of tags in the floor: look around for it, follow it, lose it and find it again.

use geometry::{Se2, Vec2};
use messages::{FailureReason, TagRead};
use path_following::{SettingError, TagStep};

use super::{
    leg::Leg,
    preview::{PREVIEW_STEP_M, Preview},
    tag_trail::{Aim, Search, TagTrail},
};
use crate::{around::Surroundings, settings::NavigatorSettings, values::Situation};

/// Behind an obstacle the trail is taken to run straight on for so long, metres.
const BEHIND_M: f64 = 4.0;

/// How well it looks where it was turned to, radians.
const TURNED_RAD: f64 = 0.15;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct ByTags {
    trail: TagTrail,
    wheel_speed_max_mps: f64,
    approach_m: f64,
    approach_from_end_m: f64,
    lost_drive_m: f64,
}

impl ByTags {
    pub(crate) fn new(s: &NavigatorSettings) -> Result<Self, SettingError> {
        let wheel_speed_max_mps = s.wheel_speed_max_mps();
        Ok(Self {
            trail: TagTrail::new(&s.tags, s.drive.wheelbase_m, wheel_speed_max_mps)?,
            wheel_speed_max_mps,
            approach_m: s.approach_m,
            approach_from_end_m: s.approach_from_trail_end_m,
            lost_drive_m: s.lost_drive_m,
        })
    }

    /// A reader has read a tag while the robot was at that pose; what the antennas smell then, left and right.
    pub(crate) fn take_tag(&mut self, pose: Se2, read: &TagRead) -> (f64, f64) {
        self.trail.take(pose, read);
        self.trail.levels()
    }

    /// The robot went from one pose to the next.
    pub(crate) fn roll(&mut self, from: Se2, to: Se2) {
        self.trail.roll(from, to);
    }

    /// A new task.
    pub(crate) fn begin(&mut self, goal: Option<Vec2>) {
        self.trail.set_goal(goal);
    }

    /// Begins to look for the trail around the robot, standing.
    pub(crate) fn look(&mut self, pose: Se2, preview: &mut Preview) -> Leg {
        preview.clear();
        let may_help = self.trail.begin(pose);
        if may_help { Leg::Look } else { Leg::Failed(FailureReason::TrailLost) }
    }

    pub(crate) fn aim(&mut self, situation: &Situation, around: &Surroundings) -> Leg {
        if !situation.steering.is_turning
            && around.goal_is_straight_ahead(situation, self.approach_m)
        {
            return Leg::ToGoal;
        }
        let pose = situation.at.pose;
        match self.trail.aim(pose) {
            Aim::Turn(heading_rad) => Leg::Turn { heading_rad, within_rad: TURNED_RAD },
            Aim::Go => {
                self.trail.set_out();
                Leg::Follow
            }
            Aim::Nothing if self.trail.has_looked_twice() => Leg::Failed(FailureReason::NoTrail),
            Aim::Nothing => {
                // Tags may be missing just here: a little further on.
                self.trail.lose(pose, None);
                Leg::Lost
            }
        }
    }

    /// The turn that was asked for is done.
    pub(crate) fn turned(&mut self) {
        self.trail.turned();
    }

    /// One control period on the trail.
    pub(crate) fn follow(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        preview: &mut Preview,
        is_blocked: bool,
    ) -> Leg {
        if around.goal_is_straight_ahead(situation, self.approach_m) {
            return Leg::ToGoal;
        }
        let pose = situation.at.pose;
        if is_blocked {
            suppose_straight_on(pose, preview);
            return Leg::Blocked;
        }
        match self.trail.about_turn_rad(pose) {
            Some(heading_rad) => Leg::Turn { heading_rad, within_rad: TURNED_RAD },
            None => Leg::ByTags,
        }
    }

    /// The law's step at a speed: wheels, or the trail is lost.
    pub(crate) fn step(&mut self, pose: Se2, speed_mps: f64) -> Leg {
        match self.trail.follow(pose, speed_mps) {
            TagStep::Drive(wheels) => Leg::Wheels(wheels.limited(self.wheel_speed_max_mps)),
            TagStep::Lost(side) => {
                self.trail.lose(pose, side);
                Leg::Lost
            }
        }
    }

    /// One control period without the trail.
    pub(crate) fn search(
        &mut self,
        situation: &Situation,
        around: &Surroundings,
        is_blocked: bool,
    ) -> Leg {
        if around.goal_is_straight_ahead(situation, self.approach_from_end_m) {
            return Leg::ToGoal;
        }
        match self.trail.search(situation.at.pose, self.lost_drive_m) {
            Search::Found => {
                self.trail.set_out();
                Leg::Follow
            }
            Search::Drive(_) if is_blocked => {
                self.trail.turn_back();
                Leg::Stop
            }
            Search::Drive(wheels) => Leg::Wheels(wheels),
            Search::Turn(heading_rad) => Leg::Turn { heading_rad, within_rad: TURNED_RAD },
            Search::GaveUp => Leg::LookAgain,
        }
    }
}

/// Where the trail is looked for behind an obstacle.
fn suppose_straight_on(pose: Se2, preview: &mut Preview) {
    preview.clear();
    let n_points = (BEHIND_M / PREVIEW_STEP_M) as u32;
    let (from, ahead) = (pose.position(), pose.heading());
    preview.lay((0..n_points).map(|k| from + ahead * (PREVIEW_STEP_M * f64::from(k))));
}
