//! An LD06 or LD19: it turns from the moment it has power, and tells what it sees.
//!
//! Differences from the device: the speed is constant and there is no PWM pin; the filter that the
//! maker's firmware applies to lone points is unknown and left out.

use std::time::Duration;

use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};
use wire::ld06::{BAUD, CLOCK_WRAP_MS, N_POINTS, Packet, Point, TURN_CDEG};

use super::{Head, LaserConfig, clockwise_steps};
use crate::{Board, BoardStatus, MotorReference, Port};

/// Firmware of an LD06.
#[derive(Clone, Debug)]
pub struct Ld06Firmware {
    head: Head,
    /// The packet that fills, and how many points it has.
    packet: Packet,
    n_points: usize,
    n_packets: u64,
}

impl Ld06Firmware {
    /// A laser that has just got power.
    pub fn new(config: LaserConfig, rng: RandomStream) -> Self {
        let turn_s = config.model.turn.max(Duration::from_millis(1)).as_secs_f64();
        let packet = Packet { speed_degps: (360.0 / turn_s).round() as u16, ..Packet::default() };
        Self { head: Head::new(&config, rng), packet, n_points: 0, n_packets: 0 }
    }

    /// Packets sent so far.
    pub fn n_packets(&self) -> u64 {
        self.n_packets
    }
}

impl Board for Ld06Firmware {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        // It has no wire to hear by.
        let mut unheard = Vec::new();
        let out = ports.first_mut().map_or(&mut unheard, |port| &mut *port.out);
        self.head.sweep.start(now);
        let (packet, n_points, n_packets) =
            (&mut self.packet, &mut self.n_points, &mut self.n_packets);
        self.head.fire(now, world, body_id, |beam| {
            let angle_cdeg = clockwise_steps(beam.bearing_rad, TURN_CDEG);
            if *n_points == 0 {
                packet.start_cdeg = angle_cdeg;
            }
            let point = &mut packet.points[*n_points];
            *point = Point::default();
            if beam.echo.is_something() {
                // Casts from floats saturate.
                point.distance_mm = (beam.echo.range_m * 1000.0).round() as u16;
                point.intensity = (beam.echo.strength_ratio * 255.0).round().max(1.0) as u8;
            }
            *n_points += 1;
            if *n_points == N_POINTS {
                *n_points = 0;
                packet.end_cdeg = angle_cdeg;
                let clock_ms = beam.at.as_nanos() / 1_000_000 % u64::from(CLOCK_WRAP_MS);
                packet.clock_ms = clock_ms as u16;
                out.extend_from_slice(&packet.encode());
                *n_packets += 1;
            }
        });
        None
    }

    fn hang_up(&mut self, _port_index: usize) {}

    fn status(&self) -> BoardStatus {
        BoardStatus { baud: Some(BAUD), ..BoardStatus::default() }
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        self.head.absorb_state(hash);
        hash.absorb_u64(self.n_packets);
        hash.absorb_u64(self.n_points as u64);
    }
}
