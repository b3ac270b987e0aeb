//! Connecting, and putting right what was lost on the way.

use messages::Observations;
use run_context::Stamp;
use wire::arcos::{Command as Packet, ConfigPac, Sip};

use super::{
    FLAG_MOTORS, FLAGS_SONAR, MEND_PERIOD, N_SETTINGS_TRIES, PioneerDriver, PioneerSettings,
    losing::Hearing, send,
};

/// How far the connection has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// The robot was lost, or sent away: nothing is said until its watchdog must have stopped it.
    Silent,
    /// A SYNC was sent and its echo is awaited.
    Sync(Step),
    /// CLOSE was sent to an old session; packets still under way are passed over.
    Closing,
    /// OPEN was sent and the first information packet is awaited.
    Opening,
    /// Information packets come in.
    Connected,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Zero,
    One,
    Two,
}

impl Phase {
    pub(super) const FIRST: Self = Self::Sync(Step::Zero);
}

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

impl PioneerSettings {
    fn packets(&self) -> [Option<Packet>; 6] {
        let millimetres = |metres: f64| (1000.0 * metres).round() as i16;
        let degrees = |rad: f64| rad.to_degrees().round() as i16;
        [
            self.speed_max_mps.map(|mps| Packet::SetV(millimetres(mps))),
            self.acceleration_mps2.map(|mps2| Packet::SetA(millimetres(mps2))),
            self.acceleration_mps2.map(|mps2| Packet::SetA(-millimetres(mps2))),
            self.turn_rate_max_radps.map(|radps| Packet::SetRv(degrees(radps))),
            self.turn_acceleration_radps2.map(|radps2| Packet::SetRa(degrees(radps2))),
            self.turn_acceleration_radps2.map(|radps2| Packet::SetRa(-degrees(radps2))),
        ]
    }

    /// Whether the robot's configuration is what these settings ask for.
    pub(super) fn agree_with(&self, config: &ConfigPac) -> bool {
        self.packets().iter().flatten().all(|packet| match *packet {
            Packet::SetV(mmps) => same(mmps, config.speed_max_mmps),
            Packet::SetA(mmps2) if mmps2 < 0 => same(-mmps2, config.deceleration_mmps2),
            Packet::SetA(mmps2) => same(mmps2, config.acceleration_mmps2),
            Packet::SetRv(degps) => same(degps, config.rotation_max_degps),
            Packet::SetRa(degps2) if degps2 < 0 => {
                same(-degps2, config.rotation_deceleration_degps2)
            }
            Packet::SetRa(degps2) => same(degps2, config.rotation_acceleration_degps2),
            _ => true,
        })
    }
}

fn same(sent: i16, reported: u16) -> bool {
    u16::try_from(sent) == Ok(reported)
}
