//! One seed per run; one independent random stream per named part.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;

/// The generator behind every random stream of a run.
pub type RandomStream = ChaCha8Rng;

/// The seed of a whole run. Everything random in a run follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunSeed(pub u64);

impl RunSeed {
    /// The random stream of one part, such as `"lidar/robot-3"`.
    ///
    /// Streams of different labels are independent, and adding a part does not disturb the
    /// numbers that the others draw.
    pub fn stream(self, label: &str) -> RandomStream {
        let mut rng = ChaCha8Rng::seed_from_u64(self.0);
        rng.set_stream(fnv1a(label.as_bytes()));
        rng
    }
}

/// A running hash of simulation state, for comparing two runs bit by bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateHash(u64);

impl StateHash {
    /// The hash of nothing.
    pub fn new() -> Self {
        Self(FNV_OFFSET)
    }

    /// Absorbs a number by its bits, so that -0.0 and 0.0 differ.
    ///
    /// # Panics
    ///
    /// In debug builds, when `value` is not finite: the bits of NaN are not guaranteed.
    pub fn absorb(&mut self, value: f64) {
        debug_assert!(value.is_finite(), "only finite numbers have one bit pattern");
        self.absorb_bytes(&value.to_bits().to_le_bytes());
    }

    /// Absorbs an integer.
    pub fn absorb_u64(&mut self, value: u64) {
        self.absorb_bytes(&value.to_le_bytes());
    }

    /// Absorbs bytes.
    pub fn absorb_bytes(&mut self, bytes: &[u8]) {
        self.0 = fnv1a_from(self.0, bytes);
    }

    /// The hash so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

impl fmt::Display for StateHash {
    /// Sixteen hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Default for StateHash {
    fn default() -> Self {
        Self::new()
    }
}

/// FNV-1a, 64 bit: offset basis and prime from the draft-eastlake-fnv reference.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

fn fnv1a(bytes: &[u8]) -> u64 {
    fnv1a_from(FNV_OFFSET, bytes)
}

fn fnv1a_from(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |h, &b| (h ^ u64::from(b)).wrapping_mul(FNV_PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;

    #[test]
    fn fnv1a_has_its_published_values() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn equal_seeds_and_labels_give_equal_streams() {
        let draw = |seed, label| RunSeed(seed).stream(label).next_u64();
        assert_eq!(draw(7, "lidar/robot-0"), draw(7, "lidar/robot-0"));
        assert_ne!(draw(7, "lidar/robot-0"), draw(7, "lidar/robot-1"));
        assert_ne!(draw(7, "lidar/robot-0"), draw(8, "lidar/robot-0"));
    }

    /// A stand-in for a simulation: every part adds noise from its own stream to its own state.
    fn run(seed: RunSeed, parts: &[&str]) -> Vec<StateHash> {
        let simulate = |label: &&str| {
            let mut rng = seed.stream(label);
            let mut hash = StateHash::new();
            (0..100).for_each(|_| hash.absorb(rng.next_u32().into()));
            hash
        };
        parts.iter().map(simulate).collect()
    }

    #[test]
    fn a_new_part_disturbs_no_other() {
        let two = run(RunSeed(1), &["wheels", "lidar"]);
        let three = run(RunSeed(1), &["gyro", "wheels", "lidar"]);
        assert_eq!(two, three[1..]);
    }
}
