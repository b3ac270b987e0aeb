//! What a passing robot leaves in one cell.

/// The evaporating part of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Deposit {
    /// The lasting value underneath, 0..=127.
    pub(crate) base: u8,
    /// What was there when it was last refreshed, 1..=127.
    pub(crate) peak: u8,
    /// Since then, nanoseconds.
    pub(crate) age_ns: u64,
}

impl Deposit {
    /// What is left: p = ⌈p₀ (1 − t/τ)⌉, or 0 from τ on. Whole numbers, so that time may be cut anyhow.
    #[inline]
    pub(crate) fn level(self, lifetime_ns: u64) -> u8 {
        let left_ns = lifetime_ns.saturating_sub(self.age_ns);
        if left_ns == 0 {
            return 0;
        }
        let level = (u128::from(self.peak) * u128::from(left_ns)).div_ceil(u128::from(lifetime_ns));
        level as u8 // at most `peak`
    }
}
