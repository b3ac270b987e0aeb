//! Figures of runs on the straight trail.

use super::setting::{LOST_M, SETTLED_M};
use crate::{batch::Outcome, statistics::median};

/// Root mean square distance from the straight trail once settled, mm; `None` when the robot lost the
/// trail: what it drove then says nothing about the law.
pub(super) fn settled_rms_mm(outcome: &Outcome) -> Option<f64> {
    if lost(outcome) {
        return None;
    }
    let line = outcome.line_m();
    let settled: Vec<f64> =
        line.iter().filter(|p| SETTLED_M.contains(&p.x)).map(|p| p.y * p.y).collect();
    let mean = settled.iter().sum::<f64>() / settled.len() as f64;
    (!settled.is_empty()).then(|| mean.sqrt() * 1e3)
}

pub(super) fn lost(outcome: &Outcome) -> bool {
    !outcome.arrived() || outcome.line_m().iter().any(|p| p.y.abs() > LOST_M)
}

pub(super) fn greatest_excursion_mm(outcome: &Outcome) -> f64 {
    outcome.line_m().iter().map(|p| p.y.abs()).fold(0.0, f64::max) * 1e3
}

pub(super) fn all_medians(
    outcomes: &[Outcome],
    figure: impl Fn(&Outcome) -> Option<f64>,
) -> Option<f64> {
    median(&outcomes.iter().filter_map(figure).collect::<Vec<_>>())
}

pub(super) fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.1}"))
}

pub(super) fn n_lost(runs: &[Outcome]) -> String {
    format!("{} of {}", runs.iter().filter(|run| lost(run)).count(), runs.len())
}
