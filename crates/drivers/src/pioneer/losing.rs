//! Losing the robot: whoever loses sight stops first, and only then looks for the other.
//!
//! Two things make a lost robot dangerous. SYNC0, which the search begins with, is PULSE byte for
//! byte, so a search keeps the watchdog of a robot that still drives from stopping it. And a robot that
//! its watchdog has stopped goes on with its last motion at the next packet, whatever that says
//! (Pioneer 3 Operations Manual, safety watchdogs). So:
//!
//! 1. STOP, [`N_LAST_STOPS`] times, because a packet may be lost: it does no harm to a robot that hears it and
//!    is no sign of life for one that does not.
//! 2. Silence for longer than the watchdog's time. While the robot is heard to roll, STOP again.
//! 3. STOP and CLOSE before every SYNC0, and again when no echo comes: what the robot still remembers of
//!    a motion is gone before the search can wake it, and if not, soon after.
//!
//! A robot is lost when it has not been heard for [`PioneerDriverConfig::silence_max`], or when it has not
//! shown for the watchdog's time and a second that it hears: the driver asks for an encoder packet with every
//! heartbeat, and more often when none comes. A robot that never answers these questions is taken to
//! hear.
//!
//! [`PioneerDriverConfig::silence_max`]: super::PioneerDriverConfig::silence_max

use std::time::Duration;

use messages::{Command, LinkState, Observations, Sensed};
use run_context::Stamp;
use wire::arcos::{Command as Packet, Sip};

use super::{
    packets::{is_rest, send},
    state::{Hearing, Phase, PioneerDriver},
};

/// How often STOP is sent when the robot is lost.
const N_LAST_STOPS: u32 = 3;

/// Time between these.
const LAST_STOP_PERIOD: Duration = Duration::from_millis(50);

/// The watchdog's time of robots that have not said theirs.
const WATCHDOG_DEFAULT: Duration = Duration::from_secs(2);

/// Silence beyond the watchdog's time: what delays may differ by between two packets.
const SILENCE_MARGIN: Duration = Duration::from_millis(500);

/// Time between two STOPs for a robot that rolls although it should stand.
const INSIST_PERIOD: Duration = Duration::from_millis(200);

/// The same for one that was lost; it is longer, because each STOP begins the silence anew.
const INSIST_PERIOD_LOST: Duration = Duration::from_millis(500);

/// Reported wheel speeds that are no motion, mm/s.
const STANDING_MMPS: u16 = 2;

/// Time between two questions to a robot that has not answered the last.
const ASK_AGAIN_PERIOD: Duration = Duration::from_millis(250);

/// How long a question may go unanswered beyond the watchdog's time.
const DEAF_MARGIN: Duration = Duration::from_secs(1);

impl PioneerDriver {
    /// How long this robot drives on without a packet.
    fn watchdog(&self) -> Duration {
        let said = self.robot_config.as_ref().map(|config| config.watchdog_ms);
        said.map_or(WATCHDOG_DEFAULT, |millis| Duration::from_millis(millis.into()))
    }

    /// Whether the robot has to be taken for lost.
    pub(super) fn is_lost(&self, now: Stamp) -> bool {
        let deaf_max = self.watchdog() + DEAF_MARGIN;
        now.since(self.last_sip) >= self.config.silence_max
            || self.hearing.deaf_for(now).is_some_and(|deaf_for| deaf_for >= deaf_max)
    }

    /// Gives the robot up: stops it, and is silent then.
    pub(super) fn lose(&mut self, now: Stamp, observations: &mut Observations, out: &mut Vec<u8>) {
        observations.push(now, Sensed::Link(LinkState::Down));
        self.counters.n_losses += 1;
        self.be_silent(now);
        self.last_stops = N_LAST_STOPS;
        self.send_last_stop(now, out);
    }

    /// Says nothing until the robot's watchdog must have stopped it, then looks for it.
    pub(super) fn be_silent(&mut self, now: Stamp) {
        self.motion = None;
        self.hearing = Hearing::default();
        self.phase = Phase::Silent;
        self.phase_since = now;
        self.started = true;
        self.last_stops = 0;
        self.last_stop = now;
        self.decoder.clear();
    }

    /// One step of the silence.
    pub(super) fn keep_silent(&mut self, now: Stamp, out: &mut Vec<u8>) {
        let silent_for = now.since(self.last_stop);
        if self.last_stops > 0 {
            if silent_for >= LAST_STOP_PERIOD {
                self.send_last_stop(now, out);
            }
        } else if silent_for > self.watchdog() + SILENCE_MARGIN {
            self.enter(now, Phase::FIRST, out);
        }
    }

    /// A lost robot is heard: one that rolls has not heard the last STOP.
    pub(super) fn hear_lost(&mut self, now: Stamp, sip: &Sip, out: &mut Vec<u8>) {
        if rolls(sip) && now.since(self.last_stop) >= INSIST_PERIOD_LOST {
            self.stop(now, out);
        }
    }

    fn send_last_stop(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.last_stops = self.last_stops.saturating_sub(1);
        self.stop(now, out);
    }

    /// Sends STOP.
    pub(super) fn stop(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.last_stop = now;
        send(&Packet::Stop, out);
    }

    /// Ends a session that this driver does not know of, and what the robot remembers of a motion.
    pub(super) fn hush(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.stop(now, out);
        send(&Packet::Close, out);
    }

    /// Asks again for the rest that a connected robot was asked for, or never asked to leave, until
    /// it reports it.
    pub(super) fn insist(&mut self, now: Stamp, sip: &Sip, out: &mut Vec<u8>) {
        if now.since(self.last_motion.max(self.last_stop)) < INSIST_PERIOD {
            return;
        }
        let again = match self.motion {
            None => rolls(sip),
            Some(motion) if is_rest(&motion) => rolls(sip),
            // Half of the order was lost: it turns, but drives on.
            Some(Command::TurnTo { .. }) => drives_straight(sip),
            Some(_) => false,
        };
        if again {
            self.counters.n_mended += 1;
            match self.motion {
                Some(motion @ Command::TurnTo { .. }) => self.send_motion(now, &motion, out),
                _ => self.stop(now, out),
            }
        }
    }

    /// Asks for a sign that the robot hears, when it is time.
    pub(super) fn ask_whether_it_hears(&mut self, now: Stamp, out: &mut Vec<u8>) {
        // Where encoder packets come unasked for, they answer no question.
        if self.config.encoder_packets {
            return;
        }
        let hearing = &mut self.hearing;
        let period = match hearing.asked {
            // One that has never answered may not know this question.
            Some(_) if hearing.answered.is_some() => ASK_AGAIN_PERIOD,
            _ => self.config.heartbeat,
        };
        if now.since(hearing.asked_last) >= period {
            hearing.asked_last = now;
            hearing.asked.get_or_insert(now);
            send(&Packet::Encoder(1), out);
        }
    }
}

/// Whether the robot reports motion.
fn rolls(sip: &Sip) -> bool {
    sip.moving || [sip.left_mmps, sip.right_mmps].iter().any(|v| v.unsigned_abs() > STANDING_MMPS)
}

/// Whether the robot reports that its middle moves.
fn drives_straight(sip: &Sip) -> bool {
    // The wheels of a robot that turns in place differ by what rounding and ramps leave.
    let mean_mmps = i32::midpoint(sip.left_mmps.into(), sip.right_mmps.into());
    mean_mmps.unsigned_abs() > 20
}
