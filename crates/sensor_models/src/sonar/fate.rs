//! Everything random about a ping, drawn before it meets anything.

use rand_core::Rng;
use rand_distr::{Distribution, StandardNormal};
use run_context::RandomStream;

/// Everything random about one ping.
pub(super) struct Fate {
    pub(super) strength: f64,
    pub(super) range_gauss: f64,
    pub(super) crosstalk: f64,
    pub(super) where_to: f64,
    pub(super) dropout: f64,
    pub(super) ghost: f64,
}

impl Fate {
    pub(super) fn draw(rng: &mut RandomStream, strength_std_ratio: f64) -> Self {
        let strength_gauss: f64 = StandardNormal.sample(rng);
        Self {
            strength: (strength_std_ratio * strength_gauss).exp(),
            range_gauss: StandardNormal.sample(rng),
            crosstalk: uniform(rng),
            where_to: uniform(rng),
            dropout: uniform(rng),
            ghost: uniform(rng),
        }
    }
}

/// Uniform in [0, 1), 53 bits.
fn uniform(rng: &mut RandomStream) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}
