//! A person who drives a robot by hand: sees where it truly is, and moves a stick.
//!
//! Logs for mapping are recorded this way. A robot that steered by its own drifting dead reckoning would leave its
//! path and hit the walls, so somebody leads it; what it records does not know of that. The person belongs to
//! the mission as the walkers and the judge do: what reaches the robot are speeds of its wheels, nothing else.

use std::time::Duration;

use geometry::Se2;
use messages::Command;
use path_following::{Path, PathFollower, PathFollowerConfig, PathLaw};
use robot_models::{RobotModel, WheelSpeeds};
use run_context::{Stamp, StateHash};

use crate::mission::plan::TeleoperatorPlan;

/// How often the stick moves.
const STICK_PERIOD: Duration = Duration::from_millis(100);
/// How far ahead of the robot the person looks, m.
const LOOKAHEAD_M: f64 = 0.3;
/// How hard the robot is slowed down before the end of the path, m/s².
const BRAKING_MPS2: f64 = 0.1;
/// Slowest way to the end, m/s.
const CREEP_MPS: f64 = 0.02;

/// One person with one robot.
#[derive(Debug)]
pub(super) struct Teleoperator {
    path: Path,
    follower: Option<PathFollower>,
    speed_mps: f64,
    starts_at: Stamp,
    next_move: Stamp,
    hold: Hold,
    sets_off: bool,
    news: Option<&'static str>,
}

/// How the person holds the stick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hold {
    /// Not yet.
    Waits,
    /// Drives along the path.
    Drives,
    /// Has driven all of it and keeps the robot standing.
    Stands,
    /// The ground gave an order: it has the robot now.
    LetGo,
}

impl Teleoperator {
    pub(super) fn new(plan: &TeleoperatorPlan, model: &RobotModel) -> Self {
        let follower = PathFollower::new(PathFollowerConfig {
            law: PathLaw::PurePursuit { lookahead_m: LOOKAHEAD_M },
            wheelbase_m: model.drive.wheelbase_m,
            wheel_speed_max_mps: (2.0 * plan.speed_mps).min(model.limits.speed_max_mps),
        });
        Self {
            path: plan.path.clone(),
            // Within its ranges for every robot of the catalogue; without it the robot would stand.
            follower: follower.ok(),
            speed_mps: plan.speed_mps,
            starts_at: plan.starts_at,
            next_move: plan.starts_at,
            hold: Hold::Waits,
            sets_off: false,
            news: None,
        }
    }

    /// Looks at the robot and moves the stick.
    pub(super) fn step(&mut self, now: Stamp, world_from_base: Se2, commands: &mut Vec<Command>) {
        self.sets_off = false;
        if self.hold == Hold::Waits && now >= self.starts_at {
            self.hold = Hold::Drives;
            self.sets_off = true;
            self.news = Some("driven by hand");
            commands.push(Command::EnableMotors(true));
        }
        if self.hold != Hold::Drives || now < self.next_move {
            return;
        }
        self.next_move = now + STICK_PERIOD;
        let Some(follower) = &mut self.follower else { return };
        let left_m = follower.progress().map_or(self.path.length_m(), |p| p.remaining_m);
        let braking_mps = (2.0 * BRAKING_MPS2 * left_m.max(0.0)).sqrt().max(CREEP_MPS);
        let speed_mps = self.speed_mps.min(braking_mps);
        let wheels = follower.step(&self.path, world_from_base, speed_mps, STICK_PERIOD);
        if follower.progress().is_some_and(|p| p.finished) {
            self.hold = Hold::Stands;
            self.news = Some("was driven to the end of its path");
            commands.push(Command::Stop);
            return;
        }
        let (left_mps, right_mps) = (wheels.left_mps, wheels.right_mps);
        commands.push(Command::Drive(WheelSpeeds { left_mps, right_mps }));
    }

    /// Gives the robot to whoever has sent it an order.
    pub(super) fn let_go(&mut self) {
        self.hold = Hold::LetGo;
    }

    /// Whether the robot moves by the person's hand.
    pub(super) fn is_driving(&self) -> bool {
        self.hold == Hold::Drives
    }

    /// Whether it was driven to the end of the path.
    pub(super) fn has_driven_all(&self) -> bool {
        self.hold == Hold::Stands
    }

    /// Whether the drive began in the last step.
    pub(super) fn sets_off(&self) -> bool {
        self.sets_off
    }

    /// What is worth telling, once.
    pub(super) fn take_news(&mut self) -> Option<&'static str> {
        self.news.take()
    }

    /// What screens show; `None` when the robot's own mind has it.
    pub(super) fn phase_name(&self) -> Option<&'static str> {
        match self.hold {
            Hold::Drives => Some("driven by hand"),
            Hold::Stands => Some("arrived"),
            Hold::Waits | Hold::LetGo => None,
        }
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.hold as u64);
        let progress = self.follower.as_ref().and_then(PathFollower::progress);
        hash.absorb(progress.map_or(0.0, |p| p.arc_length_m));
    }
}
