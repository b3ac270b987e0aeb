//! Connecting, and putting right what was lost on the way.

use std::time::Duration;

use messages::Observations;
use run_context::Stamp;
use wire::arcos::{Command as Packet, Sip};

use super::{
    packets::{FLAG_MOTORS, FLAGS_SONAR, send},
    settings::PioneerSettings,
    state::{Hearing, Phase, PioneerDriver, Step},
};

/// Time between two attempts to put right what the robot reports as wrong.
const MEND_PERIOD: Duration = Duration::from_millis(500);

/// How often the limits are sent while the robot reports others: it may refuse them.
const N_SETTINGS_TRIES: u32 = 5;

impl PioneerDriver {
    /// What time demands: retries, the heartbeat, giving up a silent connection.
    pub(super) fn keep_up(
        &mut self,
        now: Stamp,
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        if !self.started {
            self.started = true;
            self.enter(now, Phase::FIRST, out);
            return;
        }
        let waited = now.since(self.phase_since);
        match self.phase {
            Phase::Connected => {
                if self.is_lost(now) {
                    self.lose(now, observations, out);
                    return;
                }
                self.heartbeat(now, out);
                self.ask_whether_it_hears(now, out);
            }
            Phase::Silent => self.keep_silent(now, out),
            Phase::Sync(_) | Phase::Closing if waited >= self.config.echo_timeout => {
                self.counters.n_retries += 1;
                self.enter(now, Phase::FIRST, out);
            }
            // OPEN is answered by the first information packet, up to 100 ms later.
            Phase::Opening if waited >= self.config.silence_max => {
                self.counters.n_retries += 1;
                self.enter(now, Phase::FIRST, out);
            }
            // The SYNC0 may have been taken for a pulse.
            Phase::Sync(Step::Zero)
                if waited >= self.config.echo_timeout / 2 && self.last_stop <= self.phase_since =>
            {
                self.hush(now, out);
            }
            Phase::Sync(_) | Phase::Closing | Phase::Opening => {}
        }
    }

    pub(super) fn enter(&mut self, now: Stamp, phase: Phase, out: &mut Vec<u8>) {
        self.phase = phase;
        self.phase_since = now;
        match phase {
            Phase::Sync(Step::Zero) => {
                self.hush(now, out);
                send(&Packet::Sync0, out);
            }
            Phase::Sync(Step::One) => send(&Packet::Sync1, out),
            Phase::Sync(Step::Two) => send(&Packet::Sync2, out),
            Phase::Opening => {
                self.hearing = Hearing::default();
                send(&Packet::Open, out);
                send(&Packet::Enable(self.motors_wanted.into()), out);
                self.settings_confirmed = self.config.settings == PioneerSettings::default();
                self.settings_tries = 0;
                self.send_settings(out);
                if self.config.encoder_packets {
                    send(&Packet::Encoder(2), out);
                }
            }
            Phase::Silent | Phase::Closing | Phase::Connected => {}
        }
    }

    /// Compares what the robot reports with what it was told, and tells it again.
    pub(super) fn mend(&mut self, now: Stamp, sip: &Sip, out: &mut Vec<u8>) {
        if now.since(self.last_mend) < MEND_PERIOD {
            return;
        }
        let motors_on = sip.flags & FLAG_MOTORS != 0;
        if motors_on != self.motors_wanted {
            self.last_mend = now;
            self.counters.n_mended += 1;
            send(&Packet::Enable(self.motors_wanted.into()), out);
        }
        if sip.flags & FLAGS_SONAR == 0 && self.config.n_sonars > 0 {
            self.last_mend = now;
            self.counters.n_mended += 1;
            send(&Packet::Sonar(1), out);
        }
        // The configuration also says how long the watchdog waits.
        let unknown = !self.settings_confirmed || self.robot_config.is_none();
        if unknown && self.settings_tries < N_SETTINGS_TRIES {
            self.last_mend = now;
            self.counters.n_mended += 1;
            self.send_settings(out);
        }
    }

    /// Sends the limits, and CONFIG to see what became of them.
    fn send_settings(&mut self, out: &mut Vec<u8>) {
        self.settings_tries += 1;
        for packet in self.config.settings.packets().iter().flatten() {
            send(packet, out);
        }
        send(&Packet::Config, out);
    }
}
