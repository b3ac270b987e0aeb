//! Scanning lasers: boards that look at the world and drive nothing.
//!
//! A laser is a [`Board`] of its own on a robot's body, with one port. [`laser_board`] builds the one that a
//! [`LaserConfig`] asks for. Each fires its beams as time passes, from where its sensor is then, and speaks
//! as its maker's: [`wire::sick_lms`], [`wire::rplidar`], [`wire::ld06`].

mod ld06;
mod rplidar;
mod sick_lms;
#[cfg(test)]
mod tests;

use std::time::Duration;

use geometry::Se2;
use run_context::{RandomStream, Stamp, StateHash};
use sensor_models::{Beam, LaserKind, LaserModel, Sweep};
use simulator::{BodyId, World};

pub use self::{ld06::Ld06Firmware, rplidar::RplidarFirmware, sick_lms::SickLmsFirmware};
use crate::Board;

/// What one laser on a robot has of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserConfig {
    /// Which laser, and so which bytes.
    pub kind: LaserKind,
    /// How it measures; should be [`checked`](LaserModel::checked). Angles and beams of a SICK are set by its
    /// client.
    pub model: LaserModel,
    /// Where its sensor is on the robot, x ahead of the point midway between the wheels.
    pub base_from_sensor: Se2,
    /// Whether its bytes leave at the speed of its line, as on a serial cable: what a SICK measures while a
    /// scan is still leaving is not sent. Otherwise everything leaves at once, as over a socket.
    pub is_paced: bool,
}

impl LaserConfig {
    /// A laser as delivered, at that place.
    pub fn new(kind: LaserKind, base_from_sensor: Se2) -> Self {
        Self { kind, model: kind.model(), base_from_sensor, is_paced: false }
    }
}

/// Firmware of a laser that has just been switched on; `rng` is the randomness of its measurements.
pub fn laser_board(config: LaserConfig, rng: RandomStream) -> Box<dyn Board> {
    match config.kind {
        LaserKind::SickLms => Box::new(SickLmsFirmware::new(config, rng)),
        LaserKind::RplidarA1 => Box::new(RplidarFirmware::new(config, rng)),
        LaserKind::Ld06 => Box::new(Ld06Firmware::new(config, rng)),
    }
}

/// The speed at which a laser's line begins, bits per second.
pub fn laser_baud(kind: LaserKind) -> u32 {
    match kind {
        LaserKind::SickLms => wire::sick_lms::BAUD_START,
        LaserKind::RplidarA1 => wire::rplidar::BAUD,
        LaserKind::Ld06 => wire::ld06::BAUD,
    }
}

/// The part that looks: all three lasers have one.
#[derive(Clone, Debug)]
struct Head {
    sweep: Sweep,
    base_from_sensor: Se2,
    /// Every beam so far, in order.
    seen: StateHash,
}

impl Head {
    fn new(config: &LaserConfig, rng: RandomStream) -> Self {
        Self {
            sweep: Sweep::new(config.model, rng),
            base_from_sensor: config.base_from_sensor,
            seen: StateHash::new(),
        }
    }

    /// Fires the beams that are due.
    fn fire(&mut self, now: Stamp, world: &World, body_id: BodyId, mut take: impl FnMut(Beam)) {
        let world_from_base = world.body(body_id).world_from_base.se2();
        let world_from_sensor = world_from_base.compose(self.base_from_sensor);
        let (scene, seen) = (world.scene(Some(body_id)), &mut self.seen);
        self.sweep.fire(now, world_from_sensor, &scene, world.materials(), |beam| {
            seen.absorb_u64(beam.echo.range_m.to_bits());
            take(beam);
        });
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.seen.value());
        self.sweep.absorb_state(hash);
    }
}

/// The line out: busy while bytes leave.
#[derive(Clone, Copy, Debug)]
struct LineOut {
    is_paced: bool,
    free_at: Stamp,
}

impl LineOut {
    fn new(is_paced: bool) -> Self {
        Self { is_paced, free_at: Stamp::ZERO }
    }

    fn is_free(self, now: Stamp) -> bool {
        !self.is_paced || self.free_at <= now
    }

    /// So many bytes are given to it.
    fn take(&mut self, now: Stamp, n_bytes: usize, baud: u32) {
        // Start, eight data, stop.
        let nanos = (n_bytes as u64).saturating_mul(10_000_000_000) / u64::from(baud.max(1));
        self.free_at = self.free_at.max(now) + Duration::from_nanos(nanos);
    }
}

/// Angle of a beam from the sensor's x axis, clockwise, in steps of which `n_steps` are a turn.
fn clockwise_steps(bearing_rad: f64, n_steps: u16) -> u16 {
    let steps = -bearing_rad / std::f64::consts::TAU * f64::from(n_steps);
    // Below a turn, so the cast loses nothing.
    (steps.round().rem_euclid(f64::from(n_steps))) as u16
}
