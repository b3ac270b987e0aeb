//! Reading along on a link: bytes to packets to a line of text each.

use wire::{
    arcos,
    dle::{ByteOrder, Receiver},
    ground_link, pheromone_link,
};

/// Where packets go: receiving node, bytes, text.
pub(super) type Taken<'a> = &'a mut dyn FnMut(&'static str, Vec<u8>, String);

/// A reader of one link in both directions.
#[derive(Debug)]
pub(super) enum Tap {
    /// The robot's link.
    Arcos { to_robot: arcos::Decoder, to_navigation: arcos::Decoder },
    /// The pheromone server's link.
    Pheromones { to_server: Receiver, to_navigation: Receiver },
    /// The link between ground and vehicle.
    Ground { to_vehicle: Receiver, to_ground: Receiver },
}

impl Tap {
    pub(super) fn arcos() -> Self {
        Self::Arcos { to_robot: arcos::Decoder::new(), to_navigation: arcos::Decoder::new() }
    }

    pub(super) fn pheromones() -> Self {
        Self::Pheromones { to_server: Receiver::default(), to_navigation: Receiver::default() }
    }

    pub(super) fn ground() -> Self {
        Self::Ground { to_vehicle: Receiver::default(), to_ground: Receiver::default() }
    }

    /// Reads bytes that went away from the navigation node.
    pub(super) fn outward(&mut self, bytes: &[u8], take: Taken<'_>) {
        let order = ByteOrder::default();
        match self {
            Self::Arcos { to_robot, .. } => arcos_packets(to_robot, bytes, false, "robot", take),
            Self::Pheromones { to_server, .. } => frames(to_server, bytes, &mut |payload, raw| {
                take("server", raw, pheromone_link::describe(payload, order));
            }),
            Self::Ground { to_ground, .. } => frames(to_ground, bytes, &mut |payload, raw| {
                take("decision", raw, ground_link::describe(payload, order, true));
            }),
        }
    }

    /// Reads bytes that came to the navigation node.
    pub(super) fn inward(&mut self, bytes: &[u8], take: Taken<'_>) {
        let order = ByteOrder::default();
        match self {
            Self::Arcos { to_navigation, .. } => {
                arcos_packets(to_navigation, bytes, true, "navigation", take);
            }
            Self::Pheromones { to_navigation, .. } => {
                frames(to_navigation, bytes, &mut |payload, raw| {
                    take("navigation", raw, pheromone_link::describe(payload, order));
                });
            }
            Self::Ground { to_vehicle, .. } => frames(to_vehicle, bytes, &mut |payload, raw| {
                take("navigation", raw, ground_link::describe(payload, order, false));
            }),
        }
    }
}

fn arcos_packets(
    decoder: &mut arcos::Decoder,
    bytes: &[u8],
    from_robot: bool,
    to: &'static str,
    take: Taken<'_>,
) {
    decoder.push(bytes);
    while let Some(packet) = decoder.next_packet() {
        let body = packet.body();
        let count = u8::try_from(body.len() + 2).unwrap_or(u8::MAX);
        let mut raw = vec![arcos::HEADER[0], arcos::HEADER[1], count];
        raw.extend_from_slice(body);
        raw.extend_from_slice(&arcos::checksum(body).to_be_bytes());
        take(to, raw, arcos::describe(body, from_robot));
    }
}

/// Hands over each payload and the frame as it would be sent.
fn frames(receiver: &mut Receiver, bytes: &[u8], take: &mut dyn FnMut(&[u8], Vec<u8>)) {
    for &byte in bytes {
        if let Some(payload) = receiver.push(byte) {
            let mut raw = Vec::with_capacity(payload.len() + 6);
            wire::dle::write_frame(payload, wire::dle::Framing::Stuffed, &mut raw);
            take(payload, raw);
        }
    }
}
