//! Reading along on a link: bytes to packets to a line of text each.

use robot_models::RobotModel;
use wire::{
    Reader, Towards,
    dle::{ByteOrder, Receiver},
    ground_link, pheromone_link,
};

/// Where packets go: receiving node, bytes, text.
pub(super) type Taken<'a> = &'a mut dyn FnMut(&'static str, Vec<u8>, String);

/// A reader of one link in both directions.
#[derive(Debug)]
pub(super) enum Tap {
    /// The robot's link, of which nothing is read where its protocol is not known.
    Robot(Option<[Box<dyn Reader>; 2]>),
    /// The pheromone server's link.
    Pheromones { to_server: Receiver, to_navigation: Receiver },
    /// The link between ground and vehicle.
    Ground { to_vehicle: Receiver, to_ground: Receiver },
}

impl Tap {
    pub(super) fn of_robot(model: &RobotModel) -> Self {
        let reader = |towards| wire::reader(model.protocol()?, towards);
        Self::Robot(reader(Towards::Robot).zip(reader(Towards::Client)).map(<[_; 2]>::from))
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
            Self::Robot(None) => {}
            Self::Robot(Some([to_robot, _])) => {
                to_robot.push(bytes, &mut |raw, text| take("robot", raw, text));
            }
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
            Self::Robot(None) => {}
            Self::Robot(Some([_, to_navigation])) => {
                to_navigation.push(bytes, &mut |raw, text| take("navigation", raw, text));
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
