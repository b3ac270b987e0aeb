//! A SICK LMS200: it is configured, and then sends scans on request or without end.
//!
//! After power-on it tells its type, sends nothing by itself, measures 180° at 1° in centimetres and speaks at 9600
//! baud. Each request is answered by a bare `06` (or `15` for a wrong checksum) and a telegram; a change of speed takes
//! effect after its answer. Configurations are written in installation mode only.
//!
//! Differences from the device: it is ready at once instead of after a minute, and after three seconds when it was
//! reset; it measures only while somebody wants scans; subranges, partial scans, reflectivity and diagnostic mode
//! are refused (`A0 01`); fields, reflectors and dazzling do not exist; the configuration survives a reset.

use std::time::Duration;

use run_context::{RandomStream, Stamp, StateHash};
use sensor_models::LaserModel;
use simulator::{BodyId, World};
use wire::sick_lms::{
    ACK, BAUD_START, Baud, Config, Decoder, Item, NAK, PASSWORD, RangeField, Reading, Reply,
    Request, STATUS_OK, ScanReply, Side, StatusReply, Unit, Variant, write_telegram,
};

use super::{Head, LaserConfig, LineOut};
use crate::{Board, BoardStatus, MotorReference, NumberSet, Port};

/// Time after a reset in which nothing is heard.
const RESET_TIME: Duration = Duration::from_secs(3);
/// A telegram that stays unfinished for this long is noise.
const UNFINISHED_MAX: Duration = Duration::from_millis(100);
const TYPE: &[u8] = b"LMS200;301063;V02.10 ";
const FIRMWARE: [u8; 7] = *b"V02.10 ";
/// Modes as command `20` sets them.
const MODE_INSTALLATION: u8 = 0x00;
const MODE_CONTINUOUS: u8 = 0x24;
const MODE_ON_REQUEST: u8 = 0x25;

/// Firmware of a SICK LMS200.
#[derive(Clone, Debug)]
pub struct SickLmsFirmware {
    head: Head,
    decoder: Decoder,
    core: Core,
    last_byte: Stamp,
    n_bad_checksums: u64,
}

/// All of it but what takes bytes apart and what looks.
#[derive(Clone, Debug)]
struct Core {
    /// How it measures, whatever the client chooses of beams.
    model: LaserModel,
    mode: u8,
    one_scan: bool,
    config: Config,
    variant: Variant,
    baud: Baud,
    line: LineOut,
    /// Readings of the scan under way.
    readings: Vec<u16>,
    payload: Vec<u8>,
    /// When it will say that it has been switched on.
    tells_type_at: Option<Stamp>,
    unknown: NumberSet,
    n_scans: u64,
    n_scans_skipped: u64,
}

impl SickLmsFirmware {
    /// A laser that has just been switched on.
    pub fn new(config: LaserConfig, rng: RandomStream) -> Self {
        let core = Core {
            model: config.model,
            mode: MODE_ON_REQUEST,
            one_scan: false,
            config: Config::delivered(),
            variant: Variant::ALL[0],
            baud: Baud::of(BAUD_START).unwrap_or(Baud::B9600),
            line: LineOut::new(config.is_paced),
            readings: vec![0; 401],
            payload: Vec::with_capacity(wire::sick_lms::PAYLOAD_MAX),
            tells_type_at: Some(Stamp::ZERO),
            unknown: NumberSet::default(),
            n_scans: 0,
            n_scans_skipped: 0,
        };
        let mut head = Head::new(&config, rng);
        head.sweep.set_model(core.seen_model());
        let decoder = Decoder::new(Side::FromHost);
        Self { head, decoder, core, last_byte: Stamp::ZERO, n_bad_checksums: 0 }
    }

    /// Scans sent so far.
    pub fn n_scans(&self) -> u64 {
        self.core.n_scans
    }

    /// Scans measured while another was still leaving, and so never sent.
    pub fn n_scans_skipped(&self) -> u64 {
        self.core.n_scans_skipped
    }

    /// The speed at which it listens and speaks, bits per second.
    pub fn baud(&self) -> u32 {
        self.core.baud.bits_per_s()
    }

    fn measure(&mut self, now: Stamp, world: &World, body_id: BodyId, out: &mut Vec<u8>) {
        if !self.core.wants_scans() {
            self.head.sweep.stop();
            return;
        }
        self.head.sweep.start(now);
        let core = &mut self.core;
        self.head.fire(now, world, body_id, |beam| {
            core.note(beam.index, beam.echo.range_m);
            if beam.is_last {
                core.send_scan(now, out);
            }
        });
    }
}

impl Core {
    fn wants_scans(&self) -> bool {
        self.one_scan || self.mode == MODE_CONTINUOUS
    }

    fn field(&self) -> RangeField {
        // Modes without ranges are refused when they are written.
        RangeField::of_mode(self.config.measuring_mode()).unwrap_or(RangeField::BITS_13)
    }

    fn unit(&self) -> Unit {
        self.config.unit().unwrap_or(Unit::Cm)
    }

    /// The model with the beams that the client chose.
    fn seen_model(&self) -> LaserModel {
        LaserModel {
            first_beam_rad: -0.5 * f64::from(self.variant.angle_deg).to_radians(),
            beam_spacing_rad: (f64::from(self.variant.resolution_cdeg) / 100.0).to_radians(),
            n_beams: self.variant.n_readings(),
            n_turns: self.variant.n_turns(),
            ..self.model
        }
    }

    fn note(&mut self, index: usize, range_m: f64) {
        let reading = if range_m.is_finite() {
            // Casts from floats saturate.
            Reading::Range((range_m / self.unit().metres()).round() as u16)
        } else {
            Reading::NoReturn
        };
        let bits = self.field().encode(reading);
        if let Some(place) = self.readings.get_mut(index) {
            *place = bits;
        }
    }

    fn send_scan(&mut self, now: Stamp, out: &mut Vec<u8>) {
        if !self.wants_scans() {
            return;
        }
        if !self.line.is_free(now) {
            self.n_scans_skipped += 1;
            return;
        }
        self.one_scan = false;
        self.n_scans += 1;
        self.payload.clear();
        let n = self.variant.n_readings().min(self.readings.len());
        ScanReply::write(self.unit(), self.readings[..n].iter().copied(), &mut self.payload);
        let start = out.len();
        write_telegram(0x80, &self.payload, out);
        self.line.take(now, out.len() - start, self.baud.bits_per_s());
    }

    fn say(&mut self, now: Stamp, reply: &Reply<'_>, out: &mut Vec<u8>) {
        let start = out.len();
        reply.encode(0, STATUS_OK, out);
        self.line.take(now, out.len() - start, self.baud.bits_per_s());
    }

    fn set_mode(&mut self, now: Stamp, mode: u8, out: &mut Vec<u8>) {
        self.mode = mode;
        self.one_scan = false;
        self.say(now, &Reply::Mode(0), out);
    }

    fn answer(&mut self, now: Stamp, payload: &[u8], out: &mut Vec<u8>) {
        out.push(ACK);
        match Request::decode(payload) {
            Request::Reset => {
                self.say(now, &Reply::WillReset, out);
                self.tells_type_at = Some(now + RESET_TIME);
                self.forget();
            }
            Request::Installation(PASSWORD) => self.set_mode(now, MODE_INSTALLATION, out),
            Request::Continuous => self.set_mode(now, MODE_CONTINUOUS, out),
            Request::OnRequest => self.set_mode(now, MODE_ON_REQUEST, out),
            Request::Baud(baud) => {
                // The answer leaves at the old speed.
                self.say(now, &Reply::Mode(0), out);
                self.baud = baud;
            }
            Request::Installation(_) => self.say(now, &Reply::Mode(1), out),
            Request::OtherMode(mode) => {
                self.unknown.insert(mode);
                self.say(now, &Reply::Mode(1), out);
            }
            Request::OneScan => self.one_scan = true,
            Request::Status => self.say(now, &Reply::Status(self.status()), out),
            Request::Errors => self.say(now, &Reply::Errors(&[]), out),
            Request::Type => self.say(now, &Reply::Type(TYPE), out),
            Request::Variant(variant) if self.mode != MODE_CONTINUOUS => {
                let ok = variant.is_known();
                if ok {
                    self.variant = variant;
                }
                self.say(now, &Reply::Variant(ok, self.variant), out);
            }
            Request::ReadConfig => self.say(now, &Reply::Config(self.config), out),
            Request::WriteConfig(config) if self.mode == MODE_INSTALLATION => {
                let ok = config.unit().is_some()
                    && RangeField::of_mode(config.measuring_mode()).is_some();
                if ok {
                    self.config = config;
                }
                self.say(now, &Reply::ConfigWritten(ok, self.config), out);
            }
            Request::Variant(_) | Request::WriteConfig(_) => self.say(now, &Reply::Refused, out),
            Request::Other(command) => {
                self.unknown.insert(command);
                self.say(now, &Reply::Refused, out);
            }
        }
    }

    fn status(&self) -> StatusReply {
        StatusReply {
            firmware: FIRMWARE,
            mode: self.mode,
            is_defective: false,
            measuring_mode: self.config.measuring_mode(),
            variant: self.variant,
            baud: Some(self.baud),
            address: 0,
            unit: self.config.unit(),
        }
    }

    /// What a client has set and what does not outlast it.
    fn forget(&mut self) {
        self.mode = MODE_ON_REQUEST;
        self.one_scan = false;
        self.variant = Variant::ALL[0];
        self.baud = Baud::of(BAUD_START).unwrap_or(Baud::B9600);
    }
}

impl Board for SickLmsFirmware {
    fn step(
        &mut self,
        now: Stamp,
        world: &World,
        body_id: BodyId,
        ports: &mut [Port<'_>],
    ) -> Option<MotorReference> {
        let port = ports.first_mut()?;
        if let Some(at) = self.core.tells_type_at {
            if now < at {
                return None;
            }
            self.core.tells_type_at = None;
            self.core.say(now, &Reply::PowerOn(TYPE), port.out);
        }
        if !port.received.is_empty() {
            self.last_byte = now;
            self.decoder.push(port.received);
        } else if now.since(self.last_byte) >= UNFINISHED_MAX {
            self.decoder.give_up_unfinished();
        }
        let variant_before = self.core.variant;
        while let Some(item) = self.decoder.next_item() {
            if let Item::Telegram { payload, .. } = item {
                self.core.answer(now, payload, port.out);
            }
        }
        if self.decoder.n_bad_checksums() != self.n_bad_checksums {
            self.n_bad_checksums = self.decoder.n_bad_checksums();
            port.out.push(NAK);
        }
        if self.core.variant != variant_before {
            self.head.sweep.set_model(self.core.seen_model());
        }
        self.measure(now, world, body_id, port.out);
        None
    }

    /// The next client finds it as after power-on, except for what is written into its memory.
    fn hang_up(&mut self, _port_index: usize) {
        self.core.forget();
        self.core.unknown = NumberSet::default();
        self.decoder.clear();
        self.head.sweep.stop();
        self.head.sweep.set_model(self.core.seen_model());
    }

    fn status(&self) -> BoardStatus {
        BoardStatus {
            is_open: self.core.wants_scans(),
            n_heard: self.decoder.n_telegrams(),
            unknown: self.core.unknown,
            baud: Some(self.baud()),
            ..BoardStatus::default()
        }
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        self.head.absorb_state(hash);
        let core = &self.core;
        hash.absorb_u64(core.n_scans);
        hash.absorb_u64(self.decoder.n_telegrams());
        hash.absorb_u64(core.mode.into());
        hash.absorb_u64(core.one_scan.into());
        hash.absorb_u64(core.variant.n_readings() as u64);
        hash.absorb_u64(core.baud.bits_per_s().into());
        hash.absorb_u64(core.line.free_at.as_nanos());
        hash.absorb_bytes(core.config.bytes());
    }
}
