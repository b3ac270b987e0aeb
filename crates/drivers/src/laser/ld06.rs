//! The client of an LD06 or LD19: it listens.

use std::time::Duration;

use run_context::Stamp;
use sensor_models::{BeamSight, LaserKind, PlanarScan};
use wire::ld06::{BAUD, Decoder, PACKET_LEN, Packet};

use super::{LaserDriver, LaserDriverConfig, LaserTrouble, TakeNews, watch::Watch};

/// The driver of one LD06.
#[derive(Clone, Debug)]
pub struct Ld06Driver {
    decoder: Decoder,
    watch: Watch,
    /// Angle of the last point, degrees, clockwise; `None` before the first turn has begun.
    last_deg: Option<f64>,
    /// Whether the growing scan began at a turn's beginning.
    is_whole: bool,
    n_implausible: u64,
}

impl Ld06Driver {
    /// A driver that has heard nothing.
    pub fn new(config: LaserDriverConfig) -> Self {
        let watch = Watch::new(config, LaserKind::Ld06, BAUD);
        Self { decoder: Decoder::new(), watch, last_deg: None, is_whole: false, n_implausible: 0 }
    }

    /// Packets so far whose angles could not be.
    pub fn n_implausible(&self) -> u64 {
        self.n_implausible
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    fn take_packet(&mut self, now: Stamp, packet: &Packet, take: TakeNews<'_>) {
        if !packet.is_plausible() || packet.speed_degps == 0 {
            self.n_implausible += 1;
            return;
        }
        let degrees_per_s = f64::from(packet.speed_degps);
        let last_point = self.watch.config.line.sent_at(now, PACKET_LEN);
        let step_deg = f64::from(packet.span_cdeg()) / 1100.0;
        for (index, point) in packet.points.iter().enumerate() {
            let before_s = (11 - index.min(11)) as f64 * step_deg / degrees_per_s;
            let at_nanos = Duration::from_secs_f64(before_s).as_nanos() as u64;
            let at = Stamp::from_nanos(last_point.as_nanos().saturating_sub(at_nanos));
            let angle_deg = packet.angle_deg(index);
            // A turn ends where the angle falls back.
            if self.last_deg.is_some_and(|last| angle_deg < last - 180.0) {
                if self.is_whole {
                    self.watch.finish(now, take);
                }
                self.watch.growing.beams.clear();
                self.is_whole = true;
            }
            self.last_deg = Some(angle_deg);
            if self.watch.growing.beams.is_empty() {
                self.watch.growing.about = at;
            }
            let after_s = at.as_secs_f64() - self.watch.growing.about.as_secs_f64();
            let sight = match point.distance_mm {
                0 => BeamSight::NoReturn,
                mm => BeamSight::Surface(f64::from(mm) / 1000.0),
            };
            let strength_ratio = f64::from(point.intensity) / 255.0;
            self.watch.add(-angle_deg.to_radians(), after_s, sight, strength_ratio);
        }
    }
}

impl LaserDriver for Ld06Driver {
    fn step(&mut self, now: Stamp, received: &[u8], take: TakeNews<'_>, _out: &mut Vec<u8>) {
        self.watch.hear(now, received.len());
        self.decoder.push(received);
        while let Some(packet) = self.decoder.next_packet() {
            self.watch.understand();
            self.take_packet(now, &packet, take);
        }
        self.watch.count(now, self.decoder.n_packets(), self.decoder.n_bad_checksums());
        self.watch.judge(now, take);
    }

    fn latest(&self, now: Stamp) -> Option<&PlanarScan> {
        self.watch.latest(now)
    }

    fn trouble(&self) -> Option<&LaserTrouble> {
        self.watch.trouble()
    }

    /// It cannot be told anything.
    fn disconnect(&mut self, _out: &mut Vec<u8>) {}
}
