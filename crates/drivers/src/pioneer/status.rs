//! From an information packet to a status in SI units.

use geometry::{Se2, Transform2};
use messages::{
    Battery, Contacts, Motors, N_RING_MAX, Observations, OdometryReading, Ring, Sensed, age_ms,
};
use robot_models::WheelSpeeds;
use run_context::Stamp;
use wire::arcos::Sip;

use super::packets::FLAG_MOTORS;

/// Positions wrap after so many millimetres.
const WRAP_MM: i64 = 1 << 15;

/// Keeps what one packet does not say: whole turns of the position counters, older sonar ranges.
#[derive(Clone, Debug)]
pub(super) struct StatusReader {
    position_mm: [Option<i64>; 2],
    sonar_ranges_m: [f64; N_RING_MAX],
    sonar_stamps: [Stamp; N_RING_MAX],
    n_sonars: usize,
    range_max_m: f64,
}

impl StatusReader {
    pub(super) fn new(n_sonars: usize, range_max_m: f64) -> Self {
        Self {
            position_mm: [None; 2],
            sonar_ranges_m: [range_max_m; N_RING_MAX],
            sonar_stamps: [Stamp::ZERO; N_RING_MAX],
            n_sonars: n_sonars.min(N_RING_MAX),
            range_max_m,
        }
    }

    /// What a packet says, device by device. It does not say when a sonar was heard: its own time stands for that.
    pub(super) fn read(&mut self, about: Stamp, sip: &Sip, observations: &mut Observations) {
        let enabled = sip.flags & FLAG_MOTORS != 0;
        observations.push(about, Sensed::Motors(Motors { enabled }));
        let voltage_v = 0.1 * f64::from(sip.battery_decivolts);
        observations.push(about, Sensed::Battery(Battery { voltage_v }));
        let [front, rear] = sip.bumpers();
        observations.push(
            about,
            Sensed::Contact(Contacts {
                stalled: [sip.stall_left & 1 != 0, sip.stall_right & 1 != 0],
                bumpers: u16::from(front) | u16::from(rear) << 8,
                ..Contacts::default()
            }),
        );
        let odometry = self.odometry(sip);
        observations.push(about, Sensed::Odometry(odometry));
        if self.n_sonars > 0 {
            let ring = self.ring(about, sip);
            observations.push(about, Sensed::Ring(ring));
        }
    }

    fn ring(&mut self, about: Stamp, sip: &Sip) -> Ring {
        let mut sonar_fresh = 0;
        for reading in sip.sonar() {
            let index = usize::from(reading.sensor);
            if index < self.n_sonars
                && let Some(range_m) = self.sonar_ranges_m.get_mut(index)
            {
                self.sonar_stamps[index] = about;
                *range_m = (0.001 * f64::from(reading.range_mm)).min(self.range_max_m);
                sonar_fresh |= 1 << index;
            }
        }
        Ring {
            ranges_m: self.sonar_ranges_m,
            ages_ms: self.sonar_stamps.map(|measured| age_ms(measured, about)),
            n_sensors: self.n_sonars,
            fresh: sonar_fresh,
        }
    }

    fn odometry(&mut self, sip: &Sip) -> OdometryReading {
        let [x_mm, y_mm] = &mut self.position_mm;
        let pose = Se2::new(
            0.001 * unwrap(x_mm, sip.x_mm) as f64,
            0.001 * unwrap(y_mm, sip.y_mm) as f64,
            sip.heading_rad(),
        );
        OdometryReading {
            odom_from_base: Transform2::new(pose),
            wheel_speeds: WheelSpeeds {
                left_mps: 0.001 * f64::from(sip.left_mmps),
                right_mps: 0.001 * f64::from(sip.right_mmps),
            },
            moving: sip.moving,
        }
    }
}

/// The position, mm, that ends in the 15 bits `wrapped` and is nearest to the last one, which it
/// replaces. The first one is within ±16.384 m.
fn unwrap(last_mm: &mut Option<i64>, wrapped: u16) -> i64 {
    let reference = last_mm.unwrap_or(0);
    let ahead = (i64::from(wrapped) - reference).rem_euclid(WRAP_MM);
    let step = if ahead >= WRAP_MM / 2 { ahead - WRAP_MM } else { ahead };
    let position = reference + step;
    *last_mm = Some(position);
    position
}
