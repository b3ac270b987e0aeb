//! Running the settings of a plan: all of them, or a walk towards the best.

use std::collections::BTreeMap;
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;

use super::{
    SweepError, SweepOptions,
    journal::{Journal, JournalError},
    plan::{Setting, SweepPlan},
    table::{Row, SweepTable},
};
use crate::clock::Clock;

/// How a sweep or a tuning ended.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepOutcome {
    /// Everything that was run, in the order of the plan, or of the walk.
    pub table: SweepTable,
    /// Index of the best row.
    pub best: usize,
    /// Rows that the journal had already.
    pub n_resumed: usize,
    /// Whether a tuning ended because no single change is better; always true of a sweep.
    pub settled: bool,
}

/// Maps with one setting; figures, or why there are none. Called from several threads.
pub type Evaluate<'a> = &'a (dyn Fn(&Setting) -> Result<Vec<(String, f64)>, String> + Sync);
/// Told how many settings are done, and of how many; called from any thread, not in order.
pub type SweepProgress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What both searches share.
struct Bench<'a> {
    journal: Mutex<(Journal, BTreeMap<String, Row>)>,
    n_resumed: usize,
    evaluate: Evaluate<'a>,
    progress: SweepProgress<'a>,
    clock: &'a Clock,
    done: AtomicUsize,
}

/// Runs every setting of `plan` that the journal does not hold yet.
///
/// A run that fails is a row with its reason; the sweep goes on.
///
/// # Errors
///
/// [`SweepError`]; the journal keeps what was finished.
pub fn sweep(
    plan: &SweepPlan,
    options: &SweepOptions,
    clock: &Clock,
    evaluate: Evaluate<'_>,
    progress: SweepProgress<'_>,
) -> Result<SweepOutcome, SweepError> {
    let bench = Bench::open(options, clock, evaluate, progress)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.n_threads).build()?;
    let settings = plan.settings();
    let total = settings.len();
    let rows = pool.install(|| bench.run(&settings, total))?;
    let keys = plan.keys().into_iter().map(str::to_owned).collect();
    let table = SweepTable { keys, rows: settings.into_iter().zip(rows).collect() };
    bench.outcome(plan, table, true)
}

/// Looks for the best setting by coordinate descent.
///
/// Begins with the middle value of every key, or with `start` where that holds one. Then key after key, in the order of
/// the plan, all its values are tried with the others held, and the best is kept; of equals, the one that was
/// there before, then the first. A round without a change, or the plan's number of rounds, ends the walk. It finds a
/// setting that no single change betters, not the best of all; nothing is tried twice.
///
/// Costs at most rounds × (sum of the values of all keys) runs.
///
/// # Errors
///
/// [`SweepError`]; the journal keeps what was finished.
pub fn tune(
    plan: &SweepPlan,
    start: &dyn Fn(&str) -> Option<toml::Value>,
    options: &SweepOptions,
    (clock, evaluate, progress): (&Clock, Evaluate<'_>, SweepProgress<'_>),
) -> Result<SweepOutcome, SweepError> {
    let bench = Bench::open(options, clock, evaluate, progress)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.n_threads).build()?;
    let values = plan.values();
    let per_round: usize = values.iter().map(|(_, v)| v.len()).sum();
    let total = per_round * plan.rounds_max();
    let begin = |(key, values): &(String, Vec<toml::Value>)| {
        let own = start(key).filter(|own| values.contains(own));
        (key.clone(), own.unwrap_or_else(|| values[(values.len() - 1) / 2].clone()))
    };
    let mut current = Setting(values.iter().map(begin).collect());
    let keys = plan.keys().into_iter().map(str::to_owned).collect();
    let mut table = SweepTable { keys, rows: Vec::new() };
    let mut settled = false;
    for _round in 0..plan.rounds_max() {
        let before = current.clone();
        for (place, (_, values)) in values.iter().enumerate() {
            // The held one first: among equals it stays.
            let mut tried = vec![current.clone()];
            tried.extend(values.iter().filter(|&v| *v != current.0[place].1).map(|value| {
                let mut changed = current.clone();
                changed.0[place].1 = value.clone();
                changed
            }));
            let rows = pool.install(|| bench.run(&tried, total))?;
            let line = SweepTable { keys: Vec::new(), rows: tried.into_iter().zip(rows).collect() };
            if let Some(best) = line.best(plan.goal()) {
                current = line.rows[best].0.clone();
            }
            for (setting, row) in line.rows {
                if !table.rows.iter().any(|(known, _)| *known == setting) {
                    table.rows.push((setting, row));
                }
            }
        }
        settled = current == before;
        if settled {
            break;
        }
    }
    bench.outcome(plan, table, settled)
}

impl<'a> Bench<'a> {
    fn open(
        options: &SweepOptions,
        clock: &'a Clock,
        evaluate: Evaluate<'a>,
        progress: SweepProgress<'a>,
    ) -> Result<Self, JournalError> {
        let (journal, rows) = Journal::open(&options.journal, &options.fingerprint)?;
        let n_resumed = rows.len();
        let journal = Mutex::new((journal, rows));
        let done = AtomicUsize::new(0);
        Ok(Self { journal, n_resumed, evaluate, progress, clock, done })
    }

    /// The rows of `settings`, in their order.
    fn run(&self, settings: &[Setting], total: usize) -> Result<Vec<Row>, JournalError> {
        let one = |setting: &Setting| {
            let row = match self.known(setting) {
                Some(row) => row,
                None => self.fresh(setting)?,
            };
            let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
            (self.progress)(done.min(total), total);
            Ok(row)
        };
        settings.par_iter().map(one).collect()
    }

    fn known(&self, setting: &Setting) -> Option<Row> {
        let held = self.journal.lock().unwrap_or_else(PoisonError::into_inner);
        held.1.get(&setting.name()).cloned()
    }

    fn fresh(&self, setting: &Setting) -> Result<Row, JournalError> {
        let begun = self.clock.now();
        let (mut figures, failure) = match (self.evaluate)(setting) {
            Ok(figures) => (figures, None),
            Err(reason) => (Vec::new(), Some(reason)),
        };
        // What is not finite cannot be written in JSON, and cannot be the best.
        figures.retain(|(_, value)| value.is_finite());
        let time_s = self.clock.now().saturating_sub(begun).as_secs_f64();
        let row = Row { setting: setting.name(), figures, failure, time_s };
        let mut held = self.journal.lock().unwrap_or_else(PoisonError::into_inner);
        held.0.add(&row)?;
        held.1.insert(row.setting.clone(), row.clone());
        Ok(row)
    }

    fn outcome(
        &self,
        plan: &SweepPlan,
        table: SweepTable,
        settled: bool,
    ) -> Result<SweepOutcome, SweepError> {
        let Some(best) = table.best(plan.goal()) else {
            return Err(SweepError::NoFigure {
                figure: plan.goal().figure().to_owned(),
                known: table.figures().into_iter().map(str::to_owned).collect(),
                failure: table.rows.iter().find_map(|(_, row)| row.failure.clone()),
            });
        };
        Ok(SweepOutcome { table, best, n_resumed: self.n_resumed, settled })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const PLAN: &str = "minimise = \"e_m\"\n\
        [[keys]]\nkey = \"x\"\nvalues = [0.0, 1.0, 2.0, 3.0, 4.0]\n\
        [[keys]]\nkey = \"y\"\nvalues = [-2.0, -1.0, 0.0, 1.0]\n";

    fn numbers(setting: &Setting) -> (f64, f64) {
        (setting.0[0].1.as_float().unwrap(), setting.0[1].1.as_float().unwrap())
    }

    /// A bowl with its lowest point at (3, -1), and one setting that fails.
    fn bowl(setting: &Setting) -> Result<Vec<(String, f64)>, String> {
        let (x, y) = numbers(setting);
        if x > 3.5 && y > 0.5 {
            return Err("no map".to_owned());
        }
        Ok(vec![("e_m".to_owned(), (x - 3.0).powi(2) + (y + 1.0).powi(2) + 0.1 * x * y)])
    }

    fn options(folder: &Path, n_threads: usize) -> SweepOptions {
        let journal = folder.join("sweep.jsonl");
        SweepOptions { journal, fingerprint: "bowl".to_owned(), n_threads }
    }

    #[test]
    fn a_killed_sweep_ends_like_one_that_was_not() {
        let plan = SweepPlan::parse("plan", PLAN).unwrap();
        let [whole, torn] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let run = |folder: &Path, n_threads, evaluate: Evaluate<'_>| {
            sweep(&plan, &options(folder, n_threads), &Clock::stopped(), evaluate, &|_, _| ())
        };
        let alone = run(whole.path(), 1, &bowl).unwrap();
        assert_eq!((alone.table.rows.len(), alone.n_resumed), (20, 0));
        assert_eq!(numbers(&alone.table.rows[alone.best].0), (3.0, -1.0));
        assert_eq!(alone.table.rows[19].1.failure.as_deref(), Some("no map"));
        // Killed in the middle: half of the journal, its last line torn.
        let journal = std::fs::read(whole.path().join("sweep.jsonl")).unwrap();
        std::fs::write(torn.path().join("sweep.jsonl"), &journal[..journal.len() / 2]).unwrap();
        let calls = AtomicUsize::new(0);
        let counted = |setting: &Setting| {
            calls.fetch_add(1, Ordering::Relaxed);
            bowl(setting)
        };
        let resumed = run(torn.path(), 4, &counted).unwrap();
        assert_eq!(resumed.table.to_csv(), alone.table.to_csv());
        assert!(resumed.n_resumed > 5);
        assert_eq!(calls.into_inner() + resumed.n_resumed, 20, "what was done is not repeated");
    }

    #[test]
    fn tuning_reaches_what_no_single_change_betters() {
        let plan = SweepPlan::parse("plan", PLAN).unwrap();
        let place = tempfile::tempdir().unwrap();
        let run = |n_threads| {
            let options = options(place.path(), n_threads);
            let start = |key: &str| (key == "y").then_some(toml::Value::Float(1.0));
            tune(&plan, &start, &options, (&Clock::stopped(), &bowl, &|_, _| ())).unwrap()
        };
        let found = run(2);
        assert!(found.settled);
        assert_eq!(found.table.rows[0].0.name(), "x=2.0 y=1.0", "middle and start");
        assert_eq!(numbers(&found.table.rows[found.best].0), (3.0, -1.0));
        assert!(found.table.rows.len() < 20, "fewer runs than the whole grid");
        let again = run(1);
        assert_eq!((again.table, again.n_resumed), (found.table.clone(), found.table.rows.len()));
    }

    #[test]
    fn a_figure_that_no_run_has_is_an_error() {
        let text = PLAN.replace("e_m", "rmse_m");
        let plan = SweepPlan::parse("plan", &text).unwrap();
        let place = tempfile::tempdir().unwrap();
        let options = options(place.path(), 1);
        let error = sweep(&plan, &options, &Clock::stopped(), &bowl, &|_, _| ()).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains("`rmse_m`") && said.contains("e_m") && said.contains("no map"),
            "{said}"
        );
    }
}
