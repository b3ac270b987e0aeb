//! Rules about the whole program: who writes what, and whether it can ever matter.
//!
//! Every rule reports and goes on; none can fail. All but the oscillator rule are warnings: such
//! a program runs, but hardly as meant.

use crate::{
    Code, Family, Function, Mnemonic, N_RESOURCES, Operand, ResourceId, Role,
    diagnostics::{Place, Problems},
    estimate::N_FUNCTIONS_MAX,
    image::IMAGE_BYTES_MAX,
    instruction_set::Acts,
};

/// An oscillator has no use for an edge.
pub(crate) fn check_oscillator(function: &Function, problems: &mut Problems) {
    if function.mnemonic != Mnemonic::Timer || function.constant(Role::TimerType) != Some(1) {
        return;
    }
    if let Some(edge) = operand(function, Role::Edge)
        && matches!(edge.immediate(), Some(1 | 2))
    {
        let message = format!("an oscillator cannot run on the edge {}", edge.text);
        let hint = || Some("use 0 to run while INPUT is 0, or 3 while it is 1".to_owned());
        problems.report(Code::OscillatorOnEdge, place(edge), message, hint);
    }
}

/// Rules that hold for the correct lines of a program, even when other lines are wrong.
pub(crate) fn check(functions: &[Function], problems: &mut Problems) {
    check_lost_writes(functions, problems);
    check_timers(functions, problems);
    check_conditions(functions, problems);
    check_capacity(functions, problems);
}

/// Rules that need every line: whether something is written anywhere.
pub(crate) fn check_whole(functions: &[Function], problems: &mut Problems) {
    let mut written = PerResource::new();
    for function in functions {
        writes(function).for_each(|write| written.set(write.id, function.line));
    }
    let mut reported = PerResource::new();
    for function in functions {
        let reads = function.operands.iter().filter(|operand| !operand.role.is_destination());
        for (operand, id) in reads.filter_map(|operand| Some((operand, operand.resource()?))) {
            let source = if id.family() == Family::State { ResourceId::STATUS } else { id };
            if is_left_to_program(source) && written.get(source).is_none() {
                let is_trigger = function.mnemonic == Mnemonic::Move;
                if is_trigger || reported.get(id).is_none() {
                    report_unwritten(operand, id, is_trigger, problems);
                    reported.set(id, function.line);
                }
            }
        }
    }
}

/// Whether only the program itself gives it a value.
fn is_left_to_program(id: ResourceId) -> bool {
    use Family::{General, Memory, Output, Status, TimerOutput};
    matches!(id.family(), General | Memory | Output | Status | TimerOutput)
}

fn report_unwritten(operand: &Operand, id: ResourceId, is_trigger: bool, problems: &mut Problems) {
    let place = place(operand);
    if is_trigger {
        let message = format!("nothing writes {id}, so this MOVE never happens");
        let hint = || Some(format!("write {id}, or use another trigger"));
        return problems.report(Code::TriggerNeverWritten, place, message, hint);
    }
    match id.family() {
        Family::TimerOutput => {
            let message = format!("no TIMER {} drives {id}", id.number());
            let hint = || Some(format!("start it with `TIMER {},…`", id.number()));
            problems.report(Code::TimerNeverStarted, place, message, hint);
        }
        Family::State => {
            let message = format!("nothing writes STATUS, so {id} never changes");
            let hint = || Some("write STATUS, for example with STIC".to_owned());
            problems.report(Code::NeverWritten, place, message, hint);
        }
        _ => {
            let message = format!("{id} is read, but nothing writes it: it stays 0");
            problems.report(Code::NeverWritten, place, message, || None);
        }
    }
}

struct Write<'f> {
    id: ResourceId,
    place: Place,
    /// Whether it happens in every scan.
    always: bool,
    operand: &'f Operand,
}

/// What a function writes. `TIMER` writes the output of its timer.
fn writes(function: &Function) -> impl Iterator<Item = Write<'_>> {
    let always = function.mnemonic.acts() == Acts::EachScan;
    function.operands.iter().filter_map(move |operand| {
        let id = match operand.role {
            Role::TimerNumber => {
                let number = operand.immediate().and_then(|number| u8::try_from(number).ok())?;
                ResourceId::of(Family::TimerOutput, number)?
            }
            role if role.is_destination() => operand.resource()?,
            _ => return None,
        };
        Some(Write { id, place: place(operand), always, operand })
    })
}

fn check_lost_writes(functions: &[Function], problems: &mut Problems) {
    let mut written = PerResource::new();
    for function in functions {
        for write in writes(function).filter(|write| write.operand.role != Role::TimerNumber) {
            if let (true, Some(line)) = (write.always, written.get(write.id)) {
                let id = write.id;
                let message = format!("{id} is already written in line {line}: that value is lost");
                let hint = || Some("write to different resources and combine them".to_owned());
                problems.report(Code::LostWrite, write.place, message, hint);
            }
            written.set(write.id, function.line);
        }
    }
}

fn check_timers(functions: &[Function], problems: &mut Problems) {
    let mut started = PerResource::new();
    for function in functions {
        for write in writes(function).filter(|write| write.operand.role == Role::TimerNumber) {
            if let Some(line) = started.get(write.id) {
                let number = write.id.number();
                let message = format!("timer {number} is already used in line {line}");
                let hint = || Some("give each TIMER a number of its own".to_owned());
                problems.report(Code::TimerReused, write.place, message, hint);
            }
            started.set(write.id, function.line);
        }
    }
}

fn check_conditions(functions: &[Function], problems: &mut Problems) {
    for function in functions {
        let (Some(condition), Some(edge)) =
            (operand(function, Role::Condition), operand(function, Role::Edge))
        else {
            continue;
        };
        let (Some(id), Some(code)) = (condition.resource(), edge.immediate()) else {
            continue;
        };
        let is_level = code == 0 || code == 3;
        let (mnemonic, acts) = (function.mnemonic, function.mnemonic.acts());
        let never = match id {
            ResourceId::ZERO => code != 0,
            ResourceId::ONE => code != 3,
            _ => false,
        };
        if never {
            let message = format!("{id} is constant, EDGE {} never comes", edge.text);
            problems.report(Code::ConditionNeverTrue, place(condition), message, || None);
        } else if acts == Acts::OnEdges && is_level {
            let message = format!("{mnemonic} counts edges only, EDGE {} never counts", edge.text);
            let hint = || Some("use RISE or FALL".to_owned());
            problems.report(Code::ConditionNeverTrue, place(edge), message, hint);
        } else if is_level && acts == Acts::Outside {
            let message = format!("{mnemonic} acts in every scan while {id} is steady");
            let hint = || Some("use RISE or FALL to act once".to_owned());
            problems.report(Code::ActsEveryScan, place(edge), message, hint);
        }
    }
}

fn check_capacity(functions: &[Function], problems: &mut Problems) {
    if let Some(function) = functions.get(N_FUNCTIONS_MAX) {
        let n = functions.len();
        let message = format!("{n} functions: a scan takes more than 200 ms");
        let hint = || Some(format!("the target scans at most {N_FUNCTIONS_MAX} functions in time"));
        problems.report(Code::ScanTooLong, start_of(function), message, hint);
    }
    // The function ends at its address and size; one more byte ends the cycle.
    let end = |f: &Function| f.address.saturating_add(f.mnemonic.size_bytes()).saturating_add(1);
    if let Some(function) = functions.iter().find(|f| end(f) > IMAGE_BYTES_MAX) {
        let total = functions.last().map_or(0, end);
        let message = format!("the image has {total} bytes");
        let hint = || Some(format!("the target holds {IMAGE_BYTES_MAX}"));
        problems.report(Code::ImageTooLarge, start_of(function), message, hint);
    }
}

fn operand(function: &Function, role: Role) -> Option<&Operand> {
    function.operands.iter().find(|operand| operand.role == role)
}

fn place(operand: &Operand) -> Place {
    Place { span: operand.span, line: operand.line, column: operand.column }
}

/// The beginning of a function. Its column is that of its first operand, less the way there.
fn start_of(function: &Function) -> Place {
    let Some(first) = function.operands.first() else {
        return Place { span: function.span, line: function.line, column: 1 };
    };
    // Between mnemonic and first operand stand only ASCII characters: bytes are characters.
    let way = first.span.start.saturating_sub(function.span.start);
    let column = first.column.saturating_sub(way);
    Place { span: function.span, line: function.line, column }
}

/// A line number, or none, for every resource.
struct PerResource([Option<usize>; N_RESOURCES as usize]);

impl PerResource {
    fn new() -> Self {
        Self([None; N_RESOURCES as usize])
    }

    fn get(&self, id: ResourceId) -> Option<usize> {
        self.0.get(usize::from(id.address())).copied().flatten()
    }

    fn set(&mut self, id: ResourceId, line: usize) {
        if let Some(slot) = self.0.get_mut(usize::from(id.address())) {
            *slot = Some(line);
        }
    }
}
