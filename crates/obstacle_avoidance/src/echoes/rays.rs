//! What a planar laser adds to the memory of echoes: thin rays, many of them, all at about one time.
//!
//! A ray that ends at a surface says two things: something is there, and nothing is before it. So what a laser remembered
//! before a surface is forgotten at once, what lies behind one is kept until it is too old, and a ray of which nothing is
//! known changes nothing. O(rays + echoes) for a scan: rays are found by their direction.

use std::f64::consts::{PI, TAU};

use geometry::{Vec2, wrap_to_pi};
use run_context::Stamp;

use super::{Echo, EchoMemory};

/// One beam of a laser where it was fired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it began (m).
    pub from: Vec2,
    /// Its direction, radians.
    pub direction_rad: f64,
    /// So far nothing stands in it, metres; 0 where nothing is known of it.
    pub free_m: f64,
    /// Whether a surface ends it there.
    pub ends: bool,
}

impl Ray {
    /// Unit vector along it.
    fn away(&self) -> Vec2 {
        let (sine, cosine) = self.direction_rad.sin_cos();
        Vec2::new(cosine, sine)
    }

    /// Where it ends (m).
    pub fn end(&self) -> Vec2 {
        self.from + self.away() * self.free_m
    }
}

/// Directions that rays are found by: half a degree each.
const N_BINS: usize = 720;

/// Rays for which there is always room.
const N_USUAL: usize = 1024;

/// No ray.
const NONE: u16 = u16::MAX;

/// The rays of one scan; kept between scans, so that nothing is allocated.
#[derive(Clone, Debug)]
pub struct Rays {
    rays: Vec<Ray>,
    by_direction: Box<[u16; N_BINS]>,
}

impl Default for Rays {
    fn default() -> Self {
        Self { rays: Vec::with_capacity(N_USUAL), by_direction: Box::new([NONE; N_BINS]) }
    }
}

impl Rays {
    /// Forgets them.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.by_direction.fill(NONE);
    }

    /// Adds one, in the order in which the device turned. More than 65 534 are not looked at.
    pub fn push(&mut self, ray: Ray) {
        if let Ok(index) = u16::try_from(self.rays.len())
            && index != NONE
        {
            self.by_direction[bin_of(ray.direction_rad)] = index;
            self.rays.push(ray);
        }
    }

    /// All of them, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Ray> {
        self.rays.iter()
    }

    /// The ray that passes a point nearest, if one passes within `beside_m`, and how far along it that is.
    fn through(&self, point: Vec2, beside_m: f64) -> Option<(&Ray, f64)> {
        let from = self.rays.first()?.from;
        let offset = point - from;
        let bin = bin_of(offset.y.atan2(offset.x));
        let mut best: Option<(&Ray, f64, f64)> = None;
        for bin in [bin + N_BINS - 1, bin, bin + 1] {
            let index = self.by_direction[bin % N_BINS];
            let Some(ray) = self.rays.get(usize::from(index)) else { continue };
            let (offset, away) = (point - ray.from, ray.away());
            let (along_m, aside_m) = (offset.dot(&away), offset.perp(&away).abs());
            let nearer = best.is_none_or(|(_, _, least_m)| aside_m < least_m);
            if along_m > 0.0 && aside_m <= beside_m && nearer {
                best = Some((ray, along_m, aside_m));
            }
        }
        best.map(|(ray, along_m, _)| (ray, along_m))
    }
}

impl<'a> IntoIterator for &'a Rays {
    type Item = &'a Ray;
    type IntoIter = std::slice::Iter<'a, Ray>;

    fn into_iter(self) -> Self::IntoIter {
        self.rays.iter()
    }
}

fn bin_of(direction_rad: f64) -> usize {
    let turn = (wrap_to_pi(direction_rad) + PI) / TAU;
    ((turn * N_BINS as f64) as usize).min(N_BINS - 1)
}

/// A ray passes through what it passes so near by, metres.
const THROUGH_WITHIN_M: f64 = 0.04;

/// What lies so near to the end of a ray is what ends it, metres: three standard deviations of a laser's noise.
const SAME_SURFACE_M: f64 = 0.06;

/// Surfaces are remembered every so many metres, and a little less densely farther away, as a part of the range.
const SPACING_M: f64 = 0.05;
const SPACING_RATIO: f64 = 0.02;

/// Surfaces farther away are not remembered, metres: what stops a robot at 1 m/s is nearer.
const REMEMBERED_WITHIN_M: f64 = 4.0;

impl EchoMemory {
    /// Takes in a scan of laser `laser`: its surfaces, and what its rays passed through.
    ///
    /// O(rays + echoes), no allocation.
    pub fn observe_rays(&mut self, now: Stamp, laser: u8, rays: &Rays) {
        let by = laser.saturating_add(1);
        let lifetime = self.config.lifetime;
        self.echoes.retain(|echo| {
            let is_kept = now.since(echo.heard) <= lifetime;
            // What ends a ray is remembered anew, below.
            is_kept && (echo.by != by || !was_looked_at(rays, echo.at))
        });
        let mut last: Option<Vec2> = None;
        for ray in rays {
            if !ray.ends || ray.free_m > REMEMBERED_WITHIN_M {
                continue;
            }
            let at = ray.end();
            let spacing_m = SPACING_M + SPACING_RATIO * ray.free_m;
            if last.is_none_or(|last| (at - last).norm_squared() >= spacing_m * spacing_m) {
                last = Some(at);
                self.add(Echo { at, away: ray.away(), heard: now, n_seen_through: 0, by });
            }
        }
    }
}

/// Whether a ray has passed through a place, or ended there.
fn was_looked_at(rays: &Rays, at: Vec2) -> bool {
    let through = rays.through(at, THROUGH_WITHIN_M);
    through.is_some_and(|(ray, along_m)| {
        along_m < if ray.ends { ray.free_m + SAME_SURFACE_M } else { ray.free_m }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EchoMemoryConfig;

    const N: usize = 361;

    fn at(ms: u64) -> Stamp {
        Stamp::from_millis(ms)
    }

    /// A scan of half a turn from a place, with what each ray met.
    fn scan(from: Vec2, met: impl Fn(f64) -> (f64, bool)) -> Rays {
        let mut rays = Rays::default();
        for k in 0..N {
            let direction_rad = PI * (k as f64 / (N - 1) as f64 - 0.5);
            let (free_m, ends) = met(direction_rad);
            rays.push(Ray { from, direction_rad, free_m, ends });
        }
        rays
    }

    fn memory() -> EchoMemory {
        EchoMemory::new(EchoMemoryConfig { capacity: 768, ..EchoMemoryConfig::default() })
    }

    /// A wall 2 m ahead, written out: at bearing β it is 2 / cos β away.
    fn wall(direction_rad: f64) -> (f64, bool) {
        let away_m = 2.0 / direction_rad.cos().max(1e-9);
        if away_m < 10.0 { (away_m, true) } else { (10.0, false) }
    }

    #[test]
    fn a_wall_is_remembered_where_it_is_and_every_few_centimetres() {
        let mut memory = memory();
        memory.observe_rays(at(0), 0, &scan(Vec2::zeros(), wall));
        let mut places: Vec<f64> = memory.points().map(|p| p.y).collect();
        assert!(memory.points().all(|p| (p.x - 2.0).abs() < 1e-9));
        places.sort_by(f64::total_cmp);
        let reach_m = 12.0_f64.sqrt();
        assert!(places[0] < -reach_m + 0.2 && places[places.len() - 1] > reach_m - 0.2);
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] < 0.2), "{places:?}");
        assert!((40..120).contains(&places.len()), "{}", places.len());
        // Seen again, it is not remembered twice.
        let n_echoes = memory.len();
        memory.observe_rays(at(100), 0, &scan(Vec2::zeros(), wall));
        assert_eq!(memory.len(), n_echoes);
    }

    #[test]
    fn what_has_gone_is_forgotten_at_once_and_what_is_hidden_is_kept() {
        let person = |b: f64| if b.abs() < 0.2 { (1.0, true) } else { wall(b) };
        let mut memory = memory();
        memory.observe_rays(at(0), 0, &scan(Vec2::zeros(), wall));
        memory.observe_rays(at(100), 0, &scan(Vec2::zeros(), person));
        let near = |memory: &EchoMemory, far: bool| {
            let ahead = memory.points().filter(|p| p.y.atan2(p.x).abs() < 0.15);
            ahead.filter(|p| (p.norm() > 1.5) == far).count()
        };
        assert!(near(&memory, false) >= 3 && near(&memory, true) >= 5);
        memory.observe_rays(at(200), 0, &scan(Vec2::zeros(), wall));
        assert!(near(&memory, false) == 0 && near(&memory, true) >= 5);
        // Of what is not looked at nothing is known: it is kept, until it is too old.
        let n_echoes = memory.len();
        memory.observe_rays(at(300), 0, &scan(Vec2::zeros(), |_| (0.0, false)));
        assert_eq!(memory.len(), n_echoes);
        // A ray that is free to somewhere frees what lies before, and nothing beyond.
        memory.observe_rays(at(400), 0, &scan(Vec2::zeros(), |_| (1.9, false)));
        assert_eq!(memory.len(), n_echoes);
        memory.observe_rays(at(500), 0, &scan(Vec2::zeros(), |_| (2.1, false)));
        assert!(memory.len() < n_echoes && near(&memory, true) == 0);
        memory.observe_rays(at(13_000), 0, &scan(Vec2::zeros(), |_| (0.0, false)));
        assert!(memory.is_empty());
    }

    /// A laser sees through glass that a sonar hears, and one laser past what another sees.
    #[test]
    fn each_sensor_forgets_only_its_own() {
        let mut memory = memory();
        let sonar = crate::RangeSensor { in_base: Vec2::zeros(), bearing_rad: 0.0 };
        memory.observe(at(0), geometry::Se2::IDENTITY, &[sonar], &[1.0], 1);
        memory.observe_rays(at(10), 1, &scan(Vec2::zeros(), |b| (1.2, b.abs() < 0.05)));
        let n_echoes = memory.len();
        assert!(n_echoes > 2);
        memory.observe_rays(at(20), 0, &scan(Vec2::zeros(), |_| (5.0, true)));
        assert_eq!(memory.len(), n_echoes);
        memory.observe_rays(at(30), 1, &scan(Vec2::zeros(), |_| (5.0, true)));
        assert_eq!(memory.len(), 1);
    }
}
