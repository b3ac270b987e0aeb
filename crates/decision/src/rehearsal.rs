//! A program alone on the bench: inputs over time in, what it did out.
//!
//! A [`Script`] says when which input changes; [`rehearse`] runs a machine through it, one scan every
//! 10 ms, and gives a [`Row`] whenever something that is watched has changed or something has
//! happened. The same machine runs in missions; here nothing else is simulated, except that a `MOVE`
//! may be done after a fixed time.

use std::time::Duration;

use crate::{DateTime, Family, Machine, MoveReport, MoveState, ResourceId, Role, ValueKind};

/// Entries of a script at most.
const N_ENTRIES_MAX: usize = 100_000;
/// Latest time in a script, s: four weeks.
const TIME_MAX_S: f64 = 2_419_200.0;

/// What happens to a machine on the bench, and when.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// In order of time; equal times keep the order of the text.
    entries: Vec<(u64, Change)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Input(u8, bool),
    Analog(u8, u8),
    Report(MoveReport),
    Stop,
    Run,
    Reset,
    Stall(u64),
}

/// A script that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("entry {entry}, `{text}`: {problem}")]
pub struct ScriptError {
    /// Which entry, from 1; entries end at a `;` or at the end of a line.
    pub entry: usize,
    /// Its text.
    pub text: String,
    /// What is wrong, and what is allowed.
    pub problem: String,
}

impl Script {
    /// Reads a script: entries `TIME WHAT…`, one a line or separated by `;`, with times in seconds and
    /// comments from `#` to the end of the line. `WHAT` is `I0=1`, `A3=200`, `done` and `failed` (the last
    /// MOVE), `stop` and `run` (the program), `reset`, or `stall=SECONDS` (the loop stands still).
    ///
    /// # Errors
    ///
    /// [`ScriptError`] at the first entry that is something else.
    pub fn parse(text: &str) -> Result<Self, ScriptError> {
        let mut entries = Vec::new();
        let texts = text
            .lines()
            .map(|line| line.split_once('#').map_or(line, |(before, _)| before))
            .flat_map(|line| line.split(';'))
            .map(str::trim)
            .filter(|entry| !entry.is_empty());
        for (entry, text) in (1..).zip(texts) {
            let wrong = |problem: String| ScriptError { entry, text: text.to_owned(), problem };
            let mut words = text.split([' ', '\t', ',']).filter(|word| !word.is_empty());
            let tick = ticks(words.next().unwrap_or("")).ok_or_else(|| {
                wrong("it begins with a time in seconds, from 0 to 2419200, such as 2.5".to_owned())
            })?;
            let n_before = entries.len();
            for word in words {
                entries.push((tick, change(word).map_err(wrong)?));
            }
            if entries.len() == n_before {
                return Err(wrong("after the time comes what happens, such as I0=1".to_owned()));
            }
            if entries.len() > N_ENTRIES_MAX {
                return Err(wrong(format!("more than {N_ENTRIES_MAX} changes")));
            }
        }
        entries.sort_by_key(|&(tick, _)| tick);
        Ok(Self { entries })
    }

    /// The times (s, ascending, each once) of what does not happen in a rehearsal of that length, because it ends before.
    pub fn left_after(&self, duration: Duration) -> Vec<f64> {
        let n_ticks = whole_ticks(duration);
        let late = self.entries.iter().map(|&(tick, _)| tick).filter(|&tick| tick >= n_ticks);
        let mut times: Vec<f64> = late.map(|tick| tick as f64 / 100.0).collect();
        times.dedup();
        times
    }
}

/// Whole ticks of 10 ms in a number of seconds.
fn ticks(text: &str) -> Option<u64> {
    let seconds = text.parse::<f64>().ok().filter(|s| (0.0..=TIME_MAX_S).contains(s))?;
    // In range, and a cast of a float truncates.
    Some((seconds * 100.0).round() as u64)
}

fn whole_ticks(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis() / 10).unwrap_or(u64::MAX)
}

fn change(word: &str) -> Result<Change, String> {
    let allowed = "I0=1, A3=200, done, failed, stop, run, reset or stall=SECONDS";
    let unknown = || format!("`{word}` is none of {allowed}");
    let Some((name, value)) = word.split_once('=') else {
        return match word.to_ascii_lowercase().as_str() {
            "done" => Ok(Change::Report(MoveReport::Done)),
            "failed" => Ok(Change::Report(MoveReport::Failed)),
            "stop" => Ok(Change::Stop),
            "run" => Ok(Change::Run),
            "reset" => Ok(Change::Reset),
            _ => Err(unknown()),
        };
    };
    if name.eq_ignore_ascii_case("stall") {
        let n = ticks(value).ok_or_else(|| format!("`{value}` is no number of seconds"))?;
        return Ok(Change::Stall(n));
    }
    let id = ResourceId::by_name(name).map_err(|e| format!("`{name}`: {e}"))?;
    match (id.family(), value) {
        (Family::Input, "0") => Ok(Change::Input(id.number(), false)),
        (Family::Input, "1") => Ok(Change::Input(id.number(), true)),
        (Family::Input, _) => Err(format!("{id} is 0 or 1, not `{value}`")),
        (Family::Analog, _) => {
            let value =
                value.parse().map_err(|_unusable| format!("{id} is 0 to 255, not `{value}`"))?;
            Ok(Change::Analog(id.number(), value))
        }
        _ => Err(format!("{id} is no input: the field drives I0–I15 and A0–A7")),
    }
}

/// How a program is rehearsed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rehearsal {
    /// For how long.
    pub duration: Duration,
    /// What is shown in each row.
    pub watched: Vec<ResourceId>,
    /// Time after which a MOVE is done; `None`: when the script says so.
    pub move_takes: Option<Duration>,
}

/// One moment of a rehearsal in which something changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Since the beginning, s.
    pub t_s: f64,
    /// What the machine's clock shows.
    pub clock: String,
    /// The watched resources after the scan, in their order: a bit, or a number. Memory that the program
    /// writes as one bit is one; outputs are those in the field, which have their fail-safe values while no program
    /// drives them.
    pub values: Vec<u8>,
    /// The outputs in the field; bit n is output n.
    pub outputs: u16,
    /// What happened, in words.
    pub news: Vec<String>,
}

/// The resources of a program that a trace shows by itself: what it names of inputs and outputs, analog
/// inputs and `STATUS`, in the order of their addresses.
pub fn watched_by_default(machine: &Machine) -> Vec<ResourceId> {
    use Family::{Analog, Input, Output, Status};
    named(machine).filter(|id| matches!(id.family(), Input | Analog | Output | Status)).collect()
}

/// Every resource that a program names, in the order of their addresses.
pub fn watched_all(machine: &Machine) -> Vec<ResourceId> {
    named(machine).collect()
}

fn named(machine: &Machine) -> impl Iterator<Item = ResourceId> {
    let functions = machine.program().functions();
    let constant = |id: ResourceId| matches!(id.family(), Family::Zero | Family::One);
    let is_named = move |id: &ResourceId| {
        functions.iter().any(|function| {
            function.operands.iter().any(|operand| match operand.resource() {
                // A complement is seen at its input.
                Some(named) if named.family() == Family::NegatedInput => {
                    ResourceId::of(Family::Input, named.number()) == Some(*id)
                }
                Some(named) => named == *id,
                None => {
                    operand.role == Role::TimerNumber
                        && id.family() == Family::TimerOutput
                        && operand.immediate() == Some(id.number().into())
                }
            })
        })
    };
    ResourceId::all().filter(move |id| !constant(*id)).filter(is_named)
}

/// Runs a machine through a script; `show` takes each row as it comes. At the end the program is stopped, and
/// the last row has the outputs' fail-safe values. Gives how many MOVE were sent: one that another replaces in the
/// same scan is not.
///
/// As in a mission, a MOVE that is under way when the program stops driving the outputs has failed.
pub fn rehearse(
    machine: &mut Machine,
    script: &Script,
    plan: &Rehearsal,
    mut show: impl FnMut(&Row),
) -> u64 {
    let mut bench = Bench {
        n_moves_sent: 0,
        moved_at: None,
        stalled: 0,
        row: Row::default(),
        n_events: machine.n_events(),
        n_resets: machine.n_watchdog_resets(),
        is_faulted: machine.fault().is_some(),
        drove: machine.drives_outputs(),
    };
    let n_ticks = whole_ticks(plan.duration);
    let move_ticks = plan.move_takes.map(whole_ticks);
    let watched: Vec<(ResourceId, bool)> =
        plan.watched.iter().map(|&id| (id, is_bit(machine, id))).collect();
    let mut entries = script.entries.iter().peekable();
    let mut last = Row::default();
    for tick in 0..n_ticks {
        while let Some(&(_, change)) = entries.next_if(|(at, _)| *at <= tick) {
            bench.apply(machine, change);
        }
        if let (Some(after), Some(at)) = (move_ticks, bench.moved_at)
            && tick.saturating_sub(at) >= after
        {
            bench.report(machine, MoveReport::Done);
        }
        machine.tick_10ms();
        if machine.n_watchdog_resets() > bench.n_resets {
            // What the old program did ends before the new one acts.
            bench.stalled = 0;
            bench.hear_state(machine);
        }
        if bench.stalled > 0 {
            bench.stalled = bench.stalled.saturating_sub(1);
        } else {
            machine.scan();
        }
        bench.look(machine, tick, &watched);
        let row = &bench.row;
        if tick == 0
            || !row.news.is_empty()
            || (&row.values, row.outputs) != (&last.values, last.outputs)
        {
            show(row);
            last.clone_from(row);
        }
        bench.row.news.clear();
    }
    machine.stop();
    bench.look(machine, n_ticks, &watched);
    bench.row.news = vec!["the end: the outputs go to their fail-safe values".to_owned()];
    show(&bench.row);
    bench.n_moves_sent
}

/// What is kept from tick to tick.
struct Bench {
    n_moves_sent: u64,
    /// When the last MOVE was sent, while it is under way.
    moved_at: Option<u64>,
    /// Ticks for which the loop still stands.
    stalled: u64,
    row: Row,
    n_events: u64,
    n_resets: u64,
    is_faulted: bool,
    drove: bool,
}

impl Bench {
    fn tell(&mut self, text: impl Into<String>) {
        self.row.news.push(text.into());
    }

    fn apply(&mut self, machine: &mut Machine, change: Change) {
        match change {
            Change::Input(n, value) => machine.set_input(n, value),
            Change::Analog(n, value) => machine.set_analog(n, value),
            Change::Report(report) => self.report(machine, report),
            Change::Stop => {
                machine.stop();
                self.tell("the program is stopped (QRUN 0)");
            }
            Change::Run => {
                machine.run();
                self.tell("the program is set running (QRUN 1)");
            }
            Change::Reset => {
                machine.reset();
                self.moved_at = None;
                self.tell("the machine is reset");
            }
            Change::Stall(n) => {
                self.stalled = n;
                self.tell("the loop of the machine stands still");
            }
        }
    }

    fn report(&mut self, machine: &mut Machine, report: MoveReport) {
        let number = machine.n_moves();
        let what = if report == MoveReport::Done { "done" } else { "failed" };
        self.moved_at = None;
        if machine.report_move(number, report) {
            self.tell(format!("MOVE {number} is {what}"));
        } else {
            self.tell(format!("no MOVE is under way that could be {what}"));
        }
    }

    /// Takes what this tick has changed.
    fn look(&mut self, machine: &mut Machine, tick: u64, watched: &[(ResourceId, bool)]) {
        // Ticks are 10 ms; a quotient of whole numbers is the nearest number to it.
        self.row.t_s = tick as f64 / 100.0;
        self.row.clock = machine.clock().to_string();
        self.row.outputs = machine.outputs();
        self.row.values.clear();
        let value = |&(id, is_bit): &(ResourceId, bool)| {
            let byte = machine.resource(id);
            match id.family() {
                Family::Output => u8::from(machine.outputs() >> id.number() & 1 == 1),
                _ if is_bit => byte & 1,
                _ => byte,
            }
        };
        self.row.values.extend(watched.iter().map(value));
        let mut moves = Vec::new();
        machine.drain_moves(|goal| moves.push(goal));
        let last = machine.n_moves();
        for goal in moves {
            let (number, x, y, heading) = (goal.number, goal.x_mm, goal.y_mm, goal.heading_deg);
            if number < last {
                self.tell(format!(
                    "MOVE {number} is replaced by MOVE {last} in the same scan, and not sent"
                ));
                continue;
            }
            self.n_moves_sent = self.n_moves_sent.saturating_add(1);
            self.moved_at = Some(tick);
            self.tell(format!("MOVE {number} to ({x}, {y}) mm, {heading} deg"));
        }
        if machine.move_state() != MoveState::Busy {
            self.moved_at = None;
        }
        let n_new = machine.n_events().saturating_sub(self.n_events);
        self.n_events = machine.n_events();
        let n_old = machine.events().count().saturating_sub(usize::try_from(n_new).unwrap_or(0));
        for event in machine.events().skip(n_old) {
            let time: DateTime = event.clock;
            self.tell(format!("EVENT {}: {} at {time}", event.kind, event.resource));
        }
        self.hear_state(machine);
    }

    /// Whether the program drives the outputs, and what a change of that means.
    fn hear_state(&mut self, machine: &mut Machine) {
        let was_reset = machine.n_watchdog_resets() > self.n_resets;
        if was_reset {
            self.n_resets = machine.n_watchdog_resets();
            self.moved_at = None;
            self.tell("the watchdog restarts the program (R8004)");
        }
        if let Some(fault) = machine.fault().filter(|_| !self.is_faulted) {
            let (code, address, title) = (fault.code, fault.address, fault.code.title());
            self.tell(format!("{code} at byte {address}: {}", title.trim_end_matches('.')));
        }
        self.is_faulted = machine.fault().is_some();
        if self.drove && !machine.drives_outputs() {
            self.tell("the outputs go to their fail-safe values");
            let number = machine.n_moves();
            if machine.report_move(number, MoveReport::Failed) {
                self.moved_at = None;
                self.tell(format!("MOVE {number} is failed: the robot is told to stop"));
            }
        }
        self.drove = machine.drives_outputs();
    }
}

/// Whether a resource is shown as one bit: a boolean, or memory that the program writes as one.
fn is_bit(machine: &Machine, id: ResourceId) -> bool {
    let written_as = |role| {
        let mut operands = machine.program().functions().iter().flat_map(|f| &f.operands);
        operands.any(|operand| operand.role == role && operand.resource() == Some(id))
    };
    match id.value_kind() {
        ValueKind::Boolean => true,
        ValueKind::Number => false,
        ValueKind::Either => {
            written_as(Role::BooleanDestination)
                && !written_as(Role::NumberDestination)
                && !written_as(Role::ByteDestination)
        }
    }
}
