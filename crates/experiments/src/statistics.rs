//! The few statistics that the reports quote.

/// A count out of a number of trials, with what it says about the true proportion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Proportion {
    /// Trials in which it happened.
    pub n_hits: usize,
    /// All trials.
    pub n_trials: usize,
}

/// Two-sided 95 % quantile of the standard normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

impl Proportion {
    /// Hits per trial; `None` without trials.
    pub fn ratio(self) -> Option<f64> {
        (self.n_trials > 0).then(|| self.n_hits as f64 / self.n_trials as f64)
    }

    /// The 95 % confidence interval of the true ratio: 0 to 1 without trials.
    ///
    /// Source: Wilson (1927), "Probable inference, the law of succession, and statistical inference",
    /// J. Am. Stat. Assoc. 22(158), doi:10.1080/01621459.1927.10502953: the score interval, which
    /// keeps its meaning near 0 and 1.
    pub fn interval_95(self) -> [f64; 2] {
        let Some(p) = self.ratio() else { return [0.0, 1.0] };
        let n = self.n_trials as f64;
        let z2 = Z_95 * Z_95;
        let centre = p + z2 / (2.0 * n);
        let half = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        let scale = 1.0 + z2 / n;
        [((centre - half) / scale).max(0.0), ((centre + half) / scale).min(1.0)]
    }
}

/// The median; of an even number, the mean of the middle two. `None` of nothing.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(f64::midpoint(sorted[middle - 1], sorted[middle])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From Newcombe (1998), "Two-sided confidence intervals for the single proportion", Stat. Med. 17,
    /// table I, method 3.
    #[test]
    fn intervals_are_the_published_ones() {
        let published = [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ];
        for (n_hits, n_trials, low, high) in published {
            let [l, h] = Proportion { n_hits, n_trials }.interval_95();
            assert!(
                (l - low).abs() < 5e-5 && (h - high).abs() < 5e-5,
                "{n_hits}/{n_trials}: {l} {h}"
            );
        }
    }

    #[test]
    fn nothing_tried_says_nothing() {
        let none = Proportion { n_hits: 0, n_trials: 0 };
        assert_eq!((none.ratio(), none.interval_95()), (None, [0.0, 1.0]));
    }

    #[test]
    fn the_median_stands_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }
}
