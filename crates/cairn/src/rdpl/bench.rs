//! `cairn rdpl FILE --run SECONDS`: a program alone, with inputs over time and a trace.

use std::{path::PathBuf, process::ExitCode, time::Duration};

use anyhow::{Context, bail};
use decision::{
    DateTime, Failsafe, Family, Machine, Mode, MovePoints, MoveSignal, Program, Rehearsal,
    ResourceId, Row, Script, rehearse, watched_all, watched_by_default,
};
use serde_json::{Map, Value, json};

use crate::{
    given,
    output::{Format, complain, say, table},
};

/// Bytes of a table of inputs that are read at most.
const TABLE_BYTES_MAX: u64 = 4 << 20;
/// Rows that are shown at most.
const N_ROWS_MAX: usize = 20_000;
/// Seconds that are rehearsed at most: a week.
const RUN_MAX_S: f64 = 604_800.0;

/// Options of a rehearsal.
#[derive(Debug, clap::Args)]
pub(super) struct BenchArgs {
    /// Runs the program alone for so many seconds and prints what changed; writes no image and no listing
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) run: Option<Duration>,
    /// What happens when: "2 I0=1; 2.5 I0=0 A0=200; 9 done"; may be given several times
    #[arg(long, value_name = "TABLE", requires = "run")]
    input: Vec<String>,
    /// The same from a file, one moment a line; `-` is standard input
    #[arg(long, value_name = "FILE", requires = "run")]
    inputs: Option<PathBuf>,
    /// Resources to show, such as Y1,YTMR16,STATUS, or `all`; inputs, outputs and STATUS unless given
    #[arg(long, value_name = "NAMES", requires = "run")]
    watch: Option<String>,
    /// Inputs that say what became of a MOVE: "busy=6,done=4,failed=5", and "pulse" for one scan
    #[arg(long, value_name = "POINTS", requires = "run")]
    points: Option<String>,
    /// Every MOVE is done after so many seconds, unless the table says otherwise before
    #[arg(long, value_name = "SECONDS", requires = "run", value_parser = seconds)]
    move_takes: Option<Duration>,
    /// What outputs do while no program drives them: "O1=on,O2=hold"; all others go off
    #[arg(long, value_name = "OUTPUTS", requires = "run")]
    failsafe: Option<String>,
    /// What the machine's clock shows at the beginning: 07:30, or "2026-03-01 07:30:00"
    #[arg(long, value_name = "TIME", requires = "run")]
    clock: Option<String>,
    /// After so many seconds the watchdog restarts a loop that stands still; 0: never
    #[arg(long, value_name = "SECONDS", requires = "run", value_parser = seconds)]
    watchdog: Option<Duration>,
}

/// A number of seconds on the command line.
fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.parse::<f64>().ok().filter(|s| (0.0..=RUN_MAX_S).contains(s));
    let value = value.ok_or_else(|| format!("it must be from 0 to {RUN_MAX_S} s"))?;
    Ok(Duration::from_secs_f64(value))
}

/// Runs the program and prints the trace, as JSON with the compiler's `problems`; exit code 1 when it stands on an
/// error at the end.
pub(super) fn main(
    args: &BenchArgs,
    (program, mode): (&Program, Mode),
    format: Format,
    problems: Value,
) -> anyhow::Result<ExitCode> {
    let Some(duration) = args.run else { return Ok(ExitCode::SUCCESS) };
    let mut machine = machine(args, program, mode)?;
    let script = Script::parse(&script(args)?).context("in the table of inputs")?;
    for late_s in script.left_after(duration) {
        complain!(
            "cairn: warning: what the table of inputs has at {late_s} s never happens: the run ends after {} s (--run)",
            duration.as_secs_f64()
        );
    }
    let watched = watched(args, &machine)?;
    let plan = Rehearsal { duration, watched, move_takes: args.move_takes };
    let (mut rows, mut n_rows) = (Vec::new(), 0_usize);
    let n_moves = rehearse(&mut machine, &script, &plan, |row| {
        n_rows += 1;
        if rows.len() < N_ROWS_MAX {
            rows.push(row.clone());
        }
    });
    let n_left = n_rows - rows.len();
    match format {
        Format::Text => print_text((&machine, n_moves), &plan, &rows, n_left),
        Format::Json => {
            let mut object = as_json((&machine, n_moves), &plan, &rows, n_left);
            object["diagnostics"] = problems;
            say!("{object}");
        }
    }
    Ok(if machine.fault().is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn machine(args: &BenchArgs, program: &Program, mode: Mode) -> anyhow::Result<Machine> {
    let mut machine = Machine::new(program.clone(), mode);
    if let Some(text) = &args.points {
        machine.set_move_points(points(text)?);
    }
    if let Some(text) = &args.failsafe {
        machine.set_failsafe(failsafe(text)?);
    }
    if let Some(after) = args.watchdog {
        machine.set_watchdog(after);
    }
    if let Some(text) = &args.clock
        && !DateTime::parse(text).is_some_and(|clock| machine.set_clock(clock))
    {
        bail!("--clock {text}: it is a time such as 07:30, or such as \"2026-03-01 07:30:00\"");
    }
    Ok(machine)
}

/// The parts of a list: words separated by commas or blanks, `NAME=VALUE` or a name alone.
fn pairs(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let words = text.split([',', ' ']).filter(|word| !word.is_empty());
    words.map(|word| word.split_once('=').unwrap_or((word, "")))
}

fn points(text: &str) -> anyhow::Result<MovePoints> {
    let mut points = MovePoints::default();
    for (name, value) in pairs(text) {
        let place = match (name, value) {
            ("pulse", "") => {
                points.signal = MoveSignal::Pulse;
                continue;
            }
            ("busy", _) => &mut points.busy,
            ("done" | "arrived", _) => &mut points.done,
            ("failed", _) => &mut points.failed,
            _ => {
                let meant = settings::did_you_mean(name, ["busy", "done", "failed", "pulse"]);
                let meant =
                    meant.map(|meant| format!("; did you mean `{meant}`?")).unwrap_or_default();
                bail!("--points {text}: `{name}` is none of busy, done, failed and pulse{meant}")
            }
        };
        let number = value.trim_start_matches(['I', 'i']).parse::<u8>().ok().filter(|n| *n < 16);
        let Some(number) = number else {
            bail!("--points {text}: `{name}` is an input from 0 to 15, not `{value}`");
        };
        *place = Some(number);
    }
    let mut inputs: Vec<u8> =
        [points.busy, points.done, points.failed].into_iter().flatten().collect();
    let n = inputs.len();
    inputs.sort_unstable();
    inputs.dedup();
    if inputs.len() < n {
        bail!("--points {text}: each point has an input of its own");
    }
    Ok(points)
}

fn failsafe(text: &str) -> anyhow::Result<Failsafe> {
    let mut failsafe = Failsafe::default();
    for (name, value) in pairs(text) {
        let id = ResourceId::by_name(name).ok().filter(|id| id.family() == Family::Output);
        let Some(id) = id else {
            bail!("--failsafe {text}: `{name}` is no output; outputs are O0 to O15");
        };
        let bit = 1 << id.number();
        match value {
            "off" => {}
            "on" => failsafe.on |= bit,
            "hold" => failsafe.hold |= bit,
            _ => bail!("--failsafe {text}: {id} is off, on or hold, not `{value}`"),
        }
    }
    Ok(failsafe)
}

/// What is given of the table of inputs, put together.
fn script(args: &BenchArgs) -> anyhow::Result<String> {
    let mut text = args.input.join("\n");
    if let Some(path) = &args.inputs {
        let bytes = if given::is_stdin(path) {
            given::stdin(TABLE_BYTES_MAX)?
        } else {
            let limit = files::Limit::bytes(TABLE_BYTES_MAX);
            files::read(path, "the table of inputs", limit, &mut |_, _| ())?
        };
        text.push('\n');
        text.push_str(&decision::read_source(&bytes).text);
    }
    Ok(text)
}

fn watched(args: &BenchArgs, machine: &Machine) -> anyhow::Result<Vec<ResourceId>> {
    let Some(text) = &args.watch else { return Ok(watched_by_default(machine)) };
    if text.eq_ignore_ascii_case("all") {
        return Ok(watched_all(machine));
    }
    let id = |(name, _): (&str, &str)| {
        ResourceId::by_name(name).with_context(|| format!("--watch {text}: `{name}`"))
    };
    pairs(text).map(id).collect()
}

fn print_text((machine, n_moves): (&Machine, u64), plan: &Rehearsal, rows: &[Row], n_left: usize) {
    let mut lines = vec![vec!["time_s".to_owned()]];
    if let Some(head) = lines.first_mut() {
        head.extend(plan.watched.iter().map(ToString::to_string));
        head.push("what happened".to_owned());
    }
    for row in rows {
        let mut cells = vec![format!("{:.2}", row.t_s)];
        cells.extend(row.values.iter().map(ToString::to_string));
        cells.push(row.news.join("; "));
        lines.push(cells);
    }
    table(&lines);
    if n_left > 0 {
        say!("… and {n_left} rows more; the first {N_ROWS_MAX} are shown");
    }
    say!(
        "\n{} scans, {} MOVE, {} events, {} restarts by the watchdog. The clock shows {}.",
        machine.n_scans(),
        n_moves,
        machine.n_events(),
        machine.n_watchdog_resets(),
        machine.clock()
    );
    match machine.fault() {
        Some(fault) => say!("It stopped with {} at byte {}.", fault.code, fault.address),
        None => say!("No error."),
    }
}

fn as_json(
    (machine, n_moves): (&Machine, u64),
    plan: &Rehearsal,
    rows: &[Row],
    n_left: usize,
) -> Value {
    let row = |row: &Row| {
        let values: Map<String, Value> = plan
            .watched
            .iter()
            .zip(&row.values)
            .map(|(id, value)| (id.to_string(), json!(value)))
            .collect();
        json!({
            "t_s": row.t_s,
            "clock": row.clock,
            "values": values,
            "outputs": row.outputs,
            "news": row.news,
        })
    };
    json!({
        "rows": rows.iter().map(row).collect::<Vec<_>>(),
        "rows_left_out": n_left,
        "scans": machine.n_scans(),
        "moves": n_moves,
        "last_move": machine.move_state().name(),
        "events": machine.n_events(),
        "watchdog_resets": machine.n_watchdog_resets(),
        "clock": machine.clock().to_string(),
        "fault": machine.fault().map(|fault| fault.code.id()),
    })
}
