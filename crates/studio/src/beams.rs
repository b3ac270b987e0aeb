//! Scans as text: a state is JSON, and hundreds of beams with seventeen digits each would be most of it.
//!
//! A beam is an unsigned 16-bit number, little-endian: 0 is unseen, 65535 is free, else the range in millimetres. All
//! beams of a scan together are written in base 64 (RFC 4648, section 4).

use figures::base64;
use missions::ViewScan;

const UNSEEN: u16 = 0;
const FREE: u16 = u16::MAX;

/// A beam as a number. What makes no sense says nothing: it is unseen.
fn coded(range_m: f32) -> u16 {
    if range_m == ViewScan::FREE {
        return FREE;
    }
    if range_m.is_nan() || range_m <= 0.0 {
        return UNSEEN;
    }
    // Casts from floats saturate; no echo may look like a code.
    ((range_m * 1000.0).round() as u16).clamp(1, FREE - 1)
}

/// The beams of a scan as text.
pub(crate) fn packed(ranges_m: &[f32]) -> String {
    let bytes: Vec<u8> = ranges_m.iter().flat_map(|&range| coded(range).to_le_bytes()).collect();
    base64(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unseen_is_not_free_and_echoes_are_neither() {
        assert_eq!(coded(ViewScan::FREE), FREE);
        for nothing in [ViewScan::UNSEEN, f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert_eq!(coded(nothing), UNSEEN, "{nothing}");
        }
        assert_eq!((coded(1.2345), coded(0.0001), coded(70.0)), (1235, 1, FREE - 1));
        assert_eq!(packed(&[1.0, ViewScan::FREE, 0.0]), base64(&[0xE8, 3, 255, 255, 0, 0]));
    }
}
