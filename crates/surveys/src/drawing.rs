//! Maps as a survey makes them: from evidence that grows, or from a board of probabilities.

use geometry::{Se2, Vec2};
use grid_maps::{
    BeamFan, CellBox, Entropy, EvidenceModel, Lattice, LogOddsMap, MapError, ScanInserter,
    ScanRules, State, Thresholds, Window,
};
use recordings::{LaserRig, Recording, StampedPose};

use crate::config::MapSettings;

/// Two scans nearer than this are drawn once, metres.
const NEWS_M: f64 = 0.02;
/// Two scans turned by less than this are drawn once, radians.
const NEWS_RAD: f64 = 0.01;

/// A map.
#[derive(Clone, Debug)]
pub enum SurveyMap {
    /// Evidence in tiles.
    Evidence(LogOddsMap),
    /// Probabilities of a rectangle of cells; NaN where nothing is known.
    Board(Lattice, Window<f64>),
}

impl PartialEq for SurveyMap {
    /// Whether they say the same of every cell.
    fn eq(&self, other: &Self) -> bool {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        let windows = || Some((self.window().ok()?, other.window().ok()?));
        self.lattice() == other.lattice()
            && windows().is_none_or(|(a, b)| {
                a.area() == b.area() && a.values().iter().zip(b.values()).all(|(a, b)| same(*a, *b))
            })
    }
}

impl SurveyMap {
    /// Where its cells lie.
    pub fn lattice(&self) -> &Lattice {
        match self {
            Self::Evidence(map) => map.lattice(),
            Self::Board(lattice, _) => lattice,
        }
    }

    /// Probabilities of all cells around which something is known, NaN where nothing is. An empty map has one
    /// unknown cell.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn window(&self) -> Result<Window<f64>, MapError> {
        match self {
            Self::Evidence(map) => {
                let one =
                    CellBox { min: map.lattice().cell_of(Vec2::zeros()), width: 1, height: 1 };
                map.prob_window(map.bounds().unwrap_or(one))
            }
            Self::Board(_, window) => Ok(window.clone()),
        }
    }

    /// Uncertainty of the known cells.
    pub fn entropy(&self) -> Entropy {
        match self {
            Self::Evidence(map) => map.entropy(),
            Self::Board(_, window) => {
                let known = window.values().iter().filter(|prob| !prob.is_nan());
                let sum_bits = known.clone().map(|&prob| grid_maps::entropy_bits(prob)).sum();
                Entropy { sum_bits, n_known: known.count() }
            }
        }
    }

    /// How many cells are occupied and how many free.
    ///
    /// # Errors
    ///
    /// [`MapError::TooLarge`].
    pub fn counts(&self, thresholds: &Thresholds) -> Result<[usize; 2], MapError> {
        let window = self.window()?;
        let count = |state: State| {
            window.values().iter().filter(|&&prob| thresholds.state_of(prob) == state).count()
        };
        Ok([count(State::Occupied), count(State::Free)])
    }
}

impl MapSettings {
    /// What makes a cell occupied or free in files and pictures.
    pub(crate) fn thresholds(&self) -> Thresholds {
        Thresholds { occupied_prob: self.occupied_prob, free_prob: self.free_prob }
    }

    /// A map without anything in it.
    pub(crate) fn empty_map(&self) -> Result<LogOddsMap, MapError> {
        let model = EvidenceModel {
            hit_logodds: self.hit_logodds,
            miss_logodds: self.miss_logodds,
            min_logodds: -self.limit_logodds,
            max_logodds: self.limit_logodds,
        };
        LogOddsMap::new(Lattice::new(Vec2::zeros(), self.resolution_m)?, model)
    }
}

/// Draws a laser's scans, the new ones only as long as the earlier poses stay.
#[derive(Debug)]
pub(crate) struct LaserDrawing {
    map: SurveyMap,
    settings: MapSettings,
    fan: BeamFan,
    base_from_sensor: Se2,
    inserter: ScanInserter,
    n_drawn: usize,
    last: Option<Se2>,
    is_stale: bool,
}

impl LaserDrawing {
    pub(crate) fn new(rig: &LaserRig, settings: &MapSettings) -> Result<Self, MapError> {
        let range_max_m = rig.range_max_m.min(settings.range_max_m);
        let rules = ScanRules::new(range_max_m, settings.resolution_m);
        Ok(Self {
            map: SurveyMap::Evidence(settings.empty_map()?),
            settings: *settings,
            fan: BeamFan::uniform(rig.first_beam_rad, rig.beam_spacing_rad, rig.n_beams)?,
            base_from_sensor: rig.base_from_sensor,
            inserter: ScanInserter::new(rules),
            n_drawn: 0,
            last: None,
            is_stale: false,
        })
    }

    /// Earlier poses moved: everything is drawn anew next time.
    pub(crate) fn forget(&mut self) {
        self.is_stale = true;
    }

    /// The map of the scans of `trajectory`.
    pub(crate) fn update(
        &mut self,
        recording: &Recording,
        trajectory: &[StampedPose],
    ) -> Result<&SurveyMap, MapError> {
        if self.is_stale {
            self.map = SurveyMap::Evidence(self.settings.empty_map()?);
            (self.n_drawn, self.last, self.is_stale) = (0, None, false);
        }
        let SurveyMap::Evidence(map) = &mut self.map else { return Ok(&self.map) };
        let fresh = recording.scans.iter().zip(trajectory).skip(self.n_drawn);
        for (scan, &StampedPose { pose, .. }) in fresh {
            self.n_drawn += 1;
            let is_news = self.last.is_none_or(|last| {
                let moved = last.inverse().compose(pose);
                moved.position().norm() > NEWS_M || moved.yaw_rad.abs() > NEWS_RAD
            });
            if is_news {
                self.last = Some(pose);
                let map_from_sensor = pose.compose(self.base_from_sensor);
                self.inserter.insert(map, &self.fan, map_from_sensor, &scan.ranges_m);
            }
        }
        Ok(&self.map)
    }
}
