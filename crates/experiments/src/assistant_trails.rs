//! Experiment 7.4 of the thesis: following virtual pheromones.
//!
//! The thesis states the conditions (cells of 0.2 m, σ = 0.6 m, antennas 0.38 m apart, 0.3 m/s,
//! 0.2 s, 9600 baud, three fuzzy sets) and conclusions in words; its figures 7.6 to 7.9 are lost. So the
//! trends are what can be compared. The thesis does not state how hard its robot accelerates; here that
//! is one more factor, because it decides how soon the wheels do what the law asks for.

mod ideal;
mod measures;
mod setting;
mod straight;
mod sweep;

use figures::{Axes, Floor, Line};
use geometry::Vec2;
use missions::{Mission, MissionError};
use run_context::RandomStream;

use crate::{
    ExperimentError, Figure, Options, Progress, Report, Section, Table,
    batch::{Outcome, run_all, uniform},
    report,
};
use measures::{all_medians, cell, greatest_excursion_mm, lost, n_lost, settled_rms_mm};
use setting::Setting;
use straight::{ideal_medians, straight_mission};

const FREE_TRAIL: &str = include_str!("free-trail.toml");

/// Speeds swept, m/s.
const SPEEDS_MPS: [f64; 3] = [0.3, 0.5, 0.7];
/// Control periods swept, ms.
const PERIODS_MS: [u32; 4] = [100, 200, 400, 600];
/// Perception radii swept, m.
const SIGMAS_M: [f64; 4] = [0.4, 0.6, 0.68, 0.9];
/// What the wheels accelerate with, m/s²: the robot's factory setting, and quicker ones.
const ACCELERATIONS_MPS2: [f64; 3] = [0.3, 1.0, 2.0];
/// The corner of the mission `trail-corner`, m.
const CORNER_M: Vec2 = Vec2::new(4.0, 0.0);
pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Report, ExperimentError> {
    if !options.sweep.is_empty() {
        return sweep::run(options, progress);
    }
    let straight = straight_settings();
    let n_straight = straight.len();
    let n_corner = SIGMAS_M.len();
    // The free trail is one more setting; all settings share the cores and one progress bar.
    let outcomes = run_all(
        n_straight + n_corner + 1,
        &|index, rng| {
            if let Some(&setting) = straight.get(index) {
                straight_mission(setting, rng)
            } else if let Some(&sigma_m) = SIGMAS_M.get(index - n_straight) {
                corner_mission(sigma_m, rng)
            } else {
                free_mission(rng)
            }
        },
        options,
        progress,
    )?;
    let (on_straight, rest) = outcomes.split_at(n_straight);
    let (at_corner, on_free) = rest.split_at(n_corner);
    let ideal = Ideal::measure(options)?;
    Ok(Report {
        title: "Following virtual pheromones (the thesis, 7.4)".to_owned(),
        preamble: format!(
            "{} runs per setting, seeds {} to {}, the law as printed at a constant speed, each through the whole closed loop: robot, sonar, \
             9600 baud links and pheromone server simulated down to their bytes. Runs differ in where \
             within 40 mm the robot begins and to which side it is turned. It drives off without turning \
             in place first.",
            options.n_runs,
            options.seed.0,
            options.seed.0 + u64::from(options.n_runs) - 1
        ),
        sections: vec![
            trajectories(&on_straight[0], &on_free[0])?,
            speed_and_period(&straight, on_straight, &ideal)?,
            radius(at_corner)?,
            remedies(&straight, on_straight),
            comparison(&straight, on_straight, at_corner, &ideal),
        ],
    })
}

/// The ideal loop by speed and period.
struct Ideal(Vec<(Setting, Option<f64>)>);

impl Ideal {
    fn measure(options: &Options) -> Result<Self, ExperimentError> {
        let settings: Vec<Setting> = SPEEDS_MPS
            .into_iter()
            .flat_map(|speed_mps| {
                let of = move |period_ms| Setting { speed_mps, period_ms, ..Setting::THESIS };
                PERIODS_MS.into_iter().map(of)
            })
            .collect();
        let medians = ideal_medians(&settings, options)?;
        Ok(Self(settings.into_iter().zip(medians).collect()))
    }

    fn rms_mm(&self, speed_mps: f64, period_ms: u32) -> Option<f64> {
        let wanted = Setting { speed_mps, period_ms, ..Setting::THESIS };
        self.0.iter().find(|(setting, _)| *setting == wanted).and_then(|(_, rms_mm)| *rms_mm)
    }
}

fn corner_mission(sigma_m: f64, rng: &mut RandomStream) -> Result<Mission, MissionError> {
    let start_x_m = uniform(rng, 0.0, 0.2);
    let overrides = [
        format!("pheromones.sigma_m={sigma_m}"),
        format!("robots.start=[{start_x_m}, 0.0, 0.0]"),
        "robots.mind.guard.method=off".to_owned(),
        "robots.mind.follow.turn_first=false".to_owned(),
        "robots.mind.how.preview_m=0".to_owned(),
        "robots.mind.follow.fit_to_speed=false".to_owned(),
    ];
    Mission::load("trail-corner", &overrides)
}

fn free_mission(rng: &mut RandomStream) -> Result<Mission, MissionError> {
    let (x_m, yaw_deg) = (uniform(rng, 0.0, 0.2), uniform(rng, -30.0, 60.0));
    let overrides = [
        format!("robots.start=[{x_m}, -1.0, {yaw_deg}]"),
        "robots.mind.how.preview_m=0".to_owned(),
        "robots.mind.follow.fit_to_speed=false".to_owned(),
    ];
    Mission::parse("free-trail.toml", FREE_TRAIL, &overrides)
}

/// The thesis's own setting first, then the grid of speed and period, then the improvements.
fn straight_settings() -> Vec<Setting> {
    let mut settings = vec![Setting::THESIS];
    settings.extend(swept());
    settings.extend(remedied());
    settings
}

/// The grid of acceleration, speed and period.
fn swept() -> impl Iterator<Item = Setting> {
    ACCELERATIONS_MPS2.into_iter().flat_map(|acceleration_mps2| {
        SPEEDS_MPS.into_iter().flat_map(move |speed_mps| {
            let base = Setting { acceleration_mps2, speed_mps, ..Setting::THESIS };
            PERIODS_MS.into_iter().map(move |period_ms| Setting { period_ms, ..base })
        })
    })
}

/// Each speed and acceleration without and with the remedies.
fn remedied() -> impl Iterator<Item = Setting> {
    ACCELERATIONS_MPS2.into_iter().flat_map(|acceleration_mps2| {
        SPEEDS_MPS.into_iter().flat_map(move |speed_mps| {
            let base = Setting { acceleration_mps2, speed_mps, ..Setting::THESIS };
            [
                base,
                Setting { five_sets: true, ..base },
                Setting { sigma_m: 0.9, ..base },
                Setting { period_ms: 100, ..base },
                base.with_all_remedies(),
                Setting { fit_to_speed: true, ..base },
            ]
        })
    })
}

fn trajectories(straight: &[Outcome], free: &[Outcome]) -> Result<Section, ExperimentError> {
    let named = |outcomes: &[Outcome]| {
        let line = |(j, outcome): (usize, &Outcome)| (format!("run {}", j + 1), outcome.line_m());
        outcomes.iter().take(6).enumerate().map(line).collect::<Vec<_>>()
    };
    let straight_floor = Floor {
        trail_name: "trail",
        trail: vec![Vec2::new(0.0, 0.0), Vec2::new(8.0, 0.0)],
        driven: named(straight),
        ..Floor::default()
    };
    let free_floor =
        Floor { trail_name: "trail", trail: free_trail(), driven: named(free), ..Floor::default() };
    let figure = |name: &str, caption: &str, floor: &Floor| {
        let svg = figures::floor(floor)?;
        Ok::<_, ExperimentError>(Figure { name: name.to_owned(), caption: caption.to_owned(), svg })
    };
    Ok(Section {
        heading: "Trajectories".to_owned(),
        text: vec![
            "The thesis records the path for an initial heading error of 45° (Fig. 7.7, lost) and on \
             an arbitrary trail (Fig. 7.10)."
                .to_owned(),
        ],
        tables: Vec::new(),
        figures: vec![
            figure(
                "trajectory-45deg",
                "Straight trail, turned by 45° at the start to either side; six runs.",
                &straight_floor,
            )?,
            figure("trajectory-free", "A trail of any shape; six runs.", &free_floor)?,
        ],
    })
}

fn free_trail() -> Vec<Vec2> {
    let trails = Mission::parse("free-trail.toml", FREE_TRAIL, &[])
        .ok()
        .and_then(|mission| mission.file().pheromones.clone())
        .map(|pheromones| pheromones.trails_m);
    trails.into_iter().flatten().take(1).flatten().map(|[x, y]| Vec2::new(x, y)).collect()
}

/// Settings and their runs.
type Measured<'a> = Vec<(Setting, &'a [Outcome])>;

fn speed_and_period(
    settings: &[Setting],
    outcomes: &[Vec<Outcome>],
    ideal: &Ideal,
) -> Result<Section, ExperimentError> {
    let all = settings.iter().zip(outcomes).skip(1).take(swept().count());
    let all: Measured<'_> = all.map(|(setting, runs)| (*setting, runs.as_slice())).collect();
    let mut table = Table::new(
        "Distance from the trail once settled (median over the runs that kept it), and the greatest \
         (median over all)",
        &["a (m/s²)", "v (m/s)", "Δt (s)", "settled, rms (mm)", "greatest (mm)", "lost the trail"],
    );
    for (setting, runs) in &all {
        table.rows.push(vec![
            format!("{:.1}", setting.acceleration_mps2),
            format!("{:.1}", setting.speed_mps),
            format!("{:.1}", f64::from(setting.period_ms) / 1e3),
            cell(all_medians(runs, settled_rms_mm)),
            cell(all_medians(runs, |run| Some(greatest_excursion_mm(run)))),
            n_lost(runs),
        ]);
    }
    for (setting, rms_mm) in &ideal.0 {
        table.rows.push(vec![
            "ideal".to_owned(),
            format!("{:.1}", setting.speed_mps),
            format!("{:.1}", f64::from(setting.period_ms) / 1e3),
            cell(*rms_mm),
            String::new(),
            String::new(),
        ]);
    }
    let figures = ACCELERATIONS_MPS2.map(|a| period_figure(a, &all));
    Ok(Section {
        heading: "Speed and control period".to_owned(),
        text: vec![
            "The thesis: oscillation tends to appear when the speed or the period grows. It does not state \
             the acceleration a of its robot's wheels; 0.3 m/s² is the factory setting. *Ideal* is the same law \
             on the same trail with wheels that turn at once as asked and links without delay."
                .to_owned(),
        ],
        tables: vec![table],
        figures: figures.into_iter().collect::<Result<_, _>>()?,
    })
}

/// Settled distance against period, one line a speed.
fn period_figure(acceleration_mps2: f64, all: &Measured<'_>) -> Result<Figure, ExperimentError> {
    let line = |speed_mps: f64| {
        let same = |s: &Setting| {
            s.speed_mps.total_cmp(&speed_mps).is_eq()
                && s.acceleration_mps2.total_cmp(&acceleration_mps2).is_eq()
        };
        let point = |(setting, runs): &(Setting, &[Outcome])| {
            Some((f64::from(setting.period_ms) / 1e3, all_medians(runs, settled_rms_mm)?))
        };
        Line {
            name: format!("{speed_mps:.1} m/s"),
            points: all.iter().filter(|(s, _)| same(s)).filter_map(point).collect(),
            ..Line::default()
        }
    };
    let axes = Axes { x: "control period (s)", y: "settled distance from the trail, rms (mm)" };
    Ok(Figure {
        name: format!("period-a{:02.0}", 10.0 * acceleration_mps2),
        caption: format!(
            "Settled distance from the trail against the control period; wheels accelerate with \
             {acceleration_mps2:.1} m/s²."
        ),
        svg: figures::lines(axes, &SPEEDS_MPS.map(line))?,
    })
}

/// Distance at which the driven line passes the corner, mm.
fn corner_cut_mm(outcome: &Outcome) -> Option<f64> {
    let distances = outcome.line_m().into_iter().map(|p| (p - CORNER_M).norm());
    distances.min_by(f64::total_cmp).map(|d| d * 1e3)
}

fn radius(outcomes: &[Vec<Outcome>]) -> Result<Section, ExperimentError> {
    let mut table = Table::new(
        "A right angle: how far from the corner the robot passes (medians over runs)",
        &["σ (m)", "distance (mm)", "arrived"],
    );
    let mut driven = Vec::new();
    for (sigma_m, runs) in SIGMAS_M.iter().zip(outcomes) {
        let n_arrived = runs.iter().filter(|run| run.arrived()).count();
        table.rows.push(vec![
            format!("{sigma_m:.2}"),
            cell(all_medians(runs, corner_cut_mm)),
            format!("{n_arrived} of {}", runs.len()),
        ]);
        if let Some(run) = runs.first() {
            driven.push((format!("σ = {sigma_m} m"), run.line_m()));
        }
    }
    let trail = vec![Vec2::new(0.0, 0.0), CORNER_M, Vec2::new(4.0, 4.6)];
    let floor = Floor { trail_name: "trail", trail, driven, ..Floor::default() };
    Ok(Section {
        heading: "Perception radius".to_owned(),
        text: vec![
            "The thesis: a larger radius is a larger look-ahead, steadier but cutting corners."
                .to_owned(),
        ],
        tables: vec![table],
        figures: vec![Figure {
            name: "corner".to_owned(),
            caption: "The first run of each radius around the corner.".to_owned(),
            svg: figures::floor(&floor)?,
        }],
    })
}

fn remedies(settings: &[Setting], outcomes: &[Vec<Outcome>]) -> Section {
    let mut table = Table::new(
        "The remedies that the thesis proposes (medians over the runs that kept the trail)",
        &[
            "a (m/s²)",
            "v (m/s)",
            "law",
            "sets",
            "σ (m)",
            "Δt (s)",
            "settled, rms (mm)",
            "lost the trail",
        ],
    );
    let first = 1 + swept().count();
    for (setting, runs) in settings.iter().zip(outcomes).skip(first) {
        table.rows.push(vec![
            format!("{:.1}", setting.acceleration_mps2),
            format!("{:.1}", setting.speed_mps),
            if setting.fit_to_speed { "fitted to the speed" } else { "as printed" }.to_owned(),
            if setting.five_sets { "5" } else { "3" }.to_owned(),
            format!("{:.2}", setting.sigma_m),
            format!("{:.1}", f64::from(setting.period_ms) / 1e3),
            cell(all_medians(runs, settled_rms_mm)),
            n_lost(runs),
        ]);
    }
    Section {
        heading: "Sets, radius and period as remedies".to_owned(),
        text: vec![
            "The thesis expects 0.5 to 0.7 m/s without disturbing oscillation from a larger radius, five \
             sets and a shorter period. *Fitted to the speed* is Cairn's default way of driving (`fit_to_speed`): \
             above 0.3 m/s the sets grow with the square of the speed, and the robot slows down for the goal."
                .to_owned(),
        ],
        tables: vec![table],
        figures: Vec::new(),
    }
}

fn comparison(
    settings: &[Setting],
    on_straight: &[Vec<Outcome>],
    at_corner: &[Vec<Outcome>],
    ideal: &Ideal,
) -> Section {
    let thesis = &on_straight[0];
    let n_passed = thesis.iter().filter(|run| !lost(run)).count();
    let runs_of = |wanted: Setting| {
        let index = settings.iter().position(|s| *s == wanted);
        index.map_or(&[][..], |i| on_straight[i].as_slice())
    };
    let rms_mm = |wanted: Setting| cell(all_medians(runs_of(wanted), settled_rms_mm));
    let found = |wanted: Setting| {
        format!("{} mm ({} lost the trail)", rms_mm(wanted), n_lost(runs_of(wanted)))
    };
    let base = Setting::THESIS;
    let fast = Setting { speed_mps: 0.7, ..base };
    let quick = Setting { acceleration_mps2: 2.0, ..fast };
    let corner = |i: usize| cell(all_medians(&at_corner[i], corner_cut_mm));
    let rows = [
        [
            "a path from 45° off is shown; that it converges is implied".to_owned(),
            format!(
                "{n_passed} of {} runs converge and arrive; at most {} mm off, settled within {} mm rms",
                thesis.len(),
                cell(all_medians(thesis, |run| Some(greatest_excursion_mm(run)))),
                rms_mm(base)
            ),
            "no figure is stated; the original map and plot are lost".to_owned(),
        ],
        [
            "oscillation grows with the speed and the period".to_owned(),
            format!(
                "0.3 m/s: {} mm at 0.1 s, {} mm at 0.6 s; at 0.2 s: {} at 0.3 m/s, {} at 0.5 m/s",
                rms_mm(Setting { period_ms: 100, ..base }),
                rms_mm(Setting { period_ms: 600, ..base }),
                found(base),
                found(Setting { speed_mps: 0.5, ..base })
            ),
            format!(
                "the thesis gives no numbers; an ideal loop, whose wheels obey at once, settles within {} mm at \
                 0.1 s and {} mm at 0.6 s, and at 0.2 s within {} mm at 0.3 m/s and {} mm at 0.5 m/s: late \
                 corrections swing by themselves, and what is lost at 0.5 m/s is lost by the drive",
                cell(ideal.rms_mm(0.3, 100)),
                cell(ideal.rms_mm(0.3, 600)),
                cell(ideal.rms_mm(0.3, 200)),
                cell(ideal.rms_mm(0.5, 200))
            ),
        ],
        [
            "a larger radius cuts corners".to_owned(),
            format!(
                "passes the corner at {} mm with σ = 0.4 m, at {} mm with 0.9 m",
                corner(0),
                corner(SIGMAS_M.len() - 1)
            ),
            "as reported, in numbers".to_owned(),
        ],
        [
            "0.5 to 0.7 m/s expected with five sets, larger radius, shorter period".to_owned(),
            format!(
                "0.7 m/s: {} without, {} with all three; with wheels that accelerate with 2 m/s² {} and {}, and \
                 {} with the law fitted to the speed",
                found(fast),
                found(fast.with_all_remedies()),
                found(quick),
                found(quick.with_all_remedies()),
                found(Setting { fit_to_speed: true, ..quick })
            ),
            "a prediction there, a measurement here: it also takes a drive quicker than the factory \
             setting, and up to 0.5 m/s five sets alone are not better"
                .to_owned(),
        ],
    ];
    report::comparison(rows)
}

#[cfg(test)]
mod tests {
    use super::setting::SETTLED_M;
    use super::*;
    use run_context::RunSeed;

    /// Runs per setting below. Two settings meet the same situations, run by run; if they did not
    /// differ, all six pairs would differ in the expected direction with a chance of 1/64.
    const N_RUNS: u32 = 6;

    fn outcomes(settings: &[Setting]) -> Vec<Vec<Outcome>> {
        let options = Options { n_runs: N_RUNS, seed: RunSeed(11), ..Options::default() };
        let make = |i: usize, rng: &mut RandomStream| straight_mission(settings[i], rng);
        run_all(settings.len(), &make, &options, &|_, _| ()).unwrap()
    }

    /// In how many pairs of runs the second setting's figure is greater.
    fn n_greater(runs: &[Vec<Outcome>], figure: impl Fn(&Outcome) -> f64) -> usize {
        runs[0].iter().zip(&runs[1]).filter(|(a, b)| figure(b) > figure(a)).count()
    }

    /// The law is measured at the speed that the tables say: the robot does not slow down for what is ahead.
    #[test]
    fn the_speed_that_is_swept_is_driven() {
        for speed_mps in [0.3, 0.7] {
            let quick = Setting { acceleration_mps2: 2.0, speed_mps, ..Setting::THESIS };
            for run in &outcomes(&[Setting { period_ms: 100, ..quick }])[0] {
                let on_way = |p: &&(f64, missions::Pose)| SETTLED_M.contains(&p.1.x_m);
                let way: Vec<_> = run.track.iter().filter(on_way).collect();
                let ((from, first), (to, last)) = (way[0], way[way.len() - 1]);
                let driven_mps = (last.x_m - first.x_m) / (to - from);
                let ratio = driven_mps / speed_mps;
                assert!((0.95..1.02).contains(&ratio), "{speed_mps}: {driven_mps}");
            }
        }
    }

    /// R3 and AT13: converges from 45°, with the excursion of a robot that does not turn in place.
    #[test]
    fn the_thesis_setting_converges() {
        for run in &outcomes(&[Setting::THESIS])[0] {
            assert!(!lost(run), "seed {}", run.summary.seed);
            let (greatest_mm, settled_mm) =
                (greatest_excursion_mm(run), settled_rms_mm(run).unwrap());
            assert!(
                (60.0..250.0).contains(&greatest_mm),
                "seed {}: {greatest_mm}",
                run.summary.seed
            );
            assert!(settled_mm < 30.0, "seed {}: {settled_mm}", run.summary.seed);
        }
    }

    /// R4 and AT14: oscillation grows with the period, and with the speed.
    #[test]
    fn slower_corrections_and_more_speed_oscillate_more() {
        let base = Setting { acceleration_mps2: 2.0, ..Setting::THESIS };
        let rms_mm = |run: &Outcome| settled_rms_mm(run).unwrap_or(f64::INFINITY);
        let slow = Setting { period_ms: 600, ..base };
        let pair = outcomes(&[Setting { period_ms: 100, ..base }, slow]);
        assert_eq!(n_greater(&pair, rms_mm), N_RUNS as usize);
        let pair = outcomes(&[base, Setting { speed_mps: 0.7, ..base }]);
        assert_eq!(n_greater(&pair, rms_mm), N_RUNS as usize);
    }

    /// R4 and AT14: 0.7 m/s becomes possible with the remedies and a quick drive.
    #[test]
    fn the_remedies_help_at_speed() {
        let fast = Setting { acceleration_mps2: 2.0, speed_mps: 0.7, ..Setting::THESIS };
        let pair = outcomes(&[fast.with_all_remedies(), fast]);
        assert!(pair[0].iter().all(|run| !lost(run)));
        let rms_mm = |run: &Outcome| settled_rms_mm(run).unwrap_or(f64::INFINITY);
        assert_eq!(n_greater(&pair, rms_mm), N_RUNS as usize);
    }

    /// The guide: with a quick drive Cairn's default way of driving swings by millimetres at 0.7 m/s.
    #[test]
    fn a_law_fitted_to_the_speed_swings_less_than_the_printed_one() {
        let printed = Setting { acceleration_mps2: 2.0, speed_mps: 0.7, ..Setting::THESIS };
        let pair = outcomes(&[Setting { fit_to_speed: true, ..printed }, printed]);
        let rms_mm = |run: &Outcome| settled_rms_mm(run).unwrap_or(f64::INFINITY);
        assert!(pair[0].iter().all(|run| rms_mm(run) < 10.0));
        assert_eq!(n_greater(&pair, rms_mm), N_RUNS as usize);
    }

    fn median_mm(runs: &[Outcome]) -> f64 {
        all_medians(runs, settled_rms_mm).unwrap_or(f64::INFINITY)
    }

    /// The guide: at 0.3 m/s² the correction comes too late at 0.5 m/s; an ideal drive keeps the trail there.
    #[test]
    fn with_the_factory_drive_the_trail_is_lost_at_half_a_metre_per_second() {
        let fast = Setting { speed_mps: 0.5, ..Setting::THESIS };
        let runs = &outcomes(&[fast])[0];
        assert!(runs.iter().filter(|run| lost(run)).count() >= 5);
        let options = Options { n_runs: N_RUNS, seed: RunSeed(11), ..Options::default() };
        let ideal = ideal_medians(&[fast, Setting::THESIS], &options).unwrap();
        assert!(ideal[0].is_some_and(|mm| mm < 60.0) && ideal[1] < ideal[0], "{ideal:?}");
    }

    /// What swings with late corrections is the law's: wheels that obey at once swing more than quick ones.
    #[test]
    fn late_corrections_swing_the_ideal_loop_more_than_quick_wheels() {
        let late = Setting { period_ms: 400, ..Setting::THESIS };
        let options = Options { n_runs: N_RUNS, seed: RunSeed(11), ..Options::default() };
        let ideal_mm = ideal_medians(&[late], &options).unwrap()[0].unwrap();
        let runs = outcomes(&[Setting { acceleration_mps2: 2.0, ..late }, late]);
        let (quick_mm, factory_mm) = (median_mm(&runs[0]), median_mm(&runs[1]));
        assert!(1.3 * quick_mm < ideal_mm, "{quick_mm} {ideal_mm}");
        assert!((0.6..1.5).contains(&(ideal_mm / factory_mm)), "{ideal_mm} {factory_mm}");
    }

    /// AT14 wants five sets to be better. They are not: alone they change little, to either side. The guide says so.
    #[test]
    fn five_sets_alone_change_little() {
        let mut n_better = 0;
        for (acceleration_mps2, speed_mps) in [(1.0, 0.3), (1.0, 0.5), (2.0, 0.3), (2.0, 0.5)] {
            let three = Setting { acceleration_mps2, speed_mps, ..Setting::THESIS };
            let pair = outcomes(&[three, Setting { five_sets: true, ..three }]);
            let ratio = median_mm(&pair[1]) / median_mm(&pair[0]);
            assert!((0.7..1.7).contains(&ratio), "{acceleration_mps2} {speed_mps}: {ratio}");
            n_better += usize::from(ratio < 1.0);
        }
        assert!(n_better <= 1, "five sets were better in {n_better} of 4: say so in the guide");
    }

    /// A shorter period helps at every acceleration that keeps the trail; a larger radius keeps it where it was lost.
    #[test]
    fn a_shorter_period_and_a_larger_radius_help() {
        let rms_mm = |run: &Outcome| settled_rms_mm(run).unwrap_or(f64::INFINITY);
        for (acceleration_mps2, speed_mps) in [(1.0, 0.5), (2.0, 0.5), (2.0, 0.7)] {
            let base = Setting { acceleration_mps2, speed_mps, ..Setting::THESIS };
            let pair = outcomes(&[Setting { period_ms: 100, ..base }, base]);
            assert_eq!(
                n_greater(&pair, rms_mm),
                N_RUNS as usize,
                "{acceleration_mps2} {speed_mps}"
            );
        }
        let base = Setting { acceleration_mps2: 1.0, speed_mps: 0.7, ..Setting::THESIS };
        let pair = outcomes(&[Setting { sigma_m: 0.9, ..base }, base]);
        let [with, without] = [0, 1].map(|i| pair[i].iter().filter(|run| lost(run)).count());
        assert!(with + 2 < without, "lost: {with} and {without}");
    }

    /// With the factory drive all three remedies keep most runs at 0.5 m/s, swinging widely, and none at 0.7 m/s.
    #[test]
    fn the_remedies_do_not_replace_a_quicker_drive() {
        let at = |speed_mps| Setting { speed_mps, ..Setting::THESIS }.with_all_remedies();
        let runs = outcomes(&[at(0.5), at(0.7)]);
        assert!(runs[0].iter().filter(|run| !lost(run)).count() >= 4);
        assert!(median_mm(&runs[0]) > 80.0, "{}", median_mm(&runs[0]));
        assert!(runs[1].iter().all(lost));
    }

    /// The shipped mission begins where it says: it drives off 45° askew, and does not turn in place before.
    #[test]
    fn the_mission_starts_45_degrees_off_as_it_says() {
        let run = run_all(
            1,
            &|_, _| Mission::load("trail-45deg", &[]),
            &Options { n_runs: 1, ..Options::default() },
            &|_, _| (),
        );
        let track = &run.unwrap()[0][0].track;
        let gone = |p: &missions::Pose| p.x_m.hypot(p.y_m) > 0.03;
        let (_, first) = track.iter().find(|(_, pose)| gone(pose)).unwrap();
        assert!(first.y_m > 0.5 * first.x_m, "drove off to ({}, {})", first.x_m, first.y_m);
        let greatest = track.iter().map(|(_, pose)| pose.y_m.abs()).fold(0.0, f64::max);
        assert!((0.06..0.25).contains(&greatest), "{greatest} m");
    }

    /// R4 and AT14: a larger radius cuts the corner.
    #[test]
    fn a_larger_radius_cuts_the_corner() {
        let options = Options { n_runs: N_RUNS, seed: RunSeed(11), ..Options::default() };
        let make = |i: usize, rng: &mut RandomStream| corner_mission([0.4, 0.68][i], rng);
        let pair = run_all(2, &make, &options, &|_, _| ()).unwrap();
        let cut_mm = |run: &Outcome| corner_cut_mm(run).unwrap();
        assert_eq!(n_greater(&pair, cut_mm), N_RUNS as usize);
    }

    /// The tables are as wide as their heads, and every setting has its row.
    #[test]
    fn the_report_is_whole() {
        let options = Options { n_runs: 1, ..Options::default() };
        let report = run(&options, &|_, _| ()).unwrap();
        assert!(report.tables().all(|t| t.rows.iter().all(|row| row.len() == t.head.len())));
        let n_rows: Vec<usize> = report.tables().map(|table| table.rows.len()).collect();
        assert_eq!(n_rows, [48, 4, 54, 4]);
        assert_eq!(report.figures().count(), 6);
        assert!(report.figures().all(|figure| figure.svg.starts_with("<svg")));
    }
}
