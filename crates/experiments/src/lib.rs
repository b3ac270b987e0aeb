//! The published experiments, repeated and reported with figures.
//!
//! Each experiment runs missions through the whole closed loop, wire included, many times with seeds
//! of its own, and writes a [`Report`]: what the document reports, what is measured here, and why they
//! differ. Runs are spread over threads and collected by index, so that a report does not depend on the
//! number of threads.
//!
//! ```no_run
//! let experiment = experiments::by_name("assistant-7.4").unwrap();
//! let options = experiments::Options { n_runs: 20, ..experiments::Options::default() };
//! let report = experiment.run(&options, &|_done, _total| ())?;
//! std::fs::write("report.html", report.to_html())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assistant_avoidance;
mod assistant_trails;
mod batch;
mod report;
mod sonar_slam;
mod statistics;
mod tag_trails;

pub use figures::{Figure, Report, Section, Table};
pub use statistics::{Proportion, median};

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
    fn names(&self) -> Vec<&'static str> {
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

type Body = fn(&Options, Progress<'_>) -> Result<Report, ExperimentError>;

/// A published experiment.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Its name on the command line: the document and the section.
    pub name: &'static str,
    /// What it is, in a line.
    pub title: &'static str,
    /// Runs per setting unless asked otherwise.
    pub n_runs: u32,
    /// Which conditions can be swept.
    sweeps: &'static [&'static str],
    body: Body,
}

impl Experiment {
    /// Carries the experiment out.
    ///
    /// # Errors
    ///
    /// [`ExperimentError`] when a mission or a sweep is refused, or threads or figures cannot be made.
    pub fn run(
        &self,
        options: &Options,
        progress: Progress<'_>,
    ) -> Result<Report, ExperimentError> {
        let n_runs = if options.n_runs == 0 { self.n_runs } else { options.n_runs };
        let options = Options { n_runs, ..options.clone() };
        if let Some(foreign) = options.sweep.names().iter().find(|n| !self.sweeps.contains(n)) {
            let can = if self.sweeps.is_empty() { "nothing" } else { &self.sweeps.join(", ") };
            return Err(ExperimentError::Sweep(format!(
                "{} does not sweep {foreign}: it sweeps {can}",
                self.name
            )));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.n_threads).build()?;
        pool.install(|| (self.body)(&options, progress))
    }
}

/// All experiments, document by document.
pub const ALL: [Experiment; 4] = [
    Experiment {
        name: "assistant-7.4",
        title: "Following virtual pheromones: trajectories, and sweeps of speed, period, radius and sets",
        n_runs: 20,
        sweeps: &["speeds", "periods", "sigmas", "sets", "accelerations"],
        body: assistant_trails::run,
    },
    Experiment {
        name: "assistant-7.5",
        title: "Bubble rebound: obstacles missed against speed, and a person who crosses",
        n_runs: 200,
        sweeps: &["speeds"],
        body: assistant_avoidance::run,
    },
    Experiment {
        name: "assistant-5.3.2",
        title: "A trail in tags on the floor against the pheromone server's: silence, unequal wheels, missing tags",
        n_runs: 40,
        sweeps: &[],
        body: tag_trails::run,
    },
    Experiment {
        name: "sonar-slam",
        title: "Sonar maps and continuous localisation: E1 to E4 against the truth, X1 to X4, V1, V1b, V2",
        n_runs: 20,
        sweeps: &[],
        body: sonar_slam::run,
    },
];

/// The experiment of that name.
pub fn by_name(name: &str) -> Option<Experiment> {
    ALL.into_iter().find(|experiment| experiment.name == name)
}
