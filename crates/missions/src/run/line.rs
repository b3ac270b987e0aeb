//! A line: a byte pipe between the navigation node and another one, or the same messages without bytes.
//!
//! It is one thing, whatever is at its far end: a driver at the near end, a pipe (in memory and in virtual time, or to
//! elsewhere), what answers at the far end, and a tap. On a *direct* line messages are handed over at once, by
//! something that stands for both ends. A robot has as many as its mission wires, and whoever steps them knows
//! none of them by name.

use std::{fmt::Debug, time::Duration};

use drivers::Driver;
use messages::{Command, Observations};
use robot_models::RobotModel;
use run_context::{Stamp, StateHash};
use simulator::{BodyId, World};
use virtual_robots::MotorReference;
use wire::link::{End, Link, misread};

use super::tap::Tap;
use crate::{
    cut::{Cuts, Direction, Line as Which},
    node::desk::Desk,
    transport::{Transport, TransportError},
    view::{LogLevel, SceneLink},
};

/// What the ends of a robot's lines may see in a step, and the desk at the ground.
#[derive(Debug)]
pub(crate) struct Around<'a> {
    pub(crate) now: Stamp,
    pub(crate) world: &'a World,
    /// The robot's body; `None` for a robot elsewhere.
    pub(crate) body: Option<BodyId>,
    pub(crate) desk: &'a mut Desk,
}

/// What answers at the far end of a line of bytes.
pub(crate) trait Far: Debug + Send + Sync {
    /// Takes what has arrived; appends what it sends.
    fn step(&mut self, around: &mut Around<'_>, received: &[u8], out: &mut Vec<u8>);

    /// What it asks of the motors of the body; `None` when it drives none.
    fn reference(&self) -> Option<MotorReference> {
        None
    }

    /// The speed at which it speaks and listens, bits per second, if it has one of its own.
    fn baud(&self) -> Option<u32> {
        None
    }

    /// What it counted, if it is a server.
    fn traffic(&self) -> Option<Traffic> {
        None
    }

    fn absorb_state(&self, _hash: &mut StateHash) {}
}

/// Both ends of a line that carries messages instead of bytes.
pub(crate) trait Direct: Debug + Send + Sync {
    /// Appends what reaches the navigation node.
    fn step(&mut self, around: &mut Around<'_>, observations: &mut Observations);

    /// Takes a command of the navigator.
    fn command(&mut self, _command: &Command, _desk: &mut Desk) {}

    /// Cuts or mends it; away is from the navigation node.
    fn set_cut(&mut self, direction: Direction, cut: bool);

    /// Whether the other end is heard.
    fn is_connected(&self) -> bool {
        true
    }

    /// What it asks of the motors of a body of that model; `None` when it drives none.
    fn reference(&self, _model: &RobotModel) -> Option<MotorReference> {
        None
    }

    fn absorb_state(&self, _hash: &mut StateHash) {}
}

/// What a server counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Traffic {
    pub(crate) received_bytes: u64,
    pub(crate) n_questions: u64,
    pub(crate) n_errors: u64,
}

/// Working memory of a node, kept between steps so that none is allocated.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// What reached the navigation node in this step.
    pub(crate) observations: Observations,
    received: Vec<u8>,
    out: Vec<u8>,
}

/// One line of a robot's navigation node.
#[derive(Debug)]
pub(crate) struct Line {
    which: Which,
    name: String,
    far_name: &'static str,
    protocol: Option<String>,
    /// Bits per second, 0 without limit.
    baud: u32,
    pipe: Pipe,
    tap: Option<Box<Tap>>,
}

/// How it is laid.
#[derive(Debug)]
pub(crate) enum Pipe {
    /// Bytes in virtual time to something that is simulated.
    Memory(Box<Wired>),
    /// Bytes to something elsewhere.
    Elsewhere(Box<Elsewhere>),
    /// Messages, handed over at once.
    Direct(Box<dyn Direct>),
}

/// A link and what is at its two ends. End A is the navigation node.
#[derive(Debug)]
pub(crate) struct Wired {
    link: Link,
    near: Box<dyn Driver>,
    far: Box<dyn Far>,
    /// The speeds of the two ends, bits per second, where the device has one of its own.
    speeds: Option<[u32; 2]>,
}

/// The way to something elsewhere.
///
/// When it is dropped, whatever the reason, the other end is told to stop and the session is closed.
pub(crate) struct Elsewhere {
    transport: Box<dyn Transport>,
    near: Box<dyn Driver>,
    cuts: Cuts,
    /// When bytes were exchanged last.
    now: Stamp,
    /// Why it is of no use any more; taken once it has been told.
    broken: Option<TransportError>,
    is_broken: bool,
}

/// What a line is called and what can be read on it.
#[derive(Clone, Debug)]
pub(crate) struct LineName {
    pub(crate) which: Which,
    /// In lists of lines and in messages.
    pub(crate) name: String,
    /// The node at its far end.
    pub(crate) far: &'static str,
    /// What is spoken on it, as [`wire::reader`] knows it.
    pub(crate) protocol: Option<String>,
    /// Bits per second, 0 without limit.
    pub(crate) baud: u32,
}

impl Line {
    pub(crate) fn new(named: LineName, pipe: Pipe) -> Self {
        let LineName { which, name, far, protocol, baud } = named;
        Self { which, name, far_name: far, protocol, baud, pipe, tap: None }
    }

    /// The far end first, then what reaches the navigation node.
    pub(crate) fn step(&mut self, around: &mut Around<'_>, scratch: &mut Scratch) {
        let Scratch { observations, received, out } = scratch;
        received.clear();
        out.clear();
        let now = around.now;
        let n_outward = match &mut self.pipe {
            Pipe::Direct(both) => return both.step(around, observations),
            Pipe::Memory(wired) => {
                let Wired { link, near, far, speeds } = &mut **wired;
                receive(link, End::B, now, speeds.as_ref(), received);
                far.step(around, received, out);
                link.send(End::B, now, out);
                let n_arrived = received.len();
                out.clear();
                receive(link, End::A, now, speeds.as_ref(), received);
                near.step(now, &received[n_arrived..], observations, out);
                link.send(End::A, now, out);
                if let Some(speeds) = speeds {
                    self.baud = follow(link, speeds, &**near, &**far);
                }
                n_arrived
            }
            Pipe::Elsewhere(way) => {
                way.receive(now, out);
                way.near.step(now, out, observations, received);
                way.send(now, received);
                let n_sent = received.len();
                received.extend_from_slice(out);
                n_sent
            }
        };
        if let Some(tap) = &mut self.tap {
            let (outward, inward) = received.split_at(n_outward);
            tap.read(self.far_name, outward, inward);
        }
    }

    /// Sends a command of the navigator to whom it may concern.
    pub(crate) fn command(
        &mut self,
        now: Stamp,
        command: &Command,
        desk: &mut Desk,
        scratch: &mut Scratch,
    ) {
        let out = &mut scratch.out;
        out.clear();
        match &mut self.pipe {
            Pipe::Direct(both) => both.command(command, desk),
            Pipe::Memory(wired) => {
                wired.near.command(now, command, out);
                wired.link.send(End::A, now, out);
            }
            Pipe::Elsewhere(way) => {
                way.near.command(now, command, out);
                if out.is_empty() {
                    return;
                }
                way.send(now, out);
                if let Some(tap) = &mut self.tap {
                    tap.read(self.far_name, out, &[]);
                }
            }
        }
    }

    /// Tells a robot elsewhere to stand. Its driver will not know: to it no time passes.
    pub(crate) fn hold(&mut self) {
        if let Pipe::Elsewhere(way) = &mut self.pipe {
            let mut out = Vec::new();
            way.near.hold(&mut out);
            way.send(way.now, &out);
        }
    }

    /// Cuts or mends it; away is from the navigation node.
    pub(crate) fn set_cut(&mut self, direction: Direction, cut: bool) {
        match &mut self.pipe {
            Pipe::Direct(both) => both.set_cut(direction, cut),
            Pipe::Elsewhere(way) => way.cuts.set(direction, cut),
            Pipe::Memory(wired) => {
                let [away, back] = direction.ways();
                if away {
                    wired.link.set_cut(End::A, cut);
                }
                if back {
                    wired.link.set_cut(End::B, cut);
                }
            }
        }
    }

    /// Hands over what people should know of it, each once.
    pub(crate) fn take_news(&mut self, mut tell: impl FnMut(LogLevel, String)) {
        let near = match &mut self.pipe {
            Pipe::Direct(_) => return,
            Pipe::Memory(wired) => &mut wired.near,
            Pipe::Elsewhere(way) => {
                if let Some(error) = way.broken.take() {
                    tell(LogLevel::Bad, error.to_string());
                }
                &mut way.near
            }
        };
        while let Some(trouble) = near.take_trouble() {
            tell(if trouble.is_over { LogLevel::Good } else { LogLevel::Bad }, trouble.text);
        }
    }

    pub(crate) fn which(&self) -> Which {
        self.which
    }

    /// Whether the navigation node hears from the other end.
    pub(crate) fn is_connected(&self) -> bool {
        match &self.pipe {
            Pipe::Direct(both) => both.is_connected(),
            Pipe::Memory(wired) => wired.near.is_connected(),
            Pipe::Elsewhere(way) => way.near.is_connected() && !way.is_broken,
        }
    }

    /// What its far end asks of the motors of a body of that model; `None` when it drives none.
    pub(crate) fn reference(&self, model: &RobotModel) -> Option<MotorReference> {
        match &self.pipe {
            Pipe::Direct(both) => both.reference(model),
            Pipe::Memory(wired) => wired.far.reference(),
            Pipe::Elsewhere(_) => None,
        }
    }

    /// Share of the time until `now` that its busier direction was in use; `None` without a link.
    pub(crate) fn busy_ratio(&self, now: Stamp) -> Option<f64> {
        let Pipe::Memory(wired) = &self.pipe else { return None };
        let sent = |end| wired.link.counters(end).n_sent;
        let busier = sent(End::A).max(sent(End::B)) as f64;
        let byte_time = match self.baud {
            0 => Duration::ZERO,
            baud => Duration::from_secs(10) / baud,
        };
        Some(busier * byte_time.as_secs_f64() / now.as_secs_f64().max(1e-9))
    }

    /// What the server at its far end counted.
    pub(crate) fn traffic(&self) -> Option<Traffic> {
        match &self.pipe {
            Pipe::Memory(wired) => wired.far.traffic(),
            Pipe::Direct(_) | Pipe::Elsewhere(_) => None,
        }
    }

    /// As screens show it: a line of robot number `robot`; `of` is its name where there are several.
    pub(crate) fn scene(&self, robot: usize, of: Option<&str>) -> SceneLink {
        let name = match of {
            Some(robot) => format!("{} of {robot}", self.name),
            None => self.name.clone(),
        };
        let ends = [super::tap::NEAR, self.far_name];
        SceneLink { name, ends, baud: self.baud, robot, line: self.which }
    }

    /// Begins or ends reading along.
    pub(crate) fn set_trace(&mut self, on: bool) {
        self.tap = on.then(|| Box::new(Tap::new(self.protocol.as_deref())));
    }

    pub(crate) fn tap(&mut self) -> Option<&mut Tap> {
        self.tap.as_deref_mut()
    }

    pub(crate) fn absorb_state(&self, hash: &mut StateHash) {
        match &self.pipe {
            Pipe::Direct(both) => both.absorb_state(hash),
            Pipe::Memory(wired) => wired.far.absorb_state(hash),
            Pipe::Elsewhere(_) => {}
        }
    }
}

impl Wired {
    /// `baud` is the speed of the near end, bits per second, where that matters: a device that speaks at another is not
    /// understood.
    pub(crate) fn new(
        mut link: Link,
        near: Box<dyn Driver>,
        far: Box<dyn Far>,
        baud: Option<u32>,
    ) -> Self {
        let mut speeds = baud.zip(far.baud()).map(<[u32; 2]>::from);
        if let Some(speeds) = &mut speeds {
            link.set_baud(End::B, speeds[1]);
            follow(&mut link, speeds, &*near, &*far);
        }
        Self { link, near, far, speeds }
    }
}

impl Elsewhere {
    pub(crate) fn new(transport: Box<dyn Transport>, near: Box<dyn Driver>) -> Self {
        let (cuts, now) = (Cuts::default(), Stamp::ZERO);
        Self { transport, near, cuts, now, broken: None, is_broken: false }
    }

    fn send(&mut self, now: Stamp, bytes: &[u8]) {
        self.now = now;
        if !self.cuts.away {
            let sent = self.transport.send(now, bytes);
            self.note(sent);
        }
    }

    fn receive(&mut self, now: Stamp, into: &mut Vec<u8>) {
        let heard = into.len();
        let received = self.transport.receive(now, into);
        self.note(received);
        if self.cuts.back {
            into.truncate(heard);
        }
    }

    fn note(&mut self, done: Result<(), TransportError>) {
        if let Err(error) = done
            && !std::mem::replace(&mut self.is_broken, true)
        {
            self.broken = Some(error);
        }
    }
}

impl Debug for Elsewhere {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Elsewhere").field("near", &self.near).finish_non_exhaustive()
    }
}

impl Drop for Elsewhere {
    fn drop(&mut self) {
        let mut out = Vec::new();
        self.near.disconnect(self.now, &mut out);
        // If the line is broken, the robot's own watchdog has to stop it.
        let _unheard = self.transport.send(self.now, &out);
    }
}

/// What has arrived at an end; noise, when the other end speaks at another speed.
fn receive(link: &mut Link, end: End, now: Stamp, speeds: Option<&[u32; 2]>, into: &mut Vec<u8>) {
    let n_before = into.len();
    link.receive(end, now, into);
    let Some([near, far]) = speeds else { return };
    if near != far && into.len() > n_before {
        let sent = into.split_off(n_before);
        let (from, to) = if end == End::A { (*far, *near) } else { (*near, *far) };
        misread(&sent, from, to, into);
    }
}

/// Lets the link follow the speeds that its two ends have now; the near one's, bits per second.
fn follow(link: &mut Link, speeds: &mut [u32; 2], near: &dyn Driver, far: &dyn Far) -> u32 {
    let now = [near.wanted_baud().unwrap_or(speeds[0]), far.baud().unwrap_or(speeds[1])];
    // What is under way was sent at the speed before.
    if now != *speeds && link.is_idle() {
        *speeds = now;
        link.set_baud(End::A, now[0]);
        link.set_baud(End::B, now[1]);
    }
    speeds[0]
}
