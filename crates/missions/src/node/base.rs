//! A robot's own board at the far end of a line, or what stands for it: whatever the catalogue says it is.

use drivers::{Driver, DriverConfig, LineTiming};
use robot_models::WheelSpeeds;
use run_context::{RunSeed, StateHash};
use virtual_robots::{BatteryConfig, Board, BoardConfig, MotorReference, Port};

use super::direct_robot::DirectRobot;
use crate::{
    cut::Line as Which,
    mission::plan::{LinkPlan, RobotPlan},
    run::{
        error::RunError,
        line::{Around, Far, Line, LineName, Pipe},
    },
};

/// The outer wheel of a curve turns at up to so many times the cruising speed.
const OUTER_WHEEL_RATIO: f64 = 1.6;

/// A board on the robot's body.
#[derive(Debug)]
pub(super) struct OnBoard {
    board: Box<dyn Board>,
    /// What it asked of the motors last; `None` from a board that drives none.
    reference: Option<MotorReference>,
    /// Whether it speaks at a speed of its own, which its driver has to meet.
    has_speed: bool,
}

impl OnBoard {
    /// A board that drives the robot.
    fn that_drives(board: Box<dyn Board>, plan: &RobotPlan) -> Self {
        let reference = MotorReference {
            wheels: WheelSpeeds::ZERO,
            acceleration_mps2: plan.model.limits.acceleration_max_mps2,
        };
        Self { board, reference: Some(reference), has_speed: false }
    }

    /// A board that only looks.
    pub(super) fn that_looks(board: Box<dyn Board>) -> Self {
        Self { board, reference: None, has_speed: true }
    }
}

impl Far for OnBoard {
    fn step(&mut self, around: &mut Around<'_>, received: &[u8], out: &mut Vec<u8>) {
        let Some(body) = around.body else { return };
        let port = Port { received, out };
        if let Some(wanted) = self.board.step(around.now, around.world, body, &mut [port]) {
            self.reference = Some(wanted);
        }
    }

    fn reference(&self) -> Option<MotorReference> {
        self.reference
    }

    fn baud(&self) -> Option<u32> {
        if self.has_speed { self.board.status().baud } else { None }
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        self.board.absorb_state(hash);
    }
}

/// The line to the robot's own board.
pub(super) fn line(plan: &RobotPlan, seed: RunSeed) -> Result<Line, RunError> {
    let settings = |problem: String| RunError::Settings { robot: plan.name.clone(), problem };
    let driver = |timing: LineTiming| -> Result<Box<dyn Driver>, RunError> {
        let navigator = plan.navigator.settings();
        let config = DriverConfig {
            wheel_speed_max_mps: OUTER_WHEEL_RATIO * navigator.speed_mps,
            acceleration_mps2: navigator.acceleration_mps2,
            range_max_m: plan.sonar.range_max_m,
            line: timing,
        };
        drivers::driver(&plan.model, &config).map_err(|e| settings(e.to_string()))
    };
    let rng = || seed.stream(&format!("robot/{}", plan.name));
    let pipe = match &plan.link {
        LinkPlan::Direct => {
            Pipe::Direct(Box::new(DirectRobot::new(&plan.model, plan.sonar.range_max_m, rng())))
        }
        LinkPlan::Memory(config) => {
            let board = BoardConfig { name: plan.name.clone(), battery: BatteryConfig::default() };
            let board = virtual_robots::board(&plan.model, &board, rng());
            let board = board.map_err(|e| settings(e.to_string()))?;
            let far = OnBoard::that_drives(board, plan);
            let stream = format!("link/{}/robot", plan.name);
            let near = driver(super::pipe::timing(config))?;
            super::pipe::wired(config, (&plan.name, &stream, seed), near, Box::new(far))?
        }
        LinkPlan::Tcp { .. } | LinkPlan::Serial { .. } => {
            let pipe = super::pipe::elsewhere(&plan.link, &plan.name, driver)?;
            pipe.ok_or_else(|| settings("its line leads nowhere".to_owned()))?
        }
    };
    let named = LineName {
        which: Which::Robot,
        name: "robot".to_owned(),
        far: "robot",
        protocol: plan.model.protocol().map(str::to_owned),
        baud: plan.link.baud(),
    };
    Ok(Line::new(named, pipe))
}
