//! Firmware for simulated bodies: it answers the bytes the real robot answers.
//!
//! [`PioneerFirmware`] is the robot's side of [`wire::arcos`]. It reads encoder counts and sonar
//! echoes of a body, never the true pose, and asks for wheel speeds; what is between it and a
//! client is the caller's business: a simulated link, a socket, a serial port. [`ServedWorld`] is a
//! caller for clients outside: robots in a world of their own.
//!
//! Nothing here reads a clock or opens a socket.

mod pioneer;
mod served;

pub use pioneer::{
    BatteryConfig, FirmwareCounters, MotorFeedback, MotorReference, PioneerConfig, PioneerFirmware,
    SimRequest,
};
pub use served::{Exchange, ServedEvent, ServedRobot, ServedWorld};
