//! Whether a laser can be believed: silence, noise, damage, one scan for ever.

use std::time::Duration;

use geometry::wrap_to_pi;
use run_context::{Stamp, StateHash};
use sensor_models::{BeamSight, LaserKind, PlanarScan, ScanBeam};

use super::{LaserDriverConfig, LaserNews, TakeNews};

/// So many bytes in a row that say nothing are noise and no accident, from a device of short packets.
const NOISE_BYTES: u64 = 250;
/// The same of a SICK, whose scan is one telegram that trickles in: two of the longest.
const NOISE_BYTES_SICK: u64 = 1640;
/// Damage is judged over this time.
const WINDOW: Duration = Duration::from_secs(2);
/// Damaged packets in a window, and their part, from which on it is told.
const N_DAMAGED_MIN: u64 = 5;
const DAMAGED_RATIO_MIN: f64 = 0.1;
/// A scan with fewer surfaces may well repeat itself.
const N_SURFACES_MIN: usize = 8;
/// Beams of one scan; more than any device here has.
const N_BEAMS_MAX: usize = 4000;

/// What is wrong with a laser, in words that name it and say what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LaserTrouble {
    /// No byte comes.
    #[error(
        "laser `{name}` ({title}) is silent for {silent_s:.1} s: nothing is seen; check its power, its cable and \
         whether another program has it"
    )]
    Silent {
        /// The laser.
        name: String,
        /// What it is.
        title: &'static str,
        /// For how long, seconds.
        silent_s: f64,
    },
    /// Bytes come and mean nothing.
    #[error(
        "laser `{name}` ({title}) sends {n_bytes} bytes in which nothing can be read: nothing is seen; set the \
         line to the device's speed ({baud} bits per second unless it was changed), or name the right kind of laser"
    )]
    Noise {
        /// The laser.
        name: String,
        /// What it is.
        title: &'static str,
        /// Bytes since something was understood.
        n_bytes: u64,
        /// The speed at which such a device begins, bits per second.
        baud: u32,
    },
    /// It answers, but no scans come.
    #[error("laser `{name}` ({title}) answers but sends no scans: nothing is seen; {why}")]
    NoScans {
        /// The laser.
        name: String,
        /// What it is.
        title: &'static str,
        /// What it refused or reported, and what to do.
        why: String,
    },
    /// The same readings again and again.
    #[error(
        "laser `{name}` ({title}) repeats one scan for {for_s:.1} s, which no working laser does: nothing is seen; \
         switch it off and on"
    )]
    Frozen {
        /// The laser.
        name: String,
        /// What it is.
        title: &'static str,
        /// For how long, seconds.
        for_s: f64,
    },
    /// Many packets are damaged; the others are used.
    #[error(
        "laser `{name}` ({title}): {n_damaged} of {n_all} packets are damaged; check the cable, its shield and the \
         power supply"
    )]
    Damaged {
        /// The laser.
        name: String,
        /// What it is.
        title: &'static str,
        /// Damaged packets in the last two seconds.
        n_damaged: u64,
        /// All packets in that time.
        n_all: u64,
    },
}

/// Keeps the newest scan and judges.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    pub(super) config: LaserDriverConfig,
    kind: LaserKind,
    baud: u32,
    /// The scan that grows.
    pub(super) growing: PlanarScan,
    newest: PlanarScan,
    has_scan: bool,
    began: Option<Stamp>,
    last_scan: Stamp,
    last_byte: Stamp,
    n_noise_bytes: u64,
    repeated: Option<(u64, Stamp)>,
    frozen_since: Option<Stamp>,
    window_began: Stamp,
    window: [u64; 2],
    damaged: Option<[u64; 2]>,
    counted: [u64; 2],
    /// What the device refused or reported.
    pub(super) why: Option<String>,
    trouble: Option<LaserTrouble>,
}

impl Watch {
    pub(super) fn new(config: LaserDriverConfig, kind: LaserKind, baud: u32) -> Self {
        let model = kind.model();
        let scan = || PlanarScan {
            range_min_m: model.range_min_m,
            range_max_m: model.range_max_m,
            beams: Vec::with_capacity(512),
            ..PlanarScan::default()
        };
        Self {
            config,
            kind,
            baud,
            growing: scan(),
            newest: scan(),
            has_scan: false,
            began: None,
            last_scan: Stamp::ZERO,
            last_byte: Stamp::ZERO,
            n_noise_bytes: 0,
            repeated: None,
            frozen_since: None,
            window_began: Stamp::ZERO,
            window: [0; 2],
            damaged: None,
            counted: [0; 2],
            why: None,
            trouble: None,
        }
    }

    /// Bytes came.
    pub(super) fn hear(&mut self, now: Stamp, n_bytes: usize) {
        if self.began.is_none() {
            self.began = Some(now);
            self.last_byte = now;
            self.last_scan = now;
            self.window_began = now;
        }
        if n_bytes > 0 {
            self.last_byte = now;
            self.n_noise_bytes = self.n_noise_bytes.saturating_add(n_bytes as u64);
        }
    }

    /// Something was understood.
    pub(super) fn understand(&mut self) {
        self.n_noise_bytes = 0;
    }

    /// For how long no byte has come.
    pub(super) fn silent_for(&self, now: Stamp) -> Duration {
        now.since(self.last_byte)
    }

    /// For how long no scan has come.
    pub(super) fn blind_for(&self, now: Stamp) -> Duration {
        now.since(self.last_scan)
    }

    /// Adds a beam to the growing scan; `bearing_rad` counter-clockwise from the device's zero axis.
    pub(super) fn add(
        &mut self,
        bearing_rad: f64,
        after_s: f64,
        sight: BeamSight,
        strength_ratio: f64,
    ) {
        if self.growing.beams.len() < N_BEAMS_MAX {
            let bearing_rad = wrap_to_pi(bearing_rad + self.config.zero_axis_rad);
            self.growing.beams.push(ScanBeam { bearing_rad, after_s, sight, strength_ratio });
        }
    }

    /// The growing scan is whole.
    pub(super) fn finish(&mut self, now: Stamp, take: TakeNews<'_>) {
        std::mem::swap(&mut self.growing, &mut self.newest);
        self.growing.beams.clear();
        self.growing.number = self.newest.number + 1;
        self.has_scan = true;
        self.last_scan = now;
        self.why = None;
        self.look_for_repeats(now);
        // What is not believed is handed to nobody.
        if self.frozen_for(now).is_none() {
            take(LaserNews::Scan(&self.newest));
        }
    }

    fn look_for_repeats(&mut self, now: Stamp) {
        let mut hash = StateHash::new();
        for beam in &self.newest.beams {
            hash.absorb_u64(beam.surface_m().map_or(u64::MAX, f64::to_bits));
        }
        match self.repeated {
            Some((same, since))
                if same == hash.value() && self.newest.n_surfaces() >= N_SURFACES_MIN =>
            {
                self.frozen_since = Some(since);
            }
            _ => {
                self.repeated = Some((hash.value(), now));
                self.frozen_since = None;
            }
        }
    }

    /// Counts good and damaged packets, as counters since the beginning.
    pub(super) fn count(&mut self, now: Stamp, n_good: u64, n_damaged: u64) {
        self.window[0] += n_good.saturating_sub(self.counted[0]);
        self.window[1] += n_damaged.saturating_sub(self.counted[1]);
        self.counted = [n_good, n_damaged];
        if now.since(self.window_began) >= WINDOW {
            let [good, damaged] = self.window;
            let ratio = damaged as f64 / (good + damaged).max(1) as f64;
            let is_bad = damaged >= N_DAMAGED_MIN && ratio >= DAMAGED_RATIO_MIN;
            self.damaged = is_bad.then_some([damaged, good + damaged]);
            self.window = [0; 2];
            self.window_began = now;
        }
    }

    /// The newest scan, if it can be believed.
    pub(super) fn latest(&self, now: Stamp) -> Option<&PlanarScan> {
        let can = self.has_scan
            && self.blind_for(now) < self.config.silence_max
            && self.frozen_for(now).is_none();
        can.then_some(&self.newest)
    }

    pub(super) fn trouble(&self) -> Option<&LaserTrouble> {
        self.trouble.as_ref()
    }

    /// Says what is wrong, when that has changed.
    pub(super) fn judge(&mut self, now: Stamp, take: TakeNews<'_>) {
        let found = self.found(now);
        let same = match (&found, &self.trouble) {
            (Some(new), Some(old)) => std::mem::discriminant(new) == std::mem::discriminant(old),
            (new, old) => new.is_none() && old.is_none(),
        };
        if same {
            return;
        }
        self.trouble = found;
        match &self.trouble {
            Some(trouble) => take(LaserNews::Trouble(trouble)),
            None if self.has_scan => take(LaserNews::Well),
            None => {}
        }
    }

    fn frozen_for(&self, now: Stamp) -> Option<Duration> {
        let after = self.config.frozen_after?;
        self.frozen_since.map(|since| now.since(since)).filter(|time| *time >= after)
    }

    fn found(&self, now: Stamp) -> Option<LaserTrouble> {
        let (name, title) = (|| self.config.name.clone(), self.kind.title());
        if let Some(time) = self.frozen_for(now) {
            return Some(LaserTrouble::Frozen { name: name(), title, for_s: time.as_secs_f64() });
        }
        let silence = self.silent_for(now);
        if silence >= self.config.silence_max {
            let silent_s = silence.as_secs_f64();
            return Some(LaserTrouble::Silent { name: name(), title, silent_s });
        }
        let noise_bytes = match self.kind {
            LaserKind::SickLms => NOISE_BYTES_SICK,
            LaserKind::RplidarA1 | LaserKind::Ld06 => NOISE_BYTES,
        };
        if self.n_noise_bytes >= noise_bytes {
            let (n_bytes, baud) = (self.n_noise_bytes, self.baud);
            return Some(LaserTrouble::Noise { name: name(), title, n_bytes, baud });
        }
        if let Some(why) = &self.why {
            return Some(LaserTrouble::NoScans { name: name(), title, why: why.clone() });
        }
        // Twice: a laser that falls silent has sent its last scan before its last byte.
        if self.has_scan && self.blind_for(now) >= 2 * self.config.silence_max {
            let why = "it is being started again".to_owned();
            return Some(LaserTrouble::NoScans { name: name(), title, why });
        }
        let [n_damaged, n_all] = self.damaged?;
        Some(LaserTrouble::Damaged { name: name(), title, n_damaged, n_all })
    }
}
