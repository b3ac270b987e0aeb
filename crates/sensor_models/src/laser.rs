//! A scanning range finder: thin beams that turn, one after the other.
//!
//! A beam goes out, a surface scatters part of it back, and the receiver hears it when enough returns: the
//! received power falls with the square of the range and with the cosine of the incidence (the
//! lidar equation for a surface larger than the beam), so a surface of remission ρ is seen up to
//! [`reach_m`](LaserModel::reach_m)·√(ρ·cos). What is not heard is not there: glass lets the beam through
//! to what stands behind it, a mirror shows what stands in front of it, too far, and both answer for
//! themselves only when they are met head-on. Beams are infinitely thin: no mixed pixels at edges.
//!
//! [`LaserModel`] says how the beams lie in space and in time and how well they measure;
//! [`Sweep`] fires them as time passes, so that a robot that turns while it scans gets a scan that is bent
//! as a real one's; [`PlanarScan`] is the other side, what a client makes of the bytes.
//!
//! Source of the lidar equation: Wagner, Ullrich, Ducic, Melzer, Studnicka (2006), "Gaussian
//! decomposition and calibration of a novel small-footprint full-waveform digitising airborne laser
//! scanner", ISPRS J. 60(2), eq. (6), for an extended Lambertian target.

mod scan;
mod sweep;

use std::{f64::consts::TAU, time::Duration};

use geometry::{Ray, RayCaster, Se2, Vec2};
use rand_core::Rng as _;
use run_context::{RandomStream, StateHash};

pub use self::{
    scan::{BeamSight, PlanarScan, ScanBeam},
    sweep::{Beam, Sweep},
};
use crate::{
    material::{Light, Material},
    sonar::ModelRange,
};

/// Surfaces that a beam may pass or be mirrored by before it is given up: two panes of glass.
const N_SURFACES_MAX: usize = 5;

/// A beam goes on this far behind the surface it has passed (m), or it would meet it again.
const PAST_THE_SURFACE_M: f64 = 1e-6;

/// Incidence within which a smooth surface throws the beam back into the receiver: cosine of 1°,
/// the order of a receiver's aperture and a beam's divergence together. Our choice.
const HEAD_ON_COSINE: f64 = 0.999_848;

/// How a scanning range finder's beams lie in space and time, and how well they measure.
///
/// Beam `i` of a scan looks to `first_beam_rad + i · beam_spacing_rad`, counter-clockwise from the sensor's x
/// axis; a negative spacing turns clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserModel {
    /// Direction of beam 0 from the sensor's x axis, radians, counter-clockwise.
    pub first_beam_rad: f64,
    /// Angle from one beam to the next, radians; counter-clockwise positive.
    pub beam_spacing_rad: f64,
    /// Number of beams of a scan, from 1 to 10 000; they span at most a whole turn.
    pub n_beams: usize,
    /// Time of one turn of the mirror or head, from 1 ms to 10 s.
    pub turn: Duration,
    /// Turns that one scan takes, from 1 to 8. With more than one the beams are interlaced: the first turn
    /// fires beams 0, n, 2n …, the second 1, n + 1 ….
    pub n_turns: usize,
    /// Nothing nearer is measured, metres.
    pub range_min_m: f64,
    /// Nothing farther is measured, metres.
    pub range_max_m: f64,
    /// Up to where a white surface (remission 1), met head-on, returns enough light, metres.
    pub reach_m: f64,
    /// Standard deviation of the range that does not depend on it, metres.
    pub range_std_m: f64,
    /// Standard deviation of the range per metre of range, a ratio.
    pub range_std_ratio: f64,
    /// Ranges are the nearest whole number of these, metres; 0 for ranges as fine as measured.
    pub range_step_m: f64,
    /// Probability that a beam returns nothing although it should.
    pub dropout_prob: f64,
}

/// The lasers whose bytes are spoken here; one table for commands, missions and guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LaserKind {
    /// SICK LMS200: half a circle, the laser of Pioneers.
    SickLms,
    /// RPLIDAR A1: a whole turn of some 360 samples, clockwise, 5.5 turns a second.
    RplidarA1,
    /// LD06 and LD19: a whole turn of 450 points, clockwise, 10 turns a second.
    Ld06,
}

/// What came back of one beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserEcho {
    /// The range, metres; infinite when nothing came back.
    pub range_m: f64,
    /// Part of the light that the surface sent back, of a white one's head-on, from 0 to 1; 0 when nothing
    /// came back.
    pub strength_ratio: f64,
}

impl LaserEcho {
    /// Nothing came back.
    pub const NOTHING: Self = Self { range_m: f64::INFINITY, strength_ratio: 0.0 };

    /// Whether something came back.
    pub fn is_something(self) -> bool {
        self.range_m.is_finite()
    }
}

settings::choices!(LaserKind {
    SickLms = "sick": "SICK LMS200: half a circle, the laser of Pioneers",
    RplidarA1 = "rplidar": "RPLIDAR A1: a whole turn, 5.5 turns a second, clockwise",
    Ld06 = "ld06": "LD06 or LD19: a whole turn, 10 turns a second, clockwise",
});

impl LaserKind {
    /// All there are.
    pub const ALL: [Self; 3] = [Self::SickLms, Self::RplidarA1, Self::Ld06];

    /// The word for it in commands and files.
    pub fn name(self) -> &'static str {
        settings::Choice::key(self)
    }

    /// What people call it.
    pub fn title(self) -> &'static str {
        match self {
            Self::SickLms => "SICK LMS200",
            Self::RplidarA1 => "RPLIDAR A1",
            Self::Ld06 => "LD06",
        }
    }

    /// The word for what is spoken on its line.
    pub fn protocol(self) -> &'static str {
        match self {
            Self::SickLms => "sick_lms",
            Self::RplidarA1 => "rplidar",
            Self::Ld06 => "ld06",
        }
    }

    /// The kind of that [`name`](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// How it measures after power-on.
    pub fn model(self) -> LaserModel {
        match self {
            Self::SickLms => LaserModel::sick_lms200(),
            Self::RplidarA1 => LaserModel::rplidar_a1(),
            Self::Ld06 => LaserModel::ld06(),
        }
    }
}

impl LaserModel {
    /// Half a circle in front at one beam per degree, 8 m, 1 cm, 75 scans a second: the class of a small
    /// safety scanner, without anything that goes wrong.
    pub fn half_circle() -> Self {
        Self {
            first_beam_rad: -std::f64::consts::FRAC_PI_2,
            beam_spacing_rad: 1.0_f64.to_radians(),
            n_beams: 181,
            turn: Duration::from_nanos(13_333_333),
            n_turns: 1,
            range_min_m: 0.0,
            range_max_m: 8.0,
            reach_m: 80.0,
            range_std_m: 0.01,
            range_std_ratio: 0.0,
            range_step_m: 0.0,
            dropout_prob: 0.0,
        }
    }

    /// The SICK LMS200 after power-on: 180° at 1°, 75 turns a second, 80 m, 10 m on 10 % remission.
    ///
    /// Source: SICK's technical description of the LMS200 (10 m at 10 % remission, 5 mm deviation,
    /// 75 Hz), as far as quoted by public drivers.
    pub fn sick_lms200() -> Self {
        Self {
            range_max_m: 80.0,
            // 10 m at 10 %: the root of ten more at 100 %.
            reach_m: 31.6,
            range_std_m: 0.005,
            range_step_m: 0.001,
            ..Self::half_circle()
        }
    }

    /// The RPLIDAR A1 in standard mode: 360 samples of 508 µs a turn, clockwise from its zero axis, 0.15
    /// to 12 m.
    ///
    /// Source: the maker's data sheet (0.15 to 12 m on white objects; resolution below 1 % of the
    /// range); the time of a sample as measured by `mikkleini/rplidar.net#2`.
    pub fn rplidar_a1() -> Self {
        Self {
            first_beam_rad: 0.0,
            beam_spacing_rad: -TAU / 360.0,
            n_beams: 360,
            turn: Duration::from_micros(508 * 360),
            n_turns: 1,
            range_min_m: 0.15,
            range_max_m: 12.0,
            reach_m: 12.0,
            range_std_m: 0.003,
            range_std_ratio: 0.003,
            range_step_m: 0.000_25,
            dropout_prob: 0.002,
        }
    }

    /// The LD06 (and LD19): 450 points a turn, clockwise from its zero axis, ten turns a second, 0.02 to
    /// 12 m.
    ///
    /// Source: the maker's data sheet (4500 points a second, 12 m on 70 % remission, ±1 cm typical up to
    /// 3 m).
    pub fn ld06() -> Self {
        Self {
            first_beam_rad: 0.0,
            beam_spacing_rad: -TAU / 450.0,
            n_beams: 450,
            turn: Duration::from_millis(100),
            n_turns: 1,
            range_min_m: 0.02,
            range_max_m: 12.0,
            reach_m: 14.3,
            range_std_m: 0.006,
            range_std_ratio: 0.001,
            range_step_m: 0.001,
            dropout_prob: 0.002,
        }
    }

    /// The same beams without any error of measurement, and all surfaces white enough.
    #[must_use]
    pub fn without_errors(self) -> Self {
        Self {
            range_std_m: 0.0,
            range_std_ratio: 0.0,
            range_step_m: 0.0,
            dropout_prob: 0.0,
            reach_m: 1e3,
            ..self
        }
    }

    /// Refuses settings outside the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// [`ModelRange`] for the first such setting; NaN is outside every range.
    pub fn checked(self) -> Result<Self, ModelRange> {
        let span_rad = self.beam_spacing_rad.abs() * self.n_beams.saturating_sub(1) as f64;
        let turn_s = self.turn.as_secs_f64();
        let checks = [
            ("first_beam_rad", self.first_beam_rad, -TAU, TAU, "from -6.283 to 6.283 rad"),
            ("beam_spacing_rad", self.beam_spacing_rad, -TAU, TAU, "from -6.283 to 6.283 rad"),
            ("n_beams", self.n_beams as f64, 1.0, 1e4, "from 1 to 10000"),
            ("beam_spacing_rad * (n_beams - 1)", span_rad, 0.0, TAU + 1e-9, "at most 6.283 rad"),
            ("turn", turn_s, 1e-3, 10.0, "from 0.001 to 10 s"),
            ("n_turns", self.n_turns as f64, 1.0, 8.0, "from 1 to 8"),
            ("range_min_m", self.range_min_m, 0.0, 1e3, "from 0 to 1000 m"),
            ("range_max_m", self.range_max_m, self.range_min_m, 1e3, "from range_min_m to 1000 m"),
            ("reach_m", self.reach_m, 0.0, 1e4, "from 0 to 10000 m"),
            ("range_std_m", self.range_std_m, 0.0, 1.0, "from 0 to 1 m"),
            ("range_std_ratio", self.range_std_ratio, 0.0, 1.0, "from 0 to 1"),
            ("range_step_m", self.range_step_m, 0.0, 1.0, "from 0 to 1 m"),
            ("dropout_prob", self.dropout_prob, 0.0, 1.0, "from 0 to 1"),
        ];
        for (key, value, min, max, requirement) in checks {
            if !(min..=max).contains(&value) {
                return Err(ModelRange { key, value, requirement });
            }
        }
        Ok(self)
    }

    /// Direction of beam `index` from the sensor's x axis, radians, counter-clockwise, not wrapped.
    pub fn bearing_rad(&self, index: usize) -> f64 {
        self.first_beam_rad + index as f64 * self.beam_spacing_rad
    }

    /// Time from one scan to the next.
    pub fn scan_period(&self) -> Duration {
        self.turn.saturating_mul(self.n_turns as u32)
    }

    /// When beam `index` is fired, from the beginning of its scan: the mirror turns evenly, and interlaced beams
    /// wait for their turn.
    pub fn fired_after(&self, index: usize) -> Duration {
        let of_a_turn = index as f64 * self.beam_spacing_rad.abs() / TAU;
        let n_turns_before = (index % self.n_turns.max(1)) as u32;
        self.turn.saturating_mul(n_turns_before) + self.turn.mul_f64(of_a_turn)
    }

    /// Scans at one instant from `world_from_sensor` into `scene`, whose tags are indices into `materials`,
    /// and replaces the content of `ranges_m` by one range (m) per beam, beam 0 first; `range_max_m` when
    /// nothing came back.
    ///
    /// One number is drawn from `rng`, whatever the beams meet. Allocates only while `ranges_m` grows.
    /// [`Sweep`] is for scans of a robot that moves.
    pub fn scan(
        &self,
        world_from_sensor: Se2,
        scene: &impl RayCaster,
        materials: &[Material],
        rng: &mut RandomStream,
        ranges_m: &mut Vec<f64>,
    ) {
        let luck = Luck::draw(rng);
        ranges_m.clear();
        ranges_m.extend((0..self.n_beams).map(|index| {
            let yaw_rad = world_from_sensor.yaw_rad + self.bearing_rad(index);
            let (s, c) = yaw_rad.sin_cos();
            let ray = Ray { origin: world_from_sensor.position(), direction: Vec2::new(c, s) };
            self.measure(&ray, scene, materials, luck.of(index)).range_m.min(self.range_max_m)
        }));
    }

    /// Measures along one ray: at most five casts, of which all but the first are for what stands behind glass or in
    /// a mirror. Does not allocate.
    pub(crate) fn measure(
        &self,
        ray: &Ray,
        scene: &impl RayCaster,
        materials: &[Material],
        luck: BeamLuck,
    ) -> LaserEcho {
        let Some((true_m, strength_ratio)) = self.light_returned(ray, scene, materials) else {
            return LaserEcho::NOTHING;
        };
        if self.dropout_prob > 0.0 && luck.uniform() < self.dropout_prob {
            return LaserEcho::NOTHING;
        }
        let std_m = self.range_std_m + self.range_std_ratio * true_m;
        let mut range_m = true_m + std_m * luck.gauss();
        if self.range_step_m > 0.0 {
            range_m = (range_m / self.range_step_m).round() * self.range_step_m;
        }
        if (self.range_min_m..=self.range_max_m).contains(&range_m) {
            LaserEcho { range_m, strength_ratio }
        } else {
            LaserEcho::NOTHING
        }
    }

    /// Way of the light to the first surface that sends enough back (m), and how much it does.
    fn light_returned(
        &self,
        ray: &Ray,
        scene: &impl RayCaster,
        materials: &[Material],
    ) -> Option<(f64, f64)> {
        let (mut ray, mut way_m, mut power_ratio) = (*ray, 0.0, 1.0);
        for _ in 0..N_SURFACES_MAX {
            let hit = scene.cast(&ray, self.range_max_m - way_m)?;
            way_m += hit.distance_m;
            let cosine = (-hit.normal.dot(&ray.direction)).clamp(0.0, 1.0);
            let light = light_of(materials, hit.tag);
            let returned_ratio = power_ratio * light.returned_ratio(cosine);
            // P ~ ρ cos / r², against the power that just suffices: ρ cos = 1 at the reach.
            if returned_ratio * self.reach_m * self.reach_m >= way_m * way_m {
                return Some((way_m, returned_ratio));
            }
            // Both ways through the surface.
            let passed_ratio = light.transmitted_ratio.max(light.mirrored_ratio);
            power_ratio *= passed_ratio * passed_ratio;
            if power_ratio <= 0.0 {
                return None;
            }
            let at = ray.origin + hit.distance_m * ray.direction;
            if light.mirrored_ratio > light.transmitted_ratio {
                ray.direction += 2.0 * cosine * hit.normal;
                ray.direction /= ray.direction.norm();
            }
            ray.origin = at + PAST_THE_SURFACE_M * ray.direction;
        }
        None
    }
}

impl Light {
    /// Part of the light that comes back to the sender, for the cosine of the incidence.
    fn returned_ratio(self, cosine: f64) -> f64 {
        let head_on = if cosine >= HEAD_ON_COSINE { self.mirrored_ratio } else { 0.0 };
        self.diffuse_ratio * cosine + head_on
    }
}

/// A tag beyond the list takes the first; an empty list is all white.
fn light_of(materials: &[Material], tag: u32) -> Light {
    const WHITE: Light = Light { diffuse_ratio: 1.0, mirrored_ratio: 0.0, transmitted_ratio: 0.0 };
    materials.get(tag as usize).or(materials.first()).map_or(WHITE, |material| material.light)
}

/// The chance of a whole scan: one number of the stream, from which each beam's follows by its index. So
/// what a scan meets never shifts what others draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Luck(u64);

/// The chance of one beam.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BeamLuck(u64);

impl Luck {
    pub(crate) fn draw(rng: &mut RandomStream) -> Self {
        Self(rng.next_u64())
    }

    pub(crate) fn absorb(self, hash: &mut StateHash) {
        hash.absorb_u64(self.0);
    }

    pub(crate) fn of(self, index: usize) -> BeamLuck {
        BeamLuck(mixed(self.0.wrapping_add((index as u64).wrapping_mul(GOLDEN))))
    }
}

impl BeamLuck {
    /// Nearly a standard normal number: the sum of four even ones, scaled. Mean 0 and deviation 1 hold
    /// exactly; the tails end at 3.46.
    fn gauss(self) -> f64 {
        let parts = [0, 16, 32, 48].map(|shift| (self.0 >> shift & 0xFFFF) as f64);
        // Of 65 536 even steps each: mean 32 767.5, variance (2³² − 1)/12.
        (parts.iter().sum::<f64>() - 131_070.0) / 37_837.227_237
    }

    /// Even in [0, 1), independent of [`gauss`](Self::gauss).
    fn uniform(self) -> f64 {
        (mixed(self.0 ^ GOLDEN) >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }
}

/// The odd number nearest 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Source: Steele, Lea, Flood (2014), "Fast splittable pseudorandom number generators", OOPSLA, the mixing function
/// `mix64` (SplitMix64, with Stafford's variant 13 as constants).
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests;
