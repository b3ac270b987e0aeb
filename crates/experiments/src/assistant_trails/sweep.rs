//! The straight trail with conditions of one's own: every combination of what is asked for.

use super::{
    measures::{all_medians, cell, greatest_excursion_mm, n_lost, settled_rms_mm},
    setting::Setting,
    straight::{ideal_medians, straight_mission},
};
use crate::{ExperimentError, Options, Progress, Report, Section, Sweep, Table, batch::run_all};

/// Combinations at most.
const N_SETTINGS_MAX: usize = 500;

/// The report of a sweep.
pub(super) fn run(options: &Options, progress: Progress<'_>) -> Result<Report, ExperimentError> {
    let settings = settings(&options.sweep)?;
    let outcomes =
        run_all(settings.len(), &|i, rng| straight_mission(settings[i], rng), options, progress)?;
    let ideal = ideal_medians(&settings, options)?;
    let mut table = Table::new(
        "Distance from the trail once settled (median over the runs that kept it), of an ideal loop under the \
         same conditions, and the greatest (median over all)",
        &[
            "a (m/s²)",
            "v (m/s)",
            "Δt (s)",
            "σ (m)",
            "sets",
            "settled, rms (mm)",
            "ideal, rms (mm)",
            "greatest (mm)",
            "lost the trail",
        ],
    );
    for ((setting, runs), ideal_mm) in settings.iter().zip(&outcomes).zip(ideal) {
        table.rows.push(vec![
            format!("{}", setting.acceleration_mps2),
            format!("{}", setting.speed_mps),
            format!("{}", f64::from(setting.period_ms) / 1e3),
            format!("{}", setting.sigma_m),
            if setting.five_sets { "5" } else { "3" }.to_owned(),
            cell(all_medians(runs, settled_rms_mm)),
            cell(ideal_mm),
            cell(all_medians(runs, |run| Some(greatest_excursion_mm(run)))),
            n_lost(runs),
        ]);
    }
    Ok(Report {
        title: "Following virtual pheromones: conditions of one's own".to_owned(),
        preamble: format!(
            "{} runs per setting, seeds {} to {}, on the straight trail of the thesis's experiment 7.4, turned by \
             45° at the start.",
            options.n_runs,
            options.seed.0,
            options.seed.0 + u64::from(options.n_runs) - 1
        ),
        sections: vec![Section {
            heading: "Straight trail".to_owned(),
            tables: vec![table],
            ..Section::default()
        }],
    })
}

fn settings(sweep: &Sweep) -> Result<Vec<Setting>, ExperimentError> {
    fn or<T: Copy>(given: &[T], usual: T) -> Vec<T> {
        if given.is_empty() { vec![usual] } else { given.to_vec() }
    }
    let usual = Setting::THESIS;
    let mut settings = Vec::new();
    for acceleration_mps2 in or(&sweep.accelerations_mps2, usual.acceleration_mps2) {
        for speed_mps in or(&sweep.speeds_mps, usual.speed_mps) {
            for period_ms in or(&sweep.periods_ms, usual.period_ms) {
                for sigma_m in or(&sweep.sigmas_m, usual.sigma_m) {
                    for n_sets in or(&sweep.n_sets, 3) {
                        if n_sets != 3 && n_sets != 5 {
                            return Err(ExperimentError::Sweep(format!(
                                "{n_sets} fuzzy sets: there are laws with 3 and with 5"
                            )));
                        }
                        let five_sets = n_sets == 5;
                        settings.push(Setting {
                            acceleration_mps2,
                            speed_mps,
                            period_ms,
                            sigma_m,
                            five_sets,
                            ..usual
                        });
                    }
                }
            }
        }
    }
    if settings.len() > N_SETTINGS_MAX {
        return Err(ExperimentError::Sweep(format!(
            "{} combinations: at most {N_SETTINGS_MAX}",
            settings.len()
        )));
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_has_its_row_and_its_runs() {
        let sweep = Sweep {
            speeds_mps: vec![0.2, 0.3],
            n_sets: vec![3, 5],
            sigmas_m: vec![0.7],
            ..Sweep::default()
        };
        let options = Options { n_runs: 1, sweep, ..Options::default() };
        let report = run(&options, &|_, _| ()).unwrap();
        let rows = &report.tables().next().unwrap().rows;
        let heads: Vec<[&str; 5]> =
            rows.iter().map(|row| std::array::from_fn(|i| row[i].as_str())).collect();
        let row = |v, sets| ["0.3", v, "0.2", "0.7", sets];
        assert_eq!(heads, [row("0.2", "3"), row("0.2", "5"), row("0.3", "3"), row("0.3", "5")]);
        // A slower robot is steered more often on the same way: its figure is its own.
        assert_ne!(rows[0][5], rows[2][5]);
        assert_ne!(rows[0][5], rows[1][5]);
    }

    #[test]
    fn what_cannot_be_swept_is_said() {
        let refused = |sweep| settings(&sweep).unwrap_err().to_string();
        let four = Sweep { n_sets: vec![4], ..Sweep::default() };
        assert_eq!(refused(four), "4 fuzzy sets: there are laws with 3 and with 5");
        let many = Sweep { speeds_mps: vec![0.3; 501], ..Sweep::default() };
        assert_eq!(refused(many), "501 combinations: at most 500");
    }
}
