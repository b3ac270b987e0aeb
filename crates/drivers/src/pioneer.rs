//! The client of a Pioneer robot: connects, keeps the connection alive, drives.
//!
//! **Connecting.** SYNC0, SYNC1, SYNC2, each until its echo; then OPEN, the settings, ENABLE and
//! CONFIG. An information packet where an echo should be means that an old session is still open:
//! the driver sends CLOSE and begins again. Silence begins again too, so a connection comes about
//! over a line that loses and damages bytes.
//!
//! **Connected.** Everything that could have been lost is checked against what the robot reports
//! and sent again: the motors' state and the sonars by the flags of the information packets, the
//! limits by the configuration packet. The last motion command is repeated with the heartbeat, and STOP
//! until the robot reports that it stands.
//!
//! **Lost.** A robot that is not heard for [`PioneerDriverConfig::silence_max`], or no longer hears, ends
//! the connection with [`Sensed::Link(LinkState::Down)`]. The driver forgets the motion command, sends STOP, says
//! nothing for longer than the robot's watchdog waits, and only then connects anew; the module
//! `losing` says why.
//!
//! Source: the thesis, Annex C (start-up sequence, heartbeat, commands), and the manufacturer's
//! public manuals.
//! Differences: the listing waits a second after each step instead of for its echo, divides
//! wheel speeds by 20 mm/s rounding towards zero (here they are rounded to the nearest step), and stops
//! with RVEL 0 and MOVE 0, of which half may be lost; STOP is one packet, sent twice.

mod as_driver;
mod connection;
mod losing;
mod packets;
mod settings;
mod state;
mod status;

use std::time::Duration;

use messages::{Command, LinkState, Observations, Sensed};
use run_context::Stamp;
use wire::arcos::{self, Command as Packet, ConfigPac, Decoder, EncoderPac, Report, Sip};

use self::{
    packets::{is_sip, send, vel_and_rvel, vel2},
    state::{Phase, Step},
};
pub use self::{
    settings::{DriveCommand, PioneerCounters, PioneerDriverConfig, PioneerSettings},
    state::PioneerDriver,
};

impl PioneerDriver {
    /// Takes received bytes; appends what was observed and what is to be sent.
    ///
    /// Call it every few milliseconds, with or without bytes. Does not allocate between one
    /// connection and the next.
    pub fn step(
        &mut self,
        now: Stamp,
        received: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        if !received.is_empty() {
            self.decoder.push(received);
            self.last_byte = now;
        } else if self.decoder.has_unfinished()
            && now.since(self.last_byte) >= Duration::from_millis(100)
        {
            self.decoder.give_up_unfinished();
        }
        while let Some(packet) = self.decoder.next_packet() {
            self.take(now, packet.body(), observations, out);
        }
        self.keep_up(now, observations, out);
    }

    /// Sends a command of the navigator. While there is no connection, motion commands are
    /// forgotten and the motors' wanted state is kept; commands for other drivers are passed over.
    pub fn command(&mut self, now: Stamp, command: &Command, out: &mut Vec<u8>) {
        match *command {
            Command::EnableMotors(on) => {
                self.motors_wanted = on;
                if !on {
                    self.motion = None;
                }
                if self.is_connected() {
                    self.last_mend = now;
                    send(&Packet::Enable(on.into()), out);
                }
            }
            Command::Drive(_) | Command::TurnTo { .. } | Command::Stop => {
                if self.is_connected() {
                    self.motion = Some(*command);
                    self.send_motion(now, command, out);
                }
            }
            Command::QueryPheromones { .. } | Command::Report(_) => {}
        }
    }

    /// Ends the session: stops the robot and closes the connection, in whatever state it is. Later steps
    /// connect anew, but not before the robot's watchdog must have stopped it.
    pub fn disconnect(&mut self, now: Stamp, out: &mut Vec<u8>) {
        self.be_silent(now);
        self.hush(now, out);
    }

    /// Whether information packets are coming in.
    pub fn is_connected(&self) -> bool {
        self.phase == Phase::Connected
    }

    /// Name, class and subclass of the robot, once known.
    pub fn identity(&self) -> Option<&[String; 3]> {
        self.identity.as_ref()
    }

    /// The robot's configuration packet, once known.
    pub fn robot_config(&self) -> Option<&ConfigPac> {
        self.robot_config.as_ref()
    }

    /// The last encoder packet, if they were asked for.
    pub fn encoders(&self) -> Option<EncoderPac> {
        self.encoders
    }

    /// What the driver did and met.
    pub fn counters(&self) -> PioneerCounters {
        self.counters
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    pub(super) fn send_motion(&mut self, now: Stamp, motion: &Command, out: &mut Vec<u8>) {
        self.last_motion = now;
        match *motion {
            Command::Drive(wheels) => match self.config.drive_command {
                DriveCommand::Vel2 => send(&vel2(wheels), out),
                DriveCommand::VelAndRVel => {
                    let [vel, rvel] = vel_and_rvel(wheels, self.config.wheelbase_m);
                    send(&vel, out);
                    send(&rvel, out);
                }
            },
            Command::TurnTo { heading_in_odom_rad } => {
                // HEAD turns the robot; whatever it was doing straight on has to end.
                send(&Packet::Vel(0), out);
                let degrees = heading_in_odom_rad.to_degrees().round().rem_euclid(360.0);
                // Below 360, so the cast loses nothing.
                send(&Packet::Head(degrees as i16), out);
            }
            Command::Stop => {
                // Twice, because one may be lost, and the robot's report of that comes late.
                self.stop(now, out);
                self.stop(now, out);
            }
            _ => {}
        }
    }

    pub(super) fn heartbeat(&mut self, now: Stamp, out: &mut Vec<u8>) {
        if now.since(self.last_heartbeat) < self.config.heartbeat {
            return;
        }
        self.last_heartbeat = now;
        // First: a robot that its watchdog stopped goes on at the pulse with what it knows.
        if let Some(motion) = self.motion {
            self.send_motion(now, &motion, out);
        }
        send(&Packet::Pulse, out);
    }

    fn take_sip(
        &mut self,
        now: Stamp,
        body_len: usize,
        sip: &Sip,
        observations: &mut Observations,
    ) {
        self.counters.n_sips += 1;
        self.last_sip = now;
        let about = self.config.line.sent_at(now, body_len + 5);
        self.status.read(about, sip, observations);
    }
}

impl PioneerDriver {
    fn take(
        &mut self,
        now: Stamp,
        body: &[u8],
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        if is_sip(body) {
            match Sip::decode(body) {
                Ok(sip) => self.hear_sip(now, body.len(), &sip, observations, out),
                Err(_) => self.counters.n_unreadable += 1,
            }
            return;
        }
        match arcos::Report::decode(body) {
            Ok(Report::Encoder(encoders)) => {
                self.encoders = Some(encoders);
                self.hearing.hear(now);
            }
            Ok(Report::Config(config)) => {
                self.settings_confirmed = self.config.settings.agree_with(&config);
                self.robot_config = Some(config);
            }
            Ok(report) => self.hear_echo(now, report, out),
            Err(_) => self.counters.n_unreadable += 1,
        }
    }

    fn hear_sip(
        &mut self,
        now: Stamp,
        body_len: usize,
        sip: &Sip,
        observations: &mut Observations,
        out: &mut Vec<u8>,
    ) {
        match self.phase {
            Phase::Connected => {}
            Phase::Opening => {
                self.phase = Phase::Connected;
                self.counters.n_connections += 1;
                self.last_heartbeat = now;
                self.last_mend = now;
                observations.push(now, Sensed::Link(LinkState::Up));
            }
            Phase::Sync(_) => {
                // An old session: it must end before a new one can begin.
                self.hush(now, out);
                self.phase = Phase::Closing;
                self.phase_since = now;
                return;
            }
            Phase::Silent => {
                self.hear_lost(now, sip, out);
                return;
            }
            Phase::Closing => return,
        }
        self.take_sip(now, body_len, sip, observations);
        self.mend(now, sip, out);
        self.insist(now, sip, out);
    }

    fn hear_echo(&mut self, now: Stamp, report: Report, out: &mut Vec<u8>) {
        let next = match (self.phase, report) {
            (Phase::Sync(Step::Zero), Report::Sync0) => Phase::Sync(Step::One),
            (Phase::Sync(Step::One), Report::Sync1) => Phase::Sync(Step::Two),
            (Phase::Sync(Step::Two), Report::Sync2 { name, class, subclass }) => {
                self.identity = Some([name, class, subclass]);
                Phase::Opening
            }
            _ => return,
        };
        self.enter(now, next, out);
    }
}
