//! LD06 and LD19: a small turning laser that talks and never listens.
//!
//! From power-on it sends packets of 47 bytes at 230400 baud, 8N1: header, speed, angle of the first
//! point, twelve points, angle of the last, a clock, a CRC. Angles grow clockwise seen from above.
//!
//! | bytes | content, little-endian |
//! | --- | --- |
//! | 0, 1 | `54 2C`: header; version 1 and 12 points |
//! | 2, 3 | turning speed, °/s |
//! | 4, 5 | angle of the first point, 0.01° |
//! | 6 … 41 | 12 × (distance u16 in mm, intensity u8); distance 0: nothing |
//! | 42, 43 | angle of the last point, 0.01° |
//! | 44, 45 | milliseconds, beginning anew at 30 000 |
//! | 46 | CRC-8 of the 46 bytes before |
//!
//! Source: the maker's public driver (`ldrobotSensorTeam/ldlidar_stl_ros2`) and the LD19 manual's example.
//! Differences: after `54 54 2C` the maker's driver loses the packet; here a byte that was no
//! second header byte is tried as a first.

mod reader;

use crate::search::{Found, Search};
pub(crate) use reader::reader;

/// The line's speed, bits per second.
pub const BAUD: u32 = 230_400;
/// Length of a packet, bytes.
pub const PACKET_LEN: usize = 47;
/// Points in a packet.
pub const N_POINTS: usize = 12;
/// The clock begins anew here, ms.
pub const CLOCK_WRAP_MS: u16 = 30_000;
/// Hundredths of a degree in a turn.
pub const TURN_CDEG: u16 = 36_000;

const HEADER: [u8; 2] = [0x54, 0x2C];
/// Twelve points span less than this, 0.01°.
const SPAN_MAX_CDEG: u16 = 3000;
const CRC_POLYNOMIAL: u8 = 0x4D;

/// One point of a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Point {
    /// Range, mm; 0: nothing came back.
    pub distance_mm: u16,
    /// Strength of what came back.
    pub intensity: u8,
}

/// A packet: twelve points in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packet {
    /// Turning speed, degrees per second.
    pub speed_degps: u16,
    /// Angle of the first point, 0.01°, clockwise, below 36 000.
    pub start_cdeg: u16,
    /// The points, in the order in which they were measured.
    pub points: [Point; N_POINTS],
    /// Angle of the last point, 0.01°, clockwise, below 36 000.
    pub end_cdeg: u16,
    /// The device's clock, ms, below 30 000.
    pub clock_ms: u16,
}

impl Packet {
    /// The bytes on the line.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        let mut bytes = [0; PACKET_LEN];
        let body = HEADER
            .into_iter()
            .chain(self.speed_degps.to_le_bytes())
            .chain(self.start_cdeg.to_le_bytes())
            .chain(self.points.iter().flat_map(|point| {
                let [low, high] = point.distance_mm.to_le_bytes();
                [low, high, point.intensity]
            }))
            .chain(self.end_cdeg.to_le_bytes())
            .chain(self.clock_ms.to_le_bytes());
        for (place, byte) in bytes.iter_mut().zip(body) {
            *place = byte;
        }
        let crc = bytes.split_last().map_or(0, |(_, before)| crc8(before));
        if let Some(last) = bytes.last_mut() {
            *last = crc;
        }
        bytes
    }

    /// Reads a packet whose header and CRC were checked.
    fn decode(bytes: &[u8; PACKET_LEN]) -> Self {
        let u16_at = |at: usize| {
            let pair = bytes.get(at..).and_then(<[u8]>::first_chunk::<2>);
            pair.map_or(0, |pair| u16::from_le_bytes(*pair))
        };
        let mut points = [Point::default(); N_POINTS];
        let triples = bytes.get(6..42).unwrap_or_default().as_chunks::<3>().0;
        for (point, &[low, high, intensity]) in points.iter_mut().zip(triples) {
            *point = Point { distance_mm: u16::from_le_bytes([low, high]), intensity };
        }
        Self {
            speed_degps: u16_at(2),
            start_cdeg: u16_at(4),
            points,
            end_cdeg: u16_at(42),
            clock_ms: u16_at(44),
        }
    }

    /// The angle from the first point to the last, 0.01°, from 0 to 35 999, clockwise.
    pub fn span_cdeg(&self) -> u16 {
        let turn = u32::from(TURN_CDEG);
        let [start, end] = [self.start_cdeg, self.end_cdeg].map(u32::from);
        let within = |cdeg: u32| cdeg.checked_rem(turn).unwrap_or(0);
        let span = within(within(end).saturating_add(turn).saturating_sub(within(start)));
        // Below a turn, so it fits.
        u16::try_from(span).unwrap_or(0)
    }

    /// Angle of a point, degrees, clockwise, from 0 to below 360.
    pub fn angle_deg(&self, index: usize) -> f64 {
        let start_deg = f64::from(self.start_cdeg) / 100.0;
        let step_deg = f64::from(self.span_cdeg()) / 1100.0;
        (start_deg + index as f64 * step_deg) % 360.0
    }

    /// Whether the angles can be those of twelve neighbouring points. The maker's driver asks for a span of at
    /// most one and a half times what twelve points make at the packet's speed and 4500 points a second; the example
    /// of its own manual (10.4° at 2152 °/s) does not fulfil that, so a wider bound is taken here.
    pub fn is_plausible(&self) -> bool {
        self.start_cdeg < TURN_CDEG
            && self.end_cdeg < TURN_CDEG
            && self.span_cdeg() <= SPAN_MAX_CDEG
    }
}

/// CRC-8 of the packet: polynomial 0x4D, start 0, most significant bit first.
pub fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc: u8, &byte| {
        (0..8).fold(
            crc ^ byte,
            |c, _| {
                if c & 0x80 == 0 { c << 1 } else { (c << 1) ^ CRC_POLYNOMIAL }
            },
        )
    })
}

/// Finds packets in received bytes that may be cut anywhere and may carry noise.
///
/// Cost: at most 47 steps per received byte; at most 46 bytes stay behind between calls.
#[derive(Clone, Debug)]
pub struct Decoder {
    search: Search,
    n_packets: u64,
    n_bad_checksums: u64,
}

impl Decoder {
    /// A decoder that has heard nothing.
    pub fn new() -> Self {
        Self { search: Search::new(), n_packets: 0, n_bad_checksums: 0 }
    }

    /// Appends received bytes. Of more than 65 536 bytes not yet asked for, the oldest are dropped and
    /// counted as skipped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.search.push(bytes);
    }

    /// The next whole packet with a right CRC, or `None` until more bytes come.
    pub fn next_packet(&mut self) -> Option<Packet> {
        let n_bad_checksums = &mut self.n_bad_checksums;
        let packet = self.search.next(
            |byte| byte == HEADER[0],
            |bytes| {
                match bytes.get(1) {
                    None => return Found::Unfinished,
                    Some(&second) if second != HEADER[1] => return Found::Noise,
                    Some(_) => {}
                }
                let Some(packet) = bytes.first_chunk::<PACKET_LEN>() else {
                    return Found::Unfinished;
                };
                if packet.split_last().is_some_and(|(crc, body)| crc8(body) == *crc) {
                    return Found::Whole(Packet::decode(packet), PACKET_LEN);
                }
                *n_bad_checksums = n_bad_checksums.saturating_add(1);
                Found::Noise
            },
        )?;
        self.n_packets = self.n_packets.saturating_add(1);
        Some(packet)
    }

    /// Forgets the bytes of an earlier connection; the counters stay.
    pub fn clear(&mut self) {
        self.search.skip_all();
    }

    /// Packets so far.
    pub fn n_packets(&self) -> u64 {
        self.n_packets
    }

    /// Bytes thrown away as noise so far.
    pub fn n_bytes_skipped(&self) -> u64 {
        self.search.n_skipped()
    }

    /// Headers so far whose packet had a wrong CRC.
    pub fn n_bad_checksums(&self) -> u64 {
        self.n_bad_checksums
    }

    #[cfg(test)]
    pub(crate) fn n_unread(&self) -> usize {
        self.search.unread().len()
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
