//! The report's tables and figures.

use figures::{Axes, Figure, Floor, Line, Section, Table};

use super::{
    method::{Judged, Method, thesis},
    results::{Case, Results, mean},
    task::Timing,
    words::{metres, number, percent},
};
use crate::ExperimentError;
use continuous_localisation::Maturity;

/// The goal with drift and without: part of odometry's error that may be left.
const GOALS_RATIO: [f64; 2] = [0.15, 1.10];
const NAMES: [&str; 4] = ["E1", "E2", "E3", "E4"];

fn titled(heading: &str, text: &[&str], tables: Vec<Table>) -> Section {
    Section {
        heading: heading.to_owned(),
        text: text.iter().map(|&paragraph| paragraph.to_owned()).collect(),
        tables,
        figures: Vec::new(),
    }
}

/// Position errors against the goals.
pub(super) fn targets(results: &Results) -> Section {
    let mut table = Table::new(
        "Position error, RMS over a drive, mean over the runs; the goal is 15 % of odometry's with drift and \
         110 % without",
        &[
            "world",
            "sonars",
            "drift (°/m)",
            "way (m)",
            "odometry (m)",
            "localised (m)",
            "of odometry's (%)",
            "worst run (%)",
            "runs within the goal",
            "document's method (m)",
        ],
    );
    for case in results.cases() {
        let ratios = results.ratios(case, Method::Localised);
        let goal = GOALS_RATIO[usize::from(!case.drifts)];
        let n_within = ratios.iter().filter(|&&ratio| ratio <= goal).count();
        let (odometry_m, found_m) =
            (results.rms_m(case, Method::Odometry), results.rms_m(case, Method::Localised));
        let mut row = case.cells().to_vec();
        row.extend([
            number(results.room(case).map_or(f64::NAN, |room| room.way_m), 1),
            metres(odometry_m),
            metres(found_m),
            percent(results.ratio(case, Method::Localised)),
            percent(ratios.iter().copied().fold(f64::NAN, f64::max)),
            format!("{n_within} of {}", ratios.len()),
            metres(results.rms_m(case, thesis(3))),
        ]);
        table.rows.push(row);
    }
    titled(
        "Where is the robot",
        &[
            "The pose is that of the moment, as the robot itself would use it, not one that was smoothed \
           afterwards. The document's method is ±1 cell and ±3° with its equation (18) over common cells.",
        ],
        vec![table],
    )
}

/// Maps against the truth.
pub(super) fn maps(results: &Results) -> Section {
    let mut table = Table::new(
        "Walls within one cell of 35 mm, and entropy; the goals are precision 0.9 and recall 0.85",
        &[
            "world",
            "sonars",
            "drift (°/m)",
            "map",
            "precision",
            "recall of what is in sight",
            "recall of what is met squarely",
            "IoU (met squarely)",
            "entropy (bits a cell)",
        ],
    );
    for case in results.cases() {
        let methods =
            [Method::Odometry, thesis(3), Method::Localised, Method::SecondLook, Method::TruePoses];
        for method in methods {
            let judged = results.of(case, method);
            if judged.is_empty() {
                continue;
            }
            let of = |value: fn(&Judged) -> f64| number(mean(&judged, value), 3);
            let mut row = case.cells().to_vec();
            row.extend([
                method.label(),
                of(|j| j.exposed.precision_ratio),
                of(|j| j.exposed.recall_ratio),
                of(|j| j.heard.recall_ratio),
                of(|j| j.heard.iou_ratio),
                of(|j| j.entropy_bits),
            ]);
            table.rows.push(row);
        }
    }
    titled(
        "What the maps are worth",
        &[
            "In sight: a straight line from the way, within the sonars' range. Met squarely: within 3 m of a \
           sonar, in its cone, and struck within 15° of the normal, at some moment of the drive. The second look \
           maps the same recording again with the drift that the first found. At true poses, odometry is replaced \
           by the truth and nothing has to be localised: what is missing there is the sensor's doing, or the \
           drawing's. Precision is always against all walls.",
        ],
        vec![table],
    )
}

/// Why a goal is missed: what the sensor cannot tell.
pub(super) fn limits(results: &Results) -> Section {
    let mut sight = Table::new(
        "What the sonars can know of the walls",
        &[
            "world",
            "sonars",
            "wall cells in sight",
            "met squarely",
            "share (%)",
            "precision at true poses",
            "recall of what is in sight, at true poses",
        ],
    );
    let mut direction = Table::new(
        "Where the position error points, RMS, mean over the runs",
        &[
            "world",
            "sonars",
            "drift (°/m)",
            "odometry: along (m)",
            "across (m)",
            "localised: along (m)",
            "across (m)",
            "heading (°)",
        ],
    );
    for case in results.cases() {
        let Some(room) = results.room(case) else { continue };
        let [name, sonars, drift] = case.cells();
        let of = |method, value: fn(&Judged) -> f64| metres(results.mean(case, method, value));
        direction.rows.push(vec![
            name.clone(),
            sonars.clone(),
            drift,
            of(Method::Odometry, |j| j.along_m),
            of(Method::Odometry, |j| j.across_m),
            of(Method::Localised, |j| j.along_m),
            of(Method::Localised, |j| j.across_m),
            number(results.mean(case, Method::Localised, |j| j.heading_rad.to_degrees()), 2),
        ]);
        // What can be heard does not depend on odometry.
        if !case.drifts {
            continue;
        }
        let (n_seen, n_heard) = (room.truth.exposed.len(), room.truth.heard.len());
        let ideal = |of: fn(&Judged) -> f64| number(results.mean(case, Method::TruePoses, of), 3);
        sight.rows.push(vec![
            name,
            sonars,
            n_seen.to_string(),
            n_heard.to_string(),
            percent(n_heard as f64 / n_seen.max(1) as f64),
            ideal(|j| j.exposed.precision_ratio),
            ideal(|j| j.exposed.recall_ratio),
        ]);
    }
    titled(
        "What the sensor makes impossible",
        &[
            "A wall that no cone ever met squarely can only be marked by luck: its echo comes from a corner, from the \
           cone's edge, or not at all. Along is the direction in which the robot drives at that moment: between two \
           long walls nothing but doors and furniture says how far along it is.",
        ],
        vec![sight, direction],
    )
}

fn figure(name: String, caption: String, svg: String) -> Figure {
    Figure { name, caption, svg }
}

/// One drive through each world, and how the error grows in it.
pub(super) fn drives(results: &Results) -> Result<Section, ExperimentError> {
    let mut section = titled(
        "One drive through each world",
        &["The first run of each world with five sonars and a drift of 1° per metre to the left."],
        Vec::new(),
    );
    for name in NAMES {
        let case = Case::drifting(name);
        let kept = |method| results.kept(case, method);
        let (Some(odometry), Some(ours)) = (kept(Method::Odometry), kept(Method::Localised)) else {
            continue;
        };
        let floor = Floor {
            picture: ours.picture.clone(),
            driven: vec![
                ("true".to_owned(), ours.truth.clone()),
                ("odometry".to_owned(), odometry.line.clone()),
                ("localised".to_owned(), ours.line.clone()),
            ],
            ..Floor::default()
        };
        let short = name.to_lowercase();
        section.figures.push(figure(
            format!("drive-{short}"),
            format!(
                "{name}: the way over the map that was built while driving; x is the direction in which \
                 the robot started."
            ),
            figures::floor(&floor)?,
        ));
        let lines: Vec<Line> = [Method::Odometry, Method::Localised, thesis(3)]
            .into_iter()
            .filter_map(|method| Some(line(method.label(), &kept(method)?.errors)))
            .collect();
        section.figures.push(figure(
            format!("error-{short}"),
            format!("{name}: position error over the same drive."),
            figures::lines(Axes { x: "time (s)", y: "error (m)" }, &lines)?,
        ));
    }
    Ok(section)
}

fn line(name: String, points: &[(f64, f64)]) -> Line {
    Line { name, points: points.to_vec(), ..Line::default() }
}

/// X1: maps of odometry alone.
pub(super) fn odometry_alone(results: &Results) -> Section {
    let mut table = Table::new(
        "Maps of odometry alone, five sonars",
        &["world", "drift (°/m)", "precision", "recall of what is in sight", "position error (m)"],
    );
    for name in ["E1", "E2"] {
        for case in [Case::straight(name), Case::drifting(name)] {
            let [name, _, drift] = case.cells();
            let of =
                |value: fn(&Judged) -> f64| number(results.mean(case, Method::Odometry, value), 3);
            table.rows.push(vec![
                name,
                drift,
                of(|j| j.exposed.precision_ratio),
                of(|j| j.exposed.recall_ratio),
                of(|j| j.rms_m),
            ]);
        }
    }
    titled(
        "X1: encoders only",
        &["The document shows these maps as distorted (Fig. 34, lost)."],
        vec![table],
    )
}

/// X2: search spaces.
pub(super) fn search_spaces(results: &Results) -> Result<Section, ExperimentError> {
    let mut table = Table::new(
        "Position error by search space, RMS, mean over the runs; five sonars, ±1 cell of 35 mm",
        &[
            "world",
            "method",
            "candidates",
            "runs",
            "with drift (m)",
            "of odometry's (%)",
            "without drift (m)",
            "of odometry's (%)",
            "precision with drift",
            "maps that moved the robot (%)",
        ],
    );
    for name in ["E1", "E2"] {
        for method in search_methods() {
            table.rows.push(search_row(results, name, method));
        }
    }
    let mut section = titled(
        "X2: search spaces",
        &[
            "The document tries ±1°, ±3° and ±6° with ±1 cell: 27, 63 and 117 candidates. Its method is tried with its \
           equation (18) over common cells and, for ±3°, with the score that its program computes over the whole \
           window, and with ours. Evidence is Cairn's method on grids alone, over the same candidates: it corrects \
           only where a minimum is distinct. Localised is Cairn's default, which also knows walls.",
        ],
        vec![table],
    );
    for name in ["E1", "E2"] {
        let case = Case::drifting(name);
        let points = |of: &dyn Fn(usize) -> Method| {
            [1, 3, 6].map(|degrees| (degrees as f64, results.rms_m(case, of(degrees)))).to_vec()
        };
        let flat = |method| {
            let error_m = results.rms_m(case, method);
            vec![(1.0, error_m), (6.0, error_m)]
        };
        let lines = [
            line("document".to_owned(), &points(&|d| thesis(d as u32))),
            line("evidence".to_owned(), &points(&Method::Grids)),
            line("localised".to_owned(), &flat(Method::Localised)),
            line("odometry".to_owned(), &flat(Method::Odometry)),
        ];
        section.figures.push(figure(
            format!("search-{}", name.to_lowercase()),
            format!("{name}: position error against the search space, with drift."),
            figures::lines(Axes { x: "headings tried to each side (°)", y: "error (m)" }, &lines)?,
        ));
    }
    Ok(section)
}

fn search_methods() -> [(Method, &'static str); 10] {
    [
        (Method::Odometry, "0"),
        (thesis(1), "27"),
        (thesis(3), "63"),
        (thesis(6), "117"),
        (Method::Program, "63"),
        (Method::Evidence, "63"),
        (Method::Grids(1), "27"),
        (Method::Grids(3), "63"),
        (Method::Grids(6), "117"),
        (Method::Localised, "125 + 63"),
    ]
}

fn search_row(
    results: &Results,
    name: &'static str,
    (method, candidates): (Method, &str),
) -> Vec<String> {
    let (with, without) = (Case::drifting(name), Case::straight(name));
    let of_odometry = |case| percent(results.ratio(case, method));
    let moved = results.mean(with, method, |j| j.n_moved as f64 / j.n_maps.max(1) as f64);
    vec![
        name.to_owned(),
        method.label(),
        candidates.to_owned(),
        results.of(with, method).len().to_string(),
        metres(results.rms_m(with, method)),
        of_odometry(with),
        metres(results.rms_m(without, method)),
        of_odometry(without),
        number(results.mean(with, method, |j| j.exposed.precision_ratio), 3),
        percent(moved),
    ]
}

/// X3: when a short-term map is mature, where there is nothing to hear.
pub(super) fn open_area(results: &Results) -> Section {
    let mut table = Table::new(
        "E2 with drift, five sonars: short-term maps until they have enough",
        &[
            "method",
            "short-term maps in a drive",
            "with fewer than 12 readings (%)",
            "position error (m)",
            "of odometry's (%)",
            "precision",
        ],
    );
    let case = Case::drifting("E2");
    let of_document = [
        Maturity::Readings(45),
        Maturity::Readings(100),
        Maturity::Scans(20),
        Maturity::Seconds(5.0),
    ]
    .map(|maturity| Method::Thesis(3, maturity));
    let ours = [
        Maturity::Readings(120),
        Maturity::Scans(50),
        Maturity::Seconds(12.5),
        Maturity::Distance(1.0),
    ]
    .map(Method::Matured);
    for method in of_document.into_iter().chain(ours).chain([Method::Localised]) {
        let poor = results.mean(case, method, |j| j.n_poor as f64 / j.n_maps.max(1) as f64);
        let error_m = results.rms_m(case, method);
        table.rows.push(vec![
            method.label(),
            number(results.mean(case, method, |j| j.n_maps as f64), 1),
            percent(poor),
            metres(error_m),
            percent(results.ratio(case, method)),
            number(results.mean(case, method, |j| j.exposed.precision_ratio), 3),
        ]);
    }
    titled(
        "X3: the open area",
        &[
            "Where nothing is within range, a short-term map that ends after so many scans or seconds is empty and fits \
           anywhere. One that waits for readings lives on until it has some. Localised, Cairn's default, ends after a \
           metre with at least 12 echoes, or after two metres; the settings called ours are the same without that.",
        ],
        vec![table],
    )
}

/// X4: a map from an earlier visit.
pub(super) fn prior_map(results: &Results) -> Result<Section, ExperimentError> {
    let mut table = Table::new(
        "Position error in the four quarters of the drive, RMS, mean over the runs; drift of 1°/m, five sonars",
        &["world", "method", "first (m)", "second (m)", "third (m)", "fourth (m)"],
    );
    let mut figures = Vec::new();
    let methods = [Method::Odometry, Method::Localised, Method::PriorMap];
    for name in ["E1", "E2"] {
        let case = Case::drifting(name);
        for method in methods {
            let mut row = vec![name.to_owned(), method.label()];
            row.extend((0..4).map(|k| metres(results.mean(case, method, |j| j.quarters_m[k]))));
            table.rows.push(row);
        }
        let lines: Vec<Line> = [Method::Localised, Method::PriorMap]
            .into_iter()
            .filter_map(|method| Some(line(method.label(), &results.kept(case, method)?.errors)))
            .collect();
        figures.push(figure(
            format!("prior-{}", name.to_lowercase()),
            format!("{name}: position error over the first drive, without and with a prior map."),
            figures::lines(Axes { x: "time (s)", y: "error (m)" }, &lines)?,
        ));
    }
    let text =
        ["The prior map and its walls were drawn in another drive of the same way, at true poses."];
    Ok(Section { figures, ..titled("X4: a prior map", &text, vec![table]) })
}

/// V1 and V1b: two joined areas, and twice the readings.
pub(super) fn joined_areas(results: &Results) -> Section {
    let mut table = Table::new(
        "E3, drift of 1°/m, five sonars",
        &[
            "method",
            "readings",
            "precision",
            "recall of what is in sight",
            "floor known to be free (%)",
            "of the floor near the way (%)",
            "position error (m)",
        ],
    );
    let case = Case::drifting("E3");
    let doubled = [thesis(3), Method::Localised, Method::SecondLook];
    let mut push = |method: Method, readings: &str, judged: &[&Judged]| {
        let of = |digits, value: fn(&Judged) -> f64| number(mean(judged, value), digits);
        table.rows.push(vec![
            method.label(),
            readings.to_owned(),
            of(3, |j| j.exposed.precision_ratio),
            of(3, |j| j.exposed.recall_ratio),
            of(1, |j| 100.0 * j.covered[0]),
            of(1, |j| 100.0 * j.covered[1]),
            of(3, |j| j.rms_m),
        ]);
    };
    for method in doubled {
        push(method, "as given", &results.of(case, method));
    }
    for method in doubled {
        push(method, "twice as many on the way", &results.at_half_speed(case, method));
    }
    for method in [Method::Thesis(3, Maturity::Scans(40)), Method::Matured(Maturity::Distance(2.0))]
    {
        push(method, "twice as many in a short-term map", &results.of(case, method));
    }
    titled(
        "V1 and V1b: two joined areas, and twice the readings",
        &[
            "Twice as many readings can mean two things. On the way: the robot drives at 40 instead of 80 mm/s, which is \
           the price the document names. In a short-term map: it matures later. Near the way is within 2 m, in line of \
           sight; part of the second area is farther away than the sonars reach.",
        ],
        vec![table],
    )
}

/// V2: the corridor.
pub(super) fn corridor(results: &Results) -> Section {
    let case = Case::drifting("E4");
    let mut parts = Table::new(
        "E4, drift of 1°/m, five sonars: recall of the three arms' walls, all of them; the right arm is looked into \
         from the hall only",
        &["method", "left arm", "hall", "right arm"],
    );
    let mut bands = Table::new(
        "Precision of the walls drawn, by distance from the way",
        &["method", "up to 1 m", "1 to 2 m", "farther than 2 m"],
    );
    for method in [thesis(3), Method::Localised, Method::SecondLook, Method::TruePoses] {
        let mut row = vec![method.label()];
        row.extend((0..3).map(|k| {
            number(results.mean(case, method, |j| j.parts.get(k).copied().unwrap_or(f64::NAN)), 3)
        }));
        parts.rows.push(row);
        let mut row = vec![method.label()];
        row.extend((0..3).map(|k| {
            let known: Vec<f64> =
                results.of(case, method).iter().filter_map(|j| j.bands[k]).collect();
            number(known.iter().sum::<f64>() / known.len() as f64, 3)
        }));
        bands.rows.push(row);
    }
    titled(
        "V2: the corridor",
        &[
            "The robot drives through the left arm and the hall, 14.8 m and 26.6 m, and only looks into the right arm.",
        ],
        vec![parts, bands],
    )
}

/// What mapping takes.
pub(super) fn times(times: &[Timing]) -> Section {
    let mut table = Table::new(
        "The first drive of E1, one thread, least of three; the only figures here that differ from run to run",
        &["method", "time (ms)", "for each short-term map (ms)", "times faster than the drive"],
    );
    for Timing { label, took_s, drive_s, n_maps } in times {
        table.rows.push(vec![
            label.clone(),
            number(1e3 * took_s, 0),
            number(1e3 * took_s / *n_maps as f64, 2),
            number(drive_s / took_s, 0),
        ]);
    }
    titled(TIMES_HEADING, &[], vec![table])
}

/// The heading of the section of computing times.
pub(super) const TIMES_HEADING: &str = "Computing time";
