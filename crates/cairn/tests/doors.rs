//! `cairn robot` and `cairn pheromone-server` answer real bytes on a TCP port.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod support;

use std::{
    io::{Read as _, Write as _},
    net::TcpStream,
    time::Duration,
};

use support::{Place, short_drive};

fn connect(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    // Only a hanging server meets this limit.
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream
}

fn ask<const N: usize>(stream: &mut TcpStream, question: &[u8]) -> [u8; N] {
    stream.write_all(question).unwrap();
    let mut answer = [0; N];
    stream.read_exact(&mut answer).unwrap();
    answer
}

const SYNC0: [u8; 6] = [0xFA, 0xFB, 0x03, 0x00, 0x00, 0x00];
const SYNC1: [u8; 6] = [0xFA, 0xFB, 0x03, 0x01, 0x00, 0x01];
const SYNC2: [u8; 6] = [0xFA, 0xFB, 0x03, 0x02, 0x00, 0x02];
const OPEN: [u8; 6] = [0xFA, 0xFB, 0x03, 0x01, 0x00, 0x01];

#[test]
fn a_robot_greets_its_clients_one_after_the_other() {
    let place = Place::new();
    let server = place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0");
    for _client in 0..2 {
        let mut stream = connect(&server.address);
        assert_eq!(ask::<6>(&mut stream, &SYNC0), SYNC0);
        assert_eq!(ask::<6>(&mut stream, &SYNC1), SYNC1);
        let mut head = ask::<3>(&mut stream, &SYNC2);
        assert_eq!(head[..2], [0xFA, 0xFB]);
        let mut names = vec![0; usize::from(head[2])];
        stream.read_exact(&mut names).unwrap();
        let names = String::from_utf8_lossy(&names).into_owned();
        assert!(names.contains("Pioneer") && names.contains("p3dx-sh"), "{names:?}");
        // OPEN starts the information packets.
        head = ask::<3>(&mut stream, &OPEN);
        assert_eq!(head[..2], [0xFA, 0xFB]);
        let mut packet = vec![0; usize::from(head[2])];
        stream.read_exact(&mut packet).unwrap();
        assert!(packet[0] & 0xF0 == 0x30, "no information packet: {packet:02x?}");
    }
}

#[test]
fn the_pheromone_server_answers_the_golden_request() {
    let place = Place::new();
    // One source 400 mm ahead of the origin: 442.83 mm from either antenna, ⌊100 (1 − 442.83/600)⌋ = 26.
    place.write("map.txt", "0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 1\n0 0 0 0 0\n0 0 0 0 0\n");
    let server = place.serve("pheromone-server map.txt --listen 127.0.0.1:0");
    let mut stream = connect(&server.address);
    let question = [0x10, 2, 0x10, 0x10, 1, 7, 0, 0, 0, 0, 0, 0, 0x10, 3];
    let answer = [0x10, 2, 0x10, 0x10, 0x81, 7, 26, 26, 0, 0, 0x10, 3];
    assert_eq!(ask::<12>(&mut stream, &question), answer);
    // Turned round (180° = 0x00B4) the source is behind, and smells of nothing.
    let turned = [0x10, 2, 0x10, 0x10, 1, 7, 0, 0, 0, 0, 0, 0xB4, 0x10, 3];
    assert_eq!(ask::<12>(&mut stream, &turned)[6..8], [0, 0]);
}

/// Characters received, questions and errors, on the screen and for programs (the thesis, Annex B1).
#[test]
fn the_pheromone_server_shows_its_traffic() {
    let place = Place::new();
    place.write("map.txt", "0 0 0\n1 1 1\n0 0 0\n");
    let mut server =
        place.serve("pheromone-server map.txt --listen 127.0.0.1:0 --traffic-s 3600 --format json");
    let mut stream = connect(&server.address);
    assert!(server.line().contains("connected"));
    // A broken frame before the question; the client then leaves.
    let question = [0x10, 9, 0x10, 2, 0x10, 0x10, 1, 7, 0, 0, 0, 0, 0, 0, 0x10, 3];
    ask::<12>(&mut stream, &question);
    drop(stream);
    let traffic: serde_json::Value = serde_json::from_str(&server.line()).unwrap();
    assert_eq!(traffic["event"], "left");
    let counted = ["received_bytes", "sent_bytes", "requests", "errors", "broken_frames"]
        .map(|key| traffic[key].as_u64().unwrap());
    assert_eq!(counted, [16, 12, 1, 1, 1]);
    place.cairn("pheromone-server map.txt --traffic-s 0.01").refused(2, &["0.1 to 3600"]);
}

/// The mission's driver and the robot are two processes; what is between them is the real one's bytes.
#[test]
fn a_mission_drives_a_robot_in_another_process() {
    let place = Place::new();
    place.write("drive.toml", &short_drive(0.3));
    let server = place.serve("robot pioneer3dx --world drive.toml --listen 127.0.0.1:0");
    let link = format!("--set robots.line.kind=tcp --set robots.line.address={}", server.address);
    let short = "--set mission.duration_max_s=7";
    let run = place.cairn(&format!("run drive.toml --headless --format json {short} {link}"));
    // The true pose is the other process's; that the robot reports its arrival is what is seen here.
    let object = run.json();
    assert!(object["figures"]["arrival_s"].as_f64().is_some(), "{}", run.out);
    drop(server);
    place
        .cairn(&format!("run drive.toml --headless {link}"))
        .refused(2, &["cannot connect", "switched on"]);
}

#[test]
fn what_cannot_be_served_is_refused_with_2() {
    let place = Place::new();
    let robot = |rest: &str| place.cairn(&format!("robot {rest}"));
    robot("nosuch --world doorbell").refused(2, &["nosuch", "pioneer3dx", "peoplebot"]);
    robot("artemic5 --world artemic-e1").refused(2, &["ARTEMIC", "protocol", "peoplebot"]);
    robot("pioneer3dx --world absent.map").refused(2, &["absent.map", "No such file"]);
    robot("pioneer3dx --world office.map.gz").refused(2, &["unpack", "gunzip", "office.map.gz"]);
    robot("pioneer3dx --world doorbell --start 1,2").refused(2, &["three numbers"]);
    robot("pioneer3dx --world doorbell --start 100,100,0").refused(2, &["--start", "walls reach"]);
    robot("pioneer3dx --world doorbell --listen nowhere").refused(2, &["127.0.0.1:8101"]);
    let taken = place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0");
    robot(&format!("pioneer3dx --world doorbell --listen {}", taken.address))
        .refused(2, &["cannot listen", "--listen", "in use"]);
    place.write("map.txt", "0 1 0\n1 1\n");
    place.cairn("pheromone-server map.txt").refused(2, &["map.txt", "line 2", "2 values"]);
    place.cairn("pheromone-server map.txt --cell-m -1").refused(2, &["0.01 to 100"]);
}
