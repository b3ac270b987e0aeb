//! Parameter studies: one recording mapped under many settings, on all cores, with a journal on the disk.
//!
//! A plan names keys of the configuration and their values. A sweep tries all combinations, or random ones; tuning
//! walks through them by coordinate descent. Every finished setting is written to a journal at once, so that a
//! sweep that was killed goes on where it was; the result is that of a sweep that was not.
//!
//! What is random comes from one stream for each key: the order of threads, the number of threads and keys added to
//! the end of a plan change no value.

mod journal;
mod page;
mod plan;
mod search;
mod table;

pub use journal::JournalError;
pub use page::sweep_report;
pub use plan::{Goal, PlanError, Setting, SweepPlan};
pub use search::{Evaluate, SweepOutcome, SweepProgress, sweep, tune};
pub use table::{Row, SweepTable};

use std::path::PathBuf;

use recordings::Recording;
use run_context::StateHash;

use crate::{config::SurveyConfig, folder::recording_hash, outcome::Known};

/// A sweep that cannot be carried out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The journal cannot be read or written, or is another sweep's.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// No setting gave the figure that is to be judged.
    #[error(
        "no setting has the figure `{figure}`; there are {}{}", known.join(", "),
        failure.as_ref().map(|f| format!("; the first run that failed said: {f}")).unwrap_or_default()
    )]
    NoFigure {
        /// What was asked for.
        figure: String,
        /// The figures of the first setting that ended well.
        known: Vec<String>,
        /// What went wrong with the first one that did not.
        failure: Option<String>,
    },
    /// The threads cannot be started.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Where and how a sweep runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepOptions {
    /// The journal, made if there is none.
    pub journal: PathBuf,
    /// What tells this sweep from others: recording, configuration, plan.
    pub fingerprint: String,
    /// Threads; 0 for one per core. The result does not depend on it.
    pub n_threads: usize,
}

/// What tells a sweep from others: a hash of the recording, what it is judged by, the settings and the plan.
pub fn sweep_fingerprint(
    recording: &Recording,
    config: &SurveyConfig,
    plan: &SweepPlan,
    known: &Known,
) -> String {
    let mut hash = StateHash::new();
    hash.absorb_bytes(recording_hash(recording).as_bytes());
    hash.absorb_bytes(config.to_toml().as_bytes());
    hash.absorb_bytes(format!("{plan:?}").as_bytes());
    hash.absorb_u64(known.truth.len() as u64);
    for relation in &known.relations {
        let pose = relation.second_in_first;
        hash.absorb_u64(relation.first.as_nanos());
        hash.absorb_u64(relation.second.as_nanos());
        for value in [pose.x_m, pose.y_m, pose.yaw_rad] {
            hash.absorb_u64(value.to_bits());
        }
    }
    hash.to_string()
}
