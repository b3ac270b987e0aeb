//! Diffusion, evaporation and aggregation as plain functions of numbers.
//!
//! Source: the thesis, (5.33)–(5.37). Intensities here are in the unit of the sources (p₀ = 1 for a unit
//! source); [`crate::Intensities`] counts a hundred for it, as the thesis's server does.

use std::time::Duration;

/// One source as a receptor sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantSource {
    /// Intensity at the source and at the time of the deposit, p₀.
    pub intensity: f64,
    /// From the receptor, metres.
    pub distance_m: f64,
    /// Since the deposit.
    pub age: Duration,
}

/// What is left of a source at a distance: p₀ (1 − x/σ) within the reach σ, else 0; (5.33).
///
/// A negative or undefined distance or reach gives 0.
pub fn diffused(intensity: f64, distance_m: f64, reach_m: f64) -> f64 {
    // Not a number fails the comparison and counts as out of reach.
    if (0.0..reach_m).contains(&distance_m) {
        intensity * (1.0 - distance_m / reach_m)
    } else {
        0.0
    }
}

/// What is left of a source after a time: p₀ (1 − t/τ) within its lifetime τ, else 0; (5.34).
pub fn evaporated(intensity: f64, age: Duration, lifetime: Duration) -> f64 {
    if age < lifetime {
        intensity * (1.0 - age.as_secs_f64() / lifetime.as_secs_f64())
    } else {
        0.0
    }
}

/// Both at once; (5.35).
pub fn perceived(source: &DistantSource, reach_m: f64, lifetime: Duration) -> f64 {
    evaporated(diffused(source.intensity, source.distance_m, reach_m), source.age, lifetime)
}

/// The sum over all sources; (5.36). O(sources), added in their order.
///
/// Differences: the print leaves open whether t is one age for all; here each source has its own.
pub fn aggregated(sources: &[DistantSource], reach_m: f64, lifetime: Duration) -> f64 {
    sources.iter().map(|source| perceived(source, reach_m, lifetime)).sum()
}

/// The sum over sources that do not evaporate, given as (intensity, distance in metres); (5.37).
pub fn aggregated_static(sources: &[(f64, f64)], reach_m: f64) -> f64 {
    sources.iter().map(|&(intensity, distance_m)| diffused(intensity, distance_m, reach_m)).sum()
}

/// How far ahead one source of the summed intensity `total_intensity` (N p₀) would have to lie to be
/// perceived as `perceived_intensity`: `L = σ (1 − P_R / (N p₀))`, within [0, σ]; (5.47), (5.48).
///
/// σ where nothing is perceived.
pub fn equivalent_distance_m(perceived_intensity: f64, total_intensity: f64, reach_m: f64) -> f64 {
    if perceived_intensity > 0.0 && total_intensity > 0.0 {
        reach_m * (1.0 - perceived_intensity / total_intensity).max(0.0)
    } else {
        reach_m
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact")]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn diffusion_falls_linearly_to_the_reach() {
        let seen = [0.0, 0.15, 0.3, 0.599, 0.6, 0.7, -0.1, f64::NAN].map(|d| diffused(2.0, d, 0.6));
        let expected = [2.0, 1.5, 1.0, 2.0 / 600.0, 0.0, 0.0, 0.0, 0.0];
        for (a, b) in seen.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{seen:?}");
        }
    }

    #[test]
    fn no_reach_and_no_lifetime_leave_nothing() {
        assert_eq!([diffused(1.0, 0.0, 0.0), diffused(1.0, 0.0, f64::NAN)], [0.0, 0.0]);
        assert_eq!(evaporated(1.0, Duration::ZERO, Duration::ZERO), 0.0);
    }

    #[test]
    fn evaporation_falls_linearly_to_the_lifetime() {
        let left = [0, 1, 2, 3, 4, 5].map(|s| evaporated(8.0, s * SECOND, 4 * SECOND));
        assert_eq!(left, [8.0, 6.0, 4.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn aggregation_adds_what_each_source_leaves() {
        let source = |intensity, distance_m, age_s: u32| DistantSource {
            intensity,
            distance_m,
            age: age_s * SECOND,
        };
        // By hand: 1·(1/2)·(1/2) + 4·(3/4)·(1) + 0 (too far) + 0 (too old).
        let all =
            [source(1.0, 0.3, 1), source(4.0, 0.15, 0), source(9.0, 0.6, 0), source(9.0, 0.0, 2)];
        assert!((aggregated(&all, 0.6, 2 * SECOND) - 3.25).abs() < 1e-12);
        let fresh = [(1.0, 0.3), (4.0, 0.15), (9.0, 0.6)];
        assert!((aggregated_static(&fresh, 0.6) - 3.5).abs() < 1e-12);
    }

    /// The thesis's note on (5.48): σ = 600 mm, P = 0.5 of one source, and 2 of three.
    #[test]
    fn the_equivalent_source_is_where_the_thesis_puts_it() {
        assert!((equivalent_distance_m(0.5, 1.0, 0.6) - 0.3).abs() < 1e-12);
        assert!((equivalent_distance_m(2.0, 3.0, 0.6) - 0.2).abs() < 1e-12);
        assert_eq!(equivalent_distance_m(0.0, 3.0, 0.6), 0.6);
        assert_eq!(equivalent_distance_m(4.0, 3.0, 0.6), 0.0);
    }
}
