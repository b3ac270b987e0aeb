//! The mapping page's server as the page meets it: a real server, real sockets, real surveys.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::collections::BTreeMap;

use common::mapping::{MappingStudio, Picture, mapping_page};
use serde_json::{Value, json};
use surveys::testing;

/// A CARMEN log of a room, as a page brings it.
fn room_log(n_scans: usize) -> Vec<u8> {
    testing::to_carmen(&testing::room(n_scans)).into_bytes()
}

/// Scans done; none before the run is there.
fn scan_of(state: &Value, slot: usize) -> u64 {
    state["runs"][slot]["scan"].as_u64().unwrap_or(0)
}

fn is_finished(state: &Value, slot: usize) -> bool {
    state["runs"][slot]["phase"] == "finished"
}

fn figures_of(state: &Value, slot: usize) -> BTreeMap<String, f64> {
    let pairs = state["runs"][slot]["figures"].as_array().unwrap().iter();
    pairs.map(|p| (p[0].as_str().unwrap().to_owned(), p[1].as_f64().unwrap())).collect()
}

#[test]
fn an_empty_page_is_greeted_and_refuses_to_play_nothing() {
    let studio = MappingStudio::empty();
    let mut page = studio.page();
    let hello = page.until("hello", |_| true);
    assert_eq!((&hello["protocol"], &hello["has_mission"]), (&json!(2), &json!(false)));
    assert!(!hello["samples"].as_array().unwrap().is_empty());
    assert_eq!(page.until("source", |_| true)["phase"], "empty");
    page.send(&json!({"type": "play"}));
    assert!(page.error().contains("open a log first"));
    page.send(&json!({"type": "sample", "name": "../secret"}));
    assert!(page.error().contains("open a log first"));
    for text in ["", "play", "{}", r#"{"type":"fly"}"#, "[1,2"] {
        page.send_text(text);
        assert!(page.error().contains("not understood"), "{text}");
    }
}

#[test]
fn a_recording_plays_pauses_steps_and_goes_back_to_its_start() {
    let studio = MappingStudio::showing(testing::room(60));
    let mut page = studio.page();
    let source = page.until("source", |s| s["phase"] == "ready");
    let info = &source["recording"];
    assert_eq!((&info["rig"], &info["n_scans"]), (&json!("laser"), &json!(60)));
    assert!((info["duration_s"].as_f64().unwrap() - 59.0 * 0.2).abs() < 1e-9);
    page.state(|s| scan_of(s, 0) > 3);
    page.send(&json!({"type": "pause"}));
    let held = page.state(|s| s["playing"] == false);
    page.send(&json!({"type": "step"}));
    let stepped = page.state(|s| scan_of(s, 0) > scan_of(&held, 0));
    assert_eq!(scan_of(&stepped, 0), scan_of(&held, 0) + 1);
    page.send(&json!({"type": "speed", "ratio": 0.1}));
    let slow = page.state(|s| s["speed_ratio"] == 0.1);
    assert_eq!(slow["playing"], false);
    page.send(&json!({"type": "rewind"}));
    let anew = page.state(|s| s["playing"] == true);
    assert_ne!(anew["runs"][0]["run"], held["runs"][0]["run"]);
    assert!(scan_of(&anew, 0) < 5, "{anew}");
    for ratio in [0.0, 200.5, -1.0] {
        page.send(&json!({"type": "speed", "ratio": ratio}));
        assert!(page.error().contains("from 0.1 to 200"));
    }
}

#[test]
fn seeking_goes_to_a_scan_and_beyond_the_last_to_the_end() {
    let studio = MappingStudio::showing(testing::room(80));
    let mut page = studio.page();
    page.state(|s| scan_of(s, 0) > 0);
    page.send(&json!({"type": "seek", "scan": 50}));
    let there = page.state(|s| s["playing"] == false);
    assert_eq!(scan_of(&there, 0), 50);
    page.send(&json!({"type": "seek", "scan": 20}));
    let back = page.state(|s| s["playing"] == false && scan_of(s, 0) != 50);
    assert_eq!(scan_of(&back, 0), 20);
    page.send(&json!({"type": "seek", "scan": u32::MAX}));
    let end = page.state(|s| is_finished(s, 0));
    assert_eq!(scan_of(&end, 0), 80);
    let figures = figures_of(&end, 0);
    assert!(figures["truth.mean_m"] < figures["truth.odometry.mean_m"], "{figures:?}");
    assert_eq!(figures["scans"].to_bits(), 80.0_f64.to_bits());
}

/// The picture that the page puts together is the map that a survey makes without any page.
#[test]
fn the_page_gets_the_whole_picture() {
    let recording = testing::room(300);
    let studio = MappingStudio::showing(recording.clone());
    let mut page = studio.page();
    page.send(&json!({"type": "seek", "scan": u32::MAX}));
    let mut early = Picture::default();
    page.watch(&mut early, |s| is_finished(s, 0) && s["playing"] == false);
    // A page that comes late gets the same.
    let mut late = Picture::default();
    studio.page().watch(&mut late, |s| is_finished(s, 0));
    assert_eq!(early.cells(), late.cells());

    let clock = surveys::Clock::stopped();
    let config = surveys::SurveyConfig::default();
    let survey = surveys::Survey::new(recording.into(), config, clock).unwrap();
    let outcome = survey.finish().unwrap();
    let map = outcome.map.window().unwrap();
    let expected: BTreeMap<(i32, i32), u8> = map
        .iter()
        .filter(|(_, prob)| !prob.is_nan())
        .map(|(cell, prob)| ((cell.column, cell.row), (1.0 + 254.0 * prob).round() as u8))
        .collect();
    let differs = |(cell, byte): (&(i32, i32), &u8)| late.cells().get(cell) != Some(byte);
    assert!(!expected.is_empty() && !expected.iter().any(differs));
    assert_eq!(late.cells().len(), expected.len());
    assert!((late.cell_m - 0.05).abs() < 1e-12);

    let near = |a: [f32; 3], b: geometry::Se2| {
        (f64::from(a[0]) - b.x_m).abs() < 1e-4 && (f64::from(a[1]) - b.y_m).abs() < 1e-4
    };
    assert_eq!([300; 3], [0, 1, 2].map(|which| late.tracks[which].len()));
    assert!(late.tracks[1].iter().zip(&outcome.trajectory).all(|(a, b)| near(*a, b.pose)));
    let (graph, _) = outcome.graph.unwrap();
    assert_eq!(late.n_vertices, graph.poses().len());
    assert_eq!(late.n_edges, graph.edges().len());
    assert!(late.n_closures > 0 && late.n_closures <= outcome.closed.len());
}

#[test]
fn changed_parameters_make_a_second_run_beside_the_first() {
    let studio = MappingStudio::showing(testing::room(60));
    let mut page = studio.page();
    let source = page.until("source", |s| s["phase"] == "ready");
    let parameters = source["parameters"].as_array().unwrap();
    let resolution = parameters.iter().find(|p| p["key"] == "map.resolution_m").unwrap();
    assert_eq!((&resolution["kind"], &resolution["default"]), (&json!("number"), &json!("0.05")));
    assert!(!resolution["about"].as_str().unwrap().is_empty());
    page.send(&json!({"type": "seek", "scan": 1000}));
    let first = page.state(|s| is_finished(s, 0));
    let run = |values: &Value| json!({"type": "run", "values": values, "keep": 0});
    for (values, told) in [
        (json!({"map.resolution_m": "-1"}), "map.resolution_m"),
        (json!({"map.resolution_m": "wide"}), "map.resolution_m"),
        (json!({"map.colour": "red"}), "map.colour"),
        (json!({"survey.method": "sonar"}), "laser"),
    ] {
        page.send(&run(&values));
        let text = page.error();
        assert!(text.contains(told) && !text.contains("--set"), "{text}");
    }
    page.send(&run(&json!({"map.resolution_m": "0.1"})));
    page.send(&json!({"type": "seek", "scan": 1000}));
    let mut picture = Picture::of_slot(1);
    let both =
        page.watch(&mut picture, |s| s["runs"].as_array().unwrap().len() == 2 && is_finished(s, 1));
    assert_eq!(both["runs"][0]["run"], first["runs"][0]["run"], "the first run stays");
    assert_eq!(both["differences"], json!([["map.resolution_m", "0.05", "0.1"]]));
    assert_eq!(both["runs"][1]["values"], json!({"map.resolution_m": "0.1"}));
    assert!((picture.cell_m - 0.1).abs() < 1e-12);
    let [a, b] = [0, 1].map(|slot| figures_of(&both, slot));
    assert!(b["map.occupied_cells"] < a["map.occupied_cells"]);

    page.send(&json!({"type": "keep", "slot": 1}));
    let one = page.state(|s| s["runs"].as_array().unwrap().len() == 1);
    assert_eq!(one["runs"][0]["run"], both["runs"][1]["run"]);
    assert_eq!(one["differences"], json!([]));
    page.send(&json!({"type": "keep", "slot": 1}));
    assert!(page.error().contains("no run in slot 1"));
}

#[test]
fn a_log_that_a_page_brings_is_mapped_with_its_complaints() {
    let studio = MappingStudio::empty();
    let mut page = studio.page();
    let mut log = room_log(30);
    log.extend(b"FLASER 181 1.0 2.0\n");
    let (status, text) = studio.post("/map/recording?name=bad.log", &log, None);
    assert!(status.contains("204"), "{status}: {text}");
    let source = page.until("source", |s| s["phase"] == "ready");
    assert_eq!(source["name"], "bad.log");
    assert_eq!(source["recording"]["n_complaints"], 1);
    let complaint = source["recording"]["complaints"][0].as_str().unwrap();
    assert!(complaint.starts_with("line 32:"), "{complaint}");
    page.state(|s| scan_of(s, 0) > 5);
}

#[test]
fn a_log_that_cannot_be_read_is_told_and_the_one_before_stays() {
    let studio = MappingStudio::showing(testing::room(30));
    let mut page = studio.page();
    let before = page.state(|s| scan_of(s, 0) > 0);
    for (log, told) in [(&b""[..], "empty"), (b"\x89PNG\r\n\x1a\n....", "unknown format")] {
        let (status, text) = studio.post("/map/recording?name=holiday.png", log, None);
        assert!(status.contains("422") && text.contains(told), "{status}: {text}");
        let source = page.until("source", |s| s["problem"].is_string());
        assert!(source["problem"].as_str().unwrap().contains("holiday.png"));
        assert_eq!(source["phase"], "ready");
    }
    page.send(&json!({"type": "pause"}));
    let after = page.state(|s| s["playing"] == false);
    assert_eq!(after["runs"][0]["run"], before["runs"][0]["run"]);
    let (status, text) = studio.post("/map/recording?name=a&poses_bytes=9", b"12345", None);
    assert!(status.contains("400") && text.contains("shorter"), "{status}: {text}");
}

/// The server does not even take such a body.
#[test]
fn a_log_above_the_limit_is_refused_with_a_way_out() {
    let studio = MappingStudio::empty();
    let length = 10 * 1024 * 1024 + 1;
    let (status, text) = studio.post("/map/recording?name=huge.log", b"FLASER", Some(length));
    assert!(status.contains("413"), "{status}");
    assert!(text.contains("10 MB") && text.contains("cairn map"), "{text}");
}

/// `n` scans of a laser with `n_readings` each.
fn log_of(n: usize, n_readings: usize) -> Vec<u8> {
    let readings = " 2.5".repeat(n_readings);
    let line =
        |i| format!("FLASER {n_readings}{readings} 0.{i:04} 0 0 0.{i:04} 0 0 {i}.5 h {i}.5\n");
    (0..n).map(line).collect::<Vec<_>>().concat().into_bytes()
}

/// Many short scans take more memory than their text: refused before they are read.
#[test]
fn a_log_that_takes_too_much_memory_is_refused_with_a_way_out() {
    let studio = MappingStudio::empty();
    let log = log_of(60_000, 1);
    assert!(log.len() < 4 << 20);
    let (status, text) = studio.post("/map/recording?name=short.log", &log, None);
    assert!(status.contains("422"), "{status}");
    assert!(text.contains("MB of memory") && text.contains("cairn map"), "{text}");
}

/// A large recording of a page gives way to the next one, and the page says so when that one cannot be read.
#[test]
fn a_large_log_makes_room_for_the_next_one() {
    let studio = MappingStudio::empty();
    let mut page = studio.page();
    let (status, text) = studio.post("/map/recording?name=big.log", &log_of(5000, 180), None);
    assert!(status.contains("204"), "{status}: {text}");
    page.until("source", |s| s["phase"] == "ready" && s["name"] == "big.log");
    studio.post("/map/recording?name=bad.log", b"\x89PNG\r\n\x1a\n", None);
    let source = page.until("source", |s| s["problem"].is_string());
    assert_eq!(source["phase"], "empty");
    let problem = source["problem"].as_str().unwrap();
    assert!(problem.contains("bad.log") && problem.contains("big.log was put away"), "{problem}");
    let (status, text) = studio.post("/map/recording?name=small.log", &log_of(20, 180), None);
    assert!(status.contains("204"), "{status}: {text}");
    page.until("source", |s| s["phase"] == "ready" && s["name"] == "small.log");
}

#[test]
fn a_sample_is_made_on_the_spot() {
    let studio = MappingStudio::empty();
    let mut page = studio.page();
    page.send(&json!({"type": "sample", "name": "laser-room"}));
    page.until("source", |s| s["phase"] == "reading");
    let source = page.until("source", |s| s["phase"] == "ready");
    assert_eq!(source["recording"]["has_truth"], true);
    page.state(|s| scan_of(s, 0) > 0);
}

#[test]
fn sonars_show_cones_short_term_maps_and_scored_candidates() {
    let studio = MappingStudio::showing(testing::sonar_room(300));
    let mut page = studio.page();
    page.send(&json!({"type": "seek", "scan": 250}));
    let mut picture = Picture::default();
    page.watch(&mut picture, |s| scan_of(s, 0) >= 250 && s["playing"] == false);
    assert!(picture.half_angle_rad > 0.2 && picture.n_cones == 8, "{picture:?}");
    let registration = picture.registration.unwrap();
    let candidates = registration["candidates"].as_array().unwrap();
    assert!(candidates.len() > 1 && !registration["verdict"].as_str().unwrap().is_empty());
    assert!(registration["number"].as_u64().unwrap() > 0);
    assert!(picture.n_patch_cells > 0);
}

#[test]
fn foreign_origins_and_hosts_are_turned_away() {
    let studio = MappingStudio::empty();
    let own = studio.address.to_string();
    for origin in ["http://example.org", "null", &format!("https://{own}")] {
        assert_eq!(studio.page_as(origin, &own).unwrap_err(), 403, "{origin}");
        let (status, _) = studio.post_as(origin, "/map/recording?name=a", &room_log(3));
        assert!(status.contains("403"), "{origin}: {status}");
    }
    assert_eq!(studio.page_as(&format!("http://{own}"), "rebound.example.org").unwrap_err(), 403);
    let mut page = studio.page();
    assert_eq!(page.until("source", |_| true)["phase"], "empty", "nothing was loaded");
}

#[test]
fn the_mapping_page_stands_alone_or_beside_a_mission() {
    let alone = MappingStudio::empty();
    let own = alone.address.to_string();
    let (status, headers, _) = alone.get("/", &own);
    assert!(status.contains("307") && headers.contains("location: /map"), "{status} {headers}");
    assert!(alone.get("/ws", &own).0.contains("404"));
    let with_mission = common::Studio::of("decision-rig", 1.0);
    let own = with_mission.address.to_string();
    for (path, kind) in [
        ("/map", "text/html"),
        ("/assets/studio.js", "text/javascript"),
        ("/assets/studio.css", "text/css"),
    ] {
        let (status, headers, body) = with_mission.get(path, &own);
        assert!(status.contains("200") && !body.is_empty(), "{path}: {status}");
        assert!(headers.contains(&format!("content-type: {kind}")), "{path}: {headers}");
        assert!(headers.contains("content-security-policy: default-src 'self'"), "{path}");
    }
    let mut page = mapping_page(with_mission.address);
    assert_eq!(page.until("hello", |_| true)["has_mission"], true);
}

/// Two pages, one of which takes nothing: the other is served all the same. Six megabytes are more than the
/// socket's buffers hold for somebody who never read.
#[test]
fn a_page_that_does_not_read_holds_up_nobody() {
    let fine = ["map.resolution_m=0.01".to_owned()];
    let config = surveys::SurveyConfig::default().with(&fine).unwrap();
    let studio = MappingStudio::showing_with(testing::room(200), config);
    let lazy = studio.page();
    let mut page = studio.page();
    let mut n_bytes = 0;
    while n_bytes < 6_000_000 {
        page.send(&json!({"type": "rewind"}));
        page.send(&json!({"type": "seek", "scan": 10}));
        n_bytes += page.bytes_until(|s| s["playing"] == false && scan_of(s, 0) == 10);
    }
    drop(lazy);
    page.send(&json!({"type": "step"}));
    page.state(|s| scan_of(s, 0) == 11);
}

/// A second upload is refused at once, with its body unread; a slow one is given up.
#[test]
fn one_recording_at_a_time_and_not_for_ever() {
    let studio = MappingStudio::empty();
    let mut slow = std::net::TcpStream::connect(studio.address).unwrap();
    let head = format!(
        "POST /map/recording?name=slow.log HTTP/1.1\r\nHost: {}\r\nContent-Length: 1000\r\n\r\nFLASER",
        studio.address
    );
    std::io::Write::write_all(&mut slow, head.as_bytes()).unwrap();
    slow.set_read_timeout(Some(std::time::Duration::from_mins(1))).unwrap();
    // Until it is heard, the other one is still taken.
    let refused = (0..500).find_map(|_| {
        let (status, text) = studio.post("/map/recording?name=other.log", b"no log", Some(6));
        status.contains("409").then_some(text)
    });
    assert!(refused.unwrap().contains("another recording is being read"));
    let mut answer = String::new();
    std::io::Read::read_to_string(&mut slow, &mut answer).unwrap();
    assert!(answer.contains("408") && answer.contains("too slowly"), "{answer}");
    let (status, _) = studio.post("/map/recording?name=other.log", b"no log", None);
    assert!(status.contains("422"), "and the next one is taken: {status}");
}

/// The page's messages are short; what is longer is not even taken in.
#[test]
fn a_page_that_sends_too_much_is_shown_out() {
    let studio = MappingStudio::empty();
    let mut page = studio.page();
    page.send_too_much(&" ".repeat(1024 * 1024));
    assert!(page.is_shown_out());
    let mut other = studio.page();
    other.send(&json!({"type": "sample", "name": "nothing"}));
    assert!(other.error().contains("no recording"));
}
