//! Particles on a map: the wheels move them, the beams of the lasers weigh them.

use geometry::{Se2, Twist, Vec2};
use localisation::{Estimate, ParticleFilter};
use messages::DeviceId;

use crate::{around::Sweep, settings::LaserMount};

/// Beams of a scan that are used, evenly chosen.
const N_BEAMS: usize = 60;

/// The particles are weighed again after so much way or turn: beams from one place err together. Metres, radians.
const WEIGH_AFTER_M: f64 = 0.05;
const WEIGH_AFTER_RAD: f64 = 0.05;

/// A filter, and what it needs of the robot.
#[derive(Clone, Debug)]
pub(crate) struct Particles {
    filter: ParticleFilter,
    mounts: Vec<(DeviceId, Se2)>,
    /// Where the dead reckoning was when they were moved last.
    moved_at: Option<Se2>,
    ends: Vec<Vec2>,
}

impl Particles {
    pub(crate) fn new(filter: ParticleFilter, lasers: &[LaserMount]) -> Self {
        let mounts = lasers.iter().map(|laser| (laser.device, laser.base_from_sensor)).collect();
        Self { filter, mounts, moved_at: None, ends: Vec::with_capacity(N_BEAMS) }
    }

    /// Takes a scan that ended when the robot's dead reckoning was at `odom_from_base`; where the robot was then in the
    /// map. `None` for a scan that says nothing new.
    pub(crate) fn take(&mut self, odom_from_base: Se2, sweep: &Sweep<'_>) -> Option<Estimate> {
        let (_, mount) = *self.mounts.iter().find(|(device, _)| *device == sweep.from)?;
        let moved = self.moved_at.map(|before| before.inverse().compose(odom_from_base));
        if let Some(moved) = moved {
            let Twist { dx_m, dy_m, dyaw_rad } = moved.log();
            if dx_m.hypot(dy_m) < WEIGH_AFTER_M && dyaw_rad.abs() < WEIGH_AFTER_RAD {
                return None;
            }
            self.filter.predict(moved);
        }
        self.moved_at = Some(odom_from_base);
        self.gather(mount, sweep);
        self.filter.correct(&self.ends);
        Some(self.filter.estimate())
    }

    /// Where beams ended that met something, in the base frame at the end of the scan.
    fn gather(&mut self, mount: Se2, sweep: &Sweep<'_>) {
        self.ends.clear();
        let way = sweep.first.inverse().compose(sweep.last).log();
        let n_beams = sweep.beams.len();
        let step = n_beams.div_ceil(N_BEAMS).max(1);
        for (k, beam) in sweep.beams.iter().enumerate().step_by(step) {
            let Some(range_m) = beam.surface_m() else { continue };
            // From the end of the scan back to when the beam was fired.
            let back = k as f64 / n_beams.max(2) as f64 - 1.0;
            let last_from_then = Se2::exp(Twist {
                dx_m: back * way.dx_m,
                dy_m: back * way.dy_m,
                dyaw_rad: back * way.dyaw_rad,
            });
            let away = Vec2::new(beam.bearing_rad.cos(), beam.bearing_rad.sin());
            self.ends.push(last_from_then.compose(mount).transform_point(range_m * away));
        }
    }
}
