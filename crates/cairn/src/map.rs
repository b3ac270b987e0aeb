//! `cairn map`: from a recording to a map, a corrected trajectory and a report.

mod inputs;
mod print;
mod show;
mod study;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::bail;
use clap::ValueEnum;
use files::{Kind, Outputs, Refusal};
use indicatif::{ProgressBar, ProgressStyle};
use surveys::{
    CHECKPOINT, Clock, FolderInput, Outcome, SUMMARY, Survey, SurveyConfig, SurveyState, Written,
};

use crate::output::{self, Format, say_raw};
use inputs::Inputs;

/// Scans between two looks at the clock.
const SCANS_PER_LOOK: usize = 8;

/// Maps a recording: reads a log of ranges and odometry, writes map, trajectory, graph and report
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn map freiburg-079.clf.gz\n  cairn map robot_state.mat --mode thesis -o thesis\n  \
    cairn map log.clf --relations log.relations --set map.resolution_m=0.1 --format json\n  \
    cairn map log.clf --sweep plan.toml --tune\n\n\
    Logs: CARMEN (FLASER or ROBOTLASER1 with ODOM), MRPT's laser text, MAT files of level 5 with\n\
    saved_readings and saved_pose, ARTEMIC's two texts, sonar text with a pose file, cairn's CSV and MCAP; each\n\
    also as gzip. What is wrong in a log is skipped or repaired, counted and listed in the report.\n\n\
    Nothing that exists is replaced without --force, and nothing that is read ever. Written into the folder\n\
    (which is made if there is none, but none above it), each file whole or not at all: map.pgm and map.yaml (as ROS's map server reads\n\
    them), map.png, trajectory.tum (a line for each scan: time of the log, x y z, quaternion), graph.g2o (with a\n\
    laser), report.html, summary.json, settings.toml (give it to --config to repeat the run).\n\n\
    A long run leaves its results so far in FOLDER/checkpoint every half minute; they are usable as they are. A\n\
    run that was killed is finished by the same command with --resume: it takes the settings of the\n\
    checkpoint, repeats the steps (a run is deterministic), makes sure that it comes by the checkpoint's poses\n\
    bit by bit, and goes on. A sweep goes on where it was when the same command is given again.\n\n\
    Exit code 0: mapped; 1: a sweep ended, but tuning reached its limit of rounds; 2: an error."
)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line are what they are")]
pub(crate) struct Args {
    /// The recording, or `-` for standard input
    #[arg(required_unless_present_any = ["keys", "show"])]
    log: Option<PathBuf>,
    /// The second file of formats that have two: poses beside ARTEMIC's readings or a sonar text
    log2: Option<PathBuf>,
    /// Who makes the map; by the rig unless given
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Form of the sonar method
    #[arg(long, value_enum)]
    mode: Option<Mode>,
    /// A map that is known already (map server's YAML), for the sonar method
    #[arg(long, value_name = "MAP.yaml")]
    prior: Option<PathBuf>,
    /// Where the robot is in the known map at the first scan; where its odometry says unless given
    #[arg(long, value_name = "X,Y,DEG", requires = "prior", value_parser = inputs::start, allow_hyphen_values = true)]
    start: Option<geometry::Se2>,
    /// True poses (`t x y yaw` or TUM lines) to compare with
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Measured relative poses (`t1 t2 dx dy dz roll pitch yaw`) to compare with
    #[arg(long, value_name = "FILE")]
    relations: Option<PathBuf>,
    /// Seconds to add to the relations' time; found by itself unless given
    #[arg(long, value_name = "S", requires = "relations", allow_negative_numbers = true)]
    relations_shift_s: Option<f64>,
    /// Which sonars took the readings, for files that do not say: listing8, artemic5, pioneer16, course8
    #[arg(long, value_name = "PRESET", value_parser = inputs::ring)]
    ring: Option<recordings::Ring>,
    /// Which robot of a recording of several
    #[arg(long, value_name = "NAME")]
    robot: Option<String>,
    /// Settings (TOML); --keys prints all of them
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Changes one setting; may be given several times
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    overrides: Vec<String>,
    /// Maps under many settings on all cores, as the plan (TOML) says; a table and the best settings come out
    #[arg(long, value_name = "PLAN.toml")]
    sweep: Option<PathBuf>,
    /// Looks for the best settings of the plan step by step (coordinate descent) instead of trying all
    #[arg(long, requires = "sweep")]
    tune: bool,
    /// Threads of a sweep; one per core unless given. The results do not depend on it
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        hide_default_value = true,
        requires = "sweep"
    )]
    threads: usize,
    /// The folder for the results; the log's name with `-map` unless given
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replaces results that are in the folder already; with --sweep, begins the sweep anew
    #[arg(long)]
    force: bool,
    /// Finishes a run that was killed, from the checkpoint in the folder
    #[arg(long, conflicts_with_all = ["overrides", "config", "method", "mode", "sweep"])]
    resume: bool,
    /// Seconds between two checkpoints; 0 for none
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = inputs::period)]
    checkpoint_s: f64,
    /// Shows in the browser how the map grows, instead of writing it; without a log the page asks for one
    #[arg(long, conflicts_with_all = ["sweep", "resume", "output", "format"])]
    show: bool,
    /// The page's port on this computer; the first free one from 7878 unless given, 0 for any
    #[arg(long, value_name = "N", requires = "show")]
    port: Option<u16>,
    /// How the end is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Prints every setting with its default, meaning and range, and ends
    #[arg(long)]
    keys: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Method {
    Laser,
    Sonar,
    Odometry,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Mode {
    Default,
    Graph,
    Thesis,
    Listing,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if args.keys {
        say_raw!("{}", SurveyConfig::template());
        return Ok(ExitCode::SUCCESS);
    }
    if args.show {
        let inputs = args.log.as_deref().map(|log| Inputs::read(args, log)).transpose()?;
        let (config, asked) = inputs::config(args)?;
        if let Some(inputs) = &inputs {
            inputs::refuse_unread(&config, &asked, inputs)?;
        }
        return show::main(args, inputs, config);
    }
    let Some(log) = &args.log else { bail!("give the recording that is to be mapped") };
    let (config, asked) = inputs::config(args)?;
    let folder = args.output.clone().unwrap_or_else(|| inputs::default_folder(log));
    let outputs = outputs(args, &folder)?;
    let inputs = Inputs::read(args, log)?;
    inputs::refuse_unread(&config, &asked, &inputs)?;
    if let Some(plan) = &args.sweep {
        return study::main(args, (&inputs, &config), plan, &folder, &outputs);
    }
    let (resumed, config) = if args.resume {
        let (state, config) = surveys::read_checkpoint(&folder, &inputs.recording)?;
        (Some(state), config)
    } else {
        (None, config)
    };
    let begun = Instant::now();
    let place = (folder.as_path(), &outputs);
    let (outcome, written) = run(args, &inputs, &config, place, resumed.as_ref())?;
    surveys::remove_checkpoint(&folder);
    let run_s = begun.elapsed().as_secs_f64();
    match args.format {
        Format::Text => print::text(&inputs, &outcome, &written, &folder, run_s),
        Format::Json => print::json(&written, &folder, run_s),
    }
    Ok(ExitCode::SUCCESS)
}

/// What the command may write. Everything that stands in the way is said before the work.
fn outputs(args: &Args, folder: &Path) -> anyhow::Result<Outputs> {
    let given = [&args.log, &args.log2, &args.prior, &args.truth, &args.relations, &args.config];
    let given = given.into_iter().flatten().chain(&args.sweep).cloned();
    let outputs = Outputs::new(args.force).keeping(given.chain(inputs::prior_picture(args)?));
    let checked = match (&args.sweep, args.resume) {
        (Some(_), _) => study::check(args, folder, &outputs),
        // The checkpoint is what this run goes on from.
        (None, true) => outputs.check_folder(folder, &[(SUMMARY, Kind::JSON)]),
        (None, false) => surveys::check_results(folder, &outputs),
    };
    match checked {
        Ok(()) => Ok(outputs),
        Err(Refusal::Exists { path }) if path.starts_with(folder.join(CHECKPOINT)) => bail!(
            "{} holds the checkpoint of a run that was killed; finish it with --resume, begin anew with --force, or \
             choose another folder with -o",
            folder.display()
        ),
        Err(Refusal::Exists { path }) => bail!(
            "{} holds results already ({} is there); choose another folder with -o, or replace them with --force",
            folder.display(),
            path.file_name().unwrap_or_default().display()
        ),
        Err(other) => Err(other.into()),
    }
}

/// A clock for the libraries, which have none of their own.
fn clock() -> Clock {
    let begun = Instant::now();
    Clock::new(move || begun.elapsed())
}

fn run(
    args: &Args,
    inputs: &Inputs,
    config: &SurveyConfig,
    (folder, outputs): (&Path, &Outputs),
    resumed: Option<&SurveyState>,
) -> anyhow::Result<(Outcome, Written)> {
    let prior = Inputs::prior(args, config)?;
    let mut survey =
        Survey::with_prior(Arc::clone(&inputs.recording), config.clone(), clock(), prior)?;
    let input = FolderInput {
        name: &inputs.name,
        source: &inputs.source,
        recording: &inputs.recording,
        config,
        known: &inputs.known,
        complaints: &inputs.complaints,
    };
    let bar = progress(inputs.recording.scans.len());
    let period = Duration::try_from_secs_f64(args.checkpoint_s).unwrap_or_default();
    let mut saved = Instant::now();
    while survey.progress().n_done < survey.progress().n_scans {
        let n_done = survey.progress().n_done;
        if let Some(state) = resumed.filter(|state| state.n_done == n_done) {
            state.check(&survey.outcome_so_far()?)?;
        }
        survey.step()?;
        if n_done % SCANS_PER_LOOK == 0 {
            bar.set_position(n_done as u64);
            if !period.is_zero() && saved.elapsed() >= period {
                surveys::write_checkpoint(folder, &input, &survey.outcome_so_far()?)?;
                saved = Instant::now();
            }
        }
    }
    bar.set_message("the last loops, and the files");
    bar.tick();
    survey.complete()?;
    let outcome = survey.outcome_so_far()?;
    let written = surveys::write_results(folder, &input, &outcome, outputs)?;
    bar.finish_and_clear();
    Ok((outcome, written))
}

/// A bar on standard error; invisible where that is no terminal.
fn progress(n_scans: usize) -> ProgressBar {
    let bar = output::bar(n_scans as u64);
    let style = "{wide_bar} {pos}/{len} scans, {per_sec}, {eta} left {msg}";
    if let Ok(style) = ProgressStyle::with_template(style) {
        bar.set_style(style);
    }
    bar
}
