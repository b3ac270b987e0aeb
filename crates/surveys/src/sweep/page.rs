//! The report of a sweep: the table, and the judged figure against each key.

use figures::{Axes, Figure, FigureError, Line, Mark, Report, Section, Table};

use super::{plan::SweepPlan, search::SweepOutcome};

/// Rows of the table; the CSV file has all.
const ROWS_MAX: usize = 300;
/// Figures that stand beside the judged one.
const BESIDE: [&str; 6] = [
    "truth.rms_m",
    "reference.mean_m",
    "relations.mean_m",
    "map.entropy_mean_bits",
    "closures",
    "corrections",
];

/// Writes the report.
///
/// # Errors
///
/// [`FigureError`] when a chart cannot be drawn.
pub fn sweep_report(
    name: &str,
    source: &str,
    plan: &SweepPlan,
    found: &SweepOutcome,
) -> Result<Report, FigureError> {
    let goal = plan.goal().figure();
    let (setting, row) = &found.table.rows[found.best];
    let value = found.table.figure(found.best, goal);
    let best = format!(
        "Best of {} by {goal}: {} ({}).",
        found.table.rows.len(),
        setting.name(),
        value.map_or_else(|| "–".to_owned(), |v| format!("{v:.6}"))
    );
    let limit = if found.settled {
        String::new()
    } else {
        " The limit of rounds came before the walk settled.".to_owned()
    };
    let failed = found.table.rows.iter().filter(|(_, row)| row.failure.is_some()).count();
    let text = vec![
        format!("{best}{limit}"),
        format!("{failed} settings failed. The best took {:.2} s.", row.time_s),
    ];
    Ok(Report {
        title: format!("Settings tried on {name}"),
        preamble: format!("{source} Cairn {}.", env!("CARGO_PKG_VERSION")),
        sections: vec![Section {
            heading: "Result".to_owned(),
            text,
            tables: vec![table(plan, found)],
            figures: charts(goal, found)?,
        }],
    })
}

/// The best settings with their figures.
fn table(plan: &SweepPlan, found: &SweepOutcome) -> Table {
    let goal = plan.goal().figure();
    let known = found.table.figures();
    let mut figures = vec![goal];
    figures.extend(BESIDE.into_iter().filter(|f| *f != goal && known.contains(f)));
    let mut head: Vec<&str> = found.table.keys.iter().map(String::as_str).collect();
    head.extend(&figures);
    head.extend(["time (s)", "failure"]);
    let mut table = Table::new("The best first", &head);
    for i in found.table.order(plan.goal()).into_iter().take(ROWS_MAX) {
        let (setting, row) = &found.table.rows[i];
        let word = |value: &toml::Value| value.as_str().map_or(value.to_string(), str::to_owned);
        let mut cells: Vec<String> = setting.0.iter().map(|(_, value)| word(value)).collect();
        cells.extend(figures.iter().map(|figure| {
            let value = found.table.figure(i, figure);
            value.map_or_else(|| "–".to_owned(), figure_text)
        }));
        cells.push(format!("{:.2}", row.time_s));
        cells.push(row.failure.clone().unwrap_or_default());
        table.rows.push(cells);
    }
    table
}

/// Counts without decimals, measures with four.
fn figure_text(value: f64) -> String {
    if value.fract().abs() < 1e-12 { format!("{value:.0}") } else { format!("{value:.4}") }
}

/// The judged figure against every key that is a number.
fn charts(goal: &str, found: &SweepOutcome) -> Result<Vec<Figure>, FigureError> {
    let mut figures = Vec::new();
    for (place, key) in found.table.keys.iter().enumerate() {
        let number = |i: usize| {
            let value = &found.table.rows[i].0.0[place].1;
            value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
        };
        let point = |i: usize| Some((number(i)?, found.table.figure(i, goal)?));
        let points: Vec<(f64, f64)> = (0..found.table.rows.len()).filter_map(point).collect();
        if points.is_empty() {
            continue;
        }
        let line = Line { points, mark: Mark::Dots, ..Line::default() };
        figures.push(Figure {
            name: format!("by-{place}"),
            caption: format!("{goal} against {key}; a dot for each setting."),
            svg: figures::lines(Axes { x: key, y: goal }, &[line])?,
        });
    }
    Ok(figures)
}
