//! Cells as runs of equal bytes, and numbers as little-endian bytes: what binary messages are made of.

/// The longest run or copy of one packed piece.
const PIECE_MAX: usize = 128;

/// Appends `bytes` in packed form: a byte n below 128 and then n + 1 bytes as they are; or n from 129, and one byte
/// that stands 257 − n times. At most 1/128 longer than `bytes`.
pub(crate) fn pack(bytes: &[u8], out: &mut Vec<u8>) {
    let mut rest = bytes;
    while !rest.is_empty() {
        let run = run_length(rest);
        if run >= 2 {
            out.extend([(257 - run) as u8, rest[0]]);
            rest = &rest[run..];
            continue;
        }
        let copy = copy_length(rest);
        out.push((copy - 1) as u8);
        out.extend_from_slice(&rest[..copy]);
        rest = &rest[copy..];
    }
}

/// How many bytes at the beginning are equal.
fn run_length(bytes: &[u8]) -> usize {
    bytes.iter().take(PIECE_MAX).take_while(|&&byte| byte == bytes[0]).count()
}

/// How many bytes come before the next run of three.
fn copy_length(bytes: &[u8]) -> usize {
    let end = bytes.windows(3).position(|w| w[0] == w[1] && w[1] == w[2]);
    end.unwrap_or(bytes.len()).clamp(1, PIECE_MAX)
}

/// A binary message under construction.
#[derive(Debug)]
pub(crate) struct Bytes(Vec<u8>);

impl Bytes {
    /// Begins with the head that all messages share.
    pub(crate) fn begin(kind: u8, slot: usize, run: u32) -> Self {
        let mut bytes = Self(vec![kind, slot as u8, 0, 0]);
        bytes.u32(run);
        bytes
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn i32(&mut self, value: i32) {
        self.0.extend(value.to_le_bytes());
    }

    /// A count; one that needs more than 32 bits is never sent.
    pub(crate) fn count(&mut self, n: usize) {
        self.u32(n as u32);
    }

    pub(crate) fn f32(&mut self, value: f64) {
        self.0.extend((value as f32).to_le_bytes());
    }

    pub(crate) fn f64(&mut self, value: f64) {
        self.0.extend(value.to_le_bytes());
    }

    /// Packed cells with their length in 16 bits before them; for at most 4096 cells.
    pub(crate) fn tile(&mut self, cells: &[u8]) {
        let start = self.0.len();
        self.0.extend([0, 0]);
        pack(cells, &mut self.0);
        let n = (self.0.len() - start - 2) as u16;
        self.0[start..start + 2].copy_from_slice(&n.to_le_bytes());
    }

    /// Packed cells with their length in 32 bits before them.
    pub(crate) fn cells(&mut self, cells: &[u8]) {
        let start = self.0.len();
        self.0.extend([0; 4]);
        pack(cells, &mut self.0);
        let n = (self.0.len() - start - 4) as u32;
        self.0[start..start + 4].copy_from_slice(&n.to_le_bytes());
    }

    pub(crate) fn finish(self) -> Vec<u8> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written from the description alone.
    fn unpack(mut packed: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        while let [n, rest @ ..] = packed {
            let n = usize::from(*n);
            if n < 128 {
                bytes.extend(&rest[..=n]);
                packed = &rest[n + 1..];
            } else {
                assert!(n > 128);
                bytes.extend(std::iter::repeat_n(rest[0], 257 - n));
                packed = &rest[1..];
            }
        }
        bytes
    }

    #[test]
    fn whatever_is_packed_comes_back() {
        let mut noise = 7_u32;
        let mut random = |n_values: u32| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (noise >> 16) % n_values
        };
        for length in [0, 1, 2, 3, 127, 128, 129, 130, 256, 4096] {
            for n_values in [1, 2, 3, 256] {
                let bytes: Vec<u8> = (0..length).map(|_| random(n_values) as u8).collect();
                let mut packed = Vec::new();
                pack(&bytes, &mut packed);
                assert_eq!(unpack(&packed), bytes, "{length} of {n_values}");
                assert!(packed.len() <= length + length / 128 + 1, "{} of {length}", packed.len());
            }
        }
    }

    #[test]
    fn a_tile_of_one_value_takes_64_bytes() {
        let mut packed = Vec::new();
        pack(&[0; 4096], &mut packed);
        assert_eq!(packed.len(), 64);
        assert_eq!(packed[..2], [129, 0]);
    }

    #[test]
    fn the_head_and_the_numbers_are_little_endian() {
        let mut bytes = Bytes::begin(2, 1, 0x0102);
        bytes.i32(-2);
        bytes.f32(1.0);
        bytes.f64(-2.0);
        bytes.tile(&[9; 4]);
        let expected = [
            &[2, 1, 0, 0, 2, 1, 0, 0][..],
            &[0xfe, 0xff, 0xff, 0xff],
            &[0, 0, 0x80, 0x3f],
            &[0, 0, 0, 0, 0, 0, 0, 0xc0],
            &[2, 0, 253, 9],
        ];
        assert_eq!(bytes.finish(), expected.concat());
    }
}
