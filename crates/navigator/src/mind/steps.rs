//! What each phase asks of which part in a control period, and which phase comes next.

use geometry::wrap_to_pi;
use messages::{Command, FailureReason, Report};
use run_context::Stamp;

use super::{Navigator, scene};
use crate::{
    follow::{Curving, Homed, TurnStatus},
    guard::{Bypassing, Waiting},
    how::{Leg, Scent},
    phase::Phase,
    values::{Motion, Situation},
};

impl Navigator {
    /// Looks for the way, standing.
    pub(super) fn aim(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let leg = self.route.aim(&situation, &self.around);
        self.carry_out(leg, now, commands);
    }

    /// Follows the way.
    pub(super) fn follow_way(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        if self.route.advance(&situation) {
            self.task.note_progress(now);
        }
        let is_blocked = self.is_blocked(&situation);
        let leg = self.route.follow(&situation, &self.around, is_blocked);
        self.carry_out(leg, now, commands);
    }

    /// Looks for the way that was lost, driving.
    pub(super) fn search(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let is_blocked = self.is_blocked(&situation);
        let leg = self.route.search(&situation, &self.around, is_blocked, self.phase_since);
        self.carry_out(leg, now, commands);
    }

    /// Does what the route says.
    pub(super) fn carry_out(&mut self, leg: Leg, now: Stamp, commands: &mut Vec<Command>) {
        match leg {
            Leg::Rest | Leg::ByAntennas { stand: false } => {}
            Leg::Stop | Leg::ByAntennas { stand: true } => self.guard.stop(commands),
            Leg::Corner => {
                self.guard.stop(commands);
                self.follow.restart();
            }
            Leg::ToGoal => self.enter(Phase::Approach, now),
            Leg::Straight => self.drive_to_target(now),
            Leg::Look => self.enter(Phase::AimAtTrail, now),
            Leg::LookAgain => {
                self.guard.stop(commands);
                self.look(now, commands);
            }
            Leg::Join(target) => {
                self.guard.join(target, now);
                self.enter(Phase::Rejoin, now);
            }
            Leg::TurnOut { heading_rad, within_rad } => {
                self.turn_out(heading_rad, within_rad, now, commands);
            }
            Leg::Turn { heading_rad, within_rad } => {
                self.turn(heading_rad, within_rad, now, commands);
            }
            Leg::Follow => self.enter(Phase::FollowTrail, now),
            Leg::TakeUp => self.take_up(now),
            Leg::Lost => self.enter(Phase::LostTrail, now),
            Leg::Blocked => self.meet(now, commands),
            Leg::ByTags => self.follow_tags(now, commands),
            Leg::ByCourse => self.follow_course(now, commands),
            Leg::Wheels(wheels) => {
                self.pass(Motion::Wheels(wheels), &self.situation(now), commands);
            }
            Leg::Failed(reason) => self.fail(reason, now, commands),
        }
    }

    fn pass(&mut self, motion: Motion, situation: &Situation, commands: &mut Vec<Command>) {
        self.guard.pass(motion, situation, &self.around, commands);
    }

    fn drive_to_target(&mut self, now: Stamp) {
        if let Some(target) = self.task.first_target() {
            self.guard.drive_to(target, now);
            self.enter(Phase::DriveToTarget, now);
        }
    }

    /// Looks for the way anew, from where the robot stands.
    fn look(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let leg = self.route.look(&self.situation(now));
        self.carry_out(leg, now, commands);
    }

    /// Follows the way from here on.
    pub(super) fn take_up(&mut self, now: Stamp) {
        self.follow.restart();
        if self.route.take_up(&self.situation(now)) {
            self.task.note_progress(now);
        }
        self.enter(Phase::FollowTrail, now);
    }

    /// Something is in the way: stands, waits, or goes around.
    fn meet(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.guard.stop(commands);
        let situation = self.situation(now);
        let way = self.way(&situation);
        let scene = scene(&situation, &self.around, &way, &self.route);
        let phase = self.guard.meet(self.phase, scene);
        self.enter(phase, now);
    }

    /// Turns in place; then does what the route says next.
    fn turn(&mut self, heading_rad: f64, within_rad: f64, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let (status, motion) =
            self.follow.turn_to(heading_rad, within_rad, &situation, &self.around);
        self.pass(motion, &situation, commands);
        match status {
            TurnStatus::Turning => {}
            TurnStatus::Done => {
                let leg = self.route.turned();
                self.carry_out(leg, now, commands);
            }
            TurnStatus::GaveUp => self.fail(FailureReason::Stuck, now, commands),
        }
    }

    /// The same; in an arc where the tail may hit a wall that it has not heard yet.
    fn turn_out(
        &mut self,
        heading_rad: f64,
        within_rad: f64,
        now: Stamp,
        commands: &mut Vec<Command>,
    ) {
        if self.curve(now, commands) {
            return;
        }
        let at = self.locator.estimate();
        let turn_rad = wrap_to_pi(heading_rad - at.pose.yaw_rad);
        if !self.follow.steering().is_turning && self.around.tail_may_hit_a_wall(&at, turn_rad) {
            self.follow.begin_curve(heading_rad, now);
            return;
        }
        self.turn(heading_rad, within_rad, now, commands);
    }

    /// Turns in an arc if that is due; whether it is still at it.
    fn curve(&mut self, now: Stamp, commands: &mut Vec<Command>) -> bool {
        let situation = self.situation(now);
        match self.follow.curve(&situation, &self.around) {
            Curving::No => false,
            Curving::Turning(motion) => {
                self.pass(motion, &situation, commands);
                true
            }
            Curving::Ended => {
                self.guard.stop(commands);
                false
            }
        }
    }

    /// The server's answer about the robot's own pose: one step of the trail law.
    pub(super) fn follow_scent(
        &mut self,
        now: Stamp,
        intensities: (f64, f64),
        commands: &mut Vec<Command>,
    ) {
        let situation = self.situation(now);
        let follows = self.phase == Phase::FollowTrail;
        let is_lost = self.phase == Phase::LostTrail;
        if !(follows || is_lost) || self.follow.steering().is_turning || self.is_blocked(&situation)
        {
            return;
        }
        let wheels = match self.route.scent(&situation, intensities, follows) {
            Scent::Line { from, to } => {
                self.follow.restart();
                let speed_mps = self.trail_speed_mps(&situation, true);
                self.follow.along_line(&situation, from, to, speed_mps)
            }
            Scent::Nothing(wheels) => {
                if follows {
                    self.enter(Phase::LostTrail, now);
                    self.follow.restart();
                }
                wheels
            }
            Scent::Trail => {
                if is_lost {
                    self.take_up(now);
                }
                let speed_mps = self.trail_speed_mps(&situation, false);
                self.follow.along_trail(&situation, intensities, speed_mps)
            }
        };
        self.pass(Motion::Wheels(wheels), &situation, commands);
    }

    fn trail_speed_mps(&self, situation: &Situation, by_lines: bool) -> f64 {
        self.route.speed_mps(situation, self.way_speed_mps(situation), by_lines)
    }

    fn follow_tags(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let speed_mps = self.trail_speed_mps(&situation, false);
        let leg = self.route.step_by_tags(situation.at.pose, speed_mps);
        if leg == Leg::Lost {
            self.enter(Phase::LostTrail, now);
            self.search(now, commands);
            return;
        }
        // A trail may wind; how long it may take is bounded by the task's own limit.
        self.task.note_progress(now);
        self.carry_out(leg, now, commands);
    }

    fn follow_course(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let way_mps = self.way_speed_mps(&situation);
        if let Some(leg) = self.route.course(&situation, way_mps) {
            let wheels = self.follow.along_course(&situation, &leg);
            self.pass(Motion::Wheels(wheels), &situation, commands);
        }
    }

    /// Stands before what is in the way, until it has gone or for long enough.
    pub(super) fn wait(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let way = self.way(&situation);
        let seen = scene(&situation, &self.around, &way, &self.route);
        match self.guard.wait(self.phase_since, seen, commands) {
            Waiting::Still => {}
            Waiting::GoAround(phase) => self.enter(phase, now),
            Waiting::Clear(resume) => {
                if let Some((beside_m, since)) = self.guard.cleared(&situation) {
                    self.around.forget_on_way(&way, beside_m, since);
                }
                if resume == Phase::FollowTrail {
                    self.take_up(now);
                } else {
                    self.enter(resume, now);
                }
            }
        }
    }

    /// One control period of the machine that drives to a point and goes around what is in the way.
    pub(super) fn bypass(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let way = self.way(&situation);
        let seen = scene(&situation, &self.around, &way, &self.route);
        if self.guard.back_off(seen, commands) || self.curve(now, commands) {
            return;
        }
        let seen = scene(&situation, &self.around, &way, &self.route);
        let is_blocked = self.guard.is_blocked(seen);
        if is_blocked && self.guard.may_wait(self.phase, situation.at.position()) {
            self.meet(now, commands);
            return;
        }
        let bypassing = self.guard.bypass(self.phase, is_blocked, seen, commands);
        if bypassing != Bypassing::NoWay {
            self.follow.forget_saturation();
        }
        match bypassing {
            Bypassing::NoWay => {}
            Bypassing::Going => self.name_phase(),
            Bypassing::Line { from, to, most_mps } => {
                let way_mps = self.way_speed_mps(&situation).min(most_mps);
                let speed_mps = self.guard.line_speed_mps(&situation, to, way_mps);
                let wheels = self.follow.along_line(&situation, from, to, speed_mps);
                self.pass(Motion::Wheels(wheels), &situation, commands);
                self.name_phase();
            }
            Bypassing::Curve(heading_rad) => {
                self.follow.begin_curve(heading_rad, now);
                self.name_phase();
            }
            Bypassing::Reached => self.end_bypass(now, commands),
            Bypassing::Failed(reason) => self.give_up_way(reason, now, commands),
        }
    }

    /// The way cannot be driven: another one is planned, if it plans, or the task fails.
    fn give_up_way(&mut self, reason: FailureReason, now: Stamp, commands: &mut Vec<Command>) {
        let planned = match reason {
            FailureReason::Blocked => self.route.plan_anew(&self.situation(now), &self.around),
            _ => None,
        };
        let Some(leg) = planned else {
            self.fail(reason, now, commands);
            return;
        };
        self.guard.stop(commands);
        self.guard.forget_task(now);
        self.follow.restart();
        self.task.note_progress(now);
        self.carry_out(leg, now, commands);
    }

    fn name_phase(&mut self) {
        if self.phase == Phase::Avoid || self.phase == Phase::Rejoin {
            self.phase = if self.guard.is_away() { Phase::Avoid } else { Phase::Rejoin };
        }
    }

    /// The machine has reached what it was sent to.
    fn end_bypass(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        self.guard.end_bypass();
        if self.phase == Phase::DriveToTarget {
            if let Some(target) = self.task.reached(now) {
                self.guard.drive_to(target, now);
                self.enter(Phase::DriveToTarget, now);
            } else {
                self.enter(Phase::Approach, now);
            }
            return;
        }
        match self.guard.resume() {
            Phase::FollowTrail => self.take_up(now),
            Phase::LostTrail if self.route.is_scouted() => self.look(now, commands),
            _ => self.enter(Phase::Approach, now),
        }
        self.task.note_progress(now);
    }

    /// Drives straight to the goal.
    pub(super) fn approach(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let (homed, motion) = self.follow.approach(&situation, &self.around);
        self.pass(motion, &situation, commands);
        match homed {
            Homed::MayDrive if self.is_blocked(&situation) => self.meet(now, commands),
            Homed::MayDrive => {
                let way_mps = self.way_speed_mps(&situation);
                let motion = self.follow.home(&situation, way_mps);
                self.pass(motion, &situation, commands);
            }
            homed => self.end_homing(homed, now, commands),
        }
    }

    /// Turns to the goal's heading.
    pub(super) fn align(&mut self, now: Stamp, commands: &mut Vec<Command>) {
        let situation = self.situation(now);
        let (homed, motion) = self.follow.align(&situation, &self.around);
        self.pass(motion, &situation, commands);
        self.end_homing(homed, now, commands);
    }

    fn end_homing(&mut self, homed: Homed, now: Stamp, commands: &mut Vec<Command>) {
        match homed {
            Homed::Going | Homed::MayDrive => {}
            Homed::Stands => self.enter(Phase::AlignHeading, now),
            Homed::Moved => {
                self.enter(Phase::Approach, now);
                let motion = self.follow.settle(now);
                self.pass(motion, &self.situation(now), commands);
            }
            Homed::Arrived => {
                self.end_task(now);
                self.enter(Phase::Arrived, now);
                commands.push(Command::Report(Report::Arrived));
            }
            Homed::Failed(reason) => self.fail(reason, now, commands),
        }
    }
}
