//! One observation, and all of a step.

use run_context::Stamp;
use sensor_models::{PlanarScan, ScanBeam};

use crate::{Scan, Sensed};

/// A device of a robot: its place in the robot's list of devices, what the base itself senses first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DeviceId(pub u8);

impl DeviceId {
    /// What the robot's own board reports, and what is not of a device.
    pub const BASE: Self = Self(0);
}

/// Something that was sensed or received, and the time it is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// When it was true; not when it was handled. Of a scan: when its first beam was fired.
    pub about: Stamp,
    /// Whose it is.
    pub from: DeviceId,
    /// What it is.
    pub value: Sensed,
}

/// What reached a node in a step, in order.
///
/// Kept between steps and cleared, so that nothing is allocated once it has held as much as it ever will.
#[derive(Clone, Debug)]
pub struct Observations {
    list: Vec<Observation>,
    beams: Vec<ScanBeam>,
}

/// Room for the observations of a usual step; more are taken as well.
const N_USUAL: usize = 32;

impl Default for Observations {
    fn default() -> Self {
        Self { list: Vec::with_capacity(N_USUAL), beams: Vec::new() }
    }
}

impl Observations {
    /// None yet; room for those of a usual step, without scans.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.list.clear();
        self.beams.clear();
    }

    /// Adds what the base or another node said.
    pub fn push(&mut self, about: Stamp, value: Sensed) {
        self.push_from(about, DeviceId::BASE, value);
    }

    /// Adds what device `from` said. A [`Sensed::Scan`] of other observations has no beams here: use
    /// [`push_scan`](Self::push_scan).
    pub fn push_from(&mut self, about: Stamp, from: DeviceId, value: Sensed) {
        let value = match value {
            Sensed::Scan(scan) => Sensed::Scan(Scan { first_beam: 0, n_beams: 0, ..scan }),
            value => value,
        };
        self.list.push(Observation { about, from, value });
    }

    /// Adds a scan with its beams.
    pub fn push_scan(&mut self, from: DeviceId, scan: &PlanarScan) {
        // A scan has at most some thousand beams.
        let value = Sensed::Scan(Scan {
            number: scan.number,
            range_min_m: scan.range_min_m,
            range_max_m: scan.range_max_m,
            first_beam: self.beams.len() as u32,
            n_beams: scan.beams.len() as u32,
        });
        self.beams.extend_from_slice(&scan.beams);
        self.list.push(Observation { about: scan.about, from, value });
    }

    /// The beams of a scan that is in here, in the order in which the device turned.
    pub fn beams(&self, scan: &Scan) -> &[ScanBeam] {
        let first = scan.first_beam as usize;
        self.beams.get(first..first + scan.n_beams as usize).unwrap_or(&[])
    }

    /// All of them, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Observation> {
        self.list.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Keeps those of which `keep` says so.
    pub fn retain(&mut self, keep: impl FnMut(&Observation) -> bool) {
        self.list.retain(keep);
    }
}

impl<'a> IntoIterator for &'a Observations {
    type Item = &'a Observation;
    type IntoIter = std::slice::Iter<'a, Observation>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.iter()
    }
}

#[cfg(test)]
mod tests {
    use sensor_models::BeamSight;

    use super::*;
    use crate::{Battery, LinkState};

    fn scan(n_beams: u32, about_ms: u64) -> PlanarScan {
        let beam = |k: u32| ScanBeam {
            bearing_rad: 0.01 * f64::from(k),
            after_s: 0.0,
            sight: if k.is_multiple_of(2) {
                BeamSight::Surface(f64::from(k))
            } else {
                BeamSight::Unseen
            },
            strength_ratio: 0.0,
        };
        PlanarScan {
            about: Stamp::from_millis(about_ms),
            number: u64::from(n_beams),
            range_min_m: 0.1,
            range_max_m: 8.0,
            beams: (0..n_beams).map(beam).collect(),
        }
    }

    /// Two lasers in one step, with something between: each scan has its own beams.
    #[test]
    fn scans_of_one_step_keep_their_beams_apart() {
        let mut seen = Observations::new();
        let (one, two) = (scan(5, 10), scan(3, 20));
        seen.push_scan(DeviceId(1), &one);
        seen.push(Stamp::from_millis(15), Sensed::Battery(Battery { voltage_v: 12.0 }));
        seen.push_scan(DeviceId(2), &two);
        let found: Vec<_> = seen
            .iter()
            .filter_map(|o| match &o.value {
                Sensed::Scan(head) => Some((o.about, o.from, head.number, seen.beams(head))),
                _ => None,
            })
            .collect();
        assert_eq!(
            found,
            [
                (one.about, DeviceId(1), 5, one.beams.as_slice()),
                (two.about, DeviceId(2), 3, two.beams.as_slice())
            ]
        );
        // One that is handed on without its beams has none, and not those of another.
        let first = seen.iter().next().copied().unwrap();
        let mut others = Observations::new();
        others.push_scan(DeviceId(3), &two);
        others.push_from(first.about, first.from, first.value);
        let Some(Sensed::Scan(head)) = others.iter().last().map(|o| o.value) else { panic!() };
        assert!(others.beams(&head).is_empty());
    }

    #[test]
    fn once_warm_nothing_is_allocated() {
        let mut seen = Observations::new();
        let scan = scan(361, 0);
        let mut step = || {
            seen.clear();
            seen.push(Stamp::ZERO, Sensed::Link(LinkState::Up));
            seen.push_scan(DeviceId(1), &scan);
        };
        step();
        assert_eq!(allocation_counter::measure(step).count_total, 0);
    }
}
