//! `cairn robot` for several clients, rude ones, over a serial line, and what it tells of them.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

mod support;

use std::{
    io::{Read as _, Write as _},
    net::TcpStream,
    time::Duration,
};

use serde_json::Value;
use support::{Place, Server};
use wire::arcos::{Command, Decoder, Report, Sip};

/// A client that speaks the robot's packets.
struct Client {
    stream: TcpStream,
    decoder: Decoder,
}

impl Client {
    fn new(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        // Only a hanging server meets this limit.
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        Self { stream, decoder: Decoder::new() }
    }

    fn send(&mut self, command: &Command) {
        let mut bytes = Vec::new();
        command.encode(&mut bytes).unwrap();
        self.stream.write_all(&bytes).unwrap();
    }

    fn next(&mut self) -> Report {
        loop {
            if let Some(packet) = self.decoder.next_packet() {
                return Report::decode(packet.body()).unwrap();
            }
            let mut buffer = [0; 512];
            let n = self.stream.read(&mut buffer).unwrap();
            assert!(n > 0, "the robot hung up");
            self.decoder.push(&buffer[..n]);
        }
    }

    fn next_sip(&mut self) -> Sip {
        loop {
            if let Report::Sip(sip) = self.next() {
                return sip;
            }
        }
    }

    /// Greets, opens and switches the motors on; the name that the robot gives.
    fn open(&mut self) -> String {
        self.send(&Command::Sync0);
        assert_eq!(self.next(), Report::Sync0);
        self.send(&Command::Sync1);
        assert_eq!(self.next(), Report::Sync1);
        self.send(&Command::Sync2);
        let Report::Sync2 { name, .. } = self.next() else { panic!("no name") };
        self.send(&Command::Open);
        self.send(&Command::Enable(1));
        name
    }

    /// What it is told before the connection ends, packets and all.
    fn last_words(&mut self) -> String {
        let mut words = Vec::new();
        // A connection that is reset has ended, too.
        let _reset = self.stream.read_to_end(&mut words);
        String::from_utf8_lossy(&words).into_owned()
    }
}

fn event(server: &mut Server, kind: &str) -> Value {
    loop {
        let line = server.line();
        assert!(!line.is_empty(), "it ended without telling of `{kind}`");
        let object: Value = serde_json::from_str(&line).unwrap();
        if object["event"] == kind {
            return object;
        }
    }
}

#[test]
fn robots_of_one_world_have_a_port_each() {
    let place = Place::new();
    let (_server, addresses) =
        place.serve_several("robot pioneer3dx --world doorbell --robots 3 --listen 127.0.0.1:0", 3);
    let mut clients: Vec<Client> = addresses.iter().map(|a| Client::new(a)).collect();
    let names: Vec<String> = clients.iter_mut().map(Client::open).collect();
    assert_eq!(names, ["pioneer3dx-1", "pioneer3dx-2", "pioneer3dx-3"]);
    // Only the one that is told to moves.
    clients[1].send(&Command::Rotate(50));
    let turned = std::iter::repeat_with(|| clients[1].next_sip())
        .take(30)
        .any(|sip| sip.heading_rad() > 0.2);
    assert!(turned);
    assert_eq!(clients[0].next_sip().heading_units, 0);
    assert_eq!(clients[2].next_sip().heading_units, 0);
}

/// A ROS map with its picture beside it, and a Moving AI map: the robot stands in the widest place.
#[test]
fn a_robot_drives_in_any_map() {
    let place = Place::new();
    for (name, bytes) in [
        ("ward.yaml", &include_bytes!("../../../missions/ward.yaml")[..]),
        ("ward.png", include_bytes!("../../../missions/ward.png")),
        ("hall.map", b"type octile\nheight 6\nwidth 9\nmap\n@@@@@@@@@\n@.......@\n@.......@\n@.......@\n@.......@\n@@@@@@@@@\n"),
    ] {
        std::fs::write(place.path(name), bytes).unwrap();
    }
    for world in ["ward.yaml", "hall.map"] {
        let server = place.serve(&format!("robot pioneer3dx --world {world} --listen 127.0.0.1:0"));
        let mut client = Client::new(&server.address);
        client.open();
        client.send(&Command::Enable(1));
        client.send(&Command::Vel(300));
        let farthest = (0..30).map(|_| client.next_sip().x_mm).max().unwrap();
        assert!(farthest > 200, "{world}: {farthest} mm");
    }
    place.cairn("robot pioneer3dx --world ward.png").refused(2, &["ward.png"]);
}

#[test]
fn a_silent_client_is_displaced_and_both_are_told() {
    let place = Place::new();
    let mut server =
        place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0 --format json");
    let address = server.address.clone();
    let mut first = Client::new(&address);
    first.open();
    first.send(&Command::Vel(100));
    // Half a packet is no sign of life.
    first.stream.write_all(&[0xFA, 0xFB, 60]).unwrap();
    let mut second = Client::new(&address);
    second.open();
    let words = first.last_words();
    assert!(words.contains("cairn: you were silent for 2"), "{words}");
    assert!(words.contains("has taken over"), "{words}");
    let displaced = event(&mut server, "displaced");
    let silent_s = displaced["silent_s"].as_f64().unwrap();
    assert!((2.0..4.0).contains(&silent_s), "{displaced}");
    assert_ne!(displaced["client"], displaced["by"]);
    // The second has a fresh robot, at rest.
    let sip = second.next_sip();
    assert!(sip.left_mmps.abs() < 100, "{sip:?}");
    drop(second);
    let left = event(&mut server, "left");
    assert_eq!(left["client"], displaced["by"]);
    assert!(left["driven_m"].as_f64().unwrap() < 0.2, "{left}");
}

#[test]
fn an_active_client_is_not_displaced_and_the_other_is_told() {
    let place = Place::new();
    let mut server =
        place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0 --format json");
    let address = server.address.clone();
    let mut first = Client::new(&address);
    first.open();
    let mut second = Client::new(&address);
    let mut third = Client::new(&address);
    // The first answers every information packet with a sign of life, meanwhile.
    let pulse = std::thread::spawn(move || {
        for _ in 0..40 {
            first.next_sip();
            first.send(&Command::Pulse);
        }
        first
    });
    let words = third.last_words();
    assert!(words.contains("one more waits"), "{words}");
    let words = second.last_words();
    assert!(words.contains("another client is connected and active"), "{words}");
    let refused = [event(&mut server, "refused"), event(&mut server, "refused")];
    assert!(refused[1]["connected"].is_string(), "{refused:?}");
    let mut first = pulse.join().unwrap();
    first.next_sip();
    // When it has left, the next one is welcome.
    drop(first);
    Client::new(&address).open();
}

#[test]
fn a_client_that_floods_and_does_not_read_costs_no_memory_and_has_to_go() {
    let place = Place::new();
    let mut server =
        place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0 --format json");
    let address = server.address.clone();
    let before = server.memory_bytes_max();
    let mut flood = Client::new(&address);
    flood.open();
    let mut packets = Vec::new();
    for _ in 0..4096 {
        Command::Config.encode(&mut packets).unwrap();
    }
    flood.stream.set_write_timeout(Some(Duration::from_secs(20))).unwrap();
    // Each asks for an answer of 150 bytes that nobody reads, until the connection breaks.
    let broke = (0..10_000).any(|_| flood.stream.write_all(&packets).is_err());
    assert!(broke);
    assert_eq!(event(&mut server, "dropped")["event"], "dropped");
    if let (Some(before), Some(after)) = (before, server.memory_bytes_max()) {
        assert!(after - before < 8 << 20, "{} bytes more", after - before);
    }
    Client::new(&address).open();
}

#[cfg(unix)]
#[test]
fn a_robot_answers_on_a_serial_line() {
    let (mut near, far) = serialport::TTYPort::pair().unwrap();
    let device = serialport::SerialPort::name(&far).unwrap();
    // The robot opens it by its name; as long as the near end is open it is there.
    drop(far);
    let place = Place::new();
    let _server = place.serve(&format!("robot pioneer3dx --world doorbell --serial {device}"));
    serialport::SerialPort::set_timeout(&mut near, Duration::from_secs(20)).unwrap();
    let mut ask = |command: &Command| {
        let mut question = Vec::new();
        command.encode(&mut question).unwrap();
        near.write_all(&question).unwrap();
        let (mut decoder, mut buffer) = (Decoder::new(), [0; 256]);
        loop {
            let n = near.read(&mut buffer).unwrap();
            decoder.push(&buffer[..n]);
            if let Some(packet) = decoder.next_packet() {
                return Report::decode(packet.body()).unwrap();
            }
        }
    };
    assert_eq!(ask(&Command::Sync0), Report::Sync0);
    assert_eq!(ask(&Command::Sync1), Report::Sync1);
    assert!(matches!(ask(&Command::Sync2), Report::Sync2 { .. }));
    assert!(matches!(ask(&Command::Open), Report::Sip(_)));
}

#[test]
fn what_clients_do_is_told_for_programs() {
    let place = Place::new();
    let mut server = place.serve(
        "robot pioneer3dx --world doorbell --listen 127.0.0.1:0 --format json --battery 19 \
         --start -2.6,-3.1,90",
    );
    let low = event(&mut server, "battery_low");
    assert!((low["charge_percent"].as_f64().unwrap() - 19.0).abs() < 0.1, "{low}");
    let address = server.address.clone();
    let mut client = Client::new(&address);
    client.open();
    assert!(event(&mut server, "connected")["client"].is_string());
    client.send(&Command::SimMessage(b"hello\nthere".to_vec()));
    let said = event(&mut server, "said");
    assert_eq!(said["said"], "hello\nthere");
    assert!(said["text"].as_str().unwrap().contains("hello\\nthere"));
    client.send(&Command::SimSetPose { x_mm: 90_000, y_mm: 0, heading_deg: 0 });
    assert_eq!(event(&mut server, "place_refused")["x_m"], 90.0);
    client.send(&Command::SimExit(3));
    assert_eq!(event(&mut server, "exit_asked")["code"], 3);
    client.send(&Command::Other { number: 26 });
    client.send(&Command::SimStat(1));
    let stat = loop {
        if let Report::SimStat(stat) = client.next() {
            break stat;
        }
    };
    assert_eq!((stat.x_mm, stat.y_mm, stat.heading_deg), (-2600, -3100, 90));
    // 19 % are 10.95 V, and it drains.
    assert!((109..=110).contains(&client.next_sip().battery_decivolts));
    drop(client);
    let left = event(&mut server, "left");
    assert_eq!(left["unknown_commands"], serde_json::json!([26]));
    assert!((left["x_m"].as_f64().unwrap() + 2.6).abs() < 1e-9, "{left}");
}

#[test]
fn messages_without_end_are_counted_instead_of_shown() {
    let place = Place::new();
    let mut server =
        place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0 --format json");
    let mut client = Client::new(&server.address.clone());
    client.open();
    for _ in 0..200 {
        client.send(&Command::SimMessage(b"noise".to_vec()));
    }
    // An answer shows that all were read.
    client.send(&Command::Encoder(1));
    while !matches!(client.next(), Report::Encoder(_)) {}
    drop(client);
    let left = event(&mut server, "left");
    let hidden = left["n_messages_not_shown"].as_u64().unwrap();
    // Ten a second are shown; of more than sixteen in a tick the rest is not even kept.
    assert!((1..200).contains(&hidden), "{left}");
}

#[test]
fn wishes_that_cannot_be_met_are_refused_with_2() {
    let place = Place::new();
    let robot = |rest: &str| place.cairn(&format!("robot {rest}"));
    robot("pioner3dx --world doorbell").refused(2, &["did you mean pioneer3dx?", "peoplebot"]);
    robot("pioneer3dx --world doorbell --robots 0").refused(2, &["from 1 to 64"]);
    robot("pioneer3dx --world doorbell --robots 3 --listen 127.0.0.1:65534")
        .refused(2, &["ports from 65534", "65535"]);
    robot("pioneer3dx --world doorbell --start 0,0,0 --start 1,1,0").refused(2, &["--robots"]);
    robot("pioneer3dx --world doorbell --battery 101").refused(2, &["from 0 to 100"]);
    robot("pioneer3dx --world doorbell --serial /dev/nosuch").refused(2, &["/dev/nosuch"]);
    robot("pioneer3dx --world doorbell --serial /dev/nosuch --robots 2").refused(2, &["--robots"]);
    let taken = place.serve("robot pioneer3dx --world doorbell --listen 127.0.0.1:0");
    let port: u16 = taken.address.rsplit(':').next().unwrap().parse().unwrap();
    // The second of two is in the way of the one that is there.
    robot(&format!("pioneer3dx --world doorbell --robots 2 --listen 127.0.0.1:{}", port - 1))
        .refused(2, &[&format!("the ports {} to {port}", port - 1), "in use"]);
}
