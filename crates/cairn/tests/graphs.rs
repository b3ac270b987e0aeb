//! `cairn graph` from end to end.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod support;

use std::{fs, io::Write as _};

use support::Place;

/// A square of 1 m driven round, whose last edge says that it closes; the poses are off.
const SQUARE: &str = "VERTEX_SE2 10 0 0 0\n\
    VERTEX_SE2 11 1.2 0.1 1.5\n\
    VERTEX_SE2 12 1.1 1.3 3.0\n\
    VERTEX_SE2 13 -0.2 0.9 -1.5\n\
    EDGE_SE2 10 11 1 0 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 11 12 1 0 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 12 13 1 0 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 13 10 1 0 1.5707963267948966 100 0 0 100 0 400\n";

fn gzip(text: &str) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    packed.finish().unwrap()
}

#[test]
fn a_graph_is_optimised_and_written() {
    let place = Place::new();
    place.write("square.g2o", SQUARE);
    let out = place.cairn("graph square.g2o").fine().out;
    for word in ["4 vertices, 4 edges", "chi2 before", "chi2 after", "at a minimum", "iterations"] {
        assert!(out.contains(word), "`{word}` is missing in: {out}");
    }
    for start in ["auto", "file", "odometry", "chordal"] {
        let run = format!("graph square.g2o --start {start} --format json -o {start}.g2o");
        let object = place.cairn(&run).fine().json();
        assert_eq!((&object["vertices"], &object["edges"]), (&4.into(), &4.into()));
        let chi2 = |key: &str| object[key].as_f64().unwrap();
        // Edges agree with each other exactly: nothing is left.
        assert!(chi2("chi2_before") > 1.0 && chi2("chi2_after") < 1e-9, "{start}: {object}");
        assert_eq!(object["outcome"], "converged");
        assert!(object["time_s"].as_f64().unwrap() > 0.0);
        assert_eq!(start != "auto", object["start"] == start, "{object}");
        let written = place.read(&format!("{start}.g2o"));
        assert!(written.starts_with("VERTEX_SE2 10 0 0 0\nVERTEX_SE2 11 "), "{written}");
        let again = place.cairn(&format!("graph {start}.g2o --start file --format json")).json();
        assert!(again["chi2_before"].as_f64().unwrap() < 1e-9, "{again}");
    }
}

#[test]
fn gzip_is_read_as_far_as_it_goes() {
    let place = Place::new();
    let long: String = (0..400)
        .map(|i| format!("EDGE_SE2 {i} {} 1 0 0.0{i} 100 0 0 100 0 400\n", i + 1))
        .collect::<Vec<_>>()
        .concat();
    fs::write(place.path("a.g2o.gz"), gzip(&long)).unwrap();
    let whole = place.cairn("graph a.g2o.gz --format json").fine().json();
    assert_eq!((&whole["vertices"], &whole["edges"]), (&401.into(), &400.into()));
    let packed = gzip(&long);
    fs::write(place.path("cut.g2o.gz"), &packed[..packed.len() / 2]).unwrap();
    let cut = place.cairn("graph cut.g2o.gz").fine();
    assert!(cut.err.contains("cut after line"), "{}", cut.err);
    fs::write(place.path("head.g2o.gz"), &packed[..12]).unwrap();
    place.cairn("graph head.g2o.gz").refused(2, &["head.g2o.gz", "nothing", "unpacked"]);
}

#[test]
fn what_is_no_graph_is_refused_with_its_line() {
    let place = Place::new();
    place.write("words.g2o", &format!("{SQUARE}EDGE_SE2 10 x 1 0 0 1 0 0 1 0 1\n"));
    place.cairn("graph words.g2o -o out.g2o").refused(2, &["words.g2o", "line 9", "`x`"]);
    place.write("nan.g2o", &SQUARE.replace("1.2 0.1", "nan 0.1"));
    place.cairn("graph nan.g2o").refused(2, &["line 2", "nan"]);
    place.write("none.g2o", "# nothing\n");
    place.cairn("graph none.g2o").refused(2, &["none.g2o", "VERTEX_SE2"]);
    place.cairn("graph absent.g2o").refused(2, &["absent.g2o", "No such file"]);
    place.write("square.g2o", SQUARE);
    place.cairn("graph square.g2o -o square.g2o/out.g2o").refused(2, &["cannot be written"]);
    place.cairn("graph square.g2o --iterations 0").refused(2, &["--iterations"]);
    assert!(!place.path("out.g2o").exists());
}

#[test]
fn a_limit_that_comes_first_is_told() {
    let place = Place::new();
    place.write(
        "square.g2o",
        &SQUARE.replace("1.2 0.1 1.5", "9 9 -2").replace("13 10 1 0", "13 10 1.1 0"),
    );
    let run = place.cairn("graph square.g2o --start file --iterations 1 --format json");
    assert_eq!((run.code, run.json()["outcome"].clone()), (1, "iteration_limit".into()));
}
