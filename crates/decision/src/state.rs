//! What a machine sends, logs and stands on.

use run_context::Stamp;

use crate::{Code, ResourceId, clock::DateTime};

/// A goal for the robot, sent by `MOVE`. In the frame of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MoveCommand {
    /// Millimetres.
    pub x_mm: i16,
    /// Millimetres.
    pub y_mm: i16,
    /// Degrees, counter-clockwise, −360 to 360.
    pub heading_deg: i16,
    /// Which `MOVE` of this machine it is, from 1. [`Machine::report_move`](crate::Machine::report_move) takes it back.
    pub number: u64,
}

/// What the outputs do while no program drives them: before the first scan, while `QRUN` is 0,
/// after a fault, and from a reset to the end of the next scan. The default is off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Failsafe {
    /// Outputs that go to 1; bit n is output n. All others go to 0.
    pub on: u16,
    /// Outputs that stay as they were, whatever `on` says.
    pub hold: u16,
}

/// An entry of the event log, made by `EVENT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// When, on the run's clock.
    pub at: Stamp,
    /// When, on the machine's own clock.
    pub clock: DateTime,
    /// The number the program gave it, 0 to 15.
    pub kind: u8,
    /// The resource that did it.
    pub resource: ResourceId,
    /// Its history byte then.
    pub history: u8,
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One instruction was executed; the scan goes on.
    Executed,
    /// The instruction ended the scan.
    EndOfScan,
    /// `QRUN` is 0: nothing was executed.
    Stopped,
    /// Listing mode only: the instruction will be repeated for ever.
    Hung,
    /// The machine stands on a fault until it is reset.
    Faulted,
}

/// Why the machine stopped by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// One of the `R8xxx` codes.
    pub code: Code,
    /// Offset in the image.
    pub address: usize,
}
