//! Questions to the pheromone server: one at a time, answered or given up.

use std::time::Duration;

use messages::{Command, Observations, Sensed, Smell};
use run_context::Stamp;
use wire::{
    dle::{ByteOrder, Framing, Receiver},
    pheromone_link::{Reply, Request},
};

use crate::Driver;

/// Opcodes go round from 1 to this, so that a late reply is told from the awaited one. 16 would be
/// a DLE, which costs two more bytes on the wire.
const OPCODE_MAX: u8 = 15;

/// How a vehicle talks to the pheromone server.
#[derive(Clone, Debug, PartialEq)]
pub struct PheromoneClientConfig {
    /// The vehicle's number; replies to other vehicles are ignored.
    pub robot_id: u8,
    /// Order of the bytes of coordinates.
    pub byte_order: ByteOrder,
    /// Whether DLEs in the payload are doubled.
    pub framing: Framing,
    /// Time after which a question counts as lost. At 9600 baud question and answer take 27 ms on
    /// the wire.
    pub timeout: Duration,
}

/// What became of the questions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PheromoneCounters {
    /// Questions sent.
    pub n_asked: u64,
    /// Questions answered in time.
    pub n_answered: u64,
    /// Questions given up.
    pub n_timeouts: u64,
    /// Replies that nobody waited for any more, or that were for others.
    pub n_dropped: u64,
    /// Questions replaced by a newer one before they could be sent.
    pub n_replaced: u64,
}

/// The vehicle's end of the pheromone link.
///
/// One question is under way at a time. A question asked meanwhile waits, and a still newer one
/// takes its place.
#[derive(Clone, Debug)]
pub struct PheromoneClient {
    config: PheromoneClientConfig,
    receiver: Receiver,
    opcode: u8,
    awaited: Option<Awaited>,
    waiting: Option<Question>,
    counters: PheromoneCounters,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    query: u8,
    x_mm: i16,
    y_mm: i16,
    heading_deg: i16,
}

#[derive(Clone, Copy, Debug)]
struct Awaited {
    query: u8,
    opcode: u8,
    asked: Stamp,
}

impl Default for PheromoneClientConfig {
    fn default() -> Self {
        Self {
            robot_id: 1,
            byte_order: ByteOrder::BigEndian,
            framing: Framing::Stuffed,
            timeout: Duration::from_millis(400),
        }
    }
}

impl PheromoneClient {
    /// A client that has asked nothing yet.
    pub fn new(config: PheromoneClientConfig) -> Self {
        Self {
            config,
            receiver: Receiver::default(),
            opcode: 0,
            awaited: None,
            waiting: None,
            counters: PheromoneCounters::default(),
        }
    }

    /// Takes received bytes: an answer in time becomes an observation about the time when it was
    /// asked.
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        for &byte in received {
            let Some(payload) = self.receiver.push(byte) else { continue };
            match Reply::decode(payload) {
                Ok(reply) => self.take(reply, observations),
                Err(_) => self.counters.n_dropped += 1,
            }
        }
        if let Some(awaited) = self.awaited
            && now.since(awaited.asked) >= self.config.timeout
        {
            self.awaited = None;
            self.counters.n_timeouts += 1;
        }
        if self.awaited.is_none()
            && let Some(question) = self.waiting.take()
        {
            self.ask(now, question, out);
        }
    }

    /// Sends the question of a [`Command::QueryPheromones`]; other commands are not for this
    /// driver.
    ///
    /// The wire carries whole millimetres and degrees in 16 bits; positions beyond ±32 m are sent
    /// as ±32.767 m.
    pub fn command(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        let Command::QueryPheromones { query, map_from_base } = *command else { return };
        let pose = map_from_base.se2();
        let question = Question {
            query,
            // Casts from floats saturate.
            x_mm: (1000.0 * pose.x_m).round() as i16,
            y_mm: (1000.0 * pose.y_m).round() as i16,
            heading_deg: pose.yaw_rad.to_degrees().round() as i16,
        };
        if self.awaited.is_none() {
            self.ask(now, question, out);
        } else if self.waiting.replace(question).is_some() {
            self.counters.n_replaced += 1;
        }
    }

    /// Whether a question is under way.
    pub fn is_waiting(&self) -> bool {
        self.awaited.is_some()
    }

    /// What became of the questions.
    pub fn counters(&self) -> PheromoneCounters {
        self.counters
    }

    fn ask(&mut self, now: Stamp, question: Question, out: &mut Vec<u8>) {
        let Question { query, x_mm, y_mm, heading_deg } = question;
        self.opcode = self.opcode % OPCODE_MAX + 1;
        let request = Request {
            opcode: self.opcode,
            robot_id: self.config.robot_id,
            x_mm,
            y_mm,
            heading_deg,
        };
        request.encode(self.config.byte_order, self.config.framing, out);
        self.awaited = Some(Awaited { query, opcode: self.opcode, asked: now });
        self.counters.n_asked += 1;
    }

    fn take(&mut self, reply: Reply, observations: &mut Observations) {
        let fits = |awaited: &Awaited| {
            reply.opcode == awaited.opcode && reply.robot_id == self.config.robot_id
        };
        let Some(Awaited { query, asked, .. }) = self.awaited.filter(fits) else {
            self.counters.n_dropped += 1;
            return;
        };
        self.awaited = None;
        self.counters.n_answered += 1;
        let (left, right) = (f64::from(reply.left), f64::from(reply.right));
        observations.push(asked, Sensed::Smell(Smell { query, left, right }));
    }
}

impl Driver for PheromoneClient {
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
}
