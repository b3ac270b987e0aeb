//! The packets that the guide prints are whole, and mean what it says.

use wire::arcos::{Command, Decoder, EncoderPac, GripperPac, IoFields, PowerFields, Report, Sip};

const GUIDE: &str = include_str!("../../../docs/guide/robots.md");

#[test]
fn the_samples_of_the_guide_are_packets() {
    let samples = GUIDE.split('`').filter(|text| text.starts_with("FA FB ") && !text.contains('…'));
    let bodies: Vec<Vec<u8>> = samples
        .map(|text| {
            let bytes = text.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap());
            let mut decoder = Decoder::new();
            decoder.push(&bytes.collect::<Vec<u8>>());
            let body = decoder.next_packet().unwrap().body().to_vec();
            assert_eq!((decoder.bytes_skipped(), decoder.has_unfinished()), (0, false), "{text}");
            body
        })
        .collect();
    let commands: Vec<Command> =
        bodies[..2].iter().map(|body| Command::decode(body).unwrap()).collect();
    assert_eq!(commands, [Command::Vel(300), Command::Vel(-300)]);
    let battery_decivolts = 126;
    let at_rest = Sip {
        battery_decivolts,
        flags: 0b111,
        io: Some(IoFields::default()),
        power: Some(PowerFields { battery_decivolts: 126, ..PowerFields::default() }),
        ..Sip::AT_REST
    };
    let reports: Vec<Report> =
        bodies[2..].iter().map(|body| Report::decode(body).unwrap()).collect();
    assert_eq!(
        reports,
        [
            Report::Sip(at_rest),
            Report::Encoder(EncoderPac { left_ticks: 1000, right_ticks: -1000 }),
            Report::Gripper(GripperPac::default()),
        ]
    );
}

#[test]
fn the_map_of_the_guide_is_a_map() {
    let block = GUIDE.split("```").find_map(|block| block.strip_prefix("text\n2D-Map")).unwrap();
    let map = simulator::activmedia_map::parse(&format!("2D-Map{block}")).unwrap();
    assert_eq!((map.lines.len(), map.points.len(), map.things.len()), (5, 0, 2));
    assert_eq!(map.warnings, []);
    let home = map.home.unwrap();
    assert_eq!((home.x_m, home.y_m), (1.0, 2.0));
}
