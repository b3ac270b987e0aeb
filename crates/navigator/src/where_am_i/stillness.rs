//! Whether a robot stands, by what its wheels report.

use std::time::Duration;

use robot_models::WheelSpeeds;
use run_context::Stamp;

use crate::values::Rest;

/// Wheels slower than this stand, metres per second: a Pioneer reports whole millimetres per second.
const STILL_MPS: f64 = 0.01;

/// A wheel slower than this stands well enough to turn in place, metres per second.
const STANDS_MPS: f64 = 0.03;

/// So long both wheels must have been reported standing before the robot counts as at rest.
const STILL_FOR: Duration = Duration::from_millis(200);

/// Since when the wheels have been reported standing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stillness {
    since: Option<Stamp>,
    latest: Stamp,
}

impl Stillness {
    /// Takes a report that is about `about`.
    pub(crate) fn note(&mut self, about: Stamp, wheels: WheelSpeeds) {
        let stands = wheels.left_mps.abs() < STILL_MPS && wheels.right_mps.abs() < STILL_MPS;
        self.since = if stands { self.since.or(Some(about)) } else { None };
        self.latest = about;
    }

    /// How it stands with wheels that were just reported so; at rest when all reports of the last 200 ms, and at least
    /// two, say that it stands.
    pub(crate) fn rest(&self, wheels: WheelSpeeds) -> Rest {
        let slow = wheels.left_mps.abs() < STANDS_MPS && wheels.right_mps.abs() < STANDS_MPS;
        match self.since {
            _ if !slow => Rest::Moves,
            Some(since) if self.latest.since(since) >= STILL_FOR => Rest::Settled,
            _ => Rest::Stands,
        }
    }
}
