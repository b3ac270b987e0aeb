//! What the wheels are asked for, for how long, and whether the robot heard it.

use std::time::Duration;

use robot_models::WheelSpeeds;
use run_context::Stamp;

/// Speeds that are remembered to see whether the robot follows: a turn sends another with each frame.
const N_RECENT: usize = 16;

/// Opcodes after which a robot is not found again, or not soon: RESET, BAUD, POWER, STOP. When the byte before a speed is
/// lost the robot takes the speed's low byte for an opcode.
const FATAL_OPCODES: [u8; 4] = [7, 129, 133, 173];

/// The speed, mm/s, or one that is 1 mm/s slower, so that its low byte is no fatal opcode.
pub(super) fn harmless(mmps: i16) -> i16 {
    let [_, low] = mmps.to_be_bytes();
    if FATAL_OPCODES.contains(&low) { mmps - mmps.signum() } else { mmps }
}

/// What is asked of the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) wish: Wish,
    /// When somebody asked for it last.
    pub(super) asked: Stamp,
    /// What was sent last, left and right, mm/s.
    pub(super) sent_mmps: [i16; 2],
    pub(super) sent: Stamp,
    /// The speeds that it was sent, each with the time since when it holds; the newest first.
    pub(super) recent: [(Stamp, [i16; 2]); N_RECENT],
    /// Since when the robot reports another speed than it was sent.
    pub(super) differs_since: Option<Stamp>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wish {
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
    pub(super) fn set_sent(&mut self, mmps: [i16; 2]) {
        if mmps != self.sent_mmps {
            self.sent_mmps = mmps;
            self.recent.rotate_right(1);
            self.recent[0] = (self.sent, mmps);
        }
    }

    /// Since when the robot ought to have followed a newer speed than the one that it reports; `None` when it has the newest.
    pub(super) fn behind_since(&self, reported_mmps: [i32; 2]) -> Option<Stamp> {
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
