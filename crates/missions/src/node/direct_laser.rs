//! A laser without bytes, for swarms: its beams become scans as they are fired.
//!
//! The navigator cannot tell the difference, except that nothing is delayed, lost or rounded to what a protocol has room
//! for. A line that is cut brings nothing: what is not seen is not free.

use geometry::{Se2, wrap_to_pi};
use messages::{DeviceId, Observations};
use run_context::{RandomStream, StateHash};
use sensor_models::{Beam, BeamSight, LaserModel, PlanarScan, ScanBeam, Sweep};

use crate::{
    cut::{Cuts, Direction},
    run::line::{Around, Direct},
};

#[derive(Debug)]
pub(super) struct DirectLaser {
    sweep: Sweep,
    base_from_sensor: Se2,
    device: DeviceId,
    growing: PlanarScan,
    cuts: Cuts,
    /// Every beam so far, in order.
    seen: StateHash,
}

impl DirectLaser {
    pub(super) fn new(
        model: LaserModel,
        base_from_sensor: Se2,
        device: DeviceId,
        rng: RandomStream,
    ) -> Self {
        let growing = PlanarScan {
            range_min_m: model.range_min_m,
            range_max_m: model.range_max_m,
            beams: Vec::with_capacity(model.n_beams),
            ..PlanarScan::default()
        };
        let (sweep, cuts, seen) = (Sweep::new(model, rng), Cuts::default(), StateHash::new());
        Self { sweep, base_from_sensor, device, growing, cuts, seen }
    }
}

impl Direct for DirectLaser {
    fn step(&mut self, around: &mut Around<'_>, observations: &mut Observations) {
        let Some(body) = around.body else { return };
        let Self { sweep, base_from_sensor, device, growing, cuts, seen } = self;
        let world_from_base = around.world.body(body).world_from_base.se2();
        let world_from_sensor = world_from_base.compose(*base_from_sensor);
        let scene = around.world.scene(Some(body));
        sweep.start(around.now);
        let is_cut = cuts.back;
        sweep.fire(around.now, world_from_sensor, &scene, around.world.materials(), |beam| {
            seen.absorb_u64(beam.echo.range_m.to_bits());
            if beam.is_first {
                growing.beams.clear();
                growing.about = beam.at;
            }
            growing.beams.push(seen_by(&beam, growing.about));
            if beam.is_last {
                if !is_cut {
                    observations.push_scan(*device, growing);
                }
                growing.number += 1;
            }
        });
    }

    fn set_cut(&mut self, direction: Direction, cut: bool) {
        self.cuts.set(direction, cut);
    }

    fn is_connected(&self) -> bool {
        !self.cuts.back
    }

    fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.seen.value());
        self.sweep.absorb_state(hash);
    }
}

fn seen_by(beam: &Beam, about: run_context::Stamp) -> ScanBeam {
    let sight = if beam.echo.is_something() {
        BeamSight::Surface(beam.echo.range_m)
    } else {
        BeamSight::NoReturn
    };
    ScanBeam {
        bearing_rad: wrap_to_pi(beam.bearing_rad),
        after_s: beam.at.since(about).as_secs_f64(),
        sight,
        strength_ratio: beam.echo.strength_ratio,
    }
}
