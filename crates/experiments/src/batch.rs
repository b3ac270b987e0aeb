//! Many runs of many settings on all cores, collected by index.

use std::sync::atomic::{AtomicUsize, Ordering};

use geometry::Vec2;
use missions::{Mission, MissionError, Pose, Run, Summary};
use rand_core::Rng;
use rayon::prelude::*;
use run_context::{RandomStream, RunSeed};

use crate::{ExperimentError, Options, Progress};

/// Steps of a run between two points of a recorded trajectory.
const STEPS_PER_POINT: u64 = 10;

/// What one run left behind.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// The run in figures.
    pub(crate) summary: Summary,
    /// Where the first robot really was, every 100 ms: time (s) and pose.
    pub(crate) track: Vec<(f64, Pose)>,
}

impl Outcome {
    /// The driven line, metres.
    pub(crate) fn line_m(&self) -> Vec<Vec2> {
        self.track.iter().map(|(_, pose)| Vec2::new(pose.x_m, pose.y_m)).collect()
    }

    /// Whether the mission's requirements were met.
    pub(crate) fn passed(&self) -> bool {
        self.summary.verdict.as_ref().is_some_and(|verdict| verdict.passed)
    }

    /// Whether anything was touched.
    pub(crate) fn touched(&self) -> bool {
        self.summary.figure("contacts").is_some_and(|contacts| contacts > 0.0)
    }

    /// Whether the robot arrived, whatever it touched.
    pub(crate) fn arrived(&self) -> bool {
        self.summary.verdict.iter().flat_map(|v| &v.checks).any(|c| c.name == "arrived" && c.passed)
    }
}

/// Makes a mission for setting i and run j; all that is random in it comes from the stream.
pub(crate) type MakeMission<'a> =
    &'a (dyn Fn(usize, &mut RandomStream) -> Result<Mission, MissionError> + Sync);

/// Runs every setting `options.n_runs` times; the result of setting i, run j stands at `[i][j]`.
///
/// Run j draws from the same stream in every setting, so that settings meet the same situations.
pub(crate) fn run_all(
    n_settings: usize,
    make: MakeMission<'_>,
    options: &Options,
    progress: Progress<'_>,
) -> Result<Vec<Vec<Outcome>>, ExperimentError> {
    let n_runs = options.n_runs as usize;
    let total = n_settings * n_runs;
    let done = AtomicUsize::new(0);
    let mut outcomes = (0..total)
        .into_par_iter()
        .map(|index| {
            let seed = RunSeed(options.seed.0.wrapping_add((index % n_runs) as u64));
            let mission = make(index / n_runs, &mut seed.stream("experiment/situation"))?;
            let outcome = run_one(mission, seed);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            outcome
        })
        .collect::<Result<Vec<_>, _>>()?
        .into_iter();
    Ok((0..n_settings).map(|_| outcomes.by_ref().take(n_runs).collect()).collect())
}

/// A number from `low` to `high`, evenly distributed.
pub(crate) fn uniform(rng: &mut RandomStream, low: f64, high: f64) -> f64 {
    // 53 random bits fill a double's mantissa: every value from 0 to 1 - 2⁻⁵³ is equally likely.
    low + (high - low) * ((rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
}

/// One run to its verdict.
fn run_one(mission: Mission, seed: RunSeed) -> Result<Outcome, ExperimentError> {
    let mut run = Run::new(mission, seed)?;
    let mut track = Vec::new();
    while run.finished().is_none() {
        if run.steps().is_multiple_of(STEPS_PER_POINT)
            && let Some(robot) = run.view().robots.first()
        {
            track.push((run.now().as_secs_f64(), robot.truth));
        }
        run.step();
    }
    Ok(Outcome { summary: run.summary(), track })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions(n_threads: usize) -> Vec<(f64, f64)> {
        let make: MakeMission<'_> = &|setting, rng| {
            let speed_mps = 0.2 + 0.1 * setting as f64;
            let overrides = [
                format!("robots.mind.follow.speed_mps={speed_mps}"),
                format!("robots.start=[{}, 0.0, 20.0]", uniform(rng, 0.0, 0.2)),
                "mission.duration_max_s=10".to_owned(),
            ];
            Mission::load("trail-45deg", &overrides)
        };
        let options = Options { n_runs: 3, seed: RunSeed(5), n_threads, ..Options::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let outcomes = pool.install(|| run_all(2, make, &options, &|_, _| ())).unwrap();
        let last = |outcome: &Outcome| outcome.line_m().last().map(|p| (p.x, p.y)).unwrap();
        outcomes.iter().flatten().map(last).collect()
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let alone = positions(1);
        assert_eq!(alone, positions(3));
        assert_eq!(alone.len(), 6);
        assert_ne!(alone[0], alone[3], "settings must differ");
        assert_ne!(alone[0], alone[1], "runs must differ");
    }
}
