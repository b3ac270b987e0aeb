//! The robot's side of the Open Interface: an iRobot Create 2.
//!
//! **Modes.** Off until START; then passive, in which it tells what it senses and moves for nobody; SAFE and FULL let it be
//! driven. In safe mode a cliff on the way forwards, a dropped wheel or a charger stop it and put it back into passive
//! mode; in full mode nothing does. START puts it back into passive mode from any other. After five minutes in passive
//! mode it falls asleep and hears nothing any more, until somebody takes the line up anew (a real one wants its BRC pin
//! pulled low).
//!
//! **Motion.** The last DRIVE, DRIVE DIRECT or DRIVE PWM holds until another one comes: there is no watchdog. A line that
//! goes dead leaves it driving, as it does the real one.
//!
//! **Encoders** count without knowing which way a wheel turns: the sign is that of the last speed asked for. They wrap at
//! 65 536. Packets 19 and 20 (way and angle) start anew whenever they are read, by the stream too.
//!
//! Source: iRobot Create 2 Open Interface Specification (2016); no watchdog, sleep, sign of the encoders and the limit of
//! 172 bytes of a stream: notes from real robots (`AutonomyLab/libcreate` and its issues).
//! Differences: it does not clean, seek its home base or boot with a text; lights, songs, schedule and brushes are
//! accepted and do nothing but what their packets say; fractions of millimetres and degrees are kept between two readings of
//! packets 19 and 20, where real firmware loses them.

mod obey;
mod power;
mod senses;
mod state;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use robot_models::{RobotModel, WheelSpeeds};
use run_context::{RandomStream, Stamp, StateHash};
use simulator::{BodyId, World};
use wire::create_oi::{CommandDecoder, write_frame};

use crate::{
    BatteryConfig, BatteryStatus, Board, BoardConfig, BoardStatus, MotorReference, NumberSet, Port,
    SimRequest, bumpers::Bumpers,
};
use power::Power;
pub use state::CreateFirmware;
use state::{AWAKE_MAX, BAUD, Feel, LOW_PERCENT, Mode, N_NOTES_MAX, REST, STREAM_PERIOD, Site};

impl CreateFirmware {
    /// A robot that has just been switched on: interface off, wheels at rest.
    pub fn new(model: Arc<RobotModel>, battery: BatteryConfig) -> Self {
        let segments = model.devices.bumpers.iter().map(|mount| mount.between_deg);
        Self {
            decoder: CommandDecoder::new(),
            mode: Mode::Off,
            is_asleep: false,
            passive_since: Stamp::ZERO,
            requested: REST,
            wheels: WheelSpeeds::ZERO,
            counts: [0; 2],
            signs: [1; 2],
            ticks: None,
            distance_m: 0.0,
            angle_rad: 0.0,
            bumpers: Bumpers::new(model.footprint.corners(), segments),
            feel: Feel::default(),
            power: Power::new(model.devices.battery, battery),
            stream: Vec::new(),
            is_streaming: false,
            next_frame: Stamp::ZERO,
            songs: Default::default(),
            song_number: 0,
            song_ends: Stamp::ZERO,
            buttons: 0,
            buttons_end: Stamp::ZERO,
            baud: model.line.as_ref().map_or(BAUD, |line| line.baud),
            n_heard: 0,
            unknown: NumberSet::default(),
            unexpected: NumberSet::default(),
            notes: Vec::new(),
            now: Stamp::ZERO,
            last_step: None,
            model,
        }
    }

    /// The firmware of a model of the catalogue.
    pub(crate) fn board(
        model: Arc<RobotModel>,
        config: &BoardConfig,
        _rng: RandomStream,
    ) -> Box<dyn Board> {
        // It has no name on the wire.
        Box::new(Self::new(model, config.battery))
    }

    fn note(&mut self, text: String) {
        if self.notes.len() < N_NOTES_MAX {
            self.notes.push(SimRequest::Note(text));
        }
    }

    fn enter(&mut self, mode: Mode) {
        if mode < Mode::Safe {
            self.requested = REST;
            self.wheels = WheelSpeeds::ZERO;
        }
        if mode == Mode::Passive {
            self.passive_since = self.now;
        }
        self.mode = mode;
        self.unexpected = NumberSet::default();
    }

    /// What safe mode is for.
    fn guard(&mut self) {
        if self.mode != Mode::Safe {
            return;
        }
        let why = match self.feel {
            Feel { is_docked: true, .. } => "it stands on its charger",
            Feel { drops: [false, false], cliffs, .. }
                if cliffs != [false; 4] && self.heads_on() =>
            {
                "it came to a cliff"
            }
            Feel { drops, .. } if drops != [false; 2] => "a wheel dropped",
            _ => return,
        };
        self.enter(Mode::Passive);
        self.note(format!(
            "{why}: stopped and back in passive mode; 131 (SAFE) lets it be driven again"
        ));
    }

    /// Whether it drives forwards, or backwards so tightly that its front swings.
    fn heads_on(&self) -> bool {
        let velocity = self.model.drive.body_velocity(self.wheels);
        let tight = velocity.linear_mps.abs() < velocity.angular_radps.abs() * self.model.radius_m;
        velocity.linear_mps > 0.0 || (velocity.linear_mps < 0.0 && tight)
    }

    fn doze(&mut self) {
        let is_idle = self.mode == Mode::Passive && !self.feel.is_docked;
        if is_idle && !self.is_asleep && self.now.since(self.passive_since) >= AWAKE_MAX {
            self.fall_asleep("it was in passive mode for five minutes");
        }
        if self.power.is_empty() && !self.is_asleep {
            self.fall_asleep("its battery is empty");
        }
    }

    fn fall_asleep(&mut self, why: &str) {
        self.enter(Mode::Off);
        self.is_asleep = true;
        self.is_streaming = false;
        self.decoder.clear();
        self.note(format!("{why}: asleep, and hears nothing until the line is taken up anew"));
    }

    /// Sends the frames that are due.
    fn send_stream(&mut self, site: Site<'_>, out: &mut Vec<u8>) {
        while self.is_streaming && self.now >= self.next_frame {
            self.next_frame += STREAM_PERIOD;
            let ids = std::mem::take(&mut self.stream);
            let readings = self.read(site, &ids);
            write_frame(&ids, &readings, out);
            self.stream = ids;
        }
    }
}

impl Board for CreateFirmware {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        let site = Site { world, body_id };
        let before = self.last_step.replace(now).unwrap_or(now);
        self.now = now;
        self.sense(site, now.since(before));
        if let Some(port) = ports.first_mut() {
            self.listen(site, port.received, port.out);
            self.guard();
            self.doze();
            self.send_stream(site, port.out);
        } else {
            self.guard();
            self.doze();
        }
        Some(MotorReference {
            wheels: self.wheels,
            acceleration_mps2: self.model.limits.acceleration_max_mps2,
        })
    }

    /// Its wheels go on: nothing in it notices. It wakes, because who takes a line up pulls BRC.
    fn hang_up(&mut self, _port_index: usize) {
        self.decoder.clear();
        self.is_asleep = self.power.is_empty();
        if !self.wheels.is_zero() {
            self.note("its client is gone and it drives on: it has no watchdog".to_owned());
        }
    }

    fn status(&self) -> BoardStatus {
        let charge_percent = self.power.charge_percent();
        BoardStatus {
            is_open: self.mode != Mode::Off,
            motors_enabled: self.mode >= Mode::Safe,
            n_heard: self.n_heard,
            unknown: self.unknown,
            battery: Some(BatteryStatus {
                charge_percent,
                voltage_v: self.power.voltage_v(),
                is_low: charge_percent < LOW_PERCENT,
            }),
            baud: Some(self.baud),
        }
    }

    fn take_requests(&mut self, into: &mut Vec<SimRequest>) {
        into.append(&mut self.notes);
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.mode as u64);
        hash.absorb_u64(u64::from(self.is_asleep));
        hash.absorb_u64(self.n_heard);
        for value in [
            self.wheels.left_mps,
            self.wheels.right_mps,
            self.distance_m,
            self.angle_rad,
            self.power.charge_percent(),
        ] {
            hash.absorb(value);
        }
        for count in self.counts {
            hash.absorb_u64(count.cast_unsigned());
        }
    }
}
