//! Reading along on a Pioneer's line.

use super::{Decoder, HEADER, checksum, describe};
use crate::{Reader, Take, Towards};

/// Reads along in one direction.
pub(crate) fn reader(towards: Towards) -> Box<dyn Reader> {
    Box::new(ArcosReader { decoder: Decoder::new(), from_robot: towards == Towards::Client })
}

#[derive(Debug)]
struct ArcosReader {
    decoder: Decoder,
    from_robot: bool,
}

impl Reader for ArcosReader {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.decoder.push(bytes);
        while let Some(packet) = self.decoder.next_packet() {
            let body = packet.body();
            let count = u8::try_from(body.len().saturating_add(2)).unwrap_or(u8::MAX);
            let mut raw = vec![HEADER[0], HEADER[1], count];
            raw.extend_from_slice(body);
            raw.extend_from_slice(&checksum(body).to_be_bytes());
            take(raw, describe(body, self.from_robot));
        }
    }
}
