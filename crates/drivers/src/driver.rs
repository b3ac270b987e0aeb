//! What every driver is to those who run it: the host's end of a line.
//!
//! A trait and not an enum, because a robot or a sensor can come from outside this crate. Who steps drivers (a mission, a
//! test) needs no robot's, sensor's or server's name.

use std::{fmt::Debug, time::Duration};

use messages::{Command, Observations};
use run_context::Stamp;

/// The host's end of one line: received bytes become observations, commands become bytes.
///
/// It connects by itself at its first steps and again whenever the other end was lost, and the driver of a robot goes by
/// one rule: whoever loses sight stops first. It ends with wheels at rest. It never panics on bytes, whatever
/// they are.
pub trait Driver: Debug + Send + Sync {
    /// Takes received bytes; appends what was observed and what is to be sent.
    ///
    /// Call it every few milliseconds, with or without bytes; `now` never goes back. Each observation says
    /// when it was true, as well as the driver knows.
    fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    );

    /// Sends a command of the navigator. While there is no connection motion commands are forgotten; commands
    /// for other drivers are passed over.
    fn command(&mut self, _now: Stamp, _command: &Command, _out: &mut Vec<u8>) {}

    /// Ends the session, in whatever state it is: wheels at rest, connection closed.
    fn disconnect(&mut self, _now: Stamp, _out: &mut Vec<u8>) {}

    /// Appends what makes a robot stand for as long as its driver sends nothing; the driver will not know of it.
    fn hold(&self, _out: &mut Vec<u8>) {}

    /// Whether the other end is heard, as far as that can be told.
    fn is_connected(&self) -> bool {
        true
    }

    /// The speed at which its end of the line speaks and listens from now on, bits per second; `None`: as it is.
    fn wanted_baud(&self) -> Option<u32> {
        None
    }

    /// What people should know of the device, each once: a trouble, with the device's name and what to do, or its end.
    fn take_trouble(&mut self) -> Option<Trouble> {
        None
    }
}

/// What a driver has to say of its device to people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trouble {
    /// Whether it is the end of what was wrong.
    pub is_over: bool,
    /// What is wrong, or was.
    pub text: String,
}

/// What a driver has to know of its task, whatever the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverConfig {
    /// The fastest that a wheel will be asked to turn, m/s: a robot that allows less until it is told is told.
    pub wheel_speed_max_mps: f64,
    /// The acceleration that the navigator reckons with, m/s².
    pub acceleration_mps2: f64,
    /// Range that stands for «nothing heard», m.
    pub range_max_m: f64,
    /// What the way of bytes takes.
    pub line: LineTiming,
}

/// What the way of bytes takes, so that their content can be dated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineTiming {
    /// Line speed, bits per second at 10 bits per byte; `None` takes no time.
    pub baud: Option<u32>,
    /// Delay besides.
    pub latency: Duration,
}

impl LineTiming {
    /// When a packet of `n_bytes` that has just arrived was sent.
    pub fn sent_at(self, now: Stamp, n_bytes: usize) -> Stamp {
        let bits = 10 * n_bytes as u64;
        let nanos = self.baud.and_then(|baud| (bits * 1_000_000_000).checked_div(baud.into()));
        let way = self.latency + Duration::from_nanos(nanos.unwrap_or(0));
        let way_nanos = u64::try_from(way.as_nanos()).unwrap_or(u64::MAX);
        Stamp::from_nanos(now.as_nanos().saturating_sub(way_nanos))
    }
}
