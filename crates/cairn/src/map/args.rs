//! What `cairn map` may be told.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use geometry::Se2;
use recordings::Ring;
use surveys::{KeyKind, SurveyConfig};

use crate::output::Format;

/// Maps a recording: reads a log of ranges and odometry, writes map, trajectory, graph and report
#[derive(Debug, clap::Args)]
#[command(after_help = help())]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line are what they are")]
pub(crate) struct Args {
    /// The recording, or `-` for standard input
    #[arg(required_unless_present_any = ["keys", "show"])]
    pub(super) log: Option<PathBuf>,
    /// The second file of formats that have two, see below
    pub(super) log2: Option<PathBuf>,
    /// Who makes the map; by the rig unless given
    #[arg(long, value_parser = words_of("survey.method"))]
    pub(super) method: Option<String>,
    /// Form of the sonar method
    #[arg(long, value_parser = words_of("survey.mode"))]
    pub(super) mode: Option<String>,
    /// A map that is known already (map server's YAML), for the sonar method
    #[arg(long, value_name = "MAP.yaml")]
    pub(super) prior: Option<PathBuf>,
    /// Where the robot is in the known map at the first scan; where its odometry says unless given
    #[arg(long, value_name = "X,Y,DEG", requires = "prior", value_parser = start, allow_hyphen_values = true)]
    pub(super) start: Option<geometry::Se2>,
    /// True poses (`t x y yaw` or TUM lines) to compare with
    #[arg(long, value_name = "FILE")]
    pub(super) truth: Option<PathBuf>,
    /// Measured relative poses (`t1 t2 dx dy dz roll pitch yaw`) to compare with
    #[arg(long, value_name = "FILE")]
    pub(super) relations: Option<PathBuf>,
    /// Seconds to add to the relations' time; found by itself unless given
    #[arg(long, value_name = "S", requires = "relations", allow_negative_numbers = true)]
    pub(super) relations_shift_s: Option<f64>,
    #[arg(long, value_name = "PRESET", value_parser = ring, help = ring_help())]
    pub(super) ring: Option<recordings::Ring>,
    /// Which robot of a recording of several; robot/laser for one of its lasers
    #[arg(long, visible_alias = "sensor", value_name = "NAME")]
    pub(super) robot: Option<String>,
    /// Settings (TOML); --keys prints all of them
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Changes one setting; may be given several times
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    pub(super) overrides: Vec<String>,
    /// Maps under many settings on all cores, as the plan (TOML) says; a table and the best settings come out
    #[arg(long, value_name = "PLAN.toml")]
    pub(super) sweep: Option<PathBuf>,
    /// Looks for the best settings of the plan step by step (coordinate descent) instead of trying all
    #[arg(long, requires = "sweep")]
    pub(super) tune: bool,
    /// Threads of a sweep; one per core unless given. The results do not depend on it
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        hide_default_value = true,
        requires = "sweep"
    )]
    pub(super) threads: usize,
    /// The folder for the results; the log's name with `-map` unless given
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: Option<PathBuf>,
    /// Replaces results that are in the folder already; with --sweep, begins the sweep anew
    #[arg(long)]
    pub(super) force: bool,
    /// Finishes a run that was killed, from the checkpoint in the folder
    #[arg(long, conflicts_with_all = ["overrides", "config", "method", "mode", "sweep"])]
    pub(super) resume: bool,
    /// Seconds between two checkpoints; 0 for none
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = period)]
    pub(super) checkpoint_s: f64,
    /// Shows in the browser how the map grows, instead of writing it; without a log the page asks for one
    #[arg(long, conflicts_with_all = ["sweep", "resume", "output", "format"])]
    pub(super) show: bool,
    /// The page's port on this computer; the first free one from 7878 unless given, 0 for any
    #[arg(long, value_name = "N", requires = "show")]
    pub(super) port: Option<u16>,
    /// How the end is printed
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// Prints every setting with its default, meaning and range, and ends
    #[arg(long)]
    pub(super) keys: bool,
}

const EXAMPLES: &str = "Examples:\n  cairn map freiburg-079.clf.gz\n  cairn map robot_state.mat --mode thesis -o thesis\n  \
    cairn map log.clf --relations log.relations --set map.resolution_m=0.1 --format json\n  \
    cairn map log.clf --sweep plan.toml --tune";

const WRITTEN: &str = "Nothing that exists is replaced without --force, and nothing that is read ever. Written into the folder\n\
    (which is made if there is none, but none above it), each file whole or not at all: map.pgm and map.yaml (as ROS's map server reads\n\
    them), map.png, trajectory.tum (a line for each scan: time of the log, x y z, quaternion), graph.g2o (with a\n\
    laser), report.html, summary.json, settings.toml (give it to --config to repeat the run).\n\n\
    A long run leaves its results so far in FOLDER/checkpoint every half minute; they are usable as they are. A\n\
    run that was killed is finished by the same command with --resume: it takes the settings of the\n\
    checkpoint, repeats the steps (a run is deterministic), makes sure that it comes by the checkpoint's poses\n\
    bit by bit, and goes on. A sweep goes on where it was when the same command is given again.\n\n\
    Exit code 0: mapped; 1: a sweep ended, but tuning reached its limit of rounds; 2: an error.";

/// What stands below the options: examples, every format of logs, and what is written.
fn help() -> String {
    let line = |format: &recordings::Format| {
        let name = format!("{format} ({})", format.endings().join(", "));
        let second = format.second().map(|what| format!("; second file: {what}"));
        let known_by = format.known_by().replace('`', "");
        format!("  {name:<27} {known_by}{}\n", second.unwrap_or_default())
    };
    let logs: String = recordings::Format::ALL.iter().map(line).collect();
    format!(
        "{EXAMPLES}\n\nLogs, each also as gzip; what a file is says its content, not its name:\n{logs}\n\
         What is wrong in a log is skipped or repaired, counted and listed in the report.\n\n{WRITTEN}"
    )
}

/// The words that a setting may have.
fn words_of(name: &str) -> PossibleValuesParser {
    let key = SurveyConfig::keys().find(|key| key.name == name);
    let words = key.and_then(|key| match key.kind {
        KeyKind::Choice(words) => Some(words),
        _ => None,
    });
    PossibleValuesParser::new(words.unwrap_or_default().iter().copied())
}

/// A pose on the command line.
fn start(text: &str) -> Result<Se2, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [x_m, y_m, deg] if numbers.iter().all(|v| v.is_finite() && v.abs() <= 1e6) => {
            Ok(Se2::new(x_m, y_m, deg.to_radians()))
        }
        _ => {
            Err("must be three numbers, x and y in metres and degrees, such as 1.5,-2,90"
                .to_owned())
        }
    }
}

/// A ring on the command line.
fn ring(text: &str) -> Result<Ring, String> {
    Ring::by_name(text).ok_or_else(|| {
        let names = Ring::NAMED.iter().flat_map(|ring| [Some(ring.name()), ring.also()]).flatten();
        let meant =
            settings::did_you_mean(text, names).map(|meant| format!("; did you mean {meant}?"));
        format!("must be {}{}", rings("or"), meant.unwrap_or_default())
    })
}

fn rings(word: &str) -> String {
    let named = |ring: &Ring| match ring.also() {
        Some(also) => format!("{} (or {also}, as missions say)", ring.name()),
        None => ring.name().to_owned(),
    };
    crate::parse::listed(&Ring::NAMED.iter().map(named).collect::<Vec<_>>(), word)
}

fn ring_help() -> String {
    format!("Which sonars took the readings, for files that do not say: {}", rings("or"))
}

/// Seconds between checkpoints.
fn period(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..=86_400.0).contains(value));
    value.ok_or_else(|| "must be a number of seconds from 0 to 86400".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_on_the_command_line_have_three_numbers() {
        let pose = start("1.5, -2,90").unwrap();
        assert_eq!((pose.x_m, pose.y_m), (1.5, -2.0));
        assert!((pose.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        for wrong in ["", "1,2", "1,2,3,4", "1,x,3", "1,inf,3", "nan,0,0"] {
            assert!(start(wrong).is_err(), "{wrong}");
        }
        assert!(period("-1").is_err() && period("nan").is_err() && period("0").is_ok());
        assert!(ring("listing9").unwrap_err().contains("listing8"));
    }
}
