//! Occupancy as probabilities that are multiplied, as the printed equations do it.
//!
//! [`LogOddsMap`](crate::LogOddsMap) says the same in sums and is smaller and faster. This form is
//! for results that have to agree with the product to its last digits.

use crate::{Cell, MapError, Thresholds, Window, log_odds::entropy_bits};

/// What a cell is before anything was observed.
pub const PRIOR_PROB: f64 = 0.5;

/// Bayes' rule for two independent pieces of evidence and even odds before:
/// m·w / (m·w + (1−m)·(1−w)).
///
/// Both from 0 to 1. Certain evidence against certain evidence (0 and 1) is not a number.
///
/// Source: Axenie (2011), "Maparea mediului pentru roboți mobili cu structură senzorială
/// limitată", eq. 17.
pub fn fuse(m_prob: f64, w_prob: f64) -> f64 {
    let occupied = m_prob * w_prob;
    occupied / (occupied + (1.0 - m_prob) * (1.0 - w_prob))
}

/// Fuses `evidence` into `map`, its lower left cell over `at`; NaN says nothing, and cells beside
/// the map are left out.
pub fn fuse_window(map: &mut Window<f64>, evidence: &Window<f64>, at: Cell) {
    let shift = evidence.area().min;
    let (columns, rows) = (at.column - shift.column, at.row - shift.row);
    for (cell, prob) in evidence.iter().filter(|(_, prob)| !prob.is_nan()) {
        if let Some(old) = map.get_mut(cell.offset(columns, rows)) {
            *old = fuse(prob, *old);
        }
    }
}

/// 1 where a cell is at least `occupied_prob` probable, else 0, and how many of the first there
/// are.
pub fn binary(map: &Window<f64>, occupied_prob: f64) -> (Window<u8>, usize) {
    let binary = map.map(|prob| u8::from(prob >= occupied_prob));
    let n_occupied = binary.values().iter().map(|one| usize::from(*one)).sum();
    (binary, n_occupied)
}

/// Uncertainty of the cells that differ from [`PRIOR_PROB`] and are numbers.
pub fn entropy_of(map: &Window<f64>) -> crate::Entropy {
    let known = map.values().iter().filter(|prob| (**prob - PRIOR_PROB).abs() > 0.0);
    let mut entropy = crate::Entropy { sum_bits: 0.0, n_known: 0 };
    for prob in known {
        entropy.sum_bits += entropy_bits(*prob);
        entropy.n_known += 1;
    }
    entropy
}

/// Verdicts on probabilities; NaN and one half are unknown.
pub fn states_of(map: &Window<f64>, thresholds: &Thresholds) -> Window<crate::State> {
    map.map(|prob| thresholds.state_of(prob))
}

/// A window in which nothing was observed yet.
///
/// # Errors
///
/// [`MapError::TooLarge`].
pub fn prior(area: crate::CellBox) -> Result<Window<f64>, MapError> {
    Window::filled(area, PRIOR_PROB)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CellBox, State, logodds_of, prob_of};
    use proptest::prelude::*;

    #[test]
    fn a_half_changes_nothing_and_two_opinions_count_twice() {
        assert_eq!((fuse(0.5, 0.3), fuse(0.8, 0.5)), (0.3, 0.8));
        // 0.8 · 0.8 / (0.64 + 0.04) = 16 / 17.
        assert!((fuse(0.8, 0.8) - 16.0 / 17.0).abs() < 1e-15);
        assert!((fuse(0.8, 0.2) - 0.5).abs() < 1e-15);
        assert!(fuse(0.0, 1.0).is_nan());
    }

    #[test]
    fn evidence_is_laid_over_the_map_and_nothing_beside_it() {
        let area = CellBox::spanning(Cell::new(0, 0), Cell::new(2, 1));
        let mut map = prior(area).unwrap();
        let two = CellBox::spanning(Cell::new(7, 7), Cell::new(8, 8));
        let evidence = Window::from_values(two, vec![0.9, f64::NAN, 0.2, 0.4]).unwrap();
        fuse_window(&mut map, &evidence, Cell::new(2, 0));
        assert_eq!(map.values(), &[0.5, 0.5, 0.9, 0.5, 0.5, 0.2]);
        fuse_window(&mut map, &evidence, Cell::new(-1, 1));
        assert_eq!(map.values(), &[0.5, 0.5, 0.9, 0.5, 0.5, 0.2]);
        let (ones, n_occupied) = binary(&map, 0.9);
        assert_eq!((ones.values(), n_occupied), (&[0, 0, 1, 0, 0, 0][..], 1));
        let states = states_of(&map, &Thresholds::default());
        assert_eq!(states.row(1), &[State::Unknown, State::Unknown, State::Free]);
        let entropy = entropy_of(&map);
        assert_eq!(entropy.n_known, 2);
        assert!((entropy.sum_bits - entropy_bits(0.9) - entropy_bits(0.2)).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_product_is_the_sum_of_log_odds(m in 0.001..0.999_f64, w in 0.001..0.999_f64) {
            let sum = prob_of(logodds_of(m) + logodds_of(w));
            prop_assert!((fuse(m, w) - sum).abs() < 1e-12);
            prop_assert!((fuse(m, w) - fuse(w, m)).abs() < 1e-15);
        }
    }
}
