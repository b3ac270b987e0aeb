//! What each function looks like: its shape, pins and texts.

use std::time::Duration;

use crate::{Family, Function, Mnemonic, Operand, ResourceId, Role};

/// Distance between pins, px.
pub(super) const PIN_PX: i32 = 20;
/// Width of a character, px.
pub(super) const CHAR_PX: i32 = 7;
/// Length of the line at an output, px.
pub(super) const STUB_PX: i32 = 14;
const GATE_WIDTH_PX: i32 = 60;
const BOX_WIDTH_PX: i32 = 116;
/// Where the first pin of a box is, px below its top: below the title.
const BOX_FIRST_PIN_PX: i32 = 35;
const TEXT_LINE_PX: i32 = 15;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    And,
    Or,
    Xor,
    Comparator,
    Box,
}

/// Where a signal enters or leaves a symbol.
#[derive(Clone, Debug)]
pub(super) struct Pin {
    pub(super) id: ResourceId,
    /// The name to write when no wire comes.
    pub(super) label: String,
    /// Written inside the symbol.
    pub(super) mark: String,
    /// px below the top of the symbol.
    pub(super) y: i32,
}

/// A function as a symbol, not placed yet.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) line: usize,
    /// The function as written.
    pub(super) tooltip: String,
    pub(super) shape: Shape,
    pub(super) inverted: bool,
    pub(super) title: String,
    pub(super) texts: Vec<String>,
    pub(super) inputs: Vec<Pin>,
    pub(super) outputs: Vec<Pin>,
    /// px.
    pub(super) width: i32,
    /// px.
    pub(super) height: i32,
}

pub(super) fn node(function: &Function, source: &str) -> Node {
    let mnemonic = function.mnemonic;
    let shape = match mnemonic {
        Mnemonic::And | Mnemonic::Nand => Shape::And,
        Mnemonic::Or | Mnemonic::Nor => Shape::Or,
        Mnemonic::Xor => Shape::Xor,
        Mnemonic::Acomp => Shape::Comparator,
        _ => Shape::Box,
    };
    let text = source.get(function.span.start..function.span.end).unwrap_or_default();
    let mut node = Node {
        line: function.line,
        tooltip: format!("line {}: {}", function.line, text.trim()),
        shape,
        inverted: matches!(mnemonic, Mnemonic::Nand | Mnemonic::Nor),
        title: mnemonic.name().to_owned(),
        texts: Vec::new(),
        inputs: inputs(function),
        outputs: outputs(function),
        width: if shape == Shape::Box { BOX_WIDTH_PX } else { GATE_WIDTH_PX },
        height: 0,
    };
    describe(function, &mut node);
    place_pins(&mut node);
    node
}

fn place_pins(node: &mut Node) {
    let n_rows = node.inputs.len().max(node.outputs.len()).max(1);
    let rows = pixels(n_rows).saturating_mul(PIN_PX);
    let first = if node.shape == Shape::Box {
        let texts = pixels(node.texts.len()).saturating_mul(TEXT_LINE_PX);
        node.height = BOX_FIRST_PIN_PX.saturating_add(rows).saturating_add(texts);
        BOX_FIRST_PIN_PX
    } else {
        node.height = rows.saturating_add(10);
        15
    };
    let row = |i: usize| first.saturating_add(pixels(i).saturating_mul(PIN_PX));
    for (i, pin) in node.inputs.iter_mut().enumerate() {
        pin.y = row(i);
    }
    // The output of a gate leaves at its middle, that of a box beside its first input.
    let middle = node.height / 2;
    for (i, pin) in node.outputs.iter_mut().enumerate() {
        pin.y = if node.shape == Shape::Box { row(i) } else { middle };
    }
}

/// A number of things as a number of pixels; there are never so many that it matters.
pub(super) fn pixels(n: usize) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

fn pin(id: ResourceId, written: &str, mark: String) -> Pin {
    let name = id.to_string();
    // `UP` and `DOWN` are the constants 1L and 0L, but say more.
    let label = match written.to_ascii_uppercase() {
        upper if upper == name || upper == "UP" || upper == "DOWN" => upper,
        _ => format!("{written} ({name})"),
    };
    Pin { id, label, mark, y: 0 }
}

fn inputs(function: &Function) -> Vec<Pin> {
    let neutral = function.mnemonic.neutral();
    let read = |operand: &&Operand| !operand.role.is_destination();
    let pins = function.operands.iter().filter(read);
    let pins = pins.filter_map(|operand| Some((operand, operand.resource()?)));
    let mut found: Vec<Pin> = pins
        .clone()
        .filter(|&(_, id)| Some(id) != neutral)
        .map(|(operand, id)| pin(id, &operand.text, mark(function, operand)))
        .collect();
    if found.is_empty() {
        found.extend(pins.take(1).map(|(operand, id)| pin(id, &operand.text, String::new())));
    }
    found
}

/// What is written beside a pin: its name where it matters, and the edge it waits for.
fn mark(function: &Function, operand: &Operand) -> String {
    match (function.mnemonic, operand.role, operand.name) {
        (Mnemonic::Acomp, _, "OP1") => "+".to_owned(),
        (Mnemonic::Acomp, _, _) => "−".to_owned(),
        (_, Role::Condition, name) => {
            let edge = match function.constant(Role::Edge) {
                Some(1) => "↑",
                Some(2) => "↓",
                Some(3) => "=1",
                _ => "=0",
            };
            format!("{edge} {}", name.to_ascii_lowercase())
        }
        (_, Role::Boolean, name) if name.starts_with("OP") => String::new(),
        (_, _, name) if name.len() == 1 => name.to_owned(),
        (_, _, name) => name.to_ascii_lowercase(),
    }
}

fn outputs(function: &Function) -> Vec<Pin> {
    let destinations = function.operands.iter().filter(|operand| operand.role.is_destination());
    let timer = function.timer().and_then(|n| ResourceId::of(Family::TimerOutput, n));
    let timer = timer.map(|id| pin(id, &id.to_string(), String::new()));
    let mark = |operand: &Operand| match operand.name {
        "DESTH" => "high".to_owned(),
        "DESTL" => "low".to_owned(),
        _ => String::new(),
    };
    let named = destinations.filter_map(|o| Some(pin(o.resource()?, &o.text, mark(o))));
    timer.into_iter().chain(named).collect()
}

/// Title and texts of a box.
fn describe(function: &Function, node: &mut Node) {
    let number = |role| function.constant(role).unwrap_or(0);
    match function.mnemonic {
        Mnemonic::Timer => {
            let timer = number(Role::TimerNumber);
            node.title = format!("TIMER {timer}");
            let kind = if number(Role::TimerType) == 1 { "⎍" } else { "⊓" };
            let time = function.timer_time().unwrap_or_default();
            node.texts = vec![format!("{kind} {}", time_text(time))];
        }
        Mnemonic::Move => {
            let goal = function.operands.iter().filter_map(Operand::immediate).take(3);
            let units = [("x", "mm"), ("y", "mm"), ("θ", "°")];
            let texts = units.iter().zip(goal);
            node.texts =
                texts.map(|((name, unit), value)| format!("{name} {value} {unit}")).collect();
        }
        Mnemonic::Dcomp => {
            node.title.push_str(" =");
            node.texts = vec![format!("mask ${:02X}", number(Role::Constant))];
        }
        Mnemonic::Stic => node.texts = vec![format!("store {}", number(Role::Constant))],
        Mnemonic::Ff => {
            let winner = if number(Role::Priority) == 1 { "set" } else { "reset" };
            node.texts = vec![format!("{winner} wins")];
        }
        Mnemonic::Oper => {
            let sign = if number(Role::Selector) == 1 { "−" } else { "+" };
            node.title = format!("OPER {sign}");
        }
        Mnemonic::Mul => node.title.push_str(" ×"),
        Mnemonic::Event => node.texts = vec![format!("type {}", number(Role::EventType))],
        _ => {}
    }
}

fn time_text(time: Duration) -> String {
    let ms = time.as_millis();
    if ms >= 60_000 && ms.is_multiple_of(60_000) {
        format!("{} min", ms / 60_000)
    } else if ms >= 1000 {
        format!("{} s", time.as_secs_f64())
    } else {
        format!("{ms} ms")
    }
}
