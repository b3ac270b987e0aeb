//! What the document claims, beside what was found.

use continuous_localisation::Maturity;
use figures::Section;

use super::{
    method::{Judged, Method, thesis},
    results::{Case, Results, mean},
    words::{metres, percent},
};
use crate::report;

const E1: Case = Case::drifting("E1");
const E2: Case = Case::drifting("E2");
const E3: Case = Case::drifting("E3");
const E4: Case = Case::drifting("E4");

/// The last section.
pub(super) fn comparison(results: &Results) -> Section {
    report::comparison([
        distorted(results),
        larger_search(results),
        empty_maps(results),
        prior(results),
        outline(results),
        doubled(results),
        far_readings(results),
    ])
}

fn verdict(holds: bool) -> &'static str {
    if holds { "holds" } else { "does not hold here" }
}

fn precision(judged: &Judged) -> f64 {
    judged.exposed.precision_ratio
}

fn distorted(results: &Results) -> [String; 3] {
    let of = |case| results.mean(case, Method::Odometry, precision);
    let ideal = |case| results.mean(case, Method::TruePoses, precision);
    let holds = [E1, E2].iter().all(|&case| of(case) < 0.8 * ideal(case));
    [
        "X1: with encoders only the maps are distorted".to_owned(),
        format!(
            "of the cells drawn as wall {} % (E1) and {} % (E2) are within a cell of one; at true poses {} % and {} %",
            percent(of(E1)),
            percent(of(E2)),
            percent(ideal(E1)),
            percent(ideal(E2))
        ),
        verdict(holds).to_owned(),
    ]
}

fn larger_search(results: &Results) -> [String; 3] {
    let errors = |case| [1, 3, 6].map(|degrees| results.rms_m(case, thesis(degrees)));
    let row = |case| {
        let [one, three, six] = errors(case).map(metres);
        format!(
            "{one}, {three}, {six} m (odometry {} m)",
            metres(results.rms_m(case, Method::Odometry))
        )
    };
    let is_best = |case| {
        let [one, three, six] = errors(case);
        three < one && three < six
    };
    let helps = [E1, E2].iter().all(|&case| results.ratio(case, thesis(3)) < 1.0);
    let effect = if helps {
        "the document's method is better than odometry in both worlds"
    } else {
        "the document's method is not better than odometry in both worlds, so there is little to choose from"
    };
    [
        "X2: ±1 cell and ±3° is best; ±1° is as good as no localisation, ±6° is worse and takes longer".to_owned(),
        format!("document's method at ±1°, ±3°, ±6°: E1 {}; E2 {}", row(E1), row(E2)),
        format!(
            "±3° is best in E1: {}, in E2: {}; {effect}. The times are in the table above",
            verdict(is_best(E1)),
            verdict(is_best(E2))
        ),
    ]
}

fn empty_maps(results: &Results) -> [String; 3] {
    let poor = |method| results.mean(E2, method, |j| j.n_poor as f64 / j.n_maps.max(1) as f64);
    let readings = Method::Thesis(3, Maturity::Readings(100));
    let scans = thesis(3);
    let ours = Method::Matured(Maturity::Readings(120));
    let by_way = Method::Matured(Maturity::Scans(50));
    let error = |method| results.rms_m(E2, method);
    [
        "X3: in open areas short-term maps are empty and match anywhere; maturity by readings cures it".to_owned(),
        format!(
            "with fewer than 12 readings are {} % of the maps of 20 scans, {} % of those of 100 readings; error {} m \
             and {} m with the document's method, {} m (50 scans) and {} m (120 readings) with ours, {} m by default",
            percent(poor(scans)),
            percent(poor(readings)),
            metres(error(scans)),
            metres(error(readings)),
            metres(error(by_way)),
            metres(error(ours)),
            metres(error(Method::Localised)),
        ),
        format!(
            "that no map is empty any more: {}; that the error becomes less: {} with the document's method, {} with ours",
            verdict(poor(readings) < poor(scans) || poor(scans) <= 0.0),
            verdict(error(readings) < error(scans)),
            verdict(error(ours) < error(by_way)),
        ),
    ]
}

fn prior(results: &Results) -> [String; 3] {
    let quarter = |case, k: usize| results.mean(case, Method::PriorMap, |j| j.quarters_m[k]);
    let odometry = |case| results.mean(case, Method::Odometry, |j| j.quarters_m[3]);
    // Constant: from the second quarter to the last it grows by less than a half.
    let is_constant = |case| quarter(case, 3) < 1.5 * quarter(case, 1);
    let row = |case| {
        format!(
            "{} m in the second quarter, {} m in the last (odometry {} m)",
            metres(quarter(case, 1)),
            metres(quarter(case, 3)),
            metres(odometry(case))
        )
    };
    [
        "X4: with a prior map the error of odometry is held at a constant level".to_owned(),
        format!("E1: {}; E2: {}", row(E1), row(E2)),
        format!("E1: {}; E2: {}", verdict(is_constant(E1)), verdict(is_constant(E2))),
    ]
}

fn outline(results: &Results) -> [String; 3] {
    let of = |method, value: fn(&Judged) -> f64| percent(results.mean(E3, method, value));
    let near = |method| results.mean(E3, method, |j| j.covered[1]);
    let all = results.mean(E3, Method::Localised, |j| j.covered[0]);
    [
        "V1: outline and areas well defined, surface fully covered".to_owned(),
        format!(
            "document's method: {} % of its wall cells are right, {} % of the floor near the way is known; \
             Cairn's default: {} % and {} %, of the whole floor {} %",
            of(thesis(3), precision),
            of(thesis(3), |j| j.covered[1]),
            of(Method::Localised, precision),
            of(Method::Localised, |j| j.covered[1]),
            percent(all)
        ),
        format!(
            "near the way at least 90 % covered: {} with the document's method, {} with ours; the open part is out of the \
             sonars' reach",
            verdict(near(thesis(3)) >= 0.9),
            verdict(near(Method::Localised) >= 0.9)
        ),
    ]
}

fn doubled(results: &Results) -> [String; 3] {
    let at_half = |method, of: fn(&Judged) -> f64| mean(&results.at_half_speed(E3, method), of);
    let recall = |j: &Judged| j.exposed.recall_ratio;
    let row = |method| {
        format!(
            "precision {} → {} %, recall {} → {} %",
            percent(results.mean(E3, method, precision)),
            percent(at_half(method, precision)),
            percent(results.mean(E3, method, recall)),
            percent(at_half(method, recall))
        )
    };
    let better = |method| {
        at_half(method, precision) > results.mean(E3, method, precision)
            && at_half(method, recall) > results.mean(E3, method, recall)
    };
    [
        "V1b: twice the readings define the outline better; the price is speed".to_owned(),
        format!(
            "half the speed: document's method {}; Cairn's default {}",
            row(thesis(3)),
            row(Method::Localised)
        ),
        format!(
            "both figures better: {} with the document's method, {} with ours",
            verdict(better(thesis(3))),
            verdict(better(Method::Localised))
        ),
    ]
}

fn far_readings(results: &Results) -> [String; 3] {
    let part = |method, k: usize| {
        results.mean(E4, method, |j| j.parts.get(k).copied().unwrap_or(f64::NAN))
    };
    let band = |method, k: usize| {
        let known: Vec<f64> = results.of(E4, method).iter().filter_map(|j| j.bands[k]).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    let row = |method| {
        format!(
            "walls found in left arm, hall, right arm: {}, {}, {} %; right among those drawn within 1 m of the way {} %, \
             beyond 2 m {} %",
            percent(part(method, 0)),
            percent(part(method, 1)),
            percent(part(method, 2)),
            percent(band(method, 0)),
            percent(band(method, 2))
        )
    };
    let is_weak = |method| part(method, 2) < 0.5 * part(method, 0).min(part(method, 1));
    let fades = |method| band(method, 2) < band(method, 0);
    let ideal = [0, 2].map(|k| percent(band(Method::TruePoses, k)));
    [
        "V2: distant readings are weighted badly, and the arm that was not visited is poorly drawn"
            .to_owned(),
        format!(
            "document's method: {}; Cairn's default: {}",
            row(thesis(3)),
            row(Method::Localised)
        ),
        format!(
            "unvisited arm poor: {}, {}; distant cells less often right: {}, {} (document's method, ours); at true poses {} % \
             and {} % are right, near and far",
            verdict(is_weak(thesis(3))),
            verdict(is_weak(Method::Localised)),
            verdict(fades(thesis(3))),
            verdict(fades(Method::Localised)),
            ideal[0],
            ideal[1]
        ),
    ]
}
