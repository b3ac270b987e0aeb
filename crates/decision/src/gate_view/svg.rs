//! The drawing as text.

use super::{
    layout::{Drawing, Placed, Wire},
    symbols::{Pin, STUB_PX, Shape, pixels},
};

const STYLE: &str = "\
.gates text{font:12px ui-monospace,monospace;fill:var(--gate-ink,#1f2933)}\
.gates .body{fill:var(--gate-fill,#f7f9fb);stroke:var(--gate-ink,#1f2933);stroke-width:1.5}\
.gates .wire{fill:none;stroke:var(--gate-wire,#52606d);stroke-width:1.5}\
.gates .dot{fill:var(--gate-wire,#52606d)}\
.gates .title{font-weight:600}\
.gates .name{fill:var(--gate-name,#0b6e99)}\
.gates .mark{font-size:11px}";

pub(super) fn document(drawing: &Drawing, n_left_out: usize) -> String {
    let note_px = if n_left_out > 0 { 20 } else { 0 };
    let (width, height) = (drawing.width.max(240), drawing.height.saturating_add(note_px));
    let mut lines = vec![
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"gates\" width=\"{width}\" \
             height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\">"
        ),
        format!("<style>{STYLE}</style>"),
    ];
    // Wires first, so that symbols cover their ends.
    drawing.wires.iter().for_each(|wire| draw_wire(wire, &mut lines));
    drawing.nodes.iter().for_each(|placed| draw_node(placed, &mut lines));
    if n_left_out > 0 {
        let y = height.saturating_sub(10);
        lines.push(format!(
            "<text class=\"note\" x=\"20\" y=\"{y}\">{n_left_out} further functions are not drawn</text>"
        ));
    }
    lines.push("</svg>\n".to_owned());
    lines.join("\n")
}

fn draw_wire(wire: &Wire, lines: &mut Vec<String>) {
    let id = wire.id;
    let corners: Vec<String> = wire.corners.iter().map(|(x, y)| format!("{x},{y}")).collect();
    let corners = corners.join(" ");
    lines.push(format!("<polyline class=\"wire\" data-resource=\"{id}\" points=\"{corners}\"/>"));
    let dot = |(x, y): &(i32, i32)| {
        format!("<circle class=\"dot\" data-resource=\"{id}\" cx=\"{x}\" cy=\"{y}\" r=\"3\"/>")
    };
    lines.extend(wire.dots.iter().map(dot));
}

fn draw_node(placed: &Placed, lines: &mut Vec<String>) {
    let Placed { node, x, y, is_wired } = placed;
    let (x, y) = (*x, *y);
    let class = node.title.split(' ').next().unwrap_or_default().to_ascii_lowercase();
    lines.push(format!("<g class=\"function {class}\" data-line=\"{}\">", node.line));
    lines.push(format!("<title>{}</title>", escaped(&node.tooltip)));
    // Inputs reach into the symbol, as the back of an OR is hollow; the body covers the rest.
    for (pin, &wired) in node.inputs.iter().zip(is_wired) {
        let from = if wired { x } else { x.saturating_sub(10) };
        lines.push(stub(pin, [from, x.saturating_add(12)], y));
        if !wired {
            let at = [x.saturating_sub(14), y.saturating_add(pin.y).saturating_add(4)];
            lines.push(name(pin, at, "end"));
        }
    }
    let right = x.saturating_add(node.width);
    for pin in &node.outputs {
        lines.push(stub(pin, [right, right.saturating_add(STUB_PX)], y));
        let beside = right.saturating_add(if node.inverted { 12 } else { 4 });
        let at = [beside, y.saturating_add(pin.y).saturating_sub(5)];
        lines.push(name(pin, at, "start"));
    }
    lines.push(body(placed));
    if node.shape == Shape::Xor {
        let (back, half) = (x.saturating_sub(7), node.height / 2);
        let up = half.saturating_mul(2);
        lines.push(format!("<path class=\"wire\" d=\"M{back} {y}q14 {half} 0 {up}\"/>"));
    }
    if node.inverted {
        let (cx, cy) = (right.saturating_add(5), y.saturating_add(node.height / 2));
        lines.push(format!("<circle class=\"body\" cx=\"{cx}\" cy=\"{cy}\" r=\"5\"/>"));
    }
    texts(placed, lines);
    lines.push("</g>".to_owned());
}

/// The outline of a symbol, its left upper corner at the node's place.
fn body(placed: &Placed) -> String {
    let Placed { node, x, y, .. } = placed;
    let (w, h, half) = (node.width, node.height, node.height / 2);
    let path = match node.shape {
        Shape::Box => {
            return format!(
                "<rect class=\"body\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" rx=\"3\"/>"
            );
        }
        Shape::And => {
            let (straight, round) = (w / 2, w / 2);
            format!("h{straight}a{round} {half} 0 0 1 0 {h}h-{straight}z")
        }
        Shape::Or | Shape::Xor => {
            let tip = w.saturating_sub(16);
            let bend = tip / 2;
            format!("h16q{bend} 0 {tip} {half}q-{bend} {half} -{tip} {half}h-16q14 -{half} 0 -{h}z")
        }
        Shape::Comparator => format!("l{w} {half}l-{w} {half}z"),
    };
    format!("<path class=\"body\" d=\"M{x} {y}{path}\"/>")
}

fn texts(placed: &Placed, lines: &mut Vec<String>) {
    let Placed { node, x, y, .. } = placed;
    let is_box = node.shape == Shape::Box;
    for pin in node.inputs.iter().filter(|pin| !pin.mark.is_empty()) {
        let (left, base) = (x.saturating_add(5), y.saturating_add(pin.y).saturating_add(4));
        lines.push(text("mark", [left, base], "start", &pin.mark));
    }
    let right = x.saturating_add(node.width).saturating_sub(5);
    for pin in node.outputs.iter().filter(|pin| !pin.mark.is_empty()) {
        let base = y.saturating_add(pin.y).saturating_add(4);
        lines.push(text("mark", [right, base], "end", &pin.mark));
    }
    let middle = x.saturating_add(node.width / 2);
    if is_box {
        lines.push(text("title", [middle, y.saturating_add(16)], "middle", &node.title));
    }
    let bottom = y.saturating_add(node.height).saturating_sub(8);
    for (i, line) in node.texts.iter().rev().enumerate() {
        let base = bottom.saturating_sub(pixels(i).saturating_mul(15));
        lines.push(text("text", [middle, base], "middle", line));
    }
}

fn stub(pin: &Pin, [from, to]: [i32; 2], top: i32) -> String {
    let (id, y) = (pin.id, top.saturating_add(pin.y));
    format!("<polyline class=\"wire\" data-resource=\"{id}\" points=\"{from},{y} {to},{y}\"/>")
}

fn name(pin: &Pin, [x, y]: [i32; 2], anchor: &str) -> String {
    let (id, label) = (pin.id, escaped(&pin.label));
    format!(
        "<text class=\"name\" data-resource=\"{id}\" x=\"{x}\" y=\"{y}\" \
         text-anchor=\"{anchor}\">{label}</text>"
    )
}

fn text(class: &str, [x, y]: [i32; 2], anchor: &str, content: &str) -> String {
    let content = escaped(content);
    format!("<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{content}</text>")
}

/// Text that may stand in XML, control characters left out.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
