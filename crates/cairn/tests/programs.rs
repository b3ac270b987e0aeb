//! `cairn rdpl` and `cairn explain` from end to end.

mod support;

use std::fs;

use support::{Place, shipped};

const RIGHT: &str = "AND Y0,I0,I1,1L,1L\nOR O0,Y0,I2,0L,0L\n";
const WRONG: &str = "AND Y0,I0,I1,1L,1L\nOR O0,IO,I2,0L,0L\n";

#[test]
fn compiling_leaves_an_image_and_a_listing() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    let run = place.cairn("rdpl lamp").fine();
    assert!(run.out.contains("Lines compiled: 2. Total errors 0."), "{}", run.out);
    assert_eq!(fs::read(place.path("lamp.bin")).unwrap().last(), Some(&0x0F));
    assert!(place.read("lamp.lst").contains("OR O0,Y0,I2"));
}

#[test]
fn an_error_removes_the_outdated_image() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    place.cairn("rdpl lamp.src").fine();
    place.write("lamp.src", WRONG);
    let image = fs::read(place.path("lamp.bin")).unwrap();
    place.cairn("rdpl lamp.src").refused(2, &["lamp.bin", "exists already", "--force"]);
    assert_eq!(fs::read(place.path("lamp.bin")).unwrap(), image);
    let forced = place.cairn("rdpl lamp.src --force");
    forced.refused(1, &["R2001", "lamp.src:2:7", "did you mean `I0`?"]);
    assert!(!place.path("lamp.bin").exists(), "an image of the version before is left");
    assert!(place.path("lamp.lst").exists(), "the listing shows the errors");
}

#[test]
fn the_results_of_another_program_stay() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    place.write("lamp.toml", WRONG);
    place.cairn("rdpl lamp.src").fine();
    let all = || (fs::read(place.path("lamp.bin")).unwrap(), place.read("lamp.lst"));
    let before = all();
    place.cairn("rdpl lamp.toml").refused(2, &["lamp.bin", "exists already"]);
    place.cairn("rdpl lamp.toml --force").refused(2, &["lamp.src", "another program", "-o"]);
    assert_eq!(all(), before);
    // Without its listing nobody knows whose it is: an error does not remove it.
    fs::remove_file(place.path("lamp.lst")).unwrap();
    let forced = place.cairn("rdpl lamp.toml --force");
    forced.refused(1, &["lamp.bin is not of this source", "left as it was"]);
    assert_eq!(all().0, before.0);
    place.cairn("rdpl lamp.src --force").refused(2, &["lamp.toml", "another program"]);
}

#[test]
fn checking_writes_nothing() {
    let place = Place::new();
    place.write("lamp.src", RIGHT);
    let run = place.cairn("rdpl lamp.src --check").fine();
    assert!(!run.out.contains("Image"), "{}", run.out);
    assert!(!place.path("lamp.bin").exists() && !place.path("lamp.lst").exists());
}

#[test]
fn json_is_one_object_without_colours() {
    let place = Place::new();
    place.write("lamp.src", WRONG);
    let run = place.cairn("rdpl lamp.src --check --format json");
    let object = run.json();
    assert_eq!((run.code, &object["errors"], &object["lines"]), (1, &1.into(), &2.into()));
    let problem = &object["diagnostics"][0];
    assert_eq!((&problem["code"], &problem["line"]), (&"R2001".into(), &2.into()));
    assert!(!place.cairn("rdpl lamp.src --check").err.contains('\u{1b}'), "colours in a pipe");
}

#[test]
fn gates_are_drawn() {
    let place = Place::new();
    let program = shipped("doorbell.rdpl");
    let run = place.cairn(&format!("rdpl {program} --check --gates doorbell.svg")).fine();
    assert!(run.out.contains("Gates: doorbell.svg"), "{}", run.out);
    let svg = place.read("doorbell.svg");
    assert!(svg.starts_with("<svg") && svg.contains("MOVE"), "{svg}");
    place.write("lamp.src", WRONG);
    place.cairn("rdpl lamp.src --check --gates lamp.svg").refused(1, &["R2001"]);
    assert!(!place.path("lamp.svg").exists());
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let place = Place::new();
    place.cairn("rdpl absent").refused(2, &["cannot read the program absent.src"]);
    place.write("lamp.src", RIGHT);
    place
        .cairn("rdpl lamp.src --output no/such")
        .refused(2, &["no/such/lamp", "cannot be written"]);
}

#[test]
fn every_code_is_explained() {
    let place = Place::new();
    let list = place.cairn("explain --format json").fine().json();
    let codes = list["codes"].as_array().unwrap();
    assert!(codes.len() > 30);
    let page = place.cairn("explain r2001").fine().out;
    assert!(page.starts_with("# R2001") && page.contains("## Right"), "{page}");
    let object = place.cairn("explain R2001 --format json").fine().json();
    assert_eq!(object["severity"], "error");
    place.cairn("explain R77").refused(2, &["R77", "cairn explain"]);
}
