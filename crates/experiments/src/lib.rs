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
mod terms;

pub use figures::{Figure, Report, Section, Table};
pub use statistics::{Proportion, median};
pub use terms::{ExperimentError, Options, Progress, Sweep};

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
