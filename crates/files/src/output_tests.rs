//! The rule, case by case.

use std::{collections::BTreeMap, fs, path::Path};

use super::*;
use crate::Batch;

const MCAP: &[u8] = b"\x89MCAP0\r\nrest";

/// Every file of a folder with its content; links and folders by what they are.
fn everything(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap());
    entries
        .map(|e| {
            let kind = e.file_type().unwrap();
            let content = if kind.is_file() {
                fs::read(e.path()).unwrap()
            } else {
                format!("{kind:?}").into_bytes()
            };
            (e.file_name().into_string().unwrap(), content)
        })
        .collect()
}

/// What is in the folder before: a plain file, a recording, an empty file, an input, a folder, and links.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    fs::write(at("text.toml"), "[mission]\n").unwrap();
    fs::write(at("old.mcap"), MCAP).unwrap();
    fs::write(at("empty.mcap"), "").unwrap();
    fs::write(at("input.mcap"), MCAP).unwrap();
    fs::create_dir(at("folder")).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("old.mcap", at("link.mcap")).unwrap();
        std::os::unix::fs::symlink("nowhere", at("dangling.mcap")).unwrap();
        std::os::unix::fs::symlink("folder", at("folder-link")).unwrap();
        std::os::unix::fs::symlink("input.mcap", at("input-link.mcap")).unwrap();
        fs::hard_link(at("old.mcap"), at("second-name.mcap")).unwrap();
        std::os::unix::net::UnixListener::bind(at("socket.mcap")).unwrap();
    }
    place
}

/// Name; what is said without and with `--force`; empty where it is written.
const CASES: &[(&str, &str, &str)] = &[
    ("new.mcap", "", ""),
    ("folder/new.mcap", "", ""),
    ("empty.mcap", "exists already", ""),
    ("text.toml", "exists already", "not a recording (MCAP)"),
    ("input.mcap", "is read by this command", "is read by this command"),
    ("./folder/../input.mcap", "is read by this command", "is read by this command"),
    ("folder", "a folder", "a folder"),
    ("folder/", "a folder", "a folder"),
    ("new.mcap/", "names no file", "names no file"),
    ("..", "a folder", "a folder"),
    ("", "names no file", "names no file"),
    ("no/such/new.mcap", "there is no folder", "there is no folder"),
    ("text.toml/new.mcap", "is no folder", "is no folder"),
];

#[cfg(unix)]
const UNIX_CASES: &[(&str, &str, &str)] = &[
    ("old.mcap", "hard links", "hard links"),
    ("second-name.mcap", "hard links", "hard links"),
    ("link.mcap", "a symbolic link", "a symbolic link"),
    ("dangling.mcap", "a symbolic link", "a symbolic link"),
    ("input-link.mcap", "is read by this command", "is read by this command"),
    ("folder-link", "a symbolic link", "a symbolic link"),
    ("folder-link/new.mcap", "", ""),
    ("socket.mcap", "a socket", "a socket"),
    ("/dev/null", "a device", "a device"),
];
#[cfg(not(unix))]
const UNIX_CASES: &[(&str, &str, &str)] = &[("old.mcap", "exists already", "")];

#[test]
fn the_rule_case_by_case() {
    for &(name, kept, forced) in CASES.iter().chain(UNIX_CASES) {
        for (replace, expected) in [(false, kept), (true, forced)] {
            let place = place();
            let path = if name.is_empty() { PathBuf::new() } else { place.path().join(name) };
            let before = everything(place.path());
            let outputs = Outputs::new(replace).keeping([place.path().join("input.mcap")]);
            let checked = outputs.check(&path, Kind::RECORDING);
            assert_eq!(everything(place.path()), before, "{name}: a check changes nothing");
            let begun = outputs.begin(&path, Kind::RECORDING);
            if expected.is_empty() {
                checked.unwrap();
                let mut live = begun.unwrap();
                live.file().write_all(MCAP).unwrap();
                assert_eq!(live.finish().unwrap(), path);
                assert_eq!(fs::read(&path).unwrap(), MCAP);
                fs::remove_file(&path).unwrap();
                outputs.write(&path, Kind::RECORDING, MCAP).unwrap();
                assert_eq!(fs::read(&path).unwrap(), MCAP);
            } else {
                for said in [checked.unwrap_err(), begun.unwrap_err()] {
                    let said = said.to_string();
                    assert!(said.contains(expected), "{name}, replace {replace}: {said}");
                    assert!(said.contains(name), "{said}");
                }
                assert!(outputs.write(&path, Kind::RECORDING, MCAP).is_err(), "{name}");
                assert_eq!(everything(place.path()), before, "{name}, replace {replace}");
            }
        }
    }
}

#[test]
fn what_appears_during_the_work_is_not_replaced() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("out.mcap");
    let mut live = Outputs::new(false).begin(&path, Kind::RECORDING).unwrap();
    live.file().write_all(MCAP).unwrap();
    fs::write(&path, "another's").unwrap();
    let said = live.finish().unwrap_err().to_string();
    assert!(said.contains("exists already"), "{said}");
    let found = everything(place.path());
    assert_eq!(found["out.mcap"], b"another's");
    assert_eq!(found["out.mcap.part"], MCAP, "what was recorded is not lost");
}

#[test]
fn one_name_has_one_writer_and_what_a_crash_left_is_kept() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("out.mcap");
    fs::write(place.path().join("out.mcap.part"), "of a crash").unwrap();
    let outputs = Outputs::new(true);
    let mut first = outputs.begin(&path, Kind::RECORDING).unwrap();
    assert_eq!(first.left_behind(), [place.path().join("out.mcap.part")]);
    assert_eq!(first.part(), place.path().join("out.mcap.2.part"));
    first.file().write_all(MCAP).unwrap();
    let said = outputs.begin(&path, Kind::RECORDING).unwrap_err().to_string();
    assert!(said.contains("is being written by"), "{said}");
    if cfg!(target_os = "linux") && Path::new("/proc/locks").exists() {
        assert!(said.contains(&format!("process {}", std::process::id())), "{said}");
    }
    first.finish().unwrap();
    let found = everything(place.path());
    assert_eq!(found["out.mcap.part"], b"of a crash");
    assert_eq!(found["out.mcap"], MCAP);
    assert_eq!(found.len(), 2);
    drop(outputs.begin(&path, Kind::RECORDING).unwrap());
}

/// Many that begin one name at one moment: one gets it, and none is taken for what a crash left.
#[test]
fn a_name_that_many_begin_at_once_goes_to_one() {
    for _ in 0..50 {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out.mcap");
        let begin = || Outputs::new(false).begin(&path, Kind::RECORDING);
        let start = std::sync::Barrier::new(4);
        let begun: Vec<_> = std::thread::scope(|scope| {
            let of = |_| {
                scope.spawn(|| {
                    start.wait();
                    begin()
                })
            };
            let threads: Vec<_> = (0..4).map(of).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let ours: Vec<&Live> = begun.iter().flatten().collect();
        assert_eq!(ours.len(), 1, "{begun:?}");
        assert!(ours[0].left_behind().is_empty() && ours[0].part().ends_with("out.mcap.part"));
        assert_eq!(everything(place.path()).len(), 1);
    }
}

/// A program that was killed before it wrote anything leaves an empty file: that is no one's.
#[test]
fn an_empty_file_of_a_crash_does_not_hold_the_name() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("out.mcap");
    fs::write(place.path().join("out.mcap.part"), "").unwrap();
    let live = Outputs::new(false).begin(&path, Kind::RECORDING).unwrap();
    assert!(live.part().ends_with("out.mcap.2.part") && live.left_behind().len() == 1);
}

#[test]
fn two_results_never_share_a_name() {
    let place = place();
    let at = |name: &str| place.path().join(name);
    let outputs = Outputs::new(true);
    let said = outputs
        .check_all(&[(&at("a.svg"), Kind::SVG), (&at("./folder/../a.svg"), Kind::IMAGE)])
        .unwrap_err()
        .to_string();
    assert!(said.contains("two results"), "{said}");
    outputs.check_all(&[(&at("a.svg"), Kind::SVG), (&at("a.bin"), Kind::IMAGE)]).unwrap();
}

#[test]
fn results_appear_together_or_not_at_all() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("results");
    let outputs = Outputs::new(false);
    let names = [("a.csv", Kind::CSV), ("b.html", Kind::HTML)];
    outputs.check_folder(&folder, &names).unwrap();
    assert!(!folder.exists(), "a check makes no folder");
    let mut batch = Batch::new(&folder, &outputs).unwrap();
    batch.put("a.csv", Kind::CSV, b"x,y\n").unwrap();
    let said = batch.put("no/such/b", Kind::CSV, b"").unwrap_err().to_string();
    assert!(said.contains("there is no folder"), "{said}");
    drop(batch);
    assert!(!folder.exists(), "the folder that it made is gone");

    let mut batch = Batch::new(&folder, &outputs).unwrap();
    batch.put("a.csv", Kind::CSV, b"x,y\n").unwrap();
    assert!(!folder.join("a.csv").exists(), "not before the commit");
    batch.commit().unwrap();
    assert_eq!(everything(&folder).len(), 1);
    let said = outputs.check_folder(&folder, &names).unwrap_err().to_string();
    assert!(said.contains("a.csv") && said.contains("--force"), "{said}");
    Outputs::new(true).check_folder(&folder, &names).unwrap();

    let deep = place.path().join("no/such/results");
    assert!(outputs.check_folder(&deep, &names).unwrap_err().to_string().contains("no folder"));
    assert!(Batch::new(&deep, &outputs).is_err());
    let said = outputs.check_folder(&folder.join("a.csv"), &names).unwrap_err().to_string();
    assert!(said.contains("is no folder"), "{said}");
    assert_eq!(everything(place.path()).len(), 1);
}

#[test]
fn a_replaced_file_must_be_of_its_sort() {
    let samples: &[(Kind, &[u8], &[u8])] = &[
        (Kind::SVG, b"<?xml version=\"1.0\"?>\n<svg/>", b"OR O0,I0,I1,0L,0L\n"),
        (Kind::IMAGE, &[0, 1, 15], b"\x7fELF"),
        (Kind::LISTING, b"Cairn RDPL compiler list file.\n", b"another list\n"),
        (Kind::GRAPH, b"VERTEX_SE2 0 0 0 0\n", b"[mission]\n"),
        (Kind::HTML, b"<!DOCTYPE html>\n", b"[mission]\n"),
        (Kind::CSV, b"a,b\n1,2\n", b"\x89PNG\r\n"),
        (Kind::JSON, b"{\"a\": 1}\n", b"[mission]\n"),
        (Kind::PGM, b"P5\n", b"\x89PNG"),
        (Kind::PNG, b"\x89PNG\r\n", b"P5\n"),
        (Kind::MAP_YAML, b"image: map.pgm\n", b"[mission]\n"),
        (Kind::TRAJECTORY, b"-0.5 1 2 0 0 0 0 1\n", b"[mission]\n"),
        (Kind::SETTINGS, b"[survey]\n", b"[mission]\n"),
        (Kind::MARKDOWN, b"# Title\n", b"<html>"),
    ];
    for (kind, own, other) in samples {
        assert!(kind.recognises(own) && kind.recognises(b""), "{}", kind.name());
        assert!(!kind.recognises(other), "{}", kind.name());
    }
}

/// What people have in a folder is not taken for a result because a line of it looks like one.
#[test]
fn other_texts_are_of_no_sort_that_would_replace_them() {
    let mission = b"# A mission.\n\n[mission]\nname = \"a\"\n";
    let foreign: &[(Kind, &[u8])] = &[
        (Kind::CSV, b"[mission]\nname = \"a\"\n"),
        (Kind::CSV, b"start = [1, 2]\nend = [3, 4]\n"),
        (Kind::CSV, b"word\nanother\n"),
        (Kind::CSV, b"Dear all, this is a letter\nof two lines\n"),
        (Kind::CSV, mission),
        (Kind::TRAJECTORY, mission),
        (Kind::TRAJECTORY, b"# only remarks\n"),
        (Kind::TRAJECTORY, b"- a list\n"),
        (Kind::TRAJECTORY, b"2026 was a year of a long walk\n"),
        (Kind::MARKDOWN, b"#!/bin/sh\n"),
        (Kind::MARKDOWN, b"#include <a>\n"),
        (Kind::MARKDOWN, mission),
        (Kind::JSON, b"{ echo; }\n"),
        (Kind::JSON, b"[1]\n"),
    ];
    for (kind, text) in foreign {
        assert!(!kind.recognises(text), "{}: {}", kind.name(), String::from_utf8_lossy(text));
    }
    let own: &[(Kind, &[u8])] = &[
        (Kind::CSV, b"\"a, b\",c\n1,2\n"),
        (Kind::CSV, b"a,b\n\"x\ny\",2\n"),
        (Kind::CSV, b"a,b\n"),
        (Kind::CSV, b"a,b,c\n1,2"),
        (Kind::TRAJECTORY, b"# t x y z qx qy qz qw\n1.5 0 -1e-3 0 0 0 0 1\n"),
        (Kind::MARKDOWN, b"# Title\n\nText.\n\n## More\n"),
        (Kind::JSON, b"{\n  \"a\": 1}"),
        (Kind::JSON, b"{}\n"),
    ];
    for (kind, text) in own {
        assert!(kind.recognises(text), "{}: {}", kind.name(), String::from_utf8_lossy(text));
    }
}

#[test]
fn restarts_are_numbered() {
    let name = |path: &str, n| numbered(Path::new(path), n).display().to_string();
    assert_eq!(name("a/out.mcap", 1), "a/out.mcap");
    assert_eq!(name("a/out.mcap", 2), "a/out-2.mcap");
    assert_eq!(name("out", 3), "out-3");
}
