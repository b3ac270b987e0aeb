//! Reading along on an LD06's line.

use super::Decoder;
use crate::{Reader, Take, Towards};

/// Reads along; towards the device nothing is ever said.
pub(crate) fn reader(_towards: Towards) -> Box<dyn Reader> {
    Box::new(Packets { decoder: Decoder::new(), n_skipped: 0 })
}

#[derive(Debug)]
struct Packets {
    decoder: Decoder,
    n_skipped: u64,
}

impl Reader for Packets {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.decoder.push(bytes);
        while let Some(packet) = self.decoder.next_packet() {
            let degrees = |cdeg: u16| f64::from(cdeg) / 100.0;
            let nearest = packet.points.iter().map(|p| p.distance_mm).filter(|&mm| mm > 0).min();
            let nearest_m = nearest.map_or(0.0, |mm| f64::from(mm) / 1000.0);
            let (from, to) = (degrees(packet.start_cdeg), degrees(packet.end_cdeg));
            let text = format!("POINTS from {from:.1}° to {to:.1}°, the shortest {nearest_m:.2} m");
            take(packet.encode().to_vec(), text);
        }
        let n_skipped = self.decoder.n_bytes_skipped();
        let n_new = n_skipped.saturating_sub(std::mem::replace(&mut self.n_skipped, n_skipped));
        if n_new > 0 {
            take(Vec::new(), format!("{n_new} bytes outside of any packet"));
        }
    }
}
