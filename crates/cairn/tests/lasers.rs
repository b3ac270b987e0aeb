//! `cairn robot --laser`: drive and laser on two ports, the laser's bytes about the robot's own world.

#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod support;

use std::{
    io::{Read as _, Write as _},
    net::TcpStream,
    time::Duration,
};

use support::Place;
use wire::{ld06, rplidar, sick_lms};

/// A robot with that laser: its server and the laser's connection.
fn laser(place: &Place, kind: &str) -> (support::Server, TcpStream) {
    let arguments =
        format!("robot pioneer3dx --world doorbell --laser {kind} --listen 127.0.0.1:0");
    let (server, addresses) = place.serve_several(&arguments, 2);
    assert_ne!(addresses[0], addresses[1]);
    let stream = TcpStream::connect(&addresses[1]).unwrap();
    // Only a hanging server meets this limit.
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    (server, stream)
}

fn more(stream: &mut TcpStream) -> Vec<u8> {
    let mut buffer = [0; 4096];
    let n = stream.read(&mut buffer).unwrap();
    assert!(n > 0, "the laser hung up");
    buffer[..n].to_vec()
}

#[test]
fn an_ld06_talks_by_itself() {
    let place = Place::new();
    let (_server, mut stream) = laser(&place, "ld06");
    let mut decoder = ld06::Decoder::new();
    let (mut n_seen, mut n_points) = (0, 0);
    while n_points < 900 {
        decoder.push(&more(&mut stream));
        while let Some(packet) = decoder.next_packet() {
            n_points += packet.points.len();
            n_seen += packet.points.iter().filter(|point| point.distance_mm > 0).count();
        }
    }
    // Indoors most beams meet a wall.
    assert!(n_seen > n_points / 2, "{n_seen} of {n_points}");
    assert_eq!(decoder.n_bad_checksums(), 0);
}

#[test]
fn an_rplidar_is_asked_for_its_samples() {
    let place = Place::new();
    let (_server, mut stream) = laser(&place, "rplidar");
    let mut bytes = Vec::new();
    rplidar::Request::Health.encode(&mut bytes);
    rplidar::Request::Scan.encode(&mut bytes);
    stream.write_all(&bytes).unwrap();
    let mut decoder = rplidar::Decoder::new();
    let mut healthy = false;
    while decoder.n_nodes() < 360 {
        decoder.push(&more(&mut stream));
        while let Some(answer) = decoder.next_answer() {
            healthy |= matches!(answer, rplidar::Answer::Health(health) if health.status == 0);
        }
    }
    assert!(healthy);
}

#[test]
fn a_sick_sends_scans_when_it_is_told_to() {
    let place = Place::new();
    let (_server, mut stream) = laser(&place, "sick");
    let mut bytes = Vec::new();
    sick_lms::Request::Continuous.encode(0, &mut bytes);
    stream.write_all(&bytes).unwrap();
    let mut decoder = sick_lms::Decoder::new(sick_lms::Side::FromDevice);
    let mut n_scans = 0;
    while n_scans < 3 {
        decoder.push(&more(&mut stream));
        while let Some(item) = decoder.next_item() {
            let sick_lms::Item::Telegram { payload, .. } = item else { continue };
            if let Some((sick_lms::Reply::Scan(scan), _)) = sick_lms::Reply::decode(payload) {
                assert_eq!(scan.len(), 181);
                n_scans += 1;
            }
        }
    }
}

#[test]
fn what_is_wrong_with_a_laser_is_said() {
    let place = Place::new();
    let robot = "robot pioneer3dx --world doorbell --listen 127.0.0.1:0";
    let run = |more: &str| place.cairn(&format!("{robot} {more}"));
    run("--laser rplidr")
        .refused(2, &["there are sick, rplidar and ld06", "did you mean rplidar?"]);
    run("--laser-listen 127.0.0.1:0").refused(2, &["--laser"]);
    run("--laser sick --laser-at 3,0,0").refused(2, &["--laser-at 3,0,0", "at most 2 m"]);
    run("--laser sick --laser-at 1,2").refused(2, &["--laser-at 1,2", "three numbers"]);
}
