//! `cairn run`: a mission, in the browser or headless.

use std::{
    path::PathBuf,
    process::ExitCode,
    time::{Duration, Instant},
};

use anyhow::Context as _;
use files::{Kind, Outputs};
use indicatif::{ProgressBar, ProgressStyle};
use missions::{LogItem, Mission, Recorder, Run};
use run_context::RunSeed;
use studio::{Options, Recordings, Show};

use crate::output::{self, Format, complain, say};
use crate::{
    given,
    interrupt::{self, Interrupt},
    parse,
};

/// The mission that is run when nothing is asked for.
const FIRST_MISSION: &str = "doorbell";
/// One step of a run.
const TICK: Duration = Duration::from_millis(10);
/// Steps between two looks at the progress bar.
const STEPS_PER_LOOK: u64 = 500;

/// Runs a mission in real time with the studio, or headless as fast as it can
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn run doorbell\n  cairn run doorbell --headless --seed 7 --format json\n  \
    cairn run my-flat.toml --headless --record out.mcap\n  cairn run doorbell --headless --set robots.mind.follow.speed_mps=0.2 --verbose\n  \
    cairn missions doorbell | cairn run - --headless --quiet\n\n\
    With a robot behind TCP or a serial line even a headless run takes real time.\n\
    A headless run ends with exit code 0 when the verdict is passed, 1 when it is failed, 2 on an error, and\n\
    130 after Ctrl-C. Whatever ends it, the robots are told to stand first."
)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line are what they are")]
pub(crate) struct Args {
    /// A mission file, the name of a shipped mission (see `cairn missions`), or `-` for standard input
    mission: String,
    /// As fast as it can, without the studio; ends with a verdict and a table of figures
    #[arg(long)]
    headless: bool,
    /// Seed of everything random; the mission's own unless given
    #[arg(long, value_name = "N", value_parser = parse::seed)]
    seed: Option<u64>,
    /// Changes one key of the mission; may be given several times
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    overrides: Vec<String>,
    /// Records the run (MCAP); `cairn replay` shows it again. After a restart in the studio FILE-2, FILE-3 …
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Replaces a recording of that name
    #[arg(long, requires = "record")]
    force: bool,
    /// How a headless run prints its end
    #[arg(long, value_enum, default_value_t, requires = "headless")]
    format: Format,
    /// Prints every event of a headless run as it happens, and at its end what each part of each mind says, on standard
    /// error; with JSON also as `events` and `minds`
    #[arg(short, long, requires = "headless")]
    verbose: bool,
    /// Prints nothing but errors: the exit code says how a headless run ended
    #[arg(short, long, requires = "headless", conflicts_with_all = ["verbose", "format"])]
    quiet: bool,
    /// Port of the studio on this computer; the first free one from 7878 unless given, 0 for any
    #[arg(long, conflicts_with = "headless")]
    port: Option<u16>,
    /// Seconds simulated per second in the studio, 0.1 to 20
    #[arg(
        long,
        value_name = "RATIO",
        default_value_t = 1.0,
        value_parser = parse::speed,
        allow_negative_numbers = true,
        conflicts_with = "headless"
    )]
    speed: f64,
}

/// What `cairn` does without a subcommand.
pub(crate) fn studio_with_doorbell() -> anyhow::Result<ExitCode> {
    let mission = Mission::load(FIRST_MISSION, &[])?;
    let seed = mission.seed();
    in_studio(mission, seed, Options { port: None, speed_ratio: 1.0 }, None)
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let mission = if args.quiet {
        given::mission_without_warnings(&args.mission, &args.overrides)?
    } else {
        given::mission(&args.mission, &args.overrides)?
    };
    let seed = args.seed.map_or_else(|| mission.seed(), RunSeed);
    let outputs = Outputs::new(args.force).keeping(mission.read_from());
    if let Some(path) = &args.record {
        outputs.check(path, Kind::RECORDING)?;
    }
    if args.headless {
        headless(mission, seed, args, &outputs)
    } else {
        let options = Options { port: args.port, speed_ratio: args.speed };
        let record = args.record.clone().map(|path| Recordings::new(path, outputs));
        in_studio(mission, seed, options, record)
    }
}

fn headless(
    mission: Mission,
    seed: RunSeed,
    args: &Args,
    outputs: &Outputs,
) -> anyhow::Result<ExitCode> {
    let bar = if args.quiet { ProgressBar::hidden() } else { progress(&mission) };
    let mut pace = mission.has_real_robot().then(Instant::now);
    let mut run = Run::new(mission, seed)?;
    let begin = |path: &PathBuf| Recorder::create(path, &run, outputs);
    let mut recorder = args.record.as_ref().map(begin).transpose()?;
    for left in recorder.iter().flat_map(Recorder::left_behind) {
        complain!(
            "cairn: {}, left by a run that was killed, is kept; cairn replay shows it",
            left.display()
        );
    }
    let mut events = Vec::new();
    let interrupt = Interrupt::listen()?;
    while if interrupt.happened() { run.step_to_rest() } else { run.step_to_end() } {
        if let Some(next) = &mut pace {
            wait_for_tick(next);
        }
        if recorder.is_some() || args.verbose {
            let said = run.drain_log();
            if let Some(recorder) = &mut recorder {
                record(recorder, &run, &said)?;
            }
            if args.verbose {
                bar.suspend(|| said.iter().for_each(output::event));
                events.extend(said);
            }
        }
        if run.steps().is_multiple_of(STEPS_PER_LOOK) {
            bar.set_position(run.steps());
        }
    }
    bar.finish_and_clear();
    if let Some(recorder) = recorder {
        recorder.finish(&run)?;
    }
    let summary = run.summary();
    // A decision program that nobody runs any more leaves no output on.
    run.close();
    if args.verbose {
        let said = run.drain_log();
        said.iter().for_each(output::event);
        events.extend(said);
        if args.format == Format::Text {
            output::minds(&run);
        }
    }
    match args.format {
        _ if args.quiet => {}
        Format::Text => output::summary(&summary, Format::Text),
        Format::Json => {
            let mut object = output::summary_json(&summary);
            if args.verbose {
                object["events"] = events.iter().map(output::event_json).collect();
                object["minds"] = output::minds_json(&run);
            }
            say!("{object}");
        }
    }
    if summary.verdict.is_none() {
        interrupt::tell("interrupted before there was a verdict");
        return Ok(ExitCode::from(interrupt::EXIT_CODE));
    }
    let passed = summary.verdict.is_some_and(|verdict| verdict.passed);
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Records a step. A disk that is full ends the run at once: a run that was to be recorded and is not is no success.
fn record(recorder: &mut Recorder, run: &Run, said: &[LogItem]) -> anyhow::Result<()> {
    recorder.record(run, said).with_context(|| {
        let (t_s, part) = (run.steps() as f64 * 0.01, recorder.part().display());
        format!("the recording stops after {t_s:.2} s; what was recorded until then is in {part}")
    })
}

/// Waits for the next tick of real time; a machine that is late goes on from where it is.
pub(crate) fn wait_for_tick(next: &mut Instant) {
    *next += TICK;
    match next.checked_duration_since(Instant::now()) {
        Some(rest) => std::thread::sleep(rest),
        None => *next = Instant::now(),
    }
}

/// A bar on standard error; invisible where that is no terminal.
pub(crate) fn progress(mission: &Mission) -> ProgressBar {
    let steps = mission.duration_max().as_millis() / 10;
    let bar = output::bar(u64::try_from(steps).unwrap_or(u64::MAX));
    let style = ProgressStyle::with_template("{prefix} {wide_bar} at most {eta} left");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.set_prefix(mission.name().to_owned());
    bar
}

fn in_studio(
    mission: Mission,
    seed: RunSeed,
    options: Options,
    record: Option<Recordings>,
) -> anyhow::Result<ExitCode> {
    let title = mission.title().to_owned();
    let show = Show::Mission { mission: Box::new(mission), seed, record };
    let interrupt = Interrupt::listen()?;
    let on_ready = |address| {
        say!("{title} (seed {})", seed.0);
        say!("The studio is at http://{address} — open it in a browser; Ctrl-C ends it.");
    };
    for path in studio::serve_until(show, options, on_ready, interrupt.wait())? {
        say!("Recorded in {}", path.display());
    }
    Ok(ExitCode::SUCCESS)
}
