//! Planar lasers: their scans as rays in the map, as a coarse ring of sectors, and whether they are silent.

use std::{f64::consts::FRAC_PI_2, time::Duration};

use geometry::{Se2, Vec2, wrap_to_pi};
use messages::{DeviceId, N_RING_MAX, Ring};
use obstacle_avoidance::{Footprint, RangeSensor, Ray, Rays};
use run_context::Stamp;
use sensor_models::{BeamSight, ScanBeam};

use crate::settings::LaserMount;

/// Sectors of the half turn ahead of a robot.
const N_SECTORS: usize = N_RING_MAX;
const SECTOR_RAD: f64 = 2.0 * FRAC_PI_2 / N_SECTORS as f64;

/// What a robot with lasers and without a ring hears in its stead: the nearest surface of each sector, seen from where
/// its middle leaves the outline. From the left to the right.
pub(crate) fn sectors(footprint: &Footprint) -> Vec<RangeSensor> {
    let sector = |k: usize| {
        let bearing_rad = FRAC_PI_2 - SECTOR_RAD * (k as f64 + 0.5);
        let along = Se2::new(0.0, 0.0, bearing_rad).heading();
        RangeSensor { in_base: along * way_out_m(footprint, along), bearing_rad }
    };
    (0..N_SECTORS).map(sector).collect()
}

/// How far it is from the axle to the outline (m) in a direction (unit vector, base frame).
fn way_out_m(footprint: &Footprint, along: Vec2) -> f64 {
    let corners = footprint.corners();
    let edge = |k: usize| (corners[k], corners[(k + 1) % corners.len()] - corners[k]);
    let leaves = |(a, edge): (Vec2, Vec2)| {
        let turn = edge.perp(&along);
        (turn < 0.0).then(|| edge.perp(&a) / turn)
    };
    (0..corners.len()).map(edge).filter_map(leaves).fold(f64::INFINITY, f64::min)
}

/// What a scan was about: which laser saw what, from where.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep<'a> {
    pub(crate) from: DeviceId,
    pub(crate) beams: &'a [ScanBeam],
    /// What a beam beyond the scale is free up to, metres.
    pub(crate) range_max_m: f64,
    /// Where the robot was (m, rad, map) when the first beam was fired, and the last.
    pub(crate) first: Se2,
    pub(crate) last: Se2,
}

#[derive(Clone, Debug)]
struct Laser {
    mount: LaserMount,
    last_at: Option<Stamp>,
}

/// All lasers of a robot.
#[derive(Clone, Debug)]
pub(crate) struct Lasers {
    mounted: Vec<Laser>,
    silent_after: Duration,
    rays: Rays,
    sectors: Vec<RangeSensor>,
    heard: Option<Ring>,
    range_max_m: f64,
}

impl Lasers {
    pub(crate) fn new(
        mounts: &[LaserMount],
        silent_after: Duration,
        footprint: &Footprint,
        range_max_m: f64,
    ) -> Self {
        let laser = |mount: &LaserMount| Laser { mount: *mount, last_at: None };
        Self {
            mounted: mounts.iter().map(laser).collect(),
            silent_after,
            rays: Rays::default(),
            sectors: if mounts.is_empty() { Vec::new() } else { sectors(footprint) },
            heard: None,
            range_max_m,
        }
    }

    /// The same with its own room for rays, which a clone has not.
    pub(crate) fn with_room(mut self) -> Self {
        self.rays = Rays::default();
        self
    }

    /// What the sectors read last.
    pub(crate) fn heard(&self) -> Option<&Ring> {
        self.heard.as_ref()
    }

    /// Whether one of them has sent nothing for too long, or nothing yet.
    pub(crate) fn is_one_silent(&self, now: Stamp) -> bool {
        let silent = |at: Option<Stamp>| at.is_none_or(|at| now.since(at) > self.silent_after);
        self.mounted.iter().any(|laser| silent(laser.last_at))
    }

    /// Takes a scan that reached the robot now: its rays in the map, and whose they are; `None` if no laser is it.
    pub(crate) fn take(&mut self, now: Stamp, sweep: &Sweep<'_>) -> Option<(u8, &Rays)> {
        let is_it = |laser: &Laser| laser.mount.device == sweep.from;
        let index = self.mounted.iter().position(is_it)?;
        self.mounted[index].last_at = Some(now);
        self.cast(index, sweep);
        self.listen(sweep);
        Some((index as u8, &self.rays))
    }

    /// The rays of a scan, each from where the robot was when it was fired.
    fn cast(&mut self, index: usize, sweep: &Sweep<'_>) {
        self.rays.clear();
        let (Some(first), Some(last)) = (sweep.beams.first(), sweep.beams.last()) else { return };
        let mount = self.mounted[index].mount.base_from_sensor;
        let time_s = last.after_s - first.after_s;
        let way = sweep.last.position() - sweep.first.position();
        let turn_rad = wrap_to_pi(sweep.last.yaw_rad - sweep.first.yaw_rad);
        for beam in sweep.beams {
            let ratio = if time_s > 0.0 { (beam.after_s - first.after_s) / time_s } else { 0.0 };
            let yaw_rad = sweep.first.yaw_rad + ratio * turn_rad;
            let (sine, cosine) = yaw_rad.sin_cos();
            let offset = Vec2::new(
                cosine * mount.x_m - sine * mount.y_m,
                sine * mount.x_m + cosine * mount.y_m,
            );
            let (free_m, ends) = match beam.sight {
                BeamSight::Surface(range_m) => (range_m, true),
                BeamSight::Beyond => (sweep.range_max_m, false),
                // Usually free, but so are glass, mirrors and black things.
                BeamSight::NoReturn | BeamSight::Unseen => (0.0, false),
            };
            self.rays.push(Ray {
                from: sweep.first.position() + way * ratio + offset,
                direction_rad: yaw_rad + mount.yaw_rad + beam.bearing_rad,
                free_m,
                ends,
            });
        }
    }

    /// The nearest surface of each sector. A sector of which nothing at all is known keeps what it read.
    fn listen(&mut self, sweep: &Sweep<'_>) {
        let to_base = sweep.last.inverse();
        let mut ranges_m = [f64::INFINITY; N_RING_MAX];
        let mut is_looked_at = [false; N_RING_MAX];
        for (ray, beam) in self.rays.iter().zip(sweep.beams) {
            // Without an end only the direction counts.
            let end = if ray.ends { ray.end() } else { Ray { free_m: 1.0, ..*ray }.end() };
            let in_base = to_base.transform_point(end);
            let aside_rad = FRAC_PI_2 - in_base.y.atan2(in_base.x);
            if !(0.0..2.0 * FRAC_PI_2).contains(&aside_rad) || beam.sight == BeamSight::Unseen {
                continue;
            }
            let k = ((aside_rad / SECTOR_RAD) as usize).min(N_SECTORS - 1);
            is_looked_at[k] = true;
            if ray.ends {
                ranges_m[k] = ranges_m[k].min((in_base - self.sectors[k].in_base).norm());
            }
        }
        let before_m = self.heard.map_or([self.range_max_m; N_RING_MAX], |ring| ring.ranges_m);
        for k in 0..N_SECTORS {
            let now_m = ranges_m[k].min(self.range_max_m);
            ranges_m[k] = if is_looked_at[k] { now_m } else { before_m[k] };
        }
        let (n_sensors, fresh) = (N_SECTORS, u16::MAX);
        self.heard = Some(Ring { ranges_m, ages_ms: [0; N_RING_MAX], n_sensors, fresh });
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    const LASER: DeviceId = DeviceId(3);

    fn lasers(base_from_sensor: Se2) -> (Lasers, Footprint) {
        let footprint = Footprint::rectangle(0.21, 0.301, 0.2125).unwrap();
        let mount = LaserMount { device: LASER, base_from_sensor };
        (Lasers::new(&[mount], Duration::from_millis(500), &footprint, 5.0), footprint)
    }

    /// The way out of a rectangle in the directions of its sides and of a corner, by hand.
    #[test]
    fn sectors_begin_on_the_outline() {
        let (_, footprint) = lasers(Se2::IDENTITY);
        let out_m = |x: f64, y: f64| way_out_m(&footprint, Vec2::new(x, y).normalize());
        for (found, hand) in [
            (out_m(1.0, 0.0), 0.21),
            (out_m(-1.0, 0.0), 0.301),
            (out_m(0.0, 1.0), 0.2125),
            (out_m(0.0, -1.0), 0.2125),
            (out_m(0.21, -0.2125), 0.21_f64.hypot(0.2125)),
        ] {
            assert!((found - hand).abs() < 1e-12, "{found} {hand}");
        }
        let sectors = sectors(&footprint);
        assert!(sectors.windows(2).all(|pair| pair[0].bearing_rad > pair[1].bearing_rad));
        assert!(sectors[0].in_base.y > 0.2 && sectors[N_SECTORS - 1].in_base.y < -0.2);
    }

    /// A robot that turns and drives while its laser sweeps, beside a wall x = 3 of the map: each beam ends on it.
    #[test]
    fn every_beam_is_placed_where_the_robot_was_when_it_was_fired() {
        let mount = Se2::new(0.12, -0.05, std::f64::consts::PI);
        let (mut lasers, _) = lasers(mount);
        let (first, last) = (Se2::new(0.0, 0.5, -0.1), Se2::new(0.08, 0.49, 0.1));
        let at = |ratio: f64| {
            let way = last.position() - first.position();
            let p = first.position() + way * ratio;
            Se2::new(p.x, p.y, first.yaw_rad + ratio * (last.yaw_rad - first.yaw_rad))
        };
        let beam = |k: u32| {
            let ratio = f64::from(k) / 360.0;
            // The sensor looks backwards, so ahead is at its ±180°.
            let bearing_rad = wrap_to_pi(std::f64::consts::PI + 2.0 * (ratio - 0.5));
            let sensor = at(ratio).compose(mount);
            let direction_rad = sensor.yaw_rad + bearing_rad;
            let range_m = (3.0 - sensor.x_m) / direction_rad.cos();
            ScanBeam {
                bearing_rad,
                after_s: 0.1 * ratio,
                sight: BeamSight::Surface(range_m),
                strength_ratio: 0.0,
            }
        };
        let beams: Vec<ScanBeam> = (0..=360).map(beam).collect();
        let sweep = Sweep { from: LASER, beams: &beams, range_max_m: 8.0, first, last };
        let (_, rays) = lasers.take(Stamp::ZERO, &sweep).unwrap();
        let worst_m = rays.iter().map(|ray| (ray.end().x - 3.0).abs()).fold(0.0, f64::max);
        assert!(worst_m < 1e-9 && rays.iter().count() == 361, "{worst_m}");
        // A scan of somebody else is none of its own, and does not count as a sign of life.
        let foreign = Sweep { from: DeviceId(1), ..sweep };
        assert!(lasers.take(Stamp::from_millis(900), &foreign).is_none());
        assert!(lasers.is_one_silent(Stamp::from_millis(501)));
        assert!(!lasers.is_one_silent(Stamp::from_millis(500)));
    }

    /// Nothing known, nothing there, and something there: sector by sector.
    #[test]
    fn a_sector_of_which_nothing_is_known_keeps_what_it_read() {
        let (mut lasers, _) = lasers(Se2::IDENTITY);
        let pose = Se2::new(4.0, -2.0, 1.0);
        let mut look = |sight: BeamSight| {
            let beam = |k: u32| ScanBeam {
                bearing_rad: -1.5 + 0.01 * f64::from(k),
                after_s: 0.0,
                sight,
                strength_ratio: 0.0,
            };
            let beams: Vec<ScanBeam> = (0..300).map(beam).collect();
            let sweep =
                Sweep { from: LASER, beams: &beams, range_max_m: 8.0, first: pose, last: pose };
            lasers.take(Stamp::ZERO, &sweep).unwrap();
            lasers.heard().unwrap().ranges_m
        };
        let near = look(BeamSight::Surface(1.0));
        assert!(near.iter().all(|m| (0.6..0.85).contains(m)), "{near:?}");
        assert_eq!(look(BeamSight::Unseen), near);
        assert_eq!(look(BeamSight::NoReturn), [5.0; N_SECTORS]);
        assert_eq!(look(BeamSight::Unseen), [5.0; N_SECTORS]);
        look(BeamSight::Surface(2.0));
        assert_eq!(look(BeamSight::Beyond), [5.0; N_SECTORS]);
    }
}
