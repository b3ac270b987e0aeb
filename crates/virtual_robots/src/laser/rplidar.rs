//! An RPLIDAR A1: it answers, and sends samples while somebody wants them.
//!
//! The motor turns from power-on, as when the host's DTR line is clear; a PWM of 0 stops it, and samples
//! come once it has been turning for [`SPIN_UP`]. Any request ends a scan.
//!
//! Differences from the device: the speed is constant; express scans and configuration queries mean nothing
//! to it, as to early firmware, whose version it reports; it is never unwell; it says nothing after a
//! reset.

use std::time::Duration;

use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};
use wire::rplidar::{
    AnswerKind, BAUD, Health, Info, Node, Request, RequestDecoder, SampleTimes, TURN_Q6,
};

use super::{Head, LaserConfig, clockwise_steps};
use crate::{Board, BoardStatus, MotorReference, NumberSet, Port};

/// Time from the motor's start to a stable speed.
const SPIN_UP: Duration = Duration::from_secs(1);
/// Time after a reset in which nothing is heard.
const RESET_TIME: Duration = Duration::from_millis(500);
/// A request that stays unfinished for this long is noise.
const UNFINISHED_MAX: Duration = Duration::from_millis(100);
/// An A1M8 with firmware 1.20, the last before configuration queries.
const INFO: Info = Info {
    model: 0x18,
    firmware_minor: 20,
    firmware_major: 1,
    hardware: 0,
    serial: *b"cairn-rplidar-a1",
};
/// Quality of a white surface met head-on, of 63.
const QUALITY_MAX: f64 = 47.0;

/// Firmware of an RPLIDAR A1.
#[derive(Clone, Debug)]
pub struct RplidarFirmware {
    head: Head,
    decoder: RequestDecoder,
    is_scanning: bool,
    /// Since when the motor turns.
    turns_since: Option<Stamp>,
    /// Nothing is heard until then.
    deaf_until: Stamp,
    last_byte: Stamp,
    standard_us: u16,
    unknown: NumberSet,
    n_nodes: u64,
}

impl RplidarFirmware {
    /// A laser that has just been switched on.
    pub fn new(config: LaserConfig, rng: RandomStream) -> Self {
        let n_beams = config.model.n_beams.max(1) as u128;
        Self {
            head: Head::new(&config, rng),
            decoder: RequestDecoder::new(),
            is_scanning: false,
            turns_since: Some(Stamp::ZERO),
            deaf_until: Stamp::ZERO,
            last_byte: Stamp::ZERO,
            standard_us: (config.model.turn.as_micros() / n_beams).min(u16::MAX.into()) as u16,
            unknown: NumberSet::default(),
            n_nodes: 0,
        }
    }

    /// Samples sent so far.
    pub fn n_nodes(&self) -> u64 {
        self.n_nodes
    }

    fn end_scan(&mut self) {
        self.is_scanning = false;
        self.head.sweep.stop();
    }

    fn answer(&mut self, now: Stamp, request: &Request, out: &mut Vec<u8>) {
        let mut say = |kind: AnswerKind, packet: &[u8]| {
            out.extend_from_slice(&kind.descriptor());
            out.extend_from_slice(packet);
        };
        match request {
            Request::MotorPwm(pwm) => {
                if *pwm == 0 {
                    self.turns_since = None;
                    self.end_scan();
                } else {
                    self.turns_since.get_or_insert(now);
                }
                return;
            }
            Request::Scan | Request::ForceScan => {
                say(AnswerKind::Nodes, &[]);
                self.head.sweep.stop();
                self.is_scanning = true;
                return;
            }
            Request::Stop => {}
            Request::Reset => {
                self.deaf_until = now + RESET_TIME;
                self.turns_since = Some(now);
            }
            Request::Info => say(AnswerKind::Info, &INFO.encode()),
            Request::Health => say(AnswerKind::Health, &Health::default().encode()),
            Request::SampleTimes => {
                let times =
                    SampleTimes { standard_us: self.standard_us, express_us: self.standard_us };
                say(AnswerKind::SampleTimes, &times.encode());
            }
            // The A1's board drives its motor by DTR alone.
            Request::AdapterFlags => say(AnswerKind::AdapterFlags, &0_u32.to_le_bytes()),
            Request::Other(command, _) => self.unknown.insert(*command),
        }
        self.end_scan();
    }

    fn sample(&mut self, now: Stamp, world: &World, body_id: BodyId, out: &mut Vec<u8>) {
        let is_stable = self
            .turns_since
            .is_some_and(|since| since == Stamp::ZERO || now.since(since) >= SPIN_UP);
        if !self.is_scanning || !is_stable {
            return;
        }
        self.head.sweep.start(now);
        let n_nodes = &mut self.n_nodes;
        self.head.fire(now, world, body_id, |beam| {
            let mut node = Node {
                is_first: beam.is_first,
                angle_q6: clockwise_steps(beam.bearing_rad, TURN_Q6),
                ..Node::default()
            };
            if beam.echo.is_something() {
                // Casts from floats saturate.
                node.distance_q2 = (beam.echo.range_m * 4000.0).round() as u16;
                let quality = (beam.echo.strength_ratio * QUALITY_MAX).round();
                node.quality = quality.clamp(1.0, QUALITY_MAX) as u8;
            }
            out.extend_from_slice(&node.encode());
            *n_nodes += 1;
        });
    }
}

impl Board for RplidarFirmware {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        let port = ports.first_mut()?;
        if now < self.deaf_until {
            return None;
        }
        if !port.received.is_empty() {
            self.last_byte = now;
            self.decoder.push(port.received);
        } else if now.since(self.last_byte) >= UNFINISHED_MAX {
            self.decoder.give_up_unfinished();
        }
        while let Some(request) = self.decoder.next_request() {
            self.answer(now, &request, port.out);
        }
        self.sample(now, world, body_id, port.out);
        None
    }

    /// The port was closed: DTR rises, and what was asked for is forgotten.
    fn hang_up(&mut self, _port_index: usize) {
        self.end_scan();
        self.turns_since = Some(Stamp::ZERO);
        self.decoder = RequestDecoder::new();
        self.unknown = NumberSet::default();
    }

    fn status(&self) -> BoardStatus {
        BoardStatus {
            is_open: self.is_scanning,
            n_heard: self.decoder.n_requests(),
            unknown: self.unknown,
            baud: Some(BAUD),
            ..BoardStatus::default()
        }
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        self.head.absorb_state(hash);
        hash.absorb_u64(self.n_nodes);
        hash.absorb_u64(self.is_scanning.into());
        hash.absorb_u64(self.decoder.n_requests());
        hash.absorb_u64(self.turns_since.map_or(u64::MAX, Stamp::as_nanos));
        hash.absorb_u64(self.deaf_until.as_nanos());
    }
}
