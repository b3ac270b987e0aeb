//! The client of an RPLIDAR A1: stops what was going on, asks who and how it is, and lets it scan.

use std::time::Duration;

use run_context::Stamp;
use sensor_models::{BeamSight, LaserKind, PlanarScan};
use wire::rplidar::{Answer, BAUD, Decoder, Health, Info, NODE_LEN, Node, Request};

use super::{LaserDriver, LaserDriverConfig, LaserTrouble, TakeNews, watch::Watch};

/// After a stop the device needs a moment; the maker's SDK waits as long.
const AFTER_STOP: Duration = Duration::from_millis(100);
/// Time to wait for an answer.
const ANSWER_MAX: Duration = Duration::from_secs(1);
/// Time that a restart takes.
const AFTER_RESET: Duration = Duration::from_secs(2);
/// Time from the request to the first turn, in which the motor may have to start.
const FIRST_TURN_MAX: Duration = Duration::from_secs(4);
/// Status of a device that has stopped to protect itself.
const STATUS_ERROR: u8 = 2;

/// The driver of one RPLIDAR A1.
#[derive(Clone, Debug)]
pub struct RplidarDriver {
    decoder: Decoder,
    watch: Watch,
    phase: Phase,
    since: Stamp,
    info: Option<Info>,
    health: Option<Health>,
    /// When the first sample of the growing turn came; `None` before the first turn begins.
    turn_began: Option<Stamp>,
    n_restarts: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing was said yet.
    New,
    Stopping,
    AskingInfo,
    AskingHealth,
    Resetting,
    Scanning,
}

impl RplidarDriver {
    /// A driver that will look for its laser at its first step.
    pub fn new(config: LaserDriverConfig) -> Self {
        Self {
            decoder: Decoder::new(),
            watch: Watch::new(config, LaserKind::RplidarA1, BAUD),
            phase: Phase::New,
            since: Stamp::ZERO,
            info: None,
            health: None,
            turn_began: None,
            n_restarts: 0,
        }
    }

    /// Who the device is, once known.
    pub fn info(&self) -> Option<Info> {
        self.info
    }

    /// How it said that it feels.
    pub fn health(&self) -> Option<Health> {
        self.health
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    /// Times that it was begun anew, because an answer or samples did not come.
    pub fn n_restarts(&self) -> u64 {
        self.n_restarts
    }

    fn enter(&mut self, now: Stamp, phase: Phase, out: &mut Vec<u8>) {
        self.phase = phase;
        self.since = now;
        self.turn_began = None;
        self.decoder.expect_descriptor();
        match phase {
            Phase::New => {}
            Phase::Stopping => Request::Stop.encode(out),
            Phase::AskingInfo => Request::Info.encode(out),
            Phase::AskingHealth => Request::Health.encode(out),
            Phase::Resetting => Request::Reset.encode(out),
            Phase::Scanning => Request::Scan.encode(out),
        }
    }

    fn keep_up(&mut self, now: Stamp, out: &mut Vec<u8>) {
        let waited = now.since(self.since);
        let next = match self.phase {
            Phase::New => Phase::Stopping,
            Phase::Stopping if waited >= AFTER_STOP => Phase::AskingInfo,
            Phase::Resetting if waited >= AFTER_RESET => Phase::Stopping,
            Phase::AskingInfo | Phase::AskingHealth if waited >= ANSWER_MAX => Phase::Stopping,
            Phase::Scanning
                if waited >= FIRST_TURN_MAX
                    && self.watch.blind_for(now) >= self.watch.config.silence_max =>
            {
                Phase::Stopping
            }
            _ => return,
        };
        if next == Phase::Stopping && self.phase != Phase::New {
            self.n_restarts += 1;
        }
        self.enter(now, next, out);
    }

    fn take_answer(&mut self, now: Stamp, answer: Answer, take: TakeNews<'_>, out: &mut Vec<u8>) {
        match (self.phase, answer) {
            (Phase::AskingInfo, Answer::Info(info)) => {
                self.info = Some(info);
                self.enter(now, Phase::AskingHealth, out);
            }
            (Phase::AskingHealth, Answer::Health(health)) => {
                self.health = Some(health);
                if health.status >= STATUS_ERROR {
                    self.watch.why = Some(format!(
                        "it reports error {:#06x} and protects itself; it is restarted, and if that does not help, see \
                         whether its head turns freely",
                        health.error
                    ));
                    self.enter(now, Phase::Resetting, out);
                } else {
                    self.enter(now, Phase::Scanning, out);
                }
            }
            (Phase::Scanning, Answer::Node(node)) => self.take_node(now, node, take),
            _ => {}
        }
    }

    fn take_node(&mut self, now: Stamp, node: Node, take: TakeNews<'_>) {
        let at = self.watch.config.line.sent_at(now, NODE_LEN);
        if node.is_first {
            if let Some(began) = self.turn_began {
                self.date(began, at);
                self.watch.finish(now, take);
            }
            self.watch.growing.beams.clear();
            self.turn_began = Some(at);
        }
        if self.turn_began.is_none() {
            return;
        }
        let sight = match node.distance_q2 {
            0 => BeamSight::NoReturn,
            quarters => BeamSight::Surface(f64::from(quarters) / 4000.0),
        };
        let clockwise_rad = (f64::from(node.angle_q6) / 64.0).to_radians();
        self.watch.add(-clockwise_rad, 0.0, sight, f64::from(node.quality) / 63.0);
    }

    /// Samples are evenly spaced in time; only a turn's ends are dated by their arrival.
    fn date(&mut self, began: Stamp, ended: Stamp) {
        let growing = &mut self.watch.growing;
        growing.about = began;
        let step_s = ended.since(began).as_secs_f64() / growing.beams.len().max(1) as f64;
        for (index, beam) in growing.beams.iter_mut().enumerate() {
            beam.after_s = index as f64 * step_s;
        }
    }
}

impl LaserDriver for RplidarDriver {
    fn step(&mut self, now: Stamp, received: &[u8], take: TakeNews<'_>, out: &mut Vec<u8>) {
        self.watch.hear(now, received.len());
        self.decoder.push(received);
        while let Some(answer) = self.decoder.next_answer() {
            self.watch.understand();
            self.take_answer(now, answer, take, out);
        }
        // Samples have no checksum; five skipped bytes are one.
        let n_lost = self.decoder.n_bytes_skipped() / NODE_LEN as u64;
        self.watch.count(now, self.decoder.n_nodes(), n_lost);
        self.keep_up(now, out);
        self.watch.judge(now, take);
    }

    fn latest(&self, now: Stamp) -> Option<&PlanarScan> {
        self.watch.latest(now)
    }

    fn trouble(&self) -> Option<&LaserTrouble> {
        self.watch.trouble()
    }

    fn disconnect(&mut self, out: &mut Vec<u8>) {
        Request::Stop.encode(out);
        self.phase = Phase::New;
        self.decoder.expect_descriptor();
    }
}
