//! Boards in a world of their own, tick by tick: what network ports or a serial bridge need behind
//! them.

use std::{ops::Range, time::Duration};

use geometry::Se2;
use run_context::Stamp;
use simulator::{Body, BodyId, World, WorldError};

use crate::{Board, Port, SimRequest};

/// A world whose robots talk to somebody outside, each board over lines of its own.
///
/// The caller owns the clock: it calls [`tick`](Self::tick) as often as virtual time should
/// pass, once per [`World`] step, and carries the bytes. Lines are numbered from 0 through all boards, as they were
/// admitted, and their ports.
#[derive(Debug)]
pub struct ServedWorld {
    world: World,
    boards: Vec<ServedBoard>,
    requests: Vec<SimRequest>,
}

/// One board of a [`ServedWorld`]. A body may have several, of which one drives it.
#[derive(Debug)]
pub struct ServedBoard {
    body_id: BodyId,
    board: Box<dyn Board>,
    lines: Range<usize>,
    start: Se2,
}

/// The bytes of one line in one tick.
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
    /// The firmware tells why it does what it does.
    Noted(String),
}

impl ServedWorld {
    /// A world without robots that are served; bodies in it that never get a board stand.
    pub fn new(world: World) -> Self {
        Self { world, boards: Vec::new(), requests: Vec::new() }
    }

    /// Puts a board into a body of the world; the board's number, from 0.
    ///
    /// # Panics
    ///
    /// When `body_id` is of another world.
    pub fn admit(&mut self, body_id: BodyId, board: Box<dyn Board>) -> usize {
        let start = self.world.body(body_id).world_from_base.se2();
        let first = self.n_lines();
        let lines = first..first + board.ports().len();
        self.boards.push(ServedBoard { body_id, board, lines, start });
        self.boards.len() - 1
    }

    /// How many lines all boards have together.
    pub fn n_lines(&self) -> usize {
        self.boards.last().map_or(0, |board| board.lines.end)
    }

    /// Passes one step of the world; `exchanges[i]` belongs to line i, and a line without one
    /// hears nothing and is not heard. What happened is appended to `events` with the board's
    /// number.
    pub fn tick(&mut self, exchanges: &mut [Exchange], events: &mut Vec<(usize, ServedEvent)>) {
        let now = self.world.now();
        let mut rest = exchanges;
        for served in &mut self.boards {
            let ours;
            (ours, rest) = rest.split_at_mut(served.lines.len().min(rest.len()));
            let port = Exchange::port;
            let reference = match ours {
                // Most robots have one port, for which nothing needs to be allocated.
                [one] => served.step(now, &self.world, &mut [port(one)]),
                ours => {
                    let mut ports: Vec<Port<'_>> = ours.iter_mut().map(port).collect();
                    served.step(now, &self.world, &mut ports)
                }
            };
            if let Some(reference) = reference {
                self.world.set_acceleration(served.body_id, reference.acceleration_mps2);
                self.world.set_wheel_reference(served.body_id, reference.wheels);
            }
        }
        for (index, served) in self.boards.iter_mut().enumerate() {
            served.board.take_requests(&mut self.requests);
            for request in self.requests.drain(..) {
                let event = match request {
                    SimRequest::PlaceAt(pose) => place(&mut self.world, served.body_id, pose),
                    SimRequest::Reset => place(&mut self.world, served.body_id, served.start),
                    SimRequest::Say(text) => ServedEvent::Said(text),
                    SimRequest::Exit(code) => ServedEvent::ExitAsked(code),
                    SimRequest::Note(text) => ServedEvent::Noted(text),
                };
                events.push((index, event));
            }
        }
        self.world.step();
    }

    /// The client of a line is gone; the board does what it does then.
    pub fn hang_up(&mut self, line: usize) {
        if let Some(served) = self.boards.iter_mut().find(|served| served.lines.contains(&line)) {
            served.board.hang_up(line - served.lines.start);
        }
    }

    /// The real time that the last turn of the caller's loop took: clients can ask for it.
    pub fn note_interval(&mut self, interval: Duration) {
        self.boards.iter_mut().for_each(|served| served.board.note_interval(interval));
    }

    /// Virtual time passed.
    pub fn now(&self) -> Stamp {
        self.world.now()
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The boards, in the order in which they came.
    pub fn boards(&self) -> &[ServedBoard] {
        &self.boards
    }

    /// The body of a board.
    pub fn body_of(&self, served: &ServedBoard) -> &Body {
        self.world.body(served.body_id)
    }
}

impl Exchange {
    fn port(&mut self) -> Port<'_> {
        Port { received: &self.received, out: &mut self.out }
    }
}

impl ServedBoard {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        ports: &mut [Port<'_>],
    ) -> Option<crate::MotorReference> {
        self.board.step(now, world, self.body_id, ports)
    }

    /// The firmware.
    pub fn board(&self) -> &dyn Board {
        &*self.board
    }

    /// The body that it is on.
    pub fn body_id(&self) -> BodyId {
        self.body_id
    }

    /// The numbers of its lines.
    pub fn lines(&self) -> Range<usize> {
        self.lines.clone()
    }

    /// Where its body began, in the world.
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
