//! The report of a survey: what was mapped, how well, how long it took, and with which settings.

use figures::{Axes, Figure, FigureError, Floor, Line, Mark, Picture, Report, Section, Table};
use geometry::Vec2;
use recordings::Complaints;
use slam::evaluate::{Errors, RelationErrors};

use crate::{
    config::{Method, Mode, SurveyConfig},
    mapper::Registration,
    outcome::{Judgement, Outcome},
};

/// Points of a drawn trajectory are at least this part of its extent apart.
const POINT_SPACING_RATIO: f64 = 1.0 / 2000.0;
/// Points over which the cost of scans is averaged in the chart.
const COST_BINS: usize = 120;
/// Complaints and closures that are listed.
const LISTED_MAX: usize = 20;

/// What a report is about.
#[derive(Clone, Copy, Debug)]
pub struct ReportInput<'a> {
    /// The recording's name.
    pub name: &'a str,
    /// What it was read as, and what it holds, in words.
    pub source: &'a str,
    /// How it was set up.
    pub config: &'a SurveyConfig,
    /// The results.
    pub outcome: &'a Outcome,
    /// How far they are from what is known.
    pub judgement: &'a Judgement,
    /// What was wrong with the files, by file.
    pub complaints: &'a [(String, Complaints)],
    /// The map in colours: a PNG file.
    pub picture: &'a [u8],
    /// Where its lower left and upper right corners lie, metres.
    pub corners: [Vec2; 2],
}

/// What people call a method.
pub(crate) fn method_name(method: Method, mode: Mode) -> &'static str {
    match (method, mode) {
        (Method::Laser, _) => "laser SLAM: scan matching, loop closure, pose graph",
        (Method::Sonar, Mode::Default) => "sonar: continuous localisation",
        (Method::Sonar, Mode::Graph) => "sonar: submaps and loops in a pose graph",
        (Method::Sonar, Mode::Thesis) => {
            "sonar: continuous localisation as the thesis describes it"
        }
        (Method::Sonar, Mode::Listing) => "sonar: the thesis's printed program",
        (Method::Odometry | Method::Auto, _) => "dead reckoning, uncorrected",
    }
}

/// Writes the report.
///
/// # Errors
///
/// [`FigureError`] when a figure cannot be drawn.
pub fn report(input: &ReportInput<'_>) -> Result<Report, FigureError> {
    let outcome = input.outcome;
    let partial = if outcome.is_whole() {
        String::new()
    } else {
        let (done, all) = (outcome.trajectory.len(), outcome.n_scans);
        format!(" These are results of a survey under way: {done} of {all} scans.")
    };
    let preamble = format!(
        "{} Mapped by {}. Cairn {}.{partial}",
        input.source,
        method_name(outcome.method, outcome.mode),
        env!("CARGO_PKG_VERSION")
    );
    let mut sections = vec![map_section(input)?];
    sections.extend(error_section(input.judgement));
    sections.push(correction_section(outcome)?);
    if outcome.graph.is_some() {
        sections.push(closure_section(outcome));
    }
    if !outcome.registrations.is_empty() {
        sections.push(registration_section(&outcome.registrations));
    }
    sections.push(time_section(outcome)?);
    sections.push(complaint_section(input.complaints));
    sections.push(parameter_section(input.config));
    Ok(Report { title: format!("Map of {}", input.name), preamble, sections })
}

fn map_section(input: &ReportInput<'_>) -> Result<Section, FigureError> {
    let outcome = input.outcome;
    let [low, high] = input.corners;
    let spacing_m = POINT_SPACING_RATIO * (high - low).norm();
    let line = |poses: &mut dyn Iterator<Item = Vec2>| thinned(poses, spacing_m);
    let mut driven = Vec::new();
    let corrected = line(&mut outcome.trajectory.iter().map(|p| p.pose.position()));
    let before = line(&mut outcome.odometry.iter().flatten().map(|pose| pose.position()));
    driven.push(("trajectory, corrected".to_owned(), corrected));
    if outcome.method != Method::Odometry && !before.is_empty() {
        driven.push(("before: dead reckoning".to_owned(), before));
    }
    if !input.judgement.truth_in_map.is_empty() {
        let truth = input.judgement.truth_in_map.iter().map(|pose| pose.position());
        driven.push(("truth".to_owned(), line(&mut { truth })));
    }
    let place = |scan: usize| outcome.trajectory.get(scan).map(|p| p.pose.position());
    let links =
        outcome.closed.iter().filter_map(|c| Some([place(c.from_scan)?, place(c.to_scan)?]));
    let floor = Floor {
        picture: Some(Picture { png: input.picture.to_vec(), low, high }),
        driven,
        links_name: "loop closures",
        links: links.collect(),
        ..Floor::default()
    };
    let caption = "The map (dark: occupied, light: free, grey: not seen) with the robot's way. After and before \
                   correction begin at the same place.";
    let figure = |name: &str, caption: &str, floor: &Floor| {
        let svg = figures::floor(floor)?;
        Ok::<_, FigureError>(Figure { name: name.to_owned(), caption: caption.to_owned(), svg })
    };
    let alone_caption = if floor.links.is_empty() {
        "The map with the corrected way."
    } else {
        "The map with the corrected way and the loop closures, each a line between two places that are the same."
    };
    // A dead reckoning that left the building would make the map small: the map alone comes first.
    let alone = Floor { driven: floor.driven.iter().take(1).cloned().collect(), ..floor.clone() };
    Ok(Section {
        heading: "Map".to_owned(),
        figures: vec![
            figure("map", alone_caption, &alone)?,
            figure("map-before-after", caption, &floor)?,
        ],
        ..Section::default()
    })
}

/// A line without points that are nearer than `spacing_m` to the one before; the last one stays.
fn thinned(points: &mut dyn Iterator<Item = Vec2>, spacing_m: f64) -> Vec<Vec2> {
    let mut kept: Vec<Vec2> = Vec::new();
    let mut last = None;
    for point in points {
        if kept.last().is_none_or(|before| (point - before).norm() >= spacing_m) {
            kept.push(point);
            last = None;
        } else {
            last = Some(point);
        }
    }
    kept.extend(last);
    kept
}

fn error_section(judgement: &Judgement) -> Option<Section> {
    let head = ["", "pairs", "mean (m)", "std (m)", "max (m)", "mean (°)", "std (°)", "max (°)"];
    let mut table = Table::new("Errors of the survey, and of dead reckoning alone", &head);
    let mut add = |name: &str, errors: &Errors| {
        if errors.n > 0 {
            table.rows.push(error_row(name, errors));
        }
    };
    let mut text = Vec::new();
    if let Some([survey, odometry]) = &judgement.truth {
        add("true poses", survey);
        add("true poses, dead reckoning", odometry);
        text.push("Poses are compared after the rigid motion that fits best.".to_owned());
    }
    if let Some([survey, odometry]) = &judgement.reference {
        add("poses that came with the log", survey);
        add("the same, dead reckoning", odometry);
        let hint = "Poses that came with the log were computed by somebody else's program: a comparison, not a truth.";
        text.push(hint.to_owned());
    }
    if let Some([survey, odometry]) = &judgement.relations {
        if survey.all.n == 0 {
            let hint =
                "No relation lies within the trajectory: its time is another than the log's.";
            text.push(hint.to_owned());
        }
        let RelationErrors { all, consecutive, revisiting, n_outside } = survey;
        add("relations, all", all);
        add("relations, consecutive places", consecutive);
        add("relations, places visited again", revisiting);
        add("all, dead reckoning", &odometry.all);
        add("visited again, dead reckoning", &odometry.revisiting);
        if judgement.clock_shift_s.abs() > 0.0 {
            let shift_s = judgement.clock_shift_s;
            text.push(format!(
                "The clock of the relations was set by {shift_s:+.2} s, which fits best."
            ));
        }
        if *n_outside > 0 {
            text.push(format!("{n_outside} relations have a moment outside of the trajectory."));
        }
    }
    let heading = "Errors".to_owned();
    (!table.rows.is_empty()).then(|| Section {
        heading,
        text,
        tables: vec![table],
        ..Section::default()
    })
}

fn error_row(name: &str, errors: &Errors) -> Vec<String> {
    let degrees = |rad: f64| format!("{:.3}", rad.to_degrees());
    let metres = |m: f64| format!("{m:.4}");
    vec![
        name.to_owned(),
        errors.n.to_string(),
        metres(errors.mean_m),
        metres(errors.std_m),
        metres(errors.max_m),
        degrees(errors.mean_rad),
        degrees(errors.std_rad),
        degrees(errors.max_rad),
    ]
}

fn correction_section(outcome: &Outcome) -> Result<Section, FigureError> {
    let heading = "Corrections over time".to_owned();
    let corrections = outcome.corrections();
    if outcome.method == Method::Odometry || corrections.is_empty() {
        let text = match outcome.method {
            Method::Odometry => "Dead reckoning was taken as it is: nothing was corrected.",
            _ => "The recording has no odometry to be corrected.",
        };
        return Ok(Section { heading, text: vec![text.to_owned()], ..Section::default() });
    }
    let every = corrections.len().div_ceil(2000).max(1);
    let curve = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
        corrections.iter().step_by(every).map(|c| (c.0, value(c))).collect::<Vec<_>>()
    };
    let when = |scan: usize| outcome.trajectory.get(scan).map(|p| p.stamp.as_secs_f64());
    let closed = |value: &dyn Fn(&crate::mapper::Closed) -> f64| {
        outcome.closed.iter().filter_map(|c| Some((when(c.to_scan)?, value(c)))).collect::<Vec<_>>()
    };
    let step = |value: &dyn Fn(geometry::Se2) -> f64| {
        let moved = outcome.registrations.iter();
        moved.filter_map(|r| Some((when(r.last_scan)?, value(r.correction?)))).collect::<Vec<_>>()
    };
    let chart = |y: &str, points: Vec<(f64, f64)>, mark: Mark| {
        figures::lines(Axes { x: "time (s)", y }, &[Line { points, mark, ..Line::default() }])
    };
    let figure = |name: &str, caption: &str, svg: String| Figure {
        name: name.to_owned(),
        caption: caption.to_owned(),
        svg,
    };
    let away_m = chart("position (m)", curve(&|c| c.1), Mark::Joined)?;
    let away_deg = chart("heading (°)", curve(&|c| c.2.to_degrees()), Mark::Joined)?;
    let mut figures = vec![
        figure("corrections-m", "Position: distance from dead reckoning.", away_m),
        figure(
            "corrections-deg",
            "Heading: turn from dead reckoning, counter-clockwise.",
            away_deg,
        ),
    ];
    let shifts = [closed(&|c| c.shift_m), step(&|c| c.position().norm())].concat();
    let turns = [closed(&|c| c.shift_rad.to_degrees()), step(&|c| c.yaw_rad.to_degrees())].concat();
    if !shifts.is_empty() {
        let what = if outcome.closed.is_empty() { "a short-term map" } else { "a closed loop" };
        let (shifts, turns) =
            (chart("shift (m)", shifts, Mark::Dots)?, chart("turn (°)", turns, Mark::Dots)?);
        figures.push(figure("single-m", &format!("What {what} moved, each a dot."), shifts));
        figures.push(figure("single-deg", &format!("What {what} turned."), turns));
    }
    let text = "How far the corrected pose of each scan is from dead reckoning, which begins at the same place.";
    Ok(Section { heading, text: vec![text.to_owned()], figures, ..Section::default() })
}

fn closure_section(outcome: &Outcome) -> Section {
    let mut counts = Table::new("Graph and loops", &["", "number"]);
    counts.rows =
        outcome.counters.iter().map(|c| vec![c.label.to_owned(), c.n.to_string()]).collect();
    if let Some((graph, _)) = &outcome.graph {
        counts.rows.push(vec!["chi² of the graph".to_owned(), format!("{:.3}", graph.chi2())]);
    }
    let heading = "Loop closures".to_owned();
    if outcome.closed.is_empty() {
        let text =
            "No loop was closed: no place was visited again, or none was recognised beyond doubt.";
        let text = vec![text.to_owned()];
        return Section { heading, text, tables: vec![counts], ..Section::default() };
    }
    let mut largest: Vec<_> = outcome.closed.iter().collect();
    largest.sort_by(|a, b| b.shift_m.total_cmp(&a.shift_m).then(a.to_scan.cmp(&b.to_scan)));
    let head = ["from scan", "to scan", "at (s)", "off by (m)", "off by (°)"];
    let n = largest.len().min(LISTED_MAX);
    let mut table = Table::new(&format!("The {n} largest of {}", outcome.closed.len()), &head);
    let time =
        |scan: usize| outcome.trajectory.get(scan).map_or(f64::NAN, |p| p.stamp.as_secs_f64());
    table.rows.extend(largest.iter().take(LISTED_MAX).map(|c| {
        vec![
            (c.from_scan + 1).to_string(),
            (c.to_scan + 1).to_string(),
            format!("{:.1}", time(c.to_scan)),
            format!("{:.3}", c.shift_m),
            format!("{:.2}", c.shift_rad.to_degrees()),
        ]
    }));
    Section { heading, tables: vec![counts, table], ..Section::default() }
}

fn registration_section(registrations: &[Registration]) -> Section {
    let mut table = Table::new("Short-term maps compared with the map", &["verdict", "number"]);
    // The words before the numbers tell the verdicts apart.
    let kind = |r: &Registration| {
        let verdict = r.verdict.as_str();
        if r.applied { "moved".to_owned() } else { verdict.to_owned() }
    };
    let mut kinds: Vec<(String, usize)> = Vec::new();
    for registration in registrations {
        let kind = kind(registration);
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, n)) => *n += 1,
            None => kinds.push((kind, 1)),
        }
    }
    table.rows.extend(kinds.into_iter().map(|(kind, n)| vec![kind, n.to_string()]));
    let n: usize = registrations.iter().map(|r| r.candidates.len()).sum();
    let text = format!(
        "{} short-term maps, {n} candidates in all. What decides: {}.",
        registrations.len(),
        registrations.first().map_or("", |r| r.score)
    );
    let heading = "Registrations".to_owned();
    Section { heading, text: vec![text], tables: vec![table], ..Section::default() }
}

fn time_section(outcome: &Outcome) -> Result<Section, FigureError> {
    let heading = "Time".to_owned();
    let total_s: f64 = outcome.stages.values().map(|spent| spent.total.as_secs_f64()).sum();
    if total_s <= 0.0 {
        let text = vec!["The time was not measured.".to_owned()];
        return Ok(Section { heading, text, ..Section::default() });
    }
    let head = ["stage", "times", "total (s)", "mean (ms)", "longest (ms)", "share (%)"];
    let mut table = Table::new("Time spent by stage", &head);
    for (stage, spent) in &outcome.stages {
        let total = spent.total.as_secs_f64();
        table.rows.push(vec![
            (*stage).to_owned(),
            spent.n_times.to_string(),
            format!("{total:.3}"),
            format!("{:.3}", 1e3 * total / spent.n_times.max(1) as f64),
            format!("{:.2}", 1e3 * spent.longest.as_secs_f64()),
            format!("{:.1}", 100.0 * total / total_s),
        ]);
    }
    table.rows.push(vec![
        "together".to_owned(),
        String::new(),
        format!("{total_s:.3}"),
        String::new(),
        String::new(),
        "100.0".to_owned(),
    ]);
    let bin = outcome.scan_ms.len().div_ceil(COST_BINS).max(1);
    let mean = |(i, chunk): (usize, &[f64])| {
        (
            (i * bin) as f64 + 0.5 * chunk.len() as f64,
            chunk.iter().sum::<f64>() / chunk.len() as f64,
        )
    };
    let points = outcome.scan_ms.chunks(bin).enumerate().map(mean).collect();
    let line = Line { name: format!("mean of {bin} scans"), points, ..Line::default() };
    Ok(Section {
        heading,
        tables: vec![table],
        figures: vec![Figure {
            name: "cost".to_owned(),
            caption: "What a scan costs along the log: it should not grow.".to_owned(),
            svg: figures::lines(Axes { x: "scan", y: "time for a scan (ms)" }, &[line])?,
        }],
        ..Section::default()
    })
}

fn complaint_section(complaints: &[(String, Complaints)]) -> Section {
    let heading = "Complaints about the files".to_owned();
    let mut counts = Table::new("By kind", &["file", "what", "done", "number"]);
    let mut first = Table::new("The first ones", &["file", "complaint"]);
    for (file, complaints) in complaints {
        for (trouble, action, n) in complaints.counts() {
            let row = [file.clone(), trouble.to_string(), action.to_string(), n.to_string()];
            counts.rows.push(row.to_vec());
        }
        let kept = complaints.kept().iter().take(LISTED_MAX);
        first.rows.extend(kept.map(|c| vec![file.clone(), c.to_string()]));
    }
    if counts.rows.is_empty() {
        let text = vec!["There was nothing to complain about.".to_owned()];
        return Section { heading, text, ..Section::default() };
    }
    Section { heading, tables: vec![counts, first], ..Section::default() }
}

fn parameter_section(config: &SurveyConfig) -> Section {
    let default = SurveyConfig::default();
    let all: Vec<_> = SurveyConfig::keys()
        .filter_map(|key| Some((key, config.get(key.name)?, default.get(key.name)?)))
        .collect();
    let mut changed = Table::new("Set for this survey", &["key", "value", "default", "meaning"]);
    let differs = all.iter().filter(|(_, value, default)| value != default);
    changed.rows.extend(differs.map(|(key, value, default)| {
        vec![key.name.to_owned(), value.clone(), default.clone(), key.about.to_owned()]
    }));
    let mut table = Table::new("All of them", &["key", "value", "meaning"]);
    table.rows.extend(
        all.iter()
            .map(|(key, value, _)| vec![key.name.to_owned(), value.clone(), key.about.to_owned()]),
    );
    let heading = "Parameters".to_owned();
    if changed.rows.is_empty() {
        let text = vec!["Everything has its default value.".to_owned()];
        return Section { heading, text, tables: vec![table], ..Section::default() };
    }
    Section { heading, tables: vec![changed, table], ..Section::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_lines_keep_their_ends() {
        let points = [0.0, 0.1, 0.2, 1.0, 1.05, 2.0, 2.1].map(|x| Vec2::new(x, 0.0));
        let kept = thinned(&mut points.into_iter(), 0.5);
        assert_eq!(kept.iter().map(|p| p.x).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 2.1]);
        assert!(thinned(&mut std::iter::empty(), 0.5).is_empty());
    }

    #[test]
    fn errors_are_only_shown_when_there_are_any() {
        assert!(error_section(&Judgement::default()).is_none());
        let errors = Errors { n: 3, mean_m: 0.05, mean_rad: 0.01, ..Errors::default() };
        let judgement = Judgement { truth: Some([errors, errors]), ..Judgement::default() };
        let section = error_section(&judgement).unwrap();
        assert_eq!(section.tables[0].rows[0][..3], ["true poses", "3", "0.0500"]);
        assert_eq!(section.tables[0].rows[0][5], "0.573");
    }
}
