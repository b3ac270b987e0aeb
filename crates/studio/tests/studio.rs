//! The studio as its page meets it: a real server, real sockets, real runs.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::{Studio, live, record, step_of};
use serde_json::{Value, json};

#[test]
fn a_page_is_greeted_told_the_log_and_shown_states() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    let hello = page.next();
    assert_eq!((&hello["type"], &hello["protocol"]), (&json!("hello"), &json!(2)));
    assert_eq!(
        (&hello["mission"]["name"], &hello["mission"]["kind"]),
        (&json!("doorbell"), &json!("live"))
    );
    assert!(hello["missions"].as_array().unwrap().len() > 3);
    assert_eq!(page.next()["type"], "log");
    assert_eq!(page.next()["type"], "history");
    let first = page.state(|_| true);
    assert_eq!((&first["playing"], &first["robots"][0]["id"]), (&json!(true), &json!(0)));
    page.state(|s| step_of(s) > step_of(&first) + 20);
}

#[test]
fn pause_holds_time_and_step_takes_one_control_period() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    let held = page.pause();
    assert_eq!(held["achieved_ratio"], 0.0);
    let stepped = page.step(&held);
    assert_eq!((step_of(&stepped), &stepped["playing"]), (step_of(&held) + 20, &json!(false)));
    page.send(&json!({"type": "play"}));
    page.state(|s| s["playing"] == true && step_of(s) > step_of(&stepped));
}

#[test]
fn the_speed_is_taken_within_its_range_only() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    page.pause();
    for ratio in [0.1, 4.0, 20.0] {
        page.send(&json!({"type": "speed", "ratio": ratio}));
        page.state(|s| s["speed_ratio"] == ratio);
    }
    for ratio in [0.0, 20.5, -1.0] {
        page.send(&json!({"type": "speed", "ratio": ratio}));
        assert!(page.error().contains("from 0.1 to 20"));
    }
    page.send(&json!({"type": "pause"}));
    page.state(|s| s["speed_ratio"] == 20.0);
}

#[test]
fn a_pressed_bell_reaches_the_program() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    let held = page.pause();
    page.send(&json!({"type": "press", "device": "bell"}));
    let after = page.step(&held);
    let bell = after["devices"].as_array().unwrap().iter().find(|d| d["name"] == "bell").unwrap();
    assert_eq!(bell["on"], true);
    assert_eq!(after["decision"]["resources"]["I0"].as_u64().unwrap() & 1, 1);
    let edges = after["decision"]["edges"].as_array().unwrap();
    assert!(edges.iter().any(|edge| edge[1] == "I0" && edge[2] == true), "{edges:?}");
    page.send(&json!({"type": "press", "device": "gong"}));
    assert!(page.error().contains("gong"));
}

#[test]
fn a_box_can_be_put_down_and_taken_away_while_time_stands_still() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    let n_boxes = |s: &Value| s["things"].as_array().unwrap().len();
    assert_eq!(n_boxes(&page.pause()), 0);
    page.send(&json!({"type": "place", "at_m": [2.3, 0.0], "size_m": 0.4}));
    let with_box = page.state(|s| n_boxes(s) == 1);
    let thing = &with_box["things"][0];
    assert_eq!((&thing["kind"], &thing["removable"]), (&json!("box"), &json!(true)));
    let corners = thing["corners_m"].as_array().unwrap();
    let mean = |axis: usize| corners.iter().map(|c| c[axis].as_f64().unwrap()).sum::<f64>() / 4.0;
    assert!((mean(0) - 2.3).abs() < 1e-3 && mean(1).abs() < 1e-3, "{corners:?}");
    for id in [999, 0] {
        page.send(&json!({"type": "remove", "id": id}));
        assert!(!page.error().is_empty(), "furniture and what is not there stay");
    }
    page.send(&json!({"type": "remove", "id": thing["id"]}));
    page.state(|s| n_boxes(s) == 0);
}

#[test]
fn a_goal_reaches_the_robot_and_stop_stops_it() {
    let studio = Studio::of("one-obstacle", 10.0);
    let mut page = studio.page();
    page.send(&json!({"type": "goal", "robot": 0, "pose": [1.0, 0.5, 0.3]}));
    page.state(|s| {
        let at = |i: usize| s["robots"][0]["goal"][i].as_f64().unwrap_or(9.0);
        (at(0) - 1.0).abs() < 2e-3 && (at(1) - 0.5).abs() < 2e-3
    });
    page.state(|s| s["robots"][0]["task"].as_str().unwrap().contains("(1.0, 0.5)"));
    page.send(&json!({"type": "stop", "robot": 0}));
    page.state(|s| s["robots"][0]["phase"] == "idle" && s["robots"][0]["task"] == "");
    page.send(&json!({"type": "stop", "robot": 7}));
    assert!(page.error().contains('7'));
}

#[test]
fn a_restart_takes_seed_and_mission_and_forgets_the_old_run() {
    let studio = Studio::of("doorbell", 20.0);
    let mut page = studio.page();
    let first = page.until("hello", |_| true);
    page.state(|s| step_of(s) > 300);
    page.pause();
    page.send(&json!({"type": "restart", "seed": 7, "mission": null}));
    let second = page.until("hello", |_| true);
    assert_eq!(
        (&second["mission"]["seed"], &second["mission"]["name"]),
        (&json!(7), &json!("doorbell"))
    );
    assert_ne!(first["run"], second["run"]);
    let state = page.state(|_| true);
    assert!(step_of(&state) < 300 && state["playing"] == true, "{state}");
    page.send(&json!({"type": "restart", "seed": null, "mission": "trail-45deg"}));
    assert_eq!(page.until("hello", |_| true)["mission"]["name"], "trail-45deg");
    for name in ["nowhere", "../../missions/doorbell.toml", "/etc/passwd"] {
        page.send(&json!({"type": "restart", "seed": null, "mission": name}));
        assert!(page.error().contains("no mission"), "only shipped names are read");
    }
}

#[test]
fn a_bad_message_is_answered_and_the_connection_stays() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    for text in
        ["", "play", "{}", r#"{"type":"fly"}"#, r#"{"type":"speed","ratio":"fast"}"#, "[1,2"]
    {
        page.send_text(text);
        assert!(page.error().contains("not understood"), "{text}");
    }
    page.pause();
}

/// The page's messages are short; what is longer is not even taken in.
#[test]
fn a_page_that_sends_too_much_is_shown_out() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    page.send_too_much(&" ".repeat(1024 * 1024));
    assert!(page.is_shown_out());
}

#[test]
fn foreign_origins_and_hosts_are_turned_away() {
    let studio = Studio::of("decision-rig", 1.0);
    let (own, port) = (studio.address.to_string(), studio.address.port());
    for origin in [
        "http://example.org",
        "null",
        &format!("https://{own}"),
        &format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        assert_eq!(studio.page_as(origin, &own).unwrap_err(), 403, "{origin}");
    }
    let foreign = format!("rebound.example.org:{port}");
    assert_eq!(studio.page_as(&format!("http://{foreign}"), &foreign).unwrap_err(), 403);
    for path in ["/", "/api/missions", "/assets/studio.js"] {
        assert!(studio.get(path, &foreign).0.contains("403"), "{path}");
    }
    let local = format!("localhost:{port}");
    assert!(studio.page_as(&format!("http://{local}"), &local).is_ok());
}

#[test]
fn files_come_with_their_types_and_a_content_policy() {
    let studio = Studio::of("decision-rig", 1.0);
    let own = studio.address.to_string();
    for (path, kind) in [
        ("/", "text/html"),
        ("/assets/studio.js", "text/javascript"),
        ("/assets/studio.css", "text/css"),
        ("/assets/favicon.svg", "image/svg+xml"),
        ("/assets/third-party.txt", "text/plain"),
        ("/api/missions", "application/json"),
        ("/healthz", "text/plain"),
    ] {
        let (status, headers, body) = studio.get(path, &own);
        assert!(status.contains("200") && !body.is_empty(), "{path}: {status}");
        assert!(headers.contains(&format!("content-type: {kind}")), "{path}: {headers}");
        assert!(headers.contains("content-security-policy: default-src 'self'"), "{path}");
        assert!(headers.contains("x-content-type-options: nosniff"), "{path}");
    }
    for path in ["/assets/", "/assets/../Cargo.toml", "/assets/nothing.js", "/etc/passwd"] {
        assert!(studio.get(path, &own).0.contains("404"), "{path}");
    }
}

#[test]
fn the_verdict_arrives_and_time_stands_still_at_it() {
    let studio = Studio::of("decision-rig", 20.0);
    let mut page = studio.page();
    let end = page.state(|s| !s["verdict"].is_null());
    assert_eq!((&end["verdict"]["passed"], &end["playing"]), (&json!(true), &json!(false)));
    assert!(!end["verdict"]["checks"].as_array().unwrap().is_empty());
    page.send(&json!({"type": "play"}));
    let on = page.state(|s| step_of(s) > step_of(&end) + 50);
    assert_eq!(on["playing"], true, "whoever plays on may watch what happens next");
}

#[test]
fn pulses_shorter_than_a_state_are_told_at_twenty_times() {
    let studio = Studio::of("decision-rig", 20.0);
    let mut page = studio.page();
    let mut seen = Vec::new();
    loop {
        let state = page.state(|_| true);
        for edge in state["decision"]["edges"].as_array().unwrap() {
            if edge[1] == "I0" && !seen.contains(edge) {
                seen.push(edge.clone());
            }
        }
        if !state["verdict"].is_null() {
            break;
        }
    }
    let levels: Vec<bool> = seen.iter().map(|edge| edge[2].as_bool().unwrap()).collect();
    assert_eq!(levels, [true, false], "{seen:?}");
    let lasted_s = seen[1][0].as_f64().unwrap() - seen[0][0].as_f64().unwrap();
    assert!((lasted_s - 0.5).abs() < 0.02, "the bell is pressed for half a second, not {lasted_s}");
}

#[test]
fn a_page_that_comes_late_hears_the_log_so_far() {
    let studio = Studio::of("decision-rig", 20.0);
    studio.page().state(|s| !s["verdict"].is_null());
    let mut late = studio.page();
    assert_eq!(late.next()["type"], "hello");
    let log = late.next();
    let passed = |item: &Value| {
        item["level"] == "good" && item["text"].as_str().unwrap().starts_with("passed")
    };
    assert!(log["items"].as_array().unwrap().iter().any(passed), "{log}");
    assert_eq!(late.next()["type"], "history");
    assert!(!late.next()["verdict"].is_null(), "and the state comes at once");
}

#[test]
fn two_pages_see_the_same_run() {
    let studio = Studio::of("doorbell", 1.0);
    let (mut one, mut other) = (studio.page(), studio.page());
    other.state(|s| s["playing"] == true);
    let held = one.pause();
    assert_eq!(other.state(|s| s["playing"] == false)["step"], held["step"]);
    let stepped = other.step(&held);
    assert_eq!(one.state(|s| step_of(s) > step_of(&held))["step"], stepped["step"]);
}

/// Twelve megabytes that nobody takes: the socket's buffers are full long before the end.
#[test]
fn a_page_that_does_not_read_holds_up_nobody() {
    let studio = Studio::of("swarm", 1.0);
    let lazy = studio.page();
    let mut page = studio.page();
    let held = page.pause();
    let mut n_bytes = 0;
    for i in 1.. {
        let ratio = 0.5 + f64::from(i % 64) / 64.0;
        page.send(&json!({"type": "speed", "ratio": ratio}));
        n_bytes += page.state(|s| s["speed_ratio"] == ratio).to_string().len();
        if n_bytes > 12_000_000 {
            break;
        }
    }
    drop(lazy);
    page.step(&held);
}

#[test]
fn a_replay_plays_and_refuses_to_be_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.mcap");
    record("decision-rig", &path);
    let studio = Studio::start(studio::Show::Replay(path), 20.0);
    let mut page = studio.page();
    assert_eq!(page.until("hello", |_| true)["mission"]["kind"], "replay");
    for request in [
        json!({"type": "place", "at_m": [0.0, 0.0], "size_m": 0.4}),
        json!({"type": "press", "device": "bell"}),
        json!({"type": "goal", "robot": 0, "pose": [0.0, 0.0, 0.0]}),
        json!({"type": "stop", "robot": 0}),
        json!({"type": "remove", "id": 1}),
    ] {
        page.send(&request);
        assert!(page.error().contains("replay"), "{request}");
    }
    let end = page.state(|s| !s["verdict"].is_null());
    assert_eq!(end["verdict"]["passed"], true);
}

/// Wound to a time, forwards and backwards, a recording shows what it showed when it was played there.
#[test]
fn a_replay_is_wound_to_any_time_and_shows_the_same_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    record("one-obstacle", &path);
    let studio = Studio::start(studio::Show::Replay(path), 1.0);
    let mut page = studio.page();
    let hello = page.until("hello", |_| true);
    let length_s = hello["mission"]["length_s"].as_f64().unwrap();
    assert!(length_s > 10.0);
    assert!(
        hello["mission"]["marks"].as_array().unwrap().iter().any(|m| m[2] == "a goal is given")
    );
    page.pause();
    let mut at = |t_s: f64| {
        page.send(&json!({"type": "seek", "t_s": t_s}));
        let hello = page.until("hello", |_| true);
        assert_eq!(hello["mission"]["length_s"], length_s);
        let history = page.until("history", |_| true);
        let last_s = history["t_s"].as_array().unwrap().last().map_or(0.0, |t| t.as_f64().unwrap());
        assert!(
            (last_s - t_s.clamp(0.0, length_s)).abs() <= 0.1 + 1e-9,
            "the past up to there: {last_s} s"
        );
        let state = page.state(|_| true);
        assert_eq!(state["playing"], false);
        state
    };
    let first = at(9.0);
    assert_eq!(first["step"], 900);
    let later = at(12.5);
    assert_ne!(first["robots"], later["robots"]);
    let again = at(9.0);
    assert_eq!((&first["robots"], &first["signals"]), (&again["robots"], &again["signals"]));
    assert_eq!(at(1e9)["verdict"]["passed"], true);
    assert_eq!(at(-3.0)["step"], 0);
    page.send(&json!({"type": "play"}));
    page.state(|s| step_of(s) > 20);
    let live = Studio::of("one-obstacle", 1.0);
    let mut page = live.page();
    page.send(&json!({"type": "seek", "t_s": 1.0}));
    assert!(page.error().contains("only a recording"));
}

#[test]
fn a_recording_is_completed_when_the_studio_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("live.mcap");
    let studio = Studio::start(live("decision-rig", Some(path.clone())), 20.0);
    let mut page = studio.page();
    page.send(&json!({"type": "press", "device": "bell"}));
    page.state(|s| !s["verdict"].is_null());
    let address = studio.address;
    assert_eq!(studio.stop(), std::slice::from_ref(&path));
    assert!(std::net::TcpStream::connect(address).is_err(), "the port is free again");
    let report = missions::Replay::open(&path).unwrap().run_to_end();
    assert!(report.is_identical() && report.truncation.is_none(), "{report:?}");
}

#[test]
fn a_restart_goes_on_recording_under_a_name_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("run-2.mcap"), "somebody else's").unwrap();
    let studio = Studio::start(live("decision-rig", Some(at("run.mcap"))), 20.0);
    let mut page = studio.page();
    let mut run = page.until("hello", |_| true)["run"].clone();
    for mission in [serde_json::Value::Null, json!("one-obstacle")] {
        page.state(|s| step_of(s) > 100);
        page.send(&json!({"type": "restart", "seed": null, "mission": mission}));
        run = page.until("hello", |h| h["run"] != run)["run"].clone();
        let says_where =
            |log: &serde_json::Value| log.to_string().contains(".mcap.part until it ends");
        page.until("log", says_where);
    }
    page.state(|s| step_of(s) > 10);
    let recorded = [at("run.mcap"), at("run-3.mcap"), at("run-4.mcap")];
    assert_eq!(studio.stop(), recorded);
    for path in recorded {
        let report = missions::Replay::open(&path).unwrap().run_to_end();
        assert!(report.is_identical() && report.steps > 0, "{report:?}");
    }
    assert_eq!(std::fs::read_to_string(at("run-2.mcap")).unwrap(), "somebody else's");
}

/// A thousand robots: few and small states.
#[test]
fn a_crowd_is_told_ten_times_a_second_in_brief() {
    let studio = Studio::of("swarm", 1.0);
    let mut page = studio.page();
    let hello = page.until("hello", |_| true);
    assert_eq!(hello["crowd"]["n_robots"], 999);
    let first = page.state(|s| step_of(s) > 0);
    assert_eq!(first["crowd"].as_array().unwrap().len(), 999);
    assert!(first.to_string().len() < 60_000);
    page.state(|s| step_of(s) > step_of(&first));
}

#[test]
fn a_page_that_comes_late_sees_the_way_driven_and_the_curves() {
    let studio = Studio::of("one-obstacle", 20.0);
    let mut page = studio.page();
    let held = page.state(|s| s["t_s"].as_f64().unwrap() > 20.0);
    let history = studio.page().until("history", |_| true);
    let t_s = history["t_s"].as_array().unwrap();
    let last_s = t_s.last().unwrap().as_f64().unwrap();
    assert!(t_s[0].as_f64().unwrap() <= 0.2 && last_s >= held["t_s"].as_f64().unwrap() - 0.2);
    let truth = history["robots"][0]["truth"].as_array().unwrap();
    assert_eq!(truth.len(), 2 * t_s.len());
    let x_m = |i: usize| truth[2 * i].as_f64().unwrap();
    assert!(x_m(t_s.len() - 1) - x_m(0) > 1.0, "it has driven");
    assert_eq!(history["columns"]["clearance_m"].as_array().unwrap().len(), t_s.len());
}

#[test]
fn a_page_drives_by_hand_and_its_end_stops_the_robot() {
    let studio = Studio::of("one-obstacle", 4.0);
    let (mut page, mut other) = (studio.page(), studio.page());
    other.state(|s| s["t_s"].as_f64().unwrap() > 1.0);
    let drive = json!({"type": "drive", "robot": 0, "speed_mps": 0.2, "turn_rate_radps": 0.0});
    for _ in 0..10 {
        page.send(&drive);
        let before = page.state(|_| true);
        page.state(|s| s["t_s"].as_f64().unwrap() >= before["t_s"].as_f64().unwrap() + 0.1);
    }
    let driven = page.state(|s| s["robots"][0]["phase"] == "driven by hand");
    assert_eq!(driven["speed_ratio"], 1.0, "nobody steers what is faster than life");
    assert!(driven["robots"][0]["wheels_mps"][0].as_f64().unwrap() > 0.05, "{driven}");
    drop(page);
    let stopped = other.state(|s| s["robots"][0]["phase"] != "driven by hand");
    other.state(|s| s["robots"][0]["wheels_mps"][0].as_f64().unwrap().abs() < 1e-3);
    let after_s = stopped["t_s"].as_f64().unwrap() - driven["t_s"].as_f64().unwrap();
    assert!(after_s < 1.5, "{after_s} s");
    other.pause();
    other.send(&drive);
    assert!(other.error().contains("press Play"));
}

#[test]
fn own_missions_are_brought_by_a_page_and_stay_in_the_list() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    page.until("hello", |_| true);
    let mine = "[mission]\nname = \"mine\"\nduration_max_s = 9.0\n\
                [world]\nbounds_m = [-1.0, -1.0, 1.0, 1.0]\n[[robots]]\nname = \"robot\"\n\
                [robots.mind]\nhow.method = \"straight\"\n";
    let (status, _) = studio.post("/api/mission?name=mine.toml", mine.as_bytes());
    assert!(status.contains("204"), "{status}");
    let is_own = |hello: &Value| {
        let all = hello["missions"].as_array().unwrap().clone();
        all.iter().any(|m| m["name"] == "mine" && m["own"] == true)
    };
    let hello = page.until("hello", |_| true);
    assert!(hello["mission"]["name"] == "mine" && is_own(&hello), "{hello}");
    page.send(&json!({"type": "restart", "seed": null, "mission": "doorbell"}));
    let hello = page.until("hello", |_| true);
    assert!(hello["mission"]["name"] == "doorbell" && is_own(&hello), "it stays");
    page.send(&json!({"type": "restart", "seed": null, "mission": "mine"}));
    assert_eq!(page.until("hello", |_| true)["mission"]["name"], "mine");
    let wrong = mine.replace("duration_max_s", "duration");
    let (status, text) = studio.post("/api/mission?name=wrong.toml", wrong.as_bytes());
    assert!(
        status.contains("422") && text.contains("wrong.toml") && text.contains("line 3"),
        "{text}"
    );
    let (status, _) = studio.post("/api/mission?name=x.toml", &vec![b'#'; 300 * 1024]);
    assert!(status.contains("413"), "{status}");
    page.pause();
}

/// The run goes on while a page looks back, and what it sees is what was shown then, however late it came.
#[test]
fn a_page_looks_back_while_the_run_goes_on() {
    let studio = Studio::of("doorbell", 20.0);
    let mut page = studio.page();
    page.state(|s| step_of(s) > 400);
    // So slow that every step is shown, and one of them is kept.
    page.send(&json!({"type": "speed", "ratio": 0.1}));
    page.state(|s| s["speed_ratio"] == 0.1);
    let shown = page.state(|s| step_of(s).is_multiple_of(10));
    page.send(&json!({"type": "speed", "ratio": 20.0}));
    let now = page.state(|s| step_of(s) > step_of(&shown) + 300);
    let mut late = studio.page();
    for page in [&mut page, &mut late] {
        page.send(&json!({"type": "past", "t_s": shown["t_s"]}));
        let past = page.until("past", |_| true);
        let then = &past["state"];
        assert_eq!(then["t_s"], shown["t_s"]);
        for key in ["robots", "people", "things", "devices", "signals"] {
            assert_eq!(then[key], shown[key], "{key}");
        }
        assert_eq!(then["decision"]["resources"], shown["decision"]["resources"]);
        assert!(past["kept"]["n_bytes"].as_u64() <= past["kept"]["bytes_max"].as_u64());
        assert!(past["kept"]["n_states"].as_u64() > Some(50), "{}", past["kept"]);
        page.state(|s| step_of(s) > step_of(&now) && s["playing"] == true);
    }
    page.send(&json!({"type": "past", "t_s": -5}));
    assert_eq!(page.until("past", |_| true)["state"]["step"], 0);
    page.send(&json!({"type": "past", "t_s": 1e9}));
    let newest = page.until("past", |_| true);
    assert!(step_of(&newest["state"]) > step_of(&now));
    page.send(&json!({"type": "restart", "seed": 3, "mission": null}));
    page.until("hello", |_| true);
    page.send(&json!({"type": "past", "t_s": 1e9}));
    let fresh = page.until("past", |_| true);
    assert!(step_of(&fresh["state"]) < step_of(&now), "nothing of the old run is left");
}

#[test]
fn a_page_cuts_a_line_and_mends_it() {
    let studio = Studio::of("doorbell", 1.0);
    let mut page = studio.page();
    for (cut, word) in [(true, "cut"), (false, "")] {
        page.send(&json!({"type": "cut", "robot": 0, "line": "pheromones", "cut": cut}));
        page.until("log", |log| {
            let items = log["items"].as_array().unwrap();
            items.iter().any(|item| {
                let text = item["text"].as_str().unwrap();
                text.contains("pheromone server") && text.contains(word)
            })
        });
    }
    page.send(&json!({"type": "cut", "robot": 9, "line": "ground", "cut": true}));
    assert!(page.error().contains('9'));
}
