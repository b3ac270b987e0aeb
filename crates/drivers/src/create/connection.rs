//! Connecting, keeping the right mode, losing the robot.

use std::time::Duration;

use messages::{LinkState, Observations, Sensed};
use run_context::Stamp;
use wire::create_oi::{Command as Packet, STREAM_HEADER};

use super::{
    motion::Motion,
    state::{CreateDriver, Phase, STREAM, send, stand},
};

/// Time to wait for the first frame.
const ANSWER_MAX: Duration = Duration::from_millis(500);

/// Time between two wishes for another mode.
const MODE_PERIOD: Duration = Duration::from_millis(500);

/// STARTs after which a robot that stands and does not say 1 is taken to count its modes from 2.
const N_LOOKS_BEFORE_DOUBT: u32 = 3;
/// SAFEs after which that is doubted.
const N_WISHES_BEFORE_DOUBT: u32 = 4;

impl CreateDriver {
    /// What time demands.
    pub(super) fn keep_up(
        &mut self,
        now: Stamp,
        is_first: bool,
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        match self.phase {
            Phase::Looking if is_first => self.look(now, out),
            Phase::Looking if now.since(self.phase_since) >= ANSWER_MAX => {
                self.counters.n_retries += 1;
                self.look(now, out);
            }
            Phase::Looking => {}
            Phase::Connected => {
                let is_deaf = self.motion.unheard_for(now) >= self.config.silence_max;
                if is_deaf || now.since(self.last_frame) >= self.config.silence_max {
                    self.counters.n_losses += 1;
                    observations.push(now, Sensed::Link(LinkState::Down));
                    self.begin_looking(now);
                    self.look(now, out);
                } else {
                    self.watch_hand(now, out);
                }
            }
        }
    }

    pub(super) fn begin_looking(&mut self, now: Stamp) {
        self.phase = Phase::Looking;
        self.phase_since = now;
        self.n_looks = 0;
        self.motion = Motion::at_rest(now);
        self.seen.is_drivable = false;
        self.decoder.clear();
    }

    /// Stops a robot that may be driving, and asks it to tell what it senses.
    fn look(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.phase_since = now;
        self.n_looks += 1;
        // A command that was cut short takes these for its data: at most a list of 255.
        stand(out);
        send(&Packet::Start, out);
        send(&Packet::Stream(STREAM.to_vec()), out);
    }

    /// Whether a robot that is looked for has heard START; learns how it counts its modes.
    pub(super) fn has_stopped(&mut self, mode: i32) -> bool {
        // It reports no other mode as 1: with its interface off it says nothing.
        if mode == 1 {
            self.mode_offset = Some(0);
        } else if mode == 2
            && self.mode_offset.is_none()
            && self.n_looks > N_LOOKS_BEFORE_DOUBT
            && self.seen.asked_mmps == [0; 2]
        {
            self.mode_offset = Some(1);
        }
        self.mode_offset.is_some_and(|offset| mode == 1 + offset)
    }

    /// Asks for safe mode, where it may.
    pub(super) fn enter_safe(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.phase_since = now;
        // On its charger it falls back at once.
        if self.motors_wanted && !self.seen.charges {
            self.n_wishes += 1;
            send(&Packet::Safe, out);
        }
    }

    /// Asks for safe mode again where the robot is not in it.
    pub(super) fn keep_mode(&mut self, now: Stamp, mode: i32, out: &mut Vec<u8>) {
        if self.phase != Phase::Connected {
            return;
        }
        let is_drivable = mode - self.mode_offset.unwrap_or(0) >= 2;
        if is_drivable {
            self.n_wishes = 0;
        } else if now.since(self.phase_since) >= MODE_PERIOD {
            if self.n_wishes > N_WISHES_BEFORE_DOUBT && self.mode_offset == Some(1) {
                // It may have been in safe mode all the time.
                self.mode_offset = None;
                self.n_wishes = 0;
                self.begin_looking(now);
            } else {
                self.enter_safe(now, out);
            }
        }
    }

    /// Safe mode for motors that are on, passive mode for motors that are off.
    pub(super) fn enable(&mut self, on: bool, out: &mut Vec<u8>) {
        let changes = std::mem::replace(&mut self.motors_wanted, on) != on;
        if !on {
            self.motion.forget();
        }
        if self.phase == Phase::Connected && (changes || on != self.seen.is_drivable) {
            send(if on { &Packet::Safe } else { &Packet::Start }, out);
        }
    }
}

/// A frame's header is no opcode that this driver sends.
const _: () = assert!(STREAM_HEADER < 128);
