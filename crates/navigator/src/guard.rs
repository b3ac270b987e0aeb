//! *Guard*: nothing that was asked of the wheels is done before it; it slows it, stops it, or replaces it.
//!
//! It finds hazards on the way, says how fast what is around lets the robot be, waits and goes around by the nine-state
//! machine, and its helm is the only place that gives commands to the wheels.

mod behind;
mod bypass;
mod deaf;
mod hazards;
mod helm;
mod scene;

use geometry::Vec2;
use messages::Command;
use obstacle_avoidance::{Bubble, Footprint, MachineConfigError, State};
use path_following::WheelReference;
use run_context::Stamp;

use crate::{
    around::Surroundings,
    phase::Phase,
    says::Sentence,
    settings::{Avoidance, NavigatorSettings},
    values::{Motion, Situation},
};
use bypass::Bypass;
use deaf::DeafRule;
use hazards::{Hazards, WAY_MARGIN_M};
use helm::Helm;

pub(crate) use bypass::{Bypassing, Waiting};
pub(crate) use scene::Scene;

/// The part; see the module.
#[derive(Clone, Debug)]
pub(crate) struct Guard {
    helm: Helm,
    hazards: Hazards,
    bypass: Bypass,
    /// What a waiting robot heard on its way and does not hear any more has gone.
    forgets_cleared_ways: bool,
}

impl Guard {
    pub(crate) fn new(
        s: &NavigatorSettings,
        bubble: Bubble,
        footprint: &Footprint,
    ) -> Result<Self, MachineConfigError> {
        let may_go_deaf = s.watchdog_s > 0.0;
        let deaf = (s.avoidance == Avoidance::Checked && may_go_deaf).then(|| {
            DeafRule::new(footprint, s.drive.wheelbase_m, s.watchdog_s, s.acceleration_mps2)
        });
        Ok(Self {
            helm: Helm::new(deaf),
            hazards: Hazards::new(s.avoidance, s.limits()),
            bypass: Bypass::new(s, bubble)?,
            forgets_cleared_ways: may_go_deaf,
        })
    }

    pub(crate) fn says(&self) -> Sentence {
        let state = self.state();
        if state == State::Idle {
            return self.helm.says();
        }
        Sentence::GoesAround { state: state.name(), n_attempts: self.n_attempts() }
    }

    pub(crate) fn forget_task(&mut self, now: Stamp) {
        self.bypass.forget_task(now);
    }

    /// What the wheels were told last.
    pub(crate) fn told(&self) -> WheelReference {
        self.helm.told()
    }

    /// Hands a motion on to the robot, more slowly where it must be.
    pub(crate) fn pass(
        &mut self,
        motion: Motion,
        situation: &Situation,
        around: &Surroundings,
        commands: &mut Vec<Command>,
    ) {
        self.helm.pass(motion, situation, around, commands);
    }

    /// Stands.
    pub(crate) fn stop(&mut self, commands: &mut Vec<Command>) {
        self.helm.stop(commands);
    }

    /// Whether something stands on the way, near enough to stop for.
    pub(crate) fn is_blocked(&self, scene: Scene<'_>) -> bool {
        self.hazards.is_ahead(scene, self.helm.told())
    }

    /// What narrow places and things on the way ahead allow, m/s.
    pub(crate) fn way_speed_mps(&self, scene: Scene<'_>) -> f64 {
        self.hazards.way_speed_mps(scene)
    }

    /// The speed along a line to a point (m, map) at which the robot shall stand, where the way allows `way_mps`, m/s.
    pub(crate) fn line_speed_mps(&self, situation: &Situation, to: Vec2, way_mps: f64) -> f64 {
        self.hazards.line_speed_mps(situation, to, way_mps)
    }

    /// The phase that a robot which waits will come back to.
    pub(crate) fn resume(&self) -> Phase {
        self.bypass.resume()
    }

    /// Drives to a point (m, map) in a straight line.
    pub(crate) fn drive_to(&mut self, target: Vec2, now: Stamp) {
        self.bypass.drive_to(target, now);
    }

    /// The same, and follows the way from there on.
    pub(crate) fn join(&mut self, target: Vec2, now: Stamp) {
        self.bypass.join(target, now);
    }

    /// Something is in the way of that phase: the phase for that.
    pub(crate) fn meet(&mut self, phase: Phase, scene: Scene<'_>) -> Phase {
        self.bypass.meet(phase, scene)
    }

    /// Stands and waits, since `since`.
    pub(crate) fn wait(
        &mut self,
        since: Stamp,
        scene: Scene<'_>,
        commands: &mut Vec<Command>,
    ) -> Waiting {
        self.helm.stop(commands);
        let is_blocked = self.is_blocked(scene);
        self.bypass.wait(since, is_blocked, scene)
    }

    /// What a robot may forget that has found its way clear: what lies so near beside it (m) and was heard before.
    pub(crate) fn cleared(&self, situation: &Situation) -> Option<(f64, Stamp)> {
        self.forgets_cleared_ways.then(|| (WAY_MARGIN_M, Hazards::recent(situation)))
    }

    /// Backs off, or looks aside, if that is due; whether it is still at it.
    pub(crate) fn back_off(&mut self, scene: Scene<'_>, commands: &mut Vec<Command>) -> bool {
        self.bypass.back_off(scene, &mut self.helm, commands)
    }

    /// Whether a robot on its straight way has just met something that it may wait for, if that is a hazard.
    pub(crate) fn may_wait(&self, phase: Phase, position: Vec2) -> bool {
        self.bypass.may_wait(phase, position)
    }

    /// One control period of the machine in that phase.
    pub(crate) fn bypass(
        &mut self,
        phase: Phase,
        is_blocked: bool,
        scene: Scene<'_>,
        commands: &mut Vec<Command>,
    ) -> Bypassing {
        self.bypass.step(phase, is_blocked, scene, &mut self.helm, commands)
    }

    /// The obstacle is passed.
    pub(crate) fn end_bypass(&mut self) {
        self.bypass.end();
    }

    /// Whether the machine goes away from its way at present, and not back to it.
    pub(crate) fn is_away(&self) -> bool {
        self.bypass.is_away()
    }

    /// Whether it has a place beside its way to go to.
    pub(crate) fn is_detouring(&self) -> bool {
        self.bypass.machine().is_detouring()
    }

    /// What it drives to at present (m, map).
    pub(crate) fn target(&self) -> Option<Vec2> {
        self.bypass.machine().target()
    }

    /// The machine's state.
    pub(crate) fn state(&self) -> State {
        self.bypass.machine().state()
    }

    /// The last rebound, radians, relative to the heading then.
    pub(crate) fn rebound_rad(&self) -> Option<f64> {
        self.bypass.machine().rebound_rad()
    }

    /// Attempts on the present obstacle.
    pub(crate) fn n_attempts(&self) -> u32 {
        self.bypass.n_attempts()
    }
}
