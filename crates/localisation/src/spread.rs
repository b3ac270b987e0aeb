//! How widely particles are spread: groups, and how many particles describe them.

use geometry::{Se2, wrap_to_pi};

/// Side of a bin of positions, metres, and of headings, radians.
const BIN_M: f64 = 0.25;
const BIN_RAD: f64 = std::f64::consts::PI / 18.0;

/// The 99 % quantile of the standard normal distribution.
const Z_99: f64 = 2.326_347_874;

/// Counts bins; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spread {
    keys: Vec<(u64, u32)>,
}

fn key(pose: Se2) -> u64 {
    // Casts saturate; positions within 2²⁰ bins of the origin are told apart.
    let bin = |value: f64, side: f64| (value / side).floor() as i64;
    let part = |value: i64| (value & 0x1F_FFFF) as u64;
    let yaw = bin(wrap_to_pi(pose.yaw_rad), BIN_RAD);
    part(bin(pose.x_m, BIN_M)) << 42 | part(bin(pose.y_m, BIN_M)) << 21 | part(yaw)
}

impl Spread {
    pub(crate) fn with_capacity(n: usize) -> Self {
        Self { keys: Vec::with_capacity(n) }
    }

    /// Sorts poses into bins. O(n log n).
    pub(crate) fn take(&mut self, poses: impl Iterator<Item = Se2>) {
        self.keys.clear();
        self.keys.extend(poses.zip(0..).map(|(pose, index)| (key(pose), index)));
        self.keys.sort_unstable();
    }

    /// How many bins hold more than `least` of the weight.
    pub(crate) fn n_bins_of(&self, weights: &[f64], least: f64) -> usize {
        let weight = |bin: &&[(u64, u32)]| -> f64 {
            bin.iter().map(|(_, index)| weights[*index as usize]).sum()
        };
        self.keys.chunk_by(|a, b| a.0 == b.0).filter(|bin| weight(bin) > least).count()
    }

    /// The heaviest bin's first particle.
    pub(crate) fn heaviest(&self, weights: &[f64]) -> Option<usize> {
        let weight = |bin: &&[(u64, u32)]| -> f64 {
            bin.iter().map(|(_, index)| weights[*index as usize]).sum()
        };
        let bins = self.keys.chunk_by(|a, b| a.0 == b.0);
        let heaviest = bins.max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
        heaviest.first().map(|(_, index)| *index as usize)
    }
}

/// How many particles keep the distance of their distribution from one over `n_bins` below `kld_max_ratio`, with a
/// probability of 99 %.
///
/// Source: Fox (2003), eq. (13): the quantile of χ² by Wilson and Hilferty.
pub(crate) fn n_for(n_bins: usize, kld_max_ratio: f64) -> f64 {
    if n_bins < 2 {
        return 0.0;
    }
    let k = (n_bins - 1) as f64;
    let a = 2.0 / (9.0 * k);
    k / (2.0 * kld_max_ratio) * (1.0 - a + a.sqrt() * Z_99).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fox's figure: about 2000 for 150 bins at 0.05 and 99 %; by hand from tables of χ².
    #[test]
    fn the_number_of_particles_follows_the_quantile_of_chi_squared() {
        // χ²(0.99) for 10 and for 100 degrees of freedom, from tables.
        for (k, chi2) in [(10_usize, 23.209), (100, 135.807)] {
            let n = n_for(k + 1, 0.05);
            assert!((n / (chi2 / (2.0 * 0.05)) - 1.0).abs() < 0.003, "{k}: {n}");
        }
        assert!(n_for(1, 0.05).abs() < 1e-12);
    }

    #[test]
    fn poses_fall_into_bins_of_place_and_heading() {
        let mut spread = Spread::default();
        let at = |x, y, yaw| Se2::new(x, y, yaw);
        let poses = [
            at(0.1, 0.1, 0.05),
            at(0.2, 0.2, 0.1),
            at(-0.1, 0.1, 0.05),
            at(0.1, 0.1, -0.05),
            at(0.1, 0.1, 0.05),
        ];
        spread.take(poses.into_iter());
        let weights = [0.1, 0.1, 0.5, 0.2, 0.1];
        assert_eq!((spread.n_bins_of(&weights, 0.0), spread.n_bins_of(&weights, 0.25)), (3, 2));
        assert_eq!(spread.heaviest(&[0.1, 0.1, 0.5, 0.2, 0.1]), Some(2));
        assert_eq!(spread.heaviest(&[0.2, 0.2, 0.3, 0.1, 0.2]), Some(0));
    }
}
