//! Commands of a mind become speeds of wheels, renewed and mended.

use std::time::Duration;

use geometry::wrap_to_pi;
use messages::Command;
use robot_models::{BodyVelocity, WheelSpeeds};
use run_context::Stamp;
use wire::create_oi::Command as Packet;

use super::{
    motion::{Wish, harmless},
    state::{CreateDriver, Phase, send},
};

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
/// Bytes in front of a speed that is mended: as opcodes they mean SAFE, in which the robot is already; a command that lost a
/// byte takes up to four of them for its data, and the speed behind them is whole.
const N_ALIGNING: usize = 4;

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
        let wheels = if self.seen.contacts.cliffs != 0 && velocity.linear_mps > 0.0 {
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
