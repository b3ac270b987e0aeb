//! How often, with which seed and under which conditions an experiment is repeated, and what may go wrong.

use run_context::RunSeed;

/// How an experiment is repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Runs per setting; 0 for the experiment's own number.
    pub n_runs: u32,
    /// Everything random follows from it.
    pub seed: RunSeed,
    /// Threads; 0 for one per core. The report does not depend on it, but for a table of computing times.
    pub n_threads: usize,
    /// Conditions of one's own instead of the published ones.
    pub sweep: Sweep,
}

/// Conditions to try in every combination; an empty list is the thesis's own condition. All empty: the
/// experiment as published.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Cruising speeds, m/s.
    pub speeds_mps: Vec<f64>,
    /// Control periods, ms.
    pub periods_ms: Vec<u32>,
    /// Perception radii, m.
    pub sigmas_m: Vec<f64>,
    /// Numbers of fuzzy sets: 3 or 5.
    pub n_sets: Vec<u32>,
    /// What the wheels accelerate with, m/s².
    pub accelerations_mps2: Vec<f64>,
}

impl Sweep {
    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The names of what is asked for.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let given = [
            ("speeds", self.speeds_mps.is_empty()),
            ("periods", self.periods_ms.is_empty()),
            ("sigmas", self.sigmas_m.is_empty()),
            ("sets", self.n_sets.is_empty()),
            ("accelerations", self.accelerations_mps2.is_empty()),
        ];
        given.into_iter().filter(|(_, is_empty)| !is_empty).map(|(name, _)| name).collect()
    }
}

impl Default for Options {
    fn default() -> Self {
        Self { n_runs: 0, seed: RunSeed(1), n_threads: 0, sweep: Sweep::default() }
    }
}

/// An experiment that cannot be carried out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A mission of the experiment is refused.
    #[error("a mission of the experiment is refused: {0}")]
    Mission(#[from] missions::MissionError),
    /// A mission cannot be started.
    #[error("a mission of the experiment cannot be started: {0}")]
    Run(#[from] missions::RunError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] figures::FigureError),
    /// A recording cannot be localised in.
    #[error("a recording of the experiment cannot be used: {0}")]
    Localisation(#[from] continuous_localisation::RunError),
    /// A recording cannot be mapped as the document describes.
    #[error("a recording of the experiment cannot be mapped as described: {0}")]
    Described(#[from] continuous_localisation::classic::ClassicError),
    /// The ideal loop of an experiment cannot be set up.
    #[error("the ideal loop of the experiment is refused: {0}")]
    Ideal(String),
    /// Conditions that an experiment does not have.
    #[error("{0}")]
    Sweep(String),
    /// A map cannot be drawn.
    #[error("a map of the experiment cannot be drawn: {0}")]
    Map(#[from] grid_maps::MapError),
    /// The threads cannot be started.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Told how many runs are done, and of how many; called from any thread, not in order.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);
