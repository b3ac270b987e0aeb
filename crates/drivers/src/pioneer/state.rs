//! What a Pioneer's driver remembers: how far the connection has come, what was sent when, what was heard.

use std::time::Duration;

use messages::Command;
use run_context::Stamp;
use wire::arcos::{ConfigPac, Decoder, EncoderPac};

use super::{
    settings::{PioneerCounters, PioneerDriverConfig},
    status::StatusReader,
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

/// What is known of whether the robot hears.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hearing {
    /// When it last answered in this session; `None`: never yet.
    pub(super) answered: Option<Stamp>,
    /// When the oldest question without an answer left.
    pub(super) asked: Option<Stamp>,
    /// When the last question left.
    pub(super) asked_last: Stamp,
}

impl Hearing {
    /// The robot answered.
    pub(super) fn hear(&mut self, now: Stamp) {
        self.answered = Some(now);
        self.asked = None;
    }

    /// Since when questions have gone unanswered by a robot that used to answer them.
    pub(super) fn deaf_for(&self, now: Stamp) -> Option<Duration> {
        self.answered.and(self.asked).map(|asked| now.since(asked))
    }
}

/// The driver of one Pioneer robot.
#[derive(Clone, Debug)]
pub struct PioneerDriver {
    pub(super) config: PioneerDriverConfig,
    pub(super) decoder: Decoder,
    pub(super) phase: Phase,
    /// When the phase's last packet was sent.
    pub(super) phase_since: Stamp,
    pub(super) started: bool,
    pub(super) last_sip: Stamp,
    pub(super) last_heartbeat: Stamp,
    pub(super) last_mend: Stamp,
    pub(super) last_byte: Stamp,
    /// When the motion command was sent last, and STOP for whatever reason.
    pub(super) last_motion: Stamp,
    pub(super) last_stop: Stamp,
    /// STOPs still to be sent to a robot that was lost.
    pub(super) last_stops: u32,
    pub(super) hearing: Hearing,
    pub(super) motors_wanted: bool,
    pub(super) motion: Option<Command>,
    pub(super) settings_tries: u32,
    pub(super) settings_confirmed: bool,
    pub(super) status: StatusReader,
    pub(super) robot_config: Option<ConfigPac>,
    pub(super) encoders: Option<EncoderPac>,
    pub(super) identity: Option<[String; 3]>,
    pub(super) counters: PioneerCounters,
}

impl PioneerDriver {
    /// A driver that will connect at its first step, with motors to be switched on.
    pub fn new(config: PioneerDriverConfig) -> Self {
        Self {
            status: StatusReader::new(config.n_sonars, config.sonar_range_max_m),
            config,
            decoder: Decoder::new(),
            phase: Phase::FIRST,
            phase_since: Stamp::ZERO,
            started: false,
            last_sip: Stamp::ZERO,
            last_heartbeat: Stamp::ZERO,
            last_mend: Stamp::ZERO,
            last_byte: Stamp::ZERO,
            last_motion: Stamp::ZERO,
            last_stop: Stamp::ZERO,
            last_stops: 0,
            hearing: Hearing::default(),
            motors_wanted: true,
            motion: None,
            settings_tries: 0,
            settings_confirmed: false,
            robot_config: None,
            encoders: None,
            identity: None,
            counters: PioneerCounters::default(),
        }
    }
}
