//! The client of a SICK LMS200: finds it, changes the line's speed, configures it where it must, and lets it scan.
//!
//! **Finding.** Its type is asked for, at each speed in turn where the line has speeds: second-hand devices often
//! keep 38 400. Scans that come unasked are those of an old session, which is ended.
//! **Configuring.** The configuration is read and only written when unit or measuring mode differ: the
//! device's memory wears out.
//! **Scanning.** A device that falls silent is looked for again.

use std::time::Duration;

use run_context::Stamp;
use sensor_models::{BeamSight, LaserKind, PlanarScan};
use wire::sick_lms::{
    BAUD_START, Baud, Decoder, Item, RangeField, Reading, Reply, Request, ScanReply, Side, Unit,
    Variant,
};

use super::{LaserDriver, LaserDriverConfig, LaserTrouble, TakeNews, watch::Watch};

/// Time to wait for an ordinary answer.
const ANSWER_MAX: Duration = Duration::from_secs(1);
/// Time that a change of mode may take.
const MODE_MAX: Duration = Duration::from_secs(3);
/// Time that writing the configuration may take.
const WRITE_MAX: Duration = Duration::from_secs(15);
/// The device listens at its new speed after this time.
const SETTLING: Duration = Duration::from_millis(50);
/// A telegram that stays unfinished for this long is noise.
const UNFINISHED_MAX: Duration = Duration::from_millis(100);
/// Questions at one speed before the next is tried.
const N_TRIES: u32 = 3;
/// 15-bit ranges in millimetres reach 32 m.
const MEASURING_MODE: u8 = 5;
const VARIANT: Variant = Variant { angle_deg: 180, resolution_cdeg: 100 };

/// The driver of one SICK LMS200: 180° at 1°, in millimetres.
#[derive(Clone, Debug)]
pub struct SickLmsDriver {
    decoder: Decoder,
    core: Core,
}

#[derive(Clone, Debug)]
struct Core {
    watch: Watch,
    phase: Phase,
    since: Stamp,
    n_tries: u32,
    /// The line's speed, where it has one.
    baud: Option<Baud>,
    field: RangeField,
    n_refused: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    New,
    AskingType,
    EndingOldScan,
    ChangingBaud(Baud),
    Settling,
    SettingVariant,
    ReadingConfig,
    Installing,
    WritingConfig,
    Starting,
    Scanning,
}

impl SickLmsDriver {
    /// A driver that will look for its laser at its first step.
    pub fn new(config: LaserDriverConfig) -> Self {
        let baud = config.change_baud_to.and_then(|_| Baud::of(BAUD_START));
        let core = Core {
            watch: Watch::new(config, LaserKind::SickLms, BAUD_START),
            phase: Phase::New,
            since: Stamp::ZERO,
            n_tries: 0,
            baud,
            field: RangeField::BITS_13,
            n_refused: 0,
        };
        Self { decoder: Decoder::new(Side::FromDevice), core }
    }

    /// The decoder, for its counters of noise.
    pub fn decoder(&self) -> &Decoder {
        &self.decoder
    }

    /// Requests so far that the device refused.
    pub fn n_refused(&self) -> u64 {
        self.core.n_refused
    }
}

impl Core {
    fn enter(&mut self, now: Stamp, phase: Phase, out: &mut Vec<u8>) {
        self.phase = phase;
        self.since = now;
        let request = match phase {
            Phase::New | Phase::Settling | Phase::Scanning => return,
            Phase::AskingType => Request::Type,
            Phase::EndingOldScan => Request::OnRequest,
            Phase::ChangingBaud(baud) => Request::Baud(baud),
            Phase::SettingVariant => Request::Variant(VARIANT),
            Phase::ReadingConfig => Request::ReadConfig,
            Phase::Installing => Request::INSTALLATION,
            Phase::WritingConfig => {
                let config = wire::sick_lms::Config::delivered();
                Request::WriteConfig(config.with(Unit::Mm, MEASURING_MODE))
            }
            Phase::Starting => Request::Continuous,
        };
        request.encode(0, out);
    }

    fn keep_up(&mut self, now: Stamp, out: &mut Vec<u8>) {
        let limit = match self.phase {
            Phase::New => Duration::ZERO,
            Phase::Settling => SETTLING,
            Phase::WritingConfig => WRITE_MAX,
            Phase::EndingOldScan | Phase::Installing | Phase::Starting => MODE_MAX,
            Phase::Scanning => {
                let blind =
                    self.watch.blind_for(now) >= self.watch.config.silence_max.max(ANSWER_MAX);
                if blind && now.since(self.since) >= MODE_MAX {
                    self.enter(now, Phase::AskingType, out);
                }
                return;
            }
            _ => ANSWER_MAX,
        };
        if now.since(self.since) < limit {
            return;
        }
        if !matches!(self.phase, Phase::New | Phase::Settling) {
            self.n_tries += 1;
            if self.n_tries >= N_TRIES {
                self.n_tries = 0;
                self.try_next_baud();
            }
        }
        self.enter(now, Phase::AskingType, out);
    }

    /// Where the line has speeds, the next of those that RS-232 carries.
    fn try_next_baud(&mut self) {
        let order = [Baud::B9600, Baud::B38400, Baud::B19200];
        if let Some(baud) = self.baud {
            let at = order.iter().position(|one| *one == baud).unwrap_or(0);
            self.baud = Some(order[(at + 1) % order.len()]);
        }
    }

    fn take_reply(
        &mut self,
        now: Stamp,
        reply: &Reply<'_>,
        n_bytes: usize,
        news: TakeNews<'_>,
        out: &mut Vec<u8>,
    ) {
        match (self.phase, reply) {
            (Phase::Scanning, Reply::Scan(scan)) => self.take_scan(now, scan, n_bytes, news),
            (Phase::AskingType | Phase::SettingVariant | Phase::ReadingConfig, Reply::Scan(_)) => {
                self.enter(now, Phase::EndingOldScan, out);
            }
            (Phase::AskingType, Reply::Type(_)) => {
                self.n_tries = 0;
                let wanted = self.watch.config.change_baud_to.and_then(Baud::of);
                let next = match wanted.filter(|wanted| Some(*wanted) != self.baud) {
                    Some(baud) => Phase::ChangingBaud(baud),
                    None => Phase::SettingVariant,
                };
                self.enter(now, next, out);
            }
            (Phase::EndingOldScan, Reply::Mode(0)) => self.enter(now, Phase::AskingType, out),
            (Phase::ChangingBaud(baud), Reply::Mode(0)) => {
                self.baud = Some(baud);
                self.enter(now, Phase::Settling, out);
            }
            (Phase::SettingVariant, Reply::Variant(true, _)) => {
                self.enter(now, Phase::ReadingConfig, out);
            }
            (Phase::ReadingConfig, Reply::Config(config)) => {
                let is_right =
                    config.unit() == Some(Unit::Mm) && config.measuring_mode() == MEASURING_MODE;
                let next = if is_right { Phase::Starting } else { Phase::Installing };
                self.enter(now, next, out);
            }
            (Phase::Installing, Reply::Mode(0)) => self.enter(now, Phase::WritingConfig, out),
            (Phase::WritingConfig, Reply::ConfigWritten(true, _)) => {
                self.enter(now, Phase::Starting, out);
            }
            (Phase::Starting, Reply::Mode(0)) => {
                let field = RangeField::of_mode(MEASURING_MODE);
                self.field = field.unwrap_or(RangeField::BITS_13);
                self.enter(now, Phase::Scanning, out);
            }
            (
                _,
                Reply::Refused
                | Reply::Mode(_)
                | Reply::Variant(false, _)
                | Reply::ConfigWritten(false, _),
            ) => {
                self.n_refused += 1;
                let what = format!("{:?}", self.phase);
                self.watch.why = Some(format!(
                    "it refuses a request ({what}); switch it off and on, and see its password"
                ));
            }
            _ => {}
        }
    }

    fn take_scan(&mut self, now: Stamp, scan: &ScanReply<'_>, n_bytes: usize, news: TakeNews<'_>) {
        let model = LaserKind::SickLms.model();
        let metres = scan.unit.metres();
        let sent = self.watch.config.line.sent_at(now, n_bytes);
        let took = model.fired_after(VARIANT.n_readings() - 1).as_nanos() as u64;
        self.watch.growing.about = Stamp::from_nanos(sent.as_nanos().saturating_sub(took));
        self.watch.growing.range_max_m = f64::from(self.field.range_max()) * metres;
        self.watch.growing.beams.clear();
        let last = scan.len().saturating_sub(1) as f64;
        for (index, bits) in scan.bits().enumerate() {
            let sight = match self.field.decode(bits) {
                Reading::Range(units) => BeamSight::Surface(f64::from(units) * metres),
                Reading::Beyond => BeamSight::Beyond,
                Reading::NoReturn | Reading::WeakSignal => BeamSight::NoReturn,
                Reading::Invalid => BeamSight::Unseen,
            };
            let bearing_deg = index as f64 - 0.5 * last;
            let after_s = model.fired_after(index).as_secs_f64();
            self.watch.add(bearing_deg.to_radians(), after_s, sight, 0.0);
        }
        self.watch.finish(now, news);
    }
}

impl LaserDriver for SickLmsDriver {
    fn step(&mut self, now: Stamp, received: &[u8], take: TakeNews<'_>, out: &mut Vec<u8>) {
        let Self { decoder, core } = self;
        core.watch.hear(now, received.len());
        decoder.push(received);
        if received.is_empty() && core.watch.silent_for(now) >= UNFINISHED_MAX {
            decoder.give_up_unfinished();
        }
        while let Some(item) = decoder.next_item() {
            let Item::Telegram { payload, .. } = item else { continue };
            core.watch.understand();
            if let Some((reply, _status)) = Reply::decode(payload) {
                core.take_reply(now, &reply, payload.len() + 6, take, out);
            }
        }
        core.watch.count(now, decoder.n_telegrams(), decoder.n_bad_checksums());
        core.keep_up(now, out);
        core.watch.judge(now, take);
    }

    fn latest(&self, now: Stamp) -> Option<&PlanarScan> {
        self.core.watch.latest(now)
    }

    fn trouble(&self) -> Option<&LaserTrouble> {
        self.core.watch.trouble()
    }

    fn wanted_baud(&self) -> Option<u32> {
        self.core.baud.map(Baud::bits_per_s)
    }

    fn disconnect(&mut self, out: &mut Vec<u8>) {
        Request::OnRequest.encode(0, out);
        self.core.phase = Phase::New;
    }
}
