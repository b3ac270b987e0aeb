//! The phases on a trail of tags: look around for it, follow it, lose it and find it again.

use geometry::Transform2;
use messages::{Command, FailureReason, TagRead};
use path_following::TagStep;
use run_context::Stamp;

use crate::{
    ahead::Hazard,
    arrive::TurnStatus,
    config::Method,
    navigator::Navigator,
    tags::{Aim, Search},
    trail::PREVIEW_STEP_M,
    view::Phase,
};

/// Behind an obstacle the trail is taken to run straight on for so long, metres.
const BEHIND_M: f64 = 4.0;

/// What is remembered of echoes is forgotten when tags move the robot by more, metres.
const JUMP_M: f64 = 0.1;

/// How well tags say where the robot is, metres and radians (standard deviations): a reader sees a tag from up
/// to 6 cm away.
const FIX_STD_M: f64 = 0.03;
const FIX_STD_RAD: f64 = 0.03;

impl Navigator {
    /// A reader has read a tag.
    pub(crate) fn take_tag(&mut self, now: Stamp, read: &TagRead) {
        let pose = self.pose_now(now);
        self.tags.take(pose, read);
        self.intensities = Some(self.tags.levels());
        if self.tags.corrects_pose()
            && let Some(reader) = self.tags.reader_in_map(pose, read.reader)
        {
            let reader_in_odom = self.map_from_odom.se2().inverse().transform_point(reader);
            self.tag_fix.note(read.tag, read.memory.in_map, reader_in_odom);
            self.correct_by_tags();
        }
    }

    /// Moves the robot in the map to where its last tags say that it is.
    fn correct_by_tags(&mut self) {
        let (corrected, knows_heading) = self.tag_fix.corrected(self.map_from_odom.se2());
        self.map_from_odom = Transform2::new(corrected);
        let Some(odometry) = self.base.odometry else { return };
        let before = self.pose.position();
        self.pose = (self.map_from_odom * odometry.odom_from_base).se2();
        if (self.pose.position() - before).norm() > JUMP_M {
            // What was remembered in the map is in the wrong place now.
            self.echoes.clear();
        }
        let std_rad = knows_heading.then_some(FIX_STD_RAD);
        self.covariance = self.covariance.fixed(FIX_STD_M, std_rad);
    }

    /// Begins to look for the trail around the robot, standing.
    pub(crate) fn aim_by_tags(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.forget_preview();
        if self.tags.begin(self.pose) {
            self.enter(Phase::AimAtTrail, now);
        } else {
            self.fail(FailureReason::TrailLost, now, commands);
        }
    }

    /// A new task over a trail of tags.
    pub(crate) fn begin_tags(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.tags.set_goal(self.goal_point());
        self.aim_by_tags(now, commands);
    }

    /// One control period of a phase that depends on tags; whether it was one.
    pub(crate) fn tags_control(&mut self, now: Stamp, commands: &mut Vec<Command>) -> bool {
        if self.config.settings.method != Method::Tags {
            return false;
        }
        match self.phase {
            Phase::AimAtTrail => self.tags_aim(now, commands),
            Phase::FollowTrail => self.tags_follow(now, commands),
            Phase::LostTrail => self.tags_search(now, commands),
            _ => return false,
        }
        true
    }

    fn tags_aim(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        if self.turn.is_none() && self.goal_is_straight_ahead(self.config.settings.approach_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        match self.tags.aim(self.pose) {
            Aim::Turn(heading_rad) => self.tags_turn(heading_rad, now, commands),
            Aim::Go => {
                self.tags.set_out();
                self.enter(Phase::FollowTrail, now);
            }
            Aim::Nothing if self.tags.has_looked_twice() => {
                self.fail(FailureReason::NoTrail, now, commands);
            }
            Aim::Nothing => {
                // Tags may be missing just here: a little further on.
                self.tags.lose(self.pose, None);
                self.enter(Phase::LostTrail, now);
            }
        }
    }

    fn tags_turn(&mut self, heading_rad: f64, now: Stamp, commands: &mut Vec<Command>) {
        match self.turn_to(heading_rad, 0.15, now, commands) {
            TurnStatus::Turning => {}
            TurnStatus::Done => self.tags.turned(),
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    fn tags_follow(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.forget_preview();
        if self.goal_is_straight_ahead(self.config.settings.approach_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        if self.hazard(now) != Hazard::None {
            self.suppose_straight_on();
            self.stop_wheels(commands);
            self.begin_wait(now);
            return;
        }
        if let Some(heading_rad) = self.tags.about_turn_rad(self.pose) {
            self.tags_turn(heading_rad, now, commands);
            return;
        }
        let speed_mps = self.trail_speed_mps(now, false);
        match self.tags.follow(self.pose, speed_mps) {
            TagStep::Drive(wheels) => {
                // A trail may wind; how long it may take is bounded by the task's own limit.
                self.note_progress(now);
                let most_mps = self.config.settings.wheel_speed_max_mps();
                self.drive(wheels.limited(most_mps), now, commands);
            }
            TagStep::Lost(side) => {
                self.tags.lose(self.pose, side);
                self.enter(Phase::LostTrail, now);
                self.tags_search(now, commands);
            }
        }
    }

    /// Where the trail is looked for behind an obstacle.
    fn suppose_straight_on(&mut self) {
        self.forget_preview();
        let (from, ahead) = (self.pose.position(), self.pose.heading());
        let n_points = (BEHIND_M / PREVIEW_STEP_M) as u32;
        let points = (0..n_points).map(|k| from + ahead * (PREVIEW_STEP_M * f64::from(k)));
        self.preview.extend(points);
    }

    fn tags_search(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let settings = &self.config.settings;
        if self.goal_is_straight_ahead(settings.approach_from_trail_end_m) {
            self.enter(Phase::Approach, now);
            return;
        }
        match self.tags.search(self.pose, settings.lost_drive_m) {
            Search::Found => {
                self.turn = None;
                self.tags.set_out();
                self.enter(Phase::FollowTrail, now);
            }
            Search::Drive(_) if self.hazard(now) != Hazard::None => {
                self.stop_wheels(commands);
                self.tags.turn_back();
            }
            Search::Drive(wheels) => self.drive(wheels, now, commands),
            Search::Turn(heading_rad) => self.tags_turn(heading_rad, now, commands),
            Search::GaveUp => {
                self.stop_wheels(commands);
                self.aim_by_tags(now, commands);
            }
        }
    }
}
