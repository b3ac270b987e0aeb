//! Robots in a world of their own, tick by tick: what network ports or a serial bridge need behind
//! them.

use std::time::Duration;

use geometry::Se2;
use run_context::Stamp;
use simulator::{Body, BodyId, World, WorldError};

use crate::{PioneerFirmware, SimRequest};

/// A world whose robots talk to somebody outside, each over its own line.
///
/// The caller owns the clock: it calls [`tick`](Self::tick) as often as virtual time should
/// pass, once per [`World`] step, and carries the bytes.
#[derive(Debug)]
pub struct ServedWorld {
    world: World,
    robots: Vec<ServedRobot>,
}

/// One robot of a [`ServedWorld`].
#[derive(Debug)]
pub struct ServedRobot {
    body_id: BodyId,
    firmware: PioneerFirmware,
    start: Se2,
}

/// The bytes of one robot's line in one tick.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    /// What its client has sent since the last tick.
    pub received: Vec<u8>,
    /// What it answers is appended here.
    pub out: Vec<u8>,
}

/// Something that happened in a tick and that whoever watches may want to know.
#[derive(Clone, Debug)]
pub enum ServedEvent {
    /// A client moved the robot to this pose in the world.
    Placed(Se2),
    /// A client wanted the robot where it cannot stand.
    PlaceRefused(Se2, WorldError),
    /// A client wants this to be read; from a stranger, up to 195 bytes.
    Said(String),
    /// A client wants the simulator to end with this code.
    ExitAsked(i16),
}

impl ServedWorld {
    /// A world without robots that are served; bodies in it that never get a firmware stand.
    pub fn new(world: World) -> Self {
        Self { world, robots: Vec::new() }
    }

    /// Puts firmware into a body of the world; the robot's number, from 0.
    ///
    /// # Panics
    ///
    /// When `body_id` is of another world.
    pub fn admit(&mut self, body_id: BodyId, firmware: PioneerFirmware) -> usize {
        let start = self.world.body(body_id).world_from_base.se2();
        self.robots.push(ServedRobot { body_id, firmware, start });
        self.robots.len() - 1
    }

    /// Passes one step of the world; `exchanges[i]` belongs to robot i, and a robot without one
    /// hears nothing and is not heard. What happened is appended to `events` with the robot's
    /// number.
    pub fn tick(&mut self, exchanges: &mut [Exchange], events: &mut Vec<(usize, ServedEvent)>) {
        let now = self.world.now();
        let mut unheard = Vec::new();
        for (index, robot) in self.robots.iter_mut().enumerate() {
            let (received, out) = match exchanges.get_mut(index) {
                Some(Exchange { received, out }) => (received.as_slice(), out),
                None => (&[][..], &mut unheard),
            };
            let reference = robot.firmware.step(now, received, &self.world, robot.body_id, out);
            self.world.set_acceleration(robot.body_id, reference.acceleration_mps2);
            self.world.set_wheel_reference(robot.body_id, reference.wheels);
        }
        for (index, robot) in self.robots.iter_mut().enumerate() {
            for request in robot.firmware.take_sim_requests() {
                let event = match request {
                    SimRequest::PlaceAt(pose) => place(&mut self.world, robot.body_id, pose),
                    SimRequest::Reset => place(&mut self.world, robot.body_id, robot.start),
                    SimRequest::Say(text) => ServedEvent::Said(text),
                    SimRequest::Exit(code) => ServedEvent::ExitAsked(code),
                };
                events.push((index, event));
            }
        }
        self.world.step();
    }

    /// The client of robot `index` is gone; it stops and waits for the next one.
    pub fn hang_up(&mut self, index: usize) {
        if let Some(robot) = self.robots.get_mut(index) {
            robot.firmware.hang_up();
        }
    }

    /// The real time that the last turn of the caller's loop took: clients can ask for it.
    pub fn note_interval(&mut self, interval: Duration) {
        self.robots.iter_mut().for_each(|robot| robot.firmware.note_interval(interval));
    }

    /// Virtual time passed.
    pub fn now(&self) -> Stamp {
        self.world.now()
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The robots, in the order in which they came.
    pub fn robots(&self) -> &[ServedRobot] {
        &self.robots
    }

    /// The body of a robot.
    pub fn body_of(&self, robot: &ServedRobot) -> &Body {
        self.world.body(robot.body_id)
    }
}

impl ServedRobot {
    /// The robot's firmware.
    pub fn firmware(&self) -> &PioneerFirmware {
        &self.firmware
    }

    /// Where it began, in the world.
    pub fn start(&self) -> Se2 {
        self.start
    }
}

fn place(world: &mut World, body_id: BodyId, pose: Se2) -> ServedEvent {
    match world.relocate_robot(body_id, pose) {
        Ok(()) => ServedEvent::Placed(pose),
        Err(error) => ServedEvent::PlaceRefused(pose, error),
    }
}
