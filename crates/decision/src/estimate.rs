//! How much memory and time a program takes on the target.
//!
//! Source: the thesis, §7.3: 0.4 ms per function, measured; 6 bytes per function, mean; cycle of
//! at most 200 ms; 4 KB of program memory. Differences: the thesis speaks of 800 functions in
//! 4 KB, but 4096 / 6 is 682; the cycle allows 500 anyway.

use crate::{Program, image::IMAGE_BYTES_MAX};

/// Milliseconds that the target takes for one function, on the mean.
pub const FUNCTION_MS: f64 = 0.4;
/// Milliseconds that a scan may take.
pub const SCAN_MS_MAX: f64 = 200.0;
/// Functions that fit into a scan.
pub const N_FUNCTIONS_MAX: usize = 500;
/// Mean bytes of a function, for planning before there is a program.
pub const FUNCTION_BYTES: usize = 6;

/// What a program costs on the target.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Functions in the program.
    pub n_functions: usize,
    /// Bytes of its image.
    pub bytes: usize,
    /// Milliseconds of one scan.
    pub scan_ms: f64,
    /// What will not fit, as sentences for the user; empty when all is well.
    pub warnings: Vec<String>,
}

impl Estimate {
    /// The cost of so many functions of so many bytes in all.
    pub fn of_size(n_functions: usize, bytes: usize) -> Self {
        let scan_ms = n_functions as f64 * FUNCTION_MS;
        let mut warnings = Vec::new();
        if n_functions > N_FUNCTIONS_MAX {
            warnings.push(format!(
                "{n_functions} functions take {scan_ms:.1} ms a scan; {N_FUNCTIONS_MAX} take \
                 {SCAN_MS_MAX:.0} ms, the most the target allows"
            ));
        }
        if bytes > IMAGE_BYTES_MAX {
            warnings
                .push(format!("the image has {bytes} bytes; the target holds {IMAGE_BYTES_MAX}"));
        }
        Self { n_functions, bytes, scan_ms, warnings }
    }

    /// The cost of so many functions that are not written yet, at six bytes each.
    pub fn of_plan(n_functions: usize) -> Self {
        Self::of_size(n_functions, n_functions.saturating_mul(FUNCTION_BYTES).saturating_add(2))
    }
}

impl Program {
    /// What it costs on the target.
    pub fn estimate(&self) -> Estimate {
        Estimate::of_size(self.functions.len(), self.image.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_hundred_functions_fill_the_cycle() {
        let full = Estimate::of_plan(500);
        assert!((full.scan_ms - 200.0).abs() < 1e-9);
        assert_eq!((full.bytes, full.warnings.len()), (3002, 0));
        assert_eq!(Estimate::of_plan(501).warnings.len(), 1);
    }

    #[test]
    fn memory_ends_at_4096_bytes() {
        assert_eq!(Estimate::of_size(455, 4096).warnings.len(), 0);
        assert_eq!(
            Estimate::of_size(455, 4097).warnings,
            ["the image has 4097 bytes; the target holds 4096"]
        );
        // 682 functions of six bytes fit, 683 do not; neither scans in time.
        assert_eq!(Estimate::of_plan(682).warnings.len(), 1);
        assert_eq!(Estimate::of_plan(683).warnings.len(), 2);
    }
}
