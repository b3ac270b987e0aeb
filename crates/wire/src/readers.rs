//! Reading along on a robot's line: bytes to packets, with a line of text each. One line for each protocol.

use std::fmt::Debug;

use crate::{arcos, create_oi};

/// The list: protocol and constructor. A robot with a line of its own adds itself here.
const READERS: &[(&str, Build)] = &[("arcos", arcos::reader), ("create_oi", create_oi::reader)];

type Build = fn(Towards) -> Box<dyn Reader>;

/// Which way the bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Towards {
    /// From the client to its robot.
    Robot,
    /// From the robot to its client.
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
