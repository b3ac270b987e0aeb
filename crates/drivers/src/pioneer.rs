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
mod status;

use std::time::Duration;

use messages::{Command, LinkState, Observations, Sensed};
use robot_models::{BodyVelocity, WheelSpeeds};
use run_context::Stamp;
use wire::arcos::{self, Command as Packet, ConfigPac, Decoder, EncoderPac, Report, Sip};

use self::{
    connection::{Phase, Step},
    losing::Hearing,
    status::StatusReader,
};
use crate::LineTiming;

/// Metres per second in one step of VEL2.
const VEL2_STEP_MPS: f64 = 0.02;

/// Flag of an information packet: motors on.
const FLAG_MOTORS: u16 = 1;

/// Flags of an information packet: any sonar array on.
const FLAGS_SONAR: u16 = 0b1_1110;

/// Time between two attempts to put right what the robot reports as wrong.
const MEND_PERIOD: Duration = Duration::from_millis(500);

/// How often the limits are sent while the robot reports others: it may refuse them.
const N_SETTINGS_TRIES: u32 = 5;

/// Which packets a wheel-speed reference becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveCommand {
    /// VEL2: steps of 20 mm/s per wheel, as in the thesis.
    #[default]
    Vel2,
    /// VEL and RVEL: steps of 1 mm/s and 1 deg/s.
    VelAndRVel,
}

/// Limits to set after connecting; `None` leaves the robot's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PioneerSettings {
    /// SETV, m/s.
    pub speed_max_mps: Option<f64>,
    /// SETA, positive and negative, m/s².
    pub acceleration_mps2: Option<f64>,
    /// SETRV, rad/s.
    pub turn_rate_max_radps: Option<f64>,
    /// SETRA, positive and negative, rad/s².
    pub turn_acceleration_radps2: Option<f64>,
}

/// How to talk to one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PioneerDriverConfig {
    /// Which packets a wheel-speed reference becomes.
    pub drive_command: DriveCommand,
    /// Distance between the wheels, m; turns wheel speeds into VEL and RVEL.
    pub wheelbase_m: f64,
    /// Limits to set after connecting.
    pub settings: PioneerSettings,
    /// How many sonars the navigator sees, at most 16; readings of others are passed over.
    pub n_sonars: usize,
    /// Range that stands for «nothing heard», m.
    pub sonar_range_max_m: f64,
    /// Whether to ask for encoder packets.
    pub encoder_packets: bool,
    /// Time between heartbeats; the robot's watchdog stops it after two seconds of silence.
    pub heartbeat: Duration,
    /// Time to wait for an echo.
    pub echo_timeout: Duration,
    /// Time without an information packet after which the connection counts as lost.
    pub silence_max: Duration,
    /// What a packet's way takes.
    pub line: LineTiming,
}

/// What the driver did and met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PioneerCounters {
    /// Information packets understood.
    pub n_sips: u64,
    /// Packets with a right checksum that could not be read.
    pub n_unreadable: u64,
    /// Connections made.
    pub n_connections: u64,
    /// Times a step of connecting had to be begun again.
    pub n_retries: u64,
    /// Packets sent again because the robot reported that their effect was missing.
    pub n_mended: u64,
    /// Times that the robot was lost: it was not heard any more, or did not hear.
    pub n_losses: u64,
}

/// The driver of one Pioneer robot.
#[derive(Clone, Debug)]
pub struct PioneerDriver {
    config: PioneerDriverConfig,
    decoder: Decoder,
    phase: Phase,
    /// When the phase's last packet was sent.
    phase_since: Stamp,
    started: bool,
    last_sip: Stamp,
    last_heartbeat: Stamp,
    last_mend: Stamp,
    last_byte: Stamp,
    /// When the motion command was sent last, and STOP for whatever reason.
    last_motion: Stamp,
    last_stop: Stamp,
    /// STOPs still to be sent to a robot that was lost.
    last_stops: u32,
    hearing: Hearing,
    motors_wanted: bool,
    motion: Option<Command>,
    settings_tries: u32,
    settings_confirmed: bool,
    status: StatusReader,
    robot_config: Option<ConfigPac>,
    encoders: Option<EncoderPac>,
    identity: Option<[String; 3]>,
    counters: PioneerCounters,
}

impl Default for PioneerDriverConfig {
    fn default() -> Self {
        Self {
            drive_command: DriveCommand::Vel2,
            wheelbase_m: 0.38,
            settings: PioneerSettings::default(),
            n_sonars: messages::N_RING_MAX,
            sonar_range_max_m: 5.0,
            encoder_packets: false,
            heartbeat: Duration::from_millis(800),
            echo_timeout: Duration::from_millis(500),
            silence_max: Duration::from_secs(1),
            line: LineTiming::default(),
        }
    }
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

    fn send_motion(&mut self, now: Stamp, motion: &Command, out: &mut Vec<u8>) {
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

    fn heartbeat(&mut self, now: Stamp, out: &mut Vec<u8>) {
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

/// Appends a packet. Only string arguments can be too long, and the driver sends none.
fn send(packet: &Packet, out: &mut Vec<u8>) {
    let written = packet.encode(out);
    debug_assert!(written.is_ok(), "commands without strings always fit a packet");
}

/// Wheel speeds in steps of 20 mm/s, the nearest; ±2.54 m/s at most.
fn vel2(wheels: WheelSpeeds) -> Packet {
    // A cast from a float saturates, and makes 0 of what is not a number.
    let step = |mps: f64| ((mps / VEL2_STEP_MPS).round() as i8).max(-i8::MAX);
    Packet::Vel2 { left: step(wheels.left_mps), right: step(wheels.right_mps) }
}

fn vel_and_rvel(wheels: WheelSpeeds, wheelbase_m: f64) -> [Packet; 2] {
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
fn is_rest(motion: &Command) -> bool {
    match *motion {
        Command::Stop => true,
        Command::Drive(wheels) => vel2(wheels) == Packet::Vel2 { left: 0, right: 0 },
        _ => false,
    }
}

/// The type of a robot's packet, for the two that come ten times a second.
fn is_sip(body: &[u8]) -> bool {
    matches!(body.first(), Some(0x32 | 0x33))
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
