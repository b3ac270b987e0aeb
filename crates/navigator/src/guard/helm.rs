//! The last hand on the wheel: what is asked of the wheels goes through here, more slowly where it must.

use geometry::wrap_to_pi;
use messages::Command;
use path_following::WheelReference;

use super::deaf::DeafRule;
use crate::{
    around::Surroundings,
    says::Sentence,
    values::{Motion, Situation, to_wheels},
};

/// What the wheels were told last, and the rule about robots that hear nothing more.
#[derive(Clone, Debug)]
pub(crate) struct Helm {
    deaf: Option<DeafRule>,
    told: WheelReference,
    /// What of the speed that was asked for was passed on.
    ratio: f64,
}

impl Helm {
    /// With the rule where it holds.
    pub(crate) fn new(deaf: Option<DeafRule>) -> Self {
        Self { deaf, told: WheelReference::STOP, ratio: 1.0 }
    }

    pub(crate) fn says(&self) -> Sentence {
        Sentence::Passes { told_mps: self.told.linear_mps(), ratio: self.ratio }
    }

    pub(crate) fn told(&self) -> WheelReference {
        self.told
    }

    /// Hands a motion on.
    pub(crate) fn pass(
        &mut self,
        motion: Motion,
        situation: &Situation,
        around: &Surroundings,
        commands: &mut Vec<Command>,
    ) {
        match motion {
            Motion::Keep => {}
            Motion::Stop => self.stop(commands),
            Motion::Turn(heading_rad) => {
                self.told = WheelReference::STOP;
                let offset_rad = situation.at.map_from_odom.se2().yaw_rad;
                let heading_in_odom_rad = wrap_to_pi(heading_rad - offset_rad);
                commands.push(Command::TurnTo { heading_in_odom_rad });
            }
            Motion::Wheels(wheels) => self.drive(wheels, situation, around, commands),
        }
    }

    /// Turns the wheels so, or more slowly on the same arc where what was heard is too near for that.
    fn drive(
        &mut self,
        wheels: WheelReference,
        situation: &Situation,
        around: &Surroundings,
        commands: &mut Vec<Command>,
    ) {
        self.told = match &self.deaf {
            Some(rule) => {
                let pose = situation.at.pose_at_command(situation.now);
                rule.slowed(wheels, pose, around.echoes())
            }
            None => wheels,
        };
        let asked_mps = wheels.linear_mps();
        self.ratio = if asked_mps == 0.0 { 1.0 } else { self.told.linear_mps() / asked_mps };
        commands.push(Command::Drive(to_wheels(self.told)));
    }

    pub(crate) fn stop(&mut self, commands: &mut Vec<Command>) {
        self.told = WheelReference::STOP;
        self.ratio = 1.0;
        commands.push(Command::Stop);
    }
}
