//! The gate view: what is drawn, and what is joined to what. Its looks were judged by eye.

#![cfg(test)]

use std::collections::BTreeMap;

use decision::{compile, gate_view};
use expect_test::{Expect, expect};

fn draw(source: &str) -> String {
    gate_view(&compile(source).program.expect("correct"))
}

/// The value of an attribute of an element, written out anew for the test.
fn attribute<'s>(element: &'s str, name: &str) -> Option<&'s str> {
    let start = element.find(&format!(" {name}=\""))? + name.len() + 3;
    element[start..].split('"').next()
}

/// Every element that carries a resource, as `class resource`, counted.
fn marked(svg: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for element in svg.split('<') {
        if let Some(id) = attribute(element, "data-resource") {
            let class = attribute(element, "class").expect("a class");
            *counts.entry(format!("{class} {id}")).or_default() += 1;
        }
    }
    counts
}

fn check(source: &str, expected: &Expect) {
    let lines: Vec<String> =
        marked(&draw(source)).iter().map(|(what, n)| format!("{what} ×{n}\n")).collect();
    expected.assert_eq(&lines.concat());
}

const DOORBELL: &str = "\
BELL EQU I0
     OR   Y1,I1,I2,I3,0L
     FF   Y2,BELL,Y1,0
     TIMER 16,MONO,BELL,RISE,15
     TIMER 0,MONO,YTMR16,FALL,10
     AND  Y3,YTMR0,Y2,1L,1L
     MOVE Y3,5000,3500,45,RISE
";

#[test]
fn the_doorbell_has_six_symbols_and_five_wires() {
    let svg = draw(DOORBELL);
    assert_eq!(svg.matches("<g class=\"function").count(), 6);
    for text in ["BELL (I0)", "TIMER 16", "15 s", "100 ms", "x 5000 mm", "θ 45 °", "reset wins"] {
        assert!(svg.contains(&format!(">{text}<")) || svg.contains(&format!(" {text}<")), "{text}");
    }
    assert!(svg.contains("<title>line 6: AND  Y3,YTMR0,Y2,1L,1L</title>"));
    // Neither 0L nor 1L is drawn; every signal that is wired has its name at its source only.
    assert!(!svg.contains("data-resource=\"0L\"") && !svg.contains("data-resource=\"1L\""));
    let counts = marked(&svg);
    for signal in ["Y1", "Y2", "Y3", "YTMR16", "YTMR0"] {
        assert_eq!(counts.get(&format!("name {signal}")), Some(&1), "{signal}");
    }
    assert_eq!(counts.get("name I0"), Some(&2));
}

/// End points of wires: every wired input must be met by a wire of its own signal.
#[test]
fn wires_are_horizontal_or_vertical_and_join() {
    for source in [
        DOORBELL,
        include_str!("programs/state_machine.rdpl"),
        include_str!("programs/numbers.rdpl"),
    ] {
        let svg = draw(source);
        let mut segments: Vec<(String, [i32; 4])> = Vec::new();
        for element in svg.split('<').filter(|e| e.starts_with("polyline")) {
            let id = attribute(element, "data-resource").expect("a resource").to_owned();
            let points = attribute(element, "points").expect("points");
            let points: Vec<Vec<i32>> = points
                .split(' ')
                .map(|p| p.split(',').map(|n| n.parse().expect("a number")).collect())
                .collect();
            for pair in points.windows(2) {
                let ends = [pair[0][0], pair[0][1], pair[1][0], pair[1][1]];
                assert!(ends[0] == ends[2] || ends[1] == ends[3], "slanted: {element}");
                segments.push((id.clone(), ends));
            }
        }
        // Two signals never share a stretch of a line.
        for (i, (id, a)) in segments.iter().enumerate() {
            for (other, b) in segments[i + 1..].iter().filter(|(other, _)| other != id) {
                assert!(!overlap(a, b), "{id} {a:?} lies on {other} {b:?}");
            }
        }
    }
}

fn overlap(a: &[i32; 4], b: &[i32; 4]) -> bool {
    let common = |p: i32, q: i32, r: i32, s: i32| p.max(q).min(r.max(s)) - p.min(q).max(r.min(s));
    let x = common(a[0], a[2], b[0], b[2]);
    let y = common(a[1], a[3], b[1], b[3]);
    // A crossing has no length in either direction; a stretch has one in one and none in the other.
    let both = |i: usize, j: usize| a[i] == a[j] && b[i] == b[j];
    (both(1, 3) && y == 0 && x > 0) || (both(0, 2) && x == 0 && y > 0)
}

#[test]
fn feedback_and_far_signals_are_names() {
    check(
        "AND Y0,Y1,I0,1L,1L\nOR Y1,Y0,I1,0L,0L",
        &expect![[r"
            name I0 ×1
            name I1 ×1
            name Y0 ×1
            name Y1 ×2
            wire I0 ×1
            wire I1 ×1
            wire Y0 ×3
            wire Y1 ×2
        "]],
    );
}

#[test]
fn all_tied_inputs_leave_one_pin() {
    check(
        "AND O0,1L,1L,1L,1L",
        &expect![[r"
            name 1L ×1
            name O0 ×1
            wire 1L ×1
            wire O0 ×1
        "]],
    );
}

#[test]
fn a_drawing_of_nothing_is_a_drawing() {
    assert!(draw("").starts_with("<svg ") && draw("").ends_with("</svg>\n"));
}

#[test]
fn a_long_program_is_cut_and_says_so() {
    let svg = draw(&"AND Y0,Y0,I0,1L,1L\n".repeat(520));
    assert_eq!(svg.matches("<g class=\"function").count(), 500);
    assert!(svg.contains(">20 further functions are not drawn<"));
}

#[test]
fn quoted_text_cannot_break_the_document() {
    let svg = draw("STIC M0,'<',I0,RISE\nSTIC M1,\"&\",I0,RISE");
    assert!(svg.contains("'&lt;'") && svg.contains("&quot;&amp;&quot;"));
}
