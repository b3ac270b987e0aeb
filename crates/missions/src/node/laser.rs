//! A laser on the robot's body at the far end of a line, or its scans without bytes.

use drivers::{Driver, LaserClient, LaserDriverConfig, LineTiming};
use messages::DeviceId;
use run_context::RunSeed;
use virtual_robots::{LaserConfig, laser_board};

use super::{base::OnBoard, direct_laser::DirectLaser};
use crate::{
    cut::Line as Which,
    mission::plan::{LaserPlan, LinkPlan, RobotPlan},
    run::{
        error::RunError,
        line::{Line, LineName, Pipe},
    },
};

/// The robot's laser of that number, from 0, as observations name it: its base comes first.
pub(crate) fn device(number: usize) -> DeviceId {
    // A robot has a handful of lasers; a mission is refused that has more than these numbers.
    DeviceId(u8::try_from(number + 1).unwrap_or(u8::MAX))
}

/// The line to the robot's laser of that number.
pub(super) fn line(plan: &RobotPlan, number: usize, seed: RunSeed) -> Result<Line, RunError> {
    let laser = &plan.lasers[number];
    let settings = |problem: String| RunError::Settings { robot: plan.name.clone(), problem };
    let LaserPlan { name, kind, model, base_from_sensor, link } = laser;
    let rng = || seed.stream(&format!("laser/{}/{name}", plan.name));
    let near = |timing: LineTiming| -> Result<Box<dyn Driver>, RunError> {
        let config = LaserDriverConfig {
            line: timing,
            // Only a line that is simulated follows its driver.
            change_baud_to: timing.baud,
            ..LaserDriverConfig::named(name)
        };
        Ok(Box::new(LaserClient::new(*kind, device(number), config)))
    };
    let pipe = match link {
        LinkPlan::Direct => {
            let laser = DirectLaser::new(*model, *base_from_sensor, device(number), rng());
            Pipe::Direct(Box::new(laser))
        }
        LinkPlan::Memory(config) => {
            let board = LaserConfig {
                kind: *kind,
                model: *model,
                base_from_sensor: *base_from_sensor,
                is_paced: config.baud.is_some(),
            };
            let far = OnBoard::that_looks(laser_board(board, rng()));
            let stream = format!("link/{}/{name}", plan.name);
            let near = near(super::pipe::timing(config))?;
            super::pipe::wired(config, (&plan.name, &stream, seed), near, Box::new(far))?
        }
        LinkPlan::Tcp { .. } | LinkPlan::Serial { .. } => {
            let pipe = super::pipe::elsewhere(link, &plan.name, near)?;
            pipe.ok_or_else(|| settings(format!("the line of laser `{name}` leads nowhere")))?
        }
    };
    let named = LineName {
        which: Which::Laser(number as u8),
        name: name.clone(),
        far: "laser",
        protocol: Some(kind.protocol().to_owned()),
        baud: link.baud(),
    };
    Ok(Line::new(named, pipe))
}
