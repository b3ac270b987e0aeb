//! A Pioneer's driver among others.

use messages::{Command, N_RING_MAX, Observations};
use robot_models::RobotModel;
use run_context::Stamp;
use wire::arcos::Command as Packet;

use super::{
    packets::send,
    settings::{PioneerDriverConfig, PioneerSettings},
    state::PioneerDriver,
};
use crate::{Driver, DriverConfig};

/// The fastest wheel speed that Pioneers allow when switched on, m/s.
const FACTORY_SPEED_MAX_MPS: f64 = 0.75;

/// STOPs for a robot that will hear nothing for a while: one may be lost.
const N_HOLDS: usize = 3;

impl Driver for PioneerDriver {
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        Self::step(self, now, received, observations, out);
    }

    fn command(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        Self::command(self, now, command, out);
    }

    fn disconnect(&mut self, now: Stamp, out: &mut Vec<u8>) {
        Self::disconnect(self, now, out);
    }

    fn hold(&self, out: &mut Vec<u8>) {
        for _ in 0..N_HOLDS {
            send(&Packet::Stop, out);
        }
    }

    fn is_connected(&self) -> bool {
        Self::is_connected(self)
    }
}

impl PioneerDriver {
    /// The driver for a robot of the catalogue.
    pub(crate) fn for_robot(model: &RobotModel, config: &DriverConfig) -> Box<dyn Driver> {
        Box::new(Self::new(PioneerDriverConfig {
            wheelbase_m: model.drive.wheelbase_m,
            settings: settings(model, config),
            n_sonars: model.sonars.len().min(N_RING_MAX),
            sonar_range_max_m: config.range_max_m,
            line: config.line,
            ..PioneerDriverConfig::default()
        }))
    }
}

/// Limits that have to be set because the robot's own are others.
fn settings(model: &RobotModel, config: &DriverConfig) -> PioneerSettings {
    let other = |wanted: f64, own: f64| ((wanted - own).abs() > 1e-6).then_some(wanted);
    let speed_mps = config.wheel_speed_max_mps.min(model.limits.speed_max_mps);
    PioneerSettings {
        speed_max_mps: (speed_mps > FACTORY_SPEED_MAX_MPS).then_some(speed_mps),
        acceleration_mps2: other(config.acceleration_mps2, model.limits.acceleration_max_mps2),
        ..PioneerSettings::default()
    }
}
