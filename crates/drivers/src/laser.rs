//! Clients of scanning lasers: bytes to scans, and words for what is wrong.
//!
//! A [`LaserDriver`] is stepped as a robot's driver is, and hands over what it learns: whole scans
//! ([`PlanarScan`]), troubles ([`LaserTrouble`]) and their end. **What is not seen is not free**: a laser that is silent,
//! speaks noise or repeats one scan for ever has no [`latest`](LaserDriver::latest) scan at all, and beams that
//! did not arrive are [`BeamSight::Unseen`](sensor_models::BeamSight::Unseen) or absent.
//!
//! [`laser_driver`] builds the one for a kind: [`SickLmsDriver`], [`RplidarDriver`], [`Ld06Driver`]. [`LaserClient`] makes
//! any of them a [`Driver`], as every other device of a robot has one: its scans are observations.

mod client;
mod ld06;
mod rplidar;
mod sick_lms;
#[cfg(test)]
mod tests;
mod watch;

use std::{fmt::Debug, time::Duration};

use run_context::Stamp;
use sensor_models::{LaserKind, PlanarScan};

use crate::LineTiming;

pub use self::{
    client::LaserClient, ld06::Ld06Driver, rplidar::RplidarDriver, sick_lms::SickLmsDriver,
    watch::LaserTrouble,
};

/// How to talk to one laser.
#[derive(Clone, Debug, PartialEq)]
pub struct LaserDriverConfig {
    /// The name in messages.
    pub name: String,
    /// What its bytes' way takes.
    pub line: LineTiming,
    /// The speed to change to, bits per second, where laser and line allow it; the caller then follows
    /// [`LaserDriver::wanted_baud`]. `None`: the line has no speed, as a socket, or keeps its own.
    pub change_baud_to: Option<u32>,
    /// Added to every bearing, radians: where the device's zero axis is. Makers and users of the RPLIDAR A1 disagree
    /// about it.
    pub zero_axis_rad: f64,
    /// Time without a scan after which nothing is seen any more.
    pub silence_max: Duration,
    /// Time for which a laser may repeat one scan, reading by reading, before it counts as frozen; `None`: for
    /// ever, as a simulated one without errors does.
    pub frozen_after: Option<Duration>,
}

impl LaserDriverConfig {
    /// A laser of that name at a socket.
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            line: LineTiming::default(),
            change_baud_to: None,
            zero_axis_rad: 0.0,
            silence_max: Duration::from_secs(1),
            frozen_after: Some(Duration::from_secs(3)),
        }
    }
}

/// What a laser's driver learns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LaserNews<'a> {
    /// A whole scan.
    Scan(&'a PlanarScan),
    /// Something is wrong from now on; said once, until it changes.
    Trouble(&'a LaserTrouble),
    /// Scans come, and nothing is wrong any more.
    Well,
}

/// Where news go.
pub type TakeNews<'a> = &'a mut dyn FnMut(LaserNews<'_>);

/// The client of one laser.
pub trait LaserDriver: Debug + Send + Sync {
    /// Takes received bytes; hands over what they say and appends what is to be sent. Call it every few
    /// milliseconds, with or without bytes; `now` never goes back. It never panics on bytes, whatever they are.
    fn step(&mut self, now: Stamp, received: &[u8], take: TakeNews<'_>, out: &mut Vec<u8>);

    /// The newest scan; `None` when there is none that could be trusted: then nothing is known, and nothing is
    /// free.
    fn latest(&self, now: Stamp) -> Option<&PlanarScan>;

    /// What is wrong now.
    fn trouble(&self) -> Option<&LaserTrouble>;

    /// The speed at which the line should be from now on, bits per second; `None`: as it is.
    fn wanted_baud(&self) -> Option<u32> {
        None
    }

    /// Ends the session.
    fn disconnect(&mut self, out: &mut Vec<u8>);
}

/// A driver that will look for its laser at its first step.
pub fn laser_driver(kind: LaserKind, config: LaserDriverConfig) -> Box<dyn LaserDriver> {
    match kind {
        LaserKind::SickLms => Box::new(SickLmsDriver::new(config)),
        LaserKind::RplidarA1 => Box::new(RplidarDriver::new(config)),
        LaserKind::Ld06 => Box::new(Ld06Driver::new(config)),
    }
}
