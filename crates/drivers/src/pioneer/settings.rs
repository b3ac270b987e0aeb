//! How a Pioneer's driver is set up, and what it counts.

use std::time::Duration;

use wire::arcos::{Command as Packet, ConfigPac};

use crate::LineTiming;

/// Which packets a wheel-speed reference becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveCommand {
    /// VEL2: steps of 20 mm/s per wheel, as in the thesis.
    #[default]
    Vel2,
    /// VEL and RVEL: steps of 1 mm/s and 1 deg/s.
    VelAndRVel,
}

/// Limits to set after connecting; `None` leaves the robot's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PioneerSettings {
    /// SETV, m/s.
    pub speed_max_mps: Option<f64>,
    /// SETA, positive and negative, m/s².
    pub acceleration_mps2: Option<f64>,
    /// SETRV, rad/s.
    pub turn_rate_max_radps: Option<f64>,
    /// SETRA, positive and negative, rad/s².
    pub turn_acceleration_radps2: Option<f64>,
}

/// How to talk to one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PioneerDriverConfig {
    /// Which packets a wheel-speed reference becomes.
    pub drive_command: DriveCommand,
    /// Distance between the wheels, m; turns wheel speeds into VEL and RVEL.
    pub wheelbase_m: f64,
    /// Limits to set after connecting.
    pub settings: PioneerSettings,
    /// How many sonars the navigator sees, at most 16; readings of others are passed over.
    pub n_sonars: usize,
    /// Range that stands for «nothing heard», m.
    pub sonar_range_max_m: f64,
    /// Whether to ask for encoder packets.
    pub encoder_packets: bool,
    /// Time between heartbeats; the robot's watchdog stops it after two seconds of silence.
    pub heartbeat: Duration,
    /// Time to wait for an echo.
    pub echo_timeout: Duration,
    /// Time without an information packet after which the connection counts as lost.
    pub silence_max: Duration,
    /// What a packet's way takes.
    pub line: LineTiming,
}

/// What the driver did and met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PioneerCounters {
    /// Information packets understood.
    pub n_sips: u64,
    /// Packets with a right checksum that could not be read.
    pub n_unreadable: u64,
    /// Connections made.
    pub n_connections: u64,
    /// Times a step of connecting had to be begun again.
    pub n_retries: u64,
    /// Packets sent again because the robot reported that their effect was missing.
    pub n_mended: u64,
    /// Times that the robot was lost: it was not heard any more, or did not hear.
    pub n_losses: u64,
}

impl Default for PioneerDriverConfig {
    fn default() -> Self {
        Self {
            drive_command: DriveCommand::Vel2,
            wheelbase_m: 0.38,
            settings: PioneerSettings::default(),
            n_sonars: messages::N_RING_MAX,
            sonar_range_max_m: 5.0,
            encoder_packets: false,
            heartbeat: Duration::from_millis(800),
            echo_timeout: Duration::from_millis(500),
            silence_max: Duration::from_secs(1),
            line: LineTiming::default(),
        }
    }
}

impl PioneerSettings {
    pub(super) fn packets(&self) -> [Option<Packet>; 6] {
        let millimetres = |metres: f64| (1000.0 * metres).round() as i16;
        let degrees = |rad: f64| rad.to_degrees().round() as i16;
        [
            self.speed_max_mps.map(|mps| Packet::SetV(millimetres(mps))),
            self.acceleration_mps2.map(|mps2| Packet::SetA(millimetres(mps2))),
            self.acceleration_mps2.map(|mps2| Packet::SetA(-millimetres(mps2))),
            self.turn_rate_max_radps.map(|radps| Packet::SetRv(degrees(radps))),
            self.turn_acceleration_radps2.map(|radps2| Packet::SetRa(degrees(radps2))),
            self.turn_acceleration_radps2.map(|radps2| Packet::SetRa(-degrees(radps2))),
        ]
    }

    /// Whether the robot's configuration is what these settings ask for.
    pub(super) fn agree_with(&self, config: &ConfigPac) -> bool {
        self.packets().iter().flatten().all(|packet| match *packet {
            Packet::SetV(mmps) => same(mmps, config.speed_max_mmps),
            Packet::SetA(mmps2) if mmps2 < 0 => same(-mmps2, config.deceleration_mmps2),
            Packet::SetA(mmps2) => same(mmps2, config.acceleration_mmps2),
            Packet::SetRv(degps) => same(degps, config.rotation_max_degps),
            Packet::SetRa(degps2) if degps2 < 0 => {
                same(-degps2, config.rotation_deceleration_degps2)
            }
            Packet::SetRa(degps2) => same(degps2, config.rotation_acceleration_degps2),
            _ => true,
        })
    }
}

fn same(sent: i16, reported: u16) -> bool {
    u16::try_from(sent) == Ok(reported)
}
