//! The thesis, 5.3.2: a trail in tags on the floor against the trail of the pheromone server.
//!
//! The thesis tried neither of its two variants. Its claims are that the server is a single point of failure and tags are more
//! robust, that two readers' gradient makes relatively large oscillations, and that look-ahead points make smaller ones.
//! One trail is driven in three ways: with everything in order, with a server that falls silent at a random time, with unequal
//! wheels, and with tags that do not answer.

use figures::Floor;
use geometry::Vec2;
use missions::{Mission, MissionError};
use run_context::RandomStream;

use crate::{
    ExperimentError, Figure, Options, Progress, Report, Section, Table,
    batch::{Outcome, run_all, uniform},
    report,
    statistics::median,
};

const MISSION: &str = include_str!("tag-trails.toml");

/// How wrong each wheel's diameter is with unequal wheels, as a ratio: 1.5 degrees of heading per metre.
const UNEQUAL_RATIO: f64 = 0.005;

/// The server falls silent at a time between these, seconds; the drive takes 61 s at least.
const SILENT_FROM_S: f64 = 5.0;
const SILENT_TO_S: f64 = 55.0;

/// How the robot knows the trail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guide {
    Server,
    Gradient,
    LookAhead,
}

impl Guide {
    const ALL: [Self; 3] = [Self::Server, Self::Gradient, Self::LookAhead];

    fn name(self) -> &'static str {
        match self {
            Self::Server => "pheromone server",
            Self::Gradient => "tags, two readers",
            Self::LookAhead => "tags, look-ahead points",
        }
    }

    fn overrides(self) -> &'static [&'static str] {
        match self {
            Self::Server => &["robots.mind.how.method=trail"],
            Self::Gradient => &["robots.mind.how.method=tags"],
            Self::LookAhead => {
                &["robots.mind.how.method=tags", "robots.mind.follow.tags.law=look_ahead"]
            }
        }
    }
}

/// What is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Trouble {
    missing_percent: u32,
    silent: bool,
    unequal: bool,
}

impl Trouble {
    const NONE: Self = Self { missing_percent: 0, silent: false, unequal: false };
    const SILENT: Self = Self { silent: true, ..Self::NONE };
    const UNEQUAL: Self = Self { unequal: true, ..Self::NONE };
    /// Everything at once.
    const ALL: Self = Self { missing_percent: 20, silent: true, unequal: true };

    fn missing(missing_percent: u32) -> Self {
        Self { missing_percent, ..Self::NONE }
    }

    fn name(self) -> String {
        match self {
            Self::NONE => "all in order".to_owned(),
            Self::SILENT => "the server falls silent".to_owned(),
            Self::UNEQUAL => "unequal wheels".to_owned(),
            Self::ALL => "silent server, unequal wheels, 20 % of the tags missing".to_owned(),
            Self { missing_percent, .. } => format!("{missing_percent} % of the tags missing"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Setting {
    guide: Guide,
    trouble: Trouble,
}

fn settings() -> Vec<Setting> {
    let missing = [10, 20, 30].map(Trouble::missing);
    let troubles = [Trouble::NONE, Trouble::SILENT, Trouble::UNEQUAL].into_iter().chain(missing);
    let all: Vec<Trouble> = troubles.chain([Trouble::ALL]).collect();
    let of = |guide: Guide| all.iter().map(move |&trouble| Setting { guide, trouble });
    // What tags lack does not concern a robot that asks the server.
    let concerns = |s: &Setting| s.guide != Guide::Server || s.trouble.missing_percent == 0;
    Guide::ALL.into_iter().flat_map(of).filter(concerns).collect()
}

fn mission(setting: Setting, rng: &mut RandomStream) -> Result<Mission, MissionError> {
    let Trouble { missing_percent, silent, unequal } = setting.trouble;
    let (y_m, yaw_deg) = (uniform(rng, -0.05, 0.05), uniform(rng, -10.0, 10.0));
    let silent_at_s = uniform(rng, SILENT_FROM_S, SILENT_TO_S);
    let error = if uniform(rng, -1.0, 1.0) < 0.0 { -UNEQUAL_RATIO } else { UNEQUAL_RATIO };
    let mut overrides: Vec<String> =
        setting.guide.overrides().iter().map(|&o| o.to_owned()).collect();
    overrides.push(format!("robots.start=[0.0, {y_m}, {yaw_deg}]"));
    overrides.push(format!("tags.missing_ratio={}", 0.01 * f64::from(missing_percent)));
    if unequal {
        overrides.push(format!("robots.odometry.left_diameter_ratio={}", 1.0 + error));
        overrides.push(format!("robots.odometry.right_diameter_ratio={}", 1.0 - error));
    }
    let cut = format!(
        "[[events]]\nat_s = {silent_at_s:.2}\ndo = \"cut_line\"\nrobot = \"robot\"\nline = \"pheromones\"\n"
    );
    let text = if silent { format!("{MISSION}\n{cut}") } else { MISSION.to_owned() };
    Mission::parse("tag-trails.toml", &text, &overrides)
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Report, ExperimentError> {
    let settings = settings();
    let outcomes = run_all(settings.len(), &|i, rng| mission(settings[i], rng), options, progress)?;
    let results: Vec<Runs<'_>> = settings
        .iter()
        .zip(&outcomes)
        .map(|(setting, runs)| Runs { setting: *setting, runs })
        .collect();
    let paths = ways(&results)?;
    Ok(Report {
        title: "A trail in tags on the floor against the pheromone server's (the thesis, 5.3.2)"
            .to_owned(),
        preamble: format!(
            "{} runs per setting, seeds {} to {}, each through the whole closed loop at 0.2 m/s. The trail is 12.2 m long with two \
             bends of 45° and a right angle. Tags lie every 0.1 m and hold a trail three tags wide; a read takes 20 ms, one in \
             twenty fails. The server's trail is one cell of 0.2 m wide. The robot starts up to 5 cm beside the trail and 10° off \
             its direction. Arrived is who truly stands within 0.3 m and 20° of the goal; distances from the trail are true \
             ones, while following.",
            options.n_runs,
            options.seed.0,
            options.seed.0 + u64::from(options.n_runs) - 1,
        ),
        sections: vec![table(&results), paths, comparison(&results)],
    })
}

/// The runs of a setting.
#[derive(Clone, Copy, Debug)]
struct Runs<'a> {
    setting: Setting,
    runs: &'a [Outcome],
}

impl Runs<'_> {
    fn n_arrived(&self) -> usize {
        self.runs.iter().filter(|run| run.arrived()).count()
    }

    /// The median of a figure over the runs that have it.
    fn median(&self, figure: &str) -> Option<f64> {
        let values: Vec<f64> =
            self.runs.iter().filter_map(|run| run.summary.figure(figure)).collect();
        median(&values)
    }

    fn arrived(&self) -> String {
        format!("{} of {}", self.n_arrived(), self.runs.len())
    }
}

fn in_units(value: Option<f64>, factor: f64, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{:.digits$}", factor * value))
}

fn table(results: &[Runs<'_>]) -> Section {
    let mut table = Table::new(
        "Arrivals; medians of distances from the trail, of the turn rate, and of the time of those that report arrival",
        &[
            "trail",
            "trouble",
            "arrived",
            "rms (mm)",
            "greatest (mm)",
            "turn rate, rms (°/s)",
            "time (s)",
        ],
    );
    for result in results {
        table.rows.push(vec![
            result.setting.guide.name().to_owned(),
            result.setting.trouble.name(),
            result.arrived(),
            in_units(result.median("cross_track_rms_m"), 1e3, 0),
            in_units(result.median("cross_track_max_m"), 1e3, 0),
            in_units(result.median("turn_rate_rms_radps"), 1_f64.to_degrees(), 1),
            in_units(result.median("drive_time_s"), 1.0, 1),
        ]);
    }
    Section {
        heading: "Three ways to know a trail".to_owned(),
        tables: vec![table],
        ..Section::default()
    }
}

/// Where the first runs went.
fn ways(results: &[Runs<'_>]) -> Result<Section, ExperimentError> {
    let driven = |trouble: Trouble| -> Vec<(String, Vec<Vec2>)> {
        let of_trouble = results.iter().filter(|result| result.setting.trouble == trouble);
        let first = |result: &Runs<'_>| {
            Some((result.setting.guide.name().to_owned(), result.runs.first()?.line_m()))
        };
        of_trouble.filter_map(first).collect()
    };
    let trail =
        Mission::parse("tag-trails.toml", MISSION, &["robots.mind.how.method=tags".to_owned()])
            .ok()
            .and_then(|mission| mission.file().tags.clone())
            .and_then(|tags| tags.trails_m.into_iter().next())
            .unwrap_or_default();
    let trail: Vec<Vec2> = trail.into_iter().map(|[x, y]| Vec2::new(x, y)).collect();
    let figure = |name: &str, caption: &str, trouble: Trouble| -> Result<Figure, ExperimentError> {
        let floor = Floor {
            trail_name: "the trail",
            trail: trail.clone(),
            driven: driven(trouble),
            ..Floor::default()
        };
        let (name, caption) = (name.to_owned(), caption.to_owned());
        Ok(Figure { name, caption, svg: figures::floor(&floor)? })
    };
    Ok(Section {
        heading: "The ways of the first runs".to_owned(),
        figures: vec![
            figure("in-order", "Everything in order.", Trouble::NONE)?,
            figure(
                "unequal-wheels",
                "Unequal wheels: who asks the server follows the trail where it believes to be.",
                Trouble::UNEQUAL,
            )?,
        ],
        ..Section::default()
    })
}

fn comparison(results: &[Runs<'_>]) -> Section {
    let of = |guide: Guide, trouble: Trouble| {
        results.iter().find(|result| result.setting == Setting { guide, trouble })
    };
    let arrived =
        |guide: Guide, trouble: Trouble| of(guide, trouble).map_or_else(String::new, Runs::arrived);
    let turn_rate = |guide: Guide| {
        let value = of(guide, Trouble::NONE).and_then(|r| r.median("turn_rate_rms_radps"));
        in_units(value, 1_f64.to_degrees(), 1)
    };
    let rms = |guide: Guide, trouble: Trouble| {
        in_units(of(guide, trouble).and_then(|r| r.median("cross_track_rms_m")), 1e3, 0)
    };
    report::comparison([
        [
            "the server is a single point of failure; tags are decentralised and more robust"
                .to_owned(),
            format!(
                "the server falls silent: {} arrive with it, {} by two readers, {} by look-ahead points",
                arrived(Guide::Server, Trouble::SILENT),
                arrived(Guide::Gradient, Trouble::SILENT),
                arrived(Guide::LookAhead, Trouble::SILENT)
            ),
            "who loses the server stands and reports; nobody is asked where tags are".to_owned(),
        ],
        [
            "a scalar trail: relatively large oscillations".to_owned(),
            format!(
                "turn rate {} °/s by two readers, {} °/s with the server",
                turn_rate(Guide::Gradient),
                turn_rate(Guide::Server)
            ),
            "a tag tells the intensity where it lies and not where the reader is".to_owned(),
        ],
        [
            "look-ahead points: smaller oscillation".to_owned(),
            format!("turn rate {} °/s", turn_rate(Guide::LookAhead)),
            "the point lies 0.6 m ahead, and its tag tells on which side".to_owned(),
        ],
        [
            "tags keep the error of dead reckoning constant (3.5.2)".to_owned(),
            format!(
                "unequal wheels: {} mm from the trail with the server, {} mm by two readers, {} mm by look-ahead points",
                rms(Guide::Server, Trouble::UNEQUAL),
                rms(Guide::Gradient, Trouble::UNEQUAL),
                rms(Guide::LookAhead, Trouble::UNEQUAL)
            ),
            "the server answers about the place where the robot believes to be".to_owned(),
        ],
    ])
}

#[cfg(test)]
mod tests {
    use run_context::RunSeed;

    use super::*;

    /// What the guide says of the table, with fewer runs. `RUNS=40 cargo test -p cairn_experiments tag_trails -- --nocapture`
    /// prints it with as many as asked for.
    #[test]
    fn the_conclusions_of_the_guide_hold() {
        let asked = std::env::var("RUNS").ok().and_then(|runs| runs.parse().ok());
        let n_runs = asked.unwrap_or(6);
        let options = Options { n_runs, seed: RunSeed(1), ..Options::default() };
        let settings = settings();
        let make = |i: usize, rng: &mut RandomStream| mission(settings[i], rng);
        let outcomes = run_all(settings.len(), &make, &options, &|_, _| ()).unwrap();
        let results: Vec<Runs<'_>> = settings
            .iter()
            .zip(&outcomes)
            .map(|(setting, runs)| Runs { setting: *setting, runs })
            .collect();
        if asked.is_some() {
            let rows = table(&results).tables.remove(0).rows;
            for row in &rows {
                eprintln!("| {} |", row.join(" | "));
            }
        }
        let of = |guide, trouble| {
            *results.iter().find(|r| r.setting == Setting { guide, trouble }).unwrap()
        };
        let n_all = n_runs as usize;
        let most = |result: Runs<'_>| 10 * result.n_arrived() >= 8 * n_all;
        for guide in Guide::ALL {
            assert_eq!(of(guide, Trouble::NONE).n_arrived(), n_all, "{guide:?}");
        }
        assert_eq!(of(Guide::Server, Trouble::SILENT).n_arrived(), 0);
        let server_rms = of(Guide::Server, Trouble::UNEQUAL).median("cross_track_rms_m").unwrap();
        for guide in [Guide::Gradient, Guide::LookAhead] {
            let (silent, order) = (of(guide, Trouble::SILENT), of(guide, Trouble::NONE));
            assert_eq!(silent.median("cross_track_rms_m"), order.median("cross_track_rms_m"));
            assert_eq!(silent.n_arrived(), n_all, "{guide:?}");
            let unequal = of(guide, Trouble::UNEQUAL);
            assert!(most(unequal), "{guide:?}: {}", unequal.arrived());
            let rms = unequal.median("cross_track_rms_m").unwrap();
            assert!(3.0 * rms < server_rms, "{guide:?}: {rms} {server_rms}");
            assert!(most(of(guide, Trouble::missing(30))), "{guide:?}");
            assert!(most(of(guide, Trouble::ALL)), "{guide:?}");
        }
        let turn_rate = |guide| of(guide, Trouble::NONE).median("turn_rate_rms_radps").unwrap();
        assert!(turn_rate(Guide::LookAhead) < turn_rate(Guide::Gradient));
        assert!(turn_rate(Guide::Server) < turn_rate(Guide::Gradient));
    }

    #[test]
    fn the_report_is_whole() {
        let options = Options { n_runs: 1, ..Options::default() };
        let report = run(&options, &|_, _| ()).unwrap();
        assert!(report.tables().all(|t| t.rows.iter().all(|row| row.len() == t.head.len())));
        let n_rows: Vec<usize> = report.tables().map(|table| table.rows.len()).collect();
        assert_eq!(n_rows, [17, 4]);
        assert_eq!(report.figures().count(), 2);
    }
}
