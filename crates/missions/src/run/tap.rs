//! Reading along on a line: bytes to packets to a line of text each.

use wire::{Reader, Towards};

/// A packet that passed: receiving node, bytes, text.
pub(crate) type Packet = (&'static str, Vec<u8>, String);

/// The node at the near end of every line.
pub(crate) const NEAR: &str = "navigation";

/// A reader of one line in both directions, and what it has read.
#[derive(Debug)]
pub(crate) struct Tap {
    /// Away from the navigation node, and back. Nothing is read where the protocol is not known.
    readers: Option<[Box<dyn Reader>; 2]>,
    packets: Vec<Packet>,
}

impl Tap {
    pub(crate) fn new(protocol: Option<&str>) -> Self {
        let reader = |towards| wire::reader(protocol?, towards);
        let readers = reader(Towards::Robot).zip(reader(Towards::Client)).map(<[_; 2]>::from);
        Self { readers, packets: Vec::new() }
    }

    /// Reads bytes that reached the node `far` from the navigation node, and bytes that reached that.
    pub(crate) fn read(&mut self, far: &'static str, outward: &[u8], inward: &[u8]) {
        let Self { readers: Some([away, back]), packets } = self else { return };
        away.push(outward, &mut |bytes, text| packets.push((far, bytes, text)));
        back.push(inward, &mut |bytes, text| packets.push((NEAR, bytes, text)));
    }

    pub(crate) fn drain(&mut self) -> impl Iterator<Item = Packet> + '_ {
        self.packets.drain(..)
    }
}
