//! Packets of a Pioneer's driver, and what the robot's flags say.

use messages::Command;
use robot_models::{BodyVelocity, WheelSpeeds};
use wire::arcos::Command as Packet;

/// Metres per second in one step of VEL2.
const VEL2_STEP_MPS: f64 = 0.02;

/// Flag of an information packet: motors on.
pub(super) const FLAG_MOTORS: u16 = 1;

/// Flags of an information packet: any sonar array on.
pub(super) const FLAGS_SONAR: u16 = 0b1_1110;

/// Appends a packet. Only string arguments can be too long, and the driver sends none.
pub(super) fn send(packet: &Packet, out: &mut Vec<u8>) {
    let written = packet.encode(out);
    debug_assert!(written.is_ok(), "commands without strings always fit a packet");
}

/// Wheel speeds in steps of 20 mm/s, the nearest; ±2.54 m/s at most.
pub(super) fn vel2(wheels: WheelSpeeds) -> Packet {
    // A cast from a float saturates, and makes 0 of what is not a number.
    let step = |mps: f64| ((mps / VEL2_STEP_MPS).round() as i8).max(-i8::MAX);
    Packet::Vel2 { left: step(wheels.left_mps), right: step(wheels.right_mps) }
}

pub(super) fn vel_and_rvel(wheels: WheelSpeeds, wheelbase_m: f64) -> [Packet; 2] {
    let velocity = BodyVelocity {
        linear_mps: 0.5 * (wheels.left_mps + wheels.right_mps),
        angular_radps: (wheels.right_mps - wheels.left_mps) / wheelbase_m,
    };
    // Casts from floats saturate.
    [
        Packet::Vel((1000.0 * velocity.linear_mps).round() as i16),
        Packet::RVel(velocity.angular_radps.to_degrees().round() as i16),
    ]
}

/// Whether a motion command asks for standing still.
pub(super) fn is_rest(motion: &Command) -> bool {
    match *motion {
        Command::Stop => true,
        Command::Drive(wheels) => vel2(wheels) == Packet::Vel2 { left: 0, right: 0 },
        _ => false,
    }
}

/// The type of a robot's packet, for the two that come ten times a second.
pub(super) fn is_sip(body: &[u8]) -> bool {
    matches!(body.first(), Some(0x32 | 0x33))
}
