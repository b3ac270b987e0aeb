//! A scan as a client knows it: what each beam saw, and what it did not.

use run_context::Stamp;

/// What one beam says about the way that it went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BeamSight {
    /// A surface at this range, metres.
    Surface(f64),
    /// The device measured something beyond its scale: the way is free up to the range that the scan
    /// names.
    Beyond,
    /// The beam was fired and nothing came back. Usually the way is free; but glass, mirrors, black things and what is
    /// nearer than the device measures return nothing either.
    NoReturn,
    /// Nothing is known of this way: the beam was not fired, its reading did not arrive, or the device was
    /// blinded. Never free.
    Unseen,
}

/// One beam of a [`PlanarScan`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanBeam {
    /// Where it looked, from the sensor's x axis, radians in [-π, π), counter-clockwise.
    pub bearing_rad: f64,
    /// When it was fired, seconds after the scan's stamp; may be negative by the uncertainty of the stamp.
    pub after_s: f64,
    /// What it saw.
    pub sight: BeamSight,
    /// How strongly the surface answered, from 0 to 1 of the device's own scale; 0 where it does not say.
    pub strength_ratio: f64,
}

/// A scan of a planar laser, in the sensor's frame, however the device counts and turns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanarScan {
    /// When its first beam was fired.
    pub about: Stamp,
    /// Number of the scan since the client was made, from 0; a gap never occurs, what was lost is counted elsewhere.
    pub number: u64,
    /// Surfaces nearer than this are not measured, metres.
    pub range_min_m: f64,
    /// What [`BeamSight::Beyond`] is free up to, and no surface is measured beyond, metres.
    pub range_max_m: f64,
    /// The beams, in the order in which the device turned.
    pub beams: Vec<ScanBeam>,
}

impl ScanBeam {
    /// The range of the surface it met, metres.
    pub fn surface_m(&self) -> Option<f64> {
        match self.sight {
            BeamSight::Surface(range_m) => Some(range_m),
            BeamSight::Beyond | BeamSight::NoReturn | BeamSight::Unseen => None,
        }
    }
}

impl PlanarScan {
    /// Beams that saw a surface.
    pub fn n_surfaces(&self) -> usize {
        self.beams.iter().filter(|beam| beam.surface_m().is_some()).count()
    }

    /// Beams of which nothing is known.
    pub fn n_unseen(&self) -> usize {
        self.beams.iter().filter(|beam| beam.sight == BeamSight::Unseen).count()
    }
}
