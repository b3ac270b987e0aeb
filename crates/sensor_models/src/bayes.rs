//! Bayes' rule for one yes-or-no question asked again and again: is this cell occupied?
//!
//! In two forms that are the same: products of probabilities, as printed in the source, and sums of
//! log-odds, which need one addition where the products need four. A probability of exactly 0 or 1
//! absorbs everything in the first form; in the second it is an infinity.
//!
//! | from the prior and a likelihood | to a posterior |
//! | --- | --- |
//! | P(s given H), P(s given not H), P(H) | [`posterior_prob`] |
//! | two independent opinions on H | [`fused_prob`], or [`logodds`] added |
//!
//! Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială limitată",
//! MSc dissertation, Univ. Dunărea de Jos Galați, eq. (14) to (17).

/// P(H given s) from P(s given H), P(s given not H) and P(H), all from 0 to 1; eq. (14), (15).
///
/// Where both likelihoods exclude what was seen, 0/0, nothing is learnt: the prior comes back.
pub fn posterior_prob(seen_if_prob: f64, seen_if_not_prob: f64, prior_prob: f64) -> f64 {
    let both = seen_if_prob * prior_prob;
    let evidence = both + seen_if_not_prob * (1.0 - prior_prob);
    if evidence > 0.0 { both / evidence } else { prior_prob }
}

/// What a cell of probability `map_prob` becomes by a reading that alone says `reading_prob`;
/// eq. (17) with P(s given not H) = 1 - P(s given H).
///
/// Commutative and associative; 0.5 says nothing; 0 against 1 is a contradiction and keeps
/// `map_prob`. The products are formed in the printed order, which matters in the last bits only.
pub fn fused_prob(map_prob: f64, reading_prob: f64) -> f64 {
    posterior_prob(reading_prob, 1.0 - reading_prob, map_prob)
}

/// ln(p / (1 - p)): 0 at one half, infinite at 0 and 1.
///
/// [`fused_prob`] is the sum of two of these.
pub fn logodds(prob: f64) -> f64 {
    (prob / (1.0 - prob)).ln()
}

/// The probability whose [`logodds`] these are: 1 / (1 + e^-l).
pub fn prob_from_logodds(logodds: f64) -> f64 {
    1.0 / (1.0 + (-logodds).exp())
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "neutral and absorbing values are exact")]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Worked by hand from 0.5: the published sequence of four readings.
    #[test]
    fn a_cell_follows_the_published_sequence_in_both_forms() {
        let expected = [
            (0.8, 0.8, 1.386_294),
            (0.8, 0.941_176_471, 2.772_589),
            (0.3, 0.872_727_273, 1.925_291),
            (0.6, 0.911_392_405, 2.330_756),
        ];
        let (mut cell_prob, mut cell_logodds) = (0.5, 0.0);
        for (reading, prob, odds) in expected {
            cell_prob = fused_prob(cell_prob, reading);
            cell_logodds += logodds(reading);
            assert!((cell_prob - prob).abs() < 5e-10, "{cell_prob}");
            assert!((cell_logodds - odds).abs() < 5e-7, "{cell_logodds}");
            assert!((prob_from_logodds(cell_logodds) - prob).abs() < 5e-10);
        }
    }

    #[test]
    fn certainty_absorbs_and_ignorance_says_nothing() {
        for reading in [0.0, 0.2, 0.5, 0.9] {
            assert_eq!(fused_prob(0.0, reading), 0.0);
            assert_eq!(fused_prob(reading, 0.5), reading);
        }
        assert_eq!(fused_prob(1.0, 0.1), 1.0);
        // A contradiction: what was known stays.
        assert_eq!(fused_prob(1.0, 0.0), 1.0);
        assert_eq!(fused_prob(0.0, 1.0), 0.0);
        assert_eq!(logodds(0.5), 0.0);
        assert_eq!(prob_from_logodds(f64::INFINITY), 1.0);
    }

    /// Bayes over a table of joint probabilities: the definition, without the formula.
    #[test]
    fn the_posterior_is_a_ratio_of_joint_probabilities() {
        let (prior, hit, false_alarm) = (0.2, 0.9, 0.3);
        let joint_yes = 0.2 * 0.9;
        let joint_no = 0.8 * 0.3;
        let expected = joint_yes / (joint_yes + joint_no);
        assert!((posterior_prob(hit, false_alarm, prior) - expected).abs() < 1e-15);
        assert!(posterior_prob(false_alarm, hit, prior) < prior);
    }

    proptest! {
        #[test]
        fn the_order_of_readings_does_not_matter(a in 0.01..0.99, b in 0.01..0.99, c in 0.01..0.99) {
            let forward = fused_prob(fused_prob(a, b), c);
            let backward = fused_prob(a, fused_prob(c, b));
            prop_assert!((forward - backward).abs() < 1e-12);
            let odds = logodds(a) + logodds(b) + logodds(c);
            prop_assert!((prob_from_logodds(odds) - forward).abs() < 1e-12);
        }
    }
}
