//! Reading along on a robot's line: bytes to packets, with a line of text each. One line for each protocol.

use std::fmt::Debug;

use crate::{
    arcos, create_oi,
    dle::{ByteOrder, Framing, Receiver, write_frame},
    ground_link, ld06, pheromone_link, rplidar, sick_lms,
};

/// The list: protocol and constructor. A device with a line of its own adds itself here.
const READERS: &[(&str, Build)] = &[
    ("arcos", arcos::reader),
    ("create_oi", create_oi::reader),
    ("sick_lms", sick_lms::reader),
    ("rplidar", rplidar::reader),
    ("ld06", ld06::reader),
    ("pheromone_link", pheromones),
    ("ground_link", ground),
];

type Build = fn(Towards) -> Box<dyn Reader>;

/// Which way the bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Towards {
    /// From the client to its robot, device or server; from a vehicle to the ground.
    Robot,
    /// From there to the client; from the ground to a vehicle.
    Client,
}

/// Whoever reads along in one direction.
pub trait Reader: Debug + Send + Sync {
    /// Takes the next bytes, cut anywhere, and hands over what they complete: a packet's bytes and what they say.
    fn push(&mut self, bytes: &[u8], take: Take<'_>);
}

/// Where packets go: their bytes, and a line of text.
pub type Take<'a> = &'a mut dyn FnMut(Vec<u8>, String);

/// A reader of that protocol; `None` for a protocol that is not known here.
pub fn reader(protocol: &str, towards: Towards) -> Option<Box<dyn Reader>> {
    READERS.iter().find(|(known, _)| *known == protocol).map(|(_, build)| build(towards))
}

fn pheromones(_towards: Towards) -> Box<dyn Reader> {
    let describe = |payload: &[u8]| pheromone_link::describe(payload, ByteOrder::default());
    Box::new(Frames { receiver: Receiver::default(), describe })
}

fn ground(towards: Towards) -> Box<dyn Reader> {
    let describe = match towards {
        Towards::Robot => {
            |payload: &[u8]| ground_link::describe(payload, ByteOrder::default(), true)
        }
        Towards::Client => {
            |payload: &[u8]| ground_link::describe(payload, ByteOrder::default(), false)
        }
    };
    Box::new(Frames { receiver: Receiver::default(), describe })
}

/// Frames of the thesis's links.
#[derive(Debug)]
struct Frames {
    receiver: Receiver,
    describe: fn(&[u8]) -> String,
}

impl Reader for Frames {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        for &byte in bytes {
            if let Some(payload) = self.receiver.push(byte) {
                let mut raw = Vec::with_capacity(payload.len().saturating_add(6));
                write_frame(payload, Framing::Stuffed, &mut raw);
                take(raw, (self.describe)(payload));
            }
        }
    }
}
