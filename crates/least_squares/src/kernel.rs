//! Robust kernels: how much an edge may pull that disagrees with all others.

/// How the squared error s = eᵀΩe of one edge enters the sum: as ρ(s), with the weight ρ'(s).
///
/// Widths are in standard deviations (√s), so they mean the same for every edge.
///
/// Source: Agarwal, Tipaldi, Spinello, Stachniss, Burgard (2013), "Robust map optimization using
/// dynamic covariance scaling", ICRA, for the scaling; Huber, Cauchy and Geman–McClure are the
/// usual M-estimators.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Kernel {
    /// ρ = s: right for errors that are normal, lost with a single wrong loop closure.
    #[default]
    None,
    /// Grows only linearly beyond `width_ratio`; keeps the problem convex, never lets go.
    Huber {
        /// √s where the line begins.
        width_ratio: f64,
    },
    /// ρ = k² ln(1 + s/k²): lets go slowly.
    Cauchy {
        /// k, in standard deviations.
        width_ratio: f64,
    },
    /// ρ = k² s / (k² + s): lets go altogether.
    GemanMcClure {
        /// k, in standard deviations.
        width_ratio: f64,
    },
    /// Information scaled by c² with c = min(1, 2Φ / (Φ + s)): untouched up to s = Φ, then lets go.
    DynamicCovarianceScaling {
        /// √Φ, in standard deviations.
        width_ratio: f64,
    },
}

impl Kernel {
    /// ρ(s) and ρ'(s) of a squared error s ≥ 0; ρ(0) = 0, ρ'(0) = 1, ρ ≤ s.
    pub fn cost_and_weight(self, squared_error_ratio: f64) -> (f64, f64) {
        let s = squared_error_ratio;
        match self {
            Self::None => (s, 1.0),
            Self::Huber { width_ratio: k } => {
                if s <= k * k {
                    (s, 1.0)
                } else {
                    let root = s.sqrt();
                    (k * (2.0 * root - k), k / root)
                }
            }
            Self::Cauchy { width_ratio: k } => {
                let x = s / (k * k);
                (k * k * x.ln_1p(), 1.0 / (1.0 + x))
            }
            Self::GemanMcClure { width_ratio: k } => {
                let shrink = k * k / (k * k + s);
                (s * shrink, shrink * shrink)
            }
            Self::DynamicCovarianceScaling { width_ratio } => {
                let phi = width_ratio * width_ratio;
                if s <= phi {
                    (s, 1.0)
                } else {
                    // ρ' = c² integrated from Φ, where ρ = Φ: ρ = 3Φ - 4Φ² / (Φ + s).
                    let c = 2.0 * phi / (phi + s);
                    (phi * (3.0 - 2.0 * c), c * c)
                }
            }
        }
    }

    /// The width in standard deviations, if it has one.
    pub(crate) fn width_ratio(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Huber { width_ratio }
            | Self::Cauchy { width_ratio }
            | Self::GemanMcClure { width_ratio }
            | Self::DynamicCovarianceScaling { width_ratio } => Some(width_ratio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(width_ratio: f64) -> [Kernel; 5] {
        [
            Kernel::None,
            Kernel::Huber { width_ratio },
            Kernel::Cauchy { width_ratio },
            Kernel::GemanMcClure { width_ratio },
            Kernel::DynamicCovarianceScaling { width_ratio },
        ]
    }

    #[test]
    fn the_weight_is_the_slope_of_the_cost_on_both_sides_of_the_width() {
        for kernel in all(1.5) {
            assert_eq!(kernel.cost_and_weight(0.0), (0.0, 1.0), "{kernel:?}");
            for s in [0.01, 1.0, 2.2, 2.3, 5.0, 400.0] {
                let h = 1e-5 * s;
                let rise = kernel.cost_and_weight(s + h).0 - kernel.cost_and_weight(s - h).0;
                let (cost, weight) = kernel.cost_and_weight(s);
                assert!((rise / (2.0 * h) - weight).abs() < 1e-6, "{kernel:?} at {s}");
                assert!(cost <= s && cost > 0.0, "{kernel:?} at {s}");
            }
        }
    }

    #[test]
    fn dynamic_covariance_scaling_weighs_as_published() {
        let kernel = Kernel::DynamicCovarianceScaling { width_ratio: 1.0 };
        for s in [0.5_f64, 1.0, 3.0, 100.0] {
            let c = (2.0 / (1.0 + s)).min(1.0);
            assert!((kernel.cost_and_weight(s).1 - c * c).abs() < 1e-15);
        }
    }
}
