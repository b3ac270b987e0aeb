//! A Pioneer among other boards.

use std::{sync::Arc, time::Duration};

use robot_models::RobotModel;
use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};

use super::{PioneerConfig, PioneerFirmware, bumper_places::N_SEGMENTS};
use crate::{BatteryStatus, Board, BoardConfig, BoardStatus, MotorReference, Port, SimRequest};

impl Board for PioneerFirmware {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        let reference = match ports.first_mut() {
            Some(port) => Self::step(self, now, port.received, world, body_id, port.out),
            None => Self::step(self, now, &[], world, body_id, &mut Vec::new()),
        };
        Some(reference)
    }

    fn hang_up(&mut self, _port_index: usize) {
        Self::hang_up(self);
    }

    fn status(&self) -> BoardStatus {
        BoardStatus {
            is_open: self.is_open(),
            motors_enabled: self.motors_enabled,
            n_heard: self.counters.n_packets,
            unknown: self.unknown,
            battery: Some(BatteryStatus {
                charge_percent: self.battery.charge_percent(),
                voltage_v: self.battery.voltage_v(),
                is_low: self.battery.is_low(),
            }),
            baud: None,
        }
    }

    fn take_requests(&mut self, into: &mut Vec<SimRequest>) {
        into.append(&mut self.sim_requests);
    }

    fn note_interval(&mut self, interval: Duration) {
        Self::note_interval(self, interval);
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        Self::absorb_state(self, hash);
    }
}

impl PioneerFirmware {
    /// The firmware of a model of the catalogue, with the watchdog that the model has.
    pub(crate) fn board(
        model: Arc<RobotModel>,
        config: &BoardConfig,
        rng: RandomStream,
    ) -> Box<dyn Board> {
        let watchdog = model.line.as_ref().and_then(|line| line.watchdog).unwrap_or_default();
        let BoardConfig { name, battery } = config.clone();
        let config = PioneerConfig { name, watchdog, battery, ..PioneerConfig::default() };
        Box::new(Self::new(model, config, rng))
    }

    /// Segments of the bumpers that something lies against, front and rear.
    pub(super) fn pressed(&mut self, world: &World, body_id: BodyId) -> [u8; 2] {
        let bits = self.bumpers.pressed(world, body_id);
        let ring = (1 << N_SEGMENTS) - 1;
        // Both rings together have ten bits.
        [(bits & ring) as u8, (bits >> N_SEGMENTS) as u8]
    }
}
