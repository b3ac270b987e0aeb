//! One robot alone in a world, tick by tick: what a network port or a serial bridge needs behind
//! it.

use geometry::Se2;
use run_context::Stamp;
use simulator::{BodyId, World};

use crate::{PioneerFirmware, SimPose};

/// A world with one robot whose firmware talks to somebody outside.
///
/// The caller owns the clock: it calls [`tick`](Self::tick) as often as virtual time should
/// pass, once per [`World`] step, and carries the bytes.
#[derive(Debug)]
pub struct SoloRobot {
    world: World,
    body_id: BodyId,
    firmware: PioneerFirmware,
    start: Se2,
    n_refused_poses: u64,
}

impl SoloRobot {
    /// Puts the firmware into the body.
    pub fn new(world: World, body_id: BodyId, firmware: PioneerFirmware) -> Self {
        let start = world.body(body_id).world_from_base.se2();
        Self { world, body_id, firmware, start, n_refused_poses: 0 }
    }

    /// Passes one step of the world: `received` are the client's bytes since the last tick, the
    /// robot's are appended to `out`.
    pub fn tick(&mut self, received: &[u8], out: &mut Vec<u8>) {
        let now = self.world.now();
        let reference = self.firmware.step(now, received, &self.world, self.body_id, out);
        self.world.set_acceleration(self.body_id, reference.acceleration_mps2);
        self.world.set_wheel_reference(self.body_id, reference.wheels);
        match self.firmware.take_sim_pose() {
            None => {}
            Some(SimPose::At(pose)) => self.put(pose),
            Some(SimPose::Start) => self.put(self.start),
        }
        self.world.step();
    }

    /// The client is gone; the robot stops and waits for the next one.
    pub fn hang_up(&mut self) {
        self.firmware.hang_up();
    }

    /// Virtual time passed.
    pub fn now(&self) -> Stamp {
        self.world.now()
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The robot's body.
    pub fn body_id(&self) -> BodyId {
        self.body_id
    }

    /// The robot's firmware.
    pub fn firmware(&self) -> &PioneerFirmware {
        &self.firmware
    }

    /// How often a client asked for the robot to be put where the world has no room for it.
    pub fn n_refused_poses(&self) -> u64 {
        self.n_refused_poses
    }

    fn put(&mut self, pose: Se2) {
        if self.world.relocate_robot(self.body_id, pose).is_err() {
            self.n_refused_poses += 1;
        }
    }
}
