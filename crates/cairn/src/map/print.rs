//! What `cairn map` prints at its end.

use std::path::Path;

use surveys::{Outcome, Written};

use super::inputs::{Inputs, time};
use crate::output::{self, complain, number, say};

/// Complaints that are printed in full.
const COMPLAINTS_SHOWN: usize = 5;

/// A summary for people.
pub(super) fn text(
    inputs: &Inputs,
    outcome: &Outcome,
    written: &Written,
    folder: &Path,
    run_s: f64,
) {
    complaints(inputs);
    say!("{}: {}", inputs.name, lower_first(&inputs.source));
    for note in &inputs.notes {
        say!("{note}");
    }
    say!();
    let value = |name: &str| written.figures.iter().find(|f| f.name == name).map(|f| f.value);
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String, about: String| {
        rows.push(vec![format!("  {name}"), value, about]);
    };
    let scans_per_s = outcome.trajectory.len() as f64 / run_s.max(1e-9);
    row(
        "way",
        format!("{} m", number(round(outcome.path_m()))),
        "along the corrected trajectory".into(),
    );
    for counter in &outcome.counters {
        row(counter.label, counter.n.to_string(), String::new());
    }
    if outcome.n_lost > 0 {
        let about = "placed by dead reckoning".to_owned();
        row("scans that did not fit", outcome.n_lost.to_string(), about);
    }
    if let (Some(m), Some(deg)) = (value("last_correction_m"), value("last_correction_deg")) {
        let about = "between dead reckoning and the map at the end".to_owned();
        row("corrected by", format!("{m:.3} m, {deg:.2}°"), about);
    }
    if let (Some(m2), Some(bits)) = (value("map.known_m2"), value("map.entropy_mean_bits")) {
        let about = format!("known; {bits:.3} bits of doubt in a cell");
        row("map", format!("{m2:.0} m²"), about);
    }
    row("time", time(run_s), format!("{scans_per_s:.0} scans/s"));
    output::table(&rows);
    errors(written);
    say!("\nMap: {}", folder.join("map.yaml").display());
    say!("Report: {}", folder.join("report.html").display());
}

/// Three digits behind the point at most.
fn round(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn lower_first(text: &str) -> String {
    match text.strip_prefix("A ") {
        Some(rest) => format!("a {rest}"),
        None => text.to_owned(),
    }
}

fn complaints(inputs: &Inputs) {
    for (file, complaints) in &inputs.complaints {
        for complaint in complaints.kept().iter().take(COMPLAINTS_SHOWN) {
            complain!("{file}: {complaint}");
        }
        if complaints.total() > COMPLAINTS_SHOWN.min(complaints.kept().len()) {
            complain!("{file}: {} complaints in all; the report lists them", complaints.total());
        }
    }
}

fn errors(written: &Written) {
    let cells = |name: &str, errors: &surveys::Errors| {
        let metres = |m: f64| format!("{m:.4} m");
        let degrees = |rad: f64| format!("{:.3}°", rad.to_degrees());
        vec![
            format!("  {name}"),
            errors.n.to_string(),
            metres(errors.mean_m),
            metres(errors.std_m),
            metres(errors.max_m),
            degrees(errors.mean_rad),
        ]
    };
    let mut rows = Vec::new();
    let judgement = &written.judgement;
    if let Some([survey, odometry]) = &judgement.truth {
        rows.push(cells("true poses", survey));
        rows.push(cells("  dead reckoning", odometry));
    }
    if let Some([survey, odometry]) = &judgement.reference {
        rows.push(cells("poses of the log", survey));
        rows.push(cells("  dead reckoning", odometry));
    }
    if let Some([survey, odometry]) = &judgement.relations {
        rows.push(cells("relations", &survey.all));
        rows.push(cells("  consecutive places", &survey.consecutive));
        rows.push(cells("  visited again", &survey.revisiting));
        rows.push(cells("  dead reckoning", &odometry.all));
    }
    rows.retain(|row: &Vec<String>| row[1] != "0");
    if judgement.relations.is_some_and(|[survey, _]| survey.all.n == 0) {
        say!(
            "\nNo relation lies within the trajectory: is its time the log's? See --relations-shift-s."
        );
    }
    if rows.is_empty() {
        return;
    }
    let head = ["  errors against", "pairs", "mean", "std", "max", "mean turn"];
    rows.insert(0, head.map(str::to_owned).to_vec());
    say!();
    output::table(&rows);
}

/// One object for machines.
pub(super) fn json(written: &Written, folder: &Path, run_s: f64) {
    let mut object = written.summary.clone();
    if let Some(fields) = object.as_object_mut() {
        fields.insert("time_s".to_owned(), run_s.into());
        fields.insert("folder".to_owned(), folder.display().to_string().into());
        fields.insert("files".to_owned(), written.names.clone().into());
    }
    say!("{object}");
}
