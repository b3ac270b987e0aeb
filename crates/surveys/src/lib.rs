//! From a recording to a map: runs, checkpoints, sweeps, reports.
//!
//! A [`Survey`] plays a recording into a mapper, one scan at a time; what happened comes back as [`Event`]s, and how
//! things stand can be looked at between any two scans. [`Outcome`] is what it leaves: map, trajectory, corrections,
//! closures, figures. Everything that can be set is a key of [`SurveyConfig`].

mod clock;
pub mod config;
mod drawing;
mod folder;
mod known;
mod laser;
mod mapper;
mod odometry;
mod outcome;
mod page;
mod sonar;
mod survey;
mod sweep;
pub mod testing;

pub use clock::{Clock, Spent, Stages};
pub use config::{ConfigError, Key, KeyKind, MapSettings, Method, Mode, SurveyConfig};
pub use drawing::SurveyMap;
pub use folder::{
    CHECKPOINT, FolderError, FolderInput, ResumeError, SUMMARY, SurveyState, Written,
    check_results, read_checkpoint, recording_hash, remove_checkpoint, write_checkpoint,
    write_results,
};
pub use known::{RelationsFile, TruthFile, read_known_relations, read_truth};
pub use mapper::{Candidate, Closed, Counter, Event, Registration, ShortTerm, SurveyError};
pub use outcome::{Figure, Judgement, Known, Outcome};
pub use page::{ReportInput, report};
pub use slam::evaluate::{Errors, Relation, RelationErrors};
pub use sonar::SurveyPrior;
pub use survey::{Progress, Survey};
pub use sweep::{
    Evaluate, Goal, JournalError, PlanError, Row, Setting, SweepError, SweepOptions, SweepOutcome,
    SweepPlan, SweepProgress, SweepTable, sweep, sweep_fingerprint, sweep_report, tune,
};
