//! What the wheels are asked for, for how long, and whether the robot heard it.

use std::time::Duration;

use geometry::wrap_to_pi;
use navigator::Command;
use robot_models::{BodyVelocity, WheelSpeeds};
use run_context::Stamp;
use wire::create_oi::Command as Packet;

use super::{CreateDriver, Phase, send};

/// Turn rate asked for per angle that is left, 1/s.
const HEADING_GAIN_HZ: f64 = 4.0;
/// A heading this near is reached, rad: a count of one wheel turns it by 0.0019.
const HEADING_REACHED_RAD: f64 = 0.0044;
/// The slowest that wheels are asked to turn in a turn, m/s.
const TURN_SPEED_MIN_MPS: f64 = 0.01;
/// Part of the turning acceleration that braking reckons with: frames come 15 ms late and more.
const BRAKING_SHARE: f64 = 0.5;
/// The fastest the protocol can say, mm/s.
const SPEED_MAX_MMPS: f64 = 500.0;
/// Time after which a speed that the robot does not report is sent again, beside what the way there and back takes.
const MEND_AFTER: Duration = Duration::from_millis(60);
/// Speeds that are remembered to see whether the robot follows: a turn sends another with each frame.
const N_RECENT: usize = 16;
/// Bytes in front of a speed that is mended: as opcodes they mean SAFE, in which the robot is already; a command that lost a
/// byte takes up to four of them for its data, and the speed behind them is whole.
const N_ALIGNING: usize = 4;

/// Opcodes after which a robot is not found again, or not soon: RESET, BAUD, POWER, STOP. When the byte before a speed is
/// lost the robot takes the speed's low byte for an opcode.
const FATAL_OPCODES: [u8; 4] = [7, 129, 133, 173];

/// The speed, mm/s, or one that is 1 mm/s slower, so that its low byte is no fatal opcode.
fn harmless(mmps: i16) -> i16 {
    let [_, low] = mmps.to_be_bytes();
    if FATAL_OPCODES.contains(&low) { mmps - mmps.signum() } else { mmps }
}

/// What is asked of the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    wish: Wish,
    /// When somebody asked for it last.
    asked: Stamp,
    /// What was sent last, left and right, mm/s.
    sent_mmps: [i16; 2],
    sent: Stamp,
    /// The speeds that it was sent, each with the time since when it holds; the newest first.
    recent: [(Stamp, [i16; 2]); N_RECENT],
    /// Since when the robot reports another speed than it was sent.
    differs_since: Option<Stamp>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Wish {
    Rest,
    Wheels(WheelSpeeds),
    Heading(f64),
}

impl Default for Motion {
    fn default() -> Self {
        Self::at_rest(Stamp::ZERO)
    }
}

impl Motion {
    pub(super) fn at_rest(now: Stamp) -> Self {
        Self {
            wish: Wish::Rest,
            asked: now,
            sent_mmps: [0; 2],
            sent: now,
            recent: [(now, [0; 2]); N_RECENT],
            differs_since: None,
        }
    }

    pub(super) fn moves(&self) -> bool {
        self.wish != Wish::Rest || self.sent_mmps != [0; 2]
    }

    /// The robot stands, by itself or because it was told to.
    pub(super) fn forget(&mut self) {
        self.wish = Wish::Rest;
        self.set_sent([0; 2]);
        self.differs_since = None;
    }

    /// Notes a speed that the robot has from now on.
    fn set_sent(&mut self, mmps: [i16; 2]) {
        if mmps != self.sent_mmps {
            self.sent_mmps = mmps;
            self.recent.rotate_right(1);
            self.recent[0] = (self.sent, mmps);
        }
    }

    /// Since when the robot ought to have followed a newer speed than the one that it reports; `None` when it has the newest.
    fn behind_since(&self, reported_mmps: [i32; 2]) -> Option<Stamp> {
        let is_that = |&(_, mmps): &(Stamp, [i16; 2])| mmps.map(i32::from) == reported_mmps;
        match self.recent.iter().position(is_that) {
            Some(0) => None,
            Some(index) => Some(self.recent[index - 1].0),
            // One that it was never sent, or long ago.
            None => Some(self.recent[0].0),
        }
    }

    /// How long the robot has reported other speeds than it was sent.
    pub(super) fn unheard_for(&self, now: Stamp) -> Duration {
        self.differs_since.map_or(Duration::ZERO, |since| now.since(since))
    }
}

impl CreateDriver {
    /// Takes a motion command.
    pub(super) fn move_as(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        self.motion.asked = now;
        self.motion.wish = match *command {
            Command::Drive(wheels) => Wish::Wheels(wheels),
            Command::TurnTo { heading_in_odom_rad } => Wish::Heading(heading_in_odom_rad),
            _ => Wish::Rest,
        };
        let wanted = self.wanted_mmps();
        if wanted == self.motion.sent_mmps {
            // It was told, and what it did not hear is mended: every byte on a line without checksums is a risk.
            return;
        }
        // A stop is sent twice, because one may be lost, and the report of that comes late.
        if self.motion.wish == Wish::Rest {
            self.send_speeds(now, wanted, out);
        }
        self.send_speeds(now, wanted, out);
    }

    /// A motion that nobody renews ends.
    pub(super) fn watch_hand(&mut self, now: Stamp, out: &mut Vec<u8>) {
        let is_drive = matches!(self.motion.wish, Wish::Wheels(wheels) if !wheels.is_zero());
        if is_drive && now.since(self.motion.asked) >= self.config.hold_max {
            self.counters.n_dead_man_stops += 1;
            self.motion.wish = Wish::Rest;
            self.send_speeds(now, [0; 2], out);
        }
    }

    /// With each frame: goes on turning, and sends again what was not heard.
    pub(super) fn keep_driving(&mut self, now: Stamp, out: &mut Vec<u8>) {
        if self.phase != Phase::Connected || !self.seen.is_drivable {
            self.motion.differs_since = None;
            return;
        }
        let wanted = self.wanted_mmps();
        if wanted != self.motion.sent_mmps {
            self.send_speeds(now, wanted, out);
        }
        let behind = self.motion.behind_since(self.seen.asked_mmps);
        let mend_after = MEND_AFTER + 2 * self.config.line.latency;
        let late = behind.filter(|&since| now.since(since) >= mend_after);
        if late.is_none() {
            self.motion.differs_since = None;
            return;
        }
        self.motion.differs_since = self.motion.differs_since.or(late);
        if now.since(self.motion.sent) >= mend_after {
            self.counters.n_mended += 1;
            for _ in 0..N_ALIGNING {
                send(&Packet::Safe, out);
            }
            self.send_speeds(now, wanted, out);
        }
    }

    fn send_speeds(&mut self, now: Stamp, [left_mmps, right_mmps]: [i16; 2], out: &mut Vec<u8>) {
        self.motion.sent = now;
        self.motion.set_sent([left_mmps, right_mmps]);
        send(&Packet::DriveDirect { right_mmps, left_mmps }, out);
    }

    /// What the wheels should do now, left and right.
    fn wanted_mmps(&self) -> [i16; 2] {
        let drive = &self.config.drive;
        let wheels = match self.motion.wish {
            Wish::Rest => WheelSpeeds::ZERO,
            Wish::Wheels(wheels) => drive.limited(wheels, &self.config.limits),
            Wish::Heading(heading_rad) => self.turning(heading_rad),
        };
        let velocity = drive.body_velocity(wheels);
        let wheels = if self.seen.cliff && velocity.linear_mps > 0.0 {
            // Backwards and on the spot only.
            drive.wheel_speeds(BodyVelocity { linear_mps: 0.0, ..velocity })
        } else {
            wheels
        };
        let fastest = 1000.0 * wheels.left_mps.abs().max(wheels.right_mps.abs());
        let excess = (fastest / SPEED_MAX_MMPS).max(1.0);
        // A cast from a float saturates, and makes 0 of what is not a number.
        [wheels.left_mps, wheels.right_mps]
            .map(|mps| harmless((1000.0 * mps / excess).round() as i16))
    }

    fn turning(&self, heading_rad: f64) -> WheelSpeeds {
        let drive = &self.config.drive;
        let left_rad = wrap_to_pi(heading_rad - self.odometer.odom_from_base().se2().yaw_rad);
        if left_rad.is_nan() || left_rad.abs() < HEADING_REACHED_RAD {
            return WheelSpeeds::ZERO;
        }
        let limits = &self.config.limits;
        // Never faster than can still be braked: ω ≤ √(2 α φ).
        let braking_radps2 = BRAKING_SHARE * limits.turn_acceleration_max_radps2;
        let least_radps = 2.0 * TURN_SPEED_MIN_MPS / drive.wheelbase_m;
        let rate_radps = (HEADING_GAIN_HZ * left_rad.abs())
            .min((2.0 * braking_radps2 * left_rad.abs()).sqrt())
            .min(limits.turn_rate_max_radps)
            .max(least_radps)
            .copysign(left_rad);
        drive.wheel_speeds(BodyVelocity { linear_mps: 0.0, angular_radps: rate_radps })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_speed_holds_a_byte_that_switches_the_robot_off() {
        for mmps in -500_i16..=500 {
            let sent = harmless(mmps);
            assert!((mmps - sent).abs() <= 1 && sent.abs() <= mmps.abs(), "{mmps} {sent}");
            let bytes = sent.to_be_bytes();
            assert!(bytes.iter().all(|byte| !FATAL_OPCODES.contains(byte)), "{mmps} {bytes:?}");
        }
        assert_eq!((harmless(133), harmless(-123), harmless(200)), (132, -122, 200));
    }
}
