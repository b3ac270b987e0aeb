//! Firmware for simulated bodies: it answers the bytes the real robot answers.
//!
//! A [`Board`] is firmware on a body: it reads encoders, echoes and bumpers, never the true pose, and asks for
//! wheel speeds; what is between its ports and a client is the caller's business: a simulated link, a socket, a
//! serial port. [`board`] builds the one that a robot of the catalogue has, by the protocol that its file names:
//!
//! - [`PioneerFirmware`]: the robot's side of [`wire::arcos`];
//! - [`CreateFirmware`]: the robot's side of [`wire::create_oi`].
//!
//! Scanning lasers are boards of their own on the same body, built by [`laser_board`]: [`SickLmsFirmware`],
//! [`RplidarFirmware`], [`Ld06Firmware`].
//!
//! [`ServedWorld`] is a caller for clients outside: boards in a world of their own.
//!
//! Nothing here reads a clock or opens a socket.

mod board;
mod bumpers;
mod create;
mod laser;
mod pioneer;
mod registry;
mod served;

pub use board::{
    BatteryConfig, BatteryStatus, Board, BoardConfig, BoardStatus, MotorReference, NumberSet, Port,
    SimRequest,
};
pub use create::CreateFirmware;
pub use laser::{
    LaserConfig, Ld06Firmware, RplidarFirmware, SickLmsFirmware, laser_baud, laser_board,
};
pub use pioneer::{FirmwareCounters, MotorFeedback, PioneerConfig, PioneerFirmware};
pub use registry::{NoBoard, board, has_board};
pub use served::{Exchange, ServedBoard, ServedEvent, ServedWorld};
