//! What the fuzzers do with bytes from strangers: one function per decoder.
//!
//! Each function feeds bytes to one reader and checks what it promises for any bytes at all: no
//! panic, bounded work, no difference when the bytes are cut, and that what was understood can be
//! written and read again. They are called by the fuzz targets in `fuzz/` and, for every file of
//! `fuzz/corpus/<name>/`, by an ordinary test of this crate.
//!
//! # Panics
//!
//! Every function panics when a promise is broken; that is how a fuzzer notices.
#![expect(clippy::missing_panics_doc, reason = "a panic is how every target reports a fault")]

mod lasers;

pub use lasers::{ld06_decoder, rplidar_decoder, sick_decoder};
use pheromones::{Field, Server, ServerConfig};
use recordings::ReadOptions;
use wire::{
    arcos, create_oi,
    dle::{ByteOrder, Receiver},
    ground_link, pheromone_link,
};

/// Feeds bytes to a decoder; panics when one of its promises is broken.
pub type Target = fn(&[u8]);

/// Name and function of every target; the name is that of its folder in `fuzz/corpus`.
pub const TARGETS: &[(&str, Target)] = &[
    ("activmedia_map", activmedia_map),
    ("arcos_decoder", arcos_decoder),
    ("cairn_scan", cairn_scan),
    ("create_oi", create_oi),
    ("decision_compile", decision_compile),
    ("decision_image", decision_image),
    ("dle_receiver", dle_receiver),
    ("ground_link", ground_link),
    ("ld06_decoder", ld06_decoder),
    ("mat_file", mat_file),
    ("mission_file", mission_file),
    ("pheromone_map", pheromone_map),
    ("pheromone_server", pheromone_server),
    ("recording_file", recording_file),
    ("rplidar_decoder", rplidar_decoder),
    ("sick_decoder", sick_decoder),
    ("trajectory_file", trajectory_file),
];

/// Whatever comes out, an error too, can be shown to a person.
fn shown(outcome: &impl std::fmt::Debug) {
    assert!(!format!("{outcome:?}").is_empty());
}

/// The packets of a Pioneer robot: found in the same places however the bytes are cut, and each
/// body read both as a command and as a report.
pub fn arcos_decoder(bytes: &[u8]) {
    let decode = |pieces: &[&[u8]]| {
        let mut decoder = arcos::Decoder::new();
        let mut bodies = Vec::new();
        for piece in pieces {
            decoder.push(piece);
            while let Some(packet) = decoder.next_packet() {
                bodies.push(packet.body().to_vec());
            }
        }
        (bodies, decoder.bytes_skipped(), decoder.bad_checksums())
    };
    let (head, tail) = bytes.split_at(bytes.len() / 2);
    let whole = decode(&[bytes]);
    assert_eq!(whole, decode(&[head, tail]), "a cut changes what is found");
    for body in &whole.0 {
        // Not everything is understood; what is understood must be read without harm.
        shown(&arcos::Command::decode(body));
        shown(&arcos::Report::decode(body));
        assert!(!arcos::describe(body, true).is_empty());
        assert!(!arcos::describe(body, false).is_empty());
    }
}

/// Both directions of a Create's line: commands and frames found in the same places however the bytes are cut, commands written
/// as they were read, and a robot in a world that is told them.
pub fn create_oi(bytes: &[u8]) {
    let decode = |pieces: &[&[u8]]| {
        let (mut commands, mut frames) =
            (create_oi::CommandDecoder::new(), create_oi::StreamDecoder::new());
        let mut found = (Vec::new(), Vec::new());
        for piece in pieces {
            commands.push(piece);
            frames.push(piece);
            found.0.extend(std::iter::from_fn(|| commands.next_command()));
            found.1.extend(std::iter::from_fn(|| frames.next_frame()));
        }
        (found, commands.bytes_dropped(), frames.bytes_skipped(), frames.bad_sums())
    };
    let (head, tail) = bytes.split_at(bytes.len() / 2);
    let whole = decode(&[bytes]);
    assert_eq!(whole, decode(&[head, tail]), "a cut changes what is found");
    for command in &whole.0.0 {
        let mut again = Vec::new();
        command.encode(&mut again);
        let ((read, _), dropped, ..) = decode(&[&again]);
        assert_eq!((read.first(), dropped), (Some(command), 0), "it reads back differently");
    }
    for towards in [wire::Towards::Robot, wire::Towards::Client] {
        if let Some(mut reader) = wire::reader("create_oi", towards) {
            reader.push(bytes, &mut |_, text| assert!(!text.is_empty()));
        }
    }
    serve_create(bytes);
}

/// A robot that hears noise: it keeps its limits and sends no more than its line carries and was asked for.
fn serve_create(bytes: &[u8]) {
    let spec = simulator::WorldSpec::empty();
    let step = std::time::Duration::from_millis(10);
    let Ok(mut world) = simulator::World::new(spec, run_context::RunSeed(1), step) else { return };
    let Ok(model) = robot_models::RobotModel::by_name("create2").map(std::sync::Arc::new) else {
        return;
    };
    let body = world.add_robot(simulator::RobotPlacement {
        name: "create".to_owned(),
        model: std::sync::Arc::clone(&model),
        world_from_base: geometry::Se2::IDENTITY,
        errors: robot_models::OdometryErrors::default(),
        sonar: sensor_models::SonarModel::default(),
    });
    let Ok(body) = body else { return };
    let mut served = virtual_robots::ServedWorld::new(world);
    let battery = virtual_robots::BatteryConfig::default();
    served.admit(body, Box::new(virtual_robots::CreateFirmware::new(model, battery)));
    let mut exchange = [virtual_robots::Exchange { received: bytes.to_vec(), out: Vec::new() }];
    for _ in 0..20 {
        served.tick(&mut exchange, &mut Vec::new());
        exchange[0].received.clear();
    }
    // Twenty ticks are fourteen frames; every byte may ask for a group of 80 at most.
    let most = 14 * create_oi::FRAME_LEN_MAX + 80 * bytes.len();
    assert!(exchange[0].out.len() <= most, "{} bytes of answers", exchange[0].out.len());
    let wheels = served.body_of(&served.boards()[0]).wheel_speeds;
    assert!(wheels.left_mps.abs().max(wheels.right_mps.abs()) <= 0.501, "{wheels:?}");
}

/// Frames of the radio links: never more payload than the buffer holds.
pub fn dle_receiver(bytes: &[u8]) {
    let mut receiver = Receiver::with_buffer_size(64);
    for &byte in bytes {
        if let Some(payload) = receiver.push(byte) {
            assert!(payload.len() < 64, "a payload longer than its buffer");
        }
    }
}

/// Messages between decision unit and vehicle, in both byte orders, with and without framing.
pub fn ground_link(bytes: &[u8]) {
    let mut receiver = Receiver::with_buffer_size(64);
    let mut payloads = vec![bytes.to_vec()];
    payloads.extend(bytes.iter().filter_map(|&byte| receiver.push(byte).map(<[u8]>::to_vec)));
    for payload in &payloads {
        for order in [ByteOrder::BigEndian, ByteOrder::LittleEndian] {
            let mut again = Vec::new();
            if let Ok(message) = ground_link::ToVehicle::decode(payload, order) {
                message.encode(order, wire::dle::Framing::Stuffed, &mut again);
                assert!(!again.is_empty(), "what was read cannot be written");
            }
            shown(&ground_link::ToGround::decode(payload, order));
            shown(&pheromone_link::Request::decode(payload, order));
            assert!(!ground_link::describe(payload, order, true).is_empty());
            assert!(!ground_link::describe(payload, order, false).is_empty());
            assert!(!pheromone_link::describe(payload, order).is_empty());
        }
        shown(&pheromone_link::Reply::decode(payload));
    }
}

/// A pheromone server that hears noise: it answers with at most a few bytes for each it hears.
pub fn pheromone_server(bytes: &[u8]) {
    let Ok(field) = Field::new(8, 8, 0.1) else { return };
    let mut server = Server::new(ServerConfig::default());
    let mut out = Vec::new();
    server.receive(&field, bytes, &mut out);
    assert!(out.len() <= 4 * bytes.len() + 16, "{} bytes of answers", out.len());
}

/// A pheromone map as text: what is read is written and read again as the same.
pub fn pheromone_map(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(field) = Field::from_text(&text, 0.1) {
        let again = Field::from_text(&field.to_text(), 0.1);
        let same = again
            .is_ok_and(|again| again.width() == field.width() && again.values() == field.values());
        assert!(same, "the map reads back differently");
    }
    shown(&Field::from_snapshot(&text));
}

/// A program of the decision language: analysed to the end, and its image is read back.
pub fn decision_compile(bytes: &[u8]) {
    let source = String::from_utf8_lossy(bytes);
    let compilation = decision::compile(&source);
    for diagnostic in &compilation.diagnostics {
        let span = diagnostic.span.start..diagnostic.span.end;
        assert!(source.get(span).is_some(), "{diagnostic:?} points beside the text");
    }
    if let Some(program) = compilation.program {
        run(decision::Machine::from_image(program.image(), decision::Mode::Corrected), 200);
        run(decision::Machine::new(program, decision::Mode::Listing), 200);
    }
}

/// Bytes taken for the image of a program.
pub fn decision_image(bytes: &[u8]) {
    shown(&decision::decode(bytes));
    // Few ticks: a damaged image runs astray until the watchdog barks, in every one of them.
    run(decision::Machine::from_image(bytes, decision::Mode::Corrected), 5);
    run(decision::Machine::from_image(bytes, decision::Mode::Listing), 5);
}

fn run(mut machine: decision::Machine, n_ticks: u32) {
    machine.run();
    for tick in 0..n_ticks {
        machine.set_inputs(tick as u16);
        machine.set_analog(0, tick as u8);
        machine.tick_10ms();
        machine.scan();
        machine.drain_moves(|_| {});
    }
}

/// A map of the robot's maker.
pub fn activmedia_map(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(map) = simulator::activmedia_map::parse(&text) {
        let world = map.to_segment_world();
        assert!(world.len() <= text.len(), "more walls than characters");
    }
}

/// A mission file: what is accepted is written out and accepted again.
pub fn mission_file(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(mission) = missions::Mission::parse("fuzzed", &text, &[]) {
        let again = missions::Mission::parse("fuzzed again", &mission.to_toml(), &[]);
        assert!(again.is_ok(), "{:?}", again.err());
    }
}

/// Between the two files of a recording in the corpus.
const SECOND_FILE: &[u8] = b"=====\n";

/// A recording of any format, with its second file behind a line of `=====`; what is read holds what a
/// recording promises, and as CSV reads back as the same.
pub fn recording_file(bytes: &[u8]) {
    let at = bytes.windows(SECOND_FILE.len()).position(|w| w == SECOND_FILE);
    let (first, second) =
        at.map_or((bytes, &[][..]), |at| (&bytes[..at], &bytes[at + SECOND_FILE.len()..]));
    let options = ReadOptions {
        poses: Some(second),
        truth: (!second.is_empty()).then_some(second),
        bytes_max: 1 << 22,
        ..ReadOptions::default()
    };
    let loaded = match recordings::read("fuzzed", first, &options) {
        Ok(loaded) => loaded,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let recording = &loaded.recording;
    assert!(recording.scans.is_sorted_by_key(|scan| scan.stamp), "time goes back");
    let n = recording.rig.n_readings();
    for scan in &recording.scans {
        assert_eq!(scan.ranges_m.len(), n);
        assert!(scan.ranges_m.iter().all(|range| *range >= 0.0), "{:?}", scan.ranges_m);
    }
    let text = recordings::csv::write(recording);
    let again = recordings::read("again", text.as_bytes(), &ReadOptions::default());
    match again {
        // Scans whose clock was mended may now be repeats of each other.
        Ok(again) => assert!(again.recording.scans.len() <= recording.scans.len(), "{text}"),
        Err(error) => panic!("what was written cannot be read again: {error}\n{text}"),
    }
}

/// A MAT file: no matrix has other than its size in values, and what is read is written and read again.
pub fn mat_file(bytes: &[u8]) {
    let Ok(file) = recordings::mat::MatFile::parse(bytes, 1 << 22) else { return };
    for matrix in &file.matrices {
        assert_eq!(matrix.values.len(), matrix.dimensions.iter().product::<usize>());
    }
    let written = recordings::mat::write(&file.matrices);
    let again = recordings::mat::MatFile::parse(&written, 1 << 26);
    assert!(again.is_ok_and(|again| again.matrices.len() == file.matrices.len()));
}

/// Poses and relations: in order, and what is written reads back as many.
pub fn trajectory_file(bytes: &[u8]) {
    shown(&recordings::trajectories::read_relations("fuzzed", bytes));
    if let Ok(found) = recordings::trajectories::read_poses("fuzzed", bytes) {
        assert!(found.poses.is_sorted_by_key(|pose| pose.stamp));
        let text = recordings::trajectories::write_tum(&found.poses, found.epoch_ns);
        let again = recordings::trajectories::read_poses("again", text.as_bytes());
        assert!(again.is_ok_and(|again| again.poses.len() == found.poses.len()));
    }
}

/// One message of a robot's scans: what is read is the same bytes when it is written.
pub fn cairn_scan(bytes: &[u8]) {
    shown(&recordings::cairn_mcap::decode_rig(bytes));
    if let Ok(message) = recordings::cairn_mcap::decode_scan(bytes) {
        let mut again = Vec::new();
        recordings::cairn_mcap::encode_scan(&message.scan, message.truth, &mut again);
        let decoded = recordings::cairn_mcap::decode_scan(&again);
        assert_eq!(decoded, Ok(message), "the message reads back differently");
    }
}
