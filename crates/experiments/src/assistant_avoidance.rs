//! Experiment 7.5 of the thesis: obstacles that the bubble rebound misses, against speed.
//!
//! An obstacle counts as missed when the robot touches it. The thesis: practically none at 0.3 m/s, even in
//! a corridor with people; 5 to 10 % at 0.5 m/s, because of systematic sonar errors. It states neither what
//! its obstacles were made of nor how hard its robot braked; both are factors here.

use std::f64::consts::TAU;

use figures::{Axes, Floor, Line};
use geometry::{Se2, Vec2};
use missions::{Mission, MissionError};
use run_context::RandomStream;

use crate::{
    ExperimentError, Figure, Options, Progress, Report, Section, Table,
    batch::{Outcome, run_all, uniform},
    report,
    statistics::{Proportion, median},
};

const OBSTACLE: &str = include_str!("obstacle.toml");

/// Speeds swept, m/s.
const SPEEDS_MPS: [f64; 7] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7];
/// Materials that send sound back from most angles; drawn with equal chances.
const ROUGH: [&str; 3] = ["cardboard", "wood", "plaster"];
/// Materials that send it elsewhere unless met nearly at a right angle.
const SMOOTH: [&str; 2] = ["metal", "glass"];
/// What braking and speeding up is like when it is quicker than the factory setting, m/s².
const QUICK_MPS2: f64 = 1.0;

/// How obstacles are avoided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Avoider {
    /// As the thesis has it: bubble, rebound, detour, no waiting; accelerates with 0.3 m/s².
    Thesis,
    /// The same with wheels that brake and speed up more quickly.
    ThesisQuick,
    /// Cairn's default: the same machine, checked against remembered echoes; 0.3 m/s².
    Checked,
}

impl Avoider {
    const ALL: [Self; 3] = [Self::Thesis, Self::ThesisQuick, Self::Checked];

    fn name(self) -> &'static str {
        match self {
            Self::Thesis => "as in the thesis",
            Self::ThesisQuick => "the same, braking with 1 m/s²",
            Self::Checked => "checked (default)",
        }
    }

    fn overrides(self) -> Vec<String> {
        let thesis = ["guard.method=rebound", "guard.aims_again=detour", "guard.wait_s=0"];
        let mut settings: Vec<String> = match self {
            Self::Thesis | Self::ThesisQuick => thesis.map(str::to_owned).to_vec(),
            Self::Checked => Vec::new(),
        };
        if self == Self::ThesisQuick {
            settings.push(format!("follow.acceleration_mps2={QUICK_MPS2}"));
        }
        settings.iter().map(|setting| format!("robots.mind.{setting}")).collect()
    }
}

/// What stands or walks in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hindrance {
    RoughBox,
    SmoothBox,
    Person,
}

impl Hindrance {
    const ALL: [Self; 3] = [Self::RoughBox, Self::SmoothBox, Self::Person];
}

#[derive(Clone, Copy, Debug)]
struct Setting {
    speed_mps: f64,
    avoider: Avoider,
    hindrance: Hindrance,
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Report, ExperimentError> {
    let own_speeds = !options.sweep.speeds_mps.is_empty();
    let speeds_mps = if own_speeds { &options.sweep.speeds_mps[..] } else { &SPEEDS_MPS };
    let settings = settings(speeds_mps);
    let outcomes = run_all(settings.len(), &|i, rng| mission(settings[i], rng), options, progress)?;
    let of = |hindrance, avoider| {
        settings
            .iter()
            .zip(&outcomes)
            .filter(move |(s, _)| s.hindrance == hindrance && s.avoider == avoider)
            .map(|(s, runs)| (s.speed_mps, runs.as_slice()))
            .collect::<Vec<_>>()
    };
    let mut sections = vec![
        hindrance_section("A rough box in the way", "rough", of, Hindrance::RoughBox)?,
        hindrance_section("A smooth box in the way", "smooth", of, Hindrance::SmoothBox)?,
        hindrance_section("A person who crosses", "person", of, Hindrance::Person)?,
    ];
    if !own_speeds {
        // What the thesis reports is at its own speeds.
        sections.extend([examples(of)?, comparison(of)]);
    }
    Ok(Report {
        title: "Obstacles missed against speed (the thesis, 7.5)".to_owned(),
        preamble: format!(
            "{} runs per setting, seeds {} to {}, each through the whole closed loop. A drive of 7 m along \
             a straight line by fuzzy control; eight front sonars, one fired every 40 ms. The box has sides \
             of 0.25 to 0.6 m, any orientation, and stands up to 0.25 m beside the line. It is made of {}, or \
             of {}. A run counts as a miss when anything was touched. Intervals are 95 % (Wilson).",
            options.n_runs,
            options.seed.0,
            options.seed.0 + u64::from(options.n_runs) - 1,
            ROUGH.join(", "),
            SMOOTH.join(" or ")
        ),
        sections,
    })
}

fn settings(speeds_mps: &[f64]) -> Vec<Setting> {
    let mut settings = Vec::new();
    for hindrance in Hindrance::ALL {
        for avoider in Avoider::ALL {
            let of = |&speed_mps: &f64| Setting { speed_mps, avoider, hindrance };
            settings.extend(speeds_mps.iter().map(of));
        }
    }
    settings
}

fn mission(setting: Setting, rng: &mut RandomStream) -> Result<Mission, MissionError> {
    let Setting { speed_mps, avoider, hindrance } = setting;
    let mut overrides = avoider.overrides();
    overrides.push(format!("robots.mind.follow.speed_mps={speed_mps}"));
    // 7 m, waiting and detours included, at a quarter of the speed at worst.
    overrides.push(format!("mission.duration_max_s={}", 60.0 + 28.0 / speed_mps));
    let text = match hindrance {
        Hindrance::RoughBox => box_text(rng, &ROUGH),
        Hindrance::SmoothBox => box_text(rng, &SMOOTH),
        Hindrance::Person => person_text(rng, speed_mps),
    };
    Mission::parse("obstacle.toml", &format!("{OBSTACLE}\n{text}"), &overrides)
}

fn box_text(rng: &mut RandomStream, materials: &[&str]) -> String {
    let (length_m, width_m) = (uniform(rng, 0.25, 0.6), uniform(rng, 0.25, 0.6));
    let (x_m, y_m) = (uniform(rng, 2.8, 4.2), uniform(rng, -0.25, 0.25));
    let yaw_deg = uniform(rng, 0.0, 360.0);
    let material = materials[uniform(rng, 0.0, materials.len() as f64) as usize];
    format!(
        "[[world.things]]\nname = \"obstacle\"\nkind = \"box\"\nmaterial = \"{material}\"\n\
         at_m = [{x_m}, {y_m}]\nyaw_deg = {yaw_deg}\nsize_m = [{length_m}, {width_m}]\n"
    )
}

/// A person who crosses the line about when the robot comes by.
fn person_text(rng: &mut RandomStream, robot_mps: f64) -> String {
    let x_m = uniform(rng, 2.5, 4.5);
    let slant_m = uniform(rng, -1.0, 1.0);
    let side = if uniform(rng, -1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
    let person_mps = uniform(rng, 0.3, 1.0);
    let (from_m, to_m) = (2.3 * side, -2.3 * side);
    // Both reach the crossing within 1.5 s of each other.
    let meeting_s = 2.0 + x_m / robot_mps + uniform(rng, -1.5, 1.5);
    let starts_at_s = (meeting_s - 2.3 / person_mps).max(0.0);
    format!(
        "[[world.people]]\nname = \"person\"\nroute_m = [[{}, {from_m}], [{}, {to_m}]]\n\
         speed_mps = {person_mps}\nstarts_at_s = {starts_at_s}\n",
        x_m - slant_m,
        x_m + slant_m
    )
}

type Sweep<'a> = Vec<(f64, &'a [Outcome])>;

fn touched(runs: &[Outcome]) -> Proportion {
    Proportion { n_hits: runs.iter().filter(|run| run.touched()).count(), n_trials: runs.len() }
}

fn percent(proportion: Proportion) -> String {
    let [low, high] = proportion.interval_95().map(|p| 100.0 * p);
    let p = proportion.ratio().map_or(0.0, |p| 100.0 * p);
    format!("{p:.1} ({low:.1} to {high:.1})")
}

fn hindrance_section<'a>(
    heading: &str,
    name: &str,
    of: impl Fn(Hindrance, Avoider) -> Sweep<'a>,
    hindrance: Hindrance,
) -> Result<Section, ExperimentError> {
    let mut table = Table::new(
        "Runs with contact, arrivals, and the time of those that arrived (median)",
        &["avoidance", "v (m/s)", "touched (%)", "arrived", "arrived untouched", "time (s)"],
    );
    let mut lines = Vec::new();
    for avoider in Avoider::ALL {
        let sweep = of(hindrance, avoider);
        for &(speed_mps, runs) in &sweep {
            let count = |wanted: &dyn Fn(&Outcome) -> bool| {
                format!("{} of {}", runs.iter().filter(|run| wanted(run)).count(), runs.len())
            };
            let times: Vec<f64> = runs
                .iter()
                .filter(|run| run.arrived())
                .filter_map(|run| run.summary.figure("drive_time_s"))
                .collect();
            table.rows.push(vec![
                avoider.name().to_owned(),
                format!("{speed_mps:.1}"),
                percent(touched(runs)),
                count(&Outcome::arrived),
                count(&Outcome::passed),
                median(&times).map_or_else(|| "–".to_owned(), |t| format!("{t:.1}")),
            ]);
        }
        let ratio = |runs| 100.0 * touched(runs).ratio().unwrap_or(0.0);
        lines.push(Line {
            name: avoider.name().to_owned(),
            points: sweep.iter().map(|&(v, runs)| (v, ratio(runs))).collect(),
            bars: sweep.iter().map(|(_, r)| touched(r).interval_95().map(|p| 100.0 * p)).collect(),
            ..Line::default()
        });
    }
    let axes = Axes { x: "speed (m/s)", y: "runs with contact (%)" };
    Ok(Section {
        heading: heading.to_owned(),
        text: Vec::new(),
        tables: vec![table],
        figures: vec![Figure {
            name: format!("missed-{name}"),
            caption: "Runs in which something was touched, with 95 % intervals.".to_owned(),
            svg: figures::lines(axes, &lines)?,
        }],
    })
}

/// Where the first runs at 0.3 m/s with a box went.
fn examples<'a>(of: impl Fn(Hindrance, Avoider) -> Sweep<'a>) -> Result<Section, ExperimentError> {
    let index = SPEEDS_MPS.iter().position(|v| v.total_cmp(&0.3).is_eq()).unwrap_or(0);
    let first = |avoider: Avoider| {
        of(Hindrance::RoughBox, avoider).get(index).and_then(|(_, runs)| runs.first().cloned())
    };
    let runs: Vec<(Avoider, Outcome)> =
        Avoider::ALL.into_iter().filter_map(|avoider| Some((avoider, first(avoider)?))).collect();
    let floor = Floor {
        // Run j meets the same obstacle with every method.
        outlines: runs.first().map(|(_, run)| first_box(run)).into_iter().collect(),
        trail_name: "the straight way",
        trail: vec![Vec2::new(0.0, 0.0), Vec2::new(7.0, 0.0)],
        driven: runs.iter().map(|(a, run)| (a.name().to_owned(), run.line_m())).collect(),
        ..Floor::default()
    };
    Ok(Section {
        heading: "One obstacle".to_owned(),
        text: Vec::new(),
        tables: Vec::new(),
        figures: vec![Figure {
            name: "example".to_owned(),
            caption:
                "The first run at 0.3 m/s (Fig. 7.11); the lines are those of the robot's axle."
                    .to_owned(),
            svg: figures::floor(&floor)?,
        }],
    })
}

/// The outline of the obstacle of a run, drawn again from the run's seed.
fn first_box(run: &Outcome) -> Vec<Vec2> {
    let mut rng = run_context::RunSeed(run.summary.seed).stream("experiment/situation");
    let text = format!("{OBSTACLE}\n{}", box_text(&mut rng, &ROUGH));
    let mission = Mission::parse("obstacle.toml", &text, &[]).ok();
    let things = mission.map(|mission| mission.file().world.things.clone()).unwrap_or_default();
    let Some(thing) = things.first() else { return Vec::new() };
    let map_from_thing =
        Se2::new(thing.at_m[0], thing.at_m[1], thing.yaw_deg.to_radians().rem_euclid(TAU));
    let [half_x, half_y] = thing.size_m.map(|side| side / 2.0);
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(sx, sy)| map_from_thing.transform_point(Vec2::new(sx * half_x, sy * half_y)))
        .to_vec()
}

fn comparison<'a>(of: impl Fn(Hindrance, Avoider) -> Sweep<'a>) -> Section {
    let at = |hindrance, avoider, index: usize| {
        of(hindrance, avoider)
            .get(index)
            .map_or_else(String::new, |(_, runs)| percent(touched(runs)))
    };
    let all = |hindrance, index| {
        format!(
            "{} % as in the thesis; {} % braking with 1 m/s²; {} % with the default",
            at(hindrance, Avoider::Thesis, index),
            at(hindrance, Avoider::ThesisQuick, index),
            at(hindrance, Avoider::Checked, index)
        )
    };
    let rows = [
        [
            "0.3 m/s: undetected obstacles practically zero".to_owned(),
            format!("rough boxes: {}", all(Hindrance::RoughBox, 2)),
            "boxes that send sound back are met as reported; no sonar sees a mirror".to_owned(),
        ],
        [
            "0.5 m/s: 5 to 10 % missed, by systematic sonar errors".to_owned(),
            format!(
                "rough boxes: {}. Smooth boxes: {}",
                all(Hindrance::RoughBox, 4),
                all(Hindrance::SmoothBox, 4)
            ),
            "the share depends on how many obstacles are smooth, and on how hard the robot brakes; the \
             thesis states neither"
                .to_owned(),
        ],
        [
            "0.3 m/s: fine in a corridor with people".to_owned(),
            all(Hindrance::Person, 2),
            "our people wait when a robot is close ahead of them, but do not step aside".to_owned(),
        ],
    ];
    report::comparison(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use run_context::RunSeed;

    fn n_touched(settings: &[Setting], n_runs: u32) -> Vec<usize> {
        let options = Options { n_runs, seed: RunSeed(21), ..Options::default() };
        let make = |i: usize, rng: &mut RandomStream| mission(settings[i], rng);
        let outcomes = run_all(settings.len(), &make, &options, &|_, _| ()).unwrap();
        outcomes.iter().map(|runs| touched(runs).n_hits).collect()
    }

    /// R5 and AT15: at 0.3 m/s nothing that sends echoes back is touched. With a true share of 20 %, 20
    /// clean runs would have a chance of 0.8²⁰, about 1 %.
    #[test]
    fn rough_boxes_and_people_are_met_at_the_speed_of_the_thesis() {
        let setting = |hindrance| Setting { speed_mps: 0.3, avoider: Avoider::Thesis, hindrance };
        let settings = [setting(Hindrance::RoughBox), setting(Hindrance::Person)];
        let found = n_touched(&settings, 20);
        assert!(found.iter().all(|&n| n <= 1), "{found:?}");
    }

    /// R6: what is missed is what sends no echo back.
    #[test]
    fn smooth_boxes_are_missed_more_often_than_rough_ones() {
        let setting =
            |hindrance| Setting { speed_mps: 0.3, avoider: Avoider::ThesisQuick, hindrance };
        let settings = [setting(Hindrance::RoughBox), setting(Hindrance::SmoothBox)];
        let found = n_touched(&settings, 20);
        assert!(found[1] > found[0] + 2, "{found:?}");
    }

    /// The guide: with quicker brakes the printed avoider touches fewer rough boxes at speed, and both more than at
    /// 0.3 m/s.
    #[test]
    fn rough_boxes_are_touched_more_at_speed_and_less_with_quicker_brakes() {
        let at =
            |speed_mps, avoider| Setting { speed_mps, avoider, hindrance: Hindrance::RoughBox };
        let settings =
            [at(0.3, Avoider::Thesis), at(0.7, Avoider::Thesis), at(0.7, Avoider::ThesisQuick)];
        let found = n_touched(&settings, 60);
        assert!(found[0] < found[2] && found[2] < found[1], "{found:?}");
    }

    /// The guide: nobody who crosses is touched at 0.3 m/s by any avoider; at 0.7 m/s quick brakes are what helps.
    #[test]
    fn who_crosses_is_safe_at_the_speed_of_the_thesis() {
        let at = |speed_mps, avoider| Setting { speed_mps, avoider, hindrance: Hindrance::Person };
        let slow = Avoider::ALL.map(|avoider| at(0.3, avoider));
        assert_eq!(n_touched(&slow, 40), [0, 0, 0]);
        let fast = n_touched(&Avoider::ALL.map(|avoider| at(0.7, avoider)), 40);
        assert!(fast[1] == 0 && fast[0] > 2 && fast[2] > 2, "{fast:?}");
    }

    /// The guide: the checked avoider is no safer here; with smooth boxes it touches more than the printed one.
    #[test]
    fn the_checked_avoider_touches_more_smooth_boxes_and_takes_longer() {
        let at = |avoider| Setting { speed_mps: 0.2, avoider, hindrance: Hindrance::SmoothBox };
        let settings = [at(Avoider::Thesis), at(Avoider::Checked)];
        let options = Options { n_runs: 80, seed: RunSeed(21), ..Options::default() };
        let make = |i: usize, rng: &mut RandomStream| mission(settings[i], rng);
        let outcomes = run_all(settings.len(), &make, &options, &|_, _| ()).unwrap();
        let found: Vec<usize> = outcomes.iter().map(|runs| touched(runs).n_hits).collect();
        assert!(found[1] > found[0], "{found:?}");
        let time_s = |runs: &[Outcome]| {
            let arrived = runs.iter().filter(|run| run.arrived());
            let times: Vec<f64> =
                arrived.filter_map(|run| run.summary.figure("drive_time_s")).collect();
            median(&times).unwrap()
        };
        assert!(time_s(&outcomes[1]) > time_s(&outcomes[0]), "it takes longer");
    }

    /// Run j meets the same box with every method, and other runs other boxes.
    #[test]
    fn situations_follow_from_the_seed_alone() {
        let text = |seed: u64| box_text(&mut RunSeed(seed).stream("experiment/situation"), &ROUGH);
        assert_eq!(text(3), text(3));
        assert_ne!(text(3), text(4));
        let person =
            |speed_mps| person_text(&mut RunSeed(3).stream("experiment/situation"), speed_mps);
        assert_ne!(person(0.1), person(0.7), "the person must meet the robot, however fast it is");
    }

    #[test]
    fn the_report_is_whole() {
        let options = Options { n_runs: 1, ..Options::default() };
        let report = run(&options, &|_, _| ()).unwrap();
        assert!(report.tables().all(|t| t.rows.iter().all(|row| row.len() == t.head.len())));
        let n_rows: Vec<usize> = report.tables().map(|table| table.rows.len()).collect();
        assert_eq!(n_rows, [21, 21, 21, 3]);
        assert_eq!(report.figures().count(), 4);
    }
}
